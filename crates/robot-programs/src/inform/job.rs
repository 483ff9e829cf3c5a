//! What is known of a job that has been read: its positions with the headers in force, its moves, and where the numbers of their targets
//! stand.

use crate::script::blocks::BySteps;
use crate::script::cursor::integer;
use crate::script::{Script, Span, Text};
use std::collections::BTreeMap;
use std::ops::{Deref, Range};
use std::sync::Arc;

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
    let (mut all, mut last): (_, Option<&Position>) = (BTreeMap::new(), None);
    for p in positions {
        if !last.is_some_and(|last| last.kind == p.kind && Arc::ptr_eq(&last.section, &p.section)) {
            all.insert(p.kind, *p.section);
        }
        last = Some(p);
    }
    all
}

/// A line of the list.
#[derive(Debug, Clone)]
pub(super) struct Position {
    pub(super) kind: Kind,
    /// Digits of its number.
    pub(super) digits: u8,
    pub(super) number: u32,
    /// Line from 0.
    pub(super) line: u32,
    /// Those that follow each other mostly share it.
    pub(super) section: Arc<Section>,
    numbers: Span,
}

impl Position {
    /// Line from 0.
    pub(super) fn line(&self) -> usize {
        self.line as usize
    }

    /// `C00012`.
    pub(super) fn name(&self) -> String {
        let digits = usize::from(self.digits);
        format!("{}{:0digits$}", self.kind.word(), self.number)
    }
}

/// The lines of the list, and the bytes of their numbers one after the other.
#[derive(Debug, Default)]
pub(super) struct Positions {
    all: Vec<Position>,
    numbers: Vec<Span>,
}

impl Positions {
    /// With memory for those of a text.
    pub(super) fn of_text(text: &Text) -> Self {
        Self { all: Vec::with_capacity(text.line_count()), numbers: Vec::with_capacity(text.likely_numbers()) }
    }

    /// Adds a line: kind, number and its digits, place (from 0), headers, bytes of its numbers.
    pub(super) fn push(
        &mut self,
        (kind, number, digits): (Kind, u32, usize),
        line: usize,
        section: &Arc<Section>,
        numbers: impl IntoIterator<Item = Range<usize>>,
    ) {
        let first = self.numbers.len();
        self.numbers.extend(numbers.into_iter().map(Span::from));
        let numbers = (first..self.numbers.len()).into();
        let (digits, line) = (digits as u8, line as u32);
        self.all.push(Position { kind, digits, number, line, section: section.clone(), numbers });
    }

    /// Bytes of the numbers of a line.
    pub(super) fn numbers(&self, position: usize) -> &[Span] {
        self.all.get(position).and_then(|p| self.numbers.get(p.numbers.range())).unwrap_or_default()
    }
}

impl Deref for Positions {
    type Target = [Position];

    fn deref(&self) -> &[Position] {
        &self.all
    }
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

/// Words of a move that a copy of it takes along.
const COPIED: &[&str] = &["VJ", "V", "VR", "VE", "PL", "CR", "ACC", "DEC"];

/// A word with `=` of a move that a copy takes along: `PL=0`.
#[derive(Debug, Clone)]
pub(super) struct Tag {
    /// Index into [`COPIED`].
    key: u8,
    pub(super) span: Span,
}

impl Tag {
    /// `None`: a copy does not take it along; `key`: in upper case.
    pub(super) fn new(key: &str, span: Range<usize>) -> Option<Self> {
        let key = COPIED.iter().position(|c| *c == key)?;
        Some(Self { key: key as u8, span: span.into() })
    }

    /// The same elsewhere.
    pub(super) fn at(&self, span: Span) -> Self {
        Self { key: self.key, span }
    }

    /// Before the `=`, upper case.
    pub(super) fn key(&self) -> &'static str {
        COPIED.get(usize::from(self.key)).copied().unwrap_or_default()
    }
}

/// What is needed to write a move again.
#[derive(Debug, Clone, Default)]
pub(super) struct Statement {
    /// Bytes of the line before the first word.
    pub(super) indent: Span,
    /// The instruction's word.
    pub(super) word: Span,
    /// Which of [`Parts::references`] are its.
    references: Span,
    /// Which of [`Parts::tags`].
    tags: Span,
}

/// Parts of all statements, one after the other.
#[derive(Debug, Default)]
pub(super) struct Parts {
    references: Vec<Reference>,
    tags: Vec<Tag>,
}

impl Parts {
    /// With memory for those of a text.
    pub(super) fn of_text(text: &Text) -> Self {
        let moves = text.likely_steps();
        Self { references: Vec::with_capacity(moves), tags: Vec::with_capacity(2 * moves) }
    }

    /// A statement with its parts.
    pub(super) fn statement(
        &mut self,
        [indent, word]: [Span; 2],
        references: Vec<Reference>,
        tags: Vec<Tag>,
    ) -> Statement {
        let (reference, tag) = (self.references.len(), self.tags.len());
        self.references.extend(references);
        self.tags.extend(tags);
        let (references, tags) = (reference..self.references.len(), tag..self.tags.len());
        Statement { indent, word, references: references.into(), tags: tags.into() }
    }

    /// The positions that a statement names.
    pub(super) fn references(&self, of: &Statement) -> &[Reference] {
        self.references.get(of.references.range()).unwrap_or_default()
    }

    /// Words that a copy of a statement takes along, in order.
    pub(super) fn tags(&self, of: &Statement) -> &[Tag] {
        self.tags.get(of.tags.range()).unwrap_or_default()
    }

    /// Whether any statement has this word.
    pub(super) fn has_tag(&self, key: &str) -> bool {
        self.tags.iter().any(|t| t.key() == key)
    }
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

/// No target.
const NONE: u32 = u32::MAX;

/// Targets by the positions that make them, nearly always one alone.
#[derive(Debug, Default)]
pub(super) struct Known {
    /// By position; [`NONE`]: none.
    single: Vec<u32>,
    several: BTreeMap<Vec<usize>, usize>,
}

impl Known {
    pub(super) fn get(&self, positions: &[usize]) -> Option<usize> {
        match positions {
            [one] => self.single.get(*one).filter(|t| **t != NONE).map(|t| *t as usize),
            _ => self.several.get(positions).copied(),
        }
    }

    pub(super) fn insert_one(&mut self, position: usize, target: usize) {
        if position >= self.single.len() {
            self.single.resize(position + 1, NONE);
        }
        if let Some(place) = self.single.get_mut(position) {
            *place = target as u32;
        }
    }

    pub(super) fn insert(&mut self, positions: Vec<usize>, target: usize) {
        match positions[..] {
            [one] => self.insert_one(one, target),
            _ => {
                self.several.insert(positions, target);
            }
        }
    }
}

/// A job that has been read.
pub(super) struct Job {
    pub(super) script: Script,
    pub(super) positions: Positions,
    /// Bytes of the numbers of `///NPOS`.
    pub(super) counts: Vec<Range<usize>>,
    /// By step; moves whose target can be written have one.
    pub(super) statements: BySteps<Statement>,
    pub(super) parts: Parts,
    /// By target, then axis: where the axis' number stands.
    pub(super) numbers: Vec<Numbers>,
    /// Positions that something else than a move of the first group uses.
    pub(super) pinned: Vec<bool>,
    /// By axis: pulses per rad or m.
    pub(super) pulses: Vec<Option<f64>>,
    /// By axis: edge unit to SI.
    pub(super) unit: Vec<f64>,
}
