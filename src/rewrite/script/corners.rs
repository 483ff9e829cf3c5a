//! Corners that must not overlap, across calls, branches, loops and targets that stay as they are.
//!
//! Where one move follows another within a run, [`super::edits`] makes the corner of the first so small that a new point after it fits.
//! Here it is done for the other pairs: a run that goes on from a place to which another one leads, a run of which nobody knows from where
//! it is reached, the end of a run, and a move whose numbers stay. Where a corner cannot be made smaller, the new points that stand in it
//! go, and the step is spread over the move.

use super::edits::{clear_corner, corner_m};
use super::run::{Choice, Role, Run, Vertex};
use super::unplaced::Unplaced;
use crate::program::script::{Break, Document, Edits, Goal, Move, NewPoint, Script, Step, StepKind};
use crate::robot::Robot;
use std::collections::BTreeMap;

/// Keeps new points and corners apart in a format whose corners must not overlap; edits in joints.
pub(super) fn settle(
    document: &dyn Document,
    robot: &Robot,
    runs: &[Run],
    choice: &Choice,
    (edits, unplaced): (&mut Edits, &mut Unplaced),
) {
    if !document.corners_must_not_overlap() || edits.steps.iter().all(|(_, edit)| edit.before.is_empty()) {
        return;
    }
    let script = document.script();
    let mut corners = Corners { script, robot, choice, edits, unplaced };
    let goals: BTreeMap<usize, &Vertex> = runs.iter().flat_map(Run::goals).map(|v| (v.step, v)).collect();
    for run in runs {
        let own: Vec<&Vertex> = run.own().iter().filter(|v| v.role == Role::Goal).collect();
        let (Some(first), Some(last)) = (own.first(), own.last()) else { continue };
        let from = run.vertices[..run.before()].iter().rev().find(|v| v.share == 1.0);
        // from elsewhere, too, but from the move before it in the text at least
        let from = from.or_else(|| goals.get(&move_before(script, first.step)?).copied());
        if let Some(from) = from {
            corners.keep_apart(from, Some(first.step));
        }
        for pair in own.windows(2).filter(|pair| !pair[0].editable) {
            corners.keep_apart(pair[0], Some(pair[1].step));
        }
        if may_go_on(script, last.step) {
            corners.keep_apart(last, None);
        }
    }
}

/// Whether anything may move after a step, as far as the text tells.
fn may_go_on(script: &Script, step: usize) -> bool {
    let is_move = |s: &Step| matches!(s.kind, StepKind::Move(_));
    let starts = script.steps.iter().filter(|s| matches!(s.kind, StepKind::Break(Break::Start))).count();
    starts > 1
        || script.steps.iter().skip(step + 1).any(is_move)
        || script.steps.iter().any(|s| matches!(s.kind, StepKind::Break(Break::Loop)))
}

/// The move before a step in the text.
fn move_before(script: &Script, step: usize) -> Option<usize> {
    let before = script.steps.get(..step)?;
    before.iter().rposition(|s| matches!(s.kind, StepKind::Move(_)))
}

struct Corners<'a> {
    script: &'a Script,
    robot: &'a Robot,
    choice: &'a Choice<'a>,
    edits: &'a mut Edits,
    unplaced: &'a mut Unplaced,
}

impl Corners<'_> {
    /// Keeps the corner at a goal apart from the new points before it and from those of a move that may follow.
    fn keep_apart(&mut self, corner: &Vertex, next: Option<usize>) {
        let Some(StepKind::Move(m)) = self.script.steps.get(corner.step).map(|s| &s.kind) else { return };
        if m.blend_m == Some(0.0) {
            return;
        }
        let here = corner_m(self.edits, self.robot, corner);
        let away = |p: &NewPoint| 0.5 * (self.robot.tcp_m(&p.q) - here).norm();
        let own = self.edits.steps.get(corner.step).and_then(|e| e.before.last().map(away));
        let after = next.and_then(|step| self.edits.steps.get(step)?.before.first().map(away));
        let at_most = own.into_iter().chain(after).fold(f64::INFINITY, f64::min);
        if m.blend_m.is_some_and(|b| b <= at_most) || at_most == f64::INFINITY {
            return;
        }
        if m.blend_m.is_some() && self.may_be_narrower(corner.step, m) {
            self.edits.steps.change_or_insert(corner.step, |edit| {
                edit.blend_at_most_m = Some(edit.blend_at_most_m.map_or(at_most, |b| b.min(at_most)));
            });
            return;
        }
        // a corner of unknown size is taken to reach all points of the next move, and no point before it
        let clear = |p: &NewPoint| m.blend_m.is_some_and(|b| away(p) >= b);
        for step in next.into_iter().chain(m.blend_m.map(|_| corner.step)) {
            let lost = clear_corner(self.edits, step, clear);
            self.unplaced.lose(self.script, step, lost);
            if let Some(why) = m.acts_in_corner.as_ref().filter(|_| lost > 0) {
                self.unplaced.because(why, &[self.script.steps[step].at.line]);
            }
        }
    }

    /// Its corner is no matter of time for what follows, and the move may be written.
    fn may_be_narrower(&self, step: usize, m: &Move) -> bool {
        let written = match &m.goal {
            Goal::Joints(_) => true,
            Goal::Pose(goal) => goal.target.is_some() && self.choice.as_poses,
            Goal::Opaque(_) => false,
        };
        written && m.acts_in_corner.is_none() && !(self.choice.excluded)(step)
    }
}
