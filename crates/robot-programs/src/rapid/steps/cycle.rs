//! Where `main` ends: in the run mode Continuous it starts again from there (ABB, Operating manual, IRC5 with FlexPendant: run mode), and
//! so it does after `ExitCycle`.
//!
//! Grammar: `end = "ENDPROC" | "RETURN" | "ExitCycle"`, the first two of `main`. Nothing leads to the end after `WHILE TRUE`, `EXIT`,
//! `RAISE` and `GOTO` outside of blocks, nor does a `Stop` after which nothing moves: the program waits for its user there.

use super::super::facts;
use super::super::read::{Item, ItemKind};
use super::Builder;
use crate::script::blocks::is_entered;

/// The way through `main` in the order of its text.
#[derive(Debug, Default)]
pub struct Cycle {
    routine: Option<usize>,
    /// In `main`, and not in its handlers.
    inside: bool,
    /// Whether each open block is a loop without an end.
    open: Vec<bool>,
    /// Nothing leads to the place that is read.
    dead: bool,
    /// The program has stopped and nothing has moved since.
    stopped: bool,
}

impl Cycle {
    /// Goes on to an item with a first word; `main`: it is one of `main`; `endless`: its head is that of a loop without an end; `moves`: it
    /// may move. Returns whether the program runs again from its start instead.
    pub fn ends_before(&mut self, item: &Item, word: &str, main: bool, endless: bool, moves: bool) -> bool {
        if item.kind == ItemKind::Start {
            let ends = self.ends();
            let handler = self.routine == Some(item.routine);
            *self = Self { routine: Some(item.routine), inside: main && !handler, ..Self::default() };
            return ends;
        }
        if word == "exitcycle" {
            return true;
        }
        if !self.inside {
            return false;
        }
        self.stopped &= !moves;
        let ends = word == "return" && item.kind == ItemKind::Leave && self.ends();
        match item.kind {
            ItemKind::Branch | ItemKind::Loop => self.open.push(endless),
            ItemKind::EndBranch | ItemKind::EndLoop => {
                let endless = self.open.pop().unwrap_or_default();
                self.dead |= endless && self.open.is_empty();
            }
            ItemKind::Label => self.dead = false,
            ItemKind::Leave => self.dead |= self.open.is_empty(),
            ItemKind::Call { alone: false } if word == "stop" => self.stopped |= self.open.is_empty(),
            _ => {}
        }
        ends
    }

    /// Whether `main` ends where its text does.
    pub fn ends(&self) -> bool {
        self.inside && !self.dead && !self.stopped
    }
}

impl Builder<'_> {
    /// Where `main` ends the program runs again from its start.
    pub(super) fn follow_cycle(&mut self, item: &Item, moves: bool) {
        let p = self.f.p;
        let main = self.entry_routine == Some(item.routine)
            && p.routines.get(item.routine).is_some_and(|routine| routine.name == "main");
        let endless = || {
            item.kind == ItemKind::Loop
                && self.head(item).is_some_and(|(word, head)| word == "while" && is_entered(head))
        };
        let moves = moves || self.cycle.stopped && facts::called(p, item).any(|name| self.f.may_move(name));
        let (word, endless) = (self.f.word(item.span.start), main && endless());
        if self.cycle.ends_before(item, word, main, endless, moves) {
            self.steps.runs_again();
        }
    }

    /// The head of a loop and the word with which it begins, before its condition.
    pub(super) fn head(&self, item: &Item) -> Option<(&str, &[u8])> {
        let first = item.span.start.checked_sub(1)?;
        let tokens = self.f.p.tokens.get(first..item.span.end)?;
        let bytes = tokens.first()?.start()..tokens.last()?.end();
        Some((self.f.word(first), self.f.text.slice(bytes)))
    }
}
