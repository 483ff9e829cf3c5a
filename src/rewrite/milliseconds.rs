//! Programs whose times are probably milliseconds in a column `t_s`.
//!
//! Rows of a path are some hundredths of a second apart; in milliseconds they are whole numbers from 4 up. What tells is the motion: read
//! as seconds, no joint comes near a thousandth of its largest speed. Only the first rows are looked at, and none after a time that is no
//! whole number.
//!
//! How it fails: a program that really moves so slowly gets a note that does not concern it. It is a note, never a refusal.

use super::Points;
use crate::robot::{Joint, Robot};

/// Rows from which times are suspicious, and up to which they are looked at.
const MANY: usize = 10;
const LOOKED_AT: usize = 4096;
/// Mean time between two rows, s as read: that of a slow controller in milliseconds.
const APART_S: f64 = 4.0;
/// Part of its largest speed beyond which no joint moves if the seconds are milliseconds.
const SHARE: f64 = 1e-3;
/// Largest speeds of joints whose robot file has none, rad/s and m/s.
const USUAL: [f64; 2] = [2.0, 1.0];

/// What is looked at while points pass.
#[derive(Debug, Default)]
pub struct Suspicion {
    /// A time is no whole number, or a joint is too fast.
    cleared: bool,
    first_s: Option<f64>,
    last: Option<(f64, Vec<f64>)>,
    rows: usize,
}

impl Suspicion {
    /// Looks at the next points.
    pub fn see(&mut self, block: &Points, robot: &Robot) {
        if self.cleared || block.t_s.is_empty() || self.rows >= LOOKED_AT {
            return;
        }
        let fastest: Vec<f64> = robot.axis_joints().map(fastest).collect();
        for i in 0..block.len().min(LOOKED_AT - self.rows) {
            let Some(&t_s) = block.t_s.get(i) else { return };
            let row = block.row(i);
            let slow = self.last.as_ref().is_none_or(|(before_s, before)| {
                let moved = row.iter().zip(before).zip(&fastest);
                let allowed = SHARE * (t_s - before_s);
                moved.map(|((q, p), v)| (q - p).abs() / v).all(|share| share <= allowed)
            });
            if t_s.fract() != 0.0 || !slow {
                self.cleared = true;
                return;
            }
            self.first_s.get_or_insert(t_s);
            self.last = Some((t_s, row.to_vec()));
            self.rows += 1;
        }
    }

    /// Whether the times are probably milliseconds.
    pub fn is_probable(&self) -> bool {
        let (Some(first_s), Some((last_s, _))) = (self.first_s, &self.last) else { return false };
        !self.cleared && self.rows >= MANY && last_s - first_s >= APART_S * (self.rows - 1) as f64
    }
}

/// Largest speed of a joint, rad/s or m/s.
fn fastest(joint: &Joint) -> f64 {
    let usual = joint.kind.pick(USUAL);
    joint.max_speed.filter(|v| *v > 0.0).unwrap_or(usual)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// A swing of the first joint by 5 deg, rows `apart` apart, in one motion of so many seconds.
    fn looks(apart: f64, motion_s: f64) -> bool {
        let robot = Robot::load(Path::new("configs/kuka-kr120-r2500-pro.yaml")).unwrap();
        let axes = robot.dof();
        let rows = 50;
        let mut points = Points { axes, ..Points::default() };
        for k in 0..rows {
            let share = f64::from(k) / f64::from(rows - 1);
            let mut q = vec![0.0; axes];
            q[0] = (5.0 * (std::f64::consts::PI * share).sin()).to_radians();
            points.q.extend(q);
            points.t_s.push(if motion_s > 0.0 { motion_s * share } else { f64::from(k) * apart });
        }
        let mut seen = Suspicion::default();
        seen.see(&points, &robot);
        seen.is_probable()
    }

    #[test]
    fn whole_numbers_at_which_no_joint_really_moves_are_milliseconds() {
        assert!(looks(40.0, 0.0) && looks(100.0, 0.0));
        // seconds, whole or not
        assert!(!looks(1.0, 0.0) && !looks(0.0, 2.0) && !looks(0.04, 0.0));
    }
}
