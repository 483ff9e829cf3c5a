//! Steps of a trajectory that break a limit are spread, each reversal for itself.

use crate::support::{Outcome, WorkFolder, bundled};
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

/// Half gap of A1, A2 and A3, deg.
const HALF_GAP_DEG: f64 = 0.01;
/// Seconds of the fast part, and its interval; the same of the weave.
const FAST_S: f64 = 1.5;
const FAST_STEP_S: f64 = 0.02;
const WEAVE_S: f64 = 20.0;
const WEAVE_STEP_S: f64 = 0.05;

/// A1 at a time, deg, and its speed, deg/s: a swing at 4 Hz of 0.6 deg that swells and fades, then a weave at 0.5 Hz of 0.15 deg.
fn motion(t_s: f64) -> [f64; 2] {
    if t_s <= FAST_S {
        let (w, turn) = (TAU * 4.0, PI * t_s / FAST_S);
        let (size, slope) = (turn.sin().powi(2), PI / FAST_S * (2.0 * turn).sin());
        return [0.6 * size * (w * t_s).sin(), 0.6 * (size * w * (w * t_s).cos() + slope * (w * t_s).sin())];
    }
    let (t, w) = (t_s - FAST_S, TAU * 0.5);
    let share = (0.5 * t).min(1.0);
    let (size, slope) = (share * share * (3.0 - 2.0 * share), if t < 2.0 { 3.0 * share * (1.0 - share) } else { 0.0 });
    [0.15 * size * (w * t).sin(), 0.15 * (size * w * (w * t).cos() + slope * (w * t).sin())]
}

/// The program: `fast`: with the swing before the weave.
fn program(fast: bool) -> Value {
    let mut times: Vec<f64> = Vec::new();
    if fast {
        times.extend((0..(FAST_S / FAST_STEP_S).round() as u32).map(|k| FAST_STEP_S * f64::from(k)));
    }
    times.extend((0..=(WEAVE_S / WEAVE_STEP_S).round() as u32).map(|k| FAST_S + WEAVE_STEP_S * f64::from(k)));
    let (from, all) = (times[0], FAST_S + WEAVE_S);
    let points: Vec<Value> = times
        .iter()
        .map(|&t| {
            let [a1, speed] = motion(t).map(|v| (v.to_radians() * 1e8).round() / 1e8);
            let nanoseconds = ((t - from) * 1e9).round() as u64;
            json!({
                "positions": [a1, -1.4 + 0.1 * t / all, 1.6 - 0.05 * t / all, 0.0, 0.5, 0.0],
                "velocities": [speed, 0.1 / all, -0.05 / all, 0.0, 0.0, 0.0],
                "time_from_start": {"sec": nanoseconds / 1_000_000_000, "nanosec": nanoseconds % 1_000_000_000}
            })
        })
        .collect();
    json!({"joint_names": ["A1", "A2", "A3", "A4", "A5", "A6"], "points": points})
}

fn rewritten(fast: bool) -> (Outcome, Value) {
    let desk = WorkFolder::new();
    std::fs::copy(bundled("configs/kuka-kr120-r2500-pro.yaml"), desk.join("robot.yaml")).unwrap();
    let gaps =
        ["A1", "A2", "A3"].map(|j| format!("  - {{effect: backlash, joint: {j}, half_gap_deg: {HALF_GAP_DEG}}}\n"));
    let model = format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{}", gaps.concat());
    std::fs::write(desk.join("model.yaml"), model).unwrap();
    std::fs::write(desk.join("p.json"), serde_json::to_string_pretty(&program(fast)).unwrap()).unwrap();
    let run = desk.run("rewrite --model model.yaml p.json --output out.json --json").success();
    let document = run.json();
    (run, document)
}

#[test]
fn a_fast_reversal_does_not_spread_the_steps_of_a_slow_weave() {
    let rms = |document: &Value, side: &str| document["path_error"]["rms_um"][side].as_f64().unwrap();
    let (_, slow) = rewritten(false);
    let (_, both) = rewritten(true);
    let left = |d: &Value| rms(d, "after") / rms(d, "before");
    assert!(left(&slow) < 0.1, "{slow:#}");
    // of the fast reversals an error stays, and the weave is nearly all of the program
    assert!(left(&both) < 0.2, "{:#}", both["path_error"]);
    let notes = both["notes"].as_array().unwrap();
    let spread = notes.iter().filter_map(|n| n["text"].as_str()).find(|t| t.contains("the step of A1 is spread over"));
    assert!(spread.is_some_and(|t| t.contains("of its reversals")), "{notes:?}");
}
