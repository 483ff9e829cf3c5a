//! Bytes of a RAPID module to words, numbers and marks.
//!
//! Comments (`!` to the end of the line) stand apart, as they are no part of a statement; the header between two `%%%` is
//! left out. Bytes above 127 count as letters, so that Latin-1 and UTF-8 pass alike. Reference: ABB, RAPID Kernel, lexical
//! elements. Fails at a string or header that is not closed and at a character that RAPID does not have.

use crate::error::Result;
use crate::script::Text;
use crate::script::alike::{Passing, elements};
pub use crate::script::lex::{Kind, Lexed, Like, Token, Words};
use crate::script::lex::{begins_number, begins_word, line_end, not_too_long, number_end, start, word_end};
use std::ops::Range;

const PLACEHOLDERS: [&str; 14] =
    ["smt", "exp", "var", "ddn", "rdn", "tdn", "par", "arg", "id", "alt", "lbl", "cse", "eit", "dim"];

/// Tokens and comments of a text; `like`: of lines that are joint motions like the one before them.
///
/// `text = {blank | "!" comment | header | string | number | word | ":=" | placeholder | mark}`,
/// `header = "%%%" {any} "%%%"`
pub fn lex(text: &Text, like: Like) -> Result<Lexed> {
    not_too_long(text)?;
    let bytes = text.bytes.as_slice();
    let mut tokens = Vec::with_capacity(if like == Like::Read { bytes.len() / 2 } else { 0 });
    let mut comments = Vec::new();
    let mut passing = Passing::default();
    let mut i = start(bytes);
    while let Some(&b) = bytes.get(i) {
        let start = i;
        let kind = match b {
            b'\n' if like == Like::Passed => {
                i = passing.after(bytes, i + 1, tokens.len(), places);
                continue;
            }
            // 0x1A ends files of old controllers
            b' ' | b'\t' | b'\r' | b'\n' | 0x0B | 0x0C | 0x1A => {
                i += 1;
                continue;
            }
            b'!' => {
                i = line_end(bytes, i);
                comments.push((start, i));
                continue;
            }
            b'%' if bytes[i..].starts_with(b"%%%") => {
                let rest = &bytes[i + 3..];
                let Some(n) = memchr::memmem::find(rest, b"%%%") else {
                    return Err(text.bad(i, "a header `%%%` without an end", "`%%%` after VERSION and LANGUAGE"));
                };
                i += n + 6;
                continue;
            }
            b'"' => {
                i = string_end(text, i)?;
                Kind::String
            }
            _ if begins_number(bytes, i) => {
                i = number_end(bytes, i);
                Kind::Number
            }
            _ if begins_word(b) => {
                i = word_end(bytes, i);
                Kind::Word
            }
            b':' if bytes.get(i + 1) == Some(&b'=') => {
                i += 2;
                Kind::Assign
            }
            b'<' if placeholder(&bytes[i..]).is_some() => {
                i += placeholder(&bytes[i..]).unwrap_or(1);
                Kind::Placeholder
            }
            b';' | b',' | b':' | b'{' | b'}' | b'[' | b']' | b'(' | b')' | b'\\' | b'.' | b'+' | b'-' | b'*' | b'/'
            | b'<' | b'>' | b'=' | b'%' | b'?' | b'|' => {
                i += 1;
                Kind::Mark(b)
            }
            _ => return Err(text.bad(i, format!("the character {:?}", char::from(b)), "RAPID text")),
        };
        tokens.push(Token::new(text, kind, start, i)?);
    }
    Ok(Lexed { tokens, comments, passed: passing.found })
}

/// Bytes of the joint values of a line that is one motion to joint values in it: `MoveAbsJ [[1,2,3,4,5,6],[...]],v100,fine,tool0;`.
///
/// `line = "MoveAbsJ" "[[" number {"," number} "]," {any} ";"`
fn places(line: &[u8]) -> Option<Vec<Range<usize>>> {
    const WORD: &[u8] = b"MoveAbsJ";
    let statement = line.trim_ascii();
    let list = statement.get(..WORD.len()).filter(|w| w.eq_ignore_ascii_case(WORD)).and(statement.get(WORD.len()..))?;
    let list = list.trim_ascii_start().strip_prefix(b"[[")?;
    let one = memchr::memchr(b';', statement) == Some(statement.len() - 1);
    let plain = memchr::memchr3(b'!', b'"', b'%', statement).is_none();
    // the list ends with its statement
    let blanks = line.len() - line.trim_ascii_end().len();
    if one && plain { elements(line, line.len() - blanks - list.len()) } else { None }
}

/// Byte after a string that begins at `start`; a doubled quote is part of it.
///
/// `string = '"' {any | '"' '"'} '"'`, on one line
fn string_end(text: &Text, start: usize) -> Result<usize> {
    let bytes = &text.bytes;
    let mut i = start + 1;
    loop {
        match bytes.get(i) {
            Some(b'"') if bytes.get(i + 1) == Some(&b'"') => i += 2,
            Some(b'"') => return Ok(i + 1),
            Some(b'\n') | None => return Err(text.bad(start, "a string that is not closed on its line", "`\"`")),
            Some(_) => i += 1,
        }
    }
}

/// Length of a placeholder at the start of `bytes`.
///
/// `placeholder = "<" ("SMT" | "EXP" | "VAR" | "DDN" | ...) ">"`
fn placeholder(bytes: &[u8]) -> Option<usize> {
    let end = bytes.iter().take(6).position(|&b| b == b'>')?;
    let word = std::str::from_utf8(&bytes[1..end]).ok()?.to_ascii_lowercase();
    PLACEHOLDERS.contains(&word.as_str()).then_some(end + 1)
}
