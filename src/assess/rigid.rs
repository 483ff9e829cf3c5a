//! Rigid transform that takes one set of points onto another with the least sum of squares (Kabsch 1976; the sign after
//! Umeyama 1991, so that it never mirrors).

use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};

/// `dst ~ frame * src`; `None` where fewer than three points, or points on one line, leave it open.
pub fn fit(src: &[Vector3<f64>], dst: &[Vector3<f64>]) -> Option<Isometry3<f64>> {
    if src.len() != dst.len() || src.len() < 3 {
        return None;
    }
    let n = src.len() as f64;
    let mean = |p: &[Vector3<f64>]| p.iter().sum::<Vector3<f64>>() / n;
    let (cs, cd) = (mean(src), mean(dst));
    let h: Matrix3<f64> = src.iter().zip(dst).map(|(s, d)| (s - cs) * (d - cd).transpose()).sum();
    let svd = h.svd(true, true);
    let (u, vt) = (svd.u?, svd.v_t?);
    let sorted = svd.singular_values;
    if !sorted.iter().all(|v| v.is_finite()) || sorted[1] <= 1e-12 * sorted[0] {
        return None;
    }
    let v = vt.transpose();
    let sign = (v * u.transpose()).determinant().signum();
    let r = v * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * u.transpose();
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(r));
    Some(Isometry3::from_parts((cd - rotation * cs).into(), rotation))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_a_known_frame_and_never_mirrors() {
        let frame = Isometry3::from_parts(
            Vector3::new(2.65, 1.89, -0.64).into(),
            UnitQuaternion::from_euler_angles(0.0122, -0.0244, 2.4958),
        );
        // points in a plane leave the sign of the third singular vector open
        let src: Vec<_> = (0..50).map(f64::from).map(|a| Vector3::new(0.0, a.cos(), (0.7 * a).sin())).collect();
        let dst: Vec<_> = src.iter().map(|p| frame.rotation * p + frame.translation.vector).collect();
        let found = fit(&src, &dst).unwrap();
        assert!((found.to_homogeneous() - frame.to_homogeneous()).abs().max() < 1e-13);
    }

    #[test]
    fn points_on_a_line_leave_the_frame_open() {
        let line: Vec<_> = (0..9).map(|i| Vector3::new(f64::from(i), 2.0, 3.0)).collect();
        assert!(fit(&line, &line).is_none());
    }
}
