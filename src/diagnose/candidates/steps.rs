//! Steps of the tracker's frame: where the level of what is left jumps in all coordinates at one time, or from one row to the next.
//!
//! Method: the scalar product of the residual with a step at any sample is a sum over all samples after it, so that one pass gives it
//! at all of them; divided by the norm that the step has after whitening, less what a free frame swallows of it, it is the gain in
//! 2 ln L. A step that is named must be one: the level just before and just after it differs by its size, and by far more than
//! it does at any other place, and nowhere jumps back by as much: a beam that is locked again does not undo what another lock did, while
//! flanks that change sides and gaps come back. Slow drift and wander do not jump.
//!
//! Assumptions: the filter that whitens is the same all along a log; the screening computes the gain at the peaks exactly.

use crate::diagnose::candidates::Candidate;
use crate::diagnose::candidates::screen::ScreeningContext;
use crate::diagnose::candidates::spectrum::peaks;
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::problem::layout::{Group, Sensor};
use crate::effects::tracker_frame::{self, From};
use crate::effects::{EffectInstance, TrackerFrame};
use crate::numerics::robust::{SIGMA_PER_MAD, median};
use nalgebra::Vector3;

/// Samples on either side of a step whose mean is its level.
const SIDE: usize = 12;
/// Steps looked at in a log in one round.
const MOST: usize = 2;
/// How far the level beside a step may differ from its size, as a part of it.
const APART: f64 = 0.4;
/// Part of a step by which the level may jump back at another place: what comes back is a flank or a lost motion.
const BACK: f64 = 0.6;
/// Size of a step, in robust standard deviations of the difference of levels elsewhere in the log.
const OUTSTANDING: f64 = 6.0;

/// Points of the TCP in each log, where there are samples enough for a level.
fn tracked(problem: &Problem) -> impl Iterator<Item = &Group> {
    problem.groups.iter().filter(|g| g.sensor == Sensor::Reflector(0) && g.len() > 4 * SIDE)
}

/// Number of places looked at, for the chance of the best of them.
pub fn tried(problem: &Problem) -> f64 {
    tracked(problem).map(|g| (g.len() / SIDE) as f64).sum()
}

/// Candidates at the largest steps of each log that are seen as such. `back`: the whitened residual taken back through the filters. What
/// is not seen must not stand among the candidates: its gain may be far larger than that of what is really there.
pub fn steps(context: &ScreeningContext, back: &[f64]) -> Vec<Candidate> {
    let problem = context.problem;
    if tracked(problem).next().is_none() {
        return Vec::new();
    }
    let filtered = |first: usize| {
        let mut column = vec![0.0; problem.n];
        for g in tracked(problem) {
            column[g.offset + first..g.offset + g.len()].fill(1.0);
        }
        context.whitening.apply(problem, &mut column);
        column
    };
    let response = filtered(1);
    let mut level = filtered(0);
    context.whitening.adjoint(problem, &mut level);
    let of_frame = |g: &Group| -> f64 {
        let alike = tracked(problem).filter(|o| problem.logs[o.log].frame == problem.logs[g.log].frame);
        alike.map(|o| level[o.offset..o.offset + o.len()].iter().sum::<f64>()).sum()
    };
    tracked(problem)
        .flat_map(|g| {
            let (n, all) = (g.len(), of_frame(g));
            let squares: Vec<f64> = running(response[g.offset..g.offset + n].iter().map(|v| v * v));
            let inside = after(&level[g.offset..g.offset + n]);
            let sums: Vec<Vec<f64>> = (0..3).map(|c| after(&back[g.offset + c * n..g.offset + (c + 1) * n])).collect();
            let gain = |k: usize| {
                let swallowed =
                    if problem.frames_free { inside[k] * inside[k] / all.max(f64::MIN_POSITIVE) } else { 0.0 };
                let norm = squares[n - k] - swallowed;
                if norm > 0.0 { sums.iter().map(|s| s[k] * s[k]).sum::<f64>() / norm } else { 0.0 }
            };
            let power: Vec<f64> = (SIDE..n - SIDE).map(gain).collect();
            peaks(&power, SIDE).into_iter().take(MOST).map(move |k| candidate(problem, g, SIDE + k.round() as usize))
        })
        .filter(|step| {
            let size = context.score(0, step).coefficients;
            step.at(&size).iter().all(|placed| is_seen(problem, placed, &context.state.residual))
        })
        .collect()
}

/// Sums of the first 0, 1, ... values.
fn running(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sums = vec![0.0];
    values.for_each(|v| sums.push(sums[sums.len() - 1] + v));
    sums
}

/// Sums of all values from each on.
fn after(values: &[f64]) -> Vec<f64> {
    let mut sums = values.to_vec();
    (0..sums.len().saturating_sub(1)).rev().for_each(|k| sums[k] += sums[k + 1]);
    sums
}

fn candidate(problem: &Problem, g: &Group, block: usize) -> Candidate {
    let log = &problem.logs[g.log];
    let row = g.block(block).first().copied().unwrap_or(0);
    let from = match log.log.poses {
        true => From::Row(f64::from(row)),
        false => From::Time(log.trajectory.t_s()[row as usize] - log.trajectory.began_s()),
    };
    tracker_frame::step(&problem.robot, from, g.log)
}

/// First sample after a step in its log.
fn sample_after(problem: &Problem, g: &Group, from: From) -> usize {
    let log = &problem.logs[g.log];
    let begun = |b: &usize| {
        let row = g.middle(*b);
        match from {
            From::Row(at) => row as f64 >= at,
            From::Time(t) => log.trajectory.t_s().get(row).is_some_and(|now| now - log.trajectory.began_s() >= t),
        }
    };
    (0..g.len()).find(begun).unwrap_or(g.len())
}

/// Is a step seen as one in `residual`, which still holds it? Other effects always are.
pub fn is_seen(problem: &Problem, placed: &EffectInstance, residual: &[f64]) -> bool {
    let Some(step) = placed.effect.get::<TrackerFrame>().filter(|f| f.over_s.is_none()) else { return true };
    let Some(g) = tracked(problem).find(|g| step.only_log.is_none_or(|log| g.log == log)) else { return false };
    let (n, size) = (g.len(), step.translation_m.norm());
    let at = sample_after(problem, g, step.from);
    if size <= 0.0 || at < SIDE || at + SIDE > n {
        return false;
    }
    let along = |b: usize| Vector3::from_fn(|c, _| residual[g.offset + c * n + b]).dot(&step.translation_m) / size;
    let levels: Vec<f64> =
        running((0..n).map(along)).windows(SIDE + 1).map(|w| (w[SIDE] - w[0]) / SIDE as f64).collect();
    let jump = |b: usize| levels[b] - levels[b - SIDE];
    let elsewhere: Vec<f64> = (SIDE..=n - SIDE).map(|b| jump(b).abs()).collect();
    let usual = SIGMA_PER_MAD * median(&elsewhere);
    let comes_back = (SIDE..=n - SIDE).filter(|b| b.abs_diff(at) > 2 * SIDE).any(|b| jump(b) < -BACK * size);
    (jump(at) - size).abs() < APART * size && size > OUTSTANDING * usual && !comes_back
}
