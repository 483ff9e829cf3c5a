//! Where to record: a pose in which every joint moves the TCP well, and the windows within which the instrument still sees it.
//!
//! Method: of a Halton sequence over the middle of the joints' ranges the pose with the largest geometric mean of the levers
//! (m of the TCP per rad of a joint), each capped at the reach that matters, that the tracker sees. Deterministic.
//!
//! A tracker sees the TCP where the beam passes the links at [`CLEARANCE_M`] or more and meets the reflector, which is turned to
//! it in the pose, within its acceptance. Links are taken as straight lines between the joints' frames.

use super::note::Note;
use super::options::{Kind, Options};
use crate::error::{Error, Result};
use crate::numerics::halton;
use crate::plan::path::Envelope;
use crate::robot::{Joint, JointKind, Robot};
use nalgebra::Vector3;

/// Poses that are tried.
const TRIED: usize = 600;
/// Part of a joint's range from which poses are drawn, about its middle.
const MIDDLE: f64 = 0.55;
/// Range of a revolute joint without limits, or with more than a turn, rad.
const TURN: f64 = std::f64::consts::PI;
/// Farther from the middle than this no revolute joint is placed, rad.
const FARTHEST: f64 = 1.2;
/// Lever beyond which more does not count, m per rad.
const ENOUGH_M: f64 = 0.5;
/// Lowest TCP above the base, m: floors are near bases.
const ABOVE_BASE_M: f64 = 0.2;
/// Distance at which a beam passes a link, m.
const CLEARANCE_M: f64 = 0.15;
/// Steps by which a window is narrowed to what the tracker sees.
const STEPS: usize = 24;

/// What the tracker sees.
#[derive(Debug, Clone)]
pub struct Sight<'a> {
    robot: &'a Robot,
    tracker_m: Option<Vector3<f64>>,
    acceptance_rad: f64,
    /// Direction of the reflector in the TCP's frame.
    facing: Option<Vector3<f64>>,
}

impl<'a> Sight<'a> {
    pub fn new(robot: &'a Robot, options: &Options) -> Self {
        Self { robot, tracker_m: options.tracker_m, acceptance_rad: options.acceptance_rad, facing: None }
    }

    /// The reflector is turned to the tracker in this pose.
    pub fn facing(mut self, pose: &[f64]) -> Self {
        self.facing = self.tracker_m.and_then(|t| {
            let at = self.robot.forward(pose);
            (at.rotation.inverse() * (t - at.position)).try_normalize(1e-9)
        });
        self
    }

    pub fn sees(&self, q: &[f64]) -> bool {
        let Some(tracker) = self.tracker_m else { return true };
        let at = self.robot.forward(q);
        let tcp = at.position;
        if let (Some(facing), Some(beam)) = (self.facing, (tracker - tcp).try_normalize(1e-9))
            && (at.rotation * facing).dot(&beam) < self.acceptance_rad.cos()
        {
            return false;
        }
        let frames = frames(self.robot, q);
        // the last links carry the reflector
        let links = frames.len().saturating_sub(3);
        frames.windows(2).take(links).all(|w| apart(w[0], w[1], tcp, tracker) > CLEARANCE_M)
    }

    /// Narrows each joint's window to what the tracker sees while the others are stationary.
    pub fn narrow(&self, envelope: &mut Envelope, kind: Kind, notes: &mut Vec<Note>) {
        if self.tracker_m.is_none() {
            return;
        }
        let pose = envelope.pose.clone();
        // joints that move together share the reflector's acceptance
        let share = if kind == Kind::Static { 1.0 } else { 1.0 / (pose.len() as f64).sqrt() };
        for (axis, joint) in self.robot.axis_joints().enumerate() {
            let [lo, hi] = envelope.window[axis];
            let reach = |end: f64| {
                let mut last = pose[axis];
                for k in 1..=STEPS {
                    let mut q = pose.clone();
                    q[axis] += (end - pose[axis]) * k as f64 / STEPS as f64;
                    if !self.sees(&q) {
                        return pose[axis] + share * (last - pose[axis]);
                    }
                    last = q[axis];
                }
                last
            };
            envelope.window[axis] = [reach(lo), reach(hi)];
            if envelope.span(axis) < 0.5 * (hi - lo) {
                let (joint, kind) = (joint.name.clone(), joint.kind);
                notes.push(Note::Window { joint, kind, window: envelope.window[axis] });
            }
        }
    }
}

/// Origins of the base, of every joint's frame and of the TCP.
fn frames(robot: &Robot, q: &[f64]) -> Vec<Vector3<f64>> {
    let (_, jacobian) = robot.chain().jacobian(q);
    let tcp = robot.tcp_m(q);
    let mut points = vec![robot.base.translation.vector];
    for (axis, joint) in robot.axis_joints().enumerate() {
        let column = jacobian.column(axis);
        let (v, w) = (Vector3::new(column[0], column[1], column[2]), Vector3::new(column[3], column[4], column[5]));
        if joint.kind == JointKind::Revolute && w.norm() > 0.0 {
            // the point of the axis nearest to the TCP
            points.push(tcp - v.cross(&w) / w.norm_squared());
        }
    }
    points.push(tcp);
    points
}

/// Least distance between two segments, sampled along the first.
fn apart(a: Vector3<f64>, b: Vector3<f64>, from: Vector3<f64>, to: Vector3<f64>) -> f64 {
    const SAMPLES: usize = 16;
    let beam = to - from;
    (0..=SAMPLES)
        .map(|i| {
            let p = a + (b - a) * (i as f64 / SAMPLES as f64);
            let share = ((p - from).dot(&beam) / beam.norm_squared().max(1e-12)).clamp(0.0, 1.0);
            (p - from - beam * share).norm()
        })
        .fold(f64::INFINITY, f64::min)
}

/// Part of a joint's range in which a pose is looked for.
fn range(joint: &Joint) -> [f64; 2] {
    let [lo, hi] = joint.limits.unwrap_or(match joint.kind {
        JointKind::Revolute => [-TURN, TURN],
        JointKind::Prismatic => [-0.2, 0.2],
    });
    let middle = 0.5 * (lo + hi);
    let mut half = 0.5 * MIDDLE * (hi - lo);
    if joint.kind == JointKind::Revolute {
        half = half.min(FARTHEST);
    }
    [middle - half, middle + half]
}

/// A pose in the middle of the ranges, to whole tenths of a degree or millimetre: people read them.
fn drawn(robot: &Robot, ranges: &[[f64; 2]], i: usize) -> Vec<f64> {
    const BASES: [usize; 8] = [2, 3, 5, 7, 11, 13, 17, 19];
    let value = |(a, [lo, hi]): (usize, &[f64; 2])| {
        let si = robot.axis(a).kind.si_per_user_unit();
        let v = lo + (hi - lo) * halton::member(i, BASES[a % BASES.len()]);
        ((v / si) * 10.0).round() / 10.0 * si
    };
    ranges.iter().enumerate().map(value).collect()
}

/// The first poses of those that are tried.
pub fn candidates(robot: &Robot, count: usize) -> Vec<Vec<f64>> {
    let ranges: Vec<[f64; 2]> = robot.axis_joints().map(range).collect();
    (1..=count).map(|i| drawn(robot, &ranges, i)).collect()
}

/// The pose with the best levers that the tracker sees.
///
/// # Errors
/// Where no pose that was tried is visible.
pub fn find(robot: &Robot, options: &Options) -> Result<Vec<f64>> {
    let ranges: Vec<[f64; 2]> = robot.axis_joints().map(range).collect();
    let only_prismatic = robot.axis_joints().all(|j| j.kind == JointKind::Prismatic);
    let mut best: Option<(f64, Vec<f64>)> = None;
    let mut columns = vec![Vector3::zeros(); robot.dof()];
    for i in 1..=TRIED {
        let q = drawn(robot, &ranges, i);
        let p = robot.chain().position_and_jacobian(&q, &mut columns);
        let low = (p - robot.base.translation.vector).z < ABOVE_BASE_M;
        let seen = Sight::new(robot, options).facing(&q).sees(&q);
        if !seen || (low && !only_prismatic) {
            continue;
        }
        let score: f64 = columns
            .iter()
            .map(|c| {
                let reading = options.instrument.sensitivity(&p, c);
                let lever = reading.iter().map(|v| v * v).sum::<f64>().sqrt();
                lever.clamp(1e-4, ENOUGH_M).ln()
            })
            .sum();
        if best.as_ref().is_none_or(|(b, _)| score > *b) {
            best = Some((score, q));
        }
    }
    best.map(|b| b.1).ok_or_else(|| {
        let found = format!("none of {TRIED} poses is visible from there");
        Error::setting("tracker", found, "a position from which the TCP is visible, in mm; or a pose")
            .mended_by(&["pose"])
    })
}
