//! A number in the style of the one it replaces.
//!
//! Method: the value is scaled to an integer count of its last digit, and the integer's eight digits are made in one word
//! (pairwise division by multiplication); larger numbers and unusual styles go through the standard library.

use super::number::POW10;

/// Longest fast number: sign, 8 digits, point, and room for whole words.
pub const ROOM: usize = 32;
const ZEROS: u64 = 0x3030_3030_3030_3030;

/// The eight decimal digits of `n < 10^8`, a byte each, first digit in the lowest.
#[inline(always)]
fn eight_digits(n: u64) -> u64 {
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

/// What the bytes of a number say about its style.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Look<'a> {
    plus: bool,
    /// Digits before the point that are kept by zeros, 0: no digit where the value is below 1.
    whole: usize,
    /// Letter, sign and digits of an exponent.
    exponent: Option<(u8, &'a [u8])>,
}

impl<'a> Look<'a> {
    /// Looks at a number that has been read before.
    pub fn of(text: &'a [u8]) -> Self {
        let plus = text.first() == Some(&b'+');
        let body = match text.first() {
            Some(b'+' | b'-') => &text[1..],
            _ => text,
        };
        let whole = body.iter().take_while(|b| b.is_ascii_digit()).count();
        let padded = whole > 1 && body[0] == b'0';
        let exponent = body.iter().position(|b| matches!(b, b'e' | b'E')).map(|k| (body[k], &body[k + 1..]));
        Self {
            plus,
            whole: if whole == 0 {
                0
            } else if padded {
                whole
            } else {
                1
            },
            exponent,
        }
    }

    /// `value` with `decimals` digits behind the point (of an exponent form: down to the weight `10^-decimals`).
    pub fn write(&self, value: f64, decimals: usize, out: &mut Vec<u8>) {
        let mut text = match self.exponent {
            None => format!("{:.decimals$}", value.abs()),
            Some((letter, old)) => {
                let power = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
                let digits = (decimals as i32 + power).max(0) as usize;
                let text = format!("{:.digits$e}", value.abs());
                let (mantissa, power) = text.split_once('e').unwrap_or((&text, "0"));
                let power: i32 = power.parse().unwrap_or(0);
                let width = old.iter().filter(|b| b.is_ascii_digit()).count();
                let sign = match (power < 0, old.first()) {
                    (true, _) => "-",
                    (false, Some(b'+')) => "+",
                    // `e-05` comes from a writer that also writes `e+05`
                    (false, Some(b'-')) if width > 1 => "+",
                    _ => "",
                };
                format!("{mantissa}{}{sign}{:0width$}", char::from(letter), power.unsigned_abs())
            }
        };
        let zero = !text.split(['e', 'E']).next().unwrap_or("").bytes().any(|b| matches!(b, b'1'..=b'9'));
        if self.whole == 0 && text.starts_with("0.") {
            text.remove(0);
        } else {
            let digits = text.bytes().take_while(u8::is_ascii_digit).count();
            text.insert_str(0, &"0".repeat(self.whole.saturating_sub(digits)));
        }
        match (value < 0.0 && !zero, self.plus) {
            (true, _) => out.push(b'-'),
            (false, true) => out.push(b'+'),
            _ => {}
        }
        out.extend_from_slice(text.as_bytes());
    }
}

/// `10^d` for up to 22 digits.
pub fn power(d: usize) -> f64 {
    POW10.get(d).copied().unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn fixed_numbers_are_written_as_the_standard_library_writes_them(
            n in 0u64..100_000_000, small in 0u64..100_000, d in 0u32..8, negative: bool
        ) {
            for n in [n, small, small / 1000] {
                let mut out = [0u8; ROOM];
                let len = fixed(&mut out, negative, n, d);
                let sign = if negative && n != 0 { "-" } else { "" };
                let unit = 10u64.pow(d);
                let want = match d {
                    0 => format!("{sign}{n}"),
                    _ => format!("{sign}{}.{:0width$}", n / unit, n % unit, width = d as usize),
                };
                prop_assert_eq!(std::str::from_utf8(&out[..len]).unwrap(), want);
            }
        }
    }

    #[test]
    fn unusual_styles_are_kept() {
        let cases = [
            ("+1.50", 2.25, 2, "+2.25"),
            ("+1.50", -2.25, 2, "-2.25"),
            (".384", 0.3868, 4, ".3868"),
            (".384", -0.3868, 4, "-.3868"),
            (".384", 1.2, 3, "1.200"),
            ("007.5", 8.25, 2, "008.25"),
            ("-007.5", -0.001, 2, "000.00"),
            ("1.50E+01", 15.0028, 4, "1.50028E+01"),
            ("9.60894E-05", 0.002896, 10, "2.8960000E-03"),
            ("1.5e-3", 0.0, 4, "0.0000e0"),
            ("5.", 5.0028, 4, "5.0028"),
        ];
        for (old, value, decimals, want) in cases {
            let mut out = Vec::new();
            Look::of(old.as_bytes()).write(value, decimals, &mut out);
            assert_eq!(String::from_utf8(out).unwrap(), want, "{old}");
        }
    }
}
