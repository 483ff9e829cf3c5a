//! The clock from tests of dwells, and from motions that move one joint after another: what `plan-experiment static` records.
//!
//! Method: as [`super::fit`], with what such a test shows and a motion of all joints does not. A joint that waits for its turn stands
//! somewhere in its gap, which is fitted: left out, it would take the readings of all others along. Friction that fades after a
//! reversal has faded while a joint rests and lags while it moves, which would be read as time: it is fitted beside the gap, at three
//! paces. The drift has a prior. Later rounds take less of a step, because sides of a gap flip at single rows.
//!
//! Intervals: those of [`super::fit`], and what only a prior tells of a parameter widens them.
//!
//! Ordinary recordings, in which all joints move, are not fitted so: friction and late samples look alike there, and intervals held 13 of
//! 20 offsets. How far a fit with another law of friction is from the one that is used widens its interval: of a test, one without
//! friction; of an ordinary recording, this one.
//!
//! Fails: as [`super::fit`].
//!
//! Files beside: `play` (a joint with a gap that also rests), `state` (what is estimated).

mod play;
mod state;

use super::failure::Failure;
use super::fit::{Fit, fit_from};
use super::search::Seen;
use crate::numerics::series::Series;
use crate::robot::Robot;
use state::{FRICTION, NO_FRICTION, State};

/// The path fits at the start; a fit that ends this far from it, s, has lost it.
const ASTRAY_S: f64 = 1.0;
/// Movement of a joint between two samples up to which it stands, rad or m.
const STANDS: f64 = 1e-7;
/// Joints that move at a time in a test of one after another, at most, and share of the time in which nothing moves in a test of dwells.
const AT_A_TIME: f64 = 1.5;
const RESTING: f64 = 0.2;

/// Whether joints move one after another, or rest for much of the time.
pub fn is_test(commands: &Series) -> bool {
    let n = commands.times().len().saturating_sub(1);
    let moves =
        |axis: usize, k: usize| (commands.within(axis, k, 1.0).0 - commands.within(axis, k, 0.0).0).abs() > STANDS;
    let (mut moving, mut joints) = (0usize, 0usize);
    for k in 0..n {
        let count = (0..commands.channels()).filter(|a| moves(*a, k)).count();
        moving += usize::from(count > 0);
        joints += count;
    }
    let resting = (n - moving) as f64 > RESTING * n as f64;
    moving > 0 && (resting || (joints as f64) < AT_A_TIME * moving as f64)
}

/// Fits the clock from a start offset, s.
///
/// `stamps`: variances of offset and drift of the clocks that gave the stamps of both recordings.
pub fn fit(robot: &Robot, commands: &Series, seen: &Seen, start_s: f64, stamps: [f64; 2]) -> Result<Fit, Failure> {
    fit_with(FRICTION, (robot, commands), seen, start_s, stamps)
}

/// The same without friction: by how much the other is off where joints have another law of it, or none.
pub fn without_friction(
    robot: &Robot,
    commands: &Series,
    seen: &Seen,
    start_s: f64,
    stamps: [f64; 2],
) -> Result<Fit, Failure> {
    fit_with(NO_FRICTION, (robot, commands), seen, start_s, stamps)
}

/// `friction`: standard deviation of its prior, rad or m.
fn fit_with(
    friction: f64,
    (robot, commands): (&Robot, &Series),
    seen: &Seen,
    start_s: f64,
    stamps: [f64; 2],
) -> Result<Fit, Failure> {
    let state = |frame| State::begin(frame, commands.channels(), start_s, friction);
    let fit = fit_from(state, (robot, commands), seen, start_s, stamps)?;
    if (fit.offset_s.value - start_s).abs() > ASTRAY_S { Err(Failure::Open) } else { Ok(fit) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_test_of_dwells_or_of_one_joint_after_another_is_told_from_a_motion_of_all() {
        let t: Vec<f64> = (0..400).map(f64::from).collect();
        let of = |value: &dyn Fn(usize, f64) -> f64| {
            let values = (0..3).map(|a| t.iter().map(|t| value(a, *t)).collect()).collect();
            is_test(&Series::new(t.clone(), values, &[1e-7; 3]))
        };
        assert!(!of(&|a, t| (0.03 * (a as f64 + 1.0) * t).sin()));
        assert!(of(&|a, t| if (t / 100.0) as usize == a { (0.06 * t).sin() } else { 0.0 }), "one after another");
        assert!(of(&|_, t| ((t / 20.0).floor() + (t / 20.0).fract().min(0.5)) * 0.1), "dwells of all joints");
    }
}
