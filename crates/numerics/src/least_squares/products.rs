//! Linear model of a structured or partitioned Jacobian, known by its products.
//!
//! For problems whose Jacobian is never formed (columns that are filters or projections of series, blocks of rows summed by
//! many threads). Method: Cholesky of the damped Gram matrix with unit diagonal, then one correction with the gradient of the
//! *linear residual* `J^T (r + J s)`, which the caller computes from the Jacobian itself where it can: corrected seminormal
//! equations (Björck 1987), as accurate as QR while the square of the condition stays below 1e15. Rank, condition and covariance
//! come from the eigenvalues of the scaled Gram matrix.

use super::{Information, LinearModel};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// `J^T (r + J s)` of a step `s`, from the Jacobian itself.
pub type LinearGradient<'a> = Box<dyn Fn(&[f64]) -> Vec<f64> + 'a>;

/// `r + J s` by products.
pub struct Products<'a> {
    gram: DMatrix<f64>,
    gradient: Vec<f64>,
    squared_norms: Vec<f64>,
    corrected: Option<LinearGradient<'a>>,
}

impl<'a> Products<'a> {
    /// From `J^T J` and `J^T r`.
    pub fn new(gram: DMatrix<f64>, gradient: Vec<f64>) -> Self {
        let squared_norms = gram.diagonal().iter().map(|v| v.max(0.0)).collect();
        Self { gram, gradient, squared_norms, corrected: None }
    }

    /// Corrects each step with `J^T (r + J s)`.
    #[must_use]
    pub fn corrected_by(mut self, linear_gradient: impl Fn(&[f64]) -> Vec<f64> + 'a) -> Self {
        self.corrected = Some(Box::new(linear_gradient));
        self
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

impl LinearModel for Products<'_> {
    fn gradient(&self) -> &[f64] {
        &self.gradient
    }

    fn squared_norms(&self) -> &[f64] {
        &self.squared_norms
    }

    fn step(&self, damping: &[f64], held: &[bool], at: &[f64]) -> Option<Vec<f64>> {
        let (factor, scale) = self.factor(damping, held)?;
        let solve = |gradient: &[f64]| solved(&factor, &scale, gradient);
        let n = held.len();
        let mut gradient = self.gradient.clone();
        for k in (0..n).filter(|&k| held[k] && at[k] != 0.0) {
            (0..n).for_each(|i| gradient[i] += self.gram[(i, k)] * at[k]);
        }
        let mut step = solve(&gradient);
        (0..n).filter(|&k| held[k]).for_each(|k| step[k] = at[k]);
        if let Some(linear_gradient) = &self.corrected {
            let mut rest = linear_gradient(&step);
            rest.iter_mut().zip(damping.iter().zip(&step)).for_each(|(g, (d, s))| *g += d * s);
            step.iter_mut().zip(solve(&rest)).for_each(|(s, c)| *s += c);
        }
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

    /// Columns that differ by 1e-6: the Gram matrix keeps four digits of what tells them apart.
    fn nearly_alike() -> (DMatrix<f64>, Vec<f64>) {
        let a = DMatrix::from_fn(50, 3, |i, j| {
            let x = i as f64 / 49.0;
            1.0 + x + 1e-6 * x.powi(j as i32 + 2)
        });
        let r = (0..50).map(|i| (0.3 * f64::from(i)).sin()).collect();
        (a, r)
    }

    #[test]
    fn a_corrected_step_has_the_digits_of_qr() {
        let (a, r) = nearly_alike();
        let b = DVector::from_column_slice(&r);
        let products = || Products::new(a.transpose() * &a, (a.transpose() * &b).as_slice().to_vec());
        let linear = |s: &[f64]| (a.transpose() * (&b + &a * DVector::from_column_slice(s))).as_slice().to_vec();
        let dense = Dense::new(a.clone(), &r);
        let (damping, held, at) = ([1e-11; 3], [false; 3], [0.0; 3]);
        let want = DVector::from_vec(dense.step(&damping, &held, &at).unwrap());
        let plain = DVector::from_vec(products().step(&damping, &held, &at).unwrap());
        let corrected = DVector::from_vec(products().corrected_by(linear).step(&damping, &held, &at).unwrap());
        let error = |x: &DVector<f64>| (x - &want).norm() / want.norm();
        assert!(error(&plain) > 1e-6, "{}", error(&plain));
        assert!(error(&corrected) < 1e-2 * error(&plain), "{} {}", error(&corrected), error(&plain));
    }

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
