//! Words, numbers and marks of languages with statements (RAPID, URScript): their tokens.

use super::Text;
use super::alike::Passed;
use crate::error::Result;
use std::borrow::Cow;
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
    len: u16,
    from: u32,
}

impl Token {
    /// A token of a text.
    ///
    /// # Errors
    /// Bad input where it is longer than any controller takes.
    pub fn new(text: &Text, kind: Kind, start: usize, end: usize) -> Result<Self> {
        match (u32::try_from(start), u16::try_from(end.saturating_sub(start))) {
            (Ok(from), Ok(len)) => Ok(Self { kind, len, from }),
            _ => Err(text.bad(start, format!("a word of {} bytes", end - start), format!("at most {}", u16::MAX))),
        }
    }

    /// First byte.
    pub fn start(&self) -> usize {
        self.from as usize
    }

    /// Byte after it.
    pub fn end(&self) -> usize {
        self.from as usize + usize::from(self.len)
    }
}

/// Bytes of the longest text that is read.
pub const LONGEST: usize = u32::MAX as usize;

impl Kind {
    /// The byte of a mark.
    pub fn mark(self) -> Option<u8> {
        if let Self::Mark(b) = self { Some(b) } else { None }
    }
}

/// Places of a span outside of brackets, the brackets themselves left out; `mark`: the mark that stands at a place.
pub fn outside(span: Range<usize>, mark: impl Fn(usize) -> Option<u8>) -> impl Iterator<Item = usize> {
    let mut depth = 0_usize;
    span.filter(move |k| {
        match mark(*k) {
            Some(b'(' | b'[' | b'{') => depth += 1,
            Some(b')' | b']' | b'}') => depth = depth.saturating_sub(1),
            _ => return depth == 0,
        }
        false
    })
}

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

/// A name in UTF-8, or else in Latin-1, where each byte is a letter: names that differ in any byte stay different.
pub fn text_of(name: &[u8]) -> Cow<'_, str> {
    let latin = |_| Cow::Owned(name.iter().map(|b| char::from(*b)).collect());
    std::str::from_utf8(name).map_or_else(latin, Cow::Borrowed)
}

/// A word in upper case.
pub fn upper_of(word: &[u8]) -> Cow<'_, str> {
    match text_of(word) {
        // most words are in upper case already
        Cow::Borrowed(word) if !word.bytes().any(|b| b.is_ascii_lowercase()) => Cow::Borrowed(word),
        word => Cow::Owned(word.to_ascii_uppercase()),
    }
}

/// A word for each token; empty for those that are none. Each different word stands in memory once.
#[derive(Debug, Default)]
pub struct Words {
    /// For each [`BLOCK`] of tokens: which of them are words, and how many words stand before.
    blocks: Vec<(u64, u32)>,
    /// By word of the text.
    ids: Vec<u32>,
    different: Vec<String>,
}

/// Tokens of a block of [`Words`].
const BLOCK: usize = u64::BITS as usize;

impl Words {
    /// The words of tokens; `word` gives one as it is kept.
    pub fn of(text: &Text, tokens: &[Token], word: impl Fn(&[u8]) -> String) -> Self {
        let mut known: HashMap<&[u8], u32> = HashMap::new();
        let mut all = Self::default();
        all.blocks.reserve_exact(tokens.len().div_ceil(BLOCK));
        all.ids.reserve_exact(tokens.iter().filter(|t| t.kind == Kind::Word).count());
        for block in tokens.chunks(BLOCK) {
            let mut words = (0u64, all.ids.len() as u32);
            for (k, t) in block.iter().enumerate().filter(|(_, t)| t.kind == Kind::Word) {
                words.0 |= 1 << k;
                let bytes = text.slice(t.start()..t.end());
                all.ids.push(*known.entry(bytes).or_insert_with(|| {
                    all.different.push(word(bytes));
                    all.different.len() as u32 - 1
                }));
            }
            all.blocks.push(words);
        }
        all
    }

    /// The word of a token; empty where there is none.
    pub fn at(&self, token: usize) -> &str {
        let word = || {
            let (words, before) = *self.blocks.get(token / BLOCK)?;
            let bit = 1u64 << (token % BLOCK);
            let rank = (words & bit != 0).then(|| (words & (bit - 1)).count_ones())?;
            self.different.get(*self.ids.get((before + rank) as usize)? as usize)
        };
        word().map_or("", String::as_str)
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
    /// Lines that have no tokens, as they are like the one before them; empty where all were asked for.
    pub passed: Vec<Passed>,
}

/// Whether lines that are like those before them get tokens.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Like {
    /// All lines do.
    Read,
    /// They are passed over.
    Passed,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_found_at_their_tokens_alone() {
        let source = "a 1 b ".repeat(100);
        let text = Text::new("t", source.clone().into_bytes());
        let starts = (0..source.len()).step_by(2);
        let kind = |k: usize| if source.as_bytes()[k] == b'1' { Kind::Number } else { Kind::Word };
        let tokens: Vec<Token> = starts.map(|k| Token::new(&text, kind(k), k, k + 1).unwrap()).collect();
        let words = Words::of(&text, &tokens, |w| String::from_utf8_lossy(w).to_uppercase());
        for (k, t) in tokens.iter().enumerate() {
            let expected = if t.kind == Kind::Word { source[t.start()..t.end()].to_uppercase() } else { String::new() };
            assert_eq!(words.at(k), expected, "{k}");
        }
        assert_eq!((words.at(tokens.len()), words.different().count()), ("", 2));
        assert!(Token::new(&text, Kind::String, 0, 70_000).is_err());
        assert_eq!(size_of::<Token>(), 8);
    }
}
