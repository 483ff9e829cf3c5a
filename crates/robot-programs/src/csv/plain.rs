//! Rows of plain numbers alone, with new values: the fast ways of [`Edits`].
//!
//! In such rows every number of a slot gets the same decimals ([`Cell`]) and its own digits are at hand as a whole number, so that
//! a new value is an addition. As long as no number of a row changes its sign or its length, the block's text is copied in one piece
//! and the digits are changed in the copy; else the numbers of a row are made one by one. A row that needs more than that is left to
//! [`Edits::row`], which writes the same and knows the rest.

use super::super::{Block, Token};
use super::edit::Edits;
use crate::decimal::patch::Step;
use crate::decimal::print::{ROOM, fixed};
use crate::decimal::read::Packed;
use crate::decimal::{GUARD, POW10_INT, unguarded};

/// Bytes of a plain number.
const LONGEST: usize = 10;
/// Rows whose text is copied in one piece to be patched.
const PATCHED: usize = 32;

/// A slot whose numbers all get the same decimals in the present block.
#[derive(Debug, Clone)]
pub(super) struct Cell {
    /// `None`: the time.
    pub(super) axis: Option<usize>,
    pub(super) decimals: u8,
    /// Counts of [`GUARD`] digits beyond the last one, in one rad or m.
    pub(super) fine: f64,
    /// The same in a last digit of a number that has so many decimals.
    pub(super) lift: [i64; 8],
    /// Counts of last digits between which the number has 8 digits at most and rounding reaches no limit.
    pub(super) safe: [i64; 2],
    /// A number was written.
    pub(super) written: bool,
    /// What the offset that was last asked for does to numbers of these decimals.
    pub(super) last: Last,
    /// For numbers without and with a minus, by their bytes after it: the counts of last digits for which a number keeps its sign and
    /// its length and is safe.
    pub(super) same: [[Counts; MOST_BYTES + 1]; 2],
}

/// Bytes after the sign of a number that is changed in place, at most.
const MOST_BYTES: usize = 8;
/// Offsets that differ by less, in counts as [`Cell::fine`], are rounded alike: no more than half a count apart, and a little less for
/// the rounding of doubles.
const ALIKE: f64 = 0.499;

/// Counts from `least` on, as many as `many`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Counts {
    least: i64,
    many: u64,
}

impl Counts {
    fn between(least: i64, most: i64) -> Self {
        Self { least, many: u64::try_from(most - least + 1).unwrap_or(0) }
    }

    #[inline(always)]
    fn has(self, count: i64) -> bool {
        (count.wrapping_sub(self.least) as u64) < self.many
    }
}

/// An offset and what it does.
#[derive(Debug, Clone, Copy)]
pub(super) struct Last {
    /// The offset, whole counts as [`Cell::fine`]; not a number: none was asked for.
    near: f64,
    /// `None`: every number has to be made anew.
    step: Option<Step>,
}

impl Default for Last {
    fn default() -> Self {
        Self { near: f64::NAN, step: None }
    }
}

impl Edits {
    /// Writes rows of plain numbers alone ([`Block::pure`]) from row `i` on, with the targets `q` (row after row, `axes` in
    /// each) and times `t_s` (may be empty), just as [`Edits::row`] writes them one by one. Gives the number of rows that
    /// are done and the place up to which the block's text has been written; the next of the rows needs the general way.
    #[allow(clippy::too_many_arguments)]
    pub fn pure_rows(
        &mut self,
        block: &Block,
        i: usize,
        cursor: usize,
        q: &[f64],
        axes: usize,
        t_s: &[f64],
        out: &mut Vec<u8>,
    ) -> (usize, usize) {
        let (n, rows) = (self.cells.len(), q.len() / axes.max(1));
        let same = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits());
        if n == 0 || rows == 0 || !(t_s.is_empty() || same(t_s, &block.t_s[i..i + rows])) {
            return (0, cursor);
        }
        if same(q, &block.q[i * axes..(i + rows) * axes]) {
            return (rows, cursor);
        }
        pulp::Arch::new().dispatch(ChangedRows { edits: self, block, i, cursor, q, axes, out })
    }

    /// [`Edits::pure_rows`] by new digits in a copy of the text, as far as all numbers of a row keep sign and length.
    #[inline(always)]
    fn patched_rows(&mut self, text: &[u8], rows: &Rows, cursor: usize, out: &mut Vec<u8>) -> (usize, usize) {
        let end = rows.end();
        let base = out.len();
        out.extend_from_slice(&text[cursor..(end + 8).min(text.len())]);
        let copy = &mut out[base..];
        for (k, row) in rows.iter().enumerate() {
            if patched_row(&mut self.cells, &row, text, copy, cursor).is_none() {
                let start = row.tokens[0].start as usize;
                out.truncate(base + start - cursor);
                return (k, start);
            }
        }
        out.truncate(base + end - cursor);
        (rows.count(), end)
    }

    /// [`Edits::pure_rows`] by numbers that are made one by one.
    #[inline(always)]
    fn made_rows(&mut self, text: &[u8], rows: &Rows, cursor: usize, out: &mut Vec<u8>) -> (usize, usize) {
        // the text up to the last number, and what changed numbers may add to it
        let most = rows.end().saturating_sub(cursor) + rows.tokens.len() * LONGEST;
        if self.room.len() < most + 2 * ROOM {
            self.room.resize(2 * most + 2 * ROOM, 0);
        }
        let mut rest = Rest { text, cursor, room: &mut self.room, at: 0 };
        let mut done = 0;
        for row in rows.iter() {
            let (cursor, at) = (rest.cursor, rest.at);
            if pure_row(&mut self.cells, &row, &mut rest).is_none() {
                (rest.cursor, rest.at) = (cursor, at);
                break;
            }
            done += 1;
        }
        let (at, cursor) = (rest.at, rest.cursor);
        out.extend_from_slice(&self.room[..at]);
        (done, cursor)
    }
}

/// [`Edits::pure_rows`] of rows that change.
struct ChangedRows<'a> {
    edits: &'a mut Edits,
    block: &'a Block,
    i: usize,
    cursor: usize,
    q: &'a [f64],
    axes: usize,
    out: &'a mut Vec<u8>,
}

impl pulp::NullaryFnOnce for ChangedRows<'_> {
    type Output = (usize, usize);

    // inlined, so that it is compiled for the instructions that there are
    #[inline(always)]
    fn call(self) -> (usize, usize) {
        let Self { edits, block, i, mut cursor, q, axes, out } = self;
        let n = edits.cells.len();
        let mut done = 0;
        for q in q.chunks(PATCHED * axes) {
            let rows = q.len() / axes;
            let mut part = 0;
            while part < rows {
                let left = Rows::of(block, i + done + part, n, &q[part * axes..], axes);
                let (patched, end) = edits.patched_rows(&block.text, &left, cursor, out);
                part += patched;
                cursor = end;
                if part == rows {
                    break;
                }
                // one row whose numbers change their length, or all of them
                let next = if patched == 0 { rows } else { part + 1 };
                let long = Rows::of(block, i + done + part, n, &q[part * axes..next * axes], axes);
                let (made, end) = edits.made_rows(&block.text, &long, cursor, out);
                cursor = end;
                if part + made < next {
                    return (done + part + made, cursor);
                }
                part = next;
            }
            done += rows;
        }
        (done, cursor)
    }
}

/// Rows of plain numbers with their new targets; a row alone is such rows too.
struct Rows<'a> {
    /// Numbers of a row, and axes.
    n: usize,
    axes: usize,
    new: &'a [f64],
    old: &'a [f64],
    tokens: &'a [Token],
    mantissas: &'a [Packed],
}

impl<'a> Rows<'a> {
    /// From row `i` of a block on, as many as `q` has.
    fn of(block: &'a Block, i: usize, n: usize, q: &'a [f64], axes: usize) -> Self {
        let to = i + q.len() / axes;
        Self {
            n,
            axes,
            new: q,
            old: &block.q[i * axes..to * axes],
            tokens: &block.tokens[i * n..to * n],
            mantissas: &block.mantissas[i * n..to * n],
        }
    }

    fn count(&self) -> usize {
        self.new.len() / self.axes
    }

    /// The place after the last number.
    fn end(&self) -> usize {
        self.tokens.last().map_or(0, |t| t.start as usize + usize::from(t.len))
    }

    #[inline(always)]
    fn iter(&self) -> impl Iterator<Item = Rows<'a>> {
        let (n, axes) = (self.n, self.axes);
        let targets = self.new.chunks_exact(axes).zip(self.old.chunks_exact(axes));
        let numbers = self.tokens.chunks_exact(n).zip(self.mantissas.chunks_exact(n));
        targets.zip(numbers).map(move |((new, old), (tokens, mantissas))| Rows { n, axes, new, old, tokens, mantissas })
    }
}

/// Text that has not been copied, and space for what is written.
struct Rest<'a> {
    text: &'a [u8],
    cursor: usize,
    room: &'a mut [u8],
    at: usize,
}

impl Rest<'_> {
    /// Copies the text up to `start`.
    #[inline(always)]
    fn copy_to(&mut self, start: usize) -> Option<()> {
        let gap = start.checked_sub(self.cursor)?;
        let from = self.text.get(self.cursor..)?;
        let to = self.room.get_mut(self.at..)?;
        // most gaps are a comma, or the end of a row and the start of the next
        match (from.first_chunk::<ROOM>(), to.first_chunk_mut::<ROOM>()) {
            (Some(from), Some(to)) if gap <= ROOM => *to = *from,
            _ => to.get_mut(..gap)?.copy_from_slice(from.get(..gap)?),
        }
        self.at += gap;
        self.cursor = start;
        Some(())
    }
}

/// The changed numbers of a row of plain numbers, with the text before each of them. `None`: one needs the general way.
#[inline(always)]
fn pure_row(cells: &mut [Cell], row: &Rows, rest: &mut Rest) -> Option<()> {
    for (cell, (token, mantissa)) in cells.iter_mut().zip(row.tokens.iter().zip(row.mantissas)) {
        let Some(axis) = cell.axis else { continue };
        let (value, old) = (*row.new.get(axis)?, *row.old.get(axis)?);
        if value.to_bits() == old.to_bits() {
            continue;
        }
        let by = cell.offset(value - old);
        // short numbers: below 10^18 in all
        let fine = (mantissa.signed() * cell.lift[usize::from(token.decimals & 7)]).saturating_add(by);
        let count = unguarded(fine);
        let signed = if fine < 0 { -(count as i64) } else { count as i64 };
        if signed <= cell.safe[0] || signed >= cell.safe[1] {
            return None;
        }
        cell.written = true;
        rest.copy_to(token.start as usize)?;
        let place = rest.room.get_mut(rest.at..)?.first_chunk_mut::<ROOM>()?;
        rest.at += fixed(place, fine < 0, count, u32::from(cell.decimals));
        rest.cursor += usize::from(token.len);
    }
    Some(())
}

/// The changed numbers of a row of plain numbers, put into a copy of its block's `text` that begins at `from`. `None`: one changes
/// its sign or its length, or is no number for this way.
#[inline(always)]
fn patched_row(cells: &mut [Cell], row: &Rows, text: &[u8], copy: &mut [u8], from: usize) -> Option<()> {
    for (cell, (token, mantissa)) in cells.iter_mut().zip(row.tokens.iter().zip(row.mantissas)) {
        let Some(axis) = cell.axis else { continue };
        let (value, old) = (*row.new.get(axis)?, *row.old.get(axis)?);
        if value.to_bits() == old.to_bits() {
            continue;
        }
        if !cell.is_asked(value - old) {
            cell.ask(value - old);
        }
        let step = cell.last.step.as_ref().filter(|_| token.decimals == cell.decimals)?;
        let sign = u32::from(mantissa.is_negative());
        let bytes = u32::from(token.len) - sign;
        let same = cell.same[sign as usize].get(bytes as usize)?;
        if !same.has(mantissa.signed() + step.count()) {
            return None;
        }
        let at = (token.start + sign) as usize;
        let place = copy.get_mut(at.checked_sub(from)?..)?.first_chunk_mut::<8>()?;
        // from the text, not from the copy: a load would wait for what was just stored beside it
        let word = u64::from_le_bytes(*text.get(at..)?.first_chunk::<8>()?);
        *place = step.sum(word, bytes, sign == 1).to_le_bytes();
        cell.written = true;
    }
    Some(())
}

impl Cell {
    /// An offset in counts of [`GUARD`] digits beyond the last one.
    #[inline(always)]
    fn offset(&self, by: f64) -> i64 {
        let by = by * self.fine;
        (by + 0.5f64.copysign(by)) as i64
    }

    /// Whether an offset does what the last one that was asked for does.
    #[inline(always)]
    fn is_asked(&self, by: f64) -> bool {
        // false where none was asked for yet
        (by * self.fine - self.last.near).abs() < ALIKE
    }

    /// Works out what an offset does.
    #[cold]
    fn ask(&mut self, by: f64) {
        let by = self.offset(by);
        self.last = Last { near: by as f64, step: self.step_of(by) };
    }

    /// What such an offset does to numbers of the cell's decimals, if that is the same for all of them: no tie.
    fn step_of(&self, by: i64) -> Option<Step> {
        const UNIT: u64 = POW10_INT[GUARD as usize];
        let size = i64::try_from(unguarded(by)).ok()?;
        let count = if by < 0 { -size } else { size };
        (by.unsigned_abs() % UNIT != UNIT / 2).then(|| Step::new(count, self.decimals))?
    }
}

/// For numbers of so many `decimals` between the `safe` counts: those that keep sign and length ([`Cell::same`]).
pub(super) fn same_counts(decimals: u8, safe: [i64; 2]) -> [[Counts; MOST_BYTES + 1]; 2] {
    let of = |negative: bool, bytes: usize| {
        // a point, the decimals, and one digit before it at least
        let Some(whole) = bytes.checked_sub(1 + usize::from(decimals)).filter(|w| *w > 0 && decimals > 0) else {
            return Counts::default();
        };
        let power = |n: usize| POW10_INT[n.min(MOST_BYTES)] as i64;
        let digits = whole + usize::from(decimals);
        // zero has no sign, and no other number than one of a single digit before the point begins with a zero
        let (least, most) = (if whole == 1 { 1 } else { power(digits - 1) }, power(digits) - 1);
        let [least, most] = if negative { [-most, -least] } else { [least, most] };
        Counts::between(least.max(safe[0] + 1), most.min(safe[1] - 1))
    };
    [false, true].map(|negative| std::array::from_fn(|bytes| of(negative, bytes)))
}
