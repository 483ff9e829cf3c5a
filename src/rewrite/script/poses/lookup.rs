//! Frames and tools of a program's targets, by the controller's names.

use super::super::cause::Cause;
use super::place::Place;
use super::tooled::Tooled;
use crate::program::script::pose::{Frame, PoseGoal};
use crate::robot::frames::{Frames, Missing};
use crate::robot::{Flip, Robot};
use nalgebra::Isometry3;
use std::collections::BTreeMap;
use std::sync::Arc;

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
