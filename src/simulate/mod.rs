//! Simulating: a program or a log, and a model of the machine, to the log that a tracker would write.
//!
//! The chain from command to measurement is [`crate::machine`]; noise comes last. Between points a program is linear in the joints.
//!
//! Modules:
//! - [`timing`]: times of program points at a constant TCP speed.
//! - [`motion`]: commands and what the chain makes of them.
//! - [`noise`]: seeded white noise.
//! - [`predicted`]: the predicted log as CSV, with the input's own columns where it was a log.

#![warn(missing_docs)]

pub mod motion;
pub mod noise;
pub mod predicted;
pub mod timing;

pub use motion::Motion;
pub use predicted::Written;
pub use timing::Timing;

/// What a user may choose; SI.
#[derive(Debug, Clone)]
pub struct Options {
    /// Rows per second of a program's log.
    pub rate_hz: f64,
    /// TCP speed of a program without times, m/s.
    pub speed_m_s: f64,
    /// Standard deviation of each coordinate, m; 0: none.
    pub noise_m: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// Add `enc_` columns: the motor side, which the servo's effects move and the gear's do not.
    pub encoders: bool,
    /// Add `screw_` columns: between the two gaps of a drive.
    pub screws: bool,
}

impl Default for Options {
    /// 25 Hz, and 1.5 mm/s, the TCP speed of the circle of Zhang (2023) (section 3.2).
    fn default() -> Self {
        Self { rate_hz: 25.0, speed_m_s: 1.5e-3, noise_m: 0.0, seed: 1, encoders: false, screws: false }
    }
}
