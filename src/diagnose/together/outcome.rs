//! The joint fit as an outcome that the document tells.

use super::super::candidates;
use super::super::fit;
use super::super::forward::{Hypothesis, Problem};
use super::super::outcome::{Alternative, Outcome, Step, largest, rms};
use super::super::prepare;
use super::super::screen::Ground;
use super::super::signatures::tangent;
use super::super::structure;
use super::super::whitening::Whitening;

/// Fits everything together and tells it.
pub fn of(mut problem: Problem, start: Hypothesis) -> Outcome {
    let known = start.effects.len();
    let state = problem.evaluate(&start);
    let (rms_given, max_given) = (rms(&problem, &state.residual), largest(&problem, &state.residual));
    let first = prepare::drop_spikes(&mut problem, &state);
    let white = |problem: &Problem, h: &Hypothesis| Whitening::white(problem, &problem.evaluate(h).residual);
    let framed = fit::refit(&problem, &start, &[], &white(&problem, &start));
    let found = super::run(&mut problem, &framed.hypothesis);
    let nuisance = fit::refit(&problem, &framed.hypothesis, &[], &white(&problem, &framed.hypothesis));
    let rms_nuisance = rms(&problem, &nuisance.state.residual);
    let candidates = candidates::all(&problem);
    let bundles = structure::basis(&problem, &found.fit.hypothesis, &found.fit.state, &candidates);
    let tangent = tangent(&problem, &found.fit.hypothesis, &found.fit.state, &found.fit.free, &found.whitening);
    let ground = Ground::new(&problem, &found.fit.hypothesis, &found.fit.state, &found.whitening, tangent);
    let structure = structure::test(&ground, &bundles);
    let last = ground.score_all(&candidates);
    let named = |k: usize| {
        let p = &found.fit.hypothesis.effects[found.fit.free[k]];
        (p.effect.name(), p.target_text(&problem.robot), p.effect.values().len())
    };
    let count = found.fit.free.len();
    let steps = found.story.order.iter().map(|&k| Step::new(named(k).0, named(k).1)).collect();
    let rivals = (0..count)
        .map(|k| {
            let (effect, target, parameters) = named(k);
            vec![Alternative { effect, target, gain: found.support[k], parameters }]
        })
        .collect();
    Outcome {
        candidates,
        steps,
        known,
        group: None,
        notes: problem.notes.clone(),
        rivals,
        told: Some(found.story),
        structure,
        remains: None,
        next: None,
        last,
        outliers: first + found.outliers,
        contradictions: Vec::new(),
        further: None,
        rms_given,
        max_given,
        rms_nuisance,
        state_nuisance: nuisance.state,
        price: (problem.n as f64).ln().min(8.0),
        fit: found.fit,
        whitening: found.whitening,
        problem,
    }
}
