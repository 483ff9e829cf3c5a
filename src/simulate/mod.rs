//! Simulating: a program or a log, and a model of the machine, to the log that a tracker would write.
//!
//! A command track per axis (exact at the program's own points and at every row) passes the effects of the model in the
//! order of their stages; the joint positions behind the gears pass the forward kinematics; the registration takes the
//! TCP into the tracker's frame; noise comes last. Between points a program is linear in the joints.
//!
//! The play and the stiction are exact at the rows: within a stroke both are monotone functions of a monotone command, so
//! no finer grid than rows and program points together changes them. Of a log only its rows are known; its turning points
//! between them are estimated ([`turns`]).
//!
//! Rooms:
//! - [`timing`]: times of program points at a constant TCP speed.
//! - [`turns`]: turning points between the rows of a log.
//! - [`machine`]: command tracks to joint positions behind the gears.
//! - [`noise`]: seeded white noise.
//! - [`predicted`]: the predicted log as CSV, with the input's own columns where it was a log.

pub mod machine;
pub mod noise;
pub mod predicted;
pub mod timing;
pub mod turns;

pub use machine::{Column, Motion};
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
    pub seed: u64,
    /// Leave out the model's registration: TCP in the world of the robot file.
    pub base_frame: bool,
    /// Add `enc_` columns: the motor side, which the servo's effects move and the gear's do not.
    pub encoders: bool,
}

impl Default for Options {
    /// 25 Hz, and 1.5 mm/s, the TCP speed of the circle of seed 000 (section 3.2).
    fn default() -> Self {
        Self { rate_hz: 25.0, speed_m_s: 1.5e-3, noise_m: 0.0, seed: 1, base_frame: false, encoders: false }
    }
}
