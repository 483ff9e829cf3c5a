//! Numbers of documents, rounded: no more digits than the figure has.

/// A value with so many decimals; zero has no sign.
pub fn round(value: f64, decimals: i32) -> f64 {
    let unit = 10f64.powi(decimals);
    (value * unit).round() / unit + 0.0
}

/// Metres as micrometres with a nanometre as the last digit.
pub fn um(m: f64) -> f64 {
    round(m * 1e6, 3)
}

/// A value with so many significant digits.
pub fn significant(value: f64, digits: i32) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let scale = 10f64.powi(digits - 1 - value.abs().log10().floor() as i32);
    if scale.is_finite() && scale > 0.0 { (value * scale).round() / scale } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rounded_number_has_its_digits_and_zero_no_sign() {
        assert_eq!([round(1.2345, 2), um(1.234_567_8e-3)], [1.23, 1234.568]);
        assert!(round(-1e-9, 3).is_sign_positive());
        assert_eq!([significant(-1234.56, 3), significant(0.0012345, 2)], [-1230.0, 0.0012]);
        assert!(significant(f64::NAN, 3).is_nan() && significant(1e-310, 6) == 1e-310);
    }
}
