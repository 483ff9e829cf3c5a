//! What is known of a job that has been read: its positions with the headers in force, its moves, and where the numbers of their targets
//! stand.

use crate::script::blocks::BySteps;
use crate::script::cursor::integer;
use crate::script::{Script, Span};
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

/// Decimals of lengths in a Cartesian position, mm.
pub(super) const LENGTH_DECIMALS: u8 = 3;

/// Decimals that an ANGLE job, and the angles of a Cartesian position, keep.
pub(super) const ANGLE_DECIMALS: u8 = 4;

/// Kinds of positions, in the order of `///NPOS`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    C,
    Bc,
    Ec,
    P,
    Bp,
    Ex,
}

pub(super) const KINDS: [(Kind, &str); 6] =
    [(Kind::C, "C"), (Kind::Bc, "BC"), (Kind::Ec, "EC"), (Kind::P, "P"), (Kind::Bp, "BP"), (Kind::Ex, "EX")];

impl Kind {
    pub(super) fn word(self) -> &'static str {
        KINDS[self as usize].1
    }

    /// `EC00012`: kind, number, digits of the number.
    ///
    /// `position = ("C" | "BC" | "EC" | "P" | "BP" | "EX") digit {digit}`, at most six digits
    pub(super) fn read(word: &[u8]) -> Option<(Self, u32, usize)> {
        let letters = word.iter().take_while(|b| b.is_ascii_alphabetic()).count();
        let (name, digits) = word.split_at(letters);
        let kind = KINDS.iter().find(|k| name.eq_ignore_ascii_case(k.1.as_bytes()))?.0;
        let number = integer(digits).filter(|_| digits.len() <= 6)?;
        Some((kind, number, digits.len()))
    }
}

/// What the numbers of a position are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum Meaning {
    /// No `///POSTYPE` so far.
    #[default]
    Unknown,
    Pulse,
    Angle,
    Base,
    Robot,
    User,
    /// `TOOL`, `MTOOL` and what else there may be.
    Other,
}

/// The headers in force at a position line: the lines (from 0) on which they stand.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Section {
    pub(super) meaning: Meaning,
    pub(super) user: Option<u32>,
    pub(super) tool: Option<u32>,
    pub(super) postype: Option<u32>,
    /// `///PULSE`, `///ANGLE`, `///RECTAN`.
    pub(super) form: Option<u32>,
    pub(super) rconf: Option<u32>,
}

impl Section {
    /// A header on which a position of this section depends, which was not given before it and is in force at the end of its
    /// kind: a copy there would mean something else, as no line takes a header back.
    pub(super) fn lacks(&self, end: &Self) -> Option<&'static str> {
        let joints = matches!(self.meaning, Meaning::Pulse | Meaning::Angle);
        let lacking = |own: Option<u32>, there: Option<u32>| own.is_none() && there.is_some();
        if lacking(self.tool, end.tool) {
            Some("///TOOL")
        } else if self.meaning == Meaning::User && lacking(self.user, end.user) {
            Some("///USER")
        } else if !joints && lacking(self.rconf, end.rconf) {
            Some("///RCONF")
        } else if lacking(self.postype, end.postype) {
            Some("///POSTYPE")
        } else {
            None
        }
    }
}

/// The headers in force at the last position of each kind, where new positions of this kind go.
pub(super) fn ends(positions: &[Position]) -> BTreeMap<Kind, Section> {
    positions.iter().map(|p| (p.kind, p.section)).collect()
}

/// A line of the list.
#[derive(Debug, Clone)]
pub(super) struct Position {
    pub(super) kind: Kind,
    pub(super) number: u32,
    pub(super) digits: usize,
    /// Line from 0.
    pub(super) line: usize,
    pub(super) section: Section,
    /// Bytes of its numbers.
    pub(super) numbers: Box<[Span]>,
}

/// A position's name in an instruction.
#[derive(Debug, Clone)]
pub(super) struct Reference {
    /// Index into [`Job::positions`].
    pub(super) position: u32,
    pub(super) span: Span,
}

impl Reference {
    /// Index into [`Job::positions`].
    pub(super) fn position(&self) -> usize {
        self.position as usize
    }
}

/// A word with `=` of a move: `PL=0`.
#[derive(Debug, Clone)]
pub(super) struct Tag {
    /// Before the `=`, upper case.
    pub(super) key: &'static str,
    pub(super) span: Span,
}

/// What is needed to write a move again.
#[derive(Debug, Clone, Default)]
pub(super) struct Statement {
    /// Bytes of the line before the first word.
    pub(super) indent: Span,
    /// The instruction's word.
    pub(super) word: Span,
    pub(super) references: Box<[Reference]>,
    /// Words that a copy takes along, in order.
    pub(super) tags: Box<[Tag]>,
}

/// A number of a target: which position line, which of its numbers.
pub(super) type Number = (u32, u32);

/// By axis: where the number of a target's axis stands.
#[derive(Debug)]
pub(super) enum Numbers {
    /// On one line, the first so many of its numbers.
    Line(u32, u16),
    Each(Box<[Number]>),
}

impl Numbers {
    pub(super) fn of_line(position: usize, count: u16) -> Self {
        Self::Line(position as u32, count)
    }

    pub(super) fn of(numbers: &[Number]) -> Self {
        match numbers.first() {
            Some(&(line, 0)) if numbers.iter().zip(0..).all(|(n, k)| *n == (line, k)) => {
                Self::Line(line, numbers.len() as u16)
            }
            _ => Self::Each(numbers.into()),
        }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = Number> {
        let (line, count, each) = match self {
            Self::Line(line, count) => (*line, *count, &[][..]),
            Self::Each(each) => (0, 0, &**each),
        };
        (0..u32::from(count)).map(move |k| (line, k)).chain(each.iter().copied())
    }
}

/// Targets by the positions that make them, nearly always one alone.
#[derive(Debug, Default)]
pub(super) struct Known {
    pub(super) single: HashMap<u32, u32>,
    pub(super) several: BTreeMap<Vec<usize>, usize>,
}

impl Known {
    pub(super) fn get(&self, positions: &[usize]) -> Option<usize> {
        match positions {
            [one] => self.single.get(&(*one as u32)).map(|t| *t as usize),
            _ => self.several.get(positions).copied(),
        }
    }

    pub(super) fn insert(&mut self, positions: Vec<usize>, target: usize) {
        match positions[..] {
            [one] => {
                self.single.insert(one as u32, target as u32);
            }
            _ => {
                self.several.insert(positions, target);
            }
        }
    }
}

/// A job that has been read.
pub(super) struct Job {
    pub(super) script: Script,
    pub(super) positions: Vec<Position>,
    /// Bytes of the numbers of `///NPOS`.
    pub(super) counts: Vec<Range<usize>>,
    /// By step; moves whose target can be written have one.
    pub(super) statements: BySteps<Statement>,
    /// By target, then axis: where the axis' number stands.
    pub(super) numbers: Vec<Numbers>,
    /// Positions that something else than a move of the first group uses.
    pub(super) pinned: Vec<bool>,
    /// By axis: pulses per rad or m.
    pub(super) pulses: Vec<Option<f64>>,
    /// By axis: edge unit to SI.
    pub(super) unit: Vec<f64>,
}
