//! Two programs as text: equal but for numbers that differ by no more than a tolerance.
//!
//! Method: line by line, both are split into numbers and what stands between them. What stands between must be the same bytes;
//! numbers may differ by the tolerance, in the unit in which the program writes them. A whole number that belongs to a name or
//! counts something (`P1`, `G1`, `P[1]`, `1:` at the start of a line) is text.

/// Where two texts differ for the first time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FirstDifference {
    /// From 1.
    pub line: u64,
    /// The text that ends before this line.
    pub ends: Option<Text>,
}

/// One of two texts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Text {
    First,
    Second,
}

/// The first line that differs by more than `tolerance`; `None`: no line does. Without a tolerance every byte counts.
pub fn first_difference(a: &[u8], b: &[u8], tolerance: Option<f64>) -> Option<FirstDifference> {
    if a == b {
        return None;
    }
    let (mut ours, mut theirs) = (a.split_inclusive(|c| *c == b'\n'), b.split_inclusive(|c| *c == b'\n'));
    let mut line = 1;
    loop {
        match (ours.next(), theirs.next()) {
            (None, None) => return None,
            (Some(x), Some(y)) if same_line(x, y, tolerance) => line += 1,
            (None, Some(_)) => return Some(FirstDifference { line, ends: Some(Text::First) }),
            (Some(_), None) => return Some(FirstDifference { line, ends: Some(Text::Second) }),
            _ => return Some(FirstDifference { line, ends: None }),
        }
    }
}

/// Whether two lines are the same but for numbers within `tolerance`.
pub fn same_line(a: &[u8], b: &[u8], tolerance: Option<f64>) -> bool {
    if a == b {
        return true;
    }
    let Some(tolerance) = tolerance else { return false };
    let (mut i, mut j) = (0, 0);
    loop {
        match (number_at(a, i), number_at(b, j)) {
            (Some(x), Some(y)) => {
                let (xs, ys) = (&a[i..x], &b[j..y]);
                if xs != ys && ((counts(a, i, x) || counts(b, j, y)) || !near(xs, ys, tolerance)) {
                    return false;
                }
                (i, j) = (x, y);
            }
            (None, None) => match (a.get(i), b.get(j)) {
                (None, None) => return true,
                (Some(x), Some(y)) if x == y => (i, j) = (i + 1, j + 1),
                _ => return false,
            },
            _ => return false,
        }
    }
}

/// End of the number that starts at `from`: sign, digits with at most one point, exponent.
fn number_at(text: &[u8], from: usize) -> Option<usize> {
    let digits = |mut k: usize| {
        while text.get(k).is_some_and(u8::is_ascii_digit) {
            k += 1;
        }
        k
    };
    // a sign after a number or a name is an operator
    let operand = from > 0 && (text[from - 1].is_ascii_alphanumeric() || b")]_".contains(&text[from - 1]));
    let signed = matches!(text.get(from), Some(b'-' | b'+')) && (!operand || single_letter(text, from));
    let start = from + usize::from(signed);
    let mut end = digits(start);
    let mut any = end > start;
    if text.get(end) == Some(&b'.') {
        let after = digits(end + 1);
        any |= after > end + 1;
        end = if any { after } else { end };
    }
    if !any {
        return None;
    }
    if matches!(text.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(text.get(end + 1), Some(b'-' | b'+')));
        let after = digits(end + 1 + sign);
        end = if after > end + 1 + sign { after } else { end };
    }
    Some(end)
}

/// The byte before `from` is a letter that stands alone: `X` of `X-12.5`.
fn single_letter(text: &[u8], from: usize) -> bool {
    let alone = from < 2 || !(text[from - 2].is_ascii_alphanumeric() || text[from - 2] == b'_');
    from > 0 && text[from - 1].is_ascii_alphabetic() && alone
}

/// A whole number that belongs to a name, or counts.
fn counts(text: &[u8], from: usize, end: usize) -> bool {
    let whole = text[from..end].iter().all(u8::is_ascii_digit);
    let before = text[..from].last();
    let named = before.is_some_and(|c| c.is_ascii_alphabetic() || *c == b'_');
    let listed = before == Some(&b'[') && text.get(end) == Some(&b']');
    let numbered = text.get(end) == Some(&b':') && text[..from].iter().all(u8::is_ascii_whitespace);
    whole && (named || listed || numbered)
}

fn near(a: &[u8], b: &[u8], tolerance: f64) -> bool {
    let value = |t: &[u8]| std::str::from_utf8(t).ok().and_then(|t| t.parse::<f64>().ok());
    // a difference that the digits show as the tolerance is within it
    matches!((value(a), value(b)), (Some(x), Some(y)) if (x - y).abs() <= tolerance + 4.0 * f64::EPSILON * x.abs().max(y.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn same(a: &str, b: &str, tolerance: f64) -> bool {
        same_line(a.as_bytes(), b.as_bytes(), Some(tolerance))
    }

    #[test]
    fn numbers_may_differ_by_the_tolerance_and_by_no_more() {
        assert!(same("PTP {A1 10.0010,A2 -90.0}", "PTP {A1 10.002,A2 -90.0}", 0.001));
        assert!(!same("PTP {A1 10.0010,A2 -90.0}", "PTP {A1 10.0021,A2 -90.0}", 0.001));
        assert!(same("G1 X-0.0004 Y1e-3", "G1 X0.0003 Y0.0012", 0.001));
        assert!(same("C00001=1234,-56", "C00001=1235,-57", 1.0), "pulses");
        assert!(same("a,1.0\r\n", "a,1.00\r\n", 0.0));
    }

    #[test]
    fn text_and_numbers_of_names_must_be_equal() {
        for (a, b) in [
            ("PTP P1", "PTP P2"),
            ("G0 X1.5", "G1 X1.5"),
            ("1:J P[1] 50% FINE", "1:J P[2] 50% FINE"),
            ("  1:J P[1]", "  2:J P[1]"),
            ("PTP {A1 1.0}", "PTP {A2 1.0}"),
            ("LIN x", "LIN x "),
            ("1.0\n", "1.0\r\n"),
            ("a 1.0", "a 1.0 2.0"),
            ("a-1.0", "a+1.0"),
        ] {
            assert!(!same(a, b, 1.0), "{a} and {b}");
        }
        assert!(!same_line(b"1.0", b"1.00", None), "without a tolerance every byte counts");
    }

    #[test]
    fn the_first_line_that_differs_is_named() {
        let at = |a: &str, b: &str, t| first_difference(a.as_bytes(), b.as_bytes(), t);
        assert_eq!(at("1.0\n2.0\n", "1.0\n2.1\n", None), Some(FirstDifference { line: 2, ends: None }));
        assert_eq!(at("1.0\n2.0\n", "1.1\n2.1\n", Some(0.2)), None);
        assert_eq!(at("1.0\n", "1.0\n2.0\n", Some(0.2)), Some(FirstDifference { line: 2, ends: Some(Text::First) }));
    }
}
