//! Best-fit circle in space: plane by singular values, then Taubin's circle (1991) in it, in its SVD form.
//!
//! Both least-squares problems pass a QR first, so that a long log costs a 3 x 3 SVD. Taubin's fit is unbiased to first
//! order also on arcs; on an arc of a few degrees radius and centre become uncertain together.

use nalgebra::{DMatrix, Matrix3, Vector3};

/// Circle in space, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CircleFit {
    /// Centre of the circle, m.
    pub centre_m: Vector3<f64>,
    /// Unit normal of its plane.
    pub normal: Vector3<f64>,
    /// Radius of the circle, m.
    pub radius_m: f64,
    /// A point of the plane from which out-of-plane errors count: the mean of the points.
    pub mean_m: Vector3<f64>,
}

impl CircleFit {
    /// Fits at least three points that are not on one line; the normal points along `toward`.
    pub fn new(points: &[Vector3<f64>], toward: &Vector3<f64>) -> Option<Self> {
        if points.len() < 3 {
            return None;
        }
        let mean = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
        let axes = right_singular_vectors(points.iter().map(|p| (p - mean).into()), points.len())?;
        let (e1, e2, mut normal) = (axes[0], axes[1], axes[2]);
        if normal.dot(toward) < 0.0 {
            normal = -normal;
        }
        let flat: Vec<[f64; 2]> = points.iter().map(|p| [(p - mean).dot(&e1), (p - mean).dot(&e2)]).collect();
        let (x, y, radius_m) = taubin(&flat)?;
        Some(Self { centre_m: mean + e1 * x + e2 * y, normal, radius_m, mean_m: mean })
    }

    /// In-plane (radial, outwards positive) and out-of-plane (along the normal) error of a point, m.
    pub fn error_m(&self, p: &Vector3<f64>) -> [f64; 2] {
        let from = p - self.centre_m;
        let radial = from - self.normal * from.dot(&self.normal);
        [radial.norm() - self.radius_m, (p - self.mean_m).dot(&self.normal)]
    }

    /// Unit vector from the centre to the foot of a point in the plane.
    pub fn outward(&self, p: &Vector3<f64>) -> Vector3<f64> {
        let from = p - self.centre_m;
        let radial = from - self.normal * from.dot(&self.normal);
        radial.try_normalize(0.0).unwrap_or_else(Vector3::zeros)
    }
}

/// Circle through points of the plane: centre and radius (Taubin 1991).
pub fn taubin(points: &[[f64; 2]]) -> Option<(f64, f64, f64)> {
    let n = points.len() as f64;
    let (mx, my) = (points.iter().map(|p| p[0]).sum::<f64>() / n, points.iter().map(|p| p[1]).sum::<f64>() / n);
    let square = |p: &[f64; 2]| (p[0] - mx).powi(2) + (p[1] - my).powi(2);
    let zm = points.iter().map(square).sum::<f64>() / n;
    let scale = 2.0 * zm.sqrt();
    let rows = points.iter().map(|p| [(square(p) - zm) / scale, p[0] - mx, p[1] - my]);
    let a = right_singular_vectors(rows, points.len())?[2];
    let a0 = a[0] / scale;
    let a3 = -zm * a0;
    let radius = (a[1] * a[1] + a[2] * a[2] - 4.0 * a0 * a3).sqrt() / a0.abs() / 2.0;
    let centre = (-a[1] / a0 / 2.0 + mx, -a[2] / a0 / 2.0 + my);
    (radius.is_finite() && centre.0.is_finite() && centre.1.is_finite()).then_some((centre.0, centre.1, radius))
}

/// Right singular vectors of an n x 3 matrix, largest singular value first.
fn right_singular_vectors(rows: impl Iterator<Item = [f64; 3]>, n: usize) -> Option<[Vector3<f64>; 3]> {
    let mut m = DMatrix::zeros(n.max(3), 3);
    for (i, r) in rows.enumerate() {
        for (j, v) in r.into_iter().enumerate() {
            m[(i, j)] = v;
        }
    }
    let r = m.qr().r();
    let r: Matrix3<f64> = Matrix3::from_fn(|i, j| r[(i, j)]);
    if r.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let svd = r.svd(false, true);
    let vt = svd.v_t?;
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| svd.singular_values[j].total_cmp(&svd.singular_values[i]));
    Some(order.map(|i| vt.row(i).transpose()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recovers_a_circle_in_a_tilted_plane() {
        let normal = Vector3::new(1.0, -2.0, 0.5).normalize();
        let e1 = normal.cross(&Vector3::x()).normalize();
        let e2 = normal.cross(&e1);
        let centre = Vector3::new(1.7, -0.4, 2.2);
        let at = |deg: f64, r: f64| centre + (e1 * deg.to_radians().cos() + e2 * deg.to_radians().sin()) * r;
        let points: Vec<_> = (0..120).map(|i| at(f64::from(i) * 1.5, 0.31)).collect();
        let fit = CircleFit::new(&points, &normal).unwrap();
        assert!((fit.centre_m - centre).norm() < 1e-12 && (fit.radius_m - 0.31).abs() < 1e-12, "{fit:?}");
        assert!((fit.normal - normal).norm() < 1e-12);
        let [inside, off] = fit.error_m(&(at(33.0, 0.3101) + normal * 5e-5));
        assert!((inside - 1e-4).abs() < 1e-12 && (off - 5e-5).abs() < 1e-12);
    }

    #[test]
    fn points_on_a_line_have_no_circle() {
        let line: Vec<_> = (0..9).map(|i| Vector3::new(f64::from(i), 2.0, 3.0)).collect();
        assert!(CircleFit::new(&line, &Vector3::x()).is_none_or(|c| c.radius_m > 1e6));
    }
}
