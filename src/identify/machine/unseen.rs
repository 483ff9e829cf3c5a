//! Joints of which single readings tell nothing.
//!
//! A ballbar or a dial sees a joint only as far as it moves the TCP along the reading, and apart from others only where it does so in its
//! own way. What is left open is filled by priors: an estimate of that kind is none, and is not given. Where a tracker has seen the joint,
//! it is.

use super::estimate::mean_weights;
use super::evidence;
use super::law::{JointRows, turns};
use super::problem::Problem;
use crate::gaps::note::machine::Note;
use crate::identify::scalar::largest_determined_sigma;
use crate::machine::measurement::Instrument;
use nalgebra::DMatrix;

/// Axes that turn, that single readings alone have seen and whose gap they do not determine, with its standard deviation.
pub fn undetermined(problem: &Problem) -> Vec<(usize, f64)> {
    let tracked = |axis: usize| {
        let reverses = |m: &(usize, JointRows)| m.0 == axis && !turns(&m.1.x).is_empty();
        let whole = |i: &Instrument| matches!(i, Instrument::Tcp | Instrument::Joint { .. });
        problem.logs.iter().any(|l| whole(&l.instrument) && l.moving.iter().any(reverses))
    };
    let axes = (0..problem.laws.len()).filter(|a| problem.laws[*a].is_some() && !tracked(*a));
    let axes: Vec<usize> = axes.filter(|a| mean_weights(problem, *a).2 > 0).collect();
    if axes.is_empty() {
        return Vec::new();
    }
    let hessian = problem.normal().hessian;
    let mut basis = DMatrix::identity(hessian.nrows(), hessian.ncols());
    for &axis in &axes {
        let (at, knots) = (problem.offset(axis), mean_weights(problem, axis).0.len());
        basis.view_mut((at, at), (knots, 1)).fill(1.0);
    }
    let inverse = evidence::inverse(&(basis.transpose() * hessian * basis));
    let sigma = |axis: usize| {
        let (mut weights, _, _) = mean_weights(problem, axis);
        let (at, knots) = (problem.offset(axis), weights.len());
        weights[0] = 1.0;
        let Some(inverse) = &inverse else { return f64::INFINITY };
        weights.dot(&(inverse.view((at, at), (knots, knots)) * &weights)).max(0.0).sqrt()
    };
    let limit = |axis: usize| largest_determined_sigma(problem.robot.axis(axis).kind);
    axes.into_iter().map(|a| (a, sigma(a))).filter(|(a, sigma)| *sigma > limit(*a)).collect()
}

/// Why such a joint gets no estimate.
pub fn note(problem: &Problem, axis: usize, sigma: f64) -> Note {
    let joint = problem.robot.axis(axis);
    Note::NotDetermined { joint: joint.name.clone(), kind: joint.kind, sigma }
}
