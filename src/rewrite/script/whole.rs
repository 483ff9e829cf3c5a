//! Goals of moves on which a joint turns shortly before the end, where no point may stand on the way.
//!
//! With points on its way, a joint crosses its gap after the turn, and the goal carries the offset of the new direction. Without them the
//! offset goes over from the start to the goal along the whole move, so that at the turn, at the share `s` of the move, only `s` of it is
//! done. A joint that goes on by `leg` after the turn then stands off its goal by what is left of its gap, `s |step| - leg`. Where that is
//! above 0 the joint stays where it stood at the turn, and the goal has the offset of the direction before it, less the `leg`: with it the
//! joint stands at its goal by then.

use super::out::Out;
use super::run::{Role, Run, Vertex};
use super::unplaced::Unplaced;
use crate::program::script::Edits;
use crate::rewrite::engine::NOTHING;
use crate::robot::Robot;

/// The goal of a move without points on its way, where it is another one than with them: joints, rad or m. `span`: what comes out of the
/// engine before the goal `end` of the move.
pub(super) fn goal(robot: &Robot, run: &Run, vertex: &Vertex, span: &[Out], end: &Out) -> Option<Vec<f64>> {
    let of_move = |o: &&Out| {
        let own = run.vertices.get(o.vertex).is_some_and(|v| v.role == Role::Way && v.step == vertex.step);
        own && o.fraction.is_none()
    };
    let ways: Vec<&Out> = span.iter().filter(of_move).collect();
    let start = ways.first()?.vertex.checked_sub(1)?;
    let gears = |q: &[f64]| {
        let mut gears = q.to_vec();
        robot.to_gears(&mut gears);
        gears
    };
    let mut path = vec![gears(&run.vertices.get(start)?.q)];
    path.extend(ways.iter().map(|o| gears(&run.vertices[o.vertex].q)));
    path.push(gears(&vertex.q));
    let (mut whole, goal) = (gears(end.q), path.last()?.clone());
    let mut changed = false;
    for (axis, own) in whole.iter_mut().enumerate() {
        let places: Vec<f64> = path.iter().map(|q| q[axis]).collect();
        let Some(turn) = last_turn(&places) else { continue };
        let at = ways[turn - 1];
        let before = gears(at.q)[axis] - places[turn];
        let step = (*own - goal[axis] - before).abs();
        let leg = goal[axis] - places[turn];
        if step > NOTHING && leg.abs() < run.vertices[at.vertex].share * step {
            (*own, changed) = (goal[axis] + before + leg, true);
        }
    }
    robot.from_gears(&mut whole);
    changed.then_some(whole)
}

/// Number of the place at which an axis turns last before it comes to the last of its places.
fn last_turn(places: &[f64]) -> Option<usize> {
    let last = places.len().checked_sub(1)?;
    let mut back = (1..last).rev();
    let direction = |k: usize| places[k + 1] - places[k];
    let end = (0..last).rev().map(direction).find(|d| *d != 0.0)?;
    back.find(|k| places[*k] != places[*k - 1] && direction(*k - 1) * end < 0.0)
}

/// Puts the goals of `unplaced` to moves that have no point on their way.
pub(super) fn settle(edits: &mut Edits, unplaced: &mut Unplaced) {
    for (step, goal) in std::mem::take(&mut unplaced.whole) {
        let whole = edits.steps.get(step).is_some_and(|e| e.goal.is_some() && e.before.is_empty() && !e.as_joint_moves);
        if whole {
            edits.steps.change(step, |edit| edit.goal = Some(goal));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::last_turn;

    #[test]
    fn the_last_turn_is_found_over_places_at_which_the_axis_rests() {
        assert_eq!(last_turn(&[0.0, 1.0, 0.5]), Some(1));
        assert_eq!(last_turn(&[0.0, 1.0, 1.0, 0.5]), Some(1));
        assert_eq!(last_turn(&[0.0, 1.0, 0.5, 0.5]), Some(1));
        assert_eq!(last_turn(&[0.0, -1.0, 1.0, 0.5]), Some(2));
        assert_eq!(last_turn(&[0.0, 0.5, 1.0]), None);
        assert_eq!(last_turn(&[0.0, 0.0]), None);
        assert_eq!(last_turn(&[]), None);
    }
}
