//! Each joint's deviation from its command, and half the difference between the two approaches.
//!
//! Method: the projection of the measured point's error onto the tested joint's column of the Jacobian, iterated
//! (Gauss-Newton in one unknown: the place of the joint nearest to the measured point); several reflectors count together.
//! Where the log holds `meas_<joint>`, deviation is `meas - cmd` and no frame is needed. Everything that does not
//! depend on the side of approach cancels in the difference.

use super::creep::series::DwellSeries;
use super::drift::Seen;
use super::readings::{Pair, Readings};
use super::stop;
use super::summary::HalfGap;
use crate::identify::LEAST_LEVER;
use crate::identify::machine::nuisance::TILT_RAD;
use crate::log::Log;
use crate::log::dwells::Dwell;
use crate::machine::measurement::Instrument;
use crate::numerics::normal::Z95;
use crate::robot::{Chain, Robot};
use nalgebra::{Isometry3, Point3, Vector3};

/// Rounding in the last digit of a tracker's file (0.1 um): repeats cannot agree better, m.
pub(super) const ROUNDING_M: f64 = 5e-8;
/// A step of the one-joint inverse below this (rad or m) ends it.
const SETTLED: f64 = 1e-9;
const ITERATIONS: usize = 20;

/// TCP and the further reflectors that both robot file and logs know.
pub(super) fn chains(robot: &Robot, logs: &[Log]) -> Vec<Chain> {
    let further = logs.iter().map(|l| l.reflectors_m.len()).max().unwrap_or(0);
    std::iter::once(robot.chain().clone())
        .chain(robot.reflectors_m.iter().take(further).map(|p| robot.chain_to(p)))
        .collect()
}

pub(super) fn both<'a>(readings: &'a Readings, pair: &Pair) -> (&'a Dwell, &'a Dwell) {
    let found = &readings.dwells[pair.log];
    (&found[pair.up], &found[pair.down])
}

pub(super) fn point(dwell: &Dwell, k: usize) -> Option<Vector3<f64>> {
    dwell.points.get(k)?.map(|p| p.mean)
}

/// Half gap of a pair whose joint was measured after its gear.
pub(super) fn measured(readings: &Readings, pair: &Pair) -> Option<HalfGap> {
    let (up, down) = both(readings, pair);
    let of = |d: &Dwell| d.meas.get(pair.axis).copied().flatten();
    let (going_up, going_down) = (of(up)?, of(down)?);
    let deviation = |m: f64, d: &Dwell| m - d.command[pair.axis];
    Some(HalfGap {
        value: 0.5 * (deviation(going_down.mean, down) - deviation(going_up.mean, up)),
        variance_in_dwell: 0.25 * (going_up.variance + going_down.variance),
    })
}

/// Deviation of one joint in one dwell.
pub(super) struct Deviation {
    value: f64,
    /// m per rad, or m per m.
    lever: f64,
    pub(super) samples: usize,
    pub(super) sum_squares_m2: f64,
    /// Variance of the mean of the dwell, as a joint value.
    variance: f64,
    /// Variance of a coordinate of a row, m^2.
    of_row_m2: f64,
}

/// Half gap of one pair through the TCP, by the reflectors that both dwells saw.
pub(super) struct Half {
    pub(super) value: f64,
    variance: f64,
    lever: f64,
    /// Variance of a coordinate of a row, m^2.
    of_row_m2: f64,
}

/// Reflectors that both dwells of a pair saw.
fn seen_by_both(chains: &[Chain], up: &Dwell, down: &Dwell) -> Vec<bool> {
    (0..chains.len()).map(|k| point(up, k).is_some() && point(down, k).is_some()).collect()
}

/// Half the difference between the two approaches: reached going up the joint stands half a gap below its command, going
/// down half a gap above.
pub(super) fn half_gap(chains: &[Chain], inverse: &Isometry3<f64>, readings: &Readings, pair: &Pair) -> Option<Half> {
    let (up, down) = both(readings, pair);
    let mask = seen_by_both(chains, up, down);
    let going_up = deviation(chains, inverse, up, pair.axis, &mask)?;
    let going_down = deviation(chains, inverse, down, pair.axis, &mask)?;
    Some(Half {
        value: 0.5 * (going_down.value - going_up.value),
        variance: 0.25 * (going_up.variance + going_down.variance),
        lever: going_up.lever,
        of_row_m2: 0.5 * (going_up.of_row_m2 + going_down.of_row_m2),
    })
}

/// How far joint `axis` stands from its command, by the reflectors of `mask`.
pub(super) fn deviation(
    chains: &[Chain],
    inverse: &Isometry3<f64>,
    dwell: &Dwell,
    axis: usize,
    mask: &[bool],
) -> Option<Deviation> {
    let mut q = dwell.command.clone();
    let mut columns = vec![Vector3::zeros(); q.len()];
    let used = |k: usize| mask[k].then(|| dwell.points.get(k).copied().flatten()).flatten();
    let (mut value, mut lever2) = (0.0, 0.0);
    for _ in 0..ITERATIONS {
        let (mut along, mut count) = (0.0, 0usize);
        lever2 = 0.0;
        for (k, chain) in chains.iter().enumerate() {
            let Some(p) = used(k) else { continue };
            let error = (inverse * Point3::from(p.mean)).coords - chain.position_and_jacobian(&q, &mut columns);
            along += error.dot(&columns[axis]);
            lever2 += columns[axis].norm_squared();
            count += 1;
        }
        if count == 0 || lever2 / (count as f64) < LEAST_LEVER.powi(2) {
            return None;
        }
        let step = along / lever2;
        value += step;
        q[axis] += step;
        if step.abs() < SETTLED {
            break;
        }
    }
    let (mut sum, mut samples, mut scatter) = (0.0, 0usize, 0.0);
    for (k, chain) in chains.iter().enumerate() {
        let Some(p) = used(k) else { continue };
        let error = (inverse * Point3::from(p.mean)).coords - chain.position(&q);
        sum += p.sum_squares + p.used as f64 * error.norm_squared();
        samples += p.used;
        scatter += p.sum_squares;
    }
    let reflectors = mask.iter().filter(|&&m| m).count().max(1) as f64;
    let (n, dof) = (samples as f64 / reflectors, 3.0 * (samples as f64 - reflectors));
    let of_row_m2 = if dof > 0.0 { scatter / dof } else { 0.0 };
    let variance = of_row_m2 / n / lever2;
    let lever = (lever2 / reflectors).sqrt();
    Some(Deviation { value, lever, samples, sum_squares_m2: sum, variance, of_row_m2 })
}

/// What the readings of a log are seen through.
pub(super) struct View<'a> {
    pub(super) chains: &'a [Chain],
    pub(super) inverse: Option<&'a Isometry3<f64>>,
    /// Of a log with single readings.
    pub(super) instrument: Option<&'a Instrument>,
}

/// Half gap of a pair by a single reading (distance, dial), with the sensitivity of the reading to the joint.
fn along(chains: &[Chain], instrument: &Instrument, readings: &Readings, pair: &Pair) -> Reading {
    let (up, down) = both(readings, pair);
    let (Some(going_up), Some(going_down), Some(chain)) = (up.scalar, down.scalar, chains.first()) else {
        return Reading::Lost;
    };
    let mut columns = vec![Vector3::zeros(); up.command.len()];
    let place = chain.position_and_jacobian(&up.command, &mut columns);
    let column = columns[pair.axis];
    let lever = instrument.sensitivity(&place, &column)[0];
    if lever.abs() < LEAST_LEVER {
        return Reading::Insensitive;
    }
    // a dial stands along its direction by hand: what the joint moves across it is read in part
    let across = match instrument {
        Instrument::Direction { .. } => (column.norm_squared() - lever * lever).max(0.0).sqrt(),
        _ => 0.0,
    };
    let tilt = TILT_RAD * across / lever.abs();
    if Z95 * tilt >= 1.0 {
        return Reading::Across;
    }
    let half = HalfGap {
        value: 0.5 * (going_down.mean - going_up.mean) / lever,
        variance_in_dwell: 0.25 * (going_up.variance + going_down.variance) / (lever * lever),
    };
    let rows = (up.rows.len() + down.rows.len()) as f64 / 2.0;
    Reading::Lever(half, Lever { lever, tilt, of_row_m2: 0.5 * rows * (going_up.variance + going_down.variance) })
}

/// Deviation of the joint row by row within a dwell: by its sensor, by a single reading, else by the TCP along the joint's column of the
/// Jacobian.
pub(super) fn over_time(view: &View, log: &Log, dwell: &Dwell, axis: usize) -> Option<DwellSeries> {
    if let Some(column) = log.meas.get(axis).and_then(|c| c.as_deref()) {
        return DwellSeries::new(log, dwell, |row| Some(column[row]? - dwell.command[axis]));
    }
    let mut columns = vec![Vector3::zeros(); dwell.command.len()];
    let chain = view.chains.first()?;
    let place = chain.position_and_jacobian(&dwell.command, &mut columns);
    if let Some(instrument) = view.instrument {
        let lever = instrument.sensitivity(&place, &columns[axis])[0];
        let column = log.instruments.scalar()?;
        return DwellSeries::new(log, dwell, |row| Some(column[row]? / lever));
    }
    let inverse = view.inverse?;
    let along = columns[axis] / columns[axis].norm_squared().max(LEAST_LEVER * LEAST_LEVER);
    DwellSeries::new(log, dwell, |row| {
        let p = (*log.tcp_m.get(row)?)?;
        Some(((inverse * Point3::from(p)).coords - place).dot(&along))
    })
}

/// The two approaches of a pair over time.
pub(super) fn seen(pair: &Pair, dwells: [&Dwell; 2], series: &(DwellSeries, DwellSeries)) -> Option<Seen> {
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64, s: &DwellSeries| {
        s.samples.iter().map(of).sum::<f64>() / s.samples.len() as f64
    };
    let at = |s: &DwellSeries, d: &Dwell| Some(d.approach?.stopped_s + mean(&|s| s.0, s));
    let (up_s, down_s) = (at(&series.0, dwells[0])?, at(&series.1, dwells[1])?);
    let middle = 0.5 * (mean(&|s| s.1, &series.0) + mean(&|s| s.1, &series.1));
    Some(Seen { group: (pair.log << 32) | pair.place, middle, at_s: 0.5 * (up_s + down_s), later_s: down_s - up_s })
}

/// How a pair is read.
pub(super) enum Reading {
    /// By the sensor after the joint's gear.
    Joint(HalfGap),
    /// Through the TCP or a single reading.
    Lever(HalfGap, Lever),
    /// The tracker was lost.
    Lost,
    /// The joint hardly moves what is measured.
    Insensitive,
    /// The joint moves across the direction of the dial.
    Across,
    /// The reading does not change while the joint moves.
    Still,
}

/// How the joint moves what is measured.
pub(super) struct Lever {
    /// m per rad, or m per m.
    pub(super) lever: f64,
    /// Standard deviation of the half gap by the direction of a dial, as a share of it.
    pub(super) tilt: f64,
    /// Variance of a reading, or of a coordinate, within a dwell, m^2.
    pub(super) of_row_m2: f64,
}

pub(super) fn read(view: &View, log: &Log, readings: &Readings, pair: &Pair) -> Reading {
    let (up, down) = both(readings, pair);
    if let Some(half) = measured(readings, pair) {
        Reading::Joint(half)
    } else if let Some(instrument) = view.instrument {
        match along(view.chains, instrument, readings, pair) {
            Reading::Lever(_, l) if [up, down].iter().any(|d| stop::stands_still(log, d, pair.axis, l.lever)) => {
                Reading::Still
            }
            other => other,
        }
    } else if seen_by_both(view.chains, up, down).contains(&true) {
        match view.inverse.and_then(|inverse| half_gap(view.chains, inverse, readings, pair)) {
            Some(h) => Reading::Lever(
                HalfGap { value: h.value, variance_in_dwell: h.variance },
                Lever { lever: h.lever, tilt: 0.0, of_row_m2: h.of_row_m2 },
            ),
            None => Reading::Insensitive,
        }
    } else {
        Reading::Lost
    }
}
