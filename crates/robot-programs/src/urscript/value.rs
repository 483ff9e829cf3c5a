//! Lists of joint values and poses in URScript.
//!
//! An element is a number (rad, or m for a prismatic axis), `d2r(number)`, whose number is then edited in degrees, or an expression
//! of plain numbers (`0.3+0.05`), in whose place an edited number stands. Anything
//! else (a name, a call) is no value that can be edited. The controller counts in double precision; numbers are written
//! down to 1e-9 rad or m (1e-7 deg), far below what any joint resolves.

use super::lex::{Kind, Token, Words};
use super::read::Span;
use super::reason::Reason;
use crate::axes::{Axes, JointKind, OF_ARM};
use crate::error::Result;
use crate::script::number::last_digit;
use crate::script::{self, Text, Value, fold, number};
use std::ops::Range;

pub const FINEST: f64 = 1e-9;
const FINEST_DEG: f64 = 1e-7;

/// A number of a list: its value and whether it stands in `d2r()`.
struct Element {
    value: f64,
    style: number::Style,
    bytes: Range<usize>,
    degrees: bool,
}

/// Elements of the list whose `[` is the first token of `span` and whose `]` is the last.
///
/// `list = "[" element {"," element} "]"`
fn elements(
    text: &Text,
    tokens: &[Token],
    words: &Words,
    span: &Span,
) -> Option<std::result::Result<Vec<Element>, Reason>> {
    let last = span.end.checked_sub(1)?;
    let is = |i: usize, b: u8| tokens.get(i).is_some_and(|t| t.kind == Kind::Mark(b));
    if span.len() < 3 || !is(span.start, b'[') || !is(last, b']') {
        return None;
    }
    let mut out = Vec::new();
    let mut depth = 0usize;
    let mut start = span.start + 1;
    for i in span.start + 1..=last {
        match tokens[i].kind {
            Kind::Mark(b',' | b']') if depth == 0 => {
                if i != last && is(i, b']') {
                    return None;
                }
                match element(text, tokens, words, start..i) {
                    Some(e) => out.push(e),
                    None => return Some(Err(Reason::ValueComputed(out.len() + 1))),
                }
                start = i + 1;
            }
            Kind::Mark(b'(' | b'[' | b'{') => depth += 1,
            Kind::Mark(b')' | b']' | b'}') => depth = depth.checked_sub(1)?,
            _ => {}
        }
    }
    Some(Ok(out))
}

/// A joint value beyond which nothing can be meant, rad or deg.
const BEYOND: f64 = 1e6;

/// `element = number | "d2r" "(" number ")" | expression`
fn element(text: &Text, tokens: &[Token], words: &Words, mut span: Span) -> Option<Element> {
    let whole = span.clone();
    let mut degrees = false;
    if span.len() >= 4
        && words.at(span.start) == "d2r"
        && tokens[span.start + 1].kind == Kind::Mark(b'(')
        && tokens[span.end - 1].kind == Kind::Mark(b')')
    {
        span = span.start + 2..span.end - 1;
        degrees = true;
    }
    let number = plain(text, tokens, &span);
    degrees &= number.is_some();
    let (value, style, bytes) = number.or_else(|| folded(text, tokens, &whole))?;
    // no joint stands there, and its degrees may be no number any more
    if value.abs() > BEYOND {
        return None;
    }
    Some(Element { value, style, bytes, degrees })
}

/// An expression of plain numbers.
///
/// `expression = sum of numbers, brackets and "d2r" "(" sum ")"`
fn folded(text: &Text, tokens: &[Token], span: &Span) -> Option<(f64, number::Style, Range<usize>)> {
    let tokens = tokens.get(span.clone())?;
    // what is replaced stands on one line, so that no comment is removed with it
    let bytes = tokens.first()?.start()..tokens.last()?.end();
    if text.slice(bytes.clone()).contains(&b'\n') {
        return None;
    }
    let value = fold::fold(&fold::parts(text, tokens)?, &Degrees)?;
    let style = number::Style { decimals: FOLDED_DECIMALS, point: true, ..number::Style::default() };
    Some((value, style, bytes))
}

/// Decimals of a number that replaces an expression.
const FOLDED_DECIMALS: u8 = 6;

/// `d2r` and no names.
struct Degrees;

impl fold::Known for Degrees {
    fn name(&self, _name: &str) -> Option<f64> {
        None
    }

    fn call(&self, name: &str, value: f64) -> Option<f64> {
        (name == "d2r").then(|| value.to_radians())
    }
}

/// The expression as a plain number, its style and bytes.
///
/// `number = ["+" | "-"] digits`
pub fn plain(text: &Text, tokens: &[Token], span: &Span) -> Option<(f64, number::Style, Range<usize>)> {
    if span.is_empty() || span.len() > 2 {
        return None;
    }
    let bytes = tokens.get(span.start)?.start()..tokens.get(span.end - 1)?.end();
    let (v, style) = number::read(text.slice(bytes.clone()))?;
    Some((v, style, bytes))
}

/// Values of a target, one per axis, and what one unit of each written number is in SI.
pub type Joints = (Vec<Option<Value>>, Vec<f64>);

/// Numbers, from 1, of the robot's axes in a list: by their names on an arm of six or fewer; `None`: which they are is not certain.
pub fn numbers(robot: &Axes) -> Option<Vec<usize>> {
    let places = robot.places();
    if robot.dof() > OF_ARM {
        return Some((1..=robot.dof()).collect());
    }
    (places.numbered && places.external.is_empty()).then(|| places.numbers.clone())
}

/// Numbers of a list in order, in rad; `None`: it is none, or one is computed.
pub fn in_order(text: &Text, tokens: &[Token], words: &Words, span: &Span) -> Option<Vec<f64>> {
    let list = elements(text, tokens, words, span)?.ok()?;
    Some(list.iter().map(|e| if e.degrees { e.value.to_radians() } else { e.value }).collect())
}

/// Joint values of a list; `Ok(Err(reason))`: it is none, or they cannot be determined.
///
/// # Errors
/// Where a list of plain numbers has not one for every axis.
pub fn joints(
    text: &Text,
    tokens: &[Token],
    words: &Words,
    span: &Span,
    robot: &Axes,
) -> Result<std::result::Result<Joints, script::Reason>> {
    let list = match elements(text, tokens, words, span) {
        None => return Ok(Err(Reason::NoList.into())),
        Some(Err(why)) => return Ok(Err(why.into())),
        Some(Ok(list)) => list,
    };
    let Some(numbers) = numbers(robot) else {
        return Ok(Err(script::Reason::unclear_numbers(&robot.axis_names())));
    };
    let least = numbers.iter().copied().max().unwrap_or_default().max(robot.dof());
    if list.len() < least {
        let found = format!("a joint target of {} numbers", list.len());
        let expected = format!("{least}, one for every axis of {}", robot.name);
        return Err(text.bad(tokens[span.start].start(), found, expected));
    }
    let mut out = Vec::with_capacity(robot.dof());
    let mut units = Vec::with_capacity(robot.dof());
    for (joint, number) in robot.axis_joints().zip(numbers) {
        let Some(e) = number.checked_sub(1).and_then(|k| list.get(k)) else { continue };
        if e.degrees && joint.kind == JointKind::Prismatic {
            return Ok(Err(Reason::NotInDegrees(joint.name.as_str().into()).into()));
        }
        let unit = if e.degrees { JointKind::Revolute.si_per_user_unit() } else { 1.0 };
        units.push(unit);
        let finest = if e.degrees { FINEST_DEG * unit } else { FINEST };
        out.push(Some(axis_value(e.value, e.style, e.bytes.clone(), unit, finest)));
    }
    Ok(Ok((out, units)))
}

/// A number of an axis; `unit`: SI per unit of the number.
fn axis_value(value: f64, style: number::Style, bytes: Range<usize>, unit: f64, finest: f64) -> Value {
    let digit = last_digit(style.decimals) * unit;
    Value { si: value * unit, start: bytes.start, end: bytes.end, style, digit, finest }
}

/// A number of an axis that is written as it is, without a function around it.
pub fn plain_axis_value(value: f64, style: number::Style, bytes: Range<usize>) -> Value {
    axis_value(value, style, bytes, 1.0, FINEST)
}

/// Numbers of a pose `p[..]` as they can be written; `None`: it is none, or a number is computed.
///
/// `pose = "p" list`
pub fn pose_values(text: &Text, tokens: &[Token], words: &Words, span: &Span) -> Option<Vec<Option<Value>>> {
    if span.len() < 3 || words.at(span.start) != "p" {
        return None;
    }
    let list = elements(text, tokens, words, &(span.start + 1..span.end))?.ok()?;
    let value = |e: &Element| {
        let digit = number::last_digit(e.style.decimals);
        let (start, end) = (e.bytes.start, e.bytes.end);
        // degrees in a pose have their own unit
        (!e.degrees).then_some(Some(Value { si: e.value, start, end, style: e.style, digit, finest: FINEST }))
    };
    list.iter().map(value).collect::<Option<Vec<_>>>().filter(|v| v.len() == 6)
}

/// Six numbers of a pose `p[..]`, m and rad (rotation vector).
///
/// `pose = "p" list`
pub fn pose(text: &Text, tokens: &[Token], words: &Words, span: &Span) -> Option<[f64; 6]> {
    if span.len() < 3 || words.at(span.start) != "p" {
        return None;
    }
    let list = elements(text, tokens, words, &(span.start + 1..span.end))?.ok()?;
    let numbers: Vec<f64> = list.iter().map(|e| if e.degrees { e.value.to_radians() } else { e.value }).collect();
    numbers.try_into().ok()
}
