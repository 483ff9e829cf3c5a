//! Rewriting: points of a joint-space program in, points with reversal points and offsets out (Zhang (2023) equations 15-17).
//!
//! The engine sees joint vectors and times only; text, formats and files are the business of [`crate::program`] and of the
//! command. It is causal with a bounded look-ahead, so a program of any length passes in constant memory.
//!
//! Modules, in the order in which a point passes them:
//! - [`points`], [`options`]: blocks of points that go in and come out; what a user may choose.
//! - [`engine`]: the stations in a row; [`stats`]: what was done.
//! - [`statics`]: joint errors that depend on the joint vector alone, undone point by point before everything else.
//! - [`densify`]: points on the smooth TCP path between program points (`--refine cartesian`).
//! - [`turning`]: directions, dead band, true turning points between points ([`vertices`] is its memory).
//! - [`path`]: the stretch of path that is being worked on.
//! - [`plan`]: each axis' command along the path; [`offset`] says what an axis needs, [`stroke`] solves one reversal.
//! - [`limits`]: range, speed and acceleration of what comes out.
//! - [`equation2`]: another paper's law instead of all that: a whole deadzone at each change of direction.
//! - [`sizes`]: offsets that no lost motion explains.
//! - [`printed`]: the equations exactly as the paper prints them, to compare with.
//!
//! Around the engine, from file to file, every program passes the same stages. Joint-space CSV passes them block by block in constant
//! memory; a vendor program is read whole, because its moves refer to points and frames anywhere in it.
//!
//! | stage | shared by all formats | CSV | vendor program |
//! | --- | --- | --- | --- |
//! | source | [`job`]: format, size, notes beside it, guard | `stream::job` | `script::job`, `script::context` |
//! | moves | `deadband`, `digits`, [`rewritten`]: was it rewritten before? | rows | [`script`]: runs, ways, clock, poses |
//! | engine | [`engine`] | | |
//! | edits, read again | `robot_programs::decimal` | `stream::render`, `robot_programs::csv::again` | `script::edits`, `script::writing`, `script::verify` |
//! | sink | limits and their words ([`job`]), [`sink`], [`guard`] and its note, [`outcome`] | `stream::golden` | `script::change` |
//!
//! [`batch`] takes a folder of programs through (`apart`: no result goes over a program), [`manifest`] a list that many machines share;
//! `remote` does both for an object store (feature `cloud`); [`refusal`] says why a program is not rewritten, [`summary`] reports.
//!
//! Files beside:
//! - `earlier`: results of an earlier rewrite among the programs of a folder
//! - `foreign`: what stands in a folder of results and is none
//! - `deadband`: how far a joint must move against its direction before that is a reversal
//! - `milliseconds`: programs whose times are probably milliseconds in a column of seconds
//! - `radians`: programs whose angles are probably radians under names that say degrees
//! - [`near`]: two programs as text, equal but for numbers within a tolerance (checks)
//! - `original`: the bytes of a program as it was, kept in the note beside its rewritten form: zlib, base64. `undo` brings them
//!   back

#![warn(missing_docs)]

#[cfg_attr(not(feature = "cli"), allow(dead_code))]
mod apart;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod batch;
pub(crate) mod deadband;
pub(crate) mod densify;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
mod digits;
pub(crate) mod earlier;
pub(crate) mod engine;
pub(crate) mod equation2;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
mod foreign;
pub mod guard;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod job;
pub(crate) mod limits;
pub mod manifest;
mod milliseconds;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod near;
pub(crate) mod offset;
pub(crate) mod options;
pub mod original;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod outcome;
pub(crate) mod path;
pub(crate) mod plan;
pub mod points;
pub mod printed;
mod radians;
pub(crate) mod refusal;
#[cfg(feature = "cloud")]
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub mod remote;
pub(crate) mod rewritten;
pub mod script;
pub mod sink;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod sizes;
pub mod statics;
pub(crate) mod stats;
pub mod stream;
pub(crate) mod stroke;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod summary;
pub(crate) mod turning;
pub(crate) mod vertices;

pub use engine::Engine;
pub use options::{Options, Refine};
pub use points::{Origin, OutputPoints, Points};
pub use refusal::Refusal;
pub use stats::{LimitKind, RewriteStats, UncheckedRates, Violation};
