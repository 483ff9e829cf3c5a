//! Generalised least squares over the whole chain: all found effects and the nuisance (frames, sensor zeros) refitted together.
//!
//! Method: the shared Levenberg-Marquardt ([`crate::numerics::least_squares`]) on whitened residuals with the sensitivities of
//! [`crate::diagnose::problem::forward`], scaled by the columns' norms, steps held inside the physical bounds. Covariance from the whitened
//! normal matrix at the end, so intervals account for coloured noise. Fails softly: it says whether it converged, and returns the best
//! point it saw.

use crate::diagnose::candidates::screen::ScreeningContext;
use crate::diagnose::candidates::sensitivities::{Sensitivities, tangent};
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::forward::{Hypothesis, Problem, State};
use crate::diagnose::problem::normal::dot;
use crate::effects::EffectInstance;
use crate::numerics::least_squares::{self, Flow, LinearModel, Options, Products, Progress, Scaling};
use crate::numerics::normal_equations::pseudo_inverse;
use nalgebra::{DMatrix, DVector};
use std::cell::RefCell;

/// A hypothesis refitted, with what it leaves.
#[derive(Debug, Clone)]
pub struct Fit {
    /// Effects with their fitted values.
    pub hypothesis: Hypothesis,
    /// Prediction and residuals at these values.
    pub state: State,
    /// Effects that were free: index into the hypothesis' effects, in the order of the columns.
    pub free: Vec<usize>,
    /// Sum of the whitened squares.
    pub cost: f64,
    /// Covariance of the free parameters (effects in order, each with all its values; then the nuisance).
    pub covariance: DMatrix<f64>,
    /// Whether the fit met its criterion; where it did not, intervals are not given.
    pub converged: bool,
}

impl Fit {
    /// Number of free parameters.
    pub fn parameters(&self) -> usize {
        self.covariance.nrows()
    }

    /// What it leaves, off the sensitivities of everything that it fitted.
    pub fn screening<'a>(&'a self, problem: &'a Problem, whitening: &'a Whitening) -> ScreeningContext<'a> {
        let tangent = tangent(problem, &self.hypothesis, &self.state, &self.free, whitening);
        ScreeningContext::new(problem, &self.hypothesis, &self.state, whitening, tangent)
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
    /// Precision of each value, 1 over its variance in SI; 0: no prior.
    pub precision: Vec<f64>,
    /// Value about which each prior stands, SI.
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

/// Settings of a refit: the cost is 2 ln L, so that its change says when nothing is left to gain.
const SETTINGS: Options = Options {
    max_steps: 15,
    cost_tolerance: 0.0,
    cost_tolerance_absolute: 1e-2,
    gradient_tolerance: 1e-15,
    step_tolerance: 0.0,
    initial_damping: 1e-4,
    least_damping: 1e-9,
    most_damping: 1e8,
    least_easing: 0.1,
    scaling: Scaling::Columns,
    model_at_end: false,
};
/// Gain in 2 ln L that a step promises at most where a fit that was stopped counts as converged: half a standard uncertainty.
const AT_REST: f64 = 0.25;

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
    let white = whitening.of(problem, &state.residual);
    let refit = Refit::new(problem, free, whitening, prior, sensitivities, f64::INFINITY);
    refit.solve(start.clone(), Evaluated { state, white })
}

/// The same where the sensitivities `known` of the first free effects and of the nuisance were computed at this very start,
/// without the effects after them: only those on a joint that has a new one are computed anew. It ends early where the cost
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
    let white = whitening.of(problem, &state.residual);
    Refit::new(problem, free, whitening, &Prior::default(), sensitivities, aim).solve(h, Evaluated { state, white }).0
}

/// A hypothesis evaluated, with its whitened residual.
struct Evaluated {
    state: State,
    white: Vec<f64>,
}

/// The refit as a problem of the shared solver. Sensitivities are kept while they hold.
struct Refit<'a> {
    problem: &'a Problem,
    free: &'a [usize],
    whitening: &'a Whitening,
    prior: &'a Prior,
    sensitivities: Sensitivities,
    aim: f64,
    /// The start, evaluated already.
    start: Option<Evaluated>,
    /// The last change that was tried: the one taken, when a step is judged.
    tried: RefCell<Vec<f64>>,
    /// How far each value has moved since its sensitivity was computed, in its own uncertainties.
    moves: Vec<f64>,
    /// Standard uncertainties at the last linear model.
    sigma: Vec<f64>,
    /// Gain of the last step.
    gain: f64,
}

impl<'a> Refit<'a> {
    fn new(
        problem: &'a Problem,
        free: &'a [usize],
        whitening: &'a Whitening,
        prior: &'a Prior,
        sensitivities: Sensitivities,
        aim: f64,
    ) -> Self {
        let n = sensitivities.normal.nrows();
        let (moves, sigma) = (vec![0.0; n], vec![0.0; n]);
        let (start, tried, gain) = (None, RefCell::default(), 0.0);
        Self { problem, free, whitening, prior, sensitivities, aim, start, tried, moves, sigma, gain }
    }

    fn solve(mut self, start: Hypothesis, evaluated: Evaluated) -> (Fit, Sensitivities) {
        self.start = Some(evaluated);
        let found = least_squares::minimise(&mut self, start, &SETTINGS);
        let model = self.model(&found.point, &found.state);
        let covariance = pseudo_inverse(model.gram(), OPEN);
        let gradient = DVector::from_column_slice(model.gradient());
        // a kink may end a fit where nothing is left to gain
        let converged = found.reason.converged() || (&covariance * &gradient).dot(&gradient) < AT_REST;
        let (free, cost) = (self.free.to_vec(), found.cost);
        let fit = Fit { hypothesis: found.point, state: found.state.state, free, cost, covariance, converged };
        (fit, self.sensitivities)
    }

    /// Normal matrix and gradient with the prior's.
    fn model(&self, h: &Hypothesis, at: &Evaluated) -> Products {
        let mut gradient: Vec<f64> = self.sensitivities.columns().map(|c| -dot(c, &at.white)).collect();
        let mut normal = self.sensitivities.normal.clone();
        for (k, (pull, p)) in self.prior.pull(h, self.free).into_iter().zip(&self.prior.precision).enumerate() {
            gradient[k] -= pull;
            normal[(k, k)] += p;
        }
        Products::new(normal, gradient)
    }
}

impl least_squares::Problem for Refit<'_> {
    type Point = Hypothesis;
    type State = Evaluated;
    type Model = Products;

    fn evaluate(&mut self, h: &Hypothesis) -> Evaluated {
        self.start.take().unwrap_or_else(|| {
            let state = self.problem.evaluate(h);
            let white = self.whitening.of(self.problem, &state.residual);
            Evaluated { state, white }
        })
    }

    fn cost(&self, h: &Hypothesis, at: &Evaluated) -> f64 {
        dot(&at.white, &at.white) + self.prior.penalty(h, self.free)
    }

    fn linearise(&mut self, h: &Hypothesis, at: &Evaluated) -> Products {
        // close to the end the sensitivities hardly change any more
        if self.gain > REFRESHED {
            let stale = self.sensitivities.moved_too_far(h, self.free, &self.moves);
            self.sensitivities.renew(self.problem, h, &at.state, self.free, self.whitening, &stale);
            let mut start = 0;
            for (k, block) in self.sensitivities.blocks.iter().enumerate() {
                if stale[k] {
                    self.moves[start..start + block.len()].fill(0.0);
                }
                start += block.len();
            }
        }
        let model = self.model(h, at);
        self.sigma = pseudo_inverse(model.gram(), OPEN).diagonal().iter().map(|v| v.max(0.0).sqrt()).collect();
        model
    }

    fn moved(&self, h: &Hypothesis, change: &mut [f64]) -> Hypothesis {
        let next = moved(self.problem, h, self.free, change);
        *self.tried.borrow_mut() = change.to_vec();
        next
    }

    fn hold(&self, h: &Hypothesis, gradient: &[f64], held: &mut [bool]) {
        let mut at = 0;
        for &i in self.free {
            let placed = &h.effects[i];
            for (v, (lo, hi)) in placed.effect.values().iter().zip(placed.bounds(&self.problem.robot)) {
                held[at] = *v <= lo && gradient[at] > 0.0 || *v >= hi && gradient[at] < 0.0;
                at += 1;
            }
        }
    }

    fn judge(&mut self, _h: &Hypothesis, _at: &Evaluated, progress: &Progress) -> Flow {
        if progress.steps > 0 {
            self.gain = progress.gain;
            for ((m, change), sigma) in self.moves.iter_mut().zip(self.tried.borrow().iter()).zip(&self.sigma) {
                *m += change / sigma.max(f64::MIN_POSITIVE.sqrt());
            }
        }
        let far = progress.cost - self.aim;
        let hopeless = progress.steps > FIRST_STEPS && far > FAR && progress.gain < HOPELESS * far;
        if hopeless { Flow::Abandon } else { Flow::Continue }
    }
}

/// An angle within half a turn either way.
fn turned(angle_rad: f64) -> f64 {
    let turns = angle_rad / std::f64::consts::TAU;
    (turns - turns.round()) * std::f64::consts::TAU
}

/// The hypothesis with its free values moved by `step`, held inside their bounds; what they cut off is cut off the step.
fn moved(problem: &Problem, h: &Hypothesis, free: &[usize], step: &mut [f64]) -> Hypothesis {
    let mut next = h.clone();
    let mut at = 0;
    for &i in free {
        let placed = &mut next.effects[i];
        let bounds = placed.bounds(&problem.robot);
        let mut values = placed.effect.values();
        for (k, (v, (lo, hi))) in values.iter_mut().zip(bounds).enumerate() {
            let wanted = *v + step[at];
            // a phase goes round instead of stopping at a bound
            if placed.effect.is_phase(k) {
                *v = turned(wanted);
            } else {
                let next = wanted.max(lo).min(hi);
                if next != wanted {
                    step[at] = next - *v;
                }
                *v = next;
            }
            at += 1;
        }
        placed.effect = placed.effect.with_values(&values);
    }
    next.move_nuisance(problem, &step[at..]);
    next
}

/// First values held inside their bounds.
pub(in crate::diagnose) fn inside(placed: &EffectInstance, problem: &Problem) -> EffectInstance {
    let values: Vec<f64> = placed
        .effect
        .values()
        .iter()
        .zip(placed.bounds(&problem.robot))
        .map(|(v, (lo, hi))| v.max(lo).min(hi))
        .collect();
    EffectInstance { target: placed.target, effect: placed.effect.with_values(&values) }
}
