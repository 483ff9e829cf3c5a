//! Positions of the list: changed, added, copied where their moves want different things, and position variables.

use super::*;

#[test]
fn a_changed_point_changes_its_digits_and_nothing_else() {
    let text = two("MOVJ C00000 VJ=25.00\nMOVL C00001 V=50.0 PL=0");
    let out = written(&text, &[(2, Some([1000.0, -2003.4, 300.0, 0.0, -500.0, 622.0]), vec![])]);
    assert_eq!(out, text.replace("1000,-2000,", "1000,-2003,"));
}

#[test]
fn a_new_point_appends_a_position_and_the_count_grows() {
    let text = two("MOVJ C00000 VJ=25.00\nMOVL C00001 V=50.0 NWAIT 'weld start\nMOVJ C00000 VJ=25.00");
    let out = written(&text, &[(2, None, vec![[500.0, -1.0, 0.0, 0.0, 0.0, 0.0]])]);
    let expected = text
        .replace("NPOS 2,", "NPOS 3,")
        .replace(",-500,622\r\n", ",-500,622\r\nC00002=500,-1,0,0,0,0\r\n")
        .replace("MOVL C00001", "MOVL C00002 V=50.0\r\nMOVL C00001");
    assert_eq!(out, expected);
}

#[test]
fn line_feeds_stay_line_feeds() {
    let text = two("MOVJ C00000 VJ=25.00\nMOVL C00001 V=50.0").replace('\r', "");
    assert!(!written(&text, &[(2, None, vec![[5.0; 6]])]).contains('\r'));
}

#[test]
fn a_point_of_two_moves_is_cloned_where_they_want_different_things() {
    let text = two("MOVJ C00000 VJ=25.00\nMOVJ C00001 VJ=25.00\nMOVJ C00000 VJ=25.00\nMOVJ C00000 VJ=9.00");
    let out =
        written(&text, &[(1, Some([7.0; 6]), vec![]), (3, Some([-7.0; 6]), vec![]), (4, Some([-7.0; 6]), vec![])]);
    assert!(out.contains("C00000=7,7,7,7,7,7\r\n") && out.contains("C00002=-7,-7,-7,-7,-7,-7\r\n"), "{out}");
    assert!(out.contains("MOVJ C00002 VJ=25.00\r\nMOVJ C00002 VJ=9.00\r\n") && out.contains("NPOS 3,"), "{out}");
}

#[test]
fn a_point_that_another_move_uses_unchanged_keeps_its_line() {
    let text = two("MOVJ C00000 VJ=25.00\nMOVJ C00001 VJ=25.00\nMOVJ C00000 VJ=25.00");
    let out = written(&text, &[(3, Some([7.0; 6]), vec![])]);
    assert!(out.contains("C00000=0,0,0,0,0,0\r\n") && out.contains("C00002=7,7,7,7,7,7\r\n"), "{out}");
    // so does one that an instruction names
    let text = two("REFP 1 C00001\nMOVJ C00001 VJ=25.00");
    assert!(written(&text, &[(1, Some([7.0; 6]), vec![])]).contains("C00001=1000,-2000,300,0,-500,622\r\n"));
}

#[test]
fn new_lines_repeat_the_headers_where_the_type_switches_inside_the_list() {
    let list = "///USER 1\n///TOOL 2\n///POSTYPE PULSE\n///PULSE\nC00000=0,0,0,0,0,0\n///TOOL 0\n///POSTYPE USER\n///RECTAN\n\
                ///RCONF 1,0,0,0,0,0\nC00001=1.000,2.000,3.000,0.0000,0.0000,90.0000\nP00001=1.000,2.000,3.000,0.0000,0.0000,90.0000";
    let text = job("2,0,0,1,0,0", list, "MOVJ C00000 VJ=25.00\nMOVJ C00001 VJ=25.00\nMOVJ C00000 VJ=5.00");
    let out = written(&text, &[(3, Some([9.0; 6]), vec![])]);
    let added = "///TOOL 2\r\n///POSTYPE PULSE\r\n///PULSE\r\nC00002=9,9,9,9,9,9\r\n///TOOL 0\r\n///POSTYPE USER\r\n///RECTAN\r\n\
                 ///RCONF 1,0,0,0,0,0\r\nP00001=";
    assert!(out.contains(added), "{out}");
}

#[test]
fn positions_behind_new_ones_keep_the_user_frame_that_is_in_force() {
    let list = "///TOOL 0\n///USER 1\n///POSTYPE USER\n///RECTAN\n///RCONF 1,0,0,0,0,0\nC00000=1.000,2.000,3.000,0.0000,0.0000,90.0000\n\
                ///USER 2\n///RCONF 0,0,0,0,0,0\nC00001=1.000,2.000,3.000,0.0000,0.0000,90.0000\n\
                ///POSTYPE PULSE\n///PULSE\nC00002=0,0,0,0,0,0\n\
                ///POSTYPE USER\n///RECTAN\nP00001=1.000,2.000,3.000,0.0000,0.0000,90.0000";
    let instructions =
        "MOVL C00000 V=50.0\nMOVL C00001 V=50.0\nMOVJ C00002 VJ=25.00\nMOVL C00000 V=50.0\nMOVL P001 V=50.0";
    let text = job("3,0,0,1,0,0", list, instructions);
    let script = script_of(&Inform, &text, &robot());
    let steps = moves(&script);
    let mut goal = values(&script, steps[3].0);
    goal[0] += 0.0004;
    let mut edits = Edits { digit: vec![1e-6; 6], ..Edits::default() };
    edits.steps.insert(steps[3].0, Edit { goal: Some(goal), ..Edit::default() });
    let out = String::from_utf8(edited(&Inform, text.as_bytes(), &edits, &robot()).unwrap()).unwrap();
    let again = moves(&script_of(&Inform, &out, &robot()));
    let frames = |m: &Move| match &m.goal {
        Goal::Pose(p) => format!("{:?} {:?} {:?}", p.frame, p.tool, p.solution),
        other => format!("{other:?}"),
    };
    assert!(frames(&again[4].1).contains("Named(\"2\")"), "{out}");
    assert!(steps.iter().zip(&again).all(|(a, b)| frames(&a.1) == frames(&b.1)), "{out}");
}

#[test]
fn a_position_without_a_header_that_others_have_is_not_copied() {
    let list = "///POSTYPE USER\n///RECTAN\n///USER 1\n///RCONF 1,0,0,0,0,0\nC00000=1.000,2.000,3.000,0.0000,0.0000,90.0000\n\
                ///TOOL 1\nC00001=1.000,2.000,3.000,0.0000,0.0000,90.0000";
    let text = job("2,0,0,0,0,0", list, "MOVL C00000 V=50.0\nMOVL C00001 V=50.0\nMOVL C00000 V=50.0");
    let script = script_of(&Inform, &text, &robot());
    let steps = moves(&script);
    assert!(steps[0].1.closed.as_ref().is_some_and(|why| why.to_string().contains("no ///TOOL")), "{:?}", steps[0]);
    assert_eq!(steps[1].1.closed, None);
    // one of two moves to a position: it needs a separate line
    let mut edits = Edits { digit: vec![1e-6; 6], ..Edits::default() };
    let goal = values(&script, steps[2].0).iter().map(|v| v + 0.0004).collect();
    edits.steps.insert(steps[2].0, Edit { goal: Some(goal), ..Edit::default() });
    assert!(matches!(edited(&Inform, text.as_bytes(), &edits, &robot()), Err(Error::Refused(_))));
}

#[test]
fn position_variables_that_may_be_set_at_run_time_are_not_known() {
    let list = "///POSTYPE PULSE\n///PULSE\nP00001=1,2,3,4,5,6\nP00002=1,2,3,4,5,6";
    let text = job(
        "0,0,0,2,0,0",
        list,
        "MOVJ P001 VJ=25.00\nSETE P002 (1) D000\nMOVJ P002 VJ=5.00\nMOVJ P[I000] VJ=5.00\nMOVJ LP003 VJ=5.00\nMOVJ P007 VJ=5.00\nSET P[I001] P009",
    );
    let robot = robot();
    let script = script_of(&Inform, &text, &robot);
    let moves = moves(&script);
    assert!(matches!(&moves[0].1.goal, Goal::Opaque(why) if why.to_string().contains("run time")));
    for m in &moves[1..] {
        assert!(matches!(m.1.goal, Goal::Opaque(_)), "{m:?}");
    }
    let refused = edited(&Inform, text.as_bytes(), &edit(&robot, &[(1, Some([9.0; 6]), vec![])]), &robot);
    assert!(matches!(refused, Err(Error::Refused(_))));
}

#[test]
fn a_position_variable_that_nothing_else_sets_is_edited_in_the_list_where_its_moves_agree() {
    let list = "///POSTYPE PULSE\n///PULSE\nC00000=0,0,0,0,0,0\nP00001=1,2,3,4,5,6\nP00002=1,2,3,4,5,6";
    let lines = "MOVJ C00000 VJ=9.00\nMOVJ P001 VJ=25.00\nMOVJ P002 VJ=5.00\nMOVJ C00000 VJ=9.00\nMOVJ P002 VJ=5.00";
    let text = job("1,0,0,2,0,0", list, lines);
    let robot = robot();
    let script = script_of(&Inform, &text, &robot);
    let steps = moves(&script);
    assert!(steps.iter().all(|m| m.1.fixed.is_none()) && steps[1].1.closed.is_some(), "{steps:?}");
    assert!(script.notes.iter().any(|n| n.text.contains("position variables are taken")), "{:?}", script.notes);
    let wish = |list: &[(usize, [f64; 6])]| {
        let list: Vec<_> = list.iter().map(|w| (w.0, Some(w.1), vec![])).collect();
        edit(&robot, &list)
    };
    // one move, and two that agree
    let (p1, p2) = ([9.0, 2.0, 3.0, 4.0, 5.0, 6.0], [1.0, 2.0, 7.0, 4.0, 5.0, 6.0]);
    let agree = wish(&[(2, p1), (3, p2), (5, p2)]);
    let out = String::from_utf8(edited(&Inform, text.as_bytes(), &agree, &robot).unwrap()).unwrap();
    let expected = text.replace("P00001=1,2,3", "P00001=9,2,3").replace("P00002=1,2,3", "P00002=1,2,7");
    assert_eq!(out, expected);
    // two that do not: none of them, and no number of another variable
    let doc = harness::parse(&Inform, text.as_bytes(), &robot).unwrap();
    for differ in [wish(&[(2, p1), (3, p2)]), wish(&[(2, p1), (3, p2), (5, p1)])] {
        let left: Vec<usize> = doc.unwritable(&differ).into_iter().map(|u| u.0).collect();
        assert!(!left.is_empty() && left.iter().all(|k| [3, 5].contains(k)), "{left:?}");
        assert!(matches!(doc.patches(&differ), Err(Error::Refused(_))));
    }
}
