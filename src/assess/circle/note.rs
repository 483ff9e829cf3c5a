//! What a reader of a circle's figures should know. Code compares the variants; the words are for readers.

use super::SMOOTHING_S;

/// A remark on an assessed circle.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// The program runs less than a revolution.
    #[error(
        "the program runs an arc of {travel_deg:.1} deg: its radius and centre depend on this arc alone, and reversals outside it are not assessed"
    )]
    Arc {
        /// Length of the arc, deg.
        travel_deg: f64,
    },
    /// The first of two revolutions, in which gaps close, is missing.
    #[error(
        "{revolutions:.2} revolutions: the joints leave the middle of their gaps in the assessed part, so the error before the first reversal of a joint is not its steady error (run two revolutions)"
    )]
    FewRevolutions {
        /// How many the program runs.
        revolutions: f64,
    },
    /// No joint reverses.
    #[error("no joint reverses in the assessed part")]
    NoReversal,
    /// Of one of the logs.
    #[error("{log}: {remark}")]
    Log {
        /// Name of the log.
        log: String,
        /// What is to know of it.
        remark: Remark,
    },
}

/// A remark on a log of a circle; follows its name.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Remark {
    /// A log without times.
    #[error("no `t_s`: errors of single rows, not averaged over {} s", SMOOTHING_S)]
    SingleRows,
    /// Part of the revolution was measured.
    #[error("covers {measured_deg:.1} of {assessed_deg:.1} deg of the revolution")]
    Covers {
        /// What was measured, deg.
        measured_deg: f64,
        /// What is assessed, deg.
        assessed_deg: f64,
    },
}

crate::io::in_words!(Note);
