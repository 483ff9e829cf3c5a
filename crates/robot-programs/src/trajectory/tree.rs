//! YAML and JSON as a tree in which every node knows its bytes.
//!
//! `saphyr-parser` reads (YAML 1.2, of which JSON is a part) and says where each node stands in characters. To get bytes,
//! every byte is handed over as one character: ASCII as itself, the rest from the private use area, so that Latin-1 and
//! broken UTF-8 pass as well. Tabs, which YAML allows nowhere in an indentation, are handed over as spaces where the text
//! begins with a bracket: JSON is often indented with them. Values are taken from the bytes, never from the parser, so
//! that a wrong place cannot become a wrong number. The parser's ends of quoted words and of brackets reach over the blanks
//! and the comment after them: these ends are found here.

use super::plain;
use crate::error::Result;
use crate::script::cursor::unmarked;
use crate::script::{Span, Text};
use saphyr_parser::{Event, Parser, ScalarStyle, ScanError};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::ops::Range;

/// Collections within collections beyond which a text is refused.
const DEEPEST: usize = 64;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A word or number; `plain`: without quotes and not a block of text.
    Scalar {
        plain: bool,
    },
    List,
    /// Keys and values in turn.
    Map,
    Alias,
}

/// A node; a text has no more bytes than its places can tell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Node {
    pub kind: Kind,
    /// First byte; of a block collection that of its first entry.
    pub start: u32,
    /// After the last byte; of a block collection after its last entry that has bytes.
    pub end: u32,
    /// Number of its anchor, 0: none.
    pub anchor: u32,
    pub tagged: bool,
    pub items: Box<[Node]>,
}

/// The documents of a text and its comments.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tree {
    pub documents: Vec<Node>,
    /// From `#` to the end of the line, in order.
    pub comments: Vec<Range<usize>>,
    /// Anchors to which an alias points.
    aliased: BTreeSet<u32>,
}

impl Node {
    /// Its first byte.
    pub fn at(&self) -> usize {
        self.start as usize
    }

    /// Its bytes.
    pub fn span(&self) -> Range<usize> {
        self.at()..self.end as usize
    }

    /// Key and value of every entry.
    pub fn entries(&self) -> impl Iterator<Item = (&Node, &Node)> {
        let items = if self.kind == Kind::Map { &self.items[..] } else { &[] };
        items.chunks_exact(2).map(|pair| (&pair[0], &pair[1]))
    }

    /// Its word: quotes are taken off, escapes left as they are.
    ///
    /// `word = '"' {any} '"' | "'" {any} "'" | {any}`
    pub fn word<'a>(&self, text: &'a Text) -> Cow<'a, str> {
        let bytes = text.slice(self.span());
        let inner = match (self.kind, bytes) {
            (Kind::Scalar { plain: false }, [b'"', inner @ .., b'"'] | [b'\'', inner @ .., b'\'']) => inner,
            _ => bytes,
        };
        String::from_utf8_lossy(inner)
    }

    /// Whether nothing is written here: `key:`, `null`, `~`.
    ///
    /// `null = "" | "~" | "null" | "Null" | "NULL"`
    pub fn is_null(&self, text: &Text) -> bool {
        self.kind == Kind::Scalar { plain: true }
            && matches!(text.slice(self.span()), b"" | b"~" | b"null" | b"Null" | b"NULL")
    }
}

impl Tree {
    /// Reads a text.
    ///
    /// # Errors
    /// With line and column where it is no YAML or JSON, or nested too deep.
    pub fn read(text: &Text) -> Result<Self> {
        match plain::tree(&text.bytes) {
            Some(tree) => Ok(tree),
            None => Self::parse(text),
        }
    }

    /// Of documents without aliases.
    pub(super) fn of(documents: Vec<Node>, comments: Vec<Range<usize>>) -> Self {
        Self { documents, comments, ..Self::default() }
    }

    /// Reads whatever YAML or JSON has.
    ///
    /// `text = {document}`, `document = word | list | mapping | alias`, each with its anchor and its tag
    pub(super) fn parse(text: &Text) -> Result<Self> {
        let skipped = text.bytes.len() - unmarked(&text.bytes).len();
        let bytes = text.bytes.get(skipped..).unwrap_or_default();
        let characters = characters(bytes);
        let mut tree = Self::default();
        let mut open: Vec<(Node, Vec<Node>)> = Vec::new();
        let mut leaves: Vec<Span> = Vec::new();
        for event in Parser::new_from_str(&characters) {
            let (event, span) = event.map_err(|e| malformed(text, skipped, &e))?;
            let at = |index: usize| (index + skipped).min(text.bytes.len());
            let (start, end) = (at(span.start.index()), at(span.end.index()).max(at(span.start.index())));
            let node = |kind, anchor: usize, tagged| Node {
                kind,
                start: start as u32,
                end: end as u32,
                anchor: anchor as u32,
                tagged,
                items: Box::default(),
            };
            let done = match event {
                Event::Scalar(_, style, anchor, tag) => {
                    let mut word = node(Kind::Scalar { plain: style == ScalarStyle::Plain }, anchor, tag.is_some());
                    if matches!(style, ScalarStyle::SingleQuoted | ScalarStyle::DoubleQuoted) {
                        word.end = word.start + quoted(text.slice(start..end)) as u32;
                    }
                    if word.start < word.end {
                        leaves.push(word.span().into());
                    }
                    Some(word)
                }
                Event::Alias(anchor) => {
                    tree.aliased.insert(anchor as u32);
                    Some(node(Kind::Alias, 0, false))
                }
                Event::SequenceStart(anchor, tag) => {
                    open.push((node(Kind::List, anchor, tag.is_some()), Vec::new()));
                    None
                }
                Event::MappingStart(anchor, tag) => {
                    open.push((node(Kind::Map, anchor, tag.is_some()), Vec::new()));
                    None
                }
                Event::SequenceEnd | Event::MappingEnd => open.pop().map(|(n, items)| whole(text, n, items)),
                _ => None,
            };
            if open.len() > DEEPEST {
                return Err(text.bad(start, format!("more than {DEEPEST} levels"), "a trajectory message"));
            }
            if let Some(node) = done {
                match open.last_mut() {
                    Some((_, items)) => items.push(node),
                    None => tree.documents.push(node),
                }
            }
        }
        tree.comments = comments(&text.bytes, &leaves);
        Ok(tree)
    }

    /// Whether an alias elsewhere repeats this node: an edit of one would change the other.
    pub fn is_shared(&self, node: &Node) -> bool {
        self.aliased.contains(&node.anchor)
    }

    /// Comments that begin within a span.
    pub fn comments_in(&self, span: &Range<usize>) -> &[Range<usize>] {
        let from = self.comments.partition_point(|c| c.start < span.start);
        let to = self.comments.partition_point(|c| c.start < span.end);
        self.comments.get(from..to).unwrap_or_default()
    }
}

/// A list or a mapping that ends, with what is in it.
///
/// `node = "[" ... "]" | "{" ... "}" | {item}`
fn whole(text: &Text, mut node: Node, items: Vec<Node>) -> Node {
    let last = items.iter().filter(|i| i.end > i.start).map(|i| i.end).max().unwrap_or(node.start) as usize;
    let after = last.max(node.at() + 1);
    node.end = match text.bytes.get(node.at()) {
        Some(b'[') => closing(&text.bytes, after, b']'),
        Some(b'{') => closing(&text.bytes, after, b'}'),
        _ => last,
    } as u32;
    node.items = items.into_boxed_slice();
    node
}

/// A character for every byte.
///
/// `text = ("{" | "[") {any} | {any}`: in the first a tab is a blank
fn characters(bytes: &[u8]) -> String {
    let first = bytes.iter().find(|b| !b.is_ascii_whitespace());
    let tabs_are_spaces = matches!(first, Some(b'{' | b'['));
    let character = |&b: &u8| match b {
        b'\t' if tabs_are_spaces => ' ',
        0..0x80 => char::from(b),
        // U+E080 to U+E0FF: printable for YAML, and nothing that it knows
        _ => char::from_u32(0xE000 + u32::from(b)).unwrap_or('?'),
    };
    bytes.iter().map(character).collect()
}

/// Length of a quoted word: up to its closing quote.
///
/// `word = "'" {any | "'" "'"} "'" | '"' {any | "\" any} '"'`
fn quoted(bytes: &[u8]) -> usize {
    let Some(quote) = bytes.iter().position(|b| matches!(b, b'\'' | b'"')) else { return bytes.len() };
    let mark = bytes[quote];
    let mut k = quote + 1;
    while let Some(&b) = bytes.get(k) {
        let next = bytes.get(k + 1);
        match b {
            b'\\' if mark == b'"' => k += 2,
            _ if b == mark && mark == b'\'' && next == Some(&mark) => k += 2,
            _ if b == mark => return k + 1,
            _ => k += 1,
        }
    }
    bytes.len()
}

/// After the closing bracket, from the end of the last entry on: only blanks, commas, colons and comments stand between.
///
/// `rest = {any | "#" comment} bracket`
fn closing(bytes: &[u8], from: usize, bracket: u8) -> usize {
    let mut k = from;
    while let Some(&b) = bytes.get(k) {
        if b == bracket {
            return k + 1;
        }
        k += if b == b'#' {
            let rest = &bytes[k..];
            memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len())
        } else {
            1
        };
    }
    from
}

fn malformed(text: &Text, skipped: usize, e: &ScanError) -> crate::error::Error {
    let byte = (e.marker().index() + skipped).min(text.bytes.len());
    text.bad(byte, format!("no YAML or JSON here: {}", e.info()), "a trajectory message")
}

/// Every `#` after a blank or at the start of a line, outside of words.
///
/// `comment = "#" {any}`, to the end of the line
fn comments(bytes: &[u8], leaves: &[Span]) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    for at in memchr::memchr_iter(b'#', bytes) {
        let behind_blank = at.checked_sub(1).is_none_or(|k| matches!(bytes.get(k), Some(b' ' | b'\t' | b'\n' | b'\r')));
        let within_comment = found.last().is_some_and(|c| at < c.end);
        let leaf = leaves.partition_point(|l| l.start() <= at).checked_sub(1).and_then(|k| leaves.get(k));
        if behind_blank && !within_comment && leaf.is_none_or(|l| l.end() <= at) {
            let rest = bytes.get(at..).unwrap_or_default();
            let line = memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len());
            found.push(at..at + line);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (Text, Tree) {
        let text = Text::new("t.yaml", text.as_bytes().to_vec());
        let tree = Tree::read(&text).unwrap();
        (text, tree)
    }

    fn words(node: &Node, text: &Text, out: &mut Vec<String>) {
        if node.items.is_empty() {
            out.push(String::from_utf8_lossy(text.slice(node.span())).into_owned());
        }
        for item in &node.items[..] {
            words(item, text, out);
        }
    }

    #[test]
    fn every_word_is_found_at_its_bytes_in_every_style() {
        for (source, expected) in [
            ("a:\n- b: [1.5, -2]\n  c:\n    d: 1e-3   # x\n- 'q'\n", "a b 1.5 -2 c d 1e-3 'q'"),
            ("{\n\t\"a\": [\n\t\t1.0,\n\t\t2\n\t], \"b\": {}}\n", "\"a\" 1.0 2 \"b\" {}"),
            ("a: é\nb: 1.25 \r\nc: -3\r\n", "a é b 1.25 c -3"),
            ("\u{feff}---\na: 1\n---\nb: 2\n...\n", "a 1 b 2"),
            ("{a: 1.5,b: [2,3], 'c':4}", "a 1.5 b 2 3 'c' 4"),
        ] {
            let (text, tree) = read(source);
            let mut found = Vec::new();
            for d in &tree.documents {
                words(d, &text, &mut found);
            }
            assert_eq!(found.join(" "), expected, "{source}");
        }
    }

    #[test]
    fn a_collection_ends_behind_its_last_word() {
        let (text, tree) = read("a:\n- b: 1\n  c: [2]   # x\n\n- d: 3\n  e:\nf: 4\n");
        let list = &tree.documents[0].items[1];
        let bytes = |n: &Node| String::from_utf8_lossy(text.slice(n.span())).into_owned();
        assert_eq!(bytes(&list.items[0]), "b: 1\n  c: [2]");
        assert!(bytes(&list.items[1]).starts_with("d: 3\n  e"));
    }

    #[test]
    fn a_bracket_ends_behind_commas_and_comments() {
        for source in ["{a: [1, 2,] , }", "[{a: 1,} ,  # ]\n ]", "{a: {b: }, c: [] }", "[[ ], { }]"] {
            let (text, tree) = read(&format!("k: {source}   # }} ]\n"));
            let node = &tree.documents[0].items[1];
            assert_eq!(String::from_utf8_lossy(text.slice(node.span())), source);
        }
        let (text, tree) = read("[{a: [1, 2,  ] ,  }]");
        let map = &tree.documents[0].items[0];
        let list = &map.items[1];
        assert_eq!(text.slice(map.span()), b"{a: [1, 2,  ] ,  }");
        assert_eq!(text.slice(list.span()), b"[1, 2,  ]");
    }

    #[test]
    fn a_hash_within_a_word_is_no_comment() {
        let (text, tree) = read("# top\na: 'x # y'  # one # two\nb: c#d\n");
        let found: Vec<_> = tree.comments.iter().map(|c| String::from_utf8_lossy(text.slice(c.clone()))).collect();
        assert_eq!(found, ["# top", "# one # two"]);
    }

    #[test]
    fn only_an_anchor_that_is_used_is_shared() {
        let (_, tree) = read("a: &x [1]\nb: &y [2]\nc: *x\n");
        let map = &tree.documents[0];
        assert!(tree.is_shared(&map.items[1]) && !tree.is_shared(&map.items[3]));
        assert_eq!(map.items[5].kind, Kind::Alias);
    }

    #[test]
    fn what_is_no_yaml_is_refused_with_its_place() {
        for source in ["a: [1, 2", "a: }\n", "{---", "a: *nobody\n", "a: \0\n", "a: 1\n b: 2\n"] {
            let e = Tree::read(&Text::new("t.yaml", source.as_bytes().to_vec())).unwrap_err();
            assert!(e.to_string().starts_with("t.yaml:"), "{source}: {e}");
        }
        let deep = "[".repeat(100_000);
        let e = Tree::read(&Text::new("t.yaml", deep.into_bytes())).unwrap_err();
        assert!(e.to_string().contains("recursion limit") || e.to_string().contains("64 levels"), "{e}");
        let deep = "- ".repeat(70) + "a";
        let e = Tree::read(&Text::new("t.yaml", deep.into_bytes())).unwrap_err();
        assert!(e.to_string().contains("64 levels"), "{e}");
    }
}
