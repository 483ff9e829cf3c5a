//! A gap that varies: the average of polynomials and PCHIP curves, weighted by how well each explains the data for its size.
//!
//! Method: for a curve with `K` parameters and weighted sum of squares `W` between means and curve, weight
//! `q = -(N ln(SSE + W) + K ln N) / 2`, less `ln C(m-2, K-2)` for the choice of inner knots among `m` candidates (Schwarz 1978;
//! extended for model search by Chen and Chen 2008); averaging as Raftery 1995. `SSE` is the cycles' own sum of squares. The band
//! is `sqrt(sum w (f - h)^2 + s2 sum(w K) / (n R))`: spread between curves and mean variance within them, one figure per
//! place; it is approximate and no pointwise interval.
//!
//! Accuracy on the reference simulator's machine (noise 11 um, 4 cycles), every tested angle within 5 % or 0.0001 deg: 20 of 20 seeds of
//! the noise for its joint A2, 3 of 20 for A5, where an angle's own standard error is 0.00013 deg,
//! more than that tolerance at its minimum (with the true knots known it would be two of three). Below five places nothing is smoothed: the
//! raw means are the knots.

use super::knots::{Data, Tried, search};
use super::polynomial::{self, Fit};
use super::summary::Summary;
use crate::effects::GapCurve;
use crate::effects::curve::Pchip;
use crate::gaps::note::static_test::Remark;
use crate::numerics::fisher;

/// Weight of polynomials above which the readable form is a polynomial.
const POLYNOMIAL: f64 = 0.9;
/// Places below which nothing is smoothed.
const SMOOTHED_FROM: usize = 5;

/// The best single PCHIP curve.
#[derive(Debug, Clone)]
pub struct Readable {
    /// Position and half gap, rad or m.
    pub knots: Vec<[f64; 2]>,
    /// Lack of fit.
    pub p_value: f64,
    pub weight: f64,
}

/// Half gap over position and how it was found; rad or m.
#[derive(Debug, Clone)]
pub struct Schedule {
    /// Knots at all tested places.
    pub all: GapCurve,
    /// Few parameters.
    pub few: GapCurve,
    /// Value and approximate band at each place.
    pub heights: Vec<f64>,
    pub band: Vec<f64>,
    pub readable: Option<Readable>,
    pub polynomials: Vec<Fit>,
    /// The lowest degree that explains the data.
    pub degree: Option<usize>,
    pub polynomial_weight: f64,
    /// Curves that were averaged; 0: raw means.
    pub averaged: usize,
    pub notes: Vec<Remark>,
}

/// Curve of a joint whose gap varies (two places or more).
pub fn build(summary: &Summary) -> Schedule {
    let polynomials = polynomial::fits(summary);
    let degree = polynomial::explaining(&polynomials).map(|f| f.degree);
    if summary.places().len() < SMOOTHED_FROM {
        return raw_means(summary, polynomials, degree);
    }
    let (x, y, r) = (summary.places(), summary.means(), summary.repeats());
    let n = x.len();
    let tried = search(&Data { x: &x, y: &y, r: &r });
    let average = Average::new(summary, &tried, &polynomials);
    let (mean, band) = average.mean_and_band(summary);
    let n_pchip = tried.curves.len();
    let polynomial_weight: f64 = average.weights[n_pchip..].iter().sum();
    let mut notes = Vec::new();
    let heights = not_negative(&mean, &mut notes);
    let readable = average.heaviest(0..n_pchip).map(|i| {
        let c = &tried.curves[i];
        let dof = (n - c.knots.len()) as f64;
        Readable {
            knots: c.knots.iter().zip(&c.heights).map(|(&k, &h)| [x[k], h.max(0.0)]).collect(),
            p_value: fisher::tail(c.left / dof / summary.noise.variance, dof, summary.noise.dof),
            weight: average.weights[i],
        }
    });
    let of_few_knots = readable.as_ref().and_then(|k| Pchip::new(&k.knots)).map(GapCurve::Pchip);
    let all_knots = through(&x, &heights);
    let few = if polynomial_weight > POLYNOMIAL {
        let best = average.heaviest(n_pchip..average.curves.len());
        let curve = best.map(|i| polynomial::curve(&polynomials[i - n_pchip], [x[0], x[n - 1]]));
        curve.filter(|c| c.smallest() >= 0.0)
    } else {
        None
    };
    Schedule {
        few: few.or(of_few_knots).unwrap_or_else(|| all_knots.clone()),
        all: all_knots,
        heights,
        band,
        readable,
        degree,
        polynomial_weight,
        averaged: average.curves.len(),
        notes,
        polynomials,
    }
}

/// The raw means as the curve, where there are too few places to smooth.
fn raw_means(summary: &Summary, polynomials: Vec<Fit>, degree: Option<usize>) -> Schedule {
    let (x, y, r) = (summary.places(), summary.means(), summary.repeats());
    let mut notes = vec![Remark::RawMeans { positions: x.len() }];
    let heights = not_negative(&y, &mut notes);
    let band = r.iter().map(|r| (summary.noise.variance / r).sqrt()).collect();
    let all = through(&x, &heights);
    Schedule {
        few: all.clone(),
        all,
        heights,
        band,
        readable: None,
        polynomials,
        degree,
        polynomial_weight: 0.0,
        averaged: 0,
        notes,
    }
}

/// A curve of the average.
struct Curve<'a> {
    /// Logarithm of its weight, up to a common constant.
    log_weight: f64,
    parameters: usize,
    values: &'a [f64],
}

/// All curves with their weights: PCHIP first, then polynomials.
struct Average<'a> {
    curves: Vec<Curve<'a>>,
    weights: Vec<f64>,
}

impl<'a> Average<'a> {
    fn new(summary: &Summary, tried: &'a Tried, polynomials: &'a [Fit]) -> Self {
        let total = summary.total();
        let sse = summary.noise.variance * summary.noise.dof;
        let size = |k: usize, left: f64| -0.5 * (total * (sse + left).ln() + k as f64 * total.ln());
        let pchip = tried.curves.iter().map(|c| Curve {
            log_weight: size(c.knots.len(), c.left) - ln_choose(tried.candidates - 2, c.knots.len() - 2),
            parameters: c.knots.len(),
            values: &c.values,
        });
        let polynomials = polynomials.iter().map(|f| Curve {
            log_weight: size(f.degree + 1, f.left),
            parameters: f.degree + 1,
            values: &f.values,
        });
        let curves: Vec<Curve> = pchip.chain(polynomials).collect();
        let best = curves.iter().map(|c| c.log_weight).fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = curves.iter().map(|c| (c.log_weight - best).exp()).sum();
        let weights = curves.iter().map(|c| (c.log_weight - best).exp() / sum).collect();
        Self { curves, weights }
    }

    /// Weighted mean and band at each place.
    fn mean_and_band(&self, summary: &Summary) -> (Vec<f64>, Vec<f64>) {
        let weighted = || self.curves.iter().zip(&self.weights);
        let n = summary.places().len();
        let mean: Vec<f64> = (0..n).map(|i| weighted().map(|(c, w)| w * c.values[i]).sum()).collect();
        let parameters: f64 = weighted().map(|(c, w)| w * c.parameters as f64).sum();
        let within = summary.noise.variance * parameters / summary.total();
        let between = |i: usize| weighted().map(|(c, w)| w * (c.values[i] - mean[i]).powi(2)).sum::<f64>();
        let band = (0..n).map(|i| (between(i) + within).sqrt()).collect();
        (mean, band)
    }

    /// The curve of largest weight in `range`; the first of equal ones, as the search's order is fixed.
    fn heaviest(&self, range: std::ops::Range<usize>) -> Option<usize> {
        range.reduce(|a, b| if self.weights[b] > self.weights[a] { b } else { a })
    }
}

/// A gap below zero has no meaning for a play operator: cut at zero, and said.
fn not_negative(values: &[f64], notes: &mut Vec<Remark>) -> Vec<f64> {
    if values.iter().any(|v| *v < 0.0) {
        notes.push(Remark::CutAtZero);
    }
    values.iter().map(|v| v.max(0.0)).collect()
}

fn through(x: &[f64], y: &[f64]) -> GapCurve {
    let knots: Vec<[f64; 2]> = x.iter().zip(y).map(|(&a, &b)| [a, b]).collect();
    let mean = y.iter().sum::<f64>() / y.len().max(1) as f64;
    Pchip::new(&knots).map_or(GapCurve::Constant(mean), GapCurve::Pchip)
}

/// `ln` of the number of ways to choose `k` of `n`.
fn ln_choose(n: usize, k: usize) -> f64 {
    (0..k.min(n)).map(|i| ((n - i) as f64 / (i + 1) as f64).ln()).sum()
}
