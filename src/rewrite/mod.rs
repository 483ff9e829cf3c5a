//! Rewriting: points of a joint-space program in, points with reversal points and offsets out (seed 000 equations 15-17).
//!
//! The engine sees joint vectors and times only; text, formats and files are the business of [`crate::program`] and of the
//! command. It is causal with a bounded look-ahead, so a program of any length passes in constant memory.
//!
//! Rooms:
//! - [`engine`]: the state machine.
//! - [`options`]: what a user may choose.
//! - [`points`]: blocks of points that go in and come out.

pub mod engine;
pub mod options;
pub mod points;

pub use engine::{Account, Engine, LimitKind, Violation};
pub use options::{Options, Refine};
pub use points::{Emitted, Origin, Points};

// from file to file: job is one program, batch a folder of them, stream the way of the text, from_model a compensator
// made of a model file, summary the account
pub mod batch;
pub mod from_model;
pub mod job;
pub mod stream;
pub mod summary;
