//! Canned cycles that make holes: the way to a hole is that of a G0, and what happens in the hole is the cycle's own.
//!
//! With G17 a cycle traverses X and Y to their words, then Z to the level R, makes the hole, and takes Z back to R (G99) or to where Z
//! stood before the first hole (G98). Every block with a word of a place makes a hole until a G80 or a motion (NIST RS274NGC, NISTIR 6556,
//! 3.5.16: "a straight traverse parallel to the XY-plane to the given XY-position", "a straight traverse of the Z-axis only to the R
//! position"; LinuxCNC, G-codes, canned cycles, the same; Weihong NC, programming manual, format of canned cycle: K "in G90 mode ... can
//! specify the repeated machining times on the same position"). So X and Y are targets that are reached from the place before, and are
//! edited as those of a G0. No point is added: it would be a hole.
//!
//! Z, R, P, Q stay: the hole is as deep as it was. Unless G99 is in force, the move before the first hole ends at its original position:
//! its Z is the level to which the cycle comes back, from the other side. Where Z comes to depends on G98, on R and on where it stood, with
//! its offset; so it is not known until a word names it again. The same goes for axes other than X and Y, as no word of them may be added
//! to a cycle.
//!
//! What stays as a whole: G91 (R counts from where Z stands, and with L or K one block makes several holes), other planes (the axis that
//! drills is a parameter of the control: Fanuc 5101#0), lathes and printers, on which these are other words, L0 and K0 (no hole, and on
//! some controls no way either), words of other axes. G76 and G87 shift X and Y in the hole (Fanuc, Series 15i, operator's manual
//! B-63324EN/03, G76: "a shift is made in an arbitrary direction on the positioning plane"), and G88 stops for the operator to move the
//! machine by hand: from which side X and Y come after them is not known.

use super::across::Across;
use super::certain::opaque;
use super::codes::{CANNED, SPLINES, TOUCHES};
use super::lex::{Block, Word, names};
use super::read::Reader;
use super::reason::{Elsewhere, Reason};
use super::statements::{Statement, axis_words};
use crate::error::Result;
use crate::script::{AxisSet, StepKind};

/// Cycles after which X and Y stand where they came from the place before, times ten.
const HOLES: &[u32] = &[730, 740, 810, 820, 830, 840, 850, 860, 890];
/// Of them those whose I and J are parts of the way in the hole: pecks, and the speed of the return of a tap.
const PECKS: &[u32] = &[730, 740, 830, 840];

/// A hole of which the way to it is known.
pub(super) struct Hole {
    cycle: u32,
    /// Axes that stand elsewhere after it.
    others: AxisSet,
    /// The block leads to another place in X or Y.
    goes: bool,
    inch: bool,
}

impl Reader<'_> {
    /// The hole that a block makes by the cycle `cycle` (times ten); `None`: it may do more, or go otherwise.
    ///
    /// `hole = ["G98" | "G99"] ["G81" ...] {("X" | "Y") number | ("Z" | "R" | "P" | "Q" | "F") any | ("L" | "K") number}`
    pub(super) fn hole(&self, block: &Block, codes: &[Option<u32>], cycle: u32) -> Option<Hole> {
        let inch = self.inch?;
        let mode = self.absolute == Some(true) && !self.frame_to_name && self.plane == Some([b'X', b'Y', b'Z']);
        let survey = &self.survey;
        let mill = !(survey.lathe || survey.diameters || survey.printer || survey.siemens);
        if !HOLES.contains(&cycle) || !mode || !mill || self.across != Some(Across::Radius) {
            return None;
        }
        let moves = |c: &u32| [0, 10, 20, 30].contains(c) || [CANNED, SPLINES, TOUCHES].iter().any(|l| l.contains(c));
        if codes.iter().flatten().filter(|c| moves(c)).count() > 1 {
            return None;
        }
        if names(block, b"UVWABCE") || names(block, b"IJ") && !PECKS.contains(&cycle) {
            return None;
        }
        self.axes_named(block)?;
        block.words.iter().all(|w| self.is_plain_in_hole(block, w)).then_some(())?;
        let positions = |a: &usize| matches!(self.letters.get(*a), Some(b'X' | b'Y'));
        let others: AxisSet = (0..self.letters.len()).filter(|a| !positions(a)).collect();
        let hole = Hole { cycle, others, goes: names(block, b"XY"), inch };
        Some(hole).filter(|_| !others.is_empty())
    }

    /// A level alone makes a cycle run, too.
    pub(super) fn drills_by_level(&self, block: &Block) -> bool {
        self.motion.is_some_and(|c| CANNED.contains(&c)) && names(block, b"R")
    }

    /// Whether a word leads to where it says, if it leads anywhere, and the block makes a hole there.
    ///
    /// `word = ("X" | "Y") number | ("L" | "K") number | ...`
    fn is_plain_in_hole(&self, block: &Block, w: &Word) -> bool {
        let once = block.words.iter().filter(|other| other.letter == w.letter).count() == 1;
        match (w.letter, w.value) {
            (b'X' | b'Y', Some((v, style))) => once && (style.point || v == 0.0 || !self.survey.may_count()),
            (b'L' | b'K', Some((v, _))) => v > 0.0,
            (b'X' | b'Y' | b'L' | b'K', None) => false,
            _ => true,
        }
    }

    /// The steps of a hole: the way to it in X and Y, and what the cycle does there.
    pub(super) fn drills(
        &mut self,
        k: usize,
        block: Block,
        codes: &[Option<u32>],
        exact: bool,
        hole: Hole,
    ) -> Result<()> {
        let Hole { cycle, others, goes, inch } = hole;
        self.leave_to_cycle(others, cycle);
        if goes {
            let start = self.position.clone();
            let (unit, shift) = self.units_and_shifts(inch);
            let digits = self.digit.clone();
            let mut goal = self.named_goal(&block, &start, &unit, &shift, true)?;
            // the depth is no place at which Z stands
            others.axes().for_each(|a| (goal[a], self.digit[a]) = (None, digits[a]));
            let statement = Statement {
                line: k,
                motion: 0,
                motion_word: None,
                folded: block.folded,
                absolute: true,
                axis_words: axis_words(&block.words, self.letters),
                unit,
                shift,
                start,
                goal,
                arc: None,
                words: block.words,
            };
            let mut m = self.describe(&statement, codes, exact);
            m.closed = Some(Reason::WouldDrill.into());
            let step = self.put(k, &statement, m);
            self.statements.push(step, statement);
        }
        let mut goes = opaque(Elsewhere::Hole(cycle).into());
        goes.moves_alone = Some(others);
        self.step(k, StepKind::Move(goes), None);
        Ok(())
    }

    /// A cycle takes over these axes: what counts from where they stand counts from where they stood before it.
    fn leave_to_cycle(&mut self, axes: AxisSet, cycle: u32) {
        let relative = |step: usize| self.statements.places_of(step, self.letters.len()).is_some_and(|s| !s.absolute);
        // the level to which G98 comes back, from below, would have the offset of the way down to it
        let level = !self.back_to_r && axes.axes().any(|a| self.position.get(a).is_some_and(Option::is_some));
        if level || self.last.is_some_and(relative) {
            self.anchor(Elsewhere::Hole(cycle).into());
        }
        self.carry(axes);
        for a in axes.axes() {
            self.position[a] = None;
        }
    }
}
