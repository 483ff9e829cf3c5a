//! Where the tracker stands: the frame of all logs together, and that of a log before which it was moved.

use crate::error::Result;
use crate::gaps::Registered;
use crate::log::Log;
use crate::log::registration::{Pair, register_line};
use crate::numerics::robust::median_of;
use crate::robot::Robot;
use nalgebra::Isometry3;

/// Distance from the common frame from which a log gets a separate one.
const ELSEWHERE_M: f64 = 5e-3;
/// Rows of each log that register the frame.
const REGISTERED: usize = 400;

/// The tracker's frame from all logs that have a TCP; `None` where none has.
///
/// # Errors
/// Where the rows do not register a frame.
pub fn frame(robot: &Robot, logs: &[&Log]) -> Result<Option<Registered>> {
    let mut pairs = Vec::new();
    for log in logs {
        let each = (log.len() / REGISTERED).max(1);
        for i in (0..log.len()).step_by(each) {
            if let Some(Some(tracker_m)) = log.tcp_m.get(i) {
                pairs.push(Pair { base_m: robot.tcp_m(&log.command(i)), tracker_m: *tracker_m });
            }
        }
    }
    if pairs.is_empty() {
        return Ok(None);
    }
    Ok(Some(register_line(&pairs)?.found))
}

/// Tracker to base for one log: that of all logs, unless the tracker stood elsewhere.
pub fn own_frame(robot: &Robot, log: &Log, all: &Registered) -> Result<Isometry3<f64>> {
    let inverse = all.frame.inverse();
    let off = |i: usize| {
        let tracker = log.tcp_m.get(i).copied().flatten()?;
        Some(((inverse * nalgebra::Point3::from(tracker)).coords - robot.tcp_m(&log.command(i))).norm())
    };
    let each = (log.len() / REGISTERED).max(1);
    let mut distances: Vec<f64> = (0..log.len()).step_by(each).filter_map(off).collect();
    if median_of(&mut distances).is_none_or(|d| d < ELSEWHERE_M) {
        return Ok(inverse);
    }
    Ok(frame(robot, &[log])?.map_or(inverse, |own| own.frame.inverse()))
}
