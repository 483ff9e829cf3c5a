//! Numbers with and without a point in one program.

use super::*;
use crate::gcode::Reason;

const START: &str = "G21 G90 G17 G94 G40 G54\nG0 X0. Y0. Z0.\nX10. Y20. Z-1.\nX5.\nX7.\n";

/// Moves that stay since their numbers say how others are to be read.
fn markers(text: &str) -> Vec<usize> {
    let script = script_of(&Gcode, text, &robot());
    let marks = |m: &crate::script::Move| m.fixed == Some(Reason::Mixed.into());
    moves(&script).iter().enumerate().filter(|(_, m)| marks(&m.1)).map(|m| m.0).collect()
}

#[test]
fn whole_numbers_that_are_no_places_of_moves_do_not_count_beside_numbers_with_a_point() {
    for line in [
        "G4 X1",
        "G4 P500",
        "G65 P9810 A1",
        "G65 P9810 Z-10 F50",
        "G66 P100 A1",
        "G81 X5. Z-3. R2",
        "G10 L2 P1 X5",
        "T1 M6",
    ] {
        assert!(markers(&format!("{START}{line}\n")).is_empty(), "{line}");
    }
    for line in ["X8", "G81 X5 Z-3. R2.", "G3 X9. I5", "G91 X8"] {
        assert_eq!(markers(&format!("{START}{line}\n")), [0], "{line}");
    }
}

#[test]
fn numbers_with_a_point_are_changed_beside_whole_ones_and_the_first_says_how_those_are_read() {
    let text = format!("{START}X8 Y2.\nX12. Y3.\nX6.\n");
    let out = written(&text, &[(2, Some([5.02, 20.0, -1.0]), vec![]), (6, Some([6.02, 3.0, -1.0]), vec![])]);
    assert_eq!(out, text.replace("X5.", "X5.02").replace("X6.", "X6.02"));
    // the whole number is read as before
    assert_eq!(opaque(&out), opaque(&text));
    assert_eq!(opaque(&out), ["a number without a point where others end in one: it may count increments"]);
    // the first keeps its words, also where an arc or a relative word would take up a change before it
    let refused = attempt(&text, &[(0, Some([0.02, 0.0, 0.0]), vec![])]);
    assert!(matches!(refused, Err(Error::Refused(_))));
    for line in ["G2 X9. I2.", "G91 X2."] {
        let text = format!("{HEAD}G1 X5.5 Y2.5 F9\nX7.0\n{line}\nG90\nX9.0\nX8\n");
        let refused = attempt(&text, &[(2, Some([7.02, 2.5, 0.0]), vec![])]);
        assert!(matches!(refused, Err(Error::Refused(_))), "{line}");
    }
}

#[test]
fn nothing_counts_from_a_number_that_may_count_increments() {
    let text = format!("{START}X8\nY2.\nG91 X1.\nG90 Y3. X7.\nX8\nG2 X9. Y3. I1.\nX8 G91\nX1.\nZ-2.\n");
    let found = goals(&text);
    assert!(found[4].is_none());
    // X alone has no place after it, until a word gives it one
    let y = found[5].as_ref().unwrap();
    assert!(y[0].is_nan() && y[1] == 2.0, "{y:?}");
    assert_eq!(
        found.iter().skip(6).map(Option::is_some).collect::<Vec<_>>(),
        [false, true, false, false, false, false, false]
    );
    let script = script_of(&Gcode, &text, &robot());
    let moved = |k: usize| moves(&script)[k].1.moves_alone.map(|axes| axes.axes().collect::<Vec<_>>());
    // an absolute one moves its own axis, a relative one leads to no place at all
    assert_eq!((moved(4), moved(10)), (Some(vec![0]), None));
    // an origin by it is none that is known
    let shifted = format!("{START}G92 X8\nX9.\n");
    let script = script_of(&Gcode, &shifted, &robot());
    assert!(moves(&script)[4].1.displaced.has(0));
}
