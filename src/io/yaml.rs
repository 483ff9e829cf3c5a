//! YAML documents: parsed with places, so that a refusal names file and line.

use crate::error::{Error, Place, Result};
use serde::{Serialize, de::DeserializeOwned};

/// A YAML text and its name, for parsing and for finding the line of a value again.
pub struct Document<'a> {
    pub name: &'a str,
    pub text: &'a str,
}

impl Document<'_> {
    /// Parses the document; an error names line and column and what was expected there.
    pub fn parse<T: DeserializeOwned>(&self, what: &str) -> Result<T> {
        if self.text.trim().is_empty() {
            return Err(Error::bad(Place::file(self.name), "an empty file", what));
        }
        serde_yaml::from_str(self.text).map_err(|e| {
            let place = match e.location() {
                Some(l) => Place::field(self.name, l.line() as u64, l.column() as u64),
                None => Place::file(self.name),
            };
            Error::bad(place, e.to_string(), what)
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
