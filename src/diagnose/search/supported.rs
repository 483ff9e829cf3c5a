//! Do blocks that were not fitted support an effect of joint sensors?
//!
//! Their noise is far below any misfit, so that the likelihood believes whatever follows the misfit a little; with a few poses
//! it is a slow ripple of a degree. Parts that were not fitted tell: an effect must lessen what is left of them, in most folds.

use crate::diagnose::candidates::sensitivities::tangent;
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::problem::recording::Recording;
use crate::diagnose::search::finding::Refined;
use crate::diagnose::search::fit::Fit;
use crate::diagnose::search::together::blocks::Blocks;
use crate::diagnose::search::together::members::SUPPORTED;

/// Folds of five that it must improve.
const MOST_FOLDS: usize = 3;

/// What a fit leaves of each fold, fitted to the others, in 2 ln L.
fn left(problem: &Problem, fit: &Fit, whitening: &Whitening) -> Vec<f64> {
    let columns = tangent(problem, &fit.hypothesis, &fit.state, &fit.free, whitening);
    let slices: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let blocks = Blocks::new(problem, &slices, &whitening.of(problem, &fit.state.residual));
    let (all, none) = ((0..columns.len()).collect::<Vec<_>>(), vec![0.0; columns.len()]);
    blocks.held_out(&all, &none, &none)
}

/// Does a refined effect lessen what `base` leaves of parts that were not fitted? Other recordings are not asked.
pub fn supported(problem: &Problem, base: &Fit, refined: &Refined, whitening: &Whitening) -> bool {
    if problem.recording() != Recording::JointSensors {
        return true;
    }
    let (without, with) = (left(problem, base, whitening), left(problem, &refined.fit, whitening));
    let gains: Vec<f64> = without.iter().zip(&with).map(|(a, b)| a - b).collect();
    gains.iter().sum::<f64>() > SUPPORTED && gains.iter().filter(|g| **g > 0.0).count() >= MOST_FOLDS
}
