//! Relative words, and positions that count from others.

use super::*;

#[test]
fn an_axis_that_is_not_named_stays_with_its_offset_until_it_is_named() {
    let text = format!("{HEAD}G1 Y10.00 F100\nX10\nX20\nY3.00\n");
    let out = written(
        &text,
        &[
            (1, Some([0.0, 10.05, 0.0]), vec![]),
            (2, Some([10.0, 10.05, 0.0]), vec![]),
            (3, Some([20.0, 10.05, 0.0]), vec![]),
        ],
    );
    assert_eq!(out, text.replace("Y10.00", "Y10.05"));
    // an offset that changes where the axis has no word adds the word
    let out = written(&text, &[(1, Some([0.0, 10.05, 0.0]), vec![]), (2, Some([10.0, 10.02, 0.0]), vec![])]);
    assert_eq!(out, text.replace("Y10.00", "Y10.05").replace("X10\n", "X10 Y10.02\n"));
}

#[test]
fn relative_words_behind_a_change_take_it_back() {
    let text = format!("{HEAD}G91\nG1 X10 F100\nX-4\nX1\nG90\nX0\n");
    let out = written(&text, &[(1, Some([10.05, 0.0, 0.0]), vec![])]);
    assert_eq!(out, text.replace("G1 X10 ", "G1 X10.05 ").replace("X-4\n", "X-4.05\n"));
    // a change that stays changes one word; an axis without a word gets one
    let out = written(
        &text,
        &[
            (1, Some([10.05, 0.0, 0.0]), vec![]),
            (2, Some([6.05, 0.02, 0.0]), vec![]),
            (3, Some([7.05, 0.0, 0.0]), vec![]),
        ],
    );
    assert_eq!(
        out,
        text.replace("G1 X10 ", "G1 X10.05 ").replace("X-4\n", "X-4 Y0.02\n").replace("X1\n", "X1 Y-0.02\n")
    );
    // a new point takes its part of the way
    let out = written(&text, &[(2, None, vec![point([9.0, 0.0, 0.0], 0.25, false)])]);
    assert_eq!(out, text.replace("X-4\n", "X-1.00\nX-3.00\n"));
}

#[test]
fn rounding_of_relative_words_does_not_add_up() {
    let text = format!("{HEAD}G91\nG1 F100 X1\n{}G90\nX0\n", "X1\n".repeat(30));
    let list: Vec<_> = (1..31).map(|k| (k, Some([k as f64 + 0.000_333 * k as f64, 0.0, 0.0]), vec![])).collect();
    let robot = robot();
    let script = script_of(&Gcode, &text, &robot);
    let mut edits = edits(&script, &list);
    edits.digit = vec![1e-6; 3];
    // the comparison is made at every block, to half a digit
    let out = String::from_utf8(edited(&Gcode, text.as_bytes(), &edits, &robot).unwrap()).unwrap();
    assert!(out.contains("X1.001\n") && out.contains("G90\nX0\n"), "{out}");
}

#[test]
fn the_last_relative_move_before_the_position_is_lost_is_fixed() {
    for (after, fixed) in [
        ("M98 P100\n", true),
        ("", true),
        ("G92 X0\n", true),
        ("#1=2\nX#2\n", true),
        ("G90\nG1 X0\n", false),
        ("G90\nM98 P1\n", true),
        ("G28 X0\n", true),
    ] {
        let script = script_of(&Gcode, &format!("{HEAD}G91\nG1 X10 F100\nX-4\n{after}"), &robot());
        let moves = moves(&script);
        assert!(moves[1].1.fixed.is_none() && moves[2].1.fixed.is_some() == fixed, "{after}: {:?}", moves[2]);
    }
    // a way home in relative words is none of these
    let script = script_of(&Gcode, &format!("{HEAD}G1 X10 F100\nG91 G28 Z0\n"), &robot());
    assert!(moves(&script)[1].1.fixed.is_none());
    // even before G92 in absolute words, as the change would stay in the frame
    let script = script_of(&Gcode, &format!("{HEAD}G1 X10 F100\nG92 X0\nX5\n"), &robot());
    assert!(moves(&script)[1].1.fixed.is_some());
    let text = format!("{HEAD}G91\nG1 X10 F100\nX-4\nM98 P100\n");
    assert!(matches!(attempt(&text, &[(2, Some([6.1, 0.0, 0.0]), vec![])]), Err(Error::Refused(_))));
    let out = written(&text, &[(1, Some([10.1, 0.0, 0.0]), vec![])]);
    assert!(out.contains("X10.10 F100\nX-4.10\n"), "{out}");
}

#[test]
fn a_move_from_which_relative_words_count_later_on_is_fixed() {
    // by axis: Y is relative while its place is not known, X and Z are not
    let tail = |loses: &str, words: &str| format!("{HEAD}G1 X17 Y12 F100\n{loses}\nG90 G1 X5\n{words}\n");
    for loses in ["M6 T1", "M98 P100", "G20", "G55"] {
        for (words, fixed) in
            [("G91 G1 Y-3", true), ("G1 Y-3", false), ("G1 Y3\nG91 Y-3", false), ("G91 G28 Y0", false)]
        {
            let script = script_of(&Gcode, &tail(loses, words), &robot());
            // a program that is not in the text may count from there
            let fixed = fixed || loses == "M98 P100";
            assert_eq!(moves(&script)[1].1.fixed.is_some(), fixed, "{loses} {words}: {:?}", moves(&script)[1]);
        }
    }
    // twice lost, once known between: from the move after which it was lost last
    let text = format!("{HEAD}G1 X17 Y12 F100\nM6 T1\nG1 X5 Y5\nM6 T2\nG1 X4\nG91 G1 Y-3\n");
    let script = script_of(&Gcode, &text, &robot());
    let fixed: Vec<bool> = moves(&script).iter().map(|m| m.1.fixed.is_some()).collect();
    assert_eq!(fixed[..3], [false, false, true], "{fixed:?}");
    // lost before a label or a loop, in which relative words count
    for loses in ["M6 T2", "M98 P100", "G20"] {
        for words in ["N10 G91 G1 Y-3\nY3\nIF [#1 LT 3] GOTO 10", "WHILE [#1 LT 3] DO1\nG91 G1 Y-3\nEND1"] {
            let script = script_of(&Gcode, &format!("{HEAD}G1 X17 Y12 F100\n{loses}\n{words}\n"), &robot());
            assert!(moves(&script)[1].1.fixed.is_some(), "{loses} {words}: {:?}", moves(&script)[1]);
        }
    }
    // a part that is called from several places of the text
    let text = format!("{HEAD}G1 X17 Y12 F100\nM98 P100\nG90 G1 X5 Y2\nM98 P100\nM30\nO100\nG91 G1 X3\nG90\nM99\n");
    let script = script_of(&Gcode, &text, &robot());
    let fixed: Vec<bool> = moves(&script).iter().map(|m| m.1.fixed.is_some()).collect();
    assert!(fixed[1] && fixed[2], "{fixed:?}");
}

#[test]
fn a_block_with_absolute_and_relative_words_stays_and_loses_its_axes() {
    const WHY: &str = "G90 and G91 in one block: which of its words are relative depends on the control";
    for block in ["G91 Z-2 G90 X20", "G90 Z30 G91 X3", "G90 G91 G1 X5 Z1"] {
        let text = format!("{HEAD}G1 X10 Y5 Z50 F300\n{block}\nG90 Y8\nX5\nZ1\n");
        assert_eq!(opaque(&text), [WHY], "{block}");
        let script = script_of(&Gcode, &text, &robot());
        let list = moves(&script);
        // its relative words count from there, in all axes
        assert!(list[1].1.fixed.is_some() && list[3].1.fixed.is_none(), "{block}");
        let lost: Vec<usize> = list[2].1.moves_alone.expect("a straight move moves its own axes").axes().collect();
        assert_eq!(lost, [0, 2], "{block}");
        // Y is known, X and Z are not before they are named
        assert_eq!(goals(&text)[3].as_ref().map(|g| g[1]), Some(8.0), "{block}");
    }
    // a relative word after it counts from a place that is not known
    let text = format!("{HEAD}G1 X10 Z50 F300\nG90 X20 G91 Z-2\nZ-1\nX1\n");
    const LOST: &str = "a relative word, and the position before it is not known";
    assert_eq!(opaque(&text), [WHY, LOST, LOST]);
    // an arc may end anywhere
    let text = format!("{HEAD}G1 X10 Y0 F300\nG91 G2 X10 G90 Y0 I5 J0\nG1 X5\n");
    assert_eq!(opaque(&text), [WHY]);
}
