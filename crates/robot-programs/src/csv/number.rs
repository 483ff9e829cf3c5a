//! Bytes to a number of a row, correctly rounded, with the style in which it was written.
//!
//! Numbers in decimal notation are [`Decimal`]s; everything else goes through the standard library's parser.

use crate::decimal::Decimal;
use crate::decimal::read::Packed;

/// A number that was read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Read {
    /// As it is written, in the unit of its column.
    pub value: f64,
    /// Digits after the point; for a number with an exponent, of the weight of its last digit.
    pub decimals: u8,
    /// Its digits, where they are few.
    pub mantissa: Packed,
}

impl From<Decimal> for Read {
    #[inline(always)]
    fn from(number: Decimal) -> Self {
        Self { value: number.value(), decimals: number.decimals(), mantissa: Packed::of(number) }
    }
}

/// Reads a plain number at `at`; gives it and the place after it. `None`: not plain, or the text ends too soon to tell.
#[inline(always)]
pub fn plain(text: &[u8], at: usize) -> Option<(Read, usize)> {
    let (number, end) = Decimal::plain(text, at)?;
    Some((number.into(), end))
}

/// Reads any finite decimal number that fills `text` (no spaces, no quotes).
///
/// `number = ["+" | "-"] {digit} ["." {digit}] [("e" | "E") ["+" | "-"] digit {digit}]`, with one digit at least
pub fn any(text: &[u8]) -> Option<Read> {
    if let Some(number) = Decimal::read(text) {
        return Some(number.into());
    }
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
    let decimals = digits.saturating_sub(exponent).clamp(0, 30) as u8;
    Some(Read { value, decimals, mantissa: Packed::NONE })
}

/// Whether a number that fills `text` is written plainly: `-123.4567`, no plus, no exponent, no padding zeros.
///
/// `plain = ["-"] ("0" | nonzero {digit}) ["." digit {digit}]`
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
    use crate::decimal::read::short;
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
            negative: bool, whole in "[0-9]{1,8}", fraction in "[0-9]{0,8}", point: bool, after in "[,\n\r 0-9.x-]{8}"
        ) {
            let sign = if negative { "-" } else { "" };
            let text = format!("{sign}{whole}{}{fraction}{after}        ", if point { "." } else { "" });
            let chunk = text.as_bytes().first_chunk::<16>().unwrap();
            if let Some(got) = short(chunk) {
                let (want, end) = plain(text.as_bytes(), 0).unwrap();
                prop_assert_eq!((got.value().to_bits(), got.decimals, got.len), (want.value.to_bits(), want.decimals, end));
                prop_assert_eq!(!got.padded, is_plain(&text.as_bytes()[..end]));
            } else if point && after.starts_with([',', '\n', '\r']) && !fraction.is_empty() {
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
            assert_eq!(any(text.as_bytes()).map(|n| (n.value, n.decimals)), Some((value, decimals)), "{text}");
        }
        for text in ["", "-", "1,5", "nan", "inf", "1e999", "0x10", "1_000", "1.2.3", "--1"] {
            assert_eq!(any(text.as_bytes()), None, "{text}");
        }
    }
}
