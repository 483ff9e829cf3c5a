//! Yaskawa INFORM jobs (`.JBI`): positions by number in a list, instructions that name them.
//!
//! ```text
//! ///NPOS 2,0,0,0,0,0                          counts of C, BC, EC, P, BP, EX lines
//! ///POSTYPE PULSE                             what the numbers of the lines below are; may switch again
//! C00000=-49439,115900,90850,0,-52300,1200     S, L, U, R, B, T in pulses of the controller
//! MOVL C00000 V=50.0 PL=0                      a straight TCP path to joint values
//! ```
//!
//! Method: the list is read with the headers in force at each line (`///TOOL`, `///POSTYPE`, ...); instructions are read line by
//! line. A move names a C line and, with base or station axes, BC and EC lines: together they are its target. Pulses become
//! radians or metres by [`crate::axes::Axis::pulses`].
//!
//! References: Yaskawa, INFORM manuals and "Data transmission function", job data format (public editions for NX100); public
//! jobs of DX200 cells. Assumes `V=` in mm/s where it has decimals, and the factory's position levels (12.5 mm for `PL=1`, twice
//! that for each further one up to 4).
//!
//! Fails with file, line and column where counts and lines disagree, a number is none, a position is not in the list, `END`
//! is missing, or the robot file has no pulses for a joint. `docs/program-inform.md` has what may be edited.
//!
//! Modules: [`list`] positions and headers; [`read`] instructions; [`flow`] jumps, blocks and calls; [`shared`] which position variables
//! are certain; [`movement`] moves and their goals; [`circles`] arcs through three positions; [`write`] edits to patches.

mod circles;
mod flow;
mod list;
mod movement;
mod read;
mod shared;
#[cfg(test)]
mod tests;
mod write;

use super::files::Folders;
use super::script::blocks::BySteps;
use super::script::{Document, Edits, Format, Patches, Script, Span, Text};
use crate::axes::Axes;
use crate::error::Result;
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The format.
pub struct Inform;

impl Format for Inform {
    fn name(&self) -> &'static str {
        "inform"
    }

    fn title(&self) -> &'static str {
        "Yaskawa INFORM (.JBI)"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["jbi"]
    }

    fn recognises(&self, bytes: &[u8]) -> bool {
        let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
        let line = bytes.split(|&b| b == b'\n').map(<[u8]>::trim_ascii).find(|l| !l.is_empty());
        line.is_some_and(|l| l.eq_ignore_ascii_case(b"/JOB"))
    }

    fn context(&self, path: &Path, seen: &Folders) -> Vec<PathBuf> {
        shared::files(path, seen)
    }

    fn minds_unread(&self) -> bool {
        true
    }

    fn parse(&self, texts: Vec<Text>, robot: &Axes) -> Result<Box<dyn Document>> {
        Ok(Box::new(read::job(texts, robot)?))
    }
}

/// What some editors put before UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Kinds of positions, in the order of `///NPOS`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    C,
    Bc,
    Ec,
    P,
    Bp,
    Ex,
}

const KINDS: [(Kind, &str); 6] =
    [(Kind::C, "C"), (Kind::Bc, "BC"), (Kind::Ec, "EC"), (Kind::P, "P"), (Kind::Bp, "BP"), (Kind::Ex, "EX")];

impl Kind {
    fn word(self) -> &'static str {
        KINDS[self as usize].1
    }

    /// `EC00012`: kind, number, digits of the number.
    ///
    /// `position = ("C" | "BC" | "EC" | "P" | "BP" | "EX") digit {digit}`, at most six digits
    fn read(word: &[u8]) -> Option<(Self, u32, usize)> {
        let letters = word.iter().take_while(|b| b.is_ascii_alphabetic()).count();
        let (name, digits) = word.split_at(letters);
        let kind = KINDS.iter().find(|k| name.eq_ignore_ascii_case(k.1.as_bytes()))?.0;
        if digits.is_empty() || digits.len() > 6 || !digits.iter().all(u8::is_ascii_digit) {
            return None;
        }
        let number = std::str::from_utf8(digits).ok()?.parse().ok()?;
        Some((kind, number, digits.len()))
    }
}

/// What the numbers of a position are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
enum Meaning {
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
struct Section {
    meaning: Meaning,
    user: Option<u32>,
    tool: Option<u32>,
    postype: Option<u32>,
    /// `///PULSE`, `///ANGLE`, `///RECTAN`.
    form: Option<u32>,
    rconf: Option<u32>,
}

impl Section {
    /// A header on which a position of this section depends, which was not given before it and is in force at the end of its
    /// kind: a copy there would mean something else, as no line takes a header back.
    fn lacks(&self, end: &Self) -> Option<&'static str> {
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
fn ends(positions: &[Position]) -> BTreeMap<Kind, Section> {
    positions.iter().map(|p| (p.kind, p.section)).collect()
}

/// A line of the list.
#[derive(Debug, Clone)]
struct Position {
    kind: Kind,
    number: u32,
    digits: usize,
    /// Line from 0.
    line: usize,
    section: Section,
    /// Bytes of its numbers.
    numbers: Box<[Span]>,
}

/// A position's name in an instruction.
#[derive(Debug, Clone)]
struct Reference {
    /// Index into [`Job::positions`].
    position: u32,
    span: Span,
}

impl Reference {
    /// Index into [`Job::positions`].
    fn position(&self) -> usize {
        self.position as usize
    }
}

/// A word with `=` of a move: `PL=0`.
#[derive(Debug, Clone)]
struct Tag {
    /// Before the `=`, upper case.
    key: &'static str,
    span: Span,
}

/// What is needed to write a move again.
#[derive(Debug, Clone, Default)]
struct Statement {
    /// Bytes of the line before the first word.
    indent: Span,
    /// The instruction's word.
    word: Span,
    references: Box<[Reference]>,
    /// Words that a copy takes along, in order.
    tags: Box<[Tag]>,
}

/// A number of a target: which position line, which of its numbers.
type Number = (u32, u32);

/// By axis: where the number of a target's axis stands.
#[derive(Debug)]
enum Numbers {
    /// On one line, the first so many of its numbers.
    Line(u32, u16),
    Each(Box<[Number]>),
}

impl Numbers {
    fn of_line(position: usize, count: u16) -> Self {
        Self::Line(position as u32, count)
    }

    fn of(numbers: &[Number]) -> Self {
        match numbers.first() {
            Some(&(line, 0)) if numbers.iter().zip(0..).all(|(n, k)| *n == (line, k)) => {
                Self::Line(line, numbers.len() as u16)
            }
            _ => Self::Each(numbers.into()),
        }
    }

    fn iter(&self) -> impl Iterator<Item = Number> {
        let (line, count, each) = match self {
            Self::Line(line, count) => (*line, *count, &[][..]),
            Self::Each(each) => (0, 0, &**each),
        };
        (0..u32::from(count)).map(move |k| (line, k)).chain(each.iter().copied())
    }
}

/// Targets by the positions that make them, nearly always one alone.
#[derive(Debug, Default)]
struct Known {
    single: HashMap<u32, u32>,
    several: BTreeMap<Vec<usize>, usize>,
}

impl Known {
    fn get(&self, positions: &[usize]) -> Option<usize> {
        match positions {
            [one] => self.single.get(&(*one as u32)).map(|t| *t as usize),
            _ => self.several.get(positions).copied(),
        }
    }

    fn insert(&mut self, positions: Vec<usize>, target: usize) {
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
struct Job {
    script: Script,
    positions: Vec<Position>,
    /// Bytes of the numbers of `///NPOS`.
    counts: Vec<Range<usize>>,
    /// By step; moves whose target can be written have one.
    statements: BySteps<Statement>,
    /// By target, then axis: where the axis' number stands.
    numbers: Vec<Numbers>,
    /// Positions that something else than a move of the first group uses.
    pinned: Vec<bool>,
    /// By axis: pulses per rad or m.
    pulses: Vec<Option<f64>>,
    /// By axis: edge unit to SI.
    unit: Vec<f64>,
}

impl Document for Job {
    fn script(&self) -> &Script {
        &self.script
    }

    fn patches(&self, edits: &Edits) -> Result<Patches> {
        write::patches(self, edits)
    }

    fn unwritable(&self, edits: &Edits) -> Vec<(usize, String)> {
        write::unwritable(self, edits)
    }
}
