//! What kind of content a file has: an output replaces a file of its own kind only.
//!
//! Method: the first bytes identify pages, documents (`schema: lostmotion/...`, YAML or JSON), logs (a header with commands), other
//! tables and other text apart. An empty file, as `mktemp` makes one, is of every kind.
//!
//! A mistaken name (`show robot.yaml --output machine.yaml`) therefore replaces nothing that another command made or a person wrote; a
//! command that runs again replaces what it wrote.

use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Bytes that identify the kind: a header of a log with many joints, and the comments before it.
const HEAD: u64 = 1 << 16;

/// Kind of content.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Kind {
    /// No bytes.
    Empty,
    /// An HTML page.
    Page,
    /// Of the schema without its version: `robot` of `lostmotion/robot/1`.
    Document(String),
    /// A table with commands.
    Log,
    /// Another table (CSV).
    Table,
    /// Other text.
    Text,
    /// Bytes that are no text.
    Binary,
}

impl Kind {
    /// The kind of a file; `None` where it cannot be read.
    pub fn of_file(path: &Path) -> Option<Self> {
        let mut head = Vec::new();
        File::open(path).ok()?.take(HEAD).read_to_end(&mut head).ok()?;
        Some(Self::of(&head))
    }

    /// The kind of a content that begins with `head`.
    pub fn of(head: &[u8]) -> Self {
        if head.contains(&0) || head.starts_with(&[0x1f, 0x8b]) {
            return Self::Binary;
        }
        let text = String::from_utf8_lossy(head);
        let text = text.trim_start_matches('\u{feff}').trim_start();
        if text.is_empty() {
            return Self::Empty;
        }
        if text.get(..14).is_some_and(|t| t.eq_ignore_ascii_case("<!doctype html")) || text.starts_with("<html") {
            return Self::Page;
        }
        if let Some(name) = schema(text) {
            return Self::Document(name);
        }
        let header = text.lines().find(|l| !l.starts_with('#') && !l.trim().is_empty()).unwrap_or("").to_lowercase();
        let fields: Vec<&str> = header.split([',', ';', '\t']).map(|f| f.trim().trim_matches('"')).collect();
        match fields.len() > 1 && fields.iter().all(|f| is_name(f)) {
            true if fields.iter().any(|f| f.starts_with("cmd_")) => Self::Log,
            true => Self::Table,
            false => Self::Text,
        }
    }

    /// Whether an output of this kind may replace a file of kind `there`.
    pub fn replaces(&self, there: &Self) -> bool {
        *there == Self::Empty || *self == Self::Empty || self == there
    }

    /// For messages, with its article.
    pub fn name(&self) -> String {
        match self {
            Self::Empty => "an empty file".into(),
            Self::Page => "a page".into(),
            Self::Document(name) => {
                let article = if name.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
                format!("{article} {name} document")
            }
            Self::Log => "a log".into(),
            Self::Table => "a table without commands".into(),
            Self::Text => "other text".into(),
            Self::Binary => "a binary file".into(),
        }
    }
}

/// `robot` of the schema that a line of a document names.
fn schema(text: &str) -> Option<String> {
    let line = text
        .lines()
        .find_map(|l| l.trim_start_matches(['{', ' ']).split_once("lostmotion/").filter(|(key, _)| is_key(key)));
    let name: String = line?.1.chars().take_while(|c| c.is_ascii_lowercase() || *c == '-').collect();
    (!name.is_empty()).then_some(name)
}

/// `schema: ` or `"schema": "`.
fn is_key(before: &str) -> bool {
    before.trim_matches(['"', ' ', '\'']).strip_suffix(':').is_some_and(|k| k.trim_matches(['"', ' ']) == "schema")
}

/// A name of a column: no statement of a program has letters, digits and a few signs alone in every field.
fn is_name(field: &str) -> bool {
    !field.is_empty()
        && field.chars().all(|c| c.is_alphanumeric() || "_ .[]()/°-#".contains(c))
        && !field.starts_with(|c: char| c.is_ascii_digit() || c == '-')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_bytes_tell_the_kind() {
        let document = |name: &str| Kind::Document(name.into());
        for (text, kind) in [
            ("", Kind::Empty),
            ("\n\n", Kind::Empty),
            ("<!DOCTYPE html>\n<html>", Kind::Page),
            ("# a comment\nschema: lostmotion/robot/1\nname: x\n", document("robot")),
            ("{\n  \"schema\": \"lostmotion/robot-check/1\",\n", document("robot-check")),
            ("{\"schema\":\"lostmotion/gaps/1\"}", document("gaps")),
            ("t_s,cmd_A1_deg,x_mm\n0,1,2\n", Kind::Log),
            ("# comment\na1_deg,a2_deg\n0,1\n", Kind::Table),
            ("1,2,3\n", Kind::Text),
            ("DEF weld( )\nPTP {A1 0}\n", Kind::Text),
            ("MODULE m\n  CONST num a := 1;\n", Kind::Text),
            ("N10 G1 X1.0 Y2.0\n", Kind::Text),
            ("a\0b", Kind::Binary),
        ] {
            assert_eq!(Kind::of(text.as_bytes()), kind, "{text}");
        }
        assert_eq!(Kind::of(&[0x1f, 0x8b, 8]), Kind::Binary);
    }

    #[test]
    fn a_file_gives_way_to_its_own_kind_and_an_empty_one_to_all() {
        let gaps = Kind::Document("gaps".into());
        assert!(gaps.replaces(&gaps.clone()) && gaps.replaces(&Kind::Empty) && Kind::Empty.replaces(&gaps));
        assert!(!Kind::Page.replaces(&Kind::Document("model".into())) && !Kind::Log.replaces(&Kind::Table));
    }
}
