//! Polynomials of the gap over position, with the test of what each degree leaves (lack of fit; ISO 230-2 practice, Slamani (2012)).
//!
//! Method: weighted least squares in Legendre polynomials on -1..1 by QR; the residual of the places' means against the pure
//! error is F distributed with `n - K` and `nu` degrees of freedom if the polynomial is right.

use super::summary::{Summary, mapped};
use crate::effects::GapCurve;
use crate::numerics::{fisher, legendre};
use nalgebra::{DMatrix, DVector};

/// Highest degree that is tried.
const HIGHEST: usize = 9;
/// A degree whose lack of fit has a p value above this explains the data.
const EXPLAINS: f64 = 0.05;

/// One degree.
#[derive(Debug, Clone)]
pub struct Fit {
    pub degree: usize,
    /// Legendre coefficients on -1..1, rad or m.
    pub legendre: Vec<f64>,
    /// Values at the places.
    pub values: Vec<f64>,
    /// `sum R_i (y_i - f_i)^2`.
    pub left: f64,
    pub f: f64,
    pub dof: [f64; 2],
    pub p_value: f64,
}

/// All degrees that the places allow, from 0; empty below three places.
pub fn fits(summary: &Summary) -> Vec<Fit> {
    let (x, y, r) = (summary.places(), summary.means(), summary.repeats());
    let n = x.len();
    let Some(highest) = n.checked_sub(3).map(|h| h.min(HIGHEST)) else { return Vec::new() };
    let u = mapped(&x);
    let weighted = DVector::from_fn(n, |i, _| r[i].sqrt() * y[i]);
    let mut fits = Vec::new();
    for degree in 0..=highest {
        let k = degree + 1;
        let design = DMatrix::from_fn(n, k, |i, j| legendre::value(j, u[i]));
        let scaled = DMatrix::from_fn(n, k, |i, j| r[i].sqrt() * design[(i, j)]);
        let qr = scaled.qr();
        let Some(c) = qr.r().solve_upper_triangular(&(qr.q().transpose() * &weighted)) else { break };
        let values = &design * &c;
        let left: f64 = (0..n).map(|i| r[i] * (y[i] - values[i]).powi(2)).sum();
        let dof = [(n - k) as f64, summary.noise.dof];
        let f = left / dof[0] / summary.noise.variance;
        fits.push(Fit {
            degree,
            legendre: c.iter().copied().collect(),
            values: values.iter().copied().collect(),
            left,
            f,
            dof,
            p_value: fisher::tail(f, dof[0], dof[1]),
        });
    }
    fits
}

/// The lowest degree that explains the data.
pub fn explaining(fits: &[Fit]) -> Option<&Fit> {
    fits.iter().find(|f| f.p_value > EXPLAINS)
}

/// The fit as `sum c_k p^k` over the tested range.
pub fn curve(fit: &Fit, range: [f64; 2]) -> GapCurve {
    let coefficients = legendre::in_powers(&fit.legendre, range);
    GapCurve::Polynomial { coefficients, range }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_position_give_the_same_values_as_legendre() {
        let fit = Fit {
            degree: 4,
            legendre: vec![3e-5, -1e-5, 2e-5, 5e-6, -7e-6],
            values: vec![],
            left: 0.0,
            f: 0.0,
            dof: [1.0, 1.0],
            p_value: 1.0,
        };
        let range = [-1.9, 0.2];
        let curve = curve(&fit, range);
        for i in 0..=10 {
            let p = range[0] + (range[1] - range[0]) * f64::from(i) / 10.0;
            let u = (2.0 * p - range[0] - range[1]) / (range[1] - range[0]);
            let want: f64 = fit.legendre.iter().enumerate().map(|(k, c)| c * legendre::value(k, u)).sum();
            assert!((curve.at(p) - want).abs() < 1e-18, "{p}");
        }
    }
}
