//! Readings of a pair over the time since the commands stopped: half the difference of both approaches, in bins.

use crate::log::Log;
use crate::log::dwells::Dwell;
use crate::numerics::robust::{SIGMA_PER_MAD, median};

/// Most bins of a dwell.
const MOST_BINS: usize = 8;
/// Samples that a bin should hold.
const PER_BIN: usize = 2;
/// Each bin is this much wider than the one before, where there are samples enough.
const GROWTH: f64 = 1.3;
/// Samples from which the bins grow.
const GROWING_FROM: usize = 6 * MOST_BINS;
/// Samples farther than this many standard deviations from the dwell's median are gross errors.
const GROSS: f64 = 8.0;

/// One dwell over the time since its commands stopped.
#[derive(Debug, Clone)]
pub struct DwellSeries {
    /// Seconds since the stop, and deviation of the joint (rad or m).
    pub samples: Vec<(f64, f64)>,
    /// Seconds from the joint's last reversal to the stop; `None`: it never turned before.
    pub since_turn_s: Option<f64>,
}

impl DwellSeries {
    /// From deviations row by row; `None` where fewer than two rows were seen.
    pub fn new(log: &Log, dwell: &Dwell, deviation: impl Fn(usize) -> Option<f64>) -> Option<Self> {
        let approach = dwell.approach?;
        if log.poses {
            return None;
        }
        let mut samples: Vec<(f64, f64)> =
            dwell.rows.clone().filter_map(|row| Some((log.t_s[row] - approach.stopped_s, deviation(row)?))).collect();
        if samples.len() >= 4 {
            let values: Vec<f64> = samples.iter().map(|s| s.1).collect();
            let middle = median(&values);
            let off: Vec<f64> = values.iter().map(|v| (v - middle).abs()).collect();
            let limit = GROSS * SIGMA_PER_MAD * median(&off);
            samples.retain(|s| (s.1 - middle).abs() <= limit || limit == 0.0);
        }
        let since_turn_s = approach.turned_s.map(|t| (approach.stopped_s - t).max(0.0));
        (!samples.is_empty()).then_some(Self { samples, since_turn_s })
    }

    /// Mean of `exp(-t / tau)` over samples.
    fn decayed(samples: &[(f64, f64)], pace_s: f64) -> f64 {
        samples.iter().map(|s| (-s.0 / pace_s).exp()).sum::<f64>() / samples.len().max(1) as f64
    }

    /// How far the creep had come at the stop.
    fn amplitude(&self, pace_s: f64, from_turn: bool) -> f64 {
        match (from_turn, self.since_turn_s) {
            (false, _) => 1.0,
            (true, Some(s)) => (-s / pace_s).exp(),
            (true, None) => 0.0,
        }
    }
}

/// Samples of both approaches within the same time since the stop.
#[derive(Debug, Clone)]
pub struct Bin {
    pub up: Vec<(f64, f64)>,
    pub down: Vec<(f64, f64)>,
    /// Middle of the bin, s since the stop.
    pub at_s: f64,
    /// Half the difference of the means, rad or m.
    pub value: f64,
    /// White noise of `value` in variances of one sample.
    pub white: f64,
}

/// A pair over time.
#[derive(Debug, Clone)]
pub struct PairSeries {
    pub place: usize,
    /// Half the difference of the dwells' means as the identification took them, rad or m.
    pub mean: f64,
    pub bins: Vec<Bin>,
    /// End of the shorter dwell, s since the stop.
    pub end_s: f64,
    up: DwellSeries,
    down: DwellSeries,
}

impl PairSeries {
    pub fn new(place: usize, mean: f64, up: DwellSeries, down: DwellSeries) -> Self {
        let span = |d: &DwellSeries| (d.samples[0].0, d.samples[d.samples.len() - 1].0);
        let (a, b) = (span(&up), span(&down));
        let (from, to) = (a.0.max(b.0), a.1.min(b.1));
        let samples = up.samples.len().min(down.samples.len());
        let edges = edges(from, to, samples);
        let bins = edges
            .windows(2)
            .filter_map(|e| {
                let within = |d: &DwellSeries| -> Vec<(f64, f64)> {
                    d.samples.iter().copied().filter(|s| s.0 >= e[0] && s.0 < e[1]).collect()
                };
                let (up, down) = (within(&up), within(&down));
                if up.is_empty() || down.is_empty() {
                    return None;
                }
                let mean = |v: &[(f64, f64)]| v.iter().map(|s| s.1).sum::<f64>() / v.len() as f64;
                Some(Bin {
                    at_s: 0.5 * (e[0] + e[1]),
                    value: 0.5 * (mean(&down) - mean(&up)),
                    white: 0.25 * (1.0 / up.len() as f64 + 1.0 / down.len() as f64),
                    up,
                    down,
                })
            })
            .collect();
        Self { place, mean, bins, end_s: to, up, down }
    }

    /// What a creep of amplitude 1 adds to each bin.
    pub fn in_bins(&self, pace_s: f64, from_turn: bool) -> impl Iterator<Item = f64> + '_ {
        let (up, down) = (self.up.amplitude(pace_s, from_turn), self.down.amplitude(pace_s, from_turn));
        self.bins.iter().map(move |b| {
            0.5 * (up * DwellSeries::decayed(&b.up, pace_s) + down * DwellSeries::decayed(&b.down, pace_s))
        })
    }

    /// What it adds to the mean of the pair.
    pub fn in_mean(&self, pace_s: f64, from_turn: bool) -> f64 {
        let of = |d: &DwellSeries| d.amplitude(pace_s, from_turn) * DwellSeries::decayed(&d.samples, pace_s);
        0.5 * (of(&self.up) + of(&self.down))
    }

    /// What it adds `after_s` seconds after the stop.
    pub fn at(&self, pace_s: f64, from_turn: bool, after_s: f64) -> f64 {
        0.5 * (self.up.amplitude(pace_s, from_turn) + self.down.amplitude(pace_s, from_turn))
            * (-after_s / pace_s).exp()
    }
}

/// Edges of the bins between two times.
fn edges(from: f64, to: f64, samples: usize) -> Vec<f64> {
    let n = (samples / PER_BIN).clamp(1, MOST_BINS);
    let growth = if samples >= GROWING_FROM { GROWTH } else { 1.0f64 };
    let widths: Vec<f64> = (0..n).map(|k| growth.powi(k as i32)).collect();
    let total: f64 = widths.iter().sum();
    let mut edges = vec![from];
    let mut sum = 0.0;
    for w in &widths {
        sum += w;
        edges.push(from + (to - from) * sum / total);
    }
    if let Some(last) = edges.last_mut() {
        *last += 1e-9 * (1.0 + last.abs()); // the last sample belongs to the last bin
    }
    edges
}
