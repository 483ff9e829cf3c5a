//! A program or a log on a modelled machine: its commands, and what comes out of the whole chain.

use crate::error::Result;
use crate::log::Log;
use crate::machine::{CommandTrajectory, Prediction, predict, tcp};
use crate::model::Model;
use crate::program::Program;
use crate::robot::Robot;
use nalgebra::Vector3;

/// What the machine does at the rows of the log.
#[derive(Debug)]
pub struct Motion {
    /// The commands.
    pub trajectory: CommandTrajectory,
    /// What the machine makes of them.
    pub prediction: Prediction,
}

/// The machine with a command for each gear, where gears turn by sums of axes: gaps and friction are those of gears.
fn by_gears(model: &Model) -> Option<Model> {
    Some(Model { robot: model.robot.of_gears()?, ..model.clone() })
}

/// What encoders and sensors show, by axes again.
fn back(mut prediction: Prediction, robot: &Robot) -> Prediction {
    for columns in [&mut prediction.servo, &mut prediction.joint] {
        let rows = columns.first().map_or(0, Vec::len);
        for row in 0..rows {
            let mut q: Vec<f64> = columns.iter().map(|c| c[row]).collect();
            robot.from_gears(&mut q);
            columns.iter_mut().zip(q).for_each(|(c, v)| c[row] = v);
        }
    }
    prediction
}

impl Motion {
    /// Runs a program whose points stand at `t_s` (one per point, not decreasing), sampled at `rate_hz` from the first.
    pub fn of_program(model: &Model, program: &Program, t_s: &[f64], rate_hz: f64) -> Result<Self> {
        Self::of_program_at(model, program, t_s, rate_hz, &[])
    }

    /// The same with rows at the points `at` of the program (increasing), too.
    pub fn of_program_at(model: &Model, program: &Program, t_s: &[f64], rate_hz: f64, at: &[usize]) -> Result<Self> {
        let trajectory = CommandTrajectory::of_program_at(&model.robot, program, t_s, rate_hz, at)?;
        let Some(by_gears) = by_gears(model) else { return Ok(Self::of(model, trajectory)) };
        let program = program.by_gears(&model.robot);
        let gears = CommandTrajectory::of_program_at(&by_gears.robot, &program, t_s, rate_hz, at)?;
        Ok(Self { trajectory, prediction: back(predict(&by_gears, &gears), &model.robot) })
    }

    /// Runs the rows of a log.
    pub fn of_log(model: &Model, log: &Log) -> Self {
        let trajectory = CommandTrajectory::of_log(&model.robot, log);
        let Some(by_gears) = by_gears(model) else { return Self::of(model, trajectory) };
        let gears = CommandTrajectory::of_log(&by_gears.robot, &log.by_gears(&model.robot));
        Self { trajectory, prediction: back(predict(&by_gears, &gears), &model.robot) }
    }

    /// A program as [`Self::of_program_at`] runs it: its commands and the TCP in each row, m, without what takes most of the memory.
    pub fn tcp_of_program_at(
        model: &Model,
        program: &Program,
        t_s: &[f64],
        rate_hz: f64,
        at: &[usize],
    ) -> Result<(CommandTrajectory, Vec<Vector3<f64>>)> {
        let trajectory = CommandTrajectory::of_program_at(&model.robot, program, t_s, rate_hz, at)?;
        let points = match by_gears(model) {
            None => tcp(model, &trajectory),
            Some(by_gears) => {
                let program = program.by_gears(&model.robot);
                let gears = CommandTrajectory::of_program_at(&by_gears.robot, &program, t_s, rate_hz, at)?;
                tcp(&by_gears, &gears)
            }
        };
        Ok((trajectory, points))
    }

    /// The same of the rows of a log.
    pub fn tcp_of_log(model: &Model, log: &Log) -> (CommandTrajectory, Vec<Vector3<f64>>) {
        let trajectory = CommandTrajectory::of_log(&model.robot, log);
        let points = match by_gears(model) {
            None => tcp(model, &trajectory),
            Some(by_gears) => tcp(&by_gears, &CommandTrajectory::of_log(&by_gears.robot, &log.by_gears(&model.robot))),
        };
        (trajectory, points)
    }

    fn of(model: &Model, trajectory: CommandTrajectory) -> Self {
        let prediction = predict(model, &trajectory);
        Self { trajectory, prediction }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.trajectory.rows()
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
