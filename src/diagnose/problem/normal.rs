//! Scalar products of long columns, normal matrices and their inverses, in an order that depends on nothing but the columns.

use crate::numerics::parallel::ParMap;
use nalgebra::DMatrix;

/// Normal matrix of columns.
pub fn gram(columns: &[Vec<f64>]) -> DMatrix<f64> {
    let all: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    products(&all, |_, _| true)
}

/// Scalar products of all pairs of columns that are `wanted` (the second not after the first), both ways round; 0 elsewhere.
pub(in crate::diagnose) fn products(columns: &[&[f64]], wanted: impl Fn(usize, usize) -> bool + Sync) -> DMatrix<f64> {
    let one = |i: usize, j: usize| if wanted(i, j) { dot(columns[i], columns[j]) } else { 0.0 };
    let rows: Vec<Vec<f64>> = (0..columns.len()).par_map(|i| (0..=i).map(|j| one(i, j)).collect());
    DMatrix::from_fn(columns.len(), columns.len(), |i, j| if j <= i { rows[i][j] } else { rows[j][i] })
}

/// Scalar product, in a fixed order whatever the width of the processor's registers.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    pulp::Arch::new().dispatch(Dot(a, b))
}

struct Dot<'a>(&'a [f64], &'a [f64]);

impl pulp::NullaryFnOnce for Dot<'_> {
    type Output = f64;

    // inlined, so that it is compiled for the registers that there are
    #[inline(always)]
    fn call(self) -> f64 {
        const LANES: usize = 32;
        let mut sums = [0.0; LANES];
        let (x, y) = (self.0.chunks_exact(LANES), self.1.chunks_exact(LANES));
        let rest: f64 = x.remainder().iter().zip(y.remainder()).map(|(a, b)| a * b).sum();
        for (p, q) in x.zip(y) {
            for k in 0..LANES {
                sums[k] += p[k] * q[k];
            }
        }
        sums.iter().sum::<f64>() + rest
    }
}

/// Orthonormal basis of columns (Gram-Schmidt, twice); what is dependent is dropped.
pub fn orthonormal(columns: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(columns.len());
    for mut c in columns {
        let before = dot(&c, &c);
        project_off(&basis, &mut c);
        project_off(&basis, &mut c);
        let left = dot(&c, &c);
        if before > 0.0 && left > 1e-12 * before {
            let per = 1.0 / left.sqrt();
            c.iter_mut().for_each(|v| *v *= per);
            basis.push(c);
        }
    }
    basis
}

/// Takes the part in the span of an orthonormal basis off a column.
pub fn project_off(basis: &[Vec<f64>], column: &mut [f64]) {
    for b in basis {
        let share = dot(b, column);
        for (c, b) in column.iter_mut().zip(b) {
            *c -= share * b;
        }
    }
}
