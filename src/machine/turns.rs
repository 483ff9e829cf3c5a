//! Turning points between the rows of a log.
//!
//! A log shows a turning point only by the row nearest to it. The play and the stiction depend on the true one: a row
//! after it that is still the highest is predicted a whole gap off. Method: where one row alone is the extreme, a cubic
//! through it and its neighbours, with three-point slopes, has its own extreme on one side of the row; that point is
//! added to the track, limited by the extended chords on either side, so that a step in the command adds nothing.
//! On a parabola (a smooth reversal) it is exact; at the corner of two ramps it finds up to half of what is missing,
//! never more than there is. A pause on the extreme ends between rows, too: the rows after it show by which power of time
//! the joint leaves (a ramp, a constant acceleration, a constant jerk) and so when it left.

use crate::effects::Track;

/// Inserted points after a row: `(row, time in s, position)`, rows rising.
pub fn between_rows(t_s: &[f64], p: &[f64], deadband: f64) -> Vec<(usize, f64, f64)> {
    let track = Track::new(t_s, p, deadband);
    let found = |k: usize| {
        flat_turn(t_s, p, k, deadband).or_else(|| extreme_near(t_s, p, k, deadband)).or_else(|| end_of_pause(t_s, p, k))
    };
    track.turns.iter().filter_map(|turn| found(turn.index)).collect()
}

/// A reversal at which the joint comes to rest and leaves again with constant jerk: the way after it grows with the third
/// power of time, so its cube roots lie on a line that bends little; three rows give when it left, the fourth shows whether
/// it is so (a parabola's rows are 1.6 % off or more, and fit their own roots far better). The rows before it say in the
/// same way when it came: where that is after row `k`, or the leaving before it, the extreme lies beyond the row.
fn flat_turn(t_s: &[f64], p: &[f64], k: usize, deadband: f64) -> Option<(usize, f64, f64)> {
    if k < 4 || k + 4 >= p.len() || p[k - 1] == p[k] || p[k + 1] == p[k] {
        return None;
    }
    let up = (p[k] - p[k - 1]).signum();
    let mut extreme = p[k];
    let mut left = t_s[k];
    for _ in 0..4 {
        let way = |i: usize| (extreme - p[i]) * up;
        let (after, fast) = rest_beside([k + 1, k + 2, k + 3, k + 4].map(|i| (t_s[i], way(i))))?;
        left = after;
        extreme = if left < t_s[k] {
            p[k] + up * (fast * (t_s[k] - left)).powi(3)
        } else {
            match rest_beside([k - 1, k - 2, k - 3, k - 4].map(|i| (t_s[i], way(i)))) {
                Some((came, fast)) if came > t_s[k] => p[k] + up * (fast * (came - t_s[k])).abs().powi(3),
                _ => p[k],
            }
        };
    }
    let inside = left > t_s[k - 1] && left < t_s[k + 1];
    let seen = left >= t_s[k] || (extreme - p[k]) * up > deadband;
    (inside && seen).then_some((if left < t_s[k] { k - 1 } else { k }, left, extreme))
}

/// Time at which a joint rested, and the slope of the cube roots there, from the ways made in four rows beside it, nearest
/// first; `None` where the ways do not grow with the third power of time.
fn rest_beside(rows: [(f64, f64); 4]) -> Option<(f64, f64)> {
    const FITS: f64 = 0.025;
    let root = |i: usize, n: f64| rows[i].1.max(0.0).powf(1.0 / n);
    let miss = |n: f64| ((3.0 * (root(2, n) - root(1, n)) + root(0, n)) / root(3, n) - 1.0).abs();
    let off = miss(3.0);
    if off.is_nan() || off > FITS || off > 0.5 * miss(2.0) {
        return None;
    }
    let (y1, y2, y3) = (root(0, 3.0), root(1, 3.0), root(2, 3.0));
    let h = (rows[2].0 - rows[0].0) / 2.0;
    // y1 + a s + b s^2 in steps away from the first row; its root towards the rest
    let (a, b) = (0.5 * (4.0 * y2 - 3.0 * y1 - y3), 0.5 * (y3 - 2.0 * y2 + y1));
    let discriminant = (a * a - 4.0 * b * y1).max(0.0).sqrt();
    let s = -2.0 * y1 / (a + discriminant);
    Some((rows[0].0 + s * h, ((a + discriminant) / (2.0 * h)).abs()))
}

/// Powers of time by which a joint leaves a pause.
const POWERS: [f64; 3] = [1.0, 2.0, 3.0];

/// When a pause that ends after row `k` ends. For each power `n` the n-th roots of the way made lie on a line through the
/// end of the pause; two rows give it, a third and a fourth say which power it is.
fn end_of_pause(t_s: &[f64], p: &[f64], k: usize) -> Option<(usize, f64, f64)> {
    if k == 0 || k + 4 >= p.len() || p[k - 1] != p[k] {
        return None;
    }
    let way = |i: usize| (p[k + i] - p[k]).abs();
    if !(way(1) < way(2) && way(2) < way(3) && way(3) < way(4)) {
        return None;
    }
    let line = |n: f64| -> (f64, f64) {
        let (y1, y2) = (way(2).powf(1.0 / n), way(3).powf(1.0 / n));
        let slope = (y2 - y1) / (t_s[k + 3] - t_s[k + 2]);
        let end = (t_s[k + 2] - y1 / slope).clamp(t_s[k], t_s[k + 1]);
        let at = |t: f64| (slope * (t - end).max(0.0)).powf(n);
        let miss = (at(t_s[k + 1]) - way(1)).abs() / way(2) + (at(t_s[k + 4]) - way(4)).abs() / way(4);
        (miss, end)
    };
    let (_, end) = POWERS.iter().map(|&n| line(n)).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let h = t_s[k + 1] - t_s[k];
    (end > t_s[k] + 1e-6 * h && end < t_s[k + 1] - 1e-6 * h).then_some((k, end, p[k]))
}

/// The extreme of the cubic beside row `k`, where that row alone is an extreme of `p` and the cubic goes beyond it.
fn extreme_near(t_s: &[f64], p: &[f64], k: usize, deadband: f64) -> Option<(usize, f64, f64)> {
    if k == 0 || k + 1 >= p.len() || p[k - 1] == p[k] || p[k + 1] == p[k] {
        return None;
    }
    let here = slope(t_s, p, k)?;
    let up = if p[k - 1] < p[k] { 1.0 } else { -1.0 };
    // still moving outwards: the extreme lies after the row, else before it
    let i = if here * up > 0.0 { k } else { k - 1 };
    let h = t_s[i + 1] - t_s[i];
    let chord = (p[i + 1] - p[i]) / h;
    let (m0, m1) = (slope(t_s, p, i).unwrap_or(chord), slope(t_s, p, i + 1).unwrap_or(chord));
    if m0 * up <= 0.0 || m1 * up >= 0.0 {
        return None;
    }
    // derivative of the cubic at s in 0..1: a s^2 + b s + m0, positive at 0 and negative at 1 (times `up`)
    let a = 3.0 * (m0 + m1 - 2.0 * chord);
    let b = 6.0 * chord - 4.0 * m0 - 2.0 * m1;
    let root = (b * b - 4.0 * a * m0).max(0.0).sqrt();
    // the root that keeps its digits as a goes to 0: 2 m0 / (-b + up root)
    let s = 2.0 * m0 / (-b + up * root);
    if !(s > 1e-6 && s < 1.0 - 1e-6) {
        return None;
    }
    let t = t_s[i] + s * h;
    let cubic = (p[i] + h * s * (m0 + s * (b / 2.0 + s * a / 3.0))) * up;
    // a path that bends one way stays within its chords on either side, drawn out to here
    let line = |a: usize, b: usize| (p[a] + (p[b] - p[a]) * ((t - t_s[a]) / (t_s[b] - t_s[a]))) * up;
    let before = if i > 0 { line(i - 1, i) } else { f64::INFINITY };
    let following = if i + 2 < p.len() { line(i + 1, i + 2) } else { f64::INFINITY };
    let value = cubic.min(before).min(following);
    let beyond = value - p[k] * up;
    (beyond > deadband && beyond.is_finite()).then_some((i, t, value * up))
}

/// Slope of the parabola through a row and its neighbours.
fn slope(t_s: &[f64], p: &[f64], i: usize) -> Option<f64> {
    if i == 0 || i + 1 >= p.len() {
        return None;
    }
    let (h0, h1) = (t_s[i] - t_s[i - 1], t_s[i + 1] - t_s[i]);
    let (d0, d1) = ((p[i] - p[i - 1]) / h0, (p[i + 1] - p[i]) / h1);
    Some((d0 * h1 + d1 * h0) / (h0 + h1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_turns_where_it_does() {
        let t: Vec<f64> = [0.0, 0.1, 0.25, 0.3, 0.4, 0.55].to_vec();
        for sign in [1.0, -1.0] {
            let p: Vec<f64> = t.iter().map(|t| sign * (1.0 - 3.0 * (t - 0.27_f64).powi(2))).collect();
            let found = between_rows(&t, &p, 1e-12);
            assert_eq!(found.len(), 1);
            let (row, at, value) = found[0];
            assert_eq!(row, 2);
            assert!((at - 0.27).abs() < 1e-12 && (value - sign).abs() < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn a_corner_is_never_overshot() {
        for f in [0.05, 0.3, 0.45, 0.55, 0.8, 0.95] {
            let t: Vec<f64> = (0..8).map(f64::from).collect();
            let p: Vec<f64> = t.iter().map(|t| 10.0 - (t - 3.0_f64 - f).abs()).collect();
            for (_, _, value) in between_rows(&t, &p, 1e-12) {
                assert!(value <= 10.0 && value > p.iter().copied().fold(f64::MIN, f64::max));
            }
        }
    }

    #[test]
    fn a_step_behind_a_reversal_adds_nothing_to_speak_of() {
        let t: Vec<f64> = (0..7).map(f64::from).collect();
        let p = [0.0, 0.01, 0.02, 0.03, -1.0, -1.01, -1.02];
        for (_, _, value) in between_rows(&t, &p, 1e-12) {
            assert!(value <= 0.04, "{value}");
        }
    }

    #[test]
    fn a_pause_of_which_only_rows_are_known_gets_no_point() {
        let t: Vec<f64> = (0..6).map(f64::from).collect();
        assert!(between_rows(&t, &[0.0, 1.0, 2.0, 2.0, 1.0, 0.0], 1e-12).is_empty());
    }

    #[test]
    fn a_flat_turn_is_where_rest_to_rest_moves_meet() {
        // two moves of 2 and 3 s of least jerk, sampled at 10 Hz
        let least_jerk = |s: f64| s * s * s * (10.0 + s * (6.0 * s - 15.0));
        for meet in [2.02, 2.035, 2.06, 2.09] {
            let t: Vec<f64> = (0..50).map(|i| f64::from(i) * 0.1).collect();
            let p: Vec<f64> = t
                .iter()
                .map(|&t| {
                    if t < meet {
                        5.0 * least_jerk(1.0 + (t - meet) / 2.0)
                    } else {
                        5.0 - 8.0 * least_jerk((t - meet) / 3.0)
                    }
                })
                .collect();
            let found = between_rows(&t, &p, 1e-12);
            // to an eighth of the time between rows
            assert!(found.len() == 1 && (found[0].1 - meet).abs() < 0.0125, "{meet} {found:?}");
        }
    }

    #[test]
    fn a_pause_ends_when_the_joint_leaves() {
        for n in [1.0, 2.0, 3.0] {
            for left in [4.05, 4.5, 4.95] {
                let t: Vec<f64> = (0..10).map(f64::from).collect();
                let p: Vec<f64> =
                    t.iter().map(|&t| if t < 3.0 { t } else { 3.0 - (t - left).max(0.0).powf(n) }).collect();
                let found = between_rows(&t, &p, 1e-12);
                assert_eq!(found.len(), 1, "{n} {left}");
                assert!(found[0].0 == 4 && (found[0].1 - left).abs() < 0.02, "{n} {left} {found:?}");
            }
        }
    }
}
