//! Arcs whose points are joint targets (INFORM's `MOVC`): their ways, and what is left of the edits of their points.
//!
//! Three points that follow each other are of one circle, for the TCP of one tool; the robot stands at each of them in the orientation that
//! the target has, and turns the shortest way from one to the next. Between two points of more than three there may be two such circles:
//! then the joints have to come to the second point from the same sides on both. An arc that cannot be followed so keeps its points. No
//! points are added.

use super::cause::Cause;
use super::poses::Tooled;
use super::run::{Run, Vertex};
use super::way::{self, Line};
use crate::program::script::{Edits, Goal, Script, StepKind};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Displacement of a point, as a part of the shortest chord of its arc, from which the arc stays as it is: its shape would change.
const LARGE: f64 = 0.1;
/// An arc as it is written leaves that of the program by this many times what its points move at most, and digits, m.
pub(super) const LEAVES: f64 = 2.0;
pub(super) const DIGITS_M: f64 = 3e-6;

/// The points in the middle of both parts of the arc through three joint vectors, for the TCP; `None`: it cannot be followed.
pub fn middles(tooled: &Arc<Tooled>, points: [&[f64]; 3]) -> Option<[Vector3<f64>; 2]> {
    let at = points.map(|q| tooled.robot.tcp_m(q));
    let middles = way::middles([&at[0], &at[1], &at[2]])?;
    let follows = |k: usize| Line::between(tooled, points[k], points[k + 1], Some(middles[k])).is_some();
    (follows(0) && follows(1)).then_some(middles)
}

/// Of the points of an arc the threes that follow each other and hold both ends of the part that leads to point `k`, by where they begin:
/// first the one that ends with it.
pub fn threes(points: usize, k: usize) -> impl Iterator<Item = usize> {
    [k.checked_sub(2), k.checked_sub(1)].into_iter().flatten().filter(move |s| s + 2 < points)
}

/// Takes back the edits of the points of arcs that would go elsewhere, once it is known which are made.
pub fn settle(script: &Script, runs: &[Run], edits: &mut Edits, left: &mut BTreeMap<usize, Cause>) {
    for run in runs {
        let goals: Vec<&Vertex> = run.goals().collect();
        let mut k = 0;
        while let Some(circle) = goals.get(k).map(|v| circle_of(script, v)) {
            let Some(circle) = circle else {
                k += 1;
                continue;
            };
            let alike = |v: &&&Vertex| circle_of(script, v).is_some_and(|c| c.targets == circle.targets);
            let count = goals[k..].iter().take_while(alike).take(circle.targets.len() - circle.point).count();
            let points = &goals[k..k + count];
            if !(count == circle.targets.len() && points.windows(3).all(|three| stays(run, three, edits))) {
                for v in points {
                    let had = edits.steps.get(v.step).is_some_and(|e| e.goal.is_some());
                    edits.steps.change(v.step, |e| e.goal = None);
                    if had {
                        left.insert(v.step, Cause::BesideArc);
                    }
                }
            }
            k += count.max(1);
        }
    }
}

/// Of which arc a goal is a point, and which of its points.
struct OfCircle<'a> {
    targets: &'a [usize],
    point: usize,
}

fn circle_of<'a>(script: &'a Script, vertex: &Vertex) -> Option<OfCircle<'a>> {
    let StepKind::Move(m) = &script.steps.get(vertex.step)?.kind else { return None };
    let (Goal::Joints(target), Some(targets)) = (&m.goal, m.circle.as_deref()) else { return None };
    let point = targets.iter().position(|t| t == target)?;
    Some(OfCircle { targets, point })
}

/// Whether the arc through three points goes where it went, through its points as they are edited.
fn stays(run: &Run, points: &[&Vertex], edits: &Edits) -> bool {
    let edited = |v: &&Vertex| edits.steps.get(v.step).is_some_and(|e| e.goal.is_some());
    if !points.iter().any(edited) {
        return true;
    }
    let (&[first, second, third], Some(line)) = (points, points.last().and_then(|v| run.line(v.step))) else {
        return false;
    };
    let all = [first, second, third];
    let own = all.map(|v| line.tcp_m(&v.q));
    let written = all.map(|v| match edits.steps.get(v.step).and_then(|e| e.goal) {
        Some(goal) => line.tcp_m(goal),
        None => line.tcp_m(&v.q),
    });
    let most = own.iter().zip(&written).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    let chords = [(own[0] - own[1]).norm(), (own[1] - own[2]).norm(), (own[2] - own[0]).norm()];
    if most > LARGE * chords.into_iter().fold(f64::INFINITY, f64::min) {
        return false;
    }
    let of = |p: &[Vector3<f64>; 3]| way::leaves([&own[0], &own[1], &own[2]], [&p[0], &p[1], &p[2]]);
    of(&written).is_some_and(|off| off <= LEAVES * most + DIGITS_M)
}
