//! The rows of a joined log.
//!
//! Readings are never smoothed. With the tracker's rows, readings are written with the digits that they had, and joint positions
//! are interpolated by [`Series`], which keeps reversals; with the controller's rows, commands are written as they were, and
//! readings stand on the straight line between two neighbours, unless these are farther apart than [`LOST`] rows. Torque, speed
//! and temperature stand on straight lines; `trigger` and `cycle` hold only between two samples that agree.

use super::Rows;
use super::clock::Clock;
use super::fit::Fit;
use crate::log::columns::Meaning;
use crate::log::recording::{Channel, Recording, si_per_unit};
use crate::log::write::number;
use crate::numerics::robust::median_interval;
use crate::numerics::series::Series;
use crate::robot::Robot;

/// Neighbours farther apart than this many median periods have lost readings between them.
const LOST: f64 = 2.5;
/// Least digits of an interpolated value: 1 nm, 0.0036 arc seconds.
const DIGITS: u8 = 6;

/// Columns in the units of the contract; a NaN is an empty cell.
#[derive(Debug, Clone)]
pub struct Table {
    columns: Vec<Column>,
}

#[derive(Debug, Clone)]
struct Column {
    name: String,
    meaning: Meaning,
    values: Vec<f64>,
    decimals: u8,
}

impl Table {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |c| c.values.len())
    }

    /// Rows in which the tracker lost the reflector.
    pub fn rows_without_reading(&self) -> usize {
        let x = self.columns.iter().find(|c| c.meaning == Meaning::Position { k: 0, coordinate: 0 });
        x.map_or(0, |c| c.values.iter().filter(|v| v.is_nan()).count())
    }

    /// The log as CSV.
    pub fn to_csv(&self) -> Vec<u8> {
        let mut out = Vec::with_capacity(self.rows() * self.columns.len() * 10);
        let names: Vec<&str> = self.columns.iter().map(|c| c.name.as_str()).collect();
        out.extend_from_slice(names.join(",").as_bytes());
        out.push(b'\n');
        for row in 0..self.rows() {
            for (k, column) in self.columns.iter().enumerate() {
                if k > 0 {
                    out.push(b',');
                }
                let value = column.values[row];
                if value.is_finite() {
                    number(&mut out, value, column.decimals);
                }
            }
            out.push(b'\n');
        }
        out
    }
}

/// What interpolates a column.
#[derive(PartialEq)]
enum Between {
    /// Joint positions: see [`Series`].
    Monotone,
    Line,
    /// Only where both neighbours agree.
    Agreed,
}

fn between(meaning: Meaning) -> Between {
    match meaning {
        Meaning::Command(_) | Meaning::Encoder(_) | Meaning::Screw(_) | Meaning::Measured(_) => Between::Monotone,
        Meaning::Trigger | Meaning::Cycle => Between::Agreed,
        _ => Between::Line,
    }
}

/// Whether a column belongs to the controller where both files have it.
fn of_controller(meaning: Meaning) -> bool {
    matches!(
        meaning,
        Meaning::Command(_)
            | Meaning::Encoder(_)
            | Meaning::Torque(_)
            | Meaning::Force(_)
            | Meaning::Trigger
            | Meaning::Cycle
            | Meaning::Speed
    )
}

/// The joined columns: time of the controller, joints, readings, the rest.
pub(super) fn table(
    robot: &Robot,
    controller: &Recording,
    tracker: &Recording,
    ours: &Clock,
    theirs: &Clock,
    fit: &Fit,
    rows: Rows,
) -> Table {
    let tracker_s: Vec<f64> = theirs.t_s.iter().map(|t| fit.controller_s(*t)).collect();
    let (base, other, base_s, other_s) = match rows {
        Rows::Tracker => (tracker, controller, &tracker_s, &ours.t_s),
        Rows::Controller => (controller, tracker, &ours.t_s, &tracker_s),
    };
    let span = other_s[0]..=other_s[other_s.len() - 1];
    let kept: Vec<usize> = (0..base_s.len()).filter(|&i| span.contains(&base_s[i])).collect();
    let at: Vec<f64> = kept.iter().map(|&i| base_s[i]).collect();
    let mut columns = vec![Column { name: "t_s".into(), meaning: Meaning::Time, values: at.clone(), decimals: DIGITS }];
    let base_is_controller = rows == Rows::Controller;
    let wanted = |c: &Channel, from_controller: bool, other: &Recording| {
        !matches!(c.meaning, Meaning::Time | Meaning::Index | Meaning::Other)
            && (other.values(c.meaning).is_none() || of_controller(c.meaning) == from_controller)
    };
    for c in base.channels.iter().filter(|c| wanted(c, base_is_controller, other)) {
        let per_unit = si_per_unit(c.meaning, robot);
        let values = kept.iter().map(|&i| c.values[i] / per_unit).collect();
        columns.push(Column { name: c.meaning.name(robot), meaning: c.meaning, values, decimals: c.decimals });
    }
    let period = median_interval(other_s).unwrap_or(0.0);
    for c in other.channels.iter().filter(|c| wanted(c, !base_is_controller, base)) {
        let per_unit = si_per_unit(c.meaning, robot);
        let values = resampled(c, other_s, &at, period).into_iter().map(|v| v / per_unit).collect();
        let decimals = if between(c.meaning) == Between::Agreed { 0 } else { c.decimals.max(DIGITS) };
        columns.push(Column { name: c.meaning.name(robot), meaning: c.meaning, values, decimals });
    }
    columns.sort_by_key(|c| order(c.meaning));
    Table { columns }
}

/// Place of a column: time, commands, encoders, readings, the rest.
fn order(meaning: Meaning) -> (u8, usize) {
    match meaning {
        Meaning::Time => (0, 0),
        Meaning::Command(a) => (1, a),
        Meaning::Encoder(a) => (2, a),
        Meaning::Screw(a) => (3, a),
        Meaning::Measured(a) => (4, a),
        Meaning::Position { k, coordinate } => (5, 3 * k + coordinate),
        Meaning::Orientation(part) => (6, part),
        Meaning::Torque(a) => (7, a),
        Meaning::Force(part) => (8, part),
        _ => (9, 0),
    }
}

fn resampled(c: &Channel, t_s: &[f64], at: &[f64], period: f64) -> Vec<f64> {
    let how = between(c.meaning);
    if how == Between::Monotone {
        let series = Series::new(t_s.to_vec(), vec![c.values.clone()], &[0.0]);
        let (mut v, mut rate) = ([f64::NAN], [0.0]);
        return at.iter().map(|t| if series.at(*t, &mut v, &mut rate) { v[0] } else { f64::NAN }).collect();
    }
    at.iter()
        .map(|t| {
            let k = t_s.partition_point(|v| v <= t).clamp(1, t_s.len() - 1) - 1;
            let (a, b) = (c.values[k], c.values[k + 1]);
            let gap = t_s[k + 1] - t_s[k];
            match how {
                Between::Agreed => {
                    if a == b {
                        a
                    } else {
                        0.0
                    }
                }
                _ if gap > LOST * period => f64::NAN,
                _ => a + (b - a) * ((t - t_s[k]) / gap).clamp(0.0, 1.0),
            }
        })
        .collect()
}
