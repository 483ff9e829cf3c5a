//! Arcs that stay, and the moves from which they may start.

use super::*;

/// Of each move whether it must end where it always did because an arc starts there.
fn kept(text: &str) -> Vec<bool> {
    let starts = |m: &(usize, crate::script::Move)| {
        m.1.fixed.as_ref().is_some_and(|why| why.to_string().contains("arc that stays"))
    };
    moves(&script_of(&Gcode, text, &robot())).iter().map(starts).collect()
}

const START: &str = "G21 G90 G17 G94 G40\nG0 X0.0 Y0.0 Z5.0\nG1 Y20.0 Z0.0 F100\nX15.0\n";

#[test]
fn the_move_before_an_arc_that_stays_ends_where_it_always_did() {
    for between in [
        "M123",
        "M88",
        "M6",
        "T2",
        "%",
        "G55",
        "N10 G4 P1.0\nIF [#1 EQ 1] GOTO 10",
        "IF [#500 EQ 1] THEN #1=2",
        "WHILE [#1 LT 3] DO1\n#1=#1+1\nEND1",
        "o100 if [#1 gt 2]\no100 endif",
        "o100 repeat [3]\no100 endrepeat",
        "G1 A90.0",
        "/G1 Z-1.0",
        "/G1 X15.0 Y20.0",
        "G41 D1 G1 X15.0",
    ] {
        for arc in ["G3 I-5.0", "G3 X10.0 Y25.0 I-5.0 J0.0", "G2 X10.0 Y25.0 R5.0"] {
            let text = format!("{START}{between}\n{arc}\nG1 X0.0\n");
            assert_eq!(kept(&text)[..3], [false, false, true], "{between} {arc}");
        }
    }
    // by itself
    for arc in ["/G3 I-5.0", "G41 D1 G3 I-5.0", "G3 I[#500]", "G3 X15.0 A9.0 I-5.0"] {
        assert!(kept(&format!("{START}{arc}\nG1 X0.0\n"))[2], "{arc}");
    }
    // a straight move starts anywhere
    for between in ["M123", "T2", "/G1 Z-1.0", "G41 D1 G1 X15.0"] {
        assert!(!kept(&format!("{START}{between}\nG1 X0.0 Y9.0\n")).contains(&true), "{between}");
    }
    // an arc that is known is edited itself
    assert!(!kept(&format!("{START}G3 I-5.0\nG1 X0.0\n")).contains(&true));
}

#[test]
fn the_move_before_an_arc_that_stays_gets_a_word_for_each_axis_of_its_plane() {
    let text = format!("{START}M123\nG3 X10.0 Y25.0 I-5.0 J0.0\n");
    let out = written(&text, &[(1, Some([0.0, 20.03, 0.0]), vec![])]);
    assert!(out.contains("Y20.03 Z0.0 F100\nX15.0 Y20.00\nM123\nG3 X10.0 Y25.0 I-5.0 J0.0\n"), "{out}");
}

#[test]
fn a_lead_in_that_names_both_axes_leaves_the_move_before_it_alone() {
    let text = |lead: &str| format!("{START}G41 D1 G1 {lead}\nG3 X10.0 Y25.0 I-5.0 J0.0\n");
    assert!(!kept(&text("X15.0 Y20.0")).contains(&true));
    // an arc in another plane starts elsewhere, too
    assert!(kept(&text("X15.0 Y20.0\nG18"))[2]);
    // an operator may switch it off
    assert!(kept(&format!("{START}G41 D1\n/G1 X15.0 Y20.0\nG3 X10.0 Y25.0 I-5.0 J0.0\n"))[2]);
    // and a place that is known in between has its offset again
    let again = "X15.0 Y20.0\nG40\nG1 X16.0 Y21.0\nX17.0\nG41 G1 X18.0";
    let found = kept(&text(again));
    assert_eq!(found[3..7], [false, false, true, false], "{found:?}");
}

#[test]
fn a_subprogram_that_begins_with_an_arc_keeps_the_moves_before_its_calls() {
    let text = |first: &str| {
        format!("O1\n{START}M98 P1000\nG1 X14.0 Y20.0\nX15.0\nM98 P1000\nM30\nO1000\n{first}\nG1 X9.0 Y20.0\nM99\n")
    };
    let found = kept(&text("G3 X10.0 Y25.0 I-5.0 J0.0"));
    assert_eq!(found[..5], [false, false, true, false, true], "{found:?}");
    assert!(!kept(&text("G1 X10.0 Y25.0")).contains(&true));
    // the motion before the call may be that of an arc
    for first in ["X10.0 Y25.0 I-5.0 J0.0", "I-5.0"] {
        assert!(kept(&text(first))[2], "{first}");
    }
}
