//! A jump of the tracker's frame while a log was recorded, as after a beam that was locked again.
//!
//! One frame for the whole log then lies between the two that it has, and everything that is left is off by half the jump. It shows in what
//! the fit leaves: the level before and after one bin differs in all coordinates together, by far more than at any other place, and
//! stays so. Gaps come back at the next reversal, and wander does not jump.

use super::problem::Problem;
use crate::gaps::note::machine::Note;
use nalgebra::Vector3;

/// Bins whose mean is the level just beside a jump, and the level that stays.
const SIDE: usize = 12;
const STAYS: usize = 60;
/// Size of a jump, in standard deviations of the difference of levels elsewhere.
const OUTSTANDING: f64 = 8.0;
/// Part of the jump by which the level that stays may differ from it.
const APART: f64 = 0.4;
/// Median length of a vector of three normal values of standard deviation 1.
const MEDIAN_LENGTH: f64 = 1.538;

/// Logs in which what is left jumps.
pub fn notes(problem: &Problem) -> Vec<Note> {
    let note = |log: usize| {
        let (l, residual) = (&problem.logs[log], problem.residual(log, &problem.responses(log, false)));
        let there: Vec<usize> = (0..l.len()).filter(|&k| l.whole && !l.missing[k]).collect();
        let points: Vec<Vector3<f64>> = there.iter().map(|&k| residual[k]).collect();
        let (at, by) = jump(&points)?;
        Some(Note::FrameJumps { log: l.name.clone(), by_m: by.norm(), at_s: l.t_s[there[at]] })
    };
    (0..problem.logs.len()).filter_map(note).collect()
}

/// Where a series jumps, if it does, and by how much.
fn jump(points: &[Vector3<f64>]) -> Option<(usize, Vector3<f64>)> {
    let n = points.len();
    if n < 4 * STAYS {
        return None;
    }
    let mut sums = vec![Vector3::zeros()];
    points.iter().for_each(|p| sums.push(sums[sums.len() - 1] + p));
    let step = |k: usize, side: usize| (sums[k + side] - 2.0 * sums[k] + sums[k - side]) / side as f64;
    let mut lengths: Vec<f64> = (SIDE..=n - SIDE).map(|k| step(k, SIDE).norm()).collect();
    let usual = crate::numerics::robust::median_of(&mut lengths)? / MEDIAN_LENGTH;
    let at = (STAYS..=n - STAYS).max_by(|a, b| step(*a, SIDE).norm().total_cmp(&step(*b, SIDE).norm()))?;
    let (near, stays) = (step(at, SIDE), step(at, STAYS));
    (near.norm() > OUTSTANDING * usual && (stays - near).norm() < APART * near.norm()).then_some((at, near))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values between -1 and 1 that look like noise.
    fn noise(k: usize) -> f64 {
        ((k * 7919 + 104_729) % 1013) as f64 / 506.0 - 1.0
    }

    #[test]
    fn a_level_that_changes_and_stays_is_a_jump_and_one_that_comes_back_is_none() {
        let series = |level: &dyn Fn(usize) -> f64| -> Vec<Vector3<f64>> {
            (0..1500)
                .map(|k| Vector3::new(level(k) + noise(k), noise(3 * k + 1) - level(k), noise(7 * k + 2)))
                .collect()
        };
        let (at, by) = jump(&series(&|k| if k < 700 { 0.0 } else { 4.0 })).unwrap();
        assert!(at.abs_diff(700) <= 1 && (by - Vector3::new(4.0, -4.0, 0.0)).norm() < 1.0, "{at} {by}");
        assert!(jump(&series(&|_| 0.0)).is_none());
        // a gap between two reversals, and a slow drift
        assert!(jump(&series(&|k| if (700..730).contains(&k) { 4.0 } else { 0.0 })).is_none());
        assert!(jump(&series(&|k| 8.0 * k as f64 / 1500.0)).is_none());
    }
}
