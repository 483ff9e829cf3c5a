//! Bytes that are read from the front: the cursor of all lexers, and the pieces of text that look alike in every language.
//!
//! No method leaves the bytes: what would go beyond their end stops there. Bytes above 127 count as letters, so that Latin-1 and UTF-8
//! pass alike.

use super::text::Text;
use std::str::FromStr;

/// What some editors put before UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// A text without its byte order mark.
pub fn unmarked(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes)
}

/// What stands after a word with which the bytes begin, in whatever case; `None`: they begin with another.
pub fn strip_word<'a>(bytes: &'a [u8], word: &[u8]) -> Option<&'a [u8]> {
    let (head, rest) = bytes.split_at_checked(word.len())?;
    head.eq_ignore_ascii_case(word).then_some(rest)
}

/// The end of the line on which `at` stands, its line feed left out.
pub fn line_end(bytes: &[u8], at: usize) -> usize {
    memchr::memchr(b'\n', &bytes[at..]).map_or(bytes.len(), |n| at + n)
}

/// A byte that may begin a word.
pub fn begins_word(b: u8) -> bool {
    b.is_ascii_alphabetic() || b == b'_' || b >= 0x80
}

/// A whole number that is all of the bytes: digits and nothing else.
pub fn integer<N: FromStr>(digits: &[u8]) -> Option<N> {
    std::str::from_utf8(digits).ok().filter(|d| d.bytes().all(|b| b.is_ascii_digit()))?.parse().ok()
}

/// Bytes and how far they are read.
#[derive(Debug, Clone)]
pub struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    /// At the first byte.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// At the first byte of a text, after its byte order mark.
    pub fn of_text(bytes: &'a [u8]) -> Self {
        Self { bytes, at: bytes.len() - unmarked(bytes).len() }
    }

    /// At the first byte of line `k` (from 0) of a text, its ending left out.
    pub fn of_line(text: &'a Text, k: usize) -> Self {
        if k == 0 { Self::of_text(text.line(k)) } else { Self::new(text.line(k)) }
    }

    /// The byte that comes next.
    pub fn at(&self) -> usize {
        self.at
    }

    /// Goes on at a byte.
    pub fn go_to(&mut self, at: usize) {
        self.at = at.min(self.bytes.len());
    }

    /// Passes over so many bytes.
    pub fn skip(&mut self, count: usize) {
        self.go_to(self.at + count);
    }

    /// Passes all.
    pub fn end(&mut self) {
        self.at = self.bytes.len();
    }

    /// What is not read yet.
    pub fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    /// What is read since byte `from`.
    pub fn since(&self, from: usize) -> &'a [u8] {
        self.bytes.get(from..self.at).unwrap_or_default()
    }

    /// The next byte.
    pub fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    /// The byte after the next.
    pub fn second(&self) -> Option<u8> {
        self.bytes.get(self.at + 1).copied()
    }

    /// Passes the next byte where it is this one.
    pub fn eat(&mut self, byte: u8) -> bool {
        let is = self.peek() == Some(byte);
        self.at += usize::from(is);
        is
    }

    /// Goes after the next place where a mark of one or more bytes stands; stays where there is none.
    pub fn past(&mut self, mark: &[u8]) -> bool {
        let found = match mark {
            [byte] => memchr::memchr(*byte, self.rest()),
            _ => memchr::memmem::find(self.rest(), mark),
        };
        self.at += found.map_or(0, |n| n + mark.len());
        found.is_some()
    }

    /// Passes all bytes that are of a kind.
    pub fn while_is(&mut self, mut kind: impl FnMut(u8) -> bool) -> &'a [u8] {
        let from = self.at;
        self.at += self.rest().iter().take_while(|b| kind(**b)).count();
        self.since(from)
    }

    /// Passes white space.
    pub fn blanks(&mut self) {
        self.while_is(|b| b.is_ascii_whitespace());
    }

    /// Passes digits.
    pub fn digits(&mut self) -> &'a [u8] {
        self.while_is(|b| b.is_ascii_digit())
    }

    /// Passes letters of the English alphabet.
    pub fn letters(&mut self) -> &'a [u8] {
        self.while_is(|b| b.is_ascii_alphabetic())
    }

    /// Passes the rest of the line, its line feed left out.
    pub fn line(&mut self) {
        self.at = line_end(self.bytes, self.at);
    }

    /// Passes a word: letters, `_` and digits.
    pub fn word(&mut self) -> &'a [u8] {
        self.while_is(|b| begins_word(b) || b.is_ascii_digit())
    }

    /// A number begins here: a digit, or a point before one.
    pub fn begins_number(&self) -> bool {
        let digit = |b: Option<u8>| b.is_some_and(|b| b.is_ascii_digit());
        digit(self.peek()) || self.peek() == Some(b'.') && digit(self.second())
    }

    /// Passes a number in any base: `12`, `1.5E-3`, `.5`, `0x1F`.
    pub fn number(&mut self) {
        if self.peek() == Some(b'0') && self.second().is_some_and(|b| matches!(b | 0x20, b'x' | b'b' | b'o')) {
            self.while_is(|b| b.is_ascii_alphanumeric());
        } else {
            self.decimal();
        }
    }

    /// Passes a number in decimal notation.
    ///
    /// `number = {digit} ["." {digit}] [("E" | "e") ["+" | "-"] digit {digit}]`
    pub fn decimal(&mut self) {
        self.digits();
        if self.eat(b'.') {
            self.digits();
        }
        let end = self.at;
        if self.eat(b'e') || self.eat(b'E') {
            let _ = self.eat(b'+') || self.eat(b'-');
            if self.digits().is_empty() {
                self.at = end;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_end_where_they_end() {
        for (text, length) in
            [("12,", 2), ("1.5E-3]", 6), (".5 ", 2), ("5.)", 2), ("0x1F;", 4), ("1e", 1), ("1e+", 1), ("7e3x", 3)]
        {
            let mut cursor = Cursor::new(text.as_bytes());
            assert!(cursor.begins_number(), "{text}");
            cursor.number();
            assert_eq!(cursor.at(), length, "{text}");
        }
        for text in [".x", "-1", ""] {
            assert!(!Cursor::new(text.as_bytes()).begins_number(), "{text}");
        }
    }

    #[test]
    fn bytes_of_any_encoding_are_letters() {
        assert_eq!(Cursor::new(b"caf\xe9_1 x").word().len(), 6);
        assert_eq!((Cursor::of_text(b"\xEF\xBB\xBFMODULE").at(), Cursor::of_text(b"MODULE").at()), (3, 0));
        assert_eq!((line_end(b"ab\ncd", 1), line_end(b"ab\ncd", 3)), (2, 5));
    }

    #[test]
    fn nothing_leaves_the_bytes() {
        let mut cursor = Cursor::new(b"ab");
        assert!(!cursor.past(b"]") && cursor.past(b"b") && cursor.at() == 2);
        cursor.skip(5);
        assert_eq!((cursor.at(), cursor.peek(), cursor.rest()), (2, None, &b""[..]));
        assert_eq!(cursor.since(9), b"");
    }
}
