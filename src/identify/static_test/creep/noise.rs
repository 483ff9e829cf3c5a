//! Covariance of a pair's bins: `s2 (diag(white) + repeat 11' + walk min(t, t'))`.
//!
//! Method: restricted maximum likelihood over a grid of the two ratios, `s2` profiled; the mean is left wide open (an offset
//! per place and four exponentials), so that creep does not count as noise. The walk stands for the slow part of the
//! tracker's noise and of the arm's wander; repeatability for what changes from cycle to cycle.

use super::series::PairSeries;
use nalgebra::{DMatrix, DVector};

/// Exponentials of the open mean, s.
const OPEN_PACES_S: [f64; 4] = [0.15, 0.6, 2.4, 10.0];
/// Tried ratios: repeatability over the variance of a sample, and variance of the walk per second over it.
const REPEAT: [f64; 8] = [0.0, 1e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 10.0];
const WALK: [f64; 7] = [0.0, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3];

/// The covariance of a joint's pairs.
#[derive(Debug, Clone, Copy)]
pub struct CreepNoise {
    /// Variance of one sample, (rad or m)^2.
    pub variance: f64,
    pub repeat: f64,
    pub walk: f64,
}

/// Columns of a pair after whitening by the inverse Cholesky factor.
pub struct Whitened {
    pub place: usize,
    pub one: DVector<f64>,
    pub value: DVector<f64>,
    factor: DMatrix<f64>,
    log_det: f64,
}

impl Whitened {
    pub fn new(pair: &PairSeries, noise: &CreepNoise) -> Option<Self> {
        let n = pair.bins.len();
        let from = pair.bins.first()?.at_s;
        let v = DMatrix::from_fn(n, n, |i, j| {
            let (a, b) = (&pair.bins[i], &pair.bins[j]);
            let white = if i == j { a.white } else { 0.0 };
            noise.variance * (white + noise.repeat + noise.walk * (a.at_s.min(b.at_s) - from))
        });
        let factor = v.cholesky()?.unpack();
        let log_det = 2.0 * factor.diagonal().iter().map(|d| d.ln()).sum::<f64>();
        let mut out = Self { place: pair.place, one: DVector::zeros(0), value: DVector::zeros(0), factor, log_det };
        out.one = out.whiten(std::iter::repeat_n(1.0, n))?;
        out.value = out.whiten(pair.bins.iter().map(|b| b.value))?;
        Some(out)
    }

    pub fn whiten(&self, column: impl Iterator<Item = f64>) -> Option<DVector<f64>> {
        let column = DVector::from_iterator(self.factor.nrows(), column);
        self.factor.solve_lower_triangular(&column)
    }
}

/// Pairs that can be used, whitened.
pub fn whitened(pairs: &[PairSeries], noise: &CreepNoise) -> Option<Vec<Whitened>> {
    pairs.iter().filter(|p| !p.bins.is_empty()).map(|p| Whitened::new(p, noise)).collect()
}

/// Noise of a joint; `None` where the samples leave nothing to estimate it from.
pub fn estimate(pairs: &[PairSeries], places: usize) -> Option<CreepNoise> {
    let mut best: Option<(f64, CreepNoise)> = None;
    for walk in WALK {
        for repeat in REPEAT {
            let trial = CreepNoise { variance: 1.0, repeat, walk };
            let Some((likelihood, variance)) = likelihood(pairs, places, &trial) else { continue };
            if best.is_none_or(|(b, _)| likelihood > b) {
                best = Some((likelihood, CreepNoise { variance, repeat, walk }));
            }
        }
    }
    best.map(|(_, noise)| noise)
}

/// Restricted log likelihood with the scale profiled, and that scale.
fn likelihood(pairs: &[PairSeries], places: usize, trial: &CreepNoise) -> Option<(f64, f64)> {
    let used: Vec<&PairSeries> = pairs.iter().filter(|p| !p.bins.is_empty()).collect();
    let k = places + OPEN_PACES_S.len();
    let mut normal = DMatrix::<f64>::zeros(k, k);
    let mut right = DVector::<f64>::zeros(k);
    let (mut sum, mut log_det, mut rows) = (0.0, 0.0, 0usize);
    for pair in used {
        let w = Whitened::new(pair, trial)?;
        let columns: Vec<DVector<f64>> =
            OPEN_PACES_S.iter().map(|&tau| w.whiten(pair.in_bins(tau, false))).collect::<Option<_>>()?;
        let place = w.place;
        normal[(place, place)] += w.one.dot(&w.one);
        right[place] += w.one.dot(&w.value);
        for (i, a) in columns.iter().enumerate() {
            let row = places + i;
            let cross = a.dot(&w.one);
            normal[(row, place)] += cross;
            normal[(place, row)] += cross;
            right[row] += a.dot(&w.value);
            for (j, b) in columns.iter().enumerate() {
                normal[(row, places + j)] += a.dot(b);
            }
        }
        sum += w.value.dot(&w.value);
        log_det += w.log_det;
        rows += w.value.len();
    }
    // a ridge far below the data keeps nearly equal exponentials solvable
    let trace = (0..k).map(|i| normal[(i, i)]).fold(0.0, f64::max);
    for i in 0..k {
        normal[(i, i)] += 1e-9 * trace;
    }
    let dof = rows.checked_sub(k).filter(|d| *d > 1)? as f64;
    let cholesky = normal.cholesky()?;
    let left = sum - right.dot(&cholesky.solve(&right));
    if left <= 0.0 || !left.is_finite() {
        return None;
    }
    let variance = left / dof;
    let of_normal: f64 = 2.0 * cholesky.l().diagonal().iter().map(|d| d.ln()).sum::<f64>();
    Some((-0.5 * (dof * variance.ln() + log_det + of_normal), variance))
}
