//! Words, numbers and marks of languages with statements (RAPID, URScript): the tokens, and the pieces of text that look alike
//! in all of them. Bytes above 127 count as letters, so that Latin-1 and UTF-8 pass alike.

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

/// A token and its bytes.
#[derive(Debug, Clone, Copy)]
pub struct Token {
    /// What it is.
    pub kind: Kind,
    /// First byte.
    pub start: usize,
    /// Byte after it.
    pub end: usize,
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
