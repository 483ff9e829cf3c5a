//! Structure that no effect names, as curves: `empirical` terms, as few and as smooth as held-out blocks support.
//!
//! Method: every kind of curve on every target ([`curves`]) is fitted to what is left, whitened and off the tangent of all that
//! was found, with each number of knots; the logs' blocks that were not fitted say how many knots they support. The best curve
//! joins, everything is refitted, and again, until none helps. A curve must hold on either half of the data: of the time, and of what
//! it must not depend on (position: both directions; speed: both halves of the travel), fitted to one and judged on the other. It
//! stays where it lessens the gap on held-out blocks after the refit, too. It never gets a physical name.
//!
//! Fails where structure belongs to one log alone (a slip, a walk): over time a curve is tried where there are several logs,
//! and must hold on either half of them; none stands for it that half of the log contradicts. A level that a zero offset or the frame has,
//! too, is left to these: intervals are those of the shape.

pub(crate) mod curves;

use crate::diagnose::candidates::Candidate;
use crate::diagnose::candidates::screen::ScreeningContext;
use crate::diagnose::candidates::structure::Tested;
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::problem::residual::rms;
use crate::diagnose::search::finding::{Alternative, Step};
use crate::diagnose::search::fit::{self, Fit, Prior};
use crate::diagnose::search::story;
use crate::diagnose::search::together::blocks::Blocks;
use crate::diagnose::search::together::{contribution, prior};
use crate::effects::{EffectInstance, Empirical, Nature};
use crate::numerics::normal::Z95;
use crate::numerics::parallel::ParMap;
use curves::{Family, Halves};
use nalgebra::DMatrix;
use serde_yaml::Value;

/// Gain on held-out blocks, in 2 ln L, beyond which a curve is supported.
pub const SUPPORTED: f64 = 25.0;
/// Folds of five of which it must improve most.
const MOST_FOLDS: usize = 4;
/// Curves at most.
const MOST: usize = 6;
/// More knots must gain this part of the whole beyond the fewer,
const SMOOTHER: f64 = 0.03;
/// and each this much in 2 ln L.
const PER_KNOT: f64 = 2.0;
/// Kinds of structure (joint and aspect) that are described where everything was fitted together.
const STRONGEST: usize = 6;

/// What the curves are chosen from; kinds that once show nothing are not looked at again.
pub struct Pool {
    families: Vec<Family>,
}

/// A curve that helps.
pub struct Curve {
    pub placed: EffectInstance,
    /// Gain on held-out blocks in 2 ln L.
    pub gain: f64,
}

impl Pool {
    pub fn new(problem: &Problem) -> Self {
        Self { families: curves::families(problem) }
    }

    /// The kinds that depend on the same as the strongest structure which the test without the catalogue sees.
    pub fn where_structured(problem: &Problem, tested: &Tested) -> Self {
        let mut strong: Vec<_> = tested.groups.iter().filter(|b| b.gain - b.dof as f64 > SUPPORTED).collect();
        strong.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        strong.truncate(STRONGEST);
        let mut families = curves::families(problem);
        families.retain(|f| strong.iter().any(|b| f.goes_with(b)));
        Self { families }
    }

    /// The curve that helps most on held-out blocks, beside everything that is fitted.
    pub fn best(&mut self, problem: &Problem, fit: &Fit, whitening: &Whitening) -> Option<Curve> {
        let context = fit.screening(problem, whitening);
        let found: Vec<Option<(Curve, f64)>> = self.families.par_map(|f| best_of(f, &context));
        let mut seen = found.iter().map(Option::is_some);
        self.families.retain(|_| seen.next().unwrap_or(false));
        let best = found.into_iter().flatten().max_by(|a, b| a.1.total_cmp(&b.1));
        best.map(|b| b.0)
    }
}

/// The curve of a family with the fewest knots that held-out blocks support, and its merit.
fn best_of(family: &Family, context: &ScreeningContext) -> Option<(Curve, f64)> {
    let problem = context.problem;
    let halves = family.halves(problem);
    let mut best: Option<(Curve, f64)> = None;
    for trial in family.trials(problem) {
        let Some((gain, values)) = supported(&trial, context, &halves) else { continue };
        let merit = gain - PER_KNOT * values.len() as f64;
        if best.as_ref().is_none_or(|b| merit > b.1 + SMOOTHER * b.1.abs())
            && let Some(placed) = trial.at(&values).into_iter().next()
        {
            best = Some((Curve { placed, gain }, merit));
        }
    }
    best
}

/// Gain of a trial on held-out blocks and its values, where it is supported, and where no half of the data contradicts the other.
fn supported(trial: &Candidate, context: &ScreeningContext, halves: &[Halves]) -> Option<(f64, Vec<f64>)> {
    let problem = context.problem;
    let mut columns = trial.columns(problem, context.hypothesis, context.state);
    context.project(&mut columns);
    let k = columns.len();
    let width = prior::widths(problem, trial.at(&vec![0.0; k]).first()?)[0];
    let (precision, pull) = (vec![width.powi(-2); k], vec![0.0; k]);
    let slices: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let blocks = Blocks::new(problem, &slices, &context.residual);
    let all: Vec<usize> = (0..k).collect();
    let (without, with) = (blocks.held_out(&[], &precision, &pull), blocks.held_out(&all, &precision, &pull));
    let gains: Vec<f64> = without.iter().zip(&with).map(|(a, b)| a - b).collect();
    let gain: f64 = gains.iter().sum();
    let folds = gains.iter().filter(|g| **g > 0.0).count();
    if gain <= SUPPORTED || folds < MOST_FOLDS {
        return None;
    }
    let agree = |h: &Halves| {
        let halves = Blocks::over(h, &slices, &context.residual);
        let (without, with) = (halves.held_out(&[], &precision, &pull), halves.held_out(&all, &precision, &pull));
        without.iter().zip(&with).all(|(a, b)| a - b > -PER_KNOT * k as f64)
    };
    halves.iter().all(agree).then(|| (gain, blocks.solve(&all, None, &precision, &pull).as_slice().to_vec()))
}

/// Each curve (the last of the free effects) as its own only alternative.
fn own(problem: &Problem, fit: &Fit, gains: &[f64]) -> Vec<Vec<Alternative>> {
    let curves = &fit.free[fit.free.len() - gains.len()..];
    let one = |(&i, &gain): (&usize, &f64)| {
        let placed = &fit.hypothesis.effects[i];
        let (effect, target) = placed.named(&problem.robot);
        vec![Alternative { effect, target, gain, parameters: placed.effect.values().len() }]
    };
    curves.iter().zip(gains).map(one).collect()
}

/// Does it have no physical name?
pub fn is_unnamed(placed: &EffectInstance) -> bool {
    placed.effect.nature() == Nature::Unnamed
}

/// What the curves leave, where they help at all.
pub struct Described {
    pub fit: Fit,
    pub whitening: Whitening,
    /// Gain of each curve on held-out blocks; they are the last of the free effects.
    pub gains: Vec<f64>,
    /// rms that is left of blocks that were not fitted, m or rad.
    pub held_out: f64,
}

/// Describes what a fit leaves by curves, which stand after its effects.
fn describe(problem: &Problem, start: &Fit, whitening: &Whitening) -> Option<Described> {
    let held_out = story::held_out(problem, start, whitening);
    let mut found = Described { fit: start.clone(), whitening: whitening.clone(), gains: Vec::new(), held_out };
    let mut pool = Pool::new(problem);
    while found.gains.len() < MOST {
        let Some(curve) = pool.best(problem, &found.fit, &found.whitening) else { break };
        let mut h = found.fit.hypothesis.clone();
        let mut free = found.fit.free.clone();
        free.push(h.effects.len());
        h.effects.push(curve.placed);
        let prior = of_curves(problem, &h.effects, &free);
        let (next, _) = fit::refit_with_prior(problem, &h, &free, &found.whitening, &prior);
        let after = story::held_out(problem, &next, &found.whitening);
        let moved = contribution::contributions(problem, &next).last().copied().unwrap_or(0.0);
        if after >= found.held_out || moved < contribution::WORTH * rms(problem, &next.state.residual) {
            break;
        }
        found.held_out = after;
        let noise = Whitening::of_residual(problem, &next.state.residual, next.parameters()).0;
        let prior = of_curves(problem, &next.hypothesis.effects, &next.free);
        found.fit = fit::refit_with_prior(problem, &next.hypothesis, &next.free, &noise, &prior).0;
        found.whitening = noise;
        found.gains.push(curve.gain);
    }
    with_intervals(problem, &mut found.fit);
    (!found.gains.is_empty()).then_some(found)
}

/// Part of what effects and curves leave of held-out blocks that curves alone must leave at most to stand without the effects.
const AS_GOOD: f64 = 0.98;

/// The same where what was found may only stand in for what has no name: curves alone where they leave
/// clearly less of held-out blocks; says whether they do.
fn describe_alone(problem: &Problem, fit: &Fit, known: usize, whitening: &Whitening) -> (Option<Described>, bool) {
    let beside = describe(problem, fit, whitening);
    if fit.free.is_empty() {
        return (beside, false);
    }
    let mut h = fit.hypothesis.clone();
    h.effects.truncate(known);
    let bare = fit::refit(problem, &h, &[], whitening);
    let noise = Whitening::of_residual(problem, &bare.state.residual, bare.parameters()).0;
    let alone = describe(problem, &fit::refit(problem, &bare.hypothesis, &[], &noise), &noise);
    let limit = AS_GOOD * beside.as_ref().map_or_else(|| story::held_out(problem, fit, whitening), |b| b.held_out);
    match alone {
        Some(alone) if alone.held_out <= limit => (Some(alone), true),
        _ => (beside, false),
    }
}

/// What remains described by curves, with the sets and the steps of the search brought in line. `known`: effects of the model, where
/// those after them may only stand in for what has no name.
pub fn conclude(
    problem: &Problem,
    fit: Fit,
    whitening: Whitening,
    known: Option<usize>,
    alternatives: &mut Vec<Vec<Alternative>>,
    steps: &mut [Step],
) -> (Fit, Whitening) {
    let (described, alone) = match known {
        None => (describe(problem, &fit, &whitening), false),
        Some(known) => describe_alone(problem, &fit, known, &whitening),
    };
    if alone {
        alternatives.clear();
        let stood = "a curve: it stood in for structure that no effect describes";
        steps.iter_mut().filter(|s| s.replaced_by.is_none()).for_each(|s| s.replaced_by = Some(stood.into()));
    }
    let Some(described) = described else { return (fit, whitening) };
    alternatives.extend(own(problem, &described.fit, &described.gains));
    (described.fit, described.whitening)
}

/// The prior of the curves alone.
fn of_curves(problem: &Problem, effects: &[EffectInstance], free: &[usize]) -> Prior {
    let mut prior = Prior::default();
    for &i in free {
        let values = effects[i].effect.values().len();
        let precision = match is_unnamed(&effects[i]) {
            true => prior::widths(problem, &effects[i]).into_iter().map(|w| w.powi(-2)).collect(),
            false => vec![0.0; values],
        };
        prior.precision.extend(precision);
        prior.centre.extend(vec![0.0; values]);
    }
    prior
}

/// Standard uncertainties of a curve's values by their covariance: of its shape, as zeros and frame have its level, too.
pub fn sigma(placed: &EffectInstance, covariance: &DMatrix<f64>) -> Vec<f64> {
    let n = covariance.nrows();
    let width = if placed.effect.get::<Empirical>().is_some_and(Empirical::is_of_tcp) { 3 } else { 1 };
    // each coordinate's mean over the knots taken off
    let centre = DMatrix::from_fn(n, n, |i, j| {
        let mean = if i % width == j % width { width as f64 / n as f64 } else { 0.0 };
        f64::from(u8::from(i == j)) - mean
    });
    let shape = &centre * covariance * centre.transpose();
    (0..n).map(|k| shape[(k, k)].max(0.0).sqrt()).collect()
}

/// Covariance of the values of the k-th free effect.
fn covariance_of(fit: &Fit, k: usize) -> DMatrix<f64> {
    let count = |i: &usize| fit.hypothesis.effects[*i].effect.values().len();
    let start: usize = fit.free[..k].iter().map(count).sum();
    let n = count(&fit.free[k]);
    fit.covariance.view((start, start), (n, n)).into_owned()
}

/// Standard uncertainties of the curve that is the k-th free effect, by the covariance of the fit.
pub fn sigma_of(fit: &Fit, k: usize) -> Vec<f64> {
    sigma(&fit.hypothesis.effects[fit.free[k]], &covariance_of(fit, k))
}

/// Writes the intervals of the curves into them, as a model file has them; a fit that did not converge has none.
pub fn with_intervals(problem: &Problem, fit: &mut Fit) {
    for k in 0..fit.free.len() {
        let i = fit.free[k];
        let placed = &fit.hypothesis.effects[i];
        let Some(curve) = placed.effect.get::<Empirical>().cloned() else { continue };
        let values = placed.effect.values();
        let one = |((v, s), (_, factor)): ((&f64, &f64), &(String, f64))| {
            let end = |side: f64| Value::from((v + side * Z95 * s) * factor);
            Value::Sequence(vec![end(-1.0), end(1.0)])
        };
        let keys = placed.keys(&problem.robot);
        let intervals = values.iter().zip(&sigma_of(fit, k)).zip(&keys).map(one).collect();
        fit.hypothesis.effects[i].effect = curve.with_ci95(fit.converged.then_some(Value::Sequence(intervals))).into();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::empirical::{Over, Times};

    #[test]
    fn the_interval_of_a_curve_is_that_of_its_shape() {
        let knots = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]];
        let curve = Empirical::of_joint(Over::Position, Times::One, &knots).unwrap();
        let placed = EffectInstance::on_axis(0, curve);
        // a level that nothing determines, and knots known to 0.1 each beside it
        let covariance = DMatrix::from_fn(3, 3, |i, j| 100.0 + if i == j { 0.01 } else { 0.0 });
        let found = sigma(&placed, &covariance);
        let want = (0.01f64 * 2.0 / 3.0).sqrt();
        assert!(found.iter().all(|s| (s - want).abs() < 1e-9), "{found:?}");
    }
}
