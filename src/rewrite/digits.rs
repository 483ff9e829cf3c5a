//! With how many digits offsets are written: no last digit may be coarse beside the smallest half gap.

use super::deadband::smallest;
use super::job::Job;
use crate::error::{Error, Result};

/// A last digit is coarse where it is more than this share of the smallest half gap.
const COARSE: f64 = 0.05;
/// Decimals that the rule above asks for at most.
const MOST_DECIMALS: u8 = 9;
/// Decimals of a joint that is corrected at every point: 1e-6 deg is 0.05 um at a lever of 3 m.
const STATIC_DECIMALS: u8 = 6;
/// The same as the weight of a last digit, rad or m.
const STATIC_DIGIT: f64 = 1e-8;
/// Last digits of poses: lengths, m (0.0001 mm), and angles, rad (0.0001 deg).
const POSE_DIGITS: [f64; 2] = [1e-7, 1.75e-6];
/// Last digit of the other joints at a new point of a vendor program, rad or m: it must stand on the path.
const PATH_DIGIT: f64 = 2e-6;

impl Job<'_> {
    /// Decimals that each axis needs so that the last digit is no more than 5 % of its smallest half gap.
    pub(super) fn least_decimals(&self) -> Result<Vec<u8>> {
        let mut least = Vec::new();
        for (a, joint) in self.robot.axis_joints().enumerate() {
            let fine = if self.options.statics.as_ref().is_some_and(|s| s.changes(a)) { STATIC_DECIMALS } else { 0 };
            let Some(gap) = self.compensator.on(a).and_then(smallest) else {
                least.push(fine);
                continue;
            };
            let gap = joint.kind.to_user_unit(gap * self.options.gain);
            if let Some(n) = self.decimals
                && 10f64.powi(-i32::from(n)) > gap
                && gap > 0.0
            {
                return Err(Error::setting(
                    "decimals",
                    format!("{n} decimals for an offset of {gap:.6} {} of {}", joint.kind.unit(), joint.name),
                    "decimals that can hold the offset",
                ));
            }
            let digits = (0..MOST_DECIMALS).find(|&d| 10f64.powi(-i32::from(d)) <= COARSE * gap);
            least.push(digits.unwrap_or(MOST_DECIMALS).max(fine));
        }
        Ok(least)
    }

    /// Weight of the last digit that changed numbers of each axis should have at most, rad or m.
    pub(super) fn last_digits(&self) -> Result<Vec<f64>> {
        self.least_decimals()?; // refuses --decimals that cannot hold the offset
        let of = |(a, joint): (usize, &crate::robot::Joint)| {
            if let Some(n) = self.decimals {
                return 10f64.powi(-i32::from(n)) * joint.kind.si_per_user_unit();
            }
            let fine = self.options.statics.as_ref().is_some_and(|s| s.changes(a));
            let gap = self.compensator.on(a).and_then(smallest).map(|g| g * self.options.gain);
            // of a gain of 0 nothing is left but new points
            let gap = gap.filter(|g| *g > 0.0).unwrap_or(f64::INFINITY);
            (COARSE * gap).min(if fine { STATIC_DIGIT } else { PATH_DIGIT })
        };
        Ok(self.robot.axis_joints().enumerate().map(of).collect())
    }

    /// Weight of the last digits that changed numbers of poses should have at most, m and rad.
    pub(super) fn pose_digits(&self) -> [f64; 2] {
        let of = |n: u8| 10f64.powi(-i32::from(n));
        self.decimals.map_or(POSE_DIGITS, |n| [of(n) * 1e-3, of(n).to_radians()])
    }
}
