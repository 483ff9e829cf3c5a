//! A short number's digits moved by a count of last digits, as text: most numbers of a program keep sign and length, so that they
//! need not be made anew.
//!
//! Method: addition of decimal digits in one word, a byte each. Every digit is raised by 246 so that a sum of ten and more carries
//! into the next byte; the byte of the point is all ones, which hands a carry on. Bytes that have not carried are lowered again.

use super::print::eight_digits;

const ZEROS: u64 = 0x3030_3030_3030_3030;
const RAISED: u64 = 0xF6F6_F6F6_F6F6_F6F6;
const ONES: u64 = 0x0101_0101_0101_0101;
/// Turns the byte of a zero into a point.
const POINT: u64 = (b'.' ^ b'0') as u64;

/// A count of last digits that is added to numbers of so many decimals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    count: i64,
    /// Its digits, last one in the lowest byte, nothing in that of the point.
    digits: u64,
    /// Bits below the point.
    below: u32,
}

impl Step {
    /// For numbers with `decimals` digits after the point, 1 to 6. `None`: too large for a short number.
    pub fn new(count: i64, decimals: u8) -> Option<Self> {
        if !(1..=6).contains(&decimals) || count.unsigned_abs() >= 10_000_000 {
            return None;
        }
        let below = 8 * u32::from(decimals);
        let digits = eight_digits(count.unsigned_abs()).swap_bytes();
        let under = (1u64 << below) - 1;
        Some(Self { count, digits: (digits & under) | (digits & !under) << 8, below })
    }

    /// The count.
    #[inline(always)]
    pub fn count(&self) -> i64 {
        self.count
    }

    /// Adds it to the number whose bytes after the sign are the first `len` (3 to 8) of `word`, of which one is the point before its
    /// last digits; the other bytes stay. The sum must have the same sign and length, and must not be zero.
    #[inline(always)]
    pub fn sum(&self, word: u64, len: u32, negative: bool) -> u64 {
        // last digit in the lowest byte, nothing above the first
        let spare = 64u32.wrapping_sub(8 * len) & 63;
        let zeros = ZEROS >> spare;
        let point = 0xFFu64 << self.below;
        let digits = ((word.swap_bytes() >> spare) ^ zeros) & !point;
        let sum = if negative == (self.count < 0) {
            (digits.wrapping_add((RAISED >> spare) & !point) | point).wrapping_add(self.digits)
        } else {
            digits.wrapping_sub(self.digits)
        };
        let high = (sum >> 7) & ONES;
        let digits = sum.wrapping_sub(high * 0xF6) & !point;
        let text = (digits | POINT << self.below) ^ zeros;
        let kept = if spare == 0 { 0 } else { word & (u64::MAX << (64 - spare)) };
        (text << spare).swap_bytes() | kept
    }
}

#[cfg(test)]
mod tests {
    use super::super::Decimal;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn steps_of_digits_are_sums(
            negative: bool, whole in "0|[1-9][0-9]{0,5}", fraction in "[0-9]{1,6}", after in "[,\n0-9.-]{8}",
            count in -9_999_999i64..10_000_000, shift in 0u32..7
        ) {
            let number = format!("{whole}.{fraction}");
            prop_assume!(number.len() <= 8);
            let count = count / 10i64.pow(shift);
            let bytes = format!("{number}{after}");
            let word = u64::from_le_bytes(*bytes.as_bytes().first_chunk().unwrap());
            let sign = if negative { "-" } else { "" };
            let own = Decimal::read(format!("{sign}{number}").as_bytes()).unwrap();
            let want = Decimal::new(own.mantissa() + count, own.decimals()).unwrap();
            let step = Step::new(count, own.decimals()).unwrap();
            let same = want.is_negative() == negative && want.mantissa() != 0;
            let want = want.to_string();
            let digits = want.trim_start_matches('-');
            prop_assume!(same && digits.len() == number.len());
            let got = step.sum(word, number.len() as u32, negative);
            let text = String::from_utf8(got.to_le_bytes().to_vec()).unwrap();
            prop_assert_eq!(text, format!("{digits}{after}")[..8].to_string());
        }
    }
}
