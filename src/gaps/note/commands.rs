//! Notes on commands that are not known well enough.

use crate::robot::JointKind;

/// A remark on the commands of a log. Values are in rad or m, as `kind` says.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// The commands jitter and were smoothed.
    #[error(
        "{log}: the commands of {joint} jitter with a standard deviation of {:.6} {unit}, as encoder readings do; they were smoothed, and an \
         error of {:.6} {unit} is left in them. Log the commanded positions instead of the measured ones",
        kind.to_user_unit(*noise), kind.to_user_unit(*left), unit = kind.unit()
    )]
    Smoothed {
        /// Name of the log.
        log: String,
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Standard deviation of the noise, rad or m.
        noise: f64,
        /// Root mean square error after smoothing, rad or m.
        left: f64,
    },
    /// The commands do not show the friction of a joint.
    #[error(
        "{joint}: friction after reversals is not determined, because the commands are known to {:.6} {} only",
        kind.to_user_unit(*left), kind.unit()
    )]
    FrictionUnknown {
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Root mean square error of the commands, rad or m.
        left: f64,
    },
}

impl Note {
    /// The log that the note begins with.
    pub(super) fn log_mut(&mut self) -> Option<&mut String> {
        match self {
            Self::Smoothed { log, .. } => Some(log),
            Self::FrictionUnknown { .. } => None,
        }
    }
}
