//! Which number of a C line is which joint of the robot file.
//!
//! A controller counts S, L, U, R, B, T, and E, the joint between L and U of an arm of seven, last; a robot file lists joints along the
//! arm. So joints named by these letters (`E`, `joint_3_e`) are found by them, others by the numbers in their names (`J6`), or by their
//! places. An arm with fewer joints has either as many numbers as joints, in this order, or the list of six with gaps: S, L, U, -, -, T.
//!
//! Reference: Yaskawa, MotoROS2, `src/CtrlGroup.c`: the orders of the pulses that a controller gives. Assumes that a job lists them alike.

use crate::axes::{Axes, Axis, JointKind, OF_ARM};

/// Joints of an arm in the order of the controller.
const LETTERS: &[u8; 7] = b"SLURBTE";

/// Which axes of the robot have which numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Order {
    /// Axis and number, from 1, of each joint of the arm; numbers ascend.
    pub(super) arm: Vec<(usize, usize)>,
    /// The other axes, in their order.
    pub(super) external: Vec<usize>,
    /// It is known which axes are external.
    pub(super) certain: bool,
    /// Names tell the numbers of the arm, or it has six.
    pub(super) numbered: bool,
}

/// The number of a joint by the letter that its name is, or ends in after a `_`.
fn by_letter(joint: &Axis) -> Option<usize> {
    let [letter] = joint.name.rsplit('_').next()?.as_bytes() else { return None };
    let number = LETTERS.iter().position(|l| l.eq_ignore_ascii_case(letter))? + 1;
    // a rail may have this name, too
    (joint.kind == JointKind::Revolute || number <= OF_ARM).then_some(number)
}

impl Order {
    pub(super) fn of(robot: &Axes) -> Self {
        let places = robot.places();
        let lettered = || {
            let joints = robot.axis_joints().enumerate();
            let mut arm: Vec<(usize, usize)> = joints.filter_map(|(k, j)| Some((k, by_letter(j)?))).collect();
            arm.sort_by_key(|a| a.1);
            let rest: Vec<usize> = (0..robot.dof()).filter(|k| arm.iter().all(|a| a.0 != *k)).collect();
            let external: Vec<usize> = places.external.iter().map(|e| e.1).filter(|k| rest.contains(k)).collect();
            let apart = arm.windows(2).all(|w| w[0].1 != w[1].1);
            let whole = apart && !arm.is_empty() && external.len() == rest.len();
            whole.then_some(Self { arm, external, certain: true, numbered: true })
        };
        lettered().unwrap_or_else(|| {
            let mut arm: Vec<(usize, usize)> = places.arm.iter().copied().zip(places.numbers.iter().copied()).collect();
            arm.sort_by_key(|a| a.1);
            let external = places.external.iter().map(|e| e.1).collect();
            Self { arm, external, certain: places.certain, numbered: places.numbered }
        })
    }

    /// Whether the numbers are those of the axes, one after the other, and the external ones follow.
    pub(super) fn is_plain(&self) -> bool {
        self.arm.iter().zip(0..).all(|(a, k)| *a == (k, k + 1))
    }

    /// Whether a line with as many numbers as the robot has axes has them in the order of the robot file.
    pub(super) fn is_in_order(&self) -> bool {
        let in_order = self.arm.iter().zip(0..).all(|(a, k)| a.0 == k);
        self.certain && in_order && (self.external.is_empty() || self.is_plain())
    }

    /// The place, from 0, of each joint of the arm on a C line of so many numbers, and how many of them are the arm's; `None`: not certain.
    pub(super) fn on_line(&self, count: usize) -> Option<(Vec<(usize, usize)>, usize)> {
        if count == self.arm.len() {
            return Some((self.arm.iter().zip(0..).map(|(a, k)| (a.0, k)).collect(), count));
        }
        let last = self.arm.last().map_or(0, |a| a.1);
        let places = || self.arm.iter().map(|a| (a.0, a.1 - 1)).collect();
        (self.numbered && count >= last).then(|| (places(), count.min(last.max(OF_ARM))))
    }
}

/// The place, from 0, of each axis of the robot on a C line that has one for every joint of its controller; `None`: the names of the
/// robot's joints do not tell it, or an external axis carries the arm, so that its number stands on another line.
///
/// ```
/// use robot_programs::axes::{Axes, Axis, JointKind};
/// let arm = |names: &[&str]| Axes::new("r", names.iter().map(|n| Axis::new(*n, JointKind::Revolute)).collect());
/// let places = robot_programs::inform::places_on_line(&arm(&["S", "L", "E", "U", "R", "B", "T"]));
/// assert_eq!(places, Some(vec![0, 1, 6, 2, 3, 4, 5]));
/// assert_eq!(robot_programs::inform::places_on_line(&arm(&["S", "L", "U", "T"])), Some(vec![0, 1, 2, 5]));
/// ```
pub fn places_on_line(robot: &Axes) -> Option<Vec<usize>> {
    let order = Order::of(robot);
    let last = order.arm.last().map_or(0, |a| a.1).max(OF_ARM);
    let first_of_arm = order.arm.iter().map(|a| a.0).min()?;
    if !(order.certain && order.numbered) || order.external.iter().any(|k| *k < first_of_arm) {
        return None;
    }
    let mut places: Vec<(usize, usize)> = order.arm.iter().map(|a| (a.0, a.1 - 1)).collect();
    places.extend(order.external.iter().zip(last..).map(|(axis, k)| (*axis, k)));
    places.sort_unstable();
    Some(places.into_iter().map(|p| p.1).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(names: &[&str]) -> Order {
        Order::of(&Axes::new("r", names.iter().map(|n| Axis::new(*n, JointKind::Revolute)).collect()))
    }

    #[test]
    fn letters_tell_the_numbers_of_arms_of_seven_and_of_four() {
        for names in [
            ["S", "L", "E", "U", "R", "B", "T"],
            ["joint_1_s", "joint_2_l", "joint_3_e", "joint_4_u", "joint_5_r", "joint_6_b", "joint_7_t"],
        ] {
            let seven = order(&names);
            assert_eq!(seven.arm, [(0, 1), (1, 2), (3, 3), (4, 4), (5, 5), (6, 6), (2, 7)], "{names:?}");
            assert!(seven.certain && seven.external.is_empty() && !seven.is_in_order() && !seven.is_plain());
            assert_eq!(seven.on_line(6), None);
        }
        let on_track = order(&["S", "L", "E", "U", "R", "B", "T", "E1"]);
        assert_eq!((on_track.external, on_track.certain), (vec![7], true));
        let palletizer = order(&["S", "L", "U", "T"]);
        assert_eq!(palletizer.on_line(4).unwrap().0, [(0, 0), (1, 1), (2, 2), (3, 3)]);
        assert_eq!(palletizer.on_line(6), Some((vec![(0, 0), (1, 1), (2, 2), (3, 5)], 6)));
        assert_eq!(palletizer.on_line(5), None);
        assert!(palletizer.is_in_order() && !palletizer.is_plain());
    }

    #[test]
    fn six_joints_of_any_name_stand_in_their_order() {
        for names in
            [["S", "L", "U", "R", "B", "T"], ["J1", "J2", "J3", "J4", "J5", "J6"], ["a", "b", "c", "d", "x", "y"]]
        {
            let six = order(&names);
            assert!(six.is_plain() && six.is_in_order(), "{names:?}");
        }
        // fewer without a number have one for each joint, or none is certain
        let four = order(&["a", "b", "c", "d"]);
        assert!(four.on_line(4).is_some() && four.on_line(6).is_none());
        let numbered = order(&["J1", "J2", "J3", "J6"]);
        assert_eq!(numbered.on_line(6).unwrap().0, [(0, 0), (1, 1), (2, 2), (3, 5)]);
    }
}
