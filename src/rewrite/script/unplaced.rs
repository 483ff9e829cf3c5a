//! What of the engine's work found no place in a program.

use crate::program::script::{Reason, Script, StepKind};
use std::collections::BTreeMap;

/// What of the engine's work found no place in the program.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Unplaced {
    /// New points on moves that take none, or that are left as they are: the step is spread over the whole move.
    pub points: u64,
    /// Lines of these moves.
    pub lines: Vec<u64>,
    /// Why no point is added to a move, where the format says so, and the lines.
    pub why: Vec<(Reason, Vec<u64>)>,
    /// New points that are no others than their neighbours once they are rounded.
    pub rounded: u64,
    /// New points that gain less at the TCP than is asked for.
    pub little: u64,
    /// Steps of loops that would be written otherwise on each pass.
    pub differing: Vec<usize>,
    /// Goals of steps, should no point come to stand on the way to them; joints, rad or m.
    pub whole: BTreeMap<usize, Vec<f64>>,
}

impl Unplaced {
    /// New points of a step that find no place.
    pub fn lose(&mut self, script: &Script, step: usize, points: u64) {
        self.points += points;
        let Some(lost) = script.steps.get(step).filter(|_| points > 0) else { return };
        self.lines.push(lost.at.line);
        if let StepKind::Move(m) = &lost.kind
            && let Some(why) = &m.closed
        {
            self.because(why, &[lost.at.line]);
        }
    }

    /// Moves on these lines take no point for this reason.
    pub fn because(&mut self, why: &Reason, lines: &[u64]) {
        match self.why.iter_mut().find(|(known, _)| known == why) {
            Some((_, known)) => known.extend(lines),
            None => self.why.push((why.clone(), lines.to_vec())),
        }
    }
}
