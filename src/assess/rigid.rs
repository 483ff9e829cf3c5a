//! The frame between two sets of points by [`rigid`]; points that do not determine it give none.

use crate::numerics::rigid;
use nalgebra::{Isometry3, Vector3};

/// `dst ~ frame * src`; `None` where fewer than three points, or points on one line, leave it open.
pub fn fit(src: &[Vector3<f64>], dst: &[Vector3<f64>]) -> Option<Isometry3<f64>> {
    if src.len() != dst.len() || src.len() < 3 {
        return None;
    }
    let found = rigid::fit(src.iter().zip(dst).map(|(s, d)| (*s, *d, 1.0)), false)?;
    let [first, second, _] = found.spread;
    (second > 1e-12 * first).then(|| found.isometry())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;

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
