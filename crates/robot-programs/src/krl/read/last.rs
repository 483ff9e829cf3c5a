//! Which moves may come last before the program reads where the robot stands, or goes on from there in some parts only, along control
//! ([`reach`](crate::script::reach)).
//!
//! Routines that none of the file calls run one after the other, in any order. An interrupt strikes anywhere on a way: its routine reads
//! after no move that is known.

use super::ahead::{Ahead, passed, reads_place};
use super::in_force::ASSIGNED;
use super::partial::calls_partial;
use super::scan::{Found, Moves, Scan, own_routines};
use super::triggers::{has_trigger, triggers};
use super::versions::Names;
use crate::krl::calls::{calls, quiet};
use crate::krl::data::Data;
use crate::krl::going::Going;
use crate::krl::lex::{Kind, tokens, upper};
use crate::krl::lists::Lists;
use crate::krl::outside::Outside;
use crate::krl::reason::Reason;
use crate::krl::relative::with_callers;
use crate::krl::statement::{is_routine, routine_name};
use crate::krl::still::Still;
use crate::no_motion::NoMotion;
use crate::script::reach::{Atoms, BEFORE, Block, Event, FIRST, Reach, Routine, State, set_by};
use crate::script::{self, Goal, Move, Script, Text};
use std::collections::BTreeSet;

/// Lines, from 1, of the motions of a script after which its text may read where the robot stands.
pub(super) fn lines(texts: &[Text], data: &Data, declared: &NoMotion, script: &Script) -> BTreeSet<u64> {
    let Some(text) = texts.first() else { return BTreeSet::new() };
    let triggers = if has_trigger(text) { triggers(text, &reading(texts)) } else { Vec::new() };
    let apart: BTreeSet<usize> = triggers.iter().filter(|t| !t.before).map(|t| t.line).collect();
    let mut reads: BTreeSet<usize> = reads_place(text).into_iter().chain(calls_reading(texts)).collect();
    reads.extend(triggers.iter().filter(|t| t.own).map(|t| t.line));
    let reads: Vec<usize> = reads.difference(&apart).copied().collect();
    if reads.is_empty() && triggers.is_empty() {
        return BTreeSet::new();
    }
    let around = Around::of(texts, text, data, declared, apart);
    let moves: BTreeSet<usize> = script.lines_of_moves().into_iter().map(|line| line as usize - 1).collect();
    let mut found = BTreeSet::new();
    if !reads.is_empty() {
        let last = around.last(&moves, &reads);
        // what the line itself calls has moved before it
        let places = reads.iter().flat_map(|line| [(*line, line.saturating_sub(1)), (*line, *line)]);
        found.extend(places.flat_map(|(line, place)| last.at(line, place)).chain(last.always()));
    }
    let ahead = |n: usize| triggers.iter().filter(|t| t.ahead >= n).map(|t| t.line).collect::<BTreeSet<usize>>();
    if !ahead(1).is_empty() {
        let next = |from: &BTreeSet<usize>| {
            let lines: BTreeSet<usize> = moves.union(from).copied().collect();
            let asked: Vec<usize> = moves.iter().copied().collect();
            let last = around.last(&lines, &asked);
            let follows = |line: &usize| last.at(*line, line.saturating_sub(1)).iter().any(|k| from.contains(k));
            moves.iter().copied().filter(follows).collect::<BTreeSet<usize>>()
        };
        found.extend(next(&ahead(1)));
        let twice = ahead(2);
        if !twice.is_empty() {
            found.extend(next(&next(&twice)));
        }
    }
    found.into_iter().map(|line| line as u64 + 1).collect()
}

/// Lines, from 1, of the motions of a script that may come last before one of which the goal keeps parts of where the robot stands, or
/// before the call of a routine of another file that may begin with one.
pub(super) fn before_partial(texts: &[Text], data: &Data, declared: &NoMotion, script: &Script) -> BTreeSet<u64> {
    let Some(text) = texts.first() else { return BTreeSet::new() };
    let partial = script.moves().filter(|(_, m)| keeps_parts(m)).filter_map(|(k, _)| script.steps.get(k));
    let partial = partial.filter(|s| s.at.file == 0).map(|s| s.at.line as usize - 1);
    let asked: BTreeSet<usize> = partial.chain(calls_partial(texts)).collect();
    let asked: Vec<usize> = asked.into_iter().collect();
    if asked.is_empty() {
        return BTreeSet::new();
    }
    let triggers = if has_trigger(text) { triggers(text, &reading(texts)) } else { Vec::new() };
    let apart: BTreeSet<usize> = triggers.iter().filter(|t| !t.before).map(|t| t.line).collect();
    let moves: BTreeSet<usize> = script.lines_of_moves().into_iter().map(|line| line as usize - 1).collect();
    let last = Around::of(texts, text, data, declared, apart).last(&moves, &asked);
    let found: BTreeSet<usize> =
        asked.iter().flat_map(|line| last.at(*line, line.saturating_sub(1))).chain(last.always()).collect();
    found.into_iter().map(|line| line as u64 + 1).collect()
}

/// Whether the goal of a motion lacks parts, which stay where the robot stands.
fn keeps_parts(m: &Move) -> bool {
    match &m.goal {
        Goal::Pose(goal) => goal.rotation.is_none(),
        Goal::Opaque(script::Reason::Krl(why)) => matches!(**why, Reason::PartMissing(_)),
        _ => false,
    }
}

/// What the way of control through a text depends on.
struct Around<'a> {
    text: &'a Text,
    data: &'a Data,
    going: Going,
    outside: Outside,
    names: Names,
    still: Still,
    lists: Lists,
    passed: [BTreeSet<u64>; 2],
    apart: BTreeSet<usize>,
    own: BTreeSet<String>,
}

impl<'a> Around<'a> {
    /// `apart`: lines whose calls run elsewhere on the way.
    fn of(texts: &[Text], text: &'a Text, data: &'a Data, declared: &NoMotion, apart: BTreeSet<usize>) -> Self {
        let going = Going::of(texts);
        let outside = Outside::of(texts, &going);
        let (names, still) = (Names::of(text, data), Still::of(texts, declared));
        let lists = Ahead::of(text, data, &going, &outside).lists;
        let (passed, own) = (passed(text), own_routines(text));
        Self { text, data, going, outside, names, still, lists, passed, apart, own }
    }

    /// Which of the lines that move may come last, where it is asked.
    fn last(&self, lines: &BTreeSet<usize>, asked: &[usize]) -> Last {
        let kind = ASSIGNED + self.names.len();
        let scan = Scan {
            text: self.text,
            data: self.data,
            going: &self.going,
            outside: &self.outside,
            still: &self.still,
            lists: &self.lists,
            names: &self.names,
            own: self.own.clone(),
            passed: self.passed.clone(),
            moves: Some(Moves { lines, asked, kind, apart: &self.apart }),
            out: Found::default(),
        };
        Last::of(scan, kind)
    }
}

/// Names of the routines of all texts that read where the robot stands, themselves or by others.
fn reading(texts: &[Text]) -> BTreeSet<String> {
    with_callers(texts, texts.iter().flat_map(|t| t.known(Reading::of).0.clone()).collect())
}

/// Lines of the text that call routines of other files which read where the robot stands, themselves or by others.
fn calls_reading(texts: &[Text]) -> Vec<usize> {
    let Some((text, beside)) = texts.split_first() else { return Vec::new() };
    let found: BTreeSet<String> = beside.iter().flat_map(|t| t.known(Reading::of).0.clone()).collect();
    if found.is_empty() {
        return Vec::new();
    }
    let (found, mut line) = (with_callers(beside, found), Vec::new());
    let mut calls_one = |k: &usize| {
        tokens(text, *k, &mut line);
        line.retain(|t| t.kind != Kind::Comment);
        let word = line.first().map(|t| upper(text, t)).unwrap_or_default();
        let head = is_routine(&word, &line.get(1).map(|t| upper(text, t)).unwrap_or_default());
        let names = || calls(text, &line).into_iter().chain(quiet(text, &line));
        !head && names().any(|name| found.contains(&name))
    };
    text.lines_with(b"(").filter(|k| calls_one(k)).collect()
}

/// Routines of a text that read where the robot stands.
struct Reading(BTreeSet<String>);

impl Reading {
    fn of(text: &Text) -> Self {
        let (mut found, mut line) = (BTreeSet::new(), Vec::new());
        let own = triggers(text, &BTreeSet::new()).into_iter().filter(|t| t.before).map(|t| t.line);
        for read in reads_place(text).into_iter().chain(own) {
            let head = (0..read).rev().find_map(|k| {
                tokens(text, k, &mut line);
                line.retain(|t| t.kind != Kind::Comment);
                let word = line.first().map(|t| upper(text, t))?;
                let second = line.get(1).map(|t| upper(text, t)).unwrap_or_default();
                is_routine(&word, &second).then(|| routine_name(text, &line))
            });
            found.extend(head);
        }
        Self(found)
    }
}

/// Which moves may come last at each place.
struct Last {
    reach: Reach,
    /// First lines of the routines, but of what stands before the first one.
    first: Vec<usize>,
    /// What interrupts move.
    always: Atoms,
}

impl Last {
    /// Of a text; `kind`: the number of this kind of settings, beside the others.
    fn of(mut scan: Scan, kind: usize) -> Self {
        scan.lines();
        let Found { mut routines, first, mut interrupts, apart, .. } = scan.out;
        let called: BTreeSet<&String> = routines.iter().flat_map(|r| &r.events).filter_map(|e| callee(&e.1)).collect();
        interrupts.extend(apart.into_iter().filter(|name| !called.contains(name)));
        let free = |r: &&Routine| !r.name.is_empty() && !called.contains(&r.name) && !interrupts.contains(&r.name);
        let mut outside = vec![(0, Event::Open(Block::Endless)), (0, Event::Open(Block::Switch))];
        for routine in routines.iter().filter(free) {
            outside.extend([(0, Event::Middle(false)), (0, Event::Call(routine.name.clone()))]);
        }
        outside.extend([(0, Event::Close), (0, Event::Close)]);
        for (routine, at) in routines.iter_mut().skip(1).zip(&first) {
            if interrupts.contains(&routine.name) {
                routine.events.insert(0, (*at, Event::Set(kind, BEFORE)));
            }
        }
        let anything = || -> State { vec![Atoms::from([BEFORE]); kind + 1] };
        let always = set_by(&routines, &interrupts, kind + 1).pop().unwrap_or_default();
        routines.push(Routine { name: String::new(), events: outside });
        let starts: Vec<Option<State>> = (0..routines.len())
            .map(|k| (k == 0 || k + 1 == routines.len() || interrupts.contains(&routines[k].name)).then(anything))
            .collect();
        let reach = Reach::of(&routines, &starts, &anything());
        Self { reach, first, always }
    }

    /// Lines that may come last at `place` of the routine in which `line` stands.
    fn at(&self, line: usize, place: usize) -> BTreeSet<usize> {
        let state = self.reach.after(self.first.partition_point(|f| *f <= line), place);
        state.and_then(|s| s.last()).map(lines_of).unwrap_or_default()
    }

    /// Lines that may come last anywhere.
    fn always(&self) -> BTreeSet<usize> {
        lines_of(&self.always)
    }
}

fn lines_of(atoms: &Atoms) -> BTreeSet<usize> {
    atoms.iter().filter_map(|atom| Some(atom.checked_sub(FIRST)? as usize)).collect()
}

fn callee(event: &Event) -> Option<&String> {
    match event {
        Event::Call(name) => Some(name),
        _ => None,
    }
}
