//! Does a measured path have the shape that a computed one has, whatever frame it is in?
//!
//! Method: rotation and translation by [`rigid`], with the determinant of the rotation chosen by the caller, so that a mirrored path is
//! distinguished from a rotated one. Points farther out than four times the 75th percentile of the distances are dropped and the fit is
//! repeated; that percentile is also the figure of merit, so that a tenth of outliers neither hides nor makes a misfit.

use crate::numerics::rigid;
use crate::numerics::robust::lower_quantile;
use nalgebra::{Matrix3, Rotation3, Vector3};

const ROUNDS: usize = 5;

/// A rigid (or mirrored) fit `to ~ turn * from + shift`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    pub turn: Matrix3<f64>,
    pub shift: Vector3<f64>,
    /// 75th percentile of the distances that are left, metres.
    pub misfit_m: f64,
}

/// Best fit of `from` to `to`; `mirrored` requests a reflection.
pub(super) fn fit(from: &[Vector3<f64>], to: &[Vector3<f64>], mirrored: bool) -> Fit {
    let mut keep = vec![true; from.len()];
    let mut best = Fit { turn: Matrix3::identity(), shift: Vector3::zeros(), misfit_m: f64::INFINITY };
    for _ in 0..ROUNDS {
        let kept = from.iter().zip(to).zip(&keep).filter(|(_, k)| **k).map(|((p, q), _)| (*p, *q, 1.0));
        let Some(found) = rigid::fit(kept, mirrored) else { return best };
        let (turn, shift) = (found.rotation, found.translation);
        let distance: Vec<f64> = from.iter().zip(to).map(|(p, q)| (q - (turn * p + shift)).norm()).collect();
        let misfit_m = lower_quantile(&distance, 0.75);
        if misfit_m.is_nan() || misfit_m >= best.misfit_m {
            return best;
        }
        best = Fit { turn, shift, misfit_m };
        keep = distance.iter().map(|d| *d <= 4.0 * misfit_m).collect();
    }
    best
}

/// The same with the TCP free in the flange frame: `to ~ turn * (from + frame * offset) + shift`; by turns, each linear.
pub(super) fn fit_with_free_tool(
    from: &[Vector3<f64>],
    frames: &[Rotation3<f64>],
    to: &[Vector3<f64>],
) -> (Fit, Vector3<f64>) {
    const TURNS: usize = 30;
    let all = vec![true; from.len()];
    let n = from.len().max(1) as f64;
    let mean = frames.iter().fold(Matrix3::zeros(), |m, f| m + f.matrix()) / n;
    let mut offset = Vector3::zeros();
    let mut best = (fit(from, to, false), offset);
    for _ in 0..TURNS {
        let back = best.0.turn.transpose();
        let rest: Vec<Vector3<f64>> = from.iter().zip(to).map(|(p, q)| back * (q - best.0.shift) - p).collect();
        let rest_mean = centre(&rest, &all);
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for (f, e) in frames.iter().zip(&rest) {
            let f = f.matrix() - mean;
            normal += f.transpose() * f;
            right += f.transpose() * (e - rest_mean);
        }
        // along an axis about which nothing turns the tool cannot be seen: leave it there
        normal += Matrix3::identity() * (1e-9 * n);
        let Some(inverse) = normal.try_inverse() else { break };
        offset = inverse * right;
        let moved: Vec<Vector3<f64>> = from.iter().zip(frames).map(|(p, f)| p + f * offset).collect();
        let next = fit(&moved, to, false);
        if next.misfit_m >= best.0.misfit_m * 0.999 {
            break;
        }
        best = (next, offset);
    }
    best
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
