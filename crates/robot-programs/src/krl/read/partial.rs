//! Calls of routines of other files that may begin with a Cartesian goal that lacks parts: these stay where the caller has led the robot.
//!
//! A routine begins so if no motion to a whole place certainly comes before that goal. In the file itself this is found along control
//! ([`last`](super::last)).

use super::ahead::is_place;
use super::scan::own_routines;
use crate::krl::aggregate::{Aggregate, aggregate};
use crate::krl::calls::calls;
use crate::krl::lex::{Kind, Token, tokens, upper};
use crate::krl::motion;
use crate::krl::relative::each_line;
use crate::krl::statement::is_routine;
use crate::script::Text;
use std::collections::BTreeSet;

/// Lines of the first text, from 0, that call such a routine, itself or by others.
pub(super) fn calls_partial(texts: &[Text]) -> Vec<usize> {
    let Some((text, beside)) = texts.split_first() else { return Vec::new() };
    if beside.is_empty() {
        return Vec::new();
    }
    let lacking: Vec<_> = texts.iter().map(|t| t.known(Lacking::of)).collect();
    if lacking.iter().all(|l| !l.inline && l.names.is_empty()) {
        return Vec::new();
    }
    let begins: Vec<_> = texts.iter().map(|t| t.known(Begins::of)).collect();
    let mut found: BTreeSet<&str> = BTreeSet::new();
    loop {
        let lacks = |first: &First| match first {
            First::Lacking => true,
            First::Named(name) => lacking.iter().any(|l| l.names.contains(name)),
            First::Call(name) => found.contains(name.as_str()),
        };
        let all = begins.iter().flat_map(|b| &b.0).filter(|(_, first)| lacks(first));
        let all: BTreeSet<&str> = all.map(|(routine, _)| routine.as_str()).collect();
        if all.len() == found.len() {
            break;
        }
        found = all;
    }
    let own = own_routines(text);
    found.retain(|name| !own.contains(*name));
    if found.is_empty() {
        return Vec::new();
    }
    let mut line = Vec::new();
    let mut calls_one = |k: &usize| {
        tokens(text, *k, &mut line);
        line.retain(|t| t.kind != Kind::Comment);
        runs_here(text, &line) && calls(text, &line).iter().any(|name| found.contains(name.as_str()))
    };
    text.lines_with(b"(").filter(|k| calls_one(k)).collect()
}

/// Whether what a line calls runs where the line stands.
fn runs_here(text: &Text, line: &[Token]) -> bool {
    let word = |k: usize| line.get(k).map(|t| upper(text, t)).unwrap_or_default();
    let elsewhere = ["EXT", "EXTFCT", "DECL", "GLOBAL", "INTERRUPT", "TRIGGER"];
    !is_routine(&word(0), &word(1)) && !elsewhere.contains(&word(0).as_str())
}

/// Positions of a text that lack parts.
#[derive(Default)]
struct Lacking {
    /// Points, and arrays of which an element does.
    names: BTreeSet<String>,
    /// A motion has one.
    inline: bool,
}

impl Lacking {
    fn of(text: &Text) -> Self {
        let (mut all, mut line) = (Self::default(), Vec::new());
        for k in text.lines_with(b"{").filter(|k| may_lack(text.line(*k))) {
            tokens(text, k, &mut line);
            line.retain(|t| t.kind != Kind::Comment);
            let moves = line.first().is_some_and(|t| motion::word(&upper(text, t)).is_some());
            let (mut name, mut at) = (None, 0);
            while let Some(t) = line.get(at) {
                let next = if t.is(b'{') { aggregate(text, 0, &line, at).ok() } else { None };
                if next.as_ref().is_some_and(|(value, _)| value.lacks_parts()) {
                    all.inline |= moves;
                    all.names.extend(name.take().filter(|_| !moves));
                }
                match line.get(at + 1) {
                    // `P[2]=`, `XP=`
                    Some(after) if t.kind == Kind::Word && (after.is(b'=') || after.is(b'[')) => {
                        name = Some(upper(text, t));
                    }
                    _ => {}
                }
                at = next.map_or(at + 1, |(_, next)| next);
            }
        }
        all
    }
}

/// Whether a line names some of the parts of a position, but not all of them.
fn may_lack(line: &[u8]) -> bool {
    let named = |letter: u8| {
        let part = |w: &[u8]| w[1].eq_ignore_ascii_case(&letter) && !w[0].is_ascii_alphanumeric() && w[0] != b'_';
        line.windows(3).any(|w| part(w) && matches!(w[2], b' ' | b'\t' | b'+' | b'-'))
    };
    let given = b"XYZABC".iter().filter(|letter| named(**letter)).count();
    (1..6).contains(&given) || given == 6 && memchr::memchr_iter(b'{', line).count() > 1
}

/// What may come before anything else that leads the robot to a place.
enum First {
    /// A goal in line that lacks parts.
    Lacking,
    /// A goal by its name, without its index.
    Named(String),
    Call(String),
}

/// What the routines of a text may begin with, each with the routine's name.
struct Begins(Vec<(String, First)>);

/// How far the text of a routine is read.
#[derive(Default)]
struct Way {
    routine: String,
    /// Blocks that are open.
    depth: usize,
    /// The robot is certainly led to a whole place before what follows.
    led: bool,
    /// Something may be passed by.
    jumps: bool,
}

impl Begins {
    fn of(text: &Text) -> Self {
        let (mut all, mut way) = (Vec::new(), Way::default());
        each_line(text, |routine, line| {
            if way.routine != routine {
                way = Way { routine: routine.into(), ..Way::default() };
            }
            let Some(first) = line.first().filter(|_| !way.led) else { return };
            let word = upper(text, first);
            match word.as_str() {
                "IF" | "FOR" | "WHILE" | "LOOP" | "REPEAT" | "SWITCH" => way.depth += 1,
                "ENDIF" | "ENDFOR" | "ENDWHILE" | "ENDLOOP" | "UNTIL" | "ENDSWITCH" => {
                    way.depth = way.depth.saturating_sub(1);
                }
                "GOTO" => way.jumps = true,
                _ => {}
            }
            let Some(moves) = motion::word(&word) else {
                let called = if runs_here(text, line) { calls(text, line) } else { Vec::new() };
                return all.extend(called.into_iter().map(|name| (routine.into(), First::Call(name))));
            };
            if moves.relative {
                return;
            }
            let at = if moves.arc { motion::second(line) } else { Some(1) };
            let (goal, whole) = at.map(|at| goal(text, line, at)).unwrap_or_default();
            all.extend(goal.map(|goal| (routine.into(), goal)));
            way.led = whole && way.depth == 0 && !way.jumps;
        });
        Self(all)
    }
}

/// The goal at token `at` if it may lack parts, and whether it is a whole place if it does not.
///
/// `goal = aggregate | name ...`
fn goal(text: &Text, line: &[Token], at: usize) -> (Option<First>, bool) {
    match line.get(at) {
        Some(t) if t.is(b'{') => match aggregate(text, 0, line, at) {
            Ok((value, _)) => (value.lacks_parts().then_some(First::Lacking), is_whole(&value)),
            Err(_) => (None, false),
        },
        Some(t) if t.kind == Kind::Word => {
            let name = upper(text, t);
            if is_place(&name) { (None, false) } else { (Some(First::Named(name)), true) }
        }
        _ => (None, false),
    }
}

/// Whether nothing stays where the robot stands.
fn is_whole(value: &Aggregate) -> bool {
    let has = |names: [&str; 6]| names.iter().all(|name| value.component(name).is_some());
    has(["X", "Y", "Z", "A", "B", "C"]) || has(["A1", "A2", "A3", "A4", "A5", "A6"])
}
