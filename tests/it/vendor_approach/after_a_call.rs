//! `--approach-unknown`: targets after a call, which the robot reaches from anywhere.

use super::{HALF_GAP, targets, written};
use crate::support::bundled;
use crate::vendor_rewrite::Desk;
use lostmotion::robot::Robot;
use std::fmt::Write;

/// Where the targets of [`written`] follow a call of a program that nobody has.
fn after_a_call(format: &str) -> (&'static str, String, &'static str) {
    let (name, text, config) = written(format);
    let text = match format {
        "krl" => text.replace("DEF p( )\n", "DEF p( )\nGRIP( )\n"),
        "rapid" => text.replace("PROC main()\n", "PROC main()\nrGrip;\n"),
        "fanuc" => text.replace("/MN\n", "/MN\n   1:  CALL GRIP    ;\n").replace("LINE_COUNT\t= 6", "LINE_COUNT\t= 7"),
        "urscript" => text.replace("def p():\n", "def p():\n  grip()\n"),
        _ => text.replace("NOP\r\n", "NOP\r\nCALL JOB:GRIP\r\n"),
    };
    (name, text, config)
}

/// A desk with a program of [`after_a_call`] and half gaps on all joints of its robot.
fn desk_of((name, text, config): &(&str, String, &str)) -> (Desk, Robot) {
    let desk = Desk::new(0.0);
    let text_of_robot = std::fs::read_to_string(bundled("configs").join(config)).unwrap();
    let robot = Robot::parse("robot.yaml", &text_of_robot).unwrap();
    desk.write("robot.yaml", &text_of_robot);
    desk.write(name, text);
    let mut model = String::from("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n");
    for j in robot.axis_joints() {
        let _ = writeln!(model, "  - {{effect: backlash, joint: {}, half_gap_{}: {HALF_GAP}}}", j.name, j.kind.unit());
    }
    desk.write("model.yaml", &model);
    (desk, robot)
}

/// Wherever the call leaves the robot, each target is then reached, the first one over a point that lies back along the tool's axis.
#[test]
fn a_target_after_a_call_is_reached_from_anywhere_over_a_point_back_along_the_tool() {
    for format in ["krl", "rapid", "fanuc", "urscript", "inform"] {
        let program = after_a_call(format);
        let (desk, robot) = desk_of(&program);
        let name = program.0;
        desk.run(&format!("rewrite --model model.yaml {name} --output plain-{name}")).success();
        desk.run(&format!("rewrite --model model.yaml {name} --approach-unknown --output out-{name}")).success();
        let of = |name: &str| targets(&robot, name, desk.read(name));
        let (before, plain, after) = (of(name), of(&format!("plain-{name}")), of(&format!("out-{name}")));
        assert_eq!(plain[0], before[0], "{format}");
        let gears = |q: &[f64]| {
            let mut gears = q.to_vec();
            robot.to_gears(&mut gears);
            gears
        };
        for start in 0..64 {
            // half a degree above or below the first command, each joint for itself
            let side = |k: usize| if start >> k & 1 == 0 { 0.5 } else { -0.5 };
            let mut stands: Vec<f64> = gears(&after[0]).iter().enumerate().map(|(k, v)| v + side(k)).collect();
            let mut next = 0;
            for command in &after {
                for (stand, c) in stands.iter_mut().zip(gears(command)) {
                    *stand = stand.clamp(c - HALF_GAP, c + HALF_GAP);
                }
                let there = before
                    .get(next)
                    .is_some_and(|goal| stands.iter().zip(gears(goal)).all(|(a, b)| (a - b).abs() <= 1.1e-3 + 1e-9));
                next += usize::from(there);
            }
            assert_eq!(
                next,
                before.len(),
                "{format}, start {start}:\n{}",
                String::from_utf8_lossy(&desk.read(&format!("out-{name}")))
            );
        }
        let si = |q: &[f64]| q.iter().map(|v| v.to_radians()).collect::<Vec<f64>>();
        let goal = robot.forward(&si(&before[0]));
        let back = goal.rotation.inverse() * (robot.tcp_m(&si(&after[0])) - goal.position);
        assert!(back.z < 0.0 && back.norm() < 1e-3, "{format}: {back}");
        desk.run(&format!("undo out-{name} --output back-{name}")).success();
        assert_eq!(desk.read(&format!("back-{name}")), desk.read(name), "{format}");
        desk.run(&format!("rewrite --model model.yaml out-{name} --output twice-{name}")).code(2);
    }
}

#[test]
fn a_wanted_side_holds_after_a_call_too() {
    let (desk, robot) = desk_of(&after_a_call("krl"));
    desk.run("rewrite --model model.yaml p.src --approach-from - --output out.src").success();
    let (before, after) =
        (targets(&robot, "p.src", desk.read("p.src")), targets(&robot, "out.src", desk.read("out.src")));
    for k in 0..6 {
        // 1.5 times both half gaps above the target, and downwards to it: offset downwards at both
        assert!((after[0][k] - before[0][k] - 2.0 * HALF_GAP).abs() < 2e-4, "{after:?}");
        assert!((after[1][k] - before[0][k] + HALF_GAP).abs() < 2e-4, "{after:?}");
    }
}

/// Where the robot does not stop, or a process is on, or no more points may be added, the first target stays as it is.
#[test]
fn no_point_is_added_where_the_robot_goes_on_or_works() {
    let first = "PTP {A1 0.0000,A2 -80.0000,A3 80.0000,A4 10.0000,A5 40.0000,A6 5.0000}";
    let (name, text, config) = after_a_call("krl");
    let on_way = text.replace(first, &format!("{first} C_PTP"));
    let at_work = text.replace("GRIP( )\n", "GRIP( )\nARC_ON( )\n");
    for (text, options) in [(on_way, ""), (at_work, " --leave-process"), (text.clone(), " --max-added 0")] {
        let (desk, _) = desk_of(&(name, text.clone(), config));
        desk.run(&format!("rewrite --model model.yaml p.src --approach-unknown{options} --output out.src")).success();
        let out = String::from_utf8(desk.read("out.src")).unwrap();
        let of_first = |t: &str| t.lines().find(|l| l.starts_with("PTP")).unwrap().to_string();
        assert_eq!(of_first(&out), of_first(&text), "{options}: {out}");
    }
    // next to a limit the point lies on the side where there is room
    let limit = 130.0;
    for near in [limit - 0.009, 0.009 - limit] {
        let (desk, robot) = desk_of(&(name, text.replace("A5 40.0000", &format!("A5 {near:.4}")), config));
        assert!((robot.axis(4).limits.unwrap()[1].to_degrees() - limit).abs() < 1e-9);
        desk.run("rewrite --model model.yaml p.src --approach-unknown --output out.src").success();
        let after = targets(&robot, "out.src", desk.read("out.src"));
        assert!(after[0][4].abs() < after[1][4].abs() && after[1][4].abs() <= limit, "{after:?}");
    }
}

/// A Cartesian target after a call gets its point as a pose.
#[test]
fn a_cartesian_target_after_a_call_gets_its_point_as_a_pose() {
    let (desk, _) = desk_of(&after_a_call("krl"));
    let program = "DEF p( )\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\nGRIP( )\nPTP {E6POS: X 1500,Y 300,Z 1500,A 0,B 60,C 0,S 2,T 35}\nLIN {X 1500,Y 0,Z 1500,A 0,B 60,C 0}\nEND\n";
    desk.write("p.src", program);
    for (options, moves) in [("", 2), (" --approach-unknown", 3)] {
        desk.run(&format!("rewrite --model model.yaml p.src{options} --output out.src --force")).success();
        let out = String::from_utf8(desk.read("out.src")).unwrap();
        assert!(out.lines().filter(|l| l.starts_with("PTP {E6POS: X 1")).count() == moves - 1, "{out}");
    }
}

/// A program that goes to one place and calls another one: no movement tells from which side its first target is reached.
#[test]
fn the_only_target_before_a_call_is_reached_over_a_point() {
    let (name, _, config) = after_a_call("krl");
    let text = "DEF p( )\nPTP {A1 0.0000,A2 -80.0000,A3 80.0000,A4 10.0000,A5 40.0000,A6 5.0000}\nGRIP( )\nEND\n";
    let (desk, _) = desk_of(&(name, text.to_string(), config));
    for (options, moves) in [("", 1), (" --approach-unknown", 2)] {
        desk.run(&format!("rewrite --model model.yaml p.src --output out.src --force{options}")).success();
        let out = String::from_utf8(desk.read("out.src")).unwrap();
        assert_eq!(out.lines().filter(|l| l.starts_with("PTP")).count(), moves, "{out}");
        assert_eq!(out == text, moves == 1, "{out}");
    }
}

/// Movement within the dead band counts as none: the way from the point is longer.
#[test]
fn the_way_from_a_point_of_approach_is_longer_than_the_dead_band() {
    let (desk, robot) = desk_of(&after_a_call("krl"));
    desk.run("rewrite --model model.yaml p.src --approach-unknown --deadband-deg 0.02 --output out.src").success();
    let (before, after) =
        (targets(&robot, "p.src", desk.read("p.src")), targets(&robot, "out.src", desk.read("out.src")));
    for k in 0..6 {
        // the offset is that of the side from which the joint comes
        let way = after[1][k] - after[0][k];
        assert!(
            way.abs() > 0.02 && ((after[1][k] - before[0][k]) - HALF_GAP * way.signum()).abs() < 2e-4,
            "{k}: {after:?}"
        );
    }
}
