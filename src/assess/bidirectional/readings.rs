//! A readings file (CSV, `.gz`): errors at positions, from both directions, repeated, in one state or several.
//!
//! How it fails: on the first row that is not what the header promises, with line and field. An empty cell (also `nan`, `na`,
//! `n/a`, `null`, `none`) of the error or the repeat is a missing value; of the position, the direction or a state it leaves
//! the row without a place, and is refused.

use super::columns::{Column, Role, resolve};
use super::direction;
use super::note::Note;
use super::state::{Level, States};
use crate::error::{Error, Place, Result, counted};
use crate::io::input::{self, Input};
use crate::io::workbook;
use crate::log::ColumnMap;
use crate::log::read::{Head, reader};
use crate::numerics::robust::{largest_size, range};
use std::collections::HashMap;
use std::path::Path;

/// Largest position and error in metres: beyond it a cell is damaged.
const LARGEST_M: f64 = 1e4;
/// Different values of a column beyond this are measurements, not states.
const STATES: usize = 24;
/// Errors beyond this share of the line's length are no errors of positioning: a unit is wrong.
const SHARE_OF_LINE: f64 = 0.25;
/// A largest error below this (m) was written in another unit: metres in a column of mm, mm in one of um. No robot repeats so well.
const IMPOSSIBLY_SMALL_M: f64 = 0.1e-6;
/// A largest error below this (m) may have been.
const SUSPICIOUSLY_SMALL_M: f64 = 0.5e-6;
/// A line shorter than this (m) may have been written in another unit.
const SHORT_LINE_M: f64 = 5e-3;

/// One reading.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// Line of the file, from 1.
    pub line: u64,
    /// Commanded position, m.
    pub position_m: f64,
    /// Whether the position was approached with rising values.
    pub forward: bool,
    /// Name of the repeat; `None`: not given.
    pub repeat: Option<String>,
    /// Measured minus commanded; `None`: missing.
    pub error_m: Option<f64>,
    /// Number of its state in [`Readings::states`].
    pub state: usize,
}

/// A whole file.
#[derive(Debug, Clone)]
pub struct Readings {
    /// Name of the file.
    pub name: String,
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
    /// Readings in the order of the file.
    pub rows: Vec<Reading>,
    /// States of the machine that the file names.
    pub states: States,
    /// Readings that are missing.
    pub missing: usize,
    /// What a reader should know of the file.
    pub notes: Vec<Note>,
}

impl Readings {
    /// Reads a file, through a column map where one is given; `states` chooses the state columns, else all that are left are.
    pub fn load(path: &Path, map: Option<&ColumnMap>, states: Option<&[String]>) -> Result<Self> {
        Self::parse(input::read(path)?, map, states)
    }

    /// Parses the bytes of a file.
    pub fn parse(input: Input, map: Option<&ColumnMap>, states: Option<&[String]>) -> Result<Self> {
        let (Input { name, bytes, sha256 }, from_sheet) = workbook::unpacked(input)?;
        input::refuse_utf16(&name, &bytes)?;
        let map_of_text = map.filter(|_| !from_sheet);
        let separator = map_of_text.map_or(b',', |m| m.separator_of(&bytes));
        let head = Head::read(&name, &bytes, separator)?;
        let at = Place::line(&name, head.line);
        let columns = resolve(&head.names, map, states, &at).map_err(|e| head.explain(&name, separator, e))?;
        let table = Table {
            name: &name,
            head: &head,
            columns: &columns,
            decimal: map_of_text.map_or(b'.', |m| m.decimal_of(&bytes, separator)),
        };
        let raw = table.rows(&bytes[head.body.min(bytes.len())..], separator)?;
        if raw.is_empty() {
            return Err(Error::bad(Place::file(&name), "a header and no rows", "readings in both directions"));
        }
        let names: Vec<String> =
            columns.iter().filter_map(|c| if let Role::State(s) = &c.role { Some(s.clone()) } else { None }).collect();
        let mut readings =
            Self { name, sha256, rows: Vec::new(), states: States::new(names), missing: 0, notes: Vec::new() };
        for (reading, levels) in raw {
            let state = readings.states.number(levels);
            readings.missing += usize::from(reading.error_m.is_none());
            readings.rows.push(Reading { state, ..reading });
        }
        readings.check(&columns)?;
        Ok(readings)
    }

    fn check(&mut self, columns: &[Column]) -> Result<()> {
        let file = || Place::file(&self.name);
        self.refuse_many_states(columns)?;
        let all: Vec<f64> = self.rows.iter().filter_map(|r| r.error_m).collect();
        if all.is_empty() {
            return Err(Error::bad(
                file(),
                "no reading: every cell of the error is empty",
                "readings in both directions",
            ));
        }
        for (forward, found, want) in [(true, "backward", "forward"), (false, "forward", "backward")] {
            if !self.rows.iter().any(|r| r.forward == forward && r.error_m.is_some()) {
                return Err(Error::bad(
                    file(),
                    format!("readings in the {found} direction only"),
                    format!("readings in both directions ({want} is missing)"),
                ));
            }
        }
        self.check_sizes(&all, columns)?;
        if self.missing > 0 {
            self.notes.push(Note::Missing { missing: self.missing, readings: self.rows.len() });
        }
        self.refuse_twice()
    }

    /// A column with nearly as many values as rows is no state.
    fn refuse_many_states(&self, columns: &[Column]) -> Result<()> {
        for (k, name) in self.states.names.iter().enumerate() {
            let levels = self.states.levels(k);
            if levels.len() > STATES && levels.len() * 4 > self.rows.len() {
                let index = columns.iter().find(|c| c.role == Role::State(name.clone())).map(|c| c.index as u64 + 1);
                return Err(Error::bad(
                    Place { column: index, ..Place::file(&self.name) },
                    format!("{} different values in column `{name}`", levels.len()),
                    "a state such as a speed or a payload, or `ignore` for it in a column map",
                )
                .mended_by(&["states"]));
            }
        }
        Ok(())
    }

    /// Errors and positions of believable sizes: another one is a wrong unit.
    fn check_sizes(&mut self, all: &[f64], columns: &[Column]) -> Result<()> {
        let file = || Place::file(&self.name);
        let largest = largest_size(all.iter().copied());
        let [lo, hi] = range(self.rows.iter().map(|r| r.position_m));
        let mut sizes: Vec<f64> = all.iter().map(|e| e.abs()).collect();
        let middle = crate::numerics::robust::median_of(&mut sizes).unwrap_or(0.0);
        if hi > lo && middle > SHARE_OF_LINE * (hi - lo) {
            return Err(Error::bad(
                file(),
                format!("errors of {:.3} mm (median) on a line of {:.3} mm", middle * 1e3, (hi - lo) * 1e3),
                "errors far below the length of the line; check the units of position and error",
            ));
        }
        if largest > 0.0 && largest < IMPOSSIBLY_SMALL_M {
            let role = |c: &&Column| matches!(c.role, Role::Error | Role::Reading);
            let column = columns.iter().find(role);
            return Err(Error::bad(
                Place { column: column.map(|c| c.index as u64 + 1), ..file() },
                format!("errors of at most {:.2e} um in column `{}`", largest * 1e6, column.map_or("", |c| &c.name)),
                "errors of 0.1 um and more, in the unit of the column's name (error_um, error_mm, reading_mm); a column map \
                 with `unit: m` reads metres",
            ));
        }
        if hi > lo && hi - lo < SHORT_LINE_M {
            self.notes.push(Note::ShortLine { length_m: hi - lo });
        }
        if largest > 0.0 && largest < SUSPICIOUSLY_SMALL_M {
            self.notes.push(Note::SmallErrors { largest_m: largest });
        }
        Ok(())
    }

    /// One reading for each position, direction, repeat and state.
    fn refuse_twice(&self) -> Result<()> {
        let mut seen: HashMap<(i64, bool, &str, usize), u64> = HashMap::new();
        for r in self.rows.iter().filter(|r| r.error_m.is_some()) {
            let Some(repeat) = r.repeat.as_deref() else { continue };
            let key = ((r.position_m * 1e9).round() as i64, r.forward, repeat, r.state);
            if let Some(first) = seen.insert(key, r.line) {
                let direction = if r.forward { "forward" } else { "backward" };
                return Err(Error::bad(
                    Place::line(&self.name, r.line),
                    format!(
                        "a second reading of position {} mm, {direction}, repeat {repeat} (the first is on line {first})",
                        crate::assess::bidirectional::digits::digits(r.position_m * 1e3, 9)
                    ),
                    "a different repeat for each reading; put a state that differs into a column",
                ));
            }
        }
        Ok(())
    }
}

/// How the rows are to be read.
struct Table<'a> {
    name: &'a str,
    head: &'a Head,
    columns: &'a [Column<'a>],
    decimal: u8,
}

impl Table<'_> {
    fn rows(&self, body: &[u8], separator: u8) -> Result<Vec<(Reading, Vec<Level>)>> {
        let mut rows = Vec::new();
        let mut reader = reader(body, separator);
        let mut record = csv::ByteRecord::new();
        loop {
            match reader.read_byte_record(&mut record) {
                Ok(true) => {}
                Ok(false) => return Ok(rows),
                Err(e) => return Err(Error::bad(Place::file(self.name), e.to_string(), "CSV")),
            }
            let line = record.position().map_or(0, |p| p.line()) + self.head.body_line - 1;
            if record.len() == 1 && record[0].trim_ascii().is_empty() {
                continue;
            }
            if record.len() != self.head.names.len() {
                let expected = format!("{}, as in the header", counted(self.head.names.len(), "field"));
                return Err(Error::bad(Place::line(self.name, line), counted(record.len(), "field"), expected));
            }
            rows.push(self.row(line, &record)?);
        }
    }

    fn row(&self, line: u64, record: &csv::ByteRecord) -> Result<(Reading, Vec<Level>)> {
        let mut row = Reading { line, position_m: 0.0, forward: true, repeat: None, error_m: None, state: 0 };
        let (mut levels, mut measured) = (Vec::new(), None);
        for c in self.columns {
            let text = std::str::from_utf8(&record[c.index])
                .map_err(|_| self.bad(line, c, "bytes that are not UTF-8".into(), "UTF-8 text"))?
                .trim();
            let missing = is_missing(text) || c.map.as_ref().is_some_and(|m| m.is_missing(text, self.decimal));
            let needed = |what: &str| self.bad(line, c, format!("{} without {what}", shown(text)), what);
            match &c.role {
                Role::Position if missing => return Err(needed("a position")),
                Role::Position => row.position_m = self.length(line, c, text)?,
                Role::Direction => {
                    let turned = c.map.as_ref().is_some_and(|m| m.factor < 0.0);
                    let forward = direction::is_forward(text)
                        .ok_or_else(|| self.bad(line, c, shown(text), direction::EXPECTED))?;
                    row.forward = forward != turned;
                }
                Role::Repeat if missing => {}
                Role::Repeat => row.repeat = Some(Level::new(text, self.decimal).text),
                Role::Error | Role::Reading if missing => {}
                Role::Error => row.error_m = Some(self.length(line, c, text)?),
                Role::Reading => measured = Some(self.length(line, c, text)?),
                Role::State(_) if missing => return Err(needed("a state")),
                Role::State(_) => levels.push(Level::new(text, self.decimal)),
            }
        }
        if let Some(m) = measured {
            row.error_m = Some(m - row.position_m);
        }
        Ok((row, levels))
    }

    fn bad(&self, line: u64, column: &Column, found: String, expected: &str) -> Error {
        let place = Place::field(self.name, line, column.index as u64 + 1);
        Error::bad(place, format!("{found} in column `{}`", column.name), expected)
    }

    /// A length in metres.
    fn length(&self, line: u64, column: &Column, text: &str) -> Result<f64> {
        let factor = column.si * column.map.as_ref().map_or(1.0, |m| m.factor);
        match Level::new(text, self.decimal).number.map(|v| v * factor) {
            Some(v) if v.abs() <= LARGEST_M => Ok(v),
            Some(_) => Err(self.bad(line, column, shown(text), "a value of at most 10,000,000 mm")),
            None if self.decimal == b',' => {
                Err(self.bad(line, column, shown(text), "a finite number with a decimal comma"))
            }
            None => Err(self.bad(line, column, shown(text), "a finite number with a decimal point")),
        }
    }
}

fn shown(text: &str) -> String {
    if text.is_empty() { "an empty cell".into() } else { format!("`{text}`") }
}

fn is_missing(text: &str) -> bool {
    matches!(text.to_ascii_lowercase().as_str(), "" | "nan" | "na" | "n/a" | "null" | "none")
}
