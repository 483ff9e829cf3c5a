//! Rotary axes of which a control may take the shorter way.

use super::*;
use crate::axes::{Axes, Axis, JointKind};

/// X, and A that turns within these limits, deg.
fn table(limits: Option<[f64; 2]>, words: &[&str]) -> Axes {
    let mut a = Axis::new("A", JointKind::Revolute);
    a.limits = limits.map(|l| l.map(f64::to_radians));
    let mut axes = Axes::new("table", vec![Axis::new("X", JointKind::Prismatic), a]);
    axes.control = crate::gcode::Control::of_words(words.iter().copied()).unwrap();
    axes
}

/// The moves before which the side of A is lost.
fn lost(text: &str, axes: &Axes) -> Vec<usize> {
    let script = script_of(&Gcode, text, axes);
    let mut moves = 0;
    let mut found = Vec::new();
    for step in &script.steps {
        match &step.kind {
            StepKind::Move(_) => moves += 1,
            StepKind::Break(Break::Axes(axes)) if axes.has(1) && !axes.has(0) => found.push(moves),
            _ => {}
        }
    }
    found
}

#[test]
fn a_turn_by_half_a_turn_or_more_comes_from_no_known_side() {
    let text = "G21 G90\nG0 X0.0 A350.0\nG1 X1.0 A10.0 F100\nA188.9\nA9.8\nA100.0\n";
    assert_eq!(lost(text, &table(None, &[])), [1, 3]);
    assert_eq!(lost(text, &table(Some([-360.0, 360.0]), &[])), [1, 3]);
    // as it is counted, as there is no other way, or as the user says
    assert!(lost(text, &table(Some([5.0, 351.0]), &[])).is_empty());
    assert!(lost(text, &table(None, &["no-rollover"])).is_empty());
    // its place is known afterwards
    let script = script_of(&Gcode, text, &table(None, &[]));
    let goal = values(&script, moves(&script)[1].0);
    assert!((goal[1].to_degrees() - 10.0).abs() < 1e-9);
    let said =
        |axes: &Axes| script_of(&Gcode, text, axes).notes.iter().filter(|n| n.text.contains("no-rollover")).count();
    assert_eq!([said(&table(None, &[])), said(&table(None, &["no-rollover"]))], [1, 0]);
    let closed = moves(&script)[1].1.closed.as_ref().map(ToString::to_string);
    assert!(closed.is_some_and(|why| why.contains("rollover")));
}

#[test]
fn relative_words_turn_as_they_are_written() {
    assert!(lost("G21 G90\nG0 X0.0 A0.0\nG91\nG1 A270.0 F100\nA-270.0\n", &table(None, &[])).is_empty());
}

#[test]
fn blocks_of_one_form_are_looked_at_one_by_one() {
    let mut text = String::from("G21 G90\nG0 X0.0 A0.0\n");
    for a in [10, 20, 30, 40, 300, 310, 320] {
        text += &format!("G1 X1.0 A{a}.0\n");
    }
    assert_eq!(lost(&text, &table(None, &[])), [5]);
}

#[test]
fn a_turn_by_about_half_a_turn_starts_where_it_always_did() {
    let fixed = |text: &str, axes: &Axes| -> Vec<bool> {
        moves(&script_of(&Gcode, text, axes)).iter().map(|m| m.1.fixed.is_some()).collect()
    };
    let text = |from: &str, between: &str, to: &str| {
        format!("G21 G90\nG0 X0.0 A10.0\nG0 A{from}\nX1.0\n{between}G0 A{to}\nX2.0\nA170.0\n")
    };
    for (from, to) in [("0.02", "180.0"), ("0.0", "180.0"), ("0.0", "-180.0"), ("5.0", "184.5"), ("0.0", "540.0")] {
        for between in ["", "M123\n", "/A90.0\n"] {
            let text = text(from, between, to);
            let found = fixed(&text, &table(None, &[]));
            assert_eq!(found[..3], [false, false, true], "{from} {between} {to}");
            assert!(!fixed(&text, &table(None, &["no-rollover"])).contains(&true), "{from} {between} {to}");
        }
    }
    // no offset turns the shorter way of these
    for (from, to) in [("0.0", "178.9"), ("0.0", "181.1"), ("0.0", "270.0"), ("10.0", "370.0")] {
        assert!(!fixed(&text(from, "", to), &table(None, &[])).contains(&true), "{from} {to}");
    }
}
