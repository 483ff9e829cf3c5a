//! What each effect does to the TCP, its interval, and the report from the largest to the smallest.

use super::blocks::{self, Blocks};
use super::contribution::{contribution, contributions};
use super::{MachineFit, considered, members, prior, triage};
use crate::diagnose::candidates::is_geometry;
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::problem::residual::rms;
use crate::diagnose::search::fit::Fit;
use crate::diagnose::search::sandwich;
use crate::diagnose::search::story::NestedFit;
use crate::effects::{EffectInstance, Family};
use crate::numerics::normal::Z95;
use crate::numerics::parallel::ParMap;
use nalgebra::DVector;

/// The report of all effects together: order, nested fits, sizes at the TCP, uncertainties.
pub struct TogetherReport {
    /// Free effects (places in the list) in the order of the report.
    pub order: Vec<usize>,
    /// One more than effects: the first is the frame alone.
    pub nested_fits: Vec<NestedFit>,
    /// What each free effect does to the TCP, rms per coordinate beyond a rigid movement in the log where it is largest, m.
    pub contributions: Vec<f64>,
    /// The same of all geometry together.
    pub geometry: f64,
    /// Standard uncertainties of each free effect's values.
    pub sigma: Vec<Vec<f64>>,
    /// The same of a gap together with the wind-up of its joint, which is not in the fit: of the two the sum is known better.
    pub with_windup: Vec<Option<Vec<f64>>>,
}

/// Standard uncertainties of each free effect's values, and those of gaps together with the wind-up that is not in the fit.
pub(super) type Uncertainties = (Vec<Vec<f64>>, Vec<Option<Vec<f64>>>);

/// Rounds in which effects leave whose interval contains zero.
const ROUNDS: usize = 4;

/// The fit without the friction, ripple, drift and steps whose interval contains zero, with the uncertainties of the rest. Of several the
/// best determined one stays for another round, as two may cancel each other. Friction and ripple that data support far beyond chance
/// which were not fitted stay: it is their shape that is not known.
pub fn determined(problem: &Problem, machine: MachineFit) -> (MachineFit, Uncertainties) {
    let mut machine = machine;
    let mut known = uncertainties(problem, &machine);
    for _ in 0..ROUNDS {
        let support = members::support(problem, &machine);
        let shown = |k: usize| support[k] > triage::CLEAR && !is_of_time(&machine.fit, k);
        let mut open: Vec<(usize, f64)> = (0..machine.fit.free.len())
            .filter(|k| !shown(*k))
            .filter_map(|k| Some((k, ratio(problem, &machine.fit, k, &known.0[k])?)))
            .filter(|(_, ratio)| *ratio < Z95)
            .collect();
        open.sort_by(|a, b| a.1.total_cmp(&b.1));
        if open.len() > 1 {
            open.pop();
        }
        if open.is_empty() {
            break;
        }
        let kept: Vec<usize> = (0..machine.fit.free.len()).filter(|k| !open.iter().any(|o| o.0 == *k)).collect();
        machine = machine.keeping(problem, &kept).settled(problem);
        known = uncertainties(problem, &machine);
    }
    (machine, known)
}

/// Whether a free effect is of time: drifts and steps can cancel each other to any size.
fn is_of_time(fit: &Fit, k: usize) -> bool {
    matches!(fit.hypothesis.effects[fit.free[k]].effect.info().family, Family::Drift | Family::Tracker)
}

/// Size of a free effect in its uncertainties, root mean square over its sizes; `None` where it stays whatever it is: lags, gaps (whose
/// sum with the wind-up is known better), gravity and geometry, which are fitted as groups, and curves.
fn ratio(problem: &Problem, fit: &Fit, k: usize, sigma: &[f64]) -> Option<f64> {
    let placed = &fit.hypothesis.effects[fit.free[k]];
    let asked =
        matches!(placed.effect.info().family, Family::Friction | Family::Ripple | Family::Drift | Family::Tracker);
    let values = placed.effect.values();
    let kinds = prior::kinds(problem, placed);
    let sizes: Vec<f64> = (0..kinds.len())
        .filter(|&v| asked && kinds[v] == prior::Kind::Size)
        .map(|v| (values[v] / sigma[v].max(f64::MIN_POSITIVE)).powi(2))
        .collect();
    (!sizes.is_empty()).then(|| (sizes.iter().sum::<f64>() / sizes.len() as f64).sqrt())
}

/// The report of a fit whose uncertainties are known.
pub fn report(problem: &Problem, machine: &MachineFit, (sigma, with_windup): Uncertainties) -> TogetherReport {
    let fit = &machine.fit;
    let contributions = contributions(problem, fit);
    let order = order(fit, &contributions);
    let nested_fits = nested_fits(problem, machine, &order);
    let geometry: Vec<EffectInstance> = fit
        .free
        .iter()
        .map(|&i| &fit.hypothesis.effects[i])
        .filter(|e| is_geometry(e.effect.name()))
        .cloned()
        .collect();
    let geometry = if geometry.is_empty() { 0.0 } else { contribution(problem, fit, &geometry) };
    TogetherReport { order, nested_fits, contributions, geometry, sigma, with_windup }
}

/// The largest first; geometry stands together, where its largest member does.
fn order(fit: &Fit, contributions: &[f64]) -> Vec<usize> {
    let geometric = |k: usize| is_geometry(fit.hypothesis.effects[fit.free[k]].effect.name());
    let top = (0..fit.free.len()).filter(|&k| geometric(k)).map(|k| contributions[k]).fold(0.0, f64::max);
    let key = |k: usize| if geometric(k) { top } else { contributions[k] };
    let mut order: Vec<usize> = (0..fit.free.len()).collect();
    order.sort_by(|&a, &b| {
        key(b)
            .total_cmp(&key(a))
            .then(geometric(b).cmp(&geometric(a)))
            .then(contributions[b].total_cmp(&contributions[a]))
            .then(a.cmp(&b))
    });
    order
}

/// Refitted with the first 0, 1, ... effects of the order, by the sensitivities at the end.
fn nested_fits(problem: &Problem, machine: &MachineFit, order: &[usize]) -> Vec<NestedFit> {
    let MachineFit { fit, sensitivities, whitening, prior, .. } = machine;
    let columns: Vec<&[f64]> = sensitivities.columns().map(|c| c.as_slice()).collect();
    let mut starts = vec![0];
    for &i in &fit.free {
        starts.push(starts[starts.len() - 1] + fit.hypothesis.effects[i].effect.values().len());
    }
    let effects_end = starts[fit.free.len()];
    let linear = |k: usize| -> Vec<usize> {
        let kinds = prior::kinds(problem, &fit.hypothesis.effects[fit.free[k]]);
        (0..kinds.len()).filter(|&v| kinds[v] == prior::Kind::Size).map(|v| starts[k] + v).collect()
    };
    // the residual with every effect put back at its size: what the effects are fitted to
    let mut y = whitening.of(problem, &fit.state.residual);
    for (k, &i) in fit.free.iter().enumerate() {
        let values = fit.hypothesis.effects[i].effect.values();
        for v in linear(k) {
            let value = values[v - starts[k]];
            for (y, c) in y.iter_mut().zip(columns[v]) {
                *y += value * c;
            }
        }
    }
    let blocks = Blocks::new(problem, &columns, &y);
    let mut precision = prior.precision.clone();
    precision.resize(columns.len(), 0.0);
    let pull = vec![0.0; columns.len()];
    let folds = blocks::folds(problem);
    let left = |x: &DVector<f64>, pick: &[usize]| {
        let mut left = y.clone();
        for (&c, v) in pick.iter().zip(x.iter()) {
            for (l, c) in left.iter_mut().zip(columns[c]) {
                *l -= v * c;
            }
        }
        whitening.undo(problem, &mut left);
        left
    };
    (0..order.len() + 1).par_map(|count| {
        let pick: Vec<usize> =
            order[..count].iter().flat_map(|&k| linear(k)).chain(effects_end..columns.len()).collect();
        let whole = left(&blocks.solve(&pick, None, &precision, &pull), &pick);
        let mut held_out = vec![0.0; problem.n];
        for (f, ranges) in folds.iter().enumerate() {
            let part = left(&blocks.solve(&pick, Some(f), &precision, &pull), &pick);
            for r in ranges {
                held_out[r.clone()].copy_from_slice(&part[r.clone()]);
            }
        }
        let all = rms(problem, &whole);
        NestedFit { rms: all, held_out: rms(problem, &held_out), predicted: all }
    })
}

/// Uncertainties of the values: the largest of what the noise says, of what the effects that were left out may do
/// ([`considered`]), and of the scatter between parts of the logs (sandwich), as correlated noise swallows what the model does not
/// describe.
///
/// Of gaps also those of their sum with the wind-up that is not in the fit; the gap alone is known less.
pub(super) fn uncertainties(problem: &Problem, machine: &MachineFit) -> Uncertainties {
    let MachineFit { fit, sensitivities, whitening, .. } = machine;
    let scatter = sandwich::variances(problem, fit, sensitivities, whitening);
    let wider = considered::variances(problem, machine);
    let windup = considered::windup_beside_gaps(problem, machine);
    let together = |k: usize| fit.covariance[(k, k)].max(scatter[k]).max(wider[k]).max(0.0);
    let one = |range: std::ops::Range<usize>| {
        let alone = range.clone().map(|k| (together(k) + windup[k]).sqrt()).collect();
        let beside = range.clone().any(|k| windup[k] > 0.0);
        (alone, beside.then(|| range.map(|k| together(k).sqrt()).collect()))
    };
    members::columns_of(fit).into_iter().map(one).unzip()
}
