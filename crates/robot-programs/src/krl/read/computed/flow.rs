//! Which assignments may have been the last at each line: along control, through the routines of the file.

use super::assigned::Assigned;
use super::numbers::goes_elsewhere;
use super::{Around, Var};
use crate::krl::calls::is_quiet;
use crate::krl::lex::{Token, first_word, in_upper};
use crate::krl::outside::Outside;
use crate::krl::read::scan::{Found, Scan};
use crate::krl::read::versions::Names;
use crate::krl::relative::each_line;
use crate::script::Text;
use crate::script::reach::{Atoms, BEFORE, Event, FIRST, Reach, Routine, State};
use std::collections::{BTreeMap, BTreeSet};

/// Control, and what is called where.
pub(super) struct Flow {
    /// What leads where, without what is set.
    routines: Vec<Routine>,
    /// First lines of the routines but of what stands before the first one.
    pub first: Vec<usize>,
    /// Routines that may also be called by others than those of the text.
    open: Vec<bool>,
    /// Names of those that run at any time.
    any_time: BTreeSet<String>,
    /// Whether what no file has may call a routine of the text.
    is_open: bool,
}

/// The names under which something of no file is called, and something that may call the text again.
const STRANGE: &str = "?";
const BACK: &str = "??";

impl Flow {
    /// Of a program. `own`: its routines. `None`: where it goes on is not certain, after an interrupt whose routine resumes it elsewhere,
    /// or which no file has.
    pub fn of(texts: &[Text], own: BTreeSet<String>, around: Around, assigned: &Assigned) -> Option<Self> {
        let text = texts.first()?;
        let names = Names::default();
        let Around { data, going, outside, still, lists } = around;
        let passed = Default::default();
        let out = Found::default();
        let mut scan = Scan {
            text,
            data,
            going,
            outside,
            still,
            lists,
            names: &names,
            own: own.clone(),
            passed,
            moves: None,
            out,
        };
        scan.lines();
        let Found { mut routines, first, interrupts, .. } = scan.out;
        routines.iter_mut().for_each(|r| r.events.retain(|e| !matches!(e.1, Event::Set(..) | Event::Reset(..))));
        let back = |name: &str| outside.sets.get(name).is_some_and(|sets| sets.calls.iter().any(|c| own.contains(c)));
        let unknown = |name: &str| !own.contains(name) && !outside.sets.contains_key(name) && !is_quiet(name);
        let calls_unknown =
            |name: &str| outside.sets.get(name).is_some_and(|sets| sets.calls.iter().any(|c| unknown(c)));
        let strange = |name: &str| unknown(name) || calls_unknown(name);
        let is_global = |line: &usize| first_word(text, *line).eq_ignore_ascii_case(b"GLOBAL");
        let mut any_time: BTreeSet<String> = assigned.at_any_time.union(&interrupts).cloned().collect();
        if texts.iter().any(|t| t.context && runs_aside(t)) {
            // it may call what other files see
            let globals = first.iter().zip(routines.iter().skip(1)).filter(|(line, _)| is_global(line));
            any_time.extend(globals.map(|(_, routine)| routine.name.clone()));
        }
        let any_time = with_called(any_time, &routines, outside);
        if any_time.iter().any(|name| unknown(name)) || any_time.intersection(&resuming(texts)).next().is_some() {
            return None;
        }
        for (_, event) in routines.iter_mut().flat_map(|r| &mut r.events) {
            if let Event::Call(name) = event {
                match () {
                    () if own.contains(name.as_str()) => {}
                    () if back(name) => *name = BACK.into(),
                    () if strange(name) => *name = STRANGE.into(),
                    () => {}
                }
            }
        }
        for routine in &mut routines {
            routine.events = conditions_first(text, std::mem::take(&mut routine.events));
        }
        let main = routines.iter().position(|r| !r.name.is_empty()).unwrap_or_default();
        let is_open = |k: usize| {
            let global = k.checked_sub(1).and_then(|k| first.get(k)).is_some_and(is_global);
            k <= main || global || routines.get(k).is_some_and(|r| any_time.contains(&r.name))
        };
        let open = (0..routines.len()).map(is_open).collect();
        let is_open = first.iter().any(is_global);
        Some(Self { routines, first, open, is_open, any_time })
    }

    /// Whether the routine of this number may run at any time.
    pub fn at_any_time(&self, routine: usize) -> bool {
        self.routines.get(routine).is_some_and(|r| self.any_time.contains(&r.name))
    }

    /// What may have been assigned last to variables. A local one is another one each time that its routine is called: no call changes it.
    pub fn reach(&self, assigned: &Assigned, vars: &[Var], local: bool, global: &dyn Fn(&Var) -> bool) -> Reach {
        let kinds: BTreeMap<Var, usize> = vars.iter().enumerate().map(|(k, var)| (*var, k)).collect();
        let mut sets: Vec<Vec<(usize, Event)>> = vec![Vec::new(); self.routines.len()];
        let mut put = |line: usize, kind: usize, atom: u32| {
            let routine = self.first.partition_point(|first| *first <= line);
            sets.get_mut(routine).into_iter().for_each(|all| all.push((line, Event::Set(kind, atom))));
        };
        for a in &assigned.all {
            kinds.get(&a.var).into_iter().for_each(|kind| put(a.line, *kind, FIRST + a.line as u32));
        }
        let with = |(routine, sets): (&Routine, Vec<(usize, Event)>)| {
            let mut events = routine.events.clone();
            events.retain(|e| !(local && matches!(e.1, Event::Call(_))));
            events.extend(sets);
            // on a line what it calls comes before what it assigns
            events.sort_by_key(|e| e.0);
            Routine { name: routine.name.clone(), events }
        };
        let mut routines: Vec<Routine> = self.routines.iter().zip(sets).map(with).collect();
        let changes = |name: &str, may: &dyn Fn(&Var) -> bool| {
            let of = |(var, kind): (&Var, &usize)| may(var).then_some((0, Event::Set(*kind, BEFORE)));
            Routine { name: name.into(), events: kinds.iter().filter_map(of).collect() }
        };
        routines.push(changes(STRANGE, &|var| self.is_open || global(var)));
        routines.push(changes(BACK, &|_| true));
        let unknown: State = vec![Atoms::from([BEFORE]); vars.len()];
        let start = |k: usize| (local || self.open.get(k) == Some(&true)).then(|| unknown.clone());
        let starts: Vec<Option<State>> = (0..routines.len()).map(start).collect();
        Reach::of(&routines, &starts, &unknown)
    }
}

/// Puts what the head of a block calls before the block, as all its branches come after that; the head of `WHILE` is passed after each
/// pass, too.
///
/// `head = ("IF" | "SWITCH" | "FOR" | "WHILE") ... call ...`
fn conditions_first(text: &Text, events: Vec<(usize, Event)>) -> Vec<(usize, Event)> {
    let (mut all, mut ends): (Vec<(usize, Event)>, Vec<Vec<Event>>) = (Vec::with_capacity(events.len()), Vec::new());
    for of_line in events.chunk_by(|a, b| a.0 == b.0) {
        let many = |is: fn(&Event) -> bool| of_line.iter().filter(|e| is(&e.1)).count();
        let (opens, closes) = (many(|e| matches!(e, Event::Open(_))), many(|e| matches!(e, Event::Close)));
        if let [head @ (line, Event::Open(_)), called @ ..] = of_line
            && opens == closes + 1
        {
            all.extend(called.iter().cloned().chain([head.clone()]));
            let again = first_word(text, *line).eq_ignore_ascii_case(b"WHILE");
            ends.push(called.iter().filter(|_| again).map(|e| e.1.clone()).collect());
            continue;
        }
        for (line, event) in of_line {
            match event {
                Event::Open(_) => ends.push(Vec::new()),
                Event::Close => all.extend(ends.pop().unwrap_or_default().into_iter().map(|event| (*line, event))),
                _ => {}
            }
            all.push((*line, event.clone()));
        }
    }
    all
}

/// Names of the routines of other files that resume the program where their interrupt was declared.
fn resuming(texts: &[Text]) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for text in texts.iter().filter(|t| t.context && goes_elsewhere(t)) {
        each_line(text, |routine, line| {
            if line.first().is_some_and(|t| in_upper(text, t) == "RESUME") {
                found.insert(routine.to_string());
            }
        });
    }
    found
}

/// Whether a file runs something beside the program: a submit program, interrupts, triggers.
///
/// `line = ["GLOBAL"] "INTERRUPT" ... | "TRIGGER" ...`
fn runs_aside(text: &Text) -> bool {
    let mut found = text.name.to_ascii_lowercase().ends_with(".sub");
    each_line(text, |_, line| {
        let word = |t: &Token| matches!(&*in_upper(text, t), "INTERRUPT" | "TRIGGER");
        found |= line.iter().take(2).any(word);
    });
    found
}

/// Routines and all that they call, themselves or in what they call.
fn with_called(mut names: BTreeSet<String>, routines: &[Routine], outside: &Outside) -> BTreeSet<String> {
    loop {
        let mut next = names.clone();
        for name in &names {
            next.extend(routines.iter().filter(|r| r.name == *name).flat_map(called));
            next.extend(outside.sets.get(name).into_iter().flat_map(|sets| sets.calls.iter().cloned()));
        }
        if next == names {
            return names;
        }
        names = next;
    }
}

/// What a routine calls.
fn called(routine: &Routine) -> impl Iterator<Item = String> + '_ {
    routine.events.iter().filter_map(|(_, event)| match event {
        Event::Call(name) => Some(name.clone()),
        _ => None,
    })
}
