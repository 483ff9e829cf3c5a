//! Joints with their offsets as numbers of Cartesian targets, and which targets cannot hold theirs.

use super::super::cause::Cause;
use super::super::configuration::{CLEAR, prefers, stands};
use super::super::run::Run;
use super::super::unplaced::Unplaced;
use super::Place;
use super::borders::{Held, Rounding};
use super::solve::within;
use crate::program::script::pose::{PoseForm, PoseGoal, Solution};
use crate::program::script::{Edit, Edits, Goal, NewPoint, PathKind, Script, StepKind};
use crate::rewrite::engine::NOTHING;
use std::collections::BTreeMap;

impl Place {
    /// Numbers of a pose target whose joints move from `q` to `to`; `own`: the numbers that stand there.
    pub fn shifted(&self, goal: &PoseGoal, form: PoseForm, own: &[f64], q: &[f64], to: &[f64]) -> Option<Vec<f64>> {
        let joints = [q, to];
        let [from, to] = joints.map(|q| self.arm_at(q));
        let (pose, beside) = own.split_at_checked(form.count())?;
        let meant = goal.meant(&form.pose(pose)?) * (from.inverse() * to);
        let mut numbers = form.coordinates(&goal.numbers(&meant), pose);
        // external axes have their own numbers
        numbers.extend(beside.iter().zip(goal.placed()).map(|(own, p)| own + joints[1][p.axis] - joints[0][p.axis]));
        Some(numbers)
    }

    /// Numbers of a pose at joints; `near`: numbers of a pose nearby.
    pub fn written(&self, goal: &PoseGoal, form: PoseForm, q: &[f64], near: &[f64]) -> Vec<f64> {
        let mut numbers = form.coordinates(&goal.numbers(&(self.frame.inverse() * self.arm_at(q))), near);
        numbers.extend(goal.placed().iter().map(|p| q[p.axis]));
        numbers
    }

    /// The TCP in the frame of the target, m.
    pub fn position(&self, q: &[f64]) -> Vec<f64> {
        (self.frame.inverse() * self.arm_at(q)).translation.vector.iter().copied().collect()
    }

    /// Why joints with their offset cannot be written as this target.
    ///
    /// # Errors
    /// Why not.
    pub fn may_be(&self, goal: &PoseGoal, q: &[f64], rounding: Rounding) -> Result<(), Cause> {
        let robot = &self.tooled.robot;
        within(robot, q)?;
        if let Some((alone, count)) = self.alone(q) {
            return alone.may_be(goal, &q[count..], rounding);
        }
        if let (Some(arm), Solution::Configured(c), true) = (&self.tooled.arm, &goal.solution, goal.binding)
            && !stands(c, arm, q, -CLEAR)
        {
            return Err(Cause::Border);
        }
        if let (Some(arm), Solution::Near(near), true) = (&self.tooled.arm, &goal.solution, goal.binding)
            && !self.is_next_to(arm, near, q)
        {
            return Err(Cause::NamedJoints);
        }
        self.determined(q, rounding)
    }
}

/// A target into which joints with their offsets are to be written.
struct Written<'a> {
    place: &'a Place,
    goal: &'a PoseGoal,
    on_way: bool,
    rounding: Rounding,
}

impl Written<'_> {
    /// Joints `to`, with their offsets, as its numbers may hold them; `q`: without offsets.
    ///
    /// # Errors
    /// Why not.
    fn holds(&self, q: &[f64], to: &[f64]) -> Result<Vec<f64>, Cause> {
        self.holds_external(q, to)?;
        let kept = self.place.held(self.goal, self.on_way, [q, to], self.rounding)?;
        self.place.may_be(self.goal, &kept, self.rounding)?;
        Ok(kept)
    }

    /// An external axis with an offset has its number here: an axis that the target does not name stays where it was put before.
    ///
    /// # Errors
    /// One has none.
    fn holds_external(&self, q: &[f64], to: &[f64]) -> Result<(), Cause> {
        let count = self.place.tooled.carried.as_ref().map_or(0, |c| c.count);
        let named = |axis: &usize| self.goal.placed().iter().any(|p| p.axis == *axis);
        let moved = |axis: &usize| (to[*axis] - q[*axis]).abs() > NOTHING;
        if (0..count).filter(|axis| !named(axis)).any(|axis| moved(&axis)) {
            return Err(Cause::ExternalUnnamed);
        }
        Ok(())
    }

    /// Whether joints on the way have what the letters of the target say of the wrist as its own joints do: a new point has its letters.
    fn has_letters(&self, own: &[f64], q: &[f64]) -> bool {
        match (self.place.tooled.arm_of(own), self.place.tooled.arm_of(q), &self.goal.solution) {
            (Some((arm, _, own)), Some((_, _, q)), Solution::Configured(c)) => {
                prefers(c, arm, own, self.place.flip) == prefers(c, arm, q, self.place.flip)
            }
            _ => true,
        }
    }

    /// Keeps the new points of an edit, in joints, that its target's kind can hold; `own`: joints of the target, `plan`: joints without
    /// offsets by the share of the way. Returns how many go.
    fn keep_points(&self, edit: &mut Edit, own: &[f64], plan: impl Fn(f64) -> Option<Vec<f64>>) -> u64 {
        let holds = |p: &NewPoint| {
            let q = plan(p.share).filter(|q| self.has_letters(own, q))?;
            self.holds(&q, &p.q).ok()
        };
        // of a split arc no point may miss
        let whole = || {
            let stays = |q: &Vec<f64>| self.holds(q, q).is_ok();
            edit.before.iter().all(|p| holds(p).is_some()) && edit.vias.iter().chain(&edit.goal).all(stays)
        };
        if !edit.vias.is_empty() && !whole() {
            return edit.clear_points();
        }
        let all = edit.before.len();
        edit.before.retain_mut(|point| holds(point).map(|q| point.q = q).is_some());
        (all - edit.before.len()) as u64
    }
}

/// Numbers of a pose target as they stand there, in SI.
pub fn own_numbers(script: &Script, goal: &PoseGoal) -> Option<(PoseForm, Vec<f64>)> {
    let target = script.targets.get(goal.target?)?;
    let form = target.pose?;
    let values: Option<Vec<f64>> = target.values.iter().map(|v| v.map(|v| v.si)).collect();
    values.filter(|v| v.len() == form.count() + goal.placed().len()).map(|v| (form, v))
}

/// Makes poses of the edits of Cartesian targets, which are joints until here and stay joints in the copy that is returned. An edit that
/// its target cannot hold goes, and `left` says why, and new points that have to go are `unplaced`; `held`: joints that lack offsets.
pub fn write(
    script: &Script,
    runs: &[Run],
    edits: &mut Edits,
    left: &mut BTreeMap<usize, Cause>,
    unplaced: &mut Unplaced,
    held: &mut Held,
) -> Edits {
    let mut joints = edits.clone();
    for run in runs {
        for leg in run.legs() {
            let vertex = leg.goal;
            let Some(StepKind::Move(m)) = script.steps.get(vertex.step).map(|s| &s.kind) else { continue };
            let Goal::Pose(goal) = &m.goal else {
                continue;
            };
            if edits.steps.get(vertex.step).is_none_or(|e| e.as_joint_moves) {
                continue;
            }
            let edit = edits.steps.remove(vertex.step);
            joints.steps.remove(vertex.step);
            let (Some(place), Some((form, own)), Some(mut edit)) =
                (run.places.get(&vertex.step), own_numbers(script, goal), edit)
            else {
                continue;
            };
            let numbers = goal.target.and_then(|t| script.targets.get(t));
            let rounding = Rounding::of(numbers.as_ref(), edits);
            let target = Written { place, goal, on_way: m.path != PathKind::Joint, rounding };
            let gone = target.keep_points(&mut edit, &vertex.q, |share| leg.plan(share));
            unplaced.lose(script, vertex.step, gone);
            if let Some(q) = edit.goal.take() {
                match target.holds(&vertex.q, &q) {
                    Ok(kept) => {
                        held.count(script.steps[vertex.step].at, &vertex.q, &q, &kept);
                        edit.goal = Some(kept);
                    }
                    Err(why) => drop(left.insert(vertex.step, why)),
                }
            }
            if edit.goal.is_none() && edit.before.is_empty() && edit.blend_at_most_m.is_none() {
                continue;
            }
            joints.steps.insert(vertex.step, edit.clone());
            for point in &mut edit.before {
                point.q = place.written(goal, form, &point.q, &own);
            }
            edit.goal = edit.goal.and_then(|q| place.shifted(goal, form, &own, &vertex.q, &q));
            edits.steps.insert(vertex.step, edit);
        }
    }
    joints
}

#[cfg(test)]
mod tests {
    use super::super::Tooled;
    use super::*;
    use crate::program::script::pose::{Configuration, Frame};
    use crate::robot::Robot;
    use nalgebra::Isometry3;
    use std::sync::Arc;

    /// A FANUC's wrist goes through J5 = 0 on its way: before it, a point with the letter of the target would stand on the other side.
    #[test]
    fn no_point_before_the_wrist_has_turned_over_takes_the_letter_of_the_target() {
        let robot = Robot::parse("r", include_str!("../../../../configs/fanuc-m10ia.yaml")).unwrap();
        let tooled = Arc::new(Tooled::new(&robot, Isometry3::identity()));
        let place =
            Place { tooled, frame: Isometry3::identity(), posture: None, by_order: true, lettered: false, flip: None };
        let solution = Solution::Configured(Configuration::Fanuc { flip: true, up: true, front: true, turns: [0; 3] });
        let goal = PoseGoal { frame: Frame::Null, tool: Frame::Null, solution, binding: true, ..PoseGoal::default() };
        let target = Written { place: &place, goal: &goal, on_way: false, rounding: Rounding::default() };
        let q = |j5: f64| [5.0, 10.0, 20.0, 10.0, j5, 20.0].map(f64::to_radians).to_vec();
        assert!(target.has_letters(&q(8.0), &q(2.0)));
        assert!(!target.has_letters(&q(8.0), &q(-2.0)));
        // where the letter means the other side, it is the same
        assert!(target.has_letters(&q(-8.0), &q(-2.0)) && !target.has_letters(&q(-8.0), &q(2.0)));
    }
}
