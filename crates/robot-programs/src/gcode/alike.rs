//! Blocks that follow one another and differ in their numbers alone are read once ([`alike`](crate::script::alike)).
//!
//! A straight move to places in words, in absolute words, leaves the modes as they are: two such blocks one after the other, read in full
//! and found to go in the same way, show that nothing else is in them. What else a block does, and every block after a line of another
//! kind, is left to the full reader.

use super::passed::{span, varies};
use super::read::Reader;
use super::statements::{Statement, canonical, most};
use crate::script::alike::{Form, Plain};
use crate::script::{At, Goal, StepKind, Value};

/// Words of a block that is compared with others, at most.
const MOST: usize = 8;

/// The straight move that was read last.
#[derive(Default)]
pub(super) struct Alike {
    /// Letters of its words.
    letters: [u8; MOST],
    form: Option<Form>,
    /// For each number of the form its axis; `None`: the number of the block.
    axes: Vec<Option<usize>>,
    line: usize,
    /// Its step.
    step: usize,
    /// The one before it was of the same form, and both were read in full.
    sure: bool,
    numbers: Vec<Plain>,
}

impl Alike {
    /// Looks at a straight move that was read in full, and is the last step.
    pub(super) fn learn(&mut self, reader: &Reader, s: &Statement, step: usize) {
        let mut letters = [0; MOST];
        let plain = s.absolute && !s.folded && s.arc.is_none() && s.words.len() <= MOST;
        if !plain {
            self.letters = letters;
            return;
        }
        letters.iter_mut().zip(&s.words).for_each(|(place, w)| *place = w.letter);
        let text = reader.text;
        let follows = self.letters == letters && self.line + 1 == s.line && self.step + 1 == step;
        let span = span(text, s.line);
        let same =
            |form: &Form, numbers: &mut Vec<Plain>| form.read(&text.bytes, span.start, numbers) == Some(span.end);
        let goes_alike = || match (reader.script.steps.get(self.step), reader.script.steps.get(step)) {
            (Some(a), Some(b)) => match (&a.kind, &b.kind) {
                (StepKind::Move(a), StepKind::Move(b)) => a.shares_how(b) && a.way.is_empty() && b.way.is_empty(),
                _ => false,
            },
            _ => false,
        };
        self.sure = follows && goes_alike() && self.form.as_ref().is_some_and(|f| same(f, &mut self.numbers));
        if !self.sure {
            let words = || s.words.iter().filter(|w| varies(w.letter));
            self.form =
                follows.then(|| Form::of_words(&text.bytes, span.clone(), words().map(|w| w.number()))).flatten();
            self.axes.clear();
            self.axes.extend(words().map(|w| reader.letters.iter().position(|l| *l == w.letter)));
        }
        (self.letters, self.line, self.step) = (letters, s.line, step);
    }
}

impl Reader<'_> {
    /// Reads line `k` where it is like the one before it; `false`: it is not, and nothing was done.
    pub(super) fn again(&mut self, k: usize) -> bool {
        if !self.alike.sure || self.alike.line + 1 != k {
            return false;
        }
        let mut alike = std::mem::take(&mut self.alike);
        let done = self.reads(&mut alike, k).is_some();
        self.alike = alike;
        done
    }

    fn reads(&mut self, alike: &mut Alike, k: usize) -> Option<()> {
        let (text, span) = (self.text, span(self.text, k));
        let form = alike.form.as_ref()?;
        form.read(&text.bytes, span.start, &mut alike.numbers).filter(|end| *end == span.end)?;
        let axes = || alike.numbers.iter().zip(&alike.axes);
        // a number without a point may count increments, and a number of the block may be jumped to
        let counts = self.survey.may_count();
        let plain = axes().all(|(n, axis)| match axis {
            Some(_) => n.style.point || !counts || n.value == 0.0,
            None => !self.survey.is_label(n.value),
        });
        let far = |(n, axis): (&Plain, &Option<usize>)| {
            axis.is_some_and(|a| canonical(self.shifts[a] + n.value * self.units[a]).abs() >= 1e7)
        };
        let over = |(n, axis): (&Plain, &Option<usize>)| {
            let to = |a: usize| self.shifts[a] + n.value * self.units[a];
            axis.is_some_and(|a| self.position[a].is_some_and(|from| self.may_roll_over(a, from, to(a))))
        };
        let step = self.script.steps.len();
        if !plain || step != alike.step + 1 || axes().any(far) || axes().any(over) {
            return None;
        }
        let StepKind::Move(m) = &self.script.steps.last()?.kind else { return None };
        let kind = StepKind::Move(m.alike(Goal::Joints(self.script.targets.len())));
        let start = self.position.clone();
        for (n, axis) in alike.numbers.iter().zip(&alike.axes) {
            if let Some(a) = *axis {
                self.position[a] = Some(canonical(self.shifts[a] + n.value * self.units[a]));
                self.digit[a] = self.weight(a, self.units[a], n.style.decimals);
            }
        }
        let value = |a: usize| {
            let n = alike.numbers.iter().zip(&alike.axes).rev().find(|(_, axis)| **axis == Some(a))?.0;
            let kind = self.robot.axis(a).kind;
            let unit = self.units[a];
            Some(Value {
                si: self.position[a]? * kind.si_per_user_unit(),
                start: n.start,
                end: n.end,
                style: n.style,
                digit: self.digit[a],
                finest: self.weight(a, unit, n.style.decimals.max(most(kind, unit))),
            })
        };
        let at = At::of_line(k);
        let values: Vec<Option<Value>> = (0..self.letters.len()).map(value).collect();
        self.script.targets.push_numbers(None, None, at, values);
        self.statements.push_like_last(step, k, &start, &self.position);
        (self.last, self.settled) = (Some(step), false);
        self.step(k, kind, None);
        (alike.line, alike.step) = (k, step);
        Some(())
    }
}
