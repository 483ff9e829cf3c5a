//! Ends of moves that stay where they are, as the program takes on from there what it goes to later: it reads where the robot stands
//! (`here:=CRobT()`), or a relative motion counts from there. The offset of the move before would be carried along.

use super::{Break, Reason, Script, Step, StepKind};
use std::collections::BTreeSet;

impl Script {
    /// Keeps the ends of moves where they are from which a relative motion counts: an offset there would be carried along. Where a label, a
    /// branch, a loop or the start of a routine (or a call, in a text of several routines) stands before the relative motion, the motion may follow
    /// any move that ends before such a place; `jumps`: jumps of the language are no steps, so that it may follow any. `calls`: lines of calls of routines in
    /// which one may come first. Gives the steps that it kept.
    pub fn keep_before_relative(&mut self, why: &Reason, calls: &BTreeSet<u64>, jumps: bool) -> Vec<usize> {
        let ends = |s: &Step| matches!(s.kind, StepKind::Break(kind) if !kind.is_frame());
        let counts = |s: &Step| match &s.kind {
            StepKind::Move(m) => m.relative,
            StepKind::Break(Break::Call) => calls.contains(&s.at.line),
            _ => false,
        };
        let starts = self.steps.iter().filter(|s| matches!(s.kind, StepKind::Break(Break::Start))).count();
        let (mut kept, mut anywhere) = (BTreeSet::new(), false);
        // the move before, and whether others may have come before
        let (mut last, mut others) = (None, false);
        for (k, step) in self.steps.iter().enumerate() {
            if counts(step) {
                kept.extend(last);
                anywhere |= others;
            }
            match &step.kind {
                StepKind::Move(_) => (last, others) = (Some(k), false),
                // by a word of the move itself, which may end before its goal
                _ if last.and_then(|k| self.steps.get(k)).is_some_and(|m: &Step| m.at == step.at) => {}
                // what is called stands elsewhere
                StepKind::Break(Break::Call) => others |= starts > 1,
                _ if ends(step) => (last, others) = (None, true),
                _ => {}
            }
        }
        if anywhere {
            let (mut before, all) = (None, jumps);
            for (k, step) in self.steps.iter().enumerate() {
                if let StepKind::Move(_) = step.kind {
                    before = Some(k);
                    kept.extend(before.filter(|_| all));
                } else if ends(step) {
                    kept.extend(before.take());
                }
            }
            kept.extend(before);
        }
        self.fix(kept, why)
    }

    /// Keeps the goal of the move before each of the lines (of the first text) at which the program reads where the robot stands, and those
    /// of moves on that line, in whatever order they stand there. Where a label, a branch or the start of a routine comes between, the
    /// move before is not known, and none is kept; a call may move nothing, so the move before it is. Gives the steps that it kept.
    pub fn keep_before_reading(&mut self, why: &Reason, lines: &BTreeSet<u64>) -> Vec<usize> {
        let mut kept = Vec::new();
        for line in lines {
            let before = self.steps.partition_point(|s| s.at.file == 0 && s.at.line < *line);
            let after = self.steps.partition_point(|s| s.at.file == 0 && s.at.line <= *line);
            let ends = |k: &usize| match &self.steps[*k].kind {
                StepKind::Move(_) => true,
                StepKind::Break(kind) => !kind.is_frame() && *kind != Break::Call,
                _ => false,
            };
            kept.extend((0..before).rev().find(ends).into_iter().chain(before..after));
        }
        self.fix(kept, why)
    }

    /// Fixes the goals of moves that are not fixed yet; gives their steps.
    fn fix(&mut self, steps: impl IntoIterator<Item = usize>, why: &Reason) -> Vec<usize> {
        let mut fixes = |k: &usize| match self.steps.get_mut(*k).map(|s| &mut s.kind) {
            Some(StepKind::Move(m)) if m.fixed.is_none() => m.fixed.replace(why.clone()).is_none(),
            _ => false,
        };
        steps.into_iter().filter(|k| fixes(k)).collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::script::{At, Break, Few, Goal, How, Move, Reason, Script, Step, StepKind};

    fn step(line: u64, kind: StepKind) -> Step {
        Step { at: At { file: 0, line }, kind }
    }

    #[test]
    fn the_move_before_a_reading_of_the_place_keeps_its_goal() {
        let to = || StepKind::Move(Move::new(How::default(), Goal::Joints(0), Few::new()));
        let all = [
            (1, StepKind::Break(Break::Start)),
            (3, to()),
            (4, to()),
            (5, StepKind::Dwell(None)),
            (7, to()),
            (8, StepKind::Break(Break::Call)),
            (10, to()),
            (11, StepKind::Break(Break::Jump)),
            (13, to()),
            (13, to()),
        ];
        let steps = all.into_iter().map(|(line, kind)| step(line, kind)).collect();
        let mut script = Script { steps, ..Script::default() };
        // before any move; after the move of line 4 and a dwell; after a call, which may move nothing; after a label; beside moves
        let kept = script.keep_before_reading(&Reason::EndIsRead, &[2, 6, 9, 12, 13].into_iter().collect());
        assert_eq!(kept, [2, 4, 8, 9]);
        let fixed = |k: usize| matches!(&script.steps[k].kind, StepKind::Move(m) if m.fixed == Some(Reason::EndIsRead));
        assert_eq!((0..10).filter(|k| fixed(*k)).collect::<Vec<_>>(), [2, 4, 8, 9]);
    }
}
