//! Times of program points at a constant TCP speed.
//!
//! A segment lasts as long as the straight distance of the TCP at the speed, at least [`SHORTEST_S`], and no less than
//! its slowest joint needs at its `max_speed` where the robot file states one: that alone limits a move which turns a joint
//! about the TCP. A move that does not move the TCP, of joints without a known speed, lasts [`SHORTEST_S`] and is counted.

use crate::program::Program;
use crate::robot::Robot;

/// Shortest segment, s: one interpolation cycle of a common controller.
pub const SHORTEST_S: f64 = 0.004;

/// A segment that moves the TCP less than this (m) moves only joints.
const STILL_M: f64 = 1e-9;

/// Times of all points, and what a user should know about them.
#[derive(Debug, Clone, PartialEq)]
pub struct Timing {
    /// s, first 0, strictly increasing.
    pub t_s: Vec<f64>,
    /// Segments that a joint's `max_speed` makes slower than the TCP speed.
    pub held_by_a_joint: usize,
    /// Segments that move joints but not the TCP, where no speed of these joints is known.
    pub unknown_speed: usize,
}

impl Timing {
    /// At `speed_m_s` (above 0).
    pub fn at_speed(robot: &Robot, program: &Program, speed_m_s: f64) -> Self {
        let mut timing = Self { t_s: Vec::with_capacity(program.len()), held_by_a_joint: 0, unknown_speed: 0 };
        let mut q = vec![0.0; robot.dof()];
        let mut before = q.clone();
        let mut tcp_before = None;
        let mut t = 0.0;
        for i in 0..program.len() {
            program.point_into(i, &mut q);
            let tcp = robot.tcp_m(&q);
            if let Some(from) = tcp_before {
                let distance: f64 = (tcp - from as nalgebra::Vector3<f64>).norm();
                let mut duration = (distance / speed_m_s).max(SHORTEST_S);
                let mut joint_s = 0f64;
                let (mut moves, mut known) = (false, true);
                for (axis, joint) in robot.axis_joints().enumerate() {
                    let travel = (q[axis] - before[axis]).abs();
                    if travel > 0.0 {
                        moves = true;
                        match joint.max_speed {
                            Some(v) => joint_s = joint_s.max(travel / v),
                            None => known = false,
                        }
                    }
                }
                if distance < STILL_M && moves && !known {
                    timing.unknown_speed += 1;
                }
                if joint_s > duration {
                    timing.held_by_a_joint += 1;
                    duration = joint_s;
                }
                t += duration;
            }
            timing.t_s.push(t);
            tcp_before = Some(tcp);
            before.copy_from_slice(&q);
        }
        timing
    }
}
