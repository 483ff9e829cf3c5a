//! Patches: changed positions in place, velocities where an offset rises or falls, and new points as whole items in the
//! style of the point after them. Comments are not copied.

mod items;

use super::read::{Num, Point, Trajectory};
use super::spline::{self, Order, State};
use super::time::Shares;
use super::{RATE_DECIMALS, Trajectories, fine, most_decimals, state};
use crate::error::{Error, Result};
use crate::script::number::{self, Own};
use crate::script::{EditRef, Edits, NewPoint, Patch, Patches, Text};
use std::collections::BTreeMap;
use std::ops::Range;

/// Offsets below this are none, rad or m.
const NOTHING: f64 = 1e-12;
/// Most by which a velocity that turns no command back may bend the splines beside it, in parts of the change of the offset.
const BENT: f64 = 0.02;

/// A point of the edited trajectory: one of the file, or a new one.
struct Knot {
    /// The point, or for a new one the point after it.
    point: usize,
    new: bool,
    t_s: f64,
    time: String,
    /// Its own spline, before the edit, one per joint of the message.
    own: Vec<State>,
    effort: Vec<f64>,
    /// Positions as they shall be.
    asked: Vec<f64>,
    order: Order,
}

pub fn patches(document: &Trajectories, edits: &Edits) -> Result<Patches> {
    // point and step of each edit, in the order of the points
    let mut by_trajectory: BTreeMap<u32, Vec<(u32, u32)>> = BTreeMap::new();
    for (step, edit) in edits.steps.iter() {
        if edit.before.is_empty() && edit.goal.is_none() {
            continue;
        }
        let (t, p) = document
            .of_step
            .get(step)
            .copied()
            .flatten()
            .ok_or_else(|| Error::Refused(format!("step {step} is no move and cannot be edited")))?;
        by_trajectory.entry(t).or_default().push((p, step as u32));
    }
    let mut patches = Patches::with_capacity(edits.steps.likely_patches());
    for (t, mut steps) in by_trajectory {
        let t = t as usize;
        let (Some(trajectory), Some(axes)) = (document.content.trajectories.get(t), document.axes.get(t)) else {
            continue;
        };
        steps.sort_by_key(|s| s.0);
        let writer = Writer { document, text: &document.script.texts[0], trajectory, axes, edits, steps };
        writer.write(&mut patches)?;
    }
    Ok(patches)
}

struct Writer<'a> {
    document: &'a Trajectories,
    text: &'a Text,
    trajectory: &'a Trajectory,
    axes: &'a [Option<usize>],
    edits: &'a Edits,
    /// Edited points with their steps, ascending.
    steps: Vec<(u32, u32)>,
}

impl Writer<'_> {
    fn write(&self, patches: &mut Patches) -> Result<()> {
        let mut copies: BTreeMap<usize, Vec<Vec<u8>>> = BTreeMap::new();
        // a knot needs its neighbours alone: of a long trajectory no more than these are held
        let (mut knots, mut next) = (Vec::new(), 0);
        for (k, p) in self.trajectory.points.iter().enumerate() {
            self.knots(k, p, &mut knots)?;
            let known = knots.len().saturating_sub(1);
            self.knots_written(&knots, next..known, &mut copies, patches)?;
            knots.drain(..known.saturating_sub(1));
            next = knots.len().saturating_sub(1);
        }
        self.knots_written(&knots, next..knots.len(), &mut copies, patches)?;
        for (point, copies) in copies {
            patches.push(self.insertion(point, &copies)?);
        }
        Ok(())
    }

    /// Some of the knots as numbers in place, or as copies of their points.
    fn knots_written(
        &self,
        knots: &[Knot],
        chosen: Range<usize>,
        copies: &mut BTreeMap<usize, Vec<Vec<u8>>>,
        patches: &mut Patches,
    ) -> Result<()> {
        for k in chosen {
            let Some((knot, point)) = knots.get(k).and_then(|n| Some((n, self.trajectory.points.get(n.point)?))) else {
                continue;
            };
            let velocities: Vec<f64> = (0..self.axes.len()).map(|c| self.velocity(knots, k, c)).collect();
            if knot.new {
                copies.entry(knot.point).or_default().push(self.copy(point, knot, &velocities)?);
            } else {
                self.in_place(point, knot, &velocities, patches)?;
            }
        }
        Ok(())
    }

    /// The edit of a point.
    fn edit(&self, point: usize) -> Option<EditRef<'_>> {
        let k = self.steps.binary_search_by_key(&point, |s| s.0 as usize).ok()?;
        self.edits.steps.get(self.steps.get(k)?.1 as usize)
    }

    fn refused(&self, point: &Point, why: &str) -> Error {
        Error::Refused(format!("{}:{}: {why}", self.text.name, self.text.line_of(point.span.start())))
    }

    /// Point `k` of the trajectory, and the new ones before it, by time.
    fn knots(&self, k: usize, p: &Point, knots: &mut Vec<Knot>) -> Result<()> {
        let before = k.checked_sub(1).and_then(|b| self.trajectory.points.get(b));
        let edit = self.edit(k);
        let new = edit.map_or(&[][..], |e| e.before);
        if !new.is_empty() {
            if let Some(why) = super::closed(before, p) {
                return Err(self.refused(p, &format!("no point can be put before this one: {why}")));
            }
            if let Some(b) = before {
                self.between(b, k, p, new, knots)?;
            }
        }
        let own: Vec<State> = (0..self.axes.len()).map(|c| state(self.trajectory, p, c)).collect();
        let goal = edit.and_then(|e| e.goal);
        if goal.is_some() && p.positions.is_empty() {
            return Err(self.refused(p, "the point gives no positions that could be changed"));
        }
        let asked = self.asked(p, &own, goal)?;
        let order = before.map_or(Order::Linear, |b| p.order_from(b));
        let effort = Vec::new();
        knots.push(Knot { point: k, new: false, t_s: p.t_s, time: String::new(), own, effort, asked, order });
        Ok(())
    }

    /// Positions by column: those of the robot's joints as requested, the others of their own spline.
    fn asked(&self, p: &Point, own: &[State], q: Option<&[f64]>) -> Result<Vec<f64>> {
        let Some(q) = q else { return Ok(own.iter().map(|s| s.p).collect()) };
        let of = |(axis, s): (&Option<usize>, &State)| match axis {
            Some(a) => q.get(*a).copied().filter(|v| v.is_finite()),
            None => Some(s.p),
        };
        let all: Option<Vec<f64>> = self.axes.iter().zip(own).map(of).collect();
        all.ok_or_else(|| self.refused(p, "a joint value that is no number was asked for"))
    }

    /// The new points on the way from `before` to `p`.
    fn between(&self, before: &Point, k: usize, p: &Point, new: &[NewPoint], knots: &mut Vec<Knot>) -> Result<()> {
        let h_s = p.t_s - before.t_s;
        let order = p.order_from(before);
        let ends: Vec<(State, State)> =
            (0..self.axes.len()).map(|c| (state(self.trajectory, before, c), state(self.trajectory, p, c))).collect();
        let mut last_s = before.t_s;
        let shares = Shares::of(self.trajectory, (before, p), self.axes);
        for n in new {
            let (time, t_s) = shares.time(p, n.share);
            if !(t_s > last_s && t_s < p.t_s) {
                return Err(
                    self.refused(p, "there is no time for a new point between this point and the one before it")
                );
            }
            last_s = t_s;
            let x = (t_s - before.t_s) / h_s;
            let own: Vec<State> = ends.iter().map(|e| spline::at(order, e.0, e.1, h_s, x)).collect();
            let asked = self.asked(p, &own, Some(&n.q))?;
            let effort = self.trajectory.numbers(p.effort).iter().enumerate().map(|(c, e)| {
                let from = self.trajectory.numbers(before.effort).get(c).map_or(e.value, |b| b.value);
                from + x * (e.value - from)
            });
            let effort = effort.collect();
            knots.push(Knot { point: k, new: true, t_s, time, own, effort, asked, order });
        }
        Ok(())
    }

    /// Velocity of a joint at a knot: its own, and at a new point the slope of the offset where that rises or falls. The points of
    /// the file keep theirs, so that the command leaves the plan by its offsets alone.
    fn velocity(&self, knots: &[Knot], k: usize, column: usize) -> f64 {
        let own = knots[k].own[column].v;
        if !knots[k].new {
            return own;
        }
        let (Some(before), Some(following)) = (k.checked_sub(1).and_then(|b| knots.get(b)), knots.get(k + 1)) else {
            return own;
        };
        let here = &knots[k];
        let offset = |n: &Knot| n.asked[column] - n.own[column].p;
        let (o0, o, o1) = (offset(before), offset(here), offset(following));
        let level = (o - o0).abs() <= NOTHING && (o1 - o).abs() <= NOTHING;
        if self.axes[column].is_none() || level {
            return own;
        }
        let (h0, h1) = (here.t_s - before.t_s, following.t_s - here.t_s);
        let order = if following.order == Order::Quintic { Order::Quintic } else { here.order };
        let v = own + spline::slope(order, (o - o0) / h0, h0, (o1 - o) / h1, h1);
        let mean = |of: &dyn Fn(&Knot) -> f64| ((of(here) - of(before)) / h0, (of(following) - of(here)) / h1);
        // an offset that changes in the direction of the movement turns nothing back
        if [o - o0, o1 - o].iter().all(|change| change * own >= 0.0) {
            return v;
        }
        let asked = mean(&|n| n.asked[column]);
        let limited = spline::limited(order, v, asked.0, asked.1);
        // another velocity bends the splines on both sides: a new point is the plan and its offset before all else
        let bends = spline::BEND_OF_VELOCITY * (limited - v).abs() * h0.max(h1);
        if bends <= BENT * (o - o0).abs().max((o1 - o).abs()) { limited } else { v }
    }

    /// Weight that a position's last digit should have at most.
    fn weight(&self, column: usize) -> f64 {
        let axis = self.axes.get(column).copied().flatten();
        axis.and_then(|a| self.edits.digit.get(a)).copied().unwrap_or(0.0)
    }

    fn position(&self, n: &Num, column: usize, value: f64) -> String {
        let decimals = match self.axes.get(column) {
            Some(Some(_)) => number::decimals_for(n.style, self.weight(column), most_decimals(n.style)),
            _ => return fine(value, n.style, most_decimals(n.style)),
        };
        let own = Own { text: self.text.slice(n.span.range()), value: n.value, style: n.style };
        number::write_moved(own, value, n.style, decimals)
    }

    /// A velocity with digits that keep the position over `h_s` seconds.
    fn rate(&self, n: &Num, column: usize, value: f64, h_s: f64) -> String {
        let weight = self.weight(column);
        let digit = if weight > 0.0 { weight / h_s } else { 1e-9 };
        fine(value, n.style, number::decimals_for(n.style, digit, RATE_DECIMALS.max(most_decimals(n.style))))
    }

    fn in_place(&self, p: &Point, knot: &Knot, velocities: &[f64], patches: &mut Patches) -> Result<()> {
        let mut put = |n: &Num, new: String| {
            if self.text.slice(n.span.range()) != new.as_bytes() {
                patches.push(Patch::new(0, n.span.range(), new));
            }
        };
        for (c, n) in self.trajectory.numbers(p.positions).iter().enumerate() {
            let asked = knot.asked.get(c).copied().unwrap_or(n.value);
            if asked != n.value {
                put(n, self.position(n, c, asked));
            }
        }
        for (c, n) in self.trajectory.numbers(p.velocities).iter().enumerate() {
            let v = velocities.get(c).copied().unwrap_or(n.value);
            if !v.is_finite() {
                return Err(self.refused(p, "the velocities that fit are no numbers"));
            }
            if v != n.value {
                put(n, self.rate(n, c, v, 1.0));
            }
        }
        Ok(())
    }

    /// The item of `p` with the numbers of a new point and without comments.
    fn copy(&self, p: &Point, knot: &Knot, velocities: &[f64]) -> Result<Vec<u8>> {
        let before = knot.point.checked_sub(1).and_then(|b| self.trajectory.points.get(b));
        let h_s = p.t_s - before.map_or(0.0, |b| b.t_s);
        let mut swaps: Vec<(Range<usize>, Vec<u8>)> = Vec::new();
        let finite =
            |v: f64| if v.is_finite() { Ok(v) } else { Err(self.refused(p, "the numbers that fit are not finite")) };
        for (c, n) in self.trajectory.numbers(p.positions).iter().enumerate() {
            swaps.push((n.span.range(), self.position(n, c, finite(knot.asked[c])?).into_bytes()));
        }
        for (c, n) in self.trajectory.numbers(p.velocities).iter().enumerate() {
            swaps.push((n.span.range(), self.rate(n, c, finite(velocities[c])?, h_s).into_bytes()));
        }
        for (c, n) in self.trajectory.numbers(p.accelerations).iter().enumerate() {
            // the point is an end of the spline before it, too, which another acceleration would bend all along
            swaps.push((n.span.range(), self.rate(n, c, finite(knot.own[c].a)?, h_s * h_s).into_bytes()));
        }
        for (n, &e) in self.trajectory.numbers(p.effort).iter().zip(&knot.effort) {
            swaps
                .push((n.span.range(), fine(finite(e)?, n.style, number::decimals_for(n.style, 1e-6, 6)).into_bytes()));
        }
        self.swap_time(&p.time, &knot.time, &mut swaps);
        let span = self.item(knot.point)?;
        for c in self.document.tree.comments_in(&span) {
            swaps.push((self.comment(c, span.start), Vec::new()));
        }
        swaps.sort_by_key(|s| (s.0.start, s.0.end));
        let mut bytes = Vec::with_capacity(span.len() + 64);
        let mut at = span.start;
        for (range, with) in swaps {
            if range.start < at || range.end > span.end {
                return Err(self.refused(p, "the point cannot be copied as it is written"));
            }
            bytes.extend_from_slice(self.text.slice(at..range.start));
            bytes.extend_from_slice(&with);
            at = range.end;
        }
        bytes.extend_from_slice(self.text.slice(at..span.end));
        bytes.truncate(bytes.trim_ascii_end().len());
        Ok(bytes)
    }
}
