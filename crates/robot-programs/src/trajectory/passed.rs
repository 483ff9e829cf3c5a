//! Points of splines, so close that straight lines between them stay at the spline.

use super::read::Trajectory;
use super::spline::{self, Order};
use super::{Trajectories, on_spline, state};
use crate::script::{StepKind, Way};
use std::collections::BTreeMap;

/// Most by which a straight line leaves the spline, rad or m: some tenths of a micrometre at the TCP.
const WITHIN: f64 = 1e-7;
/// Points of a file between its own; with more they stand further apart.
const MOST: f64 = 100_000.0;
/// Places of a spline at which its acceleration is looked at.
const PLACES: u32 = 16;

impl Trajectories {
    /// The points on the way to the goal of each step that goes on a spline, by shares of its time; turns among them.
    pub(super) fn splines(&self) -> BTreeMap<usize, Vec<Way>> {
        let parts: Vec<(usize, f64)> = (0..self.of_step.len()).filter_map(|k| Some((k, self.parts(k)?))).collect();
        let all: f64 = parts.iter().map(|p| p.1).sum();
        let shorter = (MOST / all.max(1.0)).min(1.0);
        parts.into_iter().filter_map(|(k, parts)| Some((k, self.spline(k, (parts * shorter).ceil() as u32)?))).collect()
    }

    /// Straight lines instead of the spline to a step's goal; `None`: it is a straight line, or not known of every axis.
    fn parts(&self, step: usize) -> Option<f64> {
        let (t, before, p, axes) = self.between(step)?;
        let (order, h_s) = (p.order_from(before), p.t_s - before.t_s);
        let dof = self.dof();
        if order == Order::Linear || !(0..dof).all(|a| axes.contains(&Some(a))) {
            return None;
        }
        let bend = |c: usize| {
            let (from, to) = (state(t, before, c), state(t, p, c));
            let at = |k: u32| spline::at(order, from, to, h_s, f64::from(k) / f64::from(PLACES)).a.abs();
            (0..=PLACES).map(at).fold(0.0, f64::max)
        };
        let most = axes.iter().enumerate().filter(|(_, a)| a.is_some()).map(|(c, _)| bend(c)).fold(0.0, f64::max);
        // a chord leaves a parabola by a h^2 / 8
        let parts = (most * h_s * h_s / (8.0 * WITHIN)).sqrt();
        parts.is_finite().then_some(parts.clamp(1.0, MOST))
    }

    fn spline(&self, step: usize, parts: u32) -> Option<Vec<Way>> {
        let (t, before, p, axes) = self.between(step)?;
        let Some(StepKind::Move(m)) = self.script.steps.get(step).map(|s| &s.kind) else { return None };
        let dof = self.dof();
        let shares = (1..parts).map(|k| f64::from(k) / f64::from(parts));
        let mut way: Vec<Way> =
            shares.map(|share| Way { share, q: on_spline(t, (before, p), axes, dof, share) }).collect();
        way.extend(m.way.iter().cloned());
        way.sort_by(|a, b| a.share.total_cmp(&b.share));
        way.dedup_by(|b, a| a.share == b.share);
        Some(way)
    }

    /// A point beside the straight line between its neighbours, by as much as it stands beside their spline.
    pub(super) fn off_spline(&self, step: usize) -> Option<Vec<f64>> {
        let (t, before, p, axes) = self.between(step)?;
        let (_, k) = self.of_step.get(step).copied().flatten()?;
        let after = t.points.get(k as usize + 1).filter(|after| !after.positions.is_empty())?;
        if p.order_from(before) == Order::Linear || after.order_from(p) == Order::Linear {
            return None;
        }
        let (order, h_s) = (after.order_from(before), after.t_s - before.t_s);
        let x = (p.t_s - before.t_s) / h_s;
        let mut q = vec![f64::NAN; self.dof()];
        for (c, axis) in axes.iter().enumerate() {
            let (from, here, to) = (state(t, before, c), state(t, p, c), state(t, after, c));
            if let Some(slot) = axis.and_then(|a| q.get_mut(a)) {
                *slot = here.p - spline::at(order, from, to, h_s, x).p + from.p + x * (to.p - from.p);
            }
        }
        Some(q)
    }

    /// Trajectory, the points at both ends of the way to a step's goal, and axes by column.
    pub(super) fn between(&self, step: usize) -> Option<Between<'_>> {
        let (t, k) = self.of_step.get(step).copied().flatten()?;
        let (all, k) = (self.content.trajectories.get(t as usize)?, k as usize);
        let (before, p) = (all.points.get(k.checked_sub(1)?)?, all.points.get(k)?);
        let whole = !before.positions.is_empty() && !p.positions.is_empty();
        whole.then_some((all, before, p, self.axes.get(t as usize)?))
    }

    /// Axes of the robot.
    pub(super) fn dof(&self) -> usize {
        self.script.targets.get(0).map_or(0, |t| t.values.len())
    }
}

type Between<'a> = (&'a Trajectory, &'a super::Point, &'a super::Point, &'a [Option<usize>]);
