//! Words, numbers and marks of languages with statements (RAPID, URScript): the tokens, and the pieces of text that look alike
//! in all of them. Bytes above 127 count as letters, so that Latin-1 and UTF-8 pass alike.

use super::Text;
use crate::error::Result;
use std::collections::HashMap;
use std::ops::Range;

/// What a token is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A name or a keyword.
    Word,
    /// Without sign.
    Number,
    /// Quotes included.
    String,
    /// `:=`.
    Assign,
    /// `==`, `!=`, `<=`, `>=`.
    Compare,
    /// `<SMT>`, a place that the programmer has not filled yet.
    Placeholder,
    /// End of a statement that ends with its line.
    Line,
    /// One byte.
    Mark(u8),
}

/// A token and its bytes. Small, as there are several for each number of a program.
#[derive(Debug, Clone, Copy)]
pub struct Token {
    /// What it is.
    pub kind: Kind,
    from: u32,
    to: u32,
}

impl Token {
    /// Of a text of at most [`LONGEST`] bytes.
    pub fn new(kind: Kind, start: usize, end: usize) -> Self {
        Self { kind, from: start as u32, to: end as u32 }
    }

    /// First byte.
    pub fn start(&self) -> usize {
        self.from as usize
    }

    /// Byte after it.
    pub fn end(&self) -> usize {
        self.to as usize
    }
}

/// Bytes of the longest text that is read.
pub const LONGEST: usize = u32::MAX as usize;

/// Refuses a text whose bytes no token could tell.
///
/// # Errors
/// Bad input.
pub fn not_too_long(text: &Text) -> Result<()> {
    if text.bytes.len() <= LONGEST {
        return Ok(());
    }
    Err(text.bad(0, format!("a program of {} bytes", text.bytes.len()), format!("at most {LONGEST}")))
}

/// A word for each token; empty for those that are none. Each different word stands in memory once.
#[derive(Debug, Default)]
pub struct Words {
    of_token: Vec<u32>,
    /// The first is the empty one.
    different: Vec<String>,
}

impl Words {
    /// The words of tokens; `word` gives one as it is kept.
    pub fn of(text: &Text, tokens: &[Token], word: impl Fn(&[u8]) -> String) -> Self {
        let mut known: HashMap<&[u8], u32> = HashMap::new();
        let mut all = Self { of_token: Vec::with_capacity(tokens.len()), different: vec![String::new()] };
        for t in tokens {
            let mut id = 0;
            if t.kind == Kind::Word {
                let bytes = text.slice(t.start()..t.end());
                id = *known.entry(bytes).or_insert_with(|| {
                    all.different.push(word(bytes));
                    all.different.len() as u32 - 1
                });
            }
            all.of_token.push(id);
        }
        all
    }

    /// The word of a token; empty where there is none.
    pub fn at(&self, token: usize) -> &str {
        self.of_token.get(token).and_then(|id| self.different.get(*id as usize)).map_or("", String::as_str)
    }

    /// The words of some tokens.
    pub fn within(&self, tokens: Range<usize>) -> impl Iterator<Item = &str> {
        tokens.map(|k| self.at(k))
    }

    /// Every word, in no order of the text; some may be the same.
    pub fn different(&self) -> impl Iterator<Item = &str> {
        self.different.iter().map(String::as_str)
    }
}

/// Tokens, and the bytes of every comment, in order.
#[derive(Debug, Default)]
pub struct Lexed {
    /// In the order of the text.
    pub tokens: Vec<Token>,
    /// First byte of each comment and the byte after it.
    pub comments: Vec<(usize, usize)>,
}

/// Behind a byte order mark.
pub fn start(bytes: &[u8]) -> usize {
    if bytes.starts_with(b"\xEF\xBB\xBF") { 3 } else { 0 }
}

/// The end of the line on which `at` stands, its line feed left out.
pub fn line_end(bytes: &[u8], at: usize) -> usize {
    memchr::memchr(b'\n', &bytes[at..]).map_or(bytes.len(), |n| at + n)
}

/// A byte that may begin a word.
pub fn begins_word(b: u8) -> bool {
    b.is_ascii_alphabetic() || b == b'_' || b >= 0x80
}

/// A number begins at this byte: a digit, or a point before one.
pub fn begins_number(bytes: &[u8], at: usize) -> bool {
    let digit = |k: usize| bytes.get(k).is_some_and(u8::is_ascii_digit);
    digit(at) || bytes.get(at) == Some(&b'.') && digit(at + 1)
}

/// Behind the word that begins at `at`.
pub fn word_end(bytes: &[u8], at: usize) -> usize {
    at + bytes[at..].iter().take_while(|b| begins_word(**b) || b.is_ascii_digit()).count()
}

/// Behind the number that begins at `at`: `12`, `1.5E-3`, `.5`, `0x1F`.
pub fn number_end(bytes: &[u8], at: usize) -> usize {
    let digits = |from: usize| bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
    if bytes[at] == b'0' && bytes.get(at + 1).is_some_and(|b| matches!(b | 0x20, b'x' | b'b' | b'o')) {
        return at + bytes[at..].iter().take_while(|b| b.is_ascii_alphanumeric()).count();
    }
    let mut i = at + digits(at);
    if bytes.get(i) == Some(&b'.') {
        i += 1 + digits(i + 1);
    }
    if bytes.get(i).is_some_and(|b| matches!(b, b'e' | b'E')) {
        let sign = usize::from(bytes.get(i + 1).is_some_and(|b| matches!(b, b'+' | b'-')));
        let n = bytes.get(i + 1 + sign..).map_or(0, |_| digits(i + 1 + sign));
        if n > 0 {
            i += 1 + sign + n;
        }
    }
    i
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_end_where_they_end() {
        for (text, length) in
            [("12,", 2), ("1.5E-3]", 6), (".5 ", 2), ("5.)", 2), ("0x1F;", 4), ("1e", 1), ("1e+", 1), ("7e3x", 3)]
        {
            assert!(begins_number(text.as_bytes(), 0), "{text}");
            assert_eq!(number_end(text.as_bytes(), 0), length, "{text}");
        }
        assert!(!begins_number(b".x", 0) && !begins_number(b"-1", 0) && !begins_number(b"", 0));
    }

    #[test]
    fn bytes_of_any_encoding_are_letters() {
        assert_eq!(word_end(b"caf\xe9_1 x", 0), 6);
        assert_eq!((start(b"\xEF\xBB\xBFMODULE"), start(b"MODULE")), (3, 0));
        assert_eq!((line_end(b"ab\ncd", 1), line_end(b"ab\ncd", 3)), (2, 5));
    }
}
