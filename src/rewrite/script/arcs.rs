//! An arc through three points as several: the points on the way of its pieces.
//!
//! Where joints turn inside an arc, it is parted there, and after the short piece in which their step is spread. Each piece goes
//! through the place in its middle on the arc as it was (of a short piece of RAPID nearer to its start: [`LeastArc`]), moved by the offset
//! between those at its ends. No piece is shorter than a
//! controller needs to tell its circle: the point that parts it goes on along the arc, where a step then takes that much longer;
//! where there is no space the goal alone carries the step.
//!
//! [`settle`] comes last, once it is known which offsets can be written: the point on the way of every arc moves by what the ends move.
//! Where it cannot, and on arcs that are no larger than a gap, an arc through its three points may go elsewhere: it stays as it is.

use super::cause::Cause;
use super::circles::{DIGITS_M, LEAVES};
use super::run::{Run, Vertex};
use super::unplaced::Unplaced;
use super::way::Line;
use crate::program::script::{Edit, EditRef, Edits, Goal, LeastArc, Move, NewPoint, PathKind, Script, StepKind};
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Least length of a piece, m. ABB (RAPID Instructions, MoveC): points at least 0.1 mm apart, and each piece has three.
const LEAST_M: f64 = 1e-3;
/// Longest stretch, in least pieces, over which turns close to each other share one step.
const TOGETHER: f64 = 3.0;

/// Parts the arc of `edit` at its new points: their places, and those on the way of the pieces. `start`: joints where the arc
/// starts, with their offset; `goal` and `own`: where it ends, with and without; `least`: least angles of a piece. Returns how many
/// points found no place.
pub fn split(line: &Line, start: Option<&[f64]>, [goal, own]: [&[f64]; 2], least: LeastArc, edit: &mut Edit) -> u64 {
    let before = edit.before.len() as u64;
    let parted = line.arc().and_then(|size| {
        let points = places(line, size, least.whole_rad, &edit.before)?;
        let from = line.at(0.0)?;
        let [start, end] = [less(start?, &from), less(goal, own)];
        let vias = vias(line, least, &start, &points, &end)?;
        Some((points, vias))
    });
    match parted {
        Some((points, vias)) if !points.is_empty() => (edit.before, edit.vias) = (points, vias),
        _ => drop(edit.clear_points()),
    }
    before - edit.before.len() as u64
}

/// The points so far apart that every piece is an arc. Of points closer to each other the first and the last stay: what turns
/// between them steps there together.
fn places(line: &Line, [radius_m, angle]: [f64; 2], least_rad: f64, points: &[NewPoint]) -> Option<Vec<NewPoint>> {
    let least = (least_rad / angle).max(LEAST_M / (radius_m * angle));
    let mut out: Vec<NewPoint> = Vec::with_capacity(points.len());
    let mut rest = points;
    while let Some(first) = rest.first() {
        let joined = |k: &usize| {
            let (own, before) = (rest[*k].share, rest[*k - 1].share);
            own - before < least && own - first.share <= TOGETHER * least
        };
        let count = 1 + (1..rest.len()).take_while(joined).count();
        let (group, following) = rest.split_at(count);
        rest = following;
        let after = |out: &[NewPoint]| out.last().map_or(0.0, |p| p.share) + least;
        // a turn at the start of the arc needs no additional point, and a step at its end is that of the goal
        if let Some(last) = group.last().filter(|_| count > 1) {
            let share = first.share.min(1.0 - 2.0 * least);
            if share >= after(&out) - 0.5 * least && after(&out) <= 1.0 - 2.0 * least {
                out.push(moved(line, first, share.max(after(&out)))?);
            }
            if last.share <= 1.0 - 0.5 * least && after(&out) <= 1.0 - least {
                out.push(moved(line, last, last.share.max(after(&out)).min(1.0 - least))?);
            }
        } else if first.share <= 1.0 - least && after(&out) <= 1.0 - least {
            // a step right after the start of the arc takes one piece: the goal would spread it over the whole arc
            out.push(moved(line, first, first.share.max(after(&out)))?);
        }
    }
    // corners reach no further than to the middle of a piece
    let ends: Vec<f64> = std::iter::once(0.0).chain(out.iter().map(|p| p.share)).chain([1.0]).collect();
    let chord_m = |part: f64| 2.0 * radius_m * (0.5 * part * angle).sin();
    for (point, near) in out.iter_mut().zip(ends.windows(3)) {
        point.clearance_m = 0.5 * chord_m((near[1] - near[0]).min(near[2] - near[1]));
    }
    Some(out)
}

/// A point further along the arc, with its offset.
fn moved(line: &Line, point: &NewPoint, share: f64) -> Option<NewPoint> {
    let offset = less(&point.q, &line.at(point.share)?);
    let q = line.at(share)?.iter().zip(offset).map(|(a, b)| a + b).collect();
    Some(NewPoint { q, share, ..point.clone() })
}

/// Joints at the points on the way of the pieces that end at `points` and at the goal, one each; `start` and `end`: offsets of the ends.
fn vias(line: &Line, least: LeastArc, start: &[f64], points: &[NewPoint], end: &[f64]) -> Option<Vec<Vec<f64>>> {
    let mut share = 0.0;
    let angle = line.arc().map_or(f64::INFINITY, |[_, angle]| angle);
    let mut offset = start.to_vec();
    let mut out = Vec::with_capacity(points.len() + 1);
    for (n, to) in points.iter().map(|p| p.share).chain([1.0]).enumerate() {
        let following = match points.get(n) {
            Some(p) => less(&p.q, &line.at(p.share)?),
            None => end.to_vec(),
        };
        // the point of a whole arc stays where it stands on it
        let middle = |piece_rad: f64| (1.0 - least.after_via_rad / piece_rad).clamp(0.0, 0.5);
        let part = if points.is_empty() { line.via_share()? } else { middle((to - share) * angle) };
        out.push(line.at(share + part * (to - share))?);
        let moved = offset.iter().zip(&following).map(|(a, b)| (1.0 - part) * a + part * b);
        out.last_mut()?.iter_mut().zip(moved).for_each(|(q, by)| *q += by);
        (share, offset) = (to, following);
    }
    Some(out)
}

fn less(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// What is left of the edits of arcs once it is known which offsets can be written; see the module. `joints`: the edits before they became
/// poses. New points that go are `unplaced`; `least`: as for [`split`].
pub fn settle(
    script: &Script,
    runs: &[Run],
    joints: &mut Edits,
    edits: &mut Edits,
    left: &mut BTreeMap<usize, Cause>,
    unplaced: &mut Unplaced,
    least: LeastArc,
) {
    for run in runs {
        let goals: Vec<&Vertex> = run.goals().collect();
        // what goes may bend the arc before
        while let Some(k) = (1..goals.len()).find(|&k| {
            let arc = Arc::of(script, run, [goals[k - 1], goals[k]]);
            arc.is_some_and(|arc| !arc.settled(joints, edits, least))
        }) {
            let arc = goals[k].step;
            let mut points = 0;
            edits.steps.change(arc, |e| points = e.clear_points());
            joints.steps.change(arc, |e| {
                e.clear_points();
            });
            unplaced.lose(script, arc, points);
            if points > 0 {
                continue;
            }
            for v in [goals[k - 1], goals[k]] {
                let had = edits.steps.get(v.step).is_some_and(|e| e.goal.is_some());
                // a joint move needs joints: those of its pose
                let plain = |e: &mut Edit| e.goal = e.as_joint_moves.then(|| v.q.to_vec());
                edits.steps.change(v.step, plain);
                joints.steps.change(v.step, plain);
                if had {
                    left.insert(v.step, Cause::BesideArc);
                }
            }
        }
        let empty =
            |e: EditRef| e.goal.is_none() && e.before.is_empty() && e.vias.is_empty() && e.blend_at_most_m.is_none();
        for v in goals {
            if edits.steps.get(v.step).is_some_and(empty) {
                edits.steps.remove(v.step);
            }
        }
    }
}

/// An arc through three points between two goals of a run.
struct Arc<'a> {
    run: &'a Run,
    line: &'a Line,
    m: &'a Move,
    ends: [&'a Vertex; 2],
}

impl<'a> Arc<'a> {
    fn of(script: &'a Script, run: &'a Run, ends: [&'a Vertex; 2]) -> Option<Self> {
        let step = ends[1].step;
        let StepKind::Move(m) = &script.steps.get(step)?.kind else { return None };
        let line = run.line(step).filter(|line| line.via_share().is_some())?;
        (m.path == PathKind::Curve && matches!(m.goal, Goal::Pose(_))).then_some(Self { run, line, m, ends })
    }

    /// Offsets of an end.
    fn offset(&self, joints: &Edits, end: usize) -> Vec<f64> {
        let v = self.ends[end];
        let goal = joints.steps.get(v.step).and_then(|e| e.goal);
        less(goal.unwrap_or(&v.q), &v.q)
    }

    /// Moves the points on its way with its ends. `false`: as it would be written it leaves the program's arc.
    fn settled(&self, joints: &Edits, edits: &mut Edits, least: LeastArc) -> bool {
        let step = self.ends[1].step;
        let [start, end] = [self.offset(joints, 0), self.offset(joints, 1)];
        let points = joints.steps.get(step).map_or(&[][..], |e| e.before);
        if points.is_empty() && start.iter().chain(&end).all(|v| *v == 0.0) {
            edits.steps.change(step, |edit| edit.vias.clear());
            return true;
        }
        let open = self.m.closed.is_none() && self.ends[1].editable;
        let (Some(vias), Some(own)) = (vias(self.line, least, &start, points, &end), self.own_via()) else {
            return false;
        };
        let written: Vec<_> = vias.iter().map(|q| if open { self.line.tcp_m(q) } else { own }).collect();
        if !self.stays(&start, points, &end, &written) {
            return false;
        }
        if let Some(place) = self.run.places.get(&step).filter(|_| open) {
            let vias = vias.iter().map(|q| place.position(q)).collect();
            edits.steps.change_or_insert(step, |edit| edit.vias = vias);
        }
        true
    }

    /// The point on its way as the program says it, m.
    fn own_via(&self) -> Option<Vector3<f64>> {
        let Goal::Pose(goal) = &self.m.goal else { return None };
        self.run.places.get(&self.ends[1].step)?.via(goal)
    }

    /// Whether its pieces, as they are written, stay where the program's arc is.
    fn stays(&self, start: &[f64], points: &[NewPoint], end: &[f64], vias: &[Vector3<f64>]) -> bool {
        let moved = |q: &[f64], by: &[f64]| self.line.tcp_m(&q.iter().zip(by).map(|(q, d)| q + d).collect::<Vec<_>>());
        let [from, to] = [moved(&self.ends[0].q, start), moved(&self.ends[1].q, end)];
        let mut most =
            (from - self.line.tcp_m(&self.ends[0].q)).norm().max((to - self.line.tcp_m(&self.ends[1].q)).norm());
        let mut corners = vec![from];
        for p in points {
            let (Some(own), at) = (self.line.at(p.share), self.line.tcp_m(&p.q)) else { return false };
            most = most.max((at - self.line.tcp_m(&own)).norm());
            corners.push(at);
        }
        corners.push(to);
        let pieces = corners.windows(2).zip(vias);
        let leaves = |(ends, via): (&[Vector3<f64>], &Vector3<f64>)| match ends {
            [a, b] => self.line.leaves([a, via, b]).is_none_or(|off| off > LEAVES * most + DIGITS_M),
            _ => true,
        };
        !pieces.into_iter().any(leaves)
    }
}
