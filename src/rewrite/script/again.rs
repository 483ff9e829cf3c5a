//! A program that runs again from its start when it has ended: its first moves are reached from its end, too.
//!
//! At the first start the first movement of a joint says from which side it came. In every other cycle it comes from the end of the
//! program. A target stays as it is where the offset of a joint would then be worse than none. Where nothing is known of the joint at the
//! end, or where it has no offset at the first start, nothing that is written contradicts the other cycles.

use super::collected::Collected;
use super::fading::ByClock;
use super::run::{Role, Run};
use super::task::Task;
use super::unplaced::Unplaced;
use crate::error::Result;
use crate::program::script::{Document, Edits};
use crate::robot::Robot;

/// A smaller offset is none, rad or m: no digit of any format shows it.
const NONE: f64 = 1e-7;

/// Leaves the first targets for which the runs from the end of the program ask for contrary offsets.
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
            let first = edits.steps.get(goal.step).and_then(|edit| edit.goal);
            let second = other.steps.get(goal.step).and_then(|edit| edit.goal);
            if first.zip(second).is_some_and(|(first, second)| is_contrary(task.robot, &goal.q, first, second)) {
                edits.steps.remove(goal.step);
                unplaced.differing.push(goal.step);
            }
        }
    }
    Ok(())
}

/// Whether some gear would stand further off at the goal `q` with the offset of `first` than without one, where that of `second` is right.
fn is_contrary(robot: &Robot, q: &[f64], first: &[f64], second: &[f64]) -> bool {
    let [own, first, second] = [q, first, second].map(|q| {
        let mut gears = q.to_vec();
        robot.to_gears(&mut gears);
        gears
    });
    let offsets = own.iter().zip(first.iter().zip(&second)).map(|(q, (a, b))| (a - q, b - q));
    let mut known = offsets.filter(|(a, b)| a.abs() > NONE && b.abs() > NONE);
    known.any(|(a, b)| (a - b).abs() > b.abs() + NONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_offset_is_contrary_where_none_would_be_better() {
        let text = "schema: lostmotion/robot/1\nname: a\njoints:\n  - {name: X, kind: prismatic}\n  - {name: Y, kind: prismatic}\n";
        let robot = Robot::parse("r.yaml", text).unwrap();
        let contrary = |first: [f64; 2], second: [f64; 2]| {
            let [first, second] = [first, second].map(|by| [0.3 + by[0] * 1e-4, 0.2 + by[1] * 1e-4]);
            is_contrary(&robot, &[0.3, 0.2], &first, &second)
        };
        assert!(contrary([1.0, 1.0], [1.0, -1.0]) && contrary([1.0, 0.0], [-0.1, 0.0]));
        // friction that has not built up yet after a reversal at the end
        assert!(contrary([1.0, 1.0], [1.0, 0.4]) && !contrary([1.0, 1.0], [1.0, 0.6]));
        // a joint of which nothing is known, at the first start or at the end
        assert!(!contrary([1.0, 0.0], [1.0, -1.0]) && !contrary([1.0, 1.0], [1.0, 0.0]));
        assert!(!contrary([1.0, 1.0], [1.0, 1.0]));
    }
}
