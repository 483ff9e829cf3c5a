//! Aggregates, the values in braces: `{E6AXIS: A1 -50.70,A2 -90.0}` read into its components, and those as axes, as a Cartesian
//! target, as a frame.

use super::folded::folded;
use super::lex::{Kind, Token};
use super::reason::Reason;
use crate::axes::JointKind;
use crate::decimal::POW10;
use crate::error::Result;
use crate::script::lex::text_of;
use crate::script::number::{Style, last_digit};
use crate::script::pose::{Configuration, Frame};
use crate::script::{OfAxis, PathKind, PoseForm, PoseGoal, Solution, Span, Text, Value, number};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use std::ops::Range;
use std::sync::Arc;

/// Bytes, value and style of a plain number.
pub(super) type Plain = (Span, f64, number::Style);

/// `A1 -50.70`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Component<'a> {
    /// Upper case.
    pub name: &'a Label,
    /// `None`: it is computed.
    pub value: Option<&'a Plain>,
}

/// The name of a component: short ones, which all are, need no separate memory.
#[derive(Debug, Clone, PartialEq, Eq)]
#[allow(clippy::box_collection)] // eight bytes, where a string has twenty-four
pub(super) enum Label {
    Short([u8; 8]),
    Long(Box<String>),
}

impl Label {
    /// Of a word, in upper case.
    fn of(word: &[u8]) -> Self {
        let mut short = [0; 8];
        match short.get_mut(..word.len()) {
            Some(place) if word.is_ascii() => {
                place.copy_from_slice(word);
                short.make_ascii_uppercase();
                Self::Short(short)
            }
            _ => Self::Long(Box::new(text_of(word).to_ascii_uppercase())),
        }
    }

    pub fn as_str(&self) -> &str {
        match self {
            Self::Short(bytes) => {
                let len = bytes.iter().take_while(|b| **b != 0).count();
                bytes.get(..len).and_then(|b| std::str::from_utf8(b).ok()).unwrap_or_default()
            }
            Self::Long(text) => text,
        }
    }

    /// One letter of these.
    fn is_one_of(&self, letters: &[u8]) -> bool {
        match self {
            Self::Short([letter, 0, ..]) => letters.contains(letter),
            Self::Short(_) => false,
            Self::Long(text) => matches!(text.as_bytes(), [letter] if letters.contains(letter)),
        }
    }

    /// The name of an axis, as [`axis_name`] tells it.
    ///
    /// `axis = ("A" | "E") ("1" | "2" | "3" | "4" | "5" | "6")`
    fn is_axis(&self) -> bool {
        match self {
            Self::Short(bytes) => matches!(bytes, [b'A' | b'E', b'1'..=b'6', 0, ..]),
            Self::Long(text) => axis_name(text),
        }
    }

    fn is(&self, name: &str) -> bool {
        match self {
            Self::Short(bytes) => bytes.starts_with(name.as_bytes()) && bytes.get(name.len()).is_none_or(|b| *b == 0),
            Self::Long(text) => text.as_str() == name,
        }
    }
}

/// `{E6AXIS: A1 -50.70,A2 ...}`.
#[derive(Debug, Clone)]
pub(super) struct Aggregate {
    pub file: usize,
    /// Braces included.
    pub span: Span,
    /// Names of its components; those of aggregates after each other are mostly the same.
    names: Arc<[Label]>,
    values: Box<[Option<Plain>]>,
}

impl Aggregate {
    /// In the order of the text.
    pub fn components(&self) -> impl Iterator<Item = Component<'_>> {
        self.names.iter().zip(&self.values).map(|(name, value)| Component { name, value: value.as_ref() })
    }

    pub fn component(&self, name: &str) -> Option<Component<'_>> {
        self.components().find(|c| c.name.is(name))
    }

    /// Has the names of another one in common with it, where they are the same.
    pub fn share_names(&mut self, other: &Self) {
        if self.names == other.names {
            self.names = Arc::clone(&other.names);
        }
    }

    /// Whether it gives axes; external axes alone also stand beside a Cartesian position.
    pub fn has_axes(&self) -> bool {
        let cartesian = self.names.iter().any(|name| name.is_one_of(b"XYZABC"));
        let axes = self.names.iter().filter(|n| n.is_axis());
        axes.map(Label::as_str).any(|n| !(cartesian && n.starts_with('E')))
    }

    /// The Cartesian target in a frame and with a tool; `target`: index of its numbers, where they can be written. On straight
    /// paths the controller does not look at status and turn. Without angles it keeps the orientation of the position before; with one or
    /// two of them, or one that is computed, its orientation is not known.
    pub fn pose(
        &self,
        frame: &Frame,
        tool: &Frame,
        path: PathKind,
        target: Option<usize>,
        own: &[(String, JointKind)],
    ) -> Option<PoseGoal> {
        let of = |name: &str| self.component(name).and_then(|c| c.value).map(|v| v.1);
        let position_m = Vector3::new(of("X")?, of("Y")?, of("Z")?) * 1e-3;
        // turns about Z, then the new Y, then the new X
        let rotation = match ["A", "B", "C"].map(|name| self.component(name)) {
            [None, None, None] => None,
            _ => {
                let [a, b, c] = [of("A")?, of("B")?, of("C")?].map(f64::to_radians);
                Some(UnitQuaternion::from_euler_angles(c, b, a))
            }
        };
        let placed = self.placed(own);
        let external = |c: &Component| {
            let name = c.name.as_str();
            let foreign = axis_name(name) && name.starts_with('E') && own.iter().all(|o| o.0 != name);
            foreign && c.value.is_none_or(|v| v.1 != 0.0)
        };
        let carried: Option<Vec<(String, f64)>> =
            self.components().filter(external).map(|c| Some((c.name.as_str().to_string(), c.value?.1))).collect();
        // bits beyond the sixth are those of external axes; status has bits beyond the third of no arm
        let bits = |name: &str, mask: u32| match self.component(name) {
            None => Ok(None),
            Some(_) => of(name).filter(|v| *v >= 0.0 && *v < 65536.0).map(|v| Some((v as u32 & mask) as u8)).ok_or(()),
        };
        let (status, turn) = (bits("S", 7), bits("T", 63));
        let joint = path == PathKind::Joint;
        let unread = joint && (status.is_err() || turn.is_err());
        let (status, turn) = (status.ok().flatten(), turn.ok().flatten());
        let solution = match (status, turn) {
            (None, None) => Solution::Same,
            (status, turn) => Solution::Configured(Configuration::Kuka { status, turn }),
        };
        let frame = match (carried.filter(|_| placed.is_some()), unread) {
            (None, _) => Frame::unclear(Reason::CarrierComputed),
            (_, true) => Frame::unclear(Reason::ConfigurationComputed),
            (Some(axes), false) => frame.clone().carried("$NULLFRAME", &axes),
        };
        let tool = tool.clone();
        let placed = placed.unwrap_or_default().into_iter().map(|(axis, v)| OfAxis { axis, si: v.si });
        let external = Some(placed.collect::<Box<[OfAxis]>>()).filter(|all| !all.is_empty());
        let binding = joint;
        Some(PoseGoal { target, position_m, rotation, frame, tool, solution, binding, external, ..PoseGoal::default() })
    }

    /// External axes of the robot beside a Cartesian position, with their numbers; `None`: one is computed. `own`: the robot's axes.
    fn placed(&self, own: &[(String, JointKind)]) -> Option<Vec<(usize, Value)>> {
        let external = own.iter().enumerate().filter(|(_, o)| o.0.starts_with('E'));
        let given = external.filter_map(|(axis, (name, kind))| Some((axis, *kind, self.component(name)?)));
        let number = |(axis, kind, c): (usize, JointKind, Component)| {
            let &(span, value, style) = c.value?;
            Some((axis, axis_value(kind, value, style, span.range())))
        };
        given.map(number).collect()
    }

    /// All that a Cartesian target can have changed: the numbers of its pose, then those of the robot's external axes; `None`: one is
    /// missing or computed.
    pub fn numbers(&self, own: &[(String, JointKind)]) -> Option<Vec<Option<Value>>> {
        let mut all = self.coordinates()?;
        all.extend(self.placed(own)?.into_iter().map(|(_, v)| Some(v)));
        Some(all)
    }

    /// The numbers of a Cartesian target; `None`: one is missing or computed.
    pub fn coordinates(&self) -> Option<Vec<Option<Value>>> {
        let form = PoseForm::EulerZyx;
        let value = |(k, name): (usize, &&str)| {
            let &(span, value, style) = self.component(name)?.value?;
            let (unit, digit) = (form.unit(k), number::last_digit(style.decimals));
            let finest = finest(value).min(digit) * unit;
            let (start, end) = (span.start(), span.end());
            Some(Some(Value { si: value * unit, start, end, style, digit: digit * unit, finest }))
        };
        ["X", "Y", "Z", "A", "B", "C"].iter().enumerate().map(value).collect()
    }

    /// Why it is no Cartesian target; `of`: the point, `None`: the goal itself.
    pub fn incomplete(&self, of: Option<&str>) -> Reason {
        let of = of.map(Box::from);
        let computed =
            |names: [&'static str; 3]| names.into_iter().find(|n| self.component(n).is_some_and(|c| c.value.is_none()));
        match computed(["X", "Y", "Z"]).or_else(|| computed(["A", "B", "C"]).filter(|_| !self.lacks_parts())) {
            Some(part) => Reason::PartComputed { part, of },
            None => Reason::PartMissing(of),
        }
    }

    /// Whether it is a Cartesian position without some of its six parts, which stay where the robot stands.
    pub fn lacks_parts(&self) -> bool {
        let given = ["X", "Y", "Z", "A", "B", "C"].iter().filter(|n| self.component(n).is_some()).count();
        !self.has_axes() && (1..6).contains(&given)
    }

    /// The frame that the numbers are.
    pub fn isometry(&self) -> Option<Isometry3<f64>> {
        let numbers: Vec<f64> = self.coordinates()?.iter().flatten().map(|v| v.si).collect();
        PoseForm::EulerZyx.pose(&numbers)
    }

    /// Axes that are external, or none of the robot's.
    fn foreign(&self, own: &[String]) -> impl Iterator<Item = Component<'_>> {
        self.components().filter(|c| c.name.is_axis() && !own.iter().any(|o| c.name.is(o)))
    }

    /// Whether its [`Self::others`] certainly are those that are known.
    pub fn has_others(&self, own: &[String], text: &Text, known: &[(String, Vec<u8>)]) -> bool {
        let mut known = known.iter();
        let next = |c: Component| {
            let (name, value) = (c.name, c.value.map(|v| text.slice(v.0)));
            known.next().is_some_and(|k| name.is(&k.0) && value.is_some_and(|value| value == k.1))
        };
        self.foreign(own).all(next) && known.next().is_none()
    }

    /// Values of external axes and of axes that are none of the robot's, for comparison.
    pub fn others(&self, own: &[String], text: &Text) -> Vec<(String, Vec<u8>)> {
        let others = self.foreign(own);
        let value = |c: Component| c.value.map_or(b"?".to_vec(), |v| text.slice(v.0).to_vec());
        let mut out: Vec<_> = others.map(|c| (c.name.as_str().to_string(), value(c))).collect();
        out.sort();
        out
    }
}

/// A number of an axis.
#[inline]
pub(super) fn axis_value(kind: JointKind, value: f64, style: Style, span: Range<usize>) -> Value {
    let (unit, digit) = (kind.si_per_user_unit(), last_digit(style.decimals));
    Value {
        si: value * unit,
        start: span.start,
        end: span.end,
        style,
        digit: digit * unit,
        finest: finest(value).min(digit) * unit,
    }
}

/// Weight of the seventh digit: KRL holds numbers in single precision. Values below 1 are taken as 1.
#[inline]
pub(super) fn finest(value: f64) -> f64 {
    // most values: powers of ten are exact, as their logarithms are
    match below_seventh(value) {
        Some(decimals) => last_digit(decimals),
        None => 10_f64.powi(value.abs().log10().floor() as i32 - 6),
    }
}

/// Digits after the point up to the seventh digit.
pub(super) fn most_decimals(value: f64) -> u8 {
    below_seventh(value).unwrap_or(0)
}

/// The same; `None`: the seventh digit stands before the point.
#[inline]
fn below_seventh(value: f64) -> Option<u8> {
    let whole = POW10.iter().take(7).take_while(|p| value.abs() >= **p).count();
    (whole < 7).then(|| 6 - whole.saturating_sub(1) as u8)
}

/// A1 to A6, E1 to E6.
///
/// `axis = ("A" | "E") ("1" | "2" | "3" | "4" | "5" | "6")`
pub(super) fn axis_name(name: &str) -> bool {
    matches!(name.as_bytes(), [b'A' | b'E', b'1'..=b'6'])
}

/// No aggregate of KRL has as many components.
const MOST: usize = 64;

/// An aggregate whose brace is `tokens[k]`; the token after it.
///
/// `aggregate = "{" [type ":"] [component] {"," [component]} "}"`,
/// `component = name (literal | bits | expression)`
pub(super) fn aggregate(text: &Text, file: usize, tokens: &[Token], k: usize) -> Result<(Aggregate, usize)> {
    let open = tokens.get(k).map_or(0, |t| t.start);
    let unclosed = || text.bad(open, "`{` without `}` on its line", "an aggregate such as `{A1 0.0,A2 -90.0}`");
    let mut at = k + 1;
    // `E6AXIS:`
    if let (Some(a), Some(b)) = (tokens.get(at), tokens.get(at + 1))
        && a.kind == Kind::Word
        && b.is(b':')
    {
        at += 2;
    }
    let (mut names, mut values): (Vec<Label>, Vec<Option<Plain>>) = (Vec::with_capacity(12), Vec::with_capacity(12));
    loop {
        let first = tokens.get(at).ok_or_else(unclosed)?;
        if first.is(b'}') {
            at += 1;
            break;
        }
        let (mut depth, mut end) = (0_usize, at);
        loop {
            let t = tokens.get(end).filter(|t| t.kind != Kind::Comment).ok_or_else(unclosed)?;
            match t.kind {
                Kind::Mark(b'{' | b'(' | b'[') => depth += 1,
                Kind::Mark(b'}') if depth == 0 => break,
                Kind::Mark(b'}' | b')' | b']') => depth = depth.saturating_sub(1),
                Kind::Mark(b',') if depth == 0 => break,
                _ => {}
            }
            end += 1;
        }
        if first.kind == Kind::Word {
            let name = Label::of(text.slice(first.span()));
            if names.len() >= MOST {
                return Err(text.bad(first.start, "a further component", format!("{MOST} components at most")));
            }
            if names.contains(&name) {
                return Err(text.bad(first.start, format!("a second `{}`", name.as_str()), "each component once"));
            }
            // `A1-5`: another number would run into the name
            let apart = |v: &Plain| v.0.start() > first.end;
            let value = match &tokens[at + 1..end] {
                [t] if t.kind == Kind::Quoted && name.is_one_of(b"ST") => {
                    bits(text.slice(t.span())).map(|v| (t.span().into(), v, number::Style::default()))
                }
                rest => literal(text, rest)?.filter(apart),
            };
            names.push(name);
            values.push(value);
        } else if !first.is(b',') {
            let found = String::from_utf8_lossy(text.slice(first.span())).into_owned();
            return Err(text.bad(first.start, format!("`{found}`"), "the name of a component such as `A1`"));
        }
        at = end + usize::from(tokens.get(end).is_some_and(|t| t.is(b',')));
    }
    let span = open..tokens.get(at - 1).map_or(open, |t| t.end);
    Ok((Aggregate { file, span: span.into(), names: names.into(), values: values.into() }, at))
}

/// `'B000111'`, `'H2A'`.
///
/// `bits = "'" ("B" | "H") digit {digit} "'"`
fn bits(text: &[u8]) -> Option<f64> {
    let inner = std::str::from_utf8(text.strip_prefix(b"'")?.strip_suffix(b"'")?).ok()?;
    let inner = inner.trim_start();
    let radix = match inner.bytes().next()? {
        b'B' | b'b' => 2,
        b'H' | b'h' => 16,
        _ => return None,
    };
    u16::from_str_radix(inner[1..].trim(), radix).ok().map(f64::from)
}

/// A number with its sign beside it, or an expression of numbers; `None`: anything else.
///
/// `literal = ["+" | "-"] number | expression`
fn literal(text: &Text, tokens: &[Token]) -> Result<Option<Plain>> {
    let span = match tokens {
        [n] if n.kind == Kind::Number => n.span(),
        [s, n] if (s.is(b'-') || s.is(b'+')) && n.kind == Kind::Number && s.end == n.start => s.start..n.end,
        [n, ..]
            if n.kind == Kind::Number && tokens.get(1).is_some_and(|t| t.kind == Kind::Number && t.start == n.end) =>
        {
            let end = tokens.last().map_or(n.end, |t| t.end);
            let found = String::from_utf8_lossy(text.slice(n.start..end)).into_owned();
            return Err(text.bad(n.start, format!("`{found}`"), "a number"));
        }
        _ => return Ok(folded(text, tokens)),
    };
    Ok(number::read(text.slice(span.clone())).map(|(v, s)| (span.into(), v, s)))
}
