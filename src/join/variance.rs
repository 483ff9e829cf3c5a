//! Variance of sums of correlated terms.

/// Variance of a sum of correlated terms: Bartlett kernel, its length by Andrews (1991) for a first-order autoregression.
pub(super) fn long_run_variance(u: &[f64]) -> f64 {
    let n = u.len();
    let lagged = |l: usize| -> f64 { u.iter().zip(&u[l..]).map(|(a, b)| a * b).sum() };
    let zero = lagged(0).max(f64::MIN_POSITIVE);
    let rho = (lagged(1) / zero).clamp(-0.97, 0.97);
    let alpha = 4.0 * rho * rho / ((1.0 - rho).powi(2) * (1.0 + rho).powi(2));
    let length = (1.1447 * (alpha * n as f64).cbrt()).ceil().max(12.0).min(n as f64 / 4.0) as usize;
    let sum = (1..=length).map(|l| 2.0 * (1.0 - l as f64 / (length + 1) as f64) * lagged(l)).sum::<f64>();
    (zero + sum).max(0.25 * zero)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_variance_of_a_sum_of_correlated_terms_is_found() {
        use rand::{Rng, SeedableRng};
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        // a moving sum of five: variance of the sum is 25 times that of white terms
        let white: Vec<f64> = (0..40_000).map(|_| rng.random_range(-1.0..1.0)).collect();
        let u: Vec<f64> = white.windows(5).map(|w| w.iter().sum()).collect();
        let want = 25.0 * u.len() as f64 / 3.0;
        let found = long_run_variance(&u);
        assert!((found / want - 1.0).abs() < 0.12, "{found} {want}");
    }
}
