//! One machine, several logs: an effect has one size in all of them, and one lag of all joints looks like a clock offset.
//!
//! - [`agrees`]: the size of a refined effect is estimated again from each log alone (one Gauss-Newton step with everything
//!   else free, too). Where the sizes differ by more than chance (Wald) and by much, the effect stands for something else.
//! - [`common_lag`]: first-order lags of all joints by one time shift slow motion as a clock offset does. They are one
//!   hypothesis with one parameter, compared by its sensitivity at the size that the offset was found with; blocks of the
//!   data vote, since where a misfit stays the likelihood alone claims more than it knows.

use crate::diagnose::candidates::sensitivities::tangent;
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::problem::normal::{dot, gram};
use crate::diagnose::search::finding::Refined;
use crate::diagnose::search::fit::Fit;
use crate::effects::{Effect, EffectInstance, ServoLag};
use crate::machine::parts;
use crate::numerics::fisher;
use crate::numerics::normal_equations::pseudo_inverse;
use crate::numerics::robust::range;
use nalgebra::DVector;

/// Chance below which two logs disagree.
const DISAGREE: f64 = 1e-3;
/// Part of the mean by which they must differ.
const MUCH: f64 = 0.3;
/// Blocks of the data at least, and the size of their sum in its uncertainties that decides between two alternatives.
const BLOCKS: usize = 12;
const DECIDED: f64 = 2.5;

/// Target of lags of all joints by one time.
pub const ALL: &str = "all";

/// Parts of the data that must agree: the logs, or the halves of one log of joint sensors.
fn parts_of(problem: &Problem) -> Vec<Vec<std::ops::Range<usize>>> {
    if problem.logs.len() > 1 {
        return (0..problem.logs.len()).map(|l| problem.groups_of(l).map(|g| g.range()).collect()).collect();
    }
    if problem.groups.iter().any(|g| g.sensor.is_length()) {
        return Vec::new();
    }
    let half = |second: bool| {
        let cut = |g: &crate::diagnose::problem::layout::Group| {
            let (start, end) = (g.range().start, g.range().end);
            let middle = (start + end) / 2;
            if second { middle..end } else { start..middle }
        };
        problem.groups.iter().map(cut).collect()
    };
    vec![half(false), half(true)]
}

/// Do the parts agree about the size of the last effect of a refined fit?
pub fn agrees(problem: &Problem, refined: &Refined, whitening: &Whitening) -> bool {
    let parts = parts_of(problem);
    let Some(values) = refined.placed.first().map(|p| p.effect.values()) else { return true };
    if parts.len() < 2 {
        return true;
    }
    let fit = &refined.fit;
    let count: usize = fit.free.iter().map(|&i| fit.hypothesis.effects[i].effect.values().len()).sum();
    let at = count.saturating_sub(refined.parameters);
    let columns = tangent(problem, &fit.hypothesis, &fit.state, &fit.free, whitening);
    let white = whitening.of(problem, &fit.state.residual);
    // the values of a gap are all sizes; of another effect the first is
    let sizes = if refined.placed.iter().any(|p| p.effect.is_play()) { values.len() } else { 1 };
    let mut found: Vec<Vec<(f64, f64)>> = vec![Vec::new(); sizes];
    let last = if sizes == 1 { at + 1 } else { columns.len() };
    for ranges in &parts {
        let part = |v: &[f64]| -> Vec<f64> { ranges.iter().flat_map(|r| v[r.clone()].to_vec()).collect() };
        // a size is compared with its shape (frequency, decay) held
        let held = |k: &usize| *k < last || *k >= count;
        let columns: Vec<Vec<f64>> = (0..columns.len()).filter(held).map(|k| part(&columns[k])).collect();
        let right = part(&white);
        let normal = gram(&columns);
        let inverse = pseudo_inverse(&normal, 1e-9);
        let step = &inverse * DVector::from_iterator(columns.len(), columns.iter().map(|c| dot(c, &right)));
        let left = (dot(&right, &right) / (right.len() as f64 - columns.len() as f64).max(1.0)).max(1.0);
        for (k, found) in found.iter_mut().enumerate() {
            let variance = inverse[(at + k, at + k)] * left;
            if normal[(at + k, at + k)] > 0.0 && variance > 0.0 {
                found.push((values[k] + step[at + k], variance));
            }
        }
    }
    found.iter().all(|f| one_size(f, sizes))
}

/// Are estimates (value, variance) of one size?
fn one_size(found: &[(f64, f64)], tests: usize) -> bool {
    if found.len() < 2 {
        return true;
    }
    let weight: f64 = found.iter().map(|f| 1.0 / f.1).sum();
    let mean = found.iter().map(|f| f.0 / f.1).sum::<f64>() / weight;
    let squares: f64 = found.iter().map(|f| (f.0 - mean).powi(2) / f.1).sum();
    let freedom = (found.len() - 1) as f64;
    let [lo, hi] = range(found.iter().map(|f| f.0));
    let chance = tests as f64 * fisher::tail(squares / freedom, freedom, 1e6);
    chance > DISAGREE || hi - lo < MUCH * mean.abs()
}

/// Difference of two fits of one residual in 2 ln L, judged by blocks: whether it is the same all over (Vuong's test of
/// hypotheses that do not contain each other, with the scatter between blocks as its uncertainty).
fn decided(problem: &Problem, residual: &[f64], one: &[f64], other: &[f64]) -> bool {
    let blocks = BLOCKS.div_ceil(problem.groups.len().max(1));
    let left = |column: &[f64]| -> Vec<f64> {
        let size = dot(column, residual) / dot(column, column).max(1e-300);
        residual.iter().zip(column).map(|(r, c)| (r - size * c).powi(2)).collect()
    };
    let (a, b) = (left(one), left(other));
    let mut sums = Vec::new();
    for g in &problem.groups {
        let n = g.len();
        let mut sum = vec![0.0; blocks];
        for c in 0..g.dims {
            for k in 0..n {
                let i = g.offset + c * n + k;
                sum[k * blocks / n.max(1)] += a[i] - b[i];
            }
        }
        sums.extend(sum);
    }
    let total: f64 = sums.iter().sum();
    let mean = total / sums.len().max(1) as f64;
    let scatter: f64 = sums.iter().map(|s| (s - mean).powi(2)).sum();
    total.abs() > DECIDED * scatter.sqrt()
}

/// Lags of all joints by one time, instead of a clock offset that was found after `base`, which gains `gain`.
/// `None` where the offset points into the future, as no lag does. Without its own fit: [`Refined::placed`] is empty.
pub fn common_lag(
    problem: &Problem,
    base: &Fit,
    whitening: &Whitening,
    found: &EffectInstance,
    gain: f64,
) -> Option<Refined> {
    let offset_s = parts::clock(std::slice::from_ref(found)).offset_s;
    if offset_s >= 0.0 {
        return None;
    }
    let lag = Effect::new(ServoLag { lag_s: -offset_s });
    let mut column = vec![0.0; problem.n];
    for axis in 0..problem.robot.dof() {
        for (l, log) in problem.logs.iter().enumerate() {
            let lagged = log.trajectory.servo(axis, &[&lag], 0);
            let change = |r: usize| lagged[r] - log.trajectory.command(axis)[r];
            let motor: Option<&dyn Fn(usize) -> f64> = if log.is_driven(axis) { None } else { Some(&change) };
            problem.add_joint_change(&base.state, l, axis, &change, motor, &mut column);
        }
    }
    let context = base.screening(problem, whitening);
    let mut columns =
        vec![column, problem.difference(&base.hypothesis, &base.state, &[], std::slice::from_ref(found), 1.0)];
    context.project(&mut columns);
    let explains = |c: &[f64]| dot(c, &context.residual).powi(2) / dot(c, c).max(1e-300);
    let by_lag = explains(&columns[0]);
    let mut difference = by_lag - explains(&columns[1]);
    if !decided(problem, &context.residual, &columns[0], &columns[1]) {
        // what of the data prefers the one is as much as what prefers the other
        difference = difference
            .clamp(-0.5 * crate::diagnose::search::finding::WITHIN, 0.5 * crate::diagnose::search::finding::WITHIN);
    }
    let gain = gain + difference;
    let (effect, target, placed) = (lag.name(), ALL.to_string(), Vec::new());
    Some(Refined { effect, target, placed, gain, parameters: 1, fit: base.clone() })
}
