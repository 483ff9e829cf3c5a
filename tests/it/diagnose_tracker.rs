//! Faults of the measurement and of time: a beam that was locked again, growth of the machine, and what slow noise hides. On the gantry,
//! whose TCP stands where its joints do, the errors are made by hand.

use crate::support::{WorkFolder, run};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use serde_json::Value;
use std::fmt::Write;

/// Rows of a log, and its interval in s.
const ROWS: u32 = 3000;
const STEP_S: f64 = 0.04;
/// Noise of a reading, mm.
const NOISE_MM: f64 = 0.008;
/// Half a gap of X, mm.
const HALF_GAP_MM: f64 = 0.03;

fn command(axis: usize, t: f64) -> f64 {
    let w = [0.31, 0.23, 0.17][axis];
    40.0 * (w * t).sin() + 14.0 * (2.7 * w * t).sin()
}

/// Diagnoses a log of the gantry with a gap of X and this error of the TCP over time, mm.
fn diagnosed(error: impl Fn(f64) -> [f64; 3]) -> Value {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let noise = Normal::new(0.0, NOISE_MM).unwrap();
    let mut text = String::from("t_s,cmd_X_mm,cmd_Y_mm,cmd_Z_mm,x_mm,y_mm,z_mm\n");
    let mut x = 500.0;
    for k in 0..ROWS {
        let t = STEP_S * f64::from(k);
        let c = [0, 1, 2].map(|a| [500.0, 400.0, -200.0][a] + command(a, t));
        x = f64::clamp(x, c[0] - HALF_GAP_MM, c[0] + HALF_GAP_MM);
        let at = [x, c[1], c[2]];
        write!(text, "{t:.3},{:.6},{:.6},{:.6}", c[0], c[1], c[2]).unwrap();
        for (p, e) in at.into_iter().zip(error(t)) {
            write!(text, ",{:.5}", p + e + noise.sample(&mut rng)).unwrap();
        }
        text.push('\n');
    }
    let desk = WorkFolder::new();
    std::fs::copy("configs/gantry-xyz-ballscrew.yaml", desk.join("robot.yaml")).unwrap();
    std::fs::write(desk.join("log.csv"), text).unwrap();
    let out = run(desk.path(), "diagnose --robot robot.yaml --log log.csv --json --model-out found.yaml").success();
    let mut found: Value = serde_json::from_slice(&out.stdout).unwrap();
    found["model"] = std::fs::read_to_string(desk.join("found.yaml")).unwrap().into();
    found
}

fn names(found: &Value) -> Vec<String> {
    let rounds = found["rounds"].as_array().unwrap();
    let mut names: Vec<String> =
        rounds.iter().map(|r| format!("{} {}", r["effect"].as_str().unwrap(), r["target"].as_str().unwrap())).collect();
    names.sort();
    names
}

fn round<'a>(found: &'a Value, effect: &str) -> &'a Value {
    found["rounds"].as_array().unwrap().iter().find(|r| r["effect"] == effect).unwrap_or_else(|| panic!("{found:#}"))
}

#[test]
fn a_beam_that_was_locked_again_is_a_step_of_the_tracker_at_its_time() {
    let found = diagnosed(|t| if t >= 70.0 { [0.08, -0.05, 0.03] } else { [0.0; 3] });
    assert_eq!(names(&found), ["backlash X", "tracker_frame log"], "{found:#}");
    let step = round(&found, "tracker_frame");
    for (key, um) in [("x_um", 80.0), ("y_um", -50.0), ("z_um", 30.0)] {
        assert!((step["parameters"][key]["value"].as_f64().unwrap() - um).abs() < 3.0, "{step:#}");
    }
    let said = step["where"]["description"].as_str().unwrap();
    assert!(said.contains("from 70.00 s on in log 1"), "{said}");
    assert!(
        found["notes"].as_array().unwrap().iter().any(|n| n.as_str().unwrap().contains("jumps by 99 um")),
        "{found:#}"
    );
    // the next log does not have it
    let model = found["model"].as_str().unwrap();
    assert!(model.contains("backlash") && !model.contains("tracker_frame"), "{model}");
}

/// Growth of the gantry's Z axis by an hour's rate looks like a drift of the TCP: a set holds both, with intervals.
#[test]
fn growth_and_drift_that_a_log_cannot_tell_apart_stand_in_one_set() {
    let found = diagnosed(|t| [0.0, 0.0, 1.5e-3 * t]);
    assert_eq!(names(&found).len(), 2, "{found:#}");
    let of_time = ["thermal_growth", "thermal_drift", "tracker_frame"];
    let rounds = found["rounds"].as_array().unwrap();
    let drift =
        rounds.iter().find(|r| of_time.contains(&r["effect"].as_str().unwrap())).unwrap_or_else(|| panic!("{found:#}"));
    let set: Vec<&str> = drift["set"].as_array().unwrap().iter().map(|m| m["effect"].as_str().unwrap()).collect();
    assert!(set.len() > 1 && set.contains(&"thermal_growth"), "{drift:#}");
    assert!(drift["parameters"].as_object().unwrap().values().all(|p| !p["ci95"].is_null()), "{drift:#}");
    assert_eq!(found["verdict"], "named_set", "{found:#}");
}
