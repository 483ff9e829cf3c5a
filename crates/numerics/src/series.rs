//! Positions between samples, without smoothing reversals.
//!
//! Method: piecewise cubic Hermite interpolation with the slopes of parabolas through three samples, held within the monotone region
//! of Fritsch and Carlson (1980) but next to a reversal, and 0 where a joint stops. Between two samples of one direction the curve stays
//! between their values; at a reversal it has one peak, where the parabola has it. So it neither adds a reversal nor cuts its peak. A
//! cubic spline would overshoot where a joint stops, and the overshoot would read as a reversal.
//!
//! Assumptions: times increase strictly. Fails: `None` outside the recording.

use crate::robust::spread;
use std::ops::Range;

/// Samples of several channels at common times.
#[derive(Debug, Clone)]
pub struct Series {
    t_s: Vec<f64>,
    /// `values[channel][sample]`.
    values: Vec<Vec<f64>>,
    slopes: Vec<Vec<f64>>,
}

impl Series {
    /// `still[channel]`: movement up to which a channel stands still.
    pub fn new(t_s: Vec<f64>, values: Vec<Vec<f64>>, still: &[f64]) -> Self {
        let slopes = values.iter().zip(still).map(|(v, s)| slopes(&t_s, v, *s)).collect();
        Self { t_s, values, slopes }
    }

    /// Number of channels.
    pub fn channels(&self) -> usize {
        self.values.len()
    }

    /// First and last time, s.
    pub fn span(&self) -> Range<f64> {
        self.t_s.first().copied().unwrap_or(0.0)..self.t_s.last().copied().unwrap_or(0.0)
    }

    /// Times of the samples, s.
    pub fn times(&self) -> &[f64] {
        &self.t_s
    }

    /// Sample before `t`; `None` outside.
    pub fn before(&self, t: f64) -> Option<usize> {
        let span = self.span();
        if !(span.start..=span.end).contains(&t) || self.t_s.len() < 2 {
            return None;
        }
        Some(self.t_s.partition_point(|v| *v <= t).clamp(1, self.t_s.len() - 1) - 1)
    }

    /// Share of the interval after sample `k` that has passed at `t`.
    pub fn share(&self, k: usize, t: f64) -> f64 {
        (t - self.t_s[k]) / (self.t_s[k + 1] - self.t_s[k])
    }

    /// Values and rates at `t`; false outside.
    pub fn at(&self, t: f64, values: &mut [f64], rates: &mut [f64]) -> bool {
        let Some(k) = self.before(t) else { return false };
        let x = self.share(k, t);
        for channel in 0..self.values.len() {
            (values[channel], rates[channel]) = self.within(channel, k, x);
        }
        true
    }

    /// Range of a channel's samples.
    pub fn travel(&self, channel: usize) -> f64 {
        spread(self.values[channel].iter().copied())
    }

    /// Value and rate in the interval after sample `k`, `x` from 0 to 1.
    pub fn within(&self, channel: usize, k: usize, x: f64) -> (f64, f64) {
        let h = self.t_s[k + 1] - self.t_s[k];
        let (a, b) = (self.values[channel][k], self.values[channel][k + 1]);
        let (da, db) = (h * self.slopes[channel][k], h * self.slopes[channel][k + 1]);
        let (c2, c3) = (3.0 * (b - a) - 2.0 * da - db, da + db - 2.0 * (b - a));
        (a + x * (da + x * (c2 + x * c3)), (da + x * (2.0 * c2 + x * 3.0 * c3)) / h)
    }
}

/// Slopes of three-point parabolas, limited; 0 next to an interval of no movement.
fn slopes(t: &[f64], v: &[f64], still: f64) -> Vec<f64> {
    /// Slopes up to this many secants keep a cubic monotone (Fritsch and Carlson 1980).
    const MONOTONE: f64 = 3.0;
    let n = t.len();
    if n < 2 {
        return vec![0.0; n];
    }
    let h = |k: usize| t[k + 1] - t[k];
    let d = |k: usize| (v[k + 1] - v[k]) / h(k);
    let rests = |k: usize| k + 1 < n && (v[k + 1] - v[k]).abs() <= still;
    // one still interval is a peak between two samples; two are a stop
    let stopped = |k: usize| rests(k) && (rests(k + 1) || k > 0 && rests(k - 1));
    let turns = |k: usize| k > 0 && k + 1 < n && d(k - 1) * d(k) <= 0.0 && !stopped(k - 1) && !stopped(k);
    let mut slopes = vec![0.0; n];
    for k in 1..n - 1 {
        if !stopped(k - 1) && !stopped(k) {
            let parabola = (d(k - 1) * h(k) + d(k) * h(k - 1)) / (h(k - 1) + h(k));
            // next to a turn a limit would cut its peak
            let near_turn = turns(k) || turns(k - 1) || turns(k + 1);
            let most = if near_turn { f64::INFINITY } else { MONOTONE * d(k - 1).abs().min(d(k).abs()) };
            slopes[k] = parabola.clamp(-most, most);
        }
    }
    // at the ends the parabola of the first and of the last three samples
    let end = |near: usize, next: usize| d(near) + (d(near) - d(next)) * h(near) / (h(near) + h(next));
    let ends = |k: usize, next: usize| if n < 3 || stopped(k) { d(k) } else { end(k, next) };
    (slopes[0], slopes[n - 1]) = (ends(0, 1), ends(n - 2, n.saturating_sub(3)));
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp() -> Series {
        // up, a dwell, down
        let t: Vec<f64> = (0..9).map(f64::from).collect();
        let v = vec![0.0, 1.0, 2.0, 3.0, 3.0, 3.0, 2.0, 1.0, 0.0];
        Series::new(t, vec![v], &[1e-9])
    }

    #[test]
    fn a_stop_is_not_overshot_and_a_reversal_stays_where_it_is() {
        let s = ramp();
        let (mut v, mut d) = ([0.0], [0.0]);
        for i in 0..=800 {
            let t = f64::from(i) * 0.01;
            assert!(s.at(t, &mut v, &mut d));
            assert!((-1e-12..=3.0 + 1e-12).contains(&v[0]), "{t}: {}", v[0]);
            let down = d[0] < -1e-9;
            assert!(!(down && t < 5.0 || d[0] > 1e-9 && t > 5.0), "{t}: {}", d[0]);
        }
        assert!(!s.at(8.001, &mut v, &mut d));
    }

    #[test]
    fn a_quick_stop_is_not_overshot_either() {
        let t: Vec<f64> = (0..9).map(f64::from).collect();
        let s = Series::new(t, vec![vec![0.0, 1.0, 2.0, 2.1, 2.1, 2.1, 2.0, 1.0, 0.0]], &[1e-9]);
        let (mut v, mut d) = ([0.0], [0.0]);
        let highest = (0..=800).map(|i| {
            assert!(s.at(f64::from(i) * 0.01, &mut v, &mut d));
            v[0]
        });
        assert!(highest.fold(0.0, f64::max) <= 2.1 + 1e-12);
    }

    #[test]
    fn a_peak_between_two_samples_is_neither_cut_nor_doubled() {
        let t: Vec<f64> = (0..40).map(|i| 0.1 * f64::from(i)).collect();
        let s = Series::new(t.clone(), vec![t.iter().map(|t| (2.0 * t).sin()).collect()], &[1e-9]);
        let (mut v, mut d) = ([0.0], [0.0]);
        let (mut error, mut reversals, mut before) = (0.0f64, 0, 1.0);
        for i in 0..3900 {
            let t = 1e-3 * f64::from(i);
            assert!(s.at(t, &mut v, &mut d));
            error = error.max((v[0] - (2.0 * t).sin()).abs());
            reversals += usize::from(d[0] * before < 0.0);
            before = d[0];
        }
        // a straight line would miss by 0.005
        assert!(error < 6e-4 && reversals == 2, "{error} {reversals}");
    }

    #[test]
    fn a_smooth_motion_is_followed_to_the_third_order_between_its_reversals() {
        let error = |n: usize| {
            let t: Vec<f64> = (0..n).map(|i| i as f64 / n as f64).collect();
            let s = Series::new(t.clone(), vec![t.iter().map(|t| t.exp()).collect()], &[1e-12]);
            let (mut v, mut d) = ([0.0], [0.0]);
            (1..900)
                .map(|i| f64::from(i) * 1e-3)
                .map(|t| if s.at(t, &mut v, &mut d) { (v[0] - t.exp()).abs() } else { 0.0 })
                .fold(0.0, f64::max)
        };
        assert!(error(40) / error(80) > 3.5, "{} {}", error(40), error(80));
    }
}
