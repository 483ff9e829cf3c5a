//! The residual freed of the whole catalogue-free basis: its noise, and the test whether structure is left.

use crate::diagnose::candidates::basis::BasisGroup;
use crate::diagnose::candidates::structure::{self, Tested};
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::search::fit::Fit;
use crate::diagnose::search::precise;

/// The test without the catalogue, under the noise of what is left.
pub(in crate::diagnose) fn tested(problem: &Problem, fit: &Fit, groups: &[BasisGroup]) -> Tested {
    let whitening = Whitening::of_residual(problem, &fit.state.residual, fit.parameters()).0;
    let whitening = precise::noise_left(problem, fit, &whitening, groups);
    structure::test(&fit.screening(problem, &whitening), groups)
}

/// Noise of the residual freed of the whole catalogue-free basis, in two turns.
pub(in crate::diagnose) fn first_noise(
    problem: &Problem,
    fit: &Fit,
    white: &Whitening,
    groups: &[BasisGroup],
) -> (Whitening, Tested) {
    let (whitening, _) = noise_of_freed(problem, fit, white, groups);
    noise_of_freed(problem, fit, &whitening, groups)
}

/// One turn of it.
pub(in crate::diagnose) fn noise_of_freed(
    problem: &Problem,
    fit: &Fit,
    whitening: &Whitening,
    groups: &[BasisGroup],
) -> (Whitening, Tested) {
    let context = fit.screening(problem, whitening);
    let tested = structure::test(&context, groups);
    (Whitening::of_residual(problem, &tested.freed, tested.whole.dof).0, tested)
}
