//! Tokens of a line. KRL has one statement a line; `;` begins a comment; words have no case.

use crate::script::Text;
use crate::script::lex::upper_of;
use std::borrow::Cow;
use std::ops::Range;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Word,
    /// Without sign.
    Number,
    /// `"text"` or `'HFF'`.
    Quoted,
    Mark(u8),
    /// From `;` to the end of the line.
    Comment,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Token {
    pub kind: Kind,
    pub start: usize,
    pub end: usize,
}

impl Token {
    pub fn span(&self) -> Range<usize> {
        self.start..self.end
    }

    pub fn is(&self, mark: u8) -> bool {
        self.kind == Kind::Mark(mark)
    }
}

/// `word = word_byte {word_byte}`
fn word_byte(b: u8) -> bool {
    b.is_ascii_alphanumeric() || b == b'_' || b == b'$' || !b.is_ascii()
}

/// The word with which line `k` begins; empty: it begins with none.
pub(super) fn first_word(text: &Text, k: usize) -> &[u8] {
    let bytes = text.line(k);
    let bytes = if k == 0 { bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes) } else { bytes };
    let start = bytes.iter().take_while(|b| b.is_ascii_whitespace() || **b == 0x1a).count();
    let bytes = bytes.get(start..).unwrap_or_default();
    let len = bytes.iter().take_while(|b| word_byte(**b)).count();
    bytes.get(..len).unwrap_or_default()
}

/// The tokens of line `k` into `out`.
///
/// `line = {blank | comment | quoted | number | word | mark}`,
/// `comment = ";" {any}`,
/// `quoted = '"' {any} '"' | "'" {any} "'"`
pub(super) fn tokens(text: &Text, k: usize, out: &mut Vec<Token>) {
    out.clear();
    let start = text.line_span(k).start;
    let bytes = text.line(k);
    let bytes_from = if k == 0 && bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
    let mut at = bytes_from;
    while at < bytes.len() {
        let b = bytes[at];
        let rest = &bytes[at..];
        let (kind, len) = if b.is_ascii_whitespace() || b == 0x1a {
            at += 1;
            continue;
        } else if b == b';' {
            (Kind::Comment, rest.len())
        } else if b == b'"' || b == b'\'' {
            (Kind::Quoted, memchr::memchr(b, &rest[1..]).map_or(rest.len(), |n| n + 2))
        } else if b.is_ascii_digit() || (b == b'.' && rest.get(1).is_some_and(u8::is_ascii_digit)) {
            (Kind::Number, number_len(rest))
        } else if word_byte(b) {
            (Kind::Word, rest.iter().take_while(|b| word_byte(**b)).count())
        } else {
            (Kind::Mark(b), 1)
        };
        out.push(Token { kind, start: start + at, end: start + at + len });
        at += len;
    }
}

/// Length of a number: digits, point, digits, exponent.
///
/// `number = {digit} ["." {digit}] [("E" | "e") ["+" | "-"] digit {digit}]`
fn number_len(bytes: &[u8]) -> usize {
    let digits = |from: usize| bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
    let mut len = digits(0);
    if bytes.get(len) == Some(&b'.') {
        len += 1 + digits(len + 1);
    }
    if matches!(bytes.get(len), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(len + 1), Some(b'+' | b'-')));
        let exponent = digits(len + 1 + sign);
        if exponent > 0 {
            len += 1 + sign + exponent;
        }
    }
    len
}

/// A word in upper case.
pub(super) fn upper(text: &Text, t: &Token) -> String {
    in_upper(text, t).into_owned()
}

/// The same without a copy, where it is in upper case already.
pub(super) fn in_upper<'a>(text: &'a Text, t: &Token) -> Cow<'a, str> {
    upper_of(text.slice(t.span()))
}

/// `[2]` at token `at`: the index, and the token after it.
///
/// `index = "[" digit {digit} "]"`
pub(super) fn index(text: &Text, line: &[Token], at: usize) -> Option<(u32, usize)> {
    let [open, n, close] = line.get(at..at + 3)? else { return None };
    if !(open.is(b'[') && close.is(b']') && n.kind == Kind::Number) {
        return None;
    }
    Some((std::str::from_utf8(text.slice(n.span())).ok()?.parse().ok()?, at + 3))
}
