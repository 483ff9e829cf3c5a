//! Inverse of a normal matrix whose parameters differ in unit and size.
//!
//! Method: rows and columns scaled to a unit diagonal (van der Sluis 1969), Cholesky factor, inverse, scaled back. For sums
//! over rows that are never kept; a fit that keeps its rows goes through [`super::linear`] or [`super::least_squares`], which lose half
//! as many digits.
//!
//! Fails: `None` where the scaled matrix is not positive definite.

use nalgebra::{Cholesky, DMatrix};

/// Inverse of a normal matrix.
#[derive(Debug, Clone)]
pub struct ScaledInverse {
    /// The inverse, in the units of the matrix: times the variance of a residual it is a covariance.
    pub inverse: DMatrix<f64>,
    /// The largest variance inflation: by how much the worst parameter's variance exceeds that of the parameter alone
    /// (1: all parameters are independent).
    pub inflation: f64,
}

/// Inverts the symmetric matrix `normal`. `ridge` is added to the unit diagonal of the scaled matrix: with 1e-10 a direction that the
/// rows leave open gets a variance 1e10 times that of a known one, instead of none.
///
/// Accuracy: `eps` times the condition of the scaled matrix.
///
/// ```
/// use lostmotion_numerics::normal_equations::scaled_inverse;
/// use nalgebra::DMatrix;
/// // a length in metres beside an angle in microradians
/// let normal = DMatrix::from_row_slice(2, 2, &[4.0, 1e6, 1e6, 1e12]);
/// let found = scaled_inverse(&normal, 0.0).unwrap();
/// assert!((found.inverse[(0, 0)] - 1.0 / 3.0).abs() < 1e-14);
/// assert!((found.inflation - 4.0 / 3.0).abs() < 1e-14);
/// ```
pub fn scaled_inverse(normal: &DMatrix<f64>, ridge: f64) -> Option<ScaledInverse> {
    let n = normal.nrows();
    let scale: Vec<f64> = (0..n).map(|i| 1.0 / normal[(i, i)].max(f64::MIN_POSITIVE).sqrt()).collect();
    let scaled = DMatrix::from_fn(n, n, |i, j| normal[(i, j)] * scale[i] * scale[j] + if i == j { ridge } else { 0.0 });
    let inverse = Cholesky::new(scaled)?.inverse();
    let inflation =
        inverse.diagonal().iter().copied().fold(0.0, |m: f64, v| if v.is_nan() { f64::INFINITY } else { m.max(v) });
    Some(ScaledInverse { inverse: DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] * scale[i] * scale[j]), inflation })
}

/// Inverse of a normal matrix on the directions that its rows determine. Open ones (an eigenvalue of the scaled matrix of at most `floor`)
/// have no part in it, so that the parameters of an open direction look better known than they are: for steps and tests, not for
/// intervals.
pub fn pseudo_inverse(gram: &DMatrix<f64>, floor: f64) -> DMatrix<f64> {
    let k = gram.nrows();
    if k == 0 {
        return DMatrix::zeros(0, 0);
    }
    let d: Vec<f64> = (0..k).map(|i| if gram[(i, i)] > 0.0 { 1.0 / gram[(i, i)].sqrt() } else { 0.0 }).collect();
    let scaled = DMatrix::from_fn(k, k, |i, j| gram[(i, j)] * d[i] * d[j]);
    let eigen = scaled.symmetric_eigen();
    let mut inverse = DMatrix::zeros(k, k);
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        if *value > floor {
            inverse += vector * vector.transpose() / *value;
        }
    }
    DMatrix::from_fn(k, k, |i, j| inverse[(i, j)] * d[i] * d[j])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear;

    #[test]
    fn it_is_the_inverse_that_qr_finds_whatever_the_units() {
        let design = DMatrix::from_fn(20, 3, |i, j| ((i * (j + 1)) as f64).sin() * 10f64.powi(4 * j as i32 - 4));
        let want = linear::weighted(&design, &[0.0; 20], &[1.0; 20]).unwrap().inverse;
        let found = scaled_inverse(&(design.transpose() * &design), 0.0).unwrap();
        for (f, w) in found.inverse.iter().zip(want.iter()) {
            assert!((f - w).abs() < 1e-10 * w.abs(), "{f} {w}");
        }
        assert!(found.inflation >= 1.0);
    }

    #[test]
    fn a_pseudo_inverse_leaves_out_the_open_direction() {
        let normal = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0]);
        let found = pseudo_inverse(&normal, 1e-9);
        assert!(found.iter().all(|v| (v - 0.25).abs() < 1e-14), "{found}");
    }

    #[test]
    fn a_direction_that_is_open_has_no_inverse_without_a_ridge_and_a_large_one_with_it() {
        let normal = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0]);
        assert!(scaled_inverse(&normal, 0.0).is_none_or(|s| s.inflation > 1e14));
        assert!(scaled_inverse(&normal, 1e-10).unwrap().inflation > 1e9);
        assert!(scaled_inverse(&DMatrix::zeros(2, 2), 0.0).is_none());
    }
}
