//! Who reads or stores where the machine stands.

use super::*;

/// Whether each move must end where it always did.
fn fixed(text: &str) -> Vec<bool> {
    moves(&script_of(&Gcode, text, &robot())).iter().map(|m| m.1.fixed.is_some()).collect()
}

fn breaks_of(text: &str, kind: Break) -> usize {
    let is = |s: &&crate::script::Step| matches!(s.kind, StepKind::Break(b) if b == kind);
    script_of(&Gcode, text, &robot()).steps.iter().filter(is).count()
}

const START: &str = "G21 G90 G17 G94 G40\nG0 X0.0 Y0.0 Z0.0\nG1 X10.0 F100\nX5.0\n";

#[test]
fn the_move_before_a_stored_place_stays() {
    for word in ["G28.1", "G30.1", "M428", "G60", "G92 X5.0", "G10 L20 P1 X0"] {
        assert_eq!(fixed(&format!("{START}{word}\nX30.0\n"))[..3], [false, false, true], "{word}");
        // where a label stands between, any move before a label, jump, loop or call
        let text = format!("{START}N10\n{word}\nG0 X30.0 Y0.0 Z0.0\nG1 X20.0\nIF [#1 EQ 2] GOTO 10\n");
        assert!(fixed(&text)[2], "{word}");
    }
    // they end what is known
    let breaks = |text: &str| breaks_of(text, Break::Frame);
    assert_eq!(breaks(&format!("{START}G28.1\nX30.0\n")), 1);
    // with axes some controls go there
    let found = opaque(&format!("{START}G30.1 X5.0\nG1 X30.0 Y1.0 Z0.0\n"));
    assert!(found[0].contains("G30.1 goes to a reference point"), "{found:?}");
}

#[test]
fn the_move_before_a_condition_or_a_word_that_reads_the_place_stays() {
    for line in [
        "IF [#5041 GT 5] GOTO 10",
        "IF [#5021 EQ 5.0] THEN #1=2",
        "WHILE [#5021 LT 9] DO1",
        "o1 if [#<_x> gt 5]",
        "o1 while [#5420 gt 5]",
        "G1 X[#5041+20]",
        "G65 P9000 A#5041",
        "o<sub> call [#<_x>]",
        "M98 P#5041",
        "#1=#5041",
    ] {
        assert!(fixed(&format!("{START}{line}\n"))[2], "{line}");
    }
    for line in ["IF [#500 GT 5] GOTO 10", "IF [#5 GT 5] GOTO 10 (#5041)", "#1=#501", "#500=#500+1"] {
        assert!(!fixed(&format!("{START}{line}\n"))[2], "{line}");
    }
}

#[test]
fn a_subprogram_that_reads_the_place_keeps_the_moves_before_its_calls() {
    for read in ["#1=#5041", "G91 G1 X1.0", "IF [#5041 GT 3] GOTO 20"] {
        for more in ["", "G65 P9001\n"] {
            let text =
                format!("O1\n{START}M98 P2\nG90 G21 G17 G40 G54 G0 X30.0 Y0.0 Z0.0\n{more}M30\nO2\n{read}\nM99\n");
            assert!(fixed(&text)[2], "{read} {more}");
        }
    }
    let text = format!("O1\n{START}M98 P2\nG0 X30.0 Y0.0 Z0.0\nM30\nO2\n#1=#501\nM99\n");
    assert!(!fixed(&text)[2]);
}

#[test]
fn the_start_of_a_program_that_nothing_calls_counts_from_no_move_of_it() {
    let text = |name: &str, first: &str| {
        let main = format!("O1\n{START}M98 P2\nG0 X30.0 Y0.0 Z0.0\nM30\n");
        format!("{main}O5\nM99\n{name}\n{first}\nG1 X20.0 Y0.0 Z0.0 F100\nM99\nO2\nM99\n")
    };
    for first in ["G92 X0.0", "#1=#5041"] {
        assert!(fixed(&text("O2", first))[2] && !fixed(&text("O3", first))[2], "{first}");
        let head = format!("O1\n{first}\n{START}M98 P2\nG0 X30.0 Y0.0 Z0.0\nM30\nO2\nM99\n");
        assert!(!fixed(&head)[2], "{first}");
    }
}

#[test]
fn a_loop_that_reads_the_place_at_its_start_keeps_the_move_before_its_end() {
    for (open, close) in [
        ("WHILE [#5021 LT 9] DO1", "END1"),
        ("WHILE [#1 LT 9] DO1\n#2=#5021", "END1"),
        ("o1 while [#<_x> lt 9]", "o1 endwhile"),
        ("o1 repeat [3]\n#2=#<_x>", "o1 endrepeat"),
        ("N10 #2=#5041", "IF [#1 LT 3] GOTO 10"),
        ("N10 IF [#5041 LT 3] GOTO 20", "GOTO 10"),
    ] {
        let text = format!("{START}{open}\nG1 X20.0 Y0.0 Z0.0\nX15.0\n{close}\nX1.0\n");
        let found = fixed(&text);
        assert!(found[2] && found[4], "{open}: {found:?}");
        assert!(!found[3], "{open}: {found:?}");
    }
    // a condition in the middle of it reads the place above it
    let text = format!("{START}WHILE [#1 LT 9] DO1\nG1 X20.0 Y0.0 Z0.0\nIF [#5041 LT 3] THEN #2=1\nG1 X15.0\nEND1\n");
    assert_eq!(fixed(&text), [false, false, false, true, false]);
}

#[test]
fn a_program_that_repeats_itself_comes_to_its_start_from_its_end() {
    let text = |end: &str| format!("{START}X3.0\n{end}\n");
    let jumps = |text: &str| breaks_of(text, Break::Jump);
    // the side of the first move is not known
    assert_eq!([jumps(&text("M99")), jumps(&text("M30")), jumps("M30\nO2\nM99\n")], [1, 1, 1]);
    // relative words at its start count from its end
    let relative = |end: &str| format!("G21 G91 G17\nG1 X1.0 F100\nG90 X5.0 Y0.0 Z0.0\nX3.0\n{end}\n");
    assert_eq!([fixed(&relative("M99"))[2], fixed(&relative("M30"))[2]], [true, false]);
}

#[test]
fn a_g10_of_a_printer_with_axes_is_the_offset_of_a_tool() {
    let text = |line: &str| format!("{PRINTER}G1 X30 Z-1\n{line}\nG1 X20 Y20 Z-1\nX60\n");
    let breaks = |line: &str| breaks_of(&text(line), Break::Frame);
    assert_eq!(breaks("G10 P0 X-25"), 1);
    assert!(opaque(&text("G10 P0 X-25")).is_empty());
    let displaced = |line: &str| moves(&script_of(&Gcode, &text(line), &robot())).last().unwrap().1.displaced.has(0);
    assert!(displaced("G10 P0 X-25") && !displaced("G10"));
    // retractions and temperatures
    for line in ["G10", "G11", "G10 S1", "G10 P0 S200 R140"] {
        assert_eq!(breaks(line), 0, "{line}");
    }
}
