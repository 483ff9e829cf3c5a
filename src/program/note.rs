//! What a reader of a vendor program's path should know: which moves are not in it, and what was assumed. Code compares the variants;
//! the words are for readers.

use super::Assumed;
use crate::error::counted;

/// A remark on the path of a program.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// Moves to a position that is not known.
    #[error("{} of {all} to an unknown position are left out", counted(*left, "move"))]
    LeftOut {
        /// How many.
        left: usize,
        /// All moves.
        all: usize,
    },
    /// What has to be given for moves that are not in the path.
    #[error("{0}")]
    Waiting(Waiting),
    /// Ways whose start is not known.
    #[error(
        "{} from a position that is unknown or not determined: interpolated in the joints",
        counted(*ways, "way")
    )]
    UnknownStart {
        /// How many.
        ways: usize,
    },
    /// Moves whose speed the text does not tell.
    #[error("{} of unknown speed: {assumed}", counted(*moves, "move"))]
    UnknownSpeed {
        /// How many.
        moves: usize,
        /// At which speed they run.
        assumed: Assumed,
    },
}

/// Frames and tools that moves wait for: "tool `tGun` (3 moves)".
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("not known: {}: give it in a file of frames and tools; `rewrite` can print a template", .0.join(", "))]
pub struct Waiting(pub Vec<String>);
