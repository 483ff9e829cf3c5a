//! A robot with one of its tools.

use super::carried::{Carried, OF_ARM};
use crate::robot::arm::Arm;
use crate::robot::{JointKind, Robot};
use nalgebra::Isometry3;

/// A robot with one of its tools, ready for the inverse.
#[derive(Debug)]
pub struct Tooled {
    pub robot: Robot,
    pub arm: Option<Arm>,
    /// The arm where external axes of the robot carry it.
    pub carried: Option<Carried>,
}

impl Tooled {
    pub fn new(robot: &Robot, tool: Isometry3<f64>) -> Self {
        let robot = robot.with_geometry(robot.joints.clone(), tool);
        let arm = Arm::of(&robot);
        let carried = if arm.is_none() { Carried::of(&robot) } else { None };
        Self { robot, arm, carried }
    }

    /// The arm, the robot of which it is all, and its joints among those of the whole robot.
    pub fn arm_of<'q>(&'q self, q: &'q [f64]) -> Option<(&'q Arm, &'q Robot, &'q [f64])> {
        match (&self.arm, &self.carried) {
            (Some(arm), _) => Some((arm, &self.robot, q)),
            (None, Some(carried)) => Some((&carried.arm, &carried.robot, carried.of_arm(q))),
            (None, None) => None,
        }
    }

    /// A pose alone does not determine the joints.
    pub fn is_redundant(&self) -> bool {
        let turning = self.robot.axis_joints().any(|j| j.kind == JointKind::Revolute);
        let external = turning && !self.robot.axes().places().external.is_empty();
        self.arm.is_none() && self.carried.is_none() && (self.robot.dof() > OF_ARM || external)
    }
}
