//! Discrete Fourier transforms of one size (`rustfft`).

pub use rustfft::num_complex::Complex;

use rustfft::{Fft, FftPlanner};
use std::sync::Arc;

/// A transform of `n` numbers, planned once; without a factor: forward and then inverse gives `n` times the numbers.
#[derive(Clone)]
pub struct Fourier(Arc<dyn Fft<f64>>);

impl Fourier {
    /// `X[k] = sum of x[j] exp(-2 pi i j k / n)`.
    #[must_use]
    pub fn forward(n: usize) -> Self {
        Self(FftPlanner::new().plan_fft_forward(n))
    }

    /// `x[j] = sum of X[k] exp(2 pi i j k / n)`.
    #[must_use]
    pub fn inverse(n: usize) -> Self {
        Self(FftPlanner::new().plan_fft_inverse(n))
    }

    /// Transforms in place: `n` numbers.
    pub fn apply(&self, numbers: &mut [Complex<f64>]) {
        self.0.process(numbers);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_cycle_is_one_line_and_comes_back() {
        let n = 12;
        let one: Vec<_> = (0..n).map(|j| Complex::cis(std::f64::consts::TAU * j as f64 / n as f64)).collect();
        let mut all = one.clone();
        Fourier::forward(n).apply(&mut all);
        for (k, x) in all.iter().enumerate() {
            let wanted = if k == 1 { n as f64 } else { 0.0 };
            assert!((x - wanted).norm() < 1e-12, "{k}: {x}");
        }
        Fourier::inverse(n).apply(&mut all);
        assert!(all.iter().zip(&one).all(|(a, b)| (a / n as f64 - b).norm() < 1e-14));
    }
}
