//! Calls and blocks between two moves: where nothing in them moves, the program is compensated as if they were not there; else what
//! follows them starts anew. Relative motions lead on from where the robot stands.

use crate::support::bundled;
use crate::vendor_rewrite::Desk;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;

/// J1 (A1) of the moves, deg: the third turns back, the fourth turns again.
const J1: [f64; 4] = [0.0, 10.0, 5.0, 8.0];

pub fn desk(config: &str, joint: &str) -> Desk {
    let desk = Desk::new(0.003);
    let robot = bundled("configs").join(config);
    std::fs::copy(robot, desk.path("robot.yaml")).unwrap();
    let effect = format!("{{effect: backlash, joint: {joint}, half_gap_deg: 0.01}}");
    desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n  - {effect}\n"));
    desk
}

/// A FANUC program with these lines after its second motion.
fn fanuc(between: &[&str]) -> String {
    fanuc_named("P", between)
}

/// The same under a name.
pub fn fanuc_named(name: &str, between: &[&str]) -> String {
    let motion = |k: usize| format!("J P[{k}] 10% FINE");
    let mut lines = vec![motion(1), motion(2)];
    lines.extend(between.iter().map(|l| (*l).to_string()));
    lines.extend([motion(3), motion(4)]);
    let mut text = format!("/PROG  {name}\n/ATTR\nLINE_COUNT\t= {};\n/MN\n", lines.len());
    for (k, line) in lines.iter().enumerate() {
        text += &format!("{:4}:{line}    ;\n", k + 1);
    }
    text + &fanuc_positions(&J1)
}

/// Its positions, by J1 in deg; the other joints stand at 10.
pub fn fanuc_positions(j1: &[f64]) -> String {
    let mut text = String::from("/POS\n");
    for (k, j1) in j1.iter().enumerate() {
        let rest: String = (2..=6).map(|j| format!(",\tJ{j}=    10.000 deg")).collect();
        text += &format!("P[{}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\n\tJ1={j1:>10.3} deg{rest}\n}};\n", k + 1);
    }
    text + "/END\n"
}

/// What is written for J1 at each position, deg.
pub fn j1(desk: &Desk, name: &str) -> Vec<f64> {
    let text = String::from_utf8(desk.read(name)).unwrap();
    let after = |l: &str| l.trim().strip_prefix("J1=").map(|v| v.trim_start().to_string());
    text.lines().filter_map(after).filter_map(|v| v.split(' ').next()?.parse().ok()).collect()
}

#[test]
fn a_fanuc_program_is_compensated_over_calls_and_branches_that_move_nothing() {
    let desk = desk("fanuc-m10ia.yaml", "J1");
    desk.write("GRIP.LS", "/PROG  GRIP\n/ATTR\n/MN\n   1:  RO[1]=ON ;\n   2:  WAIT .20(sec) ;\n/POS\n/END\n");
    desk.write("plain.ls", &fanuc(&[]));
    desk.run("rewrite --model model.yaml plain.ls --output plain-out.ls --max-added 0").success();
    let plain = j1(&desk, "plain-out.ls");
    assert_eq!(plain, [0.01, 10.01, 4.99, 8.01]);
    let lines = ["  CALL GRIP", "  IF R[1]=1,JMP LBL[9]", "  LBL[1]", "  IF DI[1]=OFF,JMP LBL[1]"];
    let text = fanuc(&lines).replace("/POS", "  90:  END ;\n  91:  LBL[9] ;\n/POS").replace("= 8;", "= 91;");
    desk.write("calls.ls", &text);
    let run = desk.run("rewrite --model model.yaml calls.ls --output out.ls --max-added 0");
    run.success().stderr(contains("the program GRIP that it calls moves nothing"));
    assert_eq!(j1(&desk, "out.ls"), plain);
    desk.run("rewrite --model model.yaml out.ls --output again.ls").code(2);
    desk.run("undo out.ls --output back.ls").success();
    assert_eq!(desk.read("back.ls"), text.as_bytes());
}

#[test]
fn a_fanuc_call_of_a_program_that_moves_or_is_not_there_starts_anew() {
    let desk = desk("fanuc-m10ia.yaml", "J1");
    for (name, body) in [("GRIP", Some("   1:J PR[1] 10% FINE ;")), ("GRIP", None)] {
        std::fs::remove_file(desk.path("GRIP.LS")).ok();
        if let Some(body) = body {
            desk.write("GRIP.LS", &format!("/PROG  {name}\n/ATTR\n/MN\n{body}\n/POS\n/END\n"));
        }
        desk.write("calls.ls", &fanuc(&["  CALL GRIP"]));
        let run = desk.run("rewrite --model model.yaml calls.ls --output out.ls --max-added 0 --force");
        run.success().stderr(contains("it calls moves nothing").not());
        // from which side the third is reached is not known
        assert_eq!(j1(&desk, "out.ls"), [0.01, 10.01, 5.0, 8.01]);
    }
}

#[test]
fn a_krl_program_is_compensated_over_blocks_and_routines_that_move_nothing() {
    let desk = desk("kuka-kr120-r2500-pro.yaml", "A1");
    let krl = |between: &str, more: &str| {
        let at = |a1: f64| format!("PTP {{A1 {a1:.3},A2 -90.0,A3 90.0,A4 0.0,A5 10.0,A6 0.0}}\n");
        let [a, b, c, d] = J1.map(at);
        format!("DEF p( )\n{a}{b}{between}{c}{d}END\n{more}")
    };
    let a1 = |name: &str| -> Vec<f64> {
        let text = String::from_utf8(desk.read(name)).unwrap();
        let value = |l: &str| l.strip_prefix("PTP {A1 ").and_then(|v| v.split(',').next()?.parse().ok());
        text.lines().filter_map(value).collect()
    };
    let quiet = "IF n>1 THEN\n$OUT[1]=TRUE\nELSE\ngrip(1)\nENDIF\nWHILE NOT $IN[1]\nWAIT SEC 0.1\nENDWHILE\n";
    let grip = "DEF grip(n:IN)\nINT n\n$OUT[n]=TRUE\nWAIT FOR $IN[n]\nEND\n";
    desk.write("p.src", &krl(quiet, grip));
    let run = desk.run("rewrite --model model.yaml p.src --output out.src --max-added 0");
    run.success().stderr(contains("the routine GRIP that it calls moves nothing"));
    assert_eq!(a1("out.src"), [0.01, 10.01, 4.99, 8.01]);
    desk.run("undo out.src --output back.src").success();
    assert_eq!(desk.read("back.src"), krl(quiet, grip).as_bytes());
    for (between, more) in [
        (quiet, "DEF grip(n:IN)\nINT n\nPTP XHOME\nEND\n"),
        (quiet, ""),
        ("FOR i=1 TO 3\nPTP_REL {A1 1.0}\nENDFOR\n", ""),
    ] {
        desk.write("p.src", &krl(between, more));
        desk.run("rewrite --model model.yaml p.src --output out.src --max-added 0 --force").success();
        assert_eq!(a1("out.src")[2], 5.0, "{between}{more}");
    }
}

/// Of a KRL program of straight motions, what stands in each of them.
fn lines(desk: &Desk, name: &str) -> Vec<String> {
    let text = String::from_utf8(desk.read(name)).unwrap();
    text.lines().filter(|l| l.starts_with("LIN")).map(String::from).collect()
}

#[test]
fn after_a_relative_motion_a_program_is_compensated_as_after_the_same_one_with_its_goal() {
    let desk = desk("kuka-kr120-r2500-pro.yaml", "A1");
    desk.write("frames.yaml", "schema: lostmotion/frames/1\nframes: {\"$BASE\": {xyz_mm: [0, 0, 0]}}\ntools: {\"$TOOL\": {xyz_mm: [0, 0, 0]}}\n");
    let program = |relative: &str| {
        let at = |y: f64, z: f64| format!("LIN {{X 1500.000,Y {y:.3},Z {z:.3},A 0.0,B 90.0,C 0.0}}\n");
        let start = "PTP {A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 10.0,A6 0.0}\n";
        let (a, b, d, e) = (at(0.0, 1200.0), at(100.0, 1200.0), at(0.0, 1100.0), at(50.0, 1100.0));
        format!("DEF p( )\n{start}{a}{b}{relative}{d}{e}END\n")
    };
    let rewrite = |name: &str| {
        let line = format!("rewrite --model model.yaml {name} --output out-{name} --frames frames.yaml --max-added 0");
        desk.run(&line).success();
        lines(&desk, &format!("out-{name}"))
    };
    // A1 turns back at the third
    desk.write("absolute.src", &program("LIN {X 1500.000,Y 60.000,Z 1200.000,A 0.0,B 90.0,C 0.0}\n"));
    let absolute = rewrite("absolute.src");
    for (name, line) in [("base.src", "LIN_REL {Y -40}\n"), ("tool.src", "LIN_REL {Y -40} #TOOL\n")] {
        desk.write(name, &program(line));
        let found = rewrite(name);
        assert_eq!((&found[0], &found[3], &found[4]), (&absolute[0], &absolute[3], &absolute[4]), "{name}");
        // the point from which it counts and the motion itself stay
        assert!(found[1].contains("Y 100.000,Z 1200.000") && found[2] == line.trim_end(), "{found:?}");
        assert!(!absolute[1].contains("Y 100.000,"), "{absolute:?}");
        desk.run(&format!("undo out-{name} --output back-{name}")).success();
        assert_eq!(desk.read(&format!("back-{name}")), program(line).as_bytes());
    }
}
