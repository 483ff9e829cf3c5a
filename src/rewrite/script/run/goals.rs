//! The goal of a move in joints: those that it names, or those of its Cartesian target; and with which tool it goes there.

use super::arm::{self, joints_of};
use super::{Cutter, Joints, LastFrame, Reached, ToolAndMiddle};
use crate::program::script::{At, AxisSet, Move, Note, OtherWay, PathKind, PoseGoal, Script, TargetRef};
use crate::rewrite::script::cause::Cause;
use crate::rewrite::script::circles;
use crate::rewrite::script::poses::{Place, Tooled};
use crate::rewrite::script::way;
use crate::robot::JointKind;
use crate::robot::arm::isometry;
use nalgebra::Vector3;
use std::sync::Arc;

/// A tool that turns by less on a straight way goes straight with all its points, rad: one that is 0.5 m long leaves its line by 2 um, as
/// the sagitta of a turn is length * turn^2 / 8.
const SAME_TURN_RAD: f64 = 5e-3;

/// Frames that differ by less have the same orientation, rad: 1 um in 10 m.
const SAME_FRAME_RAD: f64 = 1e-7;

impl Cutter<'_> {
    /// The joints that a move names; `None` where it is not yet known where every axis stands.
    pub(super) fn joint_goal(
        &mut self,
        script: &Script,
        target: Option<TargetRef>,
        step: usize,
        at: At,
        m: &Move,
        from: Option<Joints>,
    ) -> Option<Reached> {
        let Some(target) = target else {
            self.lost(at, Cause::NoTarget);
            return None;
        };
        if !m.displaced.and(self.choice.by_place).is_empty() {
            self.out.left.insert(step, Cause::Displaced);
            self.lost(at, Cause::Displaced);
            return None;
        }
        let dof = self.choice.robot.dof();
        let given = |k: usize| target.values.get(k).map(|v| v.si);
        let named: AxisSet = self.free.axes().filter(|k| given(*k).is_some()).collect();
        let mut from = from;
        if let Some(last) = from.take_if(|_| !named.is_empty()) {
            self.find_again(&last, named);
        }
        // an axis without a value stays where it is; before a run that is what the moves before have said. A number in
        // the place of one that is not known would be written into new points. Only an axis that no target names
        // does not matter: it is not written.
        let before = |k: usize| from.as_ref().map(|q| q[k]).or(self.known.get(k).copied().flatten());
        let value = |k: usize| given(k).or_else(|| before(k));
        let free = self.free;
        let matters = |k: usize| !free.has(k) && self.is_commanded(k);
        if (0..dof).any(|k| value(k).is_none() && matters(k)) {
            self.known = (0..dof).map(value).collect();
            self.out.partial.push(step);
            return None;
        }
        let rest = |k: usize| self.rest.as_ref().filter(|_| free.has(k)).map(|q| q[k]);
        let q: Joints = (0..dof).map(|k| value(k).or_else(|| rest(k)).unwrap_or_default()).collect();
        // the moves before have not carried its offset: this one does not either
        let editable = Cause::of(m).is_none() && !(self.choice.excluded)(step) && self.known.is_empty();
        if !self.known.is_empty() && (!named.is_empty() || !m.unplaced.is_empty()) {
            self.out.left.insert(step, Cause::SideLost);
        }
        // nor is it the first that moves
        self.run.entry &= self.known.is_empty();
        self.known.clear();
        let curve = m.path == PathKind::Curve && !m.turns_known && !self.is_gantry();
        let other_way = m.other_way.filter(|_| m.path != PathKind::Joint);
        if from.is_some() && self.changes_to_joints(m) {
            self.run.changing.insert(step);
        }
        self.last_frame = None;
        let followed = match (&from, &m.circle) {
            (Some(_), _) if other_way.is_some() => Err(other_way.map_or(Cause::CurveToJoints, Cause::OtherWay)),
            (Some(from), Some(targets)) if !self.is_gantry() => self.on_circle(script, targets, m, from, &q),
            (Some(_), _) if curve => Err(Cause::CurveToJoints),
            (Some(from), _) => self.tool_of_way(m, from, &q).map(|tooled| (tooled, None)),
            (None, _) => Ok((None, None)),
        };
        match followed {
            Ok((tooled, via)) => {
                // an axis that no target names is not written
                let named = (0..dof).filter(|k| given(*k).is_some() || !self.is_commanded(*k)).collect();
                Some(Reached { from, q, named, editable, solved: false, tooled, via })
            }
            Err(why) => {
                // where it turns its joints is not known, and so not from which side it reaches the goal
                self.out.left.insert(step, why.clone());
                self.lost(at, why);
                self.start(step, q, false);
                None
            }
        }
    }

    /// Some joint target of the script names the axis.
    fn is_commanded(&self, axis: usize) -> bool {
        self.choice.commanded.get(axis).copied().unwrap_or(true)
    }

    /// How a move goes that leads to a point of an arc through joint targets: the tool, and a point on the way to all but the first. Where
    /// two threes of them may hold the way, joints have to come from the same sides on both.
    fn on_circle(
        &mut self,
        script: &Script,
        targets: &[usize],
        m: &Move,
        from: &[f64],
        to: &[f64],
    ) -> Result<ToolAndMiddle, Cause> {
        let dof = self.choice.robot.dof();
        let goal = m.goal.target().and_then(|own| targets.iter().position(|t| *t == own));
        let k = goal.ok_or(Cause::CurveToJoints)?;
        let mut ways: Vec<(Arc<Tooled>, Vector3<f64>)> = Vec::new();
        for start in circles::threes(targets.len(), k.max(1)) {
            let three: Vec<Vec<f64>> = targets[start..start + 3]
                .iter()
                .map(|t| script.targets.get(*t).and_then(|t| joints_of(t, dof)))
                .collect::<Option<_>>()
                .ok_or(Cause::CurveToJoints)?;
            let points = [&three[0][..], &three[1], &three[2]];
            let tooled = self.tool_of_circle(m, points)?;
            let middles = circles::middles(&tooled, points).ok_or(Cause::CurveToJoints)?;
            if k == 0 {
                return Ok((self.tool_of_way(m, from, to)?, None));
            }
            if points[k - 1 - start] != from {
                return Err(Cause::CurveToJoints);
            }
            ways.push((tooled, middles[k - 1 - start]));
        }
        let arrivals = |(tooled, via): &(Arc<Tooled>, Vector3<f64>)| {
            let line = way::Line::between(tooled, from, to, Some(*via))?;
            Some(line.arrivals(self.choice.deadband))
        };
        if ways.len() > 1 && !ways.windows(2).all(|w| arrivals(&w[0]) == arrivals(&w[1])) {
            return Err(Cause::CurveToJoints);
        }
        let (tooled, via) = ways.into_iter().next().ok_or(Cause::CurveToJoints)?;
        Ok((Some(tooled), Some(via)))
    }

    /// The robot with the tool whose TCP goes on an arc; where no tool turns on it, all its points go on arcs alike.
    fn tool_of_circle(&mut self, m: &Move, points: [&[f64]; 3]) -> Result<Arc<Tooled>, Cause> {
        let tool = m.tool.as_ref().ok_or(Cause::CurveToJoints)?;
        self.poses.unknown_arm.clone().map_or(Ok(()), Err)?;
        let rotations = points.map(|q| isometry(&self.plain.robot.forward(q)).rotation);
        let turns = (1..3).any(|k| rotations[0].angle_to(&rotations[k]) >= way::SAME_TURN);
        match self.poses.tool(tool) {
            Ok(tooled) => Ok(tooled),
            Err(_) if !turns => Ok(self.plain.clone()),
            Err(why) => {
                self.poses.waits_for(&why);
                Err(why)
            }
        }
    }

    /// The robot with the tool whose TCP goes straight to joint values; `None`: that of the robot file.
    fn tool_of_way(&mut self, m: &Move, from: &[f64], to: &[f64]) -> Result<Option<Arc<Tooled>>, Cause> {
        let Some(tool) = m.tool.as_ref().filter(|_| m.path == PathKind::Linear && !self.is_gantry()) else {
            return Ok(None);
        };
        self.poses.unknown_arm.clone().map_or(Ok(()), Err)?;
        let robot = &self.plain.robot;
        let turn = isometry(&robot.forward(from)).rotation.angle_to(&isometry(&robot.forward(to)).rotation);
        match self.poses.tool(tool) {
            Ok(tooled) => Ok(Some(tooled)),
            // where the tool does not turn, all its points go straight
            Err(_) if turn < SAME_TURN_RAD => Ok(None),
            Err(why) => {
                self.poses.waits_for(&why);
                Err(why)
            }
        }
    }

    /// All its axes are linear.
    pub(super) fn is_gantry(&self) -> bool {
        self.choice.robot.axis_joints().all(|j| j.kind == JointKind::Prismatic)
    }

    /// Joints of a Cartesian target, known also where the way to it is not, if its configuration names them.
    fn solve_pose(
        &mut self,
        goal: &PoseGoal,
        step: usize,
        at: At,
        m: &Move,
        from: &mut Option<Joints>,
    ) -> Option<(Vec<f64>, Place)> {
        // a straight way from joint values begins where the arm stands
        let unknown = self.poses.unknown_arm.clone().filter(|_| self.by_joints && m.path != PathKind::Joint);
        let solved = match unknown.filter(|_| from.is_some()) {
            Some(why) => Err(why),
            None => self.pose(goal, m, from.as_deref()),
        };
        let why = match solved {
            Ok(found) => {
                if m.path == PathKind::Joint && arm::is_ordered(goal) && !self.again {
                    self.over.extend(from.as_ref().filter(|q| found.1.goes_over(q, &found.0)).map(|_| step));
                }
                return Some(found);
            }
            Err(why) => why,
        };
        self.see_other_arm(goal, &why, m.path, from.as_deref());
        // a target whose configuration names its joints is known wherever the robot comes from
        let way_alone = matches!(why, Cause::NotReached | Cause::UnknownArm(_));
        let alone = from.as_ref().filter(|_| way_alone).and_then(|_| self.pose(goal, m, None).ok());
        if alone.is_some() {
            self.lost(at, if why == Cause::NotReached { Cause::NotFollowed } else { why });
            *from = None;
        } else {
            self.forget(m);
            self.poses.missing.posture += u64::from(why == Cause::NoStart && self.poses.posture.is_none());
            if matches!(why, Cause::NotConfigured | Cause::OtherArm | Cause::PerhapsOtherArm) {
                self.name_configurations(goal, at, from.as_deref());
            }
            self.out.left.insert(step, why.clone());
            self.lost(at, why);
        }
        alone
    }

    /// Notes the configurations that the robot has at a target whose own is none of them or another; of the first such targets.
    fn name_configurations(&mut self, goal: &PoseGoal, at: At, from: Option<&[f64]>) {
        const TARGETS: usize = 8;
        if self.named < TARGETS
            && let Ok(place) = self.poses.place(goal)
            && let Some(text) = place.configurations_text(goal, from)
            && !self.out.notes.iter().any(|n| n.text == text)
        {
            self.named += 1;
            self.out.notes.push(Note { place: at, text });
        }
    }

    /// Whether the way to a Cartesian target may be another one than that of its path; then directions are lost there.
    fn goes_another_way(
        &mut self,
        goal: &PoseGoal,
        step: usize,
        at: At,
        m: &Move,
        has_start: bool,
        place: &Place,
    ) -> bool {
        let own = [goal.frame.clone(), goal.tool.clone()];
        let here = LastFrame { name: goal.frame.name_at_rest(), rotation: place.frame.rotation, own };
        let before = self.last_frame.take();
        let same =
            |before: &LastFrame| before.name == here.name && before.rotation.angle_to(&here.rotation) < SAME_FRAME_RAD;
        // a unit that only shifts the part leaves a straight way straight
        let shifts = m.path == PathKind::Linear && before.as_ref().is_some_and(same);
        self.last_frame = Some(here);
        let way =
            m.other_way.filter(|way| m.path != PathKind::Joint && has_start && !(*way == OtherWay::Carried && shifts));
        let Some(way) = way else { return false };
        self.out.left.insert(step, Cause::OtherWay(way));
        self.lost(at, Cause::OtherWay(way));
        true
    }

    /// The joints at a Cartesian target, and whether its numbers may be written.
    pub(super) fn pose_goal(
        &mut self,
        goal: &PoseGoal,
        step: usize,
        at: At,
        m: &Move,
        mut from: Option<Joints>,
    ) -> Option<Reached> {
        let excluded = (self.choice.excluded)(step);
        let (q, place) = self.solve_pose(goal, step, at, m, &mut from)?;
        self.see_wrist(goal, from.is_some(), &place, &q);
        let q = Joints::from(q);
        self.run.entry &= self.known.is_empty();
        self.known.clear();
        let asked = self.choice.solve_within_m.is_some();
        let solved = asked && m.path == PathKind::Linear && m.is_open_to_goal() && !excluded && from.is_some();
        // joint moves from two starts keep no line
        let solved = solved && !self.run.entered.contains(&step);
        let changing = from.is_some() && self.changes_to(goal);
        let solved = solved && !(changing || goal.is_computed());
        if self.goes_another_way(goal, step, at, m, from.is_some(), &place) {
            self.start(step, q, false);
            return None;
        }
        // where a spline turns its joints is not known, nor an arc without a known start
        if m.path == PathKind::Curve && (goal.via_m.is_none() || from.is_none()) {
            self.out.left.insert(step, Cause::EndOfCurve);
            self.lost(at, Cause::Curve);
            self.run.entry = false;
            self.start(step, q, false);
            return None;
        }
        if changing {
            self.run.changing.insert(step);
        }
        let written = self.choice.as_poses && goal.target.is_some() && m.fixed.is_none();
        if let Some(why) = m.fixed.clone().filter(|_| !solved) {
            self.out.left.insert(step, Cause::Program(why));
        } else if goal.target.is_none() && !solved {
            self.out.left.insert(step, Cause::NoNumbers);
        }
        let named = place.axes_named(goal, q.len());
        self.run.places.insert(step, place);
        Some(Reached { from, q, named, editable: solved || written && !excluded, solved, tooled: None, via: None })
    }
}
