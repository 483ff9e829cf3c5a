//! Bytes to a number, correctly rounded, with the style in which it was written.
//!
//! Method: a plain number (`-123.4567`, at most 7 digits on each side) is read eight bytes at a time: the first byte that
//! is no digit is found in one word, the digits are combined pairwise by multiplication (Lemire 2018, "Quickly parsing
//! eight digits"). Mantissa (below 2^53) and power of ten are exact, so that their quotient is correctly rounded (Clinger
//! 1990). Everything else goes through the standard library's parser.

/// `10^d`, exact.
pub const POW10: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];
const POW10_INT: [u64; 8] = [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000];
const ZEROS: u64 = 0x3030_3030_3030_3030;

/// A number that was read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Read {
    /// As it is written, in the unit of its column.
    pub value: f64,
    /// Digits behind the point; for a number with an exponent, of the weight of its last digit.
    pub decimals: u8,
}

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
    let y = digits << (64 - 8 * n);
    let y = y.wrapping_mul(10).wrapping_add(y >> 8);
    let even = (y & 0x0000_00FF_0000_00FF).wrapping_mul(0x000F_4240_0000_0064);
    let odd = ((y >> 16) & 0x0000_00FF_0000_00FF).wrapping_mul(0x0000_2710_0000_0001);
    even.wrapping_add(odd) >> 32
}

/// Reads a plain number at `at`; gives it and the place behind it. `None`: not plain, or the text ends too soon to tell.
#[inline(always)]
pub fn plain(text: &[u8], at: usize) -> Option<(Read, usize)> {
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
    let (mut mantissa, mut decimals) = (whole, 0);
    if (first >> (8 * n)) as u8 == b'.' {
        let fraction = word(text, end + 1)? ^ ZEROS;
        let d = not_digits(fraction).trailing_zeros() / 8;
        if d == 0 || d > 7 {
            return None;
        }
        mantissa = whole * POW10_INT[d as usize] + join(fraction, d);
        decimals = d as u8;
        end += 1 + d as usize;
    }
    // below 2^53, so that the signed conversion is exact; the sign without a branch that would be guessed wrong
    let size = mantissa as i64 as f64 / POW10[usize::from(decimals)];
    let value = f64::from_bits(size.to_bits() | (u64::from(negative) << 63));
    Some((Read { value, decimals }, end))
}

/// A short number: what most numbers of a program are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Short {
    /// All digits, and [`NEGATIVE`] where a minus stands in front of them.
    pub mantissa: u32,
    /// Digits after the point.
    pub decimals: u8,
    /// Zeros stand in front of it.
    pub padded: bool,
    /// Bytes, sign included: at most 9.
    pub len: usize,
}

/// Sign of a mantissa: that of -0.0, too, is kept.
pub const NEGATIVE: u32 = 1 << 31;

/// Value of a mantissa with its sign, for the power of ten of its decimals: exact operands, so that the quotient is correctly rounded.
#[inline(always)]
pub fn quotient(mantissa: u32, power: f64) -> f64 {
    let size = f64::from((mantissa & !NEGATIVE) as i32) / power;
    f64::from_bits(size.to_bits() | (u64::from(mantissa & NEGATIVE) << 32))
}

impl Short {
    /// Value of the number.
    pub fn value(&self) -> f64 {
        quotient(self.mantissa, POW10[usize::from(self.decimals & 7)])
    }
}

/// Reads the number with which `text` begins, if it has a point, digits on both sides of it and at most eight bytes behind
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
    let behind = text[8 + sign];
    // one branch that is nearly never taken; which of these it is would be guessed wrong
    let other = (point == 0)
        | (point > 48)
        | ((word >> (point & 63)) as u8 != b'.')
        | (decimals == 0)
        | ((end == 64) & behind.is_ascii_digit());
    if other {
        return None;
    }
    let whole = (1u64 << point) - 1;
    let closed = (digits & whole) | ((digits >> 8) & !whole);
    let mantissa = join(closed, end / 8 - 1) as u32 | (u32::from(negative) << 31);
    let padded = word as u8 == b'0' && point > 8;
    Some(Short { mantissa, decimals: decimals as u8, padded, len: sign + (end / 8) as usize })
}

/// Reads any finite decimal number that fills `text` (no spaces, no quotes).
pub fn any(text: &[u8]) -> Option<Read> {
    // the standard parser also takes `inf`, `nan` and `infinity`
    if !text.iter().all(|b| b.is_ascii_digit() || matches!(b, b'+' | b'-' | b'.' | b'e' | b'E')) {
        return None;
    }
    let value: f64 = std::str::from_utf8(text).ok()?.parse().ok()?;
    if !value.is_finite() {
        return None;
    }
    let (mantissa, exponent) = match text.iter().position(|b| matches!(b, b'e' | b'E')) {
        Some(e) => (&text[..e], std::str::from_utf8(&text[e + 1..]).ok()?.parse::<i64>().ok()?),
        None => (text, 0),
    };
    let digits = mantissa.iter().position(|&b| b == b'.').map_or(0, |p| mantissa.len() - p - 1) as i64;
    Some(Read { value, decimals: (digits - exponent).clamp(0, 30) as u8 })
}

/// Whether a number that fills `text` is written plainly: `-123.4567`, no plus, no exponent, no padding zeros.
pub fn is_plain(text: &[u8]) -> bool {
    let body = text.strip_prefix(b"-").unwrap_or(text);
    let (whole, fraction) = match body.iter().position(|&b| b == b'.') {
        Some(p) => (&body[..p], Some(&body[p + 1..])),
        None => (body, None),
    };
    let digits = |t: &[u8]| !t.is_empty() && t.iter().all(u8::is_ascii_digit);
    digits(whole) && fraction.is_none_or(digits) && (whole.len() == 1 || whole[0] != b'0')
}

#[cfg(test)]
mod tests {
    use super::{any, *};
    use proptest::prelude::*;

    fn read(text: &str) -> Option<(Read, usize)> {
        let padded = format!("{text},        ");
        plain(padded.as_bytes(), 0)
    }

    proptest! {
        #[test]
        fn plain_numbers_are_read_as_the_standard_library_reads_them(
            negative: bool, whole in 0u32..10_000_000, d in 0usize..8, fraction in 0u32..10_000_000
        ) {
            let digits = format!("{fraction:07}");
            let mut text = format!("{}{whole}", if negative { "-" } else { "" });
            if d > 0 {
                text = format!("{text}.{}", &digits[..d]);
            }
            let (got, end) = read(&text).unwrap();
            prop_assert_eq!(got.value.to_bits(), text.parse::<f64>().unwrap().to_bits());
            prop_assert_eq!((end, usize::from(got.decimals)), (text.len(), d));
        }

        #[test]
        fn short_numbers_are_read_as_all_others(
            negative: bool, whole in "[0-9]{1,8}", fraction in "[0-9]{0,8}", point: bool, behind in "[,\n\r 0-9.x-]{8}"
        ) {
            let sign = if negative { "-" } else { "" };
            let text = format!("{sign}{whole}{}{fraction}{behind}        ", if point { "." } else { "" });
            let chunk = text.as_bytes().first_chunk::<16>().unwrap();
            if let Some(got) = short(chunk) {
                let (want, end) = plain(text.as_bytes(), 0).unwrap();
                prop_assert_eq!((got.value().to_bits(), got.decimals, got.len), (want.value.to_bits(), want.decimals, end));
                prop_assert_eq!(!got.padded, is_plain(&text.as_bytes()[..end]));
            } else if point && behind.starts_with([',', '\n', '\r']) && !fraction.is_empty() {
                prop_assert!(whole.len() + fraction.len() > 7);
            }
        }

        #[test]
        fn whatever_stands_there_reading_a_plain_number_never_panics(bytes: Vec<u8>, at in 0usize..40) {
            if let Some((_, end)) = plain(&bytes, at) {
                let text = std::str::from_utf8(&bytes[at..end]).unwrap();
                prop_assert!(text.parse::<f64>().is_ok());
            }
        }
    }

    #[test]
    fn unusual_numbers_are_read_with_the_weight_of_their_last_digit() {
        let cases = [
            ("+1.50", 1.5, 2),
            (".384", 0.384, 3),
            ("5.", 5.0, 0),
            ("9.60894E-05", 9.60894e-5, 10),
            ("1e3", 1000.0, 0),
        ];
        for (text, value, decimals) in cases {
            assert_eq!(any(text.as_bytes()), Some(Read { value, decimals }), "{text}");
        }
        for text in ["", "-", "1,5", "nan", "inf", "1e999", "0x10", "1_000", "1.2.3", "--1"] {
            assert_eq!(any(text.as_bytes()), None, "{text}");
        }
    }
}
