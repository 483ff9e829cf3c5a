//! Targets on a border of their configuration: a tool that points straight down has J4 at 0, where one quarter ends. What is written keeps
//! the configuration, by a sign that needs no kinematics: seen along the arm, the tool leans to the side of its J4.

use crate::support::WorkFolder;
use serde_json::Value;
use std::fmt::Write;

/// ABB IRB 1600: from the flange to the centre of the wrist, mm.
const WRIST_MM: f64 = 65.0;
const HALF_GAP_DEG: f64 = 0.004;
const REST: &str = "[9E9,9E9,9E9,9E9,9E9,9E9]";
/// Places of the flange, mm, on the left of the arm.
const PLACES: [[f64; 3]; 5] =
    [[900.0, 60.0, 900.0], [900.0, 200.0, 900.0], [800.0, 120.0, 800.0], [850.0, 240.0, 850.0], [900.0, 60.0, 950.0]];

/// A program of five targets, each with the tool straight down, after two joint targets from which J4 comes to 0 from above.
fn program(word: &str, configuration: &str, side: f64) -> String {
    let mut text = format!(
        "MODULE p\nPROC main()\nMoveAbsJ [[0,0,0,0,30,0],{REST}],v100,fine,tool0;\nMoveAbsJ [[3,3,3,5,50,3],{REST}],v100,fine,tool0;\n"
    );
    for [x, y, z] in PLACES {
        let y = side * y;
        let _ = writeln!(text, "{word} [[{x},{y},{z}],[0,0,1,0],{configuration},{REST}],v100,fine,tool0;");
    }
    text + "Stop;\nENDPROC\nENDMODULE\n"
}

/// The rewritten program and the summary.
fn rewritten(folder: &WorkFolder, text: &str) -> (String, Value) {
    let robot = include_str!("../../configs/abb-irb1600-6-145.yaml");
    let mut model = String::from("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n");
    for joint in ["J1", "J2", "J3", "J4", "J5", "J6"] {
        let _ = writeln!(model, "  - {{effect: backlash, joint: {joint}, half_gap_deg: {HALF_GAP_DEG}}}");
    }
    for (file, text) in [("robot.yaml", robot), ("model.yaml", &model), ("p.mod", text)] {
        std::fs::write(folder.join(file), text).unwrap();
    }
    let out = folder.run("rewrite --model model.yaml p.mod --output out.mod --max-added 0 --json").success();
    (std::fs::read_to_string(folder.join("out.mod")).unwrap(), out.json())
}

/// How far the tools of the targets lean to the side of J4 of the arm that reaches them, rad.
fn leans(text: &str) -> Vec<f64> {
    let numbers = |line: &str| -> Vec<f64> {
        let inside = line.split_once("[[").unwrap().1.replace(['[', ']'], "");
        inside.split(',').take(7).map(|n| n.parse().unwrap()).collect()
    };
    let lean = |line: &str| {
        let [x, y, _, w, i, j, k] = numbers(line)[..] else { panic!("{line}") };
        let scale = w * w + i * i + j * j + k * k;
        let down = [2.0 * (i * k + w * j), 2.0 * (j * k - w * i)].map(|v| v / scale);
        let (x, y) = (x - WRIST_MM * down[0], y - WRIST_MM * down[1]);
        (down[1] * x - down[0] * y) / x.hypot(y)
    };
    text.lines().filter(|l| l.starts_with("MoveL") || l.starts_with("MoveJ")).map(lean).collect()
}

/// Numbers of the notes in which `word` stands.
fn notes<'a>(summary: &'a Value, word: &str) -> Vec<&'a str> {
    let all = summary["notes"].as_array().into_iter().flatten().filter_map(|n| n["text"].as_str());
    all.filter(|text| text.contains(word)).collect()
}

#[test]
fn a_joint_on_the_border_of_its_quarter_keeps_it_and_the_others_are_compensated() {
    for word in ["MoveL", "MoveJ"] {
        let folder = WorkFolder::new();
        let text = program(word, "[0,0,0,0]", 1.0);
        let (out, summary) = rewritten(&folder, &text);
        assert_eq!((&summary["editable"], &summary["moves"]), (&7.into(), &7.into()), "{summary}");
        assert!(leans(&text).iter().all(|v| *v == 0.0));
        // inside of the quarter by no more than digits need
        assert!(leans(&out).iter().all(|v| (0.0..5e-6).contains(v)), "{:?}\n{out}", leans(&out));
        assert_eq!(out.lines().zip(text.lines()).filter(|(a, b)| a != b).count(), 7, "{out}");
        assert!(out.lines().all(|l| !l.starts_with(word) || l.contains(",[0,0,0,0],")));
        let said = notes(&summary, "J4 at ");
        assert!(said.len() == 1 && said[0].starts_with("J4 at 5 targets"), "{said:?}");
        assert!(notes(&summary, "lacks").len() == 1, "no other joint lacks anything: {summary}");
        // J4 keeps its gap, all others lose theirs
        let um = |side: &str| summary["path_error"]["at_targets"]["largest_um"][side].as_f64().unwrap();
        assert!(um("after") < 0.5 * um("before"), "{summary}");
        folder.run("undo out.mod --output back.mod").success();
        assert_eq!(std::fs::read_to_string(folder.join("back.mod")).unwrap(), text);
        folder.run("rewrite --model model.yaml out.mod --output again.mod").ends_with(2);
    }
}

#[test]
fn an_offset_to_the_inside_of_the_quarter_is_written_whole() {
    let folder = WorkFolder::new();
    let (out, summary) = rewritten(&folder, &program("MoveL", "[0,-1,0,0]", 1.0));
    assert_eq!(summary["editable"], 7);
    let whole = HALF_GAP_DEG.to_radians();
    assert!(notes(&summary, "lacks").is_empty());
    // the lean is the sine of J4 times that of the angle between forearm and tool, which is more than 30 deg
    assert!(leans(&out).iter().all(|v| (-whole..-0.5 * whole).contains(v)), "{:?}", leans(&out));
}

/// On the right of the arm axes 1 and 6 stand just below zero, whatever is written.
#[test]
fn straight_ways_end_at_the_nearest_joints_and_joint_motions_at_those_that_are_written() {
    let edited = |word: &str, configuration: &str| {
        let (out, summary) = rewritten(&WorkFolder::new(), &program(word, configuration, -1.0));
        let changed = out.lines().filter(|l| l.starts_with(word) && !l.contains("[0,0,1,0]")).count();
        assert_eq!(summary["editable"].as_u64().unwrap() as usize, changed + 2, "{summary}");
        changed
    };
    assert_eq!(edited("MoveL", "[-1,0,-1,0]"), 5);
    // a quarter off: the check of the configuration lets the robot go on
    assert_eq!(edited("MoveL", "[0,0,0,0]"), 5);
    assert_eq!(edited("MoveL", "[-1,-1,-2,0]"), 5);
    // two quarters off, or another posture: it stops the program
    assert_eq!(edited("MoveL", "[1,0,-1,0]"), 0);
    assert_eq!(edited("MoveL", "[0,0,1,0]"), 0);
    assert_eq!(edited("MoveL", "[0,0,0,1]"), 0);
    // a joint motion goes to the quarters that are written, or not at all
    assert_eq!(edited("MoveJ", "[-1,0,-1,0]"), 5);
    assert_eq!(edited("MoveJ", "[0,0,0,0]"), 0);
}
