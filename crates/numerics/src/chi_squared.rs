//! The chi-squared distribution.

use statrs::function::gamma::gamma_ur;

/// Probability of a sum of squares of `chi2` or more with `dof` degrees of freedom; 1 where there is nothing to test with.
pub fn tail(chi2: f64, dof: f64) -> f64 {
    if chi2.is_nan() || chi2 <= 0.0 || dof.is_nan() || dof <= 0.0 {
        return 1.0;
    }
    if chi2.is_infinite() {
        return 0.0;
    }
    gamma_ur(0.5 * dof, 0.5 * chi2).clamp(0.0, 1.0)
}

/// Sum of squares that is exceeded with probability `p`.
pub fn exceeded_with(p: f64, dof: f64) -> f64 {
    super::where_it_falls_to(p, |x| tail(x, dof))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_degrees_of_freedom_are_an_exponential() {
        for x in [0.1, 1.0, 5.0, 60.0] {
            assert!((tail(x, 2.0) / (-0.5 * x).exp() - 1.0).abs() < 1e-12);
        }
        // quantile of one degree of freedom: the square of the normal one
        assert!((exceeded_with(0.05, 1.0) - super::super::normal::Z95.powi(2)).abs() < 1e-9);
    }
}
