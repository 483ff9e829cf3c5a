//! Where joints turn on a sampled way.
//!
//! Method: a turn by more than the dead band shows in the samples; its place is the extreme of the parabola through the sample that stands
//! farthest and both beside it. Within the first and the last part of a way no sample stands beyond a turn: parabolas through the three
//! samples at the ends show those.

use crate::numerics::reversal::{Movement, ReversalDetector};

/// A sample: its share of the way, and what the gears turn there, rad or m.
pub(super) type Row = (f64, Vec<f64>);

/// Samples closer than this share of a way are one: between them a parabola has no extreme that means anything.
const ONE: f64 = 1e-6;

/// The samples of a way by their shares, each place once: joints that turn together ask for one place twice.
pub(super) fn in_order(mut rows: Vec<Row>) -> Vec<Row> {
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    rows.dedup_by(|b, a| b.0 - a.0 < ONE);
    rows
}

/// Shares within the first and the last part of a sampled way at which axes turn, by parabolas through the three samples at each end.
pub(super) fn turns_at_ends(rows: &[Row]) -> Vec<f64> {
    let [first, second, third, ..] = rows else { return Vec::new() };
    let [.., before, last_but_one, last] = rows else { return Vec::new() };
    let mut found = Vec::new();
    for [end, next, over] in [[first, second, third], [last, last_but_one, before]] {
        for (p, (q, r)) in end.1.iter().zip(next.1.iter().zip(&over.1)) {
            // steps from the end inwards, and the slopes at both ends of the part, per part
            let (step, beyond) = (q - p, r - q);
            let curvature = beyond - step;
            let slopes = [step - 0.5 * curvature, step + 0.5 * curvature];
            if slopes[0] * slopes[1] < 0.0 {
                found.push(end.0 - slopes[0] / curvature * (next.0 - end.0));
            }
        }
    }
    found
}

/// Shares at which joints turn by more than the dead band on a sampled way, by parabolas through its samples.
pub(super) fn turning_shares(rows: &[Row], deadband: &[f64]) -> Vec<f64> {
    let Some((_, first)) = rows.first() else { return Vec::new() };
    let mut found = Vec::new();
    for axis in 0..first.len() {
        let p = |k: usize| rows[k].1[axis];
        let mut detector = ReversalDetector::new(deadband.get(axis).copied().unwrap_or(0.0), 0);
        for k in 0..rows.len() {
            if let Movement::Reversed { at, extreme } = detector.take(k, p(k)) {
                // on a way that is symmetrical about the turn, the samples beside it may be equal to the last bit
                let rest = (0..at).rev().take_while(|&k| p(k) == extreme).count();
                found.push(match at.checked_sub(1) {
                    Some(before) if rest == 0 => vertex([before, at, at + 1].map(|k| [rows[k].0, p(k)])),
                    _ => 0.5 * (rows[at - rest].0 + rows[at].0),
                });
            }
        }
    }
    found
}

/// Where the parabola through three points `[x, y]` has its extreme.
fn vertex([a, b, c]: [[f64; 2]; 3]) -> f64 {
    let (before, after) = (b[0] - a[0], c[0] - b[0]);
    let (rise, fall) = ((b[1] - a[1]) / before, (c[1] - b[1]) / after);
    b[0] + 0.5 * (rise * after + fall * before) / (rise - fall)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_between_two_equal_samples_is_found() {
        assert_eq!(turning_shares(&way(&[0.0, 0.3, 0.4, 0.4, 0.3, 0.0]), &[1e-3]), [0.5]);
        assert_eq!(turning_shares(&way(&[0.0, 0.3, 0.4, 0.3, 0.0]), &[1e-3]), [0.5]);
        assert_eq!(turning_shares(&way(&[0.0, 0.3, 0.3, 0.4, 0.5]), &[1e-3]), [0.0; 0]);
    }

    #[test]
    fn a_turn_between_the_values_at_the_ends_of_a_way_is_found() {
        // down, up again, and down to the end, as a wrist may on a straight way
        let wiggle = way(&[48.28, 45.5, 45.5, 47.8, 47.9, 47.7]);
        let shares = turning_shares(&wiggle, &[0.01]);
        assert_eq!(shares.len(), 2);
        // middle of the two equal samples; a parabola through 47.8, 47.9 and 47.7 stands highest at -1/6 of a part
        assert!(
            (shares[0] - 1.5 / 5.0).abs() < 1e-12 && (shares[1] - (4.0 - 1.0 / 6.0) / 5.0).abs() < 1e-9,
            "{shares:?}"
        );
        // both turns of a way that rises from end to end, and none of those within the dead band
        assert_eq!(turning_shares(&way(&[0.0, 0.6, 0.4, 1.0]), &[0.1]).len(), 2);
        assert!(turning_shares(&way(&[0.0, 0.6, 0.55, 1.0]), &[0.1]).is_empty());
    }

    #[test]
    fn a_turn_within_the_first_or_the_last_part_is_found() {
        for turn in [0.1, 0.24, 0.76, 0.9, 0.99] {
            let rows: Vec<Row> =
                (0..5).map(|k| f64::from(k) / 4.0).map(|share| (share, vec![3.0, -(share - turn).powi(2)])).collect();
            let found = turns_at_ends(&rows);
            assert!(found.len() == 1 && (found[0] - turn).abs() < 1e-12, "{turn}: {found:?}");
        }
        let straight: Vec<Row> = (0..5).map(|k| (f64::from(k), vec![f64::from(k), 0.0])).collect();
        assert!(turns_at_ends(&straight).is_empty() && turns_at_ends(&straight[..2]).is_empty());
        // one that is no nearer to an end
        assert!(turns_at_ends(&way(&[0.0, 0.3, 0.4, 0.4, 0.3, 0.0])).is_empty());
    }

    /// Two joints that turn at one place ask for one sample there, and its place is that of both.
    #[test]
    fn joints_that_turn_together_near_an_end_have_one_place() {
        let place = |share: f64| -(share - 0.9).powi(2);
        let row = |share: f64| (share, vec![place(share), 2.0 * place(share)]);
        let mut rows: Vec<Row> = (0..5).map(|k| row(f64::from(k) / 4.0)).collect();
        let turns = turns_at_ends(&rows);
        assert_eq!(turns.len(), 2);
        rows.extend(turns.into_iter().map(row));
        let rows = in_order(rows);
        assert_eq!(rows.len(), 6);
        let shares = turning_shares(&rows, &[1e-3, 1e-3]);
        assert!(shares.len() == 2 && shares.iter().all(|share| (share - 0.9).abs() < 1e-9), "{shares:?}");
    }

    /// Samples of one axis, evenly over the way.
    fn way(values: &[f64]) -> Vec<Row> {
        let parts = (values.len() - 1) as f64;
        values.iter().enumerate().map(|(k, v)| (k as f64 / parts, vec![*v])).collect()
    }
}
