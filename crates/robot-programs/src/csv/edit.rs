//! New values in, rows out: only the digits that change are written, everything around them is copied.
//!
//! A changed number is the one that is written plus an offset: the sum is made of decimals, so that no digit goes through a double
//! and back ([`Decimal::offset`]). Numbers with an exponent, or with more than 18 digits, are made of doubles.
//!
//! Digits (`docs/program-csv.md`): a changed number has at least the decimals of its own token, at least those of its
//! column (so that rounding never makes a movement turn back where rows are of mixed length), and at least [`Style::least`].
//! Rounding never takes a value beyond a joint limit that the exact value keeps: there the last digit is rounded inwards.

use super::super::{Block, Slot, Token};
use super::print::{Look, power};
use crate::axes::Axes;
use crate::decimal::patch::Step;
use crate::decimal::print::{MOST_FIXED, ROOM, fixed};
use crate::decimal::read::Packed;
use crate::decimal::{Decimal, GUARD, POW10_INT, unguarded};

/// Decimals of a column beyond which a longer token does not lengthen the others: 1e-6 deg, 1 nm.
const COLUMN_MOST: u8 = 6;
/// Decimals of the time of an added row, where its column has fewer (trailing zeros are dropped): 1 us.
const TIME_LEAST: u8 = 6;
/// Decimals of the joints of an added row, where their columns have fewer (trailing zeros are dropped): a joint between two values
/// that are written short stands at 1e-4 deg or 0.1 um.
const ADDED_LEAST: u8 = 4;
const MOST: usize = 15;

/// How many decimals changed numbers get.
#[derive(Debug, Clone)]
pub struct Style {
    /// This many, whatever the tokens have.
    pub forced: Option<u8>,
    /// At least this many, per axis (deg or mm).
    pub least: Vec<u8>,
}

/// Writes the changed numbers of a program's rows.
#[derive(Debug, Clone)]
pub struct Edits {
    slots: Vec<SlotEdit>,
    /// The slots once more as rows of plain numbers need them; empty where the present block is not of that kind.
    cells: Vec<Cell>,
    forced: Option<u8>,
    scratch: Vec<u8>,
    /// Where rows of plain numbers are made.
    room: Vec<u8>,
}

/// A slot whose numbers all get the same decimals in the present block.
#[derive(Debug, Clone)]
struct Cell {
    /// `None`: the time.
    axis: Option<usize>,
    decimals: u8,
    /// Counts of [`GUARD`] digits beyond the last one, in one rad or m.
    fine: f64,
    /// The same in a last digit of a number that has so many decimals.
    lift: [i64; 8],
    /// Counts of last digits between which the number has 8 digits at most and rounding reaches no limit.
    safe: [i64; 2],
    /// A number was written.
    written: bool,
    /// The offset that was last asked for, in counts as `fine`, and what it does to a number of these decimals; `None`: it has to be
    /// made anew.
    step: (i64, Option<Step>),
}

/// Bytes of a plain number.
const LONGEST: usize = 10;
/// Rows whose text is copied in one piece to be patched.
const PATCHED: usize = 32;

/// What a number is to become.
struct New {
    /// The value that it has, if it is a row's own; an added row's number is none.
    old: Option<f64>,
    value: f64,
    decimals: u8,
}

#[derive(Debug, Clone)]
struct SlotEdit {
    slot: Slot,
    /// SI to edge unit.
    to_user_unit: f64,
    /// `to_user_unit * 10^d`.
    scale: [f64; MOST + 1],
    least: u8,
    /// Most decimals of the column so far.
    column: u8,
    /// Fewest decimals of a changed or added number.
    base: u8,
    /// Limits in the edge unit, and the range (SI) in which no rounding reaches them.
    limits: Option<[f64; 2]>,
    /// The same as decimals.
    exact_limits: Option<[Decimal; 2]>,
    safe: [f64; 2],
    /// Fewest decimals written so far; [`NONE`]: no number was written.
    written: u8,
}

const NONE: u8 = u8::MAX;
/// deg or mm: a limit itself must not be taken for beyond it.
const SLACK: f64 = 1e-9;

impl Edits {
    /// For rows whose numbers are `slots`.
    pub fn new(slots: &[Slot], robot: &Axes, style: &Style) -> Self {
        let slots = slots.iter().map(|&slot| {
            let (to_user_unit, least, limits) = match slot {
                Slot::Time => (1.0, 0, None),
                Slot::Axis(a) => {
                    let joint = robot.axis(a);
                    // 1e-9 deg or mm: what the limits lost on their way to SI and back
                    let edge = |v: f64| (joint.kind.to_user_unit(v) * 1e9).round() / 1e9;
                    let least = style.least.get(a).copied().unwrap_or(0);
                    (joint.kind.to_user_unit(1.0), least, joint.limits.map(|l| l.map(edge)))
                }
            };
            let mut scale = [0.0; MOST + 1];
            for (d, s) in scale.iter_mut().enumerate() {
                *s = to_user_unit * power(d);
            }
            let exact = |v: f64| Decimal::nearest(v, 9);
            let exact_limits = limits.and_then(|[lo, hi]| Some([exact(lo)?, exact(hi)?]));
            // a unit of the first digit before the point is more than any rounding
            let safe = limits
                .map_or([f64::NEG_INFINITY, f64::INFINITY], |[lo, hi]| [lo + 1.0, hi - 1.0].map(|v| v / to_user_unit));
            SlotEdit {
                slot,
                to_user_unit,
                scale,
                least,
                column: 0,
                base: least,
                limits,
                exact_limits,
                safe,
                written: NONE,
            }
        });
        Self { slots: slots.collect(), cells: Vec::new(), forced: style.forced, scratch: Vec::new(), room: Vec::new() }
    }

    /// Takes over what `other` knows of the columns; what was written stays.
    pub fn resume(&mut self, other: &Edits) {
        self.note_written();
        for (edit, other) in self.slots.iter_mut().zip(&other.slots) {
            (edit.column, edit.base) = (other.column, other.base);
        }
        self.cells.clone_from(&other.cells);
    }

    /// To be told of every block before its rows are written.
    pub fn begin(&mut self, block: &Block) {
        self.note_written();
        self.cells.clear();
        let mut even = true;
        for (edit, &d) in self.slots.iter_mut().zip(&block.decimals) {
            edit.column = edit.column.max(d);
            edit.base = match (self.forced, edit.slot) {
                (Some(n), Slot::Axis(_)) => n,
                (_, Slot::Axis(_)) => edit.least.max(edit.column.min(COLUMN_MOST.max(edit.least))),
                (_, Slot::Time) => edit.column,
            };
            let axis = match edit.slot {
                Slot::Axis(a) => Some(a),
                Slot::Time => None,
            };
            even &= edit.base <= 7 && (d <= edit.base || self.forced.is_some() && d <= edit.base + GUARD);
            let place = usize::from(edit.base.min(7) + GUARD);
            let fine = edit.to_user_unit * power(place);
            let lift = std::array::from_fn(|d| POW10_INT[place.saturating_sub(d)] as i64);
            let scale = edit.scale[usize::from(edit.base).min(MOST)];
            // a limit in last digits is rounded inwards; a number of its own kind, else none passes
            let [lo, hi] = edit.safe.map(|v| (v * scale).clamp(-1e8, 1e8));
            let safe = [lo.ceil() as i64, hi.floor() as i64];
            self.cells.push(Cell { axis, decimals: edit.base, fine, lift, safe, written: false, step: (0, None) });
        }
        if !even {
            self.cells.clear();
        }
    }

    /// Carries what the cells of a block have written over to their slots.
    fn note_written(&mut self) {
        for (edit, cell) in self.slots.iter_mut().zip(&mut self.cells) {
            if std::mem::take(&mut cell.written) {
                edit.written = edit.written.min(cell.decimals);
            }
        }
    }

    /// Fewest decimals with which numbers of an axis were written (deg or mm); `None`: none was written.
    pub fn written(&self, axis: usize) -> Option<u8> {
        let k = self.slots.iter().position(|s| s.slot == Slot::Axis(axis))?;
        let cell = self.cells.get(k).filter(|c| c.written).map_or(NONE, |c| c.decimals);
        Some(self.slots[k].written.min(cell)).filter(|&w| w != NONE)
    }

    /// Writes row `i` with the targets `q` as far as they differ, from the place `cursor` of its block on; gives the place up
    /// to which the block's text has been written. An untouched row writes nothing.
    #[inline]
    pub fn row(
        &mut self,
        block: &Block,
        i: usize,
        mut cursor: usize,
        q: &[f64],
        t_s: Option<f64>,
        out: &mut Vec<u8>,
    ) -> usize {
        let n = self.slots.len();
        let axes = q.len();
        let old = &block.q[i * axes..(i + 1) * axes];
        let tokens = &block.tokens[i * n..(i + 1) * n];
        let old_t_s = block.t_s.get(i).copied();
        let changed = |slot: Slot| match slot {
            Slot::Axis(a) => (q[a].to_bits() != old[a].to_bits()).then_some(q[a]),
            Slot::Time => t_s.filter(|t| Some(t.to_bits()) != old_t_s.map(f64::to_bits)),
        };
        let own = |slot: Slot| match slot {
            Slot::Axis(a) => old[a],
            Slot::Time => old_t_s.unwrap_or(0.0),
        };
        let Some(first) = self.slots.iter().position(|s| changed(s.slot).is_some()) else { return cursor };
        // plain numbers one behind the other, as in nearly every row: their text is made in one piece of memory
        let start = tokens[first].start as usize;
        let mut k = first;
        // (spaces in front belong to the width of a cell, which the general way keeps)
        if !matches!(start.checked_sub(1).map(|b| block.text[b]), Some(b' ')) {
            out.extend_from_slice(&block.text[cursor..start]);
            cursor = start;
            let length = out.len();
            out.resize(length + (n - first) * (ROOM + 1) + ROOM, 0);
            let room = &mut out[length..];
            let mut at = 0;
            while k < n {
                let (edit, token) = (&mut self.slots[k], &tokens[k]);
                let Some(value) = changed(edit.slot) else { break };
                let decimals = self.forced.unwrap_or(token.decimals.max(edit.base));
                let gap = token.start as usize - cursor;
                let old = (block.mantissas[i * n + k], own(edit.slot));
                let count = edit.count(token, old, value, decimals).filter(|_| gap <= 1);
                let Some((negative, count)) = count else { break };
                room[at] = block.text[cursor];
                at += gap;
                let Some(place) = room[at..].first_chunk_mut::<ROOM>() else { break };
                at += fixed(place, negative, count, u32::from(decimals));
                edit.written = edit.written.min(decimals);
                cursor = token.start as usize + usize::from(token.len);
                k += 1;
            }
            out.truncate(length + at);
        }
        for (edit, token) in self.slots[k..].iter_mut().zip(&tokens[k..]) {
            let Some(value) = changed(edit.slot) else { continue };
            let decimals = self.forced.unwrap_or(token.decimals.max(edit.base));
            let old = Some(own(edit.slot));
            cursor = edit.number(block, token, cursor, New { old, value, decimals }, &mut self.scratch, out);
        }
        cursor
    }

    /// Writes rows of plain numbers alone ([`Block::pure`]) from row `i` on, with the targets `q` (row behind row, `axes` in
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
        let (mut done, mut cursor) = (0, cursor);
        for q in q.chunks(PATCHED * axes) {
            let rows = q.len() / axes;
            let mut part = 0;
            while part < rows {
                let (patched, end) = self.patched_rows(block, i + done + part, cursor, &q[part * axes..], axes, out);
                part += patched;
                cursor = end;
                if part == rows {
                    break;
                }
                // one row whose numbers change their length, or all of them
                let next = if patched == 0 { rows } else { part + 1 };
                let q = &q[part * axes..next * axes];
                let (made, end) = self.made_rows(block, i + done + part, cursor, q, axes, out);
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

    /// [`Edits::pure_rows`] by new digits in a copy of the text, as far as all numbers of a row keep sign and length.
    fn patched_rows(
        &mut self,
        block: &Block,
        i: usize,
        cursor: usize,
        q: &[f64],
        axes: usize,
        out: &mut Vec<u8>,
    ) -> (usize, usize) {
        let (n, rows) = (self.cells.len(), q.len() / axes);
        let old = &block.q[i * axes..(i + rows) * axes];
        let tokens = &block.tokens[i * n..(i + rows) * n];
        let mantissas = &block.mantissas[i * n..(i + rows) * n];
        let last = tokens[rows * n - 1];
        let end = last.start as usize + usize::from(last.len);
        let base = out.len();
        out.extend_from_slice(&block.text[cursor..(end + 8).min(block.text.len())]);
        let copy = &mut out[base..];
        let targets = q.chunks_exact(axes).zip(old.chunks_exact(axes));
        let numbers = tokens.chunks_exact(n).zip(mantissas.chunks_exact(n));
        for (k, ((q, old), (tokens, mantissas))) in targets.zip(numbers).enumerate() {
            if patched_row(&mut self.cells, q, old, tokens, mantissas, copy, cursor).is_none() {
                let start = tokens[0].start as usize;
                out.truncate(base + start - cursor);
                return (k, start);
            }
        }
        out.truncate(base + end - cursor);
        (rows, end)
    }

    /// [`Edits::pure_rows`] by numbers that are made one by one.
    fn made_rows(
        &mut self,
        block: &Block,
        i: usize,
        cursor: usize,
        q: &[f64],
        axes: usize,
        out: &mut Vec<u8>,
    ) -> (usize, usize) {
        let (n, rows) = (self.cells.len(), q.len() / axes);
        let old = &block.q[i * axes..(i + rows) * axes];
        let tokens = &block.tokens[i * n..(i + rows) * n];
        let mantissas = &block.mantissas[i * n..(i + rows) * n];
        let last = tokens[rows * n - 1];
        // the text up to the last number, and what changed numbers may add to it
        let most = (last.start as usize + usize::from(last.len)).saturating_sub(cursor) + rows * n * LONGEST;
        if self.room.len() < most + 2 * ROOM {
            self.room.resize(2 * most + 2 * ROOM, 0);
        }
        let mut rest = Rest { text: &block.text, cursor, room: &mut self.room, at: 0 };
        let mut done = 0;
        let targets = q.chunks_exact(axes).zip(old.chunks_exact(axes));
        let numbers = tokens.chunks_exact(n).zip(mantissas.chunks_exact(n));
        for ((q, old), (tokens, mantissas)) in targets.zip(numbers) {
            let (cursor, at) = (rest.cursor, rest.at);
            if pure_row(&mut self.cells, q, old, tokens, mantissas, &mut rest).is_none() {
                (rest.cursor, rest.at) = (cursor, at);
                break;
            }
            done += 1;
        }
        let (at, cursor) = (rest.at, rest.cursor);
        out.extend_from_slice(&self.room[..at]);
        (done, cursor)
    }

    /// Writes an added row behind row `i`: its cells are those of row `i`, its targets and time are new.
    pub fn added(&mut self, block: &Block, i: usize, q: &[f64], t_s: Option<f64>, out: &mut Vec<u8>) {
        let n = self.slots.len();
        let span = block.rows[i];
        let (mut cursor, end) = (span.start as usize, span.end as usize);
        for (edit, token) in self.slots.iter_mut().zip(&block.tokens[i * n..(i + 1) * n]) {
            match edit.slot {
                Slot::Axis(a) => {
                    let own = self.forced.unwrap_or(token.decimals.max(edit.base));
                    let decimals = self.forced.unwrap_or(own.max(ADDED_LEAST));
                    let new = New { old: None, value: q[a], decimals };
                    cursor = edit.number(block, token, cursor, new, &mut self.scratch, out);
                    drop_zeros(out, usize::from(decimals), usize::from(own));
                }
                Slot::Time => {
                    let decimals = token.decimals.max(edit.base).max(TIME_LEAST);
                    let fewest = usize::from(token.decimals.max(edit.base));
                    let new = New { old: None, value: t_s.unwrap_or(block.t_s[i]), decimals };
                    cursor = edit.number(block, token, cursor, new, &mut self.scratch, out);
                    drop_zeros(out, usize::from(decimals), fewest);
                }
            }
        }
        out.extend_from_slice(&block.text[cursor..end]);
    }
}

/// Text that has not been copied, and room for what is written.
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
fn pure_row(
    cells: &mut [Cell],
    q: &[f64],
    old: &[f64],
    tokens: &[Token],
    mantissas: &[Packed],
    rest: &mut Rest,
) -> Option<()> {
    for (cell, (token, mantissa)) in cells.iter_mut().zip(tokens.iter().zip(mantissas)) {
        let Some(axis) = cell.axis else { continue };
        let (value, old) = (*q.get(axis)?, *old.get(axis)?);
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

/// The changed numbers of a row of plain numbers, put into a copy of its block's text that begins at `from`. `None`: one changes
/// its sign or its length, or is no number for this way.
#[inline(always)]
fn patched_row(
    cells: &mut [Cell],
    q: &[f64],
    old: &[f64],
    tokens: &[Token],
    mantissas: &[Packed],
    copy: &mut [u8],
    from: usize,
) -> Option<()> {
    for (cell, (token, mantissa)) in cells.iter_mut().zip(tokens.iter().zip(mantissas)) {
        let Some(axis) = cell.axis else { continue };
        let (value, old) = (*q.get(axis)?, *old.get(axis)?);
        if value.to_bits() == old.to_bits() {
            continue;
        }
        let by = cell.offset(value - old);
        if by != cell.step.0 {
            cell.step = (by, cell.step_of(by));
        }
        let step = cell.step.1.filter(|_| token.decimals == cell.decimals)?;
        let count = mantissa.signed() + step.count();
        if count <= cell.safe[0] || count >= cell.safe[1] {
            return None;
        }
        let sign = u32::from(mantissa.is_negative());
        let at = (token.start + sign) as usize;
        let place = copy.get_mut(at.checked_sub(from)?..)?.first_chunk_mut::<8>()?;
        let new = step.add(u64::from_le_bytes(*place), u32::from(token.len) - sign, sign == 1)?;
        *place = new.to_le_bytes();
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

    /// What such an offset does to numbers of the cell's decimals, if that is the same for all of them: no tie.
    #[cold]
    fn step_of(&self, by: i64) -> Option<Step> {
        const UNIT: u64 = POW10_INT[GUARD as usize];
        let size = i64::try_from(unguarded(by)).ok()?;
        let count = if by < 0 { -size } else { size };
        (by.unsigned_abs() % UNIT != UNIT / 2).then(|| Step::new(count, self.decimals))?
    }
}

/// Drops zeros at the end of a fraction of `decimals` digits down to `fewest` of them.
fn drop_zeros(out: &mut Vec<u8>, decimals: usize, fewest: usize) {
    let mut have = decimals;
    while have > fewest && out.last() == Some(&b'0') {
        out.pop();
        have -= 1;
    }
    if have == 0 && out.last() == Some(&b'.') {
        out.pop();
    }
}

impl SlotEdit {
    /// Sign and count of last digits of a value that is written plainly and is near no limit.
    #[inline(always)]
    fn count(&self, token: &Token, old: (Packed, f64), value: f64, decimals: u8) -> Option<(bool, u64)> {
        if !token.plain || decimals > 7 || !self.is_safe(value) {
            return None;
        }
        let new = old.0.decimal(token.decimals)?.offset((value - old.1) * self.to_user_unit, decimals)?;
        let count = new.mantissa().unsigned_abs();
        (count < MOST_FIXED).then_some((new.is_negative(), count))
    }

    /// No rounding reaches a limit.
    #[inline(always)]
    fn is_safe(&self, value: f64) -> bool {
        value > self.safe[0] && value < self.safe[1]
    }

    /// The number that takes the place of the one with this text; near a limit that it keeps, rounded so that it still keeps it.
    /// `None`: it is no decimal.
    fn decimal(&self, text: &[u8], new: &New) -> Option<Decimal> {
        let own = Decimal::read(text)?;
        let number = match new.old {
            Some(old) => own.offset((new.value - old) * self.to_user_unit, new.decimals)?,
            None => {
                let count = new.value * self.scale.get(usize::from(new.decimals))?;
                // of longer numbers the product's own rounding would show
                if new.decimals > 7 || count.abs() >= MOST_FIXED as f64 {
                    return None;
                }
                Decimal::new((count + 0.5f64.copysign(count)) as i64, new.decimals)?
            }
        };
        let Some([lo, hi]) = self.exact_limits.filter(|_| !self.is_safe(new.value)) else { return Some(number) };
        let exact = new.value * self.to_user_unit;
        match () {
            () if number > hi && exact <= hi.value() + SLACK => hi.floor(new.decimals),
            () if number < lo && exact >= lo.value() - SLACK => lo.ceil(new.decimals),
            () => Some(number),
        }
    }

    /// Writes the text from `cursor` to the token, then the number; gives the place behind the token.
    #[inline(always)]
    fn number(
        &mut self,
        block: &Block,
        token: &Token,
        cursor: usize,
        new: New,
        scratch: &mut Vec<u8>,
        out: &mut Vec<u8>,
    ) -> usize {
        let start = token.start as usize;
        let gap = &block.text[cursor..start];
        match gap {
            [one] => out.push(*one),
            many => out.extend_from_slice(many),
        }
        let from = out.len();
        self.written = self.written.min(new.decimals);
        let end = start + usize::from(token.len);
        let text = &block.text[start..end];
        match self.decimal(text, &new) {
            Some(number) if token.plain => number.write(out),
            Some(number) => Look::of(text).write_decimal(number, out),
            None => {
                let rounded = self.rounded(new.value, new.decimals);
                Look::of(text).write(rounded, usize::from(new.decimals), out);
            }
        }
        if gap.len() > 1 {
            pad(gap, usize::from(token.len), from, out, scratch);
        }
        end
    }

    /// The value in the edge unit; near a limit that it keeps, rounded so that it still keeps it.
    #[cold]
    fn rounded(&self, value: f64, decimals: u8) -> f64 {
        let exact = value * self.to_user_unit;
        let Some([lo, hi]) = self.limits else { return exact };
        let unit = power(usize::from(decimals.min(22)));
        let count = (exact * unit).abs().round().copysign(exact);
        if exact <= hi + SLACK && count / unit > hi + SLACK {
            return (hi * unit + 1e-6).floor() / unit;
        }
        if exact >= lo - SLACK && count / unit < lo - SLACK {
            return (lo * unit - 1e-6).ceil() / unit;
        }
        exact
    }
}

/// Keeps the width of a cell that is padded with two or more spaces on its left, as far as they reach (one is kept).
fn pad(gap: &[u8], old: usize, from: usize, out: &mut Vec<u8>, scratch: &mut Vec<u8>) {
    let spaces = gap.iter().rev().take_while(|&&b| b == b' ').count();
    let new = out.len() - from;
    if spaces < 2 || new == old {
        return;
    }
    scratch.clear();
    scratch.extend_from_slice(&out[from..]);
    out.truncate(from - spaces);
    let keep = (spaces + old).saturating_sub(new).max(1);
    out.resize(out.len() + keep, b' ');
    out.extend_from_slice(scratch);
}

#[cfg(test)]
mod tests {
    use super::super::Reader;
    use super::*;
    use crate::axes::{Axis, JointKind};
    use std::io::Cursor;

    /// A program of two axes, one of them with limits, through new targets (deg) of all rows; `added` follows the first row.
    fn edited(text: &str, q_deg: &[f64], added: Option<([f64; 2], f64)>) -> String {
        let limited =
            Axis { limits: Some([-0.996, 0.996].map(f64::to_radians)), ..Axis::new("B", JointKind::Revolute) };
        let axes = Axes::new("two", vec![Axis::new("A", JointKind::Revolute), limited]);
        let mut reader = Reader::new(Box::new(Cursor::new(text.as_bytes().to_vec())), "p.csv", &axes).unwrap();
        let mut block = Block::default();
        assert!(reader.next(&mut block).unwrap());
        let mut edits = Edits::new(reader.slots(), &axes, &Style { forced: None, least: vec![0; 2] });
        edits.begin(&block);
        let q: Vec<f64> = q_deg.iter().map(|v| v.to_radians()).collect();
        let (mut out, mut cursor) = (Vec::new(), 0);
        for (i, q) in q.chunks(2).enumerate() {
            cursor = edits.row(&block, i, cursor, q, None, &mut out);
            if let Some((q, t_s)) = added.filter(|_| i == 0) {
                let end = block.rows[0].end as usize;
                out.extend_from_slice(&block.text[cursor..end]);
                cursor = end;
                edits.added(&block, 0, &q.map(f64::to_radians), Some(t_s), &mut out);
            }
        }
        out.extend_from_slice(&block.text[cursor..]);
        // rows of plain numbers alone: the fast ways write the same
        if added.is_none() && block.pure == block.rows.len() {
            let mut fast = Vec::new();
            let (done, end) = edits.pure_rows(&block, 0, 0, &q, 2, &[], &mut fast);
            let rest = q.len() / 2 - done;
            assert!(rest == 0 || q_deg.iter().any(|v| v.abs() > 0.9), "{rest} rows are left");
            if rest == 0 {
                fast.extend_from_slice(&block.text[end..]);
                assert_eq!(String::from_utf8(fast).unwrap(), String::from_utf8(out.clone()).unwrap());
            }
        }
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn offsets_are_added_digit_by_digit_and_halves_go_away_from_zero() {
        let rows: String = (0..100).map(|k| format!("{}.{:04},0.1000\n", k % 12 - 6, (k * 1237) % 10_000)).collect();
        let text = format!("a_deg,b_deg\n{rows}");
        let own: Vec<f64> = rows.lines().flat_map(|l| l.split(',').map(|c| c.parse().unwrap())).collect();
        // a half at four digits, which the sum of doubles rounds by its noise
        let new: Vec<f64> = own.iter().enumerate().map(|(k, v)| if k % 2 == 0 { v + 0.00285 } else { *v }).collect();
        let want: String = rows
            .lines()
            .map(|l| {
                let (a, b) = l.split_once(',').unwrap();
                let digits: i64 = a.replace('.', "").parse().unwrap();
                // in hundred thousandths
                let sum = digits * 10 + 285;
                let count = (sum.abs() + 5) / 10;
                let sign = if sum < 0 && count > 0 { "-" } else { "" };
                format!("{sign}{}.{:04},{b}\n", count / 10_000, count % 10_000)
            })
            .collect();
        assert_eq!(edited(&text, &new, None), format!("a_deg,b_deg\n{want}"));
    }

    #[test]
    fn numbers_that_change_sign_or_length_are_made_anew() {
        let text = "a_deg,b_deg\n9.9990,0.1\n-0.0010,0.1\n10.0000,0.1\n-0.0028,0.1\n";
        let new = [10.0018, 0.1, 0.0018, 0.1, 9.9972, 0.1, 0.0, 0.1];
        let want = "a_deg,b_deg\n10.0018,0.1\n0.0018,0.1\n9.9972,0.1\n0.0000,0.1\n";
        assert_eq!(edited(text, &new, None), want);
    }

    #[test]
    fn rounding_stays_within_a_limit() {
        // 0.9959 is 1.00 at two digits, which is beyond 0.996
        let text = "a_deg,b_deg\n0.0,0.98\n0.0,-0.98\n";
        assert_eq!(edited(text, &[0.0, 0.9959, 0.0, -0.9959], None), "a_deg,b_deg\n0.0,0.99\n0.0,-0.99\n");
        // the limit itself, at digits that hold it
        let text = "a_deg,b_deg\n0.0,0.980\n";
        assert_eq!(edited(text, &[0.0, 0.996], None), "a_deg,b_deg\n0.0,0.996\n");
    }

    #[test]
    fn a_time_of_many_digits_is_the_double_that_was_given() {
        let t_s = 611.292_795_180_113_4;
        let text = "t_s,a_deg,b_deg\n611.000000000000,1.0,0.5\n612.000000000000,2.0,0.5\n";
        let out = edited(text, &[1.0, 0.5, 2.0, 0.5], Some(([1.5, 0.5], t_s)));
        assert_eq!(out.lines().nth(2), Some(format!("{t_s:.12},1.5,0.5").as_str()));
    }
}
