//! Coloured measurement noise: white plus first-order autoregressive, per group of observations.
//!
//! Model: `y = x + v`, `x` an AR(1) process with correlation `phi` from one sample to the next and the share `share` of
//! the variance, `v` white. Method: the scalar Kalman filter gives the innovations, which are white, for any pattern of
//! missing samples; filtering every sensitivity with the same gains turns generalised least squares into ordinary ones.
//! `phi` and `share` are those of the largest likelihood, the variance follows in closed form (Harvey 1989, section 3.4).
//!
//! Assumptions: the coordinates of a sensor are alike and independent; sampling is even up to missing samples. Settled
//! poses are white. Fails on structure in the residual: it is taken for slow noise, so the caller removes structure first.
//!
//! Files beside:
//! - `whitening`: the noise of all groups of observations, and the filters that whiten the long vector by it

pub(crate) mod whitening;

use crate::diagnose::problem::layout::{Group, Sensor};

/// Noise of one group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Standard deviation of one coordinate, m or rad.
    pub sigma: f64,
    /// Correlation of the coloured part from sample to sample.
    pub phi: f64,
    /// Share of the variance that is coloured.
    pub share: f64,
}

/// Largest correlation that is tried: slower is drift, an effect.
pub(in crate::diagnose) const SLOWEST: f64 = 0.97;
/// The same where slow wander of arm and air counts as noise.
pub(in crate::diagnose) const WANDER: f64 = 0.999;
/// Smallest standard deviation of a joint, rad or m: the last digit of a file.
const LEAST_SIGMA: f64 = 1e-9;
/// Smallest standard deviation of a coordinate of a point, m: no tracker is better, and of an exact log the turning points
/// between its rows are not known to less.
pub(in crate::diagnose) const LEAST_POINT_SIGMA: f64 = 1e-7;

/// The smallest of a group.
pub(in crate::diagnose) fn least_sigma(group: &Group) -> f64 {
    if group.sensor.is_length() || group.sensor == Sensor::Orientation { LEAST_POINT_SIGMA } else { LEAST_SIGMA }
}

impl Noise {
    /// Uncorrelated noise of standard deviation `sigma`, in the unit of the residuals (m, rad).
    pub fn white(sigma: f64) -> Self {
        Self { sigma, phi: 0.0, share: 0.0 }
    }

    /// Lag-one autocorrelation of the whole noise.
    pub fn lag_one(&self) -> f64 {
        self.phi * self.share
    }

    /// Power at `omega` (rad per sample) relative to white noise of the same variance.
    pub fn spectrum(&self, omega: f64) -> f64 {
        let p = self.phi;
        (1.0 - self.share) + self.share * (1.0 - p * p) / (1.0 - 2.0 * p * omega.cos() + p * p)
    }
}

/// Filter gains of one group, ready to whiten columns.
#[derive(Debug, Clone)]
pub struct Whitener {
    /// Per block: what its own prediction and its value weigh in the prediction of the next, 1 over the standard deviation of
    /// the innovation.
    gains: Vec<[f64; 3]>,
    /// No part of the noise is coloured: whitening is a scale.
    white: bool,
    /// Sum of the logarithms of the innovation variances over all coordinates.
    pub log_det: f64,
}

impl Whitener {
    /// Gains for the samples of `group`.
    pub fn new(group: &Group, noise: &Noise) -> Self {
        let mut gains = Vec::with_capacity(group.len());
        let (coloured, white) = (noise.share, 1.0 - noise.share);
        let mut p = coloured;
        let mut log_det = 0.0;
        let per_sigma = 1.0 / noise.sigma;
        let mut settled: Option<[f64; 3]> = None;
        let (mut run, mut settled_log) = (0usize, 0.0);
        for (b, &step) in group.steps.iter().enumerate() {
            if step == 1.0 {
                run += 1;
            } else {
                run = 0;
                settled = None;
            }
            if let Some(g) = settled {
                gains.push(g);
                log_det += settled_log;
                continue;
            }
            let a = if b == 0 {
                0.0
            } else if step == 1.0 {
                noise.phi
            } else if step.is_finite() {
                noise.phi.powf(step)
            } else {
                0.0
            };
            let before = p;
            p = if b == 0 { coloured } else { a * a * p + coloured * (1.0 - a * a) };
            let s = p + white;
            let k = p / s;
            let after = (1.0 - k) * p;
            let g = [a, k, per_sigma / s.sqrt()];
            gains.push(g);
            log_det += s.ln();
            if run > 0 && (after - before).abs() < 1e-13 {
                settled = Some(g);
                settled_log = s.ln();
            }
            p = after;
        }
        log_det += 2.0 * noise.sigma.ln() * group.len() as f64;
        // the factor of a step stands with the block after it
        for b in 0..gains.len() {
            let next = gains.get(b + 1).map_or(0.0, |g| g[0]);
            let [_, k, s] = gains[b];
            gains[b] = [next * (1.0 - k), next * k, s];
        }
        Self { gains, white: coloured == 0.0, log_det: log_det * group.dims as f64 }
    }

    /// Whitens the values of the group in place.
    pub fn apply(&self, values: &mut [f64]) {
        let n = self.gains.len();
        if n == 0 {
            return;
        }
        if self.white {
            for series in values.chunks_exact_mut(n) {
                for (v, &[_, _, s]) in series.iter_mut().zip(&self.gains) {
                    *v *= s;
                }
            }
            return;
        }
        // three coordinates side by side: each value waits for the one before it in its series alone
        let mut points = values.chunks_exact_mut(3 * n);
        for point in &mut points {
            let (first, rest) = point.split_at_mut(n);
            let (second, third) = rest.split_at_mut(n);
            let mut x = [0.0; 3];
            for (((&[c, d, s], u), v), w) in self.gains.iter().zip(first).zip(second).zip(third) {
                for (x, v) in x.iter_mut().zip([u, v, w]) {
                    let innovation = *v - *x;
                    *x = c * *x + d * *v;
                    *v = innovation * s;
                }
            }
        }
        for series in points.into_remainder().chunks_exact_mut(n) {
            let mut x = 0.0;
            for (v, &[c, d, s]) in series.iter_mut().zip(&self.gains) {
                let innovation = *v - x;
                x = c * x + d * *v;
                *v = innovation * s;
            }
        }
    }
    /// Takes the whitening back, in place.
    pub fn undo(&self, values: &mut [f64]) {
        let n = self.gains.len();
        if n == 0 {
            return;
        }
        for series in values.chunks_exact_mut(n) {
            let mut x = 0.0;
            for (v, &[c, d, s]) in series.iter_mut().zip(&self.gains) {
                *v = *v / s + x;
                x = c * x + d * *v;
            }
        }
    }

    /// Adjoint of [`Self::apply`] in place: `<apply(x), y> = <x, adjoint(y)>`.
    pub fn adjoint(&self, values: &mut [f64]) {
        let n = self.gains.len();
        if n == 0 {
            return;
        }
        for series in values.chunks_exact_mut(n) {
            let mut after = 0.0;
            for (v, &[c, d, s]) in series.iter_mut().zip(&self.gains).rev() {
                let innovation = s * *v;
                *v = innovation + d * after;
                after = c * after - innovation;
            }
        }
    }
}

/// Noise of the largest likelihood for the residual of a group (its values in the long vector), and twice its logarithm.
/// `fitted`: parameters that were fitted to the residual, for the degrees of freedom of the variance; `slowest`: the largest
/// correlation that is tried.
pub fn estimate(group: &Group, residual: &[f64], fitted: f64, slowest: f64) -> (Noise, f64) {
    let n = residual.len() as f64;
    let free = (n - fitted).max(1.0);
    let rms = (residual.iter().map(|v| v * v).sum::<f64>() / free).sqrt().max(least_sigma(group));
    if group.steps.iter().all(|s| s.is_infinite()) || residual.len() < 30 {
        return (Noise::white(rms), -n * (2.0 * rms.ln()) - n);
    }
    let mut buffer = vec![0.0; residual.len()];
    let mut cost = |phi: f64, share: f64| -> (f64, f64) {
        let w = Whitener::new(group, &Noise { sigma: 1.0, phi, share });
        buffer.copy_from_slice(residual);
        w.apply(&mut buffer);
        let variance = (buffer.iter().map(|v| v * v).sum::<f64>() / free).max(least_sigma(group).powi(2));
        (n * variance.ln() + w.log_det, variance)
    };
    let mut best = (0.0, 0.0, cost(0.0, 0.0));
    let start = |phi: &f64| *phi < slowest && (*phi < SLOWEST.min(0.95) || slowest > SLOWEST);
    for phi in [0.2, 0.5, 0.75, 0.9, 0.96, 0.99, 0.996].into_iter().filter(start) {
        for share in [0.15, 0.4, 0.7, 0.97] {
            let c = cost(phi, share);
            if c.0 < best.2.0 {
                best = (phi, share, c);
            }
        }
    }
    // a pattern search that halves its steps: the surface is smooth and has one valley
    let (mut dp, mut ds) = (0.12, 0.15);
    for _ in 0..9 {
        loop {
            let mut better = false;
            for (p, s) in [(dp, 0.0), (-dp, 0.0), (0.0, ds), (0.0, -ds), (dp, -ds), (-dp, ds)] {
                let (phi, share) = ((best.0 + p).clamp(0.0, slowest), (best.1 + s).clamp(0.0, 1.0));
                let c = cost(phi, share);
                if c.0 < best.2.0 - 1e-6 {
                    best = (phi, share, c);
                    better = true;
                }
            }
            if !better {
                break;
            }
        }
        dp *= 0.5;
        ds *= 0.5;
    }
    let (phi, share, (cost, variance)) = best;
    (Noise { sigma: variance.sqrt(), phi, share }, -cost - n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    fn coloured(n: usize, phi: f64, share: f64, sigma: f64) -> Vec<f64> {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut x = draw();
        (0..n)
            .map(|_| {
                x = phi * x + (1.0 - phi * phi).sqrt() * draw();
                sigma * (share.sqrt() * x + (1.0 - share).sqrt() * draw())
            })
            .collect()
    }

    #[test]
    fn the_adjoint_is_the_adjoint() {
        let rows: Vec<u32> = (0..50).filter(|r| r % 7 != 3).collect();
        let group = Group::new(0, Sensor::Joint(0), rows.clone(), 1, 0, false);
        let w = Whitener::new(&group, &Noise { sigma: 2.0, phi: 0.8, share: 0.6 });
        let (x, y) = (coloured(rows.len(), 0.3, 0.5, 1.0), coloured(rows.len(), 0.9, 0.1, 3.0));
        let (mut wx, mut ay) = (x.clone(), y.clone());
        w.apply(&mut wx);
        w.adjoint(&mut ay);
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert!((product(&wx, &y) - product(&x, &ay)).abs() < 1e-12);
        w.undo(&mut wx);
        assert!(wx.iter().zip(&x).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn finds_the_noise_that_was_put_in() {
        let rows: Vec<u32> = (0..20_000).filter(|r| r % 97 != 3).collect();
        let all = coloured(20_000, 0.7, 0.5, 8e-6);
        let values: Vec<f64> = rows.iter().map(|&r| all[r as usize]).collect();
        let group = Group::new(0, Sensor::Joint(0), rows, 1, 0, false);
        let (noise, _) = estimate(&group, &values, 0.0, SLOWEST);
        assert!((noise.sigma / 8e-6 - 1.0).abs() < 0.03, "{noise:?}");
        assert!((noise.phi - 0.7).abs() < 0.04 && (noise.share - 0.5).abs() < 0.05, "{noise:?}");
        let mut white = values;
        Whitener::new(&group, &noise).apply(&mut white);
        let n = white.len() as f64;
        let variance = white.iter().map(|v| v * v).sum::<f64>() / n;
        let lag = white.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n;
        assert!((variance - 1.0).abs() < 0.03 && lag.abs() < 0.02, "{variance} {lag}");
    }
}
