//! Which column is what; the dialects that are refused, each with its reason.

use super::super::Slot;
use super::clock::{self, Clock};
use super::record::{Record, content};
use crate::axes::Axes;
use crate::error::{Error, Place, Result};

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Column {
    /// A number that is read: number of its slot.
    Slot(usize),
    /// Passes through.
    Other,
}

/// The columns of a program, in file order.
#[derive(Debug, Clone)]
pub struct Header {
    /// In the order of the file.
    pub columns: Vec<Column>,
    /// The numbers of a row in the order in which they stand.
    pub slots: Vec<Slot>,
    /// Column names as they are written.
    pub names: Vec<String>,
}

impl Header {
    /// Reads the header row at `record`; `line` stands in messages.
    ///
    /// `header = name {"," name} newline`
    pub fn parse(text: &[u8], record: &Record, robot: &Axes, name: &str, line: u64) -> Result<Self> {
        let names: Vec<String> = record
            .cells
            .iter()
            .map(|&c| content(text, c))
            .map(|(s, e)| String::from_utf8_lossy(&text[s..e]).into_owned())
            .collect();
        let wanted: Vec<String> =
            robot.axis_joints().map(|j| format!("{}_{}", j.name.to_lowercase(), j.kind.unit())).collect();
        let expected = format!("a header row with the columns {}", wanted.join(","));
        let bad = |column: usize, found: String, expected: &str| {
            Error::bad(Place::field(name, line, column as u64 + 1), found, expected)
        };
        if names.len() == 1 && names[0].contains(';') {
            return Err(bad(0, "semicolons between the columns".into(), "commas, and decimal points in the numbers"));
        }
        if names.len() == 1 && names[0].contains('\t') {
            return Err(bad(0, "tabs between the columns".into(), "commas"));
        }
        if names.iter().any(|n| n.parse::<f64>().is_ok()) {
            return Err(bad(0, format!("`{}`", names.join(",")), &expected));
        }
        let mut columns = Vec::with_capacity(names.len());
        let mut slots = Vec::new();
        for (k, n) in names.iter().enumerate() {
            let low = n.to_lowercase();
            let slot = if let Some(Clock::Read(slot)) = clock::of_name(&low) {
                if let (Slot::Time(_), Some(first)) = (slot, slots.iter().position(|s| matches!(s, Slot::Time(_)))) {
                    let first = columns.iter().position(|c| *c == Column::Slot(first)).and_then(|k| names.get(k));
                    let first = first.map_or("t_s", String::as_str);
                    let found = if low == first.to_lowercase() {
                        format!("a second column `{n}`")
                    } else {
                        format!("a second column of times, `{n}` beside `{first}`")
                    };
                    return Err(bad(k, found, "every column once"));
                }
                Some(slot)
            } else if let Some(axis) = wanted.iter().position(|w| *w == low) {
                Some(Slot::Axis(axis))
            } else {
                if let Some(reason) = mistaken(&low, robot) {
                    return Err(bad(k, format!("column `{n}`: {reason}"), &expected));
                }
                None
            };
            columns.push(match slot {
                None => Column::Other,
                Some(s) if slots.contains(&s) => {
                    return Err(bad(k, format!("a second column `{n}`"), "every column once"));
                }
                Some(s) => {
                    slots.push(s);
                    Column::Slot(slots.len() - 1)
                }
            });
        }
        let missing: Vec<&str> = wanted
            .iter()
            .enumerate()
            .filter(|(a, _)| !slots.contains(&Slot::Axis(*a)))
            .map(|(_, w)| w.as_str())
            .collect();
        if !missing.is_empty() {
            let found = format!("no column {}", missing.join(", "));
            return Err(Error::bad(Place::line(name, line), found, expected));
        }
        Ok(Self { columns, slots, names })
    }

    /// Column number (from 1) of a slot, for messages.
    pub fn column_of(&self, slot: usize) -> u64 {
        self.columns.iter().position(|c| *c == Column::Slot(slot)).map_or(0, |k| k as u64 + 1)
    }
}

/// Why a column that looks like a joint's cannot be one.
fn mistaken(low: &str, robot: &Axes) -> Option<String> {
    let joint_of = |n: &str| robot.joints().iter().find(|j| j.name.eq_ignore_ascii_case(n));
    if let Some((stem, unit)) = low.rsplit_once('_')
        && let Some(j) = joint_of(stem)
        && ["deg", "rad", "mm", "m"].contains(&unit)
    {
        return Some(match &j.follows {
            Some(f) => format!("joint {} follows {f} and has no command of its own", j.name),
            None => format!("the targets of joint {} are in {}", j.name, j.kind.unit()),
        });
    }
    if low.strip_prefix("cmd_").and_then(|r| r.rsplit_once('_')).is_some_and(|(stem, _)| joint_of(stem).is_some()) {
        return Some("this is a column of a measurement log, not of a program".into());
    }
    None
}

/// The message for a quote of cell `cell` that does not close.
pub fn quote_error(name: &str, line: u64, cell: usize) -> Error {
    Error::bad(
        Place::field(name, line, cell as u64 + 1),
        "a quote that is not closed, or text after a closing quote",
        "a quoted cell, closed before the comma",
    )
}
