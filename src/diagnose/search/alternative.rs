//! What stands beside an effect whose size may be zero, where nothing that was refitted in its place comes near.
//!
//! Method: without the effect and with the others where they are, everything is screened for what the effect does to the log; the
//! candidate of the best merit whose size a machine can have is the alternative. Where nothing of the catalogue describes any of it, the
//! alternative is a curve without a name.

use crate::diagnose::candidates::Candidate;
use crate::diagnose::candidates::screen::ScreeningContext;
use crate::diagnose::candidates::sensitivities::tangent;
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::problem::normal::dot;
use crate::diagnose::search::finding::Alternative;
use crate::diagnose::search::fit::{self, Fit};
use crate::effects::{EffectInstance, Target, empirical};

/// Relative change by which a size that is brought inside its bounds was outside.
const OUTSIDE: f64 = 1e-6;

/// Gives every doubtful effect that stands alone, or is not in its own set, what the log tells from it least.
pub fn beside(
    problem: &Problem,
    fit: &Fit,
    whitening: &Whitening,
    (candidates, price): (&[Candidate], f64),
    doubtful: &[bool],
    alternatives: &mut [Vec<Alternative>],
) {
    for (k, all) in alternatives.iter_mut().enumerate().filter(|(k, _)| doubtful.get(*k) == Some(&true)) {
        let placed = &fit.hypothesis.effects[fit.free[k]];
        let (effect, target) = placed.named(&problem.robot);
        let itself = |a: &Alternative| (a.effect, &a.target) == (effect, &target);
        let there = all.iter().any(itself);
        if there && all.len() > 1 {
            continue;
        }
        let (gain, found) = screened(problem, fit, whitening, (candidates, price), k);
        if !there {
            all.insert(
                0,
                Alternative { effect, target: target.clone(), gain, parameters: placed.effect.values().len() },
            );
        }
        if all.len() == 1 {
            let mut alternative = found.unwrap_or_else(|| curve(problem, placed, gain));
            alternative.gain = alternative.gain.min(all[0].gain);
            all.push(alternative);
        }
    }
}

/// What the k-th free effect gains with the others where they are, and the best of the catalogue in its place.
fn screened(
    problem: &Problem,
    fit: &Fit,
    whitening: &Whitening,
    (candidates, price): (&[Candidate], f64),
    k: usize,
) -> (f64, Option<Alternative>) {
    let gone = fit.free[k];
    let placed = &fit.hypothesis.effects[gone];
    let own = placed.named(&problem.robot);
    let mut h = fit.hypothesis.clone();
    h.effects.remove(gone);
    let free: Vec<usize> = fit.free.iter().filter(|i| **i != gone).map(|&i| i - usize::from(i > gone)).collect();
    let state = problem.evaluate(&h);
    let around = tangent(problem, &h, &state, &free, whitening);
    let mut context = ScreeningContext::new(problem, &h, &state, whitening, around);
    let gain = (dot(&context.residual, &context.residual) - fit.cost).max(0.0);
    // what the effect does, not what else is left, is to be described
    let mut part = vec![problem.difference(&fit.hypothesis, &fit.state, std::slice::from_ref(placed), &[], -1.0)];
    context.project(&mut part);
    context.residual = part.swap_remove(0);
    let mut best: Option<Alternative> = None;
    for score in context.score_all(candidates) {
        let c = &candidates[score.candidate];
        let alternative =
            Alternative { effect: c.effect, target: c.target.clone(), gain: score.gain, parameters: c.parameters() };
        let better = best.as_ref().is_none_or(|b| alternative.merit(price) > b.merit(price));
        let other = (c.effect, &c.target) != (own.0, &own.1);
        if score.gain > 0.0 && other && better && c.at(&score.coefficients).iter().all(|q| is_inside(q, problem)) {
            best = Some(alternative);
        }
    }
    (gain, best)
}

/// Are the sizes of an effect those that a machine can have?
fn is_inside(placed: &EffectInstance, problem: &Problem) -> bool {
    let inside = fit::inside(placed, problem).effect.values();
    placed.effect.values().iter().zip(&inside).all(|(a, b)| (a - b).abs() <= OUTSIDE * a.abs())
}

/// A curve without a name.
fn curve(problem: &Problem, placed: &EffectInstance, gain: f64) -> Alternative {
    let target = placed.axis().map_or(Target::Tcp, Target::Joint).text(&problem.robot);
    Alternative { effect: empirical::INFO.name, target, gain, parameters: placed.effect.values().len() }
}
