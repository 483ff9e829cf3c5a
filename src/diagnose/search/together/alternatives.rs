//! What else a found gap may be: wind-up of friction that builds up faster than the log samples.
//!
//! Method: in the place of each gap, smooth lost motion (Dahl) of several presliding travels, alone and with the spike of an
//! integrating servo (stiction) of several decays, by what each leaves of held-out blocks beside all other effects. Where it leaves as
//! little, or where the folds do not agree on which leaves less, the log does not tell which of the two it is, and the set holds both.

use super::{MachineFit, considered, members};
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::search::finding::{Alternative, WITHIN};
use crate::effects::{Decay, Effect, EffectInstance, Hysteresis, Nature, Stiction, Target};
use crate::numerics::parallel::ParMap;

/// Presliding travels that are tried, deg or mm.
pub(super) const TRAVELS: [f64; 4] = [0.002, 0.006, 0.02, 0.06];

/// Decays of the spike beside it that are tried, s.
const DECAYS_S: [f64; 3] = [0.3, 1.0, 3.0];

/// The alternatives of every free effect, itself the first.
pub fn of(problem: &Problem, machine: &MachineFit, support: &[f64]) -> Vec<Vec<Alternative>> {
    let fit = &machine.fit;
    (0..fit.free.len()).par_map(|k| {
        let placed = &fit.hypothesis.effects[fit.free[k]];
        let own = Alternative {
            effect: placed.effect.name(),
            target: placed.target_text(&problem.robot),
            gain: support[k],
            parameters: placed.effect.values().len(),
        };
        let windup = windup(problem, machine, k, support[k]);
        std::iter::once(own).chain(windup).collect()
    })
}

/// Does one of the effects wind the target up?
pub(super) fn winds_up(effects: &[EffectInstance], target: Target) -> bool {
    let winds = |p: &EffectInstance| p.effect.nature() == Nature::WindUp;
    effects.iter().any(|p| p.target == target && winds(p))
}

/// Wind-up instead of the k-th free effect, where that is a gap and the joint has no wind-up yet.
fn windup(problem: &Problem, machine: &MachineFit, k: usize, support: f64) -> Option<Alternative> {
    let MachineFit { fit, sensitivities, whitening, .. } = machine;
    let i = fit.free[k];
    let gap = &fit.hypothesis.effects[i];
    let size = considered::size_of_gap(gap)?;
    if size <= 0.0 || winds_up(&fit.hypothesis.effects, gap.target) {
        return None;
    }
    let unit = problem.robot.axis(gap.axis()?).kind.si_per_user_unit();
    let range = members::columns_of(fit).into_iter().nth(k)?;
    let on = |effect: Effect| EffectInstance::new(gap.target, effect);
    let windups = TRAVELS.map(|t| on(Hysteresis { half_width: size, presliding: t * unit }.into()));
    let spiked = fit.hypothesis.effects.iter().any(|p| p.target == gap.target && p.effect.nature() == Nature::Spike);
    let decays: &[f64] = if problem.is_settled() || spiked { &[] } else { &DECAYS_S };
    let spikes = decays.iter().map(|&d| on(Stiction { spike: size, decay: Decay::Time(d) }.into()));
    // what each does beside what is there without the gap, at the size of the gap; sizes stand side by side
    let instead =
        |to: &[EffectInstance]| problem.difference(&fit.hypothesis, &fit.state, std::slice::from_ref(gap), to, size);
    let bare = instead(&[]);
    let more: Vec<Vec<f64>> = windups
        .iter()
        .cloned()
        .chain(spikes)
        .map(|trial| {
            let mut column = instead(&[trial]);
            column.iter_mut().zip(&bare).for_each(|(c, b)| *c -= b);
            whitening.apply(problem, &mut column);
            column
        })
        .collect();
    let table = members::table(problem, machine, &more);
    let own = sensitivities.columns().count();
    let values = members::linear_values(problem, fit);
    let others: Vec<usize> = (0..own).filter(|c| !range.contains(c)).collect();
    let gone: Vec<usize> = range.collect();
    let left = |more: &[usize]| {
        let pick: Vec<usize> = others.iter().chain(more).copied().collect();
        table.held_out_without(&pick, &gone, &values)
    };
    let sum = |folds: &[f64]| folds.iter().sum::<f64>();
    let (folds, parameters) = (own..own + windups.len())
        .flat_map(|t| {
            let beside = (0..decays.len()).map(move |d| (vec![t, own + TRAVELS.len() + d], 2));
            std::iter::once((vec![t], 1)).chain(beside)
        })
        .map(|(columns, parameters)| (left(&columns), parameters))
        .min_by(|a, b| sum(&a.0).total_cmp(&sum(&b.0)))?;
    let gain = sum(&left(&[])) - sum(&folds);
    let with_gap = table.held_out(&(0..own).collect::<Vec<_>>());
    let (gain, parameters) = match is_decided(&with_gap, &folds) {
        true => (gain, parameters),
        // what of the data prefers the one is as much as what prefers the other
        false => (support + (gain - support).clamp(-0.5 * WITHIN, 0.5 * WITHIN), gap.effect.values().len()),
    };
    let (effect, target) = (windups[0].effect.name(), gap.target_text(&problem.robot));
    (gain > 0.5 * support).then_some(Alternative { effect, target, gain, parameters })
}

/// Standard errors of the folds' sum by which one of two must leave less than the other: Student's t of four degrees of freedom, 95 %.
const DECIDED: f64 = 2.78;

/// Do the held-out folds tell two fits apart, by the scatter of their difference?
fn is_decided(one: &[f64], other: &[f64]) -> bool {
    let differences: Vec<f64> = one.iter().zip(other).map(|(a, b)| a - b).collect();
    let n = differences.len() as f64;
    let mean = differences.iter().sum::<f64>() / n;
    let squares: f64 = differences.iter().map(|d| (d - mean).powi(2)).sum();
    (n * mean).abs() > DECIDED * (n / (n - 1.0) * squares).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folds_that_take_turns_decide_nothing_and_folds_of_one_mind_do() {
        assert!(!is_decided(&[10.0, 12.0, 9.0, 11.0, 10.0], &[9.0, 14.0, 8.0, 13.0, 9.0]));
        assert!(is_decided(&[10.0, 12.0, 9.0, 11.0, 10.0], &[7.0, 9.5, 5.0, 8.0, 7.5]));
    }
}
