//! Derivatives by differences, and a check of a Jacobian against them.
//!
//! Method: central differences with a step of the cube root of the rounding unit times the size of the parameter (Nocedal
//! and Wright 2006, section 8.1): about ten digits of a smooth function. The check compares two step sizes, as rounding
//! spoils the smaller and curvature the larger.

use nalgebra::DMatrix;

/// Jacobian of `f` at `p` by central differences; parameters smaller than `typical` are taken as that large.
pub fn central(mut f: impl FnMut(&[f64]) -> Vec<f64>, p: &[f64], typical: &[f64]) -> DMatrix<f64> {
    differences(&mut f, p, typical, f64::EPSILON.cbrt())
}

fn differences(f: &mut impl FnMut(&[f64]) -> Vec<f64>, p: &[f64], typical: &[f64], relative_step: f64) -> DMatrix<f64> {
    let mut at = p.to_vec();
    let columns: Vec<Vec<f64>> = (0..p.len())
        .map(|k| {
            let step = relative_step * p[k].abs().max(typical[k]);
            at[k] = p[k] + step;
            let (above, high) = (f(&at), at[k]);
            at[k] = p[k] - step;
            let (below, low) = (f(&at), at[k]);
            at[k] = p[k];
            above.iter().zip(&below).map(|(a, b)| (a - b) / (high - low)).collect()
        })
        .collect();
    DMatrix::from_fn(columns.first().map_or(0, Vec::len), p.len(), |i, j| columns[j][i])
}

/// Largest difference between `jacobian` and differences of `f`, each column over its largest value; the better of two
/// step sizes.
pub fn error_of(mut f: impl FnMut(&[f64]) -> Vec<f64>, jacobian: &DMatrix<f64>, p: &[f64], typical: &[f64]) -> f64 {
    let mut error = |relative_step: f64| {
        let want = differences(&mut f, p, typical, relative_step);
        let of_column = |k: usize| {
            let size = want.column(k).amax().max(f64::MIN_POSITIVE);
            (jacobian.column(k) - want.column(k)).amax() / size
        };
        (0..p.len()).map(of_column).fold(0.0, f64::max)
    };
    error(f64::EPSILON.cbrt()).min(error(f64::EPSILON.sqrt().sqrt()))
}

fn f(p: &[f64]) -> Vec<f64> {
    vec![p[0].sin() * p[1], p[1].powi(3)]
}

#[test]
fn differences_have_ten_digits_and_a_wrong_jacobian_shows() {
    let p = [0.7f64, -40.0];
    let right = DMatrix::from_row_slice(2, 2, &[p[0].cos() * p[1], p[0].sin(), 0.0, 3.0 * p[1] * p[1]]);
    assert!((central(f, &p, &[1.0; 2]) - &right).amax() < 1e-9 * right.amax());
    assert!(error_of(f, &right, &p, &[1.0; 2]) < 1e-9);
    let mut wrong = right;
    wrong[(0, 1)] *= -1.0;
    assert!(error_of(f, &wrong, &p, &[1.0; 2]) > 1e-4);
}
