//! A size that may be zero is no name by itself.

use crate::support::{WorkFolder, run};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use serde_json::Value;
use std::fmt::Write;

/// Rows of the log, and its interval in s.
const ROWS: u32 = 1500;
const STEP_S: f64 = 0.04;
/// Noise of the sensor, mm.
const NOISE_MM: f64 = 0.001;
/// Half of a loop that builds up over this travel, mm, after each reversal in turn: no loop of one size.
const HALF_WIDTHS_MM: [f64; 6] = [0.041, 0.018, 0.019, 0.0, -0.018, 0.011];
const PRESLIDING_MM: f64 = 30.0;

/// Diagnosis of the gantry's X by a scale on it.
fn diagnosed() -> Value {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let noise = Normal::new(0.0, NOISE_MM).unwrap();
    let mut text = String::from("t_s,cmd_X_mm,cmd_Y_mm,cmd_Z_mm,meas_X_mm\n");
    let (mut before, mut side, mut turns, mut state) = (500.0, 0.0, 0, 0.0);
    for k in 0..ROWS {
        let t = STEP_S * f64::from(k);
        let [x, y, z] =
            [(500.0, 60.0, 0.35), (400.0, 50.0, 0.27), (-200.0, 40.0, 0.21)].map(|(c, a, w)| c + a * f64::sin(w * t));
        let step: f64 = x - before;
        before = x;
        if step != 0.0 {
            turns += usize::from(side * step < 0.0);
            side = step.signum();
            state = side + (state - side) * (-step.abs() / PRESLIDING_MM).exp();
        }
        let lost = HALF_WIDTHS_MM[turns % HALF_WIDTHS_MM.len()] * state;
        writeln!(text, "{t:.3},{x:.6},{y:.6},{z:.6},{:.6}", x - lost + noise.sample(&mut rng)).unwrap();
    }
    let desk = WorkFolder::new();
    std::fs::copy("configs/gantry-xyz-ballscrew.yaml", desk.join("robot.yaml")).unwrap();
    std::fs::write(desk.join("log.csv"), text).unwrap();
    let out = run(desk.path(), "diagnose --robot robot.yaml --log log.csv --json").success();
    serde_json::from_slice(&out.stdout).unwrap()
}

#[test]
fn a_size_whose_interval_holds_zero_stands_in_a_set_with_its_best_rival() {
    let found = diagnosed();
    let holds_zero = |round: &&Value| {
        let size = &round["parameters"]["half_width_mm"]["ci95"];
        size[0].as_f64().is_some_and(|low| low < 0.0)
    };
    let doubtful: Vec<&Value> = found["rounds"].as_array().unwrap().iter().filter(holds_zero).collect();
    assert!(!doubtful.is_empty(), "{found:#}");
    for round in doubtful {
        let set = round["set"].as_array().unwrap();
        assert!(set.len() > 1, "named alone: {round:#}");
        assert_eq!((&set[0]["effect"], &set[0]["target"]), (&round["effect"], &round["target"]), "{round:#}");
        assert!(round["decide_by"].is_string(), "{round:#}");
    }
    assert_ne!(found["verdict"], "named", "{found:#}");
}
