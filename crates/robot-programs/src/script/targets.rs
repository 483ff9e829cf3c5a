//! The targets of a program in columns: a large program has a million numbers, and most are written like many others.
//!
//! A number keeps its value, its first byte and the index of its *form* (bytes, style, weights of digits): sixteen bytes. Readers push a
//! [`Target`] with all of it; a caller gets a [`TargetRef`], which shows the same.

use super::number::Style;
use super::pose::PoseForm;
use super::step::At;
use super::text::Text;
use std::collections::HashMap;
use std::ops::Range;

/// A target as it is written: joint values, or the numbers of a pose.
#[derive(Debug, Clone, Default)]
pub struct Target {
    /// `None`: joint values, one per axis of the robot. Else the numbers of a pose in this form.
    pub pose: Option<PoseForm>,
    /// Name where it has one: `C00003`, `jHome`, `P[4]`.
    pub name: Option<String>,
    /// Line at which it stands.
    pub at: At,
    /// One per axis of the robot; `None`: this target does not command the axis, it stays where it is.
    pub values: Vec<Option<Value>>,
}

/// A number of a target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// rad or m.
    pub si: f64,
    /// Bytes of the number (sign included) in the target's text.
    pub start: usize,
    /// Byte after the number.
    pub end: usize,
    /// How it is written.
    pub style: Style,
    /// Weight of the last digit as it is written, rad or m.
    pub digit: f64,
    /// The finest weight of a last digit that the format can hold here, rad or m (a pulse; 0.001 deg in a fixed field).
    pub finest: f64,
}

impl Value {
    /// Bytes of the number.
    pub fn span(&self) -> Range<usize> {
        self.start..self.end
    }
}

/// What follows the name of a target in the name of its clone, before a number.
pub const CLONE: &str = "_lm";

/// Whether a target has the name of a clone: a program that was edited has such.
pub fn is_clone(name: &str) -> bool {
    let number = name.rsplit_once(CLONE).map(|(_, number)| number);
    number.is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
}

/// No number, no name.
const NONE: u32 = u32::MAX;

/// Targets, by their index.
#[derive(Debug, Clone, Default)]
pub struct Targets {
    rows: Vec<Row>,
    numbers: Vec<Number>,
    forms: Forms,
    names: String,
}

/// A target without its numbers.
#[derive(Debug, Clone, Copy)]
struct Row {
    line: u32,
    /// First number.
    first: u32,
    name: u32,
    name_len: u32,
    file: u16,
    count: u16,
    pose: Option<PoseForm>,
}

#[derive(Debug, Clone, Copy)]
struct Number {
    si: f64,
    start: u32,
    form: u32,
}

/// What many numbers have in common.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Form {
    digit: f64,
    finest: f64,
    len: u32,
    style: Style,
}

#[derive(Debug, Clone, Default)]
struct Forms {
    all: Vec<Form>,
    index: HashMap<[u64; 4], u32>,
    /// The last form of each bucket: most numbers are written like one before.
    recent: Vec<u32>,
}

const BUCKETS: usize = 256;

impl Forms {
    /// The form's index; `likely`: that of the number in the same place of the target before.
    fn of(&mut self, form: Form, likely: u32) -> u32 {
        let [digit, finest] = [form.digit.to_bits(), form.finest.to_bits()];
        let same = |f: &Form| {
            f.digit.to_bits() == digit && f.finest.to_bits() == finest && f.len == form.len && f.style == form.style
        };
        if self.all.get(likely as usize).is_some_and(same) {
            return likely;
        }
        let mixed = (digit ^ finest.rotate_left(7)) >> 48
            ^ (digit >> 20)
            ^ u64::from(form.len) << 3
            ^ u64::from(form.style.decimals);
        let bucket = mixed as usize % BUCKETS;
        self.recent.resize(BUCKETS, NONE);
        if let Some(&k) = self.recent.get(bucket).filter(|k| self.all.get(**k as usize).is_some_and(same)) {
            return k;
        }
        let Style { decimals, point, bare, plus, exponent } = form.style;
        let flags =
            [point, bare, plus, exponent].iter().fold(u64::from(decimals), |all, flag| all << 1 | u64::from(*flag));
        let next = self.all.len() as u32;
        let k = *self.index.entry([digit, finest, form.len.into(), flags]).or_insert(next);
        if k == next {
            self.all.push(form);
        }
        if let Some(place) = self.recent.get_mut(bucket) {
            *place = k;
        }
        k
    }
}

/// A target as it is written: joint values, or the numbers of a pose.
#[derive(Debug, Clone, Copy)]
pub struct TargetRef<'a> {
    /// `None`: joint values, one per axis of the robot. Else the numbers of a pose in this form.
    pub pose: Option<PoseForm>,
    /// Name where it has one: `C00003`, `jHome`, `P[4]`.
    pub name: Option<&'a str>,
    /// Line at which it stands.
    pub at: At,
    /// One per axis of the robot; `None`: this target does not command the axis, it stays where it is.
    pub values: Values<'a>,
}

/// The numbers of a target.
#[derive(Debug, Clone, Copy, Default)]
pub struct Values<'a> {
    numbers: &'a [Number],
    forms: &'a [Form],
}

impl<'a> Values<'a> {
    /// How many places for numbers there are.
    pub fn len(&self) -> usize {
        self.numbers.len()
    }

    /// No place for a number.
    pub fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }

    /// Number `k`; `None`: it is not given, or there is no such place.
    #[inline]
    pub fn get(&self, k: usize) -> Option<Value> {
        self.value(self.numbers.get(k)?)
    }

    /// All places, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Option<Value>> + Clone + use<'a> {
        let all = *self;
        self.numbers.iter().map(move |n| all.value(n))
    }

    /// Values in SI, NaN where none is given.
    pub fn si_or_nan(&self) -> impl ExactSizeIterator<Item = f64> + use<'a> {
        self.numbers.iter().map(|n| if n.form == NONE { f64::NAN } else { n.si })
    }

    /// Weights of the last digits as they are written, and the finest that the format can hold; rad or m.
    pub fn weights(&self) -> impl ExactSizeIterator<Item = Option<[f64; 2]>> + use<'a> {
        let forms = self.forms;
        self.numbers.iter().map(move |n| forms.get(n.form as usize).map(|form| [form.digit, form.finest]))
    }

    #[inline]
    fn value(&self, n: &Number) -> Option<Value> {
        let form = self.forms.get(n.form as usize)?;
        let start = n.start as usize;
        let end = start + form.len as usize;
        Some(Value { si: n.si, start, end, style: form.style, digit: form.digit, finest: form.finest })
    }
}

impl Targets {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// There is none.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// With memory for the targets of a text.
    pub fn of_text(text: &Text) -> Self {
        let mut all = Self::default();
        all.rows.reserve(text.likely_steps());
        all.numbers.reserve(text.likely_numbers());
        all
    }

    /// Adds a target; its index is the number of those before. Its text is no longer than [`super::lex::LONGEST`].
    pub fn push(&mut self, target: Target) {
        self.push_numbers(target.pose, target.name.as_deref(), target.at, target.values);
    }

    /// The same without a separate list.
    pub fn push_numbers(
        &mut self,
        pose: Option<PoseForm>,
        name: Option<&str>,
        at: At,
        values: impl IntoIterator<Item = Option<Value>>,
    ) {
        let first = self.numbers.len();
        let before = self.rows.last().map_or(first, |row| row.first as usize);
        for (k, value) in values.into_iter().enumerate() {
            let likely = self.numbers.get(before + k).map_or(NONE, |n| n.form);
            let number = self.number(value, likely);
            self.numbers.push(number);
        }
        let [start, len] = name.map_or([NONE, 0], |name| [self.names.len() as u32, name.len() as u32]);
        self.names.push_str(name.unwrap_or_default());
        let count = (self.numbers.len() - first) as u16;
        let (line, first, file) = (at.line as u32, first as u32, at.file as u16);
        self.rows.push(Row { line, first, name: start, name_len: len, file, count, pose });
    }

    #[inline]
    fn number(&mut self, value: Option<Value>, likely: u32) -> Number {
        let Some(v) = value else { return Number { si: 0.0, start: 0, form: NONE } };
        let len = v.end.saturating_sub(v.start) as u32;
        let form = self.forms.of(Form { digit: v.digit, finest: v.finest, len, style: v.style }, likely);
        Number { si: v.si, start: v.start as u32, form }
    }

    /// Gives target `t` another number `k`; nothing where there is no such place.
    pub fn set(&mut self, t: usize, k: usize, value: Option<Value>) {
        let Some(row) = self.rows.get(t).filter(|row| k < usize::from(row.count)) else { return };
        let at = row.first as usize + k;
        let number = self.number(value, NONE);
        if let Some(place) = self.numbers.get_mut(at) {
            *place = number;
        }
    }

    /// A target by its index.
    #[inline]
    pub fn get(&self, t: usize) -> Option<TargetRef<'_>> {
        self.rows.get(t).map(|row| self.shown(row))
    }

    /// The first one.
    pub fn first(&self) -> Option<TargetRef<'_>> {
        self.get(0)
    }

    /// All targets, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = TargetRef<'_>> + Clone {
        self.rows.iter().map(|row| self.shown(row))
    }

    #[inline]
    fn shown(&self, row: &Row) -> TargetRef<'_> {
        let span = |start: u32, len: u32| start as usize..start as usize + len as usize;
        let numbers = self.numbers.get(span(row.first, row.count.into())).unwrap_or_default();
        TargetRef {
            pose: row.pose,
            name: if row.name == NONE { None } else { self.names.get(span(row.name, row.name_len)) },
            at: At { file: row.file.into(), line: row.line.into() },
            values: Values { numbers, forms: &self.forms.all },
        }
    }
}

impl Extend<Target> for Targets {
    fn extend<I: IntoIterator<Item = Target>>(&mut self, all: I) {
        all.into_iter().for_each(|target| self.push(target));
    }
}

impl FromIterator<Target> for Targets {
    fn from_iter<I: IntoIterator<Item = Target>>(all: I) -> Self {
        let mut targets = Self::default();
        targets.extend(all);
        targets
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn value() -> impl Strategy<Value = Option<Value>> {
        let style = (0u8..6, any::<[bool; 4]>()).prop_map(|(decimals, [point, bare, plus, exponent])| Style {
            decimals,
            point,
            bare,
            plus,
            exponent,
        });
        let weight = prop_oneof![Just(1e-3), Just(1e-5), 1e-9..1.0, Just(f64::INFINITY)];
        let one = (-1e4..1e4, 0usize..1_000_000, 0usize..20, style, weight.clone(), weight);
        proptest::option::weighted(0.8, one).prop_map(|v| {
            v.map(|(si, start, len, style, digit, finest)| Value { si, start, end: start + len, style, digit, finest })
        })
    }

    proptest! {
        #[test]
        fn what_is_pushed_comes_back(
            all in proptest::collection::vec((proptest::collection::vec(value(), 0..8), proptest::option::of("[A-Z]{0,5}"), 0usize..3, 1u64..100_000), 0..40)
        ) {
            let mut targets = Targets::default();
            for (values, name, file, line) in &all {
                let at = At { file: *file, line: *line };
                targets.push(Target { pose: None, name: name.clone(), at, values: values.clone() });
            }
            prop_assert_eq!(targets.len(), all.len());
            for (t, (values, name, file, line)) in targets.iter().zip(&all) {
                prop_assert_eq!(t.values.iter().collect::<Vec<_>>(), values.clone());
                prop_assert_eq!((t.name, t.at), (name.as_deref(), At { file: *file, line: *line }));
            }
        }
    }

    #[test]
    fn a_number_can_be_given_later() {
        let mut targets = Targets::default();
        targets.push(Target { values: vec![None, None], ..Target::default() });
        let given = Value { si: 0.5, start: 3, end: 6, style: Style::default(), digit: 0.1, finest: 0.01 };
        targets.set(0, 1, Some(given));
        targets.set(0, 2, Some(given));
        let there = targets.get(0).unwrap();
        assert_eq!((there.values.get(0), there.values.get(1), there.values.get(2)), (None, Some(given), None));
        assert!(there.values.si_or_nan().next().unwrap().is_nan());
    }

    #[test]
    fn a_number_takes_sixteen_bytes() {
        assert!(size_of::<Number>() <= 16 && size_of::<Row>() <= 24);
    }
}
