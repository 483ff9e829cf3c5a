//! Bases of a controller that count from another machine than the world: an external axis, a conveyor, another robot.
//!
//! KUKA alone has them; its lists are read by [`crate::krl`].

use std::collections::BTreeMap;

/// Bases that count from another machine, by their numbers.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct CarriedBases {
    /// What carries each of them.
    pub bases: BTreeMap<u32, Carrier>,
}

/// What carries a base.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Carrier {
    /// Its number among the machines of the controller, from 1.
    pub machine: u32,
    /// It is an external axis of the same controller, of which targets tell the position; else it is a conveyor or another robot.
    pub external_axis: bool,
}

impl CarriedBases {
    /// Whether all bases count from the world.
    pub fn is_empty(&self) -> bool {
        self.bases.is_empty()
    }

    /// Adds those of another list of the same controller; a base that one of them carries is carried.
    pub fn add(&mut self, other: &Self) {
        for (number, carrier) in &other.bases {
            let own = self.bases.entry(*number).or_insert(*carrier);
            own.external_axis &= carrier.external_axis;
        }
    }
}
