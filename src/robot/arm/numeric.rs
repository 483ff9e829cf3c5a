//! Solutions of arms without a closed form: the numerical inverse from a fixed set of starts. It may miss solutions, and says
//! nothing where none of the starts leads to one.

use super::{REACHED_M, REACHED_RAD, SAME_RAD, nearest_turns};
use crate::robot::{InverseOptions, Pose, Robot, Target};
use std::f64::consts::{FRAC_PI_2, PI};

/// Starts besides the joints before: both senses of the joints that make branches.
const FLIPS: usize = 32;

pub(super) fn solutions(robot: &Robot, pose: &Pose, near: &[f64]) -> Vec<Vec<f64>> {
    let options = InverseOptions {
        target_error_m: REACHED_M * 0.1,
        target_error_rad: REACHED_RAD * 0.1,
        ..InverseOptions::default()
    };
    let mut found: Vec<Vec<f64>> = Vec::new();
    for k in 0..=FLIPS {
        let mut start = near.to_vec();
        if k > 0 {
            let bit = |b: usize| if (k - 1) >> b & 1 == 1 { 1.0 } else { -1.0 };
            for (axis, v) in start.iter_mut().enumerate() {
                *v = match axis {
                    0 => *v + if bit(0) > 0.0 { PI } else { 0.0 },
                    1 => *v * bit(1),
                    2 => *v + bit(2) * FRAC_PI_2,
                    3 => *v + if bit(3) > 0.0 { PI } else { 0.0 },
                    4 => bit(4) * v.abs().max(0.3),
                    _ => *v,
                };
            }
        }
        let result = robot.inverse(&Target::Pose(*pose), &start, &options);
        if result.error_m > REACHED_M || result.error_rad > REACHED_RAD {
            continue;
        }
        let mut q = result.q;
        nearest_turns(&mut q, near);
        if !found.iter().any(|other| other.iter().zip(&q).all(|(a, b)| (a - b).abs() < 1e3 * SAME_RAD)) {
            found.push(q);
        }
    }
    found
}
