//! Limits of the joints on what comes out: range always; speed and acceleration where times, or a TCP speed, tell them.
//!
//! Range is checked at every point. Speed is checked on every leg of a program with times; without times only on legs on
//! which an offset changes, at the TCP speed of the program along its own path: the points of a step share the time of the
//! leg in which they stand, as in a program with times. (Were the way of the step itself to take time at that speed, all
//! other joints would have to stop for it; a controller blends it into the leg.) Acceleration is the change of speed between two legs over
//! their mean duration; it is checked where an offset changes. A corner of the program itself is not held against the
//! offsets: where the program alone exceeds the limit, what the offsets add must do so too. At a TCP speed that is known
//! without times the same holds for the joints' speeds, as the speed may be too high for a place where the TCP hardly moves.

use super::Origin;
use super::stats::{LimitKind, RewriteStats, Violation};
use crate::program::script::AxisSet;
use crate::robot::{Joint, Robot};

/// Violations that are listed in full.
const LISTED: usize = 100;
/// Reversals that are kept as strained: a program with more of them is refused.
const MOST_STRAINED: usize = 1 << 16;
/// Shortest duration of a segment, s: one interpolation cycle of a controller.
pub const CYCLE_S: f64 = 0.004;
/// A limit counts as exceeded beyond this share of itself: number noise of a value that stands on it.
const SLACK: f64 = 1e-9;

#[derive(Debug, Clone, Default)]
struct Last {
    q: Vec<f64>,
    t_s: f64,
    /// Speed on the leg that arrives here, and its duration; empty where it is not known.
    speed: Vec<f64>,
    /// The same of the program without offsets, and where it stands; empty where it is not known.
    own_speed: Vec<f64>,
    own_q: Vec<f64>,
    duration_s: f64,
}

/// Shortest time in which a joint can do a step (rad or m) within its own limits: half of its acceleration, half of its speed; at least one
/// interpolation cycle.
pub fn step_s(joint: &Joint, step: f64) -> f64 {
    let by_accel = joint.max_accel.map_or(0.0, |a| 2.0 * (step / (0.5 * a)).sqrt());
    let by_speed = joint.max_speed.map_or(0.0, |v| step / (0.5 * v));
    by_accel.max(by_speed).max(CYCLE_S)
}

/// Running checks.
pub struct Limits<'a> {
    robot: &'a Robot,
    range: Vec<[f64; 2]>,
    any_rate: bool,
    tcp_speed_m_s: Option<f64>,
    last: Option<Last>,
    first_t_s: Option<f64>,
    /// The program point at which each axis turned last, or after which it did.
    turned: Vec<Option<u64>>,
}

impl<'a> Limits<'a> {
    /// `unplaced`: axes of which it is not known where they stand in their range.
    pub fn new(robot: &'a Robot, tcp_speed_m_s: Option<f64>, unplaced: AxisSet) -> Self {
        let of = |(axis, j): (usize, &Joint)| j.limits.filter(|_| !unplaced.has(axis));
        let range =
            robot.axis_joints().enumerate().map(|at| of(at).unwrap_or([f64::NEG_INFINITY, f64::INFINITY])).collect();
        let any_rate = robot.axis_joints().any(|j| j.max_speed.is_some() || j.max_accel.is_some());
        let turned = vec![None; robot.dof()];
        Self { robot, range, any_rate, tcp_speed_m_s, last: None, first_t_s: None, turned }
    }

    /// An axis turns at program point `point`, or after it: what is checked from here on belongs to this reversal.
    pub fn turn(&mut self, axis: usize, point: u64) {
        if let Some(turned) = self.turned.get_mut(axis) {
            *turned = Some(point);
        }
    }

    /// Duration before and after, where the program has times: it keeps them.
    pub fn durations(&self) -> Option<[f64; 2]> {
        let d = self.last.as_ref()?.t_s - self.first_t_s?;
        Some([d, d])
    }

    /// Checks the next points, between which no offset changes.
    pub fn check_run(&mut self, q: &[f64], t_s: Option<&[f64]>, origin: &[Origin], stats: &mut RewriteStats) {
        let axes = self.range.len();
        let rows = origin.len();
        if rows == 0 {
            return;
        }
        for (row, &at) in q.chunks_exact(axes).zip(origin) {
            let mut inside = true;
            for (v, [lo, hi]) in row.iter().zip(&self.range) {
                inside &= v >= lo && v <= hi;
            }
            if !inside {
                self.range_of(row, at, stats);
            }
        }
        match t_s {
            Some(t) if self.any_rate => {
                for ((row, &t), &at) in q.chunks_exact(axes).zip(t).zip(origin) {
                    self.rates(row, None, Some(t), None, at, stats);
                }
            }
            _ => {
                let row = &q[(rows - 1) * axes..];
                let t = t_s.map_or(0.0, |t| t[rows - 1]);
                self.first_t_s = self.first_t_s.or(t_s.map(|t| t[0]));
                let last = self.last.get_or_insert_default();
                last.q.clear();
                last.q.extend_from_slice(row);
                last.speed.clear();
                last.own_q.clear();
                last.t_s = t;
            }
        }
    }

    /// Checks the next point, at which an offset may change; `own` is the program's own. `duration_s` is the time since the last point
    /// where it is known without `t_s`; else it comes from the way of the TCP.
    pub fn check(
        &mut self,
        q: &[f64],
        own: &[f64],
        t_s: Option<f64>,
        duration_s: Option<f64>,
        origin: Origin,
        stats: &mut RewriteStats,
    ) {
        self.range_of(q, origin, stats);
        self.rates(q, Some(own), t_s, duration_s, origin, stats);
    }

    /// The robot has limits of speed or acceleration.
    pub fn any_rate(&self) -> bool {
        self.any_rate
    }

    /// TCP speed at which rates are to be checked.
    pub fn rate_speed_m_s(&self) -> Option<f64> {
        self.tcp_speed_m_s.filter(|_| self.any_rate)
    }

    fn range_of(&self, q: &[f64], origin: Origin, stats: &mut RewriteStats) {
        for (axis, (&v, &[lo, hi])) in q.iter().zip(&self.range).enumerate() {
            if v < lo || v > hi {
                let limit = if v < lo { lo } else { hi };
                if (v - limit).abs() > SLACK * limit.abs().max(1e-3) {
                    add(stats, Violation { origin, axis, what: LimitKind::Range, value: v, limit });
                }
            }
        }
    }

    /// Duration of the leg from `last` to `q`: by the program's times, else as it is known, else by the way of the TCP; 0 where it
    /// is not known.
    fn duration_of_leg(&self, last: &Last, q: &[f64], t_s: Option<f64>, duration_s: Option<f64>) -> f64 {
        match (t_s, duration_s, self.tcp_speed_m_s) {
            (Some(t), _, _) => t - last.t_s,
            (None, Some(d), _) => d,
            (None, None, Some(v)) if self.any_rate => {
                ((self.robot.tcp_m(q) - self.robot.tcp_m(&last.q)).norm() / v).max(CYCLE_S)
            }
            _ => 0.0,
        }
    }

    /// `own` is there where an offset may change.
    fn rates(
        &mut self,
        q: &[f64],
        own: Option<&[f64]>,
        t_s: Option<f64>,
        duration_s: Option<f64>,
        origin: Origin,
        stats: &mut RewriteStats,
    ) {
        self.first_t_s = self.first_t_s.or(t_s);
        let Some(mut last) = self.last.take() else {
            self.last = Some(Last { q: q.to_vec(), t_s: t_s.unwrap_or(0.0), ..Last::default() });
            return;
        };
        let duration_s = self.duration_of_leg(&last, q, t_s, duration_s);
        if duration_s > 0.0 {
            let known = last.speed.len() == q.len();
            last.speed.resize(q.len(), 0.0);
            last.own_speed.resize(q.len(), 0.0);
            let mean_s = 0.5 * (duration_s + last.duration_s);
            for (axis, (joint, (now, before))) in self.robot.axis_joints().zip(q.iter().zip(&last.q)).enumerate() {
                let speed = (now - before) / duration_s;
                // no offset changes on the way from a point at which it is not known
                let own_speed = match (own, last.own_q.get(axis)) {
                    (Some(own), Some(before)) => (own[axis] - before) / duration_s,
                    _ => speed,
                };
                let mut check = |what, value: f64, own: f64, limit: f64| {
                    let beyond = |v: f64| v.abs() > limit * (1.0 + SLACK);
                    if beyond(value) && (!beyond(own) || beyond(value - own)) {
                        add(stats, Violation { origin, axis, what, value, limit });
                        if let Some(point) = self.turned[axis].filter(|_| stats.strained.len() < MOST_STRAINED) {
                            stats.strained.insert((axis, point));
                        }
                    }
                };
                if let Some(limit) = joint.max_speed {
                    check(LimitKind::Speed, speed, if t_s.is_some() { 0.0 } else { own_speed }, limit);
                }
                if let Some(limit) = joint.max_accel
                    && known
                    && own.is_some()
                {
                    let by = (own_speed - last.own_speed[axis]) / mean_s;
                    check(LimitKind::Acceleration, (speed - last.speed[axis]) / mean_s, by, limit);
                }
                last.speed[axis] = speed;
                last.own_speed[axis] = own_speed;
            }
        } else {
            last.speed.clear();
        }
        last.own_q.clear();
        last.own_q.extend_from_slice(own.unwrap_or_default());
        last.duration_s = duration_s;
        last.q.copy_from_slice(q);
        last.t_s = t_s.unwrap_or(0.0);
        self.last = Some(last);
    }
}

fn add(stats: &mut RewriteStats, violation: Violation) {
    let range = violation.what == LimitKind::Range;
    stats.violations_total += 1;
    stats.out_of_range += u64::from(range);
    // a position out of range is never lost after speeds and accelerations
    if stats.violations.len() < LISTED || (range && stats.out_of_range <= LISTED as u64) {
        stats.violations.push(violation);
    }
}

#[cfg(test)]
mod tests;
