//! Cartesian targets as joints, and joints with their offsets as Cartesian targets.
//!
//! A target `P` in frame `F` for tool `T` puts the flange where `flange * T = F * P`. [`Poses`] looks frames and tools up by the
//! controller's names, and counts the moves that wait for one that is not known. [`Place::joints`] solves a target for the
//! joints that its configuration names, or for those next to the joints before. [`Place::shifted`] writes joints with an offset
//! as a pose: `P * (arm(q)^-1 * arm(q + offset))`, so that only differences of the nominal arm count and a target whose joints
//! do not change keeps its numbers.
//!
//! Nothing is claimed where several solutions are as good, where the solution next to the joints before and the one that a
//! configuration names differ, or where the target lies outside of the joint limits. One exception: a joint motion whose configuration is
//! that of one solution alone goes there, however far that is, as long as few motions of the program do so.
//!
//! In this folder: frames, tools and places here; [`carried`]: arms on external axes; [`letters`]: the two wrists of a pose; [`solve`] chooses the joints of a target; [`borders`] keeps joints with offsets in the
//! configuration that is written; [`mod@write`] makes numbers of joints.

mod borders;
mod carried;
mod letters;
mod solve;
#[cfg(test)]
mod tests;
mod write;

use super::cause::Cause;
use crate::program::script::pose::{Frame, PoseGoal};
use crate::robot::arm::{self, Arm};
use crate::robot::frames::{Frames, Missing};
use crate::robot::{Flip, Robot};
use nalgebra::{Isometry3, Point3, Vector3};
use std::collections::BTreeMap;
use std::sync::Arc;

pub use borders::Held;
pub use carried::Carried;
pub use write::{own_numbers, write};

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
}

/// Frame and tool of one target.
#[derive(Debug, Clone)]
pub struct Place {
    pub tooled: Arc<Tooled>,
    pub frame: Isometry3<f64>,
    /// Joints in whose configuration the arm works.
    posture: Option<Arc<[f64]>>,
    /// See [`Poses::by_order`].
    by_order: bool,
    /// The joints before are those of a target by its own letter for the wrist.
    pub lettered: bool,
    /// What a letter for the wrist means, where that is known.
    pub flip: Option<Flip>,
}

/// Frames, tools and robots for the targets of a program.
#[derive(Debug)]
pub struct Poses {
    robot: Robot,
    frames: Frames,
    by_tool: BTreeMap<String, Arc<Tooled>>,
    pub missing: Missing,
    /// Joints in whose configuration the arm works where nothing else determines it, rad or m; `None`: not given.
    pub posture: Option<Arc<[f64]>>,
    /// Why joint values of the program do not tell where the arm stands; `None`: they do.
    pub unknown_arm: Option<Cause>,
    /// A joint motion goes to the configuration that it orders where one solution alone has it, also where another solution is nearer.
    pub by_order: bool,
    /// The controller's world in that of the robot file.
    pub world: Isometry3<f64>,
    /// What a letter for the wrist means; `None`: not known, or a meaning that is tried.
    pub flip: Option<Flip>,
}

impl Poses {
    pub fn new(robot: &Robot, frames: &Frames) -> Self {
        let frames = robot.frames.with(frames);
        let si =
            |given: &Vec<f64>| robot.axis_joints().zip(given).map(|(j, v)| v * j.kind.si_per_user_unit()).collect();
        let posture = frames.posture_deg.as_ref().map(si);
        let (robot, by_tool, missing) = (robot.clone(), BTreeMap::new(), Missing::default());
        let (world, flip) = (Isometry3::identity(), robot.wrist_flip);
        Self { robot, frames, by_tool, missing, posture, unknown_arm: None, by_order: true, world, flip }
    }

    /// Frame and tool of a target.
    ///
    /// # Errors
    /// What is not known.
    pub fn place(&mut self, goal: &PoseGoal) -> Result<Place, Cause> {
        if let Some(why) = goal.unknown() {
            return Err(Cause::NoPlace(why.clone()));
        }
        let (mut frames, mut tools) = (Vec::new(), Vec::new());
        // the robot's base in the controller's world
        let (base, known) = (self.world.inverse() * self.robot.base, &self.frames);
        let frame = resolved(&goal.frame, base, &|name| known.frame(name).copied(), &mut frames);
        let tool = resolved(&goal.tool, base, &|name| known.tool(name).copied(), &mut tools);
        for (names, missing) in [(&frames, &mut self.missing.frames), (&tools, &mut self.missing.tools)] {
            for name in names {
                *missing.entry(name.clone()).or_default() += 1;
            }
        }
        let (Some(frame), Some(tool)) = (frame, tool) else {
            let named = !(frames.is_empty() && tools.is_empty());
            return Err(if named { Cause::NotGiven { frames, tools } } else { Cause::SeveralPlaces });
        };
        if self.on_moving_base(&goal.frame) {
            return Err(Cause::MovingBase);
        }
        let (posture, by_order) = (self.posture.clone(), self.by_order);
        let frame = if self.world == Isometry3::identity() { frame } else { self.world * frame };
        Ok(Place { tooled: self.tooled(tool), frame, posture, by_order, lettered: false, flip: self.flip })
    }

    /// Whether a frame is the robot's base, and that is carried by an axis.
    fn on_moving_base(&self, frame: &Frame) -> bool {
        match frame {
            Frame::Base => self.robot.dof() > 6 && !self.robot.axes().places().external.is_empty(),
            Frame::Any(all) => all.iter().any(|f| self.on_moving_base(f)),
            _ => false,
        }
    }

    fn tooled(&mut self, tool: Isometry3<f64>) -> Arc<Tooled> {
        let key = format!("{:?} {:?}", tool.translation.vector, tool.rotation.coords);
        let robot = &self.robot;
        self.by_tool.entry(key).or_insert_with(|| Arc::new(Tooled::new(robot, tool))).clone()
    }

    /// The robot with the tool whose TCP goes straight to joint values.
    ///
    /// # Errors
    /// What is not known.
    pub fn tool(&mut self, tool: &Frame) -> Result<Arc<Tooled>, Cause> {
        if let Some(why) = tool.unknown() {
            return Err(Cause::NoTool(why.clone()));
        }
        let mut missing = Vec::new();
        let known = &self.frames;
        match resolved(tool, self.robot.base, &|name| known.tool(name).copied(), &mut missing) {
            Some(tool) => Ok(self.tooled(tool)),
            None if missing.is_empty() => Err(Cause::SeveralTools),
            None => Err(Cause::ToolNotGiven { tools: missing }),
        }
    }

    /// One more move that waits for tools that are not given.
    pub fn waits_for(&mut self, cause: &Cause) {
        let Cause::ToolNotGiven { tools } = cause else { return };
        for name in tools {
            *self.missing.tools.entry(name.clone()).or_default() += 1;
        }
    }
}

/// A frame by what is known of it; names that are not given are added to `missing`. Of several the one that all are.
fn resolved(
    frame: &Frame,
    base: Isometry3<f64>,
    known: &dyn Fn(&str) -> Option<Isometry3<f64>>,
    missing: &mut Vec<String>,
) -> Option<Isometry3<f64>> {
    match frame {
        Frame::Given(frame) => Some(*frame),
        Frame::Base => Some(base),
        Frame::Null => Some(Isometry3::identity()),
        Frame::Unknown(_) => None,
        Frame::Named(name) | Frame::Computed(name) => known(name).or_else(|| {
            missing.push(name.clone());
            None
        }),
        Frame::Any(all) => {
            let all: Vec<Option<Isometry3<f64>>> = all.iter().map(|f| resolved(f, base, known, missing)).collect();
            let first = (*all.first()?)?;
            all.iter().all(|f| *f == Some(first)).then_some(first)
        }
    }
}

impl Place {
    /// The target in the world of the robot.
    pub(super) fn world(&self, goal: &PoseGoal, from: Option<&[f64]>) -> Option<Isometry3<f64>> {
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

    fn arm_at(&self, q: &[f64]) -> Isometry3<f64> {
        arm::isometry(&self.tooled.robot.forward(q))
    }
}
