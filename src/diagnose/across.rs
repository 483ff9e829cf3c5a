//! One machine, several logs: an effect has one size in all of them, and one lag of all joints looks like a clock offset.
//!
//! - [`agrees`]: the size of a refined effect is estimated again from each log alone (one Gauss-Newton step with everything
//!   else free, too). Where the sizes differ by more than chance (Wald) and by much, the effect stands for something else.
//! - [`common_lag`]: first-order lags of all joints by one time shift slow motion as a clock offset does. They are one
//!   hypothesis with one parameter, compared by its signature at the size that the offset was found with.

use super::fit::{self, Fit, Whitening, dot, gram, scaled_inverse};
use super::forward::Problem;
use super::screen::Ground;
use super::search::Refined;
use crate::effect::{Effect, Placed, ServoLag, Target};
use crate::machine::parts;
use crate::stats::fisher;
use nalgebra::DVector;

/// Chance below which two logs disagree.
const DISAGREE: f64 = 1e-3;
/// Part of the mean by which they must differ.
const MUCH: f64 = 0.3;

/// Do the logs agree about the size of the last effect of a refined fit?
pub fn agrees(problem: &Problem, refined: &Refined, whitening: &Whitening) -> bool {
    if problem.logs.len() < 2 {
        return true;
    }
    let fit = &refined.fit;
    let count: usize = fit.free.iter().map(|&i| fit.hypothesis.effects[i].effect.values().len()).sum();
    let at = count.saturating_sub(refined.parameters);
    let Some(value) = refined.placed.first().and_then(|p| p.effect.values().first().copied()) else { return true };
    let columns = fit::tangent(problem, &fit.hypothesis, &fit.state, &fit.free, whitening);
    let white = whitening.of(problem, &fit.state.residual);
    let found: Vec<(f64, f64)> = (0..problem.logs.len())
        .filter_map(|l| {
            let part = |v: &[f64]| -> Vec<f64> { problem.groups_of(l).flat_map(|g| v[g.range()].to_vec()).collect() };
            let columns: Vec<Vec<f64>> = columns.iter().map(|c| part(c)).collect();
            let right = part(&white);
            let normal = gram(&columns);
            if normal[(at, at)] <= 0.0 {
                return None;
            }
            let inverse = scaled_inverse(&normal, 1e-9);
            let step = &inverse * DVector::from_iterator(columns.len(), columns.iter().map(|c| dot(c, &right)));
            let n = right.len() as f64;
            let variance = inverse[(at, at)] * (dot(&right, &right) / (n - columns.len() as f64).max(1.0)).max(1.0);
            (variance > 0.0).then_some((value + step[at], variance))
        })
        .collect();
    if found.len() < 2 {
        return true;
    }
    let weight: f64 = found.iter().map(|f| 1.0 / f.1).sum();
    let mean = found.iter().map(|f| f.0 / f.1).sum::<f64>() / weight;
    let squares: f64 = found.iter().map(|f| (f.0 - mean).powi(2) / f.1).sum();
    let freedom = (found.len() - 1) as f64;
    let (lo, hi) = found.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), f| (a.min(f.0), b.max(f.0)));
    let chance = fisher::tail(squares / freedom, freedom, 1e6);
    chance > DISAGREE || hi - lo < MUCH * mean.abs()
}

/// Lags of all joints by one time, in the place of a clock offset that was found behind `base`, which gains `gain`.
/// `None` where the offset points into the future, as no lag does.
pub fn common_lag(problem: &Problem, base: &Fit, whitening: &Whitening, found: &Placed, gain: f64) -> Option<Refined> {
    let offset_s = parts::time_offset_s(std::slice::from_ref(found));
    if offset_s >= 0.0 {
        return None;
    }
    let lag = Effect::ServoLag(ServoLag { lag_s: -offset_s });
    let mut column = vec![0.0; problem.n];
    let mut placed = Vec::new();
    for axis in 0..problem.robot.dof() {
        for (l, log) in problem.logs.iter().enumerate() {
            let lagged = log.drive.servo(axis, &[&lag], 0);
            let change = |r: usize| lagged[r] - log.drive.command(axis)[r];
            let motor: Option<&dyn Fn(usize) -> f64> = if log.is_driven(axis) { None } else { Some(&change) };
            problem.add_joint_change(&base.state, l, axis, &change, motor, &mut column);
        }
        if problem.logs.iter().any(|l| !l.drive.rests(axis)) {
            placed.push(Placed { target: Target::Joint(axis), effect: lag.clone() });
        }
    }
    let tangent = fit::tangent(problem, &base.hypothesis, &base.state, &base.free, whitening);
    let ground = Ground::new(problem, &base.hypothesis, &base.state, whitening, tangent);
    let shifted = problem.difference(&base.hypothesis, &base.state, &[], std::slice::from_ref(found), 1.0);
    let (by_lag, by_offset) =
        (ground.score_columns(0, vec![column], true).gain, ground.score_columns(0, vec![shifted], true).gain);
    let gain = gain + by_lag - by_offset;
    Some(Refined {
        effect: "servo_lag",
        target: "all".into(),
        placed,
        gain,
        parameters: 1,
        promised: by_lag,
        fit: base.clone(),
    })
}
