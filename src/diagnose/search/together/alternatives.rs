//! What else a found gap may be: wind-up of friction that builds up faster than the log samples.
//!
//! Method: in the place of each gap, smooth lost motion (Dahl) of several presliding travels, alone and with the spike of an
//! integrating servo (stiction) of several decays, by what each leaves of held-out blocks beside all other effects. Where it leaves as little, the log does not tell which of the two it is, and the set holds both.

use super::{MachineFit, considered, members};
use crate::diagnose::candidates::sensitivities::effect_columns;
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::search::finding::Alternative;
use crate::effects::{Decay, Effect, EffectInstance, Hysteresis, Nature, Stiction, Target};
use rayon::prelude::*;

/// Presliding travels that are tried, deg or mm.
pub(super) const TRAVELS: [f64; 4] = [0.002, 0.006, 0.02, 0.06];

/// Decays of the spike beside it that are tried, s.
const DECAYS_S: [f64; 3] = [0.3, 1.0, 3.0];

/// The alternatives of every free effect, itself the first.
pub fn of(problem: &Problem, machine: &MachineFit, support: &[f64]) -> Vec<Vec<Alternative>> {
    let fit = &machine.fit;
    (0..fit.free.len())
        .into_par_iter()
        .map(|k| {
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
        .collect()
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
    let decays: &[f64] = if problem.logs.iter().all(|l| l.log.poses) || spiked { &[] } else { &DECAYS_S };
    let spikes = decays.iter().map(|&d| on(Stiction { spike: size, decay: Decay::Time(d) }.into()));
    let more: Vec<Vec<f64>> = windups
        .iter()
        .cloned()
        .chain(spikes)
        .map(|trial| {
            let mut with = fit.hypothesis.clone();
            with.effects[i] = trial;
            // the size alone: travels and decays stand side by side
            let mut column = effect_columns(problem, &with, &fit.state, i).swap_remove(0);
            whitening.apply(problem, &mut column);
            column
        })
        .collect();
    let table = members::table(problem, machine, &more);
    let own = sensitivities.columns().count();
    let values = members::linear_values(problem, fit);
    let others: Vec<usize> = (0..own).filter(|c| !range.contains(c)).collect();
    let gone: Vec<usize> = range.collect();
    let cost = |pick: &[usize]| -> f64 { table.held_out_without(pick, &gone, &values).iter().sum() };
    let bare = cost(&others);
    let gain = |more: &[usize]| bare - cost(&others.iter().chain(more).copied().collect::<Vec<_>>());
    let best = (own..own + windups.len())
        .flat_map(|t| {
            let beside = (0..decays.len()).map(move |d| (vec![t, own + TRAVELS.len() + d], 2));
            std::iter::once((vec![t], 1)).chain(beside)
        })
        .map(|(columns, parameters)| (gain(&columns), parameters))
        .max_by(|a, b| a.0.total_cmp(&b.0))?;
    let (effect, target) = (windups[0].effect.name(), gap.target_text(&problem.robot));
    (best.0 > 0.5 * support).then_some(Alternative { effect, target, gain: best.0, parameters: best.1 })
}
