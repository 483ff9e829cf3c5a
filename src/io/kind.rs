//! What kind of content a file has: an output replaces a file of its own kind only.
//!
//! Method: the first bytes identify pages, documents (`schema: lostmotion/...`, YAML or JSON), lines of JSON (of a manifest, of a
//! summary), programs of a vendor (as [`robot_programs::formats`] recognises them), joint programs (CSV), logs (a header with commands),
//! tables with other headers, and other text. Every kind replaces an empty file, as `mktemp` makes one, and one of zeros, which a loss
//! of power leaves. An empty output replaces nothing that it might not be: a summary of no program, say.
//!
//! A mistaken name (`show robot.yaml --output machine.yaml`) therefore replaces nothing that another command made or a person wrote; a
//! command that runs again replaces what it wrote.

use robot_programs::formats::{self, FORMATS};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Bytes that identify the kind: a header of a log with many joints, and the comments before it.
const HEAD: u64 = 1 << 16;

/// Kind of content.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Kind {
    /// No bytes, or zeros alone.
    Empty,
    /// An HTML page.
    Page,
    /// Of the schema without its version: `robot` of `lostmotion/robot/1`.
    Document(String),
    /// Lines of JSON, one for each program of a job.
    Manifest,
    /// Lines of JSON, one for each program that was rewritten.
    Summary,
    /// A program of a vendor; the name of its format.
    Program(&'static str),
    /// A program as CSV: values of joints, and no other column but the time.
    Joints,
    /// A table with commands.
    Log,
    /// Another table (CSV), by the names of its columns.
    Table(Vec<String>),
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
        // zeros at the end are what a loss of power leaves
        let head = &head[..head.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1)];
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
        if let Some(lines) = lines_of(text) {
            return lines;
        }
        if let Some(format) = FORMATS.iter().find(|f| f.recognises(head)) {
            return Self::Program(format.name());
        }
        let lines = text.split(['\n', '\r']);
        let header = lines.into_iter().find(|l| !l.starts_with('#') && !l.trim().is_empty()).unwrap_or("");
        table_of(&header.to_lowercase()).unwrap_or(Self::Text)
    }

    /// Whether an output of this kind may replace a file of kind `there` under the name `target`.
    pub fn replaces(&self, there: &Self, target: &Path) -> bool {
        match (self, there) {
            (_, Self::Empty) | (Self::Empty, Self::Manifest | Self::Summary) => true,
            _ => self == there || self.is_program_named(target) && there.is_program_named(target),
        }
    }

    /// Whether a program, or a table that a program with other columns may have become, has this kind.
    pub fn is_program_or_table(&self) -> bool {
        matches!(self, Self::Empty | Self::Program(_) | Self::Joints | Self::Table(_) | Self::Text)
    }

    /// Whether a file of this kind may be a program of the format that the ending of its name states: one whose first bytes do not
    /// tell its format is known by its name.
    fn is_program_named(&self, name: &Path) -> bool {
        let ending = formats::ending(name).unwrap_or_default();
        let mut names = FORMATS.iter().filter(|f| f.endings().contains(&ending.as_str())).map(|f| f.name());
        match self {
            _ if formats::is_program_by_name(name, None) != Some(true) => false, // an ending of many kinds of files
            Self::Text => names.next().is_some(),
            Self::Program(format) => names.any(|n| n == *format),
            _ => false,
        }
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
            Self::Manifest => "a manifest".into(),
            Self::Summary => "a summary".into(),
            Self::Program(format) => format!("a program ({format})"),
            Self::Joints => "a joint program (CSV)".into(),
            Self::Log => "a log".into(),
            Self::Table(_) => "a table without commands".into(),
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

/// A manifest or a summary, by the keys of its first line.
fn lines_of(text: &str) -> Option<Kind> {
    let line: serde_json::Map<String, serde_json::Value> = serde_json::from_str(text.lines().next()?).ok()?;
    let has = |keys: &[&str]| keys.iter().all(|k| line.contains_key(*k));
    if has(&["key", "size", "sha256", "state"]) {
        return Some(Kind::Manifest);
    }
    has(&["input", "output", "status", "reason"]).then_some(Kind::Summary)
}

/// The table that a header in lower case begins; `None`: it is no header.
fn table_of(header: &str) -> Option<Kind> {
    let fields: Vec<&str> = header.split([',', ';', '\t']).map(|f| f.trim().trim_matches('"')).collect();
    if !fields.iter().all(|f| is_name(f)) {
        return None;
    }
    let is_joint = |f: &&&str| f.ends_with("_deg") || f.ends_with("_mm");
    let joints = fields.iter().filter(is_joint).count();
    match fields.len() {
        _ if fields.iter().any(|f| f.starts_with("cmd_")) => Some(Kind::Log),
        // a robot may have one axis
        all if joints > 0 && joints + fields.iter().filter(|f| **f == "t_s").count() == all => Some(Kind::Joints),
        0 | 1 => None,
        _ => Some(Kind::Table(fields.into_iter().map(String::from).collect())),
    }
}

/// A name of a column: no statement of a program has letters, digits and a few signs alone in every field.
fn is_name(field: &str) -> bool {
    !field.is_empty()
        && field.chars().all(|c| c.is_alphanumeric() || "_ .[]()/°-#".contains(c))
        && !field.starts_with(|c: char| c.is_ascii_digit() || c == '-')
        && !field.ends_with('.')
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
            ("# comment\na1_deg,a2_deg\n0,1\n", Kind::Joints),
            ("# comment\r\rt_s,A1_deg\r0,1\r", Kind::Joints),
            ("t_s,x_mm,y_mm\n0,1,2\n", Kind::Joints),
            ("Name,Mail\nA,B\n", Kind::Table(vec!["name".into(), "mail".into()])),
            (
                "{\"key\":\"a.csv\",\"size\":3,\"sha256\":null,\"format\":null,\"state\":\"unreadable\"}\n",
                Kind::Manifest,
            ),
            ("{\"input\":\"a\",\"output\":null,\"status\":\"failed\",\"reason\":\"x\",\"moves\":0}\n", Kind::Summary),
            ("1,2,3\n", Kind::Text),
            ("DEF weld( )\nPTP {A1 0}\n", Kind::Program("krl")),
            ("MODULE m\n  CONST num a := 1;\n", Kind::Program("rapid")),
            ("(part, rev B)\nN10 G1 X1.0 Y2.0\n", Kind::Program("gcode")),
            ("milk, eggs and 2 loaves.\n", Kind::Text),
            ("\0\0\0", Kind::Empty),
            ("a1_deg\n1\n\0\0\0", Kind::Joints),
            ("a\0b", Kind::Binary),
        ] {
            assert_eq!(Kind::of(text.as_bytes()), kind, "{text}");
        }
        assert_eq!(Kind::of(&[0x1f, 0x8b, 8]), Kind::Binary);
    }

    #[test]
    fn a_file_gives_way_to_its_own_kind_and_an_empty_one_to_all() {
        let gaps = Kind::Document("gaps".into());
        let src = Path::new("weld.src");
        assert!(gaps.replaces(&gaps.clone(), src) && gaps.replaces(&Kind::Empty, src));
        let krl = Kind::of(b"DEF weld( )\n");
        for (ours, there) in [
            (Kind::Page, Kind::Document("model".into())),
            (Kind::Log, Kind::Joints),
            (Kind::Joints, Kind::of(b"name,mail\n")),
            (Kind::Manifest, krl.clone()),
            (Kind::Summary, Kind::Manifest),
            (Kind::Empty, krl.clone()),
            (Kind::of(b"MODULE m\n"), krl.clone()),
        ] {
            assert!(!ours.replaces(&there, src), "{ours:?} {there:?}");
        }
        // where the first bytes do not tell, the ending does, where only programs have it
        assert!(
            krl.replaces(&Kind::Text, src) && Kind::Text.replaces(&krl, src) && Kind::Text.replaces(&Kind::Text, src)
        );
        let notes = Path::new("notes.txt");
        assert!(!krl.replaces(&Kind::Text, notes) && !Kind::Text.replaces(&krl, notes));
        assert!(!krl.replaces(&Kind::Text, Path::new("weld.mod")) && Kind::Empty.replaces(&Kind::Summary, notes));
    }
}
