//! Gauss-Newton with priors, whitened by an autoregressive noise of first order.

use super::design::{Kind, Layout, Track};
use crate::numerics::normal_equations::scaled_inverse;
use crate::numerics::robust::{SIGMA_PER_MAD, median};
use crate::robot::Robot;
use nalgebra::{DMatrix, DVector};

/// Rounds: the shapes of play and spike depend on their size, the centre of a ballbar moves.
const ROUNDS: usize = 8;
/// Residuals beyond this many standard deviations are gross errors.
const GROSS: f64 = 6.0;
/// Largest autocorrelation that is whitened: beyond it a difference is all that is left.
const MOST: f64 = 0.98;

/// The result.
pub struct Fit {
    pub layout: Layout,
    pub values: DVector<f64>,
    pub covariance: DMatrix<f64>,
    pub dof: f64,
    pub sigma_m: f64,
    pub correlation: f64,
}

/// Fits all parameters; `None` where the normal equations cannot be solved.
pub fn fit(robot: &Robot, tracks: &mut [Track], reversing: &[usize]) -> Option<Fit> {
    let layout = Layout::new(robot, tracks, reversing);
    let k = layout.columns.len();
    let mut values = DVector::zeros(k);
    let (mut correlation, mut sigma) = (0.0, 1e-5);
    let mut covariance = DMatrix::zeros(k, k);
    let mut rows = 0;
    for _ in 0..ROUNDS {
        let mut normal = DMatrix::zeros(k, k);
        let mut right = DVector::zeros(k);
        let system = |(log, track): (usize, &Track)| {
            let (nominal, design) = track.design(robot, &layout, log, values.as_slice());
            let n = nominal.len();
            let matrix = DMatrix::from_fn(n, k, |i, j| design[j][i]);
            (matrix, DVector::from_fn(n, |i, _| track.readings[i] - nominal[i]))
        };
        let systems: Vec<System> = tracks.iter().enumerate().map(system).collect();
        rows = 0;
        for ((matrix, target), track) in systems.iter().zip(tracks.iter()) {
            let keep = kept(&(target - matrix * &values), sigma, values.iter().any(|v| *v != 0.0));
            let (a, y) = whitened(matrix, target, &keep, correlation, track);
            normal += a.transpose() * &a;
            right += a.transpose() * &y;
            rows += a.nrows();
        }
        add_priors(&layout, tracks, sigma * sigma, &mut normal, &mut right);
        let (solved, inverse) = solve(&normal, &right)?;
        values = solved;
        let dof = (rows as f64 - k as f64).max(1.0);
        (sigma, correlation) = noise(&systems, tracks, &values, (sigma, correlation), dof);
        covariance = inverse * (sigma * sigma);
        for (log, track) in tracks.iter_mut().enumerate() {
            track.take_centre(&layout, log, values.as_mut_slice());
        }
    }
    let dof = (rows as f64 - k as f64).max(1.0);
    let sigma_m = sigma / (1.0 - correlation * correlation).sqrt();
    Some(Fit { layout, values, covariance, dof, sigma_m, correlation })
}

/// Design and target of a log, one row per reading.
type System = (DMatrix<f64>, DVector<f64>);

fn add_priors(layout: &Layout, tracks: &[Track], variance: f64, normal: &mut DMatrix<f64>, right: &mut DVector<f64>) {
    for (i, prior) in layout.priors.iter().enumerate().filter(|(_, p)| p.is_finite()) {
        normal[(i, i)] += variance / (prior * prior);
        if let (Kind::Instrument { log }, n) = layout.columns[i] {
            right[i] += variance / (prior * prior) * tracks[log].own_about(n);
        }
    }
}

/// Standard deviation of the innovations and autocorrelation of what `values` leave; `before`: those of the round before.
fn noise(systems: &[System], tracks: &[Track], values: &DVector<f64>, before: (f64, f64), dof: f64) -> (f64, f64) {
    let (mut squares, mut lagged, mut all) = (0.0, 0.0, 0.0);
    for ((matrix, target), track) in systems.iter().zip(tracks) {
        let residual = target - matrix * values;
        let keep = kept(&residual, before.0, true);
        let (a, y) = whitened(matrix, target, &keep, before.1, track);
        squares += (y - a * values).norm_squared();
        for i in 1..residual.len() {
            if keep[i] && keep[i - 1] {
                lagged += residual[i] * residual[i - 1];
                all += residual[i] * residual[i];
            }
        }
    }
    let correlation = if all > 0.0 { (lagged / all).clamp(0.0, MOST) } else { 0.0 };
    ((squares / dof).sqrt().max(1e-9), correlation)
}

/// Rows that are no gross errors.
fn kept(residual: &DVector<f64>, sigma: f64, judged: bool) -> Vec<bool> {
    if !judged {
        return vec![true; residual.len()];
    }
    let values: Vec<f64> = residual.iter().copied().collect();
    let middle = median(&values);
    let off: Vec<f64> = values.iter().map(|v| (v - middle).abs()).collect();
    let limit = GROSS * (SIGMA_PER_MAD * median(&off)).max(0.1 * sigma);
    off.iter().map(|o| *o <= limit).collect()
}

/// Rows less `correlation` times the row before, where both are kept and neighbours in time.
fn whitened(
    matrix: &DMatrix<f64>,
    target: &DVector<f64>,
    keep: &[bool],
    correlation: f64,
    track: &Track,
) -> (DMatrix<f64>, DVector<f64>) {
    let neighbours = |i: usize| i > 0 && keep[i - 1] && track.rows[i] == track.rows[i - 1] + 1;
    let rows: Vec<usize> = (0..target.len()).filter(|&i| keep[i]).collect();
    // the first of a stretch has the whole variance
    let first = (1.0 - correlation * correlation).sqrt();
    let of = |i: usize, value: &dyn Fn(usize) -> f64| {
        if neighbours(i) { value(i) - correlation * value(i - 1) } else { first * value(i) }
    };
    let a = DMatrix::from_fn(rows.len(), matrix.ncols(), |r, c| of(rows[r], &|i| matrix[(i, c)]));
    let y = DVector::from_fn(rows.len(), |r, _| of(rows[r], &|i| target[i]));
    (a, y)
}

/// Solution and inverse of normal equations whose columns differ in scale.
fn solve(normal: &DMatrix<f64>, right: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
    // columns that the readings do not tell apart stay open, and their variance says so
    let inverse = scaled_inverse(normal, 1e-10)?.inverse;
    Some((&inverse * right, inverse))
}
