//! The engine: blocks of points in, points with offsets out.
//!
//! Stations: ([`super::statics`] ->) ([`super::densify`] ->) [`super::turning`] -> [`super::path`], on which each axis' command is worked
//! out stroke by stroke ([`super::stroke`]), -> [`super::limits`] -> out. A station holds back only what its look-ahead needs: two
//! points for turning points, and after a turn with friction the points until the friction has faded. What comes out is in [`emit`].

mod emit;

use super::densify::Densify;
use super::equation2::{Equation2, Law};
use super::limits::Limits;
use super::milliseconds;
use super::offset::Offset;
use super::path::Path;
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
}
