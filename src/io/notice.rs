//! Notices: what the library reports besides its results, and to whom.
//!
//! The library prints nothing. It hands each [`Notice`] to the handler of the process, which [`handle_with`] sets once; without
//! a handler notices are dropped. The command line prints them on standard error.

use crate::error::{counted, shown};
use std::fmt;
use std::path::Path;
use std::sync::OnceLock;

/// Something that a user may want to know and that changes no result.
#[derive(Debug, Clone, Copy)]
pub enum Notice<'a> {
    /// An input was read whole.
    Read {
        /// Its name as messages show it.
        name: &'a str,
        /// Its size as it lies on the disk, bytes.
        bytes: usize,
        /// Its SHA-256 in hexadecimal digits.
        sha256: &'a str,
    },
    /// The outputs of an interrupted run were finished, or taken away.
    ClearedUp(&'a Path),
    /// Outputs are in place, but the system could not force the folder to the disk.
    NotSynced(&'a Path, &'a std::io::Error),
    /// The lock of a run that has ended was taken over; the text says which run held it.
    LockTakenOver(&'a Path, &'a str),
    /// These files, as messages show them, were replaced by outputs.
    Replaced(&'a [String]),
    /// So many programs of a folder are left out: these folders, as messages show them, hold results of an earlier rewrite.
    EarlierResults(usize, &'a [String]),
    /// This program, as messages show it, is a result of an earlier rewrite and is rewritten once more, as forced.
    RewrittenAgain(&'a str),
    /// A note of a rewritten program is damaged: its program is not recognised by it.
    DamagedNote(&'a Path),
}

impl Notice<'_> {
    /// Whether it has its own heading, so that it needs no `note:` before it.
    pub fn is_headed(&self) -> bool {
        matches!(self, Self::Replaced(_))
    }

    /// Whether only a user who asks for details wants to see it.
    pub fn is_detail(&self) -> bool {
        matches!(self, Self::Read { .. })
    }
}

impl fmt::Display for Notice<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Read { name, bytes, sha256 } => write!(f, "read {name}: {bytes} bytes, SHA-256 {sha256}"),
            Self::ClearedUp(folder) => write!(f, "{}: the remains of an interrupted run are removed", shown(folder)),
            Self::NotSynced(folder, e) => {
                write!(f, "{}: written, but a loss of power may undo it: cannot sync the folder: {e}", shown(folder))
            }
            Self::LockTakenOver(folder, by) => {
                write!(f, "{}: the lock of a run that has ended ({by}) is taken over", shown(folder))
            }
            Self::Replaced(files) => write!(f, "replaced: {}", files.join(", ")),
            Self::EarlierResults(programs, folders) => {
                let (result, are) = if *programs == 1 { ("is a result", "is") } else { ("are results", "are") };
                let (programs, folders) = (counted(*programs, "program"), folders.join(", "));
                write!(f, "{programs} in {folders} {result} of an earlier rewrite and {are} left out")
            }
            Self::RewrittenAgain(name) => {
                write!(
                    f,
                    "{name}: rewritten already, as a note in its folder shows; its offsets are now added a second time"
                )
            }
            Self::DamagedNote(path) => {
                write!(f, "{}: damaged, so the program that it describes cannot be recognised", shown(path))
            }
        }
    }
}

type Handler = fn(Notice);

static HANDLER: OnceLock<Handler> = OnceLock::new();

/// Sets the handler of the process. The first call counts; later ones change nothing.
pub fn handle_with(handler: Handler) {
    let _ = HANDLER.set(handler);
}

/// Hands a notice to the handler of the process.
pub fn report(notice: Notice) {
    if let Some(handler) = HANDLER.get() {
        handler(notice);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_notice_names_its_folder_and_only_reading_is_a_detail() {
        let taken = Notice::LockTakenOver(Path::new("done"), "process 7 on host");
        assert_eq!(taken.to_string(), "done: the lock of a run that has ended (process 7 on host) is taken over");
        assert!(!taken.is_detail());
        assert!(Notice::Read { name: "a.csv", bytes: 3, sha256: "00" }.is_detail());
    }
}
