//! The head of a table: separator, header row, and where the rows begin; what a file is, where it is no log.

use crate::error::{Error, Place, Result, one_line};
use crate::log::columns::{Column, Meaning, listed};
use crate::robot::Robot;

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
            return Err(Error::bad(Place::file(name), "only comments", "a header and rows"));
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
                "a row of numbers as the first line",
                "a header with the names of the columns",
            ));
        }
        Ok(Self { names, line, body: skip + reader.position().byte() as usize, body_line: reader.position().line() })
    }

    /// A header in one piece where another separator would cut it: reported, whatever else is wrong.
    pub(crate) fn explain(&self, name: &str, separator: u8, otherwise: Error) -> Error {
        self.another_separator(name, separator).unwrap_or(otherwise)
    }

    fn another_separator(&self, name: &str, separator: u8) -> Option<Error> {
        let other = [';', '\t', ',']
            .iter()
            .find(|&&c| c as u32 != u32::from(separator) && self.names.len() == 1 && self.names[0].contains(c))?;
        let shown = if *other == '\t' { "tab".to_string() } else { other.to_string() };
        Some(Error::unknown_header(
            Place::line(name, self.line),
            format!("fields separated by `{shown}`"),
            format!(
                "`{}`, or a column map with `separator: \"{shown}\"` and, where numbers have decimal commas, `decimal: \",\"`",
                separator as char
            ),
        ))
    }

    /// Refuses a header in one piece where another separator would cut it.
    pub(in crate::log) fn refuse_one_piece(&self, name: &str, separator: u8) -> Result<()> {
        self.another_separator(name, separator).map_or(Ok(()), Err)
    }

    /// Whether a column has this name, whatever its letters' case.
    fn has_name(&self, name: &str) -> bool {
        self.names.iter().any(|n| n.trim().eq_ignore_ascii_case(name))
    }

    /// Why a log without this column is refused.
    fn missing(&self, name: &str, column: String, expected: String, separator: u8) -> Error {
        // a program or another text, whose first line is no header
        if let [only] = self.names.as_slice()
            && self.another_separator(name, separator).is_none()
        {
            let found = format!("no header: the first line is `{}`", one_line(only));
            let expected = format!("a log (CSV, with a header such as t_s,{column},x_mm,y_mm,z_mm)");
            return Error::bad(Place::line(name, self.line), found, expected);
        }
        let found = format!("no column `{column}` among {}", listed(&self.names));
        let error = Error::unknown_header(Place::line(name, self.line), found, expected);
        self.explain(name, separator, error)
    }

    /// Every axis needs its command, every point its three coordinates (the TCP may lack some where it may stand `lone`).
    pub(in crate::log) fn check(
        &self,
        name: &str,
        columns: &[Column],
        robot: &Robot,
        separator: u8,
        lone: bool,
    ) -> Result<()> {
        let has = |m: Meaning| columns.iter().any(|c| c.meaning == m);
        let missing = |m: Meaning, expected: String| Err(self.missing(name, m.name(robot), expected, separator));
        if let Some(axis) = (0..robot.dof()).find(|&a| !has(Meaning::Command(a))) {
            let names = robot.axis_names().join(", ");
            let program = robot.axis_joints().any(|j| self.has_name(&format!("{}_{}", j.name, j.kind.unit())));
            let more =
                if program { "; a file with joints alone is a program: a log also contains measurements" } else { "" };
            return missing(Meaning::Command(axis), format!("a command column for each joint of {names}{more}"));
        }
        let measured = columns.iter().any(|c| matches!(c.meaning, Meaning::Position { .. }));
        if let Some(unit) =
            ["m", "cm", "um", "in", "inch"].iter().find(|u| !measured && self.has_name(&format!("x_{u}")))
        {
            let found = format!("a column `x_{unit}` and no column `x_mm`");
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
        let whole: [(&[Meaning], &str); 2] = [
            (&[0, 1, 2, 3].map(Meaning::Orientation), "qw, qx, qy and qz of an orientation"),
            (&[0, 1, 2].map(Meaning::Force), "fx_n, fy_n and fz_n of a force; a column of zeros for what is none"),
        ];
        for (parts, expected) in whole {
            if parts.iter().any(|&m| has(m))
                && let Some(&absent) = parts.iter().find(|&&m| !has(m))
            {
                return missing(absent, expected.into());
            }
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
pub(super) fn passed_over(bytes: &[u8], from: u64) -> u64 {
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
