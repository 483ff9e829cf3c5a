//! Which waves over the travel of a joint the places of settled poses distinguish from slower ones.
//!
//! Method: a wave that shows all places alike is an alias (Shannon (1949) for even spacing; here by the spectral window of the places
//! themselves, as in Scargle (1982)). Waves are looked at in steps of an eighth of a cycle, each turned on from the one before, so that
//! thousands of poses take no sine per wave.

use crate::diagnose::problem::forward::Problem;
use crate::numerics::fourier::Complex;
use crate::numerics::robust::range;
use std::f64::consts::TAU;

/// Cycles over the travel at most that poses are looked at for.
const MOST_CYCLES: f64 = 256.0;
/// Of evenly spaced poses all waves that differ by their spacing are one. A wave that shows all poses this much alike is such a
/// difference.
const ALIKE: f64 = 0.9;
/// Waves in a cycle: a line is as wide as one.
const PER_CYCLE: usize = 8;

impl Problem {
    /// Most cycles over the travel of an axis that the places of the logs distinguish from fewer, and the travel (rad or m). Found
    /// once for all axes.
    pub fn told_waves(&self, axis: usize) -> (f64, f64) {
        let of = |axis: usize| {
            let places: Vec<f64> = self.logs.iter().flat_map(|l| l.trajectory.command(axis).iter().copied()).collect();
            told_by(&places)
        };
        // one after the other: a thread of the pool that waits in here would take up work that waits for this very value
        let all = self.determined.get_or_init(|| (0..self.robot.dof()).map(of).collect());
        all.get(axis).copied().unwrap_or_default()
    }
}

/// Most cycles over the travel that samples at these places distinguish from fewer, and the travel: half a cycle from one sample to the
/// next where they are spread, half of the spacing's own wave where they stand on a grid.
fn told_by(places: &[f64]) -> (f64, f64) {
    let [lo, hi] = range(places.iter().copied());
    let travel = hi - lo;
    if travel.is_nan() || travel <= 0.0 {
        return (0.0, 0.0);
    }
    let most = (0.5 * (places.len() - 1) as f64).min(MOST_CYCLES);
    let angles = || places.iter().map(|p| TAU * (p - lo) / travel);
    let by: Vec<Complex<f64>> = angles().map(|a| Complex::cis(a / PER_CYCLE as f64)).collect();
    let mut at: Vec<Complex<f64>> = angles().map(Complex::cis).collect();
    let least = ALIKE * places.len() as f64;
    let alias = (0..(2.0 * PER_CYCLE as f64 * most) as usize).find(|_| {
        let sum: Complex<f64> = at.iter().sum();
        at.iter_mut().zip(&by).for_each(|(z, r)| *z *= r);
        sum.norm() > least
    });
    let wave = |k: usize| 1.0 + k as f64 / PER_CYCLE as f64;
    (alias.map_or(most, |k| 0.5 * wave(k)).min(most), travel)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poses_on_a_grid_tell_half_a_cycle_from_one_place_to_the_next() {
        // twelve places, each visited fifty times and reached within a thirtieth of their distance
        let scatter = |k: usize| ((k * 7919) % 101) as f64 / 101.0 / 15.0 - 1.0 / 30.0;
        let grid: Vec<f64> = (0..600).map(|k| (k % 12) as f64 + scatter(k)).collect();
        let (cycles, travel) = told_by(&grid);
        assert!((5.0..=5.6).contains(&cycles) && (travel - 11.0).abs() < 0.07, "{cycles} of {travel}");
        // spread by the golden ratio: no wave shows them alike
        let spread: Vec<f64> = (0..21).map(|k| (f64::from(k) * 0.618_033_988_75).fract()).collect();
        assert_eq!(told_by(&spread).0, 10.0);
        // two places tell nothing
        assert!(told_by(&[0.0, 1.0, 0.0, 1.0, 0.0, 1.0]).0 < 2.0);
        assert_eq!(told_by(&[0.3, 0.3]), (0.0, 0.0));
    }
}
