//! How long the new exact stops of a program take.
//!
//! Method: a robot that passes a point with joint speeds `w` and stops there instead loses `w / a` of the joint that takes longest
//! (half of it before the point, half after), `a` being the joint's largest acceleration. The speeds are the mean ones of the
//! move. Controllers round such corners in their own way, so that this is an estimate.

use super::run::{Role, Run, Vertex};
use super::verify::Halt;
use crate::robot::Robot;

/// Time that one stop on the way to the goal of each step takes.
#[derive(Debug)]
pub struct Stops {
    /// Steps, in order, and the time of each, s; NaN: the speed of the move, or the acceleration of a joint that moves there, is not known.
    steps: Vec<u32>,
    times_s: Vec<f64>,
}

impl Stops {
    pub fn of(robot: &Robot, runs: &[Run]) -> Self {
        let most = runs.iter().map(|run| run.vertices.len()).sum();
        let mut all = Self { steps: Vec::with_capacity(most), times_s: Vec::with_capacity(most) };
        for run in runs {
            let mut start = None;
            for v in run.vertices.iter().filter(|v| !matches!(v.role, Role::Way | Role::Crossing)) {
                if v.role == Role::Goal {
                    let start = start.filter(|_| run.timed());
                    debug_assert!(all.steps.last().is_none_or(|last| *last <= v.step as u32));
                    all.steps.push(v.step as u32);
                    all.times_s.push(start.and_then(|start| one_s(robot, start, v)).unwrap_or(f64::NAN));
                }
                start = Some(v);
            }
        }
        all
    }

    /// Time that the stops take, s; `None`: that of one is not known.
    pub fn duration_s(&self, halts: &[Halt]) -> Option<f64> {
        let one = |step: usize| {
            let k = self.steps.partition_point(|s| (*s as usize) < step);
            self.steps.get(k).filter(|s| **s as usize == step)?;
            self.times_s.get(k).copied().filter(|s| !s.is_nan())
        };
        halts.iter().map(|h| Some(h.stops as f64 * one(h.step)?)).sum()
    }
}

/// Time that one stop on the way from `start` to `goal` takes, s.
fn one_s(robot: &Robot, start: &Vertex, goal: &Vertex) -> Option<f64> {
    let duration_s = goal.t_s - start.t_s;
    let lost = |(axis, joint): (usize, &crate::robot::Joint)| {
        let way = (goal.q[axis] - start.q[axis]).abs();
        match joint.max_accel {
            _ if way == 0.0 => Some(0.0),
            Some(a) if duration_s > 0.0 => Some(way / duration_s / a),
            _ => None,
        }
    };
    robot.axis_joints().enumerate().map(lost).try_fold(0.0, |most: f64, s| Some(most.max(s?)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::script::At;

    #[test]
    fn a_stop_costs_the_speed_over_the_acceleration_of_the_slowest_joint() {
        let text = "schema: lostmotion/robot/1\nname: a\njoints:\n  - {name: X, kind: prismatic, max_accel_mm_s2: 2000}\n  - {name: Y, kind: prismatic, max_accel_mm_s2: 500}\n";
        let robot = Robot::parse("r.yaml", text).unwrap();
        let vertex = |step, q: [f64; 2], t_s| Vertex {
            step,
            role: Role::Goal,
            q: q[..].into(),
            share: 1.0,
            editable: true,
            t_s,
            certain: true,
            again: false,
        };
        let run = Run { vertices: vec![vertex(0, [0.0, 0.0], 0.0), vertex(1, [0.2, 0.1], 1.0)], ..Run::default() };
        let halts = [Halt { step: 1, at: At::default(), stops: 3 }];
        // X: 200 / 2000 = 0.1 s, Y: 100 / 500 = 0.2 s
        let s = Stops::of(&robot, std::slice::from_ref(&run)).duration_s(&halts).unwrap();
        assert!((s - 0.6).abs() < 1e-12, "{s}");
        let unknown = Run { untimed: Some(At::default()), ..run };
        assert_eq!(Stops::of(&robot, &[unknown]).duration_s(&halts), None);
    }
}
