//! Numbers of vendor programs: read with the style in which they are written (in `reading`), written in that style again.

mod reading;

pub use super::shares::share_out;
use crate::decimal::print::ROOM;
use crate::decimal::{Decimal, MOST, POW10};
pub use reading::read;

/// How a number is written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Style {
    /// Digits after the point; for an exponent those of its last digit's weight.
    pub decimals: u8,
    /// `5.` has a point and no digits after it.
    pub point: bool,
    /// `.384` instead of `0.384`.
    pub bare: bool,
    /// `+1.5`.
    pub plus: bool,
    /// `9.60894E-05`: `E` or `e`; written plainly again when it is changed.
    pub exponent: bool,
}

/// A number as it stands in a program.
#[derive(Debug, Clone, Copy)]
pub struct Own<'a> {
    /// Its bytes; where it is computed, whatever stands in its place.
    pub text: &'a [u8],
    /// As it was read, in its own unit.
    pub value: f64,
    /// How it is written.
    pub style: Style,
}

impl Own<'_> {
    /// Its digits; `None`: it has an exponent or too many of them, or is no plain number.
    fn decimal(&self) -> Option<Decimal> {
        /// More than the arithmetic of a unit there and back, as a share.
        const SAME: f64 = 1e-9;
        let own = Decimal::read(self.text)?;
        ((own.value() - self.value).abs() <= SAME * self.value.abs().max(1.0)).then_some(own)
    }

    /// What it becomes where its value becomes `new`: the digits that stand there and the difference, added in integers, so that what
    /// was read is not rounded on its way through another unit. `None`: only the nearest number of the standard library tells.
    pub fn moved(&self, new: f64, decimals: u8) -> Option<Decimal> {
        moved(self.decimal(), self.value, new, decimals)
    }
}

fn moved(own: Option<Decimal>, old: f64, new: f64, decimals: u8) -> Option<Decimal> {
    own.and_then(|own| own.offset(new - old, decimals)).or_else(|| nearest(new, decimals))
}

/// The number that `own` becomes with the value `new`, after what stands in `out`.
pub fn append_moved(out: &mut Vec<u8>, own: Own, new: f64, style: Style, decimals: u8) {
    match own.moved(new, decimals) {
        Some(number) => put(out, number, style),
        None => out.extend_from_slice(write(new, style, decimals).as_bytes()),
    }
}

/// The same as text.
pub fn write_moved(own: Own, new: f64, style: Style, decimals: u8) -> String {
    let number = own.moved(new, decimals).and_then(text_of);
    number.map_or_else(|| write(new, style, decimals), |text| styled(text, style, decimals))
}

fn put(out: &mut Vec<u8>, number: Decimal, style: Style) {
    if style.bare || style.plus || style.point && number.decimals() == 0 {
        out.extend_from_slice(styled(text_of(number).unwrap_or_default(), style, number.decimals()).as_bytes());
    } else {
        number.write(out);
    }
}

/// A number with `decimals` digits after the point, otherwise in `style`. A number that rounds to zero has no sign.
pub fn write(value: f64, style: Style, decimals: u8) -> String {
    styled(digits_of(value, decimals), style, decimals)
}

fn styled(mut text: String, style: Style, decimals: u8) -> String {
    if style.bare {
        let (sign, digits) = text.strip_prefix('-').map_or(("", text.as_str()), |d| ("-", d));
        if let Some(fraction) = digits.strip_prefix("0.") {
            text = format!("{sign}.{fraction}");
        }
    }
    if style.point && decimals == 0 {
        text.push('.');
    }
    if style.plus && !text.starts_with('-') {
        text.insert(0, '+');
    }
    text
}

/// The same after what stands in `out`.
pub fn append(out: &mut Vec<u8>, value: f64, style: Style, decimals: u8) {
    match nearest(value, decimals) {
        Some(number) => put(out, number, style),
        None => out.extend_from_slice(write(value, style, decimals).as_bytes()),
    }
}

/// The decimal of so many digits after the point that is nearest to the number; zero has no sign.
pub fn rounded(value: f64, decimals: u8) -> f64 {
    let exact = || digits_of(value, decimals).parse().unwrap_or(value);
    nearest(value, decimals).map_or_else(exact, |d| d.value() + 0.0)
}

/// The digits of the decimal that is nearest to the number, exactly; zero has no sign.
fn digits_of(value: f64, decimals: u8) -> String {
    if let Some(text) = nearest(value, decimals).and_then(text_of) {
        return text;
    }
    let mut text = format!("{value:.*}", usize::from(decimals));
    if text.starts_with('-') && !text.bytes().any(|b| (b'1'..=b'9').contains(&b)) {
        text.remove(0);
    }
    text
}

/// The same in integers; `None`: the number is large, or so near to the middle of two decimals that a product does not tell.
fn nearest(value: f64, decimals: u8) -> Option<Decimal> {
    /// Doubles up to here have at least four digits after the point.
    const LARGEST: f64 = 1e12;
    /// More than the product is off, in last digits.
    const UNSURE: f64 = 1e-3;
    let power = POW10.get(usize::from(decimals)).filter(|_| decimals <= MOST)?;
    let scaled = value.abs() * power;
    if scaled.is_nan() || scaled > LARGEST {
        return None;
    }
    let count = scaled.round();
    if (scaled - count).abs() > 0.5 - UNSURE {
        return None;
    }
    Decimal::signed(value < 0.0, count as u64, decimals)
}

fn text_of(number: Decimal) -> Option<String> {
    let mut text = Vec::with_capacity(ROOM);
    number.write(&mut text);
    String::from_utf8(text).ok()
}

/// Decimals whose last digit weighs `digit` at most, in the number's own unit, between those of its style and `most`.
#[inline]
pub fn decimals_for(style: Style, digit: f64, most: u8) -> u8 {
    let own = style.decimals.min(most);
    if !(digit.is_finite() && digit > 0.0) {
        return own;
    }
    own.max(places(digit, 30).min(most))
}

/// Fewest digits after the point, up to `most`, of which the last weighs `digit` at most.
fn places(digit: f64, most: u8) -> u8 {
    /// A last digit that is larger by such a share is the same.
    const SLACK: f64 = 1e-9 * std::f64::consts::LN_10;
    /// Nearer than this to the slack the logarithm decides.
    const UNSURE: f64 = 1e-11;
    // with so many digits the last one certainly weighs more than half of what is asked for
    let exponent = ((digit.to_bits() >> 52) & 0x7FF) as i32 - 1023;
    let few = (f64::from(-exponent - 2) * std::f64::consts::LOG10_2).max(0.0) as usize;
    for (n, power) in POW10.iter().enumerate().take(usize::from(most)).skip(few) {
        let above = digit * power - (1.0 - SLACK);
        if above.is_nan() || above.abs() < UNSURE {
            break;
        }
        if above > 0.0 {
            return n as u8;
        }
    }
    (-digit.log10() - 1e-9).ceil().clamp(0.0, f64::from(most)) as u8
}

/// Weight of the last of so many digits after the point.
#[inline]
pub fn last_digit(decimals: u8) -> f64 {
    const WEIGHTS: [f64; POW10.len()] = {
        let mut weights = POW10;
        let mut d = 0;
        while d < weights.len() {
            weights[d] = 1.0 / POW10[d];
            d += 1;
        }
        weights
    };
    WEIGHTS.get(usize::from(decimals)).copied().unwrap_or_else(|| 10_f64.powi(-i32::from(decimals)))
}

/// A number right-aligned in a field of `width` characters, as controllers print columns; wider where it does not fit.
pub fn field(text: &str, width: usize) -> String {
    format!("{text:>width$}")
}

/// A changed number in the style of the old one, all in the number's own unit: with a last digit of at most `digit`, but none
/// finer than `finest`. `None`: it stays as it is.
pub fn changed(own: Own, new: f64, digit: f64, finest: f64) -> Option<String> {
    let mut out = Vec::with_capacity(ROOM);
    append_changed(&mut out, own, new, digit, finest).then(|| String::from_utf8(out).unwrap_or_default())
}

/// The same after what stands in `out`; `false`: it stays as it is, and nothing is added.
pub fn append_changed(out: &mut Vec<u8>, own: Own, new: f64, digit: f64, finest: f64) -> bool {
    if (new - own.value).abs() <= 1e-12 * own.value.abs().max(1.0) {
        return false;
    }
    let most = places(finest, 12);
    let mut style = own.style;
    if style.exponent {
        // an exponent says nothing about how fine the number is meant
        style.decimals = style.decimals.min(most);
        style.exponent = false;
    }
    let decimals = decimals_for(style, digit, most);
    let exact = own.decimal();
    let old = match exact {
        Some(old) if old.decimals() == decimals => Some(old),
        exact => exact.and_then(|old| old.rounded(decimals)).or_else(|| nearest(own.value, decimals)),
    };
    if let (Some(old), Some(new)) = (old, moved(exact, own.value, new, decimals)) {
        // a zero is written without its sign
        let differs = old.mantissa() != new.mantissa();
        if differs {
            put(out, new, style);
        }
        return differs;
    }
    let text = write(new, style, decimals);
    let differs = text != write(own.value, style, decimals);
    if differs {
        out.extend_from_slice(text.as_bytes());
    }
    differs
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn places_are_those_of_the_logarithm(n in 0i32..14, shift in -3e-9f64..3e-9, most in 0u8..31) {
            for digit in [10f64.powi(-n) * (1.0 + shift), 10f64.powi(-n) * (1.0 + 1e8 * shift)] {
                let expected = (-digit.log10() - 1e-9).ceil().clamp(0.0, f64::from(most)) as u8;
                prop_assert_eq!(places(digit, most), expected);
            }
        }
    }

    fn own(text: &str) -> Own<'_> {
        let (value, style) = read(text.as_bytes()).unwrap();
        Own { text: text.as_bytes(), value, style }
    }

    /// The number that `text` becomes by an offset in degrees that went through radians, as the engine's do.
    fn through_radians(text: &str, by: f64, digit: f64) -> Option<String> {
        let degree = 1f64.to_radians();
        let own = own(text);
        let (si, new) = (own.value * degree, own.value * degree + by * degree);
        changed(Own { value: si / degree, ..own }, new / degree, digit, 1e-9)
    }

    #[test]
    fn ties_are_those_of_the_digits_that_stand_there() {
        // no double is 2.675, nor 0.005: through radians the sums fall to either side
        for (text, by, sum) in [
            ("2.67", 0.005, "2.68"),
            ("-2.67", -0.005, "-2.68"),
            ("1.00", 0.005, "1.01"),
            ("0.14", 0.005, "0.15"),
            ("-0.14", -0.005, "-0.15"),
            ("89.99", 0.005, "90.00"),
            ("-179.99", -0.005, "-180.00"),
            (".14", 0.005, ".15"),
            ("+0.14", 0.005, "+0.15"),
            ("0.005", -0.005, "0.000"),
        ] {
            assert_eq!(through_radians(text, by, f64::NAN).as_deref(), Some(sum), "{text} {by}");
        }
        assert_eq!(through_radians("2.67", 0.00499, f64::NAN), None);
        assert_eq!(through_radians("2.67", 0.00285, 1e-3).as_deref(), Some("2.673"));
    }

    proptest! {
        /// Sums of decimals are exact, whatever unit the offset has gone through.
        #[test]
        fn an_offset_is_added_to_the_digits_that_stand_there(
            count in -9_999_999i64..10_000_000, decimals in 1u8..6, by in -99_999i64..100_000
        ) {
            let text = Decimal::new(count, decimals).unwrap().to_string();
            let degree = 1f64.to_radians();
            let offset = by as f64 / POW10[usize::from(decimals)] / 10.0;
            let new = (own(&text).value * degree + offset * degree) / degree;
            let got = own(&text).moved(new, decimals).unwrap();
            // one digit more, halves away from zero
            let fine = 10 * count + by;
            let want = (fine.abs() + 5) / 10 * fine.signum();
            prop_assert_eq!(got.mantissa(), want);
        }
    }

    #[test]
    fn a_number_that_is_computed_has_no_digits_of_its_own() {
        let style = Style { decimals: 3, point: true, ..Style::default() };
        let computed = Own { text: b"12.5", value: 25.0, style };
        assert_eq!(changed(computed, 25.001, f64::NAN, 1e-9).as_deref(), Some("25.001"));
        let named = Own { text: b"pi/2", ..computed };
        assert_eq!(write_moved(named, 1.5, style, 3), "1.500");
    }

    #[test]
    fn styles_come_back() {
        for text in ["-12.340", ".384", "-.5", "+7.25", "35", "0.000", "5."] {
            let (value, style) = read(text.as_bytes()).unwrap();
            assert_eq!(write(value, style, style.decimals), text);
        }
    }

    proptest! {
        #[test]
        fn numbers_are_written_as_the_standard_library_rounds_them(
            count in -99_999_999_999i64..99_999_999_999, shift in 0u8..9, off in -2i64..3, decimals in 0u8..12
        ) {
            // doubles at, and beside, numbers and ties
            let near = count as f64 / POW10[usize::from(shift)];
            let value = f64::from_bits((near.to_bits() as i64 + off).max(0) as u64);
            for value in [value, value / 2.0, -value] {
                let text = format!("{value:.*}", usize::from(decimals));
                let zero = !text.bytes().any(|b| (b'1'..=b'9').contains(&b));
                let text = if zero { text.trim_start_matches('-') } else { &text };
                prop_assert_eq!(write(value, Style::default(), decimals), text);
            }
        }
    }

    #[test]
    fn more_decimals_where_they_are_needed() {
        let style = read(b"35.13").unwrap().1;
        assert_eq!(decimals_for(style, 1e-4, 6), 4);
        assert_eq!(decimals_for(style, 1e-4, 3), 3);
        assert_eq!(decimals_for(style, 1.0, 6), 2);
    }
}
