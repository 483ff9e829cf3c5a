//! White noise of the tracker: normal, the same on each coordinate, from a seeded ChaCha8 generator, so that the same
//! seed gives the same log on every machine.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

/// A source of noise in metres.
pub struct Noise {
    normal: Normal<f64>,
    generator: ChaCha8Rng,
}

impl Noise {
    /// `None` for a standard deviation of 0, or one that is not a finite number above it.
    pub fn new(sigma_m: f64, seed: u64) -> Option<Self> {
        if !(sigma_m.is_finite() && sigma_m > 0.0) {
            return None;
        }
        let normal = Normal::new(0.0, sigma_m).ok()?;
        Some(Self { normal, generator: ChaCha8Rng::seed_from_u64(seed) })
    }

    /// The next draw.
    pub fn draw_m(&mut self) -> f64 {
        self.normal.sample(&mut self.generator)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_asked_deviation_and_repeats_with_its_seed() {
        let draw = |seed| {
            let mut noise = Noise::new(11e-6, seed).unwrap();
            (0..40_000).map(|_| noise.draw_m()).collect::<Vec<_>>()
        };
        let a = draw(7);
        let n = a.len() as f64;
        let mean = a.iter().sum::<f64>() / n;
        let sigma = (a.iter().map(|x| x * x).sum::<f64>() / n).sqrt();
        assert!(mean.abs() < 4.0 * 11e-6 / n.sqrt(), "{mean}");
        assert!((sigma / 11e-6 - 1.0).abs() < 4.0 / (2.0 * n).sqrt(), "{sigma}");
        assert_eq!(a, draw(7));
        assert_ne!(a, draw(8));
    }
}
