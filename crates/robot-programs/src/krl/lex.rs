//! Tokens of a line. KRL has one statement a line; `;` begins a comment; words have no case.

use crate::script::Text;
use crate::script::cursor::{Cursor, integer};
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
    /// The byte of a mark.
    pub fn mark(&self) -> Option<u8> {
        if let Kind::Mark(b) = self.kind { Some(b) } else { None }
    }

    pub fn span(&self) -> Range<usize> {
        self.start..self.end
    }

    pub fn is(&self, mark: u8) -> bool {
        self.kind == Kind::Mark(mark)
    }
}

/// `word = word_byte {word_byte}`
pub(super) fn word_byte(b: u8) -> bool {
    b.is_ascii_alphanumeric() || b == b'_' || b == b'$' || !b.is_ascii()
}

/// `blank = " " | tab | ... | the byte 0x1A`, with which files of old controllers end
fn is_blank(b: u8) -> bool {
    b.is_ascii_whitespace() || b == 0x1a
}

/// The word with which line `k` begins; empty: it begins with none.
pub(super) fn first_word(text: &Text, k: usize) -> &[u8] {
    let mut cursor = Cursor::of_line(text, k);
    cursor.while_is(is_blank);
    cursor.while_is(word_byte)
}

/// Whether the word with which line `k` begins has one of these first letters, in upper case; `$` counts as one.
pub(super) fn begins_with(text: &Text, k: usize, letters: &[u8]) -> bool {
    text.head(k).is_some_and(|head| letters.contains(&head))
}

/// The tokens of line `k` into `out`.
///
/// `line = {blank | comment | quoted | number | word | mark}`,
/// `comment = ";" {any}`,
/// `quoted = '"' {any} '"' | "'" {any} "'"`
pub(super) fn tokens(text: &Text, k: usize, out: &mut Vec<Token>) {
    out.clear();
    let start = text.line_span(k).start;
    let mut cursor = Cursor::of_line(text, k);
    cursor.while_is(is_blank);
    while let Some(b) = cursor.peek() {
        let from = cursor.at();
        let kind = match b {
            b';' => {
                cursor.end();
                Kind::Comment
            }
            b'"' | b'\'' => {
                cursor.skip(1);
                if !cursor.past(&[b]) {
                    cursor.end();
                }
                Kind::Quoted
            }
            _ if cursor.begins_number() => {
                cursor.decimal();
                Kind::Number
            }
            _ if word_byte(b) => {
                cursor.while_is(word_byte);
                Kind::Word
            }
            _ => {
                cursor.skip(1);
                Kind::Mark(b)
            }
        };
        out.push(Token { kind, start: start + from, end: start + cursor.at() });
        cursor.while_is(is_blank);
    }
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
    Some((integer(text.slice(n.span()))?, at + 3))
}
