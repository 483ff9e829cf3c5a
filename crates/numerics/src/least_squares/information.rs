//! What the residuals say about the parameters: rank, condition, covariance.
//!
//! Method: singular values of the Jacobian with columns scaled to norm one (van der Sluis 1969: within a factor of the root
//! of the number of columns of the best scaling), so that units do not count as ill condition.

use nalgebra::DMatrix;

/// Singular value of scaled columns, over the largest, below which a direction counts as open.
pub const OPEN: f64 = 1e-10;

/// Rank, condition and covariance.
#[derive(Debug, Clone, PartialEq)]
pub struct Information {
    /// Number of directions that the residuals determine.
    pub rank: usize,
    /// Number of parameters.
    pub parameters: usize,
    /// Largest over smallest singular value of the scaled columns; infinite where a direction is open.
    pub condition: f64,
    /// Inverse of `J^T J`: the covariance for residuals of unit variance. Open directions have no part in it, so it is a
    /// covariance of all parameters only where [`Self::is_full`].
    pub inverse: DMatrix<f64>,
}

impl Information {
    /// From a triangle (or any matrix) with the Gram matrix of the Jacobian.
    pub fn of_factor(r: &DMatrix<f64>) -> Self {
        let n = r.ncols();
        let scale: Vec<f64> = r.column_iter().map(|c| reciprocal(c.norm())).collect();
        let scaled = DMatrix::from_fn(r.nrows(), n, |i, j| r[(i, j)] * scale[j]);
        if n == 0 || !scaled.iter().all(|v| v.is_finite()) {
            return Self::nothing(n);
        }
        let svd = scaled.svd(false, true);
        let Some(v_t) = svd.v_t else { return Self::nothing(n) };
        let squares: Vec<f64> = svd.singular_values.iter().map(|s| s * s).collect();
        Self::assemble(&squares, |k, j| v_t[(k, j)], &scale, OPEN * OPEN)
    }

    /// From a Gram matrix `J^T J`. Half the digits of small singular values are lost in it, so fewer directions count.
    pub fn of_gram(gram: &DMatrix<f64>) -> Self {
        let n = gram.ncols();
        let scale: Vec<f64> = (0..n).map(|k| reciprocal(gram[(k, k)].max(0.0).sqrt())).collect();
        let scaled = DMatrix::from_fn(n, n, |i, j| gram[(i, j)] * scale[i] * scale[j]);
        if n == 0 || !scaled.iter().all(|v| v.is_finite()) {
            return Self::nothing(n);
        }
        let eigen = scaled.symmetric_eigen();
        let squares: Vec<f64> = eigen.eigenvalues.iter().map(|v| v.max(0.0)).collect();
        // rounding of the sums leaves errors of about n eps in the eigenvalues
        let floor = OPEN.max(16.0 * n as f64 * f64::EPSILON);
        Self::assemble(&squares, |k, j| eigen.eigenvectors[(j, k)], &scale, floor)
    }

    fn nothing(n: usize) -> Self {
        Self { rank: 0, parameters: n, condition: f64::INFINITY, inverse: DMatrix::zeros(n, n) }
    }

    /// From squared singular values, the right singular vectors (`vector(k, j)`: value `j` of vector `k`) and scales.
    fn assemble(squares: &[f64], vector: impl Fn(usize, usize) -> f64, scale: &[f64], floor: f64) -> Self {
        let n = scale.len();
        let largest = squares.iter().copied().fold(0.0, f64::max);
        let known: Vec<usize> = (0..squares.len()).filter(|&k| squares[k] > floor * largest).collect();
        let least = known.iter().map(|&k| squares[k]).fold(f64::INFINITY, f64::min);
        let entry = |i: usize, j: usize| {
            known.iter().map(|&k| vector(k, i) * vector(k, j) / squares[k]).sum::<f64>() * scale[i] * scale[j]
        };
        Self {
            rank: known.len(),
            parameters: n,
            condition: if known.len() == n { (largest / least).sqrt() } else { f64::INFINITY },
            inverse: DMatrix::from_fn(n, n, entry),
        }
    }

    /// Whether every direction is determined.
    pub fn is_full(&self) -> bool {
        self.rank == self.parameters
    }

    /// Covariance for residuals of variance `variance`; `None` where a direction is open.
    pub fn covariance(&self, variance: f64) -> Option<DMatrix<f64>> {
        self.is_full().then(|| &self.inverse * variance)
    }

    /// Standard uncertainties for residuals of variance `variance`; `None` where a direction is open.
    pub fn sigmas(&self, variance: f64) -> Option<Vec<f64>> {
        self.is_full().then(|| self.inverse.diagonal().iter().map(|v| (v.max(0.0) * variance).sqrt()).collect())
    }
}

fn reciprocal(norm: f64) -> f64 {
    if norm > 0.0 { 1.0 / norm } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_do_not_make_a_problem_ill_conditioned() {
        let a = DMatrix::from_row_slice(3, 2, &[1.0, 0.0, 0.0, 1e-9, 1.0, 1e-9]);
        for found in [Information::of_factor(&a), Information::of_gram(&(a.transpose() * &a))] {
            // columns at 60 degrees: condition sqrt(1.5 / 0.5)
            assert!((found.condition - 3f64.sqrt()).abs() < 1e-12 && found.is_full());
            let covariance = found.covariance(1.0).unwrap();
            for (entry, want) in covariance.iter().zip([2.0 / 3.0, -1e9 / 3.0, -1e9 / 3.0, 2e18 / 3.0]) {
                assert!((entry / want - 1.0).abs() < 1e-9, "{entry}");
            }
        }
    }

    #[test]
    fn an_open_direction_has_no_covariance() {
        let a = DMatrix::from_row_slice(3, 2, &[1.0, 2.0, 2.0, 4.0, 3.0, 6.0]);
        for found in [Information::of_factor(&a), Information::of_gram(&(a.transpose() * &a))] {
            assert_eq!((found.rank, found.parameters), (1, 2));
            assert!(found.covariance(1.0).is_none() && found.sigmas(1.0).is_none() && found.condition.is_infinite());
        }
    }
}
