//! What is taken as known put in doubt: the frame of several logs, the model's registration, sizes of its own effects.
//!
//! The log is that of an independent simulator (`tests/data/diagnose`): backlash of J1.

use crate::diagnose_cli::{BACKLASH, BACKLASH_RUN, log_text};
use crate::support::WorkFolder;
use lostmotion::model::Model;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use serde_json::Value;
use std::path::PathBuf;

struct Desk(WorkFolder);

impl Desk {
    fn new() -> Self {
        let desk = Self(WorkFolder::new());
        std::fs::copy(format!("{BACKLASH}/robot.yaml"), desk.path("robot.yaml")).unwrap();
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    fn model(&self, name: &str, rest: &str) {
        self.write(name, &format!("schema: lostmotion/model/1\nrobot: robot.yaml\n{rest}\n"));
    }

    fn run(&self, line: &str) -> (Option<i32>, Vec<u8>, String) {
        let run = self.0.run(line);
        (run.code, run.stdout, run.stderr)
    }

    fn diagnose(&self, line: &str) -> Value {
        let (code, out, err) = self.run(&format!("diagnose --json {line}"));
        assert_eq!(code, Some(0), "{err}");
        serde_json::from_slice(&out).unwrap()
    }

    /// The two halves of the log, the second as a tracker sees it that was turned by `deg` about z and moved by `mm` along x.
    fn halves(&self, deg: f64, mm: f64) {
        let text = log_text(BACKLASH);
        let mut lines = text.lines().filter(|l| !l.starts_with('#'));
        let header = lines.next().unwrap();
        let column = |name: &str| header.split(',').position(|c| c == name).unwrap();
        let (x, y) = (column("x_mm"), column("y_mm"));
        let rows: Vec<&str> = lines.collect();
        let (sin, cos) = deg.to_radians().sin_cos();
        let moved = |row: &&str| {
            let mut cells: Vec<String> = row.split(',').map(str::to_string).collect();
            if let (Ok(a), Ok(b)) = (cells[x].parse::<f64>(), cells[y].parse::<f64>()) {
                cells[x] = format!("{:.6}", cos * a - sin * b + mm);
                cells[y] = format!("{:.6}", sin * a + cos * b);
            }
            cells.join(",")
        };
        let (first, second) = rows.split_at(rows.len() / 2);
        self.write("first.csv", &format!("{header}\n{}\n", first.join("\n")));
        self.write("second.csv", &format!("{header}\n{}\n", second.iter().map(moved).collect::<Vec<_>>().join("\n")));
    }
}

fn first_note(d: &Value) -> &str {
    d["notes"][0].as_str().unwrap_or_default()
}

fn half_gap(d: &Value) -> f64 {
    d["rounds"][0]["parameters"]["half_gap_deg"]["value"].as_f64().unwrap()
}

#[test]
fn logs_of_two_stations_of_the_tracker_have_a_frame_each() {
    let desk = Desk::new();
    desk.model("model.yaml", "effects: []");
    desk.halves(0.0, 0.0);
    let logs = "--model model.yaml --log first.csv --log second.csv";
    let one = desk.diagnose(logs);
    desk.halves(30.0, 50.0);
    let two = desk.diagnose(&format!("{logs} --model-out found.yaml"));
    assert!(two["notes"].to_string().contains("each log gets its own frame"), "{}", two["notes"]);
    assert!(!one["notes"].to_string().contains("its own frame"), "{}", one["notes"]);
    for d in [&one, &two] {
        assert_eq!(
            (d["rounds"][0]["effect"].as_str(), d["rounds"][0]["target"].as_str()),
            (Some("backlash"), Some("J1"))
        );
    }
    assert!((half_gap(&one) - half_gap(&two)).abs() < 0.02 * half_gap(&one), "{} {}", half_gap(&one), half_gap(&two));
    let floor = |d: &Value| d["gap"]["final_rms_um"].as_f64().unwrap();
    assert!((floor(&one) - floor(&two)).abs() < 0.05 * floor(&one), "{} {}", floor(&one), floor(&two));
    // the next log is measured from another place
    assert!(!std::fs::read_to_string(desk.path("found.yaml")).unwrap().contains("registration"));
}

#[test]
fn a_shift_that_may_be_the_machine_s_is_a_contradiction_and_no_noise() {
    let desk = Desk::new();
    desk.model("model.yaml", "effects: []");
    desk.halves(0.0, 1.0);
    let d = desk.diagnose("--model model.yaml --log first.csv --log second.csv");
    assert_eq!(d["verdict"], "unknown");
    assert!(first_note(&d).contains("the logs are not in one frame"), "{}", d["notes"]);
    // half a millimetre to either side, a coordinate of three
    let said = d["unexplained"]["rms_um"].as_f64().unwrap();
    assert!((said - 500.0 / 3_f64.sqrt()).abs() < 60.0, "{said}");
    assert!(d["unexplained"]["p_value"].as_f64().unwrap() < 1e-6);
}

#[test]
fn an_effect_of_the_model_that_is_too_large_is_named_with_the_size_that_fits() {
    let desk = Desk::new();
    let truth = BACKLASH_RUN.json["rounds"][0]["parameters"]["half_gap_deg"]["value"].as_f64().unwrap();
    desk.write("log.csv", &log_text(BACKLASH));
    desk.model("model.yaml", "effects:\n  - {effect: backlash, joint: J1, half_gap_deg: 0.006}");
    let d = desk.diagnose("--model model.yaml --log log.csv");
    assert_eq!(d["verdict"], "unknown");
    let note = first_note(&d);
    assert!(note.contains("backlash J1 of the model does not fit this log"), "{note}");
    let near: f64 = note.split("half_gap_deg ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!((near - truth).abs() < 0.02 * truth, "{near} for {truth}");
    // right, or a little small, it is no contradiction
    for size in [truth, 0.9 * truth] {
        desk.model("model.yaml", &format!("effects:\n  - {{effect: backlash, joint: J1, half_gap_deg: {size}}}"));
        let d = desk.diagnose("--model model.yaml --log log.csv");
        assert!(!d["notes"].to_string().contains("of the model does not fit this log"), "{}", d["notes"]);
    }
}

#[test]
fn a_registration_that_is_turned_is_said_to_explain_as_much_as_what_was_found() {
    let desk = Desk::new();
    desk.write("log.csv", &log_text(BACKLASH));
    let mut model = Model::load(&BACKLASH_RUN.model).unwrap();
    model.effects.clear();
    desk.write("right.yaml", &model.to_yaml_inline().unwrap());
    let frame = model.registration.unwrap();
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.1_f64.to_radians());
    model.registration = Some(Isometry3::from_parts(frame.translation, turn * frame.rotation));
    desk.write("turned.yaml", &model.to_yaml_inline().unwrap());
    let right = desk.diagnose("--model right.yaml --log log.csv");
    assert_eq!((right["verdict"].as_str(), right["rounds"].as_array().unwrap().len()), (Some("named"), 1));
    assert!(!right["notes"].to_string().contains("another frame"), "{}", right["notes"]);
    let turned = desk.diagnose("--model turned.yaml --log log.csv");
    let notes = turned["notes"].to_string();
    assert!(notes.contains("another frame alone") && notes.contains("leave it out of the model"), "{notes}");
}

#[test]
fn a_gap_that_may_remain_is_asked_for_on_the_command_line() {
    let desk = Desk::new();
    desk.write("log.csv", &log_text(BACKLASH));
    desk.model("model.yaml", "effects: []");
    let left = BACKLASH_RUN.json["gap"]["final_rms_um"].as_f64().unwrap();
    for (most, code) in [(left * 1.01, 0), (left * 0.99, 1)] {
        let (found, out, err) = desk.run(&format!("diagnose --model model.yaml --log log.csv --max-gap-um {most}"));
        assert_eq!(found, Some(code), "{err}");
        // the answer is printed in any case
        assert!(String::from_utf8_lossy(&out).contains("Missing: backlash J1"));
    }
    assert_eq!(desk.run("diagnose --model model.yaml --log log.csv --max-gap-um nan").0, Some(2));
}

#[test]
fn a_log_without_motion_shows_nothing_whatever_its_registration() {
    let desk = Desk::new();
    let row = |k: u32| format!("{:.2},0,-90,90,0,10,0,{:.4},0,0\n", f64::from(k) * 0.04, f64::from(k % 3) * 0.004);
    let rows: String = (0..500).map(row).collect();
    let header: String = (1..=6).map(|j| format!("cmd_J{j}_deg,")).collect();
    desk.write("still.csv", &format!("t_s,{header}x_mm,y_mm,z_mm\n{rows}"));
    desk.model("model.yaml", "registration: {xyz_mm: [0, 0, 0], rpy_deg: [0, 0, 0]}\neffects: []");
    assert_eq!(desk.diagnose("--model model.yaml --log still.csv")["verdict"], "not_observable");
    // a log with too few points for anything is bad data, as a document too
    desk.write("one.csv", &format!("t_s,{header}x_mm,y_mm,z_mm\n{}", row(0)));
    desk.model("free.yaml", "effects: []");
    let (code, out, _) = desk.run("diagnose --json --model free.yaml --log one.csv");
    assert_eq!(code, Some(2));
    let d: Value = serde_json::from_slice(&out).unwrap();
    assert_eq!(d["verdict"], "bad_data");
    // and nothing to plan from
    std::fs::write(desk.path("bad.json"), &out).unwrap();
    let (code, _, err) = desk.run("plan-experiment --model free.yaml --diagnosis bad.json");
    assert!(code == Some(2) && err.contains("a diagnosis of bad data"), "{err}");
}

#[test]
fn the_gap_of_an_exact_log_is_a_plain_one() {
    let desk = Desk::new();
    desk.model(
        "truth.yaml",
        "effects:\n  - {effect: backlash, joint: J2, half_gap_deg: 0.003}\n  - {effect: stiction, joint: J3, spike_deg: 0.004, decay_s: 0.8}",
    );
    desk.write("log.csv", &log_text(BACKLASH));
    assert_eq!(desk.run("simulate --model truth.yaml --input log.csv --output exact.csv").0, Some(0));
    desk.model("model.yaml", "effects: []");
    let d = desk.diagnose("--model model.yaml --log exact.csv");
    let named: Vec<&str> = d["rounds"].as_array().unwrap().iter().map(|r| r["effect"].as_str().unwrap()).collect();
    assert_eq!(d["rounds"][0]["target"], "J2", "{named:?}");
    assert_eq!(named[0], "backlash", "{named:?}");
    assert!((half_gap(&d) - 0.003).abs() < 3e-6, "{}", half_gap(&d));
}
