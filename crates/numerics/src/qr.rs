//! QR decomposition with column pivoting, and damped least squares on its triangle.
//!
//! Method: Householder reflections with column pivoting (Golub and Van Loan 2013, section 5.4.2); the damping is eliminated
//! from the triangle by Givens rotations (Moré 1978, section 3), so one decomposition serves every damping. Only `R`, the
//! order of the columns and the first rows of `Q^T b` are kept. Tall problems may be decomposed in blocks whose triangles
//! are then joined (`TSQR`, Demmel et al. 2012); the order of the blocks is the caller's, so the result does not depend on
//! the number of threads.
//!
//! Fails: never; a matrix that holds NaN gives NaN back.

use nalgebra::{DMatrix, DVector};

/// `A P = Q R`, as far as least squares with `b` need it.
#[derive(Debug, Clone)]
pub struct Triangle {
    /// Upper triangle, `n x n`; rows that a wide matrix does not have are zero.
    r: DMatrix<f64>,
    /// Column `k` of `R` is column `order[k]` of `A`.
    order: Vec<usize>,
    /// First `n` values of `Q^T b`.
    projected: Vec<f64>,
    /// Squared norm of the part of `b` that no combination of columns reaches.
    outside: f64,
}

impl Triangle {
    /// Decomposes `a` (`m x n`) with its right-hand side `b` (`m`).
    ///
    /// # Panics
    /// Where `b` does not have as many values as `a` has rows.
    pub fn new(mut a: DMatrix<f64>, mut b: DVector<f64>) -> Self {
        let (m, n) = a.shape();
        assert_eq!(m, b.len(), "one value per row");
        let mut order: Vec<usize> = (0..n).collect();
        let mut left: Vec<f64> = a.column_iter().map(|c| dot(c.as_slice(), c.as_slice())).collect();
        let full = left.clone();
        for k in 0..m.min(n) {
            let largest = (k..n).fold(k, |best, j| if left[j] > left[best] { j } else { best });
            if largest != k {
                a.swap_columns(k, largest);
                order.swap(k, largest);
                left.swap(k, largest);
            }
            reflect(&mut a, &mut b, k);
            for j in k + 1..n {
                left[j] -= a[(k, j)].powi(2);
                // the running difference has lost its digits: sum again
                if left[j] <= 1e-8 * full[order[j]] {
                    left[j] = a.view((k + 1, j), (m - k - 1, 1)).iter().map(|v| v * v).sum();
                }
            }
        }
        let kept = m.min(n);
        let r = DMatrix::from_fn(n, n, |i, j| if i <= j && i < m { a[(i, j)] } else { 0.0 });
        let projected = (0..n).map(|i| if i < m { b[i] } else { 0.0 }).collect();
        let outside = b.as_slice()[kept..].iter().map(|v| v * v).sum();
        Self { r, order, projected, outside }
    }

    /// Joins the triangles of blocks of rows, in their order; `None` of no block.
    pub fn joined(blocks: impl IntoIterator<Item = Triangle>) -> Option<Self> {
        blocks.into_iter().reduce(|above, below| {
            let n = above.r.ncols();
            let mut a = DMatrix::zeros(2 * n, n);
            for (part, from) in [(&above, 0), (&below, n)] {
                for k in 0..n {
                    a.view_mut((from, part.order[k]), (n, 1)).copy_from(&part.r.column(k));
                }
            }
            let b = DVector::from_iterator(2 * n, above.projected.iter().chain(&below.projected).copied());
            let outside = above.outside + below.outside;
            let mut joined = Self::new(a, b);
            joined.outside += outside;
            joined
        })
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.r.ncols()
    }

    /// Squared norm of what remains of `b` at the undamped solution of full rank.
    pub fn outside(&self) -> f64 {
        self.outside
    }

    /// `argmin |A x - b|^2 + sum damping_j x_j^2`, where held columns take the values `at`. Damping is per column of `A`, not
    /// negative.
    /// Directions that neither the columns nor the damping determine stay 0.
    pub fn solve(&self, damping: &[f64], held: &[bool], at: &[f64]) -> Vec<f64> {
        let n = self.columns();
        let mut r = self.r.clone();
        let mut right = self.projected.clone();
        let mut extra = vec![0.0; n];
        for k in (0..n).filter(|&k| held[self.order[k]]) {
            let value = at[self.order[k]];
            (0..=k).for_each(|i| right[i] -= r[(i, k)] * value);
            r.column_mut(k).fill(0.0);
        }
        for k in 0..n {
            let d = if held[self.order[k]] { 1.0 } else { damping[self.order[k]].sqrt() };
            if d == 0.0 {
                continue;
            }
            // the row d e_k is turned into the triangle, column by column
            extra[k..].fill(0.0);
            extra[k] = d;
            let mut of_extra = 0.0;
            for j in k..n {
                if extra[j] == 0.0 {
                    continue;
                }
                let length = r[(j, j)].hypot(extra[j]);
                let (c, s) = (r[(j, j)] / length, extra[j] / length);
                for i in j..n {
                    let (above, below) = (r[(j, i)], extra[i]);
                    r[(j, i)] = c * above + s * below;
                    extra[i] = c * below - s * above;
                }
                let (above, below) = (right[j], of_extra);
                right[j] = c * above + s * below;
                of_extra = c * below - s * above;
            }
        }
        let largest = (0..n).map(|k| r[(k, k)].abs()).fold(0.0, f64::max);
        let mut x = vec![0.0; n];
        for k in (0..n).rev() {
            let sum: f64 = (k + 1..n).map(|j| r[(k, j)] * x[self.order[j]]).sum();
            if r[(k, k)].abs() > f64::EPSILON * largest {
                x[self.order[k]] = (right[k] - sum) / r[(k, k)];
            }
        }
        (0..n).filter(|&k| held[k]).for_each(|k| x[k] = at[k]);
        x
    }

    /// The triangle itself: its column `k` is column [`Self::order`]`[k]` of `A`.
    pub fn triangle(&self) -> &DMatrix<f64> {
        &self.r
    }

    /// Which column of `A` each column of the triangle is.
    pub fn order(&self) -> &[usize] {
        &self.order
    }

    /// First values of `Q^T b`, one per row of the triangle.
    pub fn projected(&self) -> &[f64] {
        &self.projected
    }

    /// Column `k` of `A` is column `names[k]` from now on.
    pub fn rename_columns(&mut self, names: &[usize]) {
        self.order.iter_mut().for_each(|k| *k = names[*k]);
    }

    /// `|A x|^2`.
    pub fn image_squared(&self, x: &[f64]) -> f64 {
        let n = self.columns();
        (0..n).map(|i| (i..n).map(|j| self.r[(i, j)] * x[self.order[j]]).sum::<f64>().powi(2)).sum()
    }

    /// `A^T b`, from the triangle.
    pub fn gradient(&self) -> Vec<f64> {
        let mut g = vec![0.0; self.columns()];
        for (j, &column) in self.order.iter().enumerate() {
            g[column] = (0..=j).map(|i| self.r[(i, j)] * self.projected[i]).sum();
        }
        g
    }

    /// `R` with its columns in the order of `A`: its Gram matrix is that of `A`.
    pub fn in_order(&self) -> DMatrix<f64> {
        let n = self.columns();
        let mut a = DMatrix::zeros(n, n);
        for (k, &column) in self.order.iter().enumerate() {
            a.column_mut(column).copy_from(&self.r.column(k));
        }
        a
    }
}

/// Householder reflection that clears column `k` below the diagonal, applied to the later columns and to `b`.
fn reflect(a: &mut DMatrix<f64>, b: &mut DVector<f64>, k: usize) {
    let (m, n) = a.shape();
    let data = a.as_mut_slice();
    let (done, later) = data.split_at_mut((k + 1) * m);
    let v = &mut done[k * m + k..];
    let norm = dot(v, v).sqrt();
    if norm == 0.0 || !norm.is_finite() {
        return;
    }
    let alpha = if v[0] > 0.0 { -norm } else { norm };
    v[0] -= alpha;
    // v v^T scaled so that the reflection is 1 - v v^T / scale
    let scale = -alpha * v[0];
    for j in 0..n - k - 1 {
        let column = &mut later[j * m + k..(j + 1) * m];
        let share = dot(v, column) / scale;
        column.iter_mut().zip(v.iter()).for_each(|(c, x)| *c -= share * x);
    }
    let rest = &mut b.as_mut_slice()[k..];
    let share = dot(v, rest) / scale;
    rest.iter_mut().zip(v.iter()).for_each(|(c, x)| *c -= share * x);
    v[0] = alpha;
}

/// Scalar product in a fixed order: four running sums.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (x, y) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = x.remainder().iter().zip(y.remainder()).map(|(p, q)| p * q).sum();
    for (p, q) in x.zip(y) {
        for k in 0..4 {
            sums[k] += p[k] * q[k];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(m: usize, n: usize) -> DMatrix<f64> {
        DMatrix::from_fn(m, n, |i, j| ((3 * i + 7 * j * j + 1) as f64).sin() + if i == j { 2.0 } else { 0.0 })
    }

    fn right(m: usize) -> DVector<f64> {
        DVector::from_fn(m, |i, _| (1.3 * i as f64).cos())
    }

    #[test]
    fn solves_the_normal_equations_with_and_without_damping() {
        for (m, n) in [(9, 4), (4, 4), (3, 6)] {
            let (a, b) = (matrix(m, n), right(m));
            let triangle = Triangle::new(a.clone(), b.clone());
            for damping in [0.0, 1e-3, 10.0] {
                if damping == 0.0 && m < n {
                    continue;
                }
                let weights: Vec<f64> = (0..n).map(|j| damping * (1.0 + j as f64)).collect();
                let x = DVector::from_vec(triangle.solve(&weights, &vec![false; n], &vec![0.0; n]));
                let rest = a.transpose() * (&a * &x - &b) + DVector::from_vec(weights).component_mul(&x);
                assert!(rest.amax() < 1e-13, "{m}x{n}, damping {damping}: {rest}");
                assert!((triangle.image_squared(x.as_slice()) - (&a * &x).norm_squared()).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_held_column_moves_to_the_other_side() {
        let (a, b) = (matrix(9, 4), right(9));
        let damping = [0.0, 0.1, 0.2, 0.3];
        let x =
            Triangle::new(a.clone(), b.clone()).solve(&damping, &[false, true, false, false], &[0.0, 0.7, 0.0, 0.0]);
        let rest = b - a.column(1) * 0.7;
        let without = Triangle::new(a.remove_column(1), rest).solve(&[0.0, 0.2, 0.3], &[false; 3], &[0.0; 3]);
        assert_eq!(x[1], 0.7);
        for (p, q) in [x[0], x[2], x[3]].iter().zip(without) {
            assert!((p - q).abs() < 1e-14);
        }
    }

    #[test]
    fn blocks_joined_give_what_the_whole_gives() {
        let (a, b) = (matrix(20, 3), right(20));
        let block =
            |from: usize, rows: usize| Triangle::new(a.rows(from, rows).into_owned(), b.rows(from, rows).into());
        let joined = Triangle::joined([block(0, 7), block(7, 2), block(9, 11)]).unwrap();
        let whole = Triangle::new(a.clone(), b.clone());
        for (p, q) in
            joined.solve(&[0.0; 3], &[false; 3], &[0.0; 3]).iter().zip(whole.solve(&[0.0; 3], &[false; 3], &[0.0; 3]))
        {
            assert!((p - q).abs() < 1e-14);
        }
        assert!((joined.outside() - whole.outside()).abs() < 1e-13);
        assert!((joined.in_order().transpose() * joined.in_order() - a.transpose() * &a).amax() < 1e-12);
        for (p, q) in joined.gradient().iter().zip((a.transpose() * b).iter()) {
            assert!((p - q).abs() < 1e-13);
        }
    }

    #[test]
    fn a_column_that_depends_on_others_stays_zero() {
        let mut a = matrix(8, 3);
        let sum = a.column(0) + a.column(1);
        a.set_column(2, &sum);
        let x = Triangle::new(a.clone(), right(8)).solve(&[0.0; 3], &[false; 3], &[0.0; 3]);
        assert_eq!(x.iter().filter(|v| **v == 0.0).count(), 1);
        let rest = a.transpose() * (&a * DVector::from_vec(x) - right(8));
        assert!(rest.amax() < 1e-13);
    }
}
