//! Ends of moves that stay where they are, as the program takes on from there what it goes to later: it reads where the robot stands
//! (`here:=CRobT()`), or a relative motion counts from there. The offset of the move before would be carried along.

use super::{Break, Reason, Script, Step, StepKind};
use std::collections::BTreeSet;

impl Script {
    /// Keeps the ends of moves where they are from which a relative motion counts: an offset there would be carried along. Where a label, a
    /// branch, a loop or the start of a routine (or a call, in a text of several routines) stands before the relative motion, the motion
    /// may follow any move that ends before such a place; `jumps`: jumps of the language are no steps, so that it may follow any. `calls`:
    /// lines of calls of routines in which one may come first. Gives the steps that it kept.
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

    /// Keeps the goals of the moves on these lines of the first text, after which the program may read where the robot stands. Gives the
    /// steps that it kept.
    pub fn keep_read(&mut self, why: &Reason, lines: &BTreeSet<u64>) -> Vec<usize> {
        let read = |s: &Step| s.at.file == 0 && lines.contains(&s.at.line);
        let all: Vec<usize> = (0..self.steps.len()).filter(|k| read(&self.steps[*k])).collect();
        self.fix(all, why)
    }

    /// Lines of the first text on which moves stand.
    pub fn lines_of_moves(&self) -> BTreeSet<u64> {
        self.moves().filter_map(|(k, _)| self.steps.get(k)).filter(|s| s.at.file == 0).map(|s| s.at.line).collect()
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

    #[test]
    fn moves_on_lines_after_which_the_place_is_read_keep_their_goals() {
        let step = |line: u64, kind: StepKind| Step { at: At { file: 0, line }, kind };
        let to = || StepKind::Move(Move::new(How::default(), Goal::Joints(0), Few::new()));
        let all = [(1, StepKind::Break(Break::Start)), (3, to()), (4, to()), (4, to()), (5, to())];
        let steps = all.into_iter().map(|(line, kind)| step(line, kind)).collect();
        let mut script = Script { steps, ..Script::default() };
        assert_eq!(script.lines_of_moves().into_iter().collect::<Vec<_>>(), [3, 4, 5]);
        assert_eq!(script.keep_read(&Reason::EndIsRead, &[1, 4].into_iter().collect()), [2, 3]);
        let fixed = |k: usize| matches!(&script.steps[k].kind, StepKind::Move(m) if m.fixed == Some(Reason::EndIsRead));
        assert_eq!((0..5).filter(|k| fixed(*k)).collect::<Vec<_>>(), [2, 3]);
    }
}
