//! Bytes of a RAPID module to words, numbers and marks.
//!
//! Comments (`!` to the end of the line) stand apart, as they are no part of a statement; the header between two `%%%` is
//! left out. Bytes above 127 count as letters, so that Latin-1 and UTF-8 pass alike. Reference: ABB, RAPID Kernel, lexical
//! elements. Fails at a string or header that is not closed and at a character that RAPID does not have.

use crate::error::Result;
use crate::script::Text;
use crate::script::alike::{Passing, elements};
use crate::script::cursor::{Cursor, begins_word, strip_word};
use crate::script::lex::not_too_long;
pub use crate::script::lex::{Kind, Lexed, Like, Token, Words};
use std::ops::Range;

const PLACEHOLDERS: [&str; 14] =
    ["smt", "exp", "var", "ddn", "rdn", "tdn", "par", "arg", "id", "alt", "lbl", "cse", "eit", "dim"];

/// Tokens and comments of a text; `like`: of lines that are joint motions like the one before them.
///
/// `text = {blank | "!" comment | header | token}`,
/// `header = "%%%" {any} "%%%"`
pub fn lex(text: &Text, like: Like) -> Result<Lexed> {
    not_too_long(text)?;
    let bytes = text.bytes.as_slice();
    let mut tokens = Vec::with_capacity(if like == Like::Read { bytes.len() / 2 } else { 0 });
    let mut comments = Vec::new();
    let mut passing = Passing::default();
    let mut cursor = Cursor::of_text(bytes);
    while let Some(b) = cursor.peek() {
        let start = cursor.at();
        match b {
            b'\n' if like == Like::Passed => cursor.go_to(passing.after(bytes, start + 1, tokens.len(), places)),
            // 0x1A ends files of old controllers
            b' ' | b'\t' | b'\r' | b'\n' | 0x0B | 0x0C | 0x1A => cursor.skip(1),
            b'!' => {
                cursor.line();
                comments.push((start, cursor.at()));
            }
            b'%' if cursor.rest().starts_with(b"%%%") => {
                cursor.skip(3);
                if !cursor.past(b"%%%") {
                    return Err(text.bad(start, "a header `%%%` without an end", "`%%%` after VERSION and LANGUAGE"));
                }
            }
            _ => {
                let kind = token(text, &mut cursor, b)?;
                tokens.push(Token::new(text, kind, start, cursor.at())?);
            }
        }
    }
    Ok(Lexed { tokens, comments, passed: passing.found })
}

/// Passes a token that begins with byte `b`.
///
/// `token = string | number | word | ":=" | placeholder | mark`,
/// `string = '"' {any | '"' '"'} '"'`, on one line
fn token(text: &Text, cursor: &mut Cursor, b: u8) -> Result<Kind> {
    let kind = match b {
        b'"' => {
            let start = cursor.at();
            // a doubled quote is part of it
            while cursor.eat(b'"') {
                cursor.while_is(|b| !matches!(b, b'"' | b'\n'));
                if !cursor.eat(b'"') {
                    return Err(text.bad(start, "a string that is not closed on its line", "`\"`"));
                }
            }
            return Ok(Kind::String);
        }
        _ if cursor.begins_number() => {
            cursor.number();
            return Ok(Kind::Number);
        }
        _ if begins_word(b) => {
            cursor.word();
            return Ok(Kind::Word);
        }
        b':' if cursor.second() == Some(b'=') => Kind::Assign,
        b'<' if placeholder(cursor.rest()).is_some() => Kind::Placeholder,
        b';' | b',' | b':' | b'{' | b'}' | b'[' | b']' | b'(' | b')' | b'\\' | b'.' | b'+' | b'-' | b'*' | b'/'
        | b'<' | b'>' | b'=' | b'%' | b'?' | b'|' => Kind::Mark(b),
        _ => return Err(text.bad(cursor.at(), format!("the character {:?}", char::from(b)), "RAPID text")),
    };
    cursor.skip(match kind {
        Kind::Assign => 2,
        Kind::Placeholder => placeholder(cursor.rest()).unwrap_or(1),
        _ => 1,
    });
    Ok(kind)
}

/// Bytes of the joint values of a line that is one motion to joint values in it: `MoveAbsJ [[1,2,3,4,5,6],[...]],v100,fine,tool0;`.
///
/// `line = "MoveAbsJ" "[[" number {"," number} "]," {any} ";"`
fn places(line: &[u8]) -> Option<Vec<Range<usize>>> {
    let statement = line.trim_ascii();
    let list = strip_word(statement, b"MoveAbsJ")?.trim_ascii_start().strip_prefix(b"[[")?;
    let one = memchr::memchr(b';', statement) == Some(statement.len() - 1);
    let plain = memchr::memchr3(b'!', b'"', b'%', statement).is_none();
    // the list ends with its statement
    let blanks = line.len() - line.trim_ascii_end().len();
    if one && plain { elements(line, line.len() - blanks - list.len()) } else { None }
}

/// Length of a placeholder at the start of `bytes`.
///
/// `placeholder = "<" ("SMT" | "EXP" | "VAR" | "DDN" | ...) ">"`
fn placeholder(bytes: &[u8]) -> Option<usize> {
    let end = bytes.iter().take(6).position(|&b| b == b'>')?;
    let word = std::str::from_utf8(&bytes[1..end]).ok()?.to_ascii_lowercase();
    PLACEHOLDERS.contains(&word.as_str()).then_some(end + 1)
}
