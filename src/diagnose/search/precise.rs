//! Joint sensors measure so precisely that a misfit stays: noise and slow ripple beside it.

use crate::diagnose::candidates::basis::BasisGroup;
use crate::diagnose::candidates::{self, spectrum};
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::problem::recording::Recording;
use crate::diagnose::search::finding::Refined;
use crate::diagnose::search::fit::Fit;
use crate::diagnose::search::freed;
use crate::effects::{EffectInstance, Nature};

/// Noise of what a fit leaves. Joint sensors are so precise that structure remains: taken for slow noise it would swallow
/// the next effect, so they are freed of the whole basis each time.
pub(in crate::diagnose) fn noise_left(
    problem: &Problem,
    fit: &Fit,
    whitening: &Whitening,
    groups: &[BasisGroup],
) -> Whitening {
    if problem.recording() == Recording::JointSensors {
        return freed::first_noise(problem, fit, whitening, groups).0;
    }
    Whitening::of_residual(problem, &fit.state.residual, fit.parameters()).0
}

/// Does it follow the position, as the wind-up under gravity does? So does a hysteresis whose transition no pose samples, and a
/// ripple among few poses.
fn follows_position(placed: &EffectInstance) -> bool {
    use Nature::{Coupling, GapOverPosition, Ripple, Scale, WindUp};
    matches!(placed.effect.nature(), WindUp | Ripple | Scale | Coupling | GapOverPosition)
}

/// Joint sensors at settled poses of an arm whose masses are not known: what follows the position may be gravity, which cannot
/// be tried, so that it gets no name.
fn may_be_gravity(problem: &Problem, r: &Refined) -> bool {
    problem.recording() == Recording::JointSensors
        && problem.is_settled()
        && !candidates::survey(problem).axes.iter().any(|a| a.loaded)
        && r.placed.iter().any(follows_position)
}

/// Joint sensors have a free zero: a slow ripple whose size is not known to half of it is no ripple. Nor is one of settled
/// poses that the travel or the spacing does not tell from other curves.
pub(in crate::diagnose) fn determined(problem: &Problem, r: &Refined) -> bool {
    if problem.is_settled() && !r.placed.iter().all(|p| spectrum::identifiable(problem, p)) {
        return false;
    }
    if may_be_gravity(problem, r) {
        return false;
    }
    if problem.recording() != Recording::JointSensors || !r.placed.iter().any(|p| p.effect.nature() == Nature::Ripple) {
        return true;
    }
    let k = r.fit.free.len().saturating_sub(1);
    match (r.placed.first().map(|p| p.effect.values()), r.fit.sigma_of(k).first()) {
        (Some(values), Some(sigma)) => values[0] > 2.0 * sigma,
        _ => true,
    }
}
