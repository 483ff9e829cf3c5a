//! The noise of all groups of observations, and the filters that whiten the long vector by it.

use crate::diagnose::noise::{self, Noise, Whitener};
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::problem::layout::{Group, Sensor};
use crate::numerics::parallel::ParMap;

/// Least noise of an encoder, rad or m: between its rows a model of the servo is no better.
const LEAST_MOTOR_SIGMA: f64 = 1e-6;

/// Filters of all groups.
#[derive(Debug, Clone)]
pub struct Whitening {
    pub noise: Vec<Noise>,
    filters: Vec<Whitener>,
}

impl Whitening {
    pub fn new(problem: &Problem, noise: Vec<Noise>) -> Self {
        let filters = problem.groups.iter().zip(&noise).map(|(g, n)| Whitener::new(g, n)).collect();
        Self { noise, filters }
    }

    /// White noise as large as a residual.
    pub fn white(problem: &Problem, residual: &[f64]) -> Self {
        let of = |g: &Group| {
            let v = &residual[g.range()];
            let rms = (v.iter().map(|x| x * x).sum::<f64>() / v.len() as f64).sqrt();
            Noise::white(rms.max(noise::least_sigma(g)))
        };
        Self::new(problem, problem.groups.iter().map(of).collect())
    }

    /// Noise of the largest likelihood for a residual from which `fitted` parameters were taken; with 2 ln L.
    pub fn of_residual(problem: &Problem, residual: &[f64], fitted: usize) -> (Self, f64) {
        Self::estimated(problem, residual, fitted, noise::SLOWEST)
    }

    /// The same where slow wander of arm and air counts as noise.
    pub fn with_wander(problem: &Problem, residual: &[f64], fitted: usize) -> Self {
        Self::estimated(problem, residual, fitted, noise::WANDER).0
    }

    fn estimated(problem: &Problem, residual: &[f64], fitted: usize, slowest: f64) -> (Self, f64) {
        let share = fitted as f64 / problem.n.max(1) as f64;
        let found: Vec<(Noise, f64)> = problem.groups.par_map(|g| {
            let (mut noise, mut two_ln_l) =
                noise::estimate(g, &residual[g.range()], share * g.range().len() as f64, slowest);
            // reflectors of one pose err together
            let together = inflation(problem, g.log, residual);
            noise.sigma *= together.sqrt();
            two_ln_l /= together;
            if matches!(g.sensor, Sensor::Motor(_)) {
                noise.sigma = noise.sigma.max(LEAST_MOTOR_SIGMA);
            }
            (noise, two_ln_l)
        });
        let two_ln_l = found.iter().map(|f| f.1).sum();
        (Self::new(problem, found.into_iter().map(|f| f.0).collect()), two_ln_l)
    }

    /// Whitens a long vector in place.
    pub fn apply(&self, problem: &Problem, values: &mut [f64]) {
        for (g, f) in problem.groups.iter().zip(&self.filters) {
            f.apply(&mut values[g.range()]);
        }
    }

    /// A whitened copy.
    pub fn of(&self, problem: &Problem, values: &[f64]) -> Vec<f64> {
        let mut v = values.to_vec();
        self.apply(problem, &mut v);
        v
    }

    /// Takes the whitening back, in place.
    pub fn undo(&self, problem: &Problem, values: &mut [f64]) {
        for (g, f) in problem.groups.iter().zip(&self.filters) {
            f.undo(&mut values[g.range()]);
        }
    }

    /// Adjoint of [`Self::apply`], in place.
    pub fn adjoint(&self, problem: &Problem, values: &mut [f64]) {
        for (g, f) in problem.groups.iter().zip(&self.filters) {
            f.adjoint(&mut values[g.range()]);
        }
    }
}

/// Correlation of the residuals of the reflectors of one pose makes them count for less: the factor of their variance.
pub(in crate::diagnose) fn inflation(problem: &Problem, log: usize, residual: &[f64]) -> f64 {
    let groups: Vec<_> = problem.groups_of(log).filter(|g| matches!(g.sensor, Sensor::Reflector(_))).collect();
    if groups.len() < 2 || !problem.logs[log].log.poses {
        return 1.0;
    }
    let rows = problem.logs[log].log.len();
    let mut sums = vec![[0.0_f64; 3]; rows];
    let mut squares = 0.0;
    for g in &groups {
        let (n, v) = (g.len(), &residual[g.range()]);
        for b in 0..n {
            for (c, s) in sums[g.middle(b)].iter_mut().enumerate() {
                *s += v[c * n + b];
                squares += v[c * n + b].powi(2);
            }
        }
    }
    let together: f64 = sums.iter().flatten().map(|s| s * s).sum();
    if squares > 0.0 { (together / squares).clamp(1.0, groups.len() as f64) } else { 1.0 }
}
