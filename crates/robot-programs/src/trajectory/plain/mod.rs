//! A fast way to the tree of a plain text: block mappings and lists with words, and lists and mappings in brackets, as messages are
//! printed and stored.
//!
//! It takes only what has one meaning: no anchor, alias, tag, escape, block of text, word with a blank, empty value or
//! second document. A text with anything else, and a text that is wrong, is left to the parser of [`super::tree`], which also words
//! the refusal. Both give the same tree (tests compare them).

#[cfg(test)]
mod tests;

use super::tree::{Kind, Node, Tree};
use std::ops::Range;

/// Collections within collections that are followed.
const DEEPEST: usize = 16;
/// Bytes of the longest key: YAML bounds it by 1024 characters.
const LONGEST_KEY: usize = 512;

/// The tree of a plain text; `None`: it is not plain.
///
/// `text = value | ["---" newline] block`
pub fn tree(bytes: &[u8]) -> Option<Tree> {
    let mut reader = Reader { bytes, at: 0, depth: 0, nodes: Vec::new(), comments: Vec::new(), json: false };
    let first = bytes.iter().position(|b| !matches!(b, b' ' | b'\n' | b'\t'))?;
    reader.json = matches!(bytes.get(first), Some(b'{' | b'['));
    if reader.json {
        reader.at = first;
        reader.brackets()?;
        reader.blanks();
        (reader.at == bytes.len()).then_some(())?;
    } else {
        if bytes.starts_with(b"---\n") {
            reader.at = 4;
        }
        let indent = reader.next_line()?;
        reader.block(indent)?;
        reader.next_line().is_none().then_some(())?;
        (reader.at == bytes.len()).then_some(())?;
    }
    Some(Tree::of(reader.nodes, reader.comments))
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    depth: usize,
    /// Finished nodes whose parents are open.
    nodes: Vec<Node>,
    comments: Vec<Range<usize>>,
    /// The text begins with a bracket: lines and their indentation mean nothing.
    json: bool,
}

/// Whether a byte can stand in a word.
///
/// `word_byte = letter | digit | "_" | "." | "/" | "+" | "-"`
fn of_word(b: u8) -> bool {
    b.is_ascii_alphanumeric() || matches!(b, b'_' | b'.' | b'/' | b'+' | b'-')
}

fn node(kind: Kind, start: usize, end: usize, items: Box<[Node]>) -> Node {
    Node { kind, start: start as u32, end: end as u32, anchor: 0, tagged: false, items }
}

impl Reader<'_> {
    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    fn take(&mut self, byte: u8) -> Option<()> {
        (self.peek()? == byte).then(|| self.at += 1)
    }

    /// Skips blanks: those of a line, or of a text without lines.
    fn blanks(&mut self) {
        let json = self.json;
        while self.peek().is_some_and(|b| b == b' ' || json && matches!(b, b'\n' | b'\t')) {
            self.at += 1;
        }
    }

    /// Goes to the first word of the next line that has one, from the start of a line; its indentation. `None`: there is none.
    ///
    /// `lines = {{blank} ["#" comment] newline} {blank}`
    fn next_line(&mut self) -> Option<usize> {
        loop {
            let start = self.at;
            while self.peek() == Some(b' ') {
                self.at += 1;
            }
            match self.peek()? {
                b'\n' => self.at += 1,
                b'#' => self.comment(),
                _ => return Some(self.at - start),
            }
        }
    }

    /// Goes over a comment; one with anything unusual ends the reading, as no word begins there.
    fn comment(&mut self) {
        let start = self.at;
        while self.peek().is_some_and(|b| matches!(b, b' '..=b'~' | 0x80..)) {
            self.at += 1;
        }
        self.comments.push(start..self.at);
    }

    /// Goes over the end of a line on which nothing more stands, to the first word after it; its indentation, `None` at the end of
    /// the text.
    ///
    /// `rest = {blank} ["#" comment] newline`
    fn end_of_line(&mut self) -> Option<Option<usize>> {
        self.blanks();
        if self.peek() == Some(b'#') && self.at.checked_sub(1).and_then(|k| self.bytes.get(k)) == Some(&b' ') {
            self.comment();
        }
        match self.peek() {
            None => Some(None),
            Some(b'\n') => {
                self.at += 1;
                Some(self.next_line())
            }
            Some(_) => None,
        }
    }

    /// The nodes after the first `from` become the items of one.
    fn close(&mut self, kind: Kind, start: usize, end: usize, from: usize) {
        let items = self.nodes.drain(from..).collect();
        self.nodes.push(node(kind, start, end, items));
    }

    /// End of the last node.
    fn last_end(&self) -> usize {
        self.nodes.last().map_or(0, |n| n.end as usize)
    }

    /// A word without quotes.
    ///
    /// `word = {letter | digit | "_" | "." | "/" | "+" | "-"}`, no mark of a document or of a list
    fn word(&mut self) -> Option<()> {
        let start = self.at;
        while self.peek().is_some_and(of_word) {
            self.at += 1;
        }
        let word = self.bytes.get(start..self.at)?;
        let marks = word.starts_with(b"---") || word.starts_with(b"...") || word == b"-";
        (!word.is_empty() && !marks && word.len() <= LONGEST_KEY).then_some(())?;
        self.nodes.push(node(Kind::Scalar { plain: true }, start, self.at, Box::default()));
        Some(())
    }

    /// A word in quotes, without escapes and other quotes.
    ///
    /// `word = '"' {any} '"' | "'" {any} "'"`
    fn quoted(&mut self) -> Option<()> {
        let (start, quote) = (self.at, self.peek()?);
        self.at += 1;
        while matches!(self.peek()?, b' ' | b'!' | b'#'..=b'&' | b'('..=b'[' | b']'..=b'~') {
            self.at += 1;
        }
        self.take(quote)?;
        (self.peek() != Some(quote)).then_some(())?;
        (self.at - start <= LONGEST_KEY).then_some(())?;
        self.nodes.push(node(Kind::Scalar { plain: false }, start, self.at, Box::default()));
        Some(())
    }

    /// A word, in quotes or without.
    ///
    /// `single = quoted | word`
    fn single(&mut self) -> Option<()> {
        match self.peek()? {
            b'"' | b'\'' => self.quoted(),
            _ => self.word(),
        }
    }

    /// A value in brackets, or a word within them.
    ///
    /// `value = "[" [value {"," value}] "]" | "{" [key value {"," key value}] "}" | single`
    fn brackets(&mut self) -> Option<()> {
        let (start, from) = (self.at, self.nodes.len());
        let (closing, kind) = match self.peek()? {
            b'[' => (b']', Kind::List),
            b'{' => (b'}', Kind::Map),
            _ => return self.single(),
        };
        self.depth += 1;
        (self.depth <= DEEPEST).then_some(())?;
        self.at += 1;
        self.blanks();
        while self.peek()? != closing {
            if self.nodes.len() > from {
                self.take(b',')?;
                self.blanks();
            }
            if kind == Kind::Map {
                self.key()?;
                self.blanks();
            }
            self.brackets()?;
            self.blanks();
            matches!(self.peek()?, b',' | b']' | b'}').then_some(())?;
        }
        self.at += 1;
        self.depth -= 1;
        self.close(kind, start, self.at, from);
        Some(())
    }

    /// A key and its colon.
    ///
    /// `key = single ":"`
    fn key(&mut self) -> Option<()> {
        let quoted = self.peek()? == b'"';
        self.single()?;
        self.take(b':')?;
        (quoted && self.json || matches!(self.peek(), None | Some(b' ' | b'\n'))).then_some(())
    }

    /// Whether a list goes on here.
    ///
    /// `dash = "-" (blank | newline)`
    fn dash(&self) -> bool {
        self.peek() == Some(b'-') && matches!(self.bytes.get(self.at + 1), Some(b' ' | b'\n'))
    }

    /// A list or mapping by lines, from its first word; the indentation of the line after it, `None` at the end of the text.
    ///
    /// `block = item {item} | entry {entry}`
    fn block(&mut self, indent: usize) -> Option<Option<usize>> {
        self.depth += 1;
        (self.depth <= DEEPEST).then_some(())?;
        let (start, from, list) = (self.at, self.nodes.len(), self.dash());
        let after = loop {
            let after = if list { self.item(indent)? } else { self.entry(indent)? };
            match after {
                Some(next) if next > indent => return None,
                Some(next) if next == indent && self.dash() == list => {}
                other => break other,
            }
        };
        self.depth -= 1;
        let kind = if list { Kind::List } else { Kind::Map };
        self.close(kind, start, self.last_end(), from);
        Some(after)
    }

    /// An item of a list.
    ///
    /// `item = "-" blank (value | block)`
    fn item(&mut self, indent: usize) -> Option<Option<usize>> {
        let dash = self.at;
        self.at += 1;
        self.take(b' ')?;
        self.blanks();
        (!self.dash()).then_some(())?;
        if matches!(self.peek()?, b'[' | b'{') {
            self.brackets()?;
            return self.end_of_line();
        }
        if self.is_key() {
            return self.block(indent + self.at - dash);
        }
        self.single()?;
        self.end_of_line()
    }

    /// Whether a key stands here.
    ///
    /// `key = word ":" ...`
    fn is_key(&self) -> bool {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let word = rest.iter().position(|b| !of_word(*b)).unwrap_or(rest.len());
        word > 0 && rest.get(word) == Some(&b':')
    }

    /// A key with its value.
    ///
    /// `entry = key (value | newline block)`
    fn entry(&mut self, indent: usize) -> Option<Option<usize>> {
        self.is_key().then_some(())?;
        self.key()?;
        self.blanks();
        match self.peek()? {
            b'\n' | b'#' => {
                let next = self.end_of_line()??;
                // a list may stand as far to the left as its key
                if next > indent {
                    return self.block(next);
                }
                let list = self.nodes.len();
                let after = (next == indent && self.dash()).then(|| self.block(next))??;
                // such a list begins, for the parser, at its first item
                let first = self.nodes.get(list)?.items.first()?.start;
                // where that is a bracket, the parser's end of the list differs
                (!matches!(self.bytes.get(first as usize), Some(b'[' | b'{'))).then_some(())?;
                self.nodes.get_mut(list)?.start = first;
                Some(after)
            }
            b'[' | b'{' => {
                self.brackets()?;
                self.end_of_line()
            }
            _ => {
                self.single()?;
                self.end_of_line()
            }
        }
    }
}
