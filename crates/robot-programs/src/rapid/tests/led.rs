//! What leads the arm off its targets from before a routine or a loop.

use super::*;

const MOVE: &str = "MoveAbsJ j1,v100,fine,tool0;";

/// Why each move of a program stays; `None`: it is edited.
fn reasons(source: &str) -> Vec<Option<String>> {
    let why = |m: Move| match m.goal {
        Goal::Opaque(why) => Some(why.to_string()),
        _ => None,
    };
    moves(source).into_iter().map(why).collect()
}

fn with_routines(body: &str, routines: &[&str]) -> String {
    program(J, body).replace("ENDMODULE", &format!("{}\nENDMODULE", routines.join("\n")))
}

#[test]
fn moves_of_a_routine_that_is_called_while_something_leads_the_arm_stay() {
    let sub = format!("PROC sub()\n{MOVE}\nENDPROC");
    for (on, off, by) in [
        ("SyncToSensor S\\On;", "SyncToSensor S\\Off;", "synctosensor"),
        ("FCAct f;", "FCDeact;", "fcact"),
        ("CSSAct 1;", "CSSDeactMoveL p1,v10,tool0;", "cssact"),
        ("SoftAct 3,50;", "SoftDeact;", "softact"),
    ] {
        let led = Some(format!("{by} leads the arm away from its targets"));
        let around = with_routines(&format!("{MOVE}\n{on}\nsub;\n{off}\n{MOVE}"), &[&sub]);
        let found = reasons(&around);
        assert_eq!((found.first(), found.last()), (Some(&None), Some(&led)), "{on}");
        // by another one, where it may be on, and by a name that is computed
        let twice = format!("PROC mid()\nsub;\nENDPROC\n{sub}");
        for body in [
            format!("{on}\nmid;\n{off}"),
            format!("IF d1=1 THEN\n{on}\nENDIF\nmid;\n{off}"),
            format!("{on}\n%\"mid\"%;\n{off}"),
            format!("FOR i FROM 1 TO n DO\nmid;\n{on}\nENDFOR\n{off}"),
        ] {
            assert_eq!(reasons(&with_routines(&body, &[&twice])).last(), Some(&led), "{body}");
        }
        let after = with_routines(&format!("{on}\n{off}\nsub;"), &[&sub]);
        assert_eq!(reasons(&after).last(), Some(&None), "{on}");
    }
}

#[test]
fn moves_of_a_loop_at_whose_end_something_leads_the_arm_stay() {
    let body = format!("WHILE TRUE DO\n{MOVE}\nFCAct f;\n{MOVE}\nENDWHILE");
    assert!(reasons(&program(J, &body)).iter().all(Option::is_some));
    let body = format!("WHILE TRUE DO\n{MOVE}\nFCAct f;\n{MOVE}\nFCDeact;\nENDWHILE");
    assert_eq!(reasons(&program(J, &body)).iter().map(Option::is_some).collect::<Vec<_>>(), [false, true]);
}

#[test]
fn an_axis_that_was_soft_before_a_routine_stays_so_whatever_that_makes_stiff() {
    let sub = format!("PROC sub()\nSoftAct 1,0;\n{MOVE}\nENDPROC");
    let source = with_routines("SoftAct 2,50;\nsub;\nSoftDeact;", &[&sub]);
    assert!(reasons(&source).iter().all(Option::is_some));
}

#[test]
fn an_axis_that_becomes_stiff_moves_nothing() {
    let kinds = kinds(&program(J, &format!("SoftDeact;\n{MOVE}\nSoftDeact;\n{MOVE}")));
    assert_eq!(kinds, ["Start", "move", "move"]);
    let doc = document(&program(J, &format!("{MOVE}\nSoftAct 3,50;\nSoftDeact;\n{MOVE}")));
    assert!(doc.script().unknown_calls.is_empty());
    assert_eq!(harness::kinds(doc.script()), ["Start", "move", "Call", "move"]);
}
