//! What a reader of a joined log should know. Code compares the variants; the words are for readers.

use schemars::JsonSchema;
use serde::Serialize;

/// By which columns of the controller the path was computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum AlignedBy {
    /// Commands.
    Cmd,
    /// Encoders.
    Enc,
}

/// A remark on two clocks.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// Commands do not show the lag of the servo.
    #[error(
        "the offset contains the lag of the servo; encoders (enc_) of all joints in the controller's file would separate the two"
    )]
    ContainsServoLag,
    /// A clock may have stepped.
    #[error(
        "a step of a clock by {:.1} ms at about {at_tracker_s:.1} s of the tracker would explain {:.0} % of what the fit leaves: half of it is added to the interval of the offset",
        by_s.abs() * 1e3, share * 100.0
    )]
    Step {
        /// Tracker's time of the step, s.
        at_tracker_s: f64,
        /// By how much the offset rises there, s.
        by_s: f64,
        /// Share of the sum of squares that it explains.
        share: f64,
    },
    /// The offset is not known well.
    #[error("the motion determines the clock offset only within {:.1} ms: move faster, or longer", half_95_s * 1e3)]
    OffsetUncertain {
        /// Half of its 95 % interval, s.
        half_95_s: f64,
    },
}

crate::io::in_words!(Note);
