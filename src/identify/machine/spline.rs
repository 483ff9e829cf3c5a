//! Natural cubic splines in their cardinal form: the value at a place is a weighted sum of the values at the knots.
//!
//! A gap over position is linear in its knots that way, so its knots are fitted like any other linear parameter. Beyond the
//! outer knots the curve is constant. Reference: de Boor (1978), chapter IV.

use crate::log::Log;
use crate::numerics::robust::range;
use nalgebra::DMatrix;

/// Evenly spaced knots.
#[derive(Debug, Clone)]
pub struct Spline {
    low: f64,
    step: f64,
    /// Second derivatives at the knots per unit value of each knot.
    bend: DMatrix<f64>,
}

impl Spline {
    /// `knots` of 1 or more between `low` and `high`; one knot is a constant.
    pub fn new(low: f64, high: f64, knots: usize) -> Self {
        let n = knots.max(1);
        let step = if n > 1 { (high - low) / (n - 1) as f64 } else { 0.0 };
        if n < 2 || step <= 0.0 {
            return Self { low, step: 0.0, bend: DMatrix::zeros(1, 1) };
        }
        // (M[i-1] + 4 M[i] + M[i+1]) h^2 / 6 = y[i-1] - 2 y[i] + y[i+1], M = 0 at both ends
        let mut system = DMatrix::identity(n, n);
        let mut right = DMatrix::zeros(n, n);
        for i in 1..n - 1 {
            for (k, (m, y)) in [(1.0, 1.0), (4.0, -2.0), (1.0, 1.0)].into_iter().enumerate() {
                system[(i, i + k - 1)] = m;
                right[(i, i + k - 1)] = 6.0 * y / (step * step);
            }
        }
        let bend = system.lu().solve(&right).unwrap_or_else(|| DMatrix::zeros(n, n));
        Self { low, step, bend }
    }

    /// `knots` over the travel of an axis in all logs.
    pub fn over_travel<'a>(logs: impl Iterator<Item = &'a Log>, axis: usize, knots: usize) -> Self {
        let [low, high] = range(logs.flat_map(|l| l.cmd[axis].iter().copied()));
        Self::new(low, high, knots)
    }

    pub fn knots(&self) -> usize {
        self.bend.nrows()
    }

    /// Position of a knot.
    pub fn knot(&self, k: usize) -> f64 {
        self.low + self.step * k as f64
    }

    /// Weights of the knots at `x`.
    pub fn weights(&self, x: f64, out: &mut [f64]) {
        out.fill(0.0);
        let n = self.knots();
        if n == 1 {
            out[0] = 1.0;
            return;
        }
        let u = ((x - self.low) / self.step).clamp(0.0, (n - 1) as f64);
        let i = (u as usize).min(n - 2);
        let b = u - i as f64;
        let a = 1.0 - b;
        out[i] += a;
        out[i + 1] += b;
        let (ca, cb) = ((a * a * a - a) * self.step * self.step / 6.0, (b * b * b - b) * self.step * self.step / 6.0);
        for (k, w) in out.iter_mut().enumerate() {
            *w += ca * self.bend[(i, k)] + cb * self.bend[(i + 1, k)];
        }
    }

    /// Value at `x` for the values at the knots.
    pub fn at(&self, x: f64, values: &[f64]) -> f64 {
        let mut w = vec![0.0; self.knots()];
        self.weights(x, &mut w);
        w.iter().zip(values).map(|(a, b)| a * b).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_its_knots_and_keeps_straight_lines() {
        let s = Spline::new(-1.0, 2.0, 7);
        let bent: Vec<f64> = (0..7).map(|k| f64::from(k * k)).collect();
        for (k, v) in bent.iter().enumerate() {
            assert!((s.at(s.knot(k), &bent) - v).abs() < 1e-12);
        }
        let line: Vec<f64> = (0..7).map(|k| 3.0 + 2.0 * s.knot(k)).collect();
        assert!((s.at(0.123, &line) - 3.246).abs() < 1e-12);
        assert!((s.at(9.0, &line) - 7.0).abs() < 1e-12, "constant beyond the last knot");
    }

    #[test]
    fn follows_a_wave_between_its_knots() {
        let s = Spline::new(0.0, 6.0, 13);
        let wave: Vec<f64> = (0..13).map(|k| s.knot(k).sin()).collect();
        // the second derivative of a sine is zero at 0 only, so the other end is left out
        let worst = (0..500).map(|i| f64::from(i) * 0.01).map(|x| (s.at(x, &wave) - x.sin()).abs()).fold(0.0, f64::max);
        assert!(worst < 2e-3, "{worst}");
    }
}
