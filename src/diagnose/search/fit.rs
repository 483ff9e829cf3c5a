//! Generalised least squares over the whole chain: all found effects and the nuisance (frames, sensor zeros) refitted together.
//!
//! Method: Levenberg-Marquardt on whitened residuals with the sensitivities of [`crate::diagnose::problem::forward`], scaled by the columns'
//! norms, steps held inside the physical bounds. Covariance from the whitened normal matrix at the end, so intervals
//! account for coloured noise. Fails softly: it says whether it converged, and returns the best point it saw.

use crate::diagnose::candidates::sensitivities::Sensitivities;
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::forward::{Hypothesis, Problem, State};
use crate::diagnose::problem::normal::{dot, scaled_inverse};
use crate::effects::Effect;
use nalgebra::{DMatrix, DVector};

/// A hypothesis refitted, with what it leaves.
#[derive(Debug, Clone)]
pub struct Fit {
    pub hypothesis: Hypothesis,
    pub state: State,
    /// Effects that were free: index into the hypothesis' effects, in the order of the columns.
    pub free: Vec<usize>,
    /// Sum of the whitened squares.
    pub cost: f64,
    /// Covariance of the free parameters (effects in order, each with all its values; then the nuisance).
    pub covariance: DMatrix<f64>,
    pub converged: bool,
}

impl Fit {
    /// Number of free parameters.
    pub fn parameters(&self) -> usize {
        self.covariance.nrows()
    }

    /// Standard uncertainties of the values of the k-th free effect.
    pub fn sigma_of(&self, k: usize) -> Vec<f64> {
        let values = |i: &usize| self.hypothesis.effects[*i].effect.values().len();
        let start: usize = self.free[..k].iter().map(values).sum();
        (start..start + values(&self.free[k])).map(|i| self.covariance[(i, i)].max(0.0).sqrt()).collect()
    }
}

/// Normal prior of the free values: precision (1 over the variance; 0: none) and centre of each, in the order of the columns.
#[derive(Debug, Clone, Default)]
pub struct Prior {
    pub precision: Vec<f64>,
    pub centre: Vec<f64>,
}

impl Prior {
    /// What it adds to the cost of a hypothesis.
    fn penalty(&self, h: &Hypothesis, free: &[usize]) -> f64 {
        let values = free.iter().flat_map(|&i| h.effects[i].effect.values());
        values.zip(self.precision.iter().zip(&self.centre)).map(|(v, (p, c))| p * (v - c).powi(2)).sum()
    }

    /// Minus half the gradient of the penalty.
    fn pull(&self, h: &Hypothesis, free: &[usize]) -> Vec<f64> {
        let values = free.iter().flat_map(|&i| h.effects[i].effect.values());
        values.zip(self.precision.iter().zip(&self.centre)).map(|(v, (p, c))| p * (c - v)).collect()
    }
}

/// Most steps of a refit.
const STEPS: usize = 15;
/// Change of the cost, in units of 2 ln L, at which a refit stops.
const SETTLED: f64 = 1e-2;

/// Factor by which a step that makes things worse raises the damping; it doubles from one to the next.
const GROWTH: f64 = 8.0;
/// Factor by which a step that keeps what was promised lowers it.
const LEAST_EASING: f64 = 0.1;
/// A refit is given up where it is farther than this from its aim, in units of 2 ln L,
const FAR: f64 = 50.0;
/// and a step brings less than this part of what is missing,
const HOPELESS: f64 = 0.02;
/// the first steps apart: shapes may start far off.
const FIRST_STEPS: usize = 2;
/// Gain of a step, in the same units, below which the next one uses the same sensitivities.
const REFRESHED: f64 = 1.0;

/// Eigenvalue, after scaling, below which a direction of the parameters is open.
const OPEN: f64 = 1e-10;

/// Refits the effects `free` (indices) and the frames from where the hypothesis stands.
pub fn refit(problem: &Problem, start: &Hypothesis, free: &[usize], whitening: &Whitening) -> Fit {
    refit_above(problem, start, free, whitening, f64::INFINITY)
}

/// The same for a fit that is known to lie above `aim`: where it stays far above it does not settle to the last digit.
pub fn refit_above(problem: &Problem, start: &Hypothesis, free: &[usize], whitening: &Whitening, aim: f64) -> Fit {
    let state = problem.evaluate(start);
    let sensitivities = Sensitivities::new(problem, start, &state, free, whitening);
    solve(problem, start.clone(), state, free, whitening, sensitivities, aim)
}

/// Refits the effects `free` and the frames under a prior of their values; gives the sensitivities at the end, too.
pub fn refit_with_prior(
    problem: &Problem,
    start: &Hypothesis,
    free: &[usize],
    whitening: &Whitening,
    prior: &Prior,
) -> (Fit, Sensitivities) {
    let state = problem.evaluate(start);
    let sensitivities = Sensitivities::new(problem, start, &state, free, whitening);
    solve_with_prior(problem, start.clone(), state, free, whitening, sensitivities, f64::INFINITY, prior)
}

/// The same where the sensitivities `known` of the first free effects and of the nuisance were computed at this very start,
/// without the effects behind them: only those on a joint that has a new one are computed anew. It ends early where the cost
/// stays far above `aim`.
pub fn refit_near(
    problem: &Problem,
    start: &Hypothesis,
    free: &[usize],
    whitening: &Whitening,
    known: &Sensitivities,
    aim: f64,
) -> Fit {
    let state = problem.evaluate(start);
    let old = known.blocks.len() - 1;
    let touched = |i: &usize| {
        let axis = start.effects[*i].axis();
        axis.is_some() && free[old..].iter().any(|&j| start.effects[j].axis() == axis)
    };
    let mut stale: Vec<bool> = free.iter().enumerate().map(|(k, i)| k >= old || touched(i)).collect();
    stale.push(false);
    let mut sensitivities = known.with_more(free.len() - old);
    sensitivities.renew(problem, start, &state, free, whitening, &stale);
    solve(problem, start.clone(), state, free, whitening, sensitivities, aim)
}

fn solve(
    problem: &Problem,
    h: Hypothesis,
    state: State,
    free: &[usize],
    whitening: &Whitening,
    sensitivities: Sensitivities,
    aim: f64,
) -> Fit {
    solve_with_prior(problem, h, state, free, whitening, sensitivities, aim, &Prior::default()).0
}

/// Values that stand at a bound and are pushed against it: held for a step, so that they do not bend the others.
fn held(problem: &Problem, h: &Hypothesis, free: &[usize], gradient: &DVector<f64>) -> Vec<bool> {
    let mut held = vec![false; gradient.len()];
    let mut at = 0;
    for &i in free {
        let placed = &h.effects[i];
        for (v, (lo, hi)) in placed.effect.values().iter().zip(placed.bounds(&problem.robot)) {
            held[at] = *v <= lo && gradient[at] < 0.0 || *v >= hi && gradient[at] > 0.0;
            at += 1;
        }
    }
    held
}

#[allow(clippy::too_many_arguments)]
fn solve_with_prior(
    problem: &Problem,
    mut h: Hypothesis,
    mut state: State,
    free: &[usize],
    whitening: &Whitening,
    mut sensitivities: Sensitivities,
    aim: f64,
    prior: &Prior,
) -> (Fit, Sensitivities) {
    let with_prior = !prior.precision.is_empty();
    let mut white = whitening.of(problem, &state.residual);
    let mut cost = dot(&white, &white) + prior.penalty(&h, free);
    let mut lambda = 1e-4;
    let mut growth = GROWTH;
    let mut converged = false;
    // how far each value has moved since its sensitivity was computed, in its own uncertainties
    let mut moves = vec![0.0; sensitivities.normal.nrows()];
    for step in 0..STEPS {
        if moves.is_empty() {
            converged = true;
            break;
        }
        let mut gradient = DVector::from_iterator(moves.len(), sensitivities.columns().map(|c| dot(c, &white)));
        let mut normal = sensitivities.normal.clone();
        for (k, (pull, p)) in prior.pull(&h, free).into_iter().zip(&prior.precision).enumerate() {
            gradient[k] += pull;
            normal[(k, k)] += p;
        }
        if with_prior {
            for (k, _) in held(problem, &h, free, &gradient).into_iter().enumerate().filter(|(_, held)| *held) {
                gradient[k] = 0.0;
                normal.row_mut(k).fill(0.0);
                normal.column_mut(k).fill(0.0);
            }
        }
        let mut improved = None;
        for _ in 0..8 {
            let mut damped = normal.clone();
            for i in 0..damped.nrows() {
                damped[(i, i)] *= 1.0 + lambda;
            }
            let inverse = scaled_inverse(&damped, OPEN);
            let step = &inverse * &gradient;
            // what the sensitivities promise: where that is nothing, this is the place
            let promised = 2.0 * step.dot(&gradient) - (&normal * &step).dot(&step);
            if promised < SETTLED {
                break;
            }
            let next = moved(problem, &h, free, step.as_slice());
            let next_state = problem.evaluate(&next);
            let next_white = whitening.of(problem, &next_state.residual);
            let next_cost = dot(&next_white, &next_white) + prior.penalty(&next, free);
            if next_cost <= cost {
                for (k, m) in moves.iter_mut().enumerate() {
                    *m += step[k] / inverse[(k, k)].max(f64::MIN_POSITIVE).sqrt();
                }
                let kept = (cost - next_cost) / promised;
                lambda = (lambda * (1.0 - (2.0 * kept - 1.0).powi(3)).clamp(LEAST_EASING, 2.0)).max(1e-9);
                growth = GROWTH;
                improved = Some((next, next_state, next_white, next_cost));
                break;
            }
            lambda = (lambda * growth).max(1e-6);
            growth *= 2.0;
        }
        let Some((next, next_state, next_white, next_cost)) = improved else {
            converged = true;
            break;
        };
        let gain = cost - next_cost;
        (h, state, white, cost) = (next, next_state, next_white, next_cost);
        if gain < SETTLED {
            converged = true;
            break;
        }
        let far = cost - aim;
        if step >= FIRST_STEPS && far > FAR && gain < HOPELESS * far {
            break;
        }
        // close to the end the sensitivities hardly change any more
        if gain > REFRESHED {
            let stale = sensitivities.moved_too_far(&h, free, &moves);
            sensitivities.renew(problem, &h, &state, free, whitening, &stale);
            let mut at = 0;
            for (k, block) in sensitivities.blocks.iter().enumerate() {
                if stale[k] {
                    moves[at..at + block.len()].fill(0.0);
                }
                at += block.len();
            }
        }
    }
    let mut normal = sensitivities.normal.clone();
    for (k, p) in prior.precision.iter().enumerate() {
        normal[(k, k)] += p;
    }
    let covariance = scaled_inverse(&normal, OPEN);
    (Fit { hypothesis: h, state, free: free.to_vec(), cost, covariance, converged }, sensitivities)
}

/// Which value of an effect is a phase: it goes round instead of stopping at a bound.
fn phase_of(effect: &Effect) -> Option<usize> {
    effect.phase()
}

/// An angle within half a turn either way.
fn turned(angle_rad: f64) -> f64 {
    let turns = angle_rad / std::f64::consts::TAU;
    (turns - turns.round()) * std::f64::consts::TAU
}

/// The hypothesis with its free values moved by `step`, held inside their bounds.
fn moved(problem: &Problem, h: &Hypothesis, free: &[usize], step: &[f64]) -> Hypothesis {
    let mut next = h.clone();
    let mut at = 0;
    for &i in free {
        let placed = &mut next.effects[i];
        let bounds = placed.bounds(&problem.robot);
        let mut values = placed.effect.values();
        let phase = phase_of(&placed.effect);
        for (k, (v, (lo, hi))) in values.iter_mut().zip(bounds).enumerate() {
            let wanted = *v + step[at];
            *v = if phase == Some(k) { turned(wanted) } else { wanted.clamp(lo, hi) };
            at += 1;
        }
        placed.effect = placed.effect.with_values(&values);
    }
    next.move_nuisance(problem, &step[at..]);
    next
}
