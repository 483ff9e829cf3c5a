//! The plan: each axis' command along the path, stroke by stroke.
//!
//! Between turns an axis is offset by its half gap in the direction of its movement (Zhang (2023) equation 16). At a turn it
//! goes over a stroke: the step (both half gaps and the friction gain) from the turning point to the step point, which
//! stands `step_fraction` of a program segment after it, or later where the joint could not do it sooner; then what
//! [`super::stroke`] finds until the friction has faded or the joint turns again. Nodes inside legs are laid fine enough for
//! the friction's decay and thinned to what the TCP needs ([`Options::shape_m`]).
//!
//! `turn` plans one stroke, `nodes` lays its nodes, `respond` finds the command where friction responds to it. Times after a turn come from
//! the program, or from the TCP path at constant speed, where the step itself takes time too.

mod nodes;
mod respond;
mod turn;

use super::Options;
use super::limits::{CYCLE_S, step_s};
use super::offset::{Offset, friction_gone};
use super::path::Path;
use super::stats::RewriteStats;
use super::stroke::Node;
use crate::compensator::FrictionOffset;
use crate::compensator::response::State;
use crate::robot::Robot;
use nalgebra::Vector3;
use respond::Along;
use std::collections::BTreeMap;
use std::sync::Arc;
use turn::Turn;

/// What tells the time along the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Clock {
    Times,
    /// TCP speed, m/s.
    Speed(f64),
    None,
}

/// Vertices of one stroke at most: what a look-ahead may hold.
const LONGEST_STROKE: usize = 16_384;
/// Nodes per time constant where the command may have to be held, and elsewhere.
const FINE: f64 = 64.0;
const COARSE: f64 = 8.0;
/// The step point stands at least this share of a leg after its turn.
pub(super) const NEAREST: f64 = 0.01;
/// Part of the step by which an evenly rising command may cut the bends of the program.
const CUT: f64 = 0.1;
/// ... or so many times the step itself, where that is nearer.
pub(super) const GENTLE: f64 = 20.0;
const MOST_NODES_PER_LEG: usize = 400;
/// Nodes per leg for friction that builds up over travel, at most: it has built up when the step is done.
const MOST_FOR_TRAVEL: f64 = 8.0;
/// Rounds in which command and friction of a stroke are found alternately.
const RESPONSE_PASSES: usize = 12;
/// They end where friction changes by no more than this share of it: what the last of as many halvings changes.
const SETTLED: f64 = 2e-4;

/// State of each axis along the path.
pub struct Plan<'a> {
    robot: &'a Robot,
    offsets: Vec<Option<Offset>>,
    active: Vec<usize>,
    step_fraction: f64,
    step_exact: bool,
    ramp: Vec<f64>,
    ramps_after: Arc<BTreeMap<(usize, u64), f64>>,
    shape_m: f64,
    dir: Vec<i8>,
    /// First vertex whose command is not yet known, per axis.
    done: Vec<usize>,
    /// Command of an axis that must not turn back while it catches up after a stroke.
    guard: Vec<bool>,
    /// Friction of each joint at the end of its last stroke, in the sense of that stroke.
    friction: Vec<State>,
    /// Where each joint stood when its present stroke began, rad or m.
    stands: Vec<Option<f64>>,
    next: usize,
    /// How far the look-ahead of an axis has come: turn, last vertex looked at, seconds since the turn.
    looked: Vec<(usize, usize, f64)>,
    work: Work,
    /// Memory for the joints at a turn, and the TCP's movement for each.
    here: Vec<f64>,
    columns: Vec<Vector3<f64>>,
}

/// Buffers that strokes share.
#[derive(Default)]
struct Work {
    nodes: Vec<Place>,
    machine: Vec<Node>,
    command: Vec<f64>,
    fall: Vec<f64>,
    keep: Vec<bool>,
    /// Places of nodes on a leg, as shares of it.
    shares: Vec<f64>,
    along: Along,
}

/// A node of a stroke on the path.
#[derive(Debug, Clone, Copy)]
struct Place {
    vertex: usize,
    share: f64,
    p: f64,
    since_s: f64,
    u: f64,
}

impl<'a> Plan<'a> {
    pub fn new(robot: &'a Robot, offsets: Vec<Option<Offset>>, options: &Options) -> Self {
        let axes = offsets.len();
        let active = (0..axes).filter(|&a| offsets[a].is_some()).collect();
        Self {
            robot,
            offsets,
            active,
            step_fraction: options.step_fraction.clamp(1e-4, 1.0),
            step_exact: options.step_exact,
            ramp: options.ramp.clone(),
            ramps_after: options.ramps_after.clone(),
            shape_m: options.shape_m,
            dir: options.initial_direction.clone(),
            done: vec![0; axes],
            guard: vec![false; axes],
            friction: vec![State::DRAGGED; axes],
            stands: vec![None; axes],
            next: 0,
            looked: vec![(usize::MAX, 0, 0.0); axes],
            work: Work::default(),
            here: Vec::new(),
            columns: Vec::new(),
        }
    }

    /// Works out commands as far as the path allows; returns the first vertex that is not settled.
    pub fn settle(&mut self, path: &mut Path, clock: Clock, end: bool, stats: &mut RewriteStats) -> usize {
        while self.next < path.end() {
            let k = self.next;
            // a leg is emitted with both its ends
            if !end && k + 1 >= path.end() {
                break;
            }
            let turn = path.next_turn(k).unwrap_or(usize::MAX);
            if turn == k && !self.strokes(k, path, clock, end, stats) {
                break;
            }
            // up to the next turn nothing but offsets
            let last = if end { path.end() } else { path.end() - 1 };
            let to = if turn == k { k + 1 } else { turn.min(last) };
            for a in 0..self.active.len() {
                let axis = self.active[a];
                self.offset_run(axis, k.max(self.done[axis]), to, path, stats);
            }
            self.next = to;
        }
        // vertex k is emitted with its leg, whose other end must be known as well
        if end { self.next } else { self.next.saturating_sub(1).max(path.start()) }
    }

    /// Offsets of one axis at the vertices `from..to`, between which it does not turn.
    fn offset_run(&mut self, axis: usize, from: usize, to: usize, path: &mut Path, stats: &mut RewriteStats) {
        let mut k = from;
        let Some(offset) = &self.offsets[axis] else { return };
        let dir = self.dir[axis];
        if dir == 0 {
            return;
        }
        let fixed = offset.is_plain().then(|| f64::from(dir) * offset.gap(dir, 0.0));
        while k < to {
            if let Some(by) = fixed
                && !self.guard[axis]
            {
                path.shift(axis, k, to, by);
                stats.largest_offset[axis] = stats.largest_offset[axis].max(by.abs());
                return;
            }
            self.plain(axis, k, path);
            let by = path.c(k)[axis] - path.q(k)[axis];
            stats.largest_offset[axis] = stats.largest_offset[axis].max(by.abs());
            k += 1;
        }
    }

    /// Between turns: the half gap in the direction of the movement, never turning back.
    #[inline]
    fn plain(&mut self, axis: usize, k: usize, path: &mut Path) {
        let Some(offset) = &self.offsets[axis] else { return };
        let dir = self.dir[axis];
        if dir == 0 {
            return;
        }
        let p = path.q(k)[axis];
        let mut c = p + f64::from(dir) * offset.gap(dir, p);
        if (self.guard[axis] || !offset.is_plain()) && k > path.start() {
            let before = path.c(k - 1)[axis];
            let d = f64::from(dir);
            if d * (c - before) < 0.0 && d * (p - path.q(k - 1)[axis]) >= 0.0 {
                c = before;
                path.mark_busy(k - 1, k);
            } else {
                self.guard[axis] = false;
            }
        }
        path.c_mut(k)[axis] = c;
    }

    /// All turns at vertex `k`; false where the path after is not there yet.
    fn strokes(&mut self, k: usize, path: &mut Path, clock: Clock, end: bool, stats: &mut RewriteStats) -> bool {
        let turns = path.turns(k);
        let mut ends = Vec::new();
        for a in 0..self.active.len() {
            let axis = self.active[a];
            if let Some(dir) = turns.of(axis) {
                match self.reach(axis, dir, k, path, clock, end) {
                    Some(last) => ends.push((axis, dir, last)),
                    None => return false,
                }
            }
        }
        for (axis, dir, last) in ends {
            let first_ever = self.dir[axis] == 0;
            // the command at the turn itself still belongs to the old direction
            if self.done[axis] <= k {
                self.plain(axis, k, path);
            }
            if first_ever {
                self.dir[axis] = dir;
                if k == 0 {
                    continue; // the first movement's direction holds from the first point on
                }
            } else {
                stats.reversals[axis] += 1;
            }
            self.stroke(Turn { axis, dir, k, last, first_ever }, path, clock, stats);
            self.dir[axis] = dir;
        }
        true
    }

    /// Last vertex of the stroke that begins at `k`: the friction has faded there, or the axis turns again, or the path
    /// ends; `None`: further points are needed.
    fn reach(&mut self, axis: usize, dir: i8, k: usize, path: &mut Path, clock: Clock, end: bool) -> Option<usize> {
        let offset = self.offsets[axis].as_ref()?;
        let friction = offset.friction();
        let step_s = self.step_time(axis, offset);
        let ramp = self.ramp_after(axis, k, path);
        let d = f64::from(dir);
        let p0 = path.q(k)[axis];
        let (u0, t0) = (path.u(k), path.t_s(k));
        let (from, mut since) = match self.looked[axis] {
            (turn, i, since) if turn == k => (i + 1, since),
            _ => (k + 1, 0.0),
        };
        // seconds matter to the step, and beyond it to friction that fades in seconds
        let fades = fades_in_time(friction.as_ref());
        for i in from..path.end() {
            match clock {
                Clock::Times => since = path.t_s(i) - t0,
                Clock::Speed(v) if fades || since < step_s => {
                    let leg = path.tcp_m(self.robot, i) - path.tcp_m(self.robot, i - 1);
                    since += (leg.norm() / v).max(CYCLE_S);
                }
                Clock::Speed(_) | Clock::None => {}
            }
            if path.turns(i).of(axis).is_some() || i - k >= LONGEST_STROKE {
                return Some(i);
            }
            let u = path.u(i) - u0;
            let travel = d * (path.q(i)[axis] - p0);
            let stepped = u >= self.step_fraction && (clock == Clock::None || since >= step_s) && travel >= ramp;
            let faded = friction.is_none_or(|f| friction_gone(&f, since, travel, u));
            if stepped && faded {
                return Some(i);
            }
            self.looked[axis] = (k, i, since);
        }
        (end && path.end() > k).then(|| path.end() - 1)
    }

    /// Travel over which the step of an axis is spread that turns at vertex `k`, rad or m.
    fn ramp_after(&self, axis: usize, k: usize, path: &Path) -> f64 {
        self.ramps_after.get(&(axis, path.origin(k).point())).copied().unwrap_or(self.ramp[axis])
    }

    /// Shortest time in which the joint can do its step ([`step_s`]).
    fn step_time(&self, axis: usize, offset: &Offset) -> f64 {
        step_s(self.robot.axis(axis), offset.largest_step())
    }
}

/// The friction needs a clock.
fn fades_in_time(friction: Option<&FrictionOffset>) -> bool {
    friction.is_some_and(|f| f.needs_clock())
}
