//! Who reads or stores where the machine stands: the moves from which it may have come there end where they always did.
//!
//! A place that a line reads (`#1=#5041`, `IF [#5021 GT 3]`, `X[#<_x>+1]`) or stores (G28.1, G30.1, M428) is that of the last move in the
//! order of the text, and after a label, a loop, a call or at the start of a subprogram that of any move before a label, a jump, a loop or
//! a call. Parameters: LinuxCNC (5021 and 5041 machine and work position, 5161 to 5189 reference points, 5420 current position), Fanuc
//! custom macro B (5001 end of block, 5021, 5041, 5061 skip; 100001 to 100350 the same for more axes).

use super::assignments::Assignments;
use super::certain::Carried;
use super::codes::TOUCHES;
use super::lex::{Block, has_axes};
use super::read::Reader;
use super::reason::{After, Elsewhere};
use crate::script::Break;
use crate::script::cursor::{Cursor, integer};

/// Parameters in which controls keep places.
fn is_place(n: u32) -> bool {
    matches!(n, 5000..=5999 | 100_001..=100_350)
}

/// Whether a line names variables in which a control keeps places: `#5041`, `#<_x>`, or a computed one.
///
/// `place = "#" ("<_" ... | number | "[" ... | "#")`
fn reads_places(line: &[u8]) -> bool {
    if !line.contains(&b'#') {
        return false;
    }
    let line = Assignments::compact(line);
    line.match_indices('#').any(|(at, _)| {
        let mut rest = Cursor::new(line.as_bytes());
        rest.go_to(at + 1);
        match rest.peek() {
            Some(b'<') => rest.second() == Some(b'_'),
            Some(b'[' | b'#') => true,
            // a number beyond all is none
            Some(b) if b.is_ascii_digit() => integer(rest.digits()).is_some_and(is_place),
            _ => false,
        }
    })
}

impl Reader<'_> {
    /// Whether line `k` reads where the machine stands, which is then kept.
    pub(super) fn reads_place(&mut self, k: usize) -> bool {
        let reads = reads_places(self.text.line(k));
        if reads {
            self.keeps_place(After::ReadsPlace);
        }
        reads
    }

    /// The place where the machine stands is read or stored here: it must be what it always was.
    pub(super) fn keeps_place(&mut self, why: After) {
        self.anchor(why);
        let lost = |a: &usize| self.position.get(*a).is_some_and(Option::is_none);
        let ways: Vec<Carried> = (0..self.letters.len()).filter(lost).map(|a| self.carried[a]).collect();
        ways.into_iter().for_each(|way| self.keep_way(way, why));
    }

    /// What counts from where an axis stands, of which this is known, counts from where it always stood.
    pub(super) fn keep_way(&mut self, way: Carried, why: After) {
        match way {
            Carried::Nothing => {}
            Carried::After(step) => self.anchor_at(step, why),
            Carried::Anywhere => self.keep_leaving(why),
        }
    }

    /// Whether what a G word of a block makes is about where the machine stands, in axes that the block does not name too: a touch of a
    /// probe, a scaling or a mirror, whose centre may be there, and the cycles of a lathe, which start there. What is not followed may be,
    /// too.
    pub(super) fn counts_from_here(&self, block: &Block, c: u32) -> bool {
        const OF_LATHES: &[u32] = &[730, 740, 760];
        let cycle = self.survey.diameters && OF_LATHES.contains(&c);
        TOUCHES.contains(&c) || matches!(c, 310 | 510 | 511) || cycle || self.cuts_thread(block, c)
    }

    /// G28.1 and G30.1 make a reference point of where the machine stands.
    pub(super) fn stores_place(&mut self, k: usize, block: &Block, c: u32) {
        self.keeps_place(After::StoresPlace);
        self.end(k, Break::Frame, After::StoresPlace);
        if has_axes(block) {
            // some controls go there
            self.goes_elsewhere(k, None, Elsewhere::Reference(c));
        }
    }

    /// A line that `reads` a place, and to which control may come from elsewhere in the text, as it just joined: the place may be that of
    /// any way there.
    pub(super) fn reads_anywhere(&mut self, reads: bool, block: &Block) {
        let label = self.is_label(block);
        // those are passed from above alone
        let forward = |w: &str| matches!(w, "IF" | "REPEAT" | "CALL");
        let flow = block.flow.as_deref().is_some_and(|w| !forward(w));
        if reads && (label || flow || block.keyword.as_deref() == Some("WHILE")) {
            self.keeps_place(After::ReadsPlace);
        }
    }

    /// Moves after which control may come to any other place of the text end where they always did.
    pub(super) fn keep_leaving(&mut self, why: After) {
        if !self.counts_anywhere {
            self.counts_anywhere = true;
            std::mem::take(&mut self.leaving).into_iter().for_each(|step| self.anchor_at(step, why));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_of_places_are_told_from_others() {
        for line in [
            "#1=#5041",
            "IF [#5021 EQ 2] GOTO 3",
            "G1 X[#<_x>+1]",
            "#1=#[5000+#2]",
            "G0 X##1",
            "#1=# 5041",
            "#2=#100003",
        ] {
            assert!(reads_places(line.as_bytes()), "{line}");
        }
        for line in ["#500=#501", "#50=1", "(#5041)", "G1 X5 ; #5041", "X#1", "G1 X5041", "#1=#<own_x>", "#2=#50410"] {
            assert!(!reads_places(line.as_bytes()), "{line}");
        }
    }
}
