//! Frame and tool of one target, and where they put it in the world.

use super::tooled::Tooled;
use crate::program::script::pose::PoseGoal;
use crate::robot::{Flip, arm};
use nalgebra::{Isometry3, Point3, Vector3};
use std::sync::Arc;

/// Frame and tool of one target.
#[derive(Debug, Clone)]
pub struct Place {
    pub tooled: Arc<Tooled>,
    pub frame: Isometry3<f64>,
    /// Joints in whose configuration the arm works.
    pub(super) posture: Option<Arc<[f64]>>,
    /// See [`Poses::by_order`](super::Poses::by_order).
    pub(super) by_order: bool,
    /// The joints before are those of a target by its own letter for the wrist.
    pub lettered: bool,
    /// What a letter for the wrist means, where that is known.
    pub flip: Option<Flip>,
}

impl Place {
    /// The target in the world of the robot.
    pub(in crate::rewrite::script) fn world(&self, goal: &PoseGoal, from: Option<&[f64]>) -> Option<Isometry3<f64>> {
        let rotation = match (goal.rotation, from) {
            (Some(rotation), _) => self.frame.rotation * rotation,
            (None, Some(from)) => arm::isometry(&self.tooled.robot.forward(from)).rotation,
            (None, None) => return None,
        };
        Some(Isometry3::from_parts((self.frame * Point3::from(goal.position_m)).into(), rotation))
    }

    /// The point on the way of an arc in the world, m.
    pub fn via(&self, goal: &PoseGoal) -> Option<Vector3<f64>> {
        goal.via_m.map(|at| (self.frame * Point3::from(at)).coords)
    }

    pub(super) fn arm_at(&self, q: &[f64]) -> Isometry3<f64> {
        arm::isometry(&self.tooled.robot.forward(q))
    }
}
