//! A measurement log: commands and measured TCP positions, as samples of a motion or as settled poses.
//!
//! Modules:
//! - [`columns`]: which column is what: the contract's names (`meaning`), or a column map from foreign names and units.
//! - [`read`]: CSV (and gzip) to [`Log`], with file, line and column of every refusal; `number`: decimal text to f64;
//!   [`text`]: a recording or a sheet as CSV, what each column of it is; `timestamp`: dates and times to microseconds.
//! - [`draft`]: a column map drafted from a header that is not known.
//! - [`maps`]: column maps that ship with the program; [`recording`]: columns of a file that is no whole log, for `join`.
//! - [`mod@write`]: numbers, fields and column names on the way out.
//! - [`plausibility`]: units, axes and clocks that cannot be right, found from the shape of the measured path; `side_columns`:
//!   encoders, speeds and limits that make a reader wonder; `faults`: what is tried; `shape`: robust rigid and mirrored fits, for
//!   plausibility checks.
//! - `prepare`: what every command does with a log first; `held`: readings that rows repeat; `gross`: rows far off the others.
//! - `clock`: measurements by another clock than the commands.
//! - [`mod@note`]: what a reader of a log should know.
//! - `gears`: what the gears turn by, where they turn by sums of axes.
//! - [`instruments`]: channels of other instruments: distance, dial, orientation, torque.
//! - [`dwells`]: where the robot stands still, from which side each joint came, and the mean of the measurements there.
//! - [`registration`]: the tracker's frame from points known in both frames.

#![warn(missing_docs)]

pub(crate) mod clock;
pub mod columns;
pub mod draft;
pub mod dwells;
pub(crate) mod faults;
mod gears;
mod gross;
mod held;
pub mod instruments;
pub mod maps;
mod meaning;
pub mod note;
mod number;
pub mod plausibility;
mod prepare;
pub mod read;
pub mod recording;
pub mod registration;
mod shape;
mod side_columns;
pub mod text;
mod timestamp;
pub mod write;

pub use columns::ColumnMap;
pub use instruments::Instruments;
pub use note::Note;

use crate::numerics::robust::spread;
use crate::robot::Robot;
use nalgebra::Vector3;

/// A log in SI, column by column. Joint columns stand in the order of the robot's axes.
#[derive(Debug, Clone)]
pub struct Log {
    /// File name as messages show it, and SHA-256 of the stored bytes.
    pub name: String,
    /// SHA-256 of the file's bytes, hexadecimal.
    pub sha256: String,
    /// Line in the file of each row, for messages.
    pub line: Vec<u32>,
    /// Times in s, strictly increasing; for settled poses the row number.
    pub t_s: Vec<f64>,
    /// Rows are settled poses in the order visited, not samples of a motion.
    pub poses: bool,
    /// Commands, `cmd[axis][row]`, rad or m.
    pub cmd: Vec<Vec<f64>>,
    /// Decimals with which each command column is written (the most of any row), in deg or mm.
    pub cmd_decimals: Vec<u8>,
    /// Measured TCP in the tracker frame, m; `None` where the tracker lost the reflector. Empty: no such columns.
    pub tcp_m: Vec<Option<Vector3<f64>>>,
    /// Coordinates of a TCP of which not all three were logged, m; only where a log was read for that.
    pub lone_m: [Option<Vec<Option<f64>>>; 3],
    /// Further reflectors, `reflectors_m[k][row]`.
    pub reflectors_m: Vec<Vec<Option<Vector3<f64>>>>,
    /// Encoder (motor side at the joint's scale), rad or m, per axis where logged.
    pub enc: Vec<Option<Vec<Option<f64>>>>,
    /// Between coupling and nut (or gear), at the joint's scale, rad or m, per axis where logged.
    pub screw: Vec<Option<Vec<Option<f64>>>>,
    /// Joint position measured after the gear, rad or m, per axis where logged.
    pub meas: Vec<Option<Vec<Option<f64>>>>,
    /// 1: in a dwell reached by positive movement, -1: by negative, 0: moving.
    pub trigger: Option<Vec<i8>>,
    /// Number of the repeat, 0 outside dwells.
    pub cycle: Option<Vec<u32>>,
    /// TCP speed, m/s, where logged; `None` in empty cells.
    pub speed_m_s: Option<Vec<Option<f64>>>,
    /// Payload, kg, where logged; `None` in empty cells.
    pub payload_kg: Option<Vec<Option<f64>>>,
    /// Temperature, degrees Celsius, where logged; `None` in empty cells.
    pub temp_c: Option<Vec<Option<f64>>>,
    /// Distance, dial, orientation, torque.
    pub instruments: Instruments,
}

impl Log {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.t_s.len()
    }

    /// Whether the log has no rows.
    pub fn is_empty(&self) -> bool {
        self.t_s.is_empty()
    }

    /// Commands of one row into `q` (one value per axis, rad or m).
    pub fn command_into(&self, row: usize, q: &mut [f64]) {
        for (v, column) in q.iter_mut().zip(&self.cmd) {
            *v = column[row];
        }
    }

    /// Commands of one row.
    pub fn command(&self, row: usize) -> Vec<f64> {
        self.cmd.iter().map(|c| c[row]).collect()
    }

    /// Range of the commands of an axis, rad or m.
    pub fn travel(&self, axis: usize) -> f64 {
        spread(self.cmd[axis].iter().copied())
    }

    /// Axes of a robot that move by more than `least` (rad, m).
    pub fn moving(&self, robot: &Robot, least: [f64; 2]) -> Vec<usize> {
        (0..robot.dof()).filter(|&a| self.travel(a) > robot.axis(a).kind.pick(least)).collect()
    }

    /// Axes that move by more than the last digit of their column.
    pub fn moving_axes(&self) -> Vec<usize> {
        (0..self.cmd.len()).filter(|&a| self.travel(a) > 1e-5).collect()
    }
}
