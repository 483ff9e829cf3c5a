//! Joint error traces for reports: measured and fitted error of each free joint over time.
//!
//! The measured error is the fitted one plus what the inverse of the Jacobian of the free joints makes of the remaining
//! deviation, damped so that a direction which the joints cannot reach does not blow up. Neighbouring bins are averaged
//! where a trace would have more than [`MOST`] points.

use super::problem::{Problem, Values};
use nalgebra::{DMatrix, DVector};

const MOST: usize = 4000;
/// Singular values below this share of the largest are damped.
const DAMP: f64 = 0.02;

/// Error of one joint in one log: SI.
#[derive(Debug, Clone)]
pub struct Trace {
    /// Number of the axis, from 0.
    pub axis: usize,
    /// Number of the log, from 0.
    pub log: usize,
    /// Times, s.
    pub t_s: Vec<f64>,
    /// Command of the axis, rad or m.
    pub command: Vec<f64>,
    /// Measured error of the axis, rad or m.
    pub error: Vec<f64>,
    /// The same by the fitted values, rad or m.
    pub fitted: Vec<f64>,
    /// Times of the reversals, s.
    pub reversals_s: Vec<f64>,
}

/// Traces of all joints that reverse.
pub fn traces(problem: &Problem, values: &[Values]) -> Vec<Trace> {
    let mut out = Vec::new();
    for (l, log) in problem.logs().enumerate() {
        let pairs: Vec<(usize, usize)> =
            (0..values.len()).filter_map(|g| problem.local(l, g).map(|k| (g, k))).collect();
        if pairs.is_empty() {
            continue;
        }
        let rest = problem.residual(l, values);
        let roots = problem.roots(l);
        let n = log.t_s.len();
        let fitted: Vec<Vec<f64>> = pairs.iter().map(|(g, _)| problem.error(l, *g, &values[*g])).collect();
        let mut measured = fitted.clone();
        for i in 0..n {
            if roots[i] <= 0.0 {
                continue;
            }
            let j = DMatrix::from_fn(3, pairs.len(), |r, c| log.joints[pairs[c].1].jac[i][r]);
            let r = DVector::from_column_slice((rest[i] / roots[i]).as_slice());
            let gram = &j * j.transpose();
            let damped = &gram + DMatrix::identity(3, 3) * (DAMP * DAMP * gram.trace());
            if let Some(factor) = damped.cholesky() {
                let step = j.transpose() * factor.solve(&r);
                measured.iter_mut().zip(step.iter()).for_each(|(m, s)| m[i] += s);
            }
        }
        let kept: Vec<usize> = (0..n).filter(|&i| roots[i] > 0.0).collect();
        let group = kept.len().div_ceil(MOST).max(1);
        for (c, (_, k)) in pairs.iter().enumerate() {
            let j = &log.joints[*k];
            let mean = |v: &[f64]| -> Vec<f64> {
                let one = |g: &[usize]| {
                    let w: f64 = g.iter().map(|&i| log.rows[i]).sum();
                    g.iter().map(|&i| v[i] * log.rows[i]).sum::<f64>() / w
                };
                kept.chunks(group).map(one).collect()
            };
            out.push(Trace {
                axis: j.axis,
                log: l,
                t_s: mean(&log.t_s),
                command: mean(&j.p),
                error: mean(&measured[c]),
                fitted: mean(&fitted[c]),
                reversals_s: j.runs.iter().skip(1).map(|r| r.t_s).collect(),
            });
        }
    }
    out
}
