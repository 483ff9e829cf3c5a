//! What may be assigned to a name at each place: followed through branches, loops and the functions of the file in the order in which they
//! run ([`reach`](crate::script::reach)). What a thread assigns may hold at any place.

use super::in_force::block;
use super::read::{Item, ItemKind, Parsed};
use crate::script::Text;
use crate::script::reach::{Atoms, BEFORE, Event, FIRST, Reach, Routine, State, set_by};
use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};

/// A variable: the function to which it belongs (`None`: global), and its name.
pub type Key = (Option<usize>, String);

/// The order in which a file runs, and what runs beside it.
#[derive(Default)]
pub struct Order {
    /// What each item calls of the file, and where control goes with it.
    events: OnceCell<Vec<Vec<Event>>>,
    threads: OnceCell<BTreeSet<String>>,
    /// Functions that each function may come to, by their names.
    reached: OnceCell<BTreeMap<String, BTreeSet<usize>>>,
}

/// What may be assigned to one variable at each place.
pub struct Holding {
    reach: Reach,
    /// What threads may assign at any place.
    always: Atoms,
    unknown: State,
    /// The one function in which it is known.
    only: Option<usize>,
    /// Functions that assign it.
    pub by: BTreeSet<usize>,
}

impl Holding {
    /// Items whose assignment may be the last before an item; `None`: it may have none there.
    pub fn before(&self, item: usize, def: Option<usize>) -> Option<Vec<usize>> {
        if self.only.is_some_and(|only| def != Some(only)) {
            return None;
        }
        let state = self.reach.after(def.map_or(0, |d| d + 1), item).unwrap_or(&self.unknown);
        let atoms = state.first()?.union(&self.always);
        atoms.map(|atom| Some(atom.checked_sub(FIRST)? as usize)).collect()
    }
}

impl Order {
    /// Of a variable in a file that starts with the function `entry` (`None`: with what stands outside of functions); `None`: not certain.
    pub fn of(&self, text: &Text, p: &Parsed, entry: Option<usize>, key: &Key) -> Option<Holding> {
        let variable = p.variables.get(key)?;
        let assigned: BTreeSet<usize> = variable.assigned.iter().copied().collect();
        if !is_one(p, key, &assigned) {
            return None;
        }
        let own = key.0;
        // of a function that comes to itself several may be open at a time
        let inside = || p.items.iter().filter(|item| item.def == own).flat_map(|item| p.called(item));
        if own.is_some_and(|d| inside().any(|name| self.leads_to(p, name, &BTreeSet::from([d])))) {
            return None;
        }
        let events = self.events.get_or_init(|| p.items.iter().map(|item| events(text, p, item)).collect());
        let none = BTreeSet::new();
        let threads = if own.is_some() { &none } else { self.threads.get_or_init(|| threads(p)) };
        let by: BTreeSet<usize> = assigned.iter().filter_map(|k| p.items.get(*k)?.def).collect();
        let named = |(name, _): &(String, Option<usize>)| Routine { name: name.clone(), events: Vec::new() };
        let mut routines: Vec<Routine> = std::iter::once(Routine::default()).chain(p.defs.iter().map(named)).collect();
        for (k, (item, events)) in p.items.iter().zip(events).enumerate() {
            if own.is_some() && item.def != own {
                continue;
            }
            let routine = routines.get_mut(item.def.map_or(0, |d| d + 1))?;
            for event in events {
                if let Event::Call(name) = event {
                    if own.is_some() || !self.leads_to(p, name, &by) {
                        continue;
                    }
                    // whether and when it runs within an expression is not followed
                    if item.kind != ItemKind::Other || p.words.at(item.span.start) != name || p.called(item).count() > 1
                    {
                        return None;
                    }
                }
                routine.events.push((k + 1, event.clone()));
            }
            if assigned.contains(&k) {
                routine.events.push((k + 1, Event::Set(0, FIRST + k as u32)));
            }
        }
        let before = || vec![Atoms::from([BEFORE])];
        let unknown: State = vec![assigned.iter().map(|k| FIRST + *k as u32).chain([BEFORE]).collect()];
        let outside = p.items.iter().filter(|item| item.def.is_none());
        let called: BTreeSet<&str> = outside.flat_map(|item| p.called(item)).collect();
        let start = |(k, routine): (usize, &Routine)| match () {
            () if threads.contains(&routine.name) => Some(unknown.clone()),
            () if own.is_some() || k == 0 => Some(before()),
            // one that is called from outside has what holds there
            () if entry == Some(k - 1) && !called.contains(routine.name.as_str()) => Some(before()),
            () => None,
        };
        let starts: Vec<Option<State>> = routines.iter().enumerate().map(start).collect();
        let always = set_by(&routines, threads, 1).into_iter().next()?;
        Some(Holding { reach: Reach::of(&routines, &starts, &unknown), always, unknown, only: own, by })
    }

    /// Whether a call of a function may come to one of these functions.
    pub fn leads_to(&self, p: &Parsed, name: &str, to: &BTreeSet<usize>) -> bool {
        let reached = self.reached.get_or_init(|| reached(p));
        reached.get(name).is_some_and(|all| !all.is_disjoint(to))
    }
}

/// Whether all assignments of a name surely mean one variable: a name without `global` is global only where that was said before, and one
/// of a function is assigned in it alone.
fn is_one(p: &Parsed, key: &Key, assigned: &BTreeSet<usize>) -> bool {
    let items: Vec<&Item> = assigned.iter().filter_map(|k| p.items.get(*k)).collect();
    if key.0.is_some() {
        return items.iter().all(|item| item.def == key.0);
    }
    let says = |item: &&Item| item.def.is_none() || p.words.at(item.span.start) == "global";
    items.first().is_some_and(says)
}

/// Functions that a call of each name may come to, those of the name among them.
fn reached(p: &Parsed) -> BTreeMap<String, BTreeSet<usize>> {
    let mut calls: BTreeMap<usize, BTreeSet<&str>> = BTreeMap::new();
    for item in &p.items {
        if let Some(d) = item.def {
            calls.entry(d).or_default().extend(p.called(item));
        }
    }
    let mut named: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    p.defs.iter().enumerate().for_each(|(d, (name, _))| named.entry(name).or_default().push(d));
    let of = |name: &str| {
        let (mut open, mut seen) = (named.get(name).cloned().unwrap_or_default(), BTreeSet::new());
        while let Some(d) = open.pop() {
            if !seen.insert(d) {
                continue;
            }
            open.extend(calls.get(&d).into_iter().flatten().filter_map(|n| named.get(n)).flatten());
        }
        seen
    };
    named.keys().map(|name| ((*name).to_string(), of(name))).collect()
}

/// What an item calls, and where control goes with it.
fn events(text: &Text, p: &Parsed, item: &Item) -> Vec<Event> {
    let own = |name: &&str| p.defs.iter().any(|(n, _)| n == name);
    let runs = p.words.within(item.span.clone()).any(|w| w == "run");
    let calls = p.called(item).filter(own).map(|name| Event::Call(name.to_string()));
    let mut all: Vec<Event> = if runs { Vec::new() } else { calls.collect() };
    if let Some(event) = block(text, p, item) {
        // the condition of a loop is looked at in each pass, and that of a branch after the one before it
        let first = matches!(item.kind, ItemKind::Loop | ItemKind::Middle);
        all.insert(if first { 0 } else { all.len() }, event);
    }
    all
}

/// Functions that run beside what follows.
fn threads(p: &Parsed) -> BTreeSet<String> {
    let run = |item: &&Item| p.words.within(item.span.clone()).any(|w| w == "run");
    let named = p.items.iter().filter(run).flat_map(|item| p.words.within(item.span.clone()));
    let heads = p.items.iter().filter(|item| item.kind == ItemKind::Start);
    let threads = heads.filter(|item| matches!(p.words.at(item.span.start), "thread" | "sec"));
    let own = threads.filter_map(|item| p.defs.get(item.def?)).map(|(name, _)| name.as_str());
    own.chain(named).filter(|w| p.defs.iter().any(|(name, _)| name == w)).map(String::from).collect()
}
