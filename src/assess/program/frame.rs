//! The rigid frame in which measured points lie on a path.
//!
//! A step in the commands makes the way longer, and a log's rows are apart: the length of the way gives the place along the path to some
//! tenths of a millimetre only. A rigid fit to the places by length turns such errors along the path into errors across it wherever the
//! path bends. So it is only the start. From there the distances across the path are made least, point to line (Chen and Medioni 1992), by
//! damped Gauss-Newton steps. The damping leaves alone what the path does not show: a circle in its own plane may be turned.
//!
//! How it fails: points on one line do not determine the frame, and none is returned.

use super::path::Reference;
use crate::assess::rigid;
use nalgebra::{Isometry3, Matrix3, Matrix3x6, Matrix6, Translation3, UnitQuaternion, Vector3, Vector6};

/// Points that are fitted at most.
const POINTS: usize = 4_000;
/// Steps.
const ROUNDS: usize = 30;
/// Damping, as a share of the mean of the diagonal.
const DAMPING: f64 = 1e-3;

/// The frame that brings points onto a path, across it; `along_m`: about the length of the path at each, within `slack_m`.
pub fn across(seen: &[Vector3<f64>], along_m: &[f64], reference: &Reference, slack_m: f64) -> Option<Isometry3<f64>> {
    let step = seen.len().div_ceil(POINTS).max(1);
    let seen: Vec<Vector3<f64>> = seen.iter().step_by(step).copied().collect();
    let along_m: Vec<f64> = along_m.iter().step_by(step).copied().collect();
    let by_length: Vec<Vector3<f64>> = along_m.iter().map(|a| reference.at(*a)).collect();
    let mut frame = rigid::fit(&seen, &by_length)?;
    for _ in 0..ROUNDS {
        let placed: Vec<Vector3<f64>> = seen.iter().map(|p| frame.rotation * p + frame.translation.vector).collect();
        match better(&placed, &along_m, reference, slack_m) {
            Some(step) => frame = step * frame,
            None => break,
        }
    }
    Some(frame)
}

/// One step: a small movement of the points that lessens their distances across the path.
fn better(placed: &[Vector3<f64>], along_m: &[f64], reference: &Reference, slack_m: f64) -> Option<Isometry3<f64>> {
    let n = placed.len() as f64;
    let centre = placed.iter().sum::<Vector3<f64>>() / n;
    // turns are counted as movements at the edge of the points
    let lever_m = (placed.iter().map(|p| (p - centre).norm_squared()).sum::<f64>() / n).sqrt();
    if lever_m <= 0.0 || lever_m.is_nan() {
        return None;
    }
    let (mut normal, mut right) = (Matrix6::<f64>::zeros(), Vector6::<f64>::zeros());
    for (p, a) in placed.iter().zip(along_m) {
        let near = reference.nearest(p, *a, slack_m);
        let across = Matrix3::identity() - near.direction * near.direction.transpose();
        let mut moves = Matrix3x6::zeros();
        moves.fixed_columns_mut::<3>(0).copy_from(&Matrix3::identity());
        moves.fixed_columns_mut::<3>(3).copy_from(&(-(p - centre).cross_matrix() / lever_m));
        let moves = across * moves;
        normal += moves.transpose() * moves;
        right += moves.transpose() * (across * (p - near.at));
    }
    let damped = normal + Matrix6::identity() * (DAMPING * normal.trace() / 6.0);
    let step = -(damped.cholesky()?.solve(&right));
    let turn = UnitQuaternion::from_scaled_axis(step.fixed_rows::<3>(3) / lever_m);
    let about_centre = Translation3::from(centre) * turn * Translation3::from(-centre);
    Some(Translation3::from(step.fixed_rows::<3>(0).into_owned()) * about_centre)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ring of straight pieces, seen in another frame, with lengths of the way that are wrong by up to half a millimetre.
    #[test]
    fn lengths_that_are_wrong_along_the_path_leave_nothing_across_it() {
        let corner = |k: usize| {
            let (s, c) = (k as f64 * std::f64::consts::TAU / 24.0).sin_cos();
            Vector3::new(0.9, 0.12 * c, 0.12 * s)
        };
        let points: Vec<Vector3<f64>> =
            (0..24).flat_map(|k| (0..40).map(move |i| corner(k).lerp(&corner(k + 1), f64::from(i) / 40.0))).collect();
        let reference = Reference::new(points.clone(), (0..points.len()).map(|i| i as f64).collect());
        let own = super::super::path::lengths(points.iter().copied());
        let along: Vec<f64> = own.iter().map(|a| a + 0.5e-3 * (1.0 - (a * 8.0).cos())).collect();
        let frame = Isometry3::new(Vector3::new(2.6, -1.9, 0.3), Vector3::new(0.4, 0.2, -1.0));
        let seen: Vec<Vector3<f64>> = points.iter().map(|p| frame.rotation * p + frame.translation.vector).collect();
        let found = across(&seen, &along, &reference, 2e-3).unwrap();
        let error = |(p, a): (&Vector3<f64>, &f64)| {
            let placed = found.rotation * p + found.translation.vector;
            reference.nearest(&placed, *a, 2e-3).off_m
        };
        let largest = seen.iter().zip(&along).map(error).fold(0.0, f64::max);
        assert!(largest < 1e-7, "{largest}");
    }
}
