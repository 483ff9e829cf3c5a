//! Decimals to bytes.
//!
//! Method: the eight digits of an integer are made in one word (pairwise division by multiplication); larger numbers go through the
//! standard library.

use super::{Decimal, POW10_INT};

/// Longest number that [`fixed`] writes: sign, 8 digits, point, and space for whole words.
pub const ROOM: usize = 32;
/// [`fixed`] writes integers below this.
pub const MOST_FIXED: u64 = 100_000_000;
const ZEROS: u64 = 0x3030_3030_3030_3030;

/// The eight decimal digits of `n < 10^8`, a byte each, first digit in the lowest.
#[inline(always)]
pub(super) fn eight_digits(n: u64) -> u64 {
    let n = n as u32;
    let (high, low) = (n / 10_000, n % 10_000);
    let x = u64::from(high) | (u64::from(low) << 32);
    // two digits in each 16-bit field, then one in each byte
    let hundreds = ((x * 10_486) >> 20) & 0x0000_007F_0000_007F;
    let x = hundreds | ((x - hundreds * 100) << 16);
    let tens = ((x * 103) >> 10) & 0x000F_000F_000F_000F;
    tens | ((x - tens * 10) << 8)
}

/// Writes `n * 10^-decimals` (with `-` where `negative`) to the start of `out`, for `n < 10^8`, `decimals < 8`; gives the
/// length. Zero has no sign.
#[inline(always)]
pub fn fixed(out: &mut [u8; ROOM], negative: bool, n: u64, decimals: u32) -> usize {
    let decimals = decimals & 7;
    let digits = eight_digits(n);
    let text = digits | ZEROS;
    let sign = usize::from(negative & (n != 0));
    // zeros in front go, up to the digit before the point
    let zeros = (digits | 1 << (56 - 8 * decimals)).trailing_zeros() & 56;
    let whole = (8 - zeros / 8 - decimals) as usize;
    out[0] = b'-';
    put(out, sign, text >> zeros);
    if decimals == 0 {
        return sign + whole;
    }
    out[(sign + whole) & 15] = b'.';
    put(out, sign + whole + 1, text >> (64 - 8 * decimals));
    sign + whole + 1 + decimals as usize
}

/// `at` is at most 10.
#[inline(always)]
fn put(out: &mut [u8; ROOM], at: usize, word: u64) {
    let at = at & 15;
    out[at..at + 8].copy_from_slice(&word.to_le_bytes());
}

impl Decimal {
    /// Appends its digits to `out`. Zero has no sign.
    #[inline]
    pub fn write(&self, out: &mut Vec<u8>) {
        if self.magnitude < MOST_FIXED && self.decimals < 8 {
            let from = out.len();
            out.extend_from_slice(&[0; ROOM]);
            if let Some(room) = out.get_mut(from..).and_then(|o| o.first_chunk_mut::<ROOM>()) {
                let length = fixed(room, self.negative, self.magnitude, u32::from(self.decimals));
                out.truncate(from + length);
            }
            return;
        }
        let unit = POW10_INT[usize::from(self.decimals)];
        let sign = if self.negative && self.magnitude != 0 { "-" } else { "" };
        let whole = self.magnitude / unit;
        let text = match usize::from(self.decimals) {
            0 => format!("{sign}{whole}"),
            width => format!("{sign}{whole}.{:0width$}", self.magnitude % unit),
        };
        out.extend_from_slice(text.as_bytes());
    }
}
