//! Cartesian targets as joints, and joints with their offsets as Cartesian targets.
//!
//! A target `P` in frame `F` for tool `T` puts the flange where `flange * T = F * P`. [`Poses`] looks frames and tools up by the
//! controller's names, and counts the moves that wait for one that is not known. [`Place::joints`] solves a target for the
//! joints that its configuration names, or for those next to the joints before. [`Place::shifted`] writes joints with an offset
//! as a pose: `P * (arm(q)^-1 * arm(q + offset))`, so that only differences of the nominal arm count and a target whose joints
//! do not change keeps its numbers.
//!
//! Nothing is claimed where several solutions are as good, where the solution next to the joints before and the one that a
//! configuration names differ, or where the target lies outside of the joint limits. One exception: a joint motion whose configuration is
//! that of one solution alone goes there, however far that is, as long as few motions of the program do so.
//!
//! In this folder: [`lookup`]: frames and tools by name; [`place`] and [`tooled`]: those of one target, and the robot with one tool;
//! [`carried`]: arms on external axes, and [`external`]: their targets; [`letters`]: the two wrists of a pose; [`solve`] chooses the joints
//! of a target; [`borders`] keeps joints with offsets in the configuration that is written; [`mod@write`] makes numbers of joints.

mod borders;
mod carried;
mod external;
mod letters;
mod lookup;
mod place;
mod solve;
#[cfg(test)]
mod tests;
mod tooled;
mod write;

pub use borders::Held;
pub use lookup::Poses;
pub use place::Place;
pub use tooled::Tooled;
pub use write::{own_numbers, write};
