//! What reading or editing a program can fail with: place, what was found, what is expected.

use std::fmt;

/// Where in a file something was found. Lines and columns count from 1; a CSV column is the field number.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Place {
    /// Name of the file; empty where there is none.
    pub file: String,
    /// Line, from 1.
    pub line: Option<u64>,
    /// Column, from 1.
    pub column: Option<u64>,
}

impl Place {
    /// A whole file.
    pub fn file(name: impl Into<String>) -> Self {
        Self { file: name.into(), line: None, column: None }
    }

    /// A line of a file.
    pub fn line(name: impl Into<String>, line: u64) -> Self {
        Self { file: name.into(), line: Some(line), column: None }
    }

    /// A field of a line of a file.
    pub fn field(name: impl Into<String>, line: u64, column: u64) -> Self {
        Self { file: name.into(), line: Some(line), column: Some(column) }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.file.is_empty() { "input" } else { &self.file })?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
            if let Some(column) = self.column {
                write!(f, ":{column}")?;
            }
        }
        Ok(())
    }
}

/// Input that cannot be used: place, what was found, what is expected.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BadInput {
    /// Where.
    pub place: Place,
    /// What stands there.
    pub found: String,
    /// What may stand there, and what to do.
    pub expected: String,
}

/// A number for a message: with an exponent where it would be a long row of zeros.
///
/// ```
/// use robot_programs::error::in_few_digits;
/// assert_eq!((in_few_digits(0.25).as_str(), in_few_digits(1e-305).as_str()), ("0.25", "1e-305"));
/// ```
pub fn in_few_digits(value: f64) -> String {
    let plain = value == 0.0 || (1e-9..1e15).contains(&value.abs());
    if plain { value.to_string() } else { format!("{value:e}") }
}

impl fmt::Display for BadInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: found {}; expected {}", self.place, one_line(&self.found), one_line(&self.expected))
    }
}

impl std::error::Error for BadInput {}

/// Why a program is not read or an edit is not written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The text is not what it must be.
    #[error("{0}")]
    BadInput(BadInput),
    /// The format has no legal way to say the edit. One reason a line.
    #[error("{0}")]
    Refused(String),
    /// The operating system did not deliver the bytes.
    #[error("{name}: cannot read: {source}")]
    Io {
        /// Name of the file.
        name: String,
        /// The error of the operating system.
        source: std::io::Error,
    },
}

/// A result with the error of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Bad input at a place.
    pub fn bad(place: Place, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::BadInput(BadInput { place, found: found.into(), expected: expected.into() })
    }
}

/// Whether a terminal or a page obeys a character instead of showing it: controls, line separators, marks of direction and of no
/// width.
pub fn is_obeyed(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61C}' | '\u{200B}'..='\u{200F}' | '\u{2028}'..='\u{202E}' | '\u{2060}'..='\u{206F}' | '\u{FEFF}')
}

/// Text from outside on one line, without characters that a terminal obeys, cut at a length that fits a message.
pub fn one_line(text: &str) -> String {
    const LONGEST: usize = 300;
    let mut out: String = text.chars().map(|c| if is_obeyed(c) { ' ' } else { c }).take(LONGEST).collect();
    if text.chars().count() > LONGEST {
        out.push('…');
    }
    out
}
