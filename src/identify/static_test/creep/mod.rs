//! Creep: after the commands have stopped, a joint still approaches its place, as the servo works off the friction.
//!
//! Within a dwell, half the difference of both approaches reads `g + sum c A exp(-(t - t_stop) / tau)`: the half gap at rest, and
//! one or two exponentials whose paces `tau` all dwells of the joint share. `A` is 1 (the creep begins at the stop) or
//! `exp(-(t_stop - t_rev) / tau)` (it began at the reversal: Stribeck friction under an integrating servo, equation 9 of the
//! catalogue's `stiction`). The mean of a dwell is taken back to rest by the posterior mean of the exponentials.
//!
//! - [`series`]: readings of each pair over the time since the stop, in a few bins.
//! - [`noise`]: covariance of such a reading: white noise, repeatability, a random walk; by restricted likelihood.
//! - [`evidence`]: the hypotheses (none, one, two paces; both forms of `A`; amplitudes that differ between places) and
//!   their posterior probabilities.
//!
//! A dwell that is short against the pace does not determine the place of rest: the posterior is then as wide as the prior of
//! the pace ([`evidence::PACE_S`]), and so is the interval. The dwell that would tell is estimated from the slowest plausible pace.
//!
//! Assumptions: one pace (or two) per joint; amplitudes of a joint scatter around their mean by a share. A friction that
//! keeps creeping without a pace (logarithmic in time) is described by two exponentials within the dwell and not beyond it.

pub(crate) mod evidence;
pub(crate) mod noise;
pub(crate) mod series;

use crate::numerics::normal;
use crate::numerics::robust::median;
use evidence::Component;
use series::PairSeries;

/// Below this probability of any creep the dwells' means are taken as they are.
const LEAST_PROBABILITY: f64 = 0.02;
/// From this probability on the means are taken back to rest; below it they stay, and only the joint's interval shows the doubt.
/// Of joints without any creep one in a hundred exceeds it by chance, as the prior gives creep one half.
const CREEPS: f64 = 0.99;
/// Pairs from which creep can be distinguished from the noise.
const LEAST_PAIRS: usize = 3;
/// Share of the half gap that may remain as creep at the end of a dwell that is long enough.
const NEGLIGIBLE: f64 = 0.025;
/// Bisections of a quantile: an interval of 20 standard deviations to 1e-12 of it.
const BISECTIONS: usize = 45;
/// Quantile of the pace for which a dwell should be long enough.
const SLOW: f64 = 0.9;

impl Creep {
    /// The readings creep beyond doubt, so that the half gaps are taken back to rest.
    pub fn applies(&self) -> bool {
        self.probability >= CREEPS
    }

    /// Posterior mean of what the creep adds to the mean of all pairs, rad or m.
    pub fn mean_correction(&self) -> f64 {
        self.mixture.iter().map(|m| m[0] * m[1]).sum()
    }
}

/// What is known of a joint's creep; rad or m, s.
#[derive(Debug, Clone)]
pub struct Creep {
    /// Probability that the readings creep at all.
    pub probability: f64,
    /// Posterior median and 95 % interval of the (slowest) pace, given that there is creep.
    pub pace_s: f64,
    pub pace_ci95_s: [f64; 2],
    /// Mean creep at the start and at the end of a dwell.
    pub at_stop: f64,
    pub at_end: f64,
    /// Median time from the stop of the commands to the end of a dwell.
    pub dwell_s: f64,
    /// Dwell after which the creep is negligible, for the slowest plausible pace.
    pub needed_dwell_s: f64,
    /// Correction of each pair's mean, in the order of the series: what is to be taken from the half gap.
    pub corrections: Vec<f64>,
    /// Weight, mean correction over all pairs and its variance, of each hypothesis.
    pub mixture: Vec<[f64; 3]>,
    /// Variance of each place's correction, and of its difference from the mean of all places.
    pub place_variance: Vec<f64>,
    pub place_variance_apart: Vec<f64>,
}

/// Creep of one joint; `None` where the dwells show none, or cannot.
pub fn estimate(pairs: &[PairSeries], places: usize) -> Option<Creep> {
    if pairs.len() < LEAST_PAIRS || pairs.iter().filter(|p| p.bins.len() > 1).count() < LEAST_PAIRS {
        return None;
    }
    let scale = pairs.iter().map(|p| p.mean).sum::<f64>().abs() / pairs.len() as f64;
    let noise = noise::estimate(pairs, places)?;
    let components = evidence::posterior(pairs, places, &noise, scale)?;
    let probability: f64 = components.iter().filter(|c| !c.paces.is_empty()).map(|c| c.weight).sum();
    if probability < LEAST_PROBABILITY {
        return None;
    }
    Some(collect(pairs, places, &components, probability, scale))
}

fn collect(pairs: &[PairSeries], places: usize, components: &[Component], probability: f64, scale: f64) -> Creep {
    let n = pairs.len();
    let mut corrections = vec![0.0; n];
    let mut mixture = Vec::with_capacity(components.len());
    let (mut first, mut second) = (vec![0.0; places], vec![0.0; places]);
    let (mut apart_first, mut apart_second) = (vec![0.0; places], vec![0.0; places]);
    let (mut at_stop, mut at_end) = (0.0, 0.0);
    for c in components {
        let effect = c.effect(pairs, places);
        for (sum, v) in corrections.iter_mut().zip(&effect.pairs) {
            *sum += c.weight * v;
        }
        mixture.push([c.weight, effect.mean, effect.mean_variance]);
        for i in 0..places {
            let (m, v) = (effect.places[i], effect.place_variance[i]);
            first[i] += c.weight * m;
            second[i] += c.weight * (v + m * m);
            let d = m - effect.mean;
            apart_first[i] += c.weight * d;
            apart_second[i] += c.weight * (effect.own_variance[i] + d * d);
        }
        at_stop += c.weight * effect.at_stop;
        at_end += c.weight * effect.at_end;
    }
    let left = |second: &[f64], first: &[f64]| -> Vec<f64> {
        second.iter().zip(first).map(|(s, f)| (s - f * f).max(0.0)).collect()
    };
    let pace = |share: f64| evidence::pace_quantile(components, share);
    let dwell_s = median(&pairs.iter().map(|p| p.end_s).collect::<Vec<_>>());
    let rest = (scale - mixture.iter().map(|m| m[0] * m[1]).sum::<f64>()).abs().max(0.1 * scale);
    let slow = pace(SLOW);
    let needed = slow * (at_stop.abs() / (NEGLIGIBLE * rest)).max(1.0).ln();
    Creep {
        probability,
        pace_s: pace(0.5),
        pace_ci95_s: [pace(0.025), pace(0.975)],
        at_stop,
        at_end,
        dwell_s,
        needed_dwell_s: needed.max(dwell_s.min(needed)),
        corrections,
        mixture,
        place_variance: left(&second, &first),
        place_variance_apart: left(&apart_second, &apart_first),
    }
}

/// 95 % interval of a half gap: the creep's posterior, widened by a normal error of the mean.
///
/// `half_gap` is the value at rest, from which the posterior mean was already taken; `sigma` its own standard error.
pub fn interval(creep: &Creep, half_gap: f64, sigma: f64) -> [f64; 2] {
    let mean = creep.mean_correction();
    let parts: Vec<[f64; 3]> = creep
        .mixture
        .iter()
        .map(|[weight, correction, variance]| [*weight, half_gap + mean - correction, variance.sqrt().hypot(sigma)])
        .collect();
    [quantile(&parts, 0.025), quantile(&parts, 0.975)]
}

/// Quantile of a mixture of normal distributions: weight, mean, standard deviation.
fn quantile(parts: &[[f64; 3]], share: f64) -> f64 {
    let mut low = parts.iter().map(|p| p[1] - 10.0 * p[2]).fold(f64::INFINITY, f64::min);
    let mut high = parts.iter().map(|p| p[1] + 10.0 * p[2]).fold(f64::NEG_INFINITY, f64::max);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        let below: f64 =
            parts.iter().map(|p| p[0] * normal::below((middle - p[1]) / p[2].max(f64::MIN_POSITIVE))).sum();
        if below < share { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
