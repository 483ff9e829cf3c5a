//! Assessing: what lost motion costs at the TCP.
//!
//! Rooms:
//! - [`circle`]: a measured circle before and after compensation, against its best-fit circle and its nominal path.
//! - [`impact`]: TCP displacement of one half gap of each joint, at a pose or over a program.
//! - [`rigid`]: the rigid transform between two sets of points.

pub mod circle;
pub mod impact;
pub mod rigid;
