//! RAPID's `main`, which runs again from its end; arguments that the caller of a routine may give; and two branches that lead to one target.

use crate::support::bundled;
use crate::vendor_loops::{desk, program, rewritten, rewritten_with, to};
use crate::vendor_rewrite::Desk;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;

/// A program that runs again from its start.
fn cycle(body: &str) -> String {
    program(body).replace("Stop;\n", "")
}

const OTHER_SIDES: &str = "reached from other sides on its other ways";

#[test]
fn the_first_target_of_main_stays_where_its_end_leads_there_from_another_side() {
    let desk = desk();
    // down at the first start, up from the end of main
    let body = format!("{}{}{}", to(10), to(4), to(0));
    let (by, said) = rewritten(&desk, &cycle(&body));
    assert_eq!(by, [0, -1, -1], "{said}");
    assert!(said.contains(OTHER_SIDES), "{said}");
    // as the loop that it is
    assert_eq!(rewritten(&desk, &program(&format!("WHILE TRUE DO\n{body}ENDWHILE\n"))).0, by);
    // from one of the places at which it ends
    let ends = format!("{}{}IF di1=1 THEN\n{}ELSE\n{}ENDIF\n", to(0), to(10), to(-5), to(20));
    assert_eq!(rewritten(&desk, &cycle(&ends)).0, [0, 1, -1, 1]);
    let ends = format!("{}{}IF di1=1 RETURN;\n{}", to(0), to(10), to(-5));
    assert_eq!(rewritten(&desk, &cycle(&ends)).0, [0, 1, -1]);
    // it never runs again
    for end in ["EXIT;\n", "Stop\\NoRegain;\n", "WHILE TRUE DO\nWaitTime 1;\nENDWHILE\n"] {
        assert_eq!(rewritten(&desk, &cycle(&format!("{body}{end}"))).0, [-1, -1, -1], "{end}");
    }
}

#[test]
fn the_first_target_of_main_is_edited_where_its_end_leads_there_from_the_same_side() {
    let desk = desk();
    let (by, said) = rewritten(&desk, &cycle(&format!("{}{}{}", to(0), to(10), to(-5))));
    assert_eq!(by, [1, 1, -1], "{said}");
    assert!(said.contains("all editable"), "{said}");
    // nothing is known of where a routine of no file ends
    assert_eq!(rewritten(&desk, &cycle(&format!("{}{}Elsewhere;\n", to(0), to(10)))).0, [1, 1]);
}

#[test]
fn the_first_target_of_main_is_reached_over_a_point_with_approach_unknown() {
    let desk = desk();
    desk.write("p.mod", &cycle(&format!("{}{}{}", to(10), to(4), to(0))));
    let run = desk.run("rewrite --model model.yaml p.mod --output out.mod --force --approach-unknown").success();
    run.stderr(contains(OTHER_SIDES).not());
    let out = String::from_utf8(desk.read("out.mod")).unwrap();
    assert!(out.matches("MoveAbsJ").count() > 3 && !out.contains("MoveAbsJ [[10,10,"), "{out}");
}

#[test]
fn a_joint_that_rests_at_the_first_targets_changes_nothing_there() {
    let desk = desk();
    let at = |j1: i32, j2: i32| to(j2).replacen(&format!("[[{j2},"), &format!("[[{j1},"), 1);
    // J1 goes up last, and comes down from the end: without an offset at the first start
    let text = cycle(&format!("{}{}{}{}", at(3, 0), at(3, 10), at(8, 20), at(8, -5)));
    let (by, said) = rewritten_with(&desk, &text, "--max-added 0");
    let out = String::from_utf8(desk.read("out.mod")).unwrap();
    assert!(out.contains("MoveAbsJ [[3,0.01") && said.contains("all editable"), "{said}{out}");
    assert_eq!(by, [0, 0, 1, 1]);
}

/// A robot with half gaps of 0.05 deg on all joints.
fn loose() -> Desk {
    let desk = Desk::new(0.0);
    std::fs::copy(bundled("configs/abb-irb1600-6-145.yaml"), desk.path("robot.yaml")).unwrap();
    let gaps = (1..=6).map(|n| format!("  - {{effect: backlash, joint: J{n}, half_gap_deg: 0.05}}\n"));
    let gaps: String = gaps.collect();
    desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{gaps}"));
    desk
}

const AXES: &str = "[9E9,9E9,9E9,9E9,9E9,9E9]";
const P2: &str =
    "[[719.504,-103.653,876.331],[0.141959,0.200312,0.962829,0.112621],[-1,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
const P3: &str =
    "[[323.944,123.493,672.520],[0.197622,0.207809,0.953208,0.095684],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
const T1: &str = "PERS tooldata t1:=[TRUE,[[30,0,120],[0.988771078,0,0.149438132,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];\n";
const W1: &str =
    "PERS wobjdata w1:=[FALSE,TRUE,\"\",[[400,-100,300],[0.968912422,0,0,0.247403959]],[[0,0,0],[1,0,0,0]]];\n";

#[test]
fn a_work_object_that_the_caller_may_give_is_asked_for() {
    let desk = loose();
    let moves = format!("MoveL {P3},v100,fine,t1\\WObj?WObj;\nMoveL {P2},v100,fine,t1\\WObj?WObj;\n");
    let text = format!(
        "MODULE M\n{T1}{W1}LOCAL PROC go(\\PERS wobjdata WObj)\n{moves}ENDPROC\nPROC main()\n\
         MoveAbsJ [[0,0,0,0,30,0],{AXES}],v100,fine,tool0;\ngo\\WObj:=w1;\nENDPROC\nENDMODULE\n"
    );
    desk.write("p.mod", &text);
    desk.run("rewrite --model model.yaml p.mod --list-frames").success().stdout(contains("WObj"));
    desk.run("rewrite --model model.yaml p.mod --output out.mod --force").success();
    let out = String::from_utf8(desk.read("out.mod")).unwrap();
    assert!(out.contains(&moves), "{out}");
}

#[test]
fn branches_with_a_straight_and_a_joint_move_to_one_target_are_not_taken_for_each_other() {
    let desk = loose();
    let j3 = format!("[[11.456,-16.321,18.884,12.252,48.766,5.020],{AXES}]");
    for (head, middle, end) in
        [("IF di1=1 THEN", "ELSE", "ENDIF"), ("TEST n\nCASE 1:", "CASE 2:", "ENDTEST"), ("", "lab1:", "")]
    {
        let first = format!("MoveL {P3},v100,fine,t1\\WObj:=w1;\nMoveJ {P2},v100,z10,t1;\n");
        let second = format!("MoveAbsJ {j3},v100,fine,tool0;\nMoveL {P2},v100,fine,t1;\n");
        let body = format!("{head}\n{first}{middle}\n{second}{end}\n");
        desk.write("p.mod", &format!("MODULE M\n{T1}{W1}PROC main()\n{body}ENDPROC\nENDMODULE\n"));
        let run = desk.run("rewrite --model model.yaml p.mod --output out.mod --solve-cartesian=50");
        run.success().stderr(contains("not found in the program after").not());
        std::fs::remove_file(desk.path("out.mod")).unwrap();
    }
}
