//! Calls of URScript and their arguments, by keyword or by place.

use super::lex::Kind;
use super::read::{Item, ItemKind, Parsed, Span};
use super::words::{self, Motion, MotionKind};

/// An argument of a call: keyword, tokens of the expression.
pub struct Arg<'a> {
    pub name: &'a str,
    pub span: Span,
}

/// The motion call that an item is: function, arguments, tokens from its name to its closing bracket.
///
/// `call = motion "(" arguments ")"`
pub fn call<'a>(p: &'a Parsed, item: &Item) -> Option<(Motion, Vec<Arg<'a>>, Span)> {
    let i = item.span.start;
    if item.kind != ItemKind::Other || p.tokens.get(i + 1)?.kind != Kind::Mark(b'(') || item.span.len() < 3 {
        return None;
    }
    let motion = words::motion(p.words.at(i))?;
    let (args, close) = arguments(p, i + 2, item.span.end)?;
    Some((motion, args, i..close + 1))
}

/// Arguments after an opening bracket, and its closing one.
///
/// `arguments = [argument {"," argument}]`,
/// `argument = [name "="] expression`
pub fn arguments(p: &Parsed, from: usize, end: usize) -> Option<(Vec<Arg<'_>>, usize)> {
    let mut out = Vec::new();
    let mut depth = 0usize;
    let mut start = from;
    for i in from..end {
        let kind = p.tokens[i].kind;
        let closes = depth == 0 && kind == Kind::Mark(b')');
        if closes || depth == 0 && kind == Kind::Mark(b',') {
            let named = i > start + 2 && p.tokens[start + 1].kind == Kind::Mark(b'=') && !p.words.at(start).is_empty();
            let (name, span) = if named { (p.words.at(start), start + 2..i) } else { ("", start..i) };
            if !span.is_empty() {
                out.push(Arg { name, span });
            }
            start = i + 1;
        }
        if closes {
            return Some((out, i));
        }
        match kind {
            Kind::Mark(b'(' | b'[' | b'{') => depth += 1,
            Kind::Mark(b')' | b']' | b'}') => depth = depth.checked_sub(1)?,
            _ => {}
        }
    }
    None
}

/// Argument of a parameter, by keyword or by place.
pub fn argument<'a, 'p>(motion: &Motion, args: &'a [Arg<'p>], parameter: &str) -> Option<&'a Arg<'p>> {
    args.iter().find(|a| a.name == parameter).or_else(|| {
        let place = motion.parameters.iter().position(|p| *p == parameter)?;
        args.get(place).filter(|a| a.name.is_empty())
    })
}

/// The target: `q` and `pose` are one parameter; an arc leads to `pose_to`.
pub fn goal<'a, 'p>(motion: &Motion, args: &'a [Arg<'p>]) -> Option<&'a Arg<'p>> {
    ["pose_to", "pose", "q"]
        .into_iter()
        .filter(|p| motion.kind != MotionKind::Arc || *p != "q")
        .find_map(|p| argument(motion, args, p))
        .or_else(|| args.iter().find(|a| matches!(a.name, "q" | "pose")))
}

/// Token of the name that a move leads to. Other uses of a name count as reading it, so that its value stays.
pub fn goal_name(p: &Parsed, item: &Item) -> Option<usize> {
    let (motion, args, _) = call(p, item)?;
    let mut span = goal(&motion, &args)?.span.clone();
    while matches!(p.words.at(span.start), "get_inverse_kin") && span.len() > 3 {
        span = arguments(p, span.start + 2, span.end)?.0.first()?.span.clone();
    }
    (span.len() == 1).then_some(span.start)
}
