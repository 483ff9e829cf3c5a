//! Runs: stretches of a program on which each position certainly follows the one before it.
//!
//! A label, a loop, a call, or a target that cannot be determined ends a run: after it the directions are unknown. The first
//! movement's direction is taken, but only at the start of the program the first point carries its offset: anywhere else the
//! robot may come to it from the other side. A dwell, a process or a comment ends nothing, nor does a loop whose passes are alike.
//!
//! Files, in the order of the work:
//! - `arm`: what the script says of the arm's configuration as a whole
//! - `cutter`: what cuts a script into runs, step by step, and what comes out; `cuts`: the whole script for one meaning of its letters
//! - `joints`: joint values of one point
//! - `rounds`: loops whose passes are alike
//! - `joins`: breaks of which it is known from where control comes
//! - `computed`: moves between frames and tools that the program computes, on whose way no point can be
//! - `elsewhere`: axes that go, or count from, nobody knows where, while the others go on
//! - `goals`: the goal of a move in joints, and the tool with which it goes there
//! - `stretch`: the points of a run, and what is known of it as a whole
//! - `ways`: duration and turning points of a move between two known places
//! - `wrists`: letters for the wrist whose meaning differs by model
//! - `legs`: the ways between goals, without offsets; `lengths`: how long those of joint moves are at the TCP
//! - `reach`: how far into a run it matters from where it is reached

mod arm;
mod computed;
mod cuts;
mod cutter;
mod elsewhere;
mod goals;
mod joins;
mod joints;
mod legs;
mod lengths;
mod reach;
mod rounds;
mod stretch;
mod ways;
mod wrists;

pub use cutter::{Choice, Cut, Gap, Tells};
use cutter::{Cutter, LastFrame, Reached, ToolAndMiddle};
pub use joints::Joints;
pub use stretch::{Role, Run, Vertex};
pub use wrists::cut;
