//! Where the robot comes from: what may count as the start of a program, and which solution of a pose is meant. Anything else
//! would put a point where the robot never was, or double the error at the first one.

use super::vendor_rewrite::Desk;
use crate::support::bundled;
use lostmotion::robot::Robot;
use nalgebra::{Rotation3, UnitQuaternion};

const AXES: &str = "[9E9,9E9,9E9,9E9,9E9,9E9]";

/// A desk with another robot, a gap on its first joint.
fn desk(robot: &str, joint: &str) -> Desk {
    let desk = Desk::new(0.02);
    let file = bundled("configs").join(robot);
    std::fs::copy(file, desk.path("robot.yaml")).unwrap();
    let effect = format!("  - {{effect: backlash, joint: {joint}, half_gap_deg: 0.02}}\n");
    desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{effect}"));
    desk
}

/// A program as `rewrite` leaves it, and what it says.
fn rewritten(desk: &Desk, name: &str, program: &str, more: &str) -> (String, String) {
    desk.write(name, program);
    let run =
        desk.run(format!("rewrite --model model.yaml {name} --output out_{name} --force {more}").trim_end()).success();
    let said = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
    (String::from_utf8(desk.read(&format!("out_{name}"))).unwrap(), said)
}

fn absj(a1: f64, external: &str) -> String {
    format!("MoveAbsJ [[{a1},0,0,0,30,0],{external}],v500,fine,tool0;\n")
}

fn module(body: &str) -> String {
    format!("MODULE M\n{body}ENDMODULE\n")
}

#[test]
fn the_first_point_in_a_loop_stays_as_from_the_second_turn_on_the_robot_comes_from_the_last() {
    let desk = desk("abb-irb1600-6-145.yaml", "J1");
    let body = format!("PROC main()\nWHILE TRUE DO\n{}{}ENDWHILE\nENDPROC\n", absj(0.0, AXES), absj(90.0, AXES));
    let (out, said) = rewritten(&desk, "loop.mod", &module(&body), "");
    assert!(out.contains("[[0,0,0,0,30,0]") && out.contains("[[90.0200,0"), "{out}");
    assert!(said.contains("reached from other sides on its other ways"), "{said}");
    // at the start of a program it carries its offset, and takes the direction that is asked for
    let straight = module(&format!("PROC main()\n{}{}Stop;\nENDPROC\n", absj(0.0, AXES), absj(90.0, AXES)));
    assert!(rewritten(&desk, "straight.mod", &straight, "").0.contains("[[0.0200,0"));
    let (asked, _) = rewritten(&desk, "loop.mod", &module(&body), "--initial-direction J1=-");
    // asked for, both passes of the loop reach it from above
    assert!(asked.contains("[[-0.0200,0"), "{asked}");
}

#[test]
fn a_routine_in_front_of_main_is_no_start_of_the_program() {
    let desk = desk("abb-irb1600-6-145.yaml", "J1");
    let pick = format!("PROC pick()\n{}{}ENDPROC\n", absj(10.0, AXES), absj(20.0, AXES));
    let main = format!("PROC main()\n{}{}pick;\nENDPROC\n", absj(40.0, AXES), absj(50.0, AXES));
    let (out, _) = rewritten(&desk, "order.mod", &module(&(pick + &main)), "");
    // its first point comes from the call
    assert!(out.contains("[[9.9800,0") && out.contains("[[20.0200,0"), "{out}");
    assert!(out.contains("[[40.0200,0") && out.contains("[[50.0200,0"), "{out}");
}

#[test]
fn traps_functions_and_threads_are_no_start_of_the_program() {
    let desk = desk("abb-irb1600-6-145.yaml", "J1");
    let trap = format!("TRAP tr\n{}{}ENDTRAP\n", absj(5.0, AXES), absj(15.0, AXES));
    let func = "FUNC num twice(num n)\nRETURN 2*n;\nENDFUNC\n";
    let path = format!("PROC path()\n{}{}ENDPROC\n", absj(40.0, AXES), absj(50.0, AXES));
    let (out, _) = rewritten(&desk, "trap.mod", &module(&(trap + func + &path)), "");
    assert!(out.contains("[[5,0") && out.contains("[[40.0200,0"), "{out}");
    let desk = self::desk("universal-robots-ur10.yaml", "base");
    let movej = |base: f64| format!("  movej([{base:.1},-1.2,1.3,-1.6,-1.2,0.1], a=1.4, v=1.05)\n");
    let thread = "thread watch():\n  while True:\n    sync()\n  end\nend\n";
    let (out, _) =
        rewritten(&desk, "thread.script", &format!("{thread}def p():\n{}{}end\n", movej(0.3), movej(0.8)), "");
    assert!(out.contains("movej([0.300349,"), "{out}");
    // what stands outside of functions runs first
    let outside = format!("def pick():\n{}{}end\n{}{}pick()\n", movej(0.5), movej(0.9), movej(1.5), movej(1.1));
    let (out, _) = rewritten(&desk, "outside.script", &outside, "");
    assert!(out.contains("movej([0.499651,") && out.contains("movej([1.499651,"), "{out}");
}

#[test]
fn behind_a_call_the_first_point_stays_also_where_no_run_stands_before() {
    let desk = desk("abb-irb1600-6-145.yaml", "J1");
    let body = format!("PROC main()\nGoSomewhere;\n{}{}ENDPROC\n", absj(40.0, AXES), absj(50.0, AXES));
    let (out, said) = rewritten(&desk, "call.mod", &module(&body), "");
    assert!(out.contains("[[40,0") && out.contains("[[50.0200,0"), "{out}");
    assert!(said.contains("start anew once"), "{said}");
}

#[test]
fn no_point_is_put_on_a_way_on_which_external_axes_move() {
    let desk = desk("abb-irb1600-6-145.yaml", "J1");
    let track = |mm: u32| format!("[{mm},9E9,9E9,9E9,9E9,9E9]");
    let moves = [absj(0.0, &track(0)), absj(80.0, &track(1000)), absj(0.0, &track(4000))].concat();
    let (out, said) = rewritten(&desk, "track.mod", &module(&format!("PROC main()\n{moves}ENDPROC\n")), "");
    assert_eq!(out.matches("MoveAbsJ").count(), 3, "{out}");
    assert!(said.contains("moves that cannot be split") && said.contains("(line 5)"), "{said}");
    // also after a block that moves nothing, and from a place that the text does not give
    let quiet = "IF di1=1 THEN\nSetDO do1,1;\nENDIF\n";
    let moves = [absj(0.0, &track(0)), absj(80.0, &track(1000)), quiet.into(), absj(0.0, &track(4000))].concat();
    let (out, _) = rewritten(&desk, "block.mod", &module(&format!("PROC main()\n{moves}ENDPROC\n")), "");
    assert_eq!(out.matches("MoveAbsJ").count(), 3, "{out}");
    let from = "[nTrack,9E9,9E9,9E9,9E9,9E9]";
    let moves = [absj(0.0, from), absj(80.0, from), absj(0.0, &track(4000))].concat();
    let (out, _) = rewritten(&desk, "computed.mod", &module(&format!("PROC main()\n{moves}ENDPROC\n")), "");
    assert_eq!(out.matches("MoveAbsJ").count(), 3, "{out}");
    // a track that stands changes nothing
    let moves = [absj(0.0, &track(700)), absj(80.0, &track(700)), absj(0.0, &track(700))].concat();
    let (out, _) = rewritten(&desk, "stands.mod", &module(&format!("PROC main()\n{moves}ENDPROC\n")), "");
    assert_eq!(out.matches("MoveAbsJ").count(), 4, "{out}");
}

/// `[[position],[quaternion],[conf],[external]]` of joints in degrees.
fn robtarget(robot: &Robot, joints_deg: [f64; 6], conf: &str, external: &str) -> String {
    let pose = robot.forward(&joints_deg.map(f64::to_radians));
    let p = pose.position * 1e3;
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*pose.rotation.matrix()));
    format!("[[{:.5},{:.5},{:.5}],[{:.9},{:.9},{:.9},{:.9}],{conf},{external}]", p.x, p.y, p.z, q.w, q.i, q.j, q.k)
}

#[test]
fn a_pose_is_followed_in_the_configuration_that_it_names_alone() {
    let desk = desk("abb-irb1600-6-145.yaml", "J1");
    let robot = Robot::load(&desk.path("robot.yaml")).unwrap();
    let program = |before: &str, conf: &str, external: &str| {
        let pose = robtarget(&robot, [25.0, 5.0, 12.0, -15.0, 40.0, 20.0], conf, external);
        let start = format!("MoveAbsJ [[20,0,10,-15,45,25],{external}],v500,fine,tool0;\n");
        let end = format!("MoveAbsJ [[15,5,12,-15,45,25],{external}],v500,fine,tool0;\n");
        module(&format!("PROC main()\n{before}{start}MoveJ {pose},v500,fine,tool0;\n{end}ENDPROC\n"))
    };
    let over = "another arm configuration than that before";
    let goes_over = |before: &str, conf: &str, external: &str| {
        let (out, said) = rewritten(&desk, "conf.mod", &program(before, conf, external), "");
        assert!(!said.contains("directions are lost"), "{said}{out}");
        said.contains(over)
    };
    assert!(!goes_over("", "[0,-1,0,0]", AXES));
    // the wrist turned over: the same pose, joints half a turn away, to which a joint motion goes as ordered
    assert!(goes_over("", "[0,1,-2,1]", AXES));
    assert!(!goes_over("ConfJ\\Off;\n", "[0,1,-2,1]", AXES));
    assert!(goes_over("ConfJ\\Off;\nConfJ\\On;\n", "[0,1,-2,1]", AXES));
    // the switch in main holds for routines in front of it, one in another routine for that alone
    let switched = |start: &str, switch: &str| {
        let pose = robtarget(&robot, [25.0, 5.0, 12.0, -15.0, 40.0, 20.0], "[0,1,-2,1]", AXES);
        let moves = format!("MoveAbsJ [[20,0,10,-15,45,25],{AXES}],v500,fine,tool0;\nMoveJ {pose},v500,fine,tool0;\n");
        let body = format!("PROC path()\n{moves}ENDPROC\nPROC main()\n{start}path;\nENDPROC\n");
        module(&format!("{body}PROC other()\n{switch}ENDPROC\n"))
    };
    assert!(!rewritten(&desk, "main.mod", &switched("ConfJ\\Off;\n", ""), "").1.contains(over));
    assert!(rewritten(&desk, "other.mod", &switched("", "ConfJ\\Off;\n"), "").1.contains(over));
    // what an external axis carries is not known
    let carried = program("", "[0,-1,0,0]", "[700,9E9,9E9,9E9,9E9,9E9]");
    let (out, said) = rewritten(&desk, "carried.mod", &carried, "");
    assert!(said.contains("directions are lost") && out.matches("MoveAbsJ").count() == 2, "{said}{out}");
}

#[test]
fn the_solution_next_to_qnear_is_taken() {
    let desk = desk("universal-robots-ur10.yaml", "wrist3");
    let robot = Robot::load(&desk.path("robot.yaml")).unwrap();
    let program = |near: &str| {
        let joints: [f64; 6] = [0.3, -1.3, 1.4, -1.6, -1.3, 0.2];
        let pose = robot.forward(&joints);
        let r = Rotation3::from_matrix_unchecked(*pose.rotation.matrix()).scaled_axis();
        let p = pose.position;
        let pose = format!("p[{:.9},{:.9},{:.9},{:.9},{:.9},{:.9}]", p.x, p.y, p.z, r.x, r.y, r.z);
        format!(
            "def p():\n  set_tcp(p[0,0,0,0,0,0])\n  movej([0.3,-1.2,1.3,-1.6,-1.2,0.1], a=1.4, v=1.05)\n  \
             movej(get_inverse_kin({pose}, qnear={near}), a=1.4, v=1.05)\n  movej([0.3,-1.2,1.3,-1.6,-1.2,0.1], a=1.4, v=1.05)\nend\n"
        )
    };
    // wrist3 turns at 0.2, where the robot stands on the same branch, and crosses its gap there
    let (out, said) = rewritten(&desk, "near.script", &program("[0.3,-1.3,1.4,-1.6,-1.3,0.2]"), "");
    assert!(said.contains("1 reversal"), "{said}");
    assert!(out.contains(",0.199651]"), "{out}");
    // the wrist turned over: wrist3 goes to 0.2 - pi and turns there
    let (out, said) = rewritten(&desk, "near.script", &program("[0.3,-1.3,1.4,1.54,1.3,-2.94]"), "");
    assert!(said.contains("1 reversal") || said.contains("directions are lost"), "{said}");
    assert!(!out.contains(",0.199651]"), "{out}");
    // what is computed at run time is not known
    let (_, said) = rewritten(&desk, "near.script", &program("[0.3,-1.3,1.4,x,-1.3,0.2]"), "");
    assert!(said.contains("qnear"), "{said}");
}

#[test]
fn moves_that_name_some_axes_each_tell_together_where_the_robot_stands() {
    let desk = Desk::new(0.02);
    let program = "DEF part( )\r\nPTP {A1 0.0,A2 -90.0,A3 90.0}\r\nPTP {A4 0.0,A5 10.0,A6 0.0}\r\n\
PTP {A1 20.0000}\r\nPTP {A1 5.0000}\r\nEND\r\n";
    let (out, said) = rewritten(&desk, "some.src", program, "");
    assert!(said.contains("before the position of every axis is known; line 2"), "{said}");
    // what was said before the whole was known stays, after it the turn is undone
    assert!(out.contains("PTP {A1 0.0,A2 -90.0,A3 90.0}") && out.contains("PTP {A1 20.0200}"), "{out}");
    assert!(out.contains("PTP {A1 4.9800}") && out.matches("PTP").count() == 5, "{out}");
}
