//! The first sheet of a workbook as CSV, so that what a spreadsheet saved is read like any other table.
//!
//! Row n of the sheet is line n of the text, so that a refusal names the row that the user sees. Numbers keep every digit that the
//! file holds, dates become ISO 8601. Which workbooks: `.xlsx`, `.xlsm`, `.xlsb`, `.ods`, `.xls` (by content, not by name).
//!
//! How it fails: an archive that is no workbook or unpacks to too much, a workbook without cells, a sheet that cannot be read.

use super::input::{self, Input};
use super::memory;
use crate::error::{Error, Place, Result};
use calamine::{Data, ExcelDateTime, Range, Reader, Sheets, open_workbook_auto_from_rs};
use memchr::memmem;
use std::io::{Cursor, Read};

const ZIP: &[u8] = b"PK\x03\x04";
/// Compound file of the older formats.
const COMPOUND: &[u8] = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1";
/// Bytes that the sheets of a workbook take at most, unpacked: ten million cells and more.
const LARGEST: u64 = 1 << 30;
/// Cells from the first to the last that a sheet may hold, the empty ones between them included: the reader allocates memory for all of
/// them, 24 bytes each.
const MOST_CELLS: u64 = 20_000_000;
/// Days are stored as one number, whose last digit is half a microsecond and more: finer digits would be rounding.
const TENS_OF_MICROSECONDS_PER_DAY: f64 = 86_400e5;

/// The text of a workbook's first sheet that has cells, and `true`; any other input as it is, and `false`. The checksum stays that of the
/// file.
pub fn unpacked(input: Input) -> Result<(Input, bool)> {
    if !input.bytes.starts_with(ZIP) && !input.bytes.starts_with(COMPOUND) {
        return Ok((input, false));
    }
    let Input { name, bytes, sha256 } = input;
    if bytes.starts_with(ZIP) {
        bounded(&name, &bytes)?;
    }
    let refused = |e: calamine::Error| {
        Error::bad(Place::file(&name), format!("a file that is not a workbook ({e})"), "CSV text or a workbook")
    };
    let mut book = open_workbook_auto_from_rs(Cursor::new(bytes.as_slice())).map_err(refused)?;
    for sheet in book.sheet_names() {
        require_cells(&name, extent(&mut book, &sheet).map_err(refused)?)?;
        let cells = book.worksheet_range(&sheet).map_err(refused)?;
        if !cells.is_empty() {
            let bytes = text(&name, &cells)?;
            return Ok((Input { name, bytes, sha256 }, true));
        }
    }
    Err(Error::bad(Place::file(&name), "a workbook without cells", "a header and rows on its first sheet"))
}

/// Refuses an archive that unpacks to more than memory holds, whatever sizes it states.
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
        // the one part of an OpenDocument sheet gives its cells with how often they are repeated
        let repeats = part.name().is_ok_and(|n| n == "content.xml");
        let mut part = part.take(left + 1);
        if repeats {
            let mut xml = Vec::new();
            total += part.read_to_end(&mut xml).map_err(|e| damaged(&e))? as u64;
            require_cells(name, repeated(&xml))?;
        } else {
            total += std::io::copy(&mut part, &mut std::io::sink()).map_err(|e| damaged(&e))?;
        }
        memory::require_size(name, total, LARGEST)?;
    }
    // cells are held beside the text
    memory::require(name, "a file", 2 * total)
}

/// Refuses a sheet of too many cells.
fn require_cells(name: &str, cells: u64) -> Result<()> {
    if cells <= MOST_CELLS {
        return Ok(());
    }
    let found = format!(
        "a sheet of more than {MOST_CELLS} cells from its first to its last, including empty cells between them"
    );
    Err(Error::bad(Place::file(name), found, "a smaller table, or CSV text"))
}

/// Cells of the rectangle that holds all cells of a sheet, as far as it is counted: two cells may stand far apart.
fn extent<R: std::io::Read + std::io::Seek>(
    book: &mut Sheets<R>,
    sheet: &str,
) -> std::result::Result<u64, calamine::Error> {
    let (mut low, mut high) = ((u32::MAX, u32::MAX), (0, 0));
    let mut add = |(row, column): (u32, u32)| {
        low = (low.0.min(row), low.1.min(column));
        high = (high.0.max(row), high.1.max(column));
        let cells = u64::from(high.0 - low.0 + 1) * u64::from(high.1 - low.1 + 1);
        (cells, cells > MOST_CELLS)
    };
    let mut cells = 0;
    match book {
        Sheets::Xlsx(book) => {
            let mut reader = book.worksheet_cells_reader(sheet)?;
            while let Some(cell) = reader.next_cell()? {
                let (now, enough) = add(cell.get_position());
                cells = now;
                if enough {
                    break;
                }
            }
        }
        Sheets::Xlsb(book) => {
            let mut reader = book.worksheet_cells_reader(sheet)?;
            while let Some(cell) = reader.next_cell()? {
                let (now, enough) = add(cell.get_position());
                cells = now;
                if enough {
                    break;
                }
            }
        }
        // at most 65,536 rows of 256 columns; those of OpenDocument are counted before it is read
        Sheets::Xls(_) | Sheets::Ods(_) => {}
    }
    Ok(cells)
}

/// Cells that an OpenDocument sheet makes of its repeated rows and cells. No memory is allocated for rows without a value.
fn repeated(xml: &[u8]) -> u64 {
    let tags = |text: &'_ [u8], tag: &'_ [u8]| -> Vec<usize> { memmem::find_iter(text, tag).collect() };
    let count = |text: &[u8], at: usize, attribute: &[u8]| {
        let end = memchr::memchr(b'>', text.get(at..).unwrap_or_default()).map_or(text.len(), |k| at + k);
        let head = text.get(at..end).unwrap_or_default();
        let value = memmem::find(head, attribute).and_then(|k| head.get(k + attribute.len()..));
        let digits: String =
            value.unwrap_or_default().iter().take_while(|b| b.is_ascii_digit()).map(|b| char::from(*b)).collect();
        (digits.parse().unwrap_or(1_u64), head.ends_with(b"/"))
    };
    let rows = tags(xml, b"<table:table-row");
    let mut cells = 0_u64;
    for (k, at) in rows.iter().enumerate() {
        let row = xml.get(*at..rows.get(k + 1).copied().unwrap_or(xml.len())).unwrap_or_default();
        let (times, _) = count(row, 0, b"table:number-rows-repeated=\"");
        let (mut own, mut any) = (0_u64, false);
        for at in tags(row, b"<table:table-cell") {
            let (columns, empty) = count(row, at, b"table:number-columns-repeated=\"");
            any |= !empty;
            own = own.saturating_add(columns);
        }
        if any {
            cells = cells.saturating_add(own.saturating_mul(times));
        }
    }
    cells
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
