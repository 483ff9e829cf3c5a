//! Levenberg-Marquardt on the projected problem, and the grid from which a stiction starts.
//!
//! Marquardt's scaling of the diagonal; factor 10 up and down from 1e-3; stops when the cost falls by less than 1e-8 of itself
//! or no step helps. Values are kept in bounds by clamping a step: a half gap of 0 or more, a spike from 0 to
//! [`SPIKE_OVER_GAP`] times the gap, a decay between the bin length and half the longest run, a decay step of at most a factor e.

use super::problem::{Form, Name, Problem, Values};
use nalgebra::{DMatrix, DVector};

const SPIKE_OVER_GAP: f64 = 5.0;
/// Gap below which the bound of the spike no longer shrinks, rad or m (0.002 deg, 0.035 mm).
const LEAST_FOR_SPIKE: f64 = 3.5e-5;
/// Gap from which a fit starts where the regression finds none, rad or m (2e-4 deg).
pub const START_GAP: f64 = 3.5e-6;

/// Bounds of the decay, s.
#[derive(Debug, Clone, Copy)]
pub struct TauBounds {
    pub lo_s: f64,
    pub hi_s: f64,
}

impl TauBounds {
    /// From the runs of all logs.
    pub fn of(problem: &Problem) -> Self {
        let mut longest = 0.0f64;
        for log in problem.logs() {
            let end = log.t_s.last().copied().unwrap_or(0.0);
            for j in log.joints.iter().filter(|j| j.reverses()) {
                for (k, r) in j.runs.iter().enumerate() {
                    longest = longest.max(j.runs.get(k + 1).map_or(end, |n| n.t_s) - r.t_s);
                }
            }
        }
        let hi_s = (longest / 2.0).max(1.0);
        Self { lo_s: (1e-4 * hi_s).max(0.02), hi_s }
    }
}

/// Minimises from `values`; returns the values and their cost.
pub fn minimise(
    problem: &Problem,
    start: &[Values],
    form: &Form,
    bounds: TauBounds,
    steps: usize,
) -> (Vec<Values>, f64) {
    let names = problem.names(start, form);
    let mut values = start.to_vec();
    for (v, sticky) in values.iter_mut().zip(&form.sticky) {
        if !sticky {
            v.spike = 0.0;
        }
    }
    if names.is_empty() {
        let cost = problem.cost(&values);
        return (values, cost);
    }
    let mut normal = problem.normal(&values, form);
    let mut lambda = 1e-3;
    for _ in 0..steps {
        let Some(step) = damped(&normal.matrix, &normal.gradient, lambda) else { break };
        let trial = moved(problem, &values, &names, &step, form, bounds);
        let cost = problem.cost(&trial);
        if cost < normal.cost {
            let done = normal.cost - cost < 1e-8 * normal.cost;
            values = trial;
            if done {
                normal.cost = cost;
                break;
            }
            normal = problem.normal(&values, form);
            lambda = (lambda / 10.0f64).max(1e-9);
        } else {
            lambda *= 10.0;
            if lambda > 1e6 {
                break;
            }
        }
    }
    (values, normal.cost)
}

/// `(H + lambda diag H) step = g`.
fn damped(h: &DMatrix<f64>, g: &DVector<f64>, lambda: f64) -> Option<DVector<f64>> {
    let largest = h.diagonal().max();
    let mut a = h.clone();
    for k in 0..a.nrows() {
        a[(k, k)] += lambda * h[(k, k)].max(1e-12 * largest) + f64::MIN_POSITIVE;
    }
    // unit diagonal: gaps are rad, decays are logarithms
    let s: Vec<f64> = (0..a.nrows()).map(|k| 1.0 / a[(k, k)].sqrt()).collect();
    let scaled = DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * s[i] * s[j]);
    let rhs = DVector::from_fn(g.len(), |i, _| g[i] * s[i]);
    let x = scaled.cholesky()?.solve(&rhs);
    x.iter().all(|v| v.is_finite()).then(|| DVector::from_fn(x.len(), |i, _| x[i] * s[i]))
}

/// `values` moved by a step and clamped.
fn moved(
    problem: &Problem,
    values: &[Values],
    names: &[Name],
    step: &DVector<f64>,
    form: &Form,
    bounds: TauBounds,
) -> Vec<Values> {
    let mut out = values.to_vec();
    let tau = |now: f64, by: f64| (now.ln() + by.clamp(-1.0, 1.0)).exp().clamp(bounds.lo_s, bounds.hi_s);
    for (name, &by) in names.iter().zip(step.iter()) {
        match *name {
            Name::Gap { joint, power } => {
                out[joint].c[power] += by;
                if power == 0 {
                    out[joint].c[0] = out[joint].c[0].max(0.0);
                }
            }
            Name::Spike { joint } => {
                let gap = mean_gap(problem, joint, &values[joint]);
                let most = SPIKE_OVER_GAP * gap.max(LEAST_FOR_SPIKE);
                out[joint].spike = (out[joint].spike + by).clamp(0.0, most);
            }
            Name::LnTau { joint } => out[joint].tau_s = tau(out[joint].tau_s, by),
            Name::SharedLnTau => {
                for (v, _) in out.iter_mut().zip(&form.sticky).filter(|(_, s)| **s) {
                    v.tau_s = tau(v.tau_s, by);
                }
            }
        }
    }
    out
}

/// Half gap of a joint in the middle of its travel; of a held one, the mean of nine places.
pub fn mean_gap(problem: &Problem, joint: usize, v: &Values) -> f64 {
    let j = &problem.joints[joint];
    match &j.held {
        None => v.c[0],
        Some(curve) => (-4..=4).map(|k| curve.at(j.center + j.half * f64::from(k) / 4.0)).sum::<f64>() / 9.0,
    }
}

/// Gaps from a linear regression on the direction of each joint.
pub fn start(problem: &Problem, bounds: TauBounds) -> Vec<Values> {
    let blank = Values { c: vec![START_GAP], spike: 0.0, tau_s: (bounds.lo_s * bounds.hi_s).sqrt() };
    let mut values = vec![blank; problem.joints.len()];
    let fitted: Vec<usize> = (0..values.len()).filter(|&g| problem.joints[g].held.is_none()).collect();
    let found = problem.regress_direction(&fitted);
    for (&g, b) in fitted.iter().zip(found) {
        values[g].c[0] = b.max(START_GAP);
    }
    values
}

/// Best spike and decay of joint `g` on a grid, the other joints held.
pub fn grid(problem: &Problem, values: &[Values], g: usize, bounds: TauBounds) -> Values {
    let gap = mean_gap(problem, g, &values[g]).max(START_GAP);
    let (lo, hi) = ((2.0 * bounds.lo_s).max(0.3), bounds.hi_s / 2.0);
    let mut trials = Vec::new();
    for k in 0..7 {
        let tau_s = (lo * (hi / lo).powf(f64::from(k) / 6.0)).clamp(bounds.lo_s, bounds.hi_s);
        trials.extend([0.25, 0.5, 1.0, 2.0].map(|f| Values { spike: f * gap, tau_s, ..values[g].clone() }));
    }
    let costs = problem.cost_of_trials(values, g, &trials);
    let best = costs.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |b| b.0);
    trials.swap_remove(best)
}
