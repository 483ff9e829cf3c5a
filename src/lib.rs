//! `lostmotion` takes lost motion out of robot programs before they reach the controller.
//!
//! The rooms, and the one direction in which they know each other, are drawn in `docs/architecture.md`.
#![forbid(unsafe_code)]

pub mod cli;
pub mod compensator;
pub mod effect;
pub mod error;
pub mod gaps;
pub mod io;
pub mod log;
pub mod model;
pub mod program;
pub mod rewrite;
pub mod robot;
