//! `lostmotion` takes lost motion out of robot programs before they reach the controller.
//!
//! The rooms, and the one direction in which they know each other, are drawn in `docs/architecture.md`.
#![forbid(unsafe_code)]

// first, as its macros `eprint!` and `eprintln!` stand in for those of the standard library
#[macro_use]
pub mod io;

pub mod assess;
pub mod cli;
pub mod compensator;
pub mod diagnose;
pub mod effects;
pub mod error;
pub mod fit;
pub mod gaps;
pub mod identify;
pub mod learn;
pub mod log;
pub mod machine;
pub mod model;
pub mod numerics;
pub mod plan;
pub mod program;
pub mod report;
pub mod rewrite;
pub mod robot;
pub mod simulate;
pub mod track;

/// Former name of [`numerics`].
#[doc(hidden)]
pub use numerics as stats;
