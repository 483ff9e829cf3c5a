//! Blocks, jumps and calls of a program as it is read: where steps break, and which settings hold after them.

use super::Reader;
use super::ahead::by_a_routine;
use super::in_force::InForce;
use crate::krl::calls::calls;
use crate::krl::lex::{Token, in_upper};
use crate::krl::lists::{BASES, TOOLS};
use crate::krl::settings::{self, Settings};
use crate::script::blocks::is_entered;
use crate::script::pose::Frame;
use crate::script::{At, Break, StepKind};

/// A block that is open: the settings before it and with which it began.
pub(super) struct Block {
    before: Settings,
    begins: Settings,
    /// How many statements had set any before it.
    set: usize,
}

impl Reader<'_> {
    pub(super) fn push(&mut self, k: usize, kind: StepKind) {
        if let StepKind::Break(b) = kind {
            self.breaks(k, b);
        }
        self.steps.push(At::of_line(k), kind);
    }

    /// What a break leaves of the settings.
    fn breaks(&mut self, k: usize, kind: Break) {
        if kind != Break::Frame {
            self.settings_made += usize::from(kind == Break::Call);
            self.set = self.later_settings(k);
            self.set.lists.merge_all(&self.ahead.lists, kind != Break::Call);
        }
        self.stands = None;
    }

    /// A label.
    ///
    /// `label = name ":"`
    pub(super) fn label(&mut self, k: usize, word: &str) {
        self.breaks(k, Break::Jump);
        self.steps.label(At::of_line(k), Some(word.to_ascii_uppercase()));
    }

    /// What is in force after line `k`, whichever way the program came there.
    fn later_settings(&self, k: usize) -> Settings {
        let lists = self.set.lists.clone();
        let InForce { frames: [base, tool], carried, moved } = self.force.after(k);
        Settings { base, tool, lists, carried, moved, ..Settings::turning(self.ahead.turning) }
    }

    /// What a line sets that is computed has the name that tells it from others of the same words.
    pub(super) fn frames_by_name(&mut self, k: usize) {
        let (force, set) = (&self.force, &mut self.set);
        for (list, frame) in [&mut set.base, &mut set.tool].into_iter().enumerate() {
            if let Some(own) = frame.take() {
                *frame = Some(force.named(list, k, own));
            }
        }
    }

    /// Base and tool that a motion or a spline block sets for itself, by the names that tell them from others of the same words.
    pub(super) fn with_of(&self, k: usize, line: &[Token]) -> [Option<Frame>; 2] {
        let [base, tool] = settings::with(&self.set, self.text, line, self.data, self.routine);
        [base.map(|frame| self.force.named(BASES, k, frame)), tool.map(|frame| self.force.named(TOOLS, k, frame))]
    }

    /// A routine to which `$BASE` or `$TOOL` itself is passed may set it.
    pub(super) fn passed(&mut self, k: usize) {
        let set = |list: usize| self.ahead.passed[list].contains(&(k as u64 + 1)).then(|| by_a_routine(list));
        let [base, tool] = [set(0), set(1)];
        self.settings_made += usize::from(base.is_some() || tool.is_some());
        self.set.base = base.or(self.set.base.take());
        self.set.tool = tool.or(self.set.tool.take());
    }

    /// A block, a jump or an interrupt; `false`: it is none.
    ///
    /// `flow = ("IF" | "SWITCH" | "LOOP" | "FOR" | "WHILE" | "REPEAT") ... | middle | end | jump | ["GLOBAL"] "INTERRUPT" ... | "BRAKE"`,
    /// `middle = "ELSE" | "CASE" ... | "DEFAULT"`, `jump = "GOTO" name | "EXIT" | "RETURN" [value] | "RESUME"`,
    /// `end = "ENDIF" | "ENDSWITCH" | "ENDLOOP" | "ENDFOR" | "ENDWHILE" | "UNTIL" ... | "END" | "ENDFCT"`
    pub(super) fn flow(&mut self, k: usize, line: &[Token], word: &str, second: &str) -> bool {
        match word {
            "IF" | "SWITCH" => self.open(k, line, Break::Jump),
            "ELSE" | "CASE" | "DEFAULT" => self.middle(k, line, word != "CASE"),
            "ENDIF" | "ENDSWITCH" => self.close(k, line, Break::Jump),
            "GOTO" | "EXIT" => {
                self.jumps = true;
                if word == "GOTO" {
                    self.steps.jumps_to(Some(second.to_ascii_uppercase()).filter(|name| !name.is_empty()));
                }
                self.leave(k);
            }
            "RETURN" => {
                self.jumps = true;
                self.called(k, line);
                self.steps.returns();
                self.leave(k);
            }
            "END" | "ENDFCT" => {
                self.steps.returns();
                self.steps.ends_here();
                self.stop(k, Break::Jump);
            }
            "RESUME" => {
                self.steps.calls_are_unknown();
                self.stop(k, Break::Jump);
            }
            "LOOP" | "FOR" | "WHILE" | "REPEAT" => self.open(k, line, Break::Loop),
            "ENDLOOP" | "ENDFOR" | "ENDWHILE" | "UNTIL" => self.close(k, line, Break::Loop),
            "BRAKE" => self.stop(k, Break::Interrupt),
            "INTERRUPT" => self.interrupt(k, line),
            "GLOBAL" if second == "INTERRUPT" => self.interrupt(k, line),
            _ => return false,
        }
        true
    }

    /// `interrupt = ["GLOBAL"] "INTERRUPT" ("DECL" number "WHEN" condition "DO" call | "ON" ... | "OFF" ...)`
    fn interrupt(&mut self, k: usize, line: &[Token]) {
        self.stop(k, Break::Interrupt);
        let moving = calls(self.text, line).into_iter().filter(|name| self.still.waits(name).is_none());
        self.strikes.extend(moving.map(|name| (name, k as u64 + 1)));
    }

    /// A block opens; what its line calls belongs to it.
    fn open(&mut self, k: usize, line: &[Token], kind: Break) {
        self.stands = None;
        let before = self.set.clone();
        match kind {
            Break::Loop => {
                let bytes = line.first().map_or(0, |t| t.start)..line.last().map_or(0, |t| t.end);
                self.steps.open_loop(At::of_line(k), is_entered(self.text.slice(bytes)));
            }
            _ => self.steps.open(At::of_line(k), kind),
        }
        self.set = self.later_settings(k);
        if kind == Break::Loop {
            self.set.lists.merge_all(&self.ahead.lists, false);
        }
        let begins = self.set.clone();
        self.blocks.push(Block { before, begins, set: self.settings_made });
        self.called(k, line);
    }

    /// Its next branch begins; `whole`: whatever the conditions are.
    fn middle(&mut self, k: usize, line: &[Token], whole: bool) {
        self.stands = None;
        self.steps.branch(At::of_line(k), whole);
        if let Some(block) = self.blocks.last_mut() {
            // the other branch begins with what was there before, or with both
            self.set.lists.merge(&block.begins.lists);
        }
        self.set = self.later_settings(k);
        self.called(k, line);
    }

    /// It closes: where nothing in it moves, the directions stay, and where it sets nothing the settings do.
    fn close(&mut self, k: usize, line: &[Token], kind: Break) {
        self.stands = None;
        self.called(k, line);
        let busy = self.steps.close(At::of_line(k), kind);
        let block = self.blocks.pop();
        let sets = block.as_ref().is_none_or(|b| b.set != self.settings_made);
        match block {
            Some(block) if !busy && !sets => self.set = block.before,
            block => {
                if let Some(block) = block {
                    self.set.lists.merge(&block.before.lists);
                }
                self.set = self.later_settings(k);
            }
        }
    }

    /// A jump away: what follows is reached by a label, or the end of its block.
    fn leave(&mut self, k: usize) {
        self.stands = None;
        self.steps.leaves();
        self.steps.ends_here();
        if self.blocks.is_empty() { self.stop(k, Break::Jump) } else { self.steps.jump(At::of_line(k)) }
    }

    pub(super) fn stop(&mut self, k: usize, kind: Break) {
        self.push(k, StepKind::Break(kind));
    }

    /// A break where the line calls something that may move.
    pub(super) fn called(&mut self, k: usize, line: &[Token]) {
        if self.still.hides(self.text, line) {
            return self.stop(k, Break::Call);
        }
        let (mut waits, mut sets, mut moving) = (false, false, Vec::new());
        for name in calls(self.text, line) {
            if self.counting.contains(&name) {
                self.counted_calls.insert(k as u64 + 1);
            }
            match self.still.waits(&name) {
                Some(waiting) => {
                    waits |= waiting;
                    self.named_calls.still(self.still.needs(), &name, k as u64 + 1);
                    if !self.still.needs().is_declared(&name) {
                        self.met.entry(name).or_insert(k as u64 + 1);
                    }
                }
                None if self.still.sets(&name) => {
                    sets = true;
                    self.named_calls.still(self.still.needs(), &name, k as u64 + 1);
                    self.met.entry(name).or_insert(k as u64 + 1);
                }
                None => moving.push(name),
            }
        }
        moving.iter().for_each(|name| self.named_calls.moving(self.still.needs(), name, At::of_line(k)));
        let whole = line.first().map(|t| in_upper(self.text, t));
        match moving.as_slice() {
            [] if sets => {
                self.breaks(k, Break::Call);
                self.steps.goes_on(At::of_line(k), Break::Call);
            }
            [] if waits => self.push(k, StepKind::Dwell(None)),
            [] => {}
            [name] if whole.as_deref() == Some(name) => {
                self.breaks(k, Break::Call);
                self.steps.calls(At::of_line(k), moving.swap_remove(0));
            }
            _ => {
                moving.into_iter().for_each(|name| self.steps.called_otherwise(name));
                self.stop(k, Break::Call);
            }
        }
    }
}
