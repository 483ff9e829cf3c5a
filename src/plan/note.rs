//! What a reader of a plan should know, and why no motion is enough. Code compares the variants; the words are for readers.

use super::reasons::Alike;
use crate::diagnose::search::MOST_EFFECTS;

/// A remark on a plan.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// An alternative has more effects than a diagnosis looks for.
    #[error(
        "a diagnosis searches for at most {} effects: put the larger alternative into a model and compare",
        MOST_EFFECTS
    )]
    ManyEffects,
    /// The program contains two motions.
    #[error("no single motion is enough: one program contains two motions, one after the other")]
    TwoMotions,
    /// An effect outside the alternatives comes near.
    #[error("the motion decides between the alternatives, but the effect may be confused with another one: {effect}")]
    OtherEffect {
        /// The effect and where it stands.
        effect: String,
    },
    /// The evidence is too weak.
    #[error("evidence grows with time: {times:.0} times the duration (or less noise) would be enough")]
    MoreTime {
        /// How many times the duration.
        times: f64,
    },
}

/// Why no motion is enough.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Reason {
    /// The diagnosis has decided.
    #[error("no round of the diagnosis has a set of two or more: there is nothing to decide")]
    NothingToDecide,
    /// No motion can be made.
    #[error("no motion of the library fits into the duration and the ranges of the joints")]
    NoMotion,
    /// One alternative contains the other.
    #[error("one alternative is a special case of the other, whatever the log")]
    SpecialCase,
    /// Two alternatives look the same.
    #[error("{first} and {second}: {why}")]
    Alike {
        /// Name of one of them.
        first: String,
        /// Name of the other.
        second: String,
        /// Why they look the same.
        why: Alike,
    },
    /// Effects that no motion shows.
    #[error(
        "{} cannot be detected by any motion: {}",
        effects.join(", "),
        if *frame_known { "they do not move the TCP" } else { "the estimated frame can move in the same way; measure the base" }
    )]
    Hidden {
        /// The effects, each with where it stands.
        effects: Vec<String>,
        /// The frame between base and tracker is known.
        frame_known: bool,
    },
}

crate::io::in_words!(Note, Reason);
