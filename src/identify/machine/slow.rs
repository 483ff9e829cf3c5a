//! Friction that is larger at low speed (Stribeck): do the logs show it, at which joints, and at which speed does it fade?
//!
//! Each joint is tested at speeds half a decade apart: by how much would the cost fall, at the present estimate, if its friction had an
//! excess at low speed (score test; Rao 1948; the excess is not negative)? Joints at which it falls by more than chance are fitted with an
//! excess and a speed of their own, from the best of these speeds on: the cost has a valley for each. The larger law is kept if it predicts
//! parts of the logs that were not fitted better beyond doubt; else every joint keeps friction that is the same at all speeds.
//!
//! Assumes one growth for the servo's spikes and for the wind-up of a joint. It fails where logs hold one speed alone: then nothing tells
//! an excess from friction, and nothing is fitted.

use super::evidence;
use super::problem::{Part, Problem, slow_speed};
use super::solve::{self, Kept};
use crate::effects::stribeck::Stribeck;
use nalgebra::{DMatrix, DVector, Vector3};
use rayon::prelude::*;

/// Speeds that are tried, as multiples of the expected one: half a decade apart, two standard deviations of the prior to either side.
const SPEEDS: [f64; 5] = [0.05, 0.16, 0.5, 1.6, 5.0];
/// Fall of the whitened cost, in squared standard deviations, from which a joint is fitted with an excess: of the best of so many speeds,
/// noise alone gives less in all but 1 of 1000 tests.
const BEYOND_CHANCE: f64 = 14.0;
/// Smallest and largest excess with which a fit starts.
const START: [f64; 2] = [0.05, 0.5];
/// Fall of the cost on parts that were not fitted must exceed so many standard errors of it.
const BEYOND_DOUBT: f64 = 2.0;
/// Rounds of fitting until the cost has settled, at most, and the fall of the cost at which it has.
const ROUNDS: usize = 3;
const SETTLED: f64 = 0.5;

/// Gives joints an excess of friction at low speed where the logs show it.
pub fn choose(problem: &mut Problem) {
    settle(problem);
    let Some(found) = candidates(problem).filter(|f| !f.is_empty()) else { return };
    let Some(before) = evidence::held_out(problem) else { return };
    let (laws, nuisances) = (problem.laws.clone(), problem.nuisances.clone());
    for (axis, stribeck) in found {
        if let Some(law) = &mut problem.laws[axis] {
            law.stribeck = Some(stribeck);
        }
    }
    settle(problem);
    if !evidence::held_out(problem).is_some_and(|after| falls(&before, &after)) {
        (problem.laws, problem.nuisances) = (laws, nuisances);
    }
}

/// Fits until the cost no longer falls.
fn settle(problem: &mut Problem) {
    let mut last = f64::INFINITY;
    for _ in 0..ROUNDS {
        let cost = solve::round(problem, Kept::Nothing);
        if cost > last - SETTLED {
            break;
        }
        last = cost;
    }
}

/// Whether costs of parts fall beyond doubt.
fn falls(before: &[f64], after: &[f64]) -> bool {
    let n = before.len() as f64;
    let by: Vec<f64> = before.iter().zip(after).map(|(b, a)| b - a).collect();
    let mean = by.iter().sum::<f64>() / n;
    let variance = by.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0);
    n > 1.0 && mean > BEYOND_DOUBT * (variance / n).sqrt()
}

/// Joints whose friction is larger at low speed beyond chance, each with the best of the speeds.
fn candidates(problem: &Problem) -> Option<Vec<(usize, Stribeck)>> {
    let inverse = evidence::inverse(&problem.normal().hessian)?;
    let parts: Vec<Part> = (0..problem.logs.len()).into_par_iter().map(|l| problem.part(l)).collect();
    let axes = (0..problem.laws.len()).filter(|a| problem.laws[*a].is_some());
    let best = |axis: usize| {
        let expected = slow_speed(problem.robot, axis);
        let tried = SPEEDS.into_par_iter().filter_map(|s| trial(problem, &parts, &inverse, axis, s * expected));
        let tried: Vec<(f64, Stribeck)> = tried.collect();
        let best = tried.into_iter().filter(|t| t.0 > BEYOND_CHANCE).max_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, stribeck)| (axis, stribeck))
    };
    Some(axes.filter_map(best).collect())
}

/// Fall of the cost if an axis had an excess that fades at `speed`, and that excess.
fn trial(
    problem: &Problem,
    parts: &[Part],
    inverse: &DMatrix<f64>,
    axis: usize,
    speed: f64,
) -> Option<(f64, Stribeck)> {
    let law = problem.laws[axis].as_ref()?;
    let (mut curvature, mut score, mut shared) = (0.0, 0.0, DVector::zeros(inverse.nrows()));
    let mut bins = Vec::new();
    for (log, part) in parts.iter().enumerate() {
        let l = &problem.logs[log];
        let Some((_, rows)) = l.moving.iter().find(|m| m.0 == axis) else { continue };
        l.average(&rows.by_excess(law, speed), &mut bins);
        let values: Vec<Vector3<f64>> = l.sensitivity.iter().zip(&bins).map(|(j, by)| j[axis] * *by).collect();
        let mut column = DVector::zeros(3 * l.len());
        problem.whiten(log, &values, column.as_mut_slice());
        curvature += column.norm_squared();
        score += column.dot(&part.residual);
        for (at, product) in part.index.iter().zip(part.design.tr_mul(&column).iter()) {
            shared[*at] += product;
        }
    }
    // what the other parameters would take over is no gain
    let left = curvature - shared.dot(&(inverse * &shared));
    let excess = score / left;
    (left > 0.0 && excess > 0.0).then(|| (score * excess, Stribeck { excess: excess.clamp(START[0], START[1]), speed }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fall_that_scatters_around_nothing_is_none() {
        let before = vec![100.0; 24];
        let after = |by: f64| (0..24).map(|i| 100.0 - by + 2.0 * f64::from(i % 5 - 2)).collect::<Vec<f64>>();
        assert!(falls(&before, &after(2.0)));
        assert!(!falls(&before, &after(0.5)) && !falls(&before, &after(-2.0)));
        assert!(!falls(&before[..1], &after(2.0)[..1]));
    }
}
