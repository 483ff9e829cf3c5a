//! The ways in which users write the direction of approach.

/// Whether a cell says forward (`true`) or backward; `None`: neither, or not clearly.
///
/// Forward is the direction in which the position rises, whatever the letters: `+1`, `1`, `+`, `forward`, `fwd`, `f`, `up`, `pos`,
/// `positive`, `>`, an arrow up or to the right. `0` is not a direction: who writes 0 and 1 may mean either.
pub fn is_forward(cell: &str) -> Option<bool> {
    let text = cell.trim().to_lowercase();
    match text.as_str() {
        "+" | "forward" | "forwards" | "fwd" | "fw" | "f" | "up" | "pos" | "positive" | "increasing" | ">" | "->"
        | "↑" | "→" => return Some(true),
        "-" | "\u{2212}" | "backward" | "backwards" | "bwd" | "bw" | "b" | "down" | "neg" | "negative"
        | "decreasing" | "<" | "<-" | "↓" | "←" | "\u{2212}1" => return Some(false),
        "reverse" | "rev" | "return" => return Some(false),
        _ => {}
    }
    match text.parse::<f64>() {
        Ok(1.0) => Some(true),
        Ok(-1.0) => Some(false),
        _ => None,
    }
}

/// What is expected of a cell, for messages.
pub const EXPECTED: &str = "+1 or -1, + or -, forward or backward";

#[cfg(test)]
mod tests {
    use super::is_forward;

    #[test]
    fn the_usual_ways_are_understood_and_0_is_not() {
        for forward in ["+1", "1", "1.0", "+", "Forward", "fwd", "UP", "pos", " f ", "↑"] {
            assert_eq!(is_forward(forward), Some(true), "{forward}");
        }
        for backward in ["-1", "-1.0", "-", "backward", "BWD", "down", "neg", "\u{2212}", "reverse"] {
            assert_eq!(is_forward(backward), Some(false), "{backward}");
        }
        for neither in ["", "0", "2", "left", "nan", "+-"] {
            assert_eq!(is_forward(neither), None, "{neither}");
        }
    }
}
