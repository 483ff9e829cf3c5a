//! The joint fit as an outcome that the document tells.

use super::{MachineFit, alternatives, beside, members, share, triage};
use crate::diagnose::candidates::screen::ScreeningContext;
use crate::diagnose::candidates::structure::{self, Ratio, Tested};
use crate::diagnose::candidates::{self, Candidate};
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::prepare;
use crate::diagnose::problem::forward::{Hypothesis, Problem};
use crate::diagnose::problem::residual::{largest, rms};
use crate::diagnose::search::finding::Step;
use crate::diagnose::search::fit::{self, Fit};
use crate::diagnose::search::outcome::Outcome;
use crate::diagnose::search::{alternative, determined, slow};

/// Fits everything together and tells it, where that finds many effects; with the number of its members that stand clear of the
/// noise, geometry and all lags among them.
pub fn of_many(problem: Problem, start: Hypothesis) -> Option<(Outcome, usize)> {
    let (together, clear, members) = of(problem, start);
    (clear >= triage::MANY).then_some((together, members))
}

/// Fits everything together and tells it; with the numbers of its effects and of its members that stand clear of the noise.
fn of(mut problem: Problem, start: Hypothesis) -> (Outcome, usize, usize) {
    let known = start.effects.len();
    let state = problem.evaluate(&start);
    let (rms_given, max_given) = (rms(&problem, &state.residual), largest(&problem, &state.residual));
    let first = prepare::drop_spikes(&mut problem, &state);
    let white = |problem: &Problem, h: &Hypothesis| Whitening::white(problem, &problem.evaluate(h).residual);
    let framed = fit::refit(&problem, &start, &[], &white(&problem, &start));
    let (machine, outliers) = super::run(&mut problem, &framed.hypothesis);
    let (machine, mut uncertainties) = share::determined(&problem, machine);
    let nuisance = fit::refit(&problem, &framed.hypothesis, &[], &white(&problem, &framed.hypothesis));
    let rms_nuisance = rms(&problem, &nuisance.state.residual);
    let candidates = candidates::all(&problem);
    let (structure, remains) = left(&problem, &machine, &candidates, rms_nuisance);
    let rms_named = rms(&problem, &machine.fit.state.residual);
    let machine = match &remains {
        Some(_) => {
            let with_curves = beside::curves(&problem, machine, &structure);
            uncertainties = share::uncertainties(&problem, &with_curves);
            with_curves
        }
        None => machine,
    };
    let quiet = remains.is_none();
    let slow = quiet.then(|| slow::beside_instrument(&problem, &machine.fit, &structure)).flatten();
    let support = members::support(&problem, &machine);
    let report = share::report(&problem, &machine, uncertainties);
    let mut alternatives = alternatives::of(&problem, &machine, &support);
    let price = (problem.n as f64).ln().min(8.0);
    let doubtful = doubtful(&problem, &machine.fit, &report);
    alternative::beside(&problem, &machine.fit, &machine.whitening, (&candidates, price), &doubtful, &mut alternatives);
    let clear = triage::clear(&machine, &support);
    let members = support.iter().filter(|s| **s > triage::CLEAR).count();
    let super::MachineFit { fit, whitening, .. } = machine;
    let context = fit.screening(&problem, &whitening);
    let last = context.score_all(&candidates);
    let step = |&k: &usize| {
        let p = &fit.hypothesis.effects[fit.free[k]];
        Step::new(p.effect.name(), p.target_text(&problem.robot))
    };
    let steps = report.order.iter().map(step).collect();
    let outcome = Outcome {
        candidates,
        steps,
        known,
        group: None,
        notes: problem.notes.clone(),
        alternatives,
        together: Some(report),
        structure,
        remains,
        slow,
        support,
        doubtful,
        next: None,
        last,
        outliers: first + outliers,
        contradictions: Vec::new(),
        further: None,
        rms_given,
        max_given,
        rms_nuisance,
        rms_named,
        state_nuisance: nuisance.state,
        price,
        fit,
        whitening,
        problem,
    };
    (outcome, clear, members)
}

/// Which free effects have sizes that may be zero; a gap counts with the wind-up that is not in the fit, as the log tells their sum.
fn doubtful(problem: &Problem, fit: &Fit, report: &share::TogetherReport) -> Vec<bool> {
    let of = |(alone, together): (&Vec<f64>, &Option<Vec<f64>>)| together.clone().unwrap_or_else(|| alone.clone());
    let sigma: Vec<Vec<f64>> = report.sigma.iter().zip(&report.with_windup).map(of).collect();
    determined::doubtful_by(problem, fit, &sigma)
}

/// The test without the catalogue after a fit, and what remains.
fn left(
    problem: &Problem,
    machine: &MachineFit,
    candidates: &[Candidate],
    rms_nuisance: f64,
) -> (Tested, Option<Ratio>) {
    let MachineFit { fit, sensitivities, whitening, .. } = machine;
    let groups = structure::basis(problem, &fit.hypothesis, &fit.state, candidates);
    let tangent = sensitivities.to_columns();
    let context = ScreeningContext::new(problem, &fit.hypothesis, &fit.state, whitening, tangent);
    let structure = structure::test(&context, &groups);
    let remains = structured(problem, &structure, fit, rms_nuisance);
    (structure, remains)
}

/// Part of what was explained, in squares, that must remain to be reported.
const WORTH: f64 = 0.01;
/// Chance below which structure remains.
const STRUCTURED: f64 = 1e-5;

/// Structure that remains: beyond chance, and more than a hundredth of what was explained.
fn structured(problem: &Problem, test: &Tested, fit: &Fit, rms_nuisance: f64) -> Option<Ratio> {
    let (left, floor) = (rms(problem, &fit.state.residual), rms(problem, &test.freed));
    let explained = rms_nuisance * rms_nuisance - left * left;
    if test.whole.p_value > STRUCTURED || left * left - floor * floor < WORTH * explained {
        return None;
    }
    let most = test.groups.iter().min_by(|a, b| a.p_value.total_cmp(&b.p_value).then(b.gain.total_cmp(&a.gain)));
    Some(most.unwrap_or(&test.whole).clone())
}
