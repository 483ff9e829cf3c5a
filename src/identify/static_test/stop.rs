//! A dial at its stop, or lifted off: it reads, and reads nothing.
//!
//! Method: the rows before a dwell in which the reading is that of the dwell to the last digit. Where the commands of those rows move what
//! the dial touches by more than [`MOVED_M`], the reading does not follow the joint: both dwells of the place would read alike, as without
//! a gap.

use crate::log::Log;
use crate::log::dwells::Dwell;

/// Commanded way of what is measured during which a reading that does not change by a digit is none, m.
const MOVED_M: f64 = 1e-4;

/// Whether the single reading of a log stood still while `axis` moved to a dwell; `lever`: m of the reading per rad or m of the joint.
pub(super) fn stands_still(log: &Log, dwell: &Dwell, axis: usize, lever: f64) -> bool {
    let (Some(column), Some(command)) = (log.instruments.scalar(), log.cmd.get(axis)) else { return false };
    let Some(readings) = column.get(..dwell.rows.end) else { return false };
    let within = &readings[dwell.rows.start.min(readings.len())..];
    let Some(value) = within.iter().flatten().next() else { return false };
    if within.iter().flatten().any(|v| v != value) {
        return false;
    }
    let before = (0..dwell.rows.start).rev().take_while(|&row| readings[row].is_none_or(|v| v == *value));
    let moved = before.filter_map(|row| command.get(row)).map(|c| (c - dwell.command[axis]).abs());
    moved.fold(0.0, f64::max) * lever.abs() > MOVED_M
}
