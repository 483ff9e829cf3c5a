//! The constant offset that leaves the smallest largest error over the reversals.
//!
//! With half gaps `b_i` at the reversals, the error left by an offset `d` is `|d - b_i|`; its maximum is least in the middle of the
//! smallest and the largest. That holds for gaps that truly differ. Where they differ by their noise alone the middle of the
//! extremes is a worse estimate than the common value (its variance falls with 1/log n, not 1/n), so the common value
//! is kept unless a chi-squared test refuses it.

use crate::gaps::GapPoint;
use crate::numerics::chi_squared;
use crate::numerics::normal::Z95;
use crate::numerics::robust::range;

/// p below which the gaps at the reversals count as different.
const DIFFERENT: f64 = 1e-3;

/// Offset for a joint with the common half gap `common` and the gaps `points` (rad or m).
pub fn constant_gap(common: f64, points: &[GapPoint]) -> f64 {
    let known: Vec<(f64, f64)> = points
        .iter()
        .map(|p| (p.half_gap, (p.ci95[1] - p.ci95[0]) / (2.0 * Z95)))
        .filter(|(b, s)| b.is_finite() && *s > 0.0)
        .collect();
    if known.len() < 2 {
        return common;
    }
    let weight: f64 = known.iter().map(|(_, s)| 1.0 / (s * s)).sum();
    let mean = known.iter().map(|(b, s)| b / (s * s)).sum::<f64>() / weight;
    let chi2: f64 = known.iter().map(|(b, s)| ((b - mean) / s).powi(2)).sum();
    let p = chi_squared::tail(chi2, (known.len() - 1) as f64);
    if p >= DIFFERENT {
        return common;
    }
    let [lo, hi] = range(known.iter().map(|(b, _)| *b));
    ((lo + hi) / 2.0).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(gaps: &[f64], sigma: f64) -> Vec<GapPoint> {
        let one = |&b: &f64| GapPoint {
            axis: 0,
            at: 0.0,
            half_gap: b,
            ci95: [b - Z95 * sigma, b + Z95 * sigma],
            cycles: 1,
            per_cycle: Vec::new(),
        };
        gaps.iter().map(one).collect()
    }

    #[test]
    fn gaps_that_differ_get_the_middle_and_noisy_ones_the_mean() {
        let b = [40e-6, 41e-6, 42e-6, 60e-6];
        assert_eq!(constant_gap(45e-6, &points(&b, 1e-6)), 50e-6);
        assert_eq!(constant_gap(45e-6, &points(&b, 20e-6)), 45e-6);
        assert_eq!(constant_gap(45e-6, &[]), 45e-6);
    }
}
