//! From where control comes to a break: the ways that lead to a branch, to the end of a block, and to a label.

use super::{Join, Script, StepKind};
use std::collections::{BTreeMap, BTreeSet};

/// Labels of a routine, and the places from which something jumps to them.
#[derive(Default)]
pub(super) struct Labels {
    stand: BTreeMap<String, usize>,
    jumps: BTreeMap<String, Vec<usize>>,
    /// Those to which something jumps while the robot moves: from where is not known, wherever they stand.
    on_the_way: BTreeSet<String>,
    /// Something may jump to any of them, or its place is not known.
    unknown: bool,
}

impl Labels {
    /// A label stands at a step; `None`: its name is not known.
    pub(super) fn stands(&mut self, name: Option<String>, at: usize) {
        match name {
            // two of one name: which of them is meant is not known
            Some(name) => self.unknown |= self.stand.insert(name, at).is_some(),
            None => self.unknown = true,
        }
    }

    /// Something may jump to a label from the place before a step; `None`: to any.
    pub(super) fn jumps_to(&mut self, name: Option<String>, from: usize) {
        match name {
            Some(name) => self.jumps.entry(name).or_default().push(from),
            None => self.unknown = true,
        }
    }

    /// Something may jump to a label while the robot moves; `None`: to any.
    pub(super) fn jumps_on_the_way(&mut self, name: Option<String>) {
        match name {
            Some(name) => drop(self.on_the_way.insert(name)),
            None => self.unknown = true,
        }
    }

    /// The labels of which all jumps to them are known.
    pub(super) fn joins(self) -> Vec<Join> {
        let Self { stand, mut jumps, on_the_way, unknown } = self;
        let known = stand.into_iter().filter(|(name, _)| !unknown && !on_the_way.contains(name));
        known
            .map(|(name, at)| {
                let mut from = jumps.remove(&name).unwrap_or_default();
                from.push(at);
                Join { at, from }
            })
            .collect()
    }
}

/// Places that are followed back from a break at most.
const FOLLOWED: usize = 64;

/// A place before which nothing has moved since a break is reached as that break is; where that leads through many places, nothing is
/// known.
pub(crate) fn through_still(script: &mut Script) {
    let mut joins = std::mem::take(&mut script.joins);
    joins.sort_by_key(|j| j.at);
    // the last move or break before each step, where it is a break
    let mut before = Vec::with_capacity(script.steps.len() + 1);
    let mut last = None;
    for (k, step) in script.steps.iter().enumerate() {
        before.push(last);
        match step.kind {
            StepKind::Break(_) => last = Some(k),
            StepKind::Move(_) => last = None,
            _ => {}
        }
    }
    before.push(last);
    let from = |at: usize| joins.binary_search_by_key(&at, |j| j.at).ok().map(|k| &joins[k].from);
    let followed = |join: &Join| {
        let (mut open, mut found, mut seen) = (join.from.clone(), BTreeSet::new(), BTreeSet::new());
        while let Some(place) = open.pop() {
            if !seen.insert(place) {
                continue;
            }
            if seen.len() > FOLLOWED {
                return None;
            }
            match before.get(place).copied().flatten().and_then(from) {
                Some(further) => open.extend(further),
                None => drop(found.insert(place)),
            }
        }
        Some(Join { at: join.at, from: found.into_iter().collect() })
    };
    script.joins = joins.iter().filter_map(followed).collect();
    let again = script.again.take();
    script.again = again.as_ref().and_then(followed);
    script.starts_anywhere |= again.is_some() && script.again.is_none();
}
