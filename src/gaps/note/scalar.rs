//! Notes of the identification by a ballbar or a dial gauge.

use crate::robot::JointKind;

/// A remark on gaps by a scalar reading. Values of joints are in rad or m, as `kind` says.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// The last round still moved the values.
    #[error("the fit did not settle: intervals hold what its last round still moved")]
    NotSettled,
    /// The joint does not change the reading.
    #[error("{joint}: not determined: the joint does not change this reading")]
    NotSeen {
        /// Name of the joint.
        joint: String,
    },
    /// The reading does not determine the gap.
    #[error(
        "{joint}: not determined by this reading (standard deviation {:.4} {}): the joint hardly changes the reading, or changes it as other joints do",
        kind.to_user_unit(*sigma), kind.unit()
    )]
    NotDetermined {
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Standard deviation of its half gap, rad or m.
        sigma: f64,
    },
    /// A gap that is clearly negative.
    #[error(
        "{joint}: {:.5} {}, clearly below zero, which no gap can be: check the sign of the reading and the clocks of the columns",
        kind.to_user_unit(*half_gap), kind.unit()
    )]
    BelowZero {
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Half gap that was found, rad or m.
        half_gap: f64,
    },
}
