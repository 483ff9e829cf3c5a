//! Each joint's deviation from its command, and half the difference between the two approaches.
//!
//! Method: the projection of the measured point's error onto the tested joint's column of the Jacobian, iterated
//! (Gauss-Newton in one unknown: the place of the joint nearest to the measured point); several reflectors count together.
//! Where the log holds `meas_<joint>`, deviation is `meas - cmd` and no frame is needed. Everything that does not
//! depend on the side of approach cancels in the difference.

use super::creep::series::{DwellSeries, PairSeries};
use super::frame::Frame;
use super::readings::{Pair, Readings};
use super::summary::{HalfGap, Table};
use crate::gaps::note::static_test::{Note, Remark};
use crate::identify::LEAST_LEVER;
use crate::log::Log;
use crate::log::dwells::{Dwell, count};
use crate::machine::measurement::Instrument;
use crate::numerics::robust::median;
use crate::robot::{Chain, JointKind, Robot};
use nalgebra::{Isometry3, Point3, Vector3};
use std::collections::BTreeMap;

/// Rounding in the last digit of a tracker's file (0.1 um): repeats cannot agree better, m.
pub(super) const ROUNDING_M: f64 = 5e-8;
/// Standard deviation that rounding to whole counts gives half the difference of two readings, in counts: `sqrt(1/12) / sqrt(2)`.
const ROUNDING_COUNTS: f64 = 0.204;
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
}

/// Half gap of one pair through the TCP, by the reflectors that both dwells saw.
pub(super) struct Half {
    pub(super) value: f64,
    variance: f64,
    lever: f64,
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
    let variance = if dof > 0.0 { scatter / dof / n / lever2 } else { 0.0 };
    let lever = (lever2 / reflectors).sqrt();
    Some(Deviation { value, lever, samples, sum_squares_m2: sum, variance })
}

/// Commands, half gaps and their readings over time, at one place.
#[derive(Default)]
struct Place {
    at: Vec<f64>,
    values: Vec<HalfGap>,
    series: Vec<Option<(DwellSeries, DwellSeries)>>,
}

/// What the readings of a log are seen through.
struct View<'a> {
    chains: &'a [Chain],
    inverse: Option<&'a Isometry3<f64>>,
    /// Of a log with single readings.
    instrument: Option<&'a Instrument>,
}

/// Half gap of a pair by a single reading (distance, dial), and the sensitivity of the reading to the joint; `None` where the
/// joint hardly changes it.
fn along(chains: &[Chain], instrument: &Instrument, readings: &Readings, pair: &Pair) -> Option<(HalfGap, f64)> {
    let (up, down) = both(readings, pair);
    let (going_up, going_down) = (up.scalar?, down.scalar?);
    let mut columns = vec![Vector3::zeros(); up.command.len()];
    let place = chains.first()?.position_and_jacobian(&up.command, &mut columns);
    let lever = instrument.sensitivity(&place, &columns[pair.axis])[0];
    if lever.abs() < LEAST_LEVER {
        return None;
    }
    let half = HalfGap {
        value: 0.5 * (going_down.mean - going_up.mean) / lever,
        variance_in_dwell: 0.25 * (going_up.variance + going_down.variance) / (lever * lever),
    };
    Some((half, lever))
}

/// Deviation of the joint row by row within a dwell: by its sensor, by a single reading, else by the TCP along the joint's column of the Jacobian.
fn over_time(view: &View, log: &Log, dwell: &Dwell, axis: usize) -> Option<DwellSeries> {
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

/// Half gaps of every pair, as one table per joint; pairs that cannot be read are noted.
pub fn half_gaps(
    robot: &Robot,
    logs: &[Log],
    readings: &mut Readings,
    frame: Option<&Frame>,
    instruments: &[Option<Instrument>],
) -> Vec<Table> {
    let chains = chains(robot, logs);
    let inverse = frame.map(|f| f.found.frame.inverse());
    let mut tables = Vec::new();
    for axis in 0..robot.dof() {
        let joint = robot.axis(axis);
        let mut tested = TestedJoint::new(axis);
        for p in readings.pairs.iter().filter(|p| p.axis == axis) {
            let view = View { chains: &chains, inverse: inverse.as_ref(), instrument: instruments[p.log].as_ref() };
            tested.add(&view, &logs[p.log], readings, p);
        }
        let note = |remark| Note::Joint { joint: joint.name.clone(), remark };
        readings.notes.extend(tested.notes(joint.kind).into_iter().map(note));
        if !tested.places.is_empty() {
            tables.push(tested.table(logs, readings.unpaired[axis]));
        }
    }
    tables
}

/// How a pair is read.
enum Reading {
    /// By the sensor after the joint's gear.
    Joint(HalfGap),
    /// Through the TCP or a single reading, with its lever.
    Lever(HalfGap, f64),
    /// The tracker was lost.
    Lost,
    /// The joint hardly moves what is measured.
    Insensitive,
}

fn read(view: &View, readings: &Readings, pair: &Pair) -> Reading {
    let (up, down) = both(readings, pair);
    if let Some(half) = measured(readings, pair) {
        Reading::Joint(half)
    } else if let Some(instrument) = view.instrument {
        match along(view.chains, instrument, readings, pair) {
            Some((half, lever)) => Reading::Lever(half, lever),
            None if up.scalar.is_some() && down.scalar.is_some() => Reading::Insensitive,
            None => Reading::Lost,
        }
    } else if seen_by_both(view.chains, up, down).contains(&true) {
        match view.inverse.and_then(|inverse| half_gap(view.chains, inverse, readings, pair)) {
            Some(h) => Reading::Lever(HalfGap { value: h.value, variance_in_dwell: h.variance }, h.lever),
            None => Reading::Insensitive,
        }
    } else {
        Reading::Lost
    }
}

/// What the pairs of one joint gave.
struct TestedJoint {
    axis: usize,
    places: BTreeMap<usize, Place>,
    /// Pairs left out.
    lost: usize,
    insensitive: usize,
    by_sensor: usize,
    levers: Vec<f64>,
    least_stroke: f64,
}

impl TestedJoint {
    fn new(axis: usize) -> Self {
        let (places, levers) = (BTreeMap::new(), Vec::new());
        Self { axis, places, lost: 0, insensitive: 0, by_sensor: 0, levers, least_stroke: f64::INFINITY }
    }

    fn add(&mut self, view: &View, log: &Log, readings: &Readings, pair: &Pair) {
        let value = match read(view, readings, pair) {
            Reading::Joint(half) => {
                self.by_sensor += 1;
                half
            }
            Reading::Lever(half, lever) => {
                self.levers.push(lever.abs());
                half
            }
            Reading::Lost => {
                self.lost += 1;
                return;
            }
            Reading::Insensitive => {
                self.insensitive += 1;
                return;
            }
        };
        let (up, down) = both(readings, pair);
        let strokes = [up, down].into_iter().filter_map(|d| d.approach).map(|a| a.stroke);
        self.least_stroke = strokes.fold(self.least_stroke, f64::min);
        let place = self.places.entry(pair.place).or_default();
        place.at.extend([up.command[self.axis], down.command[self.axis]]);
        place.values.push(value);
        let series = |d: &Dwell| over_time(view, log, d, self.axis);
        place.series.push(series(up).zip(series(down)));
    }

    fn notes(&self, kind: JointKind) -> Vec<Remark> {
        let mut notes = Vec::new();
        if self.lost > 0 {
            notes.push(Remark::WithoutReading { pairs: self.lost });
        }
        if self.insensitive > 0 {
            notes.push(Remark::HardlyMoves { kind, least_lever: LEAST_LEVER, pairs: self.insensitive });
        }
        notes
    }

    /// Rounding of a half gap: of the sensor's counts, or of the tracker's file through the lever.
    fn rounding(&self, logs: &[Log]) -> f64 {
        if self.is_by_sensor() {
            let of = |l: &Log| l.meas.get(self.axis).and_then(|c| c.as_deref()).map_or(0.0, count);
            ROUNDING_COUNTS * logs.iter().map(of).fold(0.0, f64::max)
        } else {
            ROUNDING_M / median(&self.levers).max(LEAST_LEVER)
        }
    }

    fn is_by_sensor(&self) -> bool {
        self.levers.is_empty() && self.by_sensor > 0
    }

    fn table(mut self, logs: &[Log], unpaired: usize) -> Table {
        let rounding = self.rounding(logs);
        let series: Option<Vec<PairSeries>> = self
            .places
            .values_mut()
            .enumerate()
            .flat_map(|(i, p)| {
                let series = std::mem::take(&mut p.series);
                series.into_iter().zip(&p.values).map(move |(s, v)| Some((i, v.value, s?)))
            })
            .map(|found| found.map(|(place, value, (up, down))| PairSeries::new(place, value, up, down)))
            .collect();
        let measured = self.is_by_sensor();
        let mean = |at: &[f64]| at.iter().sum::<f64>() / at.len() as f64;
        Table {
            axis: self.axis,
            series: series.unwrap_or_default(),
            places: self.places.into_values().map(|p| (mean(&p.at), p.values)).collect(),
            rounding,
            least_stroke: self.least_stroke,
            unpaired,
            measured,
        }
    }
}
