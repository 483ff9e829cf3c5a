//! Goals that are products of frames: `P1:{X 0,Y 4,Z 0,A 0,B 0,C 0}`, `XP[2]:OFFSET`.
//!
//! `A:B` is B counted in A. What the product of two positions means for status and turn: the right operand gives them (KUKA System
//! Software, Operating and Programming Instructions for System Integrators, geometric operator). A factor whose value is not certain
//! makes the goal computed.

use super::aggregate::{Aggregate, aggregate};
use super::data::Data;
use super::lex::{Kind, Token, index, upper};
use super::name::Holds;
use super::reason::Reason;
use crate::error::Result;
use crate::script::Text;
use std::ops::Range;

/// One of them.
pub(super) struct Factor {
    pub value: Aggregate,
    /// The point that holds the numbers.
    pub name: Option<usize>,
    /// All six numbers stand in the motion.
    pub inline: bool,
    pub tokens: Range<usize>,
}

/// The name at token `at` with a plain index, in upper case, and the token after it.
///
/// `name = word [index]`
pub(super) fn name(text: &Text, line: &[Token], at: usize) -> (String, usize) {
    let word = line.get(at).map(|t| upper(text, t)).unwrap_or_default();
    match index(text, line, at + 1) {
        Some((k, next)) => (format!("{word}[{k}]"), next),
        None => (word, at + 1),
    }
}

/// Token after the factor at `at`.
///
/// `factor = word [index] | aggregate`
fn after(text: &Text, line: &[Token], at: usize) -> Option<usize> {
    match line.get(at)? {
        t if t.kind == Kind::Word => Some(index(text, line, at + 1).map_or(at + 1, |(_, next)| next)),
        t if t.is(b'{') => {
            let mut depth = 0_usize;
            for (k, t) in line.iter().enumerate().skip(at) {
                match t.kind {
                    Kind::Mark(b'{') => depth += 1,
                    Kind::Mark(b'}') if depth <= 1 => return Some(k + 1),
                    Kind::Mark(b'}') => depth -= 1,
                    _ => {}
                }
            }
            None
        }
        _ => None,
    }
}

/// Whether the goal at token `at` is a product.
pub(super) fn is(text: &Text, line: &[Token], at: usize) -> bool {
    after(text, line, at).and_then(|next| line.get(next)).is_some_and(|t| t.is(b':'))
}

/// The factors of the product at token `at`, and the token after it; why they cannot be determined.
///
/// `product = factor {":" factor}`
pub(super) fn factors(
    text: &Text,
    line: &[Token],
    mut at: usize,
    data: &Data,
    routine: usize,
) -> Result<std::result::Result<(Vec<Factor>, usize), Reason>> {
    let mut all = Vec::new();
    loop {
        let Some(next) = after(text, line, at) else { return Ok(Err(Reason::Computed)) };
        let tokens = at..next;
        let factor = if line[at].is(b'{') {
            let (value, _) = aggregate(text, 0, line, at)?;
            let inline = value.coordinates().is_some();
            Factor { value, name: None, inline, tokens }
        } else {
            let (name, _) = name(text, line, at);
            let Some(n) = data.find(routine, &name) else { return Ok(Err(Reason::Computed)) };
            let known = &data.names[n];
            match known.value() {
                Err(why) => return Ok(Err(why)),
                Ok(_) if known.holds != Holds::Pose => return Ok(Err(Reason::Computed)),
                Ok(value) => Factor { value: value.clone(), name: Some(n), inline: false, tokens },
            }
        };
        if factor.value.isometry().is_none() {
            return Ok(Err(Reason::PartMissing(None)));
        }
        all.push(factor);
        match line.get(next) {
            Some(t) if t.is(b':') => at = next + 1,
            _ => return Ok(Ok((all, next))),
        }
    }
}
