//! Aggregates of RAPID (`[[1,2],[3,4]]`) and the joint values in them.
//!
//! An element that is no plain number (a name, a sum, a hexadecimal number) is kept as such: it can be skipped, not read.
//! Resolution: a RAPID `num` is single precision, so a number of an axis is written no finer than the weight of its seventh
//! digit, unless it stands there finer already.

use super::lex::{Kind, Token};
use super::read::Span;
use super::reason::Reason;
use crate::axes::{Axes, JointKind};
use crate::error::Result;
use crate::script::fold;
use crate::script::number::last_digit;
use crate::script::{self, PoseForm, Text, Value, number};
use std::ops::Range;

/// Deepest nesting that is read; a jointtarget array of three dimensions has five.
const DEEPEST: usize = 8;

#[derive(Debug, Clone)]
pub enum Node {
    /// Elements, and the bytes from `[` to `]`.
    List(Vec<Node>, Range<usize>),
    /// A plain number with its sign.
    Number(f64, number::Style, Range<usize>),
    /// Anything else, bytes.
    Other(Range<usize>),
}

impl Node {
    pub fn bytes(&self) -> Range<usize> {
        match self {
            Self::List(_, b) | Self::Number(_, _, b) | Self::Other(b) => b.clone(),
        }
    }

    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(v, ..) => Some(*v),
            _ => None,
        }
    }

    pub fn list(&self) -> Option<&[Node]> {
        match self {
            Self::List(items, _) => Some(items),
            _ => None,
        }
    }

    /// Element by index.
    pub fn get(&self, k: usize) -> Option<&Node> {
        self.list()?.get(k)
    }

    /// Exactly so many numbers.
    pub fn numbers<const N: usize>(&self) -> Option<[f64; N]> {
        let items = self.list()?;
        let mut out = [0.0; N];
        if items.len() != N {
            return None;
        }
        for (slot, item) in out.iter_mut().zip(items) {
            *slot = item.number()?;
        }
        Some(out)
    }
}

/// The expression in `span` as an aggregate; `None` where it is none.
///
/// `aggregate = list`
pub fn aggregate(text: &Text, tokens: &[Token], span: Span) -> Option<Node> {
    let tokens = tokens.get(span)?;
    let (node, used) = list(text, tokens, 0, 0)?;
    (used == tokens.len()).then_some(node)
}

/// The list at token `at`, and the token after it.
///
/// `list = "[" element {"," element} "]"`,
/// `element = list | number | expression`
fn list(text: &Text, tokens: &[Token], at: usize, depth: usize) -> Option<(Node, usize)> {
    let open = tokens.get(at).filter(|t| t.kind == Kind::Mark(b'['))?;
    if depth >= DEEPEST {
        return None;
    }
    let mut items = Vec::with_capacity(6);
    let mut k = at + 1;
    loop {
        let first = tokens.get(k)?;
        let nested = (first.kind == Kind::Mark(b'[')).then(|| list(text, tokens, k, depth + 1)).flatten();
        let (node, next) = match nested {
            Some(found) => found,
            None => other(text, tokens, k)?,
        };
        items.push(node);
        match tokens.get(next)?.kind {
            Kind::Mark(b',') => k = next + 1,
            Kind::Mark(b']') => return Some((Node::List(items, open.start()..tokens[next].end()), next + 1)),
            _ => return None,
        }
    }
}

/// A number or any other expression at token `at`.
///
/// `element = number | expression`, up to a comma or a `]` outside of brackets
fn other(text: &Text, tokens: &[Token], at: usize) -> Option<(Node, usize)> {
    let mut depth = 0usize;
    let mut k = at;
    loop {
        match tokens.get(k)?.kind {
            Kind::Mark(b',' | b']') if depth == 0 => break,
            Kind::Mark(b'(' | b'[' | b'{') => depth += 1,
            Kind::Mark(b')' | b']' | b'}') => depth = depth.checked_sub(1)?,
            _ => {}
        }
        k += 1;
    }
    let last = tokens.get(k.checked_sub(1)?).filter(|_| k > at)?;
    let bytes = tokens[at].start()..last.end();
    let number = number::read(text.slice(bytes.clone())).or_else(|| folded(text, tokens.get(at..k)?));
    let node = match number {
        Some((v, style)) => Node::Number(v, style, bytes),
        None => Node::Other(bytes),
    };
    Some((node, k))
}

/// An expression of plain numbers, which another number can replace: as fine as its finest number.
///
/// `expression = number {("+" | "-" | "*" | "/") number}`
fn folded(text: &Text, tokens: &[Token]) -> Option<(f64, number::Style)> {
    // what is replaced stands on one line, so that no comment is removed with it
    let whole = tokens.first()?.start()..tokens.last()?.end();
    if text.slice(whole).contains(&b'\n') {
        return None;
    }
    let finest =
        tokens.iter().filter_map(|t| number::read(text.slice(t.start()..t.end()))).map(|n| n.1.decimals).max()?;
    fold::plain(&fold::parts(text, tokens)?, finest)
}

/// Joint values of an aggregate `[[6],[6]]`: one per axis of the robot, those of the arm by their numbers, the external axes as axes 7 and
/// on.
///
/// `Ok(Err(reason))`: the values cannot be determined from the text.
///
/// `jointtarget = "[" axes "," axes "]"`,
/// `axes = "[" six elements "]" | expression`
///
/// # Errors
/// Where the lists are not two of six.
pub fn joints(
    text: &Text,
    node: &Node,
    robot: &Axes,
) -> Result<std::result::Result<Vec<Option<Value>>, script::Reason>> {
    const EXPECTED: &str = "`[[six robot axes],[six external axes]]`";
    let at = node.bytes().start;
    let Some([robax, extax]) = node.list() else {
        let n = node.list().map_or(0, <[Node]>::len);
        return Err(text.bad(at, format!("a joint target of {n} lists"), EXPECTED));
    };
    for part in [robax, extax] {
        match part {
            Node::List(items, b) if items.len() != 6 => {
                return Err(text.bad(b.start, format!("{} numbers in a joint target", items.len()), EXPECTED));
            }
            Node::Number(_, _, b) => return Err(text.bad(b.start, "a number instead of a list", EXPECTED)),
            _ => {}
        }
    }
    // a list with a call in it cannot be written into the instruction: the call would happen once more
    if text.slice(node.bytes()).contains(&b'(') {
        return Ok(Err(Reason::ValueComputed.into()));
    }
    if robot.dof() > 12 {
        return Err(text.bad(
            at,
            "a joint target of 12 numbers",
            format!("{} for the axes of {}", robot.dof(), robot.name),
        ));
    }
    let mut out = Vec::with_capacity(robot.dof());
    let places = robot.places();
    if !places.certain {
        return Ok(Err(script::Reason::unclear_axes(&robot.axis_names())));
    }
    if !places.numbered {
        return Ok(Err(script::Reason::unclear_numbers(&robot.axis_names())));
    }
    for (axis, joint) in robot.axis_joints().enumerate() {
        let external = places.external.iter().find(|e| e.1 == axis).map(|e| (extax, e.0 - 1));
        let of_arm = || (robax, places.number(axis).map_or(usize::MAX, |n| n - 1));
        let (part, k) = external.unwrap_or_else(of_arm);
        let Some(item) = part.get(k) else { return Ok(Err(Reason::NoList.into())) };
        let Node::Number(v, style, b) = item else {
            return Ok(Err(Reason::AxisComputed(joint.name.as_str().into()).into()));
        };
        // 9E9: the axis is not used; older programs write 9E+09 or 1E+10
        if v.abs() >= 8.9e9 {
            out.push(None);
            continue;
        }
        out.push(Some(axis_value(joint.kind, *v, *style, b.clone())));
    }
    Ok(Ok(out))
}

/// The six numbers of the arm in a joint target; `None`: one that is computed.
pub fn of_arm(node: &Node) -> impl Iterator<Item = Option<f64>> {
    node.get(0).and_then(Node::list).unwrap_or_default().iter().map(Node::number)
}

/// A number of an axis.
pub fn axis_value(kind: JointKind, value: f64, style: number::Style, bytes: Range<usize>) -> Value {
    let si = kind.si_per_user_unit();
    let digit = last_digit(style.decimals) * si;
    let finest = finest(value, style) * si;
    Value { si: value * si, start: bytes.start, end: bytes.end, style, digit, finest }
}

/// External axes of the robot that a robtarget places, with their numbers; `None`: one is no plain number.
///
/// `extax = "[" six numbers "]" | expression`
pub fn placed(node: Option<&Node>, robot: &Axes) -> Option<Vec<(usize, Value)>> {
    let places = robot.places();
    let mut all = Vec::new();
    for &(number, axis) in places.external.iter().filter(|_| places.certain) {
        let Node::Number(v, style, b) = node?.get(number - 1)? else { return None };
        // 9E9: the axis stays where it is
        if v.abs() < 8.9e9 {
            all.push((axis, axis_value(robot.axis(axis).kind, *v, *style, b.clone())));
        }
    }
    Some(all)
}

/// Numbers of a robtarget `[[x,y,z],[q1,q2,q3,q4],...]`; `None`: one is no plain number.
///
/// `robtarget = "[" trans "," rot ... "]"`, `trans = "[" three numbers "]"`, `rot = "[" four numbers "]"`
pub fn pose(node: &Node) -> Option<Vec<Option<Value>>> {
    let form = PoseForm::Quaternion;
    let (xyz, turn) = (node.get(0)?.list()?, node.get(1)?.list()?);
    if xyz.len() != 3 || turn.len() != 4 {
        return None;
    }
    let value = |(k, item): (usize, &Node)| {
        let Node::Number(v, style, b) = item else { return None };
        let (unit, digit) = (form.unit(k), number::last_digit(style.decimals));
        // single precision holds seven digits of a part of a quaternion
        let finest = if k < 3 { finest(*v, *style) } else { finest(*v, *style).min(QUATERNION) };
        Some(Some(Value {
            si: v * unit,
            start: b.start,
            end: b.end,
            style: *style,
            digit: digit * unit,
            finest: finest * unit,
        }))
    };
    xyz.iter().chain(turn).enumerate().map(value).collect()
}

/// Finest last digit of a part of a quaternion.
const QUATERNION: f64 = 1e-7;

/// Weight of the last digit that is written of a number that stands there as `v`, in its own unit.
fn finest(v: f64, style: number::Style) -> f64 {
    // an exponent says nothing about how fine the number is meant
    let written = if style.exponent { 1.0 } else { number::last_digit(style.decimals) };
    seventh(v).min(written)
}

/// Weight of the seventh digit, which single precision just holds; of a number below 1 that of the sixth decimal.
pub fn seventh(v: f64) -> f64 {
    /// Nearer than this to the next power of ten, as a share, the logarithm decides.
    const SURE: f64 = 0.99;
    let size = v.abs();
    for (power, digit) in [(1e1, 1e-6), (1e2, 1e-5), (1e3, 1e-4), (1e4, 1e-3)] {
        if size < 1.0 || size < SURE * power {
            return digit;
        }
        if size < power {
            break;
        }
    }
    10f64.powi(size.log10().floor() as i32 - 6)
}
