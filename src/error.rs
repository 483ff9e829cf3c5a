//! One error vocabulary: what was found, where, what was expected, and which exit code it means.
//!
//! Everything that comes from outside is refused with a [`BadInput`] (exit code 2). A request that is well formed but
//! whose answer is no (a limit would be exceeded, `--check` differs) is an [`Error::Refused`] (exit code 1).

use crate::name::text_of;
pub use robot_programs::error::{BadInput, Place, one_line};
use std::path::Path;

/// Every way in which the library says no.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Unusable input: exit code 2.
    #[error("{0}")]
    BadInput(BadInput),
    /// A program that this tool has rewritten already: exit code 2.
    #[error("{0}")]
    RewrittenAlready(BadInput),
    /// The answer is no: exit code 1. One reason a line.
    #[error("{0}")]
    Refused(String),
    /// The operating system refused: exit code 2.
    #[error("{path}: cannot {action}: {source}")]
    Io { path: String, action: &'static str, source: std::io::Error },
    /// The reader of our output went away: quiet, exit code 0.
    #[error("the reader closed the pipe")]
    ClosedPipe,
    /// A step failed, and what was done before it could not be taken back: exit code 4.
    #[error("{source}; not as they were before: {files}; the next run in this folder restores them")]
    Unfinished { files: String, source: Box<Error> },
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
        Self::io_of(text_of(path.as_ref()), action, source)
    }

    /// The same on a file whose name is text already.
    pub fn io_of(path: impl Into<String>, action: &'static str, source: std::io::Error) -> Self {
        if source.kind() == std::io::ErrorKind::BrokenPipe {
            return Self::ClosedPipe;
        }
        Self::Io { path: path.into(), action, source }
    }

    /// Exit code of the contract: 0 for a closed pipe, 1 for a no, 2 for bad input (nothing was written), 3 for nothing to do where
    /// that was asked, 4 for a commit that could neither be finished nor taken back.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::ClosedPipe => 0,
            Self::Refused(_) => 1,
            Self::Unchanged => 3,
            Self::Unfinished { .. } => 4,
            Self::BadInput(_) | Self::RewrittenAlready(_) | Self::Io { .. } => 2,
        }
    }
}

impl From<robot_programs::Error> for Error {
    fn from(e: robot_programs::Error) -> Self {
        match e {
            robot_programs::Error::BadInput(bad) => Self::BadInput(bad),
            robot_programs::Error::Refused(why) => Self::Refused(why),
            robot_programs::Error::Io { name, source } => Self::io_of(name, "read", source),
        }
    }
}

/// "1 row", "2 rows": a number of things, `what` being one of them.
pub fn counted(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

/// A file name as messages and documents show it ([`crate::name`]): `-` is standard input.
pub fn shown(path: &Path) -> String {
    if path == Path::new("-") { "standard input".into() } else { text_of(path) }
}

/// A path that may be `-`.
pub fn is_stdio(path: &Path) -> bool {
    path == Path::new("-")
}
