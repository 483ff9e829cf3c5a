//! What leads the robot away from its points, line by line: a conveyor (`CONVEYOR.FOLLOW`), a sensor (`RSI_ON`), offsets of the joints
//! (`$JOINT_OFFSET[1]=0.2`), a function generator (`$TECH[1].MODE=#CYCLE`), which weaves.
//!
//! It is followed through labels, branches and loops ([`held`]): what one way leaves on is on. What is on at the end of a routine may hold in
//! all of them, from their start; what it ends without having begun it, too. What is on where a routine of the program is called is on in it.

use super::calls::calls;
use super::lex::{Kind, Token, begins_with, first_word, in_upper, tokens, upper};
use super::statement::{is_label, is_routine, routine_name};
use crate::script::Text;
use crate::script::held::{self, Effects, Event};

const CONVEYOR: u32 = 1;
const SENSOR: u32 = 2;
const OFFSET: u32 = 4;
const GENERATOR: u32 = 8;

/// What leads the robot before each line; empty: nothing in the text does.
#[derive(Default)]
pub(super) struct Led(Vec<u32>);

impl Led {
    /// Of a program's text; `called`: what the routines of other files do that it calls.
    pub fn of(text: &Text, called: &Effects) -> Self {
        if called.is_empty() && !mentions(text) {
            return Self::default();
        }
        let mut routines: Vec<Vec<Event>> = vec![Vec::new()];
        let mut names = vec![String::new()];
        // those that interrupts call, at any place
        let mut striking: Vec<String> = Vec::new();
        // where the events of each line begin in its routine
        let mut first: Vec<(usize, usize)> = Vec::new();
        let mut line = Vec::new();
        for k in 0..text.line_count() {
            tokens(text, k, &mut line);
            line.retain(|t| t.kind != Kind::Comment);
            let word = line.first().map(|t| upper(text, t)).unwrap_or_default();
            if is_routine(&word, &line.get(1).map(|t| upper(text, t)).unwrap_or_default()) {
                routines.push(Vec::new());
                names.push(routine_name(text, &line));
            }
            if line.iter().take(2).any(|t| in_upper(text, t) == "INTERRUPT") {
                striking.extend(calls(text, &line));
            }
            let routine = routines.len() - 1;
            first.push((routine, routines[routine].len()));
            events(text, &line, &word, &mut routines[routine]);
        }
        let left = |starts: &[u32]| {
            let of = |(r, start): (&Vec<Event>, &u32)| held::before_each(r, start | held::from_before(r), called);
            routines.iter().zip(starts).map(of).collect::<Vec<Vec<u32>>>()
        };
        let first_states = left(&vec![0; routines.len()]);
        // what is on at the end of one may be on in all
        let after = first_states.iter().filter_map(|states| states.last()).fold(0, |all, s| all | s);
        let ever = first_states.iter().flatten().fold(after, |all, s| all | s);
        let mut starts: Vec<u32> =
            names.iter().map(|name| if striking.contains(name) { ever } else { after }).collect();
        let mut states = left(&starts);
        // what is on where a routine is called is on in it
        loop {
            let before = starts.clone();
            for (events, states) in routines.iter().zip(&states) {
                for (event, state) in events.iter().zip(states) {
                    let Event::Call(called) = event else { continue };
                    let own = starts.iter_mut().zip(&names).filter(|(_, name)| *name == called);
                    own.for_each(|(start, _)| *start |= state);
                }
            }
            if starts == before {
                break;
            }
            states = left(&starts);
        }
        Self(first.into_iter().map(|(routine, at)| states[routine].get(at).copied().unwrap_or_default()).collect())
    }

    /// Nothing leads it anywhere.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// What leads the robot at line `k`.
    pub fn by(&self, k: usize) -> Option<&'static str> {
        let bits = self.0.get(k).copied().unwrap_or_default();
        let names = [
            (CONVEYOR, "a conveyor"),
            (SENSOR, "a sensor (RSI_ON)"),
            (OFFSET, "$JOINT_OFFSET"),
            (GENERATOR, "a function generator ($TECH)"),
        ];
        names.iter().find(|n| bits & n.0 != 0).map(|n| n.1)
    }
}

/// Whether any of the words stands in the text.
///
/// `lead = "RSI_O" ... | "$JOINT_OFFSET" ... | "$TECH" ... | "CONVEYOR" ...`
fn mentions(text: &Text) -> bool {
    let is = |at: Option<usize>, word: &[u8]| {
        at.and_then(|at| text.bytes.get(at..at + word.len())).is_some_and(|b| b.eq_ignore_ascii_case(word))
    };
    memchr::memchr_iter(b'_', &text.bytes)
        .any(|k| is(k.checked_sub(3), b"RSI_O") || is(k.checked_sub(6), b"$JOINT_OFFSET"))
        || memchr::memchr_iter(b'$', &text.bytes).any(|k| is(Some(k), b"$TECH"))
        || (0..text.line_count())
            .any(|k| begins_with(text, k, b"C") && first_word(text, k).eq_ignore_ascii_case(b"CONVEYOR"))
}

/// What a line means by its tokens, without comments; `word`: the first, in upper case. At least one event.
pub(super) fn events(text: &Text, line: &[Token], word: &str, out: &mut Vec<Event>) {
    let own = event(text, line, word);
    // what stands after DO runs perhaps
    let perhaps = line.iter().any(|t| t.kind == Kind::Word && in_upper(text, t) == "DO");
    let called = calls(text, line);
    if !called.is_empty() && perhaps {
        out.push(Event::Open(false));
        out.extend(called.into_iter().map(Event::Call));
        out.push(Event::Close);
    } else {
        out.extend(called.into_iter().map(Event::Call));
    }
    out.push(own);
}

/// `lead = "CONVEYOR" "." ("FOLLOW" | "SKIP" | "QUIT" | "OFF") ... | ... ("RSI_ON" | "RSI_OFF") "(" ... | "$JOINT_OFFSET" ... "=" ... |
/// "$TECH" ["[" number "]"] ["." "MODE"] "=" ...`
fn event(text: &Text, line: &[Token], word: &str) -> Event {
    let says = |name: &str| line.iter().any(|t| t.kind == Kind::Word && upper(text, t) == name);
    if says("RSI_ON") {
        return Event::On(SENSOR);
    }
    match word {
        "CONVEYOR" => match line.get(2).map(|t| upper(text, t)).as_deref() {
            Some("FOLLOW" | "SKIP") => Event::On(CONVEYOR),
            Some("QUIT" | "OFF") => Event::Off(CONVEYOR),
            _ => Event::Other,
        },
        "$JOINT_OFFSET" => Event::On(OFFSET),
        "$TECH" if says("OFF") => Event::Off(GENERATOR),
        // another part than the mode
        "$TECH" if line.iter().any(|t| t.is(b'.')) && !says("MODE") => Event::Other,
        "$TECH" => Event::On(GENERATOR),
        _ if says("RSI_OFF") => Event::Off(SENSOR),
        "IF" | "SWITCH" => Event::Open(false),
        "LOOP" | "FOR" | "WHILE" | "REPEAT" => Event::Open(true),
        "ELSE" | "CASE" | "DEFAULT" => Event::Middle,
        "ENDIF" | "ENDSWITCH" | "ENDLOOP" | "ENDFOR" | "ENDWHILE" | "UNTIL" => Event::Close,
        "EXIT" => Event::Leave,
        "RETURN" => Event::End,
        "GOTO" => Event::Jump(line.get(1).map(|t| upper(text, t))),
        _ if is_label(line) => Event::Label(word.to_string()),
        _ => Event::Other,
    }
}
