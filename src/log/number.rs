//! Decimal text to the nearest f64, fast where the text is short.
//!
//! Method: a number of up to 15 digits is an integer over a power of ten, both exact in an f64, so the quotient is the
//! correctly rounded value (Clinger, "How to read floating point numbers accurately", 1990). Anything else is left to the
//! standard library.

/// Powers of ten that an f64 holds exactly and a short number needs.
const TENS: [f64; 16] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];

/// A plain number of at most 15 digits, exactly, and its decimals; anything else is `None`.
#[inline]
pub(super) fn number(text: &[u8], decimal: u8) -> Option<(f64, u8)> {
    let (negative, digits) = match text.split_first() {
        Some((b'-', rest)) => (true, rest),
        _ => (false, text),
    };
    if digits.is_empty() || digits.len() > 16 {
        return None;
    }
    let (mut mantissa, mut count, mut point) = (0_u64, 0_u8, None);
    for &b in digits {
        let d = b.wrapping_sub(b'0');
        if d < 10 {
            mantissa = mantissa * 10 + u64::from(d);
            count += 1;
        } else if b == decimal && point.is_none() {
            point = Some(count);
        } else {
            return None;
        }
    }
    if count == 0 || count > 15 {
        return None;
    }
    let places = point.map_or(0, |p| count - p);
    let v = mantissa as f64 / TENS[usize::from(places)];
    Some((if negative { -v } else { v }, places))
}

/// Decimals after the point of a number as written.
pub(super) fn decimals(text: &[u8]) -> u8 {
    match text.iter().position(|&b| b == b'.') {
        Some(i) => text[i + 1..].iter().take_while(|b| b.is_ascii_digit()).count().min(15) as u8,
        None => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_short_number_is_read_to_the_last_bit(digits in 0_u64..1_000_000_000_000_000, places in 0_usize..15, negative: bool) {
            let mut text = format!("{digits:0>width$}", width = places + 1);
            text.insert(text.len() - places, '.');
            if negative {
                text.insert(0, '-');
            }
            if let Some((v, found)) = number(text.as_bytes(), b'.') {
                prop_assert_eq!(v.to_bits(), text.parse::<f64>().unwrap().to_bits());
                prop_assert_eq!(usize::from(found), places);
            } else {
                prop_assert!(text.len() > 15);
            }
        }

        #[test]
        fn what_the_short_reader_takes_the_standard_library_takes_too(text in "[-+0-9.,eE ]{0,18}") {
            if let Some((v, _)) = number(text.as_bytes(), b'.') {
                prop_assert_eq!(text.parse::<f64>().unwrap().to_bits(), v.to_bits());
            }
        }
    }
}
