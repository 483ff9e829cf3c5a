//! The engine: blocks of points in, points with offsets out.
//!
//! Stations: ([`super::statics`] ->) ([`super::densify`] ->) [`super::turning`] -> [`super::path`], on which each axis' command is worked
//! out stroke by stroke ([`super::stroke`]), -> [`super::limits`] -> out. A station holds back only what its look-ahead needs: two
//! points for turning points, and after a turn with friction the points until the friction has faded.

use super::densify::Densify;
use super::equation2::{Equation2, Law};
use super::limits::{CYCLE_S, Limits};
use super::milliseconds;
use super::offset::Offset;
use super::path::{Path, between};
use super::plan::{Clock, Plan};
use super::radians::Suspicion;
use super::refusal::Refusal;
use super::stats::{RewriteStats, UncheckedRates};
use super::turning::Turning;
use super::{Options, Origin, OutputPoints, Points, Refine};
use crate::compensator::Compensator;
use crate::error::Result;
use crate::robot::Robot;
use std::collections::VecDeque;

/// State of a rewrite in progress.
pub struct Engine<'a> {
    robot: &'a Robot,
    options: Options,
    offsets: Vec<Option<Offset>>,
    /// Nothing to do: points pass as they are.
    idle: bool,
    /// Instead of everything after it, where another law than equation 16 is asked for.
    equation2: Option<Equation2>,
    densify: Option<Densify<'a>>,
    turning: Turning<'a>,
    path: Path,
    plan: Plan<'a>,
    limits: Limits<'a>,
    /// At constant TCP speed: the vertex that comes next, and how long after the last point it does, s.
    arrives: Option<(usize, f64)>,
    /// A point without its offsets.
    own: Vec<f64>,
    timed: Option<bool>,
    points: u64,
    /// Largest static correction per axis, rad or m.
    corrected: Vec<f64>,
    stats: RewriteStats,
    /// Points as they came in that have not come out, where gears turn by sums of axes.
    nominal: VecDeque<Vec<f64>>,
    radians: Suspicion,
    milliseconds: milliseconds::Suspicion,
}

/// A program of more axes is none of a robot.
const MOST_AXES: usize = 64;
/// A change of a joint that is none: rounding of the arithmetic, and of the way to the gears and back; rad or m.
pub(super) const NOTHING: f64 = 1e-13;

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

/// The change at the TCP is looked at in all points up to this number, after it in one of so many, and in one of so many of those that
/// are added.
const CHANGES_ALL: u64 = 4096;
const CHANGE_EVERY: u64 = 64;
const CHANGE_EVERY_ADDED: u64 = 8;

impl<'a> Engine<'a> {
    /// Prepares a rewrite. A friction offset that fades in seconds needs times or [`Options::tcp_speed_m_s`]; the first
    /// block of points tells whether there are times.
    pub fn new(robot: &'a Robot, compensator: &'a Compensator, options: Options) -> Result<Self> {
        let axes = robot.dof();
        if axes > MOST_AXES {
            return Err(Refusal::TooManyAxes { axes, most: MOST_AXES }.into());
        }
        if robot.has_sums() && (options.refine != Refine::None || options.law != Law::SymmetricHalfGap) {
            return Err(Refusal::SumOfAxes.into());
        }
        let idle = options.gain == 0.0 || (compensator.is_zero() && options.statics.is_none());
        let mut offsets: Vec<Option<Offset>> = vec![None; axes];
        if !idle {
            for joint in compensator.joints.iter().filter(|j| j.axis < axes && !options.without.has(j.axis)) {
                let offset = Offset::new(joint);
                if offset.largest_step() > 0.0 || offset.largest_gap() > 0.0 {
                    offsets[joint.axis] = Some(offset);
                }
            }
        }
        let cubic = options.refine != Refine::None;
        let turning = Turning::new(robot, &offsets, &options.deadband, &options.initial_direction, cubic);
        let densify =
            (options.refine == Refine::Cartesian && !idle).then(|| Densify::new(robot, options.chord_m.max(1e-8)));
        let plan = Plan::new(robot, offsets.clone(), &options);
        let stats = RewriteStats {
            reversals: vec![0; axes],
            largest_offset: vec![0.0; axes],
            largest_left: vec![0.0; axes],
            ..RewriteStats::default()
        };
        let limits = Limits::new(robot, options.tcp_speed_m_s, options.unplaced);
        let equation2 = (options.law != Law::SymmetricHalfGap && !idle)
            .then(|| Equation2::new(options.law == Law::Equation2Held, &options.deadband, &options.initial_direction));
        Ok(Self {
            robot,
            options,
            offsets,
            idle,
            equation2,
            densify,
            turning,
            path: Path::new(axes),
            plan,
            limits,
            arrives: None,
            own: Vec::with_capacity(axes),
            timed: None,
            points: 0,
            corrected: vec![0.0; axes],
            stats,
            nominal: VecDeque::new(),
            radians: Suspicion::default(),
            milliseconds: milliseconds::Suspicion::default(),
        })
    }

    /// Takes the next points and appends what is settled to `out`.
    pub fn push(&mut self, block: &Points, out: &mut OutputPoints) -> Result<()> {
        let timed = !block.t_s.is_empty();
        if self.timed.is_none() {
            self.timed = Some(timed);
            self.need_clock(timed)?;
        }
        out.axes = block.axes;
        self.radians.see(block, self.robot);
        self.milliseconds.see(block, self.robot);
        if self.idle {
            out.q.extend_from_slice(&block.q);
            out.t_s.extend_from_slice(&block.t_s);
            out.origin.extend((self.points..self.points + block.len() as u64).map(Origin::Point));
            self.points += block.len() as u64;
            // nothing is changed, so nothing is held against the offsets
            return Ok(());
        }
        let shifted;
        let block = match &self.options.statics {
            None => block,
            Some(statics) => {
                shifted = statics.commands(block, self.options.gain, &mut self.corrected);
                &shifted
            }
        };
        if self.equation2.is_some() {
            self.printed(block, timed, out);
            return Ok(());
        }
        // from here to the points that come out an axis is what its gear turns by
        let turned;
        let block = if self.robot.has_sums() {
            let mut own = block.clone();
            for row in own.q.chunks_exact_mut(own.axes) {
                self.nominal.push_back(row.to_vec());
                self.robot.to_gears(row);
            }
            turned = own;
            &turned
        } else {
            block
        };
        match &mut self.densify {
            None => self.turning.extend(&block.q, &block.t_s, self.points),
            Some(d) => {
                for i in 0..block.len() {
                    let t_s = block.t_s.get(i).copied().unwrap_or(0.0);
                    d.push(block.row(i), t_s, timed, Origin::Point(self.points + i as u64), &mut self.turning);
                    if i & 63 == 63 {
                        self.turning.hand_on(&mut self.path, false);
                    }
                }
            }
        }
        self.points += block.len() as u64;
        self.advance(false, out);
        Ok(())
    }

    /// Appends what is left and returns the statistics.
    pub fn finish(mut self, out: &mut OutputPoints) -> Result<RewriteStats> {
        out.axes = self.robot.dof();
        if let Some(d) = &mut self.densify {
            d.finish(&mut self.turning);
        }
        self.advance(true, out);
        self.stats.points = self.points;
        self.stats.looks_like_radians = self.radians.is_probable();
        self.stats.looks_like_milliseconds = self.milliseconds.is_probable();
        for (offset, by) in self.stats.largest_offset.iter_mut().zip(&self.corrected) {
            *offset += by;
        }
        self.stats.duration_s = self.limits.durations();
        if !self.idle {
            self.stats.unchecked_rates = self.unchecked_rates();
        }
        Ok(self.stats)
    }

    /// Points by equation 2: as many as come in.
    fn printed(&mut self, block: &Points, timed: bool, out: &mut OutputPoints) {
        let Some(law) = &mut self.equation2 else { return };
        for i in 0..block.len() {
            let (at, q) = (out.q.len(), block.row(i));
            law.apply(self.robot, &self.offsets, q, &mut out.q, &mut self.stats);
            for (c, &p) in out.q[at..].iter_mut().zip(q) {
                *c = p + self.options.gain * (*c - p);
            }
            let t_s = timed.then(|| block.t_s[i]);
            let origin = Origin::Point(self.points);
            self.limits.check(&out.q[at..], q, t_s, None, origin, &mut self.stats);
            out.t_s.extend(t_s);
            out.origin.push(origin);
            self.points += 1;
        }
    }

    fn unchecked_rates(&self) -> Option<UncheckedRates> {
        let legs = self.options.legs_s.as_deref();
        let known = |legs: &[f64]| legs.iter().all(|s| s.is_finite());
        let clocked = self.timed == Some(true) || self.options.tcp_speed_m_s.is_some() || legs.is_some_and(known);
        match (self.limits.any_rate(), clocked) {
            (false, _) => Some(UncheckedRates::NoLimits),
            (true, false) if legs.is_some_and(|l| l.iter().any(|s| *s > 0.0)) => Some(UncheckedRates::SomeSpeeds),
            (true, false) => Some(UncheckedRates::NoTimes),
            (true, true) => None,
        }
    }

    fn need_clock(&self, timed: bool) -> Result<()> {
        let seconds = |o: &Offset| o.friction().is_some_and(|f| f.needs_clock());
        let axis = self.offsets.iter().position(|o| o.as_ref().is_some_and(seconds));
        match axis {
            Some(axis) if !timed && self.options.tcp_speed_m_s.is_none() => {
                Err(Refusal::NoClock { joint: self.robot.axis(axis).name.clone() }.into())
            }
            _ => Ok(()),
        }
    }

    fn advance(&mut self, end: bool, out: &mut OutputPoints) {
        self.turning.hand_on(&mut self.path, end);
        let clock = match (self.timed, self.options.tcp_speed_m_s) {
            (Some(true), _) => Clock::Times,
            (_, Some(v)) => Clock::Speed(v),
            _ => Clock::None,
        };
        let settled = self.plan.settle(&mut self.path, clock, end, &mut self.stats);
        let mut k = self.path.start();
        while k < settled {
            let quiet = if self.options.gain == 1.0 { self.path.next_busy(k, settled) } else { k };
            if quiet > k {
                self.emit_run(k, quiet, out);
                k = quiet;
            } else {
                self.emit(k, out);
                k += 1;
            }
        }
        self.path.release(settled);
    }

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
    fn emit_run(&mut self, from: usize, to: usize, out: &mut OutputPoints) {
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
    fn emit(&mut self, k: usize, out: &mut OutputPoints) {
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
