//! Ripples of joints as candidates.

use crate::diagnose::problem::forward::Problem;
use crate::effects::{Candidate, transmission_error};

/// Ripple of an axis at a number of cycles per revolution (of its lead, for a prismatic one).
pub fn ripple(problem: &Problem, axis: usize, cycles_per_rev: f64) -> Candidate {
    transmission_error::ripple(&problem.robot, axis, cycles_per_rev)
}

/// The ripple with its own phase in each log.
pub fn ripple_by_log(problem: &Problem, axis: usize, cycles_per_rev: f64) -> Candidate {
    transmission_error::ripple_by_log(&problem.robot, axis, cycles_per_rev, problem.logs.len())
}
