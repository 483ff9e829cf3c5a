//! Programs that a program calls: whether they move the robot, as far as the files beside it tell.
//!
//! A program moves nothing where nothing in it does and all that it calls is there and moves nothing either; one that calls itself never
//! is such a one. What is loaded on the controller under a name is taken to be the file beside it, and a note says so.

use super::{At, Note};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Deref;

/// What a program does besides what it calls.
#[derive(Debug, Clone, Default)]
pub struct Does {
    /// As others call it.
    pub name: String,
    /// It moves the robot, or may.
    pub moves: bool,
    /// It holds a relative move.
    pub counts: bool,
    /// It waits.
    pub waits: bool,
    /// What it calls.
    pub calls: BTreeSet<String>,
}

/// Programs that move nothing, whether they wait; and those that may begin with a relative move.
#[derive(Debug, Default)]
pub struct Called {
    waits: BTreeMap<String, bool>,
    counts: BTreeSet<String>,
}

impl Called {
    /// Of what all the programs beside one do.
    pub fn of(all: &[impl Deref<Target = Does>]) -> Self {
        let mut by_name: BTreeMap<&str, Option<&Does>> = BTreeMap::new();
        for does in all {
            // two files of one name: which is loaded is not known
            by_name.entry(&does.name).and_modify(|d| *d = None).or_insert((!does.moves).then_some(does));
        }
        let mut waits: BTreeMap<String, bool> = BTreeMap::new();
        loop {
            let next = by_name.values().flatten().find_map(|d| {
                let fresh = !waits.contains_key(&d.name) && d.calls.iter().all(|c| waits.contains_key(c));
                fresh.then(|| (d.name.clone(), d.waits || d.calls.iter().any(|c| waits[c])))
            });
            let Some((name, waiting)) = next else { return Self { waits, counts: counting(all) } };
            waits.insert(name, waiting);
        }
    }

    /// Whether the program of this name moves nothing, and then whether it waits.
    pub fn waits(&self, name: &str) -> Option<bool> {
        self.waits.get(name).copied()
    }

    /// Whether the program of this name may begin with a relative move.
    pub fn counts(&self, name: &str) -> bool {
        self.counts.contains(name)
    }
}

/// Programs that hold a relative move, or call one that does.
fn counting(all: &[impl Deref<Target = Does>]) -> BTreeSet<String> {
    let mut found: BTreeSet<String> = all.iter().filter(|d| d.counts).map(|d| d.name.clone()).collect();
    loop {
        let calls = |d: &&Does| !found.contains(&d.name) && d.calls.iter().any(|c| found.contains(c));
        let Some(next) = all.iter().map(|d| &**d).find(calls).map(|d| d.name.clone()) else { return found };
        found.insert(next);
    }
}

/// Says that a routine which may move the robot runs whenever it strikes: a thread, or what an interrupt calls.
pub fn strikes(at: At, name: &str) -> Note {
    let text = format!(
        "{name} may move the robot while the program waits or moves: targets after that may be reached from other sides than their offsets are for"
    );
    Note { place: at, text }
}

/// Says which calls end nothing that is known of the joints; `met`: what is called so, and the line where it is first; `what` it is, and
/// the files that tell it of one and of several.
pub fn note(met: &BTreeMap<String, u64>, what: &str, [by_one, by_all]: [&str; 2]) -> Option<Note> {
    let line = met.values().min().copied()?;
    let names: Vec<&str> = met.keys().map(String::as_str).collect();
    let text = match names.as_slice() {
        [one] => format!("the {what} {one} that it calls moves nothing, by {by_one}"),
        all => format!("the {what}s {} that it calls move nothing, by {by_all}", all.join(", ")),
    };
    Some(Note { place: At { file: 0, line }, text })
}
