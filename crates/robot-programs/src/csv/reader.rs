//! The file in pieces of whole rows, each with its targets and their places.
//!
//! A piece ends after the last whole row of about [`BLOCK`] bytes; what is cut goes to the next one, so that pieces do not
//! depend on how much a pipe delivers at a time. [`Source`] reads and cuts, [`Parser`] parses, [`Placing`] counts: one after
//! the other in [`Reader::next`], or side by side for several pieces ([`Reader::split`]).

use super::super::{Block, Slot, lines::Lines};
use super::clock;
use super::header::{Header, quote_error};
use super::parser::{Aside, LONGEST_ROW, Parser};
use super::piece::{Piece, Placing, State};
use super::record::Seen;
use crate::axes::Axes;
use crate::error::{Error, Place, Result};
use crate::script::cursor::unmarked;
use std::io::Read;

/// Text of a block, bytes: large enough to hide the hand-over, small enough to stay in the cache.
pub const BLOCK: usize = 256 << 10;

/// A program that is being read.
pub struct Reader {
    source: Source,
    placing: Placing,
    parser: Parser,
    piece: Piece,
}

/// The text of a program, cut into pieces.
pub struct Source {
    input: Box<dyn Read + Send>,
    name: String,
    /// For text that is parsed where it is read.
    parser: Parser,
    /// Text that was read and belongs to the next piece; in the first one the rows start at `rows_at`.
    carry: Vec<u8>,
    rows_at: usize,
    ended: bool,
    /// Bytes read so far.
    bytes: u64,
}

impl Reader {
    /// Reads the header of a program; `name` stands in messages.
    pub fn new(input: Box<dyn Read + Send>, name: &str, robot: &Axes) -> Result<Self> {
        let mut parser = Parser::new(name, robot);
        let mut source = Source {
            input,
            name: name.into(),
            parser: parser.clone(),
            carry: Vec::new(),
            rows_at: 0,
            ended: false,
            bytes: 0,
        };
        let mut text = Vec::new();
        source.fill(&mut text, BLOCK)?;
        refuse_other_encodings(name, &text)?;
        let mut at = text.len() - unmarked(&text).len();
        loop {
            parser.ended = source.ended;
            let cut = match parser.aside(&text, at) {
                Aside::Line(next) => {
                    at = next;
                    continue;
                }
                Aside::Cut => true,
                Aside::Row => match parser.record.find(&text, at, source.ended) {
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
                    Seen::Quote(cell) => return Err(quote_error(name, parser.line, cell)),
                },
            };
            if cut {
                if text.len() - at > LONGEST_ROW {
                    return Err(parser.endless());
                }
                source.more(&mut text)?;
            }
        }
        let header_line = parser.line;
        parser.set_header(Header::parse(&text, &parser.record, robot, name, parser.line)?);
        parser.line += 1 + parser.record.breaks;
        source.rows_at = parser.record.end;
        let rows = (text.as_slice(), source.rows_at, source.ended);
        clock::refuse_unclear(&parser.header, rows, name, header_line)?;
        source.carry = text;
        source.parser = parser.fresh();
        let fresh = parser.fresh();
        Ok(Self { source, placing: Placing { parser }, parser: fresh, piece: Piece::default() })
    }

    /// Name of the file, as messages show it.
    pub fn name(&self) -> &str {
        &self.source.name
    }

    /// The numbers of a row, in the order in which they stand.
    pub fn slots(&self) -> &[Slot] {
        self.placing.slots()
    }

    /// The columns.
    pub fn header(&self) -> &Header {
        &self.parser.header
    }

    /// There is a column of times, such as `t_s`.
    pub fn has_times(&self) -> bool {
        self.parser.has_times()
    }

    /// Bytes read so far.
    pub fn bytes(&self) -> u64 {
        self.source.bytes
    }

    /// Points read so far.
    pub fn points(&self) -> u64 {
        self.placing.points()
    }

    /// Where the points stand.
    pub fn into_lines(self) -> Lines {
        self.placing.into_lines()
    }

    /// What reads, what parses and what counts, for pieces that are parsed side by side.
    pub fn split(self) -> (Source, Parser, Placing) {
        (self.source, self.parser, self.placing)
    }

    /// Reads the next block; `false`: there is none.
    pub fn next(&mut self, block: &mut Block) -> Result<bool> {
        std::mem::swap(&mut self.piece.block, block);
        let more = self.next_piece();
        std::mem::swap(&mut self.piece.block, block);
        more
    }

    fn next_piece(&mut self) -> Result<bool> {
        if !self.source.next(&mut self.piece)? {
            self.placing.end()?;
            return Ok(false);
        }
        self.piece.parse(&mut self.parser);
        self.placing.place(&mut self.piece)?;
        Ok(true)
    }
}

impl Source {
    /// Reads the next piece and cuts it off; `false`: there is none.
    pub fn next(&mut self, piece: &mut Piece) -> Result<bool> {
        piece.block.clear();
        piece.at = std::mem::take(&mut self.rows_at);
        let mut text = std::mem::take(&mut piece.block.text);
        text.extend_from_slice(&self.carry);
        self.carry.clear();
        if text.len() < BLOCK {
            self.fill(&mut text, BLOCK)?;
        }
        if text.is_empty() {
            piece.block.text = text;
            return Ok(false);
        }
        loop {
            piece.block.text = text;
            self.cut(piece);
            if piece.end > 0 || self.ended || piece.state == State::Bad {
                break;
            }
            text = std::mem::take(&mut piece.block.text);
            if text.len() > LONGEST_ROW {
                piece.block.text = text;
                piece.state = State::Endless;
                return Ok(true);
            }
            self.more(&mut text)?;
        }
        self.carry.extend_from_slice(piece.block.text.get(piece.end..).unwrap_or_default());
        if piece.state == State::Parsed {
            piece.block.text.truncate(piece.end);
        }
        Ok(true)
    }

    /// Finds the end of the last whole row.
    fn cut(&mut self, piece: &mut Piece) {
        let text = &piece.block.text;
        let rows = text.get(piece.at..).unwrap_or_default();
        piece.ended = self.ended;
        piece.state = State::Text;
        if memchr::memchr(b'"', rows).is_none() {
            piece.end = if self.ended { text.len() } else { piece.at + after_last_break(rows) };
            return;
        }
        let all = text.len();
        match piece.parse_to(&mut self.parser, all) {
            Some(end) => piece.end = end,
            None => (piece.end, piece.state) = (all, State::Bad),
        }
    }

    /// Nothing follows.
    pub fn is_ended(&self) -> bool {
        self.ended && self.carry.is_empty()
    }

    /// Bytes read so far.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Reads on until `text` holds `size` bytes or the file ends.
    fn fill(&mut self, text: &mut Vec<u8>, size: usize) -> Result<()> {
        let want = size.saturating_sub(text.len());
        text.reserve(want + 64);
        let got = (&mut self.input)
            .take(want as u64)
            .read_to_end(text)
            .map_err(|e| Error::Io { name: self.name.clone(), source: e })?;
        self.ended |= got < want;
        self.bytes += got as u64;
        Ok(())
    }

    /// More text for a row that is cut.
    fn more(&mut self, text: &mut Vec<u8>) -> Result<()> {
        let size = (text.len() * 2).max(BLOCK);
        self.fill(text, size)
    }
}

/// The place after the last line break, 0: there is none. A carriage return at the very end may be half of one.
fn after_last_break(text: &[u8]) -> usize {
    let mut end = text.len();
    while let Some(k) = memchr::memrchr2(b'\n', b'\r', &text[..end]) {
        if text[k] == b'\n' || k + 1 < text.len() {
            return k + 1;
        }
        end = k;
    }
    0
}

fn refuse_other_encodings(name: &str, text: &[u8]) -> Result<()> {
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
    Err(Error::bad(Place::file(name), found, expected))
}
