//! What routines of other files of the project leave behind when the program calls them: another base or tool, another way in which the
//! tool turns, a sensor or a conveyor that leads the robot.
//!
//! Read are the routines (`DEF`, `DEFFCT`) that the program's text names before a bracket, and those that they name in turn. A routine of
//! the program itself goes before one of the same name elsewhere; of several elsewhere any may be meant. A routine that no file of the
//! project has leaves everything as it was.

use super::calls::calls;
use super::going::{Going, Turning};
use super::led;
use super::lex::{Kind, Token, begins_with, first_word, in_upper, tokens, upper};
use super::lists::{LISTS, Lists, as_set};
use super::reason::MovesBase;
use super::statement::{assignment, is_routine};
use super::still::may_begin_routine;
use super::switches::Switches;
use crate::script::Text;
use crate::script::cursor::integer;
use crate::script::held::Event;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// What the routines do that the program calls, itself or by others.
#[derive(Default)]
pub(super) struct Outside {
    pub(super) turning: Turning,
    /// What each of them sets, itself or by others.
    pub(super) sets: BTreeMap<String, Sets>,
    /// Elements of `BASE_DATA` and `TOOL_DATA` that they set.
    pub(super) lists: Lists,
    /// What each of them switches on and off.
    pub(super) events: Vec<(String, Vec<Event>)>,
    /// By what those are told, and those of the program itself.
    pub(super) switches: Switches,
}

/// What a routine sets.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Sets {
    /// `$BASE`, `$TOOL`.
    pub(super) frames: [bool; 2],
    /// A variable that makes any base mean something else.
    pub(super) carried: Option<MovesBase>,
    pub(super) moved: Option<MovesBase>,
    /// Other variables.
    pub(super) assigned: BTreeSet<String>,
    /// Routines that it calls.
    pub(super) calls: BTreeSet<String>,
}

impl Sets {
    /// Whether it sets nothing that a frame may depend on.
    pub(super) fn is_empty(&self) -> bool {
        self.frames == [false; 2] && self.carried.is_none() && self.moved.is_none()
    }

    fn add(&mut self, other: &Self) {
        self.frames.iter_mut().zip(other.frames).for_each(|(own, other)| *own |= other);
        (self.carried, self.moved) = (self.carried.or(other.carried), self.moved.or(other.moved));
        self.assigned.extend(other.assigned.iter().cloned());
        self.calls.extend(other.calls.iter().cloned());
    }
}

/// Names of the routines of a text, and their lines.
#[derive(Default)]
struct Routines(Vec<(String, Range<usize>)>);

impl Routines {
    /// `routine = ["GLOBAL"] ("DEF" | "DEFFCT") ... name "(" ...`
    fn of(text: &Text) -> Self {
        let mut all: Vec<(String, Range<usize>)> = Vec::new();
        let mut line = Vec::new();
        for k in 0..text.line_count() {
            if !(begins_with(text, k, b"DG") && may_begin_routine(first_word(text, k))) {
                continue;
            }
            tokens(text, k, &mut line);
            let words: Vec<_> = line.iter().take(2).map(|t| in_upper(text, t)).collect();
            if !matches!(words.as_slice(), [first, second] if is_routine(first, second)) {
                continue;
            }
            let open = line.iter().position(|t| t.is(b'('));
            let name = open.and_then(|o| o.checked_sub(1)).map(|n| upper(text, &line[n])).unwrap_or_default();
            if let Some(before) = all.last_mut() {
                before.1.end = k;
            }
            all.push((name, k + 1..text.line_count()));
        }
        Self(all)
    }
}

/// Routines of other files, by name.
type Known<'a> = BTreeMap<String, Vec<(&'a Text, Range<usize>)>>;

/// Whether a line that begins with this word in upper case says that there is a routine elsewhere, and calls none: `EXT pick()`.
///
/// `declaration = ("EXT" | "EXTFCT" | "EXTP" | "EXTFCTP") ... name "(" ...`
pub(super) fn declares_routine(first: &[u8]) -> bool {
    matches!(first, b"EXT" | b"EXTFCT" | b"EXTP" | b"EXTFCTP")
}

/// The name of the first routine of a text, in upper case: the program itself.
pub(super) fn first_routine(text: &Text) -> Option<String> {
    text.known(Routines::of).0.first().map(|routine| routine.0.clone())
}

impl Outside {
    /// Of the program's text, which comes first, and the rest of its project.
    pub(super) fn of(texts: &[Text], going: &Going) -> Self {
        let mut outside = Self { switches: Switches::of(texts), ..Self::default() };
        let (Some(own), true) = (texts.first(), texts.iter().any(|t| t.context)) else { return outside };
        let own_names: BTreeSet<String> = own.known(Routines::of).0.iter().map(|r| r.0.clone()).collect();
        let mut known = Known::new();
        for text in texts.iter().filter(|t| t.context) {
            for (name, lines) in text.known(Routines::of).0.iter().filter(|r| !own_names.contains(&r.0)) {
                known.entry(name.clone()).or_default().push((text, lines.clone()));
            }
        }
        let mut open = called(own, 0..own.line_count(), &known);
        let mut seen = BTreeSet::new();
        while let Some(name) = open.pop_first() {
            if !seen.insert(name.clone()) {
                continue;
            }
            for (text, lines) in known.get(&name).into_iter().flatten() {
                outside.routine(&name, text, lines.clone(), going);
                open.extend(called(text, lines.clone(), &known));
            }
        }
        outside.close();
        outside
    }

    /// Whether another file of the project calls the first routine of the program: it starts there.
    pub(super) fn calls_start(texts: &[Text]) -> bool {
        let Some(own) = texts.first() else { return false };
        let own = own.known(Routines::of);
        let Some((start, _)) = own.0.first() else { return false };
        let known = Known::from([(start.clone(), Vec::new())]);
        let others = texts.iter().filter(|t| t.context);
        // one that has a routine of this name calls its own
        let others = others.filter(|t| !t.known(Routines::of).0.iter().any(|r| r.0 == *start));
        let declares = |t: &Text, k: usize| declares_routine(&first_word(t, k).to_ascii_uppercase());
        let mut lines = others.flat_map(|t| (0..t.line_count()).map(move |k| (t, k)));
        lines.any(|(t, k)| !declares(t, k) && !called(t, k..k + 1, &known).is_empty())
    }

    /// What a routine of another file sets that the program calls.
    pub(super) fn sets_of(&self, name: &str) -> Sets {
        self.sets.get(name).cloned().unwrap_or_default()
    }

    /// What a routine calls sets what it sets.
    fn close(&mut self) {
        loop {
            let mut next = self.sets.clone();
            for sets in next.values_mut() {
                for called in sets.calls.clone() {
                    if let Some(by) = self.sets.get(&called) {
                        sets.add(by);
                    }
                }
            }
            if next == self.sets {
                return;
            }
            self.sets = next;
        }
    }

    /// Adds what a routine does.
    fn routine(&mut self, name: &str, text: &Text, lines: Range<usize>, going: &Going) {
        let (mut line, mut events, mut sets) = (Vec::new(), Vec::new(), Sets::default());
        for k in lines {
            tokens(text, k, &mut line);
            line.retain(|t| t.kind != Kind::Comment);
            let Some(first) = line.first() else { continue };
            let word = upper(text, first);
            led::events(text, &line, &word, &mut self.switches, &mut events);
            self.turning = self.turning.max(going.turning(text, &line, &word).unwrap_or_default());
            self.setting(text, &line, &word, &mut sets);
            if !word.starts_with('$') && assignment(&line).is_some() {
                sets.assigned.insert(word);
            }
            sets.calls.extend(calls(text, &line));
        }
        self.sets.entry(name.to_string()).or_default().add(&sets);
        self.events.push((name.to_string(), events));
    }

    /// A statement that sets frames, or what they mean.
    ///
    /// `setting = "BAS" "(" "#" command ... | variable ["[" number "]" | "." field] "=" ...`
    fn setting(&mut self, text: &Text, line: &[Token], word: &str, sets: &mut Sets) {
        let is_set = || assignment(line).is_some();
        let frames = match word {
            "BAS" => match line.get(3).map(|t| upper(text, t)).as_deref() {
                Some("BASE" | "EX_BASE") => [true, false],
                Some("TOOL") => [false, true],
                Some("INITMOV" | "FRAMES" | "CP_PARAMS" | "PTP_PARAMS") => [true, true],
                _ => [false, false],
            },
            "$BASE" => [is_set(), false],
            "$TOOL" => [false, is_set()],
            "FDAT_ACT" => [is_set(); 2],
            "$IPO_MODE" if is_set() => {
                let back = line.last().is_some_and(|t| upper(text, t) == "BASE");
                sets.carried = sets.carried.or_else(|| (!back).then_some(MovesBase::IpoMode));
                return;
            }
            "$WORLD" | "$ROBROOT" if is_set() => {
                sets.moved = Some(MovesBase::of_world(word));
                return;
            }
            _ => {
                if let Some(list) = LISTS.iter().position(|l| *l == word).filter(|_| is_set()) {
                    let index = line.get(2).filter(|_| line.get(3).is_some_and(|t| t.is(b']')));
                    let number: Option<u32> = index.and_then(|t| integer(text.slice(t.span())));
                    let mut set = Lists::default();
                    set.set(list, number.map(f64::from), as_set);
                    self.lists.add(&set);
                }
                return;
            }
        };
        sets.frames.iter_mut().zip(frames).for_each(|(all, own)| *all |= own);
    }
}

/// The routines of other files that lines of a text name before a bracket.
///
/// `call = name "(" ...`
fn called(text: &Text, lines: Range<usize>, known: &Known) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut line = Vec::new();
    for k in lines {
        if memchr::memchr(b'(', text.line(k)).is_none() {
            continue;
        }
        tokens(text, k, &mut line);
        line.retain(|t| t.kind != Kind::Comment);
        found.extend(calls(text, &line).into_iter().filter(|name| known.contains_key(name)));
    }
    found
}
