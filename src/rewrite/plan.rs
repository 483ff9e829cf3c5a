//! The plan: each axis' command along the path, stroke by stroke.
//!
//! Between turns an axis is offset by its half gap in the direction of its movement (Zhang (2023) equation 16). At a turn it
//! goes over a stroke: the step (both half gaps and the friction gain) from the turning point to the step point, which
//! stands `step_fraction` of a program segment behind it, or later where the joint could not do it sooner; then what
//! [`super::stroke`] finds until the friction has faded or the joint turns again. Nodes inside legs are laid fine enough for
//! the friction's decay and thinned to what the TCP needs ([`Options::shape_m`]).
//!
//! Times behind a turn come from the program, or from the TCP path at constant speed, where the step itself takes time too.

use super::Options;
use super::engine::Account;
use super::limits::CYCLE_S;
use super::offset::{Offset, friction_gone, friction_left};
use super::path::{Knots, Path};
use super::stroke::{Node, largest_error, solve, thin, travel_command};
use crate::compensator::response::State;
use crate::compensator::{FrictionOffset, FrictionShape, Response};
use crate::effects::Decay;
use crate::robot::Robot;
use nalgebra::Vector3;

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
/// The step point stands at least this share of a leg behind its turn.
const NEAREST: f64 = 0.01;
/// Part of the step by which an evenly rising command may cut the bends of the program.
const CUT: f64 = 0.1;
/// ... or so many times the step itself, where that is nearer.
const GENTLE: f64 = 20.0;
const MOST_NODES_PER_LEG: usize = 400;
/// Nodes per leg for friction that builds up over travel, at most: it has built up when the step is done.
const MOST_FOR_TRAVEL: f64 = 8.0;
/// Rounds in which command and friction of a stroke are found in turn.
const RESPONSE_PASSES: usize = 12;

/// State of each axis along the path.
pub struct Plan<'a> {
    robot: &'a Robot,
    offsets: Vec<Option<Offset>>,
    active: Vec<usize>,
    step_fraction: f64,
    step_exact: bool,
    ramp: Vec<f64>,
    shape_m: f64,
    dir: Vec<i8>,
    /// First vertex whose command is not yet known, per axis.
    done: Vec<usize>,
    /// Command of an axis that must not turn back while it catches up behind a stroke.
    guard: Vec<bool>,
    /// Friction of each joint at the end of its last stroke, in the sense of that stroke.
    friction: Vec<State>,
    /// Where each joint stood when its present stroke began, rad or m.
    stands: Vec<Option<f64>>,
    next: usize,
    /// How far the look-ahead of an axis has come: turn, last vertex looked at, seconds since the turn.
    looked: Vec<(usize, usize, f64)>,
    work: Work,
}

/// Buffers that strokes share.
#[derive(Default)]
struct Work {
    nodes: Vec<Place>,
    machine: Vec<Node>,
    command: Vec<f64>,
    fall: Vec<f64>,
    keep: Vec<bool>,
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
            shape_m: options.shape_m,
            dir: options.initial_direction.clone(),
            done: vec![0; axes],
            guard: vec![false; axes],
            friction: vec![State::DRAGGED; axes],
            stands: vec![None; axes],
            next: 0,
            looked: vec![(usize::MAX, 0, 0.0); axes],
            work: Work::default(),
        }
    }

    /// Works out commands as far as the path allows; returns the first vertex that is not settled.
    pub fn settle(&mut self, path: &mut Path, clock: Clock, end: bool, account: &mut Account) -> usize {
        while self.next < path.end() {
            let k = self.next;
            // a leg is emitted with both its ends
            if !end && k + 1 >= path.end() {
                break;
            }
            let turn = path.next_turn(k).unwrap_or(usize::MAX);
            if turn == k && !self.strokes(k, path, clock, end, account) {
                break;
            }
            // up to the next turn nothing but offsets
            let last = if end { path.end() } else { path.end() - 1 };
            let to = if turn == k { k + 1 } else { turn.min(last) };
            for a in 0..self.active.len() {
                let axis = self.active[a];
                self.offset_run(axis, k.max(self.done[axis]), to, path, account);
            }
            self.next = to;
        }
        // vertex k is emitted with its leg, whose other end must be known as well
        if end { self.next } else { self.next.saturating_sub(1).max(path.start()) }
    }

    /// Offsets of one axis at the vertices `from..to`, between which it does not turn.
    fn offset_run(&mut self, axis: usize, from: usize, to: usize, path: &mut Path, account: &mut Account) {
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
                account.largest_offset[axis] = account.largest_offset[axis].max(by.abs());
                return;
            }
            self.plain(axis, k, path);
            let by = path.c(k)[axis] - path.q(k)[axis];
            account.largest_offset[axis] = account.largest_offset[axis].max(by.abs());
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

    /// All turns at vertex `k`; false where the path behind is not there yet.
    fn strokes(&mut self, k: usize, path: &mut Path, clock: Clock, end: bool, account: &mut Account) -> bool {
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
                account.reversals[axis] += 1;
            }
            self.stroke(axis, dir, k, last, first_ever, path, clock, account);
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
            let stepped =
                u >= self.step_fraction && (clock == Clock::None || since >= step_s) && travel >= self.ramp[axis];
            let faded = friction.is_none_or(|f| friction_gone(&f, since, travel, u));
            if stepped && faded {
                return Some(i);
            }
            self.looked[axis] = (k, i, since);
        }
        (end && path.end() > k).then(|| path.end() - 1)
    }

    /// Shortest time in which the joint can do its step within its own limits: half of its acceleration, half of its
    /// speed; at least one interpolation cycle.
    fn step_time(&self, axis: usize, offset: &Offset) -> f64 {
        let step = offset.largest_step();
        let joint = self.robot.axis(axis);
        let by_accel = joint.max_accel.map_or(0.0, |a| 2.0 * (step / (0.5 * a)).sqrt());
        let by_speed = joint.max_speed.map_or(0.0, |v| step / (0.5 * v));
        by_accel.max(by_speed).max(CYCLE_S)
    }

    /// One stroke of `axis` from the turn at vertex `k` to vertex `last`.
    #[allow(clippy::too_many_arguments)]
    fn stroke(
        &mut self,
        axis: usize,
        dir: i8,
        k: usize,
        last: usize,
        first_ever: bool,
        path: &mut Path,
        clock: Clock,
        account: &mut Account,
    ) {
        let Some(offset) = self.offsets[axis].clone() else { return };
        if last == k {
            self.done[axis] = k + 1;
            return;
        }
        let d = f64::from(dir);
        let (p_turn, c_turn) = (path.q(k)[axis], path.c(k)[axis]);
        let gap_old = if first_ever { 0.0 } else { offset.gap(-dir, c_turn) };
        // where the joint stands: dragged in the old direction at the distance of the gap, unless that stroke was too short
        // to move it at all
        let response =
            offset.friction().and_then(|f| if let FrictionShape::Response(r) = f.shape { Some(r) } else { None });
        let before = if first_ever { State::DRAGGED } else { self.friction[axis].reversed() };
        // a wind-up that had not built up and a spike that had not decayed shift the place where the joint stands
        let shift = response.filter(|_| !first_ever).map_or(0.0, |r| -r.back(&before) - r.windup());
        let dragged = c_turn + d * (gap_old + shift);
        let y0 = match self.stands[axis] {
            Some(before) if d * (before - dragged) < 0.0 => before,
            _ => dragged,
        };
        self.stands[axis] = Some(y0);
        let open = path.turns(last).of(axis).is_some();
        let friction = if first_ever { None } else { offset.friction() };
        let step_s = self.step_time(axis, &offset);
        let mut columns = vec![Vector3::zeros(); self.robot.dof()];
        let mut q = path.q(k).to_vec();
        self.robot.from_gears(&mut q);
        self.robot.chain().position_and_jacobian(&q, &mut columns);
        let lever = columns[axis];

        let fades = fades_in_time(friction.as_ref());
        // legs behind the turn: duration by the nominal path; the step adds its own time
        let mut work = std::mem::take(&mut self.work);
        let legs = self.legs(k, last, path, clock, if fades { f64::INFINITY } else { step_s });
        let mut jump = offset.gap(dir, p_turn) + gap_old + friction.map_or(0.0, |f| f.gain.max(0.0));
        let passes = if matches!(clock, Clock::Speed(_)) && fades { 3 } else { 1 };
        let mut first = 0;
        work.command.clear();
        for _ in 0..passes {
            first = self.lay_nodes(
                axis,
                k,
                path,
                clock,
                &legs,
                lever * (d * jump),
                lever.norm(),
                step_s,
                p_turn,
                d,
                friction.as_ref(),
                &mut work,
            );
            work.machine.clear();
            let u0 = path.u(k);
            for n in &work.nodes {
                let travel = d * (n.p - y0);
                let left = friction.map_or(0.0, |f| friction_left(&f, n.since_s, d * (n.p - p_turn), n.u - u0));
                work.machine.push(Node { travel, gap: offset.gap(dir, n.p), friction: left });
            }
            match friction.map(|f| (f.gain, f.shape)) {
                Some((_, FrictionShape::Response(r))) => {
                    let start = d * (c_turn - y0);
                    let end = respond(&r, &before, start, first, &mut work);
                    self.friction[axis] = if open { end } else { State::DRAGGED };
                }
                Some((gain, FrictionShape::Decay(Decay::Travel(lambda)))) => {
                    work.command.clear();
                    work.command.extend(
                        work.machine.iter().map(|m| travel_command(m.travel + gap_old + m.gap, gain, lambda) - gap_old),
                    );
                }
                _ => {
                    solve(&work.machine, first, open, &mut work.command, &mut work.fall);
                }
            }
            jump = work.command.get(first).copied().unwrap_or(0.0) - d * (c_turn - y0);
        }
        self.ramped(axis, d, p_turn, d * (c_turn - y0), first, clock, &mut work);
        if !matches!(friction.map(|f| f.shape), Some(FrictionShape::Decay(Decay::Travel(_)))) {
            let left = largest_error(&work.machine, &work.command);
            account.largest_left[axis] = account.largest_left[axis].max(left);
        }

        let largest = work.command.iter().zip(&work.nodes).map(|(c, n)| (y0 + d * c - n.p).abs()).fold(0.0, f64::max);
        account.largest_change_m = account.largest_change_m.max(lever.norm() * largest);
        account.largest_offset[axis] = account.largest_offset[axis].max(largest);

        // thin, then hand values to vertices and knots to legs; the command never turns back
        let x: Vec<f64> = work.nodes.iter().map(|n| n.u).collect();
        let y: Vec<f64> = work.command.iter().map(|c| y0 + d * c).collect();
        let tolerance = self.shape_m / lever.norm().max(1e-6);
        // between the turn and the step point the step is one straight line
        thin(&x[first..], &y[first..], tolerance, &mut work.keep);
        let mut value = c_turn;
        let mut knots: Knots = Vec::new();
        let mut leg = k;
        for (i, n) in work.nodes.iter().enumerate() {
            let c = y[i];
            value = if d * (c - value) < 0.0 { value } else { c };
            if n.vertex != leg {
                // leg by leg
                if !knots.is_empty() {
                    path.add_knots(leg, axis, std::mem::take(&mut knots));
                }
                leg = n.vertex;
            }
            if n.share == 0.0 {
                path.c_mut(n.vertex)[axis] = value;
            } else if i == first || (i > first && work.keep[i - first]) {
                knots.push((n.share, value));
            }
        }
        if !knots.is_empty() {
            path.add_knots(leg, axis, knots);
        }
        self.work = work;
        path.mark_busy(k, last);
        self.done[axis] = last + 1;
        self.guard[axis] = true;
    }

    /// Spreads the step over the chosen travel: the command rises in proportion to it.
    #[allow(clippy::too_many_arguments)]
    fn ramped(&self, axis: usize, d: f64, p_turn: f64, start: f64, first: usize, clock: Clock, work: &mut Work) {
        let ramp = self.ramp[axis];
        if ramp > 0.0 {
            for (i, n) in work.nodes.iter().enumerate().skip(first) {
                let share = (d * (n.p - p_turn) / ramp).clamp(0.0, 1.0);
                let travel = work.machine[i].travel;
                work.command[i] = travel + start + (work.command[i] - travel - start) * share;
            }
        }
        // on the way to the step point the offset rises evenly, so that the bends of legs between are not cut; where they are
        // nearly straight the command itself rises evenly, which asks less of the joint
        let (Some(from), Some(to)) = (work.nodes.first().map(|n| n.u), work.nodes.get(first).map(|n| n.u)) else {
            return;
        };
        let travel = |i: usize| work.machine[i].travel;
        let level = work.command[first];
        let (low, high) = (start - travel(0), level - travel(first));
        let share = |i: usize| if to > from { (work.nodes[i].u - from) / (to - from) } else { 0.0 };
        let bent = |i: usize| travel(i) + low + (high - low) * share(i);
        let even = |i: usize| start + (level - start) * share(i);
        let nearly = (0..first).all(|i| (bent(i) - even(i)).abs() <= CUT * (high - low).abs());
        let rise: Vec<f64> = (0..first)
            .map(|i| match clock {
                _ if i == 0 => start,
                Clock::Times | Clock::None if nearly => even(i),
                _ => bent(i),
            })
            .collect();
        work.command[..first].copy_from_slice(&rise);
    }

    /// TCP vectors and durations of the nominal legs from `k` to `last`; at constant speed zero beyond `until_s`, where they
    /// do not matter.
    fn legs(&self, k: usize, last: usize, path: &mut Path, clock: Clock, until_s: f64) -> Vec<(Vector3<f64>, f64)> {
        let mut since = 0.0;
        (k..last)
            .map(|i| match clock {
                Clock::Times => (Vector3::zeros(), path.t_s(i + 1) - path.t_s(i)),
                Clock::Speed(v) if since < until_s => {
                    let leg = path.tcp_m(self.robot, i + 1) - path.tcp_m(self.robot, i);
                    let duration = (leg.norm() / v).max(CYCLE_S);
                    since += duration;
                    (leg, duration)
                }
                Clock::Speed(_) | Clock::None => (Vector3::zeros(), 0.0),
            })
            .collect()
    }

    /// Lays the nodes of a stroke; node 0 is the turn. Returns the index of the step point.
    #[allow(clippy::too_many_arguments)]
    fn lay_nodes(
        &self,
        axis: usize,
        k: usize,
        path: &Path,
        clock: Clock,
        legs: &[(Vector3<f64>, f64)],
        jump_m: Vector3<f64>,
        lever_m: f64,
        step_s: f64,
        p_turn: f64,
        d: f64,
        friction: Option<&FrictionOffset>,
        work: &mut Work,
    ) -> usize {
        let nodes = &mut work.nodes;
        nodes.clear();
        let u0 = path.u(k);
        nodes.push(Place { vertex: k, share: 0.0, p: p_turn, since_s: 0.0, u: u0 });
        let mut first = None;
        let mut elapsed = 0.0;
        for (n, &(leg_m, duration)) in legs.iter().enumerate() {
            let i = k + n;
            let (ua, ub) = (path.u(i), path.u(i + 1));
            let (pa, pb) = (path.q(i)[axis], path.q(i + 1)[axis]);
            let mut shares: Vec<f64> = Vec::new();
            let mut step_here = None;
            if first.is_none() {
                // the step point: a fraction of a program segment behind the turn, and not before the joint can
                let by_u = if ub > ua { (u0 + self.step_fraction - ua) / (ub - ua) } else { 1.0 };
                let by_t = if clock != Clock::None && duration > 0.0 { (step_s - elapsed) / duration } else { 0.0 };
                // nearer, where the joint would lag by more than the tolerance until then
                let lag = (lever_m * (pb - pa)).abs();
                // on a long leg not steeper than the joint moves anyway, or a controller would have to stop for it
                let nearest = NEAREST.min(GENTLE * jump_m.norm() / lag.max(f64::MIN_POSITIVE));
                let near =
                    if self.step_exact || lag <= 0.0 { by_u } else { by_u.min((self.shape_m / lag).max(nearest)) };
                let share = near.max(by_t);
                if share <= 1.0 - 1e-6 {
                    step_here = Some(share.max(1e-6));
                }
            }
            if let Some(f) = friction {
                let parts = subdivisions(f, duration, elapsed, (pb - pa) * d, ub - ua);
                let from = step_here.unwrap_or(0.0);
                if first.is_some() || step_here.is_some() {
                    shares.extend((1..parts).map(|m| from + (1.0 - from) * m as f64 / parts as f64));
                }
            }
            if let Some(s) = step_here {
                shares.insert(0, s);
            }
            // the end of a ramp bends the command
            let ramp_end = p_turn + d * self.ramp[axis];
            if self.ramp[axis] > 0.0 && d * (ramp_end - pa) > 0.0 && d * (pb - ramp_end) > 0.0 {
                let s = (ramp_end - pa) / (pb - pa);
                let i = shares.partition_point(|x| *x < s);
                if first.is_some() || step_here.is_some_and(|h| h < s) {
                    shares.insert(i, s);
                }
            }
            // the step takes time of its own at constant speed
            let mut extra = 0.0;
            if let (Some(s), Clock::Speed(v)) = (step_here, clock) {
                let to_step = leg_m * s;
                extra = (((to_step + jump_m).norm() - to_step.norm()) / v).max(0.0);
            }
            for s in shares {
                if step_here == Some(s) && first.is_none() {
                    first = Some(nodes.len());
                }
                let since_s = elapsed + s * duration + extra;
                nodes.push(Place { vertex: i, share: s, p: pa + s * (pb - pa), since_s, u: ua + s * (ub - ua) });
            }
            elapsed += duration + extra;
            if first.is_none() && n + 1 < legs.len() {
                // the step may end on a vertex
                let here = (ub - u0 - self.step_fraction).abs() < 1e-6 && (clock == Clock::None || elapsed >= step_s);
                if here {
                    first = Some(nodes.len());
                }
            }
            nodes.push(Place { vertex: i + 1, share: 0.0, p: pb, since_s: elapsed, u: ub });
        }
        first.unwrap_or(nodes.len() - 1)
    }
}

/// Command of a stroke whose friction responds: what friction does depends on the command, so both are found in turn. Returns
/// the state of friction at the end of the stroke.
fn respond(r: &Response, before: &State, start: f64, first: usize, work: &mut Work) -> State {
    let n = work.machine.len();
    let mut last = *before;
    for _ in 0..RESPONSE_PASSES {
        let known = work.command.len() == n;
        let (u0, u1) = (work.nodes[0].u, work.nodes[first].u);
        let command = |k: usize| {
            if !known {
                work.machine[k].travel
            } else if k < first {
                start + (work.command[first] - start) * (work.nodes[k].u - u0) / (u1 - u0).max(f64::MIN_POSITIVE)
            } else {
                work.command[k]
            }
        };
        let mut state = *before;
        let mut friction = Vec::with_capacity(n);
        for i in 0..n {
            if i > 0 {
                let joint = work.machine[i].travel - work.machine[i - 1].travel;
                let dt_s = work.nodes[i].since_s - work.nodes[i - 1].since_s;
                state = r.advance(&state, command(i) - command(i - 1), joint, dt_s);
            }
            let now = r.back(&state) - r.windup();
            friction.push(if known { 0.5 * (work.machine[i].friction + now) } else { now });
        }
        last = state;
        work.machine.iter_mut().zip(friction).for_each(|(m, f)| m.friction = f);
        solve(&work.machine, first, false, &mut work.command, &mut work.fall);
    }
    last
}

/// The friction needs a clock.
fn fades_in_time(friction: Option<&FrictionOffset>) -> bool {
    friction.is_some_and(|f| f.needs_clock())
}

/// Parts of a leg that resolve the friction's decay there.
fn subdivisions(f: &FrictionOffset, duration_s: f64, elapsed_s: f64, travel: f64, poses: f64) -> usize {
    let parts = match f.shape {
        FrictionShape::Decay(Decay::Time(tau)) => {
            if elapsed_s > -tau * 1e-3f64.ln() {
                1.0
            } else {
                // the command may fall where the joint is slower than the friction fades
                let falls = travel * tau < f.gain * (-elapsed_s / tau).exp() * duration_s;
                duration_s / tau * if falls { FINE } else { COARSE }
            }
        }
        FrictionShape::Decay(Decay::Travel(lambda)) => travel.abs() / lambda * COARSE,
        FrictionShape::Poses { .. } => poses * COARSE,
        FrictionShape::Response(r) => {
            let early = r.spikes.iter().filter(|s| s.gain != 0.0 && elapsed_s <= -s.decay_s * 1e-3f64.ln());
            let in_time = early.map(|s| duration_s / s.decay_s).fold(0.0, f64::max);
            (in_time * COARSE).max((travel.abs() / r.presliding * COARSE).min(MOST_FOR_TRAVEL))
        }
    };
    if parts.is_nan() { 1 } else { (parts.ceil() as usize).clamp(1, MOST_NODES_PER_LEG) }
}
