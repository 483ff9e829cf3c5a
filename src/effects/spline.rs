//! A natural cubic spline, constant beyond its knots: linear in its values, which PCHIP is not.
//!
//! Method: second derivatives at the knots from the tridiagonal equations (de Boor 1978, A Practical Guide to Splines; Thomas'
//! algorithm).

use super::GapCurve;
use super::curve::Pchip;

/// A natural cubic spline through knots with rising arguments, constant beyond them.
#[derive(Debug, Clone, PartialEq)]
pub struct Spline {
    x: Vec<f64>,
    y: Vec<f64>,
    /// Second derivatives at the knots.
    second: Vec<f64>,
}

/// Points of a curve that stands for a spline where a document joins by PCHIP.
const SAMPLES: usize = 41;

impl Spline {
    /// `None` where the arguments do not rise, or a number is not finite.
    pub fn new(x: Vec<f64>, y: Vec<f64>) -> Option<Self> {
        let rising = x.windows(2).all(|w| w[0] < w[1]);
        if x.len() < 2 || x.len() != y.len() || !rising || x.iter().chain(&y).any(|v| !v.is_finite()) {
            return None;
        }
        let n = x.len();
        let mut second = vec![0.0; n];
        // Thomas' algorithm for the inner knots: h0 s0 + 2 (h0 + h1) s1 + h1 s2 = 6 (d1 - d0)
        let (mut c, mut r) = (vec![0.0; n], vec![0.0; n]);
        for i in 1..n - 1 {
            let (h0, h1) = (x[i] - x[i - 1], x[i + 1] - x[i]);
            let right = 6.0 * ((y[i + 1] - y[i]) / h1 - (y[i] - y[i - 1]) / h0);
            let pivot = 2.0 * (h0 + h1) - h0 * c[i - 1];
            c[i] = h1 / pivot;
            r[i] = (right - h0 * r[i - 1]) / pivot;
        }
        for i in (1..n - 1).rev() {
            second[i] = r[i] - c[i] * second[i + 1];
        }
        Some(Self { x, y, second })
    }

    /// Value at an argument.
    pub fn at(&self, at: f64) -> f64 {
        let n = self.x.len();
        let at = at.clamp(self.x[0], self.x[n - 1]);
        let i = self.x.partition_point(|&x| x <= at).clamp(1, n - 1) - 1;
        let h = self.x[i + 1] - self.x[i];
        let (a, b) = ((self.x[i + 1] - at) / h, (at - self.x[i]) / h);
        let bend = (a * a * a - a) * self.second[i] + (b * b * b - b) * self.second[i + 1];
        a * self.y[i] + b * self.y[i + 1] + bend * h * h / 6.0
    }

    /// The curve times a factor, as PCHIP through points of it.
    pub fn sampled(&self, factor: f64) -> Option<GapCurve> {
        let (lo, hi) = (self.x[0], *self.x.last()?);
        let last = (SAMPLES - 1) as f64;
        let place = |k: usize| lo + (hi - lo) * k as f64 / last;
        let knots: Vec<[f64; 2]> = (0..SAMPLES).map(|k| [place(k), factor * self.at(place(k))]).collect();
        Pchip::new(&knots).map(GapCurve::Pchip)
    }

    /// The same places with other values.
    pub fn with_values(&self, y: Vec<f64>) -> Option<Self> {
        Self::new(self.x.clone(), y)
    }

    /// Number of knots.
    pub fn knots(&self) -> usize {
        self.x.len()
    }

    /// Argument of a knot.
    pub fn place(&self, knot: usize) -> f64 {
        self.x[knot]
    }

    /// Value at a knot.
    pub fn value(&self, knot: usize) -> f64 {
        self.y[knot]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spline_through_a_line_is_the_line_and_constant_beyond() {
        let s = Spline::new(vec![-1.0, 0.0, 3.0], vec![1.0, 2.0, 5.0]).unwrap();
        assert!([-1.0, -0.3, 1.7, 3.0].iter().all(|&x| (s.at(x) - (x + 2.0)).abs() < 1e-14));
        assert_eq!((s.at(-9.0), s.at(9.0)), (1.0, 5.0));
    }

    #[test]
    fn a_spline_matches_the_textbook() {
        // scipy.interpolate.CubicSpline([0, 1, 2, 4], [0, 1, 0, 2], bc_type="natural")(1.5) and (3.0)
        let s = Spline::new(vec![0.0, 1.0, 2.0, 4.0], vec![0.0, 1.0, 0.0, 2.0]).unwrap();
        assert!((s.at(1.5) - SCIPY[0]).abs() < 1e-12 && (s.at(3.0) - SCIPY[1]).abs() < 1e-12);
    }

    const SCIPY: [f64; 2] = [0.5652173913043478, 0.3478260869565218];
}
