//! What a motion runs near its end, as if it stood on a separate line after the motion; and where the program reads where the robot
//! stands.

use super::{Parsed, Reader};
use crate::fanuc::flow::{self, Flow};
use crate::fanuc::instruction;
use crate::fanuc::motion;
use crate::fanuc::readings::reads_place;
use crate::fanuc::statement::{Statement, is_comment};
use crate::fanuc::triggers::Action;
use crate::script::{At, Break, StepKind};

impl Reader<'_> {
    /// An instruction that a motion runs near its end: what it sets and what it calls counts as after the motion. The robot does not wait
    /// for it.
    pub(super) fn triggered(&mut self, at: At, action: &Action) {
        let words = &action.words;
        self.selects(words, false);
        match flow::read(self.text, words) {
            Flow::On | Flow::Step(StepKind::Dwell(_) | StepKind::Process(_)) => {}
            Flow::Call(name) => self.call(at, name, false),
            flow @ (Flow::Macro(_) | Flow::Step(_)) => self.flow(at, flow),
            // a motion runs neither a jump nor a block
            _ => self.push(at, StepKind::Break(Break::Call)),
        }
        if let Some(register) = instruction::register_set(self.text, words).filter(|_| self.offsets) {
            self.push(at, StepKind::Sets(register.into()));
        }
    }

    /// Statements after whose motions the program may read where the robot stands, by their numbers, ascending. What runs before a motion
    /// ends reads a place on its way, what runs after its end one on the way of the next.
    pub(super) fn readings(&self, all: &[(Statement, Parsed)]) -> Vec<usize> {
        let calls = |words: &Parsed| match flow::read(self.text, words) {
            Flow::Call(name) => self.still.reads(&name),
            _ => false,
        };
        let mut found = Vec::new();
        for (k, (statement, words)) in all.iter().enumerate() {
            if statement.pieces.first().is_some_and(|p| is_comment(self.text.slice(p.clone()))) {
                continue;
            }
            let said = motion::read(self.text, statement, words);
            let Some(said) = said else {
                found.extend((reads_place(self.text, words) || calls(words)).then_some(k));
                continue;
            };
            for action in said.actions {
                if reads_place(self.text, &action.words) || calls(&action.words) {
                    found.push(if action.after && k + 1 < all.len() { k + 1 } else { k });
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}
