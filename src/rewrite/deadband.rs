//! How far a joint must move against its direction before that is a reversal.

use crate::compensator::JointCompensator;

/// Share of its smallest half gap that a joint must move against its direction before that is a reversal: what is left
/// uncompensated on a shorter leg is no more than this, and the joint would have to step by the whole gap for it.
const DEADBAND_SHARE: f64 = 0.1;
/// Smallest dead band, rad or m.
const LEAST_DEADBAND: f64 = 1e-9;

/// Dead band of a joint whose program is written in such digits, rad or m: these `digits`, at most the smallest half gap, and at
/// least its share of [`DEADBAND_SHARE`].
pub(super) fn deadband(digits: f64, joint: Option<&JointCompensator>) -> f64 {
    let gap = joint.and_then(smallest);
    gap.map_or(digits, |gap| digits.min(gap).max(DEADBAND_SHARE * gap)).max(LEAST_DEADBAND)
}

/// Smallest half gap of a joint that is above 0, rad or m; of a joint with friction alone, its gain.
pub(super) fn smallest(joint: &JointCompensator) -> Option<f64> {
    let curves = joint.backlash.iter().flat_map(|b| [&b.positive, &b.negative]);
    let gaps = curves.map(|c| if c.smallest() > 0.0 { c.smallest() } else { c.largest() });
    let least = gaps.filter(|g| *g > 0.0).fold(f64::INFINITY, f64::min);
    if least.is_finite() { Some(least) } else { joint.friction.map(|f| f.gain.abs()).filter(|g| *g > 0.0) }
}
