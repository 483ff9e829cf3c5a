//! Programs, macros and routines that move nothing, by what the user says of them: those whose text is not among the files.
//!
//! A name is compared as controllers do: case does not count (but in URScript it does), nor how many blanks stand between its words;
//! `_` is a character like any other. What is declared of a name counts only where no text of that name is among the files: a text counts.

use std::collections::BTreeMap;

/// Names that move nothing and leave frames and tools as they are.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct NoMotion {
    /// As they are written, by the form in which they are compared.
    names: BTreeMap<String, String>,
}

/// The form in which names are compared: upper case, one blank between words.
fn form(name: &str) -> String {
    name.split_whitespace().collect::<Vec<_>>().join(" ").to_uppercase()
}

impl NoMotion {
    /// These names; a text that [can be none](Self::is_name) is left out.
    ///
    /// ```
    /// use robot_programs::no_motion::NoMotion;
    /// let names = NoMotion::of(["Clear User Page", "GRIP_OPEN"]);
    /// assert!(names.has("CLEAR  USER PAGE") && names.has("grip_open") && !names.has("GRIP OPEN"));
    /// assert!(names.has_exactly("GRIP_OPEN") && !names.has_exactly("grip_open"));
    /// ```
    pub fn of<'a>(names: impl IntoIterator<Item = &'a str>) -> Self {
        let mut out = Self::default();
        out.add(names);
        out
    }

    /// Whether a text can be the name of a program, a macro or a routine: it has a letter or digit, and none of the marks that stand
    /// between names.
    pub fn is_name(name: &str) -> bool {
        name.chars().any(char::is_alphanumeric)
            && !name.contains(|c: char| c.is_control() || ",;()[]{}=\"'".contains(c))
    }

    /// Adds names.
    pub fn add<'a>(&mut self, names: impl IntoIterator<Item = &'a str>) {
        let named = names.into_iter().map(str::trim).filter(|n| Self::is_name(n));
        self.names.extend(named.map(|n| (form(n), n.to_string())));
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// The names as they are written, in a fixed order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.names.values().map(String::as_str)
    }

    /// Whether a name is one of them, case ignored.
    pub fn has(&self, name: &str) -> bool {
        !self.is_empty() && self.names.contains_key(&form(name))
    }

    /// Whether a name is one of them, letter by letter.
    pub fn has_exactly(&self, name: &str) -> bool {
        self.names.get(&form(name)).is_some_and(|own| own == name)
    }
}

#[cfg(test)]
mod tests;
