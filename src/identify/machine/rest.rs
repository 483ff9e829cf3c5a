//! Friction in logs of dwells apart from friction in motion, where the logs show that they differ.
//!
//! A test of dwells shows what friction has left when a joint has stopped; a path shows it while the joint moves. A servo may work friction
//! off differently at rest, and a test may hold none at all. One friction for both then follows the logs that weigh more, and the
//! reversals of the others end up in their noise.
//!
//! So each joint that has logs of both kinds is tested: by how much would the cost fall, at the present estimate, if one kind had separate
//! spikes (score test; Rao 1948; spikes are not negative)? The logs of dwells get columns for the difference where the fall is beyond
//! doubt, is more than a separate gap would give, and changes the joint's lost motion considerably. The law's spikes are then those
//! of motion, which programs meet; gap, wind-up and presliding stay common to all logs.

use super::bins::BinnedLog;
use super::evidence;
use super::law::{SPIKES, turns};
use super::nuisance::{Column, Name};
use super::problem::Problem;
use super::solve::{self, FixedLaws};
use crate::gaps::note::machine::Note;
use nalgebra::{DMatrix, DVector, Vector3};
use std::ops::Range;

/// Share of a joint's fastest movement below which it stands.
const STANDS: f64 = 0.01;
/// Bins of a dwell, at least.
const DWELL_BINS: usize = 3;
/// Dwells that make a test, at least.
const FEWEST_DWELLS: usize = 3;
/// Fall of the whitened cost, in squared standard deviations, beyond which two frictions are beyond doubt. Noise alone gives less than 45
/// in all but 1 of 10^9 tests; friction of another form than the law's, the same in all logs, gave up to 60 on random machines.
const BEYOND_DOUBT: f64 = 250.0;
/// Change of the spikes together, as a share of the joint's lost motion, that is worth a separate friction.
const WORTH: f64 = 0.2;
/// Rounds of fitting after a joint has been taken apart: its spike leaves the noise of the logs in the first.
const ROUNDS: usize = 2;

/// Takes frictions apart, the joint that gains most first; returns the axes.
pub fn apart(problem: &mut Problem) -> Vec<usize> {
    let mut taken = Vec::new();
    while let Some(axis) = differing(problem, &taken) {
        taken.push(axis);
        add_columns(problem, axis);
        for _ in 0..ROUNDS {
            solve::round(problem, FixedLaws::Nothing);
            solve::refresh_unused(problem);
            refresh_columns(problem);
            solve::refresh_noise(problem);
        }
    }
    taken
}

/// What was found at an axis that is apart.
pub fn note(problem: &Problem, axis: usize) -> Option<Note> {
    let law = problem.laws[axis].as_ref()?;
    let differences = problem.names.iter().zip(&problem.nuisances);
    let difference: f64 =
        differences.filter(|(n, _)| matches!(n, Name::AtRest { axis: a, .. } if *a == axis)).map(|(_, v)| v).sum();
    let (motion, joint) = (law.spikes.iter().sum::<f64>(), problem.robot.axis(axis));
    let dwells = motion + difference;
    Some(Note::FrictionApart { joint: joint.name.clone(), kind: joint.kind, dwells, motion })
}

/// Whether a log is a test of dwells for an axis: nothing moves at least half as often as the axis turns.
fn of_dwells(log: &BinnedLog, axis: usize) -> bool {
    let Some((_, rows)) = log.moving.iter().find(|m| m.0 == axis) else { return false };
    let fastest = |a: usize| log.speed.iter().map(|v| v[a].abs()).fold(0.0, f64::max);
    let fastest: Vec<(usize, f64)> = log.moving.iter().map(|(a, _)| (*a, fastest(*a))).collect();
    let stands = |v: &Vec<f64>| fastest.iter().all(|(a, most)| v[*a].abs() <= STANDS * most);
    let stretches = log.speed.chunk_by(|a, b| stands(a) == stands(b));
    let dwells = stretches.filter(|c| stands(&c[0]) && c.len() >= DWELL_BINS).count();
    dwells >= FEWEST_DWELLS && 2 * dwells >= turns(&rows.x).len()
}

/// Whether every log is a test of dwells for every axis that moves in it.
pub fn only_dwells(problem: &Problem) -> bool {
    problem.logs.iter().all(|log| !log.moving.is_empty() && log.moving.iter().all(|(axis, _)| of_dwells(log, *axis)))
}

/// Logs of dwells and logs of motion in which an axis moves.
fn kinds(problem: &Problem, axis: usize) -> [Vec<usize>; 2] {
    let moves = |l: &usize| problem.logs[*l].moving.iter().any(|m| m.0 == axis);
    let (rest, motion) = (0..problem.logs.len()).filter(moves).partition(|l| of_dwells(&problem.logs[*l], axis));
    [rest, motion]
}

/// The axis whose friction differs most beyond doubt between the kinds of logs, but for those that are apart already.
fn differing(problem: &Problem, taken: &[usize]) -> Option<usize> {
    let both: Vec<(usize, [Vec<usize>; 2])> = (0..problem.laws.len())
        .filter(|a| problem.laws[*a].is_some() && !taken.contains(a))
        .map(|a| (a, kinds(problem, a)))
        .filter(|(_, kinds)| kinds.iter().all(|k| !k.is_empty()))
        .collect();
    if both.is_empty() {
        return None;
    }
    let inverse = evidence::inverse(&problem.normal().hessian)?;
    let gains = both.iter().filter_map(|(axis, kinds)| Some((gain(problem, *axis, kinds, &inverse)?, *axis)));
    gains.filter(|(fall, _)| *fall > BEYOND_DOUBT).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, axis)| axis)
}

/// Fall of the cost if one kind of logs had its own spikes for an axis; `None` where they would hardly change, or where gaps of their
/// own would explain more: then the gap over position misses something of its shape, and friction is not to blame.
fn gain(problem: &Problem, axis: usize, kinds: &[Vec<usize>; 2], inverse: &DMatrix<f64>) -> Option<f64> {
    let law = problem.laws[axis].as_ref()?;
    let knots = problem.offset(axis)..problem.offset(axis) + law.gap.len();
    let spikes = knots.end..knots.end + SPIKES;
    let worth = WORTH * problem.sizes[axis];
    let apart = kinds.iter().filter_map(|logs| own(problem, logs, inverse, spikes.clone()));
    let fall = apart.filter(|(_, by)| by.abs() > worth).map(|(fall, _)| fall).max_by(f64::total_cmp)?;
    let gaps = kinds.iter().filter_map(|logs| own(problem, logs, inverse, knots.clone()));
    let shape: f64 = gaps.map(|(fall, _)| fall.max(0.0)).sum();
    (fall > shape).then_some(fall)
}

/// Fall of the cost if these logs had parameters of their own, none of them negative, and by how much their sum would change.
fn own(problem: &Problem, logs: &[usize], inverse: &DMatrix<f64>, parameters: Range<usize>) -> Option<(f64, f64)> {
    let n = parameters.len();
    let mut curvature = DMatrix::zeros(n, n);
    let mut shared = DMatrix::zeros(n, inverse.nrows());
    let mut score = DVector::zeros(n);
    for &log in logs {
        let part = problem.part(log);
        let Some(at) = part.index.iter().position(|i| *i == parameters.start) else { continue };
        let own = part.design.columns(at, n);
        curvature += own.transpose() * own;
        score += own.tr_mul(&part.residual);
        let products = own.transpose() * &part.design;
        for (k, &global) in part.index.iter().enumerate() {
            let mut column = shared.column_mut(global);
            column += products.column(k);
        }
    }
    // what the other parameters would take over is no gain
    let left = curvature - &shared * inverse * shared.transpose();
    let at = problem.values().rows(parameters.start, n).into_owned();
    let bounds: Vec<usize> = (0..n).collect();
    let by = solve::bounded(&left, &score, 1e-6, &at, &bounds, &[])?;
    Some((2.0 * score.dot(&by) - by.dot(&(&left * &by)), by.sum()))
}

/// Gives the logs of dwells columns for the difference of an axis's spikes.
fn add_columns(problem: &mut Problem, axis: usize) {
    let [rest, _] = kinds(problem, axis);
    // as wide as all of the joint's lost motion: the logs decide
    let sigma = problem.sizes[axis];
    for log in rest {
        let columns = (0..SPIKES).map(|part| {
            let values = spike_column(problem, log, axis, part)
                .unwrap_or_else(|| vec![Vector3::zeros(); problem.logs[log].len()]);
            Column { name: Name::AtRest { axis, part }, sigma, values }
        });
        let columns = columns.collect();
        problem.add_columns(log, columns);
    }
    problem.whiten_columns();
}

/// Brings these columns to the present laws, whose presliding and gap shape them.
fn refresh_columns(problem: &mut Problem) {
    for log in 0..problem.logs.len() {
        let own: Vec<(usize, usize, usize)> = problem.columns[log]
            .index
            .iter()
            .enumerate()
            .filter_map(|(k, at)| match problem.names[*at] {
                Name::AtRest { axis, part } => Some((k, axis, part)),
                _ => None,
            })
            .collect();
        for (k, axis, part) in own {
            if let Some(values) = spike_column(problem, log, axis, part) {
                problem.columns[log].values[k] = values;
            }
        }
    }
}

/// What a unit of a spike does to the TCP in a log, bin by bin.
fn spike_column(problem: &Problem, log: usize, axis: usize, part: usize) -> Option<Vec<Vector3<f64>>> {
    let (l, law) = (&problem.logs[log], problem.laws[axis].as_ref()?);
    let (_, rows) = l.moving.iter().find(|m| m.0 == axis)?;
    let response = rows.respond(law, true);
    let mut bins = Vec::new();
    l.average(&response.by[law.gap.len() + part], &mut bins);
    Some(l.sensitivity.iter().zip(&bins).map(|(j, by)| j[axis] * *by).collect())
}
