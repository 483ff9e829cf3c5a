//! Parts of the text that are called by the number of a block, and programs that are not in it.

use super::*;

/// Whether each move must end where it always did.
fn fixed_of(text: &str, robot: &crate::axes::Axes) -> Vec<bool> {
    moves(&script_of(&Gcode, text, robot)).iter().map(|m| m.1.fixed.is_some()).collect()
}

fn fixed(text: &str) -> Vec<bool> {
    fixed_of(text, &robot())
}

const START: &str = "G21 G90 G17 G94 G40 G54\nG0 X0.0 Y0.0 Z0.0\nX10.0 Y20.0 Z-1.0\nY30.0\nX5.0\n";
const AGAIN: &str = "G90 G21 G17 G40 G54 G94 G0 X5.0 Y3.0 Z-3.0\n";

#[test]
fn a_call_of_a_block_by_its_number_is_a_way_to_it() {
    for call in ["M97 P100 L2", "M98 H100 L2", "M98 Q100", "M96 P100 Q8", "M97 P#1"] {
        // X counts from the move before the call
        let sub = |first: &str| format!("{START}{call}\n{AGAIN}M30\nN100 {first}\nG90\nM99\n");
        assert!(fixed(&sub("G91 G1 X10.0 F300"))[3], "{call}");
        assert!(fixed(&sub("#1=#5041"))[3], "{call}");
        let found = fixed(&sub("G90 G21 G17 G40 G54 G1 X10.0 Y3.0 Z-3.0 F300"));
        assert!(!found[3], "{call}: {found:?}");
        // it is a label, and others are none
        let jumps = |number: u32| {
            let text = format!("{START}{call}\n{AGAIN}M30\nN{number} {AGAIN}M99\n");
            let script = script_of(&Gcode, &text, &robot());
            script.steps.iter().filter(|s| matches!(s.kind, StepKind::Break(Break::Jump))).count()
        };
        assert_eq!(jumps(100), 2, "{call}");
        assert_eq!(jumps(200), if call.contains('#') { 2 } else { 1 }, "{call}");
    }
    // also where lines of one form follow each other
    let lines: String = (98..103).map(|n| format!("N{n} X{n}.5\n")).collect();
    let text = format!("{START}M97 P101\n{AGAIN}{lines}M99\n");
    let script = script_of(&Gcode, &text, &robot());
    assert!(script.steps.iter().any(|s| matches!(s.kind, StepKind::Break(Break::Jump)) && s.at.line == 11));
}

#[test]
fn a_called_part_of_the_text_ends_where_relative_words_after_the_call_count_from() {
    // O1 makes the codes of the text not all that there are
    let text = format!("{START}G65 P1\n{AGAIN}M98 P2\nG91 G1 X1.0\nM30\nO2\n{AGAIN}X7.0\nX6.0\nM99\n");
    assert_eq!(fixed(&text)[6..], [false, false, true]);
}

#[test]
fn before_a_call_of_a_program_that_is_not_in_the_text_no_offset_stays() {
    let calls = [
        "M98 P9100",
        "M98 P29100",
        "M98 P9100 Q5",
        "M98 P#1",
        "M198 P9100",
        "G65 P9100",
        "G66 P9100",
        "L9100 P2",
        "POCKET3(1)",
        "o<hole> call",
    ];
    for call in calls {
        assert_eq!(fixed(&format!("{START}{call}\n{AGAIN}")), [false, false, false, true, false], "{call}");
    }
    // the axes without a word too
    let text = format!("{START}M98 P9100\n{AGAIN}");
    let script = script_of(&Gcode, &text, &robot());
    assert_eq!(values(&script, moves(&script)[3].0).len(), 3);
    assert!(values(&script, moves(&script)[3].0).iter().all(|v| v.is_finite()));
    // what is in the text is read there
    for (call, name) in
        [("M98 P9100", "O9100"), ("M98 P29100", "O9100"), ("G65 P9100", "O9100"), ("o<hole> call", "o<hole> sub")]
    {
        let text = format!("{START}{call}\n{AGAIN}M30\n{name}\n{AGAIN}M99\n");
        assert!(!fixed(&text)[3], "{call}");
    }
    for line in ["MSG(\"a\")", "M99", "M71"] {
        assert!(!fixed(&format!("{START}{line}\n{AGAIN}"))[3], "{line}");
    }
}

#[test]
fn a_call_of_what_moves_nothing_by_what_the_user_says_keeps_the_offset() {
    let mut robot = robot();
    robot.no_motion = crate::no_motion::NoMotion::of(["O9100", "o9", "L17", "hole", "GRIP_2"]);
    for (call, declared) in [
        ("M98 P9100", true),
        ("G65 P9100 A1.0", true),
        ("M98 P0009", true),
        ("M98 P9101", false),
        ("L17", true),
        ("L18", false),
        ("o<hole> call", true),
        ("GRIP_2(3)", true),
        ("GRIP_3", false),
    ] {
        assert_eq!(fixed_of(&format!("{START}{call}\n{AGAIN}"), &robot)[3], !declared, "{call}");
    }
}

#[test]
fn before_a_block_about_where_the_machine_stands_no_offset_stays() {
    for word in [
        "G12 I5.0 D1 F300",
        "G13 Z-2.0 I2.5 D1 F10",
        "G70 I5.0 J0.0 L4",
        "G68 R30.0",
        "G51 P2.0",
        "G51.1 X0.0",
        "G31 Z-5.0 F50",
        "G38.2 Z-5.0 F50",
        "G150 P5",
        "G#1",
    ] {
        assert_eq!(fixed(&format!("{START}{word}\n{AGAIN}"))[..4], [false, false, false, true], "{word}");
        // where an axis has lost its place before it
        let lost = format!("{START}M6 T1\n{word}\n{AGAIN}");
        assert!(fixed(&lost)[3], "{word}");
    }
    // cycles of a lathe start where it stands
    let mut lathe = robot();
    (lathe.control.diameter, lathe.control.absolute) = (Some(true), Some(true));
    for cycle in ["G92 X38.0 Z-9.0 F1.5", "G76 P10 Q0.5 R0.1", "G71 U2.0 R1.0"] {
        let text = format!("G21 G18\nG0 X50.0 Z-5.0\nX40.0\n{cycle}\n");
        assert!(fixed_of(&text, &lathe)[1], "{cycle}");
    }
    for word in ["G99 G81 X5.0 Z-3.0 R1.0", "G4 P1", "G64"] {
        assert!(!fixed(&format!("{START}{word}\n{AGAIN}"))[3], "{word}");
    }
}
