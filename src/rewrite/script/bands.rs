//! Dead bands of a program's axes: by the digits of its targets.

use super::task::Task;
use crate::program::script::pose::Quantity;
use crate::program::script::{Script, TargetRef, Value};
use crate::rewrite::deadband;

/// Smallest dead band of a program with Cartesian targets, as a share of the smallest half gap: where straight TCP moves meet at a
/// corner near a joint's turn, the joint turns there and back, and two steps by the whole gap would cost more than that leg.
const DEADBAND_SHARE_TCP: f64 = 0.5;
/// Distance of a TCP from a joint at which the digits of its position count, m.
pub(super) const LEVER_M: f64 = 0.5;

/// What was asked for, else 1.5 of the coarsest last digits with which the axis is written and a share of its smallest half gap.
pub(super) fn deadbands(script: &Script, task: &Task) -> Vec<f64> {
    let poses = || script.targets.iter().filter(|t| t.pose.is_some());
    let of_pose = poses().map(pose_noise).fold(0.0, f64::max);
    let mut coarsest = vec![of_pose; task.robot.dof()];
    for target in script.targets.iter().filter(|t| t.pose.is_none()) {
        for (coarsest, weights) in coarsest.iter_mut().zip(target.values.weights()) {
            *coarsest = weights.map_or(*coarsest, |[digit, _]| coarsest.max(digit));
        }
    }
    let of_axis = |a: usize| coarsest.get(a).copied().unwrap_or(of_pose);
    let mut all = deadband::deadbands(task.deadband, task.compensator, task.robot.dof(), of_axis);
    if poses().next().is_some() {
        for (a, band) in all.iter_mut().enumerate().filter(|(a, _)| task.deadband.get(*a).is_none_or(Option::is_none)) {
            let least = task.compensator.on(a).and_then(deadband::smallest).map_or(0.0, |gap| DEADBAND_SHARE_TCP * gap);
            *band = band.max(least);
        }
    }
    all
}

/// What the last digits of a pose make of a joint, rad: of its angles, and of its lengths at [`LEVER_M`].
fn pose_noise(target: TargetRef) -> f64 {
    let of = |(k, v): (usize, Option<Value>)| {
        let digit = v?.digit;
        Some(match target.pose?.quantity(k) {
            Quantity::Length => digit / LEVER_M,
            Quantity::Angle => digit,
            Quantity::Ratio => 2.0 * digit,
        })
    };
    target.values.iter().enumerate().filter_map(of).fold(0.0, f64::max)
}
