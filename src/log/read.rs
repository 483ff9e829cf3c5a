//! CSV (gzipped or not) and sheets of workbooks to a [`Log`].
//!
//! Method: the body is cut at line ends into pieces of about 1 MiB, which are parsed side by side and put together in
//! order, so that neither the result nor the first refusal depends on the number of threads.
//!
//! How it fails: on the first row that is not what the header promises, with line and field.
//!
//! Parts:
//! - [`head`]: separator and header row, and what a file is that is no log.
//! - [`mod@build`]: the columns of the table, put together as a [`Log`].

mod build;
mod head;

use super::Log;
use super::columns::{Column, ColumnMap, Meaning, Missing};
use super::number::{decimals, number};
use super::text::LogText;
use super::timestamp::Stamp;
use crate::error::{Error, Place, Result};
use crate::io::bag::TopicChoice;
use crate::io::input::{self, Input};
use crate::numerics::parallel::ParMap;
use crate::robot::Robot;
use build::build;
pub(crate) use head::Head;
use robot_programs::error::in_few_digits;
use std::ops::Range;
use std::path::Path;

/// Bytes of a piece; fixed, so that the cuts do not depend on the machine.
const PIECE: usize = 1 << 20;
/// Largest command (deg or mm) and coordinate (mm): beyond it a cell is damaged, and squares would lose their digits.
const LARGEST: f64 = 1e7;
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

pub(crate) fn reader(bytes: &[u8], separator: u8) -> csv::Reader<&[u8]> {
    csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .delimiter(separator)
        .buffer_capacity(1 << 16)
        .from_reader(bytes)
}

/// Blank lines and comments where a record begins: the reader passes over them without counting.
fn passed_over(bytes: &[u8], from: u64) -> u64 {
    let mut lines = 0;
    let mut rest = bytes.get(from as usize..).unwrap_or_default();
    while let Some(end) = memchr::memchr(b'\n', rest) {
        if rest[0] != b'#' && !matches!(rest[..end], [] | [b'\r']) {
            break;
        }
        lines += 1;
        rest = &rest[end + 1..];
    }
    lines
}

/// How the rows are to be read.
struct Layout<'a> {
    name: &'a str,
    head: &'a Head,
    columns: &'a [Column],
    separator: u8,
    decimal: u8,
}

/// Numbers of the used columns as written; an empty cell, where allowed, is NaN (a written NaN is refused).
pub(super) struct Table {
    pub(super) line: Vec<u32>,
    pub(super) values: Vec<Vec<f64>>,
    pub(super) decimals: Vec<u8>,
}

impl Layout<'_> {
    fn read(&self, bytes: &[u8]) -> Result<Table> {
        let cuts = self.cuts(bytes);
        let last = cuts.len().saturating_sub(1);
        let pieces = (0..cuts.len()).par_map(|i| {
            let (range, line) = &cuts[i];
            self.piece(&bytes[range.clone()], *line, i == last)
        });
        let pieces = pieces.into_iter().collect::<Result<Vec<Table>>>()?;
        let rows = pieces.iter().map(|p| p.line.len()).sum();
        let n = self.columns.len();
        let mut whole = Table { line: Vec::with_capacity(rows), values: Vec::with_capacity(n), decimals: vec![0; n] };
        whole.values.resize_with(n, || Vec::with_capacity(rows));
        for piece in pieces {
            whole.line.extend_from_slice(&piece.line);
            for (to, from) in whole.values.iter_mut().zip(&piece.values) {
                to.extend_from_slice(from);
            }
            for (to, from) in whole.decimals.iter_mut().zip(&piece.decimals) {
                *to = (*to).max(*from);
            }
        }
        Ok(whole)
    }

    /// Ranges of the body that end at line ends, with the number of their first line. A file with quotes stays whole: a
    /// line end may stand inside them.
    fn cuts(&self, bytes: &[u8]) -> Vec<(Range<usize>, u64)> {
        let mut cuts = Vec::new();
        let (mut start, mut line) = (self.head.body.min(bytes.len()), self.head.body_line);
        let whole = memchr::memchr(b'"', &bytes[start..]).is_some();
        while start < bytes.len() {
            let from = start + PIECE;
            let end = if whole || from >= bytes.len() {
                bytes.len()
            } else {
                memchr::memchr(b'\n', &bytes[from..]).map_or(bytes.len(), |k| from + k + 1)
            };
            cuts.push((start..end, line));
            line += memchr::memchr_iter(b'\n', &bytes[start..end]).count() as u64;
            start = end;
        }
        cuts
    }

    fn piece(&self, bytes: &[u8], first_line: u64, last: bool) -> Result<Table> {
        let n = self.columns.len();
        let guess = bytes.len() / (8 * self.head.names.len()).max(1);
        let mut table = Table { line: Vec::with_capacity(guess), values: Vec::with_capacity(n), decimals: vec![0; n] };
        table.values.resize_with(n, || Vec::with_capacity(guess));
        let mut reader = reader(bytes, self.separator);
        let mut record = csv::ByteRecord::new();
        loop {
            match reader.read_byte_record(&mut record) {
                Ok(true) => {}
                Ok(false) => return Ok(table),
                Err(e) => return Err(Error::bad(Place::file(self.name), e.to_string(), "CSV")),
            }
            let line = record.position().map_or(0, |p| p.line() + passed_over(bytes, p.byte())) + first_line - 1;
            if record.len() != self.head.names.len() {
                if record.len() == 1 && record[0].trim_ascii().is_empty() {
                    continue; // a line of blanks
                }
                let at_end =
                    last && record.len() < self.head.names.len() && reader.position().byte() as usize >= bytes.len();
                return Err(self.ragged(line, record.len(), at_end));
            }
            table.line.push(line as u32);
            for ((column, values), decimals) in self.columns.iter().zip(&mut table.values).zip(&mut table.decimals) {
                let text = &record[column.index];
                let (value, places) = match number(text, self.decimal) {
                    Some(n) if column.stamp.is_none() && column.missing.is_empty() => n,
                    _ => self.cell(line, column, text)?,
                };
                values.push(self.in_range(line, column, value)?);
                *decimals = (*decimals).max(places);
            }
        }
    }

    fn ragged(&self, line: u64, fields: usize, at_end: bool) -> Error {
        let found = format!(
            "{fields} field{}{}",
            if fields == 1 { "" } else { "s" },
            if at_end { " in the last row: the file is cut short" } else { "" }
        );
        Error::bad(
            Place::line(self.name, line),
            found,
            format!("{}, as in the header", crate::error::counted(self.head.names.len(), "field")),
        )
    }

    fn bad(&self, line: u64, column: &Column, found: String, expected: &str) -> Error {
        let place = Place::field(self.name, line, column.index as u64 + 1);
        Error::bad(place, format!("{found} in column `{}`", self.head.names[column.index]), expected)
    }

    /// A cell that is no plain short number: empty or missing, a date, long, with an exponent, or wrong.
    fn cell(&self, line: u64, column: &Column, text: &[u8]) -> Result<(f64, u8)> {
        let text = text.trim_ascii();
        let empty = |found: &str| match column.meaning {
            Meaning::Time | Meaning::Command(_) | Meaning::Trigger | Meaning::Cycle => {
                Err(self.bad(line, column, found.into(), "a finite number"))
            }
            _ => Ok((f64::NAN, 0)),
        };
        if text.is_empty() {
            return empty("an empty cell");
        }
        if column.missing.iter().any(|m| self.is_missing(m, text)) {
            return empty(&format!("a missing value (`{}`)", String::from_utf8_lossy(text)));
        }
        if column.stamp.is_some() || column.meaning == Meaning::Time {
            let plain = std::str::from_utf8(text).unwrap_or("");
            if let Some(us) = column.stamp.and_then(|s| s.microseconds(plain)) {
                return Ok((us, 0));
            }
            let other = Stamp::reading(std::iter::once(plain)).next().map_or(String::new(), |s| {
                format!(
                    "; a column map with `unit: {}` for this column reads this cell (`lostmotion columns` drafts it)",
                    s.unit()
                )
            });
            let expected = column.stamp.map(Stamp::expected).or((!other.is_empty()).then_some("a number of seconds"));
            if let Some(expected) = expected {
                let found = format!("`{}`", String::from_utf8_lossy(text));
                return Err(self.bad(line, column, found, &format!("{expected}{other}")));
            }
        }
        let expected = if self.decimal == b',' {
            "a finite number with a decimal comma"
        } else {
            "a finite number with a decimal point"
        };
        let bad = || self.bad(line, column, format!("`{}`", String::from_utf8_lossy(text)), expected);
        let plain = std::str::from_utf8(text).map_err(|_| bad())?;
        let plain = match self.decimal {
            b'.' => std::borrow::Cow::Borrowed(plain),
            _ if plain.contains('.') => return Err(bad()),
            d => plain.replace(d as char, ".").into(),
        };
        match plain.parse::<f64>() {
            Ok(v) if v.is_finite() => Ok((v, decimals(plain.as_bytes()))),
            _ => Err(bad()),
        }
    }

    fn is_missing(&self, missing: &Missing, text: &[u8]) -> bool {
        std::str::from_utf8(text).is_ok_and(|text| missing.is(text, self.decimal))
    }

    fn in_range(&self, line: u64, column: &Column, v: f64) -> Result<f64> {
        let (ok, expected) = match column.meaning {
            Meaning::Command(_)
            | Meaning::Encoder(_)
            | Meaning::Screw(_)
            | Meaning::Measured(_)
            | Meaning::Distance
            | Meaning::Position { .. } => {
                (v.is_nan() || (v * column.edge).abs() <= LARGEST, "a value of at most 10,000,000 deg or mm")
            }
            Meaning::Trigger => (v == 0.0 || v == 1.0 || v == -1.0, "1, -1 or 0"),
            Meaning::Cycle => {
                (v >= 0.0 && v <= f64::from(u32::MAX) && v.fract() == 0.0, "a whole number from 0 to 4,294,967,295")
            }
            _ => (true, ""),
        };
        if ok { Ok(v) } else { Err(self.bad(line, column, format!("{v}"), expected)) }
    }
}

/// A column of numbers, some of them missing.
type Cells = Vec<Option<f64>>;
