//! Arcs that stay begin where they always did: the moves before them end at their own places.
//!
//! I, J and K count from the start of an arc, and an arc by its radius goes through its start, so an offset there would move the centre
//! or make the radii of start and end differ, which controls refuse.

use super::arc::NoArc;
use super::certain::{Carried, opaque};
use super::lex::{Block, names};
use super::read::Reader;
use super::reason::{After, Doubt, Reason};
use crate::error::Result;
use crate::script::{AxisSet, StepKind};

impl Reader<'_> {
    /// A block that stays as it is, for a reason.
    pub(super) fn leaves(&mut self, k: usize, block: &Block, why: Reason) -> Result<()> {
        // a motion that is not known may be an arc
        let arc = match self.motion {
            Some(motion) => matches!(motion, 20 | 30),
            None => names(block, b"IJKR"),
        };
        if arc {
            let none = matches!(why, Reason::NoArc(no) if no != NoArc::NoStart);
            self.keep_start_of_arc(if none { After::NoArc } else { After::Arc });
        }
        let named = self.certainly_named(block, &why);
        self.lose(After::Unclear);
        self.named = self.named.or(named);
        self.step(k, StepKind::Move(opaque(why)), None);
        Ok(())
    }

    /// The axes that a block takes to the places of its words although it stays.
    fn certainly_named(&self, block: &Block, why: &Reason) -> AxisSet {
        let goes_on = match why {
            Reason::Doubt(doubt) => {
                matches!(doubt, Doubt::Compensation(_) | Doubt::CompensationMayBeOn | Doubt::Modes(_))
            }
            Reason::NoArc(_) | Reason::NoAxis(_) | Reason::NoFrame => true,
            _ => false,
        };
        let plain = self.absolute == Some(true) && self.strange.is_none() && self.modal_macro.is_none();
        if !goes_on || !plain || !matches!(self.motion, Some(0 | 10 | 20 | 30)) {
            return AxisSet::default();
        }
        block.words.iter().filter_map(|w| self.letters.iter().position(|l| *l == w.letter)).collect()
    }

    /// A circle without a word of a place, where the motion in force is not known: it may be that of an arc above.
    pub(super) fn keep_start_of_circle(&mut self, block: &Block) {
        if self.motion.is_none() && names(block, b"IJK") && !names(block, b"M") {
            self.keep_start_of_arc(After::Arc);
        }
    }

    /// An arc stays: the moves from which it may start end where they always did, in the axes of its plane.
    pub(super) fn keep_start_of_arc(&mut self, why: After) {
        self.anchor(why);
        let plane = self.plane_of_lathe().or(self.plane);
        let of_plane = |letter: u8| match plane {
            Some([u, v, _]) => letter == u || letter == v,
            None => b"XYZ".contains(&letter),
        };
        let counts = |a: &usize| {
            let lost = self.position.get(*a).is_some_and(Option::is_none);
            lost && !self.named.has(*a) && self.letters.get(*a).is_some_and(|l| of_plane(*l))
        };
        let ways: Vec<Carried> = (0..self.letters.len()).filter(counts).map(|a| self.carried[a]).collect();
        ways.into_iter().for_each(|way| self.keep_way(way, why));
    }
}
