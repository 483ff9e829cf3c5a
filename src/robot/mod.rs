//! A robot: a serial chain of revolute and prismatic joints in any mix, its base, tool and limits.
//!
//! Modules:
//! - `serial`: the robot; `joint`: its parts.
//! - [`mod@file`]: the robot file (YAML, degrees and millimetres) to and from this module's types (SI), with every refusal.
//! - [`chain`]: forward kinematics and the analytic Jacobian (Zhang (2023) equations 2-5; Craig's convention too).
//! - [`inverse`]: the damped numerical inverse for any subset of joints; reports why it stopped.
//! - [`arm`]: all joint vectors of a pose, in closed form for the arms of most makers.
//! - [`frames`]: frames and tools by the controller's names.
//! - [`mod@write`]: a robot back to its file, by `lines` one line for each joint.
//! - [`urdf`]: a robot from a URDF file, by [`dh`]: parameters of given joint axes.
//! - [`table`]: a robot from the Denavit-Hartenberg table of a data sheet.
//! - [`plausible`]: whether the numbers can be those of a machine.
//! - `flip`: which of two wrists the maker calls flipped.
//! - [`gap_of`]: joints whose gap belongs to a sum of axes.
//! - [`fingerprint`]: SHA-256 of the robot's numbers, so that a compensator cannot meet another robot.
//!
//! Joint vectors `q` hold one value per *axis*, that is, per joint with its own command, in file order, in radians
//! or metres. A joint that follows another one has no entry.

#![warn(missing_docs)]

pub mod arm;
pub mod chain;
pub mod dh;
pub mod file;
pub mod fingerprint;
mod flip;
pub mod frames;
pub mod gap_of;
pub mod inverse;
mod joint;
mod lines;
pub mod plausible;
mod serial;
pub mod table;
pub mod urdf;
pub mod write;

pub use arm::Arm;
pub use chain::{Chain, Pose};
pub use flip::Flip;
pub use frames::Frames;
pub use inverse::{Inverse, InverseOptions, Stop, Target};
pub use joint::{Convention, Follow, GapOf, Joint, JointFrame, JointKind, Link, STANDARD_GRAVITY_M_S2};
pub use serial::Robot;

pub use robot_programs::axes::{Axes, Axis};
