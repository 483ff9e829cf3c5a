//! Vertices with their offsets on their way out: runs between which no offset changes, single points, and what is inserted after them.

use super::super::limits::CYCLE_S;
use super::super::path::between;
use super::super::{Origin, OutputPoints, Refine};
use super::{Engine, NOTHING};
use crate::robot::Robot;
use std::collections::VecDeque;

/// The change at the TCP is looked at in all points up to this number, after it in one of so many, and in one of so many of those that
/// are added.
const CHANGES_ALL: u64 = 4096;
const CHANGE_EVERY: u64 = 64;
const CHANGE_EVERY_ADDED: u64 = 8;

/// Whether the change at the TCP is looked at here: at all points of a program that people read, and at some of a dense one.
fn changes_here(origin: Origin) -> bool {
    match origin {
        Origin::Point(n) => n < CHANGES_ALL || n.is_multiple_of(CHANGE_EVERY),
        Origin::Inserted { after, .. } => after < CHANGES_ALL || after.is_multiple_of(CHANGE_EVERY_ADDED),
    }
}

/// Of the sorted places of a leg that lasts `leg_s` those that a controller can tell apart: the last of each interpolation cycle,
/// so that no step ends before its joint can do it. Steps of several joints that end a little apart become one point.
fn one_of_each_cycle(shares: &mut Vec<f64>, leg_s: Option<f64>) {
    let apart = leg_s.map_or(0.0, |s| (CYCLE_S / s).min(0.5)).max(1e-6);
    let mut first = f64::NEG_INFINITY;
    shares.dedup_by(|next, kept| {
        // `kept` opens a cycle, or has been moved to the last place of it
        if first == f64::NEG_INFINITY {
            first = *kept;
        }
        let same = *next - first < apart;
        if same {
            *kept = *next;
        } else {
            first = *next;
        }
        same
    });
}

/// From what gears turn by to the values of the axes. A value that is no other than before is that of before to the last bit.
fn from_gears(robot: &Robot, nominal: &mut VecDeque<Vec<f64>>, row: &mut [f64], origin: Origin) {
    robot.from_gears(row);
    if matches!(origin, Origin::Point(_))
        && let Some(before) = nominal.pop_front()
    {
        for (v, before) in row.iter_mut().zip(before) {
            if (*v - before).abs() <= NOTHING * (1.0 + before.abs()) {
                *v = before;
            }
        }
    }
}

impl Engine<'_> {
    /// Distance of the TCP between two rows of what the gears turn, m.
    fn change_m(&self, command: &[f64], given: &[f64]) -> f64 {
        let tcp = |q: &[f64]| {
            if !self.robot.has_sums() {
                return self.robot.tcp_m(q);
            }
            let mut q = q.to_vec();
            self.robot.from_gears(&mut q);
            self.robot.tcp_m(&q)
        };
        (tcp(command) - tcp(given)).norm()
    }

    /// Vertices `from..to`, between which no offset changes.
    pub(super) fn emit_run(&mut self, from: usize, to: usize, out: &mut OutputPoints) {
        let timed = self.timed == Some(true);
        let (c, t_s, origin) = self.path.run(from, to);
        let start = out.q.len();
        out.q.extend_from_slice(c);
        if self.robot.has_sums() {
            for (row, origin) in out.q[start..].chunks_exact_mut(self.robot.dof()).zip(origin) {
                from_gears(self.robot, &mut self.nominal, row, *origin);
            }
        }
        self.limits.check_run(&out.q[start..], timed.then_some(t_s), origin, &mut self.stats);
        if timed {
            out.t_s.extend_from_slice(t_s);
        }
        out.origin.extend_from_slice(origin);
        if self.options.refine != Refine::None {
            for k in from..to {
                if let Some(given) = self.path.given(k) {
                    self.stats.largest_change_m = self.stats.largest_change_m.max(self.change_m(self.path.c(k), given));
                }
            }
        } else {
            // no offset changes here: the start, some places between for the lever, and the end where all points are looked at
            let (Origin::Point(n) | Origin::Inserted { after: n, .. }) = self.path.origin(from);
            let looked_at = |k: usize| {
                let all = n < CHANGES_ALL && (k == from || k + 1 == to);
                all || (n + (k - from) as u64).is_multiple_of(CHANGE_EVERY)
            };
            for k in (from..to).filter(|k| looked_at(*k)) {
                self.stats.largest_change_m =
                    self.stats.largest_change_m.max(self.change_m(self.path.c(k), self.path.q(k)));
            }
        }
        if self.densify.is_some() {
            self.stats.inserted += origin.iter().filter(|o| !matches!(o, Origin::Point(_))).count() as u64;
        }
    }

    /// Vertex `k`, then what is inserted in the leg after it.
    pub(super) fn emit(&mut self, k: usize, out: &mut OutputPoints) {
        let duration_s = self.arrives.take().filter(|a| a.0 == k).map(|a| a.1);
        self.emit_point(self.path.origin(k), self.path.t_s(k), None, duration_s, k, out);
        let turns = self.path.turns(k);
        for axis in (0..self.robot.dof()).filter(|a| turns.of(*a).is_some()) {
            self.limits.turn(axis, self.path.origin(k).point());
        }
        let last = k + 1 >= self.path.end();
        let known_s = self.options.legs_s.as_ref().and_then(|l| l.get(k + 1)).filter(|s| **s > 0.0).copied();
        let known_s = known_s.filter(|_| !last && self.limits.any_rate() && self.path.is_busy(k + 1));
        let leg_s = match self.limits.rate_speed_m_s() {
            _ if known_s.is_some() => known_s,
            Some(v) if !last && self.timed != Some(true) && self.path.is_busy(k + 1) => {
                let leg = self.path.tcp_m(self.robot, k + 1) - self.path.tcp_m(self.robot, k);
                Some((leg.norm() / v).max(CYCLE_S))
            }
            _ => None,
        };
        let mut at = 0.0;
        if self.path.knots(k).next().is_some() {
            let mut shares: Vec<f64> = self.path.knots(k).flat_map(|(_, knots)| knots.iter().map(|x| x.0)).collect();
            shares.sort_by(f64::total_cmp);
            let (a, b) = (self.path.origin(k), self.path.origin(k + 1));
            let (t0, t1) = (self.path.t_s(k), self.path.t_s(k + 1));
            let known_s = leg_s.or((self.timed == Some(true)).then_some(t1 - t0)).filter(|s| *s > 0.0);
            one_of_each_cycle(&mut shares, known_s);
            for share in shares {
                let duration_s = leg_s.map(|s| s * (share - at));
                at = share;
                self.emit_point(between(a, b, share), t0 + share * (t1 - t0), Some(share), duration_s, k, out);
            }
        }
        self.arrives = leg_s.map(|s| (k + 1, s * (1.0 - at)));
    }

    fn emit_point(
        &mut self,
        origin: Origin,
        t_s: f64,
        share: Option<f64>,
        duration_s: Option<f64>,
        k: usize,
        out: &mut OutputPoints,
    ) {
        let gain = self.options.gain;
        let axes = self.robot.dof();
        let at = out.q.len();
        self.own.clear();
        match share {
            None => {
                self.own.extend_from_slice(self.path.q(k));
                for (&q, &c) in self.path.q(k).iter().zip(self.path.c(k)) {
                    out.q.push(if gain == 1.0 { c } else { q + gain * (c - q) });
                }
            }
            Some(s) => {
                let lerp = |a: f64, b: f64| a + s * (b - a);
                for axis in 0..axes {
                    let (q0, q1) = (self.path.q(k)[axis], self.path.q(k + 1)[axis]);
                    let (c0, c1) = (self.path.c(k)[axis], self.path.c(k + 1)[axis]);
                    let knots = self.path.knots(k).find(|(a, _)| *a == axis);
                    let c = match knots {
                        None => lerp(c0, c1),
                        Some((_, knots)) => {
                            let i = knots.partition_point(|x| x.0 < s - 1e-6);
                            let (x0, y0) = if i == 0 { (0.0, c0) } else { knots[i - 1] };
                            let (x1, y1) = if i == knots.len() { (1.0, c1) } else { knots[i] };
                            if x1 - x0 < 1e-12 { y1 } else { y0 + ((s - x0) / (x1 - x0)).min(1.0) * (y1 - y0) }
                        }
                    };
                    let q = lerp(q0, q1);
                    self.own.push(q);
                    out.q.push(if gain == 1.0 { c } else { q + gain * (c - q) });
                }
            }
        }
        if self.robot.has_sums() {
            self.robot.from_gears(&mut self.own);
            from_gears(self.robot, &mut self.nominal, &mut out.q[at..], origin);
        }
        if self.options.refine != Refine::None {
            let given = |k: usize| self.path.given(k).unwrap_or_else(|| self.path.q(k));
            let given = match share {
                None => given(k).to_vec(),
                Some(s) => given(k).iter().zip(given(k + 1)).map(|(a, b)| a + s * (b - a)).collect(),
            };
            let mut given: Vec<f64> = given;
            if self.robot.has_sums() {
                self.robot.from_gears(&mut given);
            }
            let change = (self.robot.tcp_m(&out.q[at..]) - self.robot.tcp_m(&given)).norm();
            self.stats.largest_change_m = self.stats.largest_change_m.max(change);
        } else if changes_here(origin) {
            let change = (self.robot.tcp_m(&out.q[at..]) - self.robot.tcp_m(&self.own)).norm();
            self.stats.largest_change_m = self.stats.largest_change_m.max(change);
        }
        let timed = self.timed == Some(true);
        self.limits.check(&out.q[at..], &self.own, timed.then_some(t_s), duration_s, origin, &mut self.stats);
        if timed {
            out.t_s.push(t_s);
        }
        if !matches!(origin, Origin::Point(_)) {
            self.stats.inserted += 1;
        }
        out.origin.push(origin);
    }
}
