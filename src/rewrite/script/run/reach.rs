//! How far into a run it matters from where it is reached.
//!
//! Gaps alone remember nothing but the direction of each gear: when all have turned back some times, and went over their gaps in between,
//! what comes out of the engine is the same wherever the robot came from. A program that runs again from its start needs to be compared
//! no further than that.

use super::{Choice, Run, Vertex};
use crate::rewrite::script::approach::Directions;

/// Turns of each gear until nothing is left of the start: one ends what it was on before, another one what a step was spread over.
const FORGOTTEN: usize = 6;
/// ... and until the end of what is gone through is not seen there any more: a step ends where its gear turns again.
const UNSEEN: usize = 10;

/// How far a run is gone through once more.
pub(super) struct Reach {
    /// Steps before this one are compared.
    pub(super) compared: usize,
    /// Steps before this one are gone through.
    pub(super) end: usize,
}

impl Reach {
    /// `None`: as far as the run goes.
    pub(super) fn of(run: &Run, choice: &Choice) -> Option<Self> {
        let joints = run.places.is_empty() && run.elsewhere.is_empty() && run.lines.is_empty();
        let plain = joints && !run.by_program && !run.goes_on() && !run.is_approached();
        let forgets_over = choice.forgets_over.filter(|_| plain && !choice.approach.any())?;
        if run.vertices.iter().any(|v| v.again) {
            return None;
        }
        let moving = moving(run, choice);
        let (mut directions, mut turns) = (Directions::default(), vec![(0, 0); moving.len()]);
        let mut compared = None;
        for Vertex { step, q, .. } in &run.vertices {
            directions.go(choice.robot, q, forgets_over);
            for (axis, (sign, count)) in turns.iter_mut().enumerate() {
                let now = directions.of(axis);
                *count += usize::from(now != *sign);
                *sign = now;
            }
            let least = turns.iter().zip(&moving).filter(|(_, moves)| **moves).map(|(turn, _)| turn.1).min()?;
            if least >= FORGOTTEN && compared.is_none() {
                compared = Some(*step);
            }
            if least >= UNSEEN {
                return Some(Self { compared: compared?, end: step + 1 });
            }
        }
        None
    }
}

/// The gears that turn anywhere in a run: others get no offset at its goals.
fn moving(run: &Run, choice: &Choice) -> Vec<bool> {
    let mut moving = vec![false; choice.robot.dof()];
    let gears = |v: &Vertex| {
        let mut gears = v.q.to_vec();
        choice.robot.to_gears(&mut gears);
        gears
    };
    let Some(first) = run.vertices.first().map(gears) else { return moving };
    for v in &run.vertices {
        if moving.iter().all(|moves| *moves) {
            break;
        }
        for (moves, (own, first)) in moving.iter_mut().zip(gears(v).iter().zip(&first)) {
            *moves |= own != first;
        }
    }
    moving
}
