//! Assessing: what lost motion costs at the TCP.
//!
//! Modules:
//! - [`bidirectional`]: positions reached from both sides: repeatability, backlash, its curve over position and states.
//! - [`circle`]: a measured circle before and after compensation, against its best-fit circle and its nominal path.
//! - [`deadzone`]: deadzones of a motion without and with compensation.
//! - [`impact`]: TCP displacement of one half gap of each joint, at a pose or over a program.
//! - [`program`]: path error along any program before and after it was changed, with the verdict.
//! - [`rigid`]: the rigid transform between two sets of points.
//!
//! # Example
//!
//! What a half gap of joint A1 of 0.003 deg moves at the TCP: the radius of the TCP about the axis times the angle.
//!
//! ```
//! use lostmotion::assess::impact::displacement_m;
//! use lostmotion::robot::Robot;
//! use std::path::Path;
//!
//! let robot = Robot::load(Path::new("configs/kuka-kr120-r2500-pro.yaml"))?;
//! let q = [0.0, -90.0, 90.0, 0.0, 0.0, 0.0_f64].map(f64::to_radians);
//! let half_gap = 0.003_f64.to_radians();
//! let tcp = robot.tcp_m(&q);
//! let by_hand = tcp.x.hypot(tcp.y) * half_gap;
//! let moved = displacement_m(&robot, &q, 0, half_gap);
//! assert!((moved - by_hand).abs() < 1e-9, "{moved} m, by hand {by_hand} m");
//! # Ok::<(), lostmotion::error::Error>(())
//! ```

#![warn(missing_docs)]

pub mod bidirectional;
pub mod circle;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod deadzone;
pub mod impact;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod program;
pub(crate) mod rigid;
