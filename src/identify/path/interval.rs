//! How well the fitted numbers are known.
//!
//! Covariance `sigma^2 inflation (G^T G)^-1` with the projected derivatives `G`. Residuals of neighbouring bins may are correlated
//! (vibration, drift, a wrong model): the variance is inflated by `1 + 2 sum rho_k`, the autocorrelation summed in pairs until
//! a pair is no longer significant (Geyer 1992). Gaps have intervals in their own scale; spikes and decays, which cannot
//! be negative and trade off against each other, in the logarithm.
//!
//! Spike and decay of a slow joint are nearly one number: what a log fixes well is the lag at some time `t*` after the reversal,
//! `t* = -tau cov(ln spike, ln tau)/var(ln tau)`.

use super::problem::{Form, Name, Problem, Values};
use crate::numerics::normal_equations::pseudo_inverse;
use nalgebra::DMatrix;

/// Eigenvalue of the scaled matrix up to which a direction has no information.
const OPEN: f64 = 1e-10;
const LAGS: usize = 20;

/// Inflation of the variance by correlated residuals, 1 or more.
pub fn inflation(problem: &Problem, values: &[Values]) -> f64 {
    let mut rho = [0.0; LAGS];
    let (mut total, mut n) = (0.0, 0usize);
    for l in 0..problem.logs().len() {
        let roots = problem.roots(l);
        let r: Vec<_> =
            problem.residual(l, values).into_iter().zip(roots).filter(|(_, w)| **w > 0.0).map(|(r, _)| r).collect();
        if r.len() <= 3 * LAGS {
            continue;
        }
        n += r.len();
        total += r.iter().map(|v| v.norm_squared()).sum::<f64>();
        for (k, rho) in rho.iter_mut().enumerate() {
            *rho += r[k + 1..].iter().zip(&r).map(|(a, b)| a.dot(b)).sum::<f64>();
        }
    }
    if n == 0 || total <= 0.0 {
        return 1.0;
    }
    let noise = 2.0 * (2.0 / (3.0 * n as f64)).sqrt();
    let mut sum = 1.0;
    for pair in rho.chunks_exact(2) {
        let g = (pair[0] + pair[1]) / total;
        if g < noise {
            break;
        }
        sum += 2.0 * g;
    }
    sum.max(1.0)
}

/// Inverse of a positive semidefinite matrix; directions without information get none of it.
pub fn inverse(h: &DMatrix<f64>) -> DMatrix<f64> {
    pseudo_inverse(h, OPEN)
}

/// Covariance of the fitted numbers and their names; `variance` is that of a unit residual, inflation included.
pub struct Covariance {
    pub names: Vec<Name>,
    pub matrix: DMatrix<f64>,
}

impl Covariance {
    pub fn new(problem: &Problem, values: &[Values], form: &Form, variance: f64) -> Self {
        let normal = problem.normal(values, form);
        Self { names: problem.names(values, form), matrix: inverse(&normal.matrix) * variance }
    }

    pub fn place(&self, name: Name) -> Option<usize> {
        self.names.iter().position(|n| *n == name)
    }

    /// Place of the decay of a joint.
    pub fn tau(&self, joint: usize) -> Option<usize> {
        self.place(Name::LnTau { joint }).or_else(|| self.place(Name::SharedLnTau))
    }

    /// Standard error of a linear combination.
    pub fn sigma(&self, weights: &[(usize, f64)]) -> f64 {
        let mut v = 0.0;
        for (i, a) in weights {
            for (j, b) in weights {
                v += a * b * self.matrix[(*i, *j)];
            }
        }
        v.max(0.0).sqrt()
    }
}

/// A stiction with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StictionInterval {
    pub spike_ci95: [f64; 2],
    pub tau_ci95_s: [f64; 2],
    /// Standard error of the spike over the spike.
    pub relative: f64,
    /// Time after a reversal at which the lag is known best, s; the lag there and its interval, rad or m.
    pub best_s: f64,
    pub lag: f64,
    pub lag_ci95: [f64; 2],
}

/// Intervals of the stiction of a joint.
pub fn stiction(cov: &Covariance, joint: usize, v: &Values, t95: f64) -> Option<StictionInterval> {
    let (s, t) = (cov.place(Name::Spike { joint })?, cov.tau(joint)?);
    // in logarithms: d ln spike = d spike / spike
    let ln_spike = (s, 1.0 / v.spike);
    let relative = cov.sigma(&[ln_spike]);
    let var_tau = cov.matrix[(t, t)];
    let cross = cov.matrix[(s, t)] / v.spike;
    let best_s = if var_tau > 0.0 { (-v.tau_s * cross / var_tau).max(0.0) } else { 0.0 };
    let lag = v.spike * (-best_s / v.tau_s).exp();
    let lag_sigma = cov.sigma(&[ln_spike, (t, best_s / v.tau_s)]);
    let around = |x: f64, sigma: f64| [x * (-t95 * sigma).exp(), x * (t95 * sigma).exp()];
    Some(StictionInterval {
        spike_ci95: around(v.spike, relative),
        tau_ci95_s: around(v.tau_s, var_tau.max(0.0).sqrt()),
        relative,
        best_s,
        lag,
        lag_ci95: around(lag, lag_sigma),
    })
}
