//! What is not lost motion, as linear columns with weak priors: what the instrument sees of it per bin and column.
//!
//! Shared by all logs: small rotations and translations of every body of the arm (they hold every error of geometry, zero
//! position and tool to first order), the lag of each joint, what its servo adds to that at corners, its answer to acceleration, its
//! compliance under gravity, and ripples of its gear. Of each log alone: the tracker's frame (of a ballbar its centre and length, of a dial
//! its zero and tilt, of a joint sensor its zero, its scale and a wave once a turn), a slow
//! drift of the TCP, the offset and rate of its clock, and where a joint stood before its first movement.
//!
//! Priors are normal with the standard deviations below: several times what robots show, so that they decide nothing that the
//! logs know, and keep apart what the logs cannot tell apart.

use super::bins::BinnedLog;
use crate::identify::following::{ACCELERATION_S2, CLOCK_S, LAG_S};
use crate::machine::gravity::Gravity;
use crate::machine::measurement::Instrument;
use crate::numerics::parallel::ParMap;
use crate::robot::{JointKind, Robot};
use nalgebra::Vector3;

/// Standard deviations of the priors; SI.
const FRAME_M: f64 = 5e-3;
const FRAME_RAD: f64 = 5e-3;
/// A centre or a length that was given; a zero that was not; the direction of a dial.
const GIVEN_M: f64 = 1e-3;
const ZERO_M: f64 = 1e-2;
pub(crate) const TILT_RAD: f64 = 5e-2;
/// Errors of a joint sensor and of what turns with it over its position: scale, and once a turn.
const SENSOR: f64 = 1e-3;
const BODY_M: f64 = 1e-3;
const BODY_RAD: f64 = 1e-3;
const DRIFT_M: f64 = 5e-5;
const CLOCK_RATE: f64 = 5e-5;
/// Deflection under the largest load of the log, at the TCP.
const LOAD_M: f64 = 5e-4;
/// Ripple at the TCP.
const RIPPLE_M: f64 = 3e-5;
/// Position of a joint before its first movement, at the TCP.
const START_M: f64 = 3e-4;

/// A gear's ripple: axis, cycles a unit of its command (rad or m) times 2 pi.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ripple {
    pub axis: usize,
    pub per_unit: f64,
}

/// What a column stands for; `AtRest`: a spike of an axis in logs of dwells less that in motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Name {
    Body { joint: usize, part: usize },
    Lag { axis: usize },
    Acceleration { axis: usize },
    Servo { axis: usize, part: usize },
    Load { axis: usize },
    Ripple { number: usize, part: usize },
    AtRest { axis: usize, part: usize },
    Own { log: usize, part: usize },
}

/// A column of a log.
pub struct Column {
    pub name: Name,
    /// Standard deviation of its prior.
    pub sigma: f64,
    pub values: Vec<Vector3<f64>>,
}

/// Columns of a log; `number` is that of the log.
pub fn columns(log: &BinnedLog, number: usize, robot: &Robot, ripples: &[Ripple]) -> Vec<Column> {
    let mut out = own(log, robot, number);
    // a sensor after a gear sees nothing of what bends or stands elsewhere behind it
    if !matches!(log.instrument, Instrument::Joint { .. }) {
        out.extend(bodies(log, robot));
    }
    out.extend(joints(log, robot));
    out.extend(of_ripples(log, ripples, 0));
    out
}

/// Frame of the instrument, drift and clock of one log.
fn own(log: &BinnedLog, robot: &Robot, number: usize) -> Vec<Column> {
    let n = log.len();
    let (t0, t1) = (log.t_s.first().copied().unwrap_or(0.0), log.t_s.last().copied().unwrap_or(1.0));
    let u: Vec<f64> = log.t_s.iter().map(|t| (2.0 * t - t0 - t1) / (t1 - t0).max(1e-9)).collect();
    let velocity: Vec<Vector3<f64>> =
        log.sensitivity.iter().zip(&log.speed).map(|(j, v)| j.iter().zip(v).map(|(j, v)| j * *v).sum()).collect();
    let mut out = Vec::new();
    let mut part = 0;
    let mut add = |sigma: f64, values: Vec<Vector3<f64>>| {
        out.push(Column { name: Name::Own { log: number, part }, sigma, values });
        part += 1;
    };
    if log.instrument == Instrument::Tcp {
        let centre = log.tcp_m.iter().sum::<Vector3<f64>>() / n.max(1) as f64;
        for e in [Vector3::x(), Vector3::y(), Vector3::z()] {
            add(FRAME_M, vec![e; n]);
            add(FRAME_RAD, log.tcp_m.iter().map(|p| e.cross(&(p - centre))).collect());
            add(DRIFT_M, u.iter().map(|u| e * *u).collect());
            add(DRIFT_M, u.iter().map(|u| e * (1.5 * u * u - 0.5)).collect());
        }
    } else {
        for (sigma, values) in single(log) {
            add(sigma, values);
        }
        for values in over_position(log, robot) {
            add(SENSOR, values);
        }
        add(DRIFT_M, u.iter().map(|u| Vector3::x() * *u).collect());
        add(DRIFT_M, u.iter().map(|u| Vector3::x() * (1.5 * u * u - 0.5)).collect());
    }
    add(CLOCK_S, velocity.clone());
    add(CLOCK_RATE, velocity.iter().zip(&log.t_s).map(|(v, t)| v * (t - 0.5 * (t0 + t1))).collect());
    // a joint that waits before it moves stands anywhere in its gap
    for (axis, rows) in &log.moving {
        let first = rows.x.iter().position(|x| (x - rows.x[0]).abs() > 1e-9).unwrap_or(0);
        let waits = log.bins.iter().take_while(|b| b.1 <= first).count();
        if waits > 10 {
            let lever = lever(log, *axis);
            let at = |b: usize| if b < waits { log.sensitivity[b][*axis] } else { Vector3::zeros() };
            add(START_M / lever, (0..n).map(at).collect());
        }
    }
    out
}

/// What an instrument with one reading a row does not know of itself.
fn single(log: &BinnedLog) -> Vec<(f64, Vec<Vector3<f64>>)> {
    let centre = match log.instrument {
        Instrument::Direction { .. } => log.tcp_m.iter().sum::<Vector3<f64>>() / log.len().max(1) as f64,
        _ => Vector3::zeros(),
    };
    let own: Vec<Vec<Vector3<f64>>> = log
        .tcp_m
        .iter()
        .map(|p| log.instrument.nuisances(&(p - centre)).into_iter().map(Vector3::from).collect())
        .collect();
    let sigmas = match log.instrument {
        Instrument::Distance { .. } => {
            let centre = if log.given { GIVEN_M } else { FRAME_M };
            vec![centre, centre, centre, if log.whole { GIVEN_M } else { ZERO_M }]
        }
        Instrument::Direction { .. } => vec![ZERO_M, TILT_RAD, TILT_RAD],
        Instrument::Joint { .. } => vec![ZERO_M],
        Instrument::Tcp => Vec::new(),
    };
    let column = |k: usize| own.iter().map(|o| o[k]).collect();
    sigmas.iter().enumerate().map(|(k, sigma)| (*sigma, column(k))).collect()
}

/// What a joint sensor and the load of its joint add over its position: a scale, and of a joint that turns a wave once a turn.
fn over_position(log: &BinnedLog, robot: &Robot) -> Vec<Vec<Vector3<f64>>> {
    let Instrument::Joint { axis } = log.instrument else { return Vec::new() };
    let mean = log.q.iter().map(|q| q[axis]).sum::<f64>() / log.len().max(1) as f64;
    let column = |of: &dyn Fn(f64) -> f64| -> Vec<Vector3<f64>> {
        log.q.iter().zip(&log.sensitivity).map(|(q, s)| s[axis] * of(q[axis])).collect()
    };
    let mut out = vec![column(&|q| q - mean)];
    if robot.axis(axis).kind == JointKind::Revolute {
        out.push(column(&|q| q.sin() - mean.sin()));
        out.push(column(&|q| q.cos() - mean.cos()));
    }
    out
}

/// Root mean square of the derivative of the TCP by an axis, m per rad or m.
pub fn lever(log: &BinnedLog, axis: usize) -> f64 {
    let s: f64 = log.jacobian.iter().map(|j| j[axis].norm_squared()).sum();
    (s / log.len().max(1) as f64).sqrt().max(1e-3)
}

/// Small rigid movements of every body.
fn bodies(log: &BinnedLog, robot: &Robot) -> Vec<Column> {
    let joints = robot.joints.len();
    let mut frames: Vec<Vec<[Vector3<f64>; 4]>> = vec![Vec::with_capacity(log.len()); joints];
    for q in &log.q {
        robot.chain().frames(q, |i, f| frames[i].push(*f));
    }
    let mut out = Vec::new();
    for (joint, frames) in frames.iter().enumerate() {
        for c in 0..3 {
            let values = frames.iter().enumerate().map(|(b, f)| log.seen(b, &f[c])).collect();
            out.push(Column { name: Name::Body { joint, part: c }, sigma: BODY_M, values });
            if joint + 1 < joints {
                let turned = frames.iter().zip(&log.tcp_m).map(|(f, p)| f[c].cross(&(p - f[3])));
                let values = turned.enumerate().map(|(b, v)| log.seen(b, &v)).collect();
                out.push(Column { name: Name::Body { joint, part: 3 + c }, sigma: BODY_RAD, values });
            }
        }
    }
    out
}

/// Lag, acceleration and load of each joint.
fn joints(log: &BinnedLog, robot: &Robot) -> Vec<Column> {
    let along = |axis: usize, by: &dyn Fn(usize) -> f64| -> Vec<Vector3<f64>> {
        log.sensitivity.iter().enumerate().map(|(b, j)| j[axis] * by(b)).collect()
    };
    let mut out = Vec::new();
    for (axis, _) in &log.moving {
        let axis = *axis;
        out.push(Column { name: Name::Lag { axis }, sigma: LAG_S, values: along(axis, &|b| -log.speed[b][axis]) });
        let values = along(axis, &|b| log.acceleration[b][axis]);
        out.push(Column { name: Name::Acceleration { axis }, sigma: ACCELERATION_S2, values });
    }
    for (axis, servos) in &log.servos {
        for (part, delayed) in servos.iter().enumerate() {
            let values = along(*axis, &|b| -delayed[b]);
            out.push(Column { name: Name::Servo { axis: *axis, part }, sigma: LAG_S, values });
        }
    }
    let gravity = Gravity::new(robot);
    // what bends before a joint sensor is not what bends before the TCP
    if gravity.is_known() && !matches!(log.instrument, Instrument::Joint { .. }) {
        let columns: Vec<Vec<f64>> = (0..robot.dof()).map(|a| log.q.iter().map(|q| q[a]).collect()).collect();
        let torque = gravity.over(robot.chain(), &columns, None);
        for (axis, torque) in torque.iter().enumerate() {
            let mean = torque.iter().sum::<f64>() / torque.len().max(1) as f64;
            let most = torque.iter().map(|t| t.abs()).fold(0.0, f64::max);
            let spread = torque.iter().map(|t| (t - mean).abs()).fold(0.0, f64::max);
            if spread > 1e-3 * most && most > 0.0 {
                let sigma = LOAD_M / lever(log, axis) / torque_scale(robot, axis);
                out.push(Column { name: Name::Load { axis }, sigma, values: along(axis, &|b| torque[b]) });
            }
        }
    }
    out
}

/// A torque (Nm) or force (N) that the weights can put on an axis: all masses at arm's length, or their weight.
fn torque_scale(robot: &Robot, axis: usize) -> f64 {
    let mass: f64 = robot.links.iter().map(|l| l.mass_kg).sum();
    let length = match robot.axis(axis).kind {
        JointKind::Revolute => robot.joints.iter().map(|j| j.a_m.abs() + j.d_m.abs()).sum::<f64>().max(0.1),
        JointKind::Prismatic => 1.0,
    };
    (mass * 9.81 * length).max(1e-3)
}

/// Ripples, numbered from `first`.
pub fn of_ripples(log: &BinnedLog, ripples: &[Ripple], first: usize) -> Vec<Column> {
    let mut out = Vec::new();
    for (k, r) in ripples.iter().enumerate() {
        if matches!(log.instrument, Instrument::Joint { axis } if axis != r.axis) {
            continue;
        }
        let lever = lever(log, r.axis);
        for part in 0..2 {
            let wave = |b: usize| {
                let phase = r.per_unit * log.q[b][r.axis];
                if part == 0 { phase.sin() } else { phase.cos() }
            };
            let values = log.sensitivity.iter().enumerate().map(|(b, j)| j[r.axis] * wave(b)).collect();
            out.push(Column { name: Name::Ripple { number: first + k, part }, sigma: RIPPLE_M / lever, values });
        }
    }
    out
}

/// Columns of all logs.
pub fn of_logs(logs: &[BinnedLog], robot: &Robot, ripples: &[Ripple]) -> Vec<Vec<Column>> {
    (0..logs.len()).par_map(|l| columns(&logs[l], l, robot, ripples))
}
