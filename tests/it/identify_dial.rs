//! `identify static` with a dial: readings at its stop, and creep that its digits hide.

use crate::support::WorkFolder;
use serde_json::Value;
use std::fmt::Write;

/// Half gap of X, mm.
const HALF_GAP_MM: f64 = 0.05;
/// Interval of the rows, s; speed, mm/s; overshoot, mm; dwell, s.
const STEP_S: f64 = 0.04;
const SPEED_MM_S: f64 = 5.0;
const OVERSHOOT_MM: f64 = 2.0;
const DWELL_S: f64 = 1.5;
/// Range of the dial to either side of 100 mm, um.
const RANGE_UM: f64 = 5000.0;

/// A log of X at `places`, each reached from both sides in four cycles; friction holds it back by `stiction_mm`, which fades with `pace_s`
/// at rest.
fn log(places: &[f64], stiction_mm: f64, pace_s: f64) -> String {
    let mut text = String::from("t_s,cmd_X_mm,cmd_Y_mm,cmd_Z_mm,dial_um,trigger,cycle\n");
    let (mut t_s, mut command, mut stands, mut side) = (0.0, places[0], places[0], 1.0);
    let mut row = |command: f64, held: f64, trigger: f64, cycle: u32| {
        stands = f64::clamp(stands, command - HALF_GAP_MM, command + HALF_GAP_MM);
        let dial_um = (1e3 * (stands - held - 100.0)).round().clamp(-RANGE_UM, RANGE_UM);
        writeln!(text, "{t_s:.2},{command:.4},400.0000,-200.0000,{dial_um:.0},{trigger:.0},{cycle}").unwrap();
        t_s += STEP_S;
    };
    for cycle in 0..4 {
        for place in places {
            for (way, sense) in
                [(place - OVERSHOOT_MM, -1.0), (*place, 1.0), (place + OVERSHOOT_MM, 1.0), (*place, -1.0)]
            {
                while (way - command).abs() > 1e-9 {
                    let step: f64 = way - command;
                    command += step.signum() * step.abs().min(SPEED_MM_S * STEP_S);
                    side = step.signum();
                    row(command, side * stiction_mm, 0.0, cycle);
                }
                if way == *place && side == sense {
                    for k in 0..(DWELL_S / STEP_S) as u32 {
                        let left = (-f64::from(k + 1) * STEP_S / pace_s).exp();
                        row(command, side * stiction_mm * left, side, cycle);
                    }
                }
            }
        }
    }
    text
}

fn identified(text: &str) -> Value {
    let desk = WorkFolder::new();
    std::fs::copy("configs/gantry-xyz-ballscrew.yaml", desk.join("robot.yaml")).unwrap();
    std::fs::write(desk.join("x.csv"), text).unwrap();
    desk.run("identify static --robot robot.yaml --log x.csv --direction 1,0,0 --json").success().json()
}

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap_or_else(|| panic!("no number: {v}"))
}

#[test]
fn a_place_at_which_the_dial_is_at_its_stop_is_no_place_without_a_gap() {
    let found = identified(&log(&[100.0, 300.0], 0.0, 1.0));
    let joint = &found["joints"][0];
    assert!((number(&joint["half_gap_mm"]) / HALF_GAP_MM - 1.0).abs() < 0.05, "{found:#}");
    assert!(joint["schedule"].is_null() && joint["places"] == 1, "{found:#}");
    let notes = found["notes"].as_array().unwrap();
    assert!(notes.iter().any(|n| n.as_str().is_some_and(|n| n.contains("did not change by a digit"))), "{notes:?}");
}

#[test]
fn a_gap_behind_creep_that_hardly_scatters_lies_in_its_own_interval() {
    for pace_s in [1.5, 0.9] {
        let found = identified(&log(&[100.0], 0.04, pace_s));
        let joint = &found["joints"][0];
        let (value, low, high) = (number(&joint["half_gap_mm"]), number(&joint["ci95"][0]), number(&joint["ci95"][1]));
        assert!(low <= value && value <= high, "{joint:#}");
        assert!((value / HALF_GAP_MM - 1.0).abs() < 0.02, "{joint:#}");
        let pace = [0, 1].map(|k| number(&joint["creep"]["pace_ci95_s"][k]));
        assert!(pace[0] < pace[1], "a pace without an interval: {joint:#}");
    }
}
