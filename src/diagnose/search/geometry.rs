//! Settled poses of a real arm: the geometry as one group, gravity, and gaps beside the misfit that stays.
//!
//! A real arm differs from its drawing in ten to twenty parameters at once; found one by one, each of them bends the others.
//! - The group: forward selection among zero offsets, DH parameters and the tool (frame and further reflectors projected
//!   off; what the chosen ones explain to 1e-4 is no parameter), refitted together, then backward: what does not stand four
//!   standard uncertainties from zero goes. Three or more make a group, which counts as one effect.
//! - After it gravity compliance alone. What stays of an arm (tenths of a millimetre) is smooth in the pose, and scale,
//!   coupling and slow ripple are, too: which of them it is, poses do not say, so none of them is named. What stays is
//!   reported as `unexplained`; the verdict is `unknown` only where nothing was named.
//! - Gaps: [`crate::diagnose::search::direction`].
//!
//! Gross poses: all reflectors of a pose beyond six times the median are left out, after the group was fitted.
//! Fails where the poses are few or alike: what they do not tell to a third of [`PRIOR`] stays as the drawing has it.

use crate::diagnose::candidates::screen::ScreeningContext;
use crate::diagnose::candidates::sensitivities::tangent;
use crate::diagnose::candidates::structure::Tested;
use crate::diagnose::candidates::{Candidate, is_geometry};
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::forward::{Hypothesis, Problem};
use crate::diagnose::problem::normal::dot;
use crate::diagnose::problem::normal::{orthonormal, project_off};
use crate::diagnose::problem::residual::rms;
use crate::diagnose::search::finding::Refined;
use crate::diagnose::search::fit::{self, Fit};
use crate::effects::{EffectInstance, Family, Stage, catalogue};
use crate::numerics::fisher;
use crate::numerics::parallel::{self, ParMap};
use crate::numerics::robust::median;
use nalgebra::DVector;

/// How far a made arm may be off its drawing, rad or m.
pub const PRIOR: f64 = 3e-3;
/// Parameters that make a group.
const GROUP: usize = 3;
/// Chance below which a parameter enters the group, all that is tried counted.
const CHANCE: f64 = 1e-4;
/// Squared share of a column that must be its own.
const OWN: f64 = 1e-8;
/// Standard uncertainties from zero below which a parameter leaves the group.
const NO_PARAMETER: f64 = 4.0;
/// Parameters of a group at most.
const MOST: usize = 40;
/// Residual of a pose, in medians, beyond which it is gross.
const GROSS: f64 = 6.0;
/// Chance of structure below which it is reported.
const STRUCTURED: f64 = 1e-5;

/// The one effect that is sought after the group, besides gaps: joints that yield.
pub(in crate::diagnose) fn is_gravity(effect: &str) -> bool {
    catalogue::find(effect).is_some_and(|e| e.family == Family::Gravity && e.stage == Stage::Link)
}

/// The group as it was found.
#[derive(Debug, Clone)]
pub struct Group {
    /// Effects of the group: the first of the free ones.
    pub count: usize,
    pub parameters: usize,
    /// Gain in 2 ln L over the frame alone.
    pub gain: f64,
    pub f: f64,
    pub p_value: f64,
}

/// Fits the group from `base`, whose free effects are none; `None` where fewer than three parameters are found.
pub fn group(problem: &Problem, base: &Fit, whitening: &Whitening, candidates: &[Candidate]) -> Option<(Group, Fit)> {
    let known = base.hypothesis.effects.len();
    let mut fit = base.clone();
    let pool: Vec<&Candidate> = candidates.iter().filter(|c| is_geometry(c.effect)).collect();
    // selected at one linearisation, then again where the refit stands
    for _ in 0..4 {
        let more = select(problem, &fit, whitening, &pool);
        if more.is_empty() {
            break;
        }
        let mut h = fit.hypothesis.clone();
        h.effects.extend(more);
        let free: Vec<usize> = (known..h.effects.len()).collect();
        fit = fit::refit(problem, &h, &free, whitening);
    }
    while let Some(weakest) = weakest(problem, &fit) {
        let mut h = fit.hypothesis.clone();
        h.effects.remove(known + weakest);
        let free: Vec<usize> = (known..h.effects.len()).collect();
        fit = fit::refit(problem, &h, &free, whitening);
    }
    let parameters: usize = fit.free.iter().map(|&i| fit.hypothesis.effects[i].effect.values().len()).sum();
    if parameters < GROUP {
        return None;
    }
    let (n, k) = (problem.n as f64, parameters as f64);
    let gain = base.cost - fit.cost;
    let f = (gain / k) / (fit.cost / (n - k).max(1.0));
    let p_value = fisher::tail(f, k, n - k);
    Some((Group { count: fit.free.len(), parameters, gain, f, p_value }, fit))
}

/// A candidate, its projected sensitivities, and their squared norms before.
type Projected<'a> = (&'a Candidate, Vec<Vec<f64>>, Vec<f64>);

/// Forward selection at one linearisation.
fn select(problem: &Problem, fit: &Fit, whitening: &Whitening, pool: &[&Candidate]) -> Vec<EffectInstance> {
    let taken = |c: &Candidate| {
        fit.free.iter().any(|&i| {
            let p = &fit.hypothesis.effects[i];
            c.names(p, &problem.robot)
        })
    };
    let context = fit.screening(problem, whitening);
    let free: Vec<&Candidate> = pool.iter().copied().filter(|c| !taken(c)).collect();
    let mut left: Vec<Projected> = free.par_map(|c| {
        let mut columns = c.columns(problem, &fit.hypothesis, &fit.state);
        let before = context.project(&mut columns);
        (*c, columns, before)
    });
    let tried = left.len() as f64;
    let mut residual = context.residual.clone();
    let mut chosen: Vec<(&Candidate, Vec<Vec<f64>>)> = Vec::new();
    let n = residual.len() as f64;
    while chosen.len() + fit.free.len() < MOST {
        let rss = dot(&residual, &residual);
        let mut best: Option<(f64, usize, Vec<Vec<f64>>)> = None;
        // the tool is as rough as the frame: what it explains is not sought elsewhere
        let tool = left.iter().position(|l| l.0.is_on_tool());
        for (i, (_, columns, before)) in left.iter().enumerate().filter(|(i, _)| tool.is_none_or(|t| *i == t)) {
            // the poses must tell it, and to a third of what a drawing may be off
            let own = columns.iter().zip(before).all(|(c, b)| dot(c, c) > (OWN * b).max(9.0 / (PRIOR * PRIOR)));
            if !own {
                continue;
            }
            let basis = orthonormal(columns.clone());
            let k = basis.len() as f64;
            let gain: f64 = basis.iter().map(|b| dot(b, &residual).powi(2)).sum();
            let f = (gain / k) / ((rss - gain).max(1e-300) / n);
            if (tool.is_some() || tried * fisher::tail(f, k, n) < CHANCE) && best.as_ref().is_none_or(|b| f > b.0) {
                best = Some((f, i, basis));
            }
        }
        let Some((_, i, basis)) = best else {
            match tool {
                // nothing that the others do not have
                Some(i) => {
                    left.remove(i);
                    continue;
                }
                None => break,
            }
        };
        let (c, columns, _) = left.remove(i);
        project_off(&basis, &mut residual);
        parallel::change(&mut left, |_, l| l.1.iter_mut().for_each(|c| project_off(&basis, c)));
        chosen.push((c, columns));
    }
    // they start at zero: the refit is nearly linear
    chosen.iter().flat_map(|(c, columns)| c.at(&vec![0.0; columns.len()])).collect()
}

/// The effect nearest to zero, where that is nearer than a parameter of the group may be.
fn weakest(problem: &Problem, fit: &Fit) -> Option<usize> {
    let scale = (fit.cost / problem.n.max(1) as f64).sqrt();
    (0..fit.free.len())
        .map(|k| (k, significance(fit, k) / scale))
        .filter(|(_, z)| *z < NO_PARAMETER)
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(k, _)| k)
}

/// Largest value of the k-th effect in its standard uncertainties.
fn significance(fit: &Fit, k: usize) -> f64 {
    let values = fit.hypothesis.effects[fit.free[k]].effect.values();
    values.iter().zip(fit.sigma_of(k)).map(|(v, s)| if s > 0.0 { v.abs() / s } else { 0.0 }).fold(0.0, f64::max)
}

/// A found effect as its own only alternative: what taking it out would cost, by its covariance.
pub fn other_geometry(problem: &Problem, fit: &Fit, k: usize) -> Refined {
    let placed = fit.hypothesis.effects[fit.free[k]].clone();
    let values = placed.effect.values();
    let start: usize = fit.free[..k].iter().map(|&i| fit.hypothesis.effects[i].effect.values().len()).sum();
    let covariance = fit.covariance.view((start, start), (values.len(), values.len())).into_owned();
    let v = DVector::from_row_slice(&values);
    let gain = covariance.pseudo_inverse(1e-300).map_or(0.0, |inverse| (inverse * &v).dot(&v));
    Refined {
        effect: placed.effect.name(),
        target: placed.target_text(&problem.robot),
        parameters: values.len(),
        placed: vec![placed],
        gain,
        fit: fit.clone(),
    }
}

/// Does an effect explain more than chance beside the whole geometry, not the significant part alone?
pub fn stands_beside(
    problem: &Problem,
    fit: &Fit,
    whitening: &Whitening,
    candidates: &[Candidate],
    found: &EffectInstance,
) -> bool {
    let mut tangent = tangent(problem, &fit.hypothesis, &fit.state, &fit.free, whitening);
    for c in candidates.iter().filter(|c| is_geometry(c.effect)) {
        let mut columns = c.columns(problem, &fit.hypothesis, &fit.state);
        columns.iter_mut().for_each(|c| whitening.apply(problem, c));
        tangent.extend(columns);
    }
    let context = ScreeningContext::new(problem, &fit.hypothesis, &fit.state, whitening, tangent);
    let column = problem.difference(&fit.hypothesis, &fit.state, &[], std::slice::from_ref(found), 1.0);
    let gain = context.score_columns(0, vec![column], true).gain;
    let left =
        (dot(&context.residual, &context.residual) - gain) / (problem.n as f64 - fit.parameters() as f64).max(1.0);
    problem.robot.dof() as f64 * fisher::tail(gain / left.max(1e-300), 1.0, problem.n as f64) < CHANCE
}

/// Poses that the geometry leaves far off are left out, all their reflectors; says how many.
pub fn drop_gross(problem: &mut Problem, h: &Hypothesis, white: &dyn Fn(&Problem, &Fit) -> Whitening) -> usize {
    let mut dropped = 0;
    let mut gravity = false;
    for _ in 0..6 {
        let base = fit::refit(problem, h, &[], &white_of(problem, h));
        let mut candidates = crate::diagnose::candidates::all(problem);
        candidates.extend(further(problem));
        let whitening = white(problem, &base);
        let mut fit = group(problem, &base, &whitening, &candidates).map_or(base, |g| g.1);
        // what gravity does is not gross
        if gravity {
            let mut h = fit.hypothesis.clone();
            let mut free = fit.free.clone();
            for c in candidates.iter().filter(|c| is_gravity(c.effect)) {
                free.push(h.effects.len());
                h.effects.extend(c.at(&vec![0.0; c.sensitivities()]));
            }
            fit = fit::refit(problem, &h, &free, &whitening);
        }
        let mut found = Vec::new();
        for l in 0..problem.logs.len() {
            let mut size = vec![None; problem.logs[l].log.len()];
            for g in problem.groups_of(l).filter(|g| g.dims == 3 && g.sensor.is_length()) {
                let (n, v) = (g.len(), &fit.state.residual[g.range()]);
                for b in 0..n {
                    let s: f64 = (0..3).map(|c| v[c * n + b].powi(2)).sum::<f64>().sqrt();
                    let row = &mut size[g.middle(b)];
                    *row = Some(row.unwrap_or(0.0_f64).max(s));
                }
            }
            let there: Vec<f64> = size.iter().flatten().copied().collect();
            let limit = GROSS * median(&there);
            if there.len() >= 12 {
                found.extend(
                    size.iter().enumerate().filter(|(_, s)| s.is_some_and(|s| s > limit)).map(|(row, _)| (l, row)),
                );
            }
        }
        if found.is_empty() && gravity {
            break;
        }
        gravity |= found.is_empty();
        dropped += found.len();
        crate::diagnose::prepare::leave_poses_out(problem, &found);
    }
    dropped
}

fn white_of(problem: &Problem, h: &Hypothesis) -> Whitening {
    let state = problem.evaluate(h);
    let sigma = rms(problem, &state.residual).max(1e-9);
    Whitening::new(problem, vec![crate::diagnose::noise::Noise::white(sigma); problem.groups.len()])
}

/// What is tried of poses besides: the twist of parallel axes, which lengths and angles cannot express, and gravity with free masses.
pub fn further(problem: &Problem) -> Vec<Candidate> {
    let wanted = |c: &Candidate| is_geometry(c.effect) || is_gravity(c.effect);
    crate::diagnose::candidates::further(problem).into_iter().filter(wanted).collect()
}

/// Is there structure beyond chance?
pub fn is_structured(tested: &Tested) -> bool {
    tested.whole.p_value <= STRUCTURED
}
