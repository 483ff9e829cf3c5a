//! A number in the style of the one it replaces: signs, zeros in front and exponents as they were.

use crate::decimal::{Decimal, POW10};

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

    /// `value` with `decimals` digits after the point (of an exponent form: down to the weight `10^-decimals`).
    pub fn write(&self, value: f64, decimals: usize, out: &mut Vec<u8>) {
        let text = match self.exponent {
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
        self.dress(value < 0.0 && !zero, text.as_bytes(), out);
    }

    /// A decimal, digit for digit.
    pub fn write_decimal(&self, number: Decimal, out: &mut Vec<u8>) {
        let mut text = Vec::new();
        number.write(&mut text);
        let negative = text.first() == Some(&b'-');
        self.dress(negative, text.get(usize::from(negative)..).unwrap_or_default(), out);
    }

    /// Sign and zeros in front of `text`.
    fn dress(&self, negative: bool, text: &[u8], out: &mut Vec<u8>) {
        match (negative, self.plus) {
            (true, _) => out.push(b'-'),
            (false, true) => out.push(b'+'),
            _ => {}
        }
        match text {
            [b'0', fraction @ ..] if self.whole == 0 && fraction.first() == Some(&b'.') => {
                out.extend_from_slice(fraction)
            }
            _ => {
                let digits = text.iter().take_while(|b| b.is_ascii_digit()).count();
                out.resize(out.len() + self.whole.saturating_sub(digits), b'0');
                out.extend_from_slice(text);
            }
        }
    }

    /// It has an exponent.
    pub fn has_exponent(&self) -> bool {
        self.exponent.is_some()
    }
}

/// `10^d` for up to 22 digits.
pub fn power(d: usize) -> f64 {
    POW10.get(d).copied().unwrap_or(f64::INFINITY)
}

#[cfg(test)]
mod tests {
    use super::*;

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
            let look = Look::of(old.as_bytes());
            if !look.has_exponent() {
                let mut out = Vec::new();
                look.write_decimal(Decimal::nearest(value, decimals as u8).unwrap(), &mut out);
                assert_eq!(String::from_utf8(out).unwrap(), want, "{old}");
            }
        }
    }
}
