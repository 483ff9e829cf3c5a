//! Which of several settings may be in force at each place of a program: a tool, a base, something that leads the robot. They are followed
//! through branches, loops, labels and the routines of the file until nothing is added.
//!
//! A setting is a number. A routine is followed from what holds at its start, [`ENTRY`], which stands for what holds at the places that
//! call it. A set may hold more than can be in force, never less: what is certain is a set of one.
//!
//! Parts: `passes` follows control through one routine; [`Reach`] follows the calls of them.

mod passes;

use passes::{Changes, Effects, Pass, from, join, settled};
use std::collections::BTreeSet;

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
