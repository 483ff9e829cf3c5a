//! Numbers of vendor programs, read: short ones without an exponent in one pass, any other piece by piece.

use super::Style;
use crate::decimal::{Decimal, MOST};

/// A number and its style. Takes sign, digits, point and exponent (`e`, `E`), and nothing else around it.
pub fn read(text: &[u8]) -> Option<(f64, Style)> {
    plain(text).or_else(|| general(text))
}

/// A number of at most 18 bytes without an exponent, in one pass; `None`: any other text.
fn plain(text: &[u8]) -> Option<(f64, Style)> {
    let sign = text.first().copied().filter(|b| matches!(b, b'+' | b'-'));
    let digits = text.get(usize::from(sign.is_some())..).filter(|d| d.len() <= usize::from(MOST))?;
    let (mut magnitude, mut point) = (0u64, None);
    for (k, b) in digits.iter().enumerate() {
        match b {
            b'0'..=b'9' => magnitude = magnitude * 10 + u64::from(b - b'0'),
            b'.' if point.is_none() => point = Some(k),
            _ => return None,
        }
    }
    let whole = point.unwrap_or(digits.len());
    let decimals = point.map_or(0, |k| digits.len() - k - 1);
    if whole + decimals == 0 {
        return None;
    }
    let decimals = decimals as u8; // at most 18
    let style = Style { decimals, point: point.is_some(), bare: whole == 0, plus: sign == Some(b'+'), exponent: false };
    Some((Decimal::signed(sign == Some(b'-'), magnitude, decimals)?.value(), style))
}

/// The same of any number.
fn general(text: &[u8]) -> Option<(f64, Style)> {
    let mut rest = text;
    let mut style = Style::default();
    if let [sign @ (b'+' | b'-'), tail @ ..] = rest {
        style.plus = *sign == b'+';
        rest = tail;
    }
    let whole = rest.iter().take_while(|b| b.is_ascii_digit()).count();
    rest = &rest[whole..];
    let mut decimals = 0;
    if let [b'.', tail @ ..] = rest {
        style.point = true;
        decimals = tail.iter().take_while(|b| b.is_ascii_digit()).count();
        rest = &tail[decimals..];
    }
    if whole + decimals == 0 {
        return None;
    }
    style.bare = whole == 0;
    let mut weight = -(i64::try_from(decimals).ok()?);
    if let [b'e' | b'E', tail @ ..] = rest {
        style.exponent = true;
        let digits = tail.strip_prefix(b"+").or_else(|| tail.strip_prefix(b"-")).unwrap_or(tail);
        if digits.is_empty() || digits.len() > 4 || !digits.iter().all(u8::is_ascii_digit) {
            return None;
        }
        let exponent: i64 = std::str::from_utf8(tail).ok()?.trim_start_matches('+').parse().ok()?;
        weight += exponent;
        rest = &[];
    }
    if !rest.is_empty() {
        return None;
    }
    style.decimals = u8::try_from((-weight).clamp(0, 30)).ok()?;
    if !style.exponent
        && let Some(number) = Decimal::read(text)
    {
        return Some((number.value(), style));
    }
    let value: f64 = std::str::from_utf8(text).ok()?.trim_start_matches('+').parse().ok()?;
    value.is_finite().then_some((value, style))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn short_numbers_are_read_in_one_pass_as_in_many(text in "[+-]?[0-9]{0,9}[.]?[0-9]{0,9}[e.x-]?") {
            if let Some(found) = plain(text.as_bytes()) {
                prop_assert_eq!(Some(found), general(text.as_bytes()));
            }
        }
    }

    #[test]
    fn an_exponent_counts_its_last_digit() {
        let (value, style) = read(b"9.60894E-05").unwrap();
        assert_eq!((value, style.decimals, style.exponent), (9.60894e-5, 10, true));
        assert_eq!(read(b"1E+10").unwrap().1.decimals, 0);
    }

    #[test]
    fn what_is_no_number_is_refused() {
        for text in ["", "-", ".", "1,5", "1.2.3", "12 ", "1e", "0x1", "nan", "inf", "1e99999"] {
            assert_eq!(read(text.as_bytes()), None, "{text}");
        }
    }
}
