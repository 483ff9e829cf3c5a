//! What an identification found: half gaps per joint and angle, stiction, the registration. Document
//! `lostmotion/gaps/1`; written by `identify`, read by `fit`.
//!
//! [`Gaps`] holds the result, [`Distrust`] (`distrust`) why it cannot be trusted. [`estimate`] holds what a joint estimate over all logs of
//! a machine adds; [`after_reversal`] its curve over time. [`mod@note`] holds what a reader should know. Values are SI (rad or m, s);
//! [`document`] turns them into the document's units, [`mod@file`] into text, [`read`] back.
//!
//! # Example
//!
//! A document is in degrees or mm, its values here in rad or m.
//!
//! ```
//! use lostmotion::{gaps::Gaps, robot::Robot};
//! use std::path::Path;
//!
//! let robot = Robot::load(Path::new("configs/kuka-kr120-r2500-pro.yaml"))?;
//! let text = format!(
//!     "schema: lostmotion/gaps/1\nrobot: {{name: KUKA, sha256: {}}}\nlogs: [{{name: circle.csv, sha256: aa}}]\npoints: []\njoints:\n  \
//!      - {{joint: A2, half_gap_deg: 0.0037, ci95: [0.0036, 0.0038]}}\n",
//!     robot.fingerprint()
//! );
//! let gaps = Gaps::parse("gaps.yaml", &text, &robot)?;
//! let a2 = &gaps.joints[0];
//! assert_eq!(a2.axis, 1);
//! assert!((a2.half_gap - 0.0037_f64.to_radians()).abs() < 1e-12);
//! # Ok::<(), lostmotion::error::Error>(())
//! ```

#![warn(missing_docs)]

pub mod after_reversal;
mod distrust;
pub mod document;
pub mod estimate;
pub mod file;
mod found;
pub mod note;
pub mod read;
mod values;

pub use crate::log::registration::Registered;
pub use distrust::Distrust;
pub use found::{GapPoint, Gaps, JointGap, LogRef, Sides, StictionFound};
pub use note::Note;
