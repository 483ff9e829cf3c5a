//! CSV (gzipped or not) and sheets of workbooks to a [`Log`].
//!
//! Method: the body is cut at line ends into pieces of about 1 MiB, which are parsed side by side and put together in
//! order, so that neither the result nor the first refusal depends on the number of threads.
//!
//! How it fails: on the first row that is not what the header promises, with line and field.

use super::Log;
use super::columns::{Column, ColumnMap, Meaning, Missing, listed};
use super::instruments::{Instruments, orientations};
use super::number::{decimals, number};
use super::text::LogText;
use super::timestamp;
use crate::error::{Error, Place, Result};
use crate::io::bag::TopicChoice;
use crate::io::input::{self, Input};
use crate::robot::Robot;
use nalgebra::Vector3;
use rayon::prelude::*;
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
        let (before, t) = (self.t_s[i], self.t_s[i + 1]);
        let found = match t.total_cmp(&before) {
            std::cmp::Ordering::Equal => format!("time {t} s twice"),
            std::cmp::Ordering::Less => format!("time {t} s after {before} s"),
            std::cmp::Ordering::Greater => format!("times {before} s and {t} s, which no clock tells apart"),
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

/// The header row and where the rows begin.
pub(crate) struct Head {
    pub(crate) names: Vec<String>,
    pub(crate) line: u64,
    pub(crate) body: usize,
    pub(crate) body_line: u64,
}

impl Head {
    pub(crate) fn read(name: &str, bytes: &[u8], separator: u8) -> Result<Self> {
        let skip = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        let text = &bytes[skip..];
        if text.starts_with(b"PK\x03\x04") {
            return Err(Error::bad(Place::file(name), "a ZIP file", "CSV text, plain or gzipped, or a workbook"));
        }
        if text.iter().all(u8::is_ascii_whitespace) {
            return Err(Error::bad(Place::file(name), "an empty file", "a header and rows"));
        }
        let mut reader = reader(text, separator);
        let mut record = csv::ByteRecord::new();
        let found =
            reader.read_byte_record(&mut record).map_err(|e| Error::bad(Place::file(name), e.to_string(), "CSV"))?;
        if !found {
            return Err(Error::bad(Place::file(name), "comments and nothing else", "a header and rows"));
        }
        let line = record.position().map_or(1, |p| p.line() + passed_over(text, p.byte()));
        let mut names = Vec::with_capacity(record.len());
        for field in &record {
            match std::str::from_utf8(field) {
                Ok(s) => names.push(s.trim().to_string()),
                Err(_) => {
                    let found = format!("a header that is not UTF-8 (`{}`)", String::from_utf8_lossy(field));
                    return Err(Error::bad(Place::line(name, line), found, "UTF-8 text"));
                }
            }
        }
        if names.iter().all(|n| n.parse::<f64>().is_ok()) {
            return Err(Error::bad(
                Place::line(name, line),
                "a row of numbers first",
                "a header with the names of the columns",
            ));
        }
        Ok(Self { names, line, body: skip + reader.position().byte() as usize, body_line: reader.position().line() })
    }

    /// A header in one piece where another separator would cut it: says so, whatever else is wrong.
    pub(crate) fn explain(&self, name: &str, separator: u8, otherwise: Error) -> Error {
        self.another_separator(name, separator).unwrap_or(otherwise)
    }

    fn another_separator(&self, name: &str, separator: u8) -> Option<Error> {
        let other = [';', '\t', ',']
            .iter()
            .find(|&&c| c as u32 != u32::from(separator) && self.names.len() == 1 && self.names[0].contains(c))?;
        let shown = if *other == '\t' { "tab".to_string() } else { other.to_string() };
        Some(Error::bad(
            Place::line(name, self.line),
            format!("fields separated by `{shown}`"),
            format!("`{}`, or a column map with `separator: \"{shown}\"`", separator as char),
        ))
    }

    /// Refuses a header in one piece where another separator would cut it.
    pub(super) fn refuse_one_piece(&self, name: &str, separator: u8) -> Result<()> {
        self.another_separator(name, separator).map_or(Ok(()), Err)
    }

    /// Whether a column has this name, whatever its letters' case.
    fn has_name(&self, name: &str) -> bool {
        self.names.iter().any(|n| n.trim().eq_ignore_ascii_case(name))
    }

    /// Every axis needs its command, every point its three coordinates (the TCP may lack some where it may stand `lone`).
    fn check(&self, name: &str, columns: &[Column], robot: &Robot, separator: u8, lone: bool) -> Result<()> {
        let has = |m: Meaning| columns.iter().any(|c| c.meaning == m);
        let missing = |m: Meaning, expected: String| {
            let error = Error::bad(
                Place::line(name, self.line),
                format!("no column `{}` among {}", m.name(robot), listed(&self.names)),
                expected,
            );
            Err(self.explain(name, separator, error))
        };
        if let Some(axis) = (0..robot.dof()).find(|&a| !has(Meaning::Command(a))) {
            let names = robot.axis_names().join(", ");
            let program = robot.axis_joints().any(|j| self.has_name(&format!("{}_{}", j.name, j.kind.unit())));
            let more = if program {
                "; joints alone are a program: a log has what was measured beside the commands"
            } else {
                ""
            };
            return missing(Meaning::Command(axis), format!("a command column for each joint of {names}{more}"));
        }
        let measured = columns.iter().any(|c| matches!(c.meaning, Meaning::Position { .. }));
        if let Some(unit) =
            ["m", "cm", "um", "in", "inch"].iter().find(|u| !measured && self.has_name(&format!("x_{u}")))
        {
            let found = format!("a column `x_{unit}` and none `x_mm`");
            let expected = "positions in mm, or a column map that gives their unit";
            return Err(self.explain(name, separator, Error::bad(Place::line(name, self.line), found, expected)));
        }
        let reflectors = columns.iter().filter_map(|c| match c.meaning {
            Meaning::Position { k, .. } => Some(k),
            _ => None,
        });
        for k in 0..=reflectors.max().unwrap_or(0) {
            let point = [0, 1, 2].map(|coordinate| Meaning::Position { k, coordinate });
            if (k > 0 || !lone && point.iter().any(|&m| has(m)))
                && let Some(&absent) = point.iter().find(|&&m| !has(m))
            {
                return missing(absent, "x, y and z of every reflector".into());
            }
        }
        let parts = [0, 1, 2, 3].map(Meaning::Orientation);
        if parts.iter().any(|&m| has(m))
            && let Some(&absent) = parts.iter().find(|&&m| !has(m))
        {
            return missing(absent, "qw, qx, qy and qz of an orientation".into());
        }
        Ok(())
    }
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
        let pieces: Vec<Result<Table>> = cuts
            .into_par_iter()
            .enumerate()
            .map(|(i, (range, line))| self.piece(&bytes[range], line, i == last))
            .collect();
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
                    Some(n) if !column.timestamp && column.missing.is_empty() => n,
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
        if column.timestamp {
            let microseconds = std::str::from_utf8(text).ok().and_then(timestamp::microseconds);
            let found = format!("`{}`", String::from_utf8_lossy(text));
            return microseconds
                .map(|us| (us, 0))
                .ok_or_else(|| self.bad(line, column, found, "a date and time, e.g. 2025-11-12T10:03:29.555Z"));
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

/// The columns of a table, each taken once, in SI.
struct Columns<'a> {
    table: &'a mut Table,
    columns: &'a [Column],
}

/// A column of numbers, some of them missing.
type Cells = Vec<Option<f64>>;

impl Columns<'_> {
    fn take(&mut self, m: Meaning) -> Option<Vec<f64>> {
        let k = self.columns.iter().position(|c| c.meaning == m)?;
        let mut values = std::mem::take(&mut self.table.values[k]);
        let factor = self.columns[k].factor;
        if self.columns[k].timestamp {
            // whole microseconds: differences are exact, which the seconds of today's dates are not
            let first = values.first().copied().unwrap_or(0.0);
            values.iter_mut().for_each(|v| *v -= first);
        }
        if factor != 1.0 {
            values.iter_mut().for_each(|v| *v *= factor);
        }
        Some(values)
    }

    /// A column whose cells may be empty.
    fn cells(&mut self, m: Meaning) -> Option<Cells> {
        self.take(m).map(present)
    }

    /// Coordinates of the `k`-th reflector; a point with an empty cell is lost as a whole.
    fn points(&mut self, k: usize) -> Option<Vec<Option<Vector3<f64>>>> {
        let [x, y, z] = [0, 1, 2].map(|coordinate| self.take(Meaning::Position { k, coordinate }));
        let (x, y, z) = (x?, y?, z?);
        let point = |((x, y), z): ((&f64, &f64), &f64)| Some(Vector3::new(*x, *y, *z)).filter(|v| !v.sum().is_nan());
        Some(x.iter().zip(&y).zip(&z).map(point).collect())
    }

    /// Single coordinates of the TCP, where not all three are measured.
    fn lone(&mut self) -> [Option<Vec<f64>>; 3] {
        let coordinates = [0, 1, 2].map(|coordinate| Meaning::Position { k: 0, coordinate });
        let whole = coordinates.iter().all(|m| self.columns.iter().any(|c| c.meaning == *m));
        coordinates.map(|m| if whole { None } else { self.take(m) })
    }

    /// What instruments besides the tracker measure.
    fn instruments(&mut self, name: &str, axes: usize) -> Result<Instruments> {
        let torque_nm: Vec<Option<Cells>> = (0..axes).map(|a| self.cells(Meaning::Torque(a))).collect();
        let mut instruments = Instruments {
            distance_m: self.cells(Meaning::Distance),
            distance_off_m: self.cells(Meaning::DistanceOff),
            dial_m: self.cells(Meaning::Dial),
            orientation: Vec::new(),
            torque_nm: if torque_nm.iter().any(Option::is_some) { torque_nm } else { Vec::new() },
        };
        if let [Some(w), Some(x), Some(y), Some(z)] = [0, 1, 2, 3].map(|part| self.take(Meaning::Orientation(part))) {
            instruments.orientation = orientations([&w, &x, &y, &z]).map_err(|(row, norm)| {
                let line = self.table.line.get(row).map_or(0, |l| u64::from(*l));
                let found = format!("an orientation of length {norm:.4}");
                Error::bad(Place::line(name, line), found, "a unit quaternion qw, qx, qy, qz")
            })?;
        }
        Ok(instruments)
    }

    /// Decimals of an axis' command: another unit moves the last digit, 8 decimals of a radian are 6 of a degree.
    fn decimals(&self, axis: usize) -> u8 {
        match self.columns.iter().position(|c| c.meaning == Meaning::Command(axis)) {
            Some(k) => {
                (f64::from(self.table.decimals[k]) - self.columns[k].edge.log10()).floor().clamp(0.0, 15.0) as u8
            }
            None => 0,
        }
    }
}

/// Cells that are not empty.
fn present(values: Vec<f64>) -> Cells {
    values.into_iter().map(|v| Some(v).filter(|v| !v.is_nan())).collect()
}

/// Columns as written to a log in SI.
fn build(name: &str, sha256: String, mut table: Table, columns: &[Column], robot: &Robot) -> Result<Log> {
    let rows = table.line.len();
    let axes = robot.dof();
    let mut c = Columns { table: &mut table, columns };
    let time = c.take(Meaning::Time);
    let poses = time.is_none();
    let lone_m = c.lone().map(|values| values.map(present));
    let instruments = c.instruments(name, axes)?;
    Ok(Log {
        name: name.into(),
        sha256,
        t_s: time.unwrap_or_else(|| (0..rows).map(|i| i as f64).collect()),
        poses,
        cmd: (0..axes).map(|a| c.take(Meaning::Command(a)).unwrap_or_default()).collect(),
        cmd_decimals: (0..axes).map(|a| c.decimals(a)).collect(),
        tcp_m: c.points(0).unwrap_or_default(),
        lone_m,
        reflectors_m: (1..).map_while(|k| c.points(k)).collect(),
        enc: (0..axes).map(|a| c.cells(Meaning::Encoder(a))).collect(),
        screw: (0..axes).map(|a| c.cells(Meaning::Screw(a))).collect(),
        meas: (0..axes).map(|a| c.cells(Meaning::Measured(a))).collect(),
        trigger: c.take(Meaning::Trigger).map(|v| v.into_iter().map(|x| x as i8).collect()),
        cycle: c.take(Meaning::Cycle).map(|v| v.into_iter().map(|x| x as u32).collect()),
        speed_m_s: c.cells(Meaning::Speed),
        payload_kg: c.cells(Meaning::Payload),
        temp_c: c.cells(Meaning::Temperature),
        instruments,
        line: table.line,
    })
}
