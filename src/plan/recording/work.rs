//! Where programs work: the pose in the middle of the joints that they command.
//!
//! Friction depends on load, a gap on position, and what a joint's error does to the TCP on the pose, so a test near the programs
//! describes them better than one elsewhere.

use crate::program::Program;

/// Middle of each joint's range over all programs, rad or m; `None` where none has a point.
pub fn middle_of(programs: &[Program]) -> Option<Vec<f64>> {
    let axes = programs.iter().map(|p| p.q.len()).min()?;
    let middle = |axis: usize| {
        let all = programs.iter().flat_map(|p| p.q[axis].iter());
        let (lo, hi) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(*v), hi.max(*v)));
        (lo <= hi).then_some(0.5 * (lo + hi))
    };
    (0..axes).map(middle).collect()
}
