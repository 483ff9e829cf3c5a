//! Gap over motor position from the sizes of deadzones: a cubic spline, or a constant.
//!
//! A deadzone that begins at `p0` and ends at `p1` has the size `b(p0) + b(p1)` on a joint whose half gap depends on the command:
//! it leaves the one edge of the gap and meets the other. That is linear in `b`, so natural cubic splines (Hastie, Tibshirani
//! and Friedman, The Elements of Statistical Learning, section 5.2.1) with 2 to [`MOST_KNOTS`] even knots are fitted by
//! weighted least squares on the sizes themselves, not on "size at position". They are averaged with the weights
//! `exp(-(chi2 / s2 + K ln n) / 2)` (Schwarz 1978), the constant among them.
//!
//! `s2`, by which the sizes scatter more than their standard errors say, comes from the finest spline; above 1 it widens all intervals,
//! where an F test finds it (p < 0.01). Whether the gap varies: F test of a spline with few knots against the constant, with that scatter.
//!
//! The band at a knot is `sum w (f - mean)^2 + sum w var(f)`: spread between splines and variance within them.
//! The exported PCHIP has knots so dense that it follows the spline, and is constant beyond the deadzones seen.

use crate::numerics::{fisher, student};
use nalgebra::{DMatrix, DVector};

pub const MOST_KNOTS: usize = 9;
/// Level below which a gap counts as varying.
pub const ALPHA: f64 = 0.01;
/// Knots of the exported curve.
const EXPORTED: usize = 25;
/// Deadzones below which no shape is looked for.
const SHAPED_FROM: usize = 8;
/// Degrees of freedom of a standard error that comes from the noise of a whole log.
const KNOWN: f64 = 1e6;

/// A deadzone on its joint: where it begins and ends, its size and standard error; rad or m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sized {
    pub from: f64,
    pub to: f64,
    pub size: f64,
    pub sigma: f64,
}

/// Half gap over position; rad or m.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// Mean half gap of the deadzones seen (plain where it varies, weighted where it does not).
    pub half_gap: f64,
    pub ci95: [f64; 2],
    /// `[position, half gap]` of the exported curve, where the gap varies.
    pub knots: Vec<[f64; 2]>,
    /// Half of a 95 % interval at each knot.
    pub band: Vec<f64>,
    pub varies_p_value: Option<f64>,
    /// Factor by which the sizes scatter beyond their standard errors, applied to them; 1: none.
    pub scatter: f64,
    pub scatter_p_value: Option<f64>,
}

/// A spline that was fitted.
struct Fit {
    knots: usize,
    chi2: f64,
    coefficients: DVector<f64>,
    covariance: DMatrix<f64>,
}

/// Fits the map; `None` of nothing.
pub fn fit(sizes: &[Sized]) -> Option<Map> {
    let n = sizes.len();
    if n == 0 {
        return None;
    }
    let ends = || sizes.iter().flat_map(|s| [s.from, s.to]);
    let (lo, hi) = (ends().fold(f64::INFINITY, f64::min), ends().fold(f64::NEG_INFINITY, f64::max));
    let places = places(sizes);
    let fits: Vec<Fit> = (1..=MOST_KNOTS)
        .filter(|&k| k == 1 || (n >= SHAPED_FROM && hi > lo && n >= 2 * k && places >= 2 * k))
        .filter_map(|k| spline(sizes, lo, hi, k))
        .collect();
    let constant = fits.first().filter(|f| f.knots == 1)?;
    let finest = fits.last()?;
    let dof = (n - finest.knots) as f64;
    let raw = if dof > 0.0 { finest.chi2 / dof } else { 1.0 };
    let scatter_p_value = (dof > 0.0).then(|| fisher::tail(raw, dof, KNOWN));
    let s2 = if scatter_p_value.is_some_and(|p| p < ALPHA) { raw } else { 1.0 };
    let known = if s2 > 1.0 { dof } else { KNOWN };
    // a handful of knots is enough to see a slope, a bow and a wave
    let shaped = fits.iter().rfind(|f| f.knots <= 5).filter(|f| f.knots > 1);
    let varies_p_value = shaped.map(|f| {
        let extra = (f.knots - 1) as f64;
        // a scatter smaller than the standard errors allow is luck
        fisher::tail((constant.chi2 - f.chi2) / extra / raw.max(1.0), extra, dof)
    });
    let factor = student::factor(0.95, known);
    let around = |middle: f64, se: f64| [middle - factor * se, middle + factor * se];
    let scatter = s2.sqrt();
    if varies_p_value.is_none_or(|p| p >= ALPHA) {
        let se = (constant.covariance[(0, 0)] * s2).sqrt();
        let half_gap = constant.coefficients[0];
        let ci95 = around(half_gap, se);
        return Some(Map {
            half_gap,
            ci95,
            knots: Vec::new(),
            band: Vec::new(),
            varies_p_value,
            scatter,
            scatter_p_value,
        });
    }
    let score = |f: &Fit| -0.5 * (f.chi2 / s2 + f.knots as f64 * (n as f64).ln());
    let best = fits.iter().map(score).fold(f64::NEG_INFINITY, f64::max);
    let total: f64 = fits.iter().map(|f| (score(f) - best).exp()).sum();
    let weights: Vec<f64> = fits.iter().map(|f| (score(f) - best).exp() / total).collect();
    let (mut knots, mut band) = (Vec::new(), Vec::new());
    for i in 0..EXPORTED {
        let at = lo + (hi - lo) * i as f64 / (EXPORTED - 1) as f64;
        let values: Vec<(f64, f64)> = fits.iter().map(|f| value(f, lo, hi, at)).collect();
        let mean: f64 = values.iter().zip(&weights).map(|(v, w)| w * v.0).sum();
        let variance: f64 = values.iter().zip(&weights).map(|(v, w)| w * ((v.0 - mean).powi(2) + s2 * v.1)).sum();
        knots.push([at, mean.max(0.0)]);
        band.push(factor * variance.sqrt());
    }
    let half_gap = sizes.iter().map(|s| 0.5 * s.size).sum::<f64>() / n as f64;
    let se = (s2 * sizes.iter().map(|s| 0.25 * s.sigma * s.sigma).sum::<f64>()).sqrt() / n as f64;
    Some(Map { half_gap, ci95: around(half_gap, se), knots, band, varies_p_value, scatter, scatter_p_value })
}

/// Places at which deadzones begin, those within half a mean size of each other taken for one: from two places no shape can
/// be determined, however often they were visited.
fn places(sizes: &[Sized]) -> usize {
    let apart = 0.5 * sizes.iter().map(|s| s.size.abs()).sum::<f64>() / sizes.len().max(1) as f64;
    let mut from: Vec<f64> = sizes.iter().map(|s| s.from).collect();
    from.sort_by(f64::total_cmp);
    let mut count = 0;
    let mut last = f64::NEG_INFINITY;
    for at in from {
        if at - last > apart {
            count += 1;
            last = at;
        }
    }
    count
}

/// Basis of natural cubic splines with `k` even knots on `lo..hi`; 1: the constant, 2: a straight line.
fn basis(k: usize, lo: f64, hi: f64, at: f64) -> DVector<f64> {
    let x = if hi > lo { ((at - lo) / (hi - lo)).clamp(0.0, 1.0) } else { 0.0 };
    let mut row = DVector::zeros(k);
    row[0] = 1.0;
    if k > 1 {
        row[1] = x;
    }
    let knot = |j: usize| j as f64 / (k - 1) as f64;
    let cube = |x: f64| x.max(0.0).powi(3);
    let d = |j: usize| (cube(x - knot(j)) - cube(x - 1.0)) / (1.0 - knot(j));
    for j in 2..k {
        row[j] = d(j - 2) - d(k - 2);
    }
    row
}

fn spline(sizes: &[Sized], lo: f64, hi: f64, knots: usize) -> Option<Fit> {
    let n = sizes.len();
    let rows: Vec<DVector<f64>> =
        sizes.iter().map(|s| basis(knots, lo, hi, s.from) + basis(knots, lo, hi, s.to)).collect();
    let design = DMatrix::from_fn(n, knots, |i, j| rows[i][j] / sizes[i].sigma);
    let y = DVector::from_fn(n, |i, _| sizes[i].size / sizes[i].sigma);
    let svd = design.clone().svd(true, true);
    let (largest, least) = (svd.singular_values.max(), svd.singular_values.min());
    if least.is_nan() || least <= 1e-9 * largest {
        return None;
    }
    let coefficients = svd.solve(&y, 0.0).ok()?;
    let v_t = svd.v_t?;
    let inverse = DMatrix::from_diagonal(&svd.singular_values.map(|s| 1.0 / (s * s)));
    let covariance = v_t.transpose() * inverse * v_t;
    Some(Fit { knots, chi2: (&y - design * &coefficients).norm_squared(), coefficients, covariance })
}

/// Value and variance of a fit.
fn value(f: &Fit, lo: f64, hi: f64, at: f64) -> (f64, f64) {
    let row = basis(f.knots, lo, hi, at);
    (row.dot(&f.coefficients), row.dot(&(&f.covariance * &row)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(gap: impl Fn(f64) -> f64, n: usize, sigma: f64) -> Vec<Sized> {
        // the other end of a deadzone solves p1 = p0 - b(p0) - b(p1)
        (0..n)
            .map(|i| {
                let up = i % 2 == 0;
                let from = (if up { 1.0 } else { -1.0 }) * (0.1 + 0.6 * i as f64 / n as f64);
                let sign = if up { -1.0 } else { 1.0 };
                let mut to = from;
                for _ in 0..60 {
                    to = from + sign * (gap(from) + gap(to));
                }
                Sized { from, to, size: gap(from) + gap(to), sigma }
            })
            .collect()
    }

    #[test]
    fn a_gap_that_varies_is_met_although_a_deadzone_spans_much_of_it() {
        let gap = |p: f64| 0.03 + 0.02 * p * p + 0.01 * p;
        let map = fit(&of(gap, 44, 1e-4)).unwrap();
        assert!(map.varies_p_value.unwrap() < 1e-9);
        // inside the band everywhere; at the ends a natural spline has no curvature, in the middle it is free
        for ([at, b], band) in map.knots.iter().zip(&map.band) {
            let off = (b - gap(*at)).abs();
            assert!(off < 2.0 * band && (at.abs() > 0.5 || off < 3e-5), "at {at}: {b} for {}, band {band}", gap(*at));
        }
        assert_eq!(map.scatter, 1.0);
    }

    #[test]
    fn two_places_visited_often_show_no_shape() {
        // a sine that does not grow: all begin at one of two places, and what was measured is far from 2 b
        let sizes: Vec<Sized> = (0..50)
            .map(|i| {
                let up = if i % 2 == 0 { 1.0 } else { -1.0 };
                Sized { from: 0.35 * up, to: 0.30 * up, size: 0.05, sigma: 1e-4 }
            })
            .collect();
        let map = fit(&sizes).unwrap();
        assert!(map.knots.is_empty() && (map.half_gap - 0.025).abs() < 1e-9);
    }

    #[test]
    fn a_constant_gap_is_constant_and_few_deadzones_have_no_shape() {
        let map = fit(&of(|_| 0.03, 44, 1e-4)).unwrap();
        assert!(map.knots.is_empty() && map.varies_p_value.unwrap() > 0.5);
        assert!((map.half_gap - 0.03).abs() < 1e-12);
        // 44 sizes of 1e-4, each twice the half gap
        let half = 1.96 * 1e-4 / 2.0 / 44f64.sqrt();
        assert!(((map.ci95[1] - map.ci95[0]) / 2.0 / half - 1.0).abs() < 1e-3);
        let few = fit(&of(|p| 0.03 + 0.01 * p, 5, 1e-4)).unwrap();
        assert!(few.knots.is_empty() && few.varies_p_value.is_none());
        assert!(fit(&[]).is_none());
    }

    #[test]
    fn sizes_that_scatter_more_than_their_errors_widen_the_interval() {
        let mut sizes = of(|_| 0.03, 44, 1e-4);
        for (i, s) in sizes.iter_mut().enumerate() {
            s.size += 1e-3 * f64::from((i as i32 * 7) % 11 - 5) / 5.0;
        }
        let map = fit(&sizes).unwrap();
        assert!(map.scatter > 3.0, "{}", map.scatter);
        assert!(map.ci95[0] < 0.03 && map.ci95[1] > 0.03);
    }
}
