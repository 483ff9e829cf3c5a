//! Dead bands by the digits of a program: zeros at the end are often left out and say nothing.

use crate::vendor_rewrite::Desk;

/// A1 of each target of a KRL program through a gap of A1 of so many degrees on each side.
fn rewritten(half_gap_deg: f64, a1: &[&str]) -> Vec<f64> {
    let desk = Desk::new(half_gap_deg);
    let moves = a1.iter().map(|a1| format!("PTP {{A1 {a1},A2 -90.0,A3 90.0,A4 0.0,A5 10.0,A6 0.0}}\n"));
    desk.write("part.src", &format!("DEF part( )\n{}END\n", moves.collect::<String>()));
    desk.run("rewrite --model model.yaml part.src --output out.src --force --max-added 0").success();
    let out = String::from_utf8(desk.read("out.src")).unwrap();
    let value = |line: &str| line.split_once("A1 ")?.1.split_once(',')?.0.parse().ok();
    out.lines().filter_map(value).collect()
}

fn near(found: &[f64], want: &[f64]) {
    assert_eq!(found.len(), want.len(), "{found:?}");
    for (found, want) in found.iter().zip(want) {
        assert!((found - want).abs() < 1e-4, "{found} for {want}");
    }
}

/// The joint goes up by less than a gap and then down: it stands on the upper side until it turns.
#[test]
fn zeros_that_are_left_out_do_not_widen_the_dead_band() {
    let sides = [0.02, 0.038, -5.02, 3.02];
    near(&rewritten(0.02, &["0.0000", "0.0180", "-5.0000", "3.0000"]), &sides);
    near(&rewritten(0.02, &["0.0", "0.018", "-5.0", "3.0"]), &sides);
    near(&rewritten(0.02, &["0", "0.018", "-5", "3"]), &sides);
}

/// A movement of less than 1.5 digits of the finest number is rounding, and none of the gap's own size is.
#[test]
fn a_movement_within_the_digits_of_all_numbers_is_no_reversal() {
    // up to 20, a digit back, and on: the digit is no turn
    near(&rewritten(0.2, &["0.0", "20.0", "19.9", "30.0"]), &[0.2, 20.2, 20.1, 30.2]);
    // one finer number: it is
    near(&rewritten(0.2, &["0.00", "20.0", "19.9", "30.0"]), &[0.2, 20.2, 19.7, 30.2]);
}
