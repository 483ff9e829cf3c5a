//! `--approach-from` in every format: rewritten, read again, and played through a play (hysteresis) operator for each joint.
//!
//! The operator is the machine of a half gap and shares nothing with the rewriter: the joint stands still until the command
//! leads it by the half gap. At every target that the program names the joint must stand where the program says, and it must have
//! come from the wanted side.
//!
//! Parts:
//! - [`after_a_call`]: targets that the robot reaches from anywhere.

mod after_a_call;

use crate::support::bundled;
use crate::vendor_joins::{all, krl_with};
use crate::vendor_loops::{program, rewritten_with, to};
use crate::vendor_rewrite::Desk;
use lostmotion::program::formats::{self, Recognised};
use lostmotion::program::script::{Goal, Text};
use lostmotion::robot::Robot;
use std::fmt::Write;
use std::path::Path;

/// Half gap of every joint, deg or mm.
const HALF_GAP: f64 = 0.004;
/// Targets, deg or mm; each joint goes up, down, and hardly moves.
const POINTS: [[f64; 6]; 6] = [
    [0.0, -80.0, 80.0, 10.0, 40.0, 5.0],
    [10.0, -70.0, 70.0, 20.0, 30.0, 15.0],
    [5.0, -75.0, 75.0, 20.0, 50.0, 15.0],
    [5.001, -72.0, 60.0, 5.0, 50.001, 10.0],
    [-5.0, -72.0, 65.0, 15.0, 45.0, 20.0],
    [-4.0, -90.0, 70.0, 15.0, 60.0, 5.0],
];

/// The targets within the limits of a format's robot.
fn points(format: &str) -> [[f64; 6]; 6] {
    match format {
        "krl" => POINTS,
        _ => POINTS.map(|[a, b, c, d, e, f]| [a, b + 80.0, c - 60.0, d, e, f]),
    }
}

/// Name, text and robot of the targets as a program that stops at each.
fn written(format: &str) -> (&'static str, String, &'static str) {
    let points = points(format);
    let list = |q: &[f64]| q.iter().map(|v| format!("{v:.4}")).collect::<Vec<_>>().join(",");
    let mut t = String::new();
    match format {
        "krl" => {
            t += "DEF p( )\n";
            for q in points {
                let axes: Vec<String> = q.iter().enumerate().map(|(k, v)| format!("A{} {v:.4}", k + 1)).collect();
                let _ = writeln!(t, "PTP {{{}}}", axes.join(","));
            }
            ("p.src", t + "END\n", "kuka-kr120-r2500-pro.yaml")
        }
        "rapid" => {
            t += "MODULE p\nPROC main()\n";
            for q in points {
                let _ = writeln!(t, "MoveAbsJ [[{}],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;", list(&q));
            }
            ("p.mod", t + "Stop;\nENDPROC\nENDMODULE\n", "abb-irb1600-6-145.yaml")
        }
        "fanuc" => {
            let _ = write!(t, "/PROG  P\n/ATTR\nLINE_COUNT\t= {};\n/MN\n", points.len());
            for k in 1..=points.len() {
                let _ = writeln!(t, "{k:4}:J P[{k}] 10% FINE    ;");
            }
            t += "/POS\n";
            for (k, q) in points.iter().enumerate() {
                let f = |i: usize| format!("J{}={:>10.3} deg", i + 1, q[i]);
                let rows = [[f(0), f(1), f(2)].join(",\t"), [f(3), f(4), f(5)].join(",\t")];
                let _ = write!(t, "P[{}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\n\t{},\n\t{}\n}};\n", k + 1, rows[0], rows[1]);
            }
            ("p.ls", t + "/END\n", "fanuc-m10ia.yaml")
        }
        "urscript" => {
            t += "def p():\n";
            for q in points {
                let _ =
                    writeln!(t, "  movej([{}], a=1.4, v=1.05)", q.map(|v| format!("{:.7}", v.to_radians())).join(", "));
            }
            ("p.script", t + "end\n", "universal-robots-ur10.yaml")
        }
        "inform" => {
            let _ = write!(t, "/JOB\r\n//NAME P\r\n//POS\r\n///NPOS {},0,0,0,0,0\r\n///TOOL 0\r\n", points.len());
            t += "///POSTYPE ANGLE\r\n///ANGLE\r\n";
            for (k, q) in points.iter().enumerate() {
                let _ = write!(t, "C{k:05}={}\r\n", list(q));
            }
            t += "//INST\r\n///DATE 2024/05/06 07:08\r\n///ATTR SC,RW\r\n///GROUP1 RB1\r\nNOP\r\n";
            for k in 0..points.len() {
                let _ = write!(t, "MOVJ C{k:05} VJ=25.00 PL=0\r\n");
            }
            ("P.JBI", t + "END\r\n", "motoman-ma2010.yaml")
        }
        _ => {
            t += "G21 G90 G61\n";
            for q in points {
                let _ = writeln!(t, "G0 X{:.4} Y{:.4} Z{:.4}", q[0] + 100.0, q[1] + 200.0, q[2] - 100.0);
            }
            ("p.ngc", t, "gantry-xyz-ballscrew.yaml")
        }
    }
}

/// Joint targets in the order of the moves, deg or mm.
fn targets(robot: &Robot, name: &str, bytes: Vec<u8>) -> Vec<Vec<f64>> {
    let Recognised::Script(format) = formats::recognise(Path::new(name), &bytes) else { panic!("{name}") };
    let document = format.parse(vec![Text::new(name, bytes)], robot.axes()).unwrap();
    let script = document.script();
    let joints = |t: usize| {
        let values = script.targets.get(t).unwrap().values.iter().zip(robot.axis_joints());
        values.map(|(v, j)| v.unwrap().si / j.kind.si_per_user_unit()).collect::<Vec<f64>>()
    };
    script.moves().map(|(_, m)| if let Goal::Joints(t) = m.goal { joints(t) } else { panic!("{name}") }).collect()
}

#[test]
fn every_target_is_reached_from_its_side_in_every_format() {
    for format in ["krl", "rapid", "fanuc", "urscript", "inform", "gcode"] {
        for sign in [1.0, -1.0] {
            one(format, sign);
        }
    }
}

fn one(format: &str, sign: f64) {
    let desk = Desk::new(0.0);
    let (name, text, config) = written(format);
    let text_of_robot = std::fs::read_to_string(bundled("configs").join(config)).unwrap();
    let robot = Robot::parse("robot.yaml", &text_of_robot).unwrap();
    desk.write("robot.yaml", &text_of_robot);
    desk.write(name, &text);
    let mut model = String::from("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n");
    for j in robot.axis_joints() {
        let _ = writeln!(model, "  - {{effect: backlash, joint: {}, half_gap_{}: {HALF_GAP}}}", j.name, j.kind.unit());
    }
    desk.write("model.yaml", &model);
    let side = if sign > 0.0 { "+" } else { "-" };
    desk.run(&format!("rewrite --model model.yaml {name} --approach-from {side} --output out-{name}")).success();
    let before = targets(&robot, name, desk.read(name));
    let after = targets(&robot, &format!("out-{name}"), desk.read(&format!("out-{name}")));
    // the last digit of the coarsest format, and what G-code and FANUC hold
    let digit = 1.1e-3;
    let gears = |q: &[f64]| {
        let mut gears = q.to_vec();
        robot.to_gears(&mut gears);
        gears
    };
    // where the joints stand: at the first target within their gaps
    let mut stands = gears(&after[0]);
    let mut came = vec![0.0; stands.len()];
    let (mut next, mut reached) = (1, 0);
    for command in &after[1..] {
        let command = gears(command);
        for (axis, c) in command.iter().enumerate() {
            let to = stands[axis].clamp(c - HALF_GAP, c + HALF_GAP);
            if (to - stands[axis]).abs() > 1e-9 {
                came[axis] = (to - stands[axis]).signum();
            }
            stands[axis] = to;
        }
        let Some(goal) = before.get(next).map(|q| gears(q)) else { break };
        let there = stands.iter().zip(&goal).all(|(a, b)| (a - b).abs() <= digit + 1e-9);
        let sided = came.iter().all(|s| *s == sign);
        if there && sided {
            next += 1;
            reached += 1;
        }
    }
    assert_eq!(
        reached,
        before.len() - 1,
        "{format} {side}: {stands:?}\n{}",
        String::from_utf8_lossy(&desk.read(&format!("out-{name}")))
    );
    desk.run(&format!("undo out-{name} --output back-{name}")).success();
    assert_eq!(desk.read(&format!("back-{name}")), desk.read(name));
}

#[test]
fn without_offsets_the_points_of_approach_are_all_that_is_new() {
    let desk = Desk::new(HALF_GAP);
    let (name, text, _) = written("krl");
    desk.write(name, &text);
    desk.run(&format!("rewrite --model model.yaml {name} --approach-from A1=- --gain 0 --output out.src")).success();
    let out = String::from_utf8(desk.read("out.src")).unwrap();
    // 1.5 times both half gaps on the wanted side of targets that are reached upwards
    let new: Vec<&str> = out.lines().filter(|l| !text.lines().any(|o| o == *l)).collect();
    assert_eq!(text.lines().filter(|l| !out.lines().any(|o| o == *l)).count(), 0, "{out}");
    let first: Vec<&str> = new.iter().map(|l| l.split(',').next().unwrap()).collect();
    assert_eq!(first, ["PTP {A1 10.0120", "PTP {A1 5.0130", "PTP {A1 -3.9880"], "{out}");
}

/// Without offsets a turn on a straight way needs no point, and no stop.
#[test]
fn an_approach_without_offsets_adds_no_turning_points_to_straight_moves() {
    let desk = Desk::new(0.0);
    let robot = std::fs::read_to_string(bundled("configs/kuka-kr120-r2500-pro.yaml")).unwrap();
    desk.write("robot.yaml", &robot);
    let gaps: String =
        ["A1", "A3"].map(|j| format!("  - {{effect: backlash, joint: {j}, half_gap_deg: {HALF_GAP}}}\n")).concat();
    desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{gaps}"));
    // A3 turns where Y is 0
    let pose = |y: i32| format!("{{X 1500,Y {y},Z 1500,A 0,B 60,C 0");
    let program = format!(
        "DEF ap()\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\nPTP {{A1 0,A2 -90,A3 90,A4 0,A5 30,A6 0}}\nPTP {},S 2,T 35}}\nLIN {}}}\nLIN {}}}\nEND\n",
        pose(300).replace("{X", "{E6POS: X"),
        pose(-300),
        pose(100)
    );
    desk.write("ap.src", &program);
    desk.run("rewrite --model model.yaml ap.src --approach-from A1=-,A3=+ --gain 0 --output out.src").success();
    let out = String::from_utf8(desk.read("out.src")).unwrap();
    assert!(out.lines().count() > program.lines().count() && !out.contains("Y 0.0"), "{out}");
}

/// A joint that comes from the other side has the offset of that side wherever its point of approach is not written.
#[test]
fn without_its_point_of_approach_a_target_has_the_offset_of_the_side_from_which_it_is_reached() {
    let desk = crate::vendor_loops::desk();
    let sides = "--approach-from J1=+,J2=+,J3=+,J4=+,J5=+,J6=+";
    // no more points
    let text = program(&all(&[0, 10, 5, 3]));
    let (by, said) = rewritten_with(&desk, &text, &format!("{sides} --max-added 0"));
    assert_eq!(by, [1, 1, -1, -1], "{said}");
    assert!(said.contains("0 targets reached from the requested side"), "{said}");
    // points in a process
    let lines = ["0", "10", "ARC_ON( )", "5", "3"];
    assert_eq!(krl_with(&desk, &lines, "--approach-from A1=+ --leave-process"), [1, 1, -1, -1]);
    // only one of the ways to a target needs a point: from 10 upwards, from 20 down
    let text = program(&format!("{}IF di1=1 THEN\n{}ENDIF\n{}", all(&[0, 10]), to(20), to(15)));
    let (by, said) = rewritten_with(&desk, &text, sides);
    assert_eq!(by, [1, 1, 1, 0], "{said}");
}

/// A copy of a Cartesian move that stops would stop in the middle of a seam: no point of approach there, and no offset for its side.
#[test]
fn targets_of_a_seam_are_the_same_with_and_without_a_wanted_side() {
    let desk = crate::vendor_loops::desk();
    let seam = "\
MoveAbsJ [[0,-20,25,30,40,20],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
ArcLStart [[603.5236,138.9175,920.5201],[0.0520295,0.3291089,0.8816618,0.3341446],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,sm1,wd1,fine,tool0;
MoveL [[599.1860,67.2099,983.7444],[0.2019762,0.3010056,0.8779935,0.3126159],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
MoveL [[578.7349,43.2720,1018.0657],[0.2635004,0.2868716,0.8695204,0.3036552],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;
ArcLEnd [[571.9499,31.9500,1031.2805],[0.2902151,0.2810462,0.8654700,0.2962260],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,sm1,wd1,fine,tool0;
";
    desk.write("seam.mod", &program(seam));
    for (out, side) in [("as-it-is.mod", ""), ("from-side.mod", " --approach-from J1=+")] {
        desk.run(&format!("rewrite --model model.yaml seam.mod --output {out} --force{side}")).success();
    }
    let [plain, sided] = ["as-it-is.mod", "from-side.mod"].map(|name| String::from_utf8(desk.read(name)).unwrap());
    assert!(plain != program(seam), "{plain}");
    assert_eq!(sided, plain);
}

/// Two ways to a target, from below and from above: over a point that is the same for both.
#[test]
fn a_target_that_its_ways_reach_from_different_sides_is_reached_over_one_point() {
    let desk = crate::vendor_loops::desk();
    let text = program(&format!("{}IF di1=1 THEN\n{}ENDIF\n{}{}", all(&[0, 10]), to(20), to(15), to(12)));
    desk.write("p.mod", &text);
    for (options, points) in [("", 0), (" --approach-unknown", 1)] {
        desk.run(&format!("rewrite --model model.yaml p.mod --output out.mod --force{options}")).success();
        let out = String::from_utf8(desk.read("out.mod")).unwrap();
        let after = out.split("ENDIF").nth(1).unwrap();
        let unchanged = after.contains(to(15).trim());
        let near = after.lines().filter(|l| l.starts_with("MoveAbsJ [[15.") || l.starts_with("MoveAbsJ [[14.")).count();
        // the point, the target, and where J4 and J5 turn back from it the place once more
        assert_eq!((unchanged, near), (points == 0, 3 * points), "{options}: {out}");
    }
}

/// A desk for the KR 120 with gaps on all of its joints.
fn kuka() -> Desk {
    let desk = Desk::new(0.0);
    let gaps: String =
        (1..=6).map(|k| format!("  - {{effect: backlash, joint: A{k}, half_gap_deg: 0.05}}\n")).collect();
    desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{gaps}"));
    desk
}

/// Values of an axis in the order of the lines.
fn axis(text: &str, name: &str) -> Vec<f64> {
    let parts = text.split(['{', '}', ',']).filter_map(|w| w.strip_prefix(name)?.strip_prefix(' '));
    parts.filter_map(|w| w.parse().ok()).collect()
}

/// The way to a point that is added says nothing of the side from which joints come to the target before it.
#[test]
fn the_first_target_has_no_side_by_a_point_that_is_added_after_it() {
    let desk = kuka();
    desk.write(
        "a.src",
        "DEF a()\nPTP {A1 5,A2 -85,A3 92,A4 12,A5 32,A6 5}\nPTP {A1 5,A2 -80,A3 97,A4 14,A5 34,A6 8}\n\
         PTP {A1 12,A2 -78,A3 99,A4 16,A5 36,A6 10}\nEND\n",
    );
    desk.run("rewrite --model model.yaml a.src --approach-from + --output out.src").success();
    let out = String::from_utf8(desk.read("out.src")).unwrap();
    // the point at 4.9485 is on the way to the point of approach: from there on A1 is led on its other side
    assert_eq!(axis(&out, "A1"), [5.0, 4.9485, 4.8, 5.05, 12.05], "{out}");
    // joints that the program itself moves keep their side
    assert_eq!(axis(&out, "A2")[0], -84.95, "{out}");
    desk.run("undo out.src --output back.src").success();
    assert_eq!(desk.read("back.src"), desk.read("a.src"));
}

/// A target to which several ways lead stays; a joint that rests after it has not come from the wanted side.
#[test]
fn a_joint_that_rests_after_a_target_left_alone_is_approached() {
    let desk = kuka();
    let [p0, p1, p2] = [
        "PTP {A1 -25,A2 -80,A3 62,A4 10,A5 32,A6 12}\n",
        "PTP {A1 0,A2 -68,A3 90,A4 -1,A5 24,A6 0}\n",
        "PTP {A1 0,A2 -100,A3 90,A4 10,A5 40,A6 0}\n",
    ];
    let text = format!("DEF a()\n{p0}IF $IN[2] THEN\n{p1}ENDIF\n{p1}IF $IN[1] THEN\n{p2}ENDIF\n{p0}END\n");
    desk.write("a.src", &text);
    desk.run("rewrite --model model.yaml a.src --approach-from + --output out.src").success();
    let out = String::from_utf8(desk.read("out.src")).unwrap();
    let at = out.find("$IN[1]").unwrap();
    // 1.5 times the whole lost motion on the other side of 0, and the target with its offset
    assert_eq!(axis(&out[at..], "A6")[..2], [-0.2, 0.05], "{out}");
    assert!(out[..at].ends_with(&format!("{p1}IF ")), "{out}");
}

/// What a wanted side adds to whole degrees is no trace of an earlier rewrite.
#[test]
fn a_program_of_whole_degrees_is_not_taken_for_one_that_was_rewritten() {
    let targets = [[-28, 13, 0, -4, 40, 16], [-28, 0, 0, 38, 30, 0], [23, -29, -26, 10, 28, -21]];
    let mut text = String::from("/PROG  P\n/ATTR\nLINE_COUNT\t= 3;\n/MN\n");
    for k in 1..=3 {
        let _ = writeln!(text, "{k:4}:J P[{k}] 50% FINE    ;");
    }
    text += "/POS\n";
    for (k, q) in targets.into_iter().enumerate() {
        let f = |i: usize| format!("J{}={:>10.3} deg", i + 1, f64::from(q[i]));
        let rows = [[f(0), f(1), f(2)].join(",\t"), [f(3), f(4), f(5)].join(",\t")];
        let _ = write!(text, "P[{}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\n\t{},\n\t{}\n}};\n", k + 1, rows[0], rows[1]);
    }
    text += "/END\n";
    let desk = Desk::new(0.0);
    std::fs::copy(bundled("configs/fanuc-m10ia.yaml"), desk.path("robot.yaml")).unwrap();
    desk.write("p.ls", &text);
    for half_gap in ["0.02", "0.025", "0.05", "0.1", "0.15"] {
        let gaps: String =
            (1..=6).map(|k| format!("  - {{effect: backlash, joint: J{k}, half_gap_deg: {half_gap}}}\n")).collect();
        desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{gaps}"));
        let out = format!("out-{half_gap}.ls");
        desk.run(&format!("rewrite --model model.yaml p.ls --approach-from + --output {out}")).success();
        desk.run(&format!("undo {out} --output back-{half_gap}.ls")).success();
        assert_eq!(desk.read(&format!("back-{half_gap}.ls")), text.as_bytes());
    }
}
