//! Uncertainty where neighbouring residuals are correlated: the sandwich covariance.
//!
//! Method: the sandwich `B (sum_g s_g s_g^T) B` with `B = (J^T J)^-1` and the scores `s_g = J_g^T r_g` of blocks of rows (Liang and
//! Zeger 1986) estimates the covariance from the residuals themselves, correlation within a block included.
//!
//! Assumptions: blocks are much longer than the correlation and there are many of them (twenty or more): the sandwich of few
//! blocks is too small, which the factor `g / (g - 1)` makes up for in part.

use super::least_squares::Information;
use nalgebra::{DMatrix, DVector};

/// Covariance of the parameters from the scores of blocks of `length` neighbouring rows; `None` with fewer than two blocks,
/// or where a direction is open.
pub fn sandwich(
    jacobian: &DMatrix<f64>,
    residual: &[f64],
    length: usize,
    information: &Information,
) -> Option<DMatrix<f64>> {
    let (rows, n) = jacobian.shape();
    let length = length.max(1);
    let blocks = rows.div_ceil(length);
    if blocks < 2 || !information.is_full() {
        return None;
    }
    let mut middle = DMatrix::zeros(n, n);
    for from in (0..rows).step_by(length) {
        let count = length.min(rows - from);
        let r = DVector::from_column_slice(&residual[from..from + count]);
        let score = jacobian.rows(from, count).tr_mul(&r);
        middle += &score * score.transpose();
    }
    let few = blocks as f64 / (blocks as f64 - 1.0);
    Some(&information.inverse * middle * &information.inverse * few)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Uniform noise of unit variance, smoothed by an autoregression with coefficient `a`.
    fn noise(n: usize, a: f64, generator: &mut ChaCha8Rng) -> Vec<f64> {
        let mut last = 0.0;
        (0..n)
            .map(|_| {
                last = a * last + 12f64.sqrt() * (generator.random_range(0.0..1.0) - 0.5);
                last
            })
            .collect()
    }

    #[test]
    fn the_sandwich_of_a_mean_is_its_variance_with_correlation() {
        let mut generator = ChaCha8Rng::seed_from_u64(7);
        let (n, a) = (100_000, 0.8);
        let jacobian = DMatrix::repeat(n, 1, 1.0);
        let r = noise(n, a, &mut generator);
        let information = Information::of_gram(&DMatrix::repeat(1, 1, n as f64));
        let found = sandwich(&jacobian, &r, 500, &information).unwrap()[(0, 0)];
        // variance of the mean of an autoregression: 1 / (1 - a)^2 / n
        let want = 1.0 / (1.0 - a).powi(2) / n as f64;
        assert!((found / want - 1.0).abs() < 0.3, "{found:e} {want:e}");
        let white = information.covariance(r.iter().map(|v| v * v).sum::<f64>() / n as f64).unwrap()[(0, 0)];
        assert!(white < 0.3 * found);
    }

    #[test]
    fn one_block_or_an_open_direction_has_no_sandwich() {
        let open = Information::of_gram(&DMatrix::zeros(1, 1));
        let full = Information::of_gram(&DMatrix::repeat(1, 1, 3.0));
        let jacobian = DMatrix::repeat(3, 1, 1.0);
        assert!(sandwich(&jacobian, &[1.0; 3], 3, &full).is_none());
        assert!(sandwich(&jacobian, &[1.0; 3], 1, &open).is_none());
    }
}
