//! What comes out of the engine, as edits of the program: other values for targets, new points on the way to them.

use super::out::Out;
use super::run::{Role, Run, Vertex};
use super::unplaced::Unplaced;
use super::{approach, arcs, gain, whole};
use crate::program::script::{Document, Edit, Edits, Goal, Move, NewPoint, PathKind, Reason, Script, StepKind};
use crate::rewrite::engine::NOTHING;
use crate::rewrite::{Origin, OutputPoints};
use crate::robot::Robot;
use nalgebra::Vector3;

/// See [`spaced`].
const CLOSE: f64 = 2.0;

/// Adds the edits of one run, all in joints ([`super::poses::write`] makes poses of those of Cartesian targets). Returns what found
/// no place and how many points were added. `solve`: straight moves to Cartesian targets become joint moves; `least_gain_m`: the points of
/// a move that gain less stay away.
pub fn collect(
    document: &dyn Document,
    robot: &Robot,
    run: &Run,
    emitted: &OutputPoints,
    (solve, least_gain_m): (bool, f64),
    edits: &mut Edits,
) -> (Unplaced, u64) {
    let script = document.script();
    let out = |i: usize| {
        let (vertex, fraction) = match emitted.origin[i] {
            Origin::Point(n) => (n as usize, None),
            Origin::Inserted { after, fraction } => (after as usize, Some(fraction)),
        };
        Out { q: emitted.row(i), t_s: emitted.t_s.get(i).copied(), vertex, fraction }
    };
    let mut span: Vec<Out> = Vec::new();
    let mut unplaced = Unplaced::default();
    let mut added = 0;
    let before = |i: &usize| matches!(emitted.origin[*i], Origin::Point(n) if (n as usize) < run.before());
    let mut at = (0..emitted.len()).rev().find(before).map_or(0, |i| i + 1);
    while at < emitted.len() {
        // all that lies after the goal before, up to the goal of this step
        let Some(end) = (at..emitted.len()).find(|&i| goal(run, &out(i)).is_some()) else { break };
        let Some(vertex) = goal(run, &out(end)) else { break };
        if at == end && !solve && !vertex.again {
            // nothing but a goal: nearly every move
            at = end + 1;
            let goal = emitted.row(end);
            if vertex.editable && is_move(script, vertex.step) && differs(goal, &vertex.q) {
                edits.steps.insert_goal(vertex.step, goal);
            }
            continue;
        }
        span.clear();
        span.extend((at..end).map(out));
        let before = at.checked_sub(1).map(|k| emitted.row(k));
        let mut again = Unplaced::default();
        let lost = if vertex.again { &mut again } else { &mut unplaced };
        let mut edit = step(document, robot, run, vertex, before, &span, &out(end), solve, lost);
        let gains = |edit: &Edit| {
            edit.as_joint_moves
                || gain::is_enough(robot, run, vertex, (at.checked_sub(1).map(out), &span, &out(end)), least_gain_m)
        };
        if let Some((edit, points)) = edit.as_mut().filter(|(edit, points)| *points > 0 && !gains(edit)) {
            lost.little += edit.clear_points();
            *points = 0;
        }
        let edit = edit.filter(|(edit, points)| edit.goal.is_some() || *points > 0);
        at = end + 1;
        if vertex.again {
            second_pass(script, vertex.step, edit.map(|e| e.0), edits, &mut unplaced);
            continue;
        }
        if let Some((edit, points)) = edit {
            added += points;
            edits.steps.insert(vertex.step, edit);
        }
    }
    added -= blends(script, robot, run, edits, &mut unplaced).min(added);
    (unplaced, added)
}

/// A joint stands elsewhere.
fn differs(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).any(|(a, b)| (a - b).abs() > NOTHING)
}

fn is_move(script: &Script, step: usize) -> bool {
    script.steps.get(step).is_some_and(|s| matches!(s.kind, StepKind::Move(_)))
}

/// What the second pass of a loop asks of a move: where it is another goal, the move stays; where other points are to be on its way, it
/// has none, and the step is spread over the way.
fn second_pass(script: &Script, step: usize, second: Option<Edit>, edits: &mut Edits, unplaced: &mut Unplaced) {
    let near = |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(x, y)| (x - y).abs() <= SAME_PASS);
    let first = edits.steps.get(step).map(Edit::from).unwrap_or_default();
    let second = second.unwrap_or_default();
    let goals = match (&first.goal, &second.goal) {
        (Some(x), Some(y)) => near(x, y),
        (x, y) => x.is_none() && y.is_none(),
    };
    if !goals || first.as_joint_moves {
        if goals && first == second {
            return;
        }
        edits.steps.remove(step);
        unplaced.differing.push(step);
        return;
    }
    let points = first.before.iter().zip(&second.before).all(|(x, y)| near(&x.q, &y.q));
    let vias = first.vias.iter().zip(&second.vias).all(|(x, y)| near(x, y));
    let counts = (first.before.len(), first.vias.len()) == (second.before.len(), second.vias.len());
    if counts && points && vias {
        return;
    }
    unplaced.lose(script, step, first.before.len().max(second.before.len()) as u64);
    let mut whole = first;
    whole.clear_points();
    edits.steps.remove(step);
    if whole.goal.is_some() {
        edits.steps.insert(step, whole);
    }
}

/// Joints of two passes that differ by less are the same, rad or m: no digit of any format shows it.
const SAME_PASS: f64 = 1e-7;

/// The goal vertex at which a point stands.
fn goal<'a>(run: &'a Run, out: &Out) -> Option<&'a Vertex> {
    run.vertices.get(out.vertex).filter(|v| out.fraction.is_none() && v.role == Role::Goal)
}

#[allow(clippy::too_many_arguments)] // a step, what led to it, what came out, and where what is lost is counted
fn step(
    document: &dyn Document,
    robot: &Robot,
    run: &Run,
    vertex: &Vertex,
    before: Option<&[f64]>,
    span: &[Out],
    end: &Out,
    solve: bool,
    unplaced: &mut Unplaced,
) -> Option<(Edit, u64)> {
    let script = document.script();
    let StepKind::Move(m) = &script.steps.get(vertex.step)?.kind else { return None };
    let inserted = |o: &&Out| o.fraction.is_some();
    let of_pose = m.path == PathKind::Curve && matches!(m.goal, Goal::Pose(_));
    let arc = run.line(vertex.step).filter(|_| of_pose).filter(|line| line.arc().is_some());
    let closed = m.closed.is_some() || of_pose && arc.is_none() || run.unfollowed.contains(&vertex.step);
    let changing = run.changing.contains(&vertex.step);
    let closed = closed || changing || run.entered.contains(&vertex.step);
    if !vertex.editable || closed {
        let points = span.iter().filter(inserted).count() as u64;
        unplaced.lose(script, vertex.step, points);
        if changing && points > 0 && m.closed.is_none() {
            unplaced.because(&Reason::ComputedPlace, &[script.steps[vertex.step].at.line]);
        }
    }
    if !vertex.editable {
        return None;
    }
    let once = !run.entered.contains(&vertex.step);
    let fixed = matches!(&m.goal, Goal::Pose(goal) if !goal.is_computed()) && !changing;
    let as_joint_moves = once && solve && fixed && m.path == PathKind::Linear && m.is_open_to_goal();
    let mut edit = Edit { as_joint_moves, ..Edit::default() };
    // points of a way are written where the offset changes between them; else the goal alone carries it
    let offset = |q: &[f64], own: &[f64]| q.iter().zip(own).map(|(a, b)| a - b).collect::<Vec<f64>>();
    let here = if span.is_empty() { Vec::new() } else { offset(end.q, &vertex.q) };
    let offset_differs = |o: &Out| {
        let own = run.vertices.get(o.vertex).map(|v| offset(o.q, &v.q)).unwrap_or_default();
        own.iter().zip(&here).any(|(a, b)| (a - b).abs() > NOTHING)
    };
    let approach = |o: &Out| o.is_approach(run);
    let of_goal = matches!(m.goal, Goal::Pose(_));
    // where the robot stands, the point in place carries the step: none is needed on the way to it
    let crossing = |o: &Out, n: usize| run.vertices.get(o.vertex + n).is_some_and(|v| v.role == Role::Crossing);
    let steps = span.iter().any(|o| o.is_on_way(run, vertex.step) && (o.fraction.is_some() || offset_differs(o)));
    let steps_inside = steps || span.iter().any(|o| o.is_on_way(run, vertex.step) && approach(o));
    if !closed && (steps_inside || as_joint_moves) {
        let mut last = before;
        // from the point of approach on the goal carries the step: that way is no longer than the gap needs
        // a turn at which no offset changes needs no point
        let whole = |o: &&Out| {
            if o.fraction.is_none() { steps || as_joint_moves || approach(o) } else { !approach(o) && !crossing(o, 1) }
        };
        let span: Vec<&Out> = span.iter().filter(|o| o.is_on_way(run, vertex.step)).filter(whole).collect();
        let span = spaced(&span);
        edit.before.reserve_exact(span.len());
        for (k, o) in span.iter().enumerate() {
            let next = span.get(k + 1).map_or(end.q, |o| o.q);
            let point = new_point(document, robot, run, vertex.step, o, last, next);
            if !approach(o) && finest(script, vertex).is_some_and(|f| same(&point.q, last, &f)) {
                unplaced.rounded += 1;
                continue;
            }
            last = Some(o.q);
            let stands = |p: &NewPoint| p.share != approach::SHARE && stands_at(&p.q, &point.q);
            if of_goal && !approach(o) && arc.is_none() && edit.before.last().is_some_and(stands) {
                // a joint that turns where the robot stands: one point in place carries all steps
                edit.before.pop();
            }
            edit.before.push(point);
        }
        let late = clear_end(run, robot, m, vertex.step, end.q, &mut edit);
        unplaced.lose(script, vertex.step, late);
        if let Some(trigger) = m.end_trigger.as_ref().filter(|_| late > 0) {
            unplaced.because(&trigger.why, &[script.steps[vertex.step].at.line]);
        }
    }
    if as_joint_moves || differs(end.q, &vertex.q) {
        edit.goal = Some(end.q.to_vec());
        let whole = whole::goal(robot, run, vertex, span, end).filter(|_| once && !as_joint_moves);
        unplaced.whole.extend(whole.map(|goal| (vertex.step, goal)));
    }
    if let Some(line) = arc.filter(|_| !edit.before.is_empty()) {
        let whole = arcs::split(line, before, [end.q, &vertex.q], document.least_arc(), &mut edit);
        unplaced.lose(script, vertex.step, whole);
    }
    let points = edit.before.len() as u64;
    (edit.goal.is_some() || points > 0).then_some((edit, points))
}

/// Takes away the new points that would delay what a motion starts before its end; how many. The step is spread over the rest of the way.
fn clear_end(run: &Run, robot: &Robot, m: &Move, step: usize, goal: &[f64], edit: &mut Edit) -> u64 {
    let Some(trigger) = &m.end_trigger else { return 0 };
    let length_m = run.line(step).map(|line| line.length_m());
    let left_m = |p: &NewPoint| match length_m {
        Some(whole) => (1.0 - p.share) * whole,
        // a gantry goes straight without one
        None => (robot.tcp_m(&p.q) - robot.tcp_m(goal)).norm(),
    };
    // no sooner than at the largest speeds of the joints
    let left_s = |p: &NewPoint| {
        let joints = robot.axis_joints().zip(p.q.iter().zip(goal));
        joints.filter_map(|(j, (from, to))| Some((to - from).abs() / j.max_speed?)).fold(0.0, f64::max)
    };
    let all = edit.before.len();
    edit.before.retain(|p| left_m(p) >= trigger.way_m && (trigger.time_s == 0.0 || left_s(p) >= trigger.time_s));
    (all - edit.before.len()) as u64
}

/// Of the points of one leg that stand within [`CLOSE`] times the distance of the first of them from the leg's start, the last:
/// joints that turn together take their steps at one point, not at a row of points that no controller could tell apart.
fn spaced<'a>(span: &[&'a Out<'a>]) -> Vec<&'a Out<'a>> {
    let mut kept: Vec<&Out> = Vec::with_capacity(span.len());
    let mut first: Option<(usize, f64)> = None;
    for &o in span {
        let near = match (first, o.fraction) {
            (Some((vertex, share)), Some(own)) => o.vertex == vertex && own <= CLOSE * share,
            _ => false,
        };
        if near {
            kept.pop();
        } else {
            first = o.fraction.map(|share| (o.vertex, share));
        }
        kept.push(o);
    }
    kept
}

fn new_point(
    document: &dyn Document,
    robot: &Robot,
    run: &Run,
    step: usize,
    o: &Out,
    last: Option<&[f64]>,
    next: &[f64],
) -> NewPoint {
    let own = &run.vertices[o.vertex];
    let share = o.share(run);
    let mut q = o.q.to_vec();
    // the engine goes straight in the joints; on a straight TCP path or an arc the point moves onto it, its offset stays
    let known = || Some(run.standing(step, document.on_way(step, share)?, &own.q));
    let on_way = || known().or_else(|| run.line(step)?.at(share));
    if let (Some(f), Some(to)) = (o.fraction, run.vertices.get(o.vertex + 1))
        && let Some(on_way) = on_way()
    {
        for (k, v) in q.iter_mut().enumerate() {
            *v += on_way[k] - (own.q[k] + f * (to.q[k] - own.q[k]));
        }
    }
    let here = robot.tcp_m(&q);
    let distance = |other: &[f64]| (robot.tcp_m(other) - here).norm();
    // the side of the approach is lost where its corner is cut
    let waits = o.fraction.is_none()
        && own.role == Role::Approach
        && matches!(document.script().steps.get(step).map(|s| &s.kind), Some(StepKind::Move(m)) if !m.waits.is_empty() && m.blend_m != Some(0.0));
    let clearance_m = if waits { 0.0 } else { 0.5 * last.map_or(f64::INFINITY, distance).min(distance(next)) };
    NewPoint { q, share, t_s: o.t_s, clearance_m, of_way: o.fraction.is_none() && own.role == Role::Way, waits }
}

/// The finest digits of a step's target.
fn finest(script: &Script, vertex: &Vertex) -> Option<Vec<f64>> {
    let StepKind::Move(m) = &script.steps.get(vertex.step)?.kind else { return None };
    let Goal::Joints(t) = m.goal else { return None };
    let target = script.targets.get(t)?;
    Some(target.values.iter().map(|v| v.map_or(f64::INFINITY, |v| v.finest)).collect())
}

/// The robot stands there already: no axis moves by more than the rounding of a pose's last digits, rad or m.
fn stands_at(a: &[f64], b: &[f64]) -> bool {
    const NO_MOVE: f64 = 2e-6;
    a.iter().zip(b).all(|(x, y)| (x - y).abs() <= NO_MOVE)
}

/// No axis differs by half a digit.
fn same(a: &[f64], b: Option<&[f64]>, digit: &[f64]) -> bool {
    b.is_some_and(|b| a.iter().zip(b).zip(digit).all(|((x, y), d)| (x - y).abs() < 0.5 * d.min(1.0)))
}

/// Takes away the new points of a step that stand too near to a corner; how many.
pub(super) fn clear_corner(edits: &mut Edits, step: usize, far: impl Fn(&NewPoint) -> bool) -> u64 {
    let (mut lost, mut idle) = (0, false);
    edits.steps.change(step, |edit| {
        let all = edit.before.len();
        match edit.vias.is_empty() || edit.before.iter().all(&far) {
            true => edit.before.retain(&far),
            // of a split arc no point may miss
            false => drop(edit.clear_points()),
        }
        lost = (all - edit.before.len()) as u64;
        idle = edit.goal.is_none() && edit.before.is_empty() && edit.vias.is_empty() && edit.blend_at_most_m.is_none();
    });
    if idle {
        edits.steps.remove(step);
    }
    lost
}

/// Where the corner at a goal stands in the written program, m: by an offset aside of where the robot comes to.
pub(super) fn corner_m(edits: &Edits, robot: &Robot, own: &Vertex) -> Vector3<f64> {
    robot.tcp_m(edits.steps.get(own.step).and_then(|edit| edit.goal).unwrap_or(&own.q))
}

/// Corners that may be cut no wider than to the middle of the way to a new point; where that would delay what the robot does as it enters
/// one, the point goes. How many went.
fn blends(script: &Script, robot: &Robot, run: &Run, edits: &mut Edits, unplaced: &mut Unplaced) -> u64 {
    let mut taken = 0;
    let goals: Vec<&Vertex> = run.vertices.iter().filter(|v| v.role == Role::Goal).collect();
    for pair in goals.windows(2) {
        let [own, next] = pair else { continue };
        let near = |step: usize, first: bool| {
            let edit = edits.steps.get(step)?;
            if first { edit.before.first() } else { edit.before.last() }.map(|p| robot.tcp_m(&p.q))
        };
        let near = [near(next.step, true), near(own.step, false)];
        if near.iter().all(Option::is_none) {
            continue; // no new point is near
        }
        let here = corner_m(edits, robot, own);
        let StepKind::Move(m) = &script.steps[own.step].kind else { continue };
        if let Some(why) = m.acts_in_corner.as_ref().filter(|_| own.editable) {
            let far = |p: &NewPoint| m.blend_m.is_some_and(|b| 0.5 * (robot.tcp_m(&p.q) - here).norm() >= b);
            for step in [own.step, next.step] {
                let lost = clear_corner(edits, step, far);
                unplaced.lose(script, step, lost);
                taken += lost;
                if lost > 0 {
                    unplaced.because(why, &[script.steps[step].at.line]);
                }
            }
            continue;
        }
        let at_most = near.into_iter().flatten().map(|p| 0.5 * (p - here).norm()).fold(f64::INFINITY, f64::min);
        if at_most.is_finite() && m.blend_m != Some(0.0) && m.blend_m.is_none_or(|b| b > at_most) && own.editable {
            // on another pass of a loop it may be narrower
            let narrower = |edit: &mut Edit| {
                edit.blend_at_most_m = Some(edit.blend_at_most_m.map_or(at_most, |b| b.min(at_most)));
            };
            edits.steps.change_or_insert(own.step, narrower);
        }
    }
    taken
}
