//! What a statement that is no motion means for the next one: whether it goes on there, waits, jumps away, opens a block.
//!
//! A jump leaves the next statement reached as before: only the label to which it leads is reached from elsewhere. So
//! `IF R[1]=1,JMP LBL[2]` ends nothing that is known of the joints, and `IF R[1]=1,CALL GRIP` ends no more than its call.
//! Grammar read here: `IF <condition>,<action>`, `IF (<condition>) THEN`, `ELSE`, `ENDIF`, `SELECT R[n]=<value>,<action>`,
//! `=<value>,<action>`, `ELSE,<action>`, `FOR`, `ENDFOR`, `LBL[n]`, `JMP LBL[n]`, `CALL name(...)`; an action is a jump, a call, or an
//! assignment.

use super::statement::{Statement, is_comment, name_of, program_name};
use super::triggers::Action;
use super::{instruction, motion};
use crate::script::blocks::is_entered;
use crate::script::called::Called;
use crate::script::cursor::integer;
use crate::script::held::{self, Effects, Event};
use crate::script::last;
use crate::script::lex::text_of;
use crate::script::{Break, StepKind, Text};
use std::collections::{BTreeSet, HashMap};
use std::ops::Range;

#[derive(Debug, Clone)]
pub(super) enum Flow {
    /// Nothing.
    On,
    /// A label, by its number where that is written.
    Label(Option<u64>),
    /// It goes on at a label, at the end of the program, or with the next statement.
    Jump(Jump),
    /// A block opens, goes on with its other branch, closes.
    Open(Break),
    /// A loop with constant bounds opens.
    Round,
    Middle,
    Close(Break),
    /// It calls a program, perhaps, and goes on; upper case.
    Call(String),
    /// An instruction that is not known and may be a macro of this name; upper case.
    Macro(String),
    /// All else.
    Step(StepKind),
}

/// Where a jump leads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Jump {
    /// `None`: the end of the program.
    pub label: Option<Label>,
    /// It is always taken.
    pub always: bool,
}

/// A label to which something jumps: its number, or any.
pub(super) type Label = Option<u64>;

/// `flow = label | jump | call | "END" | "ABORT" | branch | "FOR" ... | "ENDFOR" | instruction`,
/// `branch = ("IF" ... | "SELECT" ... | "ELSE" | "=" ...) "," action | "IF" ... "THEN" | "ELSE" | "ENDIF"`
pub(super) fn read(text: &Text, words: &[Range<usize>]) -> Flow {
    let Some(first) = words.first() else { return Flow::On };
    let all: Vec<Vec<u8>> = words.iter().map(|w| text.slice(w.clone()).to_ascii_uppercase()).collect();
    let whole = all.join(&b' ');
    let other = || match instruction::macro_name(text, words) {
        Some(name) => Flow::Macro(name),
        None => instruction::read(text, words).map_or(Flow::On, Flow::Step),
    };
    let name = name_of(&all[0]);
    // `WAIT DI[1]=ON TIMEOUT,LBL[2]` names labels, too: they are found by the caller
    match name {
        b"LBL" | b"MRK" if all[0][name.len()..].starts_with(b"[") => Flow::Label(number(&all[0])),
        b"JMP" | b"SPRUNG" => jump(&whole, true).unwrap_or_else(other),
        b"CALL" | b"AUFRUF" => call(&whole).unwrap_or_else(other),
        b"END" | b"ABORT" if words.len() == 1 => Flow::Jump(Jump { label: None, always: true }),
        b"IF" | b"WENN" if all.last().is_some_and(|w| w == b"THEN") => Flow::Open(Break::Jump),
        b"FOR" if words.len() > 1 && is_entered(&whole) => Flow::Round,
        b"FOR" if words.len() > 1 => Flow::Open(Break::Loop),
        b"ENDFOR" if words.len() == 1 => Flow::Close(Break::Loop),
        b"ENDIF" if words.len() == 1 => Flow::Close(Break::Jump),
        b"ELSE" if words.len() == 1 && first.len() == 4 => Flow::Middle,
        b"IF" | b"WENN" | b"SELECT" | b"ELSE" => action(&whole).unwrap_or_else(other),
        b"" if whole.starts_with(b"=") => action(&whole).unwrap_or_else(other),
        _ => other(),
    }
}

/// What stands after the first comma outside of brackets, where that is an action whose effect is known.
///
/// `branch = condition "," (jump | call | assignment)`
fn action(whole: &[u8]) -> Option<Flow> {
    let mut depth = 0_usize;
    let comma = whole.iter().position(|b| {
        match b {
            b'[' | b'(' => depth += 1,
            b']' | b')' => depth = depth.saturating_sub(1),
            _ => {}
        }
        *b == b',' && depth == 0
    })?;
    let action = whole[comma + 1..].trim_ascii();
    jump(action, false).or_else(|| call(action)).or_else(|| instruction::assigns(action).then_some(Flow::On))
}

/// `JMP LBL[3]`; any label where its number is computed.
///
/// `jump = ("JMP" | "SPRUNG") ("LBL" | "MRK") "[" index "]"`
fn jump(action: &[u8], always: bool) -> Option<Flow> {
    let mut words = action.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
    let (word, label) = (words.next()?, words.next()?);
    let jumps = matches!(word, b"JMP" | b"SPRUNG") && (label.starts_with(b"LBL[") || label.starts_with(b"MRK["));
    jumps.then(|| Flow::Jump(Jump { label: Some(number(label)), always }))
}

/// `CALL GRIP`, `CALL GRIP(1,R[2])`; a name that is computed is none.
///
/// `call = ("CALL" | "AUFRUF") name ["(" arguments ")"]`
fn call(action: &[u8]) -> Option<Flow> {
    let rest = [&b"CALL "[..], b"AUFRUF "].iter().find_map(|w| action.strip_prefix(*w))?.trim_ascii();
    let name = program_name(rest);
    let after = rest[name.len()..].trim_ascii();
    let arguments = after.is_empty() || after.starts_with(b"(") && after.ends_with(b")");
    (!name.is_empty() && arguments).then(|| Flow::Call(text_of(name).into_owned()))
}

/// The number in brackets, `LBL[3]`, `LBL[3:end]`.
///
/// `label = ("LBL" | "MRK") "[" number [":" name] "]"`
fn number(word: &[u8]) -> Option<u64> {
    let open = memchr::memchr(b'[', word)? + 1;
    let inside = word[open..].split(|b| matches!(b, b']' | b':')).next()?.trim_ascii();
    integer(inside)
}

/// Labels that a statement names besides being one: all to which it may jump.
///
/// `statement = ... ("LBL" | "MRK") "[" number ... "]" ...`
pub(super) fn named(text: &Text, words: &[Range<usize>]) -> Vec<Label> {
    let mut out = Vec::new();
    for word in words {
        let bytes = text.slice(word.clone());
        let ends = |at: usize| at.checked_sub(1).and_then(|k| bytes.get(k)).is_some_and(|b| b"LlKk".contains(b));
        if !memchr::memchr_iter(b'[', bytes).any(ends) {
            continue;
        }
        let bytes = bytes.to_ascii_uppercase();
        for mark in [&b"LBL["[..], b"MRK["] {
            out.extend(memchr::memmem::find_iter(&bytes, mark).map(|at| number(&bytes[at..])));
        }
    }
    out
}

/// Statements as what they switch on and off, and the first event of each.
fn events(text: &Text, all: &[(Statement, Vec<Range<usize>>)]) -> (Vec<Event>, Vec<usize>) {
    let (mut events, mut first) = (Vec::new(), Vec::with_capacity(all.len()));
    for (statement, words) in all {
        first.push(events.len());
        let comment = statement.pieces.first().is_some_and(|p| is_comment(text.slice(p.clone())));
        let said = if comment { None } else { motion::read(text, statement, words) };
        let flow = if comment || said.is_some() { Flow::On } else { read(text, words) };
        let name = |label: Label| label.map(|n| n.to_string());
        let calls =
            |w: &Range<usize>| matches!(name_of(&text.slice(w.clone()).to_ascii_uppercase()), b"CALL" | b"AUFRUF");
        let event = match (instruction::leads(text, words).filter(|_| !comment), flow) {
            (Some(event), _) => event,
            (_, Flow::Label(label)) => name(label).map_or(Event::Other, Event::Label),
            (_, Flow::Round) => Event::Open(true),
            (_, Flow::Open(kind)) => Event::Open(kind == Break::Loop),
            (_, Flow::Middle) => Event::Middle,
            (_, Flow::Close(_)) => Event::Close,
            (_, Flow::Jump(Jump { label: None, .. })) => Event::End,
            (_, Flow::Call(name)) if words.first().is_some_and(calls) => Event::Call(name),
            // a condition stands before it
            (_, Flow::Call(name)) => {
                events.extend([Event::Open(false), Event::Call(name)]);
                Event::Close
            }
            _ => Event::Other,
        };
        let label = matches!(event, Event::Label(_));
        events.push(event);
        let actions = said.map(|said| said.actions).unwrap_or_default();
        events.extend(actions.iter().filter_map(|action| event_of(text, action)));
        if !comment && !label {
            events.extend(named(text, words).into_iter().map(|label| Event::Jump(name(label))));
        }
    }
    (events, first)
}

/// What an instruction that a motion runs switches on and off.
fn event_of(text: &Text, action: &Action) -> Option<Event> {
    let called = || match read(text, &action.words) {
        Flow::Call(name) => Some(Event::Call(name)),
        _ => None,
    };
    instruction::leads(text, &action.words).or_else(called)
}

/// What a program switches on and off, where it leads the robot away from its positions or calls others.
pub(super) fn switches(text: &Text, all: &[(Statement, Vec<Range<usize>>)]) -> Vec<Event> {
    events(text, all).0
}

/// What leads the robot away from its positions before each statement, as bits, whichever way the program came there; `called`: what the
/// programs do that it calls.
pub(super) fn led(text: &Text, all: &[(Statement, Vec<Range<usize>>)], called: &Effects) -> Vec<u32> {
    let comment = |s: &Statement| s.pieces.first().is_some_and(|p| is_comment(text.slice(p.clone())));
    let leads = |(s, words): &(Statement, Vec<Range<usize>>)| {
        let begins = |words: &[Range<usize>]| instruction::leads(text, words).is_some();
        // a motion without options runs nothing
        let on_the_way = || {
            words.len() > 4
                && motion::read(text, s, words).is_some_and(|said| said.actions.iter().any(|a| begins(&a.words)))
        };
        !comment(s) && (begins(words) || on_the_way())
    };
    if called.is_empty() && !all.iter().any(leads) {
        return Vec::new();
    }
    let (events, first) = events(text, all);
    let states = held::before_each(&events, held::from_before(&events), called);
    first.into_iter().map(|k| states.get(k).copied().unwrap_or_default()).collect()
}

/// Statements whose motions may come last before one of those that are `asked` for, by their numbers, ascending.
pub(super) fn last_before(text: &Text, all: &[(Statement, Vec<Range<usize>>)], asked: &[usize]) -> BTreeSet<usize> {
    if asked.is_empty() {
        return BTreeSet::new();
    }
    let moves = |(_, (statement, words)): &(usize, &(Statement, Vec<Range<usize>>))| {
        let comment = statement.pieces.first().is_some_and(|p| is_comment(text.slice(p.clone())));
        !comment && motion::read(text, statement, words).is_some()
    };
    let moves = all.iter().enumerate().filter(moves).map(|(k, _)| k).collect();
    let (events, first) = events(text, all);
    last::before(&events, &first, &moves, asked)
}

/// Labels to which nothing jumps but from statements between which and the label nothing moves, and which are reached from above, too: a
/// program that waits there comes from where it stands.
pub(super) fn labels_reached_at_rest(
    text: &Text,
    all: &[(Statement, Vec<Range<usize>>)],
    still: &Called,
) -> BTreeSet<u64> {
    let mut stretch = 0_u64;
    // in which stretch nothing leads on from above
    let mut ended = None;
    let mut defined: HashMap<u64, Vec<Option<u64>>> = HashMap::new();
    let mut jumps: Vec<(Label, u64)> = Vec::new();
    for (statement, words) in all {
        let first = statement.pieces.first().map_or(&[][..], |p| text.slice(p.clone()));
        if is_comment(first) {
            continue;
        }
        let moves = statement.nested || motion::read(text, statement, words).is_some();
        let flow = if moves { Flow::On } else { read(text, words) };
        let busy = match &flow {
            Flow::On => moves,
            Flow::Label(_) | Flow::Jump(_) | Flow::Step(StepKind::Dwell(_)) => false,
            Flow::Call(name) => still.waits(name).is_none(),
            Flow::Macro(name) => !still.is_still_macro(name),
            Flow::Open(_) | Flow::Round | Flow::Middle | Flow::Close(_) | Flow::Step(_) => true,
        };
        stretch += u64::from(busy);
        match flow {
            Flow::Label(Some(n)) => {
                defined.entry(n).or_default().push(Some(stretch).filter(|_| ended != Some(stretch)))
            }
            Flow::Label(None) => return BTreeSet::new(),
            flow => {
                if matches!(flow, Flow::Jump(jump) if jump.always) {
                    ended = Some(stretch);
                }
                jumps.extend(named(text, words).into_iter().map(|label| (label, stretch)));
            }
        }
        // a jump out of a motion or a block leaves from within
        stretch += u64::from(busy);
    }
    if jumps.iter().any(|j| j.0.is_none()) {
        return BTreeSet::new();
    }
    let quiet = |n: u64, at: &[Option<u64>]| match at {
        [Some(at)] => jumps.iter().all(|j| j.0 != Some(n) || j.1 == *at),
        _ => false,
    };
    defined.iter().filter(|(n, at)| quiet(**n, at)).map(|(n, _)| *n).collect()
}
