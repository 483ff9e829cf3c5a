//! How many lines of a program's text changed.
//!
//! Method: both texts are walked together; where lines differ, the next common line within [`AHEAD`] lines on either side ends the
//! difference. That finds changed numbers and inserted moves, which is all that a rewrite does; it is no general diff.

/// Lines ahead within which both texts meet again.
const AHEAD: usize = 64;

/// Lines of two texts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
pub struct TextDifference {
    pub unchanged: usize,
    pub changed: usize,
    pub added: usize,
    pub removed: usize,
}

/// Compares two texts line by line.
pub fn difference(before: &[u8], after: &[u8]) -> TextDifference {
    let a: Vec<&[u8]> = before.split(|b| *b == b'\n').collect();
    let b: Vec<&[u8]> = after.split(|b| *b == b'\n').collect();
    let mut out = TextDifference::default();
    let (mut i, mut j) = (0, 0);
    while i < a.len() && j < b.len() {
        if a[i] == b[j] {
            out.unchanged += 1;
            (i, j) = (i + 1, j + 1);
            continue;
        }
        // the nearest place from which both are equal again
        let meet = (1..=2 * AHEAD).find_map(|sum| {
            (0..=sum)
                .map(|k| (k, sum - k))
                .filter(|(x, y)| *x <= AHEAD && *y <= AHEAD && i + x < a.len() && j + y < b.len())
                .find(|(x, y)| a[i + x] == b[j + y])
        });
        let (x, y) = meet.unwrap_or((a.len() - i, b.len() - j));
        out.changed += x.min(y);
        out.added += y.saturating_sub(x);
        out.removed += x.saturating_sub(y);
        (i, j) = (i + x, j + y);
    }
    out.removed += a.len() - i;
    out.added += b.len() - j;
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changed_and_inserted_lines_are_counted_apart() {
        let before = b"head\n1,2\n3,4\n5,6\ntail\n";
        let after = b"head\n1,2\n3,4.001\n3,4.002\n5,6\ntail\n";
        let d = difference(before, after);
        assert_eq!(d, TextDifference { unchanged: 5, changed: 1, added: 1, removed: 0 });
        assert_eq!(difference(before, before).unchanged, 6);
        assert_eq!(difference(after, before).removed, 1);
    }
}
