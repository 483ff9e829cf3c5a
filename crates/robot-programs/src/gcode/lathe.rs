//! Lathes: what shows that a program is one of a lathe, and how its X words count.
//!
//! X of a lathe is mostly a diameter: the axis moves by half of what a word says. R, I, J and K of an arc stay radii. Fanuc, Series 16/18
//! for lathe, operator's manual B-62754EN/01, table 9.4(a). Which it is, a parameter of the control says (Fanuc 1006#3), or words: G7 and G8
//! (LinuxCNC), DIAMON, DIAMOF and DIAM90 (Siemens). Assumes that programs without a word of lathes, and those with Y moves, have the places
//! of the axis.
//!
//! G98 and G99 are feeds per minute and per turn on lathes, and levels of return on mills.

use super::codes::{CANNED, code};
use super::lex::{Block, Word};
use super::read::Reader;
use super::reason::{After, Elsewhere};
use super::survey::{has_axes, names};
use crate::axes::JointKind;
use crate::script::cursor::Cursor;
use crate::script::{Break, Text};
use std::collections::BTreeSet;

/// What an X word counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Across {
    /// The place of the axis.
    Radius,
    /// Twice that.
    Diameter,
    /// Twice that in absolute words, and the way of the axis in relative ones.
    AbsoluteDiameter,
}

impl Across {
    pub(super) fn of_control(diameter: bool) -> Self {
        if diameter { Self::Diameter } else { Self::Radius }
    }

    /// The word with which a text begins, and its length.
    ///
    /// `across = "DIAMON" | "DIAMOF" | "DIAM90"`
    pub(super) fn of_word(text: &[u8]) -> Option<(Self, usize)> {
        let mut cursor = Cursor::new(text);
        cursor.while_is(|b| b.is_ascii_alphanumeric() || b == b'_');
        let word = cursor.since(0);
        let known = [
            (&b"DIAMON"[..], Self::Diameter),
            (&b"DIAMOF"[..], Self::Radius),
            (&b"DIAM90"[..], Self::AbsoluteDiameter),
        ];
        let (_, across) = known.into_iter().find(|(name, _)| word.eq_ignore_ascii_case(name))?;
        // `DIAMON[X2]`: of another axis
        (cursor.peek() != Some(b'[')).then_some((across, word.len()))
    }

    /// G7 and G8 with nothing beside them that would make them other words: `G7 X0` and `G8 P1` are those of Fanuc controls.
    pub(super) fn of_g_word(block: &Block, c: u32) -> Option<Self> {
        let other = has_axes(block) || names(block, b"P");
        match c {
            70 if !other => Some(Self::Diameter),
            80 if !other => Some(Self::Radius),
            _ => None,
        }
    }

    /// Way of the axis by one unit of a word; `absolute`: G90.
    fn factor(self, absolute: Option<bool>) -> f64 {
        match self {
            Self::Radius => 1.0,
            Self::Diameter => 0.5,
            Self::AbsoluteDiameter => {
                if absolute == Some(false) {
                    1.0
                } else {
                    0.5
                }
            }
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
    }

    /// It may be a program of a lathe, on which G90 and G94 may be turning cycles.
    pub(super) fn cycles(&self) -> bool {
        self.words && !self.y
    }

    /// It may be a program of a lathe, whose X words may be diameters and whose feed may be that of a turn.
    ///
    /// Without a Y, G18 as the only plane will do, or a word of lathes; T words of four digits, G97, and G98 or G99 without a cycle to return
    /// from are taken for some where G17 is not there. With a Y (driven tools) it takes both a word of the spindle and a turret.
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

impl Reader<'_> {
    /// Way of an axis, in mm, by one mm of its word.
    pub(super) fn across_factor(&self, axis: usize) -> f64 {
        if self.is_across(axis) { self.across.map_or(1.0, |across| across.factor(self.absolute)) } else { 1.0 }
    }

    /// X of a lathe.
    pub(super) fn is_across(&self, axis: usize) -> bool {
        self.letters.get(axis) == Some(&b'X') && self.robot.axis(axis).kind == JointKind::Prismatic
    }

    /// X words count otherwise from here on.
    pub(super) fn count_across(&mut self, k: usize, across: Across) {
        if self.across.is_some_and(|before| before != across) {
            self.end(k, Break::Frame, After::Across);
        }
        self.across = Some(across);
    }

    /// A block whose X may be a diameter or the place of the axis: it stays, and where its axes come to is not known. `false`: it is none.
    pub(super) fn leaves_across(&mut self, k: usize, block: &Block) -> bool {
        if self.across.is_some() || !(0..self.letters.len()).any(|a| self.is_across(a)) {
            return false;
        }
        let arc = matches!(self.motion, Some(20 | 30)) && self.plane.is_some_and(|[u, v, _]| [u, v].contains(&b'X'));
        if !arc && !names(block, b"X") {
            return false;
        }
        self.script.diameter_unstated = true;
        let straight = matches!(self.motion, Some(0 | 10)) && self.absolute == Some(true);
        let axes = self.axes_named(block).filter(|_| straight);
        self.goes_elsewhere(k, axes, Elsewhere::Across);
        true
    }

    /// G98 and G99 of a lathe: feed per minute and per turn. Beside G95 they may be levels of return.
    pub(super) fn feed_of_lathe(&mut self, c: u32) {
        let per_minute = c == 980 && !self.survey.codes.contains(&950);
        self.feed_mode = if per_minute { 94 } else { 95 };
        self.feed = None;
    }

    /// G92 with a feed cuts a thread on lathes.
    pub(super) fn cuts_thread(&self, block: &Block, c: u32) -> bool {
        c == 920 && self.survey.diameters && has_axes(block) && names(block, b"F")
    }

    /// Control may come from elsewhere: what words of the text may have changed is not certain.
    pub(super) fn join_lathe(&mut self) {
        if self.survey.across.iter().any(|other| Some(*other) != self.across) {
            self.across = None;
        }
        if self.survey.diameters && !self.survey.single(&[940, 950, 980, 990]) {
            self.feed_mode = 95;
        }
    }

    /// The state of X words and of the feed in which a control begins the program.
    pub(super) fn begin_lathe(&mut self) {
        let unstated = if self.survey.diameters { None } else { Some(Across::Radius) };
        self.across = self.robot.control.diameter.map(Across::of_control).or(unstated);
        if self.survey.diameters {
            // feeds of a turn are usual there
            self.feed_mode = 95;
        }
    }
}
