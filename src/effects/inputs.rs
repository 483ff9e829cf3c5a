//! What effects look at: the commands and measurements of a log or program, row by row, and the geometry that some change.

use super::{DhParameter, Target};
use crate::robot::{Joint, JointFrame};
use nalgebra::{Isometry3, Vector3};
use std::borrow::Cow;

/// What effects look at that act row by row.
pub trait Inputs: Sync {
    /// Command of an axis, rad or m.
    fn command(&self, axis: usize) -> &[f64];

    /// Gravity's torque about an axis at the commanded pose, Nm (N for a prismatic one); positive turns the axis positive.
    fn gravity_torque(&self, axis: usize) -> &[f64];

    /// `(z cross x) . g` and `(z cross y) . g` for the axis `z` and the frame `x, y` of a joint after it, `g` of length 1.
    fn gravity_levers(&self, axis: usize, joint: usize) -> Cow<'_, [[f64; 2]]>;

    /// Measured torque of the drive of an axis, Nm or N; `None` where it was not logged.
    fn measured_torque(&self, _axis: usize) -> Option<&[f64]> {
        None
    }

    /// Torque of the force on the tool about an axis at the commanded pose, Nm or N; `None` where no force was logged.
    fn process_torque(&self, _axis: usize) -> Option<&[f64]> {
        None
    }

    /// Times, s; empty where there are none: settled poses, a single pose.
    fn t_s(&self) -> &[f64] {
        &[]
    }

    /// Time over which what was measured at each row is a mean, s; 0 where rows are samples.
    fn mean_over_s(&self) -> f64 {
        0.0
    }

    /// Temperature; `None` where it was not logged.
    fn temp_c(&self) -> Option<&[f64]> {
        None
    }

    /// Direction of the last movement of an axis: -1, +1, or 0 before the first one; empty where it is not known.
    fn direction(&self, _axis: usize) -> &[f64] {
        &[]
    }

    /// Speed of the command of an axis, rad/s or m/s; empty where it is not known.
    fn speed(&self, _axis: usize) -> &[f64] {
        &[]
    }

    /// Moment of the weights about the base's origin, Nm, and that origin, m.
    fn overturning(&self, _row: usize) -> (Vector3<f64>, Vector3<f64>) {
        (Vector3::zeros(), Vector3::zeros())
    }

    /// One turn of an axis: 2 pi rad, or its lead in m.
    fn rev(&self, _axis: usize) -> f64 {
        std::f64::consts::TAU
    }

    /// Where a series of the rows turns between them: `(row before, t in s, value there)`.
    fn turning_points(&self, _series: &[f64]) -> Vec<(usize, f64, f64)> {
        Vec::new()
    }
}

/// Kinematic parameters that geometry effects change.
#[derive(Debug, Clone)]
pub struct Geometry {
    /// Joints with their Denavit-Hartenberg parameters.
    pub joints: Vec<Joint>,
    /// Flange to TCP.
    pub tool: Isometry3<f64>,
}

/// One row, as an effect after the kinematics sees it.
#[derive(Clone, Copy)]
pub struct Row<'a> {
    /// Number of the row, from 0.
    pub index: usize,
    /// Time since the first row, s, by the clock of the robot.
    pub t_s: f64,
    /// The same by the clock of the tracker.
    pub measured_s: f64,
    /// The rows are settled poses, which have no time.
    pub settled: bool,
    /// Commands, torques and temperatures of the log or program.
    pub inputs: &'a dyn Inputs,
    /// Joint frames in the base frame, after the turn and the slide of the joint; empty where no effect needs them.
    pub frames: &'a [JointFrame],
    /// The measuring system in the base frame, m.
    pub station_m: Vector3<f64>,
}

impl Row<'_> {
    /// Frame of the joint that a target names by its axis.
    pub fn frame_of_axis(&self, target: Target) -> Option<&JointFrame> {
        let axis = target.axis()?;
        self.frames.iter().find(|f| f.axis == axis)
    }

    /// Direction in which a length of a joint moves all that is after it.
    pub fn direction_of(&self, joint: usize, parameter: DhParameter) -> Vector3<f64> {
        match (self.frames.get(joint), parameter) {
            (Some(f), DhParameter::A) => f.along_a,
            (Some(f), DhParameter::D) => f.z,
            _ => Vector3::zeros(),
        }
    }
}
