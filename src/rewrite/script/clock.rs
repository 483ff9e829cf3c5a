//! How long the moves of a vendor program take, as far as their speeds tell.
//!
//! Method: a TCP speed over the length of the way, or the duration that is written; never faster than the joints can. A
//! share of the joints' largest speeds, or a joint speed, is taken from stop to stop (trapezoid), which is too slow where
//! corners are cut: between close points such a speed says nothing of how fast they pass. Waiting for signals is not in it.
//! The times serve offsets that fade in seconds, speed limits, and an estimate of the cycle.

use crate::program::script::{PathKind, Speed};
use crate::rewrite::limits::CYCLE_S;
use crate::robot::Robot;
use nalgebra::Vector3;

/// Share of its largest speed up to which a joint is taken to be driven: a controller slows down where a TCP speed asks for
/// more, and the estimate must not stand on the limit itself.
const DRIVEN: f64 = 0.9;
/// Parts in which the TCP's way on a joint move is measured.
const PARTS: usize = 8;
/// ... and on an arc, of which a full turn then lacks 0.04 %.
pub(super) const ARC_PARTS: usize = 64;

/// Duration of the way from `a` to `b`, s; `None`: the speed is not known and there is no other. `on_way` gives joints on an
/// arc.
#[allow(clippy::too_many_arguments)] // a way, its speed, what gives joints on it, and what is known of its start
pub fn duration_s(
    robot: &Robot,
    a: &[f64],
    b: &[f64],
    path: PathKind,
    speed: Speed,
    otherwise: Option<f64>,
    on_way: &dyn Fn(f64) -> Option<Vec<f64>>,
    tcp: &mut LastTcp,
) -> Option<f64> {
    let speed = match (speed, otherwise) {
        (Speed::Unknown, Some(v)) => Speed::Tcp(v),
        (s, _) => s,
    };
    let slowest = |share: f64| {
        let of = |(k, j): (usize, &crate::robot::Joint)| {
            j.max_speed.map(|v| stop_to_stop((b[k] - a[k]).abs(), v * share, j.max_accel))
        };
        robot.axis_joints().enumerate().map(of).try_fold(0.0, |most: f64, t| Some(most.max(t?)))
    };
    let least = || {
        robot
            .axis_joints()
            .enumerate()
            .filter_map(|(k, j)| j.max_speed.map(|v| (b[k] - a[k]).abs() / (v * DRIVEN)))
            .fold(CYCLE_S, f64::max)
    };
    let wanted = match speed {
        Speed::Seconds(s) => return Some(s.max(CYCLE_S)),
        Speed::Tcp(v) if v > 0.0 => length_m(robot, a, b, path, on_way, tcp) / v,
        Speed::Joint(w) if w > 0.0 => robot
            .axis_joints()
            .enumerate()
            .map(|(k, j)| stop_to_stop((b[k] - a[k]).abs(), w, j.max_accel))
            .fold(0.0, f64::max),
        Speed::Share(s) if s > 0.0 => match (slowest(s.min(1.0)), otherwise) {
            (Some(s), _) => s,
            // a share of joint speeds that the robot file does not hold
            (None, Some(v)) => length_m(robot, a, b, path, on_way, tcp) / v,
            (None, None) => return None,
        },
        _ => return None,
    };
    Some(wanted.max(least()))
}

/// Where the TCP of one robot stood last: a move begins where the one before it ended.
#[derive(Debug, Default)]
pub struct LastTcp {
    q: Vec<f64>,
    at: Vector3<f64>,
    /// Memory for joints on the way.
    between: Vec<f64>,
    /// Length of the joint move that comes next, m, where it is measured already.
    known_m: Option<f64>,
}

impl LastTcp {
    /// Says how long the way of the next joint move is, m, where that is known.
    pub fn knows(&mut self, length_m: Option<f64>) {
        self.known_m = length_m;
    }

    /// Position of the TCP, m.
    fn at(&mut self, robot: &Robot, q: &[f64]) -> Vector3<f64> {
        if self.q != q || q.is_empty() {
            self.q.clear();
            self.q.extend_from_slice(q);
            self.at = robot.tcp_m(q);
        }
        self.at
    }
}

/// The times of such a speed can be relied on.
pub fn is_certain(speed: Speed) -> bool {
    matches!(speed, Speed::Tcp(_) | Speed::Seconds(_))
}

/// Time from stop to stop over `way` at speed `v` and acceleration `a`, s.
fn stop_to_stop(way: f64, v: f64, a: Option<f64>) -> f64 {
    match a {
        Some(a) if way < v * v / a => 2.0 * (way / a).sqrt(),
        Some(a) => way / v + v / a,
        None => way / v,
    }
}

/// Length of the TCP's way, m.
fn length_m(
    robot: &Robot,
    a: &[f64],
    b: &[f64],
    path: PathKind,
    on_way: &dyn Fn(f64) -> Option<Vec<f64>>,
    tcp: &mut LastTcp,
) -> f64 {
    let curve = path == PathKind::Curve && on_way(0.5).is_some();
    if let Some(known) = tcp.known_m.filter(|_| path == PathKind::Joint) {
        return known;
    }
    let start = tcp.at(robot, a);
    if path != PathKind::Joint && !curve {
        return (tcp.at(robot, b) - start).norm();
    }
    if curve {
        measured_m(robot, start, (a, b), (ARC_PARTS, on_way), &mut tcp.between)
    } else {
        joint_way_m(robot, start, (a, b), &mut tcp.between)
    }
}

/// Length of the TCP's way on a joint move from `a`, where the TCP stands at `start`, to `b`, m; `between`: room.
pub(super) fn joint_way_m(robot: &Robot, start: Vector3<f64>, ends: (&[f64], &[f64]), between: &mut Vec<f64>) -> f64 {
    measured_m(robot, start, ends, (PARTS, &|_| None), between)
}

/// The same in so many parts; `on_way` gives joints on an arc, which alone has another way than straight in the joints.
fn measured_m(
    robot: &Robot,
    start: Vector3<f64>,
    (a, b): (&[f64], &[f64]),
    (parts, on_way): (usize, &dyn Fn(f64) -> Option<Vec<f64>>),
    between: &mut Vec<f64>,
) -> f64 {
    between.clear();
    between.extend_from_slice(a);
    let (mut last, mut sum) = (start, 0.0);
    for k in 1..=parts {
        let s = k as f64 / parts as f64;
        let here = match on_way(s) {
            Some(q) => robot.tcp_m(&q),
            None => {
                between.iter_mut().zip(a.iter().zip(b)).for_each(|(q, (x, y))| *q = x + s * (y - x));
                robot.tcp_m(between)
            }
        };
        sum += (here - last).norm();
        last = here;
    }
    sum
}
