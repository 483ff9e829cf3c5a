//! One changed number of a slot: its offset, its digits, its limits, and its place in the row.

use super::super::{Block, Slot, Token};
use super::edit::drop_zeros;
use super::print::{Look, power};
use crate::decimal::Decimal;
use crate::decimal::print::MOST_FIXED;
use crate::decimal::read::Packed;

pub(super) const MOST: usize = 15;
pub(super) const NONE: u8 = u8::MAX;
/// deg or mm: a limit itself must not be taken for beyond it.
pub(super) const SLACK: f64 = 1e-9;

/// Decimals of the time of an added row, where its column has fewer (trailing zeros are dropped): 1 us.
pub const TIME_LEAST: u8 = 6;

/// The same in the unit of a column of times.
fn time_decimals(slot: Slot) -> u8 {
    match slot {
        Slot::Time(per_s) => TIME_LEAST.saturating_sub(per_s.ilog10() as u8),
        _ => TIME_LEAST,
    }
}

/// What a number is to become.
pub(super) struct New {
    /// The value that it has, if it is a row's own; an added row's number is none.
    pub(super) old: Option<f64>,
    pub(super) value: f64,
    pub(super) decimals: u8,
}

#[derive(Debug, Clone)]
pub(super) struct SlotEdit {
    pub(super) slot: Slot,
    /// SI to edge unit.
    pub(super) to_user_unit: f64,
    /// `to_user_unit * 10^d`.
    pub(super) scale: [f64; MOST + 1],
    pub(super) least: u8,
    /// Most decimals of the column so far.
    pub(super) column: u8,
    /// Fewest decimals of a changed or added number.
    pub(super) base: u8,
    /// Limits in the edge unit, and the range (SI) in which no rounding reaches them.
    pub(super) limits: Option<[f64; 2]>,
    /// The same as decimals.
    pub(super) exact_limits: Option<[Decimal; 2]>,
    pub(super) safe: [f64; 2],
    /// Fewest decimals written so far; [`NONE`]: no number was written.
    pub(super) written: u8,
}

impl SlotEdit {
    /// Sign and count of last digits of a value that is written plainly and is near no limit.
    #[inline(always)]
    pub(super) fn count(&self, token: &Token, old: (Packed, f64), value: f64, decimals: u8) -> Option<(bool, u64)> {
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

    /// The number that replaces the one with this text; near a limit that it keeps, rounded so that it still keeps it.
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

    /// Writes the text from `cursor` to the token, then a time or a duration (of a duration the unit of its column, else s), to a
    /// microsecond where the column is coarser; gives the place after the token.
    pub(super) fn time(
        &mut self,
        block: &Block,
        token: &Token,
        cursor: usize,
        value: f64,
        scratch: &mut Vec<u8>,
        out: &mut Vec<u8>,
    ) -> usize {
        let fewest = token.decimals.max(self.base);
        let decimals = fewest.max(time_decimals(self.slot));
        let start = token.start as usize;
        // the zeros at the end of an exponent are none of a fraction
        let exponent = !token.plain && Look::of(&block.text[start..start + usize::from(token.len)]).has_exponent();
        let end = self.number(block, token, cursor, New { old: None, value, decimals }, scratch, out);
        if !exponent {
            drop_zeros(out, usize::from(decimals), usize::from(fewest));
        }
        end
    }

    /// Writes the text from `cursor` to the token, then the number; gives the place after the token.
    #[inline(always)]
    pub(super) fn number(
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
