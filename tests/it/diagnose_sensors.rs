//! `diagnose` on channels after and before the gear, and on settled poses of an arm with many small faults.

use crate::support::{self, WorkFolder};
use serde_json::Value;
use std::fmt::Write;
use std::path::{Path, PathBuf};

const ROBOT: &str = "configs/abb-irb1600-6-145.yaml";

fn file(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// A model of the robot with a tool and further reflectors, and effects.
fn model(folder: &Path, name: &str, robot: &str, effects: &str) -> PathBuf {
    let robot = file(folder, &format!("{name}-robot.yaml"), robot);
    let robot = robot.file_name().unwrap().to_str().unwrap().to_string();
    file(folder, name, &format!("schema: lostmotion/model/1\nrobot: {robot}\neffects: {effects}\n"))
}

fn robot(tool_mm: [f64; 3], tools: &str) -> String {
    let text = std::fs::read_to_string(ROBOT).unwrap();
    let tool = "tool: {xyz_mm: [0, 0, 0], rpy_deg: [0, 0, 0]}";
    assert!(text.contains(tool));
    text.replace(tool, &format!("tool: {{xyz_mm: {tool_mm:?}, rpy_deg: [0, 0, 0]}}{tools}"))
}

fn diagnose(model: &Path, logs: &[PathBuf]) -> Value {
    let mut command = support::command();
    command.args(["diagnose", "--json", "--model"]).arg(model);
    for log in logs {
        command.arg("--log").arg(log);
    }
    serde_json::from_slice(&command.assert().success().get_output().stdout).unwrap()
}

fn rounds(doc: &Value) -> &Vec<Value> {
    doc["rounds"].as_array().unwrap()
}

fn value(round: &Value, key: &str) -> f64 {
    round["parameters"][key]["value"].as_f64().unwrap_or_else(|| panic!("no {key} in {round}"))
}

/// Numbers from -1 to 1 (Lehmer's generator).
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0 * 48_271 % 2_147_483_647;
        2.0 * self.0 as f64 / 2_147_483_647.0 - 1.0
    }
}

#[test]
fn a_stiction_is_named_from_the_encoders_and_a_gap_behind_them() {
    let folder = WorkFolder::new();
    let plain = robot([0.0, 0.0, 150.0], "");
    let truth = model(
        folder.path(),
        "truth.yaml",
        &plain,
        "[{effect: stiction, target: J4, spike_deg: 0.01, decay_s: 0.8}, {effect: backlash, target: J2, half_gap_deg: 0.004}]",
    );
    let mut text =
        String::from("t_s,cmd_J1_deg,cmd_J2_deg,cmd_J3_deg,cmd_J4_deg,cmd_J5_deg,cmd_J6_deg,x_mm,y_mm,z_mm\n");
    for i in 0..1800 {
        let t = 0.05 * f64::from(i);
        let _ = write!(text, "{t:.2}");
        for j in 0..6 {
            let w = 0.55 + 0.13 * f64::from(j);
            let _ = write!(text, ",{:.6}", 8.0 * (w * t).sin() + 3.0 * (2.3 * w * t + f64::from(j)).sin() + 10.0);
        }
        text.push_str(",0,0,0\n");
    }
    let path = file(folder.path(), "path.csv", &text);
    let log = folder.join("log.csv");
    support::command()
        .args(["simulate", "--encoders", "--noise-um", "10", "--model"])
        .arg(&truth)
        .arg("--input")
        .arg(&path)
        .arg("--output")
        .arg(&log)
        .assert()
        .success();
    let doc = diagnose(&model(folder.path(), "bare.yaml", &plain, "[]"), &[log]);
    let of = |effect: &str| rounds(&doc).iter().find(|r| r["effect"] == effect).unwrap_or_else(|| panic!("{doc}"));
    assert_eq!(rounds(&doc).len(), 2, "{doc}");
    assert_eq!(of("stiction")["target"], "J4");
    assert!((value(of("stiction"), "spike_deg") - 0.01).abs() < 1e-4, "{doc}");
    assert_eq!(of("backlash")["target"], "J2");
    assert!((value(of("backlash"), "half_gap_deg") - 0.004).abs() < 2e-4, "{doc}");
}

/// Motor and link-side encoders of J2 and J3, the motor ahead of its command, the link 4 ms behind the motor.
fn two_encoders(seed: u64, scale: f64) -> String {
    let mut draw = Draw(seed);
    let mut text = String::from(
        "t_s,cmd_J2_deg,cmd_J3_deg,enc_J2_deg,enc_J3_deg,meas_J2_deg,meas_J3_deg,cmd_J1_deg,cmd_J4_deg,cmd_J5_deg,cmd_J6_deg\n",
    );
    let at = |j: usize, t: f64| {
        let w = scale * (0.7 + 0.3 * j as f64);
        12.0 * (w * t).sin() + 4.0 * (2.7 * w * t + 1.0).sin()
    };
    for i in 0..3000 {
        let t = 0.008 * f64::from(i);
        let _ = write!(text, "{t:.3},{:.6},{:.6}", at(0, t), at(1, t));
        let _ = write!(text, ",{:.6},{:.6}", at(0, t + 0.012), at(1, t + 0.012));
        for j in 0..2 {
            let motor = at(j, t + 0.008);
            let ripple = if j == 0 { 0.004 * (motor * 360.0 / 0.9 * std::f64::consts::PI / 180.0).sin() } else { 0.0 };
            let _ = write!(text, ",{:.6}", motor + ripple + 0.08 - 0.2 * j as f64 + 3e-4 * (draw.next() + draw.next()));
        }
        text.push_str(",0,0,0,0\n");
    }
    text
}

#[test]
fn a_clock_offset_between_two_encoders_is_named_once_and_a_lead_over_the_command_is_no_effect() {
    let folder = WorkFolder::new();
    let bare = model(folder.path(), "bare.yaml", &robot([0.0, 0.0, 150.0], ""), "[]");
    let logs = [(7, 1.0), (11, 1.4)].map(|(s, v)| file(folder.path(), &format!("{s}.csv"), &two_encoders(s, v)));
    let doc = diagnose(&bare, &logs);
    let first = &rounds(&doc)[0];
    assert_eq!(first["effect"], "time_offset", "{doc}");
    assert!((value(first, "offset_s") + 0.004).abs() < 5e-5, "{first}");
    let second = &rounds(&doc)[1];
    assert_eq!(
        (second["effect"].as_str(), second["target"].as_str()),
        (Some("transmission_error"), Some("J2")),
        "{doc}"
    );
    assert!(
        (value(second, "cycles_per_rev") - 400.0).abs() < 1.0 && (value(second, "amplitude_deg") - 0.004).abs() < 3e-4
    );
    assert_eq!(rounds(&doc).len(), 2, "{doc}");
    let notes = doc["notes"].to_string();
    assert!(notes.contains("lead") && notes.contains("joint_zero_offset"), "{notes}");
}

/// Poses with three reflectors, measured by a simulated arm.
fn poses(folder: &Path, truth: &Path) -> PathBuf {
    let mut draw = Draw(5);
    let mut text = String::from("cmd_J1_deg,cmd_J2_deg,cmd_J3_deg,cmd_J4_deg,cmd_J5_deg,cmd_J6_deg");
    for k in ["", "2", "3"] {
        for c in ["x", "y", "z"] {
            let _ = write!(text, ",{c}{k}_mm");
        }
    }
    text.push('\n');
    for _ in 0..500 {
        for _ in 0..6 {
            let _ = write!(text, "{:.4},", 50.0 * draw.next());
        }
        text.push_str("0,0,0,0,0,0,0,0,0\n");
    }
    let path = file(folder, "poses.csv", &text);
    let log = folder.join("log.csv");
    support::command()
        .args(["simulate", "--noise-um", "20", "--model"])
        .arg(truth)
        .arg("--input")
        .arg(&path)
        .arg("--output")
        .arg(&log)
        .assert()
        .success();
    log
}

const REFLECTORS: &str = "\ntools: [{xyz_mm: [80, 90, 210]}, {xyz_mm: [150, 0, 120]}]";
/// As they really are: the robot file has them 1 to 3 mm off.
const PLACED: &str = "\ntools: [{xyz_mm: [81, 88, 210]}, {xyz_mm: [152, -1, 123]}]";
const FAULTS: &str = "{effect: joint_zero_offset, target: J2, offset_deg: 0.08}, {effect: joint_zero_offset, target: J5, offset_deg: -0.05}, \
                      {effect: link_error, target: J2.a, delta_mm: 0.3}, {effect: link_error, target: J4.d, delta_mm: -0.4}";

#[test]
fn the_geometry_of_an_arm_is_one_group_and_a_gap_is_found_behind_it() {
    for gap in [0.0, 0.006] {
        let folder = WorkFolder::new();
        let effects = if gap > 0.0 {
            format!("[{FAULTS}, {{effect: backlash, target: J4, half_gap_deg: {gap}}}]")
        } else {
            format!("[{FAULTS}]")
        };
        let truth = model(folder.path(), "truth.yaml", &robot([1.0, -2.0, 122.0], PLACED), &effects);
        let log = poses(folder.path(), &truth);
        let doc = diagnose(&model(folder.path(), "bare.yaml", &robot([0.0, 0.0, 120.0], REFLECTORS), "[]"), &[log]);
        let group: Vec<&Value> = rounds(&doc).iter().filter(|r| r["group"] == "geometry").collect();
        for (target, key, want) in [
            ("J2", "offset_deg", 0.08),
            ("J5", "offset_deg", -0.05),
            ("J2.a", "delta_mm", 0.3),
            ("J4.d", "delta_mm", -0.4),
        ] {
            let round = group.iter().find(|r| r["target"] == target).unwrap_or_else(|| panic!("no {target} in {doc}"));
            assert!((value(round, key) - want).abs() < 0.05 * want.abs(), "{round}");
        }
        assert!(group.iter().all(|r| r["evidence"]["group"]["p_value"].as_f64().unwrap() < 1e-9), "{doc}");
        let others: Vec<&Value> = rounds(&doc).iter().filter(|r| r["group"].is_null()).collect();
        if gap > 0.0 {
            assert_eq!(others.len(), 1, "{doc}");
            assert_eq!((others[0]["effect"].as_str(), others[0]["target"].as_str()), (Some("backlash"), Some("J4")));
            assert!((value(others[0], "half_gap_deg") - gap).abs() < 0.15 * gap, "{}", others[0]);
        } else {
            assert!(others.is_empty(), "{doc}");
        }
    }
}
