//! Axes that stand elsewhere from one step on, or count from elsewhere (a work frame, a tool length, a reference position): where they are
//! is not known until they are named again. The other axes go on in their run.

use super::super::cause::Cause;
use super::{Cutter, Gap, Joints};
use crate::program::script::{At, AxisSet};

impl Cutter<'_> {
    /// Some axes stand elsewhere from here on, or count from elsewhere: the others go on.
    pub(super) fn slip(&mut self, axes: AxisSet) {
        let still = self.run.vertices.is_empty() && self.run.entry && self.known.is_empty();
        let dof = self.choice.robot.dof();
        let commanded = |k: &usize| self.choice.commanded.get(*k).copied().unwrap_or(true);
        let all: AxisSet = (0..dof).filter(commanded).collect();
        if still || self.choice.robot.has_sums() || all.without(self.free.or(axes)).is_empty() {
            self.end(still);
        } else if self.run.vertices.is_empty() {
            axes.axes().filter_map(|k| self.known.get_mut(k).map(|v| *v = None)).for_each(drop);
            if self.known.iter().all(Option::is_none) {
                self.known.clear();
            }
        } else {
            self.free = self.free.or(axes);
        }
    }

    /// One of the axes that stand elsewhere is named again: where it comes from is not known, so a new run begins.
    pub(super) fn find_again(&mut self, from: &Joints, named: AxisSet) {
        let free = self.free;
        self.end(false);
        self.known = from.iter().enumerate().map(|(k, q)| (!free.has(k)).then_some(*q)).collect();
        self.free = free.without(named);
        self.rest = Some(from.clone());
    }

    /// A move of some axes that leads nobody knows where.
    pub(super) fn goes_elsewhere(&mut self, at: At, axes: AxisSet) {
        self.run.entry &= !self.run.vertices.is_empty();
        self.slip(axes);
        if !self.run.vertices.is_empty() {
            // the time that it takes is not known
            self.run.untimed.get_or_insert(at);
            (self.run.certain, self.run.by_program) = (false, false);
        }
        self.out.gaps.push(Gap { at, why: Cause::Undetermined });
    }
}
