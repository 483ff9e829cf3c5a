//! How far a joint must move against its direction before that is a reversal.

use crate::compensator::{Compensator, JointCompensator};

/// The dead band is this many last digits of how an axis is written: rounding to even and odd digits is no movement.
const DIGITS: f64 = 1.5;

/// Share of its smallest half gap that a joint must move against its direction before that is a reversal: what is left
/// uncompensated on a shorter leg is no more than this, and the joint would have to step by the whole gap for it.
const DEADBAND_SHARE: f64 = 0.1;
/// Smallest dead band, rad or m.
const LEAST_DEADBAND: f64 = 1e-9;

/// Dead band of each axis, rad or m: the `chosen` one, else by the `last_digit` with which the axis is written.
pub(super) fn deadbands(
    chosen: &[Option<f64>],
    compensator: &Compensator,
    axes: usize,
    last_digit: impl Fn(usize) -> f64,
) -> Vec<f64> {
    let of = |a: usize| match chosen.get(a).copied().flatten() {
        Some(chosen) => chosen,
        None => deadband(last_digit(a), compensator.on(a)),
    };
    (0..axes).map(of).collect()
}

/// Dead band of a joint whose program is written with such a last digit, rad or m: 1.5 of them, at most the smallest half gap, and
/// at least its share of [`DEADBAND_SHARE`].
fn deadband(last_digit: f64, joint: Option<&JointCompensator>) -> f64 {
    let (gap, digits) = (joint.and_then(smallest), DIGITS * last_digit);
    gap.map_or(digits, |gap| digits.min(gap).max(DEADBAND_SHARE * gap)).max(LEAST_DEADBAND)
}

/// Smallest half gap of a joint that is above 0, rad or m; of a joint with friction alone, its gain.
pub(super) fn smallest(joint: &JointCompensator) -> Option<f64> {
    let curves = joint.backlash.iter().flat_map(|b| [&b.positive, &b.negative]);
    let gaps = curves.map(|c| if c.smallest() > 0.0 { c.smallest() } else { c.largest() });
    let least = gaps.filter(|g| *g > 0.0).fold(f64::INFINITY, f64::min);
    if least.is_finite() { Some(least) } else { joint.friction.map(|f| f.gain.abs()).filter(|g| *g > 0.0) }
}
