//! Joints that all lag by one time look like a late clock: what is left of the one under the other gets no name.
//!
//! The log is exact: each joint moves by two cosines, whose first-order lag has a closed form (amplitude `1/sqrt(1 + (w lag)^2)`, phase
//! `atan(w lag)`).

use crate::support::{WorkFolder, run};
use lostmotion::robot::Robot;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use serde_json::Value;
use std::fmt::Write;
use std::path::Path;

const ROBOT: &str = "configs/kuka-kr120-r2500-pro.yaml";
/// Rows of the log, and its interval in s.
const ROWS: u32 = 2250;
const STEP_S: f64 = 0.04;
/// Noise of each coordinate, mm.
const NOISE_MM: f64 = 0.011;
/// Middle, deg; amplitude, deg, and angular speed, rad/s, of both cosines of each joint.
const JOINTS: [[f64; 5]; 6] = [
    [10.0, 5.0, 0.42, 2.6, 0.35],
    [-85.0, 5.5, 0.37, 3.0, 0.51],
    [95.0, 6.6, 0.57, 3.6, 0.61],
    [20.0, 5.8, 0.69, 3.1, 0.63],
    [40.0, 5.8, 0.66, 3.2, 0.73],
    [15.0, 5.0, 0.59, 2.4, 0.53],
];

/// Position of a joint at `t_s` that follows its command with a lag, deg.
fn at(joint: &[f64; 5], lag_s: f64, t_s: f64) -> f64 {
    let [middle, a, u, b, v] = *joint;
    let cosine =
        |size: f64, w: f64| size * ((w * t_s - (w * lag_s).atan()).cos() / (1.0 + (w * lag_s).powi(2)).sqrt() - 1.0);
    middle + cosine(a, u) + cosine(b, v)
}

/// Diagnosis of a log whose joints lag by these times, s.
fn diagnosed(lags_s: [f64; 6]) -> Value {
    let robot = Robot::load(Path::new(ROBOT)).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let noise = Normal::new(0.0, NOISE_MM).unwrap();
    let mut text = String::from("t_s");
    (1..=6).for_each(|j| write!(text, ",cmd_A{j}_deg").unwrap());
    text += ",x_mm,y_mm,z_mm\n";
    for k in 0..ROWS {
        let t_s = STEP_S * f64::from(k);
        write!(text, "{t_s:.3}").unwrap();
        JOINTS.iter().for_each(|j| write!(text, ",{:.6}", at(j, 0.0, t_s)).unwrap());
        let q: Vec<f64> = JOINTS.iter().zip(lags_s).map(|(j, lag_s)| at(j, lag_s, t_s).to_radians()).collect();
        robot.tcp_m(&q).iter().for_each(|m| write!(text, ",{:.5}", 1e3 * m + noise.sample(&mut rng)).unwrap());
        text.push('\n');
    }
    let desk = WorkFolder::new();
    std::fs::copy(ROBOT, desk.join("robot.yaml")).unwrap();
    std::fs::write(desk.join("log.csv"), text).unwrap();
    let out = run(desk.path(), "diagnose --robot robot.yaml --log log.csv --json").success();
    serde_json::from_slice(&out.stdout).unwrap()
}

/// Every found effect is a lag or a clock, and what stands alone is a lag of a joint.
fn is_lag_or_clock(found: &Value, lags_s: [f64; 6]) {
    let rounds = found["rounds"].as_array().unwrap();
    assert!(!rounds.is_empty(), "{found:#}");
    let clock = rounds.iter().any(|r| r["effect"] == "time_offset");
    for round in rounds {
        assert!(round["effect"] == "time_offset" || round["effect"] == "servo_lag", "{round:#}");
        if round["effect"] == "time_offset" {
            let set = round["set"].as_array().unwrap();
            assert!(set.iter().any(|m| m["effect"] == "servo_lag" && m["target"] == "all"), "{round:#}");
        } else if !clock {
            let joint: usize = round["target"].as_str().unwrap()[1..].parse().unwrap();
            let lag_s = round["parameters"]["lag_s"]["value"].as_f64().unwrap();
            assert!((lag_s / lags_s[joint - 1] - 1.0).abs() < 0.05, "{round:#}");
        }
    }
}

#[test]
fn lags_of_all_joints_by_10_ms_leave_no_scale_of_the_tracker() {
    let lags_s = [0.010; 6];
    is_lag_or_clock(&diagnosed(lags_s), lags_s);
}

#[test]
fn lags_of_all_joints_by_20_ms_are_diagnosed() {
    let lags_s = [0.020; 6];
    is_lag_or_clock(&diagnosed(lags_s), lags_s);
}

#[test]
fn lags_of_which_one_is_longer_leave_no_oscillation() {
    let mut lags_s = [0.010; 6];
    lags_s[0] = 0.020;
    is_lag_or_clock(&diagnosed(lags_s), lags_s);
}
