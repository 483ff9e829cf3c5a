//! Which of several settings may be in force at each place of a program: a tool, a base, something that leads the robot. They are followed
//! through branches, loops, labels and the routines of the file until nothing is added.
//!
//! A setting is a number. A routine is followed from what holds at its start, [`ENTRY`], which stands for what holds at the places that
//! call it. A set may hold more than can be in force, never less: what is certain is a set of one.

use std::collections::{BTreeMap, BTreeSet};

/// Settings of one kind that may be in force.
pub type Atoms = BTreeSet<u32>;

/// What held where the routine was called.
pub const ENTRY: u32 = 0;
/// What holds where the program starts.
pub const BEFORE: u32 = 1;
/// The first number of a setting that the program makes.
pub const FIRST: u32 = 2;

/// What a block is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Block {
    /// Its branches stand between its conditions, the first after its head.
    Branch,
    /// Each branch has its own condition: nothing stands before the first.
    Switch,
    /// It may be passed by.
    Loop,
    /// It is gone through at least once.
    Entered,
    /// It is left from inside alone.
    Endless,
}

/// What a place of a program means here.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Event {
    /// A label.
    Label(String),
    /// A jump to one.
    Jump(String),
    /// A block opens.
    Open(Block),
    /// Its next branch; `true`: whatever the conditions are.
    Middle(bool),
    /// It closes.
    Close,
    /// Out of the innermost loop.
    Leave,
    /// To the next pass of the innermost loop.
    Skip,
    /// The setting of a kind.
    Set(usize, u32),
    /// The same where something has been set before.
    Reset(usize, u32),
    /// A routine is called; one that is not among the routines changes nothing.
    Call(String),
    /// The routine ends here.
    End,
}

/// A routine, with the place of each event, ascending.
#[derive(Debug, Clone, Default)]
pub struct Routine {
    /// As it is called.
    pub name: String,
    /// Place and event.
    pub events: Vec<(usize, Event)>,
}

impl Routine {
    /// What stands at `at` comes last of its kind, from a place on. The one before it in a row is of no use where none of the places that
    /// are `asked` for, ascending, stands between them.
    pub fn comes_last(&mut self, place: usize, kind: usize, at: usize, asked: &[usize]) {
        let before = match self.events.last() {
            Some((_, Event::Set(of, to))) if *of == kind => to.checked_sub(FIRST).map(|k| k as usize),
            _ => None,
        };
        let is_asked = |from: usize| asked.get(asked.partition_point(|a| *a < from)).is_some_and(|a| *a <= at);
        if before.is_some_and(|from| !is_asked(from)) {
            self.events.pop();
        }
        self.events.push((place, Event::Set(kind, FIRST + at as u32)));
    }
}

/// What may be in force, by kind.
pub type State = Vec<Atoms>;

/// Adds what an event sets to what holds.
pub fn add(event: &Event, all: &mut State) {
    if let Event::Set(kind, to) | Event::Reset(kind, to) = event
        && let Some(atoms) = all.get_mut(*kind)
    {
        atoms.insert(*to);
    }
}

/// What routines set, themselves or by those that they call.
pub fn set_by(routines: &[Routine], names: &BTreeSet<String>, kinds: usize) -> State {
    let (mut open, mut seen) = (names.clone(), BTreeSet::new());
    let mut all = vec![Atoms::new(); kinds];
    while let Some(name) = open.pop_first() {
        if !seen.insert(name.clone()) {
            continue;
        }
        for (_, event) in routines.iter().filter(|r| r.name == name).flat_map(|r| &r.events) {
            add(event, &mut all);
            if let Event::Call(name) = event {
                open.insert(name.clone());
            }
        }
    }
    all
}

fn join(into: &mut Option<State>, state: &Option<State>) {
    match (into.as_mut(), state) {
        (Some(all), Some(more)) => all.iter_mut().zip(more).for_each(|(a, m)| a.extend(m)),
        (None, Some(_)) => into.clone_from(state),
        _ => {}
    }
}

/// A state in which what held at the start is what holds at `entry`.
fn from(state: &State, entry: &State) -> State {
    let of = |(atoms, start): (&Atoms, &Atoms)| match atoms.contains(&ENTRY) {
        true => atoms.iter().filter(|a| **a != ENTRY).chain(start).copied().collect(),
        false => atoms.clone(),
    };
    state.iter().zip(entry).map(of).collect()
}

struct Open {
    at: usize,
    block: Block,
    before: Option<State>,
    ends: Option<State>,
    /// A branch of it begins whatever the conditions are.
    whole: bool,
    /// A branch has begun.
    begun: bool,
}

/// The states at labels and at the starts of loops, from wherever control comes.
#[derive(Default)]
struct Joins {
    labels: BTreeMap<String, Option<State>>,
    loops: BTreeMap<usize, Option<State>>,
}

/// A way through a routine.
struct Pass {
    /// The states after the events, where they change.
    changes: Changes,
    /// Those with which routines are called.
    calls: Vec<(String, State)>,
    end: Option<State>,
}

type Effects = BTreeMap<String, Option<State>>;

/// The states after the events of a routine, where they change.
type Changes = Vec<(usize, Option<State>)>;

/// An event that sets something, calls or ends a routine; `false`: it is none.
fn sets(event: &Event, now: &mut Option<State>, out: &mut Pass, effects: &Effects) -> bool {
    match event {
        Event::Set(kind, to) => {
            if let Some(atoms) = now.as_mut().and_then(|s| s.get_mut(*kind)) {
                *atoms = Atoms::from([*to]);
            }
        }
        Event::Reset(kind, to) => {
            if let Some(atoms) = now.as_mut().and_then(|s| s.get_mut(*kind))
                && *atoms != Atoms::from([BEFORE])
            {
                atoms.retain(|a| matches!(*a, ENTRY | BEFORE));
                atoms.insert(*to);
            }
        }
        Event::Call(name) => {
            if let (Some(effect), Some(state)) = (effects.get(name), now.as_ref()) {
                out.calls.push((name.clone(), state.clone()));
                *now = effect.as_ref().map(|effect| from(effect, state));
            }
        }
        Event::End => {
            join(&mut out.end, now);
            *now = None;
        }
        _ => return false,
    }
    true
}

impl Joins {
    fn pass(&mut self, events: &[(usize, Event)], kinds: usize, effects: &Effects) -> Pass {
        let mut now: Option<State> = Some(vec![Atoms::from([ENTRY]); kinds]);
        let mut out = Pass { changes: Vec::new(), calls: Vec::new(), end: None };
        let mut open: Vec<Open> = Vec::new();
        for (k, (at, event)) in events.iter().enumerate() {
            if !sets(event, &mut now, &mut out, effects) {
                self.leads(k, event, &mut now, &mut open);
            }
            match out.changes.last_mut() {
                Some(last) if last.1 == now => {}
                Some(last) if last.0 == *at => last.1.clone_from(&now),
                _ => out.changes.push((*at, now.clone())),
            }
        }
        join(&mut out.end, &now);
        out
    }

    /// An event at which control goes elsewhere, or comes from there.
    fn leads(&mut self, k: usize, event: &Event, now: &mut Option<State>, open: &mut Vec<Open>) {
        let innermost = |open: &Vec<Open>| open.iter().rposition(|b| !matches!(b.block, Block::Branch | Block::Switch));
        match event {
            Event::Label(name) => {
                let joined = self.labels.entry(name.clone()).or_default();
                join(joined, now);
                now.clone_from(joined);
            }
            Event::Jump(name) => {
                join(self.labels.entry(name.clone()).or_default(), now);
                *now = None;
            }
            Event::Open(block) => {
                if !matches!(block, Block::Branch | Block::Switch) {
                    join(now, self.loops.entry(k).or_default());
                }
                open.push(Open { at: k, block: *block, before: now.clone(), ends: None, whole: false, begun: false });
            }
            Event::Middle(whole) => {
                if let Some(block) = open.last_mut() {
                    if block.begun || block.block != Block::Switch {
                        join(&mut block.ends, now);
                    }
                    (block.begun, block.whole) = (true, block.whole || *whole);
                    now.clone_from(&block.before);
                }
            }
            Event::Close => {
                if let Some(block) = open.pop() {
                    self.close(block, now);
                }
            }
            Event::Leave => {
                if let Some(block) = innermost(open).and_then(|k| open.get_mut(k)) {
                    join(&mut block.ends, now);
                }
                *now = None;
            }
            Event::Skip => {
                if let Some(block) = innermost(open).and_then(|k| open.get_mut(k)) {
                    join(self.loops.entry(block.at).or_default(), now);
                    if block.block != Block::Endless {
                        join(&mut block.ends, now);
                    }
                }
                *now = None;
            }
            _ => {}
        }
    }

    fn close(&mut self, block: Open, now: &mut Option<State>) {
        match block.block {
            Block::Branch | Block::Switch => {
                if !block.whole {
                    join(now, &block.before);
                }
            }
            Block::Loop | Block::Entered | Block::Endless => {
                join(self.loops.entry(block.at).or_default(), now);
                match block.block {
                    Block::Loop => join(now, &block.before),
                    // one that is never left leads nowhere; what stands after it counts as reached all the same
                    Block::Endless if block.ends.is_none() => join(now, &block.before),
                    Block::Endless => *now = None,
                    _ => {}
                }
            }
        }
        join(now, &block.ends);
    }
}

/// Goes through a routine until nothing is added.
fn settled(events: &[(usize, Event)], kinds: usize, effects: &Effects) -> Pass {
    let mut joins = Joins::default();
    let mut pass = joins.pass(events, kinds, effects);
    loop {
        let next = joins.pass(events, kinds, effects);
        if next.changes == pass.changes && next.end == pass.end {
            return next;
        }
        pass = next;
    }
}

/// What may be in force at each place of the routines.
#[derive(Debug, Default)]
pub struct Reach {
    routines: Vec<(State, Changes)>,
}

impl Reach {
    /// `starts`: what holds at the start of a routine besides what its callers bring, by its index; `None`: nothing, they alone call it.
    /// `unknown`: what may hold where nothing is known, also at the start of a routine that none calls.
    pub fn of(routines: &[Routine], starts: &[Option<State>], unknown: &State) -> Self {
        let kinds = unknown.len();
        let mut effects: Effects = routines.iter().map(|r| (r.name.clone(), None)).collect();
        // effects only grow, so that it comes to an end
        let passes = loop {
            let passes: Vec<Pass> = routines.iter().map(|r| settled(&r.events, kinds, &effects)).collect();
            let mut next: Effects = effects.keys().map(|name| (name.clone(), None)).collect();
            for (routine, pass) in routines.iter().zip(&passes) {
                join(next.entry(routine.name.clone()).or_default(), &pass.end);
            }
            if next == effects {
                break passes;
            }
            effects = next;
        };
        let mut entries: Vec<Option<State>> = (0..routines.len()).map(|k| starts.get(k).cloned().flatten()).collect();
        let called: BTreeSet<&str> = passes.iter().flat_map(|p| &p.calls).map(|c| c.0.as_str()).collect();
        for (entry, routine) in entries.iter_mut().zip(routines) {
            if entry.is_none() && !called.contains(routine.name.as_str()) {
                *entry = Some(unknown.clone());
            }
        }
        loop {
            let before = entries.clone();
            for (k, pass) in passes.iter().enumerate() {
                let Some(entry) = entries.get(k).cloned().flatten() else { continue };
                for (name, state) in &pass.calls {
                    let state = Some(from(state, &entry));
                    let named = entries.iter_mut().zip(routines).filter(|(_, r)| r.name == *name);
                    named.for_each(|(entry, _)| join(entry, &state));
                }
            }
            if entries == before {
                break;
            }
        }
        // of one that only itself calls nothing is known
        let of = |(entry, pass): (Option<State>, Pass)| {
            let entry = entry.unwrap_or_else(|| unknown.clone());
            let at = |state: Option<State>| Some(from(&state?, &entry));
            let changes = pass.changes.into_iter().map(|(k, state)| (k, at(state))).collect();
            (entry.clone(), changes)
        };
        Self { routines: entries.into_iter().zip(passes).map(of).collect() }
    }

    /// What may be in force in a routine after all events up to a place, that one among them; `None`: nothing leads there.
    pub fn after(&self, routine: usize, place: usize) -> Option<&State> {
        let (entry, changes) = self.routines.get(routine)?;
        match changes.partition_point(|c| c.0 <= place).checked_sub(1).and_then(|k| changes.get(k)) {
            Some((_, state)) => state.as_ref(),
            None => Some(entry),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Block::{Branch, Endless, Entered, Loop, Switch};
    use super::Event::{Call, Close, End, Jump, Label, Leave, Middle, Open, Reset, Set, Skip};
    use super::*;

    /// What may be in force after each event.
    type States<'a> = &'a [&'a [u32]];

    /// What may be in force after each event of the first routine, which starts from [`BEFORE`].
    fn after(routines: &[(&str, &[Event])]) -> Vec<Vec<u32>> {
        let of = |(name, events): &(&str, &[Event])| Routine {
            name: (*name).into(),
            events: events.iter().cloned().enumerate().collect(),
        };
        let all: Vec<Routine> = routines.iter().map(of).collect();
        let before = Some(vec![Atoms::from([BEFORE])]);
        let reach = Reach::of(&all, &[before], &vec![Atoms::from([BEFORE, 9])]);
        let state = |k: usize| reach.after(0, k).map(|s| s[0].iter().copied().collect()).unwrap_or_default();
        (0..routines[0].1.len()).map(state).collect()
    }

    #[test]
    fn settings_are_followed_through_blocks_and_labels() {
        let to = |name: &str| Jump(name.into());
        let at = |name: &str| Label(name.into());
        // worked out by hand
        let cases: [(&str, &[Event], States<'_>); 9] = [
            ("perhaps", &[Open(Branch), Set(0, 2), Close], &[&[1], &[2], &[1, 2]]),
            ("either", &[Open(Branch), Set(0, 2), Middle(true), Set(0, 3), Close], &[&[1], &[2], &[1], &[3], &[2, 3]]),
            (
                "a switch",
                &[Open(Switch), Middle(false), Set(0, 2), Middle(true), Set(0, 2), Close],
                &[&[1], &[1], &[2], &[1], &[2], &[2]],
            ),
            ("a loop", &[Open(Loop), Set(0, 2), Close], &[&[1, 2], &[2], &[1, 2]]),
            ("a loop that is entered", &[Open(Entered), Set(0, 2), Close], &[&[1, 2], &[2], &[2]]),
            (
                "out of one",
                &[Open(Endless), Open(Branch), Leave, Close, Set(0, 2), Close],
                &[&[1, 2], &[1, 2], &[], &[1, 2], &[2], &[1, 2]],
            ),
            (
                "to its next pass",
                &[Open(Endless), Set(0, 2), Skip, Set(0, 3), Close],
                &[&[1, 2], &[2], &[], &[], &[1, 2]],
            ),
            ("a jump back", &[at("A"), Set(0, 2), to("A")], &[&[1, 2], &[2], &[]]),
            ("once more", &[Reset(0, 4), Set(0, 2), Reset(0, 4)], &[&[1, 4], &[2], &[4]]),
        ];
        for (what, events, expected) in cases {
            assert_eq!(after(&[("M", events)]), expected, "{what}");
        }
    }

    #[test]
    fn routines_have_what_their_callers_have_and_change_it() {
        let call = |name: &str| Call(name.into());
        let cases: [(&str, &[Event], &[Event], States<'_>); 4] = [
            ("it sets nothing", &[Set(0, 2), call("S"), Set(0, 3), call("S")], &[], &[&[2], &[2], &[3], &[3]]),
            ("it sets one", &[call("S"), Set(0, 3)], &[Set(0, 2)], &[&[2], &[3]]),
            ("perhaps", &[call("S")], &[Open(Branch), End, Close, Set(0, 2)], &[&[1, 2]]),
            ("it never comes back", &[call("S")], &[Open(Endless), Close], &[&[1]]),
        ];
        for (what, main, sub, expected) in cases {
            assert_eq!(after(&[("M", main), ("S", sub)]), expected, "{what}");
        }
        // at the start of one: what any caller has; of one that none calls: anything
        let of = |name: &str, events: &[Event]| Routine {
            name: name.into(),
            events: events.iter().cloned().enumerate().collect(),
        };
        let all = [
            of("M", &[Set(0, 2), call("A"), Set(0, 3), call("B")]),
            of("A", &[call("B")]),
            of("B", &[]),
            of("NEVER", &[]),
        ];
        let reach = Reach::of(&all, &[Some(vec![Atoms::from([BEFORE])])], &vec![Atoms::from([BEFORE, 9])]);
        let start = |k| reach.after(k, 0).map(|s| s[0].clone());
        assert_eq!([start(1), start(2), start(3)], [Some([2].into()), Some([2, 3].into()), Some([BEFORE, 9].into())]);
    }
}
