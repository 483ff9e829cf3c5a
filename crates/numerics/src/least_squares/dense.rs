//! Linear model of a full Jacobian: QR with pivoting of columns scaled to norm one.

use super::{Information, LinearModel};
use crate::qr::Triangle;
use nalgebra::{DMatrix, DVector};

/// `r + J s`, decomposed.
#[derive(Debug, Clone)]
pub struct Dense {
    /// Triangle of the scaled columns, with `-r` on the right.
    triangle: Triangle,
    /// Norms of the columns; 1 of a column of zeros.
    norms: Vec<f64>,
    squared_norms: Vec<f64>,
    gradient: Vec<f64>,
}

impl Dense {
    /// From residuals (`m`) and their derivatives (`m x n`).
    pub fn new(mut jacobian: DMatrix<f64>, residual: &[f64]) -> Self {
        let r = DVector::from_column_slice(residual);
        let gradient = jacobian.column_iter().map(|c| c.dot(&r)).collect();
        let squared_norms: Vec<f64> = jacobian.column_iter().map(|c| c.norm_squared()).collect();
        let norms: Vec<f64> = squared_norms.iter().map(|s| if *s > 0.0 { s.sqrt() } else { 1.0 }).collect();
        for (mut column, norm) in jacobian.column_iter_mut().zip(&norms) {
            column /= *norm;
        }
        Self { triangle: Triangle::new(jacobian, -r), norms, squared_norms, gradient }
    }

    /// From triangles of blocks of rows in their order (right-hand sides `-r`), for Jacobians too tall to keep.
    pub fn of_blocks(blocks: impl IntoIterator<Item = Triangle>) -> Option<Self> {
        let whole = Triangle::joined(blocks)?;
        let right: Vec<f64> = whole.projected().iter().map(|v| -v).collect();
        Some(Self::new(whole.triangle().clone(), &right).reordered(whole.order()))
    }

    /// The model with its columns, which stand in the order of a triangle, put back in the order of the parameters.
    fn reordered(mut self, order: &[usize]) -> Self {
        let back = |values: &[f64]| {
            let mut out = vec![0.0; values.len()];
            order.iter().zip(values).for_each(|(&column, v)| out[column] = *v);
            out
        };
        self.gradient = back(&self.gradient);
        self.norms = back(&self.norms);
        self.squared_norms = back(&self.squared_norms);
        self.triangle.rename_columns(order);
        self
    }
}

impl LinearModel for Dense {
    fn gradient(&self) -> &[f64] {
        &self.gradient
    }

    fn squared_norms(&self) -> &[f64] {
        &self.squared_norms
    }

    fn step(&self, damping: &[f64], held: &[bool], at: &[f64]) -> Option<Vec<f64>> {
        let scaled: Vec<f64> = damping.iter().zip(&self.norms).map(|(d, n)| d / (n * n)).collect();
        let at: Vec<f64> = at.iter().zip(&self.norms).map(|(s, n)| s * n).collect();
        let mut step = self.triangle.solve(&scaled, held, &at);
        step.iter_mut().zip(&self.norms).for_each(|(s, n)| *s /= n);
        step.iter().all(|v| v.is_finite()).then_some(step)
    }

    fn image_squared(&self, change: &[f64]) -> f64 {
        let scaled: Vec<f64> = change.iter().zip(&self.norms).map(|(s, n)| s * n).collect();
        self.triangle.image_squared(&scaled)
    }

    fn information(&self) -> Information {
        let mut r = self.triangle.in_order();
        for (mut column, norm) in r.column_iter_mut().zip(&self.norms) {
            column *= *norm;
        }
        Information::of_factor(&r)
    }
}
