//! What the joint fit leaves, as curves without a name ([`crate::diagnose::search::unnamed`]) beside the named effects.

use super::{MachineFit, contribution, members};
use crate::diagnose::candidates::structure::Tested;
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::problem::residual::rms;
use crate::diagnose::search::unnamed::{self, Pool};

/// Curves at most: the machine has many named effects already.
const MOST: usize = 4;

/// The fit with curves where the test without the catalogue sees structure, as long as held-out blocks support them beside
/// everything else and they are worth it.
pub fn curves(problem: &Problem, machine: MachineFit, structure: &Tested) -> MachineFit {
    let mut pool = Pool::where_structured(problem, structure);
    let mut machine = machine;
    let mut found = false;
    for _ in 0..MOST {
        let Some(curve) = pool.best(problem, &machine.fit, &machine.whitening) else { break };
        let next = machine.clone().with(problem, vec![curve.placed]);
        let support = members::support(problem, &next);
        let moved = contribution::contributions(problem, &next.fit);
        let worth = contribution::WORTH * rms(problem, &next.fit.state.residual);
        let last = support.len() - 1;
        if support[last] < unnamed::SUPPORTED || moved[last] < worth {
            break;
        }
        machine = next;
        found = true;
    }
    if found {
        machine = machine.settled(problem);
        unnamed::with_intervals(problem, &mut machine.fit);
    }
    machine
}
