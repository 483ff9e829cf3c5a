//! Rows that are read in one go, number by number, without a look at cells: rows of short numbers alone, many at a time, and
//! rows of plain numbers among unquoted cells. What is anything else is left to the reader, which takes it with every refusal.

use super::super::{Block, RowSpan, Slot, Token};
use super::header::Column;
use super::number;
use super::reader::Reader;
use crate::error::Result;

/// Columns up to which rows of nothing but short numbers take the fastest way.
pub(super) const MOST_PURE: usize = 16;

/// The row at `start` if it holds short numbers alone (none padded): its end and time; targets to `q`, places to `tokens`.
#[inline(always)]
fn pure_row(
    columns: &[(Option<usize>, f64)],
    text: &[u8],
    start: usize,
    q: &mut [f64; MOST_PURE],
    tokens: &mut [Token; MOST_PURE],
) -> Option<(usize, Option<f64>)> {
    let mut at = start;
    let (mut ending, mut padded) = (0, false);
    let mut t_s = None;
    for (&(axis, si), token) in columns.iter().zip(tokens) {
        // each separator but the last is a comma
        if at > start && ending != b',' {
            return None;
        }
        let chunk = text.get(at..)?.first_chunk::<16>()?;
        let number = number::short(chunk)?;
        padded |= number.padded;
        *token = Token { start: at as u32, len: number.len as u16, decimals: number.decimals, plain: true };
        match axis {
            Some(axis) => q[axis & (MOST_PURE - 1)] = number.value * si,
            None => t_s = Some(number.value),
        }
        ending = chunk[number.len & 15];
        at += number.len + 1;
    }
    match ending {
        _ if padded => None,
        b'\n' => Some((at, t_s)),
        b'\r' if *text.get(at)? == b'\n' => Some((at + 1, t_s)),
        _ => None,
    }
}

/// Rows of short numbers alone from one place of a text to another.
struct PureRows {
    at: usize,
    end: usize,
    rows: Block,
}

impl PureRows {
    fn new(at: usize, end: usize) -> Self {
        Self { at, end, rows: Block::default() }
    }

    /// Reads one more row; `false`: there is none.
    #[inline(always)]
    fn step(&mut self, columns: &[(Option<usize>, f64)], axes: usize, text: &[u8]) -> bool {
        if self.at >= self.end {
            return false;
        }
        let mut q = [0.0; MOST_PURE];
        let mut tokens = [Token::default(); MOST_PURE];
        let Some((end, t_s)) = pure_row(columns, text, self.at, &mut q, &mut tokens) else { return false };
        let Some((q, tokens)) = q.get(..axes).zip(tokens.get(..columns.len())) else { return false };
        self.rows.q.extend_from_slice(q);
        self.rows.tokens.extend_from_slice(tokens);
        for (most, token) in self.rows.decimals.iter_mut().zip(tokens) {
            *most = (*most).max(token.decimals);
        }
        self.rows.t_s.extend(t_s);
        self.rows.rows.push(RowSpan { start: self.at as u32, end: end as u32 });
        self.at = end;
        true
    }
}

impl Reader {
    /// Rows of short numbers alone, as far as they go; gives the place behind the last. Long texts are read at two places
    /// side by side: each number waits for the one before it, and the processor has room for two such chains.
    pub(super) fn pure_rows(&mut self, text: &[u8], at: usize, block: &mut Block) -> Result<usize> {
        let middle = at + (text.len() - at) / 2;
        let middle = memchr::memchr(b'\n', &text[middle..]).map_or(text.len(), |k| middle + k + 1);
        let mut parts = [PureRows::new(at, middle), PureRows::new(middle, text.len())];
        std::mem::swap(&mut parts[0].rows, block);
        std::mem::swap(&mut parts[1].rows, &mut self.spare);
        let [one, two] = &mut parts;
        two.rows.clear();
        two.rows.decimals.resize(self.pure.len(), 0);
        let before = one.rows.rows.len();
        let all_pure = one.rows.pure == before;
        while one.step(&self.pure, self.si.len(), text) & two.step(&self.pure, self.si.len(), text) {}
        while one.step(&self.pure, self.si.len(), text) {}
        // what was read from the middle on counts only if rows that begin there are rows
        let whole = one.at == middle;
        if whole {
            while two.step(&self.pure, self.si.len(), text) {}
            one.rows.append(&two.rows);
        }
        let end = if whole { two.at } else { one.at };
        std::mem::swap(&mut parts[0].rows, block);
        std::mem::swap(&mut parts[1].rows, &mut self.spare);
        let rows = block.rows.len() - before;
        if rows > 0 {
            // the rows behind the first stand on the lines behind it
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
        let times = block.t_s.len();
        block.q.resize(base + self.si.len(), 0.0);
        let end = self.plain_cells(text, start, block, base);
        if end.is_none() {
            block.tokens.truncate(tokens);
            block.q.truncate(base);
            block.t_s.truncate(times);
        }
        end
    }

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
                    let most = &mut block.decimals[slot];
                    *most = (*most).max(number.decimals);
                    match self.header.slots[slot] {
                        Slot::Axis(axis) => block.q[base + axis] = number.value * self.si[axis],
                        Slot::Time => block.t_s.push(number.value),
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
