//! What is known of the order in which the steps of a program run: loops, and breaks that are reached from known places.

/// A loop that is certainly entered, and whose passes all run through the same steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Round {
    /// Step of the break with which it begins.
    pub open: usize,
    /// Step of the break with which it ends.
    pub close: usize,
    /// What stands after it is reached from its end alone.
    pub goes_on: bool,
}

/// A break of which it is known from where alone control comes there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Join {
    /// Step of the break.
    pub at: usize,
    /// From the places before these steps: a condition that is looked at there, the end of a branch, a jump. Control stands there when all
    /// steps before it have been done. None: nothing leads to the break.
    pub from: Vec<usize>,
}

/// Whether the head of a loop lets it be entered whatever the program does before: constant bounds, or none.
///
/// `head = "FOR" name ("FROM" | "=") integer "TO" integer ["DO"] | "WHILE" ["("] "TRUE" [")"] ["DO" | ":"] | "LOOP"`
pub fn is_entered(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head).to_ascii_uppercase().replace('=', " = ").replace(['(', ')', ':'], " ");
    let words: Vec<&str> = text.split_ascii_whitespace().collect();
    let bound = |w: &str| w.parse::<i32>().ok();
    match words[..] {
        ["FOR", _, "FROM" | "=", from, "TO", to] | ["FOR", _, "FROM" | "=", from, "TO", to, "DO"] => {
            bound(from).zip(bound(to)).is_some_and(|(from, to)| from <= to)
        }
        ["WHILE", "TRUE"] | ["WHILE", "TRUE", "DO"] | ["LOOP"] => true,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_are_entered_by_constant_bounds_and_without_a_condition() {
        let entered =
            ["FOR i FROM 1 TO 4 DO", "for i=1 to 4", "FOR R[1]=1 TO 3", "LOOP", "while (True):", "WHILE TRUE DO"];
        assert!(entered.iter().all(|head| is_entered(head.as_bytes())));
        let not = [
            "FOR i FROM 1 TO n DO",
            "FOR i=4 TO 1",
            "FOR i=1 TO 9 STEP 2",
            "WHILE x DO",
            "while True and x:",
            "FOR R[1]=4 DOWNTO 1",
        ];
        assert!(not.iter().all(|head| !is_entered(head.as_bytes())));
    }
}
