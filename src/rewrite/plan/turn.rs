//! The stroke of one axis after a turn: from the command at the turn to where the friction has faded.
//!
//! Nodes are laid ([`super::nodes`]), what the machine does at each is written down, the command is solved for
//! ([`super::super::stroke`]), thinned, and handed to the vertices and legs of the path. At constant speed the step itself takes
//! time, so that nodes and command are found alternately.

use super::respond::respond;
use super::{CUT, Clock, Plan, Work, fades_in_time};
use crate::compensator::response::State;
use crate::compensator::{FrictionOffset, FrictionShape};
use crate::effects::Decay;
use crate::rewrite::limits::CYCLE_S;
use crate::rewrite::offset::{Offset, friction_left};
use crate::rewrite::path::{Knots, Path};
use crate::rewrite::stats::RewriteStats;
use crate::rewrite::stroke::{Node, largest_error, solve, thin, travel_command};
use nalgebra::Vector3;

/// A turn of an axis at vertex `k`, and the vertex up to which its stroke goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Turn {
    pub(super) axis: usize,
    pub(super) dir: i8,
    pub(super) k: usize,
    pub(super) last: usize,
    /// The first movement of the axis: no gap is crossed.
    pub(super) first_ever: bool,
}

/// A stroke and where it starts; rad or m.
pub(super) struct Stroke {
    turn: Turn,
    pub(super) axis: usize,
    pub(super) k: usize,
    /// Sense of the new movement.
    pub(super) d: f64,
    pub(super) p_turn: f64,
    c_turn: f64,
    gap_old: f64,
    /// Where the joint stands.
    y0: f64,
    /// Friction before the turn, in the new sense.
    before: State,
    /// The stroke ends at another turn of the axis.
    open: bool,
    pub(super) friction: Option<FrictionOffset>,
    /// TCP movement per joint movement, m.
    pub(super) lever: Vector3<f64>,
    pub(super) step_s: f64,
    /// Travel over which the step is spread, rad or m; 0: at once.
    pub(super) ramp: f64,
}

impl Plan<'_> {
    /// Plans one stroke.
    pub(super) fn stroke(&mut self, turn: Turn, path: &mut Path, clock: Clock, stats: &mut RewriteStats) {
        let Turn { axis, k, last, .. } = turn;
        let Some(offset) = self.offsets[axis].clone() else { return };
        if last == k {
            self.done[axis] = k + 1;
            return;
        }
        let stroke = self.begin(turn, &offset, path);
        let mut work = std::mem::take(&mut self.work);
        let first = self.find_command(&stroke, &offset, path, clock, &mut work);
        self.ramped(&stroke, first, clock, &mut work);
        stroke.count(&work, stats);
        self.hand_over(&stroke, first, path, &mut work);
        self.work = work;
        path.mark_busy(k, last);
        self.done[axis] = last + 1;
        self.guard[axis] = true;
    }

    /// Where the joint stands as the stroke begins.
    fn begin(&mut self, turn: Turn, offset: &Offset, path: &Path) -> Stroke {
        let Turn { axis, dir, k, last, first_ever } = turn;
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
        self.columns.resize(self.robot.dof(), Vector3::zeros());
        self.here.clear();
        self.here.extend_from_slice(path.q(k));
        self.robot.from_gears(&mut self.here);
        self.robot.chain().position_and_jacobian(&self.here, &mut self.columns);
        Stroke {
            turn,
            axis,
            k,
            d,
            p_turn,
            c_turn,
            gap_old,
            y0,
            before,
            open: path.turns(last).of(axis).is_some(),
            friction: if first_ever { None } else { offset.friction() },
            lever: self.columns[axis],
            step_s: self.step_time(axis, offset),
            ramp: self.ramp_after(axis, k, path),
        }
    }

    /// Nodes and the command at each; returns the node of the step point.
    fn find_command(
        &mut self,
        stroke: &Stroke,
        offset: &Offset,
        path: &mut Path,
        clock: Clock,
        work: &mut Work,
    ) -> usize {
        let Turn { axis, dir, k, last, .. } = stroke.turn;
        let (d, friction) = (stroke.d, stroke.friction);
        let fades = fades_in_time(friction.as_ref());
        // legs after the turn: duration by the nominal path; the step adds its own time
        let legs = self.legs(k, last, path, clock, if fades { f64::INFINITY } else { stroke.step_s });
        let start = d * (stroke.c_turn - stroke.y0);
        let mut jump = offset.gap(dir, stroke.p_turn) + stroke.gap_old + friction.map_or(0.0, |f| f.gain.max(0.0));
        let passes = if matches!(clock, Clock::Speed(_)) && fades { 3 } else { 1 };
        let responds = matches!(friction, Some(FrictionOffset { shape: FrictionShape::Response(_), .. }));
        let mut first = 0;
        work.command.clear();
        for _ in 0..passes {
            first = self.lay_nodes(stroke, path, clock, &legs, stroke.lever * (d * jump), work);
            let u0 = path.u(k);
            // a response that was found for nodes a little apart is a start
            let started = responds && !work.command.is_empty() && work.machine.len() == work.nodes.len();
            work.machine.resize(work.nodes.len(), Node::default());
            for (m, n) in work.machine.iter_mut().zip(&work.nodes) {
                let faded = |f| friction_left(&f, n.since_s, d * (n.p - stroke.p_turn), n.u - u0);
                let left = if started { m.friction } else { friction.map_or(0.0, faded) };
                *m = Node { travel: d * (n.p - stroke.y0), gap: offset.gap(dir, n.p), friction: left };
            }
            if !started {
                work.command.clear();
            }
            match friction.map(|f| (f.gain, f.shape)) {
                Some((_, FrictionShape::Response(r))) => {
                    let end = respond(&r, &stroke.before, start, first, work);
                    self.friction[axis] = if stroke.open { end } else { State::DRAGGED };
                }
                Some((gain, FrictionShape::Decay(Decay::Travel(lambda)))) => {
                    let gap_old = stroke.gap_old;
                    let command = |m: &Node| travel_command(m.travel + gap_old + m.gap, gain, lambda) - gap_old;
                    work.command.clear();
                    work.command.extend(work.machine.iter().map(command));
                }
                _ => {
                    solve(&work.machine, first, stroke.open, &mut work.command, &mut work.fall);
                }
            }
            jump = work.command.get(first).copied().unwrap_or(0.0) - start;
        }
        first
    }

    /// Thins the nodes and hands values to vertices and knots to legs; the command never turns back.
    fn hand_over(&self, stroke: &Stroke, first: usize, path: &mut Path, work: &mut Work) {
        let (axis, d, y0) = (stroke.axis, stroke.d, stroke.y0);
        let x: Vec<f64> = work.nodes.iter().map(|n| n.u).collect();
        let y: Vec<f64> = work.command.iter().map(|c| y0 + d * c).collect();
        let tolerance = self.shape_m / stroke.lever.norm().max(1e-6);
        // between the turn and the step point the step is one straight line
        thin(&x[first..], &y[first..], tolerance, &mut work.keep);
        let mut value = stroke.c_turn;
        let mut knots: Knots = Vec::new();
        let mut leg = stroke.k;
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
    }

    /// Spreads the step over the chosen travel: the command rises in proportion to it.
    fn ramped(&self, stroke: &Stroke, first: usize, clock: Clock, work: &mut Work) {
        let (d, p_turn) = (stroke.d, stroke.p_turn);
        let start = d * (stroke.c_turn - stroke.y0);
        let ramp = stroke.ramp;
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
}

impl Stroke {
    /// Adds the stroke to the statistics.
    fn count(&self, work: &Work, stats: &mut RewriteStats) {
        let axis = self.axis;
        if !matches!(self.friction.map(|f| f.shape), Some(FrictionShape::Decay(Decay::Travel(_)))) {
            let left = largest_error(&work.machine, &work.command);
            stats.largest_left[axis] = stats.largest_left[axis].max(left);
        }
        let change = |(c, p): (&f64, f64)| (self.y0 + self.d * c - p).abs();
        let largest = work.command.iter().zip(work.nodes.iter().map(|n| n.p)).map(change).fold(0.0, f64::max);
        stats.largest_offset[axis] = stats.largest_offset[axis].max(largest);
    }
}
