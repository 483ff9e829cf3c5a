//! What the pairs of one joint gave: half gaps place by place, with the rounding of their readings.

use super::creep::series::{DwellSeries, PairSeries};
use super::deviation::{ROUNDING_M, Reading, View, both, chains, over_time, read, seen};
use super::drift::{self, Seen};
use super::frame::Frame;
use super::readings::{Pair, Readings};
use super::summary::{HalfGap, Table};
use crate::gaps::note::static_test::{Note, Remark};
use crate::identify::LEAST_LEVER;
use crate::identify::machine::nuisance::TILT_RAD;
use crate::log::Log;
use crate::log::dwells::{Dwell, count};
use crate::machine::measurement::Instrument;
use crate::numerics::robust::median;
use crate::robot::{JointKind, Robot};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Standard deviation that rounding to whole counts gives half the difference of two readings, in counts: `sqrt(1/12) / sqrt(2)`.
const ROUNDING_COUNTS: f64 = 0.204;

/// Commands, half gaps and their readings over time, at one place.
#[derive(Default)]
struct Place {
    at: Vec<f64>,
    values: Vec<HalfGap>,
    series: Vec<Option<(DwellSeries, DwellSeries)>>,
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

/// Step in which the readings of a log are written: of a coordinate of the TCP, or of a single reading, m.
fn step_m(log: &Log) -> f64 {
    let coordinate = |k: usize| count(&log.tcp_m.iter().map(|p| p.map(|p| p[k])).collect::<Vec<_>>());
    if log.tcp_m.is_empty() {
        return log.instruments.scalar().map_or(0.0, count);
    }
    // a coordinate that hardly changes may skip steps
    let steps = (0..3).map(coordinate).filter(|q| *q > 0.0);
    steps.reduce(f64::min).unwrap_or(0.0)
}

/// What the pairs of one joint gave.
struct TestedJoint {
    axis: usize,
    places: BTreeMap<usize, Place>,
    /// Pairs left out.
    lost: usize,
    insensitive: usize,
    across: usize,
    still: usize,
    by_sensor: usize,
    levers: Vec<f64>,
    /// Of the pairs that are read through a lever: `Lever::tilt` and `Lever::of_row_m2`.
    tilts: Vec<f64>,
    of_rows_m2: Vec<f64>,
    least_stroke: f64,
    seen: Vec<Seen>,
}

impl TestedJoint {
    fn new(axis: usize) -> Self {
        Self {
            axis,
            places: BTreeMap::new(),
            lost: 0,
            insensitive: 0,
            across: 0,
            still: 0,
            by_sensor: 0,
            levers: Vec::new(),
            tilts: Vec::new(),
            of_rows_m2: Vec::new(),
            least_stroke: f64::INFINITY,
            seen: Vec::new(),
        }
    }

    fn add(&mut self, view: &View, log: &Log, readings: &Readings, pair: &Pair) {
        let value = match read(view, log, readings, pair) {
            Reading::Joint(half) => {
                self.by_sensor += 1;
                half
            }
            Reading::Lever(half, lever) => {
                self.levers.push(lever.lever.abs());
                self.tilts.push(lever.tilt);
                self.of_rows_m2.push(lever.of_row_m2);
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
            Reading::Across => {
                self.across += 1;
                return;
            }
            Reading::Still => {
                self.still += 1;
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
        let both = series(up).zip(series(down));
        self.seen.extend(both.as_ref().and_then(|both| seen(pair, [up, down], both)));
        place.series.push(both);
    }

    fn notes(&self, kind: JointKind) -> Vec<Remark> {
        let mut notes = Vec::new();
        if self.lost > 0 {
            notes.push(Remark::WithoutReading { pairs: self.lost });
        }
        if self.insensitive > 0 {
            notes.push(Remark::HardlyMoves { kind, least_lever: LEAST_LEVER, pairs: self.insensitive });
        }
        if self.across > 0 {
            notes.push(Remark::AcrossDial { tilt_deg: TILT_RAD.to_degrees(), pairs: self.across });
        }
        if self.still > 0 {
            notes.push(Remark::AtStop { pairs: self.still });
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

    /// Standard deviation of the error that rounding of the readings leaves in a half gap and that all cycles of a place have in common.
    ///
    /// Rounding to steps of `q` leaves an error of `q / sqrt(12)` in the mean of a dwell where its readings do not scatter; scatter of a
    /// standard deviation `s` averages it out: `exp(-2 pi^2 s^2 / q^2)` of it is left (Widrow and Kollar 2008, chapter 4). Half the
    /// difference of two dwells has `1 / sqrt(2)` of it.
    fn common_rounding(&self, logs: &[Log]) -> f64 {
        if self.levers.is_empty() {
            return 0.0;
        }
        let step_m = logs.iter().map(step_m).fold(0.0, f64::max);
        if step_m <= 0.0 {
            return 0.0;
        }
        // the scatter contains the rounding
        let scatter_m2 = (median(&self.of_rows_m2) - step_m * step_m / 12.0).max(0.0);
        let left_m = ROUNDING_COUNTS * step_m * (-2.0 * PI * PI * scatter_m2 / (step_m * step_m)).exp();
        left_m / median(&self.levers).max(LEAST_LEVER)
    }

    fn is_by_sensor(&self) -> bool {
        self.levers.is_empty() && self.by_sensor > 0
    }

    fn table(mut self, logs: &[Log], unpaired: usize) -> Table {
        let rounding = self.rounding(logs);
        let common_rounding = self.common_rounding(logs);
        let tilt = self.tilts.iter().copied().fold(0.0, f64::max);
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
            common_rounding,
            tilt,
            least_stroke: self.least_stroke,
            unpaired,
            measured,
            drift: drift::estimate(&self.seen),
        }
    }
}
