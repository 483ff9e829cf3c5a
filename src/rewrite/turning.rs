//! Where joints turn: directions with a dead band, and the true turning point between samples.
//!
//! A direction is the sign of the last movement; a pause keeps it (Zhang (2023), note 2 of equation 16). A turn stands at the
//! last point of its extreme, as in [`crate::effects::Track`]. On a smooth path the true extreme lies between points: it is
//! found on the parabola through the three points around it and inserted, all joints taken from parabolas blended over the
//! leg (a local cubic). A path is smooth there when the second differences at the extreme and at both neighbours agree in
//! sign and within a factor; at a corner, at a pause and at the ends the point itself is the turning point.

use super::path::{Path, Turns, between};
use super::vertices::Vertices;
use super::{Origin, offset::Offset};
use crate::numerics::reversal::{Movement, ReversalDetector};
use crate::robot::Robot;
use std::collections::VecDeque;

/// A turn that is not settled after so many points (a pause with number noise) is taken to begin at the latest one.
const PATIENCE: usize = 4096;
/// Second differences of a smooth path agree within this factor.
const SMOOTH: f64 = 4.0;
/// An extreme closer to a point than this share of a leg is that point.
const AT_POINT: f64 = 0.02;
/// Steps of the path parameter around a turn differ at most by this factor: beyond it a cubic swings far out of its points.
pub(super) const UNEVEN: f64 = 3.0;
/// A refined path leaves the straight one by at most this share of the largest movement of the joint over the legs around: the
/// parabola through the points of an even path by an eighth.
pub(super) const OVERSHOOT: f64 = 0.25;

/// Direction of one axis as the points come in.
#[derive(Debug, Clone)]
struct Tracker {
    active: bool,
    direction: ReversalDetector,
    /// Settled turns that were not yet handed on: point, new direction.
    turns: VecDeque<(usize, i8)>,
}

/// Takes points in order and hands them on to a [`Path`] with turning points marked and inserted.
pub struct Turning<'a> {
    robot: &'a Robot,
    points: Vertices,
    trackers: Vec<Tracker>,
    cubic: bool,
    timed: bool,
    /// First point that was not handed on.
    next: usize,
}

impl<'a> Turning<'a> {
    /// `offsets[axis]` is `None` for an axis that is not compensated; its turns do not matter.
    pub fn new(robot: &'a Robot, offsets: &[Option<Offset>], deadband: &[f64], initial: &[i8], cubic: bool) -> Self {
        let trackers = offsets
            .iter()
            .zip(deadband)
            .zip(initial)
            .map(|((o, &deadband), &dir)| Tracker {
                active: o.is_some(),
                direction: ReversalDetector::new(deadband, dir),
                turns: VecDeque::new(),
            })
            .collect();
        Self { robot, points: Vertices::new(robot.dof()), trackers, cubic, timed: false, next: 0 }
    }

    /// Takes one point.
    pub fn push(&mut self, q: &[f64], t_s: f64, timed: bool, origin: Origin) {
        let i = self.points.end();
        self.timed = timed;
        self.points.push(q, t_s, origin);
        for (tracker, &p) in self.trackers.iter_mut().zip(q) {
            tracker.take(i, p);
        }
    }

    /// Says where the given path stands at the point that was taken last.
    pub fn set_given(&mut self, q: Vec<f64>) {
        self.points.set_given(q);
    }

    /// Takes a block of the program's own points, the first of them with the number `first`.
    pub fn extend(&mut self, q: &[f64], t_s: &[f64], first: u64) {
        self.timed = !t_s.is_empty();
        let start = self.points.end();
        self.points.extend(q, t_s, first);
        pulp::Arch::new().dispatch(Follow { trackers: &mut self.trackers, q, start });
    }

    /// Hands on every point of which all turns are known; at the `end` all of them.
    pub fn hand_on(&mut self, path: &mut Path, end: bool) {
        let last = self.points.end();
        let known = if end {
            last
        } else {
            // a turn at a point is known once every axis has left it, and placed once two more points are there
            let left =
                self.trackers.iter().filter(|t| t.active).map(|t| t.direction.last_on_extreme()).min().unwrap_or(last);
            left.min(last.saturating_sub(2))
        };
        while self.next < known {
            // a turn concerns its point and the one after it; runs without a turn go in one piece
            let turn = self.trackers.iter().flat_map(|t| t.turns.front()).map(|t| t.0).min();
            let quiet = turn.map_or(known, |r| r.min(known));
            if quiet > self.next {
                let (q, t_s, origin) = self.points.run(self.next, quiet);
                let start = path.end();
                path.extend(q, t_s, origin);
                for (i, given) in self.points.given_in(self.next, quiet) {
                    path.set_given(start + i - self.next, given.clone());
                }
                self.next = quiet;
            } else {
                self.hand_on_one(self.next, path);
                self.next += 1;
                for t in &mut self.trackers {
                    while t.turns.front().is_some_and(|&(r, _)| r + 1 < self.next) {
                        t.turns.pop_front();
                    }
                }
            }
        }
        self.points.forget(self.next.saturating_sub(3));
    }

    /// Point `i`, after it the turning points of the leg to `i + 1`. A turn at `i + 1` may stand in that leg; it is known
    /// one point later, so the leg is completed when `i + 1` is handed on.
    fn hand_on_one(&mut self, i: usize, path: &mut Path) {
        let mut turns = Turns::default();
        let mut inserted: Vec<(f64, usize, i8, f64)> = Vec::new();
        for axis in 0..self.trackers.len() {
            for k in 0..self.trackers[axis].turns.len() {
                let (r, dir) = self.trackers[axis].turns[k];
                if r > i {
                    break;
                }
                if r + 1 < i {
                    continue;
                }
                match self.extreme(axis, r) {
                    // in the leg that ends here
                    Some((leg, share, p)) if leg + 1 == i => inserted.push((share, axis, dir, p)),
                    Some(_) => {}
                    None if r == i => turns.add(axis, dir),
                    None => {}
                }
            }
        }
        if !inserted.is_empty() {
            inserted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            for &(share, axis, dir, p) in &inserted {
                let q = self.on_the_way(i, (share, axis, p), &inserted);
                let (a, b) = (self.points.t_s(i - 1), self.points.t_s(i));
                let origin = between(self.points.origin(i - 1), self.points.origin(i), share);
                let mut turn = Turns::default();
                turn.add(axis, dir);
                path.push(&q, a + share * (b - a), origin, turn);
                let ends = self.points.given(i - 1).iter().zip(self.points.given(i));
                path.set_given(path.end() - 1, ends.map(|(a, b)| a + share * (b - a)).collect());
            }
        }
        path.push(self.points.q(i), self.points.t_s(i), self.points.origin(i), turns);
        for (_, given) in self.points.given_in(i, i + 1) {
            path.set_given(path.end() - 1, given.clone());
        }
    }

    /// All joints at an extreme in the leg that ends at point `i`; `all`: every extreme in it. A joint stays between the ends of the leg,
    /// or an end and its own extreme: beyond the point at which its turn is known to be it would turn twice.
    fn on_the_way(&self, i: usize, (share, axis, p): (f64, usize, f64), all: &[(f64, usize, i8, f64)]) -> Vec<f64> {
        let mut q = self.blended(i - 1, share);
        for (k, v) in q.iter_mut().enumerate() {
            let [from, to] = [i - 1, i].map(|end| self.points.q(end)[k]);
            let ends = match all.iter().find(|own| own.1 == k) {
                Some(&(own, .., extreme)) if share < own => [from, extreme],
                Some(&(.., extreme)) => [extreme, to],
                None => [from, to],
            };
            *v = if k == axis { p } else { v.clamp(ends[0].min(ends[1]), ends[0].max(ends[1])) };
        }
        q
    }

    /// True extreme of `axis` near its turn at point `r`: leg, share of it, value. `None`: the point itself.
    fn extreme(&self, axis: usize, r: usize) -> Option<(usize, f64, f64)> {
        if !self.cubic || r < self.points.start() + 2 || r + 2 >= self.points.end() {
            return None;
        }
        let s = self.parameters(r - 2, 5)?;
        let p: Vec<f64> = (r - 2..=r + 2).map(|i| self.points.q(i)[axis]).collect();
        let second = |k: usize| {
            let (h0, h1) = (s[k] - s[k - 1], s[k + 1] - s[k]);
            ((p[k + 1] - p[k]) / h1 - (p[k] - p[k - 1]) / h0) * 2.0 / (h0 + h1)
        };
        let (before, here, after) = (second(1), second(2), second(3));
        let alike = |other: f64| here * other > 0.0 && here.abs() <= SMOOTH * other.abs();
        if !alike(before) || !alike(after) {
            return None;
        }
        // Newton form around the middle point
        let (h0, h1) = (s[2] - s[1], s[3] - s[2]);
        let slope = ((p[2] - p[1]) / h0 * h1 + (p[3] - p[2]) / h1 * h0) / (h0 + h1);
        let x = -slope / here;
        let (leg, share) = if x < 0.0 { (r - 1, 1.0 + x / h0) } else { (r, x / h1) };
        if !(AT_POINT..=1.0 - AT_POINT).contains(&share) {
            return None;
        }
        let value = p[2] + 0.5 * slope * x;
        if (value - p[2]).abs() > OVERSHOOT * (p[2] - p[1]).abs().max((p[3] - p[2]).abs()) {
            return None;
        }
        let fits = |v: f64| self.robot.axis(axis).limits.is_none_or(|[lo, hi]| v >= lo && v <= hi);
        (value.is_finite() && fits(value)).then_some((leg, share, value))
    }

    /// Path parameter of `count` points from `i` on: the time, else the length of the TCP path. `None` at a pause, and where the
    /// steps differ by more than [`UNEVEN`].
    fn parameters(&self, i: usize, count: usize) -> Option<Vec<f64>> {
        let mut s = Vec::with_capacity(count);
        let mut tcp = self.robot.tcp_m(self.points.q(i));
        s.push(0.0);
        for k in 1..count {
            let step = if self.timed {
                self.points.t_s(i + k) - self.points.t_s(i + k - 1)
            } else {
                let next = self.robot.tcp_m(self.points.q(i + k));
                let d = (next - tcp).norm();
                tcp = next;
                d
            };
            // a hundredth of a micrometre, or of a millisecond: the points coincide
            if step.is_nan() || step <= if self.timed { 1e-5 } else { 1e-8 } {
                return None;
            }
            s.push(s[k - 1] + step);
        }
        let steps = || s.windows(2).map(|w| w[1] - w[0]);
        let (least, most) = (steps().fold(f64::INFINITY, f64::min), steps().fold(0.0, f64::max));
        (most <= UNEVEN * least).then_some(s)
    }

    /// All joints at `share` of the leg after point `i`: the parabolas through its neighbours, blended; linear at an end.
    fn blended(&self, i: usize, share: f64) -> Vec<f64> {
        let n = self.points.q(i).len();
        let linear = |k: usize| self.points.q(i)[k] + share * (self.points.q(i + 1)[k] - self.points.q(i)[k]);
        if i == self.points.start() || i + 2 >= self.points.end() {
            return (0..n).map(linear).collect();
        }
        let Some(s) = self.parameters(i - 1, 4) else { return (0..n).map(linear).collect() };
        let x = s[1] + share * (s[2] - s[1]);
        let parabola = |k: usize, j: usize| {
            let p = |m: usize| self.points.q(i - 1 + m)[k];
            let (a, b, c) = (s[j], s[j + 1], s[j + 2]);
            p(j) * (x - b) * (x - c) / ((a - b) * (a - c))
                + p(j + 1) * (x - a) * (x - c) / ((b - a) * (b - c))
                + p(j + 2) * (x - a) * (x - b) / ((c - a) * (c - b))
        };
        let bounded = |k: usize| {
            let p = |m: usize| self.points.q(i - 1 + m)[k];
            let most = OVERSHOOT * (0..3).map(|m| (p(m + 1) - p(m)).abs()).fold(0.0, f64::max);
            let straight = linear(k);
            straight + ((1.0 - share) * parabola(k, 0) + share * parabola(k, 1) - straight).clamp(-most, most)
        };
        (0..n).map(bounded).collect()
    }
}

/// Rows that are looked at together.
const TOGETHER: usize = 8;

/// Points that the trackers follow. Most rows go on in the direction of every joint; such rows are taken several at a time.
struct Follow<'a> {
    trackers: &'a mut [Tracker],
    q: &'a [f64],
    /// Number of the first point.
    start: usize,
}

impl pulp::NullaryFnOnce for Follow<'_> {
    type Output = ();

    // inlined, so that it is compiled for the registers that there are
    #[inline(always)]
    fn call(self) {
        let Self { trackers, q, start } = self;
        let axes = trackers.len();
        if axes == 0 {
            return;
        }
        let mut directions = Vec::new();
        let mut before: Vec<f64> = vec![0.0; axes];
        for (k, rows) in q.chunks(TOGETHER * axes).enumerate() {
            let first = start + k * TOGETHER;
            if rows.len() == TOGETHER * axes && go_on(trackers, rows, &mut before, &mut directions) {
                let last = &rows[rows.len() - axes..];
                for (tracker, &p) in trackers.iter_mut().zip(last).filter(|(t, _)| t.active) {
                    tracker.direction.go_on(first + TOGETHER - 1, p);
                }
                continue;
            }
            for (axis, tracker) in trackers.iter_mut().enumerate() {
                for (i, row) in rows.chunks_exact(axes).enumerate() {
                    tracker.take(first + i, row[axis]);
                }
            }
            directions.clear();
        }
    }
}

/// Whether every active tracker goes on in its direction in all of the `rows`. `before` and `directions` are memory; directions
/// hold for the rows that follow as long as this is true.
#[inline(always)]
fn go_on(trackers: &[Tracker], rows: &[f64], before: &mut [f64], directions: &mut Vec<f64>) -> bool {
    let axes = trackers.len();
    for ((tracker, before), &own) in trackers.iter().zip(before.iter_mut()).zip(rows) {
        // an axis that is not followed does not count
        *before = if tracker.active {
            let Some(extreme) = tracker.direction.extreme() else { return false };
            extreme
        } else {
            own
        };
    }
    if directions.is_empty() {
        let of = |t: &Tracker| if t.active { f64::from(t.direction.direction()) } else { 0.0 };
        for _ in rows.chunks_exact(axes) {
            directions.extend(trackers.iter().map(of));
        }
    }
    let back = |now: &[f64], before: &[f64], directions: &[f64]| {
        let steps = now.iter().zip(before).zip(directions);
        // no short cut: rows that do not go on are few
        steps.fold(false, |back, ((now, before), d)| back | ((now - before) * d < 0.0))
    };
    let first = back(&rows[..axes], before, directions);
    !first && !back(&rows[axes..], &rows[..rows.len() - axes], &directions[axes..])
}

impl Tracker {
    #[inline]
    fn take(&mut self, i: usize, p: f64) {
        if !self.active {
            return;
        }
        match self.direction.take(i, p) {
            Movement::Start { since: at } | Movement::Reversed { at, .. } => {
                self.turns.push_back((at, self.direction.direction()));
            }
            Movement::Rest | Movement::Within if i - self.direction.last_on_extreme() > PATIENCE => {
                self.direction.settle(i - 1);
            }
            Movement::Rest | Movement::Within | Movement::Same => {}
        }
    }
}

#[cfg(test)]
mod tests;
