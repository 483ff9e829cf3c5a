//! Rows that are read in one go, number by number, without a look at cells: rows of short numbers alone, many at a time, and
//! rows of plain numbers among unquoted cells. What is anything else is left to the reader, which takes it with every refusal.

use super::super::{Block, RowSpan, Slot, Token};
use super::header::Column;
use super::number;
use super::parser::Parser;
use super::shape::Shape;
use crate::decimal::POW10;
use crate::decimal::read::{Packed, short};
use crate::error::Result;

/// Rows whose numbers are worked out together.
const CHUNK: usize = 64;

/// The row at `start` if it holds short numbers alone (none padded): its end; their places and mantissas.
///
/// `row = number {"," number} newline`
#[inline(always)]
pub(super) fn pure_row(text: &[u8], start: usize, tokens: &mut [Token], mantissas: &mut [Packed]) -> Option<usize> {
    let mut at = start;
    let (mut ending, mut padded) = (0, false);
    for (token, mantissa) in tokens.iter_mut().zip(mantissas) {
        // each separator but the last is a comma
        if at > start && ending != b',' {
            return None;
        }
        let chunk = text.get(at..)?.first_chunk::<16>()?;
        let number = short(chunk)?;
        padded |= number.padded;
        *token = Token { start: at as u32, len: number.len as u16, decimals: number.decimals, plain: true };
        *mantissa = number.mantissa;
        ending = chunk[number.len & 15];
        at += number.len + 1;
    }
    match ending {
        _ if padded => None,
        b'\n' => Some(at),
        b'\r' if *text.get(at)? == b'\n' => Some(at + 1),
        _ => None,
    }
}

/// Memory for rows that are read and not yet worked out; what their columns were like before.
#[derive(Debug, Clone, Default)]
pub(super) struct Scratch {
    tokens: Vec<Token>,
    mantissas: Vec<Packed>,
    values: Vec<f64>,
    /// Decimals of each column, and for every number of a chunk its power of ten and its unit in SI.
    decimals: Vec<u8>,
    powers: Vec<f64>,
    si: Vec<f64>,
    /// What the last row was like.
    shape: Shape,
}

impl Scratch {
    fn reserve(&mut self, columns: &[(Option<usize>, f64)]) {
        let size = CHUNK * columns.len();
        if self.tokens.len() != size {
            self.tokens = vec![Token::default(); size];
            self.mantissas = vec![Packed::NONE; size];
            self.values = vec![0.0; size];
            self.si = columns.iter().map(|c| c.1).cycle().take(size).collect();
            self.decimals = vec![0; columns.len()];
            self.powers = vec![1.0; size];
        }
    }

    /// Appends the first `count` rows to `rows`.
    fn hand_on(&mut self, count: usize, columns: &[(Option<usize>, f64)], axes: usize, rows: &mut Block) {
        let n = columns.len();
        let size = count * n;
        let (Some(tokens), Some(mantissas)) = (self.tokens.get(..size), self.mantissas.get(..size)) else { return };
        rows.tokens.extend_from_slice(tokens);
        rows.mantissas.extend_from_slice(mantissas);
        let alike = |row: &[Token]| row.iter().zip(&self.decimals).all(|(t, d)| t.decimals == *d);
        if tokens.chunks_exact(n).all(alike) {
            for (most, d) in rows.decimals.iter_mut().zip(&self.decimals) {
                *most = (*most).max(*d);
            }
            let units = self.powers.iter().zip(&self.si);
            for ((value, mantissa), (power, si)) in self.values.iter_mut().zip(mantissas).zip(units) {
                *value = mantissa.quotient(*power) * si;
            }
        } else {
            for (k, (token, mantissa)) in tokens.iter().zip(mantissas).enumerate() {
                let most = &mut rows.decimals[k % n];
                *most = (*most).max(token.decimals);
                self.values[k] = mantissa.quotient(POW10[usize::from(token.decimals & 7)]) * self.si[k];
            }
            // most columns go on as their last row was
            if let Some(last) = tokens.chunks_exact(n).last() {
                self.decimals = last.iter().map(|t| t.decimals).collect();
                let powers = self.decimals.iter().map(|d| POW10[usize::from(d & 7)]);
                self.powers = powers.cycle().take(CHUNK * n).collect();
            }
        }
        let Some(values) = self.values.get(..size) else { return };
        if axes == n && columns.iter().enumerate().all(|(k, c)| c.0 == Some(k)) {
            rows.q.extend_from_slice(values);
            return;
        }
        for row in values.chunks_exact(n) {
            let base = rows.q.len();
            rows.q.resize(base + axes, 0.0);
            for (&(axis, _), &value) in columns.iter().zip(row) {
                match axis {
                    Some(axis) => rows.q[base + axis] = value,
                    None => rows.t_s.push(value),
                }
            }
        }
    }
}

/// Rows of short numbers alone from one place of a text to another.
struct PureRows<'a> {
    at: usize,
    end: usize,
    rows: Block,
    scratch: Scratch,
    /// Rows that have not been handed on.
    held: usize,
    columns: &'a [(Option<usize>, f64)],
    axes: usize,
    text: &'a [u8],
}

impl PureRows<'_> {
    /// Reads one more row; `false`: there is none.
    #[inline(always)]
    fn step(&mut self) -> bool {
        if self.at >= self.end {
            return false;
        }
        if self.held == CHUNK {
            self.hand_on();
        }
        let n = self.columns.len();
        let place = self.held * n..(self.held + 1) * n;
        let Scratch { tokens, mantissas, shape, .. } = &mut self.scratch;
        let Some((tokens, mantissas)) = tokens.get_mut(place.clone()).zip(mantissas.get_mut(place)) else {
            return false;
        };
        let end = match shape.row(self.text, self.at, tokens, mantissas) {
            Some(end) => end,
            None => {
                let Some(end) = pure_row(self.text, self.at, tokens, mantissas) else { return false };
                shape.take(self.text, tokens, self.at, end);
                end
            }
        };
        self.rows.rows.push(RowSpan { start: self.at as u32, end: end as u32 });
        self.held += 1;
        self.at = end;
        true
    }

    fn hand_on(&mut self) {
        self.scratch.hand_on(self.held, self.columns, self.axes, &mut self.rows);
        self.held = 0;
    }
}

impl pulp::NullaryFnOnce for &mut PureRows<'_> {
    type Output = ();

    // inlined, so that it is compiled for the instructions that there are
    #[inline(always)]
    fn call(self) {
        while self.step() {}
        self.hand_on();
    }
}

impl Parser {
    /// Rows of short numbers alone, as far as they go; gives the place after the last.
    pub(super) fn pure_rows(&mut self, text: &[u8], at: usize, end: usize, block: &mut Block) -> Result<usize> {
        let columns = std::mem::take(&mut self.pure);
        let before = block.rows.len();
        let all_pure = block.pure == before;
        self.scratch.reserve(&columns);
        let mut rows = PureRows {
            at,
            end,
            rows: std::mem::take(block),
            scratch: std::mem::take(&mut self.scratch),
            held: 0,
            columns: &columns,
            axes: self.si.len(),
            text,
        };
        pulp::Arch::new().dispatch(&mut rows);
        let end = rows.at;
        (*block, self.scratch) = (rows.rows, rows.scratch);
        self.pure = columns;
        let rows = block.rows.len() - before;
        if rows > 0 {
            // the rows after the first stand on the lines after it
            self.lines.note(self.point, self.line);
        }
        if self.has_times() {
            for k in before..block.rows.len() {
                self.line += 1;
                self.check_time(block.t_s[k])?;
                self.point += 1;
            }
        } else {
            self.line += rows as u64;
            self.point += rows as u64;
        }
        if all_pure {
            block.pure = block.rows.len();
        }
        Ok(end)
    }

    /// A row of plain numbers and unquoted cells that ends in this text, else `None` and the block as it was.
    #[inline(always)]
    pub(super) fn plain_row(&self, text: &[u8], start: usize, block: &mut Block) -> Option<usize> {
        let (tokens, base) = (block.tokens.len(), block.q.len());
        let (times, durations) = (block.t_s.len(), block.durations.len());
        block.q.resize(base + self.si.len(), 0.0);
        let end = self.plain_cells(text, start, block, base);
        if end.is_none() {
            block.tokens.truncate(tokens);
            block.mantissas.truncate(tokens);
            block.q.truncate(base);
            block.t_s.truncate(times);
            block.durations.truncate(durations);
        }
        end
    }

    /// The cells of a row: plain numbers where they are read, anything without quotes where they are not.
    ///
    /// `row = (number | {any}) {"," (number | {any})} newline`
    #[inline(always)]
    fn plain_cells(&self, text: &[u8], start: usize, block: &mut Block, base: usize) -> Option<usize> {
        let mut at = start;
        let last = self.header.columns.len() - 1;
        for (k, column) in self.header.columns.iter().enumerate() {
            let end = match *column {
                Column::Slot(slot) => {
                    let (number, end) = number::plain(text, at)?;
                    let whole = usize::from(text[at] == b'-') + at;
                    let padded = text[whole] == b'0' && text[whole + 1].is_ascii_digit();
                    let token =
                        Token { start: at as u32, len: (end - at) as u16, decimals: number.decimals, plain: !padded };
                    block.tokens.push(token);
                    block.mantissas.push(number.mantissa);
                    let most = &mut block.decimals[slot];
                    *most = (*most).max(number.decimals);
                    match self.header.slots[slot] {
                        Slot::Axis(axis) => block.q[base + axis] = number.value * self.si[axis],
                        Slot::Time(_) => block.t_s.push(number.value * self.time_s),
                        Slot::Duration => block.durations.push(number.value),
                    }
                    end
                }
                Column::Other => {
                    if matches!(text.get(at)?, b'"' | b' ' | b'\t') {
                        return None;
                    }
                    at + memchr::memchr3(b',', b'\n', b'\r', &text[at..])?
                }
            };
            let separator = *text.get(end)?;
            if k < last {
                if separator != b',' {
                    return None;
                }
                at = end + 1;
            } else if separator == b'\n' {
                return Some(end + 1);
            } else if separator == b'\r' && *text.get(end + 1)? == b'\n' {
                return Some(end + 2);
            }
        }
        None
    }
}
