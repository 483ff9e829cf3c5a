//! Goals at which the machine certainly stops.

use super::*;

/// By move: it stops by the mode of the feed, and by a wait after it.
fn stops(text: &str, words: &[&str]) -> Vec<(bool, bool)> {
    let mut axes = robot();
    axes.control = crate::gcode::Control::of_words(words.iter().copied()).unwrap().or(axes.control);
    let script = script_of(&Gcode, text, &axes);
    moves(&script).iter().map(|(_, m)| (m.blend_m == Some(0.0), !m.waits.is_empty())).collect()
}

#[test]
fn a_move_before_a_dwell_stops_at_its_goal() {
    let last = |after: &str| stops(&format!("{HEAD}G1 Z-5 F100\n{after}\nG0 Z5\n"), &[])[1];
    for dwell in ["G4 P0.5", "N7 G04 P500", "G4 X1.5", "G4 F2", "(at the bottom)\n\nG4 P0.5"] {
        assert_eq!(last(dwell), (false, true), "{dwell}");
    }
    // no time, one that is not known, one that may be switched off, one beside other words, and words that wait on some controls alone
    for other in ["G4 P0", "G4", "G4 P#1", "/G4 P0.5", "G4 P0.5 M8", "G4 P0.5 X5", "M8", "M3", "M5", "M6", "M0", "M1"] {
        assert_eq!(last(other), (false, false), "{other}");
    }
    // the axes that move there, whether the block names others or not
    let script = script_of(&Gcode, &format!("{HEAD}G1 X0 Y3 Z-5 F100\nG4 P0.5\n"), &robot());
    assert_eq!(moves(&script)[1].1.waits.axes().collect::<Vec<_>>(), [1, 2]);
    // what stands between may begin before the move ends
    assert!(!last("M5\nG4 P0.5").1);
    // a point on an arc is written as a piece
    assert!(!stops(&format!("{HEAD}G2 X10 Y0 I5 J0 F100\nG4 P0.5\n"), &[])[1].1);
}

#[test]
fn a_point_before_such_a_goal_waits_too_if_its_corner_must_not_be_cut() {
    let text = format!("{HEAD}G1 Z-5 F100\nN7  G04 P0.5 (dwell)\nG0 Z5\n");
    let point = |waits: bool| vec![NewPoint { waits, ..point([0.0, 0.0, -5.03], 0.95, false) }];
    let out = written(&text, &[(1, Some([0.0, 0.0, -5.01]), point(true))]);
    assert_eq!(out, text.replace("G1 Z-5 F100\n", "G1 Z-5.03 F100\nG04 P0.5\nG1 Z-5.01 F100\n"));
    let out = written(&text, &[(1, Some([0.0, 0.0, -5.01]), point(false))]);
    assert_eq!(out, text.replace("G1 Z-5 F100\n", "G1 Z-5.03 F100\nG1 Z-5.01 F100\n"));
}

#[test]
fn exact_stops_may_be_what_a_control_starts_with() {
    let text = format!("{HEAD}G1 X5 F100\nG64\nX1\n");
    assert_eq!(stops(&text, &[]).iter().filter(|s| s.0).count(), 0);
    assert_eq!(stops(&text, &["g61"]).iter().map(|s| s.0).collect::<Vec<_>>(), [true, true, false]);
    // not where another program may have ended them, and not where one of both modes may be on
    let away = format!("{HEAD}M98 P9100\nG21 G90 G17 G40 G54 G0 X5 Y5 Z5\n");
    assert!(!stops(&away, &["G61"])[1].0);
    let either = format!("{HEAD}N5 G1 X5 F100\nG64\nX1\nIF [#1 EQ 2] GOTO 5\nG1 X2\n");
    assert_eq!(stops(&either, &["G61"]).iter().map(|s| s.0).collect::<Vec<_>>(), [true, false, false, false]);
    let only = format!("{HEAD}N5 G1 X5 F100\nX1\nIF [#1 EQ 2] GOTO 5\nG1 X2\n");
    assert_eq!(stops(&only, &["G61"]).iter().filter(|s| !s.0).count(), 0);
}
