//! Where effects act, and the same in words.

use crate::robot::Robot;

/// A DH parameter of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum DhParameter {
    /// Distance along x.
    A,
    /// Distance along z.
    D,
    /// Angle about x.
    Alpha,
    /// Hayati's twist about y after alpha, for joints whose axes are nearly parallel.
    Beta,
}

impl DhParameter {
    /// As it stands after the dot of a target.
    pub fn text(self) -> &'static str {
        match self {
            Self::A => "a",
            Self::D => "d",
            Self::Alpha => "alpha",
            Self::Beta => "beta",
        }
    }
}

/// Where an effect acts. `Joint`, `to` and `from` count axes (joints with their own command); `joint` counts
/// [`crate::robot::Robot::joints`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Target {
    /// The joint of this axis.
    Joint(usize),
    /// A joint that another one moves.
    Coupled {
        /// Axis that is moved.
        to: usize,
        /// Axis that moves it.
        from: usize,
    },
    /// A kinematic parameter of a joint.
    Link {
        /// Number of the joint.
        joint: usize,
        /// The parameter.
        parameter: DhParameter,
    },
    /// The base of the robot.
    Base,
    /// The tool.
    Tool,
    /// The TCP, in the frame of the base.
    Tcp,
    /// The log as a whole.
    Log,
}

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
