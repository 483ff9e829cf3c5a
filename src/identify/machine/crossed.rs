//! Is a correction that one half of a joint's strokes asks for a correction of the other half, too?
//!
//! The problem is nearly linear about the values of a compensator, so each half gives normal equations, a step, and what the other
//! half's step does to its cost.

use super::law::turns;
use super::problem::{Part, Problem};
use nalgebra::{DMatrix, DVector};

/// Strokes of a joint from which one half of them can judge the other.
const LEAST_STROKES: usize = 4;

/// Normal equations of the laws alone, nuisances eliminated.
struct Reduced {
    hessian: DMatrix<f64>,
    gradient: DVector<f64>,
}

impl Reduced {
    /// Of all parameters' normal equations, the priors among them.
    fn of(hessian: &DMatrix<f64>, gradient: &DVector<f64>, lost: usize) -> Option<Self> {
        let rest = hessian.nrows() - lost;
        let nuisance = nalgebra::Cholesky::new(hessian.view((lost, lost), (rest, rest)).into_owned())?;
        let mixed = hessian.view((lost, 0), (rest, lost)).into_owned();
        let own = hessian.view((0, 0), (lost, lost)) - mixed.transpose() * nuisance.solve(&mixed);
        let gradient =
            gradient.rows(0, lost) - mixed.transpose() * nuisance.solve(&gradient.rows(lost, rest).into_owned());
        Some(Self { hessian: own, gradient })
    }

    /// Fall of the cost by a step of some parameters.
    fn fall(&self, at: usize, step: &DVector<f64>) -> f64 {
        let n = step.len();
        2.0 * step.dot(&self.gradient.rows(at, n)) - step.dot(&(self.hessian.view((at, at), (n, n)) * step))
    }
}

/// Fall of the cost that corrections of a joint found on one half of its strokes bring on the other half, both ways together; nuisances
/// are eliminated on each half. `None`: too few strokes.
///
/// Every reversal draws its gap anew, so a half holds whole strokes of the joint, two in a row: one up and one down.
pub fn crossed(problem: &Problem, parts: &[Part], axis: usize) -> Option<f64> {
    let (lost, n) = (problem.lost(), problem.len());
    let (at, len) = (problem.offset(axis), problem.laws[axis].as_ref()?.parameters());
    let prior = problem.prior().0;
    let mut strokes = 0;
    let logs: Vec<[(DMatrix<f64>, DVector<f64>); 2]> =
        parts.iter().enumerate().map(|(l, p)| halves(problem, l, p, axis, &mut strokes)).collect();
    if strokes < LEAST_STROKES {
        return None;
    }
    let (mut steps, mut judges) = (Vec::new(), Vec::new());
    for half in 0..2 {
        let (mut h, mut g) = (prior.clone(), DVector::zeros(n));
        for log in &logs {
            h += &log[half].0;
            g += &log[half].1;
        }
        let all = Reduced::of(&h, &g, lost)?;
        let step = nalgebra::Cholesky::new(all.hessian.clone())?.solve(&all.gradient);
        steps.push(step.rows(at, len).into_owned());
        // the other half is judged without the prior
        judges.push(Reduced { hessian: all.hessian - prior.view((0, 0), (lost, lost)), gradient: all.gradient });
    }
    Some(judges[1].fall(at, &steps[0]) + judges[0].fall(at, &steps[1]))
}

/// Normal equations of a run over all parameters, by pairs of successive strokes of a joint; `strokes` counts on over the runs.
fn halves(
    problem: &Problem,
    log: usize,
    part: &Part,
    axis: usize,
    strokes: &mut usize,
) -> [(DMatrix<f64>, DVector<f64>); 2] {
    let (n, l) = (problem.len(), &problem.logs[log]);
    let mut out = [(DMatrix::zeros(n, n), DVector::zeros(n)), (DMatrix::zeros(n, n), DVector::zeros(n))];
    let bins = l.len();
    let rows = l.moving.iter().find(|m| m.0 == axis).map(|m| &m.1);
    let mut edges: Vec<usize> = match rows {
        Some(rows) => {
            let bin_of = |row: usize| l.bins.partition_point(|b| b.1 <= row).min(bins);
            turns(&rows.x).into_iter().map(bin_of).collect()
        }
        // a log in which the joint is stationary determines the others alone
        None => Vec::new(),
    };
    edges.push(bins);
    let mut from = 0;
    for to in edges {
        if to <= from {
            continue;
        }
        let (h, g) = &mut out[(*strokes / 2) % 2];
        *strokes += usize::from(rows.is_some());
        let k = part.index.len();
        let (mut hessian, mut gradient) = (DMatrix::zeros(k, k), DVector::zeros(k));
        for c in 0..3 {
            let design = part.design.rows(c * bins + from, to - from).into_owned();
            hessian += design.transpose() * &design;
            gradient += design.transpose() * part.residual.rows(c * bins + from, to - from);
        }
        for (i, &gi) in part.index.iter().enumerate() {
            g[gi] += gradient[i];
            for (k, &gk) in part.index.iter().enumerate() {
                h[(gi, gk)] += hessian[(i, k)];
            }
        }
        from = to;
    }
    out
}
