//! Cartesian targets: how languages write a pose, which frame and tool its numbers belong to, and which of the joints that reach
//! it are meant.
//!
//! A pose is three lengths and the turn, in one of four forms. All are the same rotation `Rz(c) Ry(b) Rx(a)`, a unit quaternion
//! or axis times angle; coordinates of a changed pose are those nearest to the ones that stand there, so that numbers that need
//! not change do not.
//!
//! Parts: `form`: the forms of a pose; `frame`: frames and tools.
//!
//! References: KUKA System Software, Operating and Programming Instructions for System Integrators (A, B, C; status and turn);
//! ABB, RAPID Instructions, Functions and Data types (`orient`, `confdata`); FANUC operator's manuals (W, P, R; configuration);
//! Yaskawa NX100, Instructions for Relative Job function, section 4.1 (`RCONF`); Universal Robots, The URScript Programming Language
//! (poses).

mod form;
mod frame;

use super::reason::Reason;
pub use form::{PoseForm, Quantity};
pub use frame::Frame;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use std::fmt;

/// A Cartesian target.
#[derive(Debug, Clone, Default)]
pub struct PoseGoal {
    /// Index into [`super::Script::targets`] of the numbers, where they can be written; `None`: they are not plain numbers.
    pub target: Option<usize>,
    /// Position of the TCP in the frame, m.
    pub position_m: Vector3<f64>,
    /// `None`: the format gives no orientation.
    pub rotation: Option<UnitQuaternion<f64>>,
    /// Frame in which the numbers are given, and tool that goes there.
    pub frame: Frame,
    /// Tool in which the pose is given.
    pub tool: Frame,
    /// Joints that are meant.
    pub solution: Solution,
    /// The controller takes `solution` as an order on this move; else it only tells how the point was taught.
    pub binding: bool,
    /// Whether it does so on this move is not certain (`binding` is `true` then): where `solution` is not the one nearest to the joints
    /// before, the joints are not known.
    pub unsure: bool,
    /// What the program adds to the numbers of `target`; `None`: nothing.
    pub shift: Option<Box<Shift>>,
    /// Of an arc through three points: the one on its way, in the frame of the goal, m.
    pub via_m: Option<Vector3<f64>>,
    /// External axes of the robot that the target places itself; boxed, as few do.
    pub external: Option<Box<[OfAxis]>>,
}

/// Where a target puts an external axis. Its number is one of the target's, after those of the pose, in the same order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OfAxis {
    /// Axis of the robot.
    pub axis: usize,
    /// rad or m.
    pub si: f64,
}

/// A displacement of a target: the pose that is meant is `before * numbers * after`.
#[derive(Debug, Clone, PartialEq)]
pub struct Shift {
    /// Left of the numbers.
    pub before: Isometry3<f64>,
    /// Right of the numbers.
    pub after: Isometry3<f64>,
}

impl Shift {
    /// Along the axes of the frame, m.
    pub fn in_frame(by: Vector3<f64>) -> Self {
        Self { before: Translation3::from(by).into(), after: Isometry3::identity() }
    }

    /// Along the axes of the pose itself.
    pub fn of_pose(by: Isometry3<f64>) -> Self {
        Self { before: Isometry3::identity(), after: by }
    }
}

impl PoseGoal {
    /// Whether its frame or its tool depends on what the program does while it runs.
    pub fn is_computed(&self) -> bool {
        self.frame.is_computed() || self.tool.is_computed()
    }

    /// External axes that the target places.
    pub fn placed(&self) -> &[OfAxis] {
        self.external.as_deref().unwrap_or_default()
    }

    /// The pose as it is written, in its frame.
    pub fn pose(&self) -> Option<Isometry3<f64>> {
        Some(Isometry3::from_parts(self.position_m.into(), self.rotation?))
    }

    /// The pose that numbers of the target mean.
    pub fn meant(&self, numbers: &Isometry3<f64>) -> Isometry3<f64> {
        self.shift.as_ref().map_or(*numbers, |s| s.before * numbers * s.after)
    }

    /// The numbers of the target for a pose that is meant.
    pub fn numbers(&self, meant: &Isometry3<f64>) -> Isometry3<f64> {
        self.shift.as_ref().map_or(*meant, |s| s.before.inverse() * meant * s.after.inverse())
    }

    /// This goal displaced.
    pub fn shifted(mut self, shift: Shift) -> Self {
        let numbers = Isometry3::from_parts(self.position_m.into(), self.rotation.unwrap_or_default());
        let meant = shift.before * numbers * shift.after;
        self.position_m = meant.translation.vector;
        self.rotation = self.rotation.map(|_| meant.rotation);
        self.shift = Some(Box::new(match self.shift.take() {
            Some(own) => Shift { before: shift.before * own.before, after: own.after * shift.after },
            None => shift,
        }));
        self
    }

    /// Why the frame or the tool cannot be known by any file of a user.
    pub fn unknown(&self) -> Option<&Reason> {
        [&self.frame, &self.tool].into_iter().find_map(Frame::unknown)
    }
}

/// Which of the joints that reach a pose are meant.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Solution {
    /// Those on the branch on which the robot stands.
    #[default]
    Same,
    /// Those next to these, rad or m.
    Near(Vec<f64>),
    /// Those with this configuration.
    Configured(Configuration),
}

/// A configuration as its maker writes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Configuration {
    /// KRL `S` and `T`. S: bit 0 the wrist's centre behind axis 1 (overhead), bit 1 the elbow, bit 2 A5 below zero. T: a bit
    /// for each of A1 to A6 below zero.
    Kuka {
        /// `S`: bits of the arm's form.
        status: Option<u8>,
        /// `T`: bits of the signs of the axes.
        turn: Option<u8>,
    },
    /// RAPID `[cf1, cf4, cf6, cfx]`: quarters of a turn of axes 1, 4, 6; cfx: wrist behind axis 1 (4), behind the lower arm
    /// (2), axis 5 negative (1).
    Abb {
        /// `cf1`, `cf4`, `cf6`: quarter turns of axes 1, 4 and 6.
        quarters: [i32; 3],
        /// `cfx`: the form of the arm, 0 to 7.
        cfx: i32,
    },
    /// `'N U T, 0, 0, 0'`: wrist flipped, elbow up, in front; turns of J1, J4, J6.
    Fanuc {
        /// `F` (flip), else `N` (no flip).
        flip: bool,
        /// `U` (up), else `D` (down).
        up: bool,
        /// `T` (toward the front), else `B` (back).
        front: bool,
        /// Turns of J1, J4 and J6.
        turns: [i32; 3],
    },
    /// `///RCONF`: no-flip, lower arm, rear, and R, T, S beyond half a turn.
    Yaskawa {
        /// First number of `///RCONF`: no flip.
        no_flip: bool,
        /// Second number: the elbow below.
        lower: bool,
        /// Third number: the rear.
        rear: bool,
        /// R, T and S are 180 deg or more.
        beyond: [bool; 3],
    },
}

/// In the words of its language: `S 2, T 34`, `[0,-1,0,1]`, `'N U T, 0, 0, 0'`, `RCONF 1,0,0,0,0,0`.
impl fmt::Display for Configuration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Kuka { status, turn } => {
                let of = |name: &str, v: Option<u8>| v.map(|v| format!("{name} {v}"));
                let all: Vec<String> = of("S", status).into_iter().chain(of("T", turn)).collect();
                f.write_str(&all.join(", "))
            }
            Self::Abb { quarters: [a, b, c], cfx } => write!(f, "[{a},{b},{c},{cfx}]"),
            Self::Fanuc { flip, up, front, turns: [a, b, c] } => {
                let letter = |is: bool, yes: char, no: char| if is { yes } else { no };
                let [wrist, elbow, side] = [letter(flip, 'F', 'N'), letter(up, 'U', 'D'), letter(front, 'T', 'B')];
                write!(f, "'{wrist} {elbow} {side}, {a}, {b}, {c}'")
            }
            Self::Yaskawa { no_flip, lower, rear, beyond } => {
                let [r, t, s] = beyond.map(u8::from);
                let [flip, elbow, side] = [no_flip, lower, rear].map(u8::from);
                write!(f, "RCONF {flip},{elbow},{side},{r},{t},{s}")
            }
        }
    }
}

impl Configuration {
    /// What it says of the arm's posture alone, without turns, as a number of no other meaning; `None`: nothing.
    pub fn posture(&self) -> Option<u8> {
        let bits = |bits: [bool; 3]| bits.iter().enumerate().map(|(k, b)| u8::from(*b) << k).sum();
        match *self {
            Self::Kuka { status, .. } => status,
            // controllers of robots without cfx write 0
            Self::Abb { cfx, .. } => u8::try_from(cfx).ok(),
            Self::Fanuc { flip, up, front, .. } => Some(bits([flip, up, front])),
            Self::Yaskawa { no_flip, lower, rear, .. } => Some(bits([no_flip, lower, rear])),
        }
    }
}
