//! RAPID's `main`, which runs again from its end; arguments that the caller of a routine may give; and two branches that lead to one
//! target.

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

/// A loop that is certainly entered goes on behind it, and a program may have many ends.
#[test]
fn the_first_target_of_main_stays_behind_loops_and_many_ends_too() {
    let desk = desk();
    let first = [to(0), to(10)].concat();
    let looped = |head: &str, end: &str| format!("{first}{head}\n{}{end}\n{}", to(15), to(20));
    let plain = rewritten(&desk, &cycle(&format!("{first}{}{}", to(15), to(20)))).0;
    assert_eq!(plain[0], 0);
    let (by, said) = rewritten(&desk, &cycle(&looped("FOR i FROM 1 TO 3 DO", "ENDFOR")));
    assert_eq!(by[0], 0, "{by:?} {said}");
    // its passes come there from below, the end of main from above
    let around = format!("FOR i FROM 1 TO 3 DO\n{}{}{}ENDFOR\n", to(0), to(10), to(-5));
    assert_eq!(rewritten(&desk, &program(&format!("{around}{}", to(20)))).0[0], 1);
    assert_eq!(rewritten(&desk, &cycle(&format!("{around}{}", to(20)))).0[0], 0);
    // out of a loop to the end of main, where nothing moves any more
    let out = |last: i32| format!("{first}WHILE TRUE DO\n{}IF di1=1 GOTO out;\nENDWHILE\nout:\n", to(last));
    assert_eq!(rewritten(&desk, &cycle(&out(15))).0[0], 0);
    for n in [3, 9, 12, 70] {
        let ends: String = (0..n).map(|k| format!("IF di{k}=1 RETURN;\n{}", to(20 + k % 2))).collect();
        let (by, said) = rewritten(&desk, &cycle(&format!("{first}{ends}")));
        assert_eq!(by[0], 0, "{n} ends: {by:?} {said}");
        // from the same side from all of them
        let ends: String = (0..n).map(|k| format!("IF di{k}=1 RETURN;\n{}", to(-20 - k % 2))).collect();
        let body = format!("{first}{}{ends}", to(-10));
        assert_eq!(rewritten(&desk, &cycle(&body)).0[0], if n < 60 { 1 } else { 0 }, "{n} ends");
    }
}

/// Where all joints have turned often it does not matter any more from where the first target was reached.
#[test]
fn a_long_program_that_runs_again_leaves_the_same_targets_as_a_short_one() {
    let desk = desk();
    let swings: String = (0..40).map(|k| format!("{}{}", to(20 + k % 3), to(1))).collect();
    let both = |body: String| (rewritten(&desk, &program(&body)).0, rewritten(&desk, &cycle(&body)).0);
    // down at the first start, up from the end
    let (once, again) = both([10, 4, 0].map(to).concat() + &swings);
    assert_eq!((once[0], again[0]), (-1, 0));
    assert_eq!(once[1..], again[1..]);
    // up from both
    let (once, again) = both([0, 10, -5].map(to).concat() + &swings + &to(-20));
    assert_eq!(once[0], 1);
    assert_eq!(once, again);
}

/// A call of `main` leads to its start, as its end does.
#[test]
fn a_program_that_calls_itself_comes_to_its_first_target_from_there_too() {
    let desk = desk();
    let body = format!("{}{}{}", to(10), to(4), to(0));
    for call in ["main;\n", "IF di1=1 main;\n", "main;\nStop;\n"] {
        let (by, said) = rewritten(&desk, &program(&format!("{body}{call}")));
        assert_eq!(by, [0, -1, -1], "{call}{said}");
        assert!(said.contains(OTHER_SIDES), "{said}");
    }
    // from the same side
    assert_eq!(rewritten(&desk, &program(&format!("{}{}{}main;\n", to(0), to(10), to(-5)))).0, [1, 1, -1]);
}

/// Position `n` (from 0) of a FANUC program with the first joint at this angle.
pub fn taught(n: usize, j1_deg: i32) -> String {
    format!(
        "P[{}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\n\tJ1=    {j1_deg}.000 deg,\tJ2=     0.000 deg,\tJ3=     0.000 deg,\n\tJ4=     0.000 deg,\t\
         J5=   -40.000 deg,\tJ6=     0.000 deg\n}};\n",
        n + 1
    )
}

/// A joint program of each other language of which the first joint goes down twice and up once, and which calls itself then.
#[test]
fn programs_of_all_languages_that_call_themselves_leave_their_first_target() {
    let krl = "DEF m()\nPTP {A1 80,A2 -90,A3 90,A4 0,A5 30,A6 0}\nPTP {A1 20,A2 -90,A3 90,A4 0,A5 30,A6 0}\n\
PTP {A1 60,A2 -90,A3 90,A4 0,A5 30,A6 0}\nm()\nEND\n";
    let urscript = |end: &str| {
        let to = |base: f64| format!("  movej([{base}, -1.5, 1.5, -1.5, -1.5, 0])\n");
        format!("def prog():\n{}{}{}{end}", to(1.2), to(0.3), to(0.9))
    };
    let joints = [80, 20, 60];
    let point = |n: usize| format!("C0000{n}={}.0000,0.0000,0.0000,0.0000,-45.0000,0.0000\n", joints[n]);
    let inform = |end: &str| {
        let points: String = (0..3).map(point).collect();
        format!(
            "/JOB\n//NAME A\n//POS\n///NPOS 3,0,0,0,0,0\n///TOOL 0\n///POSTYPE ANGLE\n///ANGLE\n{points}//INST\n///DATE 2024/05/06 07:08\n\
             ///ATTR SC,RW\n///GROUP1 RB1\nNOP\nMOVJ C00000 VJ=25.00\nMOVJ C00001 VJ=25.00\nMOVJ C00002 VJ=25.00\n{end}\nEND\n"
        )
    };
    let fanuc = |end: &str| {
        let taught: String = (0..3).map(|n| taught(n, joints[n])).collect();
        format!(
            "/PROG  A\n/ATTR\nLINE_COUNT\t= 4;\nDEFAULT_GROUP\t= 1,*,*,*,*;\n/MN\n   1:J P[1] 50% FINE ;\n   2:J P[2] 50% FINE ;\n\
                3:J P[3] 50% FINE ;\n   4:  {end} ;\n/POS\n{taught}/END\n"
        )
    };
    let looped = "end\nwhile True:\n  prog()\nend\n";
    // out of a loop to the end, where nothing moves any more
    let broken =
        format!("  while True:\n    if get_digital_in(1):\n      break\n    end\n    sleep(0.1)\n  end\n{looped}");
    let left = krl.replace(
        "m()\nEND",
        "LOOP\nPTP {A1 50,A2 -90,A3 90,A4 0,A5 30,A6 0}\nIF $IN[1] THEN\nEXIT\nENDIF\nENDLOOP\nm()\nEND",
    );
    for (robot, joint, name, text, first, stays) in [
        ("kuka-kr120-r2500-pro", "A1", "m.src", krl.to_string(), "{A1 80,", true),
        ("kuka-kr120-r2500-pro", "A1", "m.src", krl.replace("m()\nEND", "END"), "{A1 80,", false),
        ("universal-robots-ur10e", "base", "p.script", urscript("end\nprog()\nprog()\n"), "movej([1.2,", true),
        ("kuka-kr120-r2500-pro", "A1", "m.src", left, "{A1 80,", true),
        ("universal-robots-ur10e", "base", "p.script", urscript(looped), "movej([1.2,", true),
        ("universal-robots-ur10e", "base", "p.script", urscript(&broken), "movej([1.2,", true),
        ("universal-robots-ur10e", "base", "p.script", urscript("  prog()\nend\nprog()\n"), "movej([1.2,", true),
        ("universal-robots-ur10e", "base", "p.script", urscript("end\nprog()\n"), "movej([1.2,", false),
        ("motoman-ar2010", "S", "A.JBI", inform("JUMP JOB:A"), "C00000=80.0000,", true),
        ("motoman-ar2010", "S", "A.JBI", inform("CALL JOB:A"), "C00000=80.0000,", true),
        ("motoman-ar2010", "S", "A.JBI", inform("JUMP JOB:A IF IN#(1)=ON"), "C00000=80.0000,", true),
        ("motoman-ar2010", "S", "A.JBI", inform("JUMP JOB:B"), "C00000=80.0000,", false),
        ("fanuc-m20ia", "J1", "A.LS", fanuc("CALL A"), "J1=    80.000 deg", true),
        ("fanuc-m20ia", "J1", "A.LS", fanuc("CALL B"), "J1=    80.000 deg", false),
    ] {
        let desk = Desk::new(0.0);
        std::fs::copy(bundled(&format!("configs/{robot}.yaml")), desk.path("robot.yaml")).unwrap();
        let model = format!(
            "schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n  - {{effect: backlash, joint: {joint}, half_gap_deg: 0.05}}\n"
        );
        desk.write("model.yaml", &model);
        desk.write(name, &text);
        desk.run(&format!("rewrite --model model.yaml {name} --output out-{name} --force --max-added 0")).success();
        let out = String::from_utf8(desk.read(&format!("out-{name}"))).unwrap();
        assert_eq!(out.contains(first), stays, "{name}: {text}\n{out}");
        assert_ne!(out, text);
    }
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

/// The verdict begins where the program does: in the routine that `main` calls first.
#[test]
fn the_verdict_of_a_program_that_begins_in_a_routine_begins_there() {
    let desk = desk();
    let main = format!("home;\n{}{}{}", to(0), to(10), to(20));
    let home = format!("PROC home()\n{}ENDPROC\nENDMODULE", to(15));
    desk.write("p.mod", &program(&main).replace("ENDMODULE", &home));
    let run = desk.run("rewrite --model model.yaml p.mod --output out.mod").success();
    run.stderr(contains("better").and(contains("worse").not()));
    assert!(String::from_utf8(desk.read("out.mod")).unwrap().contains("MoveAbsJ [[-0.0100,"));
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
