//! Uncertainties where the model is not the whole truth: the scatter between parts of the logs beside what the noise says.
//!
//! Method: every log is cut into consecutive parts, longer than the noise is correlated. At the fit the scores of the parts (whitened
//! sensitivities times whitened residual) add up to zero; how far they scatter says how far the values would be from one
//! recording to the next (White's sandwich, with clusters). Under the right model it is what the noise says; a misfit that
//! correlated noise swallows makes it larger. Of several logs each is one cluster more: their values differ from run to run.
//!
//! Assumptions: parts err apart from each other. Fewer than [`LEAST_PARTS`] say nothing, and nothing is made smaller.

use crate::diagnose::candidates::sensitivities::{Column, Sensitivities};
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::problem::layout::Group;
use crate::diagnose::problem::normal::dot;
use crate::diagnose::search::fit::Fit;
use crate::numerics::normal::Z95;
use crate::numerics::parallel::ParMap;
use crate::numerics::{chi_squared, student};
use nalgebra::{DMatrix, DVector};

/// Parts of every log at most, and at least.
const PARTS: usize = 24;
const LEAST_PARTS: usize = 8;
/// A part is at least this many times as long as the noise is correlated.
const LONGER: f64 = 5.0;
/// Chance below which a scatter is no longer that of the noise.
const CHANCE: f64 = 0.01;

/// Parts into which the observations of a group are cut.
fn parts_of(group: &Group, phi: f64) -> usize {
    let longest = LONGER / (1.0 - phi).max(1e-3);
    ((group.len() as f64 / longest) as usize).clamp(LEAST_PARTS, PARTS)
}

/// Score of every column over one part of a group.
fn score(columns: &[&Column], white: &[f64], group: &Group, (from, to): (usize, usize)) -> DVector<f64> {
    let n = group.len();
    let one = |c: &Column| -> f64 {
        (0..group.dims)
            .map(|d| {
                let range = group.offset + d * n + from..group.offset + d * n + to;
                dot(&c[range.clone()], &white[range])
            })
            .sum()
    };
    DVector::from_iterator(columns.len(), columns.iter().map(|c| one(c)))
}

/// Scores of the parts, with the log of each.
fn scores(problem: &Problem, fit: &Fit, s: &Sensitivities, whitening: &Whitening) -> Vec<(usize, DVector<f64>)> {
    let white = whitening.of(problem, &fit.state.residual);
    let columns: Vec<&Column> = s.columns().collect();
    let cuts: Vec<(&Group, usize, usize)> = problem
        .groups
        .iter()
        .zip(&whitening.noise)
        .flat_map(|(g, noise)| {
            let (n, parts) = (g.len(), parts_of(g, noise.phi));
            (0..parts).map(move |k| (g, k * n / parts, (k + 1) * n / parts))
        })
        .collect();
    cuts.par_map(|&(g, from, to)| (g.log, score(&columns, &white, g, (from, to))))
}

/// Variance of each value by the scatter of clusters, and how many clusters tell of it.
fn scattered(fit: &Fit, clusters: &[DVector<f64>]) -> Vec<(f64, usize)> {
    let k = fit.parameters();
    let sum = clusters.iter().fold(DMatrix::zeros(k, k), |a, s| a + s * s.transpose());
    let sandwich = &fit.covariance * sum * &fit.covariance;
    let told = |i: usize| clusters.iter().filter(|s| s[i] != 0.0).count();
    (0..k).map(|i| (sandwich[(i, i)].max(0.0), told(i))).collect()
}

/// Variance of each value of a fit by the scatter between parts of the logs, as wide as their number demands.
pub fn variances(problem: &Problem, fit: &Fit, s: &Sensitivities, whitening: &Whitening) -> Vec<f64> {
    let parts: Vec<DVector<f64>> = scores(problem, fit, s, whitening).into_iter().map(|p| p.1).collect();
    scattered(fit, &parts).into_iter().map(wide).collect()
}

/// The scatter of clusters as wide as their number demands.
fn wide((scatter, clusters): (f64, usize)) -> f64 {
    if clusters < 2 {
        return 0.0;
    }
    let free = (clusters - 1) as f64;
    // of two or three runs the quantile would be that of a guess
    let wider = if clusters < LEAST_PARTS { 1.0 } else { (student::factor(0.95, free) / Z95).powi(2) };
    scatter * clusters as f64 / free * wider
}

/// A variance under misfit: that of the noise where the scatter may be chance; else the scatter, as wide as the few clusters
/// that tell of it demand.
fn honest(noise: f64, (scatter, clusters): (f64, usize)) -> f64 {
    if clusters < 2 || noise <= 0.0 {
        return noise;
    }
    let free = (clusters - 1) as f64;
    let widened = wide((scatter, clusters));
    let scatter = scatter * clusters as f64 / free;
    let chance = chi_squared::tail(free * scatter / noise, free);
    if chance > CHANCE || scatter <= noise {
        return noise;
    }
    widened
}

/// Widens the covariance of a fit where the parts of the logs, or the logs, scatter more than its noise says; correlations stay.
pub fn widen(problem: &Problem, fit: &mut Fit, whitening: &Whitening) {
    if fit.parameters() == 0 {
        return;
    }
    let s = Sensitivities::new(problem, &fit.hypothesis, &fit.state, &fit.free, whitening);
    let parts = scores(problem, fit, &s, whitening);
    let mut runs = vec![DVector::zeros(fit.parameters()); problem.logs.len()];
    for (log, score) in &parts {
        runs[*log] += score;
    }
    let parts: Vec<DVector<f64>> = parts.into_iter().map(|p| p.1).collect();
    let (by_part, by_run) = (scattered(fit, &parts), scattered(fit, &runs));
    let factor: Vec<f64> = (0..fit.parameters())
        .map(|i| {
            let noise = fit.covariance[(i, i)];
            let wide = honest(noise, by_part[i]).max(honest(noise, by_run[i]));
            if noise > 0.0 { (wide / noise).sqrt() } else { 1.0 }
        })
        .collect();
    let k = fit.parameters();
    fit.covariance = DMatrix::from_fn(k, k, |i, j| fit.covariance[(i, j)] * factor[i] * factor[j]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scatter_that_may_be_chance_changes_nothing_and_a_misfit_widens() {
        // of 24 parts the scatter of a right model is below 1.8 times the noise in 99 of 100
        assert_eq!(honest(4.0, (4.0 * 1.3, 24)), 4.0);
        assert_eq!(honest(4.0, (1.0, 24)), 4.0);
        let wide = honest(4.0, (40.0, 24));
        // 24/23 for the mean, and (2.069 / 1.960)^2 for the quantile of Student's t with 23 degrees of freedom
        assert!((wide - 40.0 * 24.0 / 23.0 * (2.0687f64 / 1.95996).powi(2)).abs() < 1e-2, "{wide}");
        // two runs that differ by d know their mean to d / 2: scatter d^2 / 8 before the factor of two runs
        assert!((honest(0.01, (1.0 / 8.0, 2)) - 0.25).abs() < 1e-12);
        assert_eq!(honest(4.0, (40.0, 1)), 4.0);
    }
}
