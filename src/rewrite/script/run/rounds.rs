//! Loops that are certainly entered, and whose passes lead to the same joints: the run goes on into them, and through them a second time.
//!
//! The first move of such a loop comes from before the loop and from its end, so that no point may be on its way; every other move has one
//! start. What comes out of the engine on both passes is compared ([`super::super::edits`]): where it is the same, it is right for all of
//! them, as nothing but the end of the pass before leads into a pass. Loops with a branch, a label, a call or a target that is not known
//! inside are none of these, nor those in which a way cannot be followed: they end the run, as every other loop does.

use super::cutter::{Cutter, Pass};
use super::stretch::Role;
use crate::program::script::{Round, Script, StepKind};

/// Joints that differ by less are the same on both passes, rad or m: what the solver leaves.
const SAME: f64 = 1e-7;

impl Cutter<'_> {
    /// The loop is entered; `false`: where the robot stands before it is not known, and it is not the first that moves.
    pub(super) fn enter(&mut self, round: Round) -> bool {
        let begun = !self.run.vertices.is_empty() || self.run.entry;
        let known = begun && self.known.is_empty() && self.pass.is_none();
        if known {
            self.pass = Some(Pass { round, first: None, vertices: self.run.vertices.len() });
        }
        known
    }

    /// The end of a loop: goes through it once more; `false`: its passes are not alike, or the run has ended in it.
    pub(super) fn second_pass(&mut self, script: &Script, round: Round) -> bool {
        let Some(Pass { vertices, .. }) = self.pass.as_ref().filter(|p| p.round == round && p.first.is_some()) else {
            return false;
        };
        let (from, until) = (*vertices, self.run.vertices.len());
        self.again = true;
        for k in round.open + 1..round.close {
            let Some(step) = script.steps.get(k) else { continue };
            match &step.kind {
                StepKind::Move(m) => self.take(script, k, step.at, m),
                StepKind::Dwell(seconds) => self.dwell(*seconds),
                StepKind::Sets(name) => self.set(name),
                _ => {}
            }
        }
        self.again = false;
        // an end of the run on the second pass has counted the loop among those that failed
        let Some(pass) = self.pass.take() else { return false };
        let goals = |range: std::ops::Range<usize>| {
            let all = self.run.vertices.get(range).unwrap_or_default();
            all.iter().filter(|v| v.role == Role::Goal)
        };
        let (first, second) = (goals(from..until), goals(until..self.run.vertices.len()));
        let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(x, y)| (x - y).abs() <= SAME);
        let alike = first.clone().count() == second.clone().count()
            && first.zip(second).all(|(a, b)| a.step == b.step && near(&a.q, &b.q));
        let followed = (round.open..round.close).all(|k| !self.run.unfollowed.contains(&k));
        if !(alike && followed) {
            self.failed.push(pass.round.open);
        }
        alike && followed
    }
}
