//! Where control goes between the steps: routines and what calls them, blocks and their branches, labels and jumps.

use super::{Block, Steps};
use crate::script::order::Round;
use crate::script::{At, Break, Join, StepKind};

impl<S> Steps<S> {
    /// A routine starts: no block is open, and its labels are others.
    pub fn start(&mut self) {
        self.open.clear();
        self.joins.extend(std::mem::take(&mut self.labels).joins());
    }

    /// The routine that starts, or goes on after another one in its text, by its own number and its name.
    pub fn routine(&mut self, id: usize, name: String) {
        let at = self.next();
        self.routines.start(id, name, at);
    }

    /// All calls of the routine that starts stand in the text (`true`), or from where the robot comes to its first target is not known.
    pub fn all_calls_are_here(&mut self, known: bool) {
        self.routines.all_calls_are_here(known);
    }

    /// Something may call a routine from a place that is not known.
    pub fn called_otherwise(&mut self, name: String) {
        self.routines.called_otherwise(name);
    }

    /// The routine is left here, back to what called it.
    pub fn returns(&mut self) {
        let at = self.next();
        self.routines.returns(at);
    }

    /// Nothing leads to what follows but a label, or the start of another routine.
    pub fn ends_here(&mut self) {
        self.routines.is_reached(!self.open.is_empty());
    }

    /// Something may lead here that is not known.
    pub fn lands(&mut self) {
        self.routines.is_reached(true);
    }

    /// A statement that is the call of a routine, and of nothing else that may move.
    pub fn calls(&mut self, at: At, name: String) {
        let unsure = self.open.last().map(|block| block.unsure);
        let k = self.push(at, StepKind::Break(Break::Call));
        if let (Some(block), Some(unsure)) = (self.open.last_mut(), unsure) {
            // the condition of the block does not call it
            block.unsure = unsure;
        }
        self.routines.called(k, name);
    }

    /// A break after which the robot stands where it stood: something else than its place may have changed.
    pub fn goes_on(&mut self, at: At, kind: Break) {
        let k = self.push(at, StepKind::Break(kind));
        self.joins.push(Join { at: k, from: vec![k] });
    }

    /// Something may lead out of a routine by another way than to what called it.
    pub fn calls_are_unknown(&mut self) {
        self.routines.are_unknown();
    }

    /// A block opens, with a break: its condition is looked at where the robot stands.
    pub fn open(&mut self, at: At, kind: Break) {
        self.open.push(Block::default());
        let k = self.own_break(at, kind);
        if kind == Break::Jump {
            self.joins.push(Join { at: k, from: vec![k] });
        }
    }

    /// A loop opens; `entered`: see [`super::is_entered`].
    pub fn open_loop(&mut self, at: At, entered: bool) {
        self.open(at, Break::Loop);
        if let Some(block) = self.open.last_mut() {
            block.round = entered;
        }
    }

    /// Something may lead from inside of the loops that are open to their next pass.
    pub fn skips(&mut self) {
        self.open.iter_mut().for_each(|block| (block.round, block.skipped) = (false, true));
    }

    /// Something may lead out of the blocks that are open.
    pub fn leaves(&mut self) {
        self.open.iter_mut().for_each(|block| block.left = true);
    }

    /// The next branch of the innermost block begins, with a break; `whole`: it has no condition of its own.
    pub fn branch(&mut self, at: At, whole: bool) {
        let next = self.next();
        // what a condition calls may stand before its break
        let called = !whole && matches!(self.last().map(|s| &s.kind), Some(StepKind::Break(Break::Call)));
        if let Some(block) = self.open.last_mut() {
            block.unsure |= called;
            block.whole |= whole;
            block.ends.push(next);
            if let Some(open) = block.breaks.first().filter(|_| !block.unsure) {
                self.joins.push(Join { at: next, from: vec![*open] });
            }
        }
        self.own_break(at, Break::Jump);
    }

    /// A jump away: nothing leads to what follows but a label, or the end of its block.
    pub fn jump(&mut self, at: At) {
        let k = self.own_break(at, Break::Jump);
        self.joins.push(Join { at: k, from: Vec::new() });
    }

    /// The program may end here, and runs again from its start ([`Self::entry`], else the first of its routines).
    pub fn runs_again(&mut self) {
        let at = self.next();
        self.again.push(at);
    }

    /// A break that belongs to the innermost block.
    fn own_break(&mut self, at: At, kind: Break) -> usize {
        let k = self.add(at, StepKind::Break(kind));
        if let Some(block) = self.open.last_mut() {
            block.breaks.push(k);
        }
        k
    }

    /// A label; `None`: its name is not known.
    pub fn label(&mut self, at: At, name: Option<String>) {
        self.routines.is_reached(true);
        let k = self.push(at, StepKind::Break(Break::Jump));
        self.labels.stands(name, k);
    }

    /// Something may jump to a label from here, where the robot stands; `None`: to any.
    pub fn jumps_to(&mut self, name: Option<String>) {
        let from = self.next();
        self.labels.jumps_to(name, from);
    }

    /// Something may jump to a label while the robot moves; `None`: to any.
    pub fn jumps_on_the_way(&mut self, name: Option<String>) {
        self.labels.jumps_on_the_way(name);
    }

    /// The innermost block closes, with a break (`true`) unless nothing in it moves: then its own breaks go.
    pub fn close(&mut self, at: At, kind: Break) -> bool {
        match self.open.pop() {
            Some(block) if !block.busy => {
                self.gone.extend(block.breaks);
                false
            }
            block => {
                let close = self.push(at, StepKind::Break(kind));
                if let Some(block) = block {
                    self.closed(&block, kind, close);
                }
                true
            }
        }
    }

    /// From where control comes to the break that closes a block, and to the one that opens a loop.
    fn closed(&mut self, block: &Block, kind: Break, close: usize) {
        let Some(&open) = block.breaks.first() else { return };
        if let ([_], true) = (&block.breaks[..], block.round) {
            self.rounds.push(Round { open, close, goes_on: !block.left });
        }
        match kind {
            _ if block.unsure => {}
            Break::Loop => {
                if !block.skipped {
                    self.joins.push(Join { at: open, from: vec![open, close] });
                }
                if !(block.left || block.skipped) {
                    let from = if block.round { vec![close] } else { vec![open, close] };
                    self.joins.push(Join { at: close, from });
                }
            }
            _ => {
                let mut from = block.ends.clone();
                from.push(close);
                from.extend((!block.whole).then_some(open));
                self.joins.push(Join { at: close, from });
            }
        }
    }
}
