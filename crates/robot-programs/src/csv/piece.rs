//! Pieces of a program between reading and their place: cut in order, parsed in any order, placed in order.
//!
//! Text is cut after a line break. Where it holds a quote, a line break may belong to a cell: such text is parsed where it is
//! read. Parsing begins at line 0 and point 0; [`Placing`] adds what came before. A piece that is refused is parsed once more
//! in its place, so that the message names the line of the file.

use super::super::{Block, Slot, lines::Lines};
use super::parser::Parser;
use crate::error::{Error, Place, Result};

/// Whole rows on their way through.
#[derive(Debug, Default)]
pub struct Piece {
    /// The rows, once they are parsed.
    pub block: Block,
    pub(super) state: State,
    /// The rows stand between these places of the text.
    pub(super) at: usize,
    pub(super) end: usize,
    pub(super) ended: bool,
    /// Lines, from 0; those of the points.
    pub(super) line: u64,
    pub(super) lines: Lines,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum State {
    #[default]
    Text,
    Parsed,
    /// Refused; why is found out in its place.
    Bad,
    /// A row that does not end.
    Endless,
}

impl Piece {
    /// The bytes of the file that this piece is; those of all pieces, one after the other, are the file.
    pub fn bytes(&self) -> &[u8] {
        self.block.text.get(..self.end).unwrap_or_default()
    }

    /// Begins with the rows of `text` from place `at` on, all of them whole; the block is empty.
    pub(super) fn begin(&mut self, text: Vec<u8>, at: usize) {
        (self.at, self.end, self.ended, self.state) = (at, text.len(), true, State::Text);
        self.block.text = text;
    }

    /// Parses the text, if it has not been parsed where it was read.
    pub fn parse(&mut self, parser: &mut Parser) {
        if self.state == State::Text {
            let parsed = self.parse_to(parser, self.end);
            if parsed.is_some_and(|at| at == self.end) {
                self.block.text.truncate(self.end);
            } else {
                self.state = State::Bad;
            }
        }
    }

    /// Parses the rows that begin before `end`; gives the place after the last whole one, `None`: they are refused.
    pub(super) fn parse_to(&mut self, parser: &mut Parser, end: usize) -> Option<usize> {
        (parser.line, parser.point, parser.last_t_s, parser.ended) = (0, 0, None, self.ended);
        let text = std::mem::take(&mut self.block.text);
        let parsed = parser.rows(&text, self.at, end, &mut self.block);
        self.block.text = text;
        self.line = parser.line;
        self.lines = std::mem::take(&mut parser.lines);
        self.state = State::Parsed;
        parsed.ok().filter(|_| self.lines.is_complete())
    }
}

/// Puts pieces in their places, one after the other.
#[derive(Debug)]
pub struct Placing {
    pub(super) parser: Parser,
}

impl Placing {
    /// Says which points and lines of the program the rows of the next piece are.
    pub fn place(&mut self, piece: &mut Piece) -> Result<()> {
        let parser = &mut self.parser;
        let block = &mut piece.block;
        let follows = match (parser.last_t_s, block.t_s.first()) {
            (Some(before), Some(first)) => *first > before,
            _ => true,
        };
        if piece.state == State::Parsed && follows {
            block.first_point = parser.point;
            parser.lines.append(&piece.lines, parser.point, parser.line);
            parser.line += piece.line;
            parser.point += block.rows.len() as u64;
            parser.last_t_s = block.t_s.last().copied().or(parser.last_t_s);
            return Ok(());
        }
        // the whole text once more, at its true place: the message names the line of the file
        parser.ended = piece.ended;
        let text = std::mem::take(&mut block.text);
        block.clear();
        let end = if piece.state == State::Endless { text.len() } else { piece.end };
        let at = parser.rows(&text, piece.at, end, block)?;
        block.text = text;
        if piece.state == State::Endless || at < end {
            return Err(parser.endless());
        }
        block.text.truncate(at);
        Ok(())
    }

    /// After the last piece: a program has points.
    pub fn end(&self) -> Result<()> {
        if self.parser.point == 0 {
            return Err(Error::bad(Place::file(&self.parser.name), "a header and no rows", "at least one row"));
        }
        Ok(())
    }

    /// The numbers of a row, in the order in which they stand.
    pub fn slots(&self) -> &[Slot] {
        &self.parser.header.slots
    }

    /// Points so far.
    pub fn points(&self) -> u64 {
        self.parser.point
    }

    /// Where the points stand.
    pub fn into_lines(self) -> Lines {
        self.parser.lines
    }
}

#[cfg(test)]
mod tests {
    use super::super::Reader;
    use super::*;
    use crate::axes::{Axes, Axis, JointKind};
    use std::io::Cursor;

    fn axes() -> Axes {
        Axes::new("two", vec![Axis::new("A1", JointKind::Revolute), Axis::new("X", JointKind::Prismatic)])
    }

    fn reader(text: &str) -> Reader {
        Reader::new(Box::new(Cursor::new(text.as_bytes().to_vec())), "p.csv", &axes()).unwrap()
    }

    /// Many pieces of rows of every kind, and what they hold: degrees, millimetres, lines of the file.
    fn program(ending: &str) -> (String, Vec<(f64, f64, u64)>) {
        let mut text = format!("# made\n\na1_deg,note,x_mm{ending}");
        let (mut want, mut line) = (Vec::new(), 4);
        for i in 0..60_000u32 {
            let (a, x) = (f64::from(i % 900) / 10.0 - 45.0, f64::from(i % 7001) / 1000.0);
            match i % 1000 {
                7 => {
                    text.push_str("# a comment with a \" in it\n");
                    line += 1;
                }
                500 => {
                    text.push_str(ending);
                    line += 1;
                }
                _ => {}
            }
            want.push((a, x, line));
            match i % 5003 {
                // the line breaks of a cell belong to its row
                4 => {
                    text.push_str(&format!("{a:e},\"two\nlines, \"\"one\"\" cell\", +{x:.4}{ending}"));
                    line += 2;
                }
                _ => {
                    text.push_str(&format!("{a:.1},seam {i},{x:.3}{ending}"));
                    line += 1;
                }
            }
        }
        (text, want)
    }

    #[test]
    fn pieces_that_are_parsed_apart_and_placed_in_order_are_the_program() {
        for ending in ["\n", "\r\n", "\r"] {
            let (text, want) = program(ending);
            let (mut source, parser, mut placing) = reader(&text).split();
            let mut pieces = Vec::new();
            loop {
                let mut piece = Piece::default();
                if !source.next(&mut piece).unwrap() {
                    break;
                }
                pieces.push(piece);
            }
            assert!(pieces.len() > 3, "{} pieces", pieces.len());
            let bytes: Vec<u8> = pieces.iter().flat_map(Piece::bytes).copied().collect();
            assert_eq!(bytes, text.as_bytes());
            // the last first: none may need what another one holds
            pieces.iter_mut().rev().for_each(|p| p.parse(&mut parser.fresh()));
            let (mut whole, mut points) = (Vec::new(), 0);
            for piece in &mut pieces {
                placing.place(piece).unwrap();
                let block = &piece.block;
                assert_eq!(block.first_point, points);
                points += block.rows.len() as u64;
                whole.extend_from_slice(&block.text);
                for (q, (a, x, _)) in block.q.chunks_exact(2).zip(&want[block.first_point as usize..]) {
                    assert!((q[0].to_degrees() - a).abs() < 1e-12 && (q[1] * 1e3 - x).abs() < 1e-12, "{q:?} {a} {x}");
                }
            }
            assert_eq!(whole, text.as_bytes());
            assert_eq!(points as usize, want.len());
            placing.end().unwrap();
            let lines = placing.into_lines();
            for (point, (.., line)) in want.iter().enumerate() {
                assert_eq!(lines.line(point as u64), Some(*line), "point {point} with {ending:?}");
            }
        }
    }

    #[test]
    fn a_bad_row_in_a_later_piece_is_named_by_its_line_of_the_file() {
        for ending in ["\n", "\r\n"] {
            let (mut text, want) = program(ending);
            let last = want.last().unwrap().2;
            text.push_str(&format!("1.0,seam,1,5{ending}2.0,seam,1.5{ending}"));
            let mut reader = reader(&text);
            let mut block = Block::default();
            let error = loop {
                match reader.next(&mut block) {
                    Ok(true) => {}
                    Ok(false) => panic!("read to its end"),
                    Err(e) => break e.to_string(),
                }
            };
            assert!(error.contains(&format!("p.csv:{}", last + 1)) && error.contains("4 cells"), "{error}");
        }
    }
}
