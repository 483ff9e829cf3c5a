//! The rigid transform that takes one set of points onto another with the least weighted sum of squares.
//!
//! Method: rotation from the singular values of the cross moments (Kabsch 1976), the sign given to the direction of least
//! spread so that it never mirrors (Umeyama 1991), or that it always does where a reflection is requested.
//!
//! Fails: `None` without points or with values that are not finite. Whether the points determine the frame is for the caller
//! to judge, from [`RigidFit::spread`]: points on one line leave a rotation about it open.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

/// `to = rotation from + translation`, in the unit of the points.
#[derive(Debug, Clone, Copy)]
pub struct RigidFit {
    /// Orthogonal; its determinant is -1 where a reflection was requested.
    pub rotation: Matrix3<f64>,
    /// In the unit of the points.
    pub translation: Vector3<f64>,
    /// Singular values of the weighted mean cross moments, falling: the second over the first shows a line.
    pub spread: [f64; 3],
}

impl RigidFit {
    /// As a rigid transform; of a reflection it has no meaning.
    pub fn isometry(&self) -> Isometry3<f64> {
        let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(self.rotation));
        Isometry3::from_parts(Translation3::from(self.translation), rotation)
    }
}

/// Fits pairs `(from, to, weight)`; `mirrored` requests a reflection.
///
/// ```
/// use lostmotion_numerics::rigid::fit;
/// use nalgebra::Vector3;
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vector3::from);
/// let turned = corners.map(|p| Vector3::new(2.0 - p.y, p.x, p.z));
/// let found = fit(corners.iter().zip(&turned).map(|(a, b)| (*a, *b, 1.0)), false).unwrap();
/// assert!((found.translation - Vector3::new(2.0, 0.0, 0.0)).norm() < 1e-14);
/// assert!((found.isometry().rotation.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-14);
/// ```
pub fn fit(pairs: impl Iterator<Item = (Vector3<f64>, Vector3<f64>, f64)> + Clone, mirrored: bool) -> Option<RigidFit> {
    let (mut total, mut a, mut b) = (0.0, Vector3::zeros(), Vector3::zeros());
    for (from, to, weight) in pairs.clone() {
        total += weight;
        a += from * weight;
        b += to * weight;
    }
    (a, b) = (a / total, b / total);
    let mut cross = Matrix3::zeros();
    for (from, to, weight) in pairs {
        cross += (to - b) * (from - a).transpose() * weight;
    }
    cross /= total;
    if !cross.iter().all(|v| v.is_finite()) {
        return None;
    }
    let svd = cross.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let least = svd.singular_values.imin();
    let mut signs = Vector3::repeat(1.0);
    signs[least] = (u * v_t).determinant().signum() * if mirrored { -1.0 } else { 1.0 };
    let rotation = u * Matrix3::from_diagonal(&signs) * v_t;
    let mut spread: [f64; 3] = svd.singular_values.into();
    spread.sort_by(|a, b| b.total_cmp(a));
    Some(RigidFit { rotation, translation: b - rotation * a, spread })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(n: usize) -> Vec<Vector3<f64>> {
        (0..n).map(|i| i as f64).map(|x| Vector3::new(x.sin(), (1.7 * x).cos(), 0.3 * (x % 4.0))).collect()
    }

    #[test]
    fn finds_a_known_frame_from_points_of_a_plane_too() {
        let truth = Isometry3::new(Vector3::new(2.65, 1.89, -0.64), Vector3::new(0.4, 2.0, -1.1));
        for flat in [1.0, 0.0] {
            let from: Vec<_> = cloud(20).iter().map(|p| p.component_mul(&Vector3::new(1.0, 1.0, flat))).collect();
            let to: Vec<_> = from.iter().map(|p| truth.rotation * p + truth.translation.vector).collect();
            let found = fit(from.iter().zip(&to).map(|(a, b)| (*a, *b, 1.0)), false).unwrap();
            assert!((found.isometry().to_homogeneous() - truth.to_homogeneous()).amax() < 1e-13);
            assert!((found.rotation.determinant() - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn finds_a_reflection_only_where_it_is_asked_for() {
        let from = cloud(12);
        let to: Vec<_> = from.iter().map(|p| Vector3::new(-p.x, p.y, p.z)).collect();
        let pairs = from.iter().zip(&to).map(|(a, b)| (*a, *b, 1.0));
        let mirrored = fit(pairs.clone(), true).unwrap();
        assert!((mirrored.rotation - Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, 1.0))).amax() < 1e-13);
        assert!((fit(pairs, false).unwrap().rotation.determinant() - 1.0).abs() < 1e-13);
    }

    #[test]
    fn a_weight_of_zero_leaves_a_point_out_and_a_line_shows_in_the_spread() {
        let from = cloud(9);
        let mut to = from.clone();
        to[3] += Vector3::new(9.0, 9.0, 9.0);
        let pairs = (0..9).map(|i| (from[i], to[i], if i == 3 { 0.0 } else { 1.0 }));
        assert!((fit(pairs, false).unwrap().rotation - Matrix3::identity()).amax() < 1e-13);
        let line = (0..9).map(|i| Vector3::new(f64::from(i), 2.0, 3.0)).map(|p| (p, p, 1.0));
        let [first, second, _] = fit(line, false).unwrap().spread;
        assert!(second <= 1e-12 * first);
        assert!(fit(std::iter::empty(), false).is_none());
    }
}
