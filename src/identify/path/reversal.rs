//! The half gap at each reversal: one linear step from the fit, gaps and spikes of every run set free, decays held.
//!
//! What is seen at reversal `i` is a step of `b_(i-1) + b_i`, the gaps of the runs before and after it; half of that is reported.
//! That the steps of a joint are alike is tested by chi-squared.

use super::chain::by_run;
use super::interval::inverse;
use super::nuisance::dot;
use super::problem::{Problem, Values};
use nalgebra::{DMatrix, DVector, Vector3};

/// More columns than this cost more than they tell: a program with hundreds of reversals is judged by its joints.
const MOST: usize = 400;

/// A reversal.
#[derive(Debug, Clone, PartialEq)]
pub struct Reversal {
    /// Joint of the problem, log.
    pub joint: usize,
    /// Number of the log, from 0.
    pub log: usize,
    /// Time of the reversal, s.
    pub t_s: f64,
    /// Turning point, rad or m, and new direction.
    pub at: f64,
    /// Direction after the reversal, -1 or 1.
    pub dir: f64,
    /// Half of the step, rad or m, and its standard error.
    pub half_gap: f64,
    /// Standard deviation of the estimate, rad or m.
    pub sigma: f64,
}

/// Chi-squared of "all steps of a joint are alike" and its degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alike {
    pub joint: usize,
    pub chi2: f64,
    pub dof: f64,
}

/// A column of the step's linear system: the gap of one run of a joint, or its spike.
#[derive(PartialEq)]
struct Column {
    /// Joint of the problem.
    joint: usize,
    run: usize,
    spike: bool,
}

/// The half gaps of a log's runs set free: where the linear step ends, and how sure that is.
struct LinearStep {
    columns: Vec<Column>,
    /// Which columns the log determines at all.
    determined: Vec<bool>,
    step: DVector<f64>,
    covariance: DMatrix<f64>,
}

/// All reversals, or `None` where there are too many. `variance` is that of a unit residual, inflation included.
pub fn reversals(
    problem: &Problem,
    values: &[Values],
    sticky: &[bool],
    variance: f64,
) -> Option<(Vec<Reversal>, Vec<Alike>)> {
    let mut out = Vec::new();
    let mut tests = Vec::new();
    for l in 0..problem.logs().len() {
        let columns = columns(problem, l, values.len(), sticky)?;
        let linear = solve(problem, values, l, columns, variance);
        for g in 0..values.len() {
            let (found, rows) = of_joint(problem, values, l, g, &linear);
            out.extend(found);
            tests.extend(linear.alike(&rows, g));
        }
    }
    Some((out, tests))
}

/// Columns of a log: of every joint the gap of each run, and the spike of each run after a reversal.
fn columns(problem: &Problem, l: usize, joints: usize, sticky: &[bool]) -> Option<Vec<Column>> {
    let log = problem.logs().nth(l)?;
    let mut columns = Vec::new();
    for (joint, &stick) in sticky.iter().enumerate().take(joints) {
        let Some(k) = problem.local(l, joint) else { continue };
        for run in 0..log.joints[k].runs.len() {
            columns.push(Column { joint, run, spike: false });
            if run > 0 && stick {
                columns.push(Column { joint, run, spike: true });
            }
        }
    }
    (columns.len() <= MOST).then_some(columns)
}

/// Weighted derivative of the TCP by each column, at every bin.
fn derivatives(problem: &Problem, values: &[Values], l: usize, columns: &[Column]) -> Vec<Vec<Vector3<f64>>> {
    let roots = problem.roots(l);
    let n = roots.len();
    let mut out = vec![vec![Vector3::zeros(); n]; columns.len()];
    let Some(log) = problem.logs().nth(l) else { return out };
    for (g, v) in values.iter().enumerate() {
        let Some(k) = problem.local(l, g) else { continue };
        let j = &log.joints[k];
        let der = by_run(&j.runs, &log.t_s, &j.p, &problem.law(g, v));
        for (c, column) in columns.iter().enumerate().filter(|(_, c)| c.joint == g) {
            for i in (0..n).filter(|&i| der[i].run == Some(column.run)) {
                out[c][i] = j.jac[i] * (roots[i] * if column.spike { der[i].spike } else { der[i].gap });
            }
        }
    }
    out
}

/// The linear step of a log, its nuisance projected out.
fn solve(problem: &Problem, values: &[Values], l: usize, columns: Vec<Column>, variance: f64) -> LinearStep {
    let by_column = derivatives(problem, values, l, &columns);
    let basis = problem.basis(l);
    let projected: Vec<Vec<f64>> =
        by_column.iter().map(|c| basis.vectors.iter().map(|q| dot(q, c)).collect()).collect();
    let residual = problem.residual(l, values);
    let m = columns.len();
    let mut normal = DMatrix::zeros(m, m);
    let mut rhs = DVector::zeros(m);
    for a in 0..m {
        rhs[a] = dot(&by_column[a], &residual);
        for b in 0..=a {
            let inner: f64 = projected[a].iter().zip(&projected[b]).map(|(x, y)| x * y).sum();
            normal[(a, b)] = dot(&by_column[a], &by_column[b]) - inner;
            normal[(b, a)] = normal[(a, b)];
        }
    }
    let covariance = inverse(&normal);
    LinearStep {
        columns,
        determined: (0..m).map(|a| normal[(a, a)] > 0.0).collect(),
        step: &covariance * rhs,
        covariance: covariance * variance,
    }
}

impl LinearStep {
    /// The column of the gap of a run, where the log determines it: a run may never be pushed, or not be measured.
    fn gap_of(&self, joint: usize, run: usize) -> Option<usize> {
        let column = Column { joint, run, spike: false };
        self.columns.iter().position(|c| *c == column).filter(|&c| self.determined[c])
    }

    /// Change of the half gap between two runs.
    fn change(&self, (a, b): (usize, usize)) -> f64 {
        (self.step[a] + self.step[b]) / 2.0
    }

    /// Are the changes at the reversals `rows` of a joint one common value?
    fn alike(&self, rows: &[(usize, usize)], joint: usize) -> Option<Alike> {
        let cov = &self.covariance;
        let deltas: Vec<f64> = rows.iter().map(|&r| self.change(r)).collect();
        let pick = |i: (usize, usize), j: (usize, usize)| {
            (cov[(i.0, j.0)] + cov[(i.0, j.1)] + cov[(i.1, j.0)] + cov[(i.1, j.1)]) / 4.0
        };
        alike(&deltas, &DMatrix::from_fn(rows.len(), rows.len(), |i, j| pick(rows[i], rows[j])), joint)
    }
}

/// The reversals of joint `g` in log `l`, and the columns before and after each.
fn of_joint(
    problem: &Problem,
    values: &[Values],
    l: usize,
    g: usize,
    linear: &LinearStep,
) -> (Vec<Reversal>, Vec<(usize, usize)>) {
    let (mut found, mut rows) = (Vec::new(), Vec::new());
    let (Some(log), Some(k)) = (problem.logs().nth(l), problem.local(l, g)) else { return (found, rows) };
    let (v, runs, cov) = (&values[g], &log.joints[k].runs, &linear.covariance);
    let law = problem.law(g, v);
    for i in 1..runs.len() {
        let (Some(a), Some(b)) = (linear.gap_of(g, i - 1), linear.gap_of(g, i)) else { continue };
        let before = law.gap.at((runs[i - 1].p + runs[i].p) / 2.0);
        let next = runs.get(i + 1).map_or(runs[i].p, |n| n.p);
        let after = law.gap.at((runs[i].p + next) / 2.0);
        let of_fit = if v.c.len() > 1 || problem.joints[g].held.is_some() {
            law.gap.at(runs[i].p)
        } else {
            (before + after) / 2.0
        };
        rows.push((a, b));
        found.push(Reversal {
            joint: g,
            log: l,
            t_s: runs[i].t_s,
            at: runs[i].p,
            dir: runs[i].dir,
            half_gap: of_fit + linear.change((a, b)),
            sigma: (cov[(a, a)] + cov[(b, b)] + 2.0 * cov[(a, b)]).max(0.0).sqrt() / 2.0,
        });
    }
    (found, rows)
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
