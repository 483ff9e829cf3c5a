//! Values that are expressions of plain numbers: `1500+94.851`, `-(20+5)`. Another number can take the place of the whole expression.

use super::aggregate::Plain;
use super::lex::{Kind, Token};
use crate::script::fold::{self, Part};
use crate::script::{Text, number};

/// The value of an expression, as fine as its finest number; `None`: it is none of plain numbers. A quotient of whole numbers is cut to a
/// whole number (KUKA System Software, arithmetic operators): none is folded.
///
/// `expression = number {("+" | "-" | "*") number}`, with brackets and signs
pub(super) fn folded(text: &Text, tokens: &[Token]) -> Option<Plain> {
    let (first, last) = (tokens.first()?, tokens.last()?);
    let mut decimals = 0;
    let mut part = |t: &Token| match t.kind {
        Kind::Number => number::read(text.slice(t.span())).map(|(v, style)| {
            decimals = style.decimals.max(decimals);
            Part::Number(v)
        }),
        Kind::Mark(m) if b"+-*()".contains(&m) => Some(Part::Mark(m)),
        _ => None,
    };
    let parts = tokens.iter().map(&mut part).collect::<Option<Vec<Part>>>()?;
    let (value, style) = fold::plain(&parts, decimals)?;
    Some(((first.start..last.end).into(), value, style))
}
