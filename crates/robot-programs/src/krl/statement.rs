//! The parts of a statement: what begins a routine, the type and the names of a declaration, the sign of an assignment.

use super::lex::{Kind, Token, upper};
use crate::script::Text;

/// The statements of a line: what stands after the `DO` of `TRIGGER` and `INTERRUPT` is a statement itself.
///
/// `line = statement ["DO" statement]`
pub(super) fn statements<'a>(text: &Text, line: &'a [Token]) -> Vec<&'a [Token]> {
    let is_do = |t: &Token| t.kind == Kind::Word && text.slice(t.span()).eq_ignore_ascii_case(b"DO");
    let at = line.iter().enumerate().skip(1).position(|(i, t)| is_do(t) && !line[i - 1].is(b'.')).map(|n| n + 1);
    match at {
        Some(at) => vec![&line[..at], &line[at + 1..]],
        None => vec![line],
    }
}

/// Whether a line begins a routine.
///
/// `routine = ["GLOBAL"] ("DEF" | "DEFFCT") ...`
pub(super) fn is_routine(first: &str, second: &str) -> bool {
    matches!(first, "DEF" | "DEFFCT") || first == "GLOBAL" && matches!(second, "DEF" | "DEFFCT")
}

/// The name of the routine that a line begins, in upper case; empty: it has none.
///
/// `routine = ["GLOBAL"] ("DEF" | "DEFFCT" type) name "(" ...`
pub(super) fn routine_name(text: &Text, line: &[Token]) -> String {
    let open = line.iter().position(|t| t.is(b'('));
    open.and_then(|o| o.checked_sub(1)).map(|n| upper(text, &line[n])).unwrap_or_default()
}

/// Whether a line that begins with this word may begin a routine or declare something.
pub(super) fn may_declare(word: &[u8]) -> bool {
    let words = ["DEF", "DEFFCT", "GLOBAL", "DECL", "CONST", "E6AXIS", "AXIS", "E6POS", "POS", "FRAME", "FDAT"];
    words.iter().any(|w| word.eq_ignore_ascii_case(w.as_bytes()))
}

/// First letters of the words with which such a line may begin.
pub(super) const DECLARING: &[u8] = b"DGCEAPF";

/// The token of the type of a declaration of points or frame data.
///
/// `declaration = {"DECL" | "GLOBAL" | "CONST"} type item {"," item}`,
/// `type = "E6AXIS" | "AXIS" | "E6POS" | "POS" | "FRAME" | "FDAT"`
pub(super) fn declaration(text: &Text, line: &[Token]) -> Option<usize> {
    let mut at = 0;
    while let Some(t) = line.get(at).filter(|t| t.kind == Kind::Word) {
        let word = text.slice(t.span());
        let is = |names: &[&str]| names.iter().any(|n| word.eq_ignore_ascii_case(n.as_bytes()));
        if is(&["DECL", "GLOBAL", "CONST"]) {
            at += 1;
        } else if is(&["E6AXIS", "AXIS", "E6POS", "POS", "FRAME", "FDAT"]) {
            return line.get(at + 1).is_some_and(|t| t.kind == Kind::Word).then_some(at);
        } else {
            return None;
        }
    }
    None
}

/// One name of a declaration: `XP1={A1 -5,...}`, `XP2`, `P[4]`.
pub(super) struct Item<'a> {
    pub word: &'a Token,
    pub array: bool,
    /// The token after its `=`.
    pub value: Option<usize>,
    /// The token after what has been read: the value, or what follows the name.
    pub next: usize,
}

/// The next name of a declaration from token `at` on; its value is not read.
///
/// `item = name ["[" ... "]"] ["=" value]`
pub(super) fn item(line: &[Token], at: usize) -> Option<Item<'_>> {
    let (at, word) = line.iter().enumerate().skip(at).find(|(_, t)| t.kind == Kind::Word)?;
    let array = line.get(at + 1).is_some_and(|t| t.is(b'['));
    let next = position(line, at + 1, |t| t.is(b',') || t.is(b'='));
    let value = line.get(next).filter(|t| t.is(b'=')).map(|_| next + 1);
    Some(Item { word, array, value, next: value.unwrap_or(next) })
}

/// The first `,` from token `at` on, else the end of the line.
pub(super) fn comma(line: &[Token], at: usize) -> usize {
    position(line, at, |t| t.is(b','))
}

fn position(line: &[Token], at: usize, is: impl Fn(&Token) -> bool) -> usize {
    line.iter().enumerate().skip(at).find(|(_, t)| is(t)).map_or(line.len(), |(i, _)| i)
}

/// The `=` of an assignment; not `==`, `<=`, `>=`, and not within brackets.
///
/// `assignment = name {"[" ... "]" | "." field} "=" value`
pub(super) fn assignment(line: &[Token]) -> Option<usize> {
    if line.first()?.kind != Kind::Word {
        return None;
    }
    let mut depth = 0_usize;
    for (i, t) in line.iter().enumerate().skip(1) {
        match t.kind {
            Kind::Mark(b'[') => depth += 1,
            Kind::Mark(b']') => depth = depth.saturating_sub(1),
            Kind::Mark(b'=') if depth == 0 => return (!line.get(i + 1).is_some_and(|t| t.is(b'='))).then_some(i),
            Kind::Mark(b'.') => {}
            Kind::Word if line[i - 1].is(b'.') => {}
            _ if depth > 0 => {}
            _ => return None,
        }
    }
    None
}

/// A place that GOTO names.
///
/// `label = name ":"`
pub(super) fn is_label(line: &[Token]) -> bool {
    matches!(line, [name, colon] if name.kind == Kind::Word && colon.is(b':'))
}
