//! What a reader of a predicted log should know. Code compares the variants; the words are for readers.

use super::timing::SHORTEST_S;
use crate::effects::Idle;
use crate::program::note::Note as OfProgram;

/// A remark on a predicted log.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// An effect of the model does nothing.
    #[error("{0}")]
    Idle(Idle),
    /// What is not in the path of the program, and what was assumed.
    #[error(transparent)]
    Program(#[from] OfProgram),
    /// A column of the log has no counterpart.
    #[error("column {column} left out: the robot file has no such reflector")]
    NoReflector {
        /// Name of the column, on one line.
        column: String,
    },
    /// The rows of the log are settled poses.
    #[error("no t_s: rows are settled poses, in which the servo has corrected its error")]
    SettledPoses,
    /// The largest speed of a joint holds segments.
    #[error("{segments} segments take longer because max_speed of a joint limits them")]
    HeldByJoint {
        /// How many.
        segments: usize,
    },
    /// Segments whose time is not known.
    #[error(
        "{segments} segments move joints of unknown max_speed while the TCP stands still: they take {} ms each",
        SHORTEST_S * 1e3
    )]
    UnknownSpeed {
        /// How many.
        segments: usize,
    },
}

crate::io::in_words!(Note);
