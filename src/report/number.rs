//! How numbers are written: fixed decimals, a true minus sign, a dash where there is no number.

/// A value with a fixed number of decimals; `-0` is `0`; what is not finite is a dash.
pub fn number(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return "–".into();
    }
    if value.abs() >= 1e9 {
        return exponent(value);
    }
    let text = format!("{:.decimals$}", value.abs());
    let zero = text.bytes().all(|b| matches!(b, b'0' | b'.'));
    if value < 0.0 && !zero { format!("\u{2212}{text}") } else { text }
}

/// A value with three significant digits, whatever its size.
pub fn significant(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() || size >= 1e9 || (size > 0.0 && size < 1e-6) {
        return if value.is_finite() { exponent(value) } else { "–".into() };
    }
    let digits = if size == 0.0 { 0 } else { (2 - size.log10().floor() as i32).clamp(0, 8) as usize };
    number(value, digits)
}

/// An interval, dashes where an end is missing.
pub fn interval(ends: [f64; 2], decimals: usize) -> String {
    format!("{} to {}", number(ends[0], decimals), number(ends[1], decimals))
}

/// A p value: three decimals, or "< 0.001".
pub fn p_value(p: f64) -> String {
    if p.is_finite() && p < 0.001 { "< 0.001".into() } else { number(p, 3) }
}

/// A share as whole per cent.
pub fn percent(share: f64) -> String {
    if share.is_finite() { format!("{}\u{202f}%", number(share * 100.0, 0)) } else { "–".into() }
}

/// A whole number in groups of three.
pub fn count(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(c);
    }
    out
}

/// A drawing coordinate: one decimal, no `-0`, never `NaN`.
pub(super) fn px(value: f64) -> String {
    let v = if value.is_finite() { (value.clamp(-1e5, 1e5) * 10.0).round() / 10.0 } else { 0.0 };
    if v == 0.0 { "0".into() } else { format!("{v}") }
}

fn exponent(value: f64) -> String {
    format!("{value:.2e}").replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_has_a_true_minus_no_negative_zero_and_a_dash_for_nothing() {
        assert_eq!(number(-1.25, 1), "\u{2212}1.2");
        assert_eq!(number(-0.001, 1), "0.0");
        assert_eq!(number(f64::NAN, 1), "–");
        assert_eq!(number(f64::NEG_INFINITY, 1), "–");
        assert_eq!(number(1e300, 1), "1.00e300");
    }

    #[test]
    fn coordinates_are_short_and_always_numbers() {
        assert_eq!([px(12.34), px(-0.04), px(f64::NAN), px(f64::INFINITY), px(7.0)], ["12.3", "0", "0", "0", "7"]);
    }

    #[test]
    fn counts_are_grouped_and_p_values_end_at_a_thousandth() {
        assert_eq!(count(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!(count(12), "12");
        assert_eq!(p_value(1e-200), "< 0.001");
        assert_eq!(p_value(0.4), "0.400");
        assert_eq!(significant(0.012345), "0.0123");
        assert_eq!(significant(1234.5), "1234");
    }
}
