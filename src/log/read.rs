//! CSV (gzipped or not) and sheets of workbooks to a [`Log`].
//!
//! Method: the body is cut at line ends into pieces of about 1 MiB, which are parsed side by side and put together in
//! order, so that neither the result nor the first refusal depends on the number of threads.
//!
//! How it fails: on the first row that is not what the header promises, with line and field.
//!
//! Parts:
//! - [`head`]: separator and header row, and what a file is that is no log.
//! - [`mod@table`]: the rows as numbers.
//! - [`mod@build`]: the columns of the table, put together as a [`Log`].

mod build;
mod head;
mod table;

use super::Log;
use super::columns::{Column, ColumnMap, Meaning};
use super::text::LogText;
use crate::error::{Error, Place, Result};
use crate::io::bag::TopicChoice;
use crate::io::input::{self, Input};
use crate::robot::Robot;
use build::build;
pub(crate) use head::{Head, reader};
use robot_programs::error::in_few_digits;
use std::path::Path;
use table::Layout;
pub(super) use table::Table;

/// Samples closer than this are not two, s: speeds between them would be rounding, or not even numbers.
const CLOSEST_S: f64 = 1e-9;

impl Log {
    /// Reads a log with the contract's column names.
    pub fn load(path: &Path, robot: &Robot) -> Result<Self> {
        Self::load_with(path, robot, None)
    }

    /// Reads a log, through a column map where one is given.
    pub fn load_with(path: &Path, robot: &Robot, map: Option<&ColumnMap>) -> Result<Self> {
        Self::parse_any(input::read(path)?, robot, map, false)
    }

    /// Reads a log of which the tracker may have written one or two coordinates only ([`Log::lone_m`]).
    pub fn load_lone(path: &Path, robot: &Robot, map: Option<&ColumnMap>) -> Result<Self> {
        Self::parse_any(input::read(path)?, robot, map, true)
    }

    /// Parses the bytes of a log with the contract's column names.
    pub fn parse(input: Input, robot: &Robot) -> Result<Self> {
        Self::parse_with(input, robot, None)
    }

    /// Parses the bytes of a log, through a column map where one is given.
    pub fn parse_with(input: Input, robot: &Robot, map: Option<&ColumnMap>) -> Result<Self> {
        Self::parse_any(input, robot, map, false)
    }

    fn parse_any(input: Input, robot: &Robot, map: Option<&ColumnMap>, lone: bool) -> Result<Self> {
        let text = LogText::of(input, robot, map, TopicChoice::Any)?;
        let (table, columns) = Self::table(&text, robot, lone)?;
        let Input { name, sha256, .. } = text.input; // its bytes are no longer held
        Self::of_table(&name, sha256, table, &columns, robot)
    }

    /// The log that a text is.
    pub(super) fn of_text(text: &LogText, robot: &Robot) -> Result<Self> {
        let (table, columns) = Self::table(text, robot, false)?;
        Self::of_table(&text.input.name, text.input.sha256.clone(), table, &columns, robot)
    }

    fn table(text: &LogText, robot: &Robot, lone: bool) -> Result<(Table, Vec<Column>)> {
        let name = &text.input.name;
        table(text, robot, |head, columns, separator| head.check(name, columns, robot, separator, lone))
    }

    fn of_table(name: &str, sha256: String, table: Table, columns: &[Column], robot: &Robot) -> Result<Self> {
        let log = build(name, sha256, table, columns, robot)?;
        log.check_time(columns)?;
        Ok(log)
    }

    fn check_time(&self, columns: &[Column]) -> Result<()> {
        if self.poses {
            return Ok(());
        }
        let close = |w: &[f64]| w[1] - w[0] < CLOSEST_S;
        let Some(i) = self.t_s.windows(2).position(close) else { return Ok(()) };
        let numbers = (self.t_s[i], self.t_s[i + 1]);
        let (before, t) = (in_few_digits(numbers.0), in_few_digits(numbers.1));
        let found = match numbers.1.total_cmp(&numbers.0) {
            std::cmp::Ordering::Equal => format!("time {t} s twice"),
            std::cmp::Ordering::Less => format!("time {t} s after {before} s"),
            std::cmp::Ordering::Greater => format!("times {before} s and {t} s, which are too close to distinguish"),
        };
        let place = Place {
            file: self.name.clone(),
            line: Some(u64::from(self.line[i + 1])),
            column: columns.iter().find(|c| c.meaning == Meaning::Time).map(|c| c.index as u64 + 1),
        };
        Err(Error::bad(place, found, "times that strictly increase"))
    }
}

/// The used columns of a file as written, once `check` has accepted them.
pub(super) fn table(
    text: &LogText,
    robot: &Robot,
    check: impl FnOnce(&Head, &[Column], u8) -> Result<()>,
) -> Result<(Table, Vec<Column>)> {
    let Input { name, bytes, .. } = &text.input;
    let separator = text.separator;
    let (head, columns) = text.columns(robot)?;
    check(&head, &columns, separator)?;
    let layout = Layout { name, head: &head, columns: &columns, separator, decimal: text.decimal };
    let table = layout.read(bytes)?;
    if table.line.is_empty() {
        return Err(Error::bad(Place::file(name), "a header and no rows", "at least one row"));
    }
    Ok((table, columns))
}
