//! The normal distribution.

use statrs::function::erf::erfc;

/// Factor of a two-sided interval that holds 95 % of the probability.
pub const Z95: f64 = 1.959_963_984_540_054;

/// Probability of `z` or less; 0 where `z` is not a number.
pub fn below(z: f64) -> f64 {
    if z.is_nan() { 0.0 } else { 0.5 * erfc(-z * std::f64::consts::FRAC_1_SQRT_2) }
}

#[cfg(test)]
mod tests {
    use super::{Z95, below};

    #[test]
    fn the_quantiles_that_everybody_knows() {
        for (z, p) in [(0.0, 0.5), (Z95, 0.975), (-2.326_347_874, 0.01), (f64::INFINITY, 1.0)] {
            assert!((below(z) - p).abs() < 1e-9, "{z}: {}", below(z));
        }
    }
}
