//! Joints with their offsets as numbers of Cartesian targets, and which targets cannot hold theirs.

use super::super::cause::Cause;
use super::super::configuration::allows;
use super::super::edits::Unplaced;
use super::super::run::{Role, Run};
use super::Place;
use super::solve::within;
use crate::program::script::pose::{PoseForm, PoseGoal, Quantity, Solution};
use crate::program::script::{Edits, Goal, Move, Script, StepKind};
use crate::robot::JointKind;
use std::collections::BTreeMap;

/// How far joints with their offset must keep clear of the borders of their configuration, rad: the digits that are written.
const CLEAR: f64 = 2e-5;
/// Half a last digit of a pose may move a joint by so much at most, rad.
const LOST_RAD: f64 = 1e-3;

impl Place {
    /// Numbers of a pose target whose joints move from `q` to `to`; `own`: the numbers that stand there.
    pub fn shifted(&self, goal: &PoseGoal, form: PoseForm, own: &[f64], q: &[f64], to: &[f64]) -> Option<Vec<f64>> {
        let (from, to) = (self.arm_at(q), self.arm_at(to));
        let meant = goal.meant(&form.pose(own)?) * (from.inverse() * to);
        Some(form.coordinates(&goal.numbers(&meant), own))
    }

    /// Numbers of a pose at joints; `near`: numbers of a pose nearby.
    pub fn written(&self, goal: &PoseGoal, form: PoseForm, q: &[f64], near: &[f64]) -> Vec<f64> {
        form.coordinates(&goal.numbers(&(self.frame.inverse() * self.arm_at(q))), near)
    }

    /// The TCP in the frame of the target, m.
    pub fn position(&self, q: &[f64]) -> Vec<f64> {
        (self.frame.inverse() * self.arm_at(q)).translation.vector.iter().copied().collect()
    }

    /// Why joints with their offset cannot be written as this target.
    ///
    /// # Errors
    /// Why not.
    pub fn may_be(&self, goal: &PoseGoal, q: &[f64], digit: f64) -> Result<(), Cause> {
        let robot = &self.tooled.robot;
        within(robot, q)?;
        if let (Some(arm), Solution::Configured(c), true) = (&self.tooled.arm, &goal.solution, goal.binding)
            && !allows(c, arm, q, -CLEAR)
        {
            return Err(Cause::Border);
        }
        if let (Some(arm), Solution::Near(near), true) = (&self.tooled.arm, &goal.solution, goal.binding)
            && !self.is_next_to(arm, near, q)
        {
            return Err(Cause::NamedJoints);
        }
        // half a last digit of the pose, as joints
        if robot.dof() >= 6 && robot.axis_joints().all(|j| j.kind == JointKind::Revolute) {
            let (_, jacobian) = robot.chain().jacobian(q);
            let least = jacobian.singular_values().min();
            if 0.5 * digit > LOST_RAD * least {
                return Err(Cause::Singular);
            }
        }
        Ok(())
    }
}

/// Numbers of a pose target as they stand there, in SI.
pub fn own_numbers(script: &Script, goal: &PoseGoal) -> Option<(PoseForm, Vec<f64>)> {
    let target = script.targets.get(goal.target?)?;
    let form = target.pose?;
    let values: Option<Vec<f64>> = target.values.iter().map(|v| v.map(|v| v.si)).collect();
    values.filter(|v| v.len() == form.count()).map(|v| (form, v))
}

/// Makes poses of the edits of Cartesian targets, which are joints until here. An edit that its target cannot hold goes, and
/// `left` says why, and new points that have to go are `unplaced`.
pub fn write(
    script: &Script,
    runs: &[Run],
    edits: &mut Edits,
    left: &mut BTreeMap<usize, Cause>,
    unplaced: &mut Unplaced,
) {
    for run in runs {
        for vertex in run.vertices.iter().filter(|v| v.role == Role::Goal) {
            let Some(StepKind::Move(Move { goal: Goal::Pose(goal), .. })) =
                script.steps.get(vertex.step).map(|s| &s.kind)
            else {
                continue;
            };
            if edits.steps.get(vertex.step).is_none_or(|e| e.as_joint_moves) {
                continue;
            }
            let (Some(place), Some((form, own))) = (run.places.get(&vertex.step), own_numbers(script, goal)) else {
                edits.steps.remove(vertex.step);
                continue;
            };
            let Some(mut edit) = edits.steps.remove(vertex.step) else { continue };
            let digit = finest_angle(script, goal);
            let mut gone = 0;
            let all = edit.before.iter().map(|p| &p.q).chain(&edit.vias).chain(&edit.goal);
            if !edit.vias.is_empty() && all.clone().any(|q| place.may_be(goal, q, digit).is_err()) {
                // of a split arc no point may miss
                gone += edit.clear_points();
            }
            edit.before.retain_mut(|point| {
                let may = place.may_be(goal, &point.q, digit).is_ok();
                if may {
                    point.q = place.written(goal, form, &point.q, &own);
                }
                gone += u64::from(!may);
                may
            });
            unplaced.lose(script, vertex.step, gone);
            if let Some(q) = edit.goal.take() {
                match place.may_be(goal, &q, digit) {
                    Ok(()) => edit.goal = place.shifted(goal, form, &own, &vertex.q, &q),
                    Err(why) => drop(left.insert(vertex.step, why)),
                }
            }
            if edit.goal.is_some() || !edit.before.is_empty() || edit.blend_at_most_m.is_some() {
                edits.steps.insert(vertex.step, edit);
            }
        }
    }
}

/// Weight of the finest digit of the coarsest angle of a target, rad (of a quaternion's parts twice that).
fn finest_angle(script: &Script, goal: &PoseGoal) -> f64 {
    let Some(target) = goal.target.and_then(|t| script.targets.get(t)) else { return 0.0 };
    let factor = |k: usize| match target.pose.map(|f| f.quantity(k)) {
        Some(Quantity::Angle) => 1.0,
        Some(Quantity::Ratio) => 2.0,
        _ => 0.0,
    };
    target.values.iter().enumerate().filter_map(|(k, v)| Some(v?.finest * factor(k))).fold(0.0, f64::max)
}
