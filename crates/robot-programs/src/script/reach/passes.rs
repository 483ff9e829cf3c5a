//! Passes through one routine, until nothing is added: the states after its events, those with which it calls, and that at its end.

use super::{Atoms, BEFORE, Block, ENTRY, Event, State};
use std::collections::BTreeMap;

pub(super) fn join(into: &mut Option<State>, state: &Option<State>) {
    match (into.as_mut(), state) {
        (Some(all), Some(more)) => all.iter_mut().zip(more).for_each(|(a, m)| a.extend(m)),
        (None, Some(_)) => into.clone_from(state),
        _ => {}
    }
}

/// A state in which what held at the start is what holds at `entry`.
pub(super) fn from(state: &State, entry: &State) -> State {
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
pub(super) struct Pass {
    /// The states after the events, where they change.
    pub(super) changes: Changes,
    /// Those with which routines are called.
    pub(super) calls: Vec<(String, State)>,
    pub(super) end: Option<State>,
}

pub(super) type Effects = BTreeMap<String, Option<State>>;

/// The states after the events of a routine, where they change.
pub(super) type Changes = Vec<(usize, Option<State>)>;

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
pub(super) fn settled(events: &[(usize, Event)], kinds: usize, effects: &Effects) -> Pass {
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
