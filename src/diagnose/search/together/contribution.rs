//! How far each effect moves the TCP.

use crate::diagnose::problem::forward::Problem;
use crate::diagnose::problem::layout::Sensor;
use crate::diagnose::problem::normal::{dot, gram};
use crate::diagnose::search::fit::Fit;
use crate::effects::EffectInstance;
use crate::numerics::normal_equations::pseudo_inverse;
use crate::numerics::parallel::ParMap;
use nalgebra::DVector;

/// An effect is named where it moves the TCP by this part of what is left with everything found, rms.
pub const WORTH: f64 = 0.2;

/// rms per coordinate of what each free effect moves, beyond a movement of the frame; the largest log.
pub fn contributions(problem: &Problem, fit: &Fit) -> Vec<f64> {
    fit.free.par_map(|&i| contribution(problem, fit, std::slice::from_ref(&fit.hypothesis.effects[i])))
}

/// The same of some of the effects together.
pub(super) fn contribution(problem: &Problem, fit: &Fit, effects: &[EffectInstance]) -> f64 {
    let moved = problem.difference(&fit.hypothesis, &fit.state, effects, &[], 1.0);
    (0..problem.logs.len()).map(|l| beyond_frame(problem, fit, l, &moved)).fold(0.0, f64::max)
}

/// rms over one log of a column beyond what a rigid movement of that log explains.
fn beyond_frame(problem: &Problem, fit: &Fit, log: usize, column: &[f64]) -> f64 {
    // micrometres are those of the TCP
    let groups: Vec<_> = problem.groups_of(log).filter(|g| g.sensor != Sensor::Orientation).collect();
    let n: usize = groups.iter().map(|g| g.range().len()).sum();
    let part = |v: &[f64]| -> Vec<f64> { groups.iter().flat_map(|g| v[g.range()].iter().copied()).collect() };
    let y = part(column);
    if groups.iter().any(|g| g.dims != 3) {
        return (dot(&y, &y) / n.max(1) as f64).sqrt();
    }
    let frame: Vec<Vec<f64>> =
        problem.frame_columns(&fit.state, problem.logs[log].frame).iter().map(|c| part(c)).collect();
    let right = DVector::from_iterator(frame.len(), frame.iter().map(|c| dot(c, &y)));
    let x = pseudo_inverse(&gram(&frame), 1e-12) * &right;
    ((dot(&y, &y) - x.dot(&right)).max(0.0) / n.max(1) as f64).sqrt()
}
