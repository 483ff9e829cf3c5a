//! Gauss-Newton rounds, noise and discarded bins, alternately.

use super::law::{Response, WINDUPS};
use super::noise::Noise;
use super::problem::Problem;
use crate::machine::measurement::Instrument;
use crate::numerics::least_squares::{LinearModel, Products};
use crate::numerics::parallel::ParMap;
use crate::numerics::robust::{SIGMA_PER_MAD, median_of};
use nalgebra::{DMatrix, DVector, Vector3};

/// Gauss-Newton steps in a round, at most.
const STEPS: usize = 6;
/// The same of a trial.
const TRIAL_STEPS: usize = 4;
/// Share of wind-up in gap and wind-up together from which a gap is tried in its place.
const MUCH_WINDUP: f64 = 0.2;
/// Relative fall of the cost below which a round ends.
const SETTLED: f64 = 1e-4;
/// The same of the fall that a step promises: it is not worth a trial.
const NOTHING_LEFT: f64 = 1e-5;
/// Largest change of the logarithm of a presliding in one step.
const LOG_STEP: f64 = 0.7;

/// What the laws miss, as a share of lost motion: single reversals scatter by 1 to 8 %, and laws of this form leave 1 to 13 % of the error
/// of joints whose friction is of another form, without any noise.
const MISSED: f64 = 0.1;

/// Bins on either side that a bin is compared with, and standard deviations beyond which it is an outlier.
const NEIGHBOURS: usize = 3;
const OUTLIER: f64 = 6.0;

/// What a round leaves as it stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FixedLaws {
    Nothing,
    /// Gap and wind-up explain nearly the same, so a fit that starts with both may end with a wind-up instead of a gap.
    Friction,
    /// Every law: nuisances alone are fitted.
    Laws,
}

/// Runs one round; returns the cost.
pub fn round(problem: &mut Problem, kept: FixedLaws) -> f64 {
    steps(problem, kept, STEPS)
}

/// Tries a gap where a joint has much wind-up, and keeps what explains the logs better.
///
/// A gap and a wind-up explain nearly the same, so the cost has a valley for each, and which one the first rounds find depends on
/// where they start. In the other valley the joint's lost motion just after a reversal is wrong by up to its whole size.
pub fn other_valleys(problem: &mut Problem) {
    for axis in 0..problem.laws.len() {
        problem.refresh_sizes();
        let (values, cost) = (problem.values(), problem.cost());
        let Some(law) = &mut problem.laws[axis] else { continue };
        let (windup, knots) = (law.windup(), law.gap.len() as f64);
        let gap = law.gap.iter().sum::<f64>() / knots;
        if windup < MUCH_WINDUP * (gap + windup) {
            continue;
        }
        law.gap.iter_mut().for_each(|g| *g += windup);
        law.windups = [0.0; WINDUPS];
        if steps(problem, FixedLaws::Nothing, TRIAL_STEPS) > cost * (1.0 - SETTLED) {
            problem.set_values(&values);
        }
    }
}

/// Gauss-Newton steps, `most` of them; returns the cost.
fn steps(problem: &mut Problem, kept: FixedLaws, most: usize) -> f64 {
    problem.refresh_sizes();
    let bounds = problem.not_negative();
    let frozen = match kept {
        FixedLaws::Nothing => Vec::new(),
        FixedLaws::Friction => problem.friction(),
        FixedLaws::Laws => (0..problem.lost()).collect(),
    };
    let mut damping = 1e-6;
    let mut cost = f64::INFINITY;
    // normal equations of a step that has been accepted
    let mut ready = None;
    for k in 0..most {
        let normal = ready.take().unwrap_or_else(|| problem.normal());
        if normal.cost >= cost * (1.0 - SETTLED) {
            cost = normal.cost.min(cost);
            break;
        }
        cost = normal.cost;
        let before = problem.values();
        let mut better = false;
        for trial in 0..6 {
            let Some(step) = bounded(&normal.hessian, &normal.gradient, damping, &before, &bounds, &frozen) else {
                break;
            };
            let step = limited(problem, step);
            let promised = 2.0 * normal.gradient.dot(&step) - step.dot(&(&normal.hessian * &step));
            if promised < cost * NOTHING_LEFT {
                break;
            }
            problem.set_values(&(&before + step));
            // the first trial helps as a rule, and the next step wants its normal equations
            ready = (trial == 0 && k + 1 < most).then(|| problem.normal());
            if ready.as_ref().map_or_else(|| problem.cost(), |n| n.cost) < cost {
                better = true;
                damping = (damping * 0.1).max(1e-9);
                break;
            }
            ready = None;
            damping = (damping * 30.0).max(1e-4);
        }
        if !better {
            problem.set_values(&before);
            break;
        }
    }
    cost
}

/// A step that leaves the parameters `bounds` at zero or above: those that would fall below are put to zero, and the rest is
/// solved again.
pub fn bounded(
    hessian: &DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: f64,
    at: &DVector<f64>,
    bounds: &[usize],
    frozen: &[usize],
) -> Option<DVector<f64>> {
    let model = model(hessian, gradient);
    let damping = damping_of(&model, damping);
    let mut held = vec![false; at.len()];
    frozen.iter().for_each(|&k| held[k] = true);
    let mut to: Vec<f64> = vec![0.0; at.len()];
    loop {
        let step = model.step(&damping, &held, &to)?;
        let below: Vec<usize> = bounds.iter().copied().filter(|&k| !held[k] && at[k] + step[k] < 0.0).collect();
        if below.is_empty() {
            return Some(step.into());
        }
        for k in below {
            held[k] = true;
            to[k] = -at[k];
        }
    }
}

/// Solves `(H + damping diag H) x = g`.
pub fn solve(hessian: &DMatrix<f64>, gradient: &DVector<f64>, damping: f64) -> Option<DVector<f64>> {
    let (model, n) = (model(hessian, gradient), gradient.len());
    model.step(&damping_of(&model, damping), &vec![false; n], &vec![0.0; n]).map(DVector::from)
}

/// The normal equations as a linear model; `gradient` points downhill.
fn model(hessian: &DMatrix<f64>, gradient: &DVector<f64>) -> Products {
    Products::new(hessian.clone(), gradient.iter().map(|g| -g).collect())
}

/// Damping by a share of each squared norm.
fn damping_of(model: &Products, share: f64) -> Vec<f64> {
    model.squared_norms().iter().map(|s| share * s).collect()
}

/// Keeps preslidings from leaping.
fn limited(problem: &Problem, mut step: DVector<f64>) -> DVector<f64> {
    for (axis, law) in problem.laws.iter().enumerate() {
        if let Some(law) = law {
            let k = problem.offset(axis) + law.parameters() - 1;
            step[k] = step[k].clamp(-LOG_STEP, LOG_STEP);
        }
    }
    step
}

/// Says anew which bins count: measured, after the joints have settled, not an outlier of the whitened residual.
pub fn refresh_unused(problem: &mut Problem) {
    let unused: Vec<Vec<bool>> = (0..problem.logs.len()).par_map(|l| {
        let responses = problem.responses(l, false);
        let log = &problem.logs[l];
        let mut unused = log.missing.clone();
        // between the first movement of a joint and the moment at which its state is known
        for ((_, rows), (_, r)) in log.moving.iter().zip(&responses) {
            let first = rows.x.iter().position(|x| (x - rows.x[0]).abs() > 1e-9).unwrap_or(0);
            let settled = r.settled.unwrap_or(first);
            let early = first < log.bins.get(10).map_or(0, |b| b.0);
            for (u, &(from, to)) in unused.iter_mut().zip(&log.bins) {
                *u |= to > if early { 0 } else { first } && from <= settled;
            }
        }
        let residual = problem.residual(l, &responses);
        for (u, o) in unused.iter_mut().zip(outliers(&residual, &log.missing)) {
            *u |= o;
        }
        unused
    });
    problem.unused = unused;
}

/// Estimates the noise of every log from its residual, and from what the laws miss.
pub fn refresh_noise(problem: &mut Problem) {
    let noise: Vec<Noise> = (0..problem.logs.len()).par_map(|l| {
        let responses = problem.responses(l, false);
        Noise::of(&problem.residual(l, &responses), &problem.unused[l], missed(problem, l, &responses))
    });
    problem.noise = noise;
    problem.whiten_columns();
}

/// What the laws miss in a log, m per coordinate of its readings; nothing where known values are corrected, from which they may not go far.
fn missed(problem: &Problem, log: usize, responses: &[(usize, Response)]) -> f64 {
    if problem.centre.is_some() {
        return 0.0;
    }
    let lost = problem.lost_motion(log, responses);
    let coordinates = if problem.logs[log].instrument == Instrument::Tcp { 3 } else { 1 };
    let mean_m2 = lost.iter().map(Vector3::norm_squared).sum::<f64>() / (coordinates * lost.len()).max(1) as f64;
    MISSED * mean_m2.sqrt()
}

/// Bins that stand out of their neighbours.
fn outliers(residual: &[Vector3<f64>], missing: &[bool]) -> Vec<bool> {
    let n = residual.len();
    let mut out = vec![false; n];
    for c in 0..3 {
        let off: Vec<Option<f64>> = (0..n)
            .map(|i| {
                let near = i.saturating_sub(NEIGHBOURS)..(i + NEIGHBOURS + 1).min(n);
                let mut near: Vec<f64> = near.filter(|k| !missing[*k]).map(|k| residual[k][c]).collect();
                if missing[i] { None } else { median_of(&mut near).map(|m| residual[i][c] - m) }
            })
            .collect();
        let mut sizes: Vec<f64> = off.iter().flatten().map(|v| v.abs()).collect();
        let sigma = SIGMA_PER_MAD * median_of(&mut sizes).unwrap_or(0.0);
        for (o, v) in out.iter_mut().zip(&off) {
            *o |= v.is_some_and(|v| v.abs() > OUTLIER * sigma.max(1e-7));
        }
    }
    out
}
