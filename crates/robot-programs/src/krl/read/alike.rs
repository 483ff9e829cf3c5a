//! Motions that follow one another and differ in their axis values alone are read once ([`alike`](crate::script::alike)).
//!
//! A motion in line with axis values leaves the reader as it found it, but for a TRIGGER before it, which it takes: two of them one after
//! the other, read in full and found to go in the same way, show that it does. Folds, splines, comments, and what leads the robot away by
//! its line, are left to the full reader.

use super::Reader;
use crate::krl::aggregate::axis_value;
use crate::krl::lex::{Kind, Token};
use crate::krl::motion::Motion;
use crate::krl::program::Source;
use crate::krl::relative::Stands;
use crate::krl::target::Site;
use crate::script::alike::{Anchors, Form, Moves, Plain};
use crate::script::{At, Goal, StepKind, Value};

/// The form of the motion that was read last.
#[derive(Default)]
pub(super) struct Alike {
    last: Option<Known>,
    numbers: Vec<Plain>,
}

struct Known {
    form: Form,
    /// By axis, which of the numbers of the form is its own.
    numbers: Vec<Option<usize>>,
    motion: Motion,
    at: Anchors,
    /// Its step.
    step: usize,
    /// The one before it was of the same form, and both were read in full.
    sure: bool,
}

/// How far a reader was before a line.
pub(super) struct Before {
    steps: usize,
    targets: usize,
}

impl Alike {
    pub(super) fn before(&self, reader: &Reader) -> Before {
        Before { steps: reader.steps.next(), targets: reader.targets.len() }
    }

    /// Looks at a line that was read in full.
    pub(super) fn learn(&mut self, reader: &Reader, k: usize, line: &[Token], before: Before) {
        let last = self.last.take();
        let Some(mut known) = known(reader, k, line, &before) else { return };
        known.sure = last.is_some_and(|last| {
            let of = |step: usize| match reader.steps.get(step).map(|s| &s.kind) {
                Some(StepKind::Move(m)) => Some(m),
                _ => None,
            };
            let goes_alike = of(last.step).zip(of(known.step)).is_some_and(|(a, b)| a.shares_how(b));
            let same = last.step + 1 == known.step && last.form == known.form && last.numbers == known.numbers;
            same && goes_alike && last.moved(k, last.at.to(known.at)) == known.motion
        });
        self.last = Some(known);
    }

    /// Reads line `k` where it is like the one before it; `false`: it is not, and nothing was done.
    pub(super) fn again(&mut self, reader: &mut Reader, k: usize) -> bool {
        let Some(known) = self.last.as_mut().filter(|known| known.sure) else { return false };
        let text = reader.text;
        let line = text.line_span(k);
        let start = line.start;
        let read = known.form.read(&text.bytes, start, &mut self.numbers);
        if !read.is_some_and(|end| matches!(text.slice(end..line.end), b"\n" | b"\r\n" | b"\r" | b"")) {
            return false;
        }
        let Some(StepKind::Move(m)) = reader.steps.last().map(|s| &s.kind) else { return false };
        let (Some(place), Some(at)) = (reader.steps.last_place(), Anchors::of(start, &self.numbers)) else {
            return false;
        };
        let others = place.others;
        let exact = m.blend_m == Some(0.0);
        let step = StepKind::Move(m.alike(Goal::Joints(reader.targets.len())));
        reader.stands = exact.then(|| Stands::Target(reader.targets.len()));
        let motion = known.moved(k, known.at.to(at));
        let numbers = &self.numbers;
        let value = |(n, (_, kind)): (&Option<usize>, &(_, _))| {
            let number = numbers.get((*n)?)?;
            Some(axis_value(*kind, number.value, number.style, number.start..number.end))
        };
        let at = At::of_line(k);
        reader.targets.push_numbers(None, None, at, known.numbers.iter().zip(reader.axes).map(value));
        reader.sources.push(Source::Inline(0, motion.goal));
        reader.steps.place(reader.steps.next(), Site { motion: Some(motion), others });
        known.step = reader.steps.push(at, step);
        true
    }
}

impl Known {
    /// The motion of a line of the same form.
    fn moved(&self, k: usize, by: Moves) -> Motion {
        let m = &self.motion;
        let [keyword, goal, point, tail] = [m.keyword, m.goal, m.point, m.tail].map(|span| by.span(span));
        Motion { line: k as u32, keyword, goal, point, tail, ..m.clone() }
    }
}

/// The form of a line that is one motion with axis values in it, and nothing else.
fn known(reader: &Reader, k: usize, line: &[Token], before: &Before) -> Option<Known> {
    let text = reader.text;
    let plain = reader.folds.is_empty() && !reader.spline && reader.led.is_empty();
    let one = reader.steps.next() == before.steps + 1 && reader.targets.len() == before.targets + 1;
    if !plain || !one || line.iter().any(|t| t.kind == Kind::Comment) {
        return None;
    }
    let StepKind::Move(m) = &reader.steps.last()?.kind else { return None };
    let Goal::Joints(target) = m.goal else { return None };
    let motion = reader.steps.last_place()?.motion.clone()?;
    let inline = matches!(reader.sources.last()?, Source::Inline(0, span) if *span == motion.goal);
    if target != before.targets || !inline || motion.via.is_some() || motion.fold.is_some() || !m.way.is_empty() {
        return None;
    }
    let values = reader.targets.get(target)?.values;
    let mut given: Vec<(usize, Value)> = values.iter().enumerate().filter_map(|(axis, v)| Some((axis, v?))).collect();
    given.sort_by_key(|(_, v)| v.start);
    let start = text.line_span(k).start;
    let span = start..start + text.line(k).len();
    let form = Form::of(&text.bytes, span, given.iter().map(|(_, v)| v.span()))?;
    let at = Anchors { start, first: given.first()?.1.start, last: given.last()?.1.end };
    if ![motion.keyword, motion.goal, motion.point, motion.tail].iter().all(|span| at.tell_span(*span)) {
        return None;
    }
    let numbers = (0..values.len()).map(|axis| given.iter().position(|(of, _)| *of == axis)).collect();
    Some(Known { form, numbers, motion, at, step: before.steps, sure: false })
}
