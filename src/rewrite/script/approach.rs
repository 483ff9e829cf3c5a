//! Targets that are reached from one side (`--approach-from`): a point before each target at which the robot stops exactly.
//!
//! For drilling, probing and picking the last movement of a joint decides on which side of its gap it stands. Where a joint
//! comes to such a target from the other side, or its last movement is too short to cross the gap, or its direction is not known,
//! the robot first goes to a point that lies by the joint's whole lost motion on the wanted side: no further than what the gap
//! needs, [`MARGIN`] times what the compensator knows of it. Joints that come from the wanted side anyway do not move for it.
//!
//! The point is one of the run: offsets, limits and directions are those of a program that was written with it.

use super::run::{Role, Run, Vertex};
use super::task::Task;
use crate::compensator::Compensator;
use crate::program::script::{Edits, Move, PathKind};
use crate::rewrite::Options;
use crate::rewrite::limits::step_s;
use crate::rewrite::offset::Offset;
use crate::robot::{Joint, Robot};
use std::collections::BTreeSet;

/// The way to a target, in parts of the joint's whole lost motion.
const MARGIN: f64 = 1.5;
/// Share of the way to the target at which the report places the point.
const SHARE: f64 = 0.95;

/// From which side each axis comes to its targets.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sides {
    /// +1 or -1 per axis, and the way in that direction, rad or m; 0: any.
    axes: Vec<(i8, f64)>,
    /// Steps of targets before which no point can stand: they are reached as the program says.
    without: BTreeSet<usize>,
}

impl Sides {
    /// `signs`: per axis, 0 for any; axes without a lost motion come as they come.
    pub fn new(signs: &[i8], compensator: &Compensator) -> Self {
        let of = |(axis, sign): (usize, &i8)| {
            let way = compensator.on(axis).map_or(0.0, |j| MARGIN * Offset::new(j).largest_step());
            (if way > 0.0 { *sign } else { 0 }, way)
        };
        Self { axes: signs.iter().enumerate().map(of).collect(), without: BTreeSet::new() }
    }

    pub fn any(&self) -> bool {
        self.axes.iter().any(|a| a.0 != 0)
    }

    /// Whether the move leads to a target that has a side: it stops exactly, and a point may stand before it.
    pub fn count(&self, m: &Move) -> bool {
        self.any() && m.blend_m == Some(0.0) && m.path != PathKind::Curve
    }

    /// Whether the target of a step is reached as the program says, although it has a side.
    pub fn goes_without(&self, step: usize) -> bool {
        self.without.contains(&step)
    }

    /// The targets of these steps are reached as the program says.
    pub fn leave(&mut self, steps: impl IntoIterator<Item = usize>) {
        self.without.extend(steps);
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

    /// The vertex of such a point.
    pub fn vertex(&self, goal: &Vertex, t_s: f64, q: Vec<f64>) -> Vertex {
        Vertex { role: Role::Approach, q: q.into(), share: SHARE, t_s, ..goal.clone() }
    }
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
    }
}
