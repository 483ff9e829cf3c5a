//! Stamps of a recording: as they are, or those of a regular clock that jitter hides.
//!
//! Method: many recorders sample at a fixed period and stamp late, by an operating system's whim; others sample when they wake and
//! stamp rightly. Stamps alone do not tell which. The line through stamps over row numbers is offered as a second reading
//! where the stamps scatter about it without drifting away; the fit of the motion decides (see `fit`).
//!
//! The stamps are the clock, so the line is known only as well as the jitter allows: [`Clock::variances`] goes into the intervals.
//!
//! Assumptions: a regular recorder lost no row. One that did is read by its stamps.

/// A reading of a recording's stamps.
#[derive(Debug, Clone)]
pub struct Clock {
    pub t_s: Vec<f64>,
    /// Standard deviation of the stamps about a regular clock that replaces them, s; `None`: stamps as they are.
    pub jitter_s: Option<f64>,
}

impl Clock {
    /// Variances of the line through jittering stamps: of its height in the middle, s2, and of its slope.
    pub fn variances(&self) -> [f64; 2] {
        let n = self.t_s.len() as f64;
        let span = self.t_s.last().copied().unwrap_or(0.0) - self.t_s.first().copied().unwrap_or(0.0);
        self.jitter_s.map_or([0.0, 0.0], |s| [s * s / n, 12.0 * s * s / (n * span * span)])
    }
}

/// Jitter below this part of the period is not worth a second reading.
const LEAST: f64 = 1e-3;
/// Jitter beyond this part of the period may hide lost rows.
const MOST: f64 = 1.5;
/// Correlation of consecutive deviations from which on they drift rather than jitter.
const DRIFTS: f64 = 0.5;
/// Rows from which on a line means something.
const FEWEST: usize = 20;

/// The readings that the stamps allow; empty where the stamps neither increase nor jitter about a regular clock.
pub fn readings(stamps_s: &[f64]) -> Vec<Clock> {
    let mut out = Vec::new();
    if stamps_s.windows(2).all(|w| w[1] > w[0]) {
        out.push(Clock { t_s: stamps_s.to_vec(), jitter_s: None });
    }
    out.extend(regular(stamps_s));
    out
}

fn regular(stamps_s: &[f64]) -> Option<Clock> {
    let n = stamps_s.len();
    if n < FEWEST {
        return None;
    }
    let middle = 0.5 * (n - 1) as f64;
    let first = stamps_s[0];
    let mean = stamps_s.iter().map(|t| t - first).sum::<f64>() / n as f64;
    let (mut up, mut down) = (0.0, 0.0);
    for (i, t) in stamps_s.iter().enumerate() {
        up += (i as f64 - middle) * (t - first - mean);
        down += (i as f64 - middle).powi(2);
    }
    let period = up / down;
    let t_s: Vec<f64> = (0..n).map(|i| first + mean + (i as f64 - middle) * period).collect();
    let off: Vec<f64> = stamps_s.iter().zip(&t_s).map(|(a, b)| a - b).collect();
    let variance = off.iter().map(|v| v * v).sum::<f64>() / n as f64;
    let lagged = off.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / (n - 1) as f64;
    let jitter = variance.sqrt();
    let jitters = period > 0.0 && jitter > LEAST * period && jitter < MOST * period && lagged < DRIFTS * variance;
    jitters.then_some(Clock { t_s, jitter_s: Some(jitter) })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// White numbers from -1 to 1 (a step of splitmix64).
    fn jitter(i: usize) -> f64 {
        let mut x = (i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (x >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    #[test]
    fn a_regular_clock_is_found_behind_jitter_and_not_across_lost_rows() {
        let stamps: Vec<f64> = (0..2000).map(|i| 5.0 + 0.004 * i as f64 + 0.003 * jitter(i)).collect();
        let found = regular(&stamps).unwrap();
        let late = found.t_s[0] - 5.0;
        for (i, t) in found.t_s.iter().enumerate() {
            assert!((t - late - 0.004 * i as f64 - 5.0).abs() < 3e-4, "{i}");
        }
        let lost: Vec<f64> =
            stamps.iter().enumerate().filter(|(i, _)| !(700..800).contains(i)).map(|(_, t)| *t).collect();
        assert!(regular(&lost).is_none());
        let even: Vec<f64> = (0..2000).map(|i| 0.004 * f64::from(i)).collect();
        assert_eq!(readings(&even).len(), 1);
    }
}
