use super::*;
use crate::compensator::{BacklashOffset, Evidence as Known};
use crate::effects::GapCurve;

/// Two axes, six decimals of a rad.
fn looks_rewritten(q: &[f64], compensator: &Compensator) -> bool {
    let rounded: Vec<f64> = q.iter().map(|v| (v * 1e6).round() / 1e6).collect();
    let mut evidence = Evidence::default();
    let digits = [Digits { last: 1e-6, unit: 1.0 }; 2];
    evidence.add(Rows { q: &rounded, straight: &[], axes: 2 }, &digits, compensator, 0.1);
    evidence.is_rewritten()
}

fn compensator(half_gap: f64) -> Compensator {
    let gap = GapCurve::Constant(half_gap);
    let backlash = Some(BacklashOffset { positive: gap.clone(), negative: gap });
    Compensator {
        robot_name: String::new(),
        robot_sha256: String::new(),
        joints: vec![JointCompensator { axis: 0, backlash, friction: None }],
        evidence: Known::default(),
    }
}

/// Two axes on a circle of 100 points a turn; with `half_gap`, as a rewrite leaves it.
fn circle(half_gap: f64) -> Vec<f64> {
    arc(half_gap, 0.0628)
}

/// 1,000 points, `step` rad apart.
fn arc(half_gap: f64, step: f64) -> Vec<f64> {
    let at = |i: f64| [(i * step + 0.01).cos(), (i * step + 0.01).sin()];
    let mut q = Vec::new();
    let mut dir = -1.0;
    for i in 0..1000 {
        let [x, y] = at(f64::from(i));
        let next = at(f64::from(i + 1));
        q.extend([x + dir * half_gap, y]);
        let to = (next[0] - x).signum();
        if to != dir {
            dir = to;
            if half_gap > 0.0 {
                q.extend([x + 0.1 * (next[0] - x) + dir * half_gap, y + 0.1 * (next[1] - y)]);
            }
        }
    }
    q
}

#[test]
fn a_rewritten_program_is_known_by_its_reversals() {
    assert!(looks_rewritten(&circle(5e-4), &compensator(5e-4)));
    assert!(!looks_rewritten(&circle(0.0), &compensator(5e-4)));
}

/// Face milling: straights of 30 mm along one axis, joined by half circles of 1.5 mm in front of each.
#[test]
fn turns_of_a_program_that_are_short_as_they_are_do_not_look_made() {
    let mut q = Vec::new();
    for k in 0..20 {
        let (x, sign) = (if k % 2 == 0 { 0.0 } else { 0.03 }, if k % 2 == 0 { 1.0 } else { -1.0 });
        let y = 0.003 * f64::from(k);
        q.extend([x - sign * 0.0015, y - 0.0015, x, y, x + sign * 0.03, y]);
    }
    assert!(!looks_rewritten(&q, &compensator(2.2e-5)));
}

#[test]
fn a_step_at_the_nearest_place_of_a_long_leg_is_known() {
    let (b, mut q) = (3.5e-4, Vec::new());
    for k in 0..20 {
        let (x, sign) = if k % 2 == 0 { (0.0, 1.0) } else { (0.5, -1.0) };
        q.extend([x - sign * b, 0.0, x + sign * (0.01 * 0.5 + b), 0.0]);
    }
    assert!(looks_rewritten(&q, &compensator(b)));
}

#[test]
fn where_points_are_dense_the_step_stands_out_among_its_neighbours() {
    assert!(looks_rewritten(&arc(5e-4, 0.014), &compensator(5e-4)));
    assert!(!looks_rewritten(&arc(0.0, 0.014), &compensator(5e-4)));
}

#[test]
fn even_where_the_steps_of_the_program_are_as_large_as_the_gap_the_original_passes() {
    let q = circle(0.0);
    // the first segment after a reversal is about half of 0.0628^2 / 2
    for gap in [2e-4, 5e-4, 1e-3, 2e-3] {
        assert!(!looks_rewritten(&q, &compensator(gap)), "{gap}");
    }
}

/// One axis to and fro between 10 and 100, approached by a tenth: as it was, and as a rewrite leaves it.
#[test]
fn a_single_axis_is_known_by_the_share_of_its_steps_and_an_approach_of_a_tenth_is_none() {
    let b = 3.5e-4;
    let (mut original, mut rewritten) = (Vec::new(), Vec::new());
    for k in 0..8 {
        let (from, to, d) = if k % 2 == 0 { (0.1, 1.0, 1.0) } else { (1.0, 0.1, -1.0) };
        original.extend([from, 0.0, from + 0.1 * (to - from), 0.0]);
        rewritten.extend([from - d * b, 0.0, from + 0.1 * (to - from) + d * b, 0.0]);
    }
    assert!(looks_rewritten(&rewritten, &compensator(b)));
    assert!(!looks_rewritten(&original, &compensator(b)));
}

/// One axis alone, a little more and less than ten samples a turn: each turn ends on the way between two samples.
#[test]
fn a_sampled_oscillation_of_one_axis_does_not_look_made() {
    let sampled = |step: f64| -> Vec<f64> { (0..60).flat_map(|j| [(f64::from(j) * step).sin() / 10.0, 0.4]).collect() };
    for step in [0.63, 0.6275, 0.42, 1.05] {
        assert!(!looks_rewritten(&sampled(step), &compensator(5e-5)), "{step}");
    }
}

/// Targets of round numbers that carry their offset, without a point more.
#[test]
fn round_numbers_are_known_by_the_digits_that_the_offset_adds() {
    let b = 0.0028;
    let program = |b: f64| -> Vec<f64> {
        let stops = [0.0, 0.5, 0.3, 0.9, 0.1, 0.7, 0.4, 0.8, 0.2];
        let moved = stops.windows(2).map(|w| w[1] + if w[1] > w[0] { b } else { -b });
        moved.flat_map(|x| [x, 0.5]).collect()
    };
    assert!(looks_rewritten(&program(b), &compensator(b)));
    assert!(!looks_rewritten(&program(0.0), &compensator(b)));
    assert!(!looks_rewritten(&program(0.00137), &compensator(b)), "another offset");
}

/// Three axes that all turn at every target.
#[test]
fn where_all_axes_turn_at_once_their_steps_agree_on_the_share() {
    let b = [3.5e-4, 6e-4, 2e-4];
    let joint = |axis: usize| {
        let gap = GapCurve::Constant(b[axis]);
        let backlash = Some(BacklashOffset { positive: gap.clone(), negative: gap });
        JointCompensator { axis, backlash, friction: None }
    };
    let compensator = Compensator { joints: (0..3).map(joint).collect(), ..compensator(0.0) };
    let program = |gain: f64, share: f64| -> Vec<f64> {
        let (low, high) = ([0.1, 0.2, -0.3], [0.9, 0.5, 0.4]);
        let mut q = Vec::new();
        for k in 0..4 {
            let (from, to, d) = if k % 2 == 0 { (low, high, 1.0) } else { (high, low, -1.0) };
            q.extend((0..3).map(|a| from[a] - d * gain * b[a]));
            q.extend((0..3).map(|a| from[a] + share * (to[a] - from[a]) + d * gain * b[a]));
        }
        q.iter().map(|v: &f64| (v * 1e6).round() / 1e6).collect()
    };
    let is_rewritten = |q: Vec<f64>| {
        let mut evidence = Evidence::default();
        evidence.add(Rows { q: &q, straight: &[], axes: 3 }, &[Digits { last: 1e-6, unit: 1.0 }; 3], &compensator, 0.1);
        evidence.is_rewritten()
    };
    for share in [0.013, 0.1, 0.25] {
        assert!(is_rewritten(program(1.0, share)), "{share}");
        assert!(!is_rewritten(program(0.0, share)), "as it was: {share}");
    }
    assert!(!is_rewritten(program(0.4, 0.013)), "another gain");
}
