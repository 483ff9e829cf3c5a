//! The rows of a table as numbers: cut into pieces at line ends, parsed side by side, put together in order.

use super::head::{Head, passed_over, reader};
use crate::error::{Error, Place, Result, counted};
use crate::log::columns::{Column, Meaning, Missing};
use crate::log::number::{decimals, number};
use crate::log::timestamp::Stamp;
use crate::numerics::parallel::ParMap;
use std::ops::Range;

/// Bytes of a piece; fixed, so that the cuts do not depend on the machine.
const PIECE: usize = 1 << 20;
/// Largest command (deg or mm) and coordinate (mm): beyond it a cell is damaged, and squares would lose their digits.
const LARGEST: f64 = 1e7;

/// How the rows are to be read.
pub(super) struct Layout<'a> {
    pub(super) name: &'a str,
    pub(super) head: &'a Head,
    pub(super) columns: &'a [Column],
    pub(super) separator: u8,
    pub(super) decimal: u8,
}

/// Numbers of the used columns as written; an empty cell, where allowed, is NaN (a written NaN is refused).
pub(in crate::log) struct Table {
    pub(in crate::log) line: Vec<u32>,
    pub(in crate::log) values: Vec<Vec<f64>>,
    pub(in crate::log) decimals: Vec<u8>,
}

impl Layout<'_> {
    pub(super) fn read(&self, bytes: &[u8]) -> Result<Table> {
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
            "{}{}",
            counted(fields, "field"),
            if at_end { " in the last row: the file is cut short" } else { "" }
        );
        Error::bad(
            Place::line(self.name, line),
            found,
            format!("{}, as in the header", counted(self.head.names.len(), "field")),
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
pub(super) type Cells = Vec<Option<f64>>;
