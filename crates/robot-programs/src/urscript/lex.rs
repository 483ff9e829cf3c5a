//! Bytes of a URScript to words, numbers and marks, and the ends of its lines.
//!
//! Comments (`#`) stand apart; a line break inside brackets ends nothing; lines that begin with `$` are marks of the editor.
//! Reference: Universal Robots, The URScript Programming Language. Fails at a string or bracket that is not closed, and
//! at the marks of a template (`{{name}}`, `{% if %}`).

use crate::error::Result;
use crate::script::Text;
use crate::script::alike::{Passing, elements};
use crate::script::cursor::{Cursor, begins_word};
use crate::script::lex::not_too_long;
pub use crate::script::lex::{Kind, Lexed, Like, Token, Words};
use std::ops::Range;

/// Tokens and comments of a text; `like`: of lines that are joint motions like the one before them.
///
/// `text = {blank | "#" comment | "$" mark_of_the_editor | string | number | word | compare | mark | newline}`
pub fn lex(text: &Text, like: Like) -> Result<Lexed> {
    not_too_long(text)?;
    let bytes = text.bytes.as_slice();
    let tokens = Vec::with_capacity(if like == Like::Read { bytes.len() / 3 } else { 0 });
    let mut lexer = Lexer { text, cursor: Cursor::of_text(bytes), tokens, comments: Vec::new(), open: Vec::new() };
    let mut passing = Passing::default();
    while let Some(b) = lexer.cursor.peek() {
        let start = lexer.cursor.at();
        if like == Like::Passed && lexer.open.is_empty() && start.checked_sub(1).is_some_and(|k| bytes[k] == b'\n') {
            let next = passing.after(bytes, start, lexer.tokens.len(), places);
            if next > start {
                // at the start of another line, or the end
                lexer.cursor.go_to(next);
                continue;
            }
        }
        if let Some(kind) = lexer.token(b)? {
            lexer.tokens.push(Token::new(text, kind, start, lexer.cursor.at())?);
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
    cursor: Cursor<'a>,
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
        let at = self.cursor.at();
        let kind = match b {
            b' ' | b'\t' | b'\r' | 0x0B | 0x0C => None,
            // a line break within brackets ends nothing
            b'\n' => self.open.is_empty().then_some(Kind::Line),
            b'#' => {
                self.cursor.line();
                self.comments.push((at, self.cursor.at()));
                return Ok(None);
            }
            b'$' if self.tokens.last().is_none_or(|t| t.kind == Kind::Line) => {
                self.cursor.line();
                return Ok(None);
            }
            b'"' | b'\'' => return self.string(b).map(Some),
            _ if self.cursor.begins_number() => {
                self.cursor.number();
                return Ok(Some(Kind::Number));
            }
            _ if begins_word(b) => {
                self.cursor.word();
                return Ok(Some(Kind::Word));
            }
            b'=' | b'!' | b'<' | b'>' if self.cursor.second() == Some(b'=') => {
                self.cursor.skip(2);
                return Ok(Some(Kind::Compare));
            }
            // what a template holds is not known before it is filled in, nor which of its branches stay
            b'{' if matches!(self.cursor.second(), Some(b'{' | b'%' | b'#')) => {
                return Err(self.text.bad(at, "a mark of a template", "a script with its templates filled in"));
            }
            b'(' | b'[' | b'{' => {
                self.open.push(at);
                Some(Kind::Mark(b))
            }
            b')' | b']' | b'}' => {
                if self.open.pop().is_none() {
                    return Err(self.text.bad(at, format!("`{}`", char::from(b)), "the bracket that it closes"));
                }
                Some(Kind::Mark(b))
            }
            0x21..=0x7E => Some(Kind::Mark(b)),
            _ => return Err(self.text.bad(at, format!("the character {:?}", char::from(b)), "URScript text")),
        };
        self.cursor.skip(1);
        Ok(kind)
    }

    /// Passes the string whose quote `b` stands here.
    ///
    /// `string = '"' {any} '"' | "'" {any} "'"`, on one line
    fn string(&mut self, b: u8) -> Result<Kind> {
        let at = self.cursor.at();
        self.cursor.skip(1);
        self.cursor.while_is(|c| c != b && c != b'\n');
        if !self.cursor.eat(b) {
            let expected = format!("`{}`", char::from(b));
            return Err(self.text.bad(at, "a string that is not closed on its line", expected));
        }
        Ok(Kind::String)
    }
}
