//! Rows of short numbers that are written like the row before them: the same signs, and as many digits on either side of each point.
//!
//! Where a number ends is then known before it is read, so that no number waits for the one before it. A row is compared with the
//! [`Shape`] byte by byte, many bytes at once and without a branch: punctuation has to be what it was, and a digit a digit. Its
//! numbers are worked out side by side. A row of another shape is read by [`fast`](super::fast), which finds the same, and gives
//! the next shape.
//!
//! The loops run over arrays of fixed length, so that the compiler makes vector instructions of them.

use super::super::Token;
use crate::decimal::read::{Packed, eight_in_lanes};

/// Columns up to which rows of nothing but short numbers take the fastest way.
pub(super) const MOST_PURE: usize = 16;

/// Bytes that are compared at once.
const CHUNK: usize = 32;
/// Bytes of the longest row: sign, eight bytes and a separator for each number, and a line ending of two bytes.
pub(super) const LONGEST: usize = (MOST_PURE * 10 + 1).next_multiple_of(CHUNK);
/// Numbers that are worked out at once.
const LANES: usize = 8;
const ZERO: u8 = b'0';

/// What a row was like.
#[derive(Debug, Clone)]
pub(super) struct Shape {
    /// Bytes of a row, line ending included; 0: none was seen.
    whole: usize,
    /// Bytes that are compared, and that are looked at: the row and what follows it.
    compared: usize,
    span: usize,
    /// What a byte of the row is compared with, and the least and the most by which it may differ from that (exclusive or).
    like: [u8; LONGEST],
    least: [u8; LONGEST],
    most: [u8; LONGEST],
    /// The numbers, as places in the row.
    tokens: [Token; MOST_PURE],
    /// First digit of each, as a place in the row.
    digits: [usize; MOST_PURE],
    /// Bits of the word that begins there: those of digits before the point, and what else the digits leave once they have closed up.
    before: [u64; MOST_PURE],
    above: [u64; MOST_PURE],
    /// The sign of a mantissa.
    sign: [u32; MOST_PURE],
}

impl Default for Shape {
    fn default() -> Self {
        Self {
            whole: 0,
            compared: 0,
            span: 0,
            like: [0; LONGEST],
            least: [0; LONGEST],
            most: [0; LONGEST],
            tokens: [Token::default(); MOST_PURE],
            digits: [0; MOST_PURE],
            before: [0; MOST_PURE],
            above: [0; MOST_PURE],
            sign: [0; MOST_PURE],
        }
    }
}

impl Shape {
    /// Takes over what the row of `text` between `start` and `end` is like, whose numbers, [`short`](crate::decimal::read::short)
    /// and not padded, are `tokens`.
    pub(super) fn take(&mut self, text: &[u8], tokens: &[Token], start: usize, end: usize) {
        self.whole = 0;
        let Some(row) = text.get(start..end).filter(|r| r.len() <= LONGEST && tokens.len() <= MOST_PURE) else {
            return;
        };
        let compared = row.len().next_multiple_of(CHUNK);
        for (k, byte) in row.iter().enumerate() {
            let digit = byte.is_ascii_digit();
            (self.like[k], self.least[k], self.most[k]) = if digit { (ZERO, 0, 9) } else { (*byte, 0, 0) };
        }
        self.least[row.len()..compared].fill(0);
        self.most[row.len()..compared].fill(u8::MAX);
        for (k, token) in tokens.iter().enumerate() {
            let place = token.start as usize - start;
            let negative = row[place] == b'-';
            let digits = place + usize::from(negative);
            let length = 8 * (u32::from(token.len) - u32::from(negative));
            let point = length - 8 * (u32::from(token.decimals) + 1);
            self.tokens[k] = Token { start: place as u32, ..*token };
            self.digits[k] = digits;
            self.before[k] = (1 << point) - 1;
            self.above[k] = u64::from(64 - (length - 8));
            self.sign[k] = u32::from(negative) << 31;
            // no zero in front of another digit
            self.least[digits] = u8::from(point > 8);
        }
        (self.whole, self.compared) = (row.len(), compared);
        self.span = compared.max(row.len() + size_of::<u64>());
    }

    /// The row at `start` if it is like the one before: its end; the places and mantissas of its numbers.
    #[inline(always)]
    pub(super) fn row(
        &self,
        text: &[u8],
        start: usize,
        tokens: &mut [Token],
        mantissas: &mut [Packed],
    ) -> Option<usize> {
        let end = self.numbers(text, start, mantissas)?;
        for (token, own) in tokens.iter_mut().zip(&self.tokens) {
            *token = Token { start: start as u32 + own.start, ..*own };
        }
        Some(end)
    }

    /// The row at `start` if it is like the one before: its end; the mantissas of its numbers.
    #[inline(always)]
    pub(super) fn numbers(&self, text: &[u8], start: usize, mantissas: &mut [Packed]) -> Option<usize> {
        let row = text.get(start..)?.get(..self.span)?;
        if self.whole == 0 || !self.is_like(row) {
            return None;
        }
        for (k, mantissas) in mantissas.chunks_mut(LANES).enumerate() {
            let first = k * LANES;
            let mut words = [0; LANES];
            for (word, digits) in words.iter_mut().zip(&self.digits[first..first + LANES]) {
                *word = u64::from_le_bytes(*row.get(*digits..)?.first_chunk()?);
            }
            let lanes = |a: &[u64; MOST_PURE]| -> [u64; LANES] { std::array::from_fn(|i| a[first + i]) };
            let numbers = eight_in_lanes(words, lanes(&self.before), lanes(&self.above));
            for (i, mantissa) in mantissas.iter_mut().enumerate() {
                *mantissa = Packed::short(numbers[i], self.sign[first + i]);
            }
        }
        Some(start + self.whole)
    }

    /// Whether the bytes with which `row` begins are those of a row of this shape.
    #[inline(always)]
    fn is_like(&self, row: &[u8]) -> bool {
        let mut other = [0u8; CHUNK];
        let shape =
            self.like.chunks_exact(CHUNK).zip(self.least.chunks_exact(CHUNK)).zip(self.most.chunks_exact(CHUNK));
        for (row, ((like, least), most)) in row.get(..self.compared).unwrap_or_default().chunks_exact(CHUNK).zip(shape)
        {
            for i in 0..CHUNK {
                let by = row[i] ^ like[i];
                other[i] |= by.saturating_sub(most[i]) | least[i].saturating_sub(by);
            }
        }
        let words = other.chunks_exact(8).flat_map(|b| b.first_chunk());
        words.fold(0, |all, word| all | u64::from_le_bytes(*word)) == 0
    }
}

#[cfg(test)]
mod tests {
    use super::super::fast::pure_row;
    use super::*;
    use proptest::prelude::*;

    /// Numbers of up to eight bytes after the sign, as parts: sign, digits before the point and after it.
    fn numbers() -> impl Strategy<Value = Vec<(bool, String, String)>> {
        let number = (any::<bool>(), "0|[1-9][0-9]{0,3}", "[0-9]{1,3}");
        let long = (any::<bool>(), "[1-9][0-9]{0,2}", "[0-9]{4}");
        prop::collection::vec(prop_oneof![number, long], 1..=MOST_PURE)
    }

    fn row(numbers: &[(bool, String, String)], ending: &str) -> String {
        let cell = |(negative, whole, fraction): &(bool, String, String)| {
            format!("{}{whole}.{fraction}", if *negative { "-" } else { "" })
        };
        numbers.iter().map(cell).collect::<Vec<_>>().join(",") + ending
    }

    /// What the general way and the shape of `before` find in `row`, with text after it.
    type Found = Option<(usize, Vec<Token>, Vec<Packed>)>;

    fn found(before: &[u8], row: &[u8], n: usize) -> (Found, Found) {
        let start = before.len();
        let text = [before, row, &b"1.5,2.5\n".repeat(60)[..]].concat();
        let memory = || (vec![Token::default(); n], vec![Packed::NONE; n]);
        let mut shape = Shape::default();
        let (mut tokens, mut mantissas) = memory();
        let end = pure_row(&text, 0, &mut tokens, &mut mantissas).expect("a row of short numbers");
        shape.take(&text, &tokens, 0, end);
        let (mut tokens, mut mantissas) = memory();
        let general = pure_row(&text, start, &mut tokens, &mut mantissas).map(|end| (end, tokens, mantissas));
        let (mut tokens, mut mantissas) = memory();
        let fast = shape.row(&text, start, &mut tokens, &mut mantissas).map(|end| (end, tokens, mantissas));
        (general, fast)
    }

    proptest! {
        #[test]
        fn a_row_of_the_same_shape_is_what_the_general_way_finds(
            numbers in numbers(), digits in prop::collection::vec(0u8..10, 200), crlf: bool
        ) {
            let ending = if crlf { "\r\n" } else { "\n" };
            let before = row(&numbers, ending);
            let mut digits = digits.iter();
            let mut other = |b: u8| if b.is_ascii_digit() { ZERO + digits.next().unwrap_or(&1) } else { b };
            let next: Vec<u8> = before.bytes().map(&mut other).collect();
            let (general, fast) = found(before.as_bytes(), &next, numbers.len());
            prop_assert_eq!(general, fast);
        }

        #[test]
        fn a_row_with_any_other_byte_is_left_to_the_general_way(
            numbers in numbers(), place in any::<prop::sample::Index>(), byte: u8, crlf: bool
        ) {
            let before = row(&numbers, if crlf { "\r\n" } else { "\n" });
            let mut next = before.clone().into_bytes();
            let place = place.index(next.len());
            next[place] = byte;
            let (general, fast) = found(before.as_bytes(), &next, numbers.len());
            prop_assert!(fast.is_none() || fast == general, "{:?} for {:?}", fast, general);
            prop_assert!(fast.is_none() || byte.is_ascii_digit() || byte == before.as_bytes()[place]);
        }

        #[test]
        fn any_row_after_any_other_is_what_the_general_way_finds_or_left_to_it(
            first in numbers(), second in numbers()
        ) {
            let (before, next) = (row(&first, "\n"), row(&second, "\n"));
            let (general, fast) = found(before.as_bytes(), next.as_bytes(), first.len());
            prop_assert!(fast.is_none() || fast == general, "{:?} for {:?}", fast, general);
        }
    }
}
