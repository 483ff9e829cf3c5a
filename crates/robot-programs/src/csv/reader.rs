//! The file in blocks of whole rows, each with its targets and their places.
//!
//! A block ends behind the last whole row of about [`BLOCK`] bytes; what is cut goes to the next block, so that blocks do
//! not depend on how much a pipe delivers at a time. A row that is plain throughout takes the fast way
//! ([`fast`](super::fast)); any other is cut into cells ([`record`](super::record)) and read with every refusal.

use super::super::{Block, RowSpan, Slot, Token, lines::Lines};
use super::fast::MOST_PURE;
use super::header::{Column, Header, quote_error};
use super::number;
use super::record::{Record, Seen, content};
use crate::axes::Axes;
use crate::error::{Error, Place, Result};
use sha2::{Digest, Sha256};
use std::io::Read;

/// Text of a block, bytes: large enough to hide the hand-over, small enough to stay in the cache.
pub const BLOCK: usize = 256 << 10;
/// A row that is longer is refused.
const LONGEST_ROW: usize = 8 << 20;

/// A program that is being read.
pub struct Reader {
    input: Box<dyn Read + Send>,
    name: String,
    pub(super) header: Header,
    /// Edge unit to SI, per axis; the number of axes.
    pub(super) si: Vec<f64>,
    /// Where the numbers of a row go, if the columns hold nothing else: axis (`None`: the time) and unit to SI.
    pub(super) pure: Vec<(Option<usize>, f64)>,
    /// Memory for rows that are read ahead.
    pub(super) spare: Block,
    /// Text that was read and belongs to the next block; in the first block the rows start at `rows_at`.
    carry: Vec<u8>,
    rows_at: usize,
    ended: bool,
    pub(super) line: u64,
    pub(super) point: u64,
    last_t_s: Option<f64>,
    pub(super) lines: Lines,
    record: Record,
    hash: Option<Sha256>,
    /// Bytes read so far.
    bytes: u64,
}

enum Aside {
    /// A comment or a blank line; the next line starts here.
    Line(usize),
    Cut,
    Row,
}

impl Reader {
    /// Reads the header of a program; `name` stands in messages.
    pub fn new(input: Box<dyn Read + Send>, name: &str, robot: &Axes) -> Result<Self> {
        let mut reader = Self {
            input,
            name: name.into(),
            header: Header { columns: Vec::new(), slots: Vec::new(), names: Vec::new() },
            si: robot.axis_joints().map(|j| j.kind.si_per_user_unit()).collect(),
            pure: Vec::new(),
            spare: Block::default(),
            carry: Vec::new(),
            rows_at: 0,
            ended: false,
            line: 1,
            point: 0,
            last_t_s: None,
            lines: Lines::default(),
            record: Record::default(),
            hash: None,
            bytes: 0,
        };
        let mut text = Vec::new();
        reader.fill(&mut text, BLOCK)?;
        reader.refuse_other_encodings(&text)?;
        let mut at = if text.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        loop {
            let cut = match reader.aside(&text, at) {
                Aside::Line(next) => {
                    at = next;
                    continue;
                }
                Aside::Cut => true,
                Aside::Row => match reader.record.find(&text, at, reader.ended) {
                    Seen::Whole if at < text.len() => break,
                    Seen::Whole => {
                        let what = if text.is_empty() { "an empty file" } else { "no header row" };
                        return Err(Error::bad(
                            Place::file(name),
                            what,
                            "a program: a header row such as a1_deg,a2_deg and rows",
                        ));
                    }
                    Seen::Cut => true,
                    Seen::Quote(cell) => return Err(quote_error(name, reader.line, cell)),
                },
            };
            if cut {
                reader.more(&mut text, at)?;
            }
        }
        reader.header = Header::parse(&text, &reader.record, robot, name, reader.line)?;
        reader.line += 1 + reader.record.breaks;
        let slots = &reader.header.slots;
        if slots.len() == reader.header.columns.len() && slots.len() <= MOST_PURE {
            let target = |slot: &Slot| match *slot {
                Slot::Axis(axis) => (Some(axis), reader.si[axis]),
                Slot::Time => (None, 1.0),
            };
            reader.pure = slots.iter().map(target).collect();
        }
        reader.rows_at = reader.record.end;
        reader.carry = text;
        Ok(reader)
    }

    /// Also computes the SHA-256 of the bytes; to be asked for before the first block.
    pub fn with_hash(mut self) -> Self {
        self.hash = Some(Sha256::new_with_prefix(&self.carry));
        self
    }

    /// Name of the file, as messages show it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The numbers of a row, in the order in which they stand.
    pub fn slots(&self) -> &[Slot] {
        &self.header.slots
    }

    /// The columns.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// There is a column `t_s`.
    pub fn has_times(&self) -> bool {
        self.header.slots.contains(&Slot::Time)
    }

    /// Bytes read so far.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Points read so far.
    pub fn points(&self) -> u64 {
        self.point
    }

    /// SHA-256 of the bytes, once all are read.
    pub fn sha256(&mut self) -> Option<String> {
        self.hash.take().map(|h| h.finalize().iter().map(|b| format!("{b:02x}")).collect())
    }

    /// Where the points stand.
    pub fn into_lines(self) -> Lines {
        self.lines
    }

    /// Reads the next block; `false`: there is none.
    pub fn next(&mut self, block: &mut Block) -> Result<bool> {
        block.clear();
        block.first_point = self.point;
        block.decimals.resize(self.header.slots.len(), 0);
        let mut text = std::mem::take(&mut block.text);
        let mut at = std::mem::take(&mut self.rows_at);
        text.extend_from_slice(&self.carry);
        self.carry.clear();
        if text.len() < BLOCK {
            self.fill(&mut text, BLOCK)?;
        }
        if text.is_empty() {
            if self.point == 0 {
                return Err(Error::bad(Place::file(&self.name), "a header and no rows", "at least one row"));
            }
            block.text = text;
            return Ok(false);
        }
        loop {
            at = self.rows(&text, at, block)?;
            if at > 0 || self.ended {
                break;
            }
            self.more(&mut text, 0)?;
        }
        self.carry.extend_from_slice(&text[at..]);
        text.truncate(at);
        block.text = text;
        Ok(true)
    }

    /// Reads rows from `at` on as far as they are whole; gives the place behind the last.
    fn rows(&mut self, text: &[u8], mut at: usize, block: &mut Block) -> Result<usize> {
        if !self.pure.is_empty() {
            // room for rows of this length; more where they become shorter
            let rows = text.len() / (3 * self.pure.len());
            block.tokens.reserve(rows / 2 * self.pure.len());
            block.q.reserve(rows / 2 * self.si.len());
            block.rows.reserve(rows / 2);
        }
        while let Some(&byte) = text.get(at) {
            if !self.pure.is_empty() {
                let next = self.pure_rows(text, at, block)?;
                if next > at {
                    at = next;
                    continue;
                }
            }
            if matches!(byte, b'#' | b'\n' | b'\r' | b' ' | b'\t') {
                match self.aside(text, at) {
                    Aside::Line(next) => {
                        at = next;
                        continue;
                    }
                    Aside::Cut => break,
                    Aside::Row => {}
                }
            }
            let end = match self.plain_row(text, at, block) {
                Some(end) => {
                    self.lines.note(self.point, self.line);
                    self.line += 1;
                    end
                }
                None => match self.any_row(text, at, block)? {
                    Some(end) => end,
                    None => break,
                },
            };
            if let Some(&t) = block.t_s.last() {
                self.check_time(t)?;
            }
            block.rows.push(RowSpan { start: at as u32, end: end as u32 });
            self.point += 1;
            at = end;
        }
        Ok(at)
    }

    /// Any row; `None`: it is cut.
    fn any_row(&mut self, text: &[u8], start: usize, block: &mut Block) -> Result<Option<usize>> {
        let mut record = std::mem::take(&mut self.record);
        let seen = record.find(text, start, self.ended);
        if seen == Seen::Cut {
            self.record = record;
            return Ok(None);
        }
        if let Seen::Quote(cell) = seen {
            return Err(quote_error(&self.name, self.line, cell));
        }
        let columns = self.header.columns.len();
        if record.cells.len() != columns {
            let found = format!("{} cells", record.cells.len());
            let mut expected = format!("{columns} cells, as in the header");
            if text[start..record.end].contains(&b';') || record.cells.len() > columns {
                expected.push_str(" (commas between cells, decimal points in numbers)");
            }
            return Err(Error::bad(Place::line(&self.name, self.line), found, expected));
        }
        let base = block.q.len();
        block.q.resize(base + self.si.len(), 0.0);
        for (k, column) in self.header.columns.iter().enumerate() {
            let Column::Slot(slot) = *column else { continue };
            let (s, e) = content(text, record.cells[k]);
            let body = &text[s..e];
            let number = number::any(body).filter(|_| body.len() <= usize::from(u16::MAX));
            let number = number.ok_or_else(|| self.no_number(k, body))?;
            let exponent = body.iter().any(|b| matches!(b, b'e' | b'E'));
            let plain = number::is_plain(body) && !exponent && (s, e) == record.cells[k];
            block.tokens.push(Token { start: s as u32, len: (e - s) as u16, decimals: number.decimals, plain });
            block.decimals[slot] = block.decimals[slot].max(number.decimals);
            match self.header.slots[slot] {
                Slot::Axis(axis) => block.q[base + axis] = number.value * self.si[axis],
                Slot::Time => block.t_s.push(number.value),
            }
        }
        self.lines.note(self.point, self.line);
        self.line += 1 + record.breaks;
        let end = record.end;
        self.record = record;
        Ok(Some(end))
    }

    fn no_number(&self, column: usize, body: &[u8]) -> Error {
        let head = &self.header.names[column];
        let text = String::from_utf8_lossy(body);
        let found = match () {
            () if body.is_empty() => format!("an empty cell in column `{head}`"),
            () if body.contains(&b',') => format!("a decimal comma, `{text}`, in column `{head}`"),
            () => format!("`{text}` in column `{head}`"),
        };
        let place = Place::field(&self.name, self.line, column as u64 + 1);
        Error::bad(place, found, "a finite number with a decimal point")
    }

    pub(super) fn check_time(&mut self, t: f64) -> Result<()> {
        if let Some(before) = self.last_t_s
            && t <= before
        {
            let slot = self.header.slots.iter().position(|s| *s == Slot::Time).unwrap_or(0);
            // the line counter already stands behind this row
            let line = self.lines.line(self.point).unwrap_or(self.line);
            let place = Place::field(&self.name, line, self.header.column_of(slot));
            return Err(Error::bad(place, format!("time {t} s after {before} s"), "times that strictly increase"));
        }
        self.last_t_s = Some(t);
        Ok(())
    }

    /// Whether the line at `at` is a comment or blank.
    fn aside(&mut self, text: &[u8], at: usize) -> Aside {
        let first = at + text[at..].iter().take_while(|b| matches!(b, b' ' | b'\t')).count();
        match text.get(first) {
            Some(b'#' | b'\n' | b'\r') => {}
            Some(_) => return Aside::Row,
            None if self.ended && first > at => return Aside::Line(first),
            None if self.ended => return Aside::Row,
            None => return Aside::Cut,
        }
        let next = match memchr::memchr2(b'\n', b'\r', &text[first..]).map(|k| first + k) {
            None if self.ended => text.len(),
            None => return Aside::Cut,
            Some(k) if text[k] == b'\n' => k + 1,
            Some(k) => match text.get(k + 1) {
                None if !self.ended => return Aside::Cut,
                next => k + 1 + usize::from(next == Some(&b'\n')),
            },
        };
        self.line += 1;
        Aside::Line(next)
    }

    /// Reads on until `text` holds `size` bytes or the file ends.
    fn fill(&mut self, text: &mut Vec<u8>, size: usize) -> Result<()> {
        let want = size.saturating_sub(text.len());
        let before = text.len();
        text.reserve(want + 64);
        let got = (&mut self.input)
            .take(want as u64)
            .read_to_end(text)
            .map_err(|e| Error::Io { name: self.name.clone(), source: e })?;
        self.ended |= got < want;
        self.bytes += got as u64;
        if let Some(hash) = &mut self.hash {
            hash.update(&text[before..]);
        }
        Ok(())
    }

    /// More text for a row at `at` that is cut.
    fn more(&mut self, text: &mut Vec<u8>, at: usize) -> Result<()> {
        if text.len() - at > LONGEST_ROW {
            return Err(Error::bad(
                Place::line(&self.name, self.line),
                format!("a line of more than {} MB, or a quote that is not closed", LONGEST_ROW >> 20),
                "rows of a program",
            ));
        }
        let size = (text.len() * 2).max(BLOCK);
        self.fill(text, size)
    }

    fn refuse_other_encodings(&self, text: &[u8]) -> Result<()> {
        let found = if text.starts_with(&[0x1f, 0x8b]) {
            "a gzip file"
        } else if text.starts_with(&[0xff, 0xfe]) || text.starts_with(&[0xfe, 0xff]) {
            "UTF-16 text"
        } else if memchr::memchr(0, text).is_some() {
            "bytes of value 0: no text"
        } else {
            return Ok(());
        };
        let expected = "a program as plain text (UTF-8 or ASCII), not packed";
        Err(Error::bad(Place::file(&self.name), found, expected))
    }
}
