//! Bytes of a URScript to words, numbers and marks, and the ends of its lines.
//!
//! Comments (`#`) stand apart; a line break inside brackets ends nothing; lines that begin with `$` are marks of the editor.
//! Reference: Universal Robots, The URScript Programming Language. Fails at a string or bracket that is not closed, and
//! at the marks of a template (`{{name}}`, `{% if %}`).

use crate::error::Result;
use crate::script::Text;
use crate::script::alike::{Passing, elements};
pub use crate::script::lex::{Kind, Lexed, Like, Token, Words};
use crate::script::lex::{begins_number, begins_word, line_end, not_too_long, number_end, start, word_end};
use std::ops::Range;

/// Tokens and comments of a text; `like`: of lines that are joint motions like the one before them.
///
/// `text = {blank | "#" comment | "$" mark_of_the_editor | string | number | word | compare | mark | newline}`
pub fn lex(text: &Text, like: Like) -> Result<Lexed> {
    not_too_long(text)?;
    let bytes = text.bytes.as_slice();
    let at = start(bytes);
    let tokens = Vec::with_capacity(if like == Like::Read { bytes.len() / 3 } else { 0 });
    let mut lexer = Lexer { text, bytes, at, tokens, comments: Vec::new(), open: Vec::new() };
    let mut passing = Passing::default();
    while let Some(&b) = bytes.get(lexer.at) {
        let mut start = lexer.at;
        if like == Like::Passed && lexer.open.is_empty() && start.checked_sub(1).is_some_and(|k| bytes[k] == b'\n') {
            let next = passing.after(bytes, start, lexer.tokens.len(), places);
            if next > start {
                // at the start of another line, or the end
                lexer.at = next;
                continue;
            }
            start = next;
        }
        if let Some(kind) = lexer.token(b)? {
            lexer.tokens.push(Token::new(text, kind, start, lexer.at)?);
        }
    }
    if let Some(at) = lexer.open.pop() {
        let found = format!("`{}` that is not closed", char::from(bytes[at]));
        return Err(text.bad(at, found, "its closing bracket"));
    }
    lexer.tokens.push(Token::new(text, Kind::Line, bytes.len(), bytes.len())?);
    Ok(Lexed { tokens: lexer.tokens, comments: lexer.comments, passed: passing.found })
}

/// Bytes of the joint values of a line that is one motion to joint values in it: `movej([1,2,3,4,5,6], a=1.4, v=1.05)`.
///
/// `line = ("movej" | "servoj") "([" number {"," number} "]" {any} ")"`
fn places(line: &[u8]) -> Option<Vec<Range<usize>>> {
    let statement = line.trim_ascii();
    let list = [b"movej([".as_slice(), b"servoj(["].iter().find_map(|word| statement.strip_prefix(*word))?;
    let plain = memchr::memchr3(b'#', b'"', b'\'', statement).is_none() && memchr::memchr(b'{', statement).is_none();
    // a call that goes on in the next line is no statement
    let count = |mark: u8| memchr::memchr_iter(mark, statement).count();
    let whole = statement.ends_with(b")") && count(b'(') == count(b')') && count(b'[') == count(b']');
    // the list ends with its statement
    let blanks = line.len() - line.trim_ascii_end().len();
    if plain && whole { elements(line, line.len() - blanks - list.len()) } else { None }
}

/// A text that is read up to a byte.
struct Lexer<'a> {
    text: &'a Text,
    bytes: &'a [u8],
    at: usize,
    tokens: Vec<Token>,
    comments: Vec<(usize, usize)>,
    /// Brackets that are open.
    open: Vec<usize>,
}

impl Lexer<'_> {
    /// Passes what begins with byte `b`: the kind of its token; `None`: it makes none.
    ///
    /// `token = blank | newline | "#" comment | "$" ... | string | number | word | compare | mark`,
    /// `compare = ("=" | "!" | "<" | ">") "="`
    fn token(&mut self, b: u8) -> Result<Option<Kind>> {
        let (bytes, at) = (self.bytes, self.at);
        let (kind, end) = match b {
            b' ' | b'\t' | b'\r' | 0x0B | 0x0C => (None, at + 1),
            // a line break within brackets ends nothing
            b'\n' => (self.open.is_empty().then_some(Kind::Line), at + 1),
            b'#' => {
                let end = line_end(bytes, at);
                self.comments.push((at, end));
                (None, end)
            }
            b'$' if self.tokens.last().is_none_or(|t| t.kind == Kind::Line) => (None, line_end(bytes, at)),
            b'"' | b'\'' => (Some(Kind::String), self.string_end(b)?),
            _ if begins_number(bytes, at) => (Some(Kind::Number), number_end(bytes, at)),
            _ if begins_word(b) => (Some(Kind::Word), word_end(bytes, at)),
            b'=' | b'!' | b'<' | b'>' if bytes.get(at + 1) == Some(&b'=') => (Some(Kind::Compare), at + 2),
            // what a template holds is not known before it is filled in, nor which of its branches stay
            b'{' if matches!(bytes.get(at + 1), Some(b'{' | b'%' | b'#')) => {
                return Err(self.text.bad(at, "a mark of a template", "a script with its templates filled in"));
            }
            b'(' | b'[' | b'{' => {
                self.open.push(at);
                (Some(Kind::Mark(b)), at + 1)
            }
            b')' | b']' | b'}' => {
                if self.open.pop().is_none() {
                    return Err(self.text.bad(at, format!("`{}`", char::from(b)), "the bracket that it closes"));
                }
                (Some(Kind::Mark(b)), at + 1)
            }
            0x21..=0x7E => (Some(Kind::Mark(b)), at + 1),
            _ => return Err(self.text.bad(at, format!("the character {:?}", char::from(b)), "URScript text")),
        };
        self.at = end;
        Ok(kind)
    }

    /// After the string whose quote `b` stands here.
    ///
    /// `string = '"' {any} '"' | "'" {any} "'"`, on one line
    fn string_end(&self, b: u8) -> Result<usize> {
        let (bytes, at) = (self.bytes, self.at);
        match memchr::memchr(b, &bytes[at + 1..line_end(bytes, at)]) {
            Some(len) => Ok(at + len + 2),
            None => Err(self.text.bad(at, "a string that is not closed on its line", format!("`{}`", char::from(b)))),
        }
    }
}
