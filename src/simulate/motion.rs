//! A program or a log on a modelled machine: its commands, and what comes out of the whole chain.

use crate::error::Result;
use crate::log::Log;
use crate::machine::{CommandTrajectory, Prediction, predict};
use crate::model::Model;
use crate::program::Program;
use nalgebra::Vector3;

/// What the machine does at the rows of the log.
#[derive(Debug)]
pub struct Motion {
    /// The commands.
    pub drive: CommandTrajectory,
    /// What the machine makes of them.
    pub prediction: Prediction,
}

impl Motion {
    /// Runs a program whose points stand at `t_s` (one per point, not decreasing), sampled at `rate_hz` from the first.
    pub fn of_program(model: &Model, program: &Program, t_s: &[f64], rate_hz: f64) -> Result<Self> {
        Self::of_program_at(model, program, t_s, rate_hz, &[])
    }

    /// The same with rows at the points `at` of the program (increasing), too.
    pub fn of_program_at(model: &Model, program: &Program, t_s: &[f64], rate_hz: f64, at: &[usize]) -> Result<Self> {
        Ok(Self::of(model, CommandTrajectory::of_program_at(&model.robot, program, t_s, rate_hz, at)?))
    }

    /// Runs the rows of a log.
    pub fn of_log(model: &Model, log: &Log) -> Self {
        Self::of(model, CommandTrajectory::of_log(&model.robot, log))
    }

    fn of(model: &Model, drive: CommandTrajectory) -> Self {
        let prediction = predict(model, &drive);
        Self { drive, prediction }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.drive.rows()
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Reflector `k` (0: the TCP) in a row, m.
    pub fn point_m(&self, k: usize, row: usize) -> Vector3<f64> {
        self.prediction.points_m[k][row]
    }
}
