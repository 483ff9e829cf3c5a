//! What a reader of a gaps document should know, as data: one enum for each kind of identification. Code compares the variants; the
//! words are for readers, with values in the units of documents (`unit`).
//!
//! Files beside, by identification: [`machine`] (all logs), [`static_test`], [`path`], [`deadzone`], [`screw`], [`scalar`] (ballbar, dial
//! gauge), [`mod@line`] (positions of a line); [`commands`]: what is wrong with the commands of a log.

pub mod commands;
pub mod deadzone;
pub mod line;
pub mod machine;
pub mod path;
pub mod scalar;
pub mod screw;
pub mod static_test;
mod unit;

use super::Distrust;
use crate::robot::gap_of::JointsAlone;

/// A remark on gaps.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// A note as a gaps file holds it.
    #[error("{0}")]
    Read(String),
    /// Why the gaps cannot be trusted.
    #[error("{0}")]
    Distrust(Distrust),
    /// The method takes the gap of a sum of axes for that of a joint alone.
    #[error("{0}")]
    JointsAlone(JointsAlone),
    /// The centre of a ballbar was not given and is estimated.
    #[error(
        "{log}: centre of the ballbar estimated at {:.3}, {:.3}, {:.3} mm",
        centre_m[0] * 1e3, centre_m[1] * 1e3, centre_m[2] * 1e3
    )]
    BallbarCentre {
        /// Name of the log.
        log: String,
        /// Centre in the base frame of the robot, m.
        centre_m: [f64; 3],
    },
    /// Of commands that are not known well.
    #[error(transparent)]
    Commands(#[from] commands::Note),
    /// Of an estimate of all logs of a machine.
    #[error(transparent)]
    Machine(#[from] machine::Note),
    /// Of a path.
    #[error(transparent)]
    Path(#[from] path::Note),
    /// Of a test of bidirectional dwells.
    #[error(transparent)]
    Static(#[from] static_test::Note),
    /// Of a ballbar or a dial gauge.
    #[error(transparent)]
    Scalar(#[from] scalar::Note),
    /// Of two gaps in series.
    #[error("{joint}: {remark}")]
    Screw {
        /// Name of the joint.
        joint: String,
        /// What is to know of it.
        remark: screw::Remark,
    },
    /// Of growing sweeps.
    #[error("{joint}: {remark}")]
    Deadzone {
        /// Name of the joint.
        joint: String,
        /// What is to know of it.
        remark: deadzone::Remark,
    },
    /// Of the positions of a line, measured from both sides.
    #[error(transparent)]
    Line(#[from] line::Note),
}

impl Note {
    /// The name of the log that the note is about and begins with, where it is about one.
    pub fn log_mut(&mut self) -> Option<&mut String> {
        match self {
            Self::BallbarCentre { log, .. } => Some(log),
            Self::Commands(note) => note.log_mut(),
            Self::Machine(note) => note.log_mut(),
            Self::Path(note) => note.log_mut(),
            _ => None,
        }
    }
}

crate::io::in_words!(Note);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_note_on_a_log_names_it_and_one_on_a_joint_does_not() {
        let mut note = Note::BallbarCentre { log: "runs/bar.csv".into(), centre_m: [0.5, 0.0, 0.25] };
        *note.log_mut().unwrap() = "bar.csv".into();
        assert_eq!(note.to_string(), "bar.csv: centre of the ballbar estimated at 500.000, 0.000, 250.000 mm");
        assert!(Note::from(scalar::Note::NotSeen { joint: "A1".into() }).log_mut().is_none());
    }

    #[test]
    fn a_document_holds_the_words() {
        let note = Note::from(scalar::Note::NotSeen { joint: "A1".into() });
        assert_eq!(serde_json::to_value(&note).unwrap(), "A1: not determined: the joint does not change this reading");
    }
}
