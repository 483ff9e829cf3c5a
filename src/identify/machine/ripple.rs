//! Search for the ripple of a joint's gear: periodic in its position, of unknown period.
//!
//! A transmission errs with a period of a turn of its motor, or of half of one (harmonic drives), and ratios are not in a robot file.
//! For each number of cycles a turn of the joint a sine and a cosine are fitted to the whitened residual of all logs in which
//! it moves (a Lomb-Scargle periodogram in whitened noise); the best is taken where its gain exceeds what the best of so many
//! trials reaches by chance. For a joint with a lead one and two cycles of its screw are tried.

use super::bins::BinnedLog;
use super::nuisance::Ripple;
use super::problem::Problem;
use crate::numerics::parallel::ParMap;
use crate::numerics::robust::range;
use crate::robot::JointKind;
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// Cycles a turn of the joint that are tried.
const CYCLES: std::ops::RangeInclusive<u32> = 20..=400;
/// Probability that the best of all trials exceeds the limit by chance.
const CHANCE: f64 = 1e-3;
/// Periods nearer than this share to a known one are the same ripple.
const NEAR: f64 = 0.05;
/// Steps of the first look, and how many of its best places are looked at closely.
const COARSE: usize = 3;
const REFINED: usize = 3;
/// Ripples a joint at most.
const MOST: usize = 2;

/// Ripples that the residual shows beyond those of `known`.
pub fn search(problem: &Problem, known: &[Ripple]) -> Vec<Ripple> {
    let white: Vec<Vec<f64>> = (0..problem.logs.len()).par_map(|l| {
        let residual = problem.residual(l, &problem.responses(l, false));
        let mut w = vec![0.0; 3 * residual.len()];
        problem.whiten(l, &residual, &mut w);
        w
    });
    let mut found = Vec::new();
    for (axis, law) in problem.laws.iter().enumerate() {
        if law.is_none() || known.iter().filter(|k| k.axis == axis).count() >= MOST {
            continue;
        }
        let trials = trials(problem, axis);
        let limit = 2.0 * (trials.len() as f64 / CHANCE).ln();
        let gains = gains(problem, &white, axis, &trials);
        let new = |k: usize| known.iter().all(|r| r.axis != axis || (r.per_unit - trials[k]).abs() > NEAR * r.per_unit);
        let best = (0..trials.len()).filter(|k| new(*k)).max_by(|a, b| gains[*a].total_cmp(&gains[*b]));
        if let Some(k) = best.filter(|k| gains[*k] > limit) {
            found.push(Ripple { axis, per_unit: trials[k] });
        }
    }
    found
}

/// Gain of every trial; between trials of little gain only every third is looked at, as neighbours differ by less than the joint's
/// travel resolves.
fn gains(problem: &Problem, white: &[Vec<f64>], axis: usize, trials: &[f64]) -> Vec<f64> {
    let at = |k: usize| gain(problem, white, axis, trials[k]);
    let mut out = vec![0.0; trials.len()];
    let coarse: Vec<usize> = (0..trials.len()).step_by(COARSE).collect();
    let first: Vec<f64> = coarse.par_map(|&k| at(k));
    coarse.iter().zip(&first).for_each(|(&k, g)| out[k] = *g);
    let mut best: Vec<usize> = coarse.clone();
    best.sort_by(|a, b| out[*b].total_cmp(&out[*a]));
    let mut near: Vec<usize> = best
        .iter()
        .take(REFINED)
        .flat_map(|&k| k.saturating_sub(COARSE - 1)..(k + COARSE).min(trials.len()))
        .filter(|k| k % COARSE != 0)
        .collect();
    near.sort_unstable();
    near.dedup();
    let fine: Vec<f64> = near.par_map(|&k| at(k));
    near.iter().zip(&fine).for_each(|(&k, g)| out[k] = *g);
    out
}

/// Angular frequencies over the position of a joint.
fn trials(problem: &Problem, axis: usize) -> Vec<f64> {
    let joint = problem.robot.axis(axis);
    match (joint.kind, joint.lead_m_per_rev) {
        (JointKind::Revolute, _) => CYCLES.map(f64::from).collect(),
        (JointKind::Prismatic, Some(lead)) if lead > 0.0 => vec![TAU / lead, 2.0 * TAU / lead],
        (JointKind::Prismatic, _) => Vec::new(),
    }
}

/// Fall of the cost by a sine and a cosine.
fn gain(problem: &Problem, white: &[Vec<f64>], axis: usize, per_unit: f64) -> f64 {
    let (mut h, mut g) = ([0.0; 3], [0.0; 2]);
    for (l, log) in problem.logs.iter().enumerate() {
        if !moves_enough(log, axis, per_unit) {
            continue;
        }
        let n = log.len();
        let mut columns = [vec![0.0; 3 * n], vec![0.0; 3 * n]];
        for (part, column) in columns.iter_mut().enumerate() {
            let wave = |b: usize| {
                let phase = per_unit * log.q[b][axis];
                if part == 0 { phase.sin() } else { phase.cos() }
            };
            let values: Vec<Vector3<f64>> = (0..n).map(|b| log.sensitivity[b][axis] * wave(b)).collect();
            problem.whiten(l, &values, column);
        }
        let [s, c] = &columns;
        for i in 0..3 * n {
            h[0] += s[i] * s[i];
            h[1] += s[i] * c[i];
            h[2] += c[i] * c[i];
            g[0] += s[i] * white[l][i];
            g[1] += c[i] * white[l][i];
        }
    }
    let det = h[0] * h[2] - h[1] * h[1];
    if det <= 1e-9 * h[0] * h[2] {
        0.0
    } else {
        (g[0] * g[0] * h[2] - 2.0 * g[0] * g[1] * h[1] + g[1] * g[1] * h[0]) / det
    }
}

/// The joint moves over a quarter of a period at least.
fn moves_enough(log: &BinnedLog, axis: usize, per_unit: f64) -> bool {
    log.moving.iter().filter(|m| m.0 == axis).any(|(_, rows)| {
        let [lo, hi] = range(rows.x.iter().copied());
        (hi - lo) * per_unit > TAU / 4.0
    })
}
