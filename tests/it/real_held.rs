//! What `diagnose` must say of measured sets that are no tracker log: a reducer with its output held, a friction damper, and an
//! arm whose motor and link encoders were read at 21 poses. Figures: the READMEs of the sets.

use crate::real_data::{data, ours};
use crate::support::{self, WorkFolder};
use serde_json::Value;
use std::fmt::Write;

/// Columns of a CSV file by name.
fn columns(file: &str, names: &[&str]) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(data(file)).unwrap();
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let at: Vec<usize> = names.iter().map(|n| head.iter().position(|h| h == n).unwrap()).collect();
    let rows: Vec<Vec<&str>> = lines.map(|l| l.split(',').collect()).collect();
    at.iter().map(|&c| rows.iter().map(|r| r[c].parse().unwrap()).collect()).collect()
}

/// The diagnosis of a log of a set.
fn diagnose(set: &str, csv: &str) -> Value {
    let folder = WorkFolder::new();
    let log = folder.join("log.csv");
    std::fs::write(&log, csv).unwrap();
    let mut command = support::command();
    command.args(["diagnose", "--json", "--model"]).arg(ours(&format!("{set}/model.yaml"))).arg("--log").arg(&log);
    serde_json::from_slice(&command.assert().success().get_output().stdout).unwrap()
}

fn named(doc: &Value) -> Vec<&str> {
    doc["rounds"].as_array().unwrap().iter().map(|r| r["effect"].as_str().unwrap()).collect()
}

/// Half of the loop at no torque after ramps of 4 Nm, deg: README of the set.
#[test]
#[cfg_attr(not(real_data), ignore = "the measured sets are absent: LOSTMOTION_REAL_DATA names their folder")]
fn a_reducer_with_its_output_held_shows_wind_up_with_a_loop_over_the_torque_and_no_play_of_a_movement() {
    for (file, half_loop_deg) in [("baseline_runin1", 0.956), ("conic_init1", 0.323)] {
        let file = format!("cycloidal-locked-output-ramps/{file}.csv");
        let read = columns(&file, &["TIME", "POSITION", "CONTROL_TORQUE", "test_nr"]);
        let mut csv = "t_s,cmd_J1_deg,meas_J1_deg,torque_J1_nm\n".to_string();
        // the clock ticks every 15 ms: the last row of a tick
        for k in (0..read[0].len()).filter(|&k| read[3][k] < 100.0 && read[0].get(k + 1) != Some(&read[0][k])) {
            writeln!(csv, "{:.4},0,{:.5},{:.4}", read[0][k], 360.0 * read[1][k], read[2][k]).unwrap();
        }
        let doc = diagnose("cycloidal-locked-output-ramps", &csv);
        let names = named(&doc);
        assert!(names.contains(&"torque_windup") && names.contains(&"torque_hysteresis"), "{file}: {doc}");
        let allowed = ["torque_windup", "torque_hysteresis", "empirical"];
        assert!(names.iter().all(|n| allowed.contains(n)), "{file}: {names:?}");
        let gap = |key: &str| doc["gap"][key].as_f64().unwrap();
        assert!(gap("final_rms_um") < 0.5 * gap("nuisance_only_rms_um"), "{file}: {}", doc["gap"]);
        let turn = doc["rounds"].as_array().unwrap().iter().find(|r| r["effect"] == "torque_hysteresis").unwrap();
        let value = |key: &str| turn["parameters"][key]["value"].as_f64().unwrap();
        let at_4_nm = value("half_width_deg") * (1.0 - 1.0 / (4.0 / value("torque_nm")).cosh());
        assert!((at_4_nm - half_loop_deg).abs() < 0.35 * half_loop_deg, "{file}: {at_4_nm} deg");
    }
}

#[test]
#[cfg_attr(not(real_data), ignore = "the measured sets are absent: LOSTMOTION_REAL_DATA names their folder")]
fn a_friction_damper_is_no_gear_and_gets_no_name_for_its_stroke() {
    for file in ["0.25Hz0lbtension1.5amplitude_first12s.csv", "0.25Hz30lbtension1.5amplitude_first12s.csv"] {
        let read =
            columns(&format!("friction-damper-backlash/{file}"), &["t_s", "displacement_in", "friction_force_kip"]);
        let mut csv = "t_s,cmd_X_mm,meas_X_mm,torque_X_nm\n".to_string();
        for k in (0..read[0].len()).step_by(8) {
            writeln!(csv, "{:.6},0,{:.5},{:.3}", read[0][k], 25.4 * read[1][k], 4448.222 * read[2][k]).unwrap();
        }
        let doc = diagnose("friction-damper-backlash", &csv);
        let names = named(&doc);
        assert!(
            !names.iter().any(|n| ["backlash", "backlash_position", "hysteresis", "stiction"].contains(n)),
            "{doc}"
        );
        // 20 mm of stroke are not the noise of a sensor
        assert!(doc["verdict"] != "none", "{file}: {doc}");
    }
}

#[test]
#[cfg_attr(not(real_data), ignore = "the measured sets are absent: LOSTMOTION_REAL_DATA names their folder")]
fn what_follows_the_position_of_an_arm_without_masses_gets_no_physical_name() {
    let joints: Vec<String> = (1..=7).map(|k| format!("arm_{k}_joint")).collect();
    let joints: Vec<&str> = joints.iter().map(String::as_str).collect();
    let read = |side: &str| columns(&format!("tiago-motor-vs-link-encoder/{side}_gripper3_base1.csv"), &joints);
    let (motor, link) = (read("relative"), read("absolute"));
    let heads = |prefix: &str| (1..=7).map(|k| format!("{prefix}_J{k}_deg")).collect::<Vec<_>>().join(",");
    let mut csv = format!("{},{}\n", heads("cmd"), heads("meas"));
    for k in 0..motor[0].len() {
        let row: Vec<String> = motor.iter().chain(&link).map(|c| format!("{:.6}", c[k].to_degrees())).collect();
        writeln!(csv, "{}", row.join(",")).unwrap();
    }
    let doc = diagnose("tiago-motor-vs-link-encoder", &csv);
    assert!(named(&doc).iter().all(|n| *n == "empirical"), "{:?}", named(&doc));
    assert_eq!(doc["verdict"], "unknown", "{doc}");
    assert!(!doc["unexplained"].is_null(), "{doc}");
}
