//! One error vocabulary: what was found, where, and what was expected. Exit codes are the business of the command line.
//!
//! Everything that comes from outside is refused with a [`BadInput`]. A request that is well formed but whose answer is no (a
//! limit would be exceeded) is an [`Error::Refused`] that holds the domain's own type ([`crate::rewrite::Refusal`],
//! [`crate::assess::bidirectional::Refusal`]). A mistake of this library is an [`Error::Internal`].

#![warn(missing_docs)]

use crate::name::text_of;
pub use robot_programs::error::{BadInput, Place, one_line};
use std::path::Path;

/// Every way in which the library says no.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Unusable input.
    #[error("{0}")]
    BadInput(BadInput),
    /// A header with other names or another separator than ours, which a column map may read.
    #[error("{0}")]
    UnknownHeader(BadInput),
    /// A setting that the caller chose cannot be used; [`Error::setting`] makes it.
    #[error("setting `{name}`: found {}; expected {}", one_line(found), one_line(expected))]
    Setting {
        /// Its name in this library.
        name: &'static str,
        /// Its value, and what is wrong with it.
        found: String,
        /// What is possible.
        expected: String,
    },
    /// An error that these settings can mend; [`Error::mended_by`] makes it.
    #[error("{source}")]
    MendedBy {
        /// Names of the settings.
        settings: &'static [&'static str],
        /// The error.
        source: Box<Error>,
    },
    /// A program that this tool has rewritten already.
    #[error("{0}")]
    RewrittenAlready(BadInput),
    /// The answer is no. One reason a line.
    #[error("{0}")]
    Refused(Box<dyn std::error::Error + Send + Sync>),
    /// The operating system refused.
    #[error("{path}: cannot {action}: {source}")]
    Io {
        /// File as messages show it.
        path: String,
        /// What was tried: `read`, `write`.
        action: &'static str,
        /// What the system answered.
        source: std::io::Error,
    },
    /// A step failed, and what was done before it could not be taken back.
    #[error("{source}; not as they were before: {files}; the next run in this folder restores them")]
    Unfinished {
        /// Files that are not as they were before.
        files: String,
        /// The step that failed.
        source: Box<Error>,
    },
    /// A mistake of this library: nothing that the input or the user could mend.
    #[error("internal error, please report it: cannot {action}: {source}")]
    Internal {
        /// What was tried.
        action: &'static str,
        /// Why it failed.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

/// The result of a function of this crate.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Bad input at a place.
    pub fn bad(place: Place, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::BadInput(BadInput { place, found: found.into(), expected: expected.into() })
    }

    /// A header that is not ours.
    pub fn unknown_header(place: Place, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::UnknownHeader(BadInput { place, found: found.into(), expected: expected.into() })
    }

    /// A setting, by its name in this library, with which the job cannot be done.
    pub fn setting(name: &'static str, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::Setting { name, found: found.into(), expected: expected.into() }
    }

    /// The same error with the settings that can mend it.
    pub fn mended_by(self, settings: &'static [&'static str]) -> Self {
        Self::MendedBy { settings, source: Box::new(self) }
    }

    /// Input or a setting that cannot be used.
    pub fn is_bad_input(&self) -> bool {
        match self {
            Self::BadInput(_) | Self::UnknownHeader(_) | Self::Setting { .. } => true,
            Self::MendedBy { source, .. } => source.is_bad_input(),
            _ => false,
        }
    }

    /// The reader of our output went away.
    pub fn is_closed_pipe(&self) -> bool {
        matches!(self, Self::Io { source, .. } if source.kind() == std::io::ErrorKind::BrokenPipe)
    }

    /// A mistake of this library while it does `action`.
    pub fn internal(action: &'static str, source: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Self {
        Self::Internal { action, source: source.into() }
    }

    /// An operating-system error on a path.
    pub fn io(path: impl AsRef<Path>, action: &'static str, source: std::io::Error) -> Self {
        Self::io_of(text_of(path.as_ref()), action, source)
    }

    /// The same on a file whose name is text already.
    pub fn io_of(path: impl Into<String>, action: &'static str, source: std::io::Error) -> Self {
        Self::Io { path: path.into(), action, source }
    }
}

impl From<robot_programs::Error> for Error {
    fn from(e: robot_programs::Error) -> Self {
        match e {
            robot_programs::Error::BadInput(bad) => Self::BadInput(bad),
            robot_programs::Error::Refused(why) => Self::Refused(why.into()),
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
