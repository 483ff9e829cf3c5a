//! Gross errors, pure error between cycles, intervals, and whether the gap varies with position.
//!
//! Method, for half gaps `b[i][c]` of place `i` and cycle `c`:
//! - Gross errors: values farther from their place's median than [`GROSS`] times the median of all such distances are left
//!   out and reported; a place of which fewer than two cycles would stay is kept whole and flagged.
//! - Pure error: `s2 = sum (b - y_i)^2 / nu`, `nu = N - n` (the replicates' own variance, no model in it). Intervals
//!   `y_i +- t(nu) sqrt(s2 / R_i)`. Mean of the joint: of the places, unweighted, `se = sqrt(s2 sum(1/R_i)) / n`; where the
//!   gap is constant, of all values.
//! - Gate: F test of the places' means against `s2`, once for any shape (`n - 1` degrees of freedom) and once for slope and
//!   bow (2), the smaller p value doubled (Bonferroni). At [`ALPHA`] or above the gap is constant.
//!
//! Rounding of the readings that the scatter in the dwells does not average out is an error of the place, the same in all its cycles; that
//! of the direction of a dial is the same in all values. Both are in the intervals, the first in the test, too.
//!
//! Assumptions: cycles are independent and their scatter is the same at all places. With fewer than 3 degrees of freedom
//! nothing is tested. One cycle only: the spread between places stands for the noise; one place only: the noise inside
//! the dwells does, which does not include repeatability. Notes report both.
//!
//! Parts:
//! - [`mod@notes`]: what a reader should know.

mod notes;

use super::creep::series::PairSeries;
use super::creep::{self, Creep};
use super::drift::Drift;
use crate::numerics::normal::Z95;
use crate::numerics::robust::{median, median_of};
use crate::numerics::{fisher, student};
use nalgebra::{DMatrix, DVector};
pub use notes::notes;

/// Distance of a gross error, in medians of all distances (8 standard deviations of a normal distribution).
const GROSS: f64 = 12.0;
/// Level of the gate: below it a gap counts as varying with position. A robot of six joints shows a shape that is not there in one
/// test of 160; at 0.01 it is one of 16.
pub const ALPHA: f64 = 0.001;
/// Degrees of freedom of a variance that is known well.
const KNOWN_DOF: f64 = 30.0;
/// Width of an interval over its value from which a note tells the dwell that is needed.
const WIDE: f64 = 0.1;
/// Degrees of freedom from which something can be tested.
const LEAST_DOF: f64 = 3.0;

/// Half gap of one pair, rad or m, and the variance that the noise inside its dwells leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfGap {
    pub value: f64,
    pub variance_in_dwell: f64,
}

/// Half gaps of one joint by place, before any statistics; rad or m.
#[derive(Debug, Clone)]
pub struct Table {
    pub axis: usize,
    /// Places in rising order, each with one value per cycle in the order of time.
    pub places: Vec<(f64, Vec<HalfGap>)>,
    /// Repeats cannot agree better than the file's rounding: standard deviation of a value, rad or m.
    pub rounding: f64,
    /// Standard deviation of the error by the rounding of the readings that all cycles of a place have in common, rad or m.
    pub common_rounding: f64,
    /// Standard deviation by the direction of a dial, as a share of the half gap; common to all values.
    pub tilt: f64,
    /// Shortest approach, rad or m.
    pub least_stroke: f64,
    pub unpaired: usize,
    pub measured: bool,
    /// What moved steadily during the test.
    pub drift: Option<Drift>,
    /// The pairs over the time since the commands stopped, in the order of `places`; empty where a log shows settled poses.
    pub series: Vec<PairSeries>,
}

/// One place, summarised.
#[derive(Debug, Clone)]
pub struct Angle {
    pub at: f64,
    pub cycles: Vec<f64>,
    /// Gross errors that were left out.
    pub dropped: Vec<f64>,
    /// Gross errors that could not be left out.
    pub flagged: bool,
    pub mean: f64,
    pub ci95: [f64; 2],
}

/// What the noise was taken from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoiseFrom {
    /// Repeats of the same place.
    Cycles,
    /// No repeats: the spread between places, as if the gap were constant.
    Places,
    /// One pair at one place: scatter inside its dwells.
    Dwells,
}

/// Variance of one half gap and its degrees of freedom.
#[derive(Debug, Clone, Copy)]
pub struct Noise {
    pub variance: f64,
    pub dof: f64,
    pub from: NoiseFrom,
    /// The repeats agree better than the file's digits: the rounding was taken instead.
    pub rounding: bool,
}

/// Test that the gap is constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gate {
    /// What decides: both tests together, with what a possible creep leaves open from place to place as part of the noise.
    pub p_value: f64,
    /// The tests alone, against the noise of the repeats.
    pub p_any_shape: f64,
    pub p_slope_and_bow: Option<f64>,
}

/// A joint's half gaps with their statistics; rad or m.
#[derive(Debug, Clone)]
pub struct Summary {
    pub angles: Vec<Angle>,
    pub noise: Noise,
    pub half_gap: f64,
    pub ci95: [f64; 2],
    /// `None` where nothing could be tested.
    pub gate: Option<Gate>,
    /// Scatter expected of a value from the noise inside its dwells alone.
    pub sigma_in_dwell: f64,
    /// Where the readings creep within the dwells: all figures are at rest.
    pub creep: Option<Creep>,
}

impl Summary {
    pub fn varies(&self) -> bool {
        self.gate.is_some_and(|g| g.p_value < ALPHA)
    }

    pub fn places(&self) -> Vec<f64> {
        self.angles.iter().map(|a| a.at).collect()
    }

    pub fn means(&self) -> Vec<f64> {
        self.angles.iter().map(|a| a.mean).collect()
    }

    /// Cycles per place.
    pub fn repeats(&self) -> Vec<f64> {
        self.angles.iter().map(|a| a.cycles.len() as f64).collect()
    }

    /// Number of values.
    pub fn total(&self) -> f64 {
        self.repeats().iter().sum()
    }
}

/// Scatter of a reading: from the cycles where angles have several, else from place to place, else within dwells; `total` is the number
/// of cycles. `None` where nothing tells it.
fn noise(table: &Table, angles: &[Angle], total: f64, sigma_in_dwell: f64) -> Option<Noise> {
    let n = angles.len() as f64;
    let floor = table.rounding.powi(2);
    if total > n {
        let sse: f64 = angles.iter().flat_map(|a| a.cycles.iter().map(|b| (b - a.mean).powi(2))).sum();
        let raw = sse / (total - n);
        // the width of a sensor's count is known, not estimated from these few cycles
        let dof = if table.measured && raw < floor { (total - n).max(KNOWN_DOF) } else { total - n };
        return Some(Noise { variance: raw.max(floor), dof, from: NoiseFrom::Cycles, rounding: raw < floor });
    }
    if n > 1.0 {
        let mean = angles.iter().map(|a| a.mean).sum::<f64>() / n;
        let raw = angles.iter().map(|a| (a.mean - mean).powi(2)).sum::<f64>() / (n - 1.0);
        return Some(Noise { variance: raw.max(floor), dof: n - 1.0, from: NoiseFrom::Places, rounding: raw < floor });
    }
    // degrees of freedom of the scatter are many; this keeps the interval honest where they are few
    let raw = sigma_in_dwell.powi(2);
    let known = sigma_in_dwell > 0.0 || (table.measured && floor > 0.0);
    known.then(|| Noise { variance: raw.max(floor), dof: KNOWN_DOF, from: NoiseFrom::Dwells, rounding: raw < floor })
}

/// Summarises a joint; `None` where no interval is possible at all.
pub fn summarise(table: &Table) -> Option<Summary> {
    let (places, creep) = at_rest(table);
    let mut angles = without_gross_errors(table, &places);
    let n = angles.len() as f64;
    let means: Vec<f64> = angles.iter().map(|a| a.mean).collect();
    let repeats: Vec<f64> = angles.iter().map(|a| a.cycles.len() as f64).collect();
    let total: f64 = repeats.iter().sum();
    let in_dwell: Vec<f64> = table.places.iter().flat_map(|(_, v)| v.iter().map(|h| h.variance_in_dwell)).collect();
    let sigma_in_dwell = median(&in_dwell).sqrt();
    let noise = noise(table, &angles, total, sigma_in_dwell)?;
    let factor = student::factor(0.95, noise.dof);
    // errors that repeats do not show: of the rounding, apart from place to place; of the direction of a dial, one for all
    let common =
        |half_gap: f64, places: f64| (Z95 * table.common_rounding / places.sqrt()).hypot(Z95 * table.tilt * half_gap);
    for (i, (a, r)) in angles.iter_mut().zip(&repeats).enumerate() {
        let of_creep = creep.as_ref().filter(|c| c.applies()).map_or(0.0, |c| Z95 * c.place_variance[i].sqrt());
        a.ci95 = around(a.mean, (factor * (noise.variance / r).sqrt()).hypot(of_creep).hypot(common(a.mean, 1.0)));
    }
    let gate = (noise.from == NoiseFrom::Cycles && noise.dof >= LEAST_DOF && angles.len() > 1).then(|| {
        // what the creep leaves open from place to place is no variation of the gap
        let open = creep.as_ref().map_or(0.0, |c| c.place_variance_apart.iter().sum::<f64>() / (n - 1.0));
        let open = open + table.common_rounding.powi(2);
        let widened = Noise { variance: noise.variance + open * total / n, ..noise };
        let p_value = test(&angles, &means, &repeats, &widened).p_value;
        Gate { p_value, ..test(&angles, &means, &repeats, &noise) }
    });
    let varies = gate.is_some_and(|g| g.p_value < ALPHA);
    let (half_gap, se) = if varies {
        let inverse: f64 = repeats.iter().map(|r| 1.0 / r).sum();
        (means.iter().sum::<f64>() / n, (noise.variance * inverse).sqrt() / n)
    } else {
        (means.iter().zip(&repeats).map(|(y, r)| y * r).sum::<f64>() / total, (noise.variance / total).sqrt())
    };
    let half = (factor * se).hypot(common(half_gap, n));
    let ci95 = match &creep {
        Some(c) if c.applies() => creep::interval(c, half_gap, half / Z95),
        // in doubt the value stays as it was read, and the interval holds both readings of the dwells
        Some(c) => {
            let [lo, hi] = creep::interval(c, half_gap - c.mean_correction(), half / Z95);
            [lo.min(half_gap - half), hi.max(half_gap + half)]
        }
        None => around(half_gap, half),
    };
    // the mean of a skew posterior may lie beyond its quantiles
    let ci95 = [ci95[0].min(half_gap), ci95[1].max(half_gap)];
    let ci95 = table.drift.map_or(ci95, |d| with_drift(ci95, &d));
    Some(Summary { angles, noise, half_gap, ci95, gate, sigma_in_dwell, creep })
}

/// Half gaps by place as they are at rest, and the creep that was taken from them.
fn at_rest(table: &Table) -> (Vec<Vec<f64>>, Option<Creep>) {
    let mut places: Vec<Vec<f64>> = table.places.iter().map(|(_, v)| v.iter().map(|h| h.value).collect()).collect();
    let limit = gross_limit(table, &places);
    let medians: Vec<f64> = places.iter().map(|v| median(v)).collect();
    let mut series = table.series.clone();
    for s in &mut series {
        if (s.mean - medians[s.place]).abs() > limit {
            s.bins.clear(); // a gross error says nothing of the pace
        }
    }
    let creep = creep::estimate(&series, places.len());
    if let Some(c) = creep.as_ref().filter(|c| c.applies()) {
        for (value, correction) in places.iter_mut().flatten().zip(&c.corrections) {
            *value -= correction;
        }
    }
    (places, creep)
}

/// Distance from the median of its place beyond which a value is a gross error. A median of an odd number of values is one of them:
/// its distance is zero by construction and says nothing of the spread (with three cycles a third of all distances would be zero, and a
/// place in seven would lose a sound value).
fn gross_limit(table: &Table, places: &[Vec<f64>]) -> f64 {
    let mut distances: Vec<f64> = Vec::new();
    for place in places {
        let middle = median(place);
        let mut of_place: Vec<f64> = place.iter().map(|b| (b - middle).abs()).collect();
        of_place.sort_unstable_by(f64::total_cmp);
        distances.extend_from_slice(&of_place[of_place.len() % 2..]);
    }
    GROSS * median_of(&mut distances).unwrap_or(0.0).max(table.rounding)
}

/// The interval with and without what a drift adds: whether it is as fast between the approaches as from cycle to cycle is not known.
fn with_drift([lo, hi]: [f64; 2], drift: &Drift) -> [f64; 2] {
    let half = drift.half;
    [lo.min(lo - drift.bias - half), hi.max(hi - drift.bias + half)]
}

fn around(middle: f64, half: f64) -> [f64; 2] {
    [middle - half, middle + half]
}

fn without_gross_errors(table: &Table, places: &[Vec<f64>]) -> Vec<Angle> {
    let limit = gross_limit(table, places);
    table
        .places
        .iter()
        .zip(places)
        .map(|((at, _), all)| {
            let middle = median(all);
            let (kept, dropped): (Vec<f64>, Vec<f64>) = all.iter().partition(|&&b| (b - middle).abs() <= limit);
            let flagged = !dropped.is_empty() && kept.len() < 2;
            let (cycles, dropped) = if flagged { (all.clone(), Vec::new()) } else { (kept, dropped) };
            let mean = cycles.iter().sum::<f64>() / cycles.len().max(1) as f64;
            Angle { at: *at, cycles, dropped, flagged, mean, ci95: [mean; 2] }
        })
        .collect()
}

/// Positions mapped to -1..1.
pub fn mapped(places: &[f64]) -> Vec<f64> {
    let (lo, hi) = (places.first().copied().unwrap_or(0.0), places.last().copied().unwrap_or(0.0));
    places.iter().map(|x| if hi > lo { (2.0 * x - lo - hi) / (hi - lo) } else { 0.0 }).collect()
}

fn test(angles: &[Angle], means: &[f64], repeats: &[f64], noise: &Noise) -> Gate {
    let n = means.len();
    let total: f64 = repeats.iter().sum();
    let grand = means.iter().zip(repeats).map(|(y, r)| y * r).sum::<f64>() / total;
    let between: f64 = means.iter().zip(repeats).map(|(y, r)| r * (y - grand).powi(2)).sum();
    let dof = n as f64 - 1.0;
    let p_any_shape = fisher::tail(between / dof / noise.variance, dof, noise.dof);
    let p_slope_and_bow = (n >= 4).then(|| {
        let u = mapped(&angles.iter().map(|a| a.at).collect::<Vec<_>>());
        let root: Vec<f64> = repeats.iter().map(|r| r.sqrt()).collect();
        let q = DMatrix::from_fn(n, 3, |i, k| root[i] * u[i].powi(k as i32)).qr().q();
        let y = DVector::from_fn(n, |i, _| root[i] * means[i]);
        let explained: f64 = (1..3).map(|k| q.column(k).dot(&y).powi(2)).sum();
        fisher::tail(explained / 2.0 / noise.variance, 2.0, noise.dof)
    });
    let p_value = p_slope_and_bow.map_or(p_any_shape, |q| (2.0 * q.min(p_any_shape)).min(1.0));
    Gate { p_value, p_any_shape, p_slope_and_bow }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    /// Places with as many cycles each of a constant half gap of 1 and noise of a tenth.
    fn table(rng: &mut ChaCha8Rng, places: usize, cycles: usize) -> Table {
        let mut value = |_| HalfGap {
            value: 1.0 + 0.1 * Distribution::<f64>::sample(&StandardNormal, rng),
            variance_in_dwell: 0.0,
        };
        let places = (0..places).map(|p| (p as f64, (0..cycles).map(&mut value).collect())).collect();
        Table {
            axis: 0,
            places,
            rounding: 0.0,
            common_rounding: 0.0,
            tilt: 0.0,
            least_stroke: 1.0,
            unpaired: 0,
            measured: false,
            drift: None,
            series: Vec::new(),
        }
    }

    #[test]
    fn three_cycles_lose_no_sound_value_and_the_interval_covers() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        for (places, cycles) in [(5, 3), (1, 3), (5, 5), (11, 3), (5, 2)] {
            let (runs, mut dropped, mut covered) = (2000, 0, 0);
            for _ in 0..runs {
                let s = summarise(&table(&mut rng, places, cycles)).unwrap();
                dropped += usize::from(s.angles.iter().any(|a| !a.dropped.is_empty()));
                covered += usize::from(s.ci95[0] <= 1.0 && 1.0 <= s.ci95[1]);
            }
            // a normal value lies beyond 8 standard deviations never; few values know their own spread badly
            assert!(dropped <= runs / 50, "{places} x {cycles}: {dropped} of {runs} tables lost a sound value");
            assert!((1870..=1930).contains(&covered), "{places} x {cycles}: {covered} of {runs} intervals cover");
        }
    }

    #[test]
    fn rounding_common_to_the_cycles_of_a_place_is_no_variation_of_the_gap() {
        let mut rng = ChaCha8Rng::seed_from_u64(13);
        let (runs, mut varies, mut covered) = (500, 0, 0);
        for _ in 0..runs {
            let mut t = table(&mut rng, 11, 4);
            t.common_rounding = 1.0;
            for (_, values) in &mut t.places {
                let off: f64 = StandardNormal.sample(&mut rng);
                values.iter_mut().for_each(|h| h.value += off);
            }
            let s = summarise(&t).unwrap();
            varies += usize::from(s.varies());
            covered += usize::from(s.ci95[0] <= 1.0 && 1.0 <= s.ci95[1]);
        }
        assert!(varies <= runs / 100, "{varies} of {runs} vary");
        assert!(covered >= runs * 92 / 100, "{covered} of {runs} cover");
    }

    #[test]
    fn the_direction_of_a_dial_is_in_the_interval() {
        let mut t = table(&mut ChaCha8Rng::seed_from_u64(14), 3, 4);
        t.tilt = 0.2;
        let s = summarise(&t).unwrap();
        assert!(
            s.ci95[1] - s.ci95[0] > 2.0 * Z95 * 0.2 * s.half_gap && s.angles.iter().all(|a| a.ci95[0] < 0.7),
            "{s:?}"
        );
    }

    #[test]
    fn a_gross_error_among_three_cycles_is_left_out() {
        let mut rng = ChaCha8Rng::seed_from_u64(12);
        let mut found = 0;
        for _ in 0..200 {
            let mut t = table(&mut rng, 5, 3);
            t.places[2].1[1].value += 5.0;
            let s = summarise(&t).unwrap();
            found += usize::from(
                s.angles[2].dropped.len() == 1 && s.angles.iter().map(|a| a.dropped.len()).sum::<usize>() == 1,
            );
        }
        assert!(found >= 190, "{found} of 200");
    }
}
