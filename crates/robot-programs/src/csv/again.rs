//! Printed rows, read again: what a controller will read of them.

use super::super::Slot;
use super::parser::Parser;
use super::piece::{Piece, State};
use super::same::SameRows;
use super::slot::SLACK;

/// Units of the last written digit by which a number may miss what was meant: a half by rounding, a whole one where a limit is near and
/// the number is rounded inwards.
pub(super) const LAST_DIGITS: f64 = 1.0 + 1e-6;
/// What the arithmetic may add to that, as a share of the number.
const ARITHMETIC: f64 = 1e-12;

/// Reads rows that were printed, and compares them with what was meant.
#[derive(Debug)]
pub struct Again {
    pub(super) parser: Parser,
    piece: Piece,
    /// The fast way, for most rows.
    pub(super) rows: SameRows,
    /// What a number of each slot may miss at the most decimals that its rows have, rad or m; per axis, and for times.
    strict: Vec<f64>,
    strict_s: f64,
}

/// What rows are meant to be.
#[derive(Debug, Clone, Copy)]
pub struct Meant<'a> {
    /// Number of axes: values per row.
    pub axes: usize,
    /// Targets, row after row, rad or m.
    pub q: &'a [f64],
    /// Empty, or the time of each row, s.
    pub t_s: &'a [f64],
}

impl Again {
    /// For rows as `parser` reads them.
    pub fn new(parser: &Parser) -> Self {
        Self {
            parser: parser.fresh(),
            piece: Piece::default(),
            rows: SameRows::default(),
            strict: Vec::new(),
            strict_s: 0.0,
        }
    }

    /// The first row of `text`, from place `at` on, that a reader does not take for what was meant; the text stays as it is.
    /// Nothing: they are the same, within the digits that are written.
    pub fn first_difference(&mut self, text: &mut Vec<u8>, at: usize, meant: Meant) -> Option<usize> {
        if self.rows.are_all(text, at, &self.parser.pure, meant) {
            return None;
        }
        self.first_difference_of_any(text, at, meant)
    }

    /// [`Again::first_difference`] of rows of any kind.
    pub(super) fn first_difference_of_any(&mut self, text: &mut Vec<u8>, at: usize, meant: Meant) -> Option<usize> {
        self.piece.block.clear();
        self.piece.begin(std::mem::take(text), at);
        self.piece.parse(&mut self.parser);
        *text = std::mem::take(&mut self.piece.block.text);
        let block = &self.piece.block;
        let meant = Meant { axes: meant.axes.max(1), ..meant };
        let rows = meant.q.len() / meant.axes;
        if self.piece.state != State::Parsed {
            return Some(block.rows.len());
        }
        if block.rows.len() != rows || block.t_s.len() != meant.t_s.len() {
            return Some(block.rows.len().min(rows));
        }
        self.set_strict(meant.axes);
        let block = &self.piece.block;
        let close = |is: f64, meant: f64, within: f64| (is - meant).abs() <= within;
        let targets = block.q.chunks_exact(meant.axes).zip(meant.q.chunks_exact(meant.axes));
        let mut same = true;
        for (is, meant) in targets {
            same &= is.iter().zip(meant).zip(&self.strict).all(|((is, meant), within)| close(*is, *meant, *within));
        }
        let within = self.strict_s;
        same &= block.t_s.iter().zip(meant.t_s).all(|(is, meant)| close(*is, *meant, within));
        if same { None } else { (0..rows).find(|&i| !self.row_is(i, &meant)) }
    }

    /// What numbers with the most decimals of their columns may miss.
    fn set_strict(&mut self, axes: usize) {
        self.strict.clear();
        self.strict.resize(axes, 0.0);
        for (slot, decimals) in self.parser.header.slots.iter().zip(&self.piece.block.decimals) {
            let within = LAST_DIGITS * 10f64.powi(-i32::from(*decimals));
            match *slot {
                Slot::Axis(a) => self.strict[a] = within * self.parser.si[a],
                Slot::Time(_) => self.strict_s = within * self.parser.time_s,
                Slot::Duration => {}
            }
        }
    }

    /// Whether row `i` is what was meant, number by number with the decimals that each has.
    fn row_is(&self, i: usize, meant: &Meant) -> bool {
        let (block, slots) = (&self.piece.block, &self.parser.header.slots);
        let Some(tokens) = block.tokens.get(i * slots.len()..(i + 1) * slots.len()) else { return false };
        slots.iter().zip(tokens).all(|(slot, token)| {
            let (is, meant, unit, slack) = match *slot {
                Slot::Axis(a) => (block.q[i * meant.axes + a], meant.q[i * meant.axes + a], self.parser.si[a], SLACK),
                Slot::Time(_) => (block.t_s[i], meant.t_s[i], self.parser.time_s, 0.0),
                Slot::Duration => return true,
            };
            let digit = 10f64.powi(-i32::from(token.decimals));
            (is - meant).abs() <= (LAST_DIGITS * digit + slack) * unit + ARITHMETIC * meant.abs()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Reader;
    use super::*;
    use crate::axes::{Axes, Axis, JointKind};

    fn difference(text: &str, deg: &[[f64; 2]], t_s: &[f64]) -> Option<usize> {
        let axes = Axes::new("two", vec![Axis::new("A", JointKind::Revolute), Axis::new("X", JointKind::Prismatic)]);
        let head = if t_s.is_empty() { "A_deg,X_mm\n" } else { "t_s,A_deg,X_mm\n" };
        let mut own = Vec::from(format!("{head}{text}"));
        let (_, parser, _) = Reader::new(Box::new(std::io::Cursor::new(own.clone())), "p.csv", &axes).unwrap().split();
        let q: Vec<f64> = deg.iter().flat_map(|[a, x]| [a.to_radians(), x / 1e3]).collect();
        let found = Again::new(&parser).first_difference(&mut own, head.len(), Meant { axes: 2, q: &q, t_s });
        assert_eq!(own, format!("{head}{text}").into_bytes());
        found
    }

    #[test]
    fn rows_within_their_digits_are_the_same_whatever_they_look_like() {
        let deg = [[1.23456, 10.0], [-2.5, 0.125], [3.0, 250.0], [4.0, -1.5]];
        assert_eq!(difference("1.235,10\n-2.50,0.1\n# a word\n3e0,+250.0\n\n\"4\",-1.5000\n", &deg, &[]), None);
        let times = [0.5, 1.0, 1.25, 2.0];
        assert_eq!(difference("0.5,1.2346,10\n1,-2.5,.13\r\n1.250,3,250\r\n2,4,-1.5", &deg, &times), None);
    }

    #[test]
    fn a_value_as_far_beyond_a_limit_as_limits_are_exact_is_the_limit() {
        // written with more decimals than that
        assert_eq!(difference("180.000000000000,10\n", &[[180.000_000_000_9, 10.0]], &[]), None);
        assert_eq!(difference("180.000000000000,10\n", &[[180.000_000_003, 10.0]], &[]), Some(0));
    }

    #[test]
    fn a_wrong_digit_a_missing_row_and_a_row_too_many_are_found() {
        let deg = [[1.23456, 10.0], [-2.5, 0.125], [3.0, 250.0]];
        assert_eq!(difference("1.2346,10\n2.50,0.125\n3.0,250\n", &deg, &[]), Some(1));
        assert_eq!(difference("1.2346,10\n-2.50,0.125\n3.0,251.1\n", &deg, &[]), Some(2));
        assert_eq!(difference("1.2246,10\n-2.5,0.125\n3,250\n", &deg, &[]), Some(0));
        assert_eq!(difference("1.2346,10\n-2.5,0.125\n", &deg, &[]), Some(2));
        assert_eq!(difference("1.2346,10\n-2.5,0.125\n3,250\n3,250\n", &deg, &[]), Some(3));
        assert_eq!(difference("1.2346,10\n-2.5,0.125\n3,25O\n", &deg, &[]), Some(2));
        assert_eq!(difference("0,1.2346,10\n1.2,-2.5,0.125\n2,3,250\n", &deg, &[0.0, 1.0, 2.0]), Some(1));
    }
}
