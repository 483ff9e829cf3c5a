//! Targets that are reached from one side (`--approach-from`): a point before each target at which the robot stops exactly.
//!
//! For drilling, probing and picking the last movement of a joint decides on which side of its gap it stands. Where a joint
//! comes to such a target from the other side, or its last movement is too short to cross the gap, or its direction is not known,
//! the robot first goes to a point that lies by the joint's whole lost motion on the wanted side: no further than what the gap
//! needs, [`MARGIN`] times what the compensator knows of it. Joints that come from the wanted side anyway do not move for it.
//!
//! The point is one of the run: offsets, limits and directions are those of a program that was written with it.
//!
//! The first target after a label, a loop or a call has no way before it in the program. There the joints come from the wanted side if the
//! point stands there whatever was before ([`Sides::first_point`]). With `--approach-unknown` joints for which no side is wanted come from
//! such sides that the point lies back along the tool's axis: a tool that works there is not pressed further in.

use super::cause::Cause;
use super::run::{Role, Run, Vertex};
use super::task::Task;
use crate::compensator::Compensator;
use crate::program::script::{AxisSet, Edits, Move, PathKind, Script, StepKind};
use crate::rewrite::Options;
use crate::rewrite::limits::step_s;
use crate::rewrite::offset::Offset;
use crate::robot::{Joint, JointKind, Robot};
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

/// The way to a target, in parts of the joint's whole lost motion.
const MARGIN: f64 = 1.5;
/// Share of the way to the target at which the report places the point.
pub(super) const SHARE: f64 = 0.95;
/// Share of the way after it.
pub const LEG: f64 = 1.0 - SHARE;

/// From which side each axis comes to its targets.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sides {
    /// +1 or -1 per axis, and the way in that direction, rad or m; 0: any.
    axes: Vec<(i8, f64)>,
    /// First targets of runs are reached from sides that are chosen where none is wanted.
    unknown: bool,
    /// Axes that a target does not name are written at its move, too, where a point before it has moved them. Else they would stay at that
    /// point.
    names_missing: bool,
    /// Steps of targets before which no point can stand: they are reached as the program says.
    without: BTreeSet<usize>,
    /// Steps of first targets that are reached over a point although it is known from where, as the ways there ask for different offsets,
    /// or although the program starts with them, as nothing moves after them that would tell a side.
    apart: BTreeSet<usize>,
}

impl Sides {
    /// `signs`: per axis, 0 for any; axes without a lost motion come as they come. `unknown`: first targets of runs are reached over a
    /// point. `names_missing`: [`Document::names_missing_axes`](crate::program::script::Document::names_missing_axes).
    pub fn new(
        robot: &Robot,
        signs: &[i8],
        (unknown, names_missing): (bool, bool),
        compensator: &Compensator,
        deadband: &[f64],
    ) -> Self {
        let of = |axis: usize| {
            // a shorter way would count as none
            let least = |step: f64| if step > 0.0 { step.max(deadband.get(axis).copied().unwrap_or(0.0)) } else { 0.0 };
            let way = compensator.on(axis).map_or(0.0, |j| MARGIN * least(Offset::new(j).largest_step()));
            (signs.get(axis).copied().filter(|_| way > 0.0).unwrap_or(0), way)
        };
        Self { axes: (0..robot.dof()).map(of).collect(), unknown, names_missing, ..Self::default() }
    }

    /// Some target is to be reached from a side.
    pub fn any(&self) -> bool {
        self.wanted() || self.unknown && self.axes.iter().any(|a| a.1 > 0.0)
    }

    /// The user wants a side of some joint.
    pub fn wanted(&self) -> bool {
        self.axes.iter().any(|a| a.0 != 0)
    }

    /// Whether the move leads to a target that has a side: it stops exactly, and a point may stand before it.
    pub fn count(&self, m: &Move) -> bool {
        self.any() && (m.blend_m == Some(0.0) || !m.waits.is_empty()) && m.path != PathKind::Curve
    }

    /// Whether the target of a step is reached as the program says, although it has a side.
    pub fn goes_without(&self, step: usize) -> bool {
        self.without.contains(&step)
    }

    /// The targets of these steps are reached as the program says.
    pub fn leave(&mut self, steps: impl IntoIterator<Item = usize>) {
        self.without.extend(steps);
    }

    /// The first target of this step is reached as if it were not known from where.
    pub fn is_apart(&self, step: usize) -> bool {
        self.apart.contains(&step) && !self.without.contains(&step)
    }

    /// Takes first targets apart that would need other offsets on each of the ways there or have no side, and gives those up for which that
    /// did not help; `left`: why steps stay as they are. Returns whether anything is new.
    pub fn take_apart(&mut self, script: &Script, left: &BTreeMap<usize, Cause>) -> bool {
        let counts = |step: &usize| match script.steps.get(*step).map(|s| &s.kind) {
            Some(StepKind::Move(m)) => m.is_open_to_goal() && self.count(m),
            _ => false,
        };
        let sides = |why: &Cause| matches!(why, Cause::PassesDiffer | Cause::SideUnknown);
        let differ = left.iter().filter(|(_, why)| sides(why)).map(|(step, _)| *step);
        let differ: Vec<usize> =
            differ.filter(|step| self.unknown && counts(step) && !self.goes_without(*step)).collect();
        let failed: Vec<usize> =
            self.apart.iter().copied().filter(|s| self.is_apart(*s) && left.contains_key(s)).collect();
        let fresh = differ.iter().any(|step| !self.apart.contains(step)) || !failed.is_empty();
        self.apart.extend(differ);
        self.without.extend(failed);
        fresh
    }

    /// The point before a target `q` whose vertices up to it are those of the run; `None`: it is reached from its side.
    pub fn point(&self, robot: &Robot, run: &Run, directions: &Directions, q: &[f64]) -> Option<Vec<f64>> {
        let from = run.vertices.last()?;
        let (mut last, mut goal) = (from.q.to_vec(), q.to_vec());
        robot.to_gears(&mut last);
        robot.to_gears(&mut goal);
        let mut point = goal.clone();
        for (axis, (sign, way)) in self.axes.iter().enumerate().filter(|(_, a)| a.0 != 0) {
            let leg = f64::from(*sign) * (goal[axis] - last[axis]);
            let came = directions.of(axis) == *sign;
            // far enough in the wanted direction, or on in it, or at rest after it
            if leg >= *way || came && leg >= 0.0 {
                continue;
            }
            point[axis] = goal[axis] - f64::from(*sign) * way;
        }
        let moves = point != goal;
        robot.from_gears(&mut point);
        moves.then_some(point)
    }

    /// The point before the target `q` of a move ([`Self::point`]). Where it is known that the robot stops as the program waits there, axes
    /// that the move does not move stay where they are: they may stand in the work, and what stopped them before is not known. So do axes
    /// that the target does not name: `named` are those that it does.
    pub fn point_of(
        &self,
        (m, named): (&Move, AxisSet),
        robot: &Robot,
        run: &Run,
        directions: &Directions,
        q: &[f64],
    ) -> Option<Vec<f64>> {
        let mut point = self.point(robot, run, directions, q)?;
        for (axis, v) in point.iter_mut().enumerate().filter(|(axis, _)| !self.moves(m, named, *axis)) {
            *v = q.get(axis).copied().unwrap_or(*v);
        }
        (point != q).then_some(point)
    }

    /// The point before a target `q` to which the robot may come from anywhere; `None`: some joint has no side, or there is no room for the
    /// point within the limits.
    ///
    /// Of all choices of the sides that are free it is the one that lies back along the axis of the tool (z of the TCP's frame, out of the
    /// flange), as little aside as they allow. `unplaced`: axes whose numbers are not those of the machine.
    pub fn first_point(&self, robot: &Robot, unplaced: AxisSet, q: &[f64]) -> Option<Vec<f64>> {
        /// Joints with lost motion at most: each doubles the choices.
        const MOST: usize = 10;
        let free: Vec<usize> = (0..self.axes.len()).filter(|k| self.axes[*k].0 == 0 && self.axes[*k].1 > 0.0).collect();
        let arm = robot.axis_joints().any(|j| j.kind == JointKind::Revolute);
        // the axis of a gantry's tool points in or out, as its maker likes
        let chosen = free.is_empty() || self.unknown && arm;
        if !chosen || free.len() > MOST || !self.any() {
            return None;
        }
        let (there, mut gears) = (robot.forward(q), q.to_vec());
        robot.to_gears(&mut gears);
        let axis = there.rotation * Vector3::z();
        let mut best: Option<(f64, Vec<f64>)> = None;
        for choice in 0..1usize << free.len() {
            let chosen = |k: usize| {
                free.iter().position(|f| *f == k).map_or(1.0, |n| if choice >> n & 1 == 0 { 1.0 } else { -1.0 })
            };
            // on the wanted side, and where the goal comes to stand with its offset
            let (mut point, mut end) = (gears.clone(), gears.clone());
            for (k, (sign, way)) in self.axes.iter().enumerate() {
                let sign = if *sign == 0 { chosen(k) } else { f64::from(*sign) };
                point[k] -= sign * way;
                end[k] += sign * way / MARGIN;
            }
            robot.from_gears(&mut point);
            robot.from_gears(&mut end);
            let by = robot.tcp_m(&point) - there.position;
            let along = by.dot(&axis);
            let aside = (by - along * axis).norm();
            let into = !free.is_empty() && along > aside * 1e-6;
            let better = best.as_ref().is_none_or(|(least, _)| aside < *least - 1e-12);
            if !into && better && [&point, &end].iter().all(|q| within_limits(robot, unplaced, q)) {
                best = Some((aside, point));
            }
        }
        best.map(|(_, point)| point)
    }

    /// A point before the goal of a move may move the axis; `named`: axes that its target names.
    fn moves(&self, m: &Move, named: AxisSet, axis: usize) -> bool {
        (self.names_missing || named.has(axis)) && (m.blend_m == Some(0.0) || m.waits.has(axis))
    }

    /// Whether a first point may move all axes before the goal of a move.
    pub(super) fn moves_all(&self, m: &Move, named: AxisSet, axes: usize) -> bool {
        (0..axes).all(|axis| self.moves(m, named, axis))
    }

    /// Whether a move leads to a target that has a side, but does not name all axes for which one is wanted. `commanded`: axes that some
    /// target names.
    pub fn lacks_axes(&self, script: &Script, m: &Move, commanded: &[bool]) -> bool {
        let Some(target) = m.goal.target().and_then(|t| script.targets.get(t)).filter(|t| t.pose.is_none()) else {
            return false;
        };
        let wanted = |axis: &usize| self.axes[*axis].0 != 0 && commanded.get(*axis).copied().unwrap_or(false);
        let missing = (0..self.axes.len()).filter(wanted).any(|axis| target.values.get(axis).is_none());
        missing && !self.names_missing && self.count(m)
    }

    /// The vertex of such a point.
    pub fn vertex(&self, goal: &Vertex, t_s: f64, q: Vec<f64>) -> Vertex {
        Vertex { role: Role::Approach, q: q.into(), share: SHARE, t_s, ..goal.clone() }
    }
}

/// Each axis is within its limits, as far as its numbers are those of the machine.
fn within_limits(robot: &Robot, unplaced: AxisSet, q: &[f64]) -> bool {
    let inside = |(axis, (joint, v)): (usize, (&Joint, &f64))| {
        unplaced.has(axis) || joint.limits.is_none_or(|[low, high]| *v >= low && *v <= high)
    };
    robot.axis_joints().zip(q).enumerate().all(inside)
}

/// Steps whose point of approach is not written (too many points, a process, ways that need different ones, a format that cannot say it):
/// without it a joint comes from the other side, and the offset for the wanted one would double its error.
pub fn unwritten(runs: &[Run], edits: &Edits) -> BTreeSet<usize> {
    let written = |step: usize| {
        edits.steps.get(step).is_some_and(|edit| edit.before.iter().any(|p| p.share == SHARE && !p.of_way))
    };
    let points = runs.iter().flat_map(|r| &r.vertices).filter(|v| v.role == Role::Approach);
    points.map(|v| v.step).filter(|step| !written(*step)).collect()
}

/// Time in which each axis crosses its gap where the robot stands, s; 0: it has none.
///
/// None where the user says how far the steps go.
pub fn crossing_s(task: &Task) -> Vec<f64> {
    let Options { step_exact, ramp, .. } = task.options;
    if *step_exact || ramp.iter().any(|r| *r > 0.0) {
        return Vec::new();
    }
    let of = |(axis, joint): (usize, &Joint)| {
        let step = task.compensator.on(axis).map_or(0.0, |j| task.options.gain * Offset::new(j).largest_step());
        if step > 0.0 { step_s(joint, step) } else { 0.0 }
    };
    task.robot.axis_joints().enumerate().map(of).collect()
}

/// Directions in which the gears moved last.
#[derive(Debug, Clone, Default)]
pub struct Directions {
    last: Vec<f64>,
    signs: Vec<i8>,
    /// Where the gears stand now: room that is kept.
    here: Vec<f64>,
}

impl Directions {
    /// Some gear has moved.
    pub fn any(&self) -> bool {
        self.signs.iter().any(|s| *s != 0)
    }

    /// Nothing is known any more.
    pub fn forget(&mut self) {
        self.last.clear();
        self.signs.clear();
    }

    /// The robot goes on to `q`; movement within `deadband` (per axis) is none.
    pub fn go(&mut self, robot: &Robot, q: &[f64], deadband: &[f64]) {
        self.here.clear();
        self.here.extend_from_slice(q);
        robot.to_gears(&mut self.here);
        if self.last.len() != self.here.len() {
            self.signs = vec![0; self.here.len()];
            self.last.clone_from(&self.here);
            return;
        }
        for (axis, v) in self.here.iter().enumerate() {
            let by = v - self.last[axis];
            if by.abs() > deadband.get(axis).copied().unwrap_or(0.0) {
                self.signs[axis] = if by > 0.0 { 1 } else { -1 };
                self.last[axis] = *v;
            }
        }
    }

    /// -1 or +1; 0: not known.
    pub(super) fn of(&self, axis: usize) -> i8 {
        self.signs.get(axis).copied().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::script::{Few, Goal, How};

    fn robot() -> Robot {
        let text = "schema: lostmotion/robot/1\nname: a\njoints:\n  - {name: X, kind: prismatic}\n  - {name: Y, kind: prismatic}\n";
        Robot::parse("r.yaml", text).unwrap()
    }

    fn at(q: [f64; 2]) -> Vertex {
        Vertex {
            step: 0,
            role: Role::Goal,
            q: q[..].into(),
            share: 1.0,
            editable: true,
            t_s: 0.0,
            certain: true,
            again: false,
        }
    }

    #[test]
    fn a_joint_goes_back_by_its_lost_motion_only_where_it_comes_from_the_other_side() {
        let robot = robot();
        let sides = Sides { axes: vec![(1, 0.01), (-1, 0.02)], ..Sides::default() };
        let band = [1e-6; 2];
        let mut directions = Directions::default();
        let run = |q| Run { vertices: vec![at(q)], ..Run::default() };
        directions.go(&robot, &[0.0, 0.0], &band);
        // up, down: both as wanted
        assert_eq!(sides.point(&robot, &run([0.0, 0.0]), &directions, &[0.5, -0.5]), None);
        // too short a way, and its direction before it is not known
        let point = sides.point(&robot, &run([0.0, 0.0]), &directions, &[0.005, -0.5]).unwrap();
        assert!((point[0] + 0.005).abs() < 1e-12 && point[1] == -0.5, "{point:?}");
        directions.go(&robot, &[0.5, -0.5], &band);
        // it came up already: a little further is enough, and so is rest
        assert_eq!(sides.point(&robot, &run([0.5, -0.5]), &directions, &[0.505, -0.5]), None);
        // the other way: beyond the target, and back
        let point = sides.point(&robot, &run([0.5, -0.5]), &directions, &[0.2, -0.2]).unwrap();
        assert!((point[0] - 0.19).abs() < 1e-12 && (point[1] + 0.18).abs() < 1e-12, "{point:?}");
        // an axis that the target does not name would stay where the point is
        let stops = Move::new(How { blend_m: Some(0.0), ..How::default() }, Goal::Joints(0), Few::new());
        let of = |sides: &Sides, named: &[usize]| {
            let named = named.iter().copied().collect();
            sides.point_of((&stops, named), &robot, &run([0.5, -0.5]), &directions, &[0.2, -0.2])
        };
        let alone = of(&sides, &[0]).unwrap();
        assert!((alone[0] - 0.19).abs() < 1e-12 && alone[1] == -0.2, "{alone:?}");
        assert_eq!(of(&sides, &[]), None);
        // unless the format writes it at the move
        let written = Sides { names_missing: true, ..sides.clone() };
        assert_eq!(of(&written, &[0]), Some(point));
    }
}
