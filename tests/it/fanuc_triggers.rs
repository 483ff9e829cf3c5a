//! FANUC: what a motion starts before its end (`DB`, `TB`) starts where it did in the rewritten program.

use crate::support::bundled;
use crate::vendor_rewrite::Desk;
use lostmotion::program::formats::{self, Recognised};
use lostmotion::program::script::{Goal, Text};
use lostmotion::robot::Robot;
use std::fmt::Write;
use std::path::Path;

/// Ends of a straight way across the front of the arm, deg: on its middle the arm reaches out least, and joints reverse.
const ENDS: [[f64; 6]; 2] = [[-40.0, 10.0, -10.0, 0.0, -70.0, 0.0], [40.0, 10.0, -10.0, 0.0, -70.0, 0.0]];

fn program(options: &str) -> String {
    let lines = ["J P[1] 100% FINE", &format!("L P[2] 1000mm/sec FINE {options}")];
    let mut text = format!("/PROG  P\n/ATTR\nLINE_COUNT\t= {};\n/MN\n", lines.len());
    for (k, line) in lines.iter().enumerate() {
        let _ = writeln!(text, "{:4}:{line}    ;", k + 1);
    }
    text += "/POS\n";
    for (k, q) in ENDS.iter().enumerate() {
        let f = |i: usize| format!("J{}={:>10.3} deg", i + 1, q[i]);
        let rows = [[f(0), f(1), f(2)].join(",\t"), [f(3), f(4), f(5)].join(",\t")];
        let _ = write!(text, "P[{}]{{\n   GP1:\n\tUF : 0, UT : 0,\t\n\t{},\n\t{}\n}};\n", k + 1, rows[0], rows[1]);
    }
    text + "/END\n"
}

/// Joint targets in the order of the moves, rad.
fn targets(robot: &Robot, bytes: Vec<u8>) -> Vec<Vec<f64>> {
    let Recognised::Script(format) = formats::recognise(Path::new("p.ls"), &bytes) else { panic!("p.ls") };
    let document = format.parse(vec![Text::new("p.ls", bytes)], robot.axes()).unwrap();
    let script = document.script();
    let joints = |t: usize| script.targets.get(t).unwrap().values.iter().map(|v| v.unwrap().si).collect();
    script.moves().map(|(_, m)| if let Goal::Joints(t) = m.goal { joints(t) } else { panic!("p.ls") }).collect()
}

#[test]
fn no_added_point_is_nearer_to_the_end_than_what_a_motion_starts_before_it() {
    let desk = Desk::new(0.0);
    let config = std::fs::read_to_string(bundled("configs/fanuc-m10ia.yaml")).unwrap();
    let robot = Robot::parse("robot.yaml", &config).unwrap();
    desk.write("robot.yaml", &config);
    let effects: String =
        (1..=6).map(|k| format!("  - {{effect: backlash, joint: J{k}, half_gap_deg: 0.02}}\n")).collect();
    desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{effects}"));
    let mut counts = Vec::new();
    for (options, way_m) in [
        ("", 0.0),
        ("DB 100mm,DO[1]=ON", 0.1),
        ("TB .10sec,DO[1]=ON", 0.1),
        ("TB 0.00sec,DO[1]=ON", 0.0),
        ("DB 700mm,DO[1]=ON", 0.7),
        ("TB .70sec,DO[1]=ON", 0.7),
        ("DB 3000mm,DO[1]=ON", 3.0),
    ] {
        desk.write("p.ls", &program(options));
        let out = format!("out-{}.ls", counts.len());
        desk.run(&format!("rewrite --model model.yaml p.ls --output {out}")).success();
        let found = targets(&robot, desk.read(&out));
        let [_, added @ .., goal] = &found[..] else { panic!("{found:?}") };
        let end = robot.tcp_m(goal);
        for q in added {
            let left_m = (robot.tcp_m(q) - end).norm();
            assert!(left_m > way_m - 1e-3, "{options}: {left_m} m");
        }
        counts.push(added.len());
    }
    let whole = counts[0];
    assert!(whole > 0 && counts[1..4].iter().all(|n| *n == whole), "{counts:?}");
    assert!(counts[4] < whole && counts[5] == counts[4] && counts[6] == 0, "{counts:?}");
    desk.write("p.ls", &program("DB 3000mm,DO[1]=ON"));
    desk.run("rewrite --model model.yaml p.ls --dry-run")
        .success()
        .stderr(predicates::str::contains("would start late"));
}

/// A joint motion of 80 deg of J1 takes 0.38 s at the largest speed of the robot file (210 deg/s): the point just after the reversal of J1
/// stands far before the last tenth of a second, and within the last minute.
#[test]
fn a_joint_motion_takes_points_from_which_the_joints_need_longer_than_what_starts_before_its_end() {
    let desk = Desk::new(0.0);
    let config = std::fs::read_to_string(bundled("configs/fanuc-m10ia.yaml")).unwrap();
    desk.write("robot.yaml", &config);
    desk.write(
        "model.yaml",
        "schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n  - {effect: backlash, joint: J1, half_gap_deg: 0.02}\n",
    );
    let there = |options: &str| {
        let text = program("");
        let last = text.lines().find(|l| l.contains("L P[2]")).unwrap();
        let back =
            format!("   2:J P[2] 100% FINE    ;\n   3:J P[1] 100% FINE {options}    ;\n   4:J P[2] 100% FINE    ;");
        text.replace(last, &back).replace("LINE_COUNT\t= 2", "LINE_COUNT\t= 4")
    };
    let added = |options: &str| {
        desk.write("p.ls", &there(options));
        let run = desk.run("rewrite --model model.yaml p.ls --output out.ls --replace --json").success();
        let document: serde_json::Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
        document["inserted"].as_u64().unwrap()
    };
    let whole = added("");
    assert!(whole >= 2);
    assert_eq!(added("TB .10sec,DO[1]=ON"), whole);
    assert_eq!(added("TB 60.00sec,DO[1]=ON"), whole - 1);
    assert_eq!(added("DB 20.0mm,DO[1]=ON"), whole - 1);
}
