//! Reweighted rounds ([`crate::numerics::least_squares::reweighted`]) with priors, whitened by an autoregressive noise of first order.

use super::design::{Kind, Layout, Track};
use crate::numerics::least_squares::{Dense, Flow, LinearModel, Reweighted, TerminationReason, ridge_weights, rounds};
use crate::numerics::robust::{SIGMA_PER_MAD, median};
use crate::robot::Robot;
use nalgebra::{DMatrix, DVector};
use std::convert::Infallible;

/// Rounds at most: the shapes of play and spike depend on their size, the centre of a ballbar moves.
const ROUNDS: usize = 40;
/// A round that moves no parameter by more than this many of its standard deviations is the last.
const SETTLED: f64 = 0.01;
/// Residuals beyond this many standard deviations are gross errors.
const GROSS: f64 = 6.0;
/// Share of what the rows know of a parameter by which it is held back; an open direction gets a variance 1e10 times that of a known one.
const RIDGE: f64 = 1e-10;
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
    /// What the last round still moved each parameter by, where the rounds did not settle.
    pub unsettled: Option<DVector<f64>>,
}

/// Fits all parameters; `None` where the rows cannot be solved.
pub fn fit(robot: &Robot, tracks: &mut [Track], reversing: &[usize]) -> Option<Fit> {
    let layout = Layout::new(robot, tracks, reversing);
    let k = layout.columns.len();
    let values = DVector::zeros(k);
    let covariance = DMatrix::zeros(k, k);
    let mut present = Present {
        robot,
        tracks,
        layout,
        values,
        sigma: 1e-5,
        correlation: 0.0,
        covariance,
        systems: Vec::new(),
        rows: 0,
        moved: DVector::zeros(k),
    };
    let Ok(reason) = rounds(&mut present, ROUNDS);
    if reason == TerminationReason::NotFinite {
        return None;
    }
    let dof = present.dof();
    let Present { layout, values, sigma, correlation, covariance, moved, .. } = present;
    let sigma_m = sigma / (1.0 - correlation * correlation).sqrt();
    let unsettled = (!reason.converged()).then_some(moved);
    Some(Fit { layout, values, covariance, dof, sigma_m, correlation, unsettled })
}

/// Design and target of a log, one row per reading.
type System = (DMatrix<f64>, DVector<f64>);

/// The present estimate of parameters and noise.
struct Present<'a> {
    robot: &'a Robot,
    tracks: &'a mut [Track],
    layout: Layout,
    values: DVector<f64>,
    /// Standard deviation of the innovations, m.
    sigma: f64,
    correlation: f64,
    covariance: DMatrix<f64>,
    systems: Vec<System>,
    /// Number of readings that count.
    rows: usize,
    /// What the last round moved each parameter by.
    moved: DVector<f64>,
}

impl Present<'_> {
    fn dof(&self) -> f64 {
        (self.rows as f64 - self.values.len() as f64).max(1.0)
    }

    /// Rows of the priors: parameter, weight, and what the parameter differs by.
    fn priors(&self) -> Vec<(usize, f64, f64)> {
        let row = |(k, prior): (usize, &f64)| {
            let about = match self.layout.columns[k] {
                (Kind::Instrument { log }, n) => self.tracks[log].own_about(n),
                _ => 0.0,
            };
            (k, self.sigma / prior, self.values[k] - about)
        };
        self.layout.priors.iter().enumerate().filter(|(_, p)| p.is_finite()).map(row).collect()
    }
}

impl Reweighted for Present<'_> {
    type Model = Dense;
    type Failure = Infallible;

    fn linearise(&mut self) -> Result<Dense, Infallible> {
        let k = self.values.len();
        let system = |(log, track): (usize, &Track)| {
            let (nominal, design) = track.design(self.robot, &self.layout, log, self.values.as_slice());
            let n = nominal.len();
            let matrix = DMatrix::from_fn(n, k, |i, j| design[j][i]);
            (matrix, DVector::from_fn(n, |i, _| track.readings[i] - nominal[i]))
        };
        self.systems = self.tracks.iter().enumerate().map(system).collect();
        let judged = self.values.iter().any(|v| *v != 0.0);
        let white = |((matrix, target), track): (&System, &Track)| {
            let keep = kept(&(target - matrix * &self.values), self.sigma, judged);
            whitened(matrix, target, &keep, self.correlation, track)
        };
        let blocks: Vec<System> = self.systems.iter().zip(self.tracks.iter()).map(white).collect();
        self.rows = blocks.iter().map(|(a, _)| a.nrows()).sum();
        let priors = self.priors();
        let mut jacobian = DMatrix::zeros(self.rows + priors.len() + k, k);
        let mut residual = vec![0.0; jacobian.nrows()];
        let mut at = 0;
        for (a, y) in &blocks {
            jacobian.rows_mut(at, a.nrows()).copy_from(a);
            residual[at..at + a.nrows()].copy_from_slice((a * &self.values - y).as_slice());
            at += a.nrows();
        }
        for (column, weight, off) in priors {
            jacobian[(at, column)] = weight;
            residual[at] = weight * off;
            at += 1;
        }
        // columns that the readings do not tell apart stay open, and their variance says so
        let norms: Vec<f64> = jacobian.column_iter().map(|c| c.norm()).collect();
        for (column, weight) in ridge_weights(norms, RIDGE).into_iter().enumerate() {
            jacobian[(at, column)] = weight;
            residual[at] = weight * self.values[column];
            at += 1;
        }
        Ok(Dense::new(jacobian, &residual))
    }

    fn take(&mut self, model: &Dense, step: &[f64], round: usize) -> Flow {
        self.values.iter_mut().zip(step).for_each(|(v, s)| *v += s);
        let before = (self.sigma, self.correlation);
        (self.sigma, self.correlation) = noise(&self.systems, self.tracks, &self.values, before, self.dof());
        self.covariance = model.information().inverse * (self.sigma * self.sigma);
        for (log, track) in self.tracks.iter_mut().enumerate() {
            track.take_centre(&self.layout, log, self.values.as_mut_slice());
        }
        self.moved = DVector::from_iterator(step.len(), step.iter().map(|s| s.abs()));
        let at_rest = |k: usize| self.moved[k] <= SETTLED * self.covariance[(k, k)].max(0.0).sqrt();
        // the first rounds have no gross errors and no correlation to go by
        if round > 1 && (0..step.len()).all(at_rest) { Flow::Reached } else { Flow::Continue }
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
