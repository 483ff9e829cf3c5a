//! Where a TRIGGER reads where the robot stands, itself (`DO XQ=$AXIS_ACT`) or by a routine.
//!
//! With `DISTANCE=0` it strikes where the motion before ends, with `DISTANCE=1` where the next one does, and with `PATH` at a distance from
//! there (with `ONSTART`, from where the motion before ends); a delay, or a distance, moves that along the way (KUKA System Software,
//! Operating and Programming Instructions for System Integrators, TRIGGER). Both ends of a way on which it may strike count as read.

use super::ahead::is_place;
use crate::krl::calls::{calls, quiet};
use crate::krl::lex::{Kind, Token, begins_with, first_word, in_upper, tokens};
use crate::krl::statement::{assignment, statements};
use crate::script::Text;
use crate::script::number as digits;
use std::collections::BTreeSet;

/// A TRIGGER that reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Trigger {
    /// Its line, from 0.
    pub(super) line: usize,
    /// It reads itself, and not by a routine.
    pub(super) own: bool,
    /// It may strike on the way from where the motion before it ends.
    pub(super) before: bool,
    /// How many motions after it count.
    pub(super) ahead: usize,
}

/// Whether a text has any.
///
/// `trigger = "TRIGGER" ...`
pub(super) fn has_trigger(text: &Text) -> bool {
    (0..text.line_count()).any(|k| begins_with(text, k, b"T") && first_word(text, k).eq_ignore_ascii_case(b"TRIGGER"))
}

/// The TRIGGERs of a text that read; `reading`: routines that do.
///
/// `trigger = "TRIGGER" "WHEN" place "DELAY" "=" value "DO" statement`
pub(super) fn triggers(text: &Text, reading: &BTreeSet<String>) -> Vec<Trigger> {
    let mut line = Vec::new();
    let mut of = |k: usize| {
        tokens(text, k, &mut line);
        line.retain(|t| t.kind != Kind::Comment);
        let [head, does] = statements(text, &line)[..] else { return None };
        let own = reads(text, does);
        let named = || calls(text, does).into_iter().chain(quiet(text, does)).any(|name| reading.contains(&name));
        if in_upper(text, head.first()?) != "TRIGGER" || !(own || named()) {
            return None;
        }
        let (before, ahead) = strikes(text, head);
        Some(Trigger { line: k, own, before, ahead })
    };
    (0..text.line_count()).filter(|k| begins_with(text, *k, b"T")).filter_map(&mut of).collect()
}

/// Whether a statement takes on where the robot stands: what stands before the sign is set.
///
/// `statement = name "=" {any} place ... | name "(" ... place ...`
fn reads(text: &Text, does: &[Token]) -> bool {
    let from = assignment(does).map_or(0, |sign| sign + 1);
    let quiet = does.first().is_none_or(|t| in_upper(text, t).contains("MSG"));
    !quiet && does[from..].iter().any(|t| t.kind == Kind::Word && is_place(&in_upper(text, t)))
}

/// A number by its sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sign {
    Zero,
    Below,
    Above,
    /// It is computed.
    Either,
}

/// Whether it may strike where the motion before ends or on the way from there, and how many motions after it count.
///
/// `place = "DISTANCE" "=" ("0" | "1") | "PATH" "=" value ["ONSTART"]`
fn strikes(text: &Text, head: &[Token]) -> (bool, usize) {
    use Sign::{Above, Below, Either, Zero};
    let says = |name: &str| head.iter().any(|t| t.kind == Kind::Word && in_upper(text, t) == name);
    let distance = sign(text, head, "DISTANCE");
    let from_start = distance == Some(Zero) || says("ONSTART");
    let path = sign(text, head, "PATH").unwrap_or(if distance == Some(Either) { Either } else { Zero });
    match (from_start, path, sign(text, head, "DELAY").unwrap_or(Zero)) {
        (true, Zero, Zero) => (true, 0),
        (true, ..) => (true, 1),
        (false, Zero, Zero) => (false, 1),
        (false, Zero | Above, Zero | Above) => (false, 2),
        (false, Zero | Below, Zero | Below) => (true, 1),
        (false, ..) => (true, 2),
    }
}

/// The sign of the value that a name gets; `None`: it gets none.
///
/// `value = name "=" ["+" | "-"] number | name "=" expression`
fn sign(text: &Text, head: &[Token], name: &str) -> Option<Sign> {
    let at = head.windows(2).position(|w| w[1].is(b'=') && in_upper(text, &w[0]) == name)?;
    let ends = |t: &Token| ["DELAY", "ONSTART", "PATH", "DO"].contains(&in_upper(text, t).as_ref());
    let value: Vec<&Token> = head.iter().skip(at + 2).take_while(|t| !ends(t)).collect();
    let (minus, number) = match value[..] {
        [number] => (false, number),
        [sign, number] if sign.is(b'-') || sign.is(b'+') => (sign.is(b'-'), number),
        _ => return Some(Sign::Either),
    };
    let number = (number.kind == Kind::Number).then(|| digits::read(text.slice(number.span()))).flatten();
    Some(match number {
        Some((0.0, _)) => Sign::Zero,
        Some(_) if minus => Sign::Below,
        Some(_) => Sign::Above,
        None => Sign::Either,
    })
}
