//! Arguments of RAPID instructions: what stands between the commas, and its switches after backslashes.

use super::lex::Kind;
use super::read::{Item, ItemKind, Parsed, Span};
use super::words::{self, Leads, Motion};
use crate::script::lex::outside;
use std::ops::Range;

/// An argument: its expression and its switches.
#[derive(Debug, Clone, Default)]
pub struct Arg {
    pub bytes: Range<usize>,
    pub switches: Vec<Switch>,
    /// Tokens of the expression.
    pub span: Span,
    /// `ToPoint` of `ToPoint:=p1`, lower case.
    pub name: String,
}

#[derive(Debug, Clone)]
pub struct Switch {
    /// Lower case.
    pub name: String,
    /// From `\`.
    pub bytes: Range<usize>,
    /// Tokens of its value; of a conditional argument (`\WObj?WObj`), of the parameter that has it.
    pub value: Option<Span>,
    /// It is there only where the caller of the routine gives that parameter.
    pub conditional: bool,
}

/// Whether a switch is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Given {
    No,
    /// A conditional argument: where the caller of the routine gives it.
    Perhaps,
    Yes,
}

/// Whether an instruction has a word (lower case) as its switch.
///
/// `switch = "\" name ["?" parameter | ":=" expression]`
pub fn given(p: &Parsed, span: &Span, word: &str) -> Given {
    let mark = |k: usize, mark: u8| p.tokens.get(k).is_some_and(|t| t.kind == Kind::Mark(mark));
    let switch = |k: &usize| p.words.at(*k) == word && k.checked_sub(1).is_some_and(|k| mark(k, b'\\'));
    match span.clone().find(switch) {
        None => Given::No,
        Some(k) if mark(k + 1, b'?') => Given::Perhaps,
        Some(_) => Given::Yes,
    }
}

/// Token of the name that the move of an item leads to, as [`goal_name`] tells it; numbers in the move itself have none.
///
/// `call = motion arguments`
pub fn goal_of(p: &Parsed, item: &Item) -> Option<usize> {
    let ItemKind::Call { .. } = item.kind else { return None };
    let motion = words::motion(p.words.at(item.span.start))?;
    let first = p.tokens.get(item.span.start + 1)?;
    if motion.target == 0 && first.kind == Kind::Mark(b'[') {
        return None;
    }
    goal_name(p, motion, &arguments(p, item.span.start + 1..item.span.end))
}

/// Arguments of a motion instruction.
///
/// `call = motion arguments`
pub fn motion_of(p: &Parsed, item: &Item) -> Option<(Motion, Vec<Arg>)> {
    let ItemKind::Call { .. } = item.kind else { return None };
    let motion = words::motion(p.words.at(item.span.start))?;
    Some((motion, arguments(p, item.span.start + 1..item.span.end)))
}

/// Token of the name that a move leads to. Other uses of a name count as reading it, so that its value stays.
///
/// `goal = name {"{" | number | "," | "}"}`
pub fn goal_name(p: &Parsed, motion: Motion, args: &[Arg]) -> Option<usize> {
    let span = point_of(p, &args.get(positional(args, motion.target)?)?.span);
    let index = span.clone().skip(1).all(|i| matches!(p.tokens[i].kind, Kind::Number | Kind::Mark(b'{' | b',' | b'}')));
    let follows = matches!(motion.leads, Leads::Joints | Leads::Pose);
    (index && follows).then_some(span.start)
}

/// The point that `Offs` or `RelTool` displaces; else the expression itself.
///
/// `point = ("Offs" | "RelTool") "(" point {"," argument} ")" | expression`
fn point_of(p: &Parsed, span: &Span) -> Span {
    if span.len() <= 4 || !matches!(p.words.at(span.start), "offs" | "reltool") {
        return span.clone();
    }
    let point = arguments(p, span.start + 2..span.end.saturating_sub(1)).into_iter().next();
    point.filter(|a| !a.span.is_empty()).map_or(span.clone(), |a| a.span)
}

/// Splits at commas, and each argument at its backslashes.
///
/// `arguments = [argument] {"," [argument]}`; a comma within brackets belongs to its argument
pub fn arguments(p: &Parsed, span: Span) -> Vec<Arg> {
    let mut out = Vec::with_capacity(4);
    let mut start = span.start;
    let end = span.end;
    for end in marks(p, span, b',').chain([end]) {
        out.push(argument(p, start..end));
        start = end + 1;
    }
    out
}

/// Places of a mark outside of brackets.
fn marks(p: &Parsed, span: Span, mark: u8) -> impl Iterator<Item = usize> {
    let of = |k: usize| p.tokens.get(k).and_then(|t| t.kind.mark());
    outside(span, of).filter(move |k| of(*k) == Some(mark))
}

/// Splits an argument into its expression and its switches.
///
/// `argument = [name ":="] expression {switch}`,
/// `switch = "\" name [":=" expression | "?" parameter]`
pub fn argument(p: &Parsed, span: Span) -> Arg {
    let bytes = |s: &Span| match (p.tokens.get(s.start), s.end.checked_sub(1).and_then(|k| p.tokens.get(k))) {
        (Some(a), Some(b)) if s.start < s.end => a.start()..b.end(),
        (Some(a), _) => a.start()..a.start(),
        _ => 0..0,
    };
    let cuts: Vec<usize> = marks(p, span.clone(), b'\\').collect();
    let mut expression = span.start..cuts.first().copied().unwrap_or(span.end);
    let mut name = String::new();
    let assigned = |at: usize| p.tokens.get(at).is_some_and(|t| t.kind == Kind::Assign);
    if expression.len() > 2 && assigned(expression.start + 1) {
        name.push_str(p.words.at(expression.start));
        expression.start += 2;
    }
    let ends = cuts.iter().skip(1).copied().chain([span.end]);
    let asks = |at: usize| p.tokens.get(at).is_some_and(|t| t.kind == Kind::Mark(b'?'));
    let switches = cuts
        .iter()
        .zip(ends)
        .map(|(&start, end)| Switch {
            name: p.words.at(start + 1).to_string(),
            bytes: bytes(&(start..end)),
            value: ((assigned(start + 2) || asks(start + 2)) && start + 3 < end).then_some(start + 3..end),
            conditional: asks(start + 2),
        })
        .collect();
    Arg { bytes: bytes(&expression), switches, span: expression, name }
}

/// Index of the `n`-th required argument; `\Conc` before a comma counts as none.
pub fn positional(args: &[Arg], n: usize) -> Option<usize> {
    args.iter().enumerate().filter(|(_, a)| !a.span.is_empty()).map(|(k, _)| k).nth(n)
}
