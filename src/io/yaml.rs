//! YAML documents: parsed with places, so that a refusal names file and line.

use super::memory;
use crate::error::{Error, Place, Result};
use serde::{Serialize, de::DeserializeOwned};

/// A document has at most so many bytes.
const LARGEST: u64 = 64 << 20;
/// Collections within collections beyond which a document is refused: a parser may take a time that grows with their square.
const DEEPEST: usize = 64;

/// The line on which brackets, or dashes of lists within lists, go too deep. Brackets in words may count as well: no document of ours has
/// so many that are never closed.
fn too_deep(text: &str) -> Option<u64> {
    let mut depth = 0usize;
    for (k, line) in text.lines().enumerate() {
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
        if dashes > DEEPEST {
            return Some(k as u64 + 1);
        }
    }
    None
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
        if self.text.trim().is_empty() {
            return Err(Error::bad(Place::file(self.name), "an empty file", what));
        }
        memory::require_size(self.name, self.text.len() as u64, LARGEST)?;
        if let Some(line) = too_deep(self.text) {
            return Err(Error::bad(Place::line(self.name, line), format!("more than {DEEPEST} levels"), what));
        }
        serde_yaml::from_str(self.text).map_err(|e| {
            let place = match e.location() {
                Some(l) => Place::field(self.name, l.line() as u64, l.column() as u64),
                None => Place::file(self.name),
            };
            // the scanner's own words begin as ours do
            let text = e.to_string();
            Error::bad(place, text.strip_prefix("found ").unwrap_or(&text), what)
        })
    }

    /// The same for a document of one schema; another kind of document is called what it is, not by its first strange key.
    pub fn parse_schema<T: DeserializeOwned>(&self, what: &str, schema: &str) -> Result<T> {
        self.parse(&format!("{what} (schema {schema})")).map_err(|e| {
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
        Err(Error::bad(self.place(&[found]), format!("schema `{found}`"), format!("schema `{expected}`")))
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
        for text in [deep("[", "]"), deep("{a: ", "}"), format!("a:\n  {}1\n", "- ".repeat(40_000))] {
            let start = std::time::Instant::now();
            let refused = Document { name: "nest.yaml", text: &text }.parse::<serde_yaml::Value>("a document");
            assert!(refused.unwrap_err().to_string().contains("more than 64 levels"));
            assert!(start.elapsed().as_secs_f64() < 1.0);
        }
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
