//! Calls of routines of the same file: what stands after a call comes from where the routine ends.

use crate::vendor_joins::{all, krl};
use crate::vendor_loops::{desk, program, rewritten, to};

/// A module of RAPID in which `main` begins with 0 and 10 and then does `body`, with a routine `part`.
fn module(body: &str, part: &str) -> String {
    program(&format!("{}{body}Stop;\nENDPROC\nPROC part()\n{part}", all(&[0, 10])))
}

#[test]
fn what_follows_a_call_comes_from_where_the_routine_ends() {
    let desk = desk();
    // `part` ends at 5, down from 20: down to 3, and a step up to 30; not from 10, at which its caller stood
    for (next, by_next) in [(3, -1), (7, 1), (30, 1)] {
        let (by, said) = rewritten(&desk, &module(&format!("part;\n{}", to(next)), &all(&[0, 20, 5])));
        assert_eq!(by, [1, 1, by_next, -1, 1, -1], "{next}: {said}");
    }
    // two calls, of routines that call others
    let nested = format!("{}part;\n{}ENDPROC\nPROC part()\n{}", all(&[0, 20]), to(1), all(&[0, 20, 5]));
    let text = program(&format!("{}outer;\n{}Stop;\nENDPROC\nPROC outer()\n{nested}", all(&[0, 10]), to(3)));
    assert_eq!(rewritten(&desk, &text).0, [1, 1, 1, -1, 1, -1, -1, 1, -1]);
}

#[test]
fn a_routine_that_ends_at_several_places_or_may_not_move_has_all_of_them() {
    let desk = desk();
    // left at 20 or at 5: both come down to 3, but not to 10
    let part = format!("{}IF di1=1 THEN\nRETURN;\nENDIF\n{}", all(&[0, 20]), to(5));
    for (next, by_next) in [(3, -1), (10, 0), (30, 1)] {
        let by = rewritten(&desk, &module(&format!("part;\n{}", to(next)), &part)).0;
        assert_eq!(by, [1, 1, by_next, -1, 1, -1], "{next}");
    }
    // what nothing leads to is no end
    let part = format!("{}RETURN;\n", all(&[0, 20, 5]));
    assert_eq!(rewritten(&desk, &module(&format!("part;\n{}", to(3)), &part)).0[2], -1);
    // where it may do nothing, the robot is where its caller was: at 5 or at 10
    let part = format!("IF di1=1 THEN\n{}ENDIF\n", all(&[0, 20, 5]));
    for (next, by_next) in [(3, -1), (7, 0), (30, 1)] {
        assert_eq!(rewritten(&desk, &module(&format!("part;\n{}", to(next)), &part)).0[2], by_next, "{next}");
    }
    // of one that another module may call that is not known
    let other = module(&format!("part;\n{}", to(3)), &part).replace("PROC main", "PROC other");
    assert_eq!(rewritten(&desk, &other).0[2], 0);
    // it calls itself: where it ends is known, from which side it comes there is not
    let part = format!("{}part;\n{}", all(&[0, 20]), to(5));
    let by = rewritten(&desk, &module(&format!("part;\n{}", to(3)), &part)).0;
    assert_eq!((by[2], by[5]), (-1, 0), "{by:?}");
}

#[test]
fn calls_that_may_lead_elsewhere_end_what_is_known() {
    let desk = desk();
    let part = all(&[0, 20, 5]);
    let handler = |last: &str| format!("{part}ERROR\n{last}");
    let cases = [
        ("a handler that goes back to the caller", handler("RETURN;\n")),
        ("the end of a handler", handler("TPWrite \"x\";\n")),
        ("goes on after what failed", handler("TRYNEXT;\n")),
        ("a target that is not known", format!("{part}MoveJ Offs(p1,0,0,x),v100,fine,tool0;\n")),
        ("a frame", format!("{part}PDispOn p1,tool0;\n")),
        ("an interrupt", format!("{part}CONNECT i1 WITH t;\n")),
    ];
    for (what, part) in cases {
        assert_eq!(rewritten(&desk, &module(&format!("part;\n{}", to(3)), &part)).0[2], 0, "{what}");
    }
    // a handler that gives up is not on the way
    assert_eq!(rewritten(&desk, &module(&format!("part;\n{}", to(3)), &handler("RAISE;\n"))).0[2], -1);
    // names that are computed, and functions in the arguments
    for call in ["%\"part\"%;\n", "part f();\n"] {
        let text = module(
            &format!("{call}{}", to(3)),
            &format!("{part}ENDPROC\nFUNC num f()\n{}RETURN 1;\nENDFUNC\nPROC g()\n", to(1)),
        );
        assert_eq!(rewritten(&desk, &text).0[2], 0, "{call}");
    }
}

#[test]
fn points_after_a_call_stand_after_it_and_can_be_undone() {
    let desk = desk();
    let text = module(&format!("part;\n{}{}", to(30), to(3)), &all(&[0, 20, 5]));
    desk.write("p.mod", &text);
    desk.run("rewrite --model model.yaml p.mod --output out.mod").success();
    let out = String::from_utf8(desk.read("out.mod")).unwrap();
    let call = out.lines().position(|l| l == "part;").unwrap();
    // up from 5: the step first
    let next = out.lines().nth(call + 1).unwrap();
    let j1: f64 = next.strip_prefix("MoveAbsJ [[").unwrap().split(',').next().unwrap().parse().unwrap();
    assert!((5.0..6.0).contains(&j1), "{out}");
    desk.run("rewrite --model model.yaml out.mod --output again.mod").code(2);
    desk.run("undo out.mod --output back.mod").success();
    assert_eq!(desk.read("back.mod"), desk.read("p.mod"));
}

#[test]
fn calls_of_krl_are_followed_but_where_an_interrupt_may_end_a_routine() {
    let desk = desk();
    let part = ["END", "DEF part( )", "0", "20", "5"];
    let with =
        |before: &[&'static str], after: &[&'static str]| -> Vec<&'static str> { [before, &part, after].concat() };
    assert_eq!(krl(&desk, &with(&["0", "10", "part( )", "3"], &[])), [1, 1, -1, -1, 1, -1]);
    assert_eq!(krl(&desk, &with(&["0", "10", "part( )", "30"], &["RETURN"])), [1, 1, 1, -1, 1, -1]);
    for (what, lines) in [
        ("an interrupt", with(&["INTERRUPT ON 1", "0", "10", "part( )", "3"], &[])),
        ("resume", with(&["0", "10", "part( )", "3"], &["END", "DEF stop( )", "RESUME"])),
        ("two of one name", with(&["0", "10", "part( )", "3"], &["END", "DEF part( )", "1"])),
        ("another file", with(&["0", "10", "away( )", "3"], &[])),
        ("a relative motion", with(&["0", "10", "part( )", "3"], &["PTP_REL {A1 1}", "PTP XHOME"])),
    ] {
        assert_eq!(krl(&desk, &lines)[2], 0, "{what}");
    }
}

#[test]
fn the_first_target_of_a_routine_is_reached_from_all_its_calls() {
    let desk = desk();
    let part = all(&[0, 20, 5]);
    let first = |main: &str, part: &str| {
        let by = rewritten(&desk, &program(&format!("{}{main}Stop;\nENDPROC\nPROC part()\n{part}", all(&[0, 10])))).0;
        by[by.len() - 3]
    };
    // from 10; from 10 and 30; from 10 and -30; in a loop that ends at -30; before anything has moved to a known place
    assert_eq!(first("part;\n", &part), -1);
    assert_eq!(first(&format!("part;\n{}part;\n", to(30)), &part), -1);
    assert_eq!(first(&format!("part;\n{}part;\n", to(-30)), &part), 0);
    assert_eq!(first(&format!("WHILE TRUE DO\npart;\n{}ENDWHILE\n", to(-30)), &part), 0);
    assert_eq!(first("MoveJ p1,v100,fine,tool0;\npart;\n", &part), 0);
    // a handler that runs the call again, a name in a text, one that is computed
    assert_eq!(first("part;\nERROR\nRETRY;\n", &part), 0);
    assert_eq!(first("part;\nMoveLSync p1,v100,z10,tool0,\"part\";\n", &part), 0);
    assert_eq!(first("part;\n%\"pa\"+\"rt\"%;\n", &part), 0);
    // KRL: by a local routine, not by one that others see, nor by one that an interrupt calls
    let krl_first = |before: &[&'static str], head: &'static str| {
        let lines = [before, &["0", "10", "part( )", "END", head, "0", "20", "5"]].concat();
        krl(&desk, &lines)[2]
    };
    assert_eq!(krl_first(&[], "DEF part( )"), -1);
    assert_eq!(krl_first(&[], "GLOBAL DEF part( )"), 0);
    assert_eq!(krl_first(&["INTERRUPT DECL 3 WHEN $IN[1] DO part( )"], "DEF part( )"), 0);
}

#[test]
fn the_move_before_a_target_that_counts_from_nowhere_is_edited() {
    let desk = desk();
    let last = |goal: &str| rewritten(&desk, &program(&format!("{}{goal}\n{}", all(&[0, 20, 5]), to(3)))).0[2];
    for goal in
        ["MoveL Offs(p1,0,0,h),v100,fine,tool0;", "MoveJ p{i},v100,z10,tool0;", "MoveAbsJ jHome,v100,fine,tool0;"]
    {
        assert_eq!(last(goal), -1, "{goal}");
    }
    for goal in [
        "MoveL Offs(CRobT(),0,0,h),v100,fine,tool0;",
        "p1:=CRobT();\nMoveL Offs(p1,0,0,h),v100,fine,tool0;",
        "MoveC p2,Offs(p1,0,0,h),v100,fine,tool0;",
    ] {
        assert_eq!(last(goal), 0, "{goal}");
    }
    // KRL: a part that is not given stays where the robot stands
    assert_eq!(krl(&desk, &["0", "20", "5", "LIN {X 900,Y n,Z 800,A 0,B 90,C 0}", "3"])[2], -1);
    assert_eq!(krl(&desk, &["0", "20", "5", "LIN {Z n}", "3"])[2], 0);
}
