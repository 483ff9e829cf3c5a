//! Routines of a file that call each other: what stands after a call is reached from where the routine ends, and from nowhere else.
//!
//! Where a routine ends does not depend on the place that calls it, if it moves on every way through it. A way on which nothing moves
//! leads back to its start, of which nothing is known here.

use super::order::Join;
use std::collections::{BTreeMap, BTreeSet};

/// The routines of a file, where they end, and the calls of one by another.
#[derive(Debug, Default)]
pub(super) struct Routines {
    /// Those of each name.
    names: BTreeMap<String, BTreeSet<usize>>,
    /// Where the text of each begins.
    begins: BTreeMap<usize, usize>,
    /// The places at which each is left, back to what called it.
    ends: BTreeMap<usize, Vec<usize>>,
    /// Breaks of calls, and what they call.
    calls: Vec<(usize, String)>,
    /// The routine that is read.
    current: Option<usize>,
    /// Nothing leads to the place that is read.
    dead: bool,
    /// Something may lead from inside of a routine to elsewhere, or back into the middle of one.
    unknown: bool,
}

impl Routines {
    /// The text of a routine starts or goes on at a step: the one before has ended.
    pub(super) fn start(&mut self, id: usize, name: String, at: usize) {
        self.returns(at);
        self.names.entry(name).or_default().insert(id);
        self.begins.entry(id).or_insert(at);
        (self.current, self.dead) = (Some(id), false);
    }

    /// The routine is left before a step, back to what called it.
    pub(super) fn returns(&mut self, at: usize) {
        if let Some(id) = self.current.filter(|_| !self.dead) {
            self.ends.entry(id).or_default().push(at);
        }
    }

    /// Whether something leads to the place that is read.
    pub(super) fn is_reached(&mut self, reached: bool) {
        self.dead = !reached;
    }

    /// Where control comes from after a call is not known in this file.
    pub(super) fn are_unknown(&mut self) {
        self.unknown = true;
    }

    /// The break at a step is the call of a routine, and of nothing else that moves.
    pub(super) fn called(&mut self, at: usize, name: String) {
        self.calls.push((at, name));
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

    /// Whether a break is the call of a routine of the file.
    pub(super) fn is_call(&self, at: usize) -> bool {
        self.calls.binary_search_by_key(&at, |c| c.0).is_ok()
    }

    /// From where control comes to what stands after calls; `end`: the step after the last.
    pub(super) fn joins(mut self, end: usize) -> Vec<Join> {
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
    fn where_anything_may_lead_out_of_a_routine_nothing_is_known_after_calls() {
        let mut routines = Routines::default();
        routines.start(0, "MAIN".into(), 0);
        routines.called(1, "A".into());
        routines.start(1, "A".into(), 2);
        routines.are_unknown();
        assert!(routines.joins(4).is_empty());
    }
}
