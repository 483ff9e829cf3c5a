//! Numbers as a report prints them.

/// A number with so many significant digits, without zeros at its end.
pub fn digits(v: f64, n: usize) -> String {
    if v == 0.0 || !v.is_finite() {
        return if v == 0.0 { "0".into() } else { "–".into() };
    }
    let rounded: f64 = format!("{:.*e}", n.saturating_sub(1), v).parse().unwrap_or(v);
    if (1e-7..1e9).contains(&rounded.abs()) { format!("{rounded}") } else { format!("{rounded:e}") }
}
