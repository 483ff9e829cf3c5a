//! What holds along control, not in the order of the text: whether RAPID's configurations are watched, and which move ends where a program
//! reads the position of the robot. Also names of targets in the modules of a task, and a robot on a track.

use super::vendor_rewrite::Desk;
use crate::support::bundled;
use lostmotion::robot::Robot;
use nalgebra::{Rotation3, UnitQuaternion};

const AXES: &str = "[9E9,9E9,9E9,9E9,9E9,9E9]";

/// An IRB 1600 with the same gap on joints 1 and 6.
fn desk() -> Desk {
    let desk = Desk::new(0.05);
    std::fs::copy(bundled("configs/abb-irb1600-6-145.yaml"), desk.path("robot.yaml")).unwrap();
    let effects: String =
        ["J1", "J6"].map(|j| format!("  - {{effect: backlash, joint: {j}, half_gap_deg: 0.05}}\n")).concat();
    desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{effects}"));
    desk
}

/// A program as `rewrite` leaves it, and what it says.
fn rewritten(desk: &Desk, name: &str, program: &str, more: &str) -> (String, String) {
    desk.write(name, program);
    let line = format!("rewrite --model model.yaml {name} --output out_{name} --force {more}");
    let run = desk.run(line.trim_end()).success();
    let said = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
    (String::from_utf8(desk.read(&format!("out_{name}"))).unwrap(), said)
}

fn absj(joints: [f64; 6]) -> String {
    let joints: Vec<String> = joints.iter().map(f64::to_string).collect();
    format!("MoveAbsJ [[{}],{AXES}],v200,fine,tool0;\n", joints.join(","))
}

/// A joint move to joints in degrees, with the quarter of joint 6 as `cf6` says.
fn movej(robot: &Robot, joints_deg: [f64; 6], cf6: i32) -> String {
    let pose = robot.forward(&joints_deg.map(f64::to_radians));
    let p = pose.position * 1e3;
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*pose.rotation.matrix()));
    let at = format!("[{:.4},{:.4},{:.4}],[{:.8},{:.8},{:.8},{:.8}]", p.x, p.y, p.z, q.w, q.i, q.j, q.k);
    format!("MoveJ [{at},[0,0,{cf6},0],{AXES}],v200,fine,tool0;\n")
}

/// A target that is written with joint 6 a whole turn further on: the robot goes there as ordered, or to the nearest one.
#[test]
fn a_target_stays_whose_configuration_is_another_one_and_may_be_followed_or_not() {
    let desk = desk();
    let robot = Robot::load(&desk.path("robot.yaml")).unwrap();
    let [a, b, c] = [
        [0.0, -20.0, 25.0, 10.0, 50.0, 5.0],
        [10.0, -15.0, 30.0, 15.0, 55.0, 10.0],
        [4.0, -18.0, 22.0, 20.0, 52.0, 4.0],
    ];
    let (turned, near) = (movej(&robot, b, -4), movej(&robot, b, 0));
    let program = |before: &str, to: &str, after: &str, routines: &str| {
        let moves = format!("{}{to}{}", absj(a), absj(c));
        format!("MODULE m\nPROC main()\n{before}{moves}{after}ENDPROC\n{routines}ENDMODULE\n")
    };
    let off = "PROC init()\nConfJ\\Off;\nENDPROC\n";
    let handler = "ERROR\nConfJ\\Off;\nTRYNEXT;\n";
    let stays = |name: &str, program: &str| {
        let (out, said) = rewritten(&desk, name, program, "");
        assert!(said.contains("depends on what ran before (ConfJ, ConfL)"), "{said}");
        assert!(out.contains(turned.trim_end()) && out.matches("Move").count() == 3, "{out}");
    };
    stays("err.mod", &program("", &turned, handler, ""));
    stays("if.mod", &program("IF di1=1 ConfJ\\Off;\n", &turned, "", ""));
    stays("loop.mod", &program("WHILE TRUE DO\n", &turned, "ConfJ\\Off;\nENDWHILE\n", ""));
    stays("late.mod", &program("%\"init\"%;\n", &turned, "", off));
    // off for certain, in a routine that is called: the nearest one, 10 deg up from 5
    let (out, said) = rewritten(&desk, "sub.mod", &program("init;\n", &turned, "", off), "");
    assert!(!said.contains("depends on what ran before") && !out.contains(turned.trim_end()), "{out}{said}");
    // the same where the configuration is that of the nearest one: it makes no difference
    let (out, said) = rewritten(&desk, "near.mod", &program("IF di1=1 ConfJ\\Off;\n", &near, "", ""), "");
    assert!(!said.contains("depends on what ran before") && !out.contains(near.trim_end()), "{out}{said}");
}

#[test]
fn the_move_before_a_reading_of_the_place_stays_wherever_it_stands() {
    let desk = desk();
    let [a, b, c] = [0.0, 10.0, 4.0].map(|j1| absj([j1, 0.0, 0.0, 0.0, 30.0, 0.0]));
    let read = "ph:=CRobT();\nMoveL Offs(ph,0,0,50),v200,fine,tool0;\n";
    let program = |main: &str, routines: &str| {
        format!("MODULE m\nVAR robtarget ph;\nPROC main()\n{main}ENDPROC\n{routines}ENDMODULE\n")
    };
    for (name, text) in [
        ("sub.mod", program(&format!("{a}sub;\n{read}"), &format!("PROC sub()\n{c}{b}ENDPROC\n"))),
        ("loop.mod", program(&format!("{a}FOR i FROM 1 TO 3 DO\n{read}{c}{b}ENDFOR\n"), "")),
        ("late.mod", program(&format!("{a}{b}%\"rd\"%;\n{c}"), &format!("PROC rd()\n{read}ENDPROC\n"))),
        ("here.mod", program(&format!("{a}{b}PDispOn p1,tool0;\n{c}"), "")),
    ] {
        let (out, _) = rewritten(&desk, name, &text, "");
        assert!(out.contains(b.trim_end()), "{name}: {out}");
    }
    let (out, _) = rewritten(&desk, "none.mod", &program(&format!("{a}{b}{c}"), ""), "");
    assert!(!out.contains(b.trim_end()), "{out}");
}

#[test]
fn modules_of_a_task_that_are_rewritten_in_one_run_get_different_names() {
    let desk = desk();
    let module = |name: &str, target: &str, main: &str, joint: f64| {
        let [a, c] = [-5.0, 12.0].map(|j1| absj([j1, 0.0, 0.0, 0.0, 30.0, 0.0]));
        let to = format!("MoveAbsJ {target},v200,fine,tool0;\n");
        format!(
            "MODULE {name}\nCONST jointtarget {target}:=[[{joint},0,0,0,30,0],{AXES}];\nPROC {main}()\n{a}{to}{c}{to}ENDPROC\nENDMODULE\n"
        )
    };
    let [one, two] = [1, 2].map(|k| format!("pStationAlphaConveyorPick000000{k}"));
    desk.write("task/PROGMOD/A.mod", &module("A", &one, "main", 3.0));
    desk.write("task/PROGMOD/B.mod", &module("B", &two, "part", 5.0));
    desk.run("rewrite --model model.yaml task --output-dir out").success();
    let new = |file: &str| -> Vec<String> {
        let text = String::from_utf8(desk.read(&format!("out/PROGMOD/{file}"))).unwrap();
        let names = text.lines().filter_map(|line| line.strip_prefix("CONST jointtarget ")?.split(":=").next());
        names.map(str::to_lowercase).collect()
    };
    let (a, b) = (new("A.mod"), new("B.mod"));
    assert!(a.len() == 2 && b.len() == 2 && a.iter().all(|name| !b.contains(name)), "{a:?} {b:?}");
}

#[test]
fn moves_of_a_robot_on_a_track_get_new_points() {
    let desk = desk();
    let text = String::from_utf8(desk.read("robot.yaml")).unwrap();
    let track = "joints:\n  - {name: eax_a, kind: prismatic, theta_deg: 0, d_mm: 0.0, a_mm: 0.0, alpha_deg: 0, direction: 1, limits_mm: [-1000, 1000], max_speed_mm_s: 500, max_accel_mm_s2: 2000}\n";
    desk.write("robot.yaml", &text.replace("joints:\n", track));
    let to = |j1: f64, track: f64| {
        format!("MoveAbsJ [[{j1},-20,25,10,50,{j1}],[{track},9E9,9E9,9E9,9E9,9E9]],v200,fine,tool0;\n")
    };
    let program =
        format!("MODULE m\nPROC main()\n{}{}{}ENDPROC\nENDMODULE\n", to(0.0, 0.0), to(10.0, 100.0), to(4.0, 50.0));
    let (out, _) = rewritten(&desk, "track.mod", &program, "");
    assert!(out.matches("MoveAbsJ [[").count() > 3, "{out}");
}
