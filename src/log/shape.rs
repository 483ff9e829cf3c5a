//! Does a measured path have the shape that a computed one has, whatever frame it is in?
//!
//! Method: rotation and translation by [`rigid`], with the determinant of the rotation chosen by the caller, so that a mirrored path is
//! distinguished from a rotated one. Points farther out than four times the 75th percentile of the distances are dropped and the fit is
//! repeated; that percentile is also the figure of merit, so that a tenth of outliers neither hides nor makes a misfit.

use crate::numerics::rigid;
use crate::numerics::robust::lower_quantile;
use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, Vector3};

const ROUNDS: usize = 5;

/// A rigid (or mirrored) fit `to ~ rotation * from + translation`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    pub rotation: Matrix3<f64>,
    pub translation: Vector3<f64>,
    /// 75th percentile of the distances that are left, metres.
    pub misfit_m: f64,
}

/// Best fit of `from` to `to`; `mirrored` requests a reflection.
pub(super) fn fit(from: &[Vector3<f64>], to: &[Vector3<f64>], mirrored: bool) -> Fit {
    let mut keep = vec![true; from.len()];
    let mut best = Fit { rotation: Matrix3::identity(), translation: Vector3::zeros(), misfit_m: f64::INFINITY };
    for _ in 0..ROUNDS {
        let kept = from.iter().zip(to).zip(&keep).filter(|(_, k)| **k).map(|((p, q), _)| (*p, *q, 1.0));
        let Some(found) = rigid::fit(kept, mirrored) else { return best };
        let (rotation, translation) = (found.rotation, found.translation);
        let distance: Vec<f64> = from.iter().zip(to).map(|(p, q)| (q - (rotation * p + translation)).norm()).collect();
        let misfit_m = lower_quantile(&distance, 0.75);
        if misfit_m.is_nan() || misfit_m >= best.misfit_m {
            return best;
        }
        best = Fit { rotation, translation, misfit_m };
        keep = distance.iter().map(|d| *d <= 4.0 * misfit_m).collect();
    }
    best
}

/// The same with the TCP free in the flange frame: `to ~ rotation * (from + frame * offset) + translation`. Gauss-Newton steps of offset,
/// rotation and translation together: on a path along which the flange turns little, one of them alone hardly moves.
pub(super) fn fit_with_free_tool(
    from: &[Vector3<f64>],
    frames: &[Rotation3<f64>],
    to: &[Vector3<f64>],
) -> (Fit, Vector3<f64>) {
    const STEPS: usize = 30;
    let with =
        |offset: &Vector3<f64>| -> Vec<Vector3<f64>> { from.iter().zip(frames).map(|(p, f)| p + f * offset).collect() };
    let mut best = (fit(from, to, false), Vector3::zeros());
    for _ in 0..STEPS {
        let Some(step) = tool_step(&with(&best.1), frames, to, &best.0) else { break };
        let offset = best.1 + step;
        let next = fit(&with(&offset), to, false);
        if next.misfit_m.is_nan() || next.misfit_m >= best.0.misfit_m * 0.999 {
            break;
        }
        best = (next, offset);
    }
    best
}

/// The change of the offset that a linear model of offset, rotation and translation asks for.
fn tool_step(moved: &[Vector3<f64>], frames: &[Rotation3<f64>], to: &[Vector3<f64>], at: &Fit) -> Option<Vector3<f64>> {
    let middle = centre(moved, &vec![true; moved.len()]);
    let (mut normal, mut right) = (SMatrix::<f64, 9, 9>::zeros(), SVector::<f64, 9>::zeros());
    for ((p, f), q) in moved.iter().zip(frames).zip(to) {
        let left = q - (at.rotation * p + at.translation);
        if left.norm() > 4.0 * at.misfit_m {
            continue;
        }
        let mut jacobian = SMatrix::<f64, 3, 9>::zeros();
        jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&(at.rotation * f.matrix()));
        jacobian.fixed_view_mut::<3, 3>(0, 3).copy_from(&-(at.rotation * (p - middle)).cross_matrix());
        jacobian.fixed_view_mut::<3, 3>(0, 6).copy_from(&Matrix3::identity());
        normal += jacobian.transpose() * jacobian;
        right += jacobian.transpose() * left;
    }
    // along an axis about which nothing turns the tool cannot be seen: leave it there
    let little = 1e-9 * moved.len().max(1) as f64;
    (0..3).for_each(|k| normal[(k, k)] += little);
    let step = normal.cholesky()?.solve(&right);
    Some(step.fixed_rows::<3>(0).into_owned()).filter(|s| s.iter().all(|v| v.is_finite()))
}

/// 75th percentile of the distances from the centre, metres.
pub(super) fn spread(points: &[Vector3<f64>]) -> f64 {
    let c = centre(points, &vec![true; points.len()]);
    lower_quantile(&points.iter().map(|p| (p - c).norm()).collect::<Vec<_>>(), 0.75)
}

fn centre(points: &[Vector3<f64>], keep: &[bool]) -> Vector3<f64> {
    let mut sum = Vector3::zeros();
    let mut n = 0.0;
    for (p, _) in points.iter().zip(keep).filter(|(_, k)| **k) {
        sum += p;
        n += 1.0;
    }
    if n > 0.0 { sum / n } else { sum }
}
