//! Linear model of a structured or partitioned Jacobian, known by its products.
//!
//! For problems whose Jacobian is never formed (columns that are filters or projections of series, blocks of rows summed by
//! many threads). Method: Cholesky of the damped Gram matrix with unit diagonal, that is, normal equations: a step loses digits with
//! the square of the condition of the scaled columns. Rank, condition and covariance come from the eigenvalues of the scaled Gram
//! matrix.

use super::{Information, LinearModel};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// `r + J s` by products.
pub struct Products {
    gram: DMatrix<f64>,
    gradient: Vec<f64>,
    squared_norms: Vec<f64>,
}

impl Products {
    /// From `J^T J` and `J^T r`.
    pub fn new(gram: DMatrix<f64>, gradient: Vec<f64>) -> Self {
        let squared_norms = gram.diagonal().iter().map(|v| v.max(0.0)).collect();
        Self { gram, gradient, squared_norms }
    }

    /// `J^T J`.
    pub fn gram(&self) -> &DMatrix<f64> {
        &self.gram
    }

    fn factor(&self, damping: &[f64], held: &[bool]) -> Option<(Cholesky<f64, Dyn>, Vec<f64>)> {
        let n = self.gradient.len();
        let scale: Vec<f64> = (0..n)
            .map(|k| {
                let d = self.gram[(k, k)] + damping[k];
                if held[k] || d <= 0.0 { 0.0 } else { 1.0 / d.sqrt() }
            })
            .collect();
        let scaled = DMatrix::from_fn(n, n, |i, j| if i == j { 1.0 } else { self.gram[(i, j)] * scale[i] * scale[j] });
        Some((scaled.cholesky()?, scale))
    }
}

/// `-(S F F^T S^-1)^-1 g` of a factor with unit diagonal and its scales.
fn solved(factor: &Cholesky<f64, Dyn>, scale: &[f64], gradient: &[f64]) -> Vec<f64> {
    let right = DVector::from_iterator(scale.len(), gradient.iter().zip(scale).map(|(g, s)| -g * s));
    factor.solve(&right).iter().zip(scale).map(|(x, s)| x * s).collect()
}

impl LinearModel for Products {
    fn gradient(&self) -> &[f64] {
        &self.gradient
    }

    fn squared_norms(&self) -> &[f64] {
        &self.squared_norms
    }

    fn step(&self, damping: &[f64], held: &[bool], at: &[f64]) -> Option<Vec<f64>> {
        let (factor, scale) = self.factor(damping, held)?;
        let n = held.len();
        let mut gradient = self.gradient.clone();
        for k in (0..n).filter(|&k| held[k] && at[k] != 0.0) {
            (0..n).for_each(|i| gradient[i] += self.gram[(i, k)] * at[k]);
        }
        let mut step = solved(&factor, &scale, &gradient);
        (0..n).filter(|&k| held[k]).for_each(|k| step[k] = at[k]);
        step.iter().all(|v| v.is_finite()).then_some(step)
    }

    fn image_squared(&self, change: &[f64]) -> f64 {
        let s = DVector::from_column_slice(change);
        (&self.gram * &s).dot(&s).max(0.0)
    }

    fn information(&self) -> Information {
        Information::of_gram(&self.gram)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::least_squares::Dense;

    #[test]
    fn held_parameters_and_products_agree_with_the_dense_model() {
        let a = DMatrix::from_fn(9, 3, |i, j| ((i * i + 3 * j) as f64).cos() * 10f64.powi(j as i32));
        let r: Vec<f64> = (0..9).map(|i| f64::from(i).sin()).collect();
        let b = DVector::from_column_slice(&r);
        let products = Products::new(a.transpose() * &a, (a.transpose() * &b).as_slice().to_vec());
        let dense = Dense::new(a, &r);
        let (damping, held, at) = ([0.1, 2.0, 0.0], [false, true, false], [0.0, 0.3, 0.0]);
        let (p, d) = (products.step(&damping, &held, &at).unwrap(), dense.step(&damping, &held, &at).unwrap());
        assert_eq!((p[1], d[1]), (0.3, 0.3));
        assert!(p.iter().zip(&d).all(|(p, d)| (p - d).abs() < 1e-12 * (1.0 + d.abs())));
        assert!((products.image_squared(&p) - dense.image_squared(&d)).abs() < 1e-9);
        assert!((products.information().inverse - dense.information().inverse).amax() < 1e-12);
        assert!(products.gradient().iter().zip(dense.gradient()).all(|(p, d)| (p - d).abs() < 1e-12));
    }
}
