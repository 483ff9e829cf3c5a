//! Joint sensors measure so precisely that a misfit stays: noise, delays and slow ripple beside it.

use super::fit::{self, Fit, Whitening, dot, gram, scaled_inverse};
use super::forward::Problem;
use super::screen::Ground;
use super::search::Refined;
use super::structure::{self, Bundle};
use nalgebra::DVector;

/// Noise of what a fit leaves. Joint sensors are so precise that structure remains: taken for slow noise it would swallow
/// the next effect, so they are freed of the whole basis each time.
pub(super) fn noise_left(problem: &Problem, fit: &Fit, whitening: &Whitening, bundles: &[Bundle]) -> Whitening {
    if problem.groups.iter().all(|g| g.dims == 1) {
        return super::search::first_noise(problem, fit, whitening, bundles).0;
    }
    Whitening::of_residual(problem, &fit.state.residual, fit.parameters()).0
}

/// Parameters that do not depend on the pose, estimated beside smooth terms in it. Joint sensors are so precise that a misfit
/// stays, and it would bend a delay by hundreds of its uncertainty. What such terms could swallow stays as it is.
pub(super) fn beside_structure(problem: &Problem, fit: &Fit, whitening: &Whitening, bundles: &[Bundle]) -> Fit {
    let tangent = fit::tangent(problem, &fit.hypothesis, &fit.state, &fit.free, whitening);
    let values: usize = fit.free.iter().map(|&i| fit.hypothesis.effects[i].effect.values().len()).sum();
    let mut smooth: Vec<Vec<f64>> = tangent[values..].to_vec();
    for b in bundles.iter().filter(|b| matches!(b.aspect, structure::Aspect::Position | structure::Aspect::Geometry)) {
        smooth.extend(b.columns.iter().map(|c| whitening.of(problem, c)));
    }
    let ground = Ground::new(problem, &fit.hypothesis, &fit.state, whitening, smooth);
    let mut columns = tangent[..values].to_vec();
    let own: Vec<bool> = columns
        .iter_mut()
        .map(|c| {
            let before = dot(c, c);
            ground.take_tangent_off(c);
            dot(c, c) > OWN_SHARE * before
        })
        .collect();
    let moved: Vec<usize> = (0..values).filter(|&k| own[k]).collect();
    let kept: Vec<Vec<f64>> = moved.iter().map(|&k| columns[k].clone()).collect();
    let covariance = scaled_inverse(&gram(&kept), 1e-10);
    let right = DVector::from_iterator(kept.len(), kept.iter().map(|c| dot(c, &ground.residual)));
    let step = &covariance * right;
    let mut all = fit.clone();
    let mut change = vec![0.0; values];
    for (i, &k) in moved.iter().enumerate() {
        change[k] = step[i];
        for (j, &m) in moved.iter().enumerate() {
            all.covariance[(k, m)] = covariance[(i, j)];
        }
    }
    let mut at = 0;
    for &i in &fit.free {
        let placed = &mut all.hypothesis.effects[i];
        let bounds = placed.bounds(&problem.robot);
        let mut values = placed.effect.values();
        for (v, (lo, hi)) in values.iter_mut().zip(bounds) {
            *v = (*v + change[at]).clamp(lo, hi);
            at += 1;
        }
        placed.effect = placed.effect.with_values(&values);
    }
    // the zeros follow
    let only = fit::refit(problem, &all.hypothesis, &[], whitening);
    Fit { hypothesis: only.hypothesis, state: only.state, ..all }
}

/// Share of a signature that smooth terms may not swallow.
const OWN_SHARE: f64 = 0.2;

/// Joint sensors have a free zero: a slow ripple whose size is not known to half of it is no ripple.
pub(super) fn determined(problem: &Problem, r: &Refined) -> bool {
    let sensors = problem.groups.iter().all(|g| g.dims == 1);
    if !sensors || r.effect != "transmission_error" {
        return true;
    }
    let k = r.fit.free.len().saturating_sub(1);
    match (r.placed.first().map(|p| p.effect.values()), r.fit.sigma_of(k).first()) {
        (Some(values), Some(sigma)) => values[0] > 2.0 * sigma,
        _ => true,
    }
}
