//! The program as CSV: `t_s`, then the joints in their order.

use super::follow::{DECIMALS, Tracked};
use crate::error::one_line;
use crate::log::write::number;
use crate::robot::Robot;
use std::io::Write;

/// The program as bytes; `from` and `by` stand in its first line.
pub fn program(robot: &Robot, tracked: &Tracked, from: &str, by: &str) -> Vec<u8> {
    let from = from.rsplit(['/', '\\']).next().unwrap_or(from);
    let mut out = format!("# lostmotion track: {}, {}\nt_s", one_line(from), one_line(by)).into_bytes();
    for joint in robot.axis_joints() {
        // writing to memory does not fail
        let _ = write!(out, ",{}_{}", joint.name.to_lowercase(), joint.kind.unit());
    }
    out.push(b'\n');
    for (q, t) in tracked.q.iter().zip(&tracked.t_s) {
        let _ = write!(out, "{t}");
        for (joint, v) in robot.axis_joints().zip(q) {
            out.push(b',');
            number(&mut out, joint.kind.to_user_unit(*v), DECIMALS as u8);
        }
        out.push(b'\n');
    }
    out
}
