//! Ends of moves that stay where they are, as the program takes on from there what it goes to later: it reads where the robot stands
//! (`here:=CRobT()`), and the offset of the move before would be carried along.

use super::{Break, Script, StepKind};
use std::collections::BTreeSet;

impl Script {
    /// Keeps the goal of the move before each of the lines (of the first text) at which the program reads where the robot stands, and those
    /// of moves on that line, in whatever order they stand there. Where a label, a branch or the start of a routine comes between, the
    /// move before is not known, and none is kept; a call may move nothing, so the move before it is. Gives the steps that it kept.
    pub fn keep_before_reading(&mut self, why: &str, lines: &BTreeSet<u64>) -> Vec<usize> {
        let mut kept = Vec::new();
        for line in lines {
            let before = self.steps.partition_point(|s| s.at.file == 0 && s.at.line < *line);
            let after = self.steps.partition_point(|s| s.at.file == 0 && s.at.line <= *line);
            let ends = |k: &usize| match &self.steps[*k].kind {
                StepKind::Move(_) => true,
                StepKind::Break(kind) => !matches!(kind, Break::Frame | Break::Call),
                _ => false,
            };
            for k in (0..before).rev().find(ends).into_iter().chain(before..after) {
                if let Some(StepKind::Move(m)) = self.steps.get_mut(k).map(|s| &mut s.kind)
                    && m.fixed.is_none()
                {
                    m.fixed = Some(why.into());
                    kept.push(k);
                }
            }
        }
        kept
    }
}

#[cfg(test)]
mod tests {
    use crate::script::{At, Break, Few, Goal, How, Move, Script, Step, StepKind};

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
        let kept = script.keep_before_reading("read", &[2, 6, 9, 12, 13].into_iter().collect());
        assert_eq!(kept, [2, 4, 8, 9]);
        let fixed = |k: usize| matches!(&script.steps[k].kind, StepKind::Move(m) if m.fixed.as_deref() == Some("read"));
        assert_eq!((0..10).filter(|k| fixed(*k)).collect::<Vec<_>>(), [2, 4, 8, 9]);
    }
}
