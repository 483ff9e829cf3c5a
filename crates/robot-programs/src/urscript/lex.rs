//! Bytes of a URScript to words, numbers and marks, and the ends of its lines.
//!
//! Comments (`#`) stand apart; a line break inside brackets ends nothing; lines that begin with `$` are marks of the editor.
//! Reference: Universal Robots, The URScript Programming Language. Fails at a string or bracket that is not closed, and
//! at the marks of a template (`{{name}}`, `{% if %}`).

use crate::error::Result;
use crate::script::Text;
pub use crate::script::lex::{Kind, Lexed, Token, Words};
use crate::script::lex::{begins_number, begins_word, line_end, not_too_long, number_end, start, word_end};

pub fn lex(text: &Text) -> Result<Lexed> {
    not_too_long(text)?;
    let bytes = text.bytes.as_slice();
    let mut tokens: Vec<Token> = Vec::with_capacity(bytes.len() / 3);
    let mut comments = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    let mut i = start(bytes);
    while let Some(&b) = bytes.get(i) {
        let start = i;
        let kind = match b {
            b' ' | b'\t' | b'\r' | 0x0B | 0x0C => {
                i += 1;
                continue;
            }
            b'\n' => {
                i += 1;
                if !open.is_empty() {
                    continue;
                }
                Kind::Line
            }
            b'#' => {
                i = line_end(bytes, i);
                comments.push((start, i));
                continue;
            }
            b'$' if tokens.last().is_none_or(|t| t.kind == Kind::Line) => {
                i = line_end(bytes, i);
                continue;
            }
            b'"' | b'\'' => {
                let end = bytes[i + 1..line_end(bytes, i)].iter().position(|&c| c == b);
                let Some(end) = end else {
                    return Err(text.bad(i, "a string that is not closed on its line", format!("`{}`", char::from(b))));
                };
                i += end + 2;
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
            b'=' | b'!' | b'<' | b'>' if bytes.get(i + 1) == Some(&b'=') => {
                i += 2;
                Kind::Compare
            }
            // what a template holds is not known before it is filled in, nor which of its branches stay
            b'{' if matches!(bytes.get(i + 1), Some(b'{' | b'%' | b'#')) => {
                return Err(text.bad(i, "a mark of a template", "a script with its templates filled in"));
            }
            b'(' | b'[' | b'{' => {
                open.push(i);
                i += 1;
                Kind::Mark(b)
            }
            b')' | b']' | b'}' => {
                if open.pop().is_none() {
                    return Err(text.bad(i, format!("`{}`", char::from(b)), "the bracket that it closes"));
                }
                i += 1;
                Kind::Mark(b)
            }
            0x21..=0x7E => {
                i += 1;
                Kind::Mark(b)
            }
            _ => return Err(text.bad(i, format!("the character {:?}", char::from(b)), "URScript text")),
        };
        tokens.push(Token::new(text, kind, start, i)?);
    }
    if let Some(at) = open.pop() {
        let found = format!("`{}` that is not closed", char::from(bytes[at]));
        return Err(text.bad(at, found, "its closing bracket"));
    }
    tokens.push(Token::new(text, Kind::Line, bytes.len(), bytes.len())?);
    Ok(Lexed { tokens, comments })
}
