//! The half gap at each reversal: one linear step from the fit, gaps and spikes of every run set free, decays held.
//!
//! What is seen at reversal `i` is a step of `b_(i-1) + b_i`, the gaps of the runs before and behind it; half of that is reported.
//! That the steps of a joint are alike is tested by chi-squared.

use super::chain::by_run;
use super::interval::inverse;
use super::problem::{Problem, Values};
use nalgebra::{DMatrix, DVector, Vector3};

/// More columns than this cost more than they tell: a program with hundreds of reversals is judged by its joints.
const MOST: usize = 400;

/// A reversal.
#[derive(Debug, Clone, PartialEq)]
pub struct Reversal {
    /// Joint of the problem, log.
    pub joint: usize,
    pub log: usize,
    pub t_s: f64,
    /// Turning point, rad or m, and new direction.
    pub at: f64,
    pub dir: f64,
    /// Half of the step, rad or m, and its standard error.
    pub half_gap: f64,
    pub sigma: f64,
}

/// Chi-squared of "all steps of a joint are alike" and its degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alike {
    pub joint: usize,
    pub chi2: f64,
    pub dof: f64,
}

/// All reversals, or `None` where there are too many. `variance` is that of a unit residual, inflation included.
pub fn reversals(
    problem: &Problem,
    values: &[Values],
    sticky: &[bool],
    variance: f64,
) -> Option<(Vec<Reversal>, Vec<Alike>)> {
    let mut out = Vec::new();
    let mut groups: Vec<(Vec<f64>, DMatrix<f64>, usize)> = Vec::new();
    for l in 0..problem.logs().len() {
        let log = problem.logs().nth(l)?;
        // column of (joint, run): gap, then spike
        let mut columns: Vec<(usize, usize, bool)> = Vec::new();
        for (g, &stick) in sticky.iter().enumerate() {
            if let Some(k) = problem.local(l, g) {
                for r in 0..log.joints[k].runs.len() {
                    columns.push((g, r, false));
                    if r > 0 && stick {
                        columns.push((g, r, true));
                    }
                }
            }
        }
        if columns.len() > MOST {
            return None;
        }
        let roots = problem.roots(l);
        let n = roots.len();
        let mut g_raw = vec![vec![Vector3::zeros(); n]; columns.len()];
        for (g, v) in values.iter().enumerate() {
            let Some(k) = problem.local(l, g) else { continue };
            let j = &log.joints[k];
            let der = by_run(&j.runs, &log.t_s, &j.p, &problem.law(g, v));
            for (c, &(_, run, spike)) in columns.iter().enumerate().filter(|(_, c)| c.0 == g) {
                for i in 0..n {
                    if der[i].run == Some(run) {
                        g_raw[c][i] = j.jac[i] * (roots[i] * if spike { der[i].spike } else { der[i].gap });
                    }
                }
            }
        }
        let basis = problem.basis(l);
        let project: Vec<Vec<f64>> =
            g_raw.iter().map(|c| basis.vectors.iter().map(|q| super::nuisance::dot(q, c)).collect()).collect();
        let r = problem.residual(l, values);
        let m = columns.len();
        let mut h = DMatrix::zeros(m, m);
        let mut rhs = DVector::zeros(m);
        for a in 0..m {
            rhs[a] = super::nuisance::dot(&g_raw[a], &r);
            for b in 0..=a {
                let inner: f64 = project[a].iter().zip(&project[b]).map(|(x, y)| x * y).sum();
                h[(a, b)] = super::nuisance::dot(&g_raw[a], &g_raw[b]) - inner;
                h[(b, a)] = h[(a, b)];
            }
        }
        let cov = inverse(&h);
        let step = &cov * rhs;
        let cov = cov * variance;
        for (g, v) in values.iter().enumerate() {
            let Some(k) = problem.local(l, g) else { continue };
            let runs = &log.joints[k].runs;
            let at = |run: usize| columns.iter().position(|c| *c == (g, run, false));
            let mut rows = Vec::new();
            for i in 1..runs.len() {
                let (Some(a), Some(b)) = (at(i - 1), at(i)) else { continue };
                if h[(a, a)] <= 0.0 || h[(b, b)] <= 0.0 {
                    continue; // a run that is never pushed, or was not measured
                }
                let law = problem.law(g, v);
                let before = law.gap.at((runs[i - 1].p + runs[i].p) / 2.0);
                let next = runs.get(i + 1).map_or(runs[i].p, |n| n.p);
                let behind = law.gap.at((runs[i].p + next) / 2.0);
                let base = if v.c.len() > 1 || problem.joints[g].held.is_some() {
                    law.gap.at(runs[i].p)
                } else {
                    (before + behind) / 2.0
                };
                let sigma = (cov[(a, a)] + cov[(b, b)] + 2.0 * cov[(a, b)]).max(0.0).sqrt() / 2.0;
                rows.push((a, b));
                out.push(Reversal {
                    joint: g,
                    log: l,
                    t_s: runs[i].t_s,
                    at: runs[i].p,
                    dir: runs[i].dir,
                    half_gap: base + (step[a] + step[b]) / 2.0,
                    sigma,
                });
            }
            let deltas = rows.iter().map(|(a, b)| (step[*a] + step[*b]) / 2.0).collect();
            let pick = |i: (usize, usize), j: (usize, usize)| {
                (cov[(i.0, j.0)] + cov[(i.0, j.1)] + cov[(i.1, j.0)] + cov[(i.1, j.1)]) / 4.0
            };
            let c = DMatrix::from_fn(rows.len(), rows.len(), |i, j| pick(rows[i], rows[j]));
            groups.push((deltas, c, g));
        }
    }
    Some((out, groups.into_iter().filter_map(|(d, c, joint)| alike(&d, &c, joint)).collect()))
}

/// Generalised least squares of one common value.
fn alike(deltas: &[f64], cov: &DMatrix<f64>, joint: usize) -> Option<Alike> {
    if deltas.len() < 2 {
        return None;
    }
    let w = inverse(cov);
    let d = DVector::from_column_slice(deltas);
    let one = DVector::from_element(deltas.len(), 1.0);
    let mean = (one.transpose() * &w * &d)[0] / (one.transpose() * &w * &one)[0];
    let x = d.add_scalar(-mean);
    Some(Alike { joint, chi2: (x.transpose() * w * &x)[0], dof: (deltas.len() - 1) as f64 })
}
