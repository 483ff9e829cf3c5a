//! Lines after which another control, or another way to them, may take words otherwise: nothing after them is edited as if it were
//! certain.

use super::super::Gcode;
use super::{goals, opaque, robot};
use crate::script::harness::script_of;
use crate::script::{Break, StepKind};

const HEAD: &str = "G21 G90 G17 G40 G54\nG0 X10 Y10 Z-5\nG1 X50 F900\n";
const MOVES: &str = "G1 X20 Y10 Z-5\nG1 X60\nG1 X30\n";

#[test]
fn what_stands_behind_a_condition_besides_a_jump_or_an_assignment_leaves_the_rest() {
    for line in [
        "IF [#5 EQ 1] THEN G91",
        "IF [#5 EQ 1] G91",
        "WHILE [#2 LT 3] DO1 G91",
        "O100 IF [#1] G91",
        "o<if> if [#1] G68 R30",
        "IF [#5 EQ 1] THEN G66 P9",
        "IF [#5 EQ 1] THEN M98 P2000",
        "GOTO 10 G91",
        "M117 #1=45",
    ] {
        let text = format!("{HEAD}{line}\n{MOVES}");
        assert_eq!(goals(&text)[2..], [None, None, None], "{line}");
        assert!(opaque(&text).iter().all(|why| why.contains("not followed")), "{line}");
    }
    for line in ["IF [#5 EQ 1] GOTO 10", "IF[#5EQ1]THEN #1=2", "O100 IF [[#1] EQ 1]", "WHILE [#2 LT 3] DO 1 (G91)"] {
        assert!(goals(&format!("{HEAD}{line}\n{MOVES}"))[2].is_some(), "{line}");
    }
    // a subprogram in the text is as uncertain as the line in it
    let sub = format!("{HEAD}M98 P2\n{MOVES}M30\nO2\nIF [#1 EQ 1] THEN G91\nM99\n");
    assert_eq!(goals(&sub)[2..5], [None, None, None]);
}

#[test]
fn a_tool_or_an_offset_moves_the_frame_unless_another_word_takes_it() {
    let breaks = |text: &str| {
        let script = script_of(&Gcode, text, &robot());
        // but for that of G54
        script.steps.iter().filter(|s| matches!(s.kind, StepKind::Break(Break::Frame))).count() - 1
    };
    for (line, frames) in [("T0202", 1), ("D2", 1), ("H2", 1), ("M104 T1 S200", 0), ("G4 P1", 0)] {
        assert_eq!(breaks(&format!("{HEAD}{line}\n{MOVES}")), frames, "{line}");
    }
    // where M6 changes tools, T chooses the next one
    assert_eq!(breaks(&format!("{HEAD}M6 T1\n{MOVES}T2\n{MOVES}")), 0);
    assert_eq!(breaks(&format!("{HEAD}G41 D1 X50\n{MOVES}")), 0);
}

#[test]
fn a_block_that_may_be_switched_off_switches_nothing_off() {
    let text = format!("{HEAD}G66 P9\nG1 X30\n/G67\nG21 G90 G17 G40 G54\n{MOVES}");
    assert!(opaque(&text).iter().all(|why| why.contains("G66")) && opaque(&text).len() == 4, "{:?}", opaque(&text));
}

#[test]
fn centres_of_arcs_are_not_certain_where_one_way_there_sets_g90_1() {
    let text = "G21 G90 G17 G40 G54\nIF [#1 EQ 1] GOTO 10\nG90.1\nN10 G1 X110 Y100 Z-5 F900\nG3 X110 Y120 I105 J110\nG1 X140\n";
    assert!(opaque(text).iter().all(|why| why.contains("G90.1")) && opaque(text).len() == 3, "{:?}", opaque(text));
}

#[test]
fn a_turning_cycle_of_a_lathe_is_no_distance_mode() {
    let text = "G21 G40\nG0 X140 Z-2\nG90 X130 Z-20 F200\nX128\nX126 Z-25\nG0 X160 Z-1\n";
    assert!(goals(text).iter().all(Option::is_none));
    // a mill has a Y, or names its motion
    assert!(goals("G21\nG0 X1 Y1 Z1\nG90 X2 Y1 Z1\n")[1].is_some());
    assert!(goals("G21\nG90 G0 X1 Z1\n")[0].is_some());
}
