//! Friction that builds up, that is larger one way, or that grows with load, a ripple that fades with speed, and play that follows the
//! load are named with their sizes, beside slow noise, too; slow noise alone is no fault. On the gantry, whose TCP stands where its joints
//! do, the errors are stepped here by hand; those of the arm come from `simulate`.

use crate::support::{WorkFolder, run};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use serde_json::Value;
use std::f64::consts::TAU;
use std::fmt::Write;

/// Noise of a reading, mm.
const NOISE_MM: f64 = 0.004;
/// Rows of the log, its interval in s, and steps of the simulation between two rows.
const ROWS: u32 = 3000;
const STEP_S: f64 = 0.04;
const FINE: u32 = 20;

/// Command of an axis at a time, mm: it stops and reverses at many speeds.
fn command(axis: usize, t: f64) -> f64 {
    let w = [0.31, 0.23, 0.17][axis];
    40.0 * (w * t).sin() + 14.0 * (2.7 * w * t).sin()
}

fn speed(t: f64) -> f64 {
    let h = 1e-4;
    (command(0, t + h) - command(0, t - h)) / (2.0 * h)
}

/// Log of a gantry whose X axis has an error over time, mm.
fn log(error: impl FnMut(f64, f64) -> f64) -> String {
    let mut error = error;
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let noise = Normal::new(0.0, NOISE_MM).unwrap();
    let mut text = String::from("t_s,cmd_X_mm,cmd_Y_mm,cmd_Z_mm,x_mm,y_mm,z_mm\n");
    let mut e = 0.0;
    for k in 0..ROWS {
        let t = STEP_S * f64::from(k);
        if k > 0 {
            for i in 1..=FINE {
                e = error(t - STEP_S + STEP_S * f64::from(i) / f64::from(FINE), STEP_S / f64::from(FINE));
            }
        }
        let c = [0, 1, 2].map(|a| [500.0, 400.0, -200.0][a] + command(a, t));
        let mut read = |v: f64| v + noise.sample(&mut rng);
        let (x, y, z) = (read(c[0] + e), read(c[1]), read(c[2]));
        writeln!(text, "{t:.3},{:.6},{:.6},{:.6},{x:.5},{y:.5},{z:.5}", c[0], c[1], c[2]).unwrap();
    }
    text
}

/// Friction that turns over within a time, whose error fades: bristles and an integrating servo, in small steps.
fn friction(spike: [f64; 2], rise_s: f64, decay_s: f64) -> impl FnMut(f64, f64) -> f64 {
    let (mut z, mut e, mut turned) = (f64::NAN, 0.0, false);
    move |t, dt| {
        let dir = speed(t).signum();
        if z.is_nan() {
            // turned over at the start
            z = dir;
        }
        turned |= (dir - z).abs() > 1.0;
        let dz = (dir - z) * dt / rise_s;
        if turned {
            e += -0.5 * spike[usize::from(dir < 0.0)] * dz - e * dt / decay_s;
        }
        z += dz;
        e
    }
}

/// Diagnoses a log; the one round.
fn found(desk: &WorkFolder, robot: &str) -> Value {
    let out = run(desk.path(), &format!("diagnose --robot {robot} --log log.csv --json")).success().stdout;
    let d: Value = serde_json::from_slice(&out).unwrap();
    assert_eq!(d["verdict"], "named", "{d:#}");
    assert_eq!(d["rounds"].as_array().unwrap().len(), 1, "{d:#}");
    d["rounds"][0].clone()
}

fn assert_found(round: &Value, effect: &str, target: &str, truth: &[(&str, f64)]) {
    assert_eq!((round["effect"].as_str(), round["target"].as_str()), (Some(effect), Some(target)), "{round:#}");
    for (key, value) in truth {
        let p = &round["parameters"][key];
        let (at, ci) = (p["value"].as_f64(), &p["ci95"]);
        let half = 0.5 * (ci[1].as_f64().unwrap() - ci[0].as_f64().unwrap());
        // twice the interval, as four times in a thousand values are outside of it by chance
        assert!((at.unwrap() - value).abs() < 2.0 * half && half < 0.25 * value, "{key}: {value}, {round:#}");
    }
}

fn gantry(log: &str) -> WorkFolder {
    let desk = WorkFolder::new();
    std::fs::copy("configs/gantry-xyz-ballscrew.yaml", desk.join("robot.yaml")).unwrap();
    std::fs::write(desk.join("log.csv"), log).unwrap();
    desk
}

#[test]
fn friction_that_builds_up_is_named_with_its_rise() {
    let round = found(&gantry(&log(friction([0.04, 0.04], 0.4, 2.0))), "robot.yaml");
    assert_found(&round, "stiction", "X", &[("spike_mm", 0.04), ("rise_s", 0.4), ("decay_s", 2.0)]);
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn friction_that_is_larger_one_way_has_a_size_for_each() {
    let round = found(&gantry(&log(friction([0.05, 0.025], 0.3, 2.0))), "robot.yaml");
    let truth = [("spike_positive_mm", 0.05), ("spike_negative_mm", 0.025), ("decay_s", 2.0)];
    assert_found(&round, "stiction", "X", &truth);
}

#[test]
fn a_ripple_that_fades_with_speed_is_named_with_that_speed() {
    let text = log(|t, _| 0.02 * (-speed(t).abs() / 8.0).exp() * (TAU * (500.0 + command(0, t)) / 5.0).sin());
    let round = found(&gantry(&text), "robot.yaml");
    assert_found(&round, "transmission_error", "X", &[("amplitude_mm", 0.02), ("fade_mm_s", 8.0)]);
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn friction_that_grows_with_load_is_named_with_its_growth() {
    let desk = arm("{effect: stiction, joint: J2, spike_deg: 0.002, rise_s: 0.3, decay_s: 2, per_nm: 0.001}", 0.0);
    let round = found(&desk, "robot.yaml");
    assert_found(&round, "stiction", "J2", &[("rise_s", 0.3), ("decay_s", 2.0), ("per_nm", 0.001)]);
}

/// The cycles come from a spectrum, as those of a ripple do: no list has 24.
#[test]
fn a_bearing_that_wobbles_many_times_a_turn_is_named() {
    let wobble = "{effect: bearing_wobble, joint: J1, amplitude_deg: 0.004, cycles_per_rev: 24, phase_deg: 40, direction: [1, 0, 0]}";
    let round = found(&arm(wobble, 0.0), "robot.yaml");
    assert_found(&round, "bearing_wobble", "J1", &[("amplitude_deg[0]", 0.004), ("cycles_per_rev", 24.0)]);
}

/// Commands of an arm whose joints all move, with two of them loaded both ways.
fn commands_of_an_arm() -> String {
    let mut input = String::from("t_s,cmd_J1_deg,cmd_J2_deg,cmd_J3_deg,cmd_J4_deg,cmd_J5_deg,cmd_J6_deg\n");
    for k in 0..ROWS {
        let t = STEP_S * f64::from(k);
        let [a, b, c] = [0, 1, 2].map(|axis| 0.5 * command(axis, t));
        writeln!(input, "{t:.3},{a:.6},{:.6},{c:.6},{b:.6},{:.6},{c:.6}", a + 30.0, 40.0 + b).unwrap();
    }
    input
}

/// A folder with the robot and the log of an arm with these effects: readings with white noise, and slow noise beside it.
fn arm(effects: &str, slow_um: f64) -> WorkFolder {
    let desk = WorkFolder::new();
    std::fs::copy("tests/data/machines/arm/robot.yaml", desk.join("robot.yaml")).unwrap();
    std::fs::write(desk.join("input.csv"), commands_of_an_arm()).unwrap();
    let truth = format!(
        "schema: lostmotion/model/1\nrobot: robot.yaml\nregistration: {{xyz_mm: [0, 0, 0], rpy_deg: [0, 0, 0]}}\neffects: [{effects}]\n"
    );
    std::fs::write(desk.join("truth.yaml"), truth).unwrap();
    run(desk.path(), "simulate --model truth.yaml --input input.csv --noise-um 7 --output white.csv").success();
    let text = std::fs::read_to_string(desk.join("white.csv")).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let noise = Normal::new(0.0, 1e-3 * slow_um).unwrap();
    let mut slow = [0.0; 3];
    let mut out = String::new();
    for line in text.lines() {
        let mut cells: Vec<String> = line.split(',').map(str::to_string).collect();
        let n = cells.len();
        if cells[0].parse::<f64>().is_ok() {
            for (k, s) in slow.iter_mut().enumerate() {
                // fades over 30 rows
                *s = 0.967 * *s + (1.0_f64 - 0.967 * 0.967).sqrt() * noise.sample(&mut rng);
                cells[n - 3 + k] = format!("{:.5}", cells[n - 3 + k].parse::<f64>().unwrap() + *s);
            }
        }
        writeln!(out, "{}", cells.join(",")).unwrap();
    }
    std::fs::write(desk.join("log.csv"), out).unwrap();
    desk
}

#[test]
fn slow_noise_of_an_instrument_is_no_structure() {
    let desk = arm("", 3.0);
    let out = run(desk.path(), "diagnose --robot robot.yaml --log log.csv --json").success().stdout;
    let d: Value = serde_json::from_slice(&out).unwrap();
    assert_eq!(d["verdict"], "none", "{d:#}");
}

#[test]
fn play_whose_flank_follows_the_load_is_named_beside_slow_noise() {
    let desk = arm("{effect: loaded_play, joint: J5, half_gap_deg: 0.01, torque_nm: 0}", 2.0);
    let round = found(&desk, "robot.yaml");
    assert_found(&round, "loaded_play", "J5", &[("half_gap_deg", 0.01)]);
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn friction_of_one_size_keeps_one_size_beside_slow_noise() {
    let desk = arm("{effect: stiction, joint: J2, spike_deg: 0.003, rise_s: 0.3, decay_s: 2}", 3.0);
    let round = found(&desk, "robot.yaml");
    assert_found(&round, "stiction", "J2", &[("spike_deg", 0.003), ("rise_s", 0.3), ("decay_s", 2.0)]);
}
