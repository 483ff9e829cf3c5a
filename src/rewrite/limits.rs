//! Limits of the joints on what comes out: range always; speed and acceleration where times, or a TCP speed, tell them.
//!
//! Range is checked at every point. Speed is checked on every leg of a program with times; without times only on legs whose
//! offset changes, at the TCP speed of the program. Acceleration is the change of speed between two legs over their mean
//! duration; it is checked where an offset changes, so that a corner of the program itself is not held against the offsets.

use super::Origin;
use super::engine::{Account, LimitKind, Violation};
use crate::robot::Robot;

/// Violations that are listed in full.
const LISTED: usize = 100;
/// Shortest duration of a segment, s: one interpolation cycle of a controller.
pub const CYCLE_S: f64 = 0.004;
/// A limit counts as exceeded beyond this share of itself: number noise of a value that stands on it.
const SLACK: f64 = 1e-9;

#[derive(Debug, Clone, Default)]
struct Last {
    q: Vec<f64>,
    offset: Vec<f64>,
    t_s: f64,
    /// Speed on the leg that arrives here, and its duration; empty before the second point.
    speed: Vec<f64>,
    duration_s: f64,
    changed: bool,
}

/// Running checks.
pub struct Limits<'a> {
    robot: &'a Robot,
    range: Vec<[f64; 2]>,
    any_rate: bool,
    tcp_speed_m_s: Option<f64>,
    last: Option<Last>,
    first_t_s: Option<f64>,
}

impl<'a> Limits<'a> {
    pub fn new(robot: &'a Robot, tcp_speed_m_s: Option<f64>) -> Self {
        let range = robot.axis_joints().map(|j| j.limits.unwrap_or([f64::NEG_INFINITY, f64::INFINITY])).collect();
        let any_rate = robot.axis_joints().any(|j| j.max_speed.is_some() || j.max_accel.is_some());
        Self { robot, range, any_rate, tcp_speed_m_s, last: None, first_t_s: None }
    }

    /// Duration before and after, where the program has times: it keeps them.
    pub fn durations(&self) -> Option<[f64; 2]> {
        let d = self.last.as_ref()?.t_s - self.first_t_s?;
        Some([d, d])
    }

    /// Checks the next point: nominal joints, compensated joints.
    pub fn check(&mut self, nominal: &[f64], q: &[f64], t_s: Option<f64>, origin: Origin, account: &mut Account) {
        for (axis, (&v, &[lo, hi])) in q.iter().zip(&self.range).enumerate() {
            if v < lo || v > hi {
                let limit = if v < lo { lo } else { hi };
                if (v - limit).abs() > SLACK * limit.abs().max(1e-3) {
                    add(account, Violation { origin, axis, what: LimitKind::Range, value: v, limit });
                }
            }
        }
        if !self.any_rate || (t_s.is_none() && self.tcp_speed_m_s.is_none()) {
            return;
        }
        self.rates(nominal, q, t_s, origin, account);
    }

    fn rates(&mut self, nominal: &[f64], q: &[f64], t_s: Option<f64>, origin: Origin, account: &mut Account) {
        let axes = q.len();
        let Some(mut last) = self.last.take() else {
            self.first_t_s = t_s;
            let offset = q.iter().zip(nominal).map(|(c, n)| c - n).collect();
            self.last = Some(Last { q: q.to_vec(), offset, t_s: t_s.unwrap_or(0.0), ..Last::default() });
            return;
        };
        let inserted = matches!(origin, Origin::Inserted { .. });
        // an inserted point has no nominal of its own here; it stands where offsets change
        let mut changed = inserted;
        for axis in 0..axes {
            let offset = if inserted { last.offset[axis] } else { q[axis] - nominal[axis] };
            changed |= (offset - last.offset[axis]).abs() > 1e-3 * (q[axis] - last.q[axis]).abs();
            last.offset[axis] = offset;
        }
        let duration_s = match t_s {
            Some(t) => t - last.t_s,
            None if changed || last.changed => {
                let v = self.tcp_speed_m_s.unwrap_or(f64::INFINITY);
                ((self.robot.tcp_m(q) - self.robot.tcp_m(&last.q)).norm() / v).max(CYCLE_S)
            }
            None => 0.0,
        };
        if duration_s > 0.0 {
            let known = last.speed.len() == axes && last.duration_s > 0.0;
            last.speed.resize(axes, 0.0);
            for axis in 0..axes {
                let joint = self.robot.axis(axis);
                let speed = (q[axis] - last.q[axis]) / duration_s;
                if let Some(limit) = joint.max_speed
                    && speed.abs() > limit * (1.0 + SLACK)
                {
                    add(account, Violation { origin, axis, what: LimitKind::Speed, value: speed, limit });
                }
                if let Some(limit) = joint.max_accel
                    && known
                    && (changed || last.changed)
                {
                    let accel = (speed - last.speed[axis]) / (0.5 * (duration_s + last.duration_s));
                    if accel.abs() > limit * (1.0 + SLACK) {
                        add(account, Violation { origin, axis, what: LimitKind::Acceleration, value: accel, limit });
                    }
                }
                last.speed[axis] = speed;
            }
        } else {
            last.speed.clear();
        }
        last.duration_s = duration_s;
        last.changed = changed;
        last.q.copy_from_slice(q);
        last.t_s = t_s.unwrap_or(0.0);
        self.last = Some(last);
    }
}

fn add(account: &mut Account, violation: Violation) {
    account.violations_total += 1;
    if account.violations.len() < LISTED {
        account.violations.push(violation);
    }
}
