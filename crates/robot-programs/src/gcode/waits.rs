//! Moves after which the program waits: they end exactly at their goals, whatever mode of the feed is in force.
//!
//! A dwell keeps the axes where they are (NIST RS274NGC, 3.5.4: "This will keep the axes unmoving for the period of time in seconds
//! specified by the P number"). LinuxCNC ends the motion before it (`emcTaskCheckPreconditions`: `EMC_TRAJ_DELAY` waits for motion); SEW:
//! "Dwelling begins only when the previously programmed motion path has been run in its entirety"; Siemens, 840D, ISO milling, 3.3.1: the
//! move of the next block waits. A point before such a goal is no stop by itself, so the same dwell is written after it. Words that stop a
//! program (M0, M30) and those that may wait for the machine (M3, M5, M6) have no such form, and controls differ in the latter.

use super::lex::{Block, Word};
use super::read::Reader;
use super::statements::Statement;
use super::write::{SAME, Writer};
use crate::script::{AxisSet, Patch, PathKind, StepKind};

impl Reader<'_> {
    /// The dwell of a block is one of some time, and its words can stand in a separate block: the move of the block before ends
    /// exactly.
    ///
    /// `dwell = ["N" number] "G4" ("P" | "X" | "U" | "F" | "S") number`
    pub(super) fn waits_at_goal(&mut self, block: &Block) {
        let words: Vec<&Word> = block.words.iter().filter(|w| w.letter != b'N').collect();
        let [code, time] = words.as_slice() else { return };
        let lasts = b"PXUFS".contains(&time.letter) && time.value.is_some_and(|v| v.0 > 0.0);
        if code.letter != b'G' || !lasts || block.folded || block.optional || block.special.is_some() {
            return;
        }
        let text = [code, time].map(|w| String::from_utf8_lossy(self.text.slice(w.span())).into_owned()).join(" ");
        let Some(step) = self.script.steps.len().checked_sub(1) else { return };
        // others stand, and it may be in the work: no point may move them there
        let moved = |(axis, (from, to)): (usize, (&f64, &f64))| {
            (!to.is_nan() && (from.is_nan() || (to - from).abs() > SAME)).then_some(axis)
        };
        let Some(places) = self.statements.places_of(step, self.letters.len()) else { return };
        let axes: AxisSet = places.start.iter().zip(places.goal).enumerate().filter_map(moved).collect();
        if !axes.is_empty()
            && let Some(StepKind::Move(m)) = self.script.steps.get_mut(step).map(|s| &mut s.kind)
            && m.goal.target().is_some()
            && m.path == PathKind::Joint
        {
            m.waits = axes;
            self.waits.0.insert(step, text);
        }
    }
}

impl Writer<'_> {
    /// Waits at a new point before the goal of a step, as the program does at the goal.
    pub(super) fn wait(&mut self, step: usize, s: &Statement) {
        let Some(words) = self.program.waits.0.get(&step) else { return };
        let Some(text) = self.program.script.texts.first() else { return };
        let line = text.line_span(s.line);
        let mut bytes = words.as_bytes().to_vec();
        bytes.extend_from_slice(text.ending(line.start));
        self.patches.push(Patch::new(0, line.start..line.start, bytes));
    }
}
