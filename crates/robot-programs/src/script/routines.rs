//! Routines of a file that call each other: what stands after a call is reached from where the routine ends, and from nowhere else.
//!
//! Where a routine ends does not depend on the place that calls it, if it moves on every way through it. A way on which nothing moves
//! leads back to its start, which is reached from its calls alone where all of them stand in the text ([`Routines::entered`]).

use super::order::Join;
use std::collections::{BTreeMap, BTreeSet};

/// The routines of a file, where they end, and the calls of one by another.
#[derive(Debug, Default)]
pub(crate) struct Routines {
    /// Those of each name.
    names: BTreeMap<String, BTreeSet<usize>>,
    /// Where the text of each begins.
    begins: BTreeMap<usize, usize>,
    /// Where the text of one goes on after another that stands within it, and which.
    goes_on: BTreeMap<usize, usize>,
    /// The places at which each is left, back to what called it.
    ends: BTreeMap<usize, Vec<usize>>,
    /// Breaks of calls, and what they call.
    calls: Vec<(usize, String)>,
    /// The routine that is read.
    current: Option<usize>,
    /// Those of which all calls stand in the file.
    known: BTreeSet<usize>,
    /// Names that something else than a known call may call.
    otherwise: BTreeSet<String>,
    /// Nothing leads to the place that is read.
    dead: bool,
    /// Something may lead from inside of a routine to elsewhere, or back into the middle of one.
    unknown: bool,
}

impl Routines {
    /// The text of a routine starts or goes on at a step: the one before has ended.
    pub(crate) fn start(&mut self, id: usize, name: String, at: usize) {
        self.returns(at);
        self.names.entry(name).or_default().insert(id);
        if *self.begins.entry(id).or_insert(at) != at {
            self.goes_on.insert(at, id);
        }
        (self.current, self.dead) = (Some(id), false);
    }

    /// The routine is left before a step, back to what called it.
    pub(crate) fn returns(&mut self, at: usize) {
        if let Some(id) = self.current.filter(|_| !self.dead) {
            self.ends.entry(id).or_default().push(at);
        }
    }

    /// Whether something leads to the place that is read.
    pub(crate) fn is_reached(&mut self, reached: bool) {
        self.dead = !reached;
    }

    /// Where control comes from after a call is not known in this file.
    pub(crate) fn are_unknown(&mut self) {
        self.unknown = true;
    }

    /// The break at a step is the call of a routine, and of nothing else that moves.
    pub(crate) fn called(&mut self, at: usize, name: String) {
        self.calls.push((at, name));
    }

    /// All calls of the routine that is read stand in the file (`true`), or where the robot comes from to it is not known.
    pub(crate) fn all_calls_are_here(&mut self, known: bool) {
        if let Some(id) = self.current {
            if known {
                self.known.insert(id)
            } else {
                self.known.remove(&id)
            };
        }
    }

    /// Something may call a routine from a place that is not known.
    pub(crate) fn called_otherwise(&mut self, name: String) {
        self.otherwise.insert(name);
    }

    /// From which calls the robot comes to the start of each routine of which all of them stand in the file.
    pub(crate) fn entered(&self) -> Vec<Join> {
        let of = |(name, ids): (&String, &BTreeSet<usize>)| {
            let one = ids.first().filter(|id| ids.len() == 1 && self.known.contains(id) && !self.unknown)?;
            let from: Vec<usize> = self.calls.iter().filter(|c| c.1 == *name).map(|c| c.0).collect();
            let open = from.is_empty() || self.otherwise.contains(name);
            Some(Join { at: *self.begins.get(one).filter(|_| !open)?, from })
        };
        self.names.iter().filter_map(of).collect()
    }

    /// From which calls control comes to the start of each routine. `others`: calls of something else; none: of that it is not known.
    pub(super) fn starts(&self, others: &[usize]) -> Vec<Join> {
        let of = |(name, ids): (&String, &BTreeSet<usize>)| {
            let from: Vec<usize> = self.calls.iter().filter(|c| c.1 == *name).map(|c| c.0).collect();
            let from: Vec<usize> = from.into_iter().chain(others.iter().copied()).collect();
            let begins: Vec<usize> = ids.iter().filter_map(|id| self.begins.get(id)).copied().collect();
            begins.into_iter().map(move |at| Join { at, from: from.clone() })
        };
        if self.unknown { Vec::new() } else { self.names.iter().flat_map(of).collect() }
    }

    /// Calls of the routine whose text begins at a step, or goes on there.
    pub(super) fn calls_of_start(&self, begin: usize) -> Vec<usize> {
        let own = self.goes_on.get(&begin);
        let begins =
            |ids: &BTreeSet<usize>| ids.iter().any(|id| self.begins.get(id) == Some(&begin) || own == Some(id));
        let called = |(_, name): &&(usize, String)| self.names.get(name).is_some_and(begins);
        self.calls.iter().filter(called).map(|(at, _)| *at).collect()
    }

    /// Whether a break is the call of a routine of the file.
    pub(super) fn is_call(&self, at: usize) -> bool {
        self.calls.binary_search_by_key(&at, |c| c.0).is_ok()
    }

    /// From where control comes to what stands after calls; `end`: the step after the last.
    pub(crate) fn joins(mut self, end: usize) -> Vec<Join> {
        self.returns(end);
        if self.unknown {
            return Vec::new();
        }
        let Self { names, ends, calls, .. } = self;
        let ends_of = |name: &String| {
            let one = names.get(name).filter(|ids| ids.len() == 1)?.first()?;
            ends.get(one).cloned()
        };
        calls.iter().filter_map(|(at, name)| Some(Join { at: *at, from: ends_of(name)? })).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_after_a_call_is_reached_from_the_ends_of_the_one_routine_of_its_name() {
        let mut routines = Routines::default();
        routines.start(0, "MAIN".into(), 0);
        for (at, name) in [(1, "A"), (3, "B"), (5, "TWICE"), (6, "GONE")] {
            routines.called(at, name.into());
        }
        routines.start(1, "A".into(), 8);
        routines.returns(10);
        // B never comes back
        routines.start(2, "B".into(), 12);
        routines.is_reached(false);
        routines.start(3, "TWICE".into(), 14);
        routines.start(4, "TWICE".into(), 16);
        assert_eq!(routines.joins(18), [Join { at: 1, from: vec![10, 12] }]);
    }

    #[test]
    fn a_routine_is_entered_from_its_calls_where_all_of_them_are_known() {
        let of = |known: &[usize], otherwise: &str, unknown: bool| {
            let mut routines = Routines::default();
            routines.start(0, "MAIN".into(), 0);
            for (at, name) in [(1, "A"), (3, "B"), (5, "A"), (6, "TWICE")] {
                routines.called(at, name.into());
            }
            for (id, name, at) in [(1, "A", 8), (2, "B", 12), (3, "TWICE", 14), (4, "TWICE", 16), (5, "NEVER", 18)] {
                routines.start(id, name.into(), at);
                routines.all_calls_are_here(known.contains(&id));
            }
            routines.called_otherwise(otherwise.into());
            if unknown {
                routines.are_unknown();
            }
            routines.entered()
        };
        let [a, b] = [Join { at: 8, from: vec![1, 5] }, Join { at: 12, from: vec![3] }];
        assert_eq!(of(&[1, 2, 3, 4, 5], "", false), [a.clone(), b.clone()]);
        assert_eq!(of(&[1, 2], "B", false), [a]);
        assert_eq!(of(&[2], "", false), [b]);
        assert!(of(&[1, 2], "", true).is_empty());
    }

    #[test]
    fn where_anything_may_lead_out_of_a_routine_nothing_is_known_after_calls() {
        let mut routines = Routines::default();
        routines.start(0, "MAIN".into(), 0);
        routines.called(1, "A".into());
        routines.start(1, "A".into(), 2);
        routines.are_unknown();
        assert!(routines.joins(4).is_empty());
    }
}
