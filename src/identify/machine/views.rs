//! Two views of the same logs, and the estimate between them.
//!
//! Autoregressive noise takes every slow part of the residual for noise, that of laws whose form is not the machine's, too. A fit that is
//! whitened by it follows the sharp detail just after a reversal and loses some of what stays. A fit that takes noise for uncorrelated
//! weighs each part of the error by its size, as the path error of a program does, and takes slow noise for lost motion. Where the two
//! differ, the logs do not tell which is right; the middle has the smallest largest distance to both, and half the difference is
//! part of its uncertainty.

use super::noise::Noise;
use super::problem::Problem;
use super::solve::{self, FixedLaws};
use nalgebra::DVector;

/// Rounds of fitting with uncorrelated noise.
const ROUNDS: usize = 2;

/// Puts the laws between both views; returns half of the difference, zero for nuisances, which are fitted to the middle.
pub fn middle(problem: &mut Problem) -> DVector<f64> {
    let (coloured, noise) = (problem.values(), problem.noise.clone());
    for _ in 0..ROUNDS {
        problem.noise = (0..problem.logs.len())
            .map(|l| Noise::uncorrelated(&problem.residual(l, &problem.responses(l, false)), &problem.unused[l]))
            .collect();
        problem.whiten_columns();
        solve::round(problem, FixedLaws::Nothing);
    }
    let mut half = (problem.values() - &coloured) * 0.5;
    let lost = problem.lost();
    half.rows_mut(lost, coloured.len() - lost).fill(0.0);
    problem.set_values(&(coloured + &half));
    problem.noise = noise;
    problem.whiten_columns();
    solve::round(problem, FixedLaws::Laws);
    half
}
