//! `assess program`: better and worse as an executed program shows it, and the verdict that `rewrite` tells.

use crate::support::{self, WorkFolder, bundled, root};
use crate::vendor_circle::{circle, written};
use serde_json::Value;
use std::path::Path;

const MODEL: &str = "schema: lostmotion/model/1
robot: robot.yaml
effects:
  - {effect: backlash, joint: A1, half_gap_deg: 0.0028}
  - {effect: backlash, joint: A2, half_gap_deg: 0.0037}
  - {effect: backlash, joint: A3, half_gap_deg: 0.0022}
";

fn desk() -> WorkFolder {
    let folder = WorkFolder::new();
    let root = root();
    std::fs::copy(root.join("configs/kuka-kr120-r2500-pro.yaml"), folder.join("robot.yaml")).unwrap();
    std::fs::copy(root.join("samples/circle/circle_program.csv"), folder.join("circle.csv")).unwrap();
    std::fs::write(folder.join("machine.yaml"), MODEL).unwrap();
    folder
}

fn run(folder: &Path, line: &str) -> (i32, String, String) {
    let out = support::run(folder, line);
    (out.code.unwrap(), out.text(), out.stderr)
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn a_compensated_circle_is_better_and_the_way_back_is_worse() {
    let folder = desk();
    let at = folder.path();
    let (code, _, words) = run(at, "rewrite --model machine.yaml circle.csv --output done.csv --speed-mm-s 4");
    assert_eq!(code, 0, "{words}");
    assert!(words.contains("verdict on the model's machine: better"), "{words}");
    let line = "assess program --model machine.yaml --before circle.csv --after done.csv --speed-mm-s 4 --json --report proof.html";
    let (code, out, err) = run(at, line);
    assert_eq!(code, 0, "{err}");
    let doc = json(&out);
    assert_eq!(doc["verdict"], "better");
    let um = |key: &str, side: &str| doc[key][side].as_f64().unwrap();
    assert!(um("largest_um", "after") < 0.1 * um("largest_um", "before"), "{doc}");
    let after_reversals = doc["reversals"].as_array().unwrap().iter().map(|r| r["after_um"].as_f64().unwrap());
    assert!(after_reversals.fold(0.0, f64::max) < 5.0, "{doc}");
    assert!(um("rms_um", "after") < 0.2 * um("rms_um", "before"), "{doc}");
    assert!(doc["text_lines"]["added"].as_u64().unwrap() > 0);
    assert!(doc["reversals"].as_array().unwrap().len() >= 6);
    let page = std::fs::read_to_string(at.join("proof.html")).unwrap();
    assert!(page.contains("Better: path error rms"), "the page tells the verdict");
    let (code, _, err) =
        run(at, "assess program --model machine.yaml --before done.csv --after circle.csv --speed-mm-s 4");
    assert_eq!(code, 1, "{err}");
    assert!(err.contains("worse"), "{err}");
}

#[test]
fn a_program_against_itself_is_unchanged() {
    let folder = desk();
    let (code, out, _) =
        run(folder.path(), "assess program --model machine.yaml --before circle.csv --after circle.csv --json");
    // two paths of one name: the same file may be given twice
    assert_eq!(code, 0, "{out}");
    assert_eq!(json(&out)["verdict"], "unchanged");
}

/// A quarter of an hour of fast moves round a square, each of `leg_s`; `late_s`: how long the robot waits first.
fn squares(leg_s: f64, late_s: f64) -> String {
    let mut text = String::from("t_s,a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n0,0,-90,90,0,0,0\n");
    for k in 0..900 {
        let (a1, a2) = [(0, -90), (40, -90), (40, -60), (0, -60)][k % 4];
        text += &format!("{:.6},{a1},{a2},90,0,0,0\n", late_s + leg_s * (k + 1) as f64);
    }
    text
}

#[test]
fn corners_of_fast_moves_in_a_long_program_are_no_errors() {
    let folder = desk();
    let at = folder.path();
    // rows stand 6 mm apart here, and those of both runs elsewhere
    std::fs::write(at.join("before.csv"), squares(1.0013, 0.0)).unwrap();
    std::fs::write(at.join("after.csv"), squares(1.0013, 0.0017)).unwrap();
    let line = "assess program --model machine.yaml --before before.csv --after after.csv --json";
    let (code, out, err) = run(at, line);
    assert_eq!(code, 0, "{err}");
    let largest = |side: &str| json(&out)["largest_um"][side].as_f64().unwrap();
    // gaps of 2.8 to 3.7 mdeg at a reach of 2 to 3 m
    assert!((20.0..400.0).contains(&largest("before")), "{out}");
    assert!((largest("after") - largest("before")).abs() < 0.1 * largest("before"), "{out}");
}

#[test]
fn friction_that_builds_up_is_an_error_of_the_machine_and_not_of_its_path() {
    let folder = desk();
    let at = folder.path();
    let of = |effect: &str| {
        let model = format!(
            "schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n  - {{effect: stiction, joint: A1, spike_deg: 0.004, {effect}decay_s: 3}}\n"
        );
        std::fs::write(at.join("friction.yaml"), model).unwrap();
        let line = "assess program --model friction.yaml --before circle.csv --after circle.csv --speed-mm-s 4 --json";
        json(&run(at, line).1)["largest_um"]["before"].as_f64().unwrap()
    };
    let (at_once, built_up) = (of(""), of("rise_deg: 0.005, "));
    // over a travel as short as this the spike loses little of its size
    assert!(at_once > 20.0 && built_up > 0.5 * at_once && built_up < at_once, "{built_up} um for {at_once}");
}

#[test]
fn a_verdict_is_told_of_vendor_programs_and_never_good_where_the_largest_error_grows() {
    let folder = desk();
    let at = folder.path();
    // every n-th point of the circle: the coarser, the farther the reversals are from the points
    for every in [1, 8, 24] {
        let points: Vec<[f64; 6]> = circle().into_iter().step_by(every).collect();
        let (name, text, _) = written("rapid", &points);
        std::fs::write(at.join(&name), text).unwrap();
        let out = format!("done_{name}");
        let (code, _, words) =
            run(at, &format!("rewrite --model machine.yaml {name} --output {out} --speed-mm-s 4 --force"));
        assert_eq!(code, 0, "{words}");
        let (code, doc, _) = run(
            at,
            &format!("assess program --model machine.yaml --before {name} --after {out} --speed-mm-s 4 --json"),
        );
        let doc = json(&doc);
        let [before, after] = ["before", "after"].map(|s| doc["largest_um"][s].as_f64().unwrap());
        if after > 1.02 * before + 1.0 {
            assert_eq!((code, doc["verdict"].as_str()), (1, Some("worse")), "{doc}");
            assert!(words.contains("verdict on the model's machine: worse"), "{words}");
        } else {
            assert!(words.contains(&format!("verdict on the model's machine: {}", doc["verdict"].as_str().unwrap())));
        }
    }
}

#[test]
fn logs_of_both_runs_are_compared_like_the_programs() {
    let folder = desk();
    let at = folder.path();
    run(at, "rewrite --model machine.yaml circle.csv --output done.csv --speed-mm-s 4");
    for (program, log) in [("circle.csv", "before.log.csv"), ("done.csv", "after.log.csv")] {
        let line =
            format!("simulate --model machine.yaml --input {program} --output {log} --speed-mm-s 4 --noise-um 5");
        assert_eq!(run(at, &line).0, 0);
    }
    let (code, out, err) =
        run(at, "assess program --model machine.yaml --before before.log.csv --after after.log.csv --json");
    assert_eq!(code, 0, "{err}");
    let doc = json(&out);
    assert_eq!(doc["verdict"], "better");
    assert!(doc["rms_um"]["after"].as_f64().unwrap() < 0.5 * doc["rms_um"]["before"].as_f64().unwrap(), "{doc}");
}

/// Straight moves to and fro across the middle plane of the arm: each has a turn in its middle.
const ACROSS: &str = "DEF across( )\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\nPTP {A1 0,A2 -90,A3 90,A4 0,A5 60,A6 0}\n\
LIN {X 1500,Y 200,Z 1800,A 0,B 60,C 0}\nLIN {X 1500,Y -200,Z 1800,A 0,B 60,C 0}\nLIN {X 1500,Y 200,Z 1800,A 0,B 60,C 0}\n\
LIN {X 1500,Y -200,Z 1800,A 0,B 60,C 0}\nLIN {X 1500,Y 200,Z 1800,A 0,B 60,C 0}\nEND\n";

#[test]
fn errors_at_the_targets_and_on_the_way_are_told_apart() {
    let folder = WorkFolder::new();
    let at = folder.path();
    let robot = bundled("configs/kuka-kr120-r2500-pro.yaml");
    std::fs::copy(robot, at.join("robot.yaml")).unwrap();
    let gaps = (1..=6).map(|j| format!("  - {{effect: backlash, joint: A{j}, half_gap_deg: 0.004}}\n"));
    let model = format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{}", gaps.collect::<String>());
    std::fs::write(at.join("machine.yaml"), model).unwrap();
    std::fs::write(at.join("across.src"), ACROSS).unwrap();
    // without new points the step of a reversal is spread over the whole move: its goal is right, its start is not
    for (points, more) in [("few", " --max-added 0"), ("all", "")] {
        let line = format!("rewrite --model machine.yaml across.src --output {points}.src --force{more} --json");
        let (code, out, words) = run(at, &line);
        assert_eq!(code, 0, "{words}");
        let doc = &json(&out)["path_error"];
        let targets = &doc["at_targets"];
        let largest = |of: &Value, side: &str| of["largest_um"][side].as_f64().unwrap();
        assert_eq!((targets["targets"].as_u64(), targets["verdict"].as_str()), (Some(6), Some("better")), "{doc}");
        assert!(largest(targets, "before") > 100.0 && largest(targets, "after") < 2.0, "{points}: {doc}");
        if points == "few" {
            assert_eq!(doc["verdict_on_the_way"], "worse", "{doc}");
        } else {
            assert!(
                doc["rms_um"]["after"].as_f64().unwrap() < 0.4 * doc["rms_um"]["before"].as_f64().unwrap(),
                "{doc}"
            );
        }
        let line = format!("assess program --model machine.yaml --before across.src --after {points}.src");
        let words = run(at, &line).1;
        assert!(words.contains("at the targets") && words.contains("largest at the targets, um"), "{words}");
    }
}

#[test]
fn joint_moves_run_at_the_speeds_that_the_program_states() {
    let folder = desk();
    let at = folder.path();
    let target = |a1: f64, speed: &str| {
        format!("    MoveAbsJ [[{a1},-80,85,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],{speed},fine,tool0;\n")
    };
    let cycle = |second: &str| {
        let moves = target(0.0, "v50") + &target(5.0, second) + &target(0.0, "v50");
        std::fs::write(at.join("p.mod"), format!("MODULE p\n  PROC main()\n{moves}  ENDPROC\nENDMODULE\n")).unwrap();
        let (code, out, err) = run(at, "assess program --model machine.yaml --before p.mod --after p.mod --json");
        assert_eq!(code, 0, "{err}");
        let doc = json(&out);
        (doc["cycle_time_s"]["before"].as_f64().unwrap(), doc["notes"].to_string())
    };
    // 5 deg at the reach of about 1.9 m are some 170 mm each way, at 50 mm/s
    let (s, notes) = cycle("v50");
    assert!((5.0..9.0).contains(&s) && !notes.contains("speed"), "{s}: {notes}");
    let (faster, _) = cycle("v100");
    assert!((0.7..0.8).contains(&(faster / s)), "{faster} of {s}");
    // a speed that is set while the program runs: that of the others
    let (unknown, notes) = cycle("vVar");
    assert!((unknown - s).abs() < 1e-6, "{unknown} for {s}");
    assert!(notes.contains("1 move of unknown speed: 50 mm/s"), "{notes}");
}

#[test]
fn zero_offsets_of_a_calibrated_arm_are_no_error_that_a_program_should_lose() {
    let folder = desk();
    let at = folder.path();
    // found together with the errors of links: `rewrite` leaves them to the kinematics
    let calibrated = format!(
        "{MODEL}  - {{effect: joint_zero_offset, joint: A2, offset_deg: 0.03}}\n  - {{effect: joint_zero_offset, joint: A3, offset_deg: -0.02}}\n  \
         - {{effect: link_error, target: A2.a, delta_mm: 0.4}}\n  - {{effect: link_error, target: A3.a, delta_mm: -0.3}}\n  \
         - {{effect: link_error, target: A4.d, delta_mm: 0.3}}\n"
    );
    std::fs::write(at.join("calibrated.yaml"), calibrated).unwrap();
    let (code, _, words) = run(at, "rewrite --model calibrated.yaml circle.csv --output done.csv --speed-mm-s 4");
    assert_eq!(code, 0, "{words}");
    assert!(words.contains("part of a geometry error"), "{words}");
    assert!(words.contains("verdict on the model's machine: better"), "{words}");
    let line = "assess program --model calibrated.yaml --before circle.csv --after done.csv --speed-mm-s 4 --json";
    let (code, out, err) = run(at, line);
    assert_eq!(code, 0, "{err}");
    let doc = json(&out);
    let rms = |side: &str| doc["rms_um"][side].as_f64().unwrap();
    assert!(rms("before") < 100.0 && rms("after") < 0.2 * rms("before"), "{doc}");
}
