//! A program that has been read, with what it takes to write its moves, in little memory: the words of a block are taken from its line
//! when they are asked for.

use super::arc::{Arc, Centre};
use super::codes::code;
use super::lex::{self, Word};
use crate::axes::JointKind;
use crate::script::blocks::BySteps;
use crate::script::{Script, Text};
use std::collections::BTreeMap;
use std::sync::Arc as Shared;

/// A program that has been read.
pub(super) struct Program {
    pub(super) script: Script,
    pub(super) statements: Statements,
    /// By axis: letter of its word.
    pub(super) letters: Vec<u8>,
    /// By axis: edge unit to SI.
    pub(super) si: Vec<f64>,
    /// Numbers with and without a point stand in it: the line that says how the latter are to be read.
    pub(super) marker: Option<usize>,
    pub(super) waits: Waits,
}

/// The words of dwells, as they stand in the text, by the step of the move before them.
#[derive(Debug, Default)]
pub(super) struct Waits(pub(super) BTreeMap<usize, String>);

/// Most decimals that a changed number gets, by unit: controls keep 10 nm or less, and 1e-5 deg.
const MOST_MM: u8 = 5;
const MOST_INCH: u8 = 6;
const MOST_DEG: u8 = 5;

/// Most decimals that a changed word of an axis gets.
pub(super) fn most(kind: JointKind, unit: f64) -> u8 {
    match kind {
        JointKind::Revolute => MOST_DEG,
        JointKind::Prismatic if unit > 1.0 => MOST_INCH,
        JointKind::Prismatic => MOST_MM,
    }
}

/// A length or angle without the noise of sums: the same place has the same number, however it was reached.
pub(super) fn canonical(x: f64) -> f64 {
    let rounded = (x * 1e9).round() / 1e9;
    if rounded == 0.0 { 0.0 } else { rounded }
}

/// What is needed to write a move again. Lengths in mm, angles in degrees.
#[derive(Debug, Clone)]
pub(super) struct Statement {
    pub line: usize,
    pub words: Vec<Word>,
    /// Words hold values that do not stand in the line: those of its expressions.
    pub folded: bool,
    /// 0 to 3.
    pub motion: u8,
    /// Its word in the block.
    pub motion_word: Option<usize>,
    pub absolute: bool,
    /// By axis: word of the block.
    pub axis_words: Vec<Option<u32>>,
    /// By axis: mm or deg of one unit of a word.
    pub unit: Shared<[f64]>,
    /// By axis: what is added to an absolute word.
    pub shift: Shared<[f64]>,
    /// By axis, before and after the move; `None`: not known.
    pub start: Vec<Option<f64>>,
    pub goal: Vec<Option<f64>>,
    pub arc: Option<(Arc, Centre)>,
}

/// The word of the block that names each axis: the last one that has a value.
pub(super) fn axis_words(words: &[Word], letters: &[u8]) -> Vec<Option<u32>> {
    let word = |letter: &u8| words.iter().rposition(|w| w.letter == *letter && w.value.is_some()).map(|i| i as u32);
    letters.iter().map(word).collect()
}

/// The word of a motion (times ten) in its block.
pub(super) fn motion_word(words: &[Word], motion: u32) -> Option<usize> {
    words.iter().position(|w| w.letter == b'G' && w.value.is_some_and(|v| code(v.0) == motion))
}

impl Statement {
    /// The word of an axis.
    pub fn axis_word(&self, axis: usize) -> Option<&Word> {
        self.words.get((*self.axis_words.get(axis)?)? as usize)
    }

    /// Words that a copy takes along besides axes, motion and centre: G words and F.
    pub fn copied(&self, letter: u8) -> impl Iterator<Item = &Word> {
        let motion = |w: &Word| w.value.is_some_and(|v| matches!(code(v.0), 0 | 10 | 20 | 30));
        self.words.iter().filter(move |w| w.letter == letter && !(letter == b'G' && motion(w)))
    }

    /// mm of one unit of the words of an arc's centre and radius in the plane of two axes: those words are never diameters.
    pub fn arc_unit(&self, [u, v]: [usize; 2]) -> f64 {
        self.unit[u].max(self.unit[v])
    }

    /// Place at a share of an arc, mm or deg by axis: on the arc in its plane, straight in the others.
    pub fn on_arc(&self, arc: &Arc, share: f64) -> Vec<f64> {
        on_arc(&self.start, &self.goal, arc, share)
    }
}

fn on_arc(start: &[Option<f64>], goal: &[Option<f64>], arc: &Arc, share: f64) -> Vec<f64> {
    let on = arc.at(share);
    let axis = |a: usize| match (start[a], goal[a]) {
        _ if a == arc.u => on[0],
        _ if a == arc.v => on[1],
        (Some(from), Some(to)) => from + share * (to - from),
        (_, to) => to.unwrap_or(0.0),
    };
    (0..goal.len()).map(axis).collect()
}

/// The statements of a program, by step; moves that lead to a known place have one.
#[derive(Debug, Default)]
pub(super) struct Statements {
    kept: BySteps<PackedStatement>,
    /// Rows of places, NaN: not known.
    places: Vec<f64>,
    /// Units and shifts.
    frames: Vec<[Shared<[f64]>; 2]>,
    rest: Vec<Rest>,
}

/// Where a statement leads, by axis; mm or deg, NaN: not known.
pub(super) struct Places<'a> {
    pub start: &'a [f64],
    pub goal: &'a [f64],
    /// As in [`Statement`].
    pub unit: &'a [f64],
    pub shift: &'a [f64],
    pub absolute: bool,
    /// It is no arc, and all of its words stand in its line.
    pub plain: bool,
}

/// Nothing else than what all statements have.
const NONE: u32 = u32::MAX;

#[derive(Debug)]
struct PackedStatement {
    line: u32,
    /// First number of its rows in the places.
    start: u32,
    goal: u32,
    frame: u32,
    motion: u8,
    absolute: bool,
    /// What nearly no statement has: an arc, or words that are not those of its line; [`NONE`]: it has neither.
    rest: u32,
}

#[derive(Debug)]
struct Rest {
    arc: Option<(Arc, Centre)>,
    words: Option<Vec<Word>>,
}

impl Statements {
    /// With memory for those of a text.
    pub fn of_text(text: &Text, axes: usize) -> Self {
        let places = Vec::with_capacity(text.likely_steps() * axes.min(3));
        Self { kept: BySteps::of_text(text), places, ..Self::default() }
    }

    /// Adds the statement of a step after those that have one.
    pub fn push(&mut self, step: usize, s: Statement) {
        let start = self.row(&s.start);
        let goal = self.row(&s.goal);
        let same = |f: &[Shared<[f64]>; 2]| Shared::ptr_eq(&f[0], &s.unit) && Shared::ptr_eq(&f[1], &s.shift);
        if !self.frames.last().is_some_and(same) {
            self.frames.push([s.unit, s.shift]);
        }
        let mut rest = NONE;
        if s.arc.is_some() || s.folded {
            rest = self.rest.len() as u32;
            self.rest.push(Rest { arc: s.arc, words: s.folded.then_some(s.words) });
        }
        let frame = self.frames.len() as u32 - 1;
        let kept =
            PackedStatement { line: s.line as u32, start, goal, frame, motion: s.motion, absolute: s.absolute, rest };
        self.kept.push(step, kept);
    }

    /// Adds the statement of a step that is a straight move like the last one, in line `line`.
    pub fn push_like_last(&mut self, step: usize, line: usize, start: &[Option<f64>], goal: &[Option<f64>]) {
        let Some(&PackedStatement { frame, motion, absolute, .. }) = self.kept.last() else { return };
        let (start, goal) = (self.row(start), self.row(goal));
        self.kept.push(step, PackedStatement { line: line as u32, start, goal, frame, motion, absolute, rest: NONE });
    }

    /// A row of places; where it is the last one, that.
    fn row(&mut self, places: &[Option<f64>]) -> u32 {
        let last = self.places.len().saturating_sub(places.len());
        let there = self.places.get(last..).unwrap_or_default().iter();
        let same = |(there, own): (&f64, &Option<f64>)| own.unwrap_or(f64::NAN).to_bits() == there.to_bits();
        if there.len() == places.len() && there.zip(places).all(same) {
            return last as u32;
        }
        let first = self.places.len() as u32;
        self.places.extend(places.iter().map(|p| p.unwrap_or(f64::NAN)));
        first
    }

    fn places(&self, first: u32, count: usize) -> Vec<Option<f64>> {
        let row = self.places.get(first as usize..first as usize + count).unwrap_or_default();
        row.iter().map(|v| Some(*v).filter(|v| !v.is_nan())).collect()
    }

    /// The places of a statement as they are kept, without its words.
    pub fn places_of(&self, step: usize, axes: usize) -> Option<Places<'_>> {
        let kept = self.kept.get(step)?;
        let row = |first: u32| self.places.get(first as usize..first as usize + axes);
        let [unit, shift] = self.frames.get(kept.frame as usize)?;
        let (absolute, plain) = (kept.absolute, kept.rest == NONE);
        Some(Places { start: row(kept.start)?, goal: row(kept.goal)?, unit, shift, absolute, plain })
    }

    /// The statement of a step; `letters`: the words of the axes.
    pub fn get(&self, step: usize, text: &Text, letters: &[u8]) -> Option<Statement> {
        let kept = self.kept.get(step)?;
        let [unit, shift] = self.frames.get(kept.frame as usize)?;
        let line = kept.line as usize;
        let own = self.rest.get(kept.rest as usize).and_then(|r| r.words.clone());
        let folded = own.is_some();
        // a line that was read can be read again
        let words = own.unwrap_or_else(|| lex::block(text, line).map(|b| b.words).unwrap_or_default());
        Some(Statement {
            line,
            folded,
            motion: kept.motion,
            motion_word: motion_word(&words, u32::from(kept.motion) * 10),
            absolute: kept.absolute,
            axis_words: axis_words(&words, letters),
            unit: Shared::clone(unit),
            shift: Shared::clone(shift),
            start: self.places(kept.start, letters.len()),
            goal: self.places(kept.goal, letters.len()),
            arc: self.arc(step),
            words,
        })
    }

    fn arc(&self, step: usize) -> Option<(Arc, Centre)> {
        self.rest.get(self.kept.get(step)?.rest as usize)?.arc
    }

    /// Place at a share of the arc of a step, mm or deg by axis; `None`: it is none.
    pub fn on_arc(&self, step: usize, axes: usize, share: f64) -> Option<Vec<f64>> {
        let (arc, _) = self.arc(step)?;
        let kept = self.kept.get(step)?;
        Some(on_arc(&self.places(kept.start, axes), &self.places(kept.goal, axes), &arc, share))
    }

    /// The arcs of all statements.
    #[cfg(test)]
    pub fn arcs(&self) -> Vec<(Arc, Centre)> {
        self.rest.iter().filter_map(|r| r.arc).collect()
    }
}
