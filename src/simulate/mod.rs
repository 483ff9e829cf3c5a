//! Simulating: a program or a log, and a model of the machine, to the log that a tracker would write.
//!
//! The chain from command to measurement is [`crate::machine`]; noise comes last. Between points a program is linear in the joints.
//!
//! Modules:
//! - [`timing`]: times of program points at a constant TCP speed.
//! - [`motion`]: commands and what the chain makes of them.
//! - [`noise`]: seeded white noise.
//! - `note`: what a reader of the predicted log should know.
//! - [`predicted`]: the predicted log as CSV, with the input's own columns where it was a log.
//!
//! # Example
//!
//! A gantry with a half gap of 0.05 mm goes 10 mm forth and back: on the way back the TCP is a whole gap behind its way forth.
//!
//! ```
//! use lostmotion::{io::input::from_bytes, model::Model, program::Program, robot::Robot, simulate::Motion};
//! use std::path::Path;
//!
//! let robot = Robot::load(Path::new("configs/gantry-xyz-ballscrew.yaml"))?;
//! let text = "schema: lostmotion/model/1\nrobot: gantry.yaml\neffects:\n  - {effect: backlash, joint: X, half_gap_mm: 0.05}\n";
//! let model = Model::parse("model.yaml", text, &|_| Ok(robot.clone()))?;
//! let rows = b"x_mm,y_mm,z_mm\n100,0,0\n110,0,0\n100,0,0\n".to_vec();
//! let program = Program::parse(from_bytes("program.csv".into(), rows)?, &robot)?;
//! let motion = Motion::of_program(&model, &program, &[0.0, 1.0, 2.0], 10.0)?;
//! // at 0.5 s and at 1.5 s the command is 105 mm
//! let (forth, back) = (motion.point_m(0, 5).x, motion.point_m(0, 15).x);
//! assert!((back - forth - 2.0 * 0.05e-3).abs() < 1e-9, "{forth} m, {back} m");
//! # Ok::<(), lostmotion::error::Error>(())
//! ```

#![warn(missing_docs)]

pub mod motion;
pub mod noise;
pub mod note;
pub mod predicted;
pub mod timing;

pub use motion::Motion;
pub use note::Note;
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
