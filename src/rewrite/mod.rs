//! Rewriting: points of a joint-space program in, points with reversal points and offsets out (seed 000 equations 15-17).
//!
//! The engine sees joint vectors and times only; text, formats and files are the business of [`crate::program`] and of the
//! command. It is causal with a bounded look-ahead, so a program of any length passes in constant memory.
//!
//! Rooms:
//! - [`engine`]: the state machine.
//! - [`options`]: what a user may choose.
//! - [`points`]: blocks of points that go in and come out.
//! - [`job`]: one program from file to file; [`batch`]: a folder of them; [`summary`]: what was done, for people and machines.
//! - [`from_model`]: a compensator made of a model file.
//! - [`stream`]: a program of any length through the engine: text in, text out.

pub mod batch;
pub mod engine;
pub mod from_model;
pub mod job;
pub mod options;
pub mod points;
pub mod stream;
pub mod summary;

pub use engine::{Account, Engine, LimitKind, Violation};
pub use options::{Options, Refine};
pub use points::{Emitted, Origin, Points};
