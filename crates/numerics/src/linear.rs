//! Weighted linear least squares by QR, with covariance.
//!
//! Method: rows scaled by the root of their weights; QR by Householder reflections (Golub and Van Loan, section 5.3). The
//! covariance of the coefficients is the returned inverse of the normal matrix times a variance that the caller chooses: what
//! is noise (residual, pure error) is for the caller to decide. A design whose columns depend on each other has no fit.

use nalgebra::{DMatrix, DVector};

/// A diagonal element of R below this share of the largest means columns that depend on each other.
const DEPENDENT: f64 = 1e-10;

/// A fit.
#[derive(Debug, Clone)]
pub struct Fit {
    /// One per column of the design.
    pub coefficients: DVector<f64>,
    /// `(X' W X)^-1`: times a variance it is the covariance of the coefficients.
    pub inverse: DMatrix<f64>,
    /// Weighted sum of squared residuals.
    pub residual: f64,
}

/// Fits `y` with the columns of `design`; `None` with fewer rows than columns, or where columns depend on each other.
pub fn weighted(design: &DMatrix<f64>, y: &[f64], weights: &[f64]) -> Option<Fit> {
    let (n, k) = design.shape();
    if n < k || k == 0 || y.len() != n || weights.len() != n {
        return None;
    }
    let scaled = DMatrix::from_fn(n, k, |i, j| weights[i].sqrt() * design[(i, j)]);
    let qr = scaled.qr();
    let r = qr.r();
    let diagonal: Vec<f64> = (0..k).map(|j| r[(j, j)].abs()).collect();
    let largest = diagonal.iter().copied().fold(0.0, f64::max);
    if diagonal.iter().any(|d| *d <= DEPENDENT * largest) {
        return None;
    }
    let right = DVector::from_fn(n, |i, _| weights[i].sqrt() * y[i]);
    let coefficients = r.solve_upper_triangular(&(qr.q().transpose() * right))?;
    let inverse_r = r.solve_upper_triangular(&DMatrix::identity(k, k))?;
    let fitted = design * &coefficients;
    let residual = (0..n).map(|i| weights[i] * (y[i] - fitted[i]).powi(2)).sum();
    Some(Fit { coefficients, inverse: &inverse_r * inverse_r.transpose(), residual })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_through_four_points_is_the_textbook_one() {
        // x = 1..4, y = 6, 5, 7, 10: y = 3.5 + 1.4 x, residual 4.2, inverse of [[4, 10], [10, 30]]
        let x = DMatrix::from_fn(4, 2, |i, j| if j == 0 { 1.0 } else { i as f64 + 1.0 });
        let fit = weighted(&x, &[6.0, 5.0, 7.0, 10.0], &[1.0; 4]).unwrap();
        assert!((fit.coefficients[0] - 3.5).abs() < 1e-12 && (fit.coefficients[1] - 1.4).abs() < 1e-12);
        assert!((fit.residual - 4.2).abs() < 1e-12);
        for (found, want) in fit.inverse.iter().zip([1.5, -0.5, -0.5, 0.2]) {
            assert!((found - want).abs() < 1e-12);
        }
    }

    #[test]
    fn a_weight_of_two_is_the_row_twice() {
        let x = DMatrix::from_row_slice(3, 2, &[1.0, 0.0, 1.0, 1.0, 1.0, 3.0]);
        let twice = DMatrix::from_row_slice(4, 2, &[1.0, 0.0, 1.0, 1.0, 1.0, 3.0, 1.0, 3.0]);
        let a = weighted(&x, &[1.0, 0.0, 5.0], &[1.0, 1.0, 2.0]).unwrap();
        let b = weighted(&twice, &[1.0, 0.0, 5.0, 5.0], &[1.0; 4]).unwrap();
        assert!((a.coefficients - b.coefficients).norm() < 1e-12 && (a.inverse - b.inverse).norm() < 1e-12);
    }

    #[test]
    fn columns_that_depend_on_each_other_have_no_fit() {
        let x = DMatrix::from_row_slice(3, 2, &[1.0, 2.0, 1.0, 2.0, 1.0, 2.0]);
        assert!(weighted(&x, &[1.0, 2.0, 3.0], &[1.0; 3]).is_none());
    }
}
