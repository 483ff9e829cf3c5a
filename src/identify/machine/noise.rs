//! Noise of a log: autoregressive in each principal direction, estimated from residuals, and the filter that whitens by it.
//!
//! A tracker measures distance better than angles, and air and structure move slowly, so residuals are turned into the principal
//! directions of their short-time scatter and each gets an autoregressive model (Burg 1975; order by the criterion of Akaike,
//! corrected for short series). Bins that are missing or discarded are replaced by their prediction, in residuals and in
//! columns alike, so that the filter stays linear. Autoregressive noise also absorbs part of what the model lacks: judge a
//! model by data that were not fitted.
//!
//! What the laws lack is as smooth as the movement. Beside it an instrument may have next to no noise, and a filter that predicts the
//! residual almost exactly would see nothing but corners: a gap that stays wrong for a whole stroke would cost nothing. So the noise is
//! that of the residual and of white noise of the size of what laws are known to miss.

use crate::numerics::robust::{SIGMA_PER_MAD, median_of};
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Differences beyond this many medians are no scatter.
const GROSS: f64 = 4.0;
/// Highest order that is tried.
pub const MOST_LAGS: usize = 24;
/// Bins that are whitened at a time: they stay in the processor's nearest memory.
const STRETCH: usize = 512;

/// Noise of one principal direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Autoregressive {
    pub phi: Vec<f64>,
    /// Standard deviation of the innovation, m.
    pub sigma: f64,
}

impl Autoregressive {
    /// Whitens `values` in place: `(v[i] - sum phi_k v[i-k]) / sigma`; a missing bin becomes 0 and counts as predicted.
    pub fn whiten(&self, values: &mut [f64], missing: &[bool], history: &mut Vec<f64>) {
        history.clear();
        history.extend_from_slice(values);
        let order = self.phi.len();
        for i in (0..values.len()).filter(|&i| missing[i]) {
            let lags = order.min(i);
            history[i] = self.phi[..lags].iter().enumerate().map(|(k, p)| p * history[i - 1 - k]).sum();
        }
        // lag by lag over short stretches, which a processor does several bins at a time
        for from in (order..values.len()).step_by(STRETCH) {
            let out = &mut values[from..(from + STRETCH).min(history.len())];
            out.copy_from_slice(&history[from..from + out.len()]);
            // four lags in one pass over the bins
            let n = out.len();
            let lag = |k: usize| &history[from - 1 - k..][..n];
            let mut fours = self.phi.chunks_exact(4);
            for (m, p) in fours.by_ref().enumerate() {
                let [a, b, c, d] = [0, 1, 2, 3].map(|i| lag(4 * m + i));
                for i in 0..n {
                    out[i] = out[i] - p[0] * a[i] - p[1] * b[i] - p[2] * c[i] - p[3] * d[i];
                }
            }
            let rest = fours.remainder();
            for (k, p) in rest.iter().enumerate() {
                let before = lag(order - rest.len() + k);
                out.iter_mut().zip(before).for_each(|(o, h)| *o -= p * h);
            }
            out.iter_mut().for_each(|o| *o /= self.sigma);
        }
        // the first bins have no history: they only start the filter
        for i in 0..values.len() {
            if missing[i] || i < order {
                values[i] = 0.0;
            }
        }
    }
}

/// Noise of a log.
#[derive(Debug, Clone)]
pub struct Noise {
    /// Rows: principal directions.
    pub rotation: Matrix3<f64>,
    pub along: [Autoregressive; 3],
}

impl Noise {
    /// First guess: strongly correlated noise, so that slow misfit counts little, with the size of the differences of neighbours.
    pub fn first(residual: &[Vector3<f64>], missing: &[bool]) -> Self {
        const CORRELATION: f64 = 0.9;
        let rotation = principal(residual, missing);
        let along = std::array::from_fn(|c| {
            let mut differences: Vec<f64> = (1..residual.len())
                .filter(|&i| !missing[i] && !missing[i - 1])
                .map(|i| (rotation.row(c) * residual[i])[0] - CORRELATION * (rotation.row(c) * residual[i - 1])[0])
                .collect();
            differences.iter_mut().for_each(|d| *d = d.abs());
            let sigma = SIGMA_PER_MAD * median_of(&mut differences).unwrap_or(0.0);
            Autoregressive { phi: vec![CORRELATION], sigma: sigma.max(1e-8) }
        });
        Self { rotation, along }
    }

    /// Noise without correlation, of the size of the residuals.
    pub fn uncorrelated(residual: &[Vector3<f64>], missing: &[bool]) -> Self {
        let rotation = principal(residual, missing);
        let along = std::array::from_fn(|c| {
            let used: Vec<f64> =
                residual.iter().zip(missing).filter(|(_, m)| !**m).map(|(r, _)| (rotation.row(c) * r)[0]).collect();
            let n = used.len().max(1) as f64;
            let mean = used.iter().sum::<f64>() / n;
            let variance = used.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
            Autoregressive { phi: Vec::new(), sigma: variance.sqrt().max(1e-9) }
        });
        Self { rotation, along }
    }

    /// Estimate from residuals, to each direction of which white noise of standard deviation `floor_m` is added.
    pub fn of(residual: &[Vector3<f64>], missing: &[bool], floor_m: f64) -> Self {
        let rotation = principal(residual, missing);
        let along = std::array::from_fn(|c| {
            let series: Vec<f64> = residual.iter().map(|r| (rotation.row(c) * r)[0]).collect();
            burg(&series, missing, floor_m)
        });
        Self { rotation, along }
    }
}

/// Principal directions of the scatter of differences of neighbours: what is slow does not count.
///
/// Single readings stand in the first coordinate, and stay there.
fn principal(residual: &[Vector3<f64>], missing: &[bool]) -> Matrix3<f64> {
    if residual.iter().all(|r| r.y == 0.0 && r.z == 0.0) {
        return Matrix3::identity();
    }
    let mut scatter = Matrix3::zeros();
    let pairs = (1..residual.len()).filter(|&i| !missing[i] && !missing[i - 1]);
    let mut sizes: Vec<f64> = pairs.clone().map(|i| (residual[i] - residual[i - 1]).norm()).collect();
    let limit = GROSS * median_of(&mut sizes).unwrap_or(0.0);
    for i in pairs {
        let d = residual[i] - residual[i - 1];
        if d.norm() <= limit {
            scatter += d * d.transpose();
        }
    }
    let eigen = SymmetricEigen::new(scatter);
    eigen.eigenvectors.transpose()
}

/// Burg's method over the stretches between missing bins; the sums are those expected where white noise of standard deviation `floor` is
/// added to the series.
fn burg(series: &[f64], missing: &[bool], floor: f64) -> Autoregressive {
    let mean = {
        let (s, n) =
            series.iter().zip(missing).filter(|(_, m)| !**m).fold((0.0, 0.0), |(s, n), (v, _)| (s + v, n + 1.0));
        if n > 0.0 { s / n } else { 0.0 }
    };
    let n = series.len();
    let mut forward: Vec<f64> = series.iter().map(|v| v - mean).collect();
    let mut backward = forward.clone();
    // number of bins without a gap up to and with bin i
    let mut run = vec![0usize; n];
    for i in 0..n {
        run[i] = if missing[i] { 0 } else { 1 + if i > 0 { run[i - 1] } else { 0 } };
    }
    let good = run.iter().filter(|r| **r > 0).count().max(1);
    let mut power = (0..n).filter(|&i| run[i] > 0).map(|i| forward[i] * forward[i]).sum::<f64>() / good as f64;
    power += floor * floor;
    let mut phi: Vec<f64> = Vec::new();
    let mut best = (f64::INFINITY, Vec::new(), power);
    for order in 0..=MOST_LAGS.min(good / 20) {
        let used = (0..n).filter(|&i| run[i] > order).count() as f64;
        if used < 3.0 * order as f64 + 10.0 || power <= 0.0 {
            break;
        }
        let k = order as f64 + 1.0;
        let criterion = used * power.ln() + 2.0 * k * used / (used - k - 1.0);
        if criterion / used < best.0 {
            best = (criterion / used, phi.clone(), power);
        }
        // reflection by the stretches that are long enough; first what the filters of this order make of the white noise
        let white = floor * floor * (0..n).filter(|&i| run[i] > order + 1).count() as f64;
        let mut num = white * phi.iter().zip(phi.iter().rev()).map(|(a, b)| a * b).sum::<f64>();
        let mut den = 2.0 * white * (1.0 + phi.iter().map(|p| p * p).sum::<f64>());
        for i in 1..n {
            if run[i] > order + 1 {
                num += forward[i] * backward[i - 1];
                den += forward[i] * forward[i] + backward[i - 1] * backward[i - 1];
            }
        }
        if den <= 0.0 {
            break;
        }
        let reflection = 2.0 * num / den;
        let (old_f, old_b) = (forward.clone(), backward.clone());
        for i in (1..n).rev() {
            forward[i] = old_f[i] - reflection * old_b[i - 1];
            backward[i] = old_b[i - 1] - reflection * old_f[i];
        }
        let mut next: Vec<f64> = phi.iter().enumerate().map(|(j, p)| p - reflection * phi[phi.len() - 1 - j]).collect();
        next.push(reflection);
        phi = next;
        power *= 1.0 - reflection * reflection;
    }
    Autoregressive { phi: best.1, sigma: best.2.sqrt().max(1e-9) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The filter by its definition, bin by bin: a missing bin is its prediction and counts nothing.
    fn by_definition(noise: &Autoregressive, values: &[f64], missing: &[bool]) -> Vec<f64> {
        let mut history = values.to_vec();
        let mut out = vec![0.0; values.len()];
        for i in 0..values.len() {
            let lags = noise.phi.len().min(i);
            let predicted: f64 = (0..lags).map(|k| noise.phi[k] * history[i - 1 - k]).sum();
            if missing[i] {
                history[i] = predicted;
            } else if i >= noise.phi.len() {
                out[i] = (history[i] - predicted) / noise.sigma;
            }
        }
        out
    }

    #[test]
    fn whitens_as_the_definition_says_over_missing_bins_and_long_logs() {
        let noise = Autoregressive { phi: vec![0.7, -0.2, 0.15, 0.05, -0.1], sigma: 2e-6 };
        for n in [3, 7, 1300] {
            let values: Vec<f64> = (0..n).map(|i| ((i * i) as f64 * 0.37).sin() * 1e-5).collect();
            let missing: Vec<bool> = (0..n).map(|i| i % 11 == 4 || (500..530).contains(&i) || i == 1).collect();
            let want = by_definition(&noise, &values, &missing);
            let mut is = values.clone();
            noise.whiten(&mut is, &missing, &mut Vec::new());
            for (i, (a, b)) in is.iter().zip(&want).enumerate() {
                assert!((a - b).abs() < 1e-9, "bin {i} of {n}: {a} for {b}");
            }
        }
    }

    /// Truth: the same filter estimated from a series to which white noise was in fact added. Without the white noise a step of the size of
    /// the residual hardly counts, as it is predicted from its neighbours.
    #[test]
    fn a_floor_is_white_noise_that_is_expected_instead_of_drawn() {
        let (n, floor) = (6000, 2e-6);
        let missing: Vec<bool> = (0..n).map(|i| i % 97 == 5).collect();
        let smooth: Vec<f64> =
            (0..n).map(|i| 5e-6 * ((0.031 * i as f64).sin() + (0.0173 * i as f64 + 1.0).sin())).collect();
        let mut state = 11u64;
        let mut uniform = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let mut normal = || (0..12).map(|_| uniform()).sum::<f64>();
        let drawn: Vec<f64> = smooth.iter().map(|v| v + floor * normal()).collect();
        let counts = |noise: &Autoregressive| {
            let mut step: Vec<f64> = (0..n).map(|i| if i < n / 2 { 0.0 } else { floor }).collect();
            noise.whiten(&mut step, &missing, &mut Vec::new());
            step.iter().map(|v| v * v).sum::<f64>().sqrt()
        };
        let (expected, real, without) =
            (burg(&smooth, &missing, floor), burg(&drawn, &missing, 0.0), burg(&smooth, &missing, 0.0));
        assert!((expected.sigma / real.sigma - 1.0).abs() < 0.03, "{} for {}", expected.sigma, real.sigma);
        assert!((counts(&expected) / counts(&real) - 1.0).abs() < 0.2, "{} for {}", counts(&expected), counts(&real));
        assert!(without.sigma < 0.1 * expected.sigma, "{} beside {}", without.sigma, expected.sigma);
        assert_eq!(burg(&drawn, &missing, 0.0), burg(&drawn, &missing, 1e-30), "no floor, no change");
    }

    #[test]
    fn uncorrelated_noise_scales_by_the_scatter_of_what_was_measured_and_looks_at_no_neighbour() {
        let missing: Vec<bool> = (0..400).map(|i| i % 9 == 3).collect();
        let value = |i: usize| if i % 9 == 3 { 1.0 } else { 5e-6 + 2e-6 * f64::from(i as i32 % 2 * 2 - 1) };
        let residual: Vec<Vector3<f64>> = (0..400).map(|i| Vector3::new(value(i), 0.0, 0.0)).collect();
        let noise = Noise::uncorrelated(&residual, &missing);
        let along = (0..3).find(|c| noise.rotation.row(*c)[0].abs() > 0.9).unwrap();
        assert!((noise.along[along].sigma - 2e-6).abs() < 1e-8, "{}", noise.along[along].sigma);
        let mut steps: Vec<f64> = (0..400).map(|i| if i < 200 { 0.0 } else { 4e-6 }).collect();
        noise.along[along].whiten(&mut steps, &[false; 400], &mut Vec::new());
        assert!((steps[399] - 2.0).abs() < 0.01 && steps[199] == 0.0, "what stays counts to its end");
    }
}
