//! What leads the robot away from its points, line by line: a conveyor (`CONVEYOR.FOLLOW`), a sensor (`RSI_ON`), offsets of the joints
//! (`$JOINT_OFFSET[1]=0.2`), a function generator (`$TECH[1].MODE=#CYCLE`), which weaves, a soft servo, a seam on which ArcTech weaves:
//! what statements [switch](super::switches).
//!
//! It is followed through labels, branches and loops ([`held`]): what one way leaves on is on. What is on at the end of a routine may hold
//! in all of them, from their start; what it ends without having begun it, too. What is on where a routine of the program is called is on
//! in it.

use super::calls::calls;
use super::lex::{Kind, Token, begins_with, first_word, in_upper, tokens, upper, word_byte};
use super::reason::Reason;
use super::statement::{is_label, is_routine, routine_name};
use super::switches::{ENDED_ANYWAY, Switches};
use crate::script::Text;
use crate::script::held::{self, Effects, Event};

/// What leads the robot.
#[derive(Default)]
pub(super) struct Led {
    /// Before each line; empty: nothing in the text does.
    before: Vec<u32>,
    switches: Switches,
}

impl Led {
    /// Of a program's text; `called`: what the routines of other files do that it calls, by the same `switches`.
    pub fn of(text: &Text, called: &Effects, mut switches: Switches) -> Self {
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
            switches_and_flow(text, (Some(k), &line), &word, &mut switches, &mut routines[routine]);
        }
        let left = |starts: &[u32]| {
            let of = |(r, start): (&Vec<Event>, &u32)| {
                held::before_each(r, start | held::from_before(r) & !ENDED_ANYWAY, called)
            };
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
        let of = |(routine, at): (usize, usize)| states[routine].get(at).copied().unwrap_or_default();
        Self { before: first.into_iter().map(of).collect(), switches }
    }

    /// Nothing leads it anywhere.
    pub fn is_empty(&self) -> bool {
        self.before.is_empty()
    }

    /// Why a motion on line `k` stays: what leads the robot there.
    pub fn by(&self, k: usize) -> Option<Reason> {
        self.switches.reason(self.before.get(k).copied().unwrap_or_default(), k)
    }
}

/// Whether any of the words stands in the text.
///
/// `lead = "RSI_O" ... | "ST_O" ... | "SET_TORQUE_LIMITS" ... | "$JOINT_OFFSET" ... | "$TORQUE_AXIS" ... | "$CURR_RED" ... | "$TECH" ... |
/// "CONVEYOR" ... | "ARC" ...`
fn mentions(text: &Text) -> bool {
    let is = |at: Option<usize>, word: &[u8]| {
        let begins = |at: usize| !at.checked_sub(1).and_then(|k| text.bytes.get(k)).is_some_and(|b| word_byte(*b));
        let same = |b: &[u8]| b.eq_ignore_ascii_case(word);
        at.is_some_and(|at| text.bytes.get(at..at + word.len()).is_some_and(same) && begins(at))
    };
    // how far from its first underscore each word begins
    const WORDS: [(usize, &[u8]); 6] = [
        (3, b"RSI_O"),
        (2, b"ST_O"),
        (3, b"SET_TORQUE_LIMITS"),
        (6, b"$JOINT_OFFSET"),
        (7, b"$TORQUE_AXIS"),
        (5, b"$CURR_RED"),
    ];
    let begins = |k: usize| {
        let word = first_word(text, k);
        word.eq_ignore_ascii_case(b"CONVEYOR") || word.get(..3).is_some_and(|w| w.eq_ignore_ascii_case(b"ARC"))
    };
    memchr::memchr_iter(b'_', &text.bytes).any(|k| WORDS.iter().any(|(before, word)| is(k.checked_sub(*before), word)))
        || memchr::memchr_iter(b'$', &text.bytes).any(|k| is(Some(k), b"$TECH"))
        || (0..text.line_count()).any(|k| begins_with(text, k, b"CA") && begins(k))
}

/// What a line of another file means by its tokens, without comments; `word`: the first, in upper case. At least one event.
pub(super) fn events(text: &Text, line: &[Token], word: &str, switches: &mut Switches, out: &mut Vec<Event>) {
    switches_and_flow(text, (None, line), word, switches, out);
}

fn switches_and_flow(
    text: &Text,
    (k, line): (Option<usize>, &[Token]),
    word: &str,
    switches: &mut Switches,
    out: &mut Vec<Event>,
) {
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
    switches.add(text, k, line, out);
    out.push(flow(text, line, word));
}

/// `flow = "IF" ... | "SWITCH" ... | loop ... | "ELSE" | "CASE" ... | "DEFAULT" | end | "EXIT" | "RETURN" ... | "GOTO" name | label`
fn flow(text: &Text, line: &[Token], word: &str) -> Event {
    match word {
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
