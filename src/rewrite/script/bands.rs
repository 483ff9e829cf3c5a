//! Dead bands of a program's axes: by the digits of its targets.

use super::task::Task;
use crate::program::script::pose::Quantity;
use crate::program::script::{Script, TargetRef};
use crate::rewrite::deadband;

/// Smallest dead band of a program with Cartesian targets, as a share of the smallest half gap: where straight TCP moves meet at a
/// corner near a joint's turn, the joint turns there and back, and two steps by the whole gap would cost more than that leg.
const DEADBAND_SHARE_TCP: f64 = 0.5;
/// Distance of a TCP from a joint at which the digits of its position count, m.
pub(super) const LEVER_M: f64 = 0.5;

/// What was asked for, else 1.5 of the last digits with which the axis is written and a share of its smallest half gap. Zeros at the end
/// are often left out: the finest number tells how exact they all are.
pub(super) fn deadbands(script: &Script, task: &Task) -> Vec<f64> {
    let mut poses = PoseDigits::default();
    let mut finest = vec![f64::INFINITY; task.robot.dof()];
    for target in script.targets.iter() {
        if target.pose.is_some() {
            poses.see(target);
            continue;
        }
        for (finest, weights) in finest.iter_mut().zip(target.values.weights()) {
            *finest = weights.map_or(*finest, |[digit, _]| finest.min(digit));
        }
    }
    let of_pose = poses.noise();
    let of_axis = |a: usize| finest.get(a).filter(|digit| digit.is_finite()).map_or(of_pose, |d| d.max(of_pose));
    let mut all = deadband::deadbands(task.deadband, task.compensator, task.robot.dof(), of_axis);
    if poses.any {
        for (a, band) in all.iter_mut().enumerate().filter(|(a, _)| task.deadband.get(*a).is_none_or(Option::is_none)) {
            let least = task.compensator.on(a).and_then(deadband::smallest).map_or(0.0, |gap| DEADBAND_SHARE_TCP * gap);
            *band = band.max(least);
        }
    }
    all
}

/// Digits of the poses of a program, number by number.
#[derive(Default)]
struct PoseDigits {
    any: bool,
    /// What the last digit of each number makes of a joint, rad, where it is finest; the first value; whether others differ from it.
    numbers: Vec<(f64, f64, bool)>,
}

impl PoseDigits {
    fn see(&mut self, target: TargetRef) {
        self.any = true;
        for (k, value) in target.values.iter().enumerate() {
            let (Some(value), Some(pose)) = (value, target.pose) else { continue };
            let noise = noise_rad(pose.quantity(k), value.digit);
            if self.numbers.len() <= k {
                self.numbers.resize(k + 1, (f64::INFINITY, f64::NAN, false));
            }
            let (finest, first, differs) = &mut self.numbers[k];
            *finest = finest.min(noise);
            *differs |= *first != value.si && !first.is_nan();
            *first = if first.is_nan() { value.si } else { *first };
        }
    }

    /// What the digits make of a joint, rad. A number that is the same in all poses is no less exact for few digits.
    fn noise(&self) -> f64 {
        self.numbers.iter().filter(|n| n.2).map(|n| n.0).fold(0.0, f64::max)
    }
}

/// What the last digit of a number of a pose makes of a joint, rad: of an angle, and of a length at [`LEVER_M`].
fn noise_rad(quantity: Quantity, digit: f64) -> f64 {
    match quantity {
        Quantity::Length => digit / LEVER_M,
        Quantity::Angle => digit,
        Quantity::Ratio => 2.0 * digit,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::script::{Format, Text};
    use crate::robot::Robot;
    use robot_programs::krl::Krl;

    fn noise_rad(poses: [&str; 2]) -> f64 {
        let robot = Robot::parse("robot", include_str!("../../../configs/kuka-kr120-r2500-pro.yaml")).unwrap();
        let moves = poses.map(|pose| format!("LIN {{{pose}}}\n")).concat();
        let text = Text::new("m.src", format!("DEF m( )\n{moves}END\n").into_bytes());
        let document = Krl.parse(vec![text], robot.axes()).unwrap();
        let mut digits = PoseDigits::default();
        document.script().targets.iter().for_each(|target| digits.see(target));
        assert_eq!(digits.numbers.len(), 6);
        digits.noise()
    }

    #[test]
    fn numbers_that_are_the_same_in_all_poses_and_zeros_that_are_left_out_do_not_count() {
        // 0.001 mm at half a metre
        let of_length = 1e-6 / LEVER_M;
        let near = |is: f64, want: f64| assert!((is - want).abs() < 1e-12, "{is} for {want}");
        near(
            noise_rad(["X 1500.000,Y 0,Z 1000.000,A 0,B 90,C 0", "X 1400.000,Y 0,Z 1000.000,A 0,B 90,C 0"]),
            of_length,
        );
        near(noise_rad(["X 1500.125,Y 0,Z 1000.5,A 0,B 90,C 0", "X 1400,Y 0,Z 1000.125,A 0,B 90,C 0"]), of_length);
        // an angle that turns in whole degrees
        let turned = ["X 1500.125,Y 0,Z 1000.5,A 0,B 90,C 0", "X 1400,Y 0,Z 1000.125,A 0,B 90,C 4"];
        near(noise_rad(turned), 1f64.to_radians());
    }
}
