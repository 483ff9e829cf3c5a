//! Lines that a look over the text passes, as they are like one that it has read.

use super::codes::AXES;
use super::lex::Word;
use crate::script::Text;
use crate::script::alike::{Form, Plain};
use std::ops::Range;

/// Bytes of a line, its ending left out.
pub(super) fn span(text: &Text, k: usize) -> Range<usize> {
    let start = text.line_span(k).start;
    start..start + text.line(k).len()
}

/// Whether the numbers in which a block differs from others are those of this word.
pub(super) fn varies(letter: u8) -> bool {
    letter == b'N' || AXES.contains(&letter)
}

/// How numbers are written.
pub(super) struct Written {
    /// One other than 0 has no point.
    pub(super) bare: bool,
    /// One has a point.
    pub(super) pointed: bool,
}

/// Lines of a text that are like one that a look over it has passed.
#[derive(Default)]
pub(super) struct Passed {
    form: Option<Form>,
    /// For each number of the form whether it is that of a place.
    places: Vec<bool>,
    numbers: Vec<Plain>,
}

impl Passed {
    /// How the numbers of places in line `k` are written, where it is like the one that was noted last, so that nothing else is new.
    pub(super) fn again(&mut self, text: &Text, k: usize) -> Option<Written> {
        let span = span(text, k);
        let read = self.form.as_ref().and_then(|form| form.read(&text.bytes, span.start, &mut self.numbers));
        read.filter(|end| *end == span.end)?;
        let places = || self.numbers.iter().zip(&self.places).filter(|(_, place)| **place).map(|(n, _)| n);
        let (bare, pointed) = (|n: &Plain| !n.style.point && n.value != 0.0, |n: &Plain| n.style.point);
        Some(Written { bare: places().any(bare), pointed: places().any(pointed) })
    }

    /// Notes a line of words of which nothing is new but its numbers.
    pub(super) fn note(&mut self, text: &Text, k: usize, words: &[Word]) {
        let varying = || words.iter().filter(|w| varies(w.letter));
        self.form = Form::of_words(&text.bytes, span(text, k), varying().map(|w| w.number()));
        self.places.clear();
        self.places.extend(varying().map(|w| AXES.contains(&w.letter)));
    }
}
