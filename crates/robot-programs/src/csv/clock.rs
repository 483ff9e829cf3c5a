//! Columns of times: which names are read, and which look like a time that cannot be read.
//!
//! An added row stands between two rows of the program. Its time does, too, so that a time must never be copied: two rows with one time
//! are a jump. `t_s` and other names with a unit are read; a duration (`dt_s`) is split between an added row and the next one, whatever its
//! unit. A name without a unit (`timestamp`) is refused where its cells increase from row to row.

use super::super::Slot;
use super::header::Header;
use super::number;
use super::record::{Record, Seen, content};
use crate::error::{Error, Place, Result};

/// What a name says of time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clock {
    /// It is read.
    Read(Slot),
    /// A time whose unit or form the name does not tell.
    Unclear,
}

/// Names of times and of durations before their unit.
const TIMES: [&str; 5] = ["t", "time", "timestamp", "time_stamp", "elapsed"];
const DURATIONS: [&str; 4] = ["dt", "duration", "delta_t", "delta_time"];
/// Units, and how many of each are one second.
const UNITS: [(&[&str], u32); 4] = [
    (&["s", "sec", "secs", "seconds"], 1),
    (&["ms", "msec", "millis", "milliseconds"], 1_000),
    (&["us", "usec", "micros", "microseconds"], 1_000_000),
    (&["ns", "nsec", "nanos", "nanoseconds"], 1_000_000_000),
];
/// Rows at which an unclear column is looked at.
const LOOKED_AT: usize = 64;

/// What a column's name in lower case says of time; `None`: nothing.
pub fn of_name(low: &str) -> Option<Clock> {
    let words: Vec<&str> = low.split(|c: char| !c.is_alphanumeric()).filter(|w| !w.is_empty()).collect();
    let name = words.join("_");
    let unit = words.last().and_then(|last| UNITS.iter().find(|(names, _)| names.contains(last)));
    let stem = words.split_last().map(|(_, stem)| stem.join("_")).unwrap_or_default();
    match unit {
        Some((_, per_s)) if TIMES.contains(&stem.as_str()) => return Some(Clock::Read(Slot::Time(*per_s))),
        Some(_) if DURATIONS.contains(&stem.as_str()) => return Some(Clock::Read(Slot::Duration)),
        _ => {}
    }
    if DURATIONS.contains(&name.as_str()) {
        return Some(Clock::Read(Slot::Duration));
    }
    let first = words.first()?;
    let unclear = TIMES.contains(&name.as_str()) || (words.len() > 1 && ["time", "timestamp"].contains(first));
    unclear.then_some(Clock::Unclear)
}

/// Refuses a column that looks like a time and increases from row to row, where its name does not say how it is to be read; the rows begin
/// at the place `at` of the text, in `line`.
pub(super) fn refuse_unclear(
    header: &Header,
    (text, at, ended): (&[u8], usize, bool),
    name: &str,
    line: u64,
) -> Result<()> {
    let unclear = |k: &usize| of_name(&header.names[*k].to_lowercase()) == Some(Clock::Unclear);
    for column in (0..header.names.len()).filter(unclear) {
        if increases(&cells(text, at, ended, column)) {
            let found = format!("column `{}`: a time whose unit its name does not tell", header.names[column]);
            let expected = "t_s, t_ms, t_us or t_ns (durations: dt_s): added rows get a time between their neighbours";
            return Err(Error::bad(Place::field(name, line, column as u64 + 1), found, expected));
        }
    }
    Ok(())
}

/// Cells of a column in the first rows.
fn cells(text: &[u8], mut at: usize, ended: bool, column: usize) -> Vec<&[u8]> {
    let mut record = Record::default();
    let mut found = Vec::new();
    while found.len() < LOOKED_AT && at < text.len() {
        if matches!(text[at], b'#' | b'\n' | b'\r') {
            match memchr::memchr2(b'\n', b'\r', &text[at..]) {
                Some(k) => at += k + 1,
                None => break,
            }
            continue;
        }
        if record.find(text, at, ended) != Seen::Whole {
            break;
        }
        let Some(&cell) = record.cells.get(column) else { break };
        let (from, to) = content(text, cell);
        found.push(&text[from..to]);
        if record.end <= at {
            break;
        }
        at = record.end;
    }
    found
}

/// Whether each cell is beyond the one before: as a number, or as text of one length (a date).
fn increases(cells: &[&[u8]]) -> bool {
    let beyond = |pair: &[&[u8]]| match (number::any(pair[0]), number::any(pair[1])) {
        (Some(a), Some(b)) => b.value > a.value,
        (None, None) => pair[0].len() == pair[1].len() && pair[1] > pair[0],
        _ => false,
    };
    cells.len() > 1 && cells.windows(2).all(beyond)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_a_unit_are_times_and_names_without_one_are_unclear() {
        let time = |per_s| Some(Clock::Read(Slot::Time(per_s)));
        for (name, means) in [
            ("t_s", time(1)),
            ("time_s", time(1)),
            ("t_ms", time(1000)),
            ("timestamp_ns", time(1_000_000_000)),
            ("time [us]", time(1_000_000)),
            ("dt_s", Some(Clock::Read(Slot::Duration))),
            ("duration_ms", Some(Clock::Read(Slot::Duration))),
            ("dt", Some(Clock::Read(Slot::Duration))),
            ("timestamp", Some(Clock::Unclear)),
            ("t", Some(Clock::Unclear)),
            ("time_utc", Some(Clock::Unclear)),
            ("tool_s", None),
            ("t_tool", None),
            ("speed_mm_s", None),
            ("times", None),
            ("note", None),
            ("s", None),
        ] {
            assert_eq!(of_name(name), means, "{name}");
        }
    }
}
