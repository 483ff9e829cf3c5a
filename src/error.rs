//! One error vocabulary: what was found, where, what was expected, and which exit code it means.
//!
//! Everything that comes from outside is refused with a [`BadInput`] (exit code 2). A request that is well formed but
//! whose answer is no (a limit would be exceeded, `--check` differs) is an [`Error::Refused`] (exit code 1).

use std::fmt;
use std::path::Path;

/// Where in a file something was found. Lines and columns count from 1; a CSV column is the field number.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Place {
    pub file: String,
    pub line: Option<u64>,
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
    pub place: Place,
    pub found: String,
    pub expected: String,
}

impl fmt::Display for BadInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: found {}; expected {}", self.place, one_line(&self.found), one_line(&self.expected))
    }
}

impl std::error::Error for BadInput {}

/// Every way in which the library says no.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Unusable input: exit code 2.
    #[error("{0}")]
    BadInput(BadInput),
    /// The answer is no: exit code 1. One reason a line.
    #[error("{0}")]
    Refused(String),
    /// The operating system refused: exit code 2.
    #[error("{path}: cannot {action}: {source}")]
    Io { path: String, action: &'static str, source: std::io::Error },
    /// The reader of our output went away: quiet, exit code 0.
    #[error("the reader closed the pipe")]
    ClosedPipe,
    /// `--exit-code`: done, and no program needed a change: exit code 3.
    #[error("nothing needed a change")]
    Unchanged,
}

pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Bad input at a place.
    pub fn bad(place: Place, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::BadInput(BadInput { place, found: found.into(), expected: expected.into() })
    }

    /// An operating-system error on a path; a closed pipe keeps its own kind.
    pub fn io(path: impl AsRef<Path>, action: &'static str, source: std::io::Error) -> Self {
        if source.kind() == std::io::ErrorKind::BrokenPipe {
            return Self::ClosedPipe;
        }
        Self::Io { path: path.as_ref().display().to_string(), action, source }
    }

    /// Exit code of the contract: 0 for a closed pipe, 1 for a no, 2 for bad input, 3 for nothing to do where that was asked.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::ClosedPipe => 0,
            Self::Refused(_) => 1,
            Self::Unchanged => 3,
            Self::BadInput(_) | Self::Io { .. } => 2,
        }
    }
}

/// Text from outside on one line, without control characters, cut at a length that fits a message.
pub fn one_line(text: &str) -> String {
    const LONGEST: usize = 300;
    let mut out: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).take(LONGEST).collect();
    if text.chars().count() > LONGEST {
        out.push('…');
    }
    out
}

/// "1 row", "2 rows": a number of things, `what` being one of them.
pub fn counted(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

/// A file name as a message shows it: `-` is standard input.
pub fn shown(path: &Path) -> String {
    if path == Path::new("-") { "standard input".into() } else { path.display().to_string() }
}

/// A path that may be `-`.
pub fn is_stdio(path: &Path) -> bool {
    path == Path::new("-")
}
