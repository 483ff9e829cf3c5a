//! What shows that a program is one of a lathe.

use super::across::Across;
use super::codes::{CANNED, code};
use super::lex::{Block, Word, has_axes, names};
use crate::script::Text;
use std::collections::BTreeSet;

impl Across {
    /// G7 and G8 with nothing beside them that would make them other words: `G7 X0` and `G8 P1` are those of Fanuc controls.
    pub(super) fn of_g_word(block: &Block, c: u32) -> Option<Self> {
        let other = has_axes(block) || names(block, b"P");
        match c {
            70 if !other => Some(Self::Diameter),
            80 if !other => Some(Self::Radius),
            _ => None,
        }
    }
}

/// What a look over a text finds of lathes.
#[derive(Debug, Default)]
pub(super) struct Signs {
    /// A Y, which lathes do not have.
    pub(super) y: bool,
    /// U and W, a speed limit or a constant cutting speed of the spindle, or a turning cycle ([`turns`]).
    words: bool,
    /// A speed limit of the spindle or a constant cutting speed.
    spindle: bool,
    /// `T0101`.
    turret: bool,
    /// Words that only Siemens controls have: `DIAMON`, `X=IC(5)`, `T="MILL10"`.
    siemens: bool,
}

/// On a Siemens control G70 and G71 are inches and millimetres, and so are G700 and G710 for the feed too (times ten).
pub(super) fn unit_of_siemens(c: u32) -> u32 {
    match c {
        700 | 7000 => 200,
        710 | 7100 => 210,
        _ => c,
    }
}

impl Signs {
    /// What a block tells.
    pub(super) fn block(&mut self, text: &Text, block: &Block) {
        let limit = has(block, &[500, 920]) && names(block, b"S") && !has_axes(block);
        self.words |= turns(block);
        self.spindle |= has(block, &[960]) || limit;
        let turret = |w: &Word| {
            let digits = text.slice(w.number());
            w.letter == b'T' && digits.len() == 4 && digits.iter().all(u8::is_ascii_digit)
        };
        self.turret |= block.words.iter().any(turret);
        let siemens = |w: &Word| {
            let own = text.slice(w.number()).to_ascii_uppercase();
            [&b"=IC("[..], b"=AC(", b"=DC(", b"=ACP(", b"=ACN(", b"=\""].iter().any(|form| own.starts_with(form))
        };
        self.siemens |= block.across.is_some() || block.words.iter().any(|w| w.value.is_none() && siemens(w));
    }

    /// Units as Siemens controls name them, where the text is certainly one of theirs.
    pub(super) fn units(&self, codes: &mut BTreeSet<u32>, unfollowed: &mut BTreeSet<u32>) -> bool {
        let units: Vec<u32> = codes.iter().copied().filter(|c| self.siemens && unit_of_siemens(*c) != *c).collect();
        for c in units {
            unfollowed.remove(&c);
            codes.insert(unit_of_siemens(c));
        }
        self.siemens
    }

    /// It may be a program of a lathe, on which G90 and G94 may be turning cycles.
    pub(super) fn cycles(&self) -> bool {
        self.words && !self.y
    }

    /// It may be a program of a lathe, whose X words may be diameters and whose feed may be that of a turn.
    ///
    /// Without a Y, G18 as the only plane will do, or a word of lathes; T words of four digits, G97, and G98 or G99 without a cycle to
    /// return from are taken for some where G17 is not there. With a Y (driven tools) it takes both a word of the spindle and a turret.
    pub(super) fn diameters(&self, codes: &BTreeSet<u32>, changes_tools: bool) -> bool {
        let has = |c: u32| codes.contains(&c);
        let turret = self.turret && !changes_tools;
        let across = has(180) && !has(170) && !has(190);
        let feeds = (has(980) || has(990)) && !CANNED.iter().any(|c| has(*c));
        let weak = !has(170) && (turret || has(970) || feeds);
        if self.y { self.spindle && turret } else { self.words || self.spindle || across || weak }
    }
}

/// Signs of a lathe: a limit or a constant cutting speed of the spindle, increments as U and W, a G90 or G94 with places and no motion
/// beside it.
///
/// `lathe = "G96" | "G50" "S" | "U" | "W" | ("G90" | "G94") ("X" | "Z")`
fn turns(block: &Block) -> bool {
    has(block, &[960])
        || has(block, &[500]) && names(block, b"S")
        || names(block, b"UW")
        || has(block, &[900, 940]) && names(block, b"XZ") && !has(block, &[0, 10, 20, 30, 280, 300, 530, 920])
}

/// Whether a block has one of these G words (times ten).
fn has(block: &Block, codes: &[u32]) -> bool {
    block.words.iter().any(|w| w.letter == b'G' && w.value.is_some_and(|v| codes.contains(&code(v.0))))
}
