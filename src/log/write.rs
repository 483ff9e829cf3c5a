//! Numbers, fields and column names of a log, as bytes (contract, section 4).
//!
//! Fixed decimals: a value is rounded half away from zero as a whole number of last digits, which is exact up to 2^53 of
//! them (9 km at 1 nm) and many times faster than the formatter of the standard library, to which larger values go.
//! A zero has no sign.

use crate::robot::Joint;

/// Appends `value` with `decimals` (0 to 15) digits after the point.
pub fn number(out: &mut Vec<u8>, value: f64, decimals: u8) {
    const EXACT: f64 = 9_007_199_254_740_992.0;
    let scaled = value * 10f64.powi(i32::from(decimals));
    if !scaled.is_finite() || scaled.abs() >= EXACT {
        out.extend_from_slice(format!("{value:.*}", usize::from(decimals)).as_bytes());
        return;
    }
    let mut whole = scaled.abs().round() as u64;
    if scaled < 0.0 && whole > 0 {
        out.push(b'-');
    }
    let mut digits = [b'0'; 20];
    let mut first = digits.len();
    let least = usize::from(decimals) + 1; // at least one digit before the point
    while whole > 0 || digits.len() - first < least {
        first -= 1;
        digits[first] = b'0' + (whole % 10) as u8;
        whole /= 10;
    }
    let point = digits.len() - usize::from(decimals);
    out.extend_from_slice(&digits[first..point]);
    if decimals > 0 {
        out.push(b'.');
        out.extend_from_slice(&digits[point..]);
    }
}

/// Appends a CSV field, in quotes where it needs them.
pub fn field(out: &mut Vec<u8>, text: &[u8]) {
    field_between(out, text, b',');
}

/// The same with another separator.
pub fn field_between(out: &mut Vec<u8>, text: &[u8], separator: u8) {
    if !text.iter().any(|b| *b == separator || matches!(b, b'"' | b'\n' | b'\r')) {
        out.extend_from_slice(text);
        return;
    }
    out.push(b'"');
    for &b in text {
        if b == b'"' {
            out.push(b'"');
        }
        out.push(b);
    }
    out.push(b'"');
}

/// Column of a joint: `cmd_A1_deg`; `what` is `cmd`, `enc` or `meas`.
pub fn joint_column(what: &str, joint: &Joint) -> String {
    format!("{what}_{}_{}", joint.name, joint.kind.unit())
}

/// Columns of reflector `k`, counted from 0: `x_mm`, then `x2_mm`, `x3_mm`, ...
pub fn position_columns(k: usize) -> [String; 3] {
    let number = if k == 0 { String::new() } else { (k + 1).to_string() };
    ["x", "y", "z"].map(|c| format!("{c}{number}_mm"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(value: f64, decimals: u8) -> String {
        let mut out = Vec::new();
        number(&mut out, value, decimals);
        String::from_utf8(out).unwrap_or_default()
    }

    #[test]
    fn numbers_have_the_digits_that_were_asked_for() {
        assert_eq!(text(-14.35909, 6), "-14.359090");
        assert_eq!(text(0.04, 3), "0.040");
        assert_eq!(text(-1e-9, 6), "0.000000");
        assert_eq!(text(12.0, 0), "12");
        assert_eq!(text(-0.0005, 3), "-0.001");
        assert_eq!(text(1e18, 3), "1000000000000000000.000");
    }

    #[test]
    fn numbers_are_those_of_the_standard_formatter_away_from_ties() {
        let mut x = 0.123_456_789_f64;
        for _ in 0..20_000 {
            x = (x * 997.0 + 0.618_033_988_749).rem_euclid(5000.0);
            let v = x - 2500.0;
            let want = format!("{v:.6}");
            assert_eq!(text(v, 6), if want == "-0.000000" { "0.000000".into() } else { want });
        }
    }

    #[test]
    fn a_field_with_a_comma_stands_in_quotes() {
        let mut out = Vec::new();
        field(&mut out, b"a,\"b\"");
        assert_eq!(out, b"\"a,\"\"b\"\"\"");
    }
}
