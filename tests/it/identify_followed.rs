//! `identify` where commands have corners and servos lag: programs of points, dwells, swapped sensors; on simulated machines of known gaps.

use crate::support::{WorkFolder, bundled};
use serde_json::Value;
use std::f64::consts::TAU;
use std::fmt::Write;

const JOINTS: [&str; 6] = ["A1", "A2", "A3", "A4", "A5", "A6"];
const HALF_GAPS_DEG: [f64; 6] = [0.0028, 0.0037, 0.0022, 0.008, 0.009, 0.01];
const HOME_DEG: [f64; 6] = [10.0, -85.0, 95.0, 20.0, 40.0, 15.0];

/// A machine with these effects of each joint, one line each.
fn machine(effects: impl Fn(usize) -> Vec<String>) -> WorkFolder {
    let folder = WorkFolder::new();
    let mut model = String::from("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n");
    for effect in (0..6).flat_map(effects) {
        let _ = writeln!(model, "  - {{{effect}}}");
    }
    std::fs::copy(bundled("configs/kuka-kr120-r2500-pro.yaml"), folder.join("robot.yaml")).unwrap();
    std::fs::write(folder.join("machine.yaml"), model).unwrap();
    folder
}

fn gap(axis: usize) -> String {
    format!("effect: backlash, joint: {}, half_gap_deg: {}", JOINTS[axis], HALF_GAPS_DEG[axis])
}

fn lag(axis: usize, lag_s: f64) -> String {
    format!("effect: servo_lag, joint: {}, lag_s: {lag_s}", JOINTS[axis])
}

/// A program of all joints, two sines each, with points `apart_s` apart.
fn program(seconds: f64, apart_s: f64) -> String {
    let mut text = String::from("t_s,a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n");
    for i in 0..(seconds / apart_s) as usize {
        let t = apart_s * i as f64;
        let _ = write!(text, "{t:.3}");
        for (k, home) in HOME_DEG.iter().enumerate() {
            let k = k as f64;
            let (slow, fast) = (0.041 + 0.007 * k, 0.113 - 0.009 * k);
            let q = home + 6.0 * (TAU * slow * t + k).sin() + 4.0 * (TAU * fast * t + 2.0 * k).sin();
            let _ = write!(text, ",{q:.5}");
        }
        text.push('\n');
    }
    text
}

/// A test of dwells of one joint: three angles, each three times from both sides.
fn dwells(axis: usize) -> String {
    let mut text = String::from("t_s,a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n");
    let (mut t, mut at) = (0.0, HOME_DEG[axis]);
    let mut to = |q: f64, stay_s: f64, text: &mut String| {
        t += f64::max(0.1, (q - at).abs() / 5.0);
        at = q;
        for t in [t, t + stay_s].into_iter().take(if stay_s > 0.0 { 2 } else { 1 }) {
            let _ = write!(text, "{t:.4}");
            for (k, home) in HOME_DEG.iter().enumerate() {
                let _ = write!(text, ",{:.5}", if k == axis { at } else { *home });
            }
            text.push('\n');
        }
        t += stay_s;
    };
    to(HOME_DEG[axis], 0.5, &mut text);
    for angle in [-15.0, 0.0, 12.0].map(|off| HOME_DEG[axis] + off) {
        to(angle - 2.0, 0.0, &mut text);
        for _ in 0..3 {
            for (q, stay_s) in [(angle, 1.0), (angle + 2.0, 0.0), (angle, 1.0), (angle - 2.0, 0.0)] {
                to(q, stay_s, &mut text);
            }
        }
    }
    text
}

fn joints(folder: &WorkFolder, logs: &[String]) -> Vec<Value> {
    let logs: String = logs.iter().map(|l| format!(" --log {l}")).collect();
    let told = folder.run(&format!("identify --robot robot.yaml{logs} --json")).success();
    let document: Value = told.json();
    document["joints"].as_array().unwrap().clone()
}

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap()
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn programs_of_points_some_tenths_of_a_second_apart_show_their_gaps() {
    let folder = machine(|axis| vec![gap(axis)]);
    for apart_s in [0.1, 0.2, 0.3, 0.5] {
        std::fs::write(folder.join("p.csv"), program(150.0, apart_s)).unwrap();
        let _ = std::fs::remove_file(folder.join("log.csv"));
        folder
            .run("simulate --model machine.yaml --input p.csv --output log.csv --rate-hz 50 --noise-um 11 --seed 3")
            .success();
        for (joint, truth) in joints(&folder, &["log.csv".into()]).iter().zip(HALF_GAPS_DEG) {
            // in so few places gap and wind-up are known together, and less well each
            let found = number(&joint["half_gap_deg"]) + number(&joint["response"]["windup_deg"]);
            assert!((found / truth - 1.0).abs() < 0.05, "{apart_s} s: {found} for {truth}: {joint:#}");
            assert_eq!(joint["trust"]["compensate"], true, "{apart_s} s: {joint:#}");
        }
    }
}

/// A lag of 50 ms moves a joint on after each stop for some tenths of a second, as friction that fades does.
#[test]
fn a_lag_in_a_test_of_dwells_is_neither_gap_nor_friction() {
    let folder = machine(|axis| vec![lag(axis, 0.05)]);
    let logs: Vec<String> = (0..6).map(|axis| format!("static{axis}.csv")).collect();
    for (axis, log) in logs.iter().enumerate() {
        std::fs::write(folder.join("p.csv"), dwells(axis)).unwrap();
        folder
            .run(&format!(
                "simulate --model machine.yaml --input p.csv --output {log} --rate-hz 25 --noise-um 11 --seed {axis}"
            ))
            .success();
    }
    for joint in joints(&folder, &logs) {
        let trust = &joint["trust"];
        assert!(trust["compensate"] == false || number(&trust["before_um"]) < 1.5, "{joint:#}");
    }
}

#[test]
fn sensors_of_two_joints_that_are_swapped_are_refused() {
    let folder = machine(|axis| vec![gap(axis)]);
    std::fs::write(folder.join("p.csv"), program(60.0, 0.05)).unwrap();
    let text = std::fs::read_to_string(folder.join("p.csv")).unwrap();
    let mut log = String::from("t_s");
    for what in ["cmd", "meas"] {
        JOINTS.iter().for_each(|j| log += &format!(",{what}_{j}_deg"));
    }
    for swapped in [false, true] {
        let mut log = if swapped {
            log.replace("meas_A1", "meas_A").replace("meas_A2", "meas_A1").replace("meas_A_", "meas_A2_")
        } else {
            log.clone()
        };
        log.push('\n');
        for line in text.lines().skip(1) {
            let (_, joints) = line.split_once(',').unwrap();
            let _ = writeln!(log, "{line},{joints}");
        }
        std::fs::write(folder.join("log.csv"), log).unwrap();
        for command in ["identify", "identify path"] {
            let told = folder.run(&format!("{command} --robot robot.yaml --log log.csv"));
            assert_eq!(told.succeeded(), !swapped, "{}", told.stderr);
            if swapped {
                let named = "column `meas_A1` follows the commands of A2, not those of A1";
                assert!(told.stderr.contains(named), "{}", told.stderr);
            }
        }
    }
}
