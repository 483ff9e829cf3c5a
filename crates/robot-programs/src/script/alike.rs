//! Lines that differ in their plain numbers alone: nearly all lines of a large program are of few forms, so that a reader needs to read
//! each form once.
//!
//! Method: a [`Form`] is the text of a line with places for its numbers. A line that has this text, and a plain number in each place, is
//! made of the same words and marks; a reader that comes to it in the state in which it came to the line before finds the same, but for
//! the numbers. Whether it does come in that state a reader has to know: it takes a line for one like others only after it has read two
//! of them in full, one after the other, and has found the same in both.
//!
//! A lexer of statements does not even pass such lines on ([`Passing`]): they are kept beside its tokens, as lines like the statement
//! before them, and who reads that statement reads them with it.
//!
//! A plain number has a sign or none, one to seven digits, and a point with one to seven digits after it or none. Any other (`+5`, `.5`,
//! `1e3`), and whatever else differs, is read in full.

use super::Span;
use super::cursor::line_end;
use super::number::Style;
use crate::decimal::Decimal;
use std::ops::Range;

/// A plain number of a text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plain {
    /// As it is written.
    pub value: f64,
    /// How it is written.
    pub style: Style,
    /// First byte, that of its sign where it has one.
    pub start: usize,
    /// Byte after it.
    pub end: usize,
}

impl Plain {
    /// The number at a byte; `None`: none that is plain.
    #[inline]
    pub fn at(bytes: &[u8], start: usize) -> Option<Self> {
        let (number, end) = Decimal::plain(bytes, start)?;
        let decimals = number.decimals();
        let style = Style { decimals, point: decimals > 0, ..Style::default() };
        Some(Self { value: number.value(), style, start, end })
    }
}

/// The text of a line with places for numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Form {
    /// What stands between the numbers, one piece after the other.
    fixed: Box<[u8]>,
    /// Ends of the pieces in `fixed`: one before each number, and one after the last.
    ends: Box<[u32]>,
    /// The first bytes of each piece.
    heads: Box<[Head]>,
}

/// The first bytes of a piece, as many as fit into a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Head {
    bytes: u64,
    /// Ones where it has bytes.
    mask: u64,
}

impl Head {
    const LEN: usize = size_of::<u64>();

    fn of(piece: &[u8]) -> Self {
        let (mut bytes, mut mask) = ([0; Self::LEN], [0; Self::LEN]);
        for ((byte, mask), own) in bytes.iter_mut().zip(&mut mask).zip(piece) {
            (*byte, *mask) = (*own, u8::MAX);
        }
        Self { bytes: u64::from_le_bytes(bytes), mask: u64::from_le_bytes(mask) }
    }
}

/// A byte beside which a number begins as a separate word.
fn parts_before(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b',' | b'[' | b'(' | b'{' | b'=')
}

/// A byte with which a number has certainly ended.
fn parts_after(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b',' | b']' | b')' | b'}' | b';')
}

impl Form {
    /// Of `span` of a text, with places for the numbers at `numbers`, in order. `None`: one of them is not plain, or does not stand
    /// apart from what is around it.
    pub fn of(bytes: &[u8], span: Range<usize>, numbers: impl IntoIterator<Item = Range<usize>>) -> Option<Self> {
        Self::parted(parts_before, parts_after, bytes, span, numbers)
    }

    /// The same of a line of words, each of them a letter with its number.
    pub fn of_words(bytes: &[u8], span: Range<usize>, numbers: impl IntoIterator<Item = Range<usize>>) -> Option<Self> {
        let letter = |b: u8| b.is_ascii_alphabetic();
        Self::parted(|b| letter(b) || parts_before(b), |b| letter(b) || parts_after(b), bytes, span, numbers)
    }

    fn parted(
        before: impl Fn(u8) -> bool,
        after: impl Fn(u8) -> bool,
        bytes: &[u8],
        span: Range<usize>,
        numbers: impl IntoIterator<Item = Range<usize>>,
    ) -> Option<Self> {
        let (mut fixed, mut ends, mut at) = (Vec::with_capacity(span.len()), Vec::new(), span.start);
        for number in numbers {
            let piece = bytes.get(at..number.start)?;
            let next = if number.end < span.end { bytes.get(number.end).copied() } else { Some(b' ') };
            let apart = piece.last().is_some_and(|b| before(*b)) && next.is_some_and(&after);
            Plain::at(bytes, number.start).filter(|n| apart && n.end == number.end && n.end <= span.end)?;
            fixed.extend_from_slice(piece);
            ends.push(fixed.len() as u32);
            at = number.end;
        }
        fixed.extend_from_slice(bytes.get(at..span.end)?);
        ends.push(fixed.len() as u32);
        let starts = std::iter::once(&0).chain(&ends);
        let heads = starts.zip(&ends).filter_map(|(from, to)| fixed.get(*from as usize..*to as usize)).map(Head::of);
        Some(Self { heads: heads.collect(), fixed: fixed.into(), ends: ends.into() })
    }

    /// How many numbers it has.
    pub fn count(&self) -> usize {
        self.ends.len().saturating_sub(1)
    }

    /// Whether the text from `start` on is of this form: its numbers go to `numbers`, and the byte after it comes back.
    #[inline]
    pub fn read(&self, bytes: &[u8], start: usize, numbers: &mut Vec<Plain>) -> Option<usize> {
        numbers.clear();
        let (mut at, mut from) = (start, 0);
        for (k, (end, head)) in self.ends.iter().zip(&self.heads).enumerate() {
            let length = *end as usize - from;
            let same = match bytes.get(at..).and_then(|rest| rest.first_chunk()) {
                // a call that compares few bytes costs more than they do
                Some(word) if length <= Head::LEN => (u64::from_le_bytes(*word) ^ head.bytes) & head.mask == 0,
                _ => bytes.get(at..at + length)? == self.fixed.get(from..*end as usize)?,
            };
            if !same {
                return None;
            }
            at += length;
            from = *end as usize;
            if k + 1 < self.ends.len() {
                let number = Plain::at(bytes, at)?;
                at = number.end;
                numbers.push(number);
            }
        }
        Some(at)
    }
}

/// How the bytes of a line move to those of another one of its form.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moves {
    from: Anchors,
    to: Anchors,
}

/// Places of a line from which others count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Anchors {
    /// First byte of the line.
    pub start: usize,
    /// First byte of its first number.
    pub first: usize,
    /// Byte after its last number.
    pub last: usize,
}

impl Anchors {
    /// Of a line that begins at `start`; `None`: it has no number.
    pub fn of(start: usize, numbers: &[Plain]) -> Option<Self> {
        Some(Self { start, first: numbers.first()?.start, last: numbers.last()?.end })
    }

    /// Whether the same byte of another line is known: no byte among the numbers is.
    pub fn tell(&self, byte: usize) -> bool {
        byte <= self.first || byte >= self.last
    }

    /// The same for a span.
    pub fn tell_span(&self, span: Span) -> bool {
        self.tell(span.start()) && self.tell(span.end())
    }

    /// From this line to another one of its form.
    pub fn to(self, other: Self) -> Moves {
        Moves { from: self, to: other }
    }
}

impl Moves {
    /// The same byte of the other line.
    pub fn byte(&self, byte: usize) -> usize {
        if byte <= self.from.first {
            byte + self.to.start - self.from.start
        } else {
            byte + self.to.last - self.from.last
        }
    }

    /// The same span of the other line.
    pub fn span(&self, span: Span) -> Span {
        (self.byte(span.start())..self.byte(span.end())).into()
    }
}

/// Lines that a lexer passed over: each is of the form of the line before it, and all lines are whole statements.
#[derive(Debug, Clone)]
pub struct Passed {
    /// Number of tokens before them.
    pub token: usize,
    /// What they have in common.
    pub form: Form,
    /// First bytes of the two lines before them, which are of the same form and have tokens.
    pub models: [usize; 2],
    /// First byte of each of them, one line after the other.
    pub lines: Vec<u32>,
}

impl Passed {
    /// Places of the two lines before them; `numbers` are then those of the second. `None`: a line without numbers.
    pub fn anchors(&self, bytes: &[u8], numbers: &mut Vec<Plain>) -> Option<[Anchors; 2]> {
        let [before, model] = self.models.map(|start| {
            self.form.read(bytes, start, numbers)?;
            Anchors::of(start, numbers)
        });
        Some([before?, model?])
    }
}

/// Finds lines that a lexer may pass over.
#[derive(Debug, Default)]
pub struct Passing {
    /// Form and first byte of the line before, and the first byte of the one before that, where it is of this form.
    last: Option<(Form, usize, Option<usize>)>,
    numbers: Vec<Plain>,
    /// All that were found.
    pub found: Vec<Passed>,
}

impl Passing {
    /// Looks at the lines from the one that begins at `at` on, where a lexer with so many tokens stands: the byte with which it goes on,
    /// after all that can be passed over. `places`: bytes of the numbers of a line in which a statement like others may begin and end.
    pub fn after(
        &mut self,
        bytes: &[u8],
        mut at: usize,
        tokens: usize,
        places: impl Fn(&[u8]) -> Option<Vec<Range<usize>>>,
    ) -> usize {
        while at < bytes.len()
            && let Some(end) = self.passes(bytes, at, tokens)
        {
            at = bytes.len().min(end + 1);
        }
        let end = line_end(bytes, at);
        let places = bytes.get(at..end).and_then(places);
        let form = places.and_then(|all| Form::of(bytes, at..end, all.into_iter().map(|n| n.start + at..n.end + at)));
        self.last = form.map(|form| {
            let before = self.last.take().filter(|(last, ..)| *last == form).map(|(_, at, _)| at);
            (form, at, before)
        });
        at
    }

    /// The byte after a line that is passed over, its line feed left out.
    fn passes(&mut self, bytes: &[u8], at: usize, tokens: usize) -> Option<usize> {
        let (form, model, before) = self.last.as_ref()?;
        let models = [(*before)?, *model];
        let end = form.read(bytes, at, &mut self.numbers).filter(|end| bytes.get(*end).is_none_or(|b| *b == b'\n'))?;
        match self.found.last_mut().filter(|p| p.token == tokens) {
            Some(passed) => passed.lines.push(at as u32),
            None => self.found.push(Passed { token: tokens, form: form.clone(), models, lines: vec![at as u32] }),
        }
        Some(end)
    }
}

/// The elements of the list that stands open at a byte of a line, blanks around them left out.
pub fn elements(line: &[u8], open: usize) -> Option<Vec<Range<usize>>> {
    let inner = line.get(open..)?;
    let inner = inner.get(..memchr::memchr2(b']', b'[', inner).filter(|k| inner.get(*k) == Some(&b']'))?)?;
    let mut at = open;
    let element = |part: &[u8]| {
        let from = at + part.iter().take_while(|b| **b == b' ').count();
        at += part.len() + 1;
        from..from + part.trim_ascii().len()
    };
    Some(inner.split(|b| *b == b',').map(element).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::script::number;
    use proptest::prelude::*;

    /// The form of a line whose numbers stand between `<` and `>`.
    fn form(marked: &str) -> (String, Option<Form>) {
        let (mut text, mut numbers, mut start) = (String::new(), Vec::new(), 0);
        for c in marked.chars() {
            match c {
                '<' => start = text.len(),
                '>' => numbers.push(start..text.len()),
                c => text.push(c),
            }
        }
        let length = text.len();
        // what stands after a line: a number is read a word at a time
        text.push_str("\n         ");
        let found = Form::of(text.as_bytes(), 0..length, numbers);
        (text, found)
    }

    fn reads(form: &Form, line: &str) -> Option<Vec<f64>> {
        let (text, mut numbers) = (format!("{line}\n         "), Vec::new());
        let end = form.read(text.as_bytes(), 0, &mut numbers)?;
        (end == line.len()).then(|| numbers.iter().map(|n| n.value).collect())
    }

    #[test]
    fn a_line_is_of_a_form_where_only_plain_numbers_differ() {
        let (_, found) = form("PTP {A1 <5.25>,A2 <-90>} C_PTP");
        let found = found.unwrap();
        assert_eq!(found.count(), 2);
        assert_eq!(reads(&found, "PTP {A1 -1234.5,A2 0} C_PTP"), Some(vec![-1234.5, 0.0]));
        for other in [
            "PTP {A1 5.25,A2 -90} C_DIS",
            "PTP {A1 5.25,A3 -90} C_PTP",
            "PTP {A1 +5.25,A2 -90} C_PTP",
            "PTP {A1 .25,A2 -90} C_PTP",
            "PTP {A1 5.,A2 -90} C_PTP",
            "PTP {A1 5.25E1,A2 -90} C_PTP",
            "PTP {A1 5.25,A2 - 90} C_PTP",
            "PTP {A1 5.25,A2 -90 } C_PTP",
            "PTP {A1 5.25,A2 12345678} C_PTP",
            "PTP {A1 5.25,A2 -90} C_PTP ; slow",
            "PTP {A1 5.25,A2 --90} C_PTP",
            "PTP {A1 ,A2 -90} C_PTP",
            "PTP {A1 5.25,A2 ",
        ] {
            assert_eq!(reads(&found, other), None, "{other}");
        }
    }

    #[test]
    fn numbers_that_touch_a_word_or_are_not_plain_have_no_form() {
        for line in ["X<5>", "P[<1>]x<2>", "A <5>e", "A <1.5E3>", "A <+5>", "A <.5>", "A <5>.2", "<5>"] {
            assert_eq!(form(line).1, None, "{line}");
        }
        assert!(form("A <5>").1.is_some() && form("[<5>,<-6.5>];").1.is_some());
    }

    proptest! {
        /// What a form reads of a number is what the readers of numbers read of it.
        #[test]
        fn a_plain_number_is_the_number_that_stands_there(text in "-?[0-9]{1,7}(\\.[0-9]{1,7})?") {
            let (_, form) = form("J <1>,");
            let line = format!("J {text},");
            let padded = format!("{line}\n         ");
            let mut numbers = Vec::new();
            let end = form.unwrap().read(padded.as_bytes(), 0, &mut numbers);
            let (value, style) = number::read(text.as_bytes()).unwrap();
            prop_assert_eq!(end, Some(line.len()));
            prop_assert_eq!(numbers[0].value.to_bits(), value.to_bits());
            prop_assert_eq!(numbers[0].style, style);
            prop_assert_eq!((numbers[0].start, numbers[0].end), (2, 2 + text.len()));
        }
    }
}
