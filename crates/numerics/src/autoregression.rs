//! Autoregressive noise: estimation from a series, and the filter that whitens by it.
//!
//! Method: Burg's recursion (Burg 1975): reflection coefficients that minimise the forward and backward prediction errors,
//! always a stable filter; the order of least Akaike criterion up to a given one.
//!
//! Assumptions: samples of even spacing, a mean near zero. A series shorter than four times the order gets a lower order.

/// Autoregression `e_t = x_t - sum_k a_k x_{t-k}` with variance of `e`.
#[derive(Debug, Clone, PartialEq)]
pub struct Autoregression {
    /// `a_1`, `a_2`, ...
    pub coefficients: Vec<f64>,
    /// Variance of the innovations.
    pub variance: f64,
}

impl Autoregression {
    /// The order up to `most` with the least Akaike criterion; white noise of an empty series has variance 0.
    pub fn fit(series: &[f64], most: usize) -> Self {
        let n = series.len();
        let mut variance = series.iter().map(|x| x * x).sum::<f64>() / n.max(1) as f64;
        let mut best = Self { coefficients: Vec::new(), variance };
        if variance <= 0.0 || !variance.is_finite() {
            return best;
        }
        let criterion = |variance: f64, order: usize| n as f64 * variance.ln() + 2.0 * order as f64;
        let mut least = criterion(variance, 0);
        let (mut forward, mut backward) = (series.to_vec(), series.to_vec());
        let mut a: Vec<f64> = Vec::new();
        for order in 1..=most.min(n / 4) {
            // forward errors from `order` on, backward errors one sample earlier
            let pairs = || forward[order..].iter().zip(&backward[order - 1..n - 1]);
            let power: f64 = pairs().map(|(f, b)| f * f + b * b).sum();
            if power <= 0.0 {
                break;
            }
            let reflection = 2.0 * pairs().map(|(f, b)| f * b).sum::<f64>() / power;
            let before = a.clone();
            for (k, c) in a.iter_mut().enumerate() {
                *c -= reflection * before[order - 2 - k];
            }
            a.push(reflection);
            for i in (order..n).rev() {
                let (f, b) = (forward[i], backward[i - 1]);
                forward[i] = f - reflection * b;
                backward[i] = b - reflection * f;
            }
            variance *= 1.0 - reflection * reflection;
            if variance <= 0.0 {
                break;
            }
            if criterion(variance, order) < least {
                least = criterion(variance, order);
                best = Self { coefficients: a.clone(), variance };
            }
        }
        best
    }

    /// Innovations of a series over their deviation; the first rows are predicted from the rows that there are.
    pub fn whiten(&self, series: &[f64]) -> Vec<f64> {
        let sigma = self.variance.sqrt().max(f64::MIN_POSITIVE);
        let past = |t: usize| {
            let rows = series[..t].iter().rev();
            self.coefficients.iter().zip(rows).map(|(a, x)| a * x).sum::<f64>()
        };
        (0..series.len()).map(|t| (series[t] - past(t)) / sigma).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn series(n: usize, a: &[f64]) -> Vec<f64> {
        let mut generator = ChaCha8Rng::seed_from_u64(11);
        let mut x: Vec<f64> = Vec::with_capacity(n);
        for t in 0..n {
            let past: f64 = a.iter().zip(x[..t].iter().rev()).map(|(a, x)| a * x).sum();
            x.push(past + 12f64.sqrt() * (generator.random_range(0.0..1.0) - 0.5));
        }
        x
    }

    #[test]
    fn finds_the_coefficients_that_made_a_series_and_leaves_it_white() {
        let truth = [1.2, -0.5];
        let x = series(20_000, &truth);
        let found = Autoregression::fit(&x, 8);
        assert!((found.variance - 1.0).abs() < 0.03, "{found:?}");
        assert!(found.coefficients.iter().zip(truth).all(|(f, t)| (f - t).abs() < 0.03), "{found:?}");
        assert!(found.coefficients[2..].iter().all(|f| f.abs() < 0.03), "{found:?}");
        let white = found.whiten(&x);
        let lag = |k: usize| white[k..].iter().zip(&white).map(|(a, b)| a * b).sum::<f64>() / white.len() as f64;
        assert!((lag(0) - 1.0).abs() < 0.03 && (1..6).all(|k| lag(k).abs() < 0.03));
    }

    #[test]
    fn white_noise_needs_no_filter_and_silence_has_none() {
        assert!(Autoregression::fit(&series(5000, &[]), 3).coefficients.iter().all(|a| a.abs() < 0.05));
        assert_eq!(Autoregression::fit(&[0.0; 40], 3), Autoregression { coefficients: Vec::new(), variance: 0.0 });
        assert_eq!(Autoregression::fit(&[], 3).variance, 0.0);
    }
}
