//! Identification: from measurement logs to half gaps per joint, with intervals ([`crate::gaps::Gaps`]).
//!
//! Modules:
//! - [`machine`]: all logs of a machine together: gap, friction, geometry, frames, with trust.
//! - [`static_test`]: every angle reached from both sides with a dwell (Zhang (2023), Table 1 and Figure 5).
//! - `gears`: robots whose gears turn by sums of axes, before each of these; `deadzone` and `screw` take joints alone and note it.
//! - `commands`: commands that jitter or are coarse, before [`machine`] and [`path`].
//! - `following`: lags and clocks, for [`machine`] and [`path`].
//! - [`deadzone`]: deadzones by growing sweeps of one joint at a time, tip positions only (Cursi (2022), algorithm 1).
//! - [`path`]: gaps and stiction from reversals in continuous motion (Zhang (2023), sections 3 and 5).
//! - [`scalar`]: gaps from one reading a row: ballbar, dial gauge.
//! - [`screw`]: two gaps in series, coupling and nut, from strokes of one joint (Gantry (2015)).

#![warn(missing_docs)]

pub(crate) mod commands;
pub mod deadzone;
pub(crate) mod following;
pub(crate) mod gears;
pub mod machine;
pub mod path;
pub mod scalar;
pub mod screw;
pub mod static_test;

/// A joint that moves the TCP by less than this (m per rad, or m per m) cannot be tested through it.
const LEAST_LEVER: f64 = 1e-3;
