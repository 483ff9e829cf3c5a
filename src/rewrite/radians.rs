//! Programs whose joint angles are probably radians under names that say degrees.
//!
//! That all angles are small proves nothing: a short program near the zero of its joints is like that, too. What tells are right angles: a
//! pose taught in radians has several joints at +-pi/2, pi/4 or pi. The suspicion needs two joints at such values in the first or the last
//! row, and no angle of the program beyond a turn in radians. Two of six angles in degrees stand so by chance in 1 of 40,000 rows.
//!
//! Or else: an arm of four joints or more, many rows, no angle beyond half a turn in radians, one beyond 1, and more digits than a pendant
//! shows. In degrees such an arm would stay within 3 deg of its zero with all its joints, which is a stretched or a singular pose.
//!
//! How it fails: a short program in radians without right angles is not noticed. It is a note, never a refusal.

use super::Points;
use crate::robot::{JointKind, Robot};
use std::f64::consts::{FRAC_PI_4, PI, TAU};

/// Angles as written with three decimals, in the unit of the file.
const ROUNDED: f64 = 5e-4;
/// Joints that have to stand at such an angle.
const JOINTS: usize = 2;
/// Rows from which small angles alone are suspicious.
const MANY: usize = 50;
/// Turning joints of an arm that cannot work with all of them near zero.
const ARM: usize = 4;

/// What is looked at while points pass.
#[derive(Debug, Default)]
pub struct Suspicion {
    /// An angle is larger than a turn in radians.
    large: bool,
    ends: bool,
    seen: bool,
    last: Vec<f64>,
    rows: usize,
    /// Largest angle, as written.
    largest: f64,
    /// An angle has more than three decimals.
    fine: bool,
}

impl Suspicion {
    /// Looks at the next points, rad as they were read from degrees.
    pub fn see(&mut self, block: &Points, robot: &Robot) {
        if self.large || block.is_empty() {
            return;
        }
        let revolute: Vec<bool> = robot.axis_joints().map(|j| j.kind == JointKind::Revolute).collect();
        let is_large = |row: &[f64]| row.iter().zip(&revolute).any(|(v, r)| *r && v.abs().to_degrees() > TAU + ROUNDED);
        self.large = (0..block.len()).any(|i| is_large(block.row(i)));
        let angles = |row: &[f64]| -> Vec<f64> {
            row.iter().zip(&revolute).filter(|(_, r)| **r).map(|(v, _)| v.to_degrees()).collect()
        };
        if !self.seen {
            self.seen = true;
            self.ends = has_right_angles(&angles(block.row(0)));
        }
        self.last = angles(block.row(block.len() - 1));
        self.rows += block.len();
        for i in 0..block.len() {
            for v in angles(block.row(i)) {
                self.largest = self.largest.max(v.abs());
                self.fine |= (v * 1e3 - (v * 1e3).round()).abs() > 1e-3;
            }
        }
    }

    /// Many rows of an arm, all of them small.
    fn is_small_everywhere(&self) -> bool {
        let within = (1.0..=PI + ROUNDED).contains(&self.largest);
        self.last.len() >= ARM && self.rows >= MANY && within && self.fine
    }

    /// Whether the angles are probably radians.
    pub fn is_probable(&self) -> bool {
        self.seen && !self.large && (self.ends || has_right_angles(&self.last) || self.is_small_everywhere())
    }
}

fn has_right_angles(values: &[f64]) -> bool {
    let right = |v: &&f64| {
        let eighths = (**v / FRAC_PI_4).round();
        eighths != 0.0 && (**v - eighths * FRAC_PI_4).abs() <= ROUNDED
    };
    values.iter().filter(right).count() >= JOINTS
}

#[cfg(test)]
mod tests {
    use super::*;

    fn suspected(rows: &[[f64; 6]]) -> bool {
        let robot = Robot::parse("r", include_str!("../../configs/abb-irb2400-12-155.yaml")).unwrap();
        let q = rows.iter().flatten().map(|v| v.to_radians()).collect();
        let block = Points { axes: 6, q, ..Points::default() };
        let mut suspicion = Suspicion::default();
        suspicion.see(&block, &robot);
        suspicion.is_probable()
    }

    /// As a program of four decimals has it.
    const RIGHT_ANGLE: f64 = -15708e-4;

    #[test]
    fn a_pose_of_right_angles_in_radians_is_suspected_and_small_programs_are_not() {
        let start = [0.0, RIGHT_ANGLE, 1.571, 0.0, 1.0, 0.0];
        assert!(suspected(&[start, [0.2, -1.4, 1.3, 0.1, 0.9, 0.0]]));
        assert!(suspected(&[[0.2, -1.4, 1.3, 0.1, 0.9, 0.0], start]));
        // a short program in degrees, near zero
        assert!(!suspected(&[[0.0, 1.5, -2.0, 0.0, 3.0, 0.0], [0.5, 1.5, -2.25, 0.0, 3.1, 0.0]]));
        assert!(!suspected(&[[0.0; 6], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]]));
        // many rows of small angles with many digits, and the same with a joint that turns in degrees
        let path = |scale: f64| -> Vec<[f64; 6]> {
            let row = |k: i32| [0.1 * f64::from(k).sin(), -1.2 - 0.3123 * f64::from(k).cos(), 1.3, 0.2, 0.9, 0.05];
            (0..80).map(|k| row(k).map(|v| v * scale)).collect()
        };
        assert!(suspected(&path(1.0)) && !suspected(&path(1.0)[..20]));
        assert!(!suspected(&path(57.3)) && !suspected(&path(0.2)));
        // one right angle is chance, and an angle beyond a turn is none in radians
        assert!(!suspected(&[[0.0, RIGHT_ANGLE, 0.3, 0.0, 1.0, 0.0]]));
        assert!(!suspected(&[start, [0.2, -1.4, 1.3, 0.1, 30.0, 0.0]]));
    }
}
