//! Identification: from measurement logs to half gaps per joint, with intervals ([`crate::gaps::Gaps`]).
//!
//! Rooms:
//! - [`machine`]: all logs of a machine together: gap, friction, geometry, frames, with trust.
//! - [`static_test`]: every angle reached from both sides with a dwell (seed 000, Table 1 and Figure 5).
//! - [`deadzone`]: deadzones by growing sweeps of one joint at a time, tip positions only (seed 002, algorithm 1).
//! - [`path`]: gaps and stiction from reversals in continuous motion (seed 000, sections 3 and 5).
//! - [`scalar`]: gaps from one reading a row: ballbar, dial gauge.
//! - [`screw`]: two gaps in series, coupling and nut, from strokes of one joint (seed 003).

pub mod deadzone;
pub mod machine;
pub mod path;
pub mod scalar;
pub mod screw;
pub mod static_test;
