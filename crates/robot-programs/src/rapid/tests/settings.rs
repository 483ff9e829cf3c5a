//! Tools and work objects that the program sets while it runs.

use super::*;

const DATA: &str = "LOCAL PERS wobjdata w:=[FALSE,TRUE,\"\",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\n\
                    LOCAL PERS tooldata t:=[TRUE,[[0,0,0],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\n\
                    CONST robtarget p1:=[[500,-20,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\nVAR num i;";

fn move_in(wobj: &str) -> String {
    format!("MoveL p1,v100,fine,tool0\\WObj:={wobj};")
}

/// Frames of the moves of a body.
fn frames(source: &str) -> Vec<Frame> {
    let frame = |m: Move| match m.goal {
        Goal::Pose(p) => p.frame.clone(),
        other => panic!("{other:?}"),
    };
    moves(source).into_iter().map(frame).collect()
}

fn computed(name: &str) -> Frame {
    Frame::Computed(name.into())
}

fn with_routine(body: &str, routine: &str) -> String {
    program(DATA, body).replace("ENDMODULE", &format!("{routine}\nENDMODULE"))
}

#[test]
fn data_that_the_program_sets_are_computed_and_those_of_the_controller_stand_fixed() {
    let m = move_in("w");
    let one = |body: &str| frames(&program(DATA, body)).pop().unwrap();
    assert_eq!(one(&move_in("wFixture")), Frame::Named("wFixture".into()));
    assert!(matches!(one(&m), Frame::Given(_)));
    for set in ["w.oframe.trans.y:=GInput(g);", "w:=wOther;", "Find w;", "wOther.uframe.trans.x:=3;"] {
        let (name, m) = if set.starts_with("wO") { ("wOther", move_in("wOther")) } else { ("w", m.clone()) };
        assert_eq!(one(&format!("{set}\n{m}")), computed(name), "{set}");
    }
    // of a list, by an index that the program counts; the first element is always the same
    assert_eq!(one(&format!("i:=i+1;\n{}", move_in("wList{i}"))), computed("wList{i}"));
    assert_eq!(one(&format!("i:=i+1;\n{}", move_in("wList{1}"))), Frame::Named("wList{1}".into()));
    // a parameter
    let sub = format!("PROC sub(PERS wobjdata v)\n{}\nENDPROC", move_in("v"));
    assert_eq!(frames(&with_routine("sub w;", &sub)), [computed("v")]);
    // passing its value on changes nothing
    let shows = "PROC shows(wobjdata v)\nTPWrite \"a\";\nENDPROC";
    assert!(!matches!(frames(&with_routine(&format!("shows w;\n{m}"), shows))[0], Frame::Computed(_)));
}

#[test]
fn where_a_work_object_or_a_tool_is_set_moves_in_it_lead_elsewhere() {
    let m = move_in("w");
    let sets = |source: &str| kinds(source).iter().filter(|k| k.starts_with("sets ")).count();
    assert_eq!(
        kinds(&program(DATA, &format!("{m}\nw.uframe.trans.x:=300;\n{m}"))),
        ["Start", "move", "sets w", "move"]
    );
    // in a routine that does not move, and in one that such a one calls
    let upd = "PROC upd()\nupd2;\nENDPROC\nPROC upd2()\nw.uframe.trans.x:=300;\nENDPROC";
    let called = kinds(&with_routine(&format!("{m}\nupd;\n{m}"), upd));
    assert_eq!(called[..4], ["Start", "move", "sets w", "move"]);
    let tool = "MoveL p1,v100,fine,t;";
    let of_tool = program(DATA, &format!("{tool}\nt.tframe.trans.z:=300;\n{tool}"));
    assert_eq!(kinds(&of_tool), ["Start", "move", "sets t", "move"]);
    // other data are none of a move's
    assert_eq!(sets(&program(DATA, &format!("{m}\ni:=3;\n{m}"))), 0);
    // a routine's parameter is another one on each call
    let sub = format!("PROC sub(wobjdata v)\n{}\nENDPROC", move_in("v"));
    assert_eq!(kinds(&with_routine("sub w;", &sub)), ["Start", "Call", "Start", "sets v", "move"]);
    // the counter of a loop
    let list = format!("FOR k FROM 1 TO 3 DO\n{}\nENDFOR", move_in("wList{k}"));
    assert_eq!(kinds(&program(DATA, &list)), ["Start", "Loop", "sets k", "move", "Loop"]);
}

#[test]
fn a_work_object_is_asked_for_once_for_each_assignment_where_the_last_one_is_certain() {
    let m = move_in("w");
    let names = |source: &str| frames(source);
    let second = "w from assignment 1 on";
    // before and after
    let source = program(DATA, &format!("{m}\nw.uframe.trans.x:=300;\n{m}\n{m}"));
    assert_eq!(names(&source), [computed("w"), computed(second), computed(second)]);
    let d = document(&source);
    assert!(d.script().notes.iter().any(|n| n.text == format!("asked for after this line as `{second}`")));
    // in a routine that is called
    let upd = "PROC upd()\nw.uframe.trans.x:=300;\nENDPROC";
    assert_eq!(names(&with_routine(&format!("{m}\nupd;\n{m}"), upd)), [computed("w"), computed(second)]);
    // fields that are set in a row are one assignment, and one alone before all moves needs no name
    let row = "w.oframe.trans.x:=1;\nw.oframe.trans.y:=2;\nSetDO d1,1;\nw.oframe.trans.z:=i;";
    assert_eq!(names(&program(DATA, &format!("{row}\n{m}\n{m}"))), [computed("w"), computed("w")]);
    let rows = program(DATA, &format!("{row}\n{m}\n{row}\n{m}"));
    assert_eq!(names(&rows), [computed(second), computed("w from assignment 2 on")]);
    // on every pass of a loop before its moves
    let pallet = program(DATA, &format!("FOR k FROM 1 TO 9 DO\n{row}\n{m}\n{m}\nENDFOR"));
    assert_eq!(names(&pallet), [computed("w"), computed("w")]);
    // which one was last is not certain
    for body in [
        format!("{m}\nIF d1=1 THEN\nw.uframe.trans.x:=300;\nENDIF\n{m}"),
        format!("{m}\nWHILE TRUE DO\n{m}\nw.uframe.trans.x:=300;\n{m}\nENDWHILE"),
        format!("{m}\nagain:\n{m}\nw.uframe.trans.x:=300;\nGOTO again;"),
    ] {
        assert!(names(&program(DATA, &body)).iter().all(|f| *f == computed("w")), "{body}");
    }
    // nor at the start of a routine that another one calls
    let sub = format!("PROC sub()\n{m}\nw.uframe.trans.x:=300;\n{m}\nENDPROC");
    assert!(names(&with_routine("sub;\nsub;", &sub)).iter().all(|f| *f == computed("w")));
}

#[test]
fn what_a_trap_sets_is_not_known() {
    let source = with_routine(&move_in("w"), "TRAP tr\nw.uframe.trans.x:=300;\nENDTRAP");
    let found = frames(&source);
    assert!(matches!(&found[0], Frame::Unknown(why) if why.to_string() == "a TRAP sets `w`"), "{found:?}");
}

#[test]
fn a_note_at_an_assignment_stands_only_where_a_move_asks_for_what_is_set() {
    let notes = |body: &str| {
        let doc = document(&program(DATA, body));
        doc.script().notes.iter().filter(|n| n.text.starts_with("asked for after this line")).count()
    };
    let m = move_in("w");
    assert_eq!(notes(&format!("{m}\nw.uframe.trans.x:=300;\n{m}")), 1);
    // what is not known may set what it is given; tool0 is never asked for
    let m = move_in("wobj0");
    assert_eq!(notes(&format!("{m}\nEGMMoveL e1,p1,path1,fine,tool0;\n{m}\nNutL p1,v100,nut1,gun1,tool0;\n{m}")), 0);
}
