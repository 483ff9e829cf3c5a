//! What a reader of a verdict should know. Code compares the variants; the words are for readers.

use crate::error::counted;
use crate::program::Assumed;
use crate::program::note::Waiting;

/// A remark on the comparison of two runs.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// The gap of a sum of axes counts as that of a joint alone.
    #[error("a gap that belongs to a sum of axes (`gap_of`) is treated as a gap of its joint alone")]
    JointsAlone,
    /// Parts of the program before that the program after does not have.
    #[error(
        "{} of the program before not found in the program after, and left out of the verdict",
        counted(*stretches, "part")
    )]
    StretchesLeftOut {
        /// How many.
        stretches: usize,
    },
    /// The two runs do not follow the same path.
    #[error(
        "the commanded paths differ in length by {:.2} mm of {:.1} mm: check that both programs follow the same path",
        off_m * 1e3, length_m * 1e3
    )]
    LengthsDiffer {
        /// By how much their lengths differ, m.
        off_m: f64,
        /// Length of the reference, m.
        length_m: f64,
    },
    /// Some moves of a vendor program state no speed.
    #[error(
        "not every move states its speed: the whole program runs at {} mm/s, because no other speed is given",
        speed_m_s * 1e3
    )]
    SpeedNotStated {
        /// Speed of the TCP, m/s.
        speed_m_s: f64,
    },
    /// Rows of joints have no times.
    #[error("the program contains no times: it runs at {} mm/s, because no other speed is given", speed_m_s * 1e3)]
    NoTimes {
        /// Speed of the TCP, m/s.
        speed_m_s: f64,
    },
    /// Moves whose speed the text does not tell.
    #[error("{} of unknown speed: {assumed}", counted(*moves, "move"))]
    UnknownSpeed {
        /// How many.
        moves: usize,
        /// At which speed they run.
        assumed: Assumed,
    },
    /// Moves of a program wait for frames or tools.
    #[error("{program}: {waiting}")]
    Waiting {
        /// Name of the program.
        program: String,
        /// What has to be given.
        waiting: Waiting,
    },
}

crate::io::in_words!(Note);
