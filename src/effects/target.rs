//! Targets of effects in words.

use super::{DhParameter, Target};
use crate::robot::Robot;

impl Target {
    /// The axis whose position changes.
    pub fn axis(self) -> Option<usize> {
        match self {
            Self::Joint(axis) | Self::Coupled { to: axis, .. } => Some(axis),
            _ => None,
        }
    }

    /// As a reader knows it.
    pub fn text(self, robot: &Robot) -> String {
        match self {
            Self::Joint(axis) => robot.axis(axis).name.clone(),
            Self::Coupled { to, from } => format!("{}<-{}", robot.axis(to).name, robot.axis(from).name),
            Self::Link { joint, parameter } => format!("{}.{}", robot.joints[joint].name, parameter.text()),
            Self::Base => "base".into(),
            Self::Tool => "tool".into(),
            Self::Tcp => "tcp".into(),
            Self::Log => "log".into(),
        }
    }
}

impl DhParameter {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::A, Self::D, Self::Alpha, Self::Beta];
}
