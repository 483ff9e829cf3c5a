//! Words that steer the order of blocks, and lines of them that do what is not read.

use super::assignments::Assignments;
use super::lex::{self, Block};
use crate::script::Text;

/// What a line assigns; a text for the operator assigns nothing.
pub(super) fn assignments_of(text: &Text, k: usize, block: &Block) -> Option<Assignments> {
    if !block.assignment && block.words.iter().any(lex::is_message) && !text.line(k).contains(&b'#') {
        return None;
    }
    Assignments::of(text.line(k))
}

/// Whether a line of flow control does what is not read: anything after its condition but a jump, the start of a loop, or an
/// assignment, which is looked at elsewhere.
pub(super) fn flow_hides(text: &Text, k: usize, block: &Block) -> bool {
    let line = || Assignments::compact(text.line(k));
    match (block.flow.as_deref(), block.keyword.as_deref()) {
        (Some(word), _) if !word.is_empty() => {
            let line = line();
            !behind_label(&line).and_then(|rest| rest.strip_prefix(word)).is_some_and(is_brackets)
        }
        (_, Some(word)) if is_flow(word) => {
            let line = line();
            !line.find(word).is_some_and(|at| is_plain_flow(&line[at..]))
        }
        _ => false,
    }
}

/// After `O100`, `N5 O<name>`, `O[#1]`.
///
/// `flow = ["N" {digit} | "/"] "O" ("<" name ">" | "[" ... "]" | {digit | "#"}) rest`
fn behind_label(line: &str) -> Option<&str> {
    let label =
        line.trim_start_matches(['N', '/']).trim_start_matches(|c: char| c.is_ascii_digit()).strip_prefix('O')?;
    let end = match label.bytes().next()? {
        b'<' => label.find('>')? + 1,
        b'[' => lex::expression_end(label.as_bytes())?,
        _ => label.bytes().take_while(|b| b.is_ascii_digit() || *b == b'#').count(),
    };
    Some(&label[end..])
}

/// Expressions in brackets, one after the other, and nothing else.
fn is_brackets(mut rest: &str) -> bool {
    while let Some(end) = lex::expression_end(rest.as_bytes()).filter(|_| rest.starts_with('[')) {
        rest = &rest[end..];
    }
    rest.is_empty()
}

/// `GOTO 10`, `DO1`, `END1`, `WHILE [...] DO1`, `IF [...] GOTO 10`, `IF [...] THEN #1=2`, without blanks.
///
/// `flow = "GOTO" target | ("DO" | "END") number | "IF" condition ("GOTO" target | "THEN" ["#" ...]) | "WHILE" condition "DO" number`,
/// `target = ["#"] number | brackets`
fn is_plain_flow(line: &str) -> bool {
    let number = |rest: &str| !rest.is_empty() && rest.bytes().all(|b| b.is_ascii_digit());
    let target = |rest: &str| {
        let digits = rest.strip_prefix('#').unwrap_or(rest);
        number(digits) || rest.starts_with('[') && is_brackets(rest)
    };
    if let Some(rest) = line.strip_prefix("GOTO") {
        return target(rest);
    }
    if let Some(rest) = line.strip_prefix("DO").or_else(|| line.strip_prefix("END")) {
        return number(rest);
    }
    let (condition, is_while) = match (line.strip_prefix("IF"), line.strip_prefix("WHILE")) {
        (Some(rest), _) => (rest, false),
        (_, Some(rest)) => (rest, true),
        _ => return false,
    };
    let Some(end) = lex::expression_end(condition.as_bytes()).filter(|_| condition.starts_with('[')) else {
        return false;
    };
    let after = &condition[end..];
    match (after.strip_prefix("GOTO"), after.strip_prefix("THEN"), after.strip_prefix("DO")) {
        (Some(rest), ..) if !is_while => target(rest),
        (_, Some(rest), _) if !is_while => rest.is_empty() || rest.starts_with('#'),
        (_, _, Some(rest)) if is_while => number(rest),
        _ => after.is_empty(),
    }
}

/// Words of several letters that steer the order of blocks.
///
/// `flow = ... "GOTO" ... | "IF" | "THEN" | "WHILE" | "DO" | "END"`
pub(super) fn is_flow(keyword: &str) -> bool {
    keyword.contains("GOTO") || matches!(keyword, "IF" | "THEN" | "WHILE" | "DO" | "END")
}
