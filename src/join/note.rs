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
    /// The offset is not known well.
    #[error("the motion determines the clock offset only within {:.1} ms: move faster, or longer", half_95_s * 1e3)]
    OffsetUncertain {
        /// Half of its 95 % interval, s.
        half_95_s: f64,
    },
}

crate::io::in_words!(Note);
