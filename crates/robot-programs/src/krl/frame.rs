//! Values of frames and numbers, as statements give them.

use super::aggregate::aggregate;
use super::lex::{Kind, Token, upper};
use crate::script::cursor::integer;
use crate::script::pose::Frame;
use crate::script::{Text, number as digits};
use nalgebra::Isometry3;

/// The frames that have a name and a value wherever the program runs.
pub(super) type Known<'a> = &'a dyn Fn(&str) -> Option<Isometry3<f64>>;

/// A plain number.
pub(super) fn number(text: &Text, value: &[Token]) -> Option<f64> {
    let [t] = value else { return None };
    (t.kind == Kind::Number).then(|| digits::read(text.slice(t.span())).map(|v| v.0)).flatten()
}

/// `TOOL_NO 1` of an aggregate.
///
/// `field = name digit {digit}`
pub(super) fn numbered_field(text: &Text, value: &[Token], field: &str) -> Option<u32> {
    let at = value.iter().position(|t| upper(text, t) == field)?;
    integer(text.slice(value.get(at + 1)?.span()))
}

/// Tokens as they stand there.
pub(super) fn written(text: &Text, value: &[Token]) -> String {
    let (Some(a), Some(b)) = (value.first(), value.last()) else { return String::new() };
    crate::error::one_line(&String::from_utf8_lossy(text.slice(a.start..b.end)))
}

/// A frame by its number in a list; one that is computed is asked for by what computes it.
pub(super) fn numbered(text: &Text, value: &[Token], list: &str) -> Frame {
    match number(text, value) {
        Some(0.0) => Frame::Null,
        Some(n) if n > 0.0 && n.fract() == 0.0 => Frame::Named(format!("{n:.0}")),
        _ => Frame::Computed(format!("{list}[{}]", written(text, value))),
    }
}

/// What is assigned to a frame: `$NULLFRAME`, `BASE_DATA[2]`, `{X 0,Y 0,Z 180,A 0,B 0,C 0}`, the name of such a one.
///
/// `value = "$NULLFRAME" | name | list "[" number "]" | aggregate | expression`
pub(super) fn frame(text: &Text, value: &[Token], part: Option<&str>, list: &str, known: Known) -> Frame {
    let computed = || Frame::Computed(written(text, value));
    if let Some(part) = part {
        return Frame::Computed(format!("{part} set to {}", written(text, value)));
    }
    match value {
        [t] if upper(text, t) == "$NULLFRAME" => Frame::Null,
        [t] if t.kind == Kind::Word => known(&upper(text, t)).map_or_else(computed, Frame::Given),
        [t, open, n, close] if upper(text, t) == list && open.is(b'[') && close.is(b']') => {
            numbered(text, std::slice::from_ref(n), list)
        }
        [open, ..] if open.is(b'{') => {
            let whole = aggregate(text, 0, value, 0).ok().filter(|(_, next)| *next == value.len());
            whole.and_then(|(a, _)| a.isometry()).map_or_else(computed, Frame::Given)
        }
        _ => computed(),
    }
}
