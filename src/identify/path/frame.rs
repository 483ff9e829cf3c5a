//! The tracker's frame of the fit, and the residual of its rows.

use super::problem::Problem;
use super::select::Selected;
use crate::gaps::Registered;
use nalgebra::{Matrix3, Vector3};

/// Root mean square of a coordinate of a row about the fit, m: within the bins and between them.
pub(super) fn rms_m(problem: &Problem, selected: &Selected) -> f64 {
    let (mut within, mut rest, mut rows) = (0.0, 0.0, 0usize);
    for (l, log) in problem.logs().enumerate() {
        within += log.within_m2;
        rest += problem.residual(l, &selected.values).iter().map(|r| r.norm_squared()).sum::<f64>()
            / problem.scale(l).powi(2);
        rows += log.good;
    }
    ((within + rest) / (3.0 * rows.max(1) as f64)).sqrt()
}

/// The frame of the first log and its standard errors; `variance` is that of a row in units of its noise.
pub(super) fn registration(problem: &Problem, s: &Selected, rms_m: f64, variance: f64) -> Option<Registered> {
    let log = problem.logs().next()?;
    let (_, cov) = problem.frame_error(0, &s.values);
    // the covariance is about the middle of the path; the frame's origin is elsewhere
    let centre = log.want.iter().sum::<Vector3<f64>>() / log.want.len().max(1) as f64;
    let arm = centre - log.frame.translation.vector;
    let rotation = cov.fixed_view::<3, 3>(3, 3).into_owned();
    let cross = arm.cross_matrix();
    let mixed = cov.fixed_view::<3, 3>(0, 3) * cross.transpose();
    let translation = cov.fixed_view::<3, 3>(0, 0) + cross * rotation * cross.transpose() + mixed + mixed.transpose();
    let frame = log.frame.inverse();
    // world frame -> tracker frame
    let r = frame.rotation.to_rotation_matrix();
    let translation = r.matrix() * translation * r.matrix().transpose() * variance;
    let rotation = r.matrix() * rotation * r.matrix().transpose() * variance;
    let root = |k: usize, m: &Matrix3<f64>| m[(k, k)].max(0.0).sqrt();
    Some(Registered {
        frame,
        rms_m,
        samples: problem.logs().map(|l| l.good).sum(),
        sigma_m: [0, 1, 2].map(|k| root(k, &translation)),
        sigma_rad: [0, 1, 2].map(|k| root(k, &rotation)),
    })
}
