//! From point to point of a path.
//!
//! `Qp`: one bounded quadratic program per step, a step longer than [`STEP_M`] in equal parts (the Jacobian is that of its start).
//! `Inverse`: the same program, again and again at one point until the point is met (a bounded Gauss-Newton), so that a point does not
//! depend on how finely the path is sampled. The first point is found in that way from the start vector, without a bound on speed.
//!
//! Both take the smallest move of the joints; a redundant robot may therefore come back from a closed path with other joints.

use super::kinematics::Kinematics;
use super::path::Path;
use super::quadratic::Quadratic;
use crate::error::{Error, Place, Result};
use crate::robot::Robot;
use nalgebra::DVector;

/// Longest step of one linearisation, m: it errs by its square over twice the arm, 0.003 mm at 45 mm.
const STEP_M: f64 = 0.5e-3;
/// Parts of one step at most.
const MOST_PARTS: usize = 2000;
/// Largest move of an axis in one linearisation, rad or m.
const MOST_MOVE: f64 = 0.5;
/// The inverse has arrived, m.
const MET_M: f64 = 1e-10;
const MOST_ITERATIONS: usize = 200;
/// Decimals with which joints are written, deg or mm.
pub const DECIMALS: i32 = 6;

/// How a step is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// A bounded quadratic program for each step (Cursi (2022), equation 1).
    Qp,
    /// Numerical inverse kinematics at each point.
    Inverse,
}

impl Method {
    /// Name of the method in documents.
    pub fn text(self) -> &'static str {
        match self {
            Self::Qp => "qp",
            Self::Inverse => "inverse",
        }
    }
}

/// What a user may choose; SI.
#[derive(Debug, Clone)]
pub struct Options {
    /// How each step is found.
    pub method: Method,
    /// Joint vector from which the first point is looked for; `None`: all zero, or the nearest allowed.
    pub start: Option<Vec<f64>>,
    /// Distance from the path that is no miss, m.
    pub tolerance_m: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { method: Method::Qp, start: None, tolerance_m: 1e-4 }
    }
}

/// What holds an axis back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// A joint limit, or the end of the range that was learned.
    Range,
    /// The largest speed of the joint.
    Speed,
}

/// A point that is not met.
#[derive(Debug, Clone, PartialEq)]
pub struct Miss {
    /// Number of the point, from 0.
    pub point: usize,
    /// Distance from the path, m.
    pub distance_m: f64,
    /// Axes at a bound there.
    pub held: Vec<(usize, Bound)>,
}

/// An acceleration beyond its limit, after a point; per second squared.
#[derive(Debug, Clone, PartialEq)]
pub struct TooFast {
    /// Number of the point, from 0.
    pub point: usize,
    /// Axis of the robot.
    pub axis: usize,
    /// Acceleration of the joint, rad/s^2 or m/s^2.
    pub value: f64,
    /// Its largest acceleration, rad/s^2 or m/s^2.
    pub limit: f64,
}

/// The program and how well it follows, by the kinematics it was made with.
#[derive(Debug, Clone)]
pub struct Tracked {
    /// One joint vector per point, rad or m.
    pub q: Vec<Vec<f64>>,
    /// Time of each point, s.
    pub t_s: Vec<f64>,
    /// Distance of each point from the path, m.
    pub error_m: Vec<f64>,
    /// Largest distance from the path half way between two points, where the program runs linear in the joints, m.
    pub between_m: f64,
    /// Points that are farther from the path than the tolerance.
    pub misses: Vec<Miss>,
    /// Points at which a joint exceeds its acceleration.
    pub too_fast: Vec<TooFast>,
    /// Largest speed of each axis, per second.
    pub speed: Vec<f64>,
}

/// Tracks `path` at the times `t_s`.
pub fn follow(robot: &Robot, kinematics: &Kinematics, path: &Path, t_s: &[f64], options: &Options) -> Result<Tracked> {
    let walker = Walker::new(robot, kinematics);
    let mut q = walker.start(options.start.as_deref())?;
    let mut tracked = Tracked {
        q: Vec::with_capacity(path.len()),
        t_s: t_s.to_vec(),
        error_m: Vec::with_capacity(path.len()),
        between_m: 0.0,
        misses: Vec::new(),
        too_fast: Vec::new(),
        speed: vec![0.0; robot.dof()],
    };
    for (i, point) in path.points_m.iter().enumerate() {
        let target = DVector::from_column_slice(point);
        let from = q.clone();
        let seconds = if i == 0 { None } else { Some(t_s[i] - t_s[i - 1]) };
        let reach = walker.reach(&from, seconds);
        match (options.method, seconds) {
            (Method::Qp, Some(dt)) => walker.step(&mut q, &target, dt),
            _ => walker.meet(&mut q, &target, &reach),
        }
        walker.round(&mut q, &reach);
        if q.iter().any(|v| !v.is_finite()) {
            let place = Place::line(&path.name, path.line[i]);
            return Err(Error::bad(place, "a point without a finite joint vector", "a path near the robot"));
        }
        let error_m = (&target - kinematics.position_m(&q)).norm();
        if error_m > options.tolerance_m {
            tracked.misses.push(Miss { point: i, distance_m: error_m, held: walker.held(&q, &reach) });
        }
        if i > 0 {
            let middle: Vec<f64> = from.iter().zip(&q).map(|(a, b)| 0.5 * (a + b)).collect();
            let half =
                DVector::from_iterator(point.len(), path.points_m[i - 1].iter().zip(point).map(|(a, b)| 0.5 * (a + b)));
            tracked.between_m = tracked.between_m.max((half - kinematics.position_m(&middle)).norm());
        }
        tracked.error_m.push(error_m);
        tracked.q.push(q.clone());
    }
    rates(robot, &mut tracked);
    Ok(tracked)
}

/// Speeds, and accelerations beyond their limit: the change between two legs over their mean duration.
fn rates(robot: &Robot, tracked: &mut Tracked) {
    let (q, t) = (&tracked.q, &tracked.t_s);
    let speed = |k: usize, a: usize| (q[k + 1][a] - q[k][a]) / (t[k + 1] - t[k]);
    for (a, joint) in robot.axis_joints().enumerate() {
        for k in 0..q.len().saturating_sub(1) {
            tracked.speed[a] = tracked.speed[a].max(speed(k, a).abs());
            let Some(limit) = joint.max_accel.filter(|_| k > 0) else { continue };
            let value = (speed(k, a) - speed(k - 1, a)) / (0.5 * (t[k + 1] - t[k - 1]));
            if value.abs() > limit * (1.0 + 1e-9) {
                tracked.too_fast.push(TooFast { point: k, axis: a, value, limit });
            }
        }
    }
    tracked.too_fast.sort_by_key(|f| (f.point, f.axis));
}

struct Walker<'a> {
    robot: &'a Robot,
    kinematics: &'a Kinematics,
    lower: Vec<f64>,
    upper: Vec<f64>,
    /// Size of an axis' range, so that radians and metres compare.
    scale: Vec<f64>,
    /// Last digit of each axis, rad or m.
    digit: Vec<f64>,
}

impl<'a> Walker<'a> {
    fn new(robot: &'a Robot, kinematics: &'a Kinematics) -> Self {
        let mut walker =
            Self { robot, kinematics, lower: Vec::new(), upper: Vec::new(), scale: Vec::new(), digit: Vec::new() };
        for (joint, known) in robot.axis_joints().zip(&kinematics.range) {
            let [lo, hi] = joint.limits.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            let digit = joint.kind.si_per_user_unit() * 10f64.powi(-DECIMALS);
            let (lo, hi) = (lo.max(known[0]), hi.min(known[1]));
            // whole digits inside the range: what is written never stands outside it. A range within a digit is one place
            let (mut inner, mut outer) = ((lo / digit).ceil() * digit, (hi / digit).floor() * digit);
            if inner > outer {
                (inner, outer) = (0.5 * (lo + hi), 0.5 * (lo + hi));
            }
            let size = if (outer - inner).is_finite() && outer > inner { outer - inner } else { std::f64::consts::TAU };
            walker.lower.push(inner);
            walker.upper.push(outer);
            walker.scale.push(size);
            walker.digit.push(digit);
        }
        walker
    }

    fn start(&self, asked: Option<&[f64]>) -> Result<Vec<f64>> {
        if let Some(q) = asked {
            for (a, joint) in self.robot.axis_joints().enumerate() {
                if !(q[a] >= self.lower[a] - self.digit[a] && q[a] <= self.upper[a] + self.digit[a]) {
                    let edge = |v: f64| joint.kind.to_user_unit(v);
                    let unit = joint.kind.unit();
                    return Err(Error::setting(
                        "start",
                        format!("{} at {} {unit}", joint.name, edge(q[a])),
                        format!(
                            "{:.6} to {:.6} {unit}: limits, and what was learned",
                            edge(self.lower[a]),
                            edge(self.upper[a])
                        ),
                    ));
                }
            }
        }
        let q = asked.map_or_else(|| vec![0.0; self.lower.len()], <[f64]>::to_vec);
        Ok((0..q.len()).map(|a| q[a].max(self.lower[a]).min(self.upper[a])).collect())
    }

    /// Where the axes can be within `seconds`; `None`: any time.
    fn reach(&self, from: &[f64], seconds: Option<f64>) -> Vec<[f64; 2]> {
        (0..from.len())
            .map(|a| {
                let far = match (seconds, self.robot.axis(a).max_speed) {
                    // rounding of both ends may not add to the speed
                    (Some(s), Some(v)) => (v * s - 2.0 * self.digit[a]).max(0.0),
                    _ => f64::INFINITY,
                };
                [self.lower[a].max(from[a] - far), self.upper[a].min(from[a] + far)]
            })
            .collect()
    }

    /// One bounded step towards the target; false where there is none.
    fn advance(&self, q: &mut [f64], target: &DVector<f64>, share: f64, reach: &[[f64; 2]]) -> bool {
        let (position, jacobian) = self.kinematics.position_and_jacobian(q);
        let velocity = (target - position) * share;
        let lower: Vec<f64> = q.iter().zip(reach).map(|(q, r)| (r[0] - q).clamp(-MOST_MOVE, 0.0)).collect();
        let upper: Vec<f64> = q.iter().zip(reach).map(|(q, r)| (r[1] - q).clamp(0.0, MOST_MOVE)).collect();
        let problem =
            Quadratic { jacobian: &jacobian, velocity: &velocity, lower: &lower, upper: &upper, scale: &self.scale };
        let Some(step) = problem.solve() else { return false };
        q.iter_mut().zip(&step).for_each(|(q, s)| *q += s);
        true
    }

    /// Equation 1 over `seconds`.
    fn step(&self, q: &mut [f64], target: &DVector<f64>, seconds: f64) {
        let distance = (target - self.kinematics.position_m(q)).norm();
        let parts = ((distance / STEP_M).ceil() as usize).clamp(1, MOST_PARTS);
        for k in 0..parts {
            let reach = self.reach(q, Some(seconds / parts as f64));
            // the way that is left, in as many parts as are left
            if !self.advance(q, target, 1.0 / (parts - k) as f64, &reach) {
                return;
            }
        }
    }

    /// Bounded Gauss-Newton; stops where no step brings the TCP nearer.
    fn meet(&self, q: &mut [f64], target: &DVector<f64>, reach: &[[f64; 2]]) {
        let miss = |q: &[f64]| (target - self.kinematics.position_m(q)).norm();
        let mut best = miss(q);
        let mut share = 1.0;
        for _ in 0..MOST_ITERATIONS {
            if best <= MET_M {
                return;
            }
            let mut trial = q.to_vec();
            if !self.advance(&mut trial, target, share, reach) {
                return;
            }
            let there = miss(&trial);
            if there < best {
                q.copy_from_slice(&trial);
                best = there;
                share = (2.0 * share).min(1.0);
            } else if share > 1e-6 {
                share *= 0.25;
            } else {
                return;
            }
        }
    }

    /// To the digits that are written, within reach.
    fn round(&self, q: &mut [f64], reach: &[[f64; 2]]) {
        for a in 0..q.len() {
            let d = self.digit[a];
            let mut v = (q[a] / d).round() * d;
            // half a digit out of reach: one digit back
            if v > self.upper[a].min(reach[a][1] + d) {
                v -= d;
            }
            if v < self.lower[a].max(reach[a][0] - d) {
                v += d;
            }
            q[a] = if self.lower[a] == self.upper[a] { self.lower[a] } else { v };
        }
    }

    /// Axes that stand at a bound.
    fn held(&self, q: &[f64], reach: &[[f64; 2]]) -> Vec<(usize, Bound)> {
        let near = |a: usize, v: f64| (q[a] - v).abs() <= (4.0 * self.digit[a]).max(1e-6 * self.scale[a]);
        (0..q.len())
            .filter_map(|a| {
                if near(a, self.lower[a]) || near(a, self.upper[a]) {
                    Some((a, Bound::Range))
                } else if near(a, reach[a][0]) || near(a, reach[a][1]) {
                    Some((a, Bound::Speed))
                } else {
                    None
                }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests;
