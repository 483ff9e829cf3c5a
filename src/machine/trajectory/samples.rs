//! The samples of one axis, and columns of a log without their gaps.

use super::*;
use crate::effects::Track;
use crate::log::Log;
use crate::robot::{JointKind, Robot};
use std::sync::OnceLock;

impl Axis {
    pub(super) fn new(
        robot: &Robot,
        axis: usize,
        samples: Samples,
        times: &[f64],
        rows: &[f64],
        deadband: f64,
    ) -> Self {
        let joint = robot.axis(axis);
        let rev = match joint.kind {
            JointKind::Revolute => std::f64::consts::TAU,
            JointKind::Prismatic => joint.lead_m_per_rev.unwrap_or(1.0),
        };
        let track = match &samples {
            Samples::Rest => Track::new(&times[..times.len().min(1)], &rows[..rows.len().min(1)], deadband),
            Samples::Rows => Track::new(times, rows, deadband),
            Samples::Grid { p } => Track::new(times, p, deadband),
            Samples::Own { t_s, p, .. } => Track::new(t_s, p, deadband),
        };
        let (dir, turns) = (track.dir.into_owned(), track.turns.into_owned());
        let (speed, load) = (OnceLock::new(), OnceLock::new());
        let (direction, command_speed) = (OnceLock::new(), OnceLock::new());
        let cubics = OnceLock::new();
        Self { samples, dir, turns, rev, deadband, speed, load, direction, command_speed, cubics }
    }
}

/// Movement that counts as none, rad or m.
pub(super) fn deadband(robot: &Robot, axis: usize) -> f64 {
    NO_MOVEMENT * robot.axis(axis).kind.si_per_user_unit()
}

pub(super) fn at_rest(p: &[f64]) -> bool {
    p.windows(2).all(|w| w[0] == w[1])
}

/// Rows and the turning points after them.
pub(super) fn with_turning_points(times: &[f64], p: &[f64], found: Vec<(usize, f64, f64)>) -> Samples {
    let n = p.len() + found.len();
    let (mut t_s, mut q, mut rows) = (Vec::with_capacity(n), Vec::with_capacity(n), Vec::with_capacity(p.len()));
    let mut next = found.into_iter().peekable();
    for (row, (&t, &v)) in times.iter().zip(p).enumerate() {
        rows.push(t_s.len() as u32);
        t_s.push(t);
        q.push(v);
        while let Some((_, t, v)) = next.next_if(|turn| turn.0 == row) {
            t_s.push(t);
            q.push(v);
        }
    }
    Samples::Own { t_s, p: q, rows }
}

/// Torques of the drives as a log has them.
pub(super) fn measured_torque(log: &Log) -> Vec<Option<Vec<f64>>> {
    log.instruments.torque_nm.iter().map(|t| t.as_ref().map(|t| from_first(t))).collect()
}

/// Force on the tool as a log has it; what is missing is what was measured before it, and before the first one none.
pub(super) fn force(log: &Log) -> Option<Vec<Vector3<f64>>> {
    let column = log.instruments.force_n.as_ref()?;
    let mut last = Vector3::zeros();
    let mut next = |v: &Option<Vector3<f64>>| {
        last = v.unwrap_or(last);
        last
    };
    Some(column.iter().map(&mut next).collect())
}

/// A column with gaps: what is missing is what stood before it; before the first value that one.
pub(super) fn from_first(column: &[Option<f64>]) -> Vec<f64> {
    let mut last = column.iter().flatten().next().copied().unwrap_or(0.0);
    let mut next = |v: &Option<f64>| {
        last = v.unwrap_or(last);
        last
    };
    column.iter().map(&mut next).collect()
}

/// A column with gaps: what is missing is what stood before it; 0 before the first value.
pub(super) fn carried(column: &[Option<f64>]) -> Vec<f64> {
    let mut last = 0.0;
    column
        .iter()
        .map(|v| {
            last = v.unwrap_or(last);
            last
        })
        .collect()
}
