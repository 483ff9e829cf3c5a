//! Names that are nearly others: what a misspelt key, effect or joint was meant to be.

/// Letters to insert, remove or replace until one name is the other (Levenshtein 1966).
pub fn edits(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=a.chars().count()).collect();
    for (k, y) in b.chars().enumerate() {
        let mut next = vec![k + 1];
        let mut last = k + 1;
        for (x, pair) in a.chars().zip(row.windows(2)) {
            last = (pair[0] + usize::from(x != y)).min(pair[1] + 1).min(last + 1);
            next.push(last);
        }
        row = next;
    }
    row.last().copied().unwrap_or_default()
}

/// Units at the end of a key.
const UNITS: [&str; 9] = ["deg", "rad", "mrad", "mdeg", "mm", "um", "m", "s", "ms"];

/// Whether a key may be another one misspelt: up to two letters of it (one of a short key), or its unit.
pub fn almost(key: &str, known: &str) -> bool {
    let stem = |k: &str| k.rsplit_once('_').filter(|(_, unit)| UNITS.contains(unit)).map(|(stem, _)| stem.to_string());
    let units = stem(key).is_some() && stem(key) == stem(known);
    let stripped = |k: &str| stem(k).unwrap_or_else(|| k.to_string());
    let allowed = match known.chars().count() {
        0..=3 => 0,
        4..=7 => 1,
        _ => 2,
    };
    units || stripped(key) == stripped(known) || edits(&key.to_ascii_lowercase(), known) <= allowed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_with_another_unit_or_a_letter_wrong_is_almost_the_known_one() {
        for (key, known) in [
            ("half_gap_rad", "half_gap_deg"),
            ("half_gap", "half_gap_deg"),
            ("halfgap_deg", "half_gap_deg"),
            ("hlaf_gap_deg", "half_gap_deg"),
            ("CI95", "ci95"),
            ("signficant", "significant"),
        ] {
            assert!(almost(key, known), "{key}");
        }
        for (key, known) in
            [("at_deg", "half_gap_deg"), ("positive_deg", "negative_deg"), ("cycles", "ci95"), ("log", "logs")]
        {
            let meant = almost(key, known);
            assert_eq!(meant, key == "log", "{key}");
        }
        assert_eq!((edits("kitten", "sitting"), edits("", "abc")), (3, 3));
    }
}
