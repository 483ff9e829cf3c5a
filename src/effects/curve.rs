//! A half gap as a function of the commanded position: constant, polynomial, or PCHIP through knots.
//!
//! PCHIP: monotone piecewise cubic Hermite interpolation (Fritsch and Carlson 1980, end slopes as Moler 2004), the same
//! as `scipy.interpolate.PchipInterpolator`. Beyond its knots, or its tested range, a curve is constant.

/// Share of the largest half gap that a polynomial may lose as its coefficients are rounded.
const LOST_IN_ROUNDING: f64 = 1e-4;
/// Knots of a polynomial that becomes a curve through knots: 2.5 % of its range apart, so that even a maximum is met to about
/// 1e-3 of the curve's change.
const CURVE_KNOTS: usize = 41;

/// Half gap over position; arguments and values in rad or m.
#[derive(Debug, Clone, PartialEq)]
pub enum GapCurve {
    /// The same half gap everywhere.
    Constant(f64),
    /// `sum c_k p^k`, held constant outside `range`.
    Polynomial {
        /// Coefficients by rising power.
        coefficients: Vec<f64>,
        /// First and last position that was tested.
        range: [f64; 2],
    },
    /// A monotone cubic through knots.
    Pchip(Pchip),
}

impl GapCurve {
    /// Half gap at position `p`.
    #[inline]
    pub fn at(&self, p: f64) -> f64 {
        match self {
            Self::Constant(b) => *b,
            Self::Polynomial { coefficients, range } => {
                let x = p.clamp(range[0], range[1]);
                coefficients.iter().rev().fold(0.0, |s, c| s * x + c)
            }
            Self::Pchip(c) => c.at(p),
        }
    }

    /// The curve with a constant added.
    pub fn raised(&self, by: f64) -> Self {
        match self {
            Self::Constant(b) => Self::Constant(b + by),
            Self::Polynomial { coefficients, range } => {
                let mut coefficients = coefficients.clone();
                if let Some(c) = coefficients.first_mut() {
                    *c += by;
                }
                Self::Polynomial { coefficients, range: *range }
            }
            Self::Pchip(c) => {
                let mut c = c.clone();
                c.y.iter_mut().for_each(|y| *y += by);
                Self::Pchip(c)
            }
        }
    }

    /// The curve as a document can hold it whose numbers have `digits` significant digits: a polynomial of positions far from 0 in
    /// proportion to its range has large terms that cancel, and loses its value with the last digits. It becomes knots.
    pub fn for_digits(&self, digits: i32) -> Self {
        let Self::Polynomial { coefficients, range: [lo, hi] } = self else { return self.clone() };
        let far = lo.abs().max(hi.abs());
        let terms: f64 = coefficients.iter().enumerate().map(|(k, c)| c.abs() * far.powi(k as i32)).sum();
        if terms * 0.5 * 10f64.powi(1 - digits) <= LOST_IN_ROUNDING * self.largest().abs() {
            return self.clone();
        }
        self.through_knots(|p| self.at(p))
    }

    /// [`CURVE_KNOTS`] knots of `value` over the range of a polynomial; other curves stay.
    pub fn through_knots(&self, value: impl Fn(f64) -> f64) -> Self {
        let Self::Polynomial { range: [lo, hi], .. } = self else { return self.clone() };
        let step = (hi - lo) / (CURVE_KNOTS - 1) as f64;
        let places = (0..CURVE_KNOTS).map(|k| if k + 1 == CURVE_KNOTS { *hi } else { lo + step * k as f64 });
        let knots: Vec<[f64; 2]> = places.map(|p| [p, value(p)]).collect();
        Pchip::new(&knots).map_or_else(|| self.clone(), Self::Pchip)
    }

    /// The value, where it is one everywhere.
    pub fn constant(&self) -> Option<f64> {
        if let Self::Constant(b) = self { Some(*b) } else { None }
    }

    /// Largest value: at knots for PCHIP (it does not overshoot), on a grid of 1,000 points for a polynomial.
    pub fn largest(&self) -> f64 {
        match self {
            Self::Constant(b) => *b,
            Self::Polynomial { range: [lo, hi], .. } => {
                (0..=1000).map(|k| self.at(lo + (hi - lo) * f64::from(k) / 1000.0)).fold(f64::NEG_INFINITY, f64::max)
            }
            Self::Pchip(c) => c.y.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        }
    }

    /// Smallest value, found in the same way.
    pub fn smallest(&self) -> f64 {
        match self {
            Self::Constant(b) => *b,
            Self::Polynomial { range: [lo, hi], .. } => {
                (0..=1000).map(|k| self.at(lo + (hi - lo) * f64::from(k) / 1000.0)).fold(f64::INFINITY, f64::min)
            }
            Self::Pchip(c) => c.y.iter().copied().fold(f64::INFINITY, f64::min),
        }
    }
}

/// PCHIP through knots with strictly rising positions.
#[derive(Debug, Clone, PartialEq)]
pub struct Pchip {
    x: Vec<f64>,
    y: Vec<f64>,
    slope: Vec<f64>,
}

impl Pchip {
    /// At least two finite knots with strictly rising positions, else `None`.
    pub fn new(knots: &[[f64; 2]]) -> Option<Self> {
        let rising = knots.windows(2).all(|w| w[0][0] < w[1][0]);
        if knots.len() < 2 || !rising || knots.iter().flatten().any(|v| !v.is_finite()) {
            return None;
        }
        let (x, y): (Vec<f64>, Vec<f64>) = knots.iter().map(|k| (k[0], k[1])).unzip();
        let mut slope = vec![0.0; x.len()];
        slopes(&x, &y, &mut slope);
        Some(Self { x, y, slope })
    }

    /// Knots `[position, value]`.
    pub fn knots(&self) -> Vec<[f64; 2]> {
        self.x.iter().zip(&self.y).map(|(&x, &y)| [x, y]).collect()
    }

    /// Value at `p`, constant beyond the knots.
    pub fn at(&self, p: f64) -> f64 {
        let n = self.x.len();
        if p <= self.x[0] {
            return self.y[0];
        }
        if p >= self.x[n - 1] {
            return self.y[n - 1];
        }
        let i = self.x.partition_point(|&x| x <= p) - 1;
        let h = self.x[i + 1] - self.x[i];
        let s = (p - self.x[i]) / h;
        let (s2, s3) = (s * s, s * s * s);
        let value = (2.0 * s3 - 3.0 * s2 + 1.0) * self.y[i]
            + (s3 - 2.0 * s2 + s) * h * self.slope[i]
            + (3.0 * s2 - 2.0 * s3) * self.y[i + 1]
            + (s3 - s2) * h * self.slope[i + 1];
        // monotone between two knots; rounding could dip below a knot of zero
        value.clamp(self.y[i].min(self.y[i + 1]), self.y[i].max(self.y[i + 1]))
    }
}

/// Slopes of the curve at its knots, at least two, without an allocation.
pub(crate) fn slopes(x: &[f64], y: &[f64], slope: &mut [f64]) {
    let n = x.len();
    let h = |i: usize| x[i + 1] - x[i];
    let d = |i: usize| (y[i + 1] - y[i]) / h(i);
    if n == 2 {
        return slope[..2].fill(d(0));
    }
    for i in 1..n - 1 {
        let (h0, h1, d0, d1) = (h(i - 1), h(i), d(i - 1), d(i));
        let (w1, w2) = (2.0 * h1 + h0, h1 + 2.0 * h0);
        slope[i] = if d0 * d1 > 0.0 { (w1 + w2) / (w1 / d0 + w2 / d1) } else { 0.0 };
    }
    slope[0] = end_slope(h(0), h(1), d(0), d(1));
    slope[n - 1] = end_slope(h(n - 2), h(n - 3), d(n - 2), d(n - 3));
}

/// Three-point end slope that keeps the shape.
fn end_slope(h0: f64, h1: f64, d0: f64, d1: f64) -> f64 {
    let s = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
    if s * d0 <= 0.0 {
        0.0
    } else if d0 * d1 <= 0.0 && s.abs() > 3.0 * d0.abs() {
        3.0 * d0
    } else {
        s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `1 + u + u^2` on a range of half width 1 about `center`, by powers of the position.
    fn parabola(center: f64) -> GapCurve {
        let coefficients = vec![1.0 - center + center * center, 1.0 - 2.0 * center, 1.0];
        GapCurve::Polynomial { coefficients, range: [center - 1.0, center + 1.0] }
    }

    #[test]
    fn a_polynomial_that_rounding_would_spoil_becomes_knots_and_another_one_stays() {
        assert_eq!(parabola(3.0).for_digits(10), parabola(3.0));
        let far = parabola(2e3);
        let kept = far.for_digits(10);
        assert!(matches!(&kept, GapCurve::Pchip(c) if c.knots().len() == CURVE_KNOTS), "{kept:?}");
        for k in 0..=100 {
            let p = 1999.0 + f64::from(k) * 0.02;
            assert!((kept.at(p) - far.at(p)).abs() < 2e-3, "{p}: {} {}", kept.at(p), far.at(p));
        }
        let endless = GapCurve::Polynomial { coefficients: vec![1.0, 0.5], range: [f64::MIN, f64::MAX] };
        assert_eq!(endless.for_digits(10), endless, "no range to place knots in");
    }
}
