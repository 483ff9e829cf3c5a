//! One measurement model for every command: ballbar, dial and joint sensors for `identify` and `diagnose`, on machines whose gaps are
//! known. (`instruments` has `identify` of readings that a tracker's logs were made into.)

use crate::support::{self, WorkFolder, bundled};
use lostmotion::gaps::Gaps;
use lostmotion::log::Log;
use lostmotion::robot::Robot;
use nalgebra::Vector3;
use serde_json::Value;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::PathBuf;

/// Half gaps of X, Y, Z of the gantry, mm.
const TRUE_MM: [f64; 3] = [0.020, 0.030, 0.040];
const JOINTS: [&str; 3] = ["X", "Y", "Z"];
/// Middle of the gantry's motions, mm.
const MIDDLE_MM: [f64; 3] = [600.0, 400.0, -200.0];

/// Numbers from -1 to 1 (Lehmer's generator), and their sum as noise of standard deviation 1.
struct Draw(u64);

impl Draw {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0 * 48_271 % 2_147_483_647;
        2.0 * self.0 as f64 / 2_147_483_647.0 - 1.0
    }

    fn normal(&mut self) -> f64 {
        (0..3).map(|_| self.uniform()).sum()
    }
}

/// A gantry with gaps, and a folder with its files.
struct Desk {
    folder: WorkFolder,
    robot: Robot,
}

impl Desk {
    fn new() -> Self {
        let folder = WorkFolder::new();
        let source = bundled("tests/data/machines/gantry/robot.yaml");
        let text = std::fs::read_to_string(&source).unwrap();
        let robot = Robot::load(&source).unwrap();
        let gaps: String = JOINTS
            .iter()
            .zip(TRUE_MM)
            .map(|(j, b)| format!("  - {{effect: backlash, joint: {j}, half_gap_mm: {b}}}\n"))
            .collect();
        let model = format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{gaps}");
        let desk = Self { folder, robot };
        for (name, content) in [("robot.yaml", text), ("machine.yaml", model)] {
            std::fs::write(desk.at(name), content).unwrap();
        }
        // three turns of a circle in a tilted plane, and strokes of X alone
        let tilt = 35f64.to_radians();
        let circle = (0..=1200).map(|k| {
            let a = TAU * f64::from(k) / 400.0;
            [100.0 * a.cos(), 100.0 * a.sin() * tilt.cos(), 100.0 * a.sin() * tilt.sin()]
        });
        desk.program("circle.csv", circle);
        // the same in a plane that lies alike to all three joints: each reverses by itself
        let third = (2.0 / 3.0f64).sqrt() * 100.0;
        let apart = (0..=1200).map(|k| {
            let a = TAU * f64::from(k) / 400.0 + 0.4;
            [0.0, 1.0, 2.0].map(|j| third * (a + j * TAU / 3.0).cos())
        });
        desk.program("apart.csv", apart);
        desk.program("strokes.csv", (0..=960).map(|k| [15.0 * (TAU * f64::from(k) / 160.0).sin(), 0.0, 0.0]));
        desk
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    fn program(&self, name: &str, off_mm: impl Iterator<Item = [f64; 3]>) {
        let mut text = String::from("x_mm,y_mm,z_mm\n");
        for off in off_mm {
            let q: Vec<String> = MIDDLE_MM.iter().zip(off).map(|(m, o)| format!("{:.5}", m + o)).collect();
            text += &(q.join(",") + "\n");
        }
        std::fs::write(self.at(name), text).unwrap();
    }

    fn run(&self, line: &str) -> String {
        self.folder.run(line).success().stderr
    }

    fn json(&self, line: &str) -> Value {
        let mut command = support::command();
        let run = command.current_dir(self.folder.path()).args(line.split_whitespace()).assert().success();
        serde_json::from_slice(&run.get_output().stdout).unwrap()
    }

    /// A run of a program on the machine as a tracker in the robot's own frame would see it.
    fn measured(&self, program: &str, seed: u32) -> Log {
        self.measured_at(20, program, seed)
    }

    /// The same with so many rows a second.
    fn measured_at(&self, rate_hz: u32, program: &str, seed: u32) -> Log {
        self.run(&format!(
            "simulate --model machine.yaml --input {program} --output seen.csv --speed-mm-s 8 --rate-hz {rate_hz} --noise-um 1 --seed {seed}"
        ));
        Log::load(&self.at("seen.csv"), &self.robot).unwrap()
    }

    /// A log with other columns than the TCP, computed from it.
    fn read(&self, log: &Log, name: &str, columns: &str, values: impl Fn(usize, &Vector3<f64>) -> String) {
        let mut text = format!("t_s,cmd_X_mm,cmd_Y_mm,cmd_Z_mm,{columns}\n");
        for row in 0..log.len() {
            let q: Vec<String> = log.cmd.iter().map(|c| format!("{:.6}", c[row] * 1e3)).collect();
            let _ = writeln!(text, "{:.4},{},{}", log.t_s[row], q.join(","), values(row, &log.tcp_m[row].unwrap()));
        }
        std::fs::write(self.at(name), text).unwrap();
    }

    /// Distances from a point that is not quite the centre of the circle, less a length that is not quite the bar's.
    fn ballbar(&self, log: &Log, name: &str) {
        let centre = self.robot.tcp_m(&MIDDLE_MM.map(|v| v * 1e-3)) + Vector3::new(0.7e-3, -0.4e-3, 0.3e-3);
        self.read(log, name, "r_um", |_, p| format!("{:.3}", ((p - centre).norm() - 0.1003) * 1e6));
    }

    /// Positions after the gears, each with a zero that is not that of the commands.
    fn sensors(&self, log: &Log, name: &str) {
        let origin = self.robot.tcp_m(&[0.0; 3]);
        let mut axes = vec![Vector3::zeros(); 3];
        self.robot.chain().position_and_jacobian(&[0.0; 3], &mut axes);
        let values = |_: usize, p: &Vector3<f64>| {
            let q: Vec<String> = axes.iter().map(|a| format!("{:.5}", a.dot(&(p - origin)) * 1e3 + 0.25)).collect();
            q.join(",")
        };
        self.read(log, name, "meas_X_mm,meas_Y_mm,meas_Z_mm", values);
    }
}

/// Half gaps of the effects of a diagnosis, by joint.
fn named(doc: &Value) -> Vec<(String, f64)> {
    let effects = doc["effects"].as_array().unwrap();
    let gaps = effects.iter().filter(|e| e["effect"] == "backlash");
    gaps.map(|e| (e["target"].as_str().unwrap().to_string(), e["half_gap_mm"].as_f64().unwrap())).collect()
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn val_diagnose_names_the_gaps_that_a_ballbar_circle_shows() {
    let desk = Desk::new();
    // in the tilted plane Y and Z reverse together: the reading shows one loss that is crossed over two travels
    for program in ["apart.csv", "circle.csv"] {
        desk.ballbar(&desk.measured(program, 3), "bar.csv");
        let doc = desk.json("diagnose --robot robot.yaml --log bar.csv --json");
        let found = named(&doc);
        assert_eq!(found.len(), 3, "{program}: {}", doc["effects"]);
        assert_eq!(doc["effects"].as_array().unwrap().len(), 3, "{program}: {}", doc["effects"]);
        for (joint, want) in JOINTS.iter().zip(TRUE_MM) {
            let is = found.iter().find(|f| f.0 == *joint).unwrap().1;
            assert!((is / want - 1.0).abs() < 0.05, "{program}, {joint}: {is} for {want}");
        }
        let left = doc["gap"]["final_rms_um"].as_f64().unwrap();
        assert!(left < 1.2, "{program}: {left} um of 1.0 um noise");
        let notes = doc["notes"].to_string();
        assert!(notes.contains("a reading shows one part of the motion of the TCP"), "{notes}");
    }
}

#[test]
fn val_what_a_ballbar_cannot_tell_has_a_set() {
    let desk = Desk::new();
    // 4 mm from row to row: no row within a crossing, so that Y and Z, which reverse together, are one to the reading
    desk.ballbar(&desk.measured_at(2, "circle.csv", 3), "bar.csv");
    let doc = desk.json("diagnose --robot robot.yaml --log bar.csv --json");
    for round in doc["rounds"].as_array().unwrap().iter().filter(|r| r["target"] != "X") {
        let value = round["parameters"]["half_gap_mm"]["value"].as_f64();
        let true_mm = JOINTS.iter().zip(TRUE_MM).find(|j| *j.0 == round["target"]).map(|j| j.1);
        let right = value.zip(true_mm).is_some_and(|(is, want)| (is / want - 1.0).abs() < 0.05);
        let several = round["set"].as_array().is_some_and(|set| set.len() > 1);
        assert!(right || several || doc["verdict"] == "unknown", "{}: {round}", doc["verdict"]);
    }
}

/// Strokes of X alone against a dial, with rests at the ends or without, by the play operator in steps of a tenth of a row.
fn dial_of_x(desk: &Desk, name: &str, rests: bool) -> Vector3<f64> {
    let mut axes = vec![Vector3::zeros(); 3];
    desk.robot.chain().position_and_jacobian(&[0.0; 3], &mut axes);
    let (mut text, mut draw) = (String::from("t_s,cmd_X_mm,cmd_Y_mm,cmd_Z_mm,dial_um\n"), Draw(7));
    let mut y = MIDDLE_MM[0];
    let stroke_s = 15.0 / 8.0;
    let part_s = if rests { stroke_s + 1.0 } else { stroke_s };
    for i in 0..6000 {
        let t = f64::from(i) * 0.005;
        let (part, within) = ((t / part_s).floor(), (t % part_s).min(stroke_s) / stroke_s);
        let up = part as i64 % 2 == 0;
        let q = MIDDLE_MM[0] + 15.0 * if up { within } else { 1.0 - within };
        y = y.clamp(q - TRUE_MM[0], q + TRUE_MM[0]);
        if i % 10 == 0 {
            let read = 1e3 * (y - MIDDLE_MM[0]) + draw.normal();
            let _ = writeln!(text, "{t:.4},{q:.6},{:.6},{:.6},{read:.3}", MIDDLE_MM[1], MIDDLE_MM[2]);
        }
    }
    std::fs::write(desk.at(name), text).unwrap();
    axes[0]
}

#[test]
fn val_diagnose_names_the_gap_that_a_dial_shows_and_asks_for_its_direction() {
    let desk = Desk::new();
    let along = dial_of_x(&desk, "dial.csv", true);
    let direction = format!("{},{},{}", along.x, along.y, along.z);
    let doc = desk.json(&format!("diagnose --robot robot.yaml --log dial.csv --direction {direction} --json"));
    let found = named(&doc);
    assert_eq!(found.len(), 1, "{}", doc["effects"]);
    assert!(found[0].0 == "X" && (found[0].1 / TRUE_MM[0] - 1.0).abs() < 0.05, "{found:?}");
    let refused = desk.folder.run("diagnose --robot robot.yaml --log dial.csv").ends_with(2).stderr;
    assert!(refused.contains("`dial_um` without its direction") && refused.contains("--direction"), "{refused}");
}

#[test]
fn val_a_gap_at_one_speed_without_rests_is_named_by_a_dial_only_beside_a_lag() {
    let desk = Desk::new();
    let along = dial_of_x(&desk, "dial.csv", false);
    let direction = format!("{},{},{}", along.x, along.y, along.z);
    let doc = desk.json(&format!("diagnose --robot robot.yaml --log dial.csv --direction {direction} --json"));
    // half a gap against the movement, and what a late reading is off at one speed, are the same
    let found = named(&doc);
    let right = found.len() == 1 && (found[0].1 / TRUE_MM[0] - 1.0).abs() < 0.05;
    assert!(right || doc["verdict"] != "named", "{}: {}", doc["verdict"], doc["effects"]);
}

/// The arm's joints after their gears: gaps by the play operator, noise of a third of an arc second.
fn sensed_arm(folder: &WorkFolder, half_gaps_deg: [f64; 6]) -> Robot {
    let robot = Robot::load(&bundled("tests/data/machines/arm/robot.yaml")).unwrap();
    let names = robot.axis_names();
    let mut text = String::from("t_s");
    names.iter().for_each(|n| text += &format!(",cmd_{n}_deg"));
    names.iter().for_each(|n| text += &format!(",meas_{n}_deg"));
    text.push('\n');
    let (mut draw, mut y) = (Draw(11), [f64::NAN; 6]);
    for i in 0..4800 {
        let t = f64::from(i) * 0.05;
        let q: Vec<f64> = (0..6)
            .map(|a| {
                let w = TAU * (a as f64 + 3.0) / 120.0;
                [10.0, -30.0, 20.0, 5.0, 40.0, 15.0][a] + 4.0 * (w * t).sin() + 1.5 * (2.3 * w * t + a as f64).sin()
            })
            .collect();
        let _ = write!(text, "{t:.3}");
        q.iter().for_each(|v| text += &format!(",{v:.6}"));
        for (a, b) in half_gaps_deg.iter().enumerate() {
            y[a] = if y[a].is_nan() { q[a] - b } else { y[a].clamp(q[a] - b, q[a] + b) };
            // the sensor has another zero, and a scale that is off by 50 ppm
            text += &format!(",{:.6}", 1.00005 * y[a] + 3.0 + 1e-4 * draw.normal());
        }
        text.push('\n');
    }
    std::fs::write(folder.join("sensors.csv"), text).unwrap();
    std::fs::copy(bundled("tests/data/machines/arm/robot.yaml"), folder.join("robot.yaml")).unwrap();
    robot
}

#[test]
fn val_joint_sensors_give_the_gaps_of_all_joints_to_identify_and_to_identify_path() {
    let folder = WorkFolder::new();
    let gaps_deg = [0.004, 0.006, 0.005, 0.008, 0.010, 0.012];
    let robot = sensed_arm(&folder, gaps_deg);
    folder.run("identify --robot robot.yaml --log sensors.csv --output all.yaml").success();
    folder.run("identify path --robot robot.yaml --log sensors.csv --output path.yaml").success();
    let load = |name: &str| Gaps::load(&folder.join(name), &robot).unwrap();
    let (all, path) = (load("all.yaml"), load("path.yaml"));
    for (axis, want) in gaps_deg.map(f64::to_radians).into_iter().enumerate() {
        let gap = all.joints.iter().find(|j| j.axis == axis).unwrap();
        let estimate = all.estimate.as_ref().unwrap().joints.iter().find(|j| j.axis == axis).unwrap();
        let sum = gap.half_gap + estimate.response.windup();
        assert!((sum / want - 1.0).abs() < 0.05, "axis {axis}: {sum:e} for {want:e}");
        assert!(gap.ci95[0] <= want && want <= gap.ci95[1], "axis {axis}: {:?} for {want:e}", gap.ci95);
        let gap = path.joints.iter().find(|j| j.axis == axis).unwrap();
        assert!((gap.half_gap / want - 1.0).abs() < 0.05, "axis {axis}, path: {:e} for {want:e}", gap.half_gap);
    }
    // along a path of several joints their sensors predict its error together
    assert_eq!(all.estimate.as_ref().unwrap().predicted.len(), 1);
    folder.run("fit --robot robot.yaml --gaps all.yaml --output c.yaml").success();
}

#[test]
fn a_log_of_sensors_stands_beside_one_of_a_tracker() {
    let desk = Desk::new();
    let log = desk.measured("circle.csv", 5);
    desk.run("simulate --model machine.yaml --input circle.csv --output tracker.csv --speed-mm-s 8 --rate-hz 20 --noise-um 5 --seed 6");
    desk.sensors(&log, "sensors.csv");
    desk.run("identify --robot robot.yaml --log tracker.csv --log sensors.csv --output both.yaml");
    let both = Gaps::load(&desk.at("both.yaml"), &desk.robot).unwrap();
    for (axis, want) in TRUE_MM.iter().enumerate() {
        let gap = both.joints.iter().find(|j| j.axis == axis).unwrap();
        assert!((gap.half_gap * 1e3 / want - 1.0).abs() < 0.06, "{}: {}", JOINTS[axis], gap.half_gap * 1e3);
    }
}

#[test]
fn an_empty_log_is_refused_with_its_name() {
    let desk = Desk::new();
    std::fs::write(desk.at("empty.csv"), "").unwrap();
    std::fs::write(desk.at("head.csv"), "t_s,cmd_X_mm,cmd_Y_mm,cmd_Z_mm,r_um\n").unwrap();
    for log in ["empty.csv", "head.csv"] {
        for command in ["diagnose", "identify", "identify path"] {
            let said = desk.folder.run(&format!("{command} --robot robot.yaml --log {log}")).ends_with(2).stderr;
            assert!(said.contains(log), "{command}: {said}");
        }
    }
}

#[test]
fn readings_that_cannot_be_what_their_column_says_are_refused() {
    let desk = Desk::new();
    let log = desk.measured("apart.csv", 3);
    let middle = desk.robot.tcp_m(&MIDDLE_MM.map(|v| v * 1e-3)) + Vector3::new(1e-3, 0.0, 0.0);
    let off = |p: &Vector3<f64>| (p - middle).norm() - 0.1;
    desk.read(&log, "mm_as_um.csv", "r_um", |_, p| format!("{:.6}", off(p) * 1e3));
    desk.read(&log, "um_as_mm.csv", "r_mm", |_, p| format!("{:.1}", (off(p) + 0.1) * 1e6));
    for (name, said) in [("mm_as_um.csv", "larger unit"), ("um_as_mm.csv", "smaller unit")] {
        for command in ["diagnose", "identify", "identify path"] {
            let refused = desk.folder.run(&format!("{command} --robot robot.yaml --log {name}")).ends_with(2).stderr;
            assert!(refused.contains(said), "{command}, {name}: {refused}");
        }
    }
    // a dial across the joint that moves, whose readings say that it does not stand there
    let along = dial_of_x(&desk, "dial.csv", true);
    let across = Vector3::new(along.y, along.z, along.x);
    let direction = format!("--direction {},{},{}", across.x, across.y, across.z);
    for command in ["diagnose", "identify", "identify path"] {
        let line = format!("{command} --robot robot.yaml --log dial.csv {direction}");
        let refused = desk.folder.run(&line).ends_with(2).stderr;
        assert!(refused.contains("along the dial") && refused.contains("--direction"), "{command}: {refused}");
        if command != "identify path" {
            let refused = desk.folder.run(&format!("{line} --centre 1,2,3")).ends_with(2).stderr;
            assert!(refused.contains("--centre") && refused.contains("no log that it is for"), "{command}: {refused}");
        }
    }
}
