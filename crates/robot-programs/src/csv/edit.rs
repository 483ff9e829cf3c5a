//! New values in, rows out: only the digits that change are written, everything around them is copied.
//!
//! A changed number is the one that is written plus an offset: the sum is made of decimals, so that no digit goes through a double
//! and back ([`Decimal::offset`]). Numbers with an exponent, or with more than 18 digits, are made of doubles.
//!
//! Digits (`docs/program-csv.md`): a changed number has at least the decimals of its own token, at least those of its
//! column (so that rounding never makes a movement turn back where rows are of mixed length), and at least [`Style::least`].
//! Rounding never takes a value beyond a joint limit that the exact value keeps: there the last digit is rounded inwards.
//! The slots are in `slot.rs`, rows of plain numbers alone in `plain.rs`.

use super::super::{Block, Slot};
use super::plain::{Cell, Last, same_counts};
use super::print::{Look, power};
use super::slot::{MOST, NONE, New, SlotEdit};
use crate::axes::Axes;
use crate::decimal::print::{ROOM, fixed};
use crate::decimal::{Decimal, GUARD, POW10_INT};

/// Decimals of a column beyond which a longer token does not lengthen the others: 1e-6 deg, 1 nm.
const COLUMN_MOST: u8 = 6;
/// Decimals of the joints of an added row, where their columns have fewer (trailing zeros are dropped): a joint between two values
/// that are written short stands at 1e-4 deg or 0.1 um.
const ADDED_LEAST: u8 = 4;

/// How many decimals changed numbers get.
#[derive(Debug, Clone)]
pub struct Style {
    /// This many, whatever the tokens have.
    pub forced: Option<u8>,
    /// At least this many, per axis (deg or mm).
    pub least: Vec<u8>,
}

/// Times of a row that is written; `None`: its own, or there is none.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Clock {
    /// Time of the row, s.
    pub t_s: Option<f64>,
    /// Time from the row before, in the unit of its column.
    pub duration: Option<f64>,
}

impl Clock {
    /// The time of a row, s.
    pub fn at(t_s: Option<f64>) -> Self {
        Self { t_s, duration: None }
    }
}

/// Writes the changed numbers of a program's rows.
#[derive(Debug, Clone)]
pub struct Edits {
    slots: Vec<SlotEdit>,
    /// The slots once more as rows of plain numbers need them; empty where the present block is not of that kind.
    pub(super) cells: Vec<Cell>,
    forced: Option<u8>,
    scratch: Vec<u8>,
    /// Where rows of plain numbers are made.
    pub(super) room: Vec<u8>,
}

impl Edits {
    /// For rows whose numbers are `slots`.
    pub fn new(slots: &[Slot], robot: &Axes, style: &Style) -> Self {
        let slots = slots.iter().map(|&slot| {
            let (to_user_unit, least, limits) = match slot {
                Slot::Time(per_s) => (f64::from(per_s), 0, None),
                Slot::Duration => (1.0, 0, None),
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

    /// Call it with every block before its rows are written.
    pub fn begin(&mut self, block: &Block) {
        self.note_written();
        self.cells.clear();
        let mut even = true;
        for (edit, &d) in self.slots.iter_mut().zip(&block.decimals) {
            edit.column = edit.column.max(d);
            edit.base = match (self.forced, edit.slot) {
                (Some(n), Slot::Axis(_)) => n,
                (_, Slot::Axis(_)) => edit.least.max(edit.column.min(COLUMN_MOST.max(edit.least))),
                (_, Slot::Time(_) | Slot::Duration) => edit.column,
            };
            let axis = match edit.slot {
                Slot::Axis(a) => Some(a),
                Slot::Time(_) | Slot::Duration => None,
            };
            even &= edit.base <= 7 && (d <= edit.base || self.forced.is_some() && d <= edit.base + GUARD);
            let place = usize::from(edit.base.min(7) + GUARD);
            let fine = edit.to_user_unit * power(place);
            let lift = std::array::from_fn(|d| POW10_INT[place.saturating_sub(d)] as i64);
            let scale = edit.scale[usize::from(edit.base).min(MOST)];
            // a limit in last digits is rounded inwards; a number of its own kind, else none passes
            let [lo, hi] = edit.safe.map(|v| (v * scale).clamp(-1e8, 1e8));
            let safe = [lo.ceil() as i64, hi.floor() as i64];
            let same = same_counts(edit.base, safe);
            let (decimals, last) = (edit.base, Last::default());
            self.cells.push(Cell { axis, decimals, fine, lift, safe, written: false, last, same });
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
        clock: Clock,
        out: &mut Vec<u8>,
    ) -> usize {
        let n = self.slots.len();
        let axes = q.len();
        let old = &block.q[i * axes..(i + 1) * axes];
        let tokens = &block.tokens[i * n..(i + 1) * n];
        let old_t_s = block.t_s.get(i).copied();
        let changed = |slot: Slot| match slot {
            Slot::Axis(a) => (q[a].to_bits() != old[a].to_bits()).then_some(q[a]),
            Slot::Time(_) => clock.t_s.filter(|t| Some(t.to_bits()) != old_t_s.map(f64::to_bits)),
            Slot::Duration => clock.duration,
        };
        let own = |slot: Slot| match slot {
            Slot::Axis(a) => old[a],
            Slot::Time(_) => old_t_s.unwrap_or(0.0),
            Slot::Duration => block.durations.get(i).copied().unwrap_or(0.0),
        };
        let Some(first) = self.slots.iter().position(|s| changed(s.slot).is_some()) else { return cursor };
        // plain numbers one after the other, as in nearly every row: their text is made in one piece of memory
        let start = tokens[first].start as usize;
        let mut k = first;
        // (spaces in front belong to the width of a cell, which the general way keeps)
        if clock.duration.is_none() && !matches!(start.checked_sub(1).map(|b| block.text[b]), Some(b' ')) {
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
            if edit.slot == Slot::Duration {
                cursor = edit.time(block, token, cursor, value, &mut self.scratch, out);
                continue;
            }
            let decimals = self.forced.unwrap_or(token.decimals.max(edit.base));
            let old = Some(own(edit.slot));
            cursor = edit.number(block, token, cursor, New { old, value, decimals }, &mut self.scratch, out);
        }
        cursor
    }

    /// Writes an added row after row `i`: its cells are those of row `i`, its targets and time are new.
    pub fn added(&mut self, block: &Block, i: usize, q: &[f64], clock: Clock, out: &mut Vec<u8>) {
        let n = self.slots.len();
        let span = block.rows[i];
        let (mut cursor, end) = (span.start as usize, span.end as usize);
        for (edit, token) in self.slots.iter_mut().zip(&block.tokens[i * n..(i + 1) * n]) {
            let start = token.start as usize;
            // the zeros at the end of an exponent are none of a fraction
            let exponent = !token.plain && Look::of(&block.text[start..start + usize::from(token.len)]).has_exponent();
            match edit.slot {
                Slot::Axis(a) => {
                    let own = self.forced.unwrap_or(token.decimals.max(edit.base));
                    let decimals = self.forced.unwrap_or(own.max(ADDED_LEAST));
                    let new = New { old: None, value: q[a], decimals };
                    cursor = edit.number(block, token, cursor, new, &mut self.scratch, out);
                    if !exponent {
                        drop_zeros(out, usize::from(decimals), usize::from(own));
                    }
                }
                Slot::Time(_) => {
                    let own = block.t_s.get(i).copied().unwrap_or(0.0);
                    cursor = edit.time(block, token, cursor, clock.t_s.unwrap_or(own), &mut self.scratch, out);
                }
                Slot::Duration => {
                    let own = block.durations.get(i).copied().unwrap_or(0.0);
                    cursor = edit.time(block, token, cursor, clock.duration.unwrap_or(own), &mut self.scratch, out);
                }
            }
        }
        out.extend_from_slice(&block.text[cursor..end]);
    }
}

/// Drops zeros at the end of a fraction of `decimals` digits down to `fewest` of them.
pub(super) fn drop_zeros(out: &mut Vec<u8>, decimals: usize, fewest: usize) {
    let mut have = decimals;
    while have > fewest && out.last() == Some(&b'0') {
        out.pop();
        have -= 1;
    }
    if have == 0 && out.last() == Some(&b'.') {
        out.pop();
    }
}

#[cfg(test)]
mod tests {
    use super::super::Reader;
    use super::*;
    use crate::axes::{Axis, JointKind};
    use proptest::prelude::*;
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
            cursor = edits.row(&block, i, cursor, q, Clock::default(), &mut out);
            if let Some((q, t_s)) = added.filter(|_| i == 0) {
                let end = block.rows[0].end as usize;
                out.extend_from_slice(&block.text[cursor..end]);
                cursor = end;
                edits.added(&block, 0, &q.map(f64::to_radians), Clock::at(Some(t_s)), &mut out);
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

    proptest! {
        #[test]
        fn rows_of_plain_numbers_are_written_as_one_by_one(
            rows in prop::collection::vec((-130_000i32..130_000, -4_000i32..4_000, 0u8..4), 1..120),
            by in (-3e-3..3e-3f64, -3e-3..3e-3f64), coarse in -2i32..5
        ) {
            // the digits before the point and the sign change here and there; some numbers have another length
            let fixed = |n: i32, d: usize| format!("{:.d$}", f64::from(n) / 1e4);
            let cells = rows.iter().map(|&(a, b, kind)| {
                let decimals = if kind == 0 { 3 } else { 4 };
                format!("{},{}\n", fixed(a / 10i32.pow(coarse.max(0) as u32), decimals), fixed(b, 4))
            });
            let text: String = std::iter::once("a_deg,b_deg\n".to_string()).chain(cells).collect();
            let own = text.lines().skip(1).flat_map(|l| l.split(',').map(|c| c.parse::<f64>().unwrap()));
            // the same offset for several rows, none for others
            let new: Vec<f64> = own
                .enumerate()
                .map(|(k, v)| match (k / 2 % 37, k % 2) {
                    (0, _) | (_, 1) => v,
                    (19.., _) => v - by.0,
                    (_, _) => v + by.1,
                })
                .collect();
            // compares the two ways
            edited(&text, &new, None);
        }
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
    fn an_added_row_keeps_the_exponents_of_its_style() {
        let text = "t_s,a_deg,b_deg\n0e0,1.0e0,5e-1\n2e0,20.0e0,5e-1\n";
        let out = edited(text, &[1.0, 0.5, 20.0, 0.5], Some(([10.5, 0.25], 1.5)));
        let added: Vec<f64> = out.lines().nth(2).unwrap().split(',').map(|c| c.parse().unwrap()).collect();
        assert!(added.iter().zip([1.5, 10.5, 0.25]).all(|(got, want)| (got - want).abs() < 1e-9), "{out}");
    }

    #[test]
    fn a_time_of_many_digits_is_the_double_that_was_given() {
        let t_s = 611.292_795_180_113_4;
        let text = "t_s,a_deg,b_deg\n611.000000000000,1.0,0.5\n612.000000000000,2.0,0.5\n";
        let out = edited(text, &[1.0, 0.5, 2.0, 0.5], Some(([1.5, 0.5], t_s)));
        assert_eq!(out.lines().nth(2), Some(format!("{t_s:.12},1.5,0.5").as_str()));
    }
}
