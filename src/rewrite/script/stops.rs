//! How long the new exact stops of a program take.
//!
//! Method: a robot that passes a point with joint speeds `w` and stops there instead loses `w / a` of the joint that takes longest
//! (half of it before the point, half behind), `a` being the joint's largest acceleration. The speeds are the mean ones of the
//! move. Controllers round such corners in their own way, so that this is an estimate.

use super::run::{Role, Run};
use super::verify::Halt;
use crate::robot::Robot;

/// Time that the stops take, s; `None`: the speed of a move, or the acceleration of a joint that moves there, is not known.
pub fn duration_s(robot: &Robot, runs: &[Run], halts: &[Halt]) -> Option<f64> {
    halts.iter().map(|h| Some(h.stops as f64 * one_s(robot, runs, h.step)?)).sum()
}

/// Time that one stop on the way to the goal of `step` takes, s.
fn one_s(robot: &Robot, runs: &[Run], step: usize) -> Option<f64> {
    let found = runs.iter().find_map(|run| {
        let k = run.vertices.iter().position(|v| v.step == step && v.role == Role::Goal)?;
        Some((run, k))
    });
    let (run, k) = found.filter(|(run, _)| run.timed())?;
    let goal = &run.vertices[k];
    let start = run.vertices[..k].iter().rev().find(|v| v.role != Role::Way)?;
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
    use crate::rewrite::script::run::Vertex;

    #[test]
    fn a_stop_costs_the_speed_over_the_acceleration_of_the_slowest_joint() {
        let text = "schema: lostmotion/robot/1\nname: a\njoints:\n  - {name: X, kind: prismatic, max_accel_mm_s2: 2000}\n  - {name: Y, kind: prismatic, max_accel_mm_s2: 500}\n";
        let robot = Robot::parse("r.yaml", text).unwrap();
        let vertex = |step, q: [f64; 2], t_s| Vertex {
            step,
            role: Role::Goal,
            q: q.to_vec(),
            share: 1.0,
            editable: true,
            t_s,
            certain: true,
        };
        let run = Run { vertices: vec![vertex(0, [0.0, 0.0], 0.0), vertex(1, [0.2, 0.1], 1.0)], ..Run::default() };
        let halts = [Halt { step: 1, at: At::default(), stops: 3 }];
        // X: 200 / 2000 = 0.1 s, Y: 100 / 500 = 0.2 s
        let s = duration_s(&robot, std::slice::from_ref(&run), &halts).unwrap();
        assert!((s - 0.6).abs() < 1e-12, "{s}");
        let unknown = Run { untimed: Some(At::default()), ..run };
        assert_eq!(duration_s(&robot, &[unknown], &halts), None);
    }
}
