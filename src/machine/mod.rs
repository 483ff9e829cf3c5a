//! The machine: from commands to what a tracker measures, through every stage of the effect catalogue.
//!
//! command -> servo -> gear -> link -> geometry -> TCP -> measurement. `simulate` writes what comes out, `diagnose` fits it,
//! `assess` judges it; all three run this one chain.
//!
//! The play and the stiction are exact at the rows: within a stroke both are monotone functions of a monotone command, so no
//! finer grid than rows, a program's points and turning points together changes them. Of a log only its rows are known; its
//! turning points between them are estimated ([`turns`]).
//!
//! Modules:
//! - [`trajectory`]: commands of all axes, prepared once; through servo and gear as often as wanted.
//!   `wide`: over more samples than there are; `inputs`: what effects look at that act row by row.
//! - [`grid`]: points of a program and rows together; [`turns`]: turning points between the rows of a log.
//! - [`speed`]: speed of the commanded TCP; [`gravity`]: torque of the weights about each axis.
//! - [`measurement`]: what an instrument reads: TCP, distance, direction, joint.
//! - [`parts`]: single stages, for callers that run the chain piece by piece.
//! - [`mod@predict`]: the whole chain, to the reflectors in the tracker's frame.

#![warn(missing_docs)]

pub mod gravity;
pub mod grid;
mod inputs;
pub mod measurement;
pub mod parts;
pub mod predict;
pub mod speed;
pub mod trajectory;
pub mod turns;
mod wide;

pub use parts::slopes;
pub use predict::{Prediction, geometry, predict, tcp};
pub use trajectory::CommandTrajectory;
