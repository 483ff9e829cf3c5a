//! How a command ends, and the exit code of each error.

use crate::error::Error;

/// How a command that did what it was asked for ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Finished {
    Done,
    /// `--exit-code`, and no program needed a change.
    NothingChanged,
}

impl Finished {
    /// 0, or 3 where nothing needed a change and that was asked.
    pub fn code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::NothingChanged => 3,
        }
    }
}

/// Exit code of an error: 0 for a reader that has gone, 1 for a no, 2 for bad input (nothing was written), 4 for a commit that could
/// neither be finished nor taken back, 70 for a mistake of the program itself.
pub fn code(error: &Error) -> u8 {
    match error {
        Error::ClosedPipe => 0,
        Error::Refused(_) => 1,
        Error::BadInput(_) | Error::RewrittenAlready(_) | Error::Io { .. } => 2,
        Error::Unfinished { .. } => 4,
        Error::Internal { .. } => 70,
    }
}
