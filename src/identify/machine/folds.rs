//! Stretches of a log that are left out together, so that what is left still tells of every joint.
//!
//! Judging by parts that were not fitted asks for a prediction, not for an estimate from nothing: where a log moves one joint after
//! the other, a sixth of it in one piece is all that there is of a joint, and what is left knows neither its gap nor where its body
//! stands. Such a log is cut into shorter stretches, every sixth of which makes a fold.

use std::ops::Range;

/// Folds of a log.
pub const FOLDS: usize = 6;
/// Share of a joint's reversals in one fold from which shorter stretches are looked for.
const MOST: f64 = 0.4;
/// Share at which the search ends.
const ENOUGH: f64 = 1.0 / 3.0;
/// Reversals of a joint that one fold may hold in any case.
const FEW: usize = 2;

/// The stretches of each fold, of `bins` bins in all; `turned` holds the bins in which each joint turns, and no stretch is shorter than
/// `shortest` bins unless a sixth of the log is.
pub fn folds(bins: usize, turned: &[Vec<usize>], shortest: usize) -> Vec<Vec<Range<usize>>> {
    let most = |folds: &[Vec<Range<usize>>]| {
        let of = |turns: &Vec<usize>| {
            let inside = |fold: &Vec<Range<usize>>| turns.iter().filter(|t| fold.iter().any(|s| s.contains(t))).count();
            let most = folds.iter().map(inside).max().unwrap_or(0);
            if most > FEW { most as f64 / turns.len() as f64 } else { 0.0 }
        };
        turned.iter().map(of).fold(0.0, f64::max)
    };
    let whole = cut(bins, 1);
    let mut best = (most(&whole), whole);
    if best.0 <= MOST {
        return best.1;
    }
    for stretches in 2..=bins / (FOLDS * shortest.max(1)) {
        let shorter = cut(bins, stretches);
        let share = most(&shorter);
        if share < best.0 {
            best = (share, shorter);
        }
        if best.0 <= ENOUGH {
            break;
        }
    }
    best.1
}

/// Folds of so many stretches each, which take turns.
fn cut(bins: usize, stretches: usize) -> Vec<Vec<Range<usize>>> {
    let width = bins.div_ceil(FOLDS * stretches).max(1);
    let stretch = |k: usize| (k * width).min(bins)..((k + 1) * width).min(bins);
    (0..FOLDS)
        .map(|fold| (0..stretches).map(|s| stretch(s * FOLDS + fold)).filter(|s| !s.is_empty()).collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inside(folds: &[Vec<Range<usize>>], turns: &[usize]) -> Vec<usize> {
        folds.iter().map(|f| turns.iter().filter(|t| f.iter().any(|s| s.contains(t))).count()).collect()
    }

    #[test]
    fn a_log_whose_joints_turn_all_along_is_left_out_in_six_pieces() {
        let turned = [(5..600).step_by(40).collect(), (25..600).step_by(70).collect(), vec![300]];
        let found = folds(601, &turned, 60);
        let want: Vec<Vec<Range<usize>>> =
            [0..101, 101..202, 202..303, 303..404, 404..505, 505..601].into_iter().map(|r| vec![r]).collect();
        assert_eq!(found, want);
    }

    #[test]
    fn a_log_that_moves_one_joint_after_the_other_keeps_most_of_each_joint_in_every_fold() {
        for (joints, per) in [(6, 800), (3, 900), (7, 731)] {
            let turned: Vec<Vec<usize>> =
                (0..joints).map(|j| (j * per + 15..(j + 1) * per).step_by(25).collect()).collect();
            let bins = joints * per;
            let found = folds(bins, &turned, 60);
            let mut all: Vec<Range<usize>> = found.iter().flatten().cloned().collect();
            all.sort_by_key(|r| r.start);
            assert!(all.windows(2).all(|w| w[0].end == w[1].start) && all[0].start == 0);
            assert_eq!(all.last().unwrap().end, bins, "every bin is left out once");
            assert!(all[..all.len() - 1].iter().all(|r| r.len() >= 60));
            for turns in &turned {
                let most = inside(&found, turns).into_iter().max().unwrap();
                assert!(3 * most <= turns.len() + 2, "{joints} joints: {most} of {}", turns.len());
            }
        }
    }

    #[test]
    fn short_logs_and_joints_that_turn_once_are_left_out_as_they_are() {
        assert_eq!(folds(30, &[vec![1, 2, 3, 4]], 60).len(), FOLDS);
        assert_eq!(folds(600, &[vec![50], vec![310, 320]], 60), cut(600, 1));
        assert!(folds(0, &[], 60).iter().all(Vec::is_empty));
    }
}
