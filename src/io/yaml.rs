//! YAML documents: parsed with places, so that a refusal names file and line.

use super::memory;
use crate::error::{Error, Place, Result};
use serde::{Serialize, de::DeserializeOwned};

/// A document has at most so many bytes.
const LARGEST: u64 = 64 << 20;
/// Collections within collections beyond which a document is refused: a parser may take a time that grows with their square.
const DEEPEST: usize = 64;

/// The line on which brackets, dashes of lists within lists, or steps of indentation go too deep. Brackets in words may count as well: no
/// document of ours has so many that are never closed.
fn too_deep(text: &str) -> Option<u64> {
    let mut depth = 0usize;
    let mut indents: Vec<usize> = Vec::new();
    for (k, line) in text.lines().enumerate() {
        let indent = line.len() - line.trim_start_matches(' ').len();
        if indent < line.trim_end().len() {
            let open = indents.partition_point(|i| *i < indent);
            indents.truncate(open);
            indents.push(indent);
        }
        let dashes =
            line.split(' ').take_while(|w| w.is_empty() || *w == "-" || *w == "?").filter(|w| !w.is_empty()).count();
        let content = line.split(" #").next().unwrap_or_default();
        for b in content.bytes().filter(|_| !line.trim_start().starts_with('#')) {
            match b {
                b'[' | b'{' => depth += 1,
                b']' | b'}' => depth = depth.saturating_sub(1),
                _ => {}
            }
            if depth > DEEPEST {
                return Some(k as u64 + 1);
            }
        }
        if dashes > DEEPEST || indents.len() > DEEPEST {
            return Some(k as u64 + 1);
        }
    }
    None
}

/// The parser's words as a user reads them: without the place, which stands before them, and without names of types. Second: what is
/// expected there, where that is more than the document.
fn plainly(text: &str, line: Option<&str>) -> (String, Option<String>) {
    let text = text.find(" at line ").map_or(text, |at| &text[..at]);
    // the scanner's own words begin as ours do
    let text = text.strip_prefix("found ").unwrap_or(text);
    if text.contains("cannot start any token") && line.is_some_and(|l| l.contains('\t')) {
        return ("a tab".into(), Some("blanks to indent lines".into()));
    }
    let quoted: Vec<&str> = text.split('`').skip(1).step_by(2).collect();
    if let (Some((before, _)), Some((key, known))) = (text.split_once("unknown field "), quoted.split_first()) {
        let nearest = known.iter().min_by_key(|k| distance(key, k)).filter(|k| distance(key, k) <= 1 + key.len() / 4);
        let expected = match nearest {
            Some(k) => format!("perhaps `{k}`,"),
            None => format!("one of {},", known.join(", ")),
        };
        return (format!("{before}an unknown key `{key}`"), Some(expected));
    }
    let Some((before, expected)) = text.rsplit_once(", expected ") else { return (text.to_string(), None) };
    let before = before.replace("invalid type: ", "");
    match expected {
        "f64" => (before, Some("a number".into())),
        "usize" | "u8" | "u16" | "u32" | "u64" => (before, Some("a whole number".into())),
        kind if kind.starts_with("struct ") && before.starts_with("string ") => ("a text without keys".into(), None),
        kind if kind.starts_with("struct ") => (before, Some("keys with values".into())),
        other => (before, Some(other.to_string())),
    }
}

/// How many letters must change, come or go to make one word of the other (Levenshtein 1966).
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let changed = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = changed.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row.last().copied().unwrap_or(0)
}

/// How one kind of document comes from another that was given in its place.
fn made_of(found: &str, expected: &str) -> &'static str {
    let are = |a: &str, b: &str| found.starts_with(a) && expected.starts_with(b);
    if are("lostmotion/gaps/", "lostmotion/compensator/") {
        " (`fit` makes one of gaps)"
    } else if are("lostmotion/robot/", "lostmotion/model/") {
        " (a model names its robot file: `robot: FILE`)"
    } else if are("lostmotion/compensator/", "lostmotion/gaps/") {
        " (gaps are what a compensator is made of: `identify` writes them)"
    } else {
        ""
    }
}

/// A YAML text and its name, for parsing and for finding the line of a value again.
pub struct Document<'a> {
    /// Name of the file as messages show it.
    pub name: &'a str,
    /// The whole text.
    pub text: &'a str,
}

impl Document<'_> {
    /// Parses the document; an error names line and column and what was expected there.
    pub fn parse<T: DeserializeOwned>(&self, what: &str) -> Result<T> {
        self.require_readable(what)?;
        self.read(what)
    }

    /// Refuses what a parser would take too long for: nothing may parse such a text, not even to explain an error.
    fn require_readable(&self, what: &str) -> Result<()> {
        if self.text.trim().is_empty() {
            return Err(Error::bad(Place::file(self.name), "an empty file", what));
        }
        memory::require_size(self.name, self.text.len() as u64, LARGEST)?;
        match too_deep(self.text) {
            Some(line) => Err(Error::bad(Place::line(self.name, line), format!("more than {DEEPEST} levels"), what)),
            None => Ok(()),
        }
    }

    fn read<T: DeserializeOwned>(&self, what: &str) -> Result<T> {
        serde_yaml::from_str(self.text).map_err(|e| {
            let place = match e.location() {
                Some(l) => Place::field(self.name, l.line() as u64, l.column() as u64),
                None => Place::file(self.name),
            };
            let (found, hint) = plainly(&e.to_string(), place.line.and_then(|l| self.text.lines().nth(l as usize - 1)));
            Error::bad(place, found, hint.map_or_else(|| what.to_string(), |h| format!("{h} in {what}")))
        })
    }

    /// The same for a document of one schema; another kind of document is called what it is, not by its first strange key.
    pub fn parse_schema<T: DeserializeOwned>(&self, what: &str, schema: &str) -> Result<T> {
        let what = format!("{what} (schema {schema})");
        self.require_readable(&what)?;
        self.read(&what).map_err(|e| {
            let other = serde_yaml::from_str::<serde_yaml::Value>(self.text).ok();
            let found = other.as_ref().and_then(|v| v.get("schema")).and_then(|v| v.as_str());
            found.and_then(|f| self.require_schema(f, schema).err()).unwrap_or(e)
        })
    }

    /// Refuses a document of another schema, with the line on which it stands.
    pub fn require_schema(&self, found: &str, expected: &str) -> Result<()> {
        if found == expected {
            return Ok(());
        }
        Err(Error::bad(
            self.place(&[found]),
            format!("schema `{found}`"),
            format!("schema `{expected}`{}", made_of(found, expected)),
        ))
    }

    /// Place of the first line that holds all `needles` (a joint's name and a key, say), else of the file.
    pub fn place(&self, needles: &[&str]) -> Place {
        let hit = self.text.lines().position(|l| needles.iter().all(|n| l.contains(n)));
        match hit {
            Some(i) => Place::line(self.name, i as u64 + 1),
            None if needles.len() > 1 => self.place(&needles[..1]),
            None => Place::file(self.name),
        }
    }
}

/// A document as YAML text.
pub fn to_text<T: Serialize>(value: &T) -> Result<String> {
    serde_yaml::to_string(value).map_err(|e| Error::bad(Place::default(), e.to_string(), "values that YAML can hold"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_document_nested_too_deep_is_refused_at_once() {
        let deep = |open: &str, close: &str| format!("a: {}1{}\n", open.repeat(40_000), close.repeat(40_000));
        let indented: String = (0..2_000).map(|k| format!("{}a:\n", " ".repeat(k))).collect();
        for text in [deep("[", "]"), deep("{a: ", "}"), format!("a:\n  {}1\n", "- ".repeat(40_000)), indented] {
            let document = Document { name: "nest.yaml", text: &text };
            let start = std::time::Instant::now();
            let read = document.parse::<serde_yaml::Value>("a document");
            let of_schema = document.parse_schema::<serde_yaml::Value>("a document", "lostmotion/robot/1");
            for refused in [read, of_schema] {
                assert!(refused.unwrap_err().to_string().contains("more than 64 levels"));
            }
            assert!(start.elapsed().as_secs_f64() < 1.0, "{:?}", start.elapsed());
        }
    }

    #[test]
    fn words_of_the_parser_are_those_of_a_user() {
        let nearest = plainly(
            "joints[1]: unknown field `max_sped_deg_s`, expected one of `name`, `max_speed_deg_s`, `max_accel_deg_s2`",
            None,
        );
        assert_eq!(
            nearest,
            ("joints[1]: an unknown key `max_sped_deg_s`".into(), Some("perhaps `max_speed_deg_s`,".into()))
        );
        let strange = plainly("unknown field `colour`, expected `name` or `kind` at line 3 column 4", None);
        assert_eq!(strange, ("an unknown key `colour`".into(), Some("one of name, kind,".into())));
        let number = plainly("joints[1].a_mm: invalid type: string \"79O\", expected f64 at line 11 column 63", None);
        assert_eq!(number, ("joints[1].a_mm: string \"79O\"".into(), Some("a number".into())));
        assert_eq!(
            plainly("invalid type: string \"/PROG x\", expected struct RobotFile", None).0,
            "a text without keys"
        );
        let tab = plainly("found character that cannot start any token at line 14 column 2", Some("\t- a"));
        assert_eq!(tab.0, "a tab");
        assert_eq!((distance("abc", "abd"), distance("", "ab"), distance("tol", "tool")), (1, 2, 1));
    }

    #[test]
    fn aliases_that_multiply_are_refused() {
        let mut text = String::from("a0: &a0 [x, x, x, x, x, x, x, x, x]\n");
        for k in 1..12 {
            let list = vec![format!("*a{}", k - 1); 9].join(", ");
            text += &format!("a{k}: &a{k} [{list}]\n");
        }
        assert!(Document { name: "alias.yaml", text: &text }.parse::<serde_yaml::Value>("a document").is_err());
    }
}
