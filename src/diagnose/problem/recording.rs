//! What the logs are: each kind is searched in its own way.

use super::forward::{LogData, Problem};

/// Kind of the logs of a problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Recording {
    /// Poses at which the arm stood still, with points: its geometry is one group, then gravity, then gaps by the side of approach.
    SettledPoses,
    /// Joints were measured, and no points: so precisely that a misfit always stays.
    JointSensors,
    /// Points along a motion.
    Motion,
}

impl Problem {
    /// Whether the arm stood still at every reading of every log.
    pub fn is_settled(&self) -> bool {
        self.logs.iter().all(|l| l.log.poses)
    }

    /// The logs in which the arm moves.
    pub fn motions(&self) -> impl Iterator<Item = &LogData> {
        self.logs.iter().filter(|l| !l.log.poses)
    }

    /// Kind of its logs.
    pub fn recording(&self) -> Recording {
        if !self.groups.iter().any(|g| g.sensor.is_length()) {
            Recording::JointSensors
        } else if self.is_settled() && self.logs.iter().all(|l| l.reflectors() > 0) {
            Recording::SettledPoses
        } else {
            Recording::Motion
        }
    }
}
