//! The first sheet of a workbook as CSV, so that what a spreadsheet saved is read like any other table.
//!
//! Row n of the sheet is line n of the text, so that a refusal names the row that the user sees. Numbers keep every digit that the
//! file holds, dates become ISO 8601. Which workbooks: `.xlsx`, `.xlsm`, `.xlsb`, `.ods`, `.xls` (by content, not by name).
//!
//! How it fails: an archive that is no workbook or unpacks to too much, a workbook without cells, a sheet that cannot be read.

use super::input::{self, Input};
use super::memory;
use crate::error::{Error, Place, Result};
use calamine::{Data, ExcelDateTime, Range, Reader, open_workbook_auto_from_rs};
use std::io::{Cursor, Read};

const ZIP: &[u8] = b"PK\x03\x04";
/// Compound file of the older formats.
const COMPOUND: &[u8] = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1";
/// Bytes that the sheets of a workbook take at most, unpacked: ten million cells and more.
const LARGEST: u64 = 1 << 30;
/// Days are stored as one number, whose last digit is half a microsecond and more: finer digits would be rounding.
const TENS_OF_MICROSECONDS_PER_DAY: f64 = 86_400e5;

/// The text of a workbook's first sheet that has cells, and `true`; any other input as it is, and `false`. The checksum stays that of the file.
pub fn unpacked(input: Input) -> Result<(Input, bool)> {
    if !input.bytes.starts_with(ZIP) && !input.bytes.starts_with(COMPOUND) {
        return Ok((input, false));
    }
    let Input { name, bytes, sha256 } = input;
    if bytes.starts_with(ZIP) {
        bounded(&name, &bytes)?;
    }
    let refused = |e: calamine::Error| {
        Error::bad(Place::file(&name), format!("a file that no spreadsheet wrote ({e})"), "CSV text or a workbook")
    };
    let mut book = open_workbook_auto_from_rs(Cursor::new(bytes.as_slice())).map_err(refused)?;
    for sheet in book.sheet_names() {
        let cells = book.worksheet_range(&sheet).map_err(refused)?;
        if !cells.is_empty() {
            let bytes = text(&name, &cells)?;
            return Ok((Input { name, bytes, sha256 }, true));
        }
    }
    Err(Error::bad(Place::file(&name), "a workbook without cells", "a header and rows on its first sheet"))
}

/// Refuses an archive that unpacks to more than there is room for, whatever sizes it states.
fn bounded(name: &str, bytes: &[u8]) -> Result<()> {
    let damaged = |e: &dyn std::fmt::Display| {
        Error::bad(
            Place::file(name),
            format!("a ZIP file that is damaged or cut short ({e})"),
            "CSV text or a workbook",
        )
    };
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(|e| damaged(&e))?;
    let mut total = 0;
    for i in 0..archive.len() {
        let part = archive.by_index(i).map_err(|e| damaged(&e))?;
        let left = LARGEST - total;
        total += std::io::copy(&mut part.take(left + 1), &mut std::io::sink()).map_err(|e| damaged(&e))?;
        memory::require_size(name, total, LARGEST)?;
    }
    // cells are held beside the text
    memory::require(name, 2 * total)
}

/// A sheet as CSV, from row 1 on; a row without cells is a blank line.
fn text(name: &str, cells: &Range<Data>) -> Result<Vec<u8>> {
    let first = cells.start().map_or(0, |c| c.0) as usize;
    let mut bytes = vec![b'\n'; first];
    for row in cells.rows() {
        if row.iter().all(|c| matches!(c, Data::Empty)) {
            bytes.push(b'\n');
            continue;
        }
        let mut writer = csv::Writer::from_writer(&mut bytes);
        let cut = |e: csv::Error| Error::bad(Place::file(name), e.to_string(), "cells that CSV can hold");
        writer.write_record(row.iter().map(written)).map_err(cut)?;
        writer.flush().map_err(|e| Error::io_of(name, "read", e))?;
    }
    memory::require_size(name, bytes.len() as u64, input::LARGEST)?;
    Ok(bytes)
}

/// A cell as text on one line.
fn written(cell: &Data) -> String {
    match cell {
        Data::Empty => String::new(),
        Data::Int(v) => v.to_string(),
        Data::Float(v) => v.to_string(),
        Data::Bool(v) => v.to_string(),
        Data::DateTime(v) => date(v),
        Data::String(v) | Data::DateTimeIso(v) | Data::DurationIso(v) => v.replace(['\r', '\n'], " "),
        Data::Error(e) => e.to_string(),
    }
}

/// A date to 10 us; a duration in seconds.
fn date(cell: &ExcelDateTime) -> String {
    if cell.is_duration() {
        return (cell.as_f64() * 86_400.0).to_string();
    }
    let (year, month, day, ..) = cell.to_ymd_hms_milli();
    // the tuple stops at milliseconds, the cell does not
    let whole = TENS_OF_MICROSECONDS_PER_DAY;
    let tens = (cell.as_f64().fract() * whole).round().clamp(0.0, whole - 1.0) as u64;
    let (seconds, rest) = (tens / 100_000, tens % 100_000);
    let (hour, minute, second) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{rest:05}")
}
