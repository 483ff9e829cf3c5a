//! A program that runs again from its start when it has ended: its first moves are reached from its end, too.
//!
//! At the first start the first movement of a joint says from which side it came. In every other cycle it comes from the end of the program.
//! Where that asks for another offset of a joint that has one, the target stays as it is; where it asks for other points on the way, the move
//! has none, and the step is spread over the way. An offset of a joint that the first start leaves without one is none of these: nothing is
//! written that a later cycle contradicts.

use super::collected::Collected;
use super::edits::Unplaced;
use super::fading::ByClock;
use super::run::{Role, Run};
use super::task::Task;
use crate::error::Result;
use crate::program::script::{Document, Edit, Edits, NewPoint};
use crate::rewrite::engine::NOTHING;
use crate::robot::Robot;

/// Joints of two cycles that differ by less are the same, rad or m: no digit of any format shows it.
const SAME: f64 = 1e-7;

/// Compares the edits of the first moves with those that the runs from the end of the program ask for.
pub(super) fn settle(
    document: &dyn Document,
    task: &Task,
    by_clock: &ByClock,
    from_end: &[Run],
    (deadband, solve): (&[f64], bool),
    (edits, unplaced): (&mut Edits, &mut Unplaced),
) -> Result<()> {
    for run in from_end {
        let other = Collected::of(document, task, by_clock, std::slice::from_ref(run), deadband, solve)?.edits;
        for goal in run.own().iter().filter(|v| v.role == Role::Goal) {
            let Some(first) = edits.steps.get(goal.step).map(Edit::from) else { continue };
            let second = other.steps.get(goal.step).map(Edit::from).unwrap_or_default();
            let entered = run.entered.contains(&goal.step);
            let points = entered || alike(&first, &second);
            if !agree(task.robot, &goal.q, &first, &second) || first.as_joint_moves && !points {
                edits.steps.remove(goal.step);
                unplaced.differing.push(goal.step);
            } else if !points && !first.before.is_empty() {
                let mut whole = first;
                unplaced.lose(document.script(), goal.step, whole.clear_points());
                edits.steps.remove(goal.step);
                if whole.goal.is_some() {
                    edits.steps.insert(goal.step, whole);
                }
            }
        }
    }
    Ok(())
}

/// Whether each gear that has an offset at the goal `q` has the same one in the other cycle.
fn agree(robot: &Robot, q: &[f64], first: &Edit, second: &Edit) -> bool {
    let gears = |q: &[f64]| {
        let mut gears = q.to_vec();
        robot.to_gears(&mut gears);
        gears
    };
    let of = |edit: &Edit| gears(edit.goal.as_deref().unwrap_or(q));
    let (own, first, second) = (gears(q), of(first), of(second));
    own.iter().zip(first.iter().zip(&second)).all(|(q, (a, b))| (a - q).abs() <= NOTHING || (a - b).abs() <= SAME)
}

/// Whether the same points are on the way.
fn alike(first: &Edit, second: &Edit) -> bool {
    let near = |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(x, y)| (x - y).abs() <= SAME);
    let points = |a: &NewPoint, b: &NewPoint| near(&a.q, &b.q);
    let same = first.before.iter().zip(&second.before).all(|(a, b)| points(a, b))
        && first.vias.iter().zip(&second.vias).all(|(a, b)| near(a, b));
    same && (first.before.len(), first.vias.len()) == (second.before.len(), second.vias.len())
}
