//! Bytes to decimals.
//!
//! Method: eight bytes at a time: the first byte that is no digit is found in one word, the digits are combined pairwise by
//! multiplication (Lemire 2018, "Quickly parsing eight digits").

use super::{Decimal, POW10, POW10_INT};

const ZEROS: u64 = 0x3030_3030_3030_3030;

#[inline(always)]
fn word(text: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(*text.get(at..)?.first_chunk::<8>()?))
}

/// High bit of every byte of `digits` (already `^ ZEROS`) up to and including the first that is no digit.
#[inline(always)]
fn not_digits(digits: u64) -> u64 {
    (digits.wrapping_add(0x7676_7676_7676_7676) | digits) & 0x8080_8080_8080_8080
}

/// Value of the first `n` (1 to 7) bytes of `digits`.
#[inline(always)]
fn join(digits: u64, n: u32) -> u64 {
    eight(digits << (64 - 8 * n))
}

/// Value of eight bytes, first digit in the lowest.
#[inline(always)]
fn eight(y: u64) -> u64 {
    let y = y.wrapping_mul(10).wrapping_add(y >> 8);
    let even = (y & 0x0000_00FF_0000_00FF).wrapping_mul(0x000F_4240_0000_0064);
    let odd = ((y >> 16) & 0x0000_00FF_0000_00FF).wrapping_mul(0x0000_2710_0000_0001);
    even.wrapping_add(odd) >> 32
}

impl Decimal {
    /// Reads sign, digits and point that fill `text`; digits on one side of the point are enough. `None`: anything else, an
    /// exponent, more than 18 digits or 18 decimals.
    pub fn read(text: &[u8]) -> Option<Self> {
        let negative = text.first() == Some(&b'-');
        let body = if matches!(text.first(), Some(b'-' | b'+')) { text.get(1..)? } else { text };
        let (whole, fraction) = match body.iter().position(|b| *b == b'.') {
            Some(k) => (body.get(..k)?, body.get(k + 1..)?),
            None => (body, &[][..]),
        };
        if whole.len() + fraction.len() == 0 {
            return None;
        }
        let magnitude = digits(digits(0, whole)?, fraction)?;
        Self::signed(negative, magnitude, u8::try_from(fraction.len()).ok()?)
    }

    /// Reads a plain number (`-123.4567`, at most 7 digits on each side of the point) at `at`; gives it and the place after it.
    /// `None`: not plain, or the text ends too soon to tell.
    #[inline(always)]
    pub fn plain(text: &[u8], at: usize) -> Option<(Self, usize)> {
        let negative = *text.get(at)? == b'-';
        let start = at + usize::from(negative);
        let first = word(text, start)?;
        let digits = first ^ ZEROS;
        let stop = not_digits(digits);
        let n = stop.trailing_zeros() / 8;
        if n == 0 || n > 7 {
            return None;
        }
        let whole = join(digits, n);
        let mut end = start + n as usize;
        let (mut magnitude, mut decimals) = (whole, 0);
        if (first >> (8 * n)) as u8 == b'.' {
            let fraction = word(text, end + 1)? ^ ZEROS;
            let d = not_digits(fraction).trailing_zeros() / 8;
            if d == 0 || d > 7 {
                return None;
            }
            magnitude = whole * POW10_INT[d as usize] + join(fraction, d);
            decimals = d as u8;
            end += 1 + d as usize;
        }
        Some((Self { magnitude, decimals, negative }, end))
    }
}

/// `before` with the digits of `text` after it. `None`: no digits, or too many.
fn digits(before: u64, text: &[u8]) -> Option<u64> {
    let mut magnitude = before;
    let mut words = text.chunks_exact(8);
    for chunk in words.by_ref() {
        let chunk = word(chunk, 0)? ^ ZEROS;
        if not_digits(chunk) != 0 {
            return None;
        }
        magnitude = magnitude.checked_mul(POW10_INT[8])?.checked_add(eight(chunk))?;
    }
    for byte in words.remainder() {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            return None;
        }
        magnitude = magnitude.checked_mul(10)?.checked_add(u64::from(digit))?;
    }
    Some(magnitude)
}

/// A short number: what most numbers of a program are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Short {
    /// All digits, with their sign.
    pub mantissa: Packed,
    /// Digits after the point.
    pub decimals: u8,
    /// Zeros stand in front of it.
    pub padded: bool,
    /// Bytes, sign included: at most 9.
    pub len: usize,
}

/// Digits and sign of a short number in 32 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Packed(u32);

impl Default for Packed {
    fn default() -> Self {
        Self::NONE
    }
}

impl Packed {
    /// No short number.
    pub const NONE: Self = Self(u32::MAX);
    const NEGATIVE: u32 = 1 << 31;

    /// Of a decimal; [`Packed::NONE`] where it is longer.
    #[inline(always)]
    pub fn of(number: Decimal) -> Self {
        if number.magnitude < u64::from(Self::NEGATIVE - 1) {
            Self(number.magnitude as u32 | (u32::from(number.negative) << 31))
        } else {
            Self::NONE
        }
    }

    /// Of at most seven digits, with the highest bit set in `sign` for a minus.
    #[inline(always)]
    pub fn short(digits: u32, sign: u32) -> Self {
        Self(digits | sign)
    }

    /// The decimal, whose digits after the point stand elsewhere.
    #[inline(always)]
    pub fn decimal(self, decimals: u8) -> Option<Decimal> {
        if self == Self::NONE {
            return None;
        }
        Decimal::signed(self.0 & Self::NEGATIVE != 0, u64::from(self.0 & !Self::NEGATIVE), decimals)
    }

    /// Digits with their sign.
    #[inline(always)]
    pub fn signed(self) -> i64 {
        let size = i64::from(self.0 & !Self::NEGATIVE);
        if self.0 & Self::NEGATIVE == 0 { size } else { -size }
    }

    /// A minus stands before it.
    #[inline(always)]
    pub fn is_negative(self) -> bool {
        self.0 & Self::NEGATIVE != 0
    }

    /// So many units.
    #[inline(always)]
    pub fn times(self, unit: f64) -> f64 {
        let size = f64::from((self.0 & !Self::NEGATIVE) as i32) * unit;
        f64::from_bits(size.to_bits() | (u64::from(self.0 & Self::NEGATIVE) << 32))
    }

    /// The value, for the power of ten of its decimals: exact operands, so that the quotient is correctly rounded (Clinger 1990).
    #[inline(always)]
    pub fn quotient(self, power: f64) -> f64 {
        let size = f64::from((self.0 & !Self::NEGATIVE) as i32) / power;
        f64::from_bits(size.to_bits() | (u64::from(self.0 & Self::NEGATIVE) << 32))
    }
}

impl Short {
    /// Value of the number.
    pub fn value(&self) -> f64 {
        self.mantissa.quotient(POW10[usize::from(self.decimals & 7)])
    }
}

/// Values of numbers whose first digits stand in `words` in front of a point: the digits of `before` stay, those above the point close
/// its place, and all but them are shifted out, by `above` bits.
#[inline(always)]
pub fn eight_in_lanes<const N: usize>(words: [u64; N], before: [u64; N], above: [u64; N]) -> [u32; N] {
    const PAIRS: u64 = 0x00FF_00FF_00FF_00FF;
    const FOURS: u64 = 0x0000_FFFF_0000_FFFF;
    let mut values = [0; N];
    for i in 0..N {
        let digits = words[i] ^ ZEROS;
        let closed = (digits & before[i]) | ((digits >> 8) & !before[i]);
        let y = closed << (above[i] & 63);
        // times 10 and times 100 as shifts, which vector instructions have
        let (high, low) = (y & PAIRS, (y >> 8) & PAIRS);
        let y = (high << 3) + (high << 1) + low;
        let (high, low) = (y & FOURS, (y >> 16) & FOURS);
        let y = (high << 6) + (high << 5) + (high << 2) + low;
        values[i] = (y as u32).wrapping_mul(10_000).wrapping_add((y >> 32) as u32);
    }
    values
}

/// Reads the number with which `text` begins, if it has a point, digits on both sides of it and at most eight bytes after
/// its sign (`-118.6345`): one word, in which the digits close the place of the point. The way to the next number is short,
/// as each waits for the one before it.
#[inline(always)]
pub fn short(text: &[u8; 16]) -> Option<Short> {
    let negative = text[0] == b'-';
    // a load from one of two places: a choice between two words would become a branch that is guessed wrong
    let sign = usize::from(negative);
    let mut word = [0; 8];
    word.copy_from_slice(&text[sign..sign + 8]);
    let word = u64::from_le_bytes(word);
    let digits = word ^ ZEROS;
    // exact up to the second byte that is no digit, if the first is a point
    let stops = not_digits(digits);
    let point = stops.trailing_zeros() & !7;
    let end = (stops & stops.wrapping_sub(1)).trailing_zeros() & !7;
    let decimals = end.wrapping_sub(point + 8) / 8;
    let after = text[8 + sign];
    // one branch that is nearly never taken; which of these it is would be guessed wrong
    let other = (point == 0)
        | (point > 48)
        | ((word >> (point & 63)) as u8 != b'.')
        | (decimals == 0)
        | ((end == 64) & after.is_ascii_digit());
    if other {
        return None;
    }
    let whole = (1u64 << point) - 1;
    let closed = (digits & whole) | ((digits >> 8) & !whole);
    let mantissa = Packed(join(closed, end / 8 - 1) as u32 | (u32::from(negative) << 31));
    let padded = word as u8 == b'0' && point > 8;
    Some(Short { mantissa, decimals: decimals as u8, padded, len: sign + (end / 8) as usize })
}
