//! Assessing: what lost motion costs at the TCP.
//!
//! Modules:
//! - [`bidirectional`]: positions reached from both sides: repeatability, backlash, its curve over position and states.
//! - [`circle`]: a measured circle before and after compensation, against its best-fit circle and its nominal path.
//! - [`deadzone`]: deadzones of a motion without and with compensation.
//! - [`impact`]: TCP displacement of one half gap of each joint, at a pose or over a program.
//! - [`program`]: path error along any program before and after it was changed, with the verdict.
//! - [`rigid`]: the rigid transform between two sets of points.

#![warn(missing_docs)]

pub mod bidirectional;
pub mod circle;
pub(crate) mod deadzone;
pub mod impact;
pub(crate) mod program;
pub(crate) mod rigid;
