//! Held-out blocks by linear algebra: sensitivities multiplied once, block by block, so that any set of terms can be fitted to
//! some blocks and judged on the others at the price of a small factorisation.
//!
//! Method: the logs are cut into [`FOLDS`] x [`TURNS`] consecutive parts. The normal matrix, the right side and the squares of
//! every fold are kept. A set of columns is fitted with its prior to all folds but one; what it leaves of that one is
//! the held-out cost, in units of 2 ln L, as all columns are whitened.

use crate::diagnose::problem::forward::Problem;
use crate::numerics::parallel::ParMap;
use nalgebra::{Cholesky, DMatrix, DVector};

/// Folds of the cross-validation.
pub const FOLDS: usize = 5;
/// Parts of one fold in a log, spread over it.
const TURNS: usize = 4;
/// Values that are multiplied at a time.
const PIECE: usize = 1024;

/// Products of whitened columns with each other and with a residual, fold by fold.
pub struct Blocks {
    gram: Vec<DMatrix<f64>>,
    right: Vec<DVector<f64>>,
    square: Vec<f64>,
}

/// Ranges of the long vector that make each fold.
pub fn folds(problem: &Problem) -> Vec<Vec<std::ops::Range<usize>>> {
    let mut folds = vec![Vec::new(); FOLDS];
    for g in &problem.groups {
        let (n, parts) = (g.len(), FOLDS * TURNS);
        for k in 0..parts {
            let (from, to) = (k * n / parts, (k + 1) * n / parts);
            for c in 0..g.dims {
                if to > from {
                    folds[k % FOLDS].push(g.offset + c * n + from..g.offset + c * n + to);
                }
            }
        }
    }
    folds
}

/// Products of one range, added to what is there.
fn add(columns: &[&[f64]], y: &[f64], range: &std::ops::Range<usize>, out: &mut (DMatrix<f64>, DVector<f64>, f64)) {
    let k = columns.len();
    let mut s = range.start;
    while s < range.end {
        let e = (s + PIECE).min(range.end);
        let a = DMatrix::from_fn(e - s, k, |i, j| columns[j][s + i]);
        let b = DVector::from_column_slice(&y[s..e]);
        let t = a.transpose();
        out.0.gemm(1.0, &t, &a, 1.0);
        out.1.gemv(1.0, &t, &b, 1.0);
        out.2 += b.norm_squared();
        s = e;
    }
}

impl Blocks {
    /// Products of whitened columns and a whitened residual.
    pub fn new(problem: &Problem, columns: &[&[f64]], y: &[f64]) -> Self {
        Self::over(&folds(problem), columns, y)
    }

    /// The same with given folds: ranges of the long vector.
    pub fn over(folds: &[Vec<std::ops::Range<usize>>], columns: &[&[f64]], y: &[f64]) -> Self {
        let k = columns.len();
        let sums: Vec<(DMatrix<f64>, DVector<f64>, f64)> = folds.par_map(|ranges| {
            let mut out = (DMatrix::zeros(k, k), DVector::zeros(k), 0.0);
            ranges.iter().for_each(|r| add(columns, y, r, &mut out));
            out
        });
        let mut all = Self { gram: Vec::new(), right: Vec::new(), square: Vec::new() };
        for (g, r, s) in sums {
            all.gram.push(g);
            all.right.push(r);
            all.square.push(s);
        }
        all
    }

    /// The normal matrix of all folds.
    pub fn whole(&self) -> DMatrix<f64> {
        self.gram.iter().fold(DMatrix::zeros(self.gram[0].nrows(), self.gram[0].ncols()), |a, b| a + b)
    }

    /// Solution of the chosen columns without fold `out` (`None`: of all folds); `precision` and `pull` are the prior's.
    pub fn solve(&self, pick: &[usize], out: Option<usize>, precision: &[f64], pull: &[f64]) -> DVector<f64> {
        Self::solve_in(&self.gram, &self.right, pick, out, precision, pull)
    }

    fn solve_in(
        gram: &[DMatrix<f64>],
        rights: &[DVector<f64>],
        pick: &[usize],
        out: Option<usize>,
        precision: &[f64],
        pull: &[f64],
    ) -> DVector<f64> {
        let k = pick.len();
        let mut normal = DMatrix::<f64>::zeros(k, k);
        let mut right = DVector::<f64>::zeros(k);
        for f in (0..gram.len()).filter(|f| Some(*f) != out) {
            let (g, r) = (&gram[f], &rights[f]);
            for (j, &b) in pick.iter().enumerate() {
                let column = g.column(b);
                for (i, &a) in pick.iter().enumerate().take(j + 1) {
                    normal[(i, j)] += column[a];
                }
                right[j] += r[b];
            }
        }
        // scaled to a unit diagonal; what the folds do not tell at all stays where it is
        let mut scale = vec![0.0; k];
        for j in 0..k {
            normal[(j, j)] += precision[pick[j]];
            right[j] += pull[pick[j]];
            scale[j] = if normal[(j, j)] > 0.0 { normal[(j, j)].sqrt().recip() } else { 0.0 };
        }
        let scaled = DMatrix::from_fn(k, k, |i, j| {
            let (a, b) = if i <= j { (i, j) } else { (j, i) };
            normal[(a, b)] * scale[i] * scale[j]
                + if i == j { 1e-9 + f64::from(u8::from(scale[i] == 0.0)) } else { 0.0 }
        });
        let b = DVector::from_fn(k, |i, _| right[i] * scale[i]);
        let x = Cholesky::new(scaled).map_or_else(|| DVector::zeros(k), |c| c.solve(&b));
        DVector::from_fn(k, |i, _| x[i] * scale[i])
    }

    /// What the chosen columns leave of each fold, fitted to the others.
    pub fn held_out(&self, pick: &[usize], precision: &[f64], pull: &[f64]) -> Vec<f64> {
        (0..self.gram.len())
            .map(|f| {
                let x = self.solve(pick, Some(f), precision, pull);
                let (g, r) = (&self.gram[f], &self.right[f]);
                let mut cost = self.square[f];
                for (j, &b) in pick.iter().enumerate() {
                    let column = g.column(b);
                    let row: f64 = pick.iter().zip(x.iter()).map(|(&a, v)| column[a] * v).sum();
                    cost += x[j] * (row - 2.0 * r[b]);
                }
                cost
            })
            .collect()
    }
}

impl Blocks {
    /// Right side and square of a fold with columns put back into the residual.
    fn put_back(&self, f: usize, gone: &[usize], values: &[f64]) -> (DVector<f64>, f64) {
        let g = &self.gram[f];
        let mut right = self.right[f].clone();
        let mut square = self.square[f];
        for &c in gone {
            // y + v x: what it adds to the products with all columns, and to its own square
            let v = values.get(c).copied().unwrap_or(0.0);
            square += v * (2.0 * right[c] + v * g[(c, c)]);
            right.axpy(v, &g.column(c), 1.0);
        }
        (right, square)
    }

    /// The same where the columns `gone`, which the residual has been freed of at `values`, are put back into it.
    pub fn held_out_without(
        &self,
        pick: &[usize],
        gone: &[usize],
        values: &[f64],
        precision: &[f64],
        pull: &[f64],
    ) -> Vec<f64> {
        let parts: Vec<(DVector<f64>, f64)> = (0..self.gram.len()).map(|f| self.put_back(f, gone, values)).collect();
        let other = Self {
            gram: Vec::new(),
            right: parts.iter().map(|p| p.0.clone()).collect(),
            square: parts.iter().map(|p| p.1).collect(),
        };
        (0..self.gram.len())
            .map(|f| {
                let x = Self::solve_in(&self.gram, &other.right, pick, Some(f), precision, pull);
                let g = &self.gram[f];
                let mut cost = other.square[f];
                for (j, &b) in pick.iter().enumerate() {
                    let column = g.column(b);
                    let row: f64 = pick.iter().zip(x.iter()).map(|(&a, v)| column[a] * v).sum();
                    cost += x[j] * (row - 2.0 * other.right[f][b]);
                }
                cost
            })
            .collect()
    }
}
