//! What the residuals support: covariance, single reversals, what is left on parts of the logs that were not fitted.
//!
//! Covariance: `H^-1 (M + P) H^-1` (sandwich; White 1980, with sums over blocks of some seconds as Newey and West 1987), `M`
//! the scatter of the blocks' scores and `P` the precision of the priors; never less than `H^-1`. The same with the scores of whole
//! logs (clusters; Liang and Zeger 1986) shows where logs contradict each other because friction is of another form than the
//! model's; the larger counts.
//!
//! The prior of a wind-up is far narrower than what wind-ups are: it says that lost motion is a gap where the logs do not tell. That
//! makes a good estimate of their sum, and would make intervals of the gap that are too narrow, so intervals count the wind-up as any
//! share of gap and wind-up together ([`Problem::open_wind_up`]).
//!
//! Held-out estimates: the problem is nearly linear at its minimum, so leaving stretches of a log out ([`folds`]) moves the estimate by
//! `-(H - H_b)^-1 g_b`. Each reversal's remainder is then estimated in its window by generalized least squares with three
//! shapes: a step that stays, and two that decay. Reference: Belsley, Kuh and Welsch (1980), chapter 2.

use super::bins::BinnedLog;
use super::folds::folds;
use super::law::turns;
use super::noise::MOST_LAGS;
use super::problem::{Part, Problem};
use super::solve;
use crate::numerics::normal::Z95;
use crate::numerics::normal_equations::scaled_inverse;
use crate::numerics::parallel::ParMap;
use crate::numerics::student;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use std::ops::Range;

/// Length of the blocks whose scores count as one, bins.
const BLOCK: usize = 100;
/// Window after a reversal in which its error counts, s; and before it, s.
pub const AFTER_S: f64 = 4.0;
const BEFORE_S: f64 = 2.0;
/// Distance from which the windows of two reversals do not overlap, s.
pub const APART_S: f64 = AFTER_S + BEFORE_S;
/// Quarters of a window that may be unused: corners of the command near dwells are.
const MOST_UNUSED: usize = 2;
/// Decays of the two shapes that fade, s.
const SHAPES_S: [f64; 2] = [0.5, 2.0];

/// Everything that the last round knows.
pub struct Evidence {
    pub covariance: DMatrix<f64>,
    /// The same without what logs disagree in: for differences within a joint, in which that cancels.
    pub within: DMatrix<f64>,
    pub reversals: Vec<Reversal>,
}

/// One reversal.
#[derive(Debug, Clone, Default)]
pub struct Reversal {
    pub log: usize,
    pub axis: usize,
    pub t_s: f64,
    pub at: f64,
    /// Mean square TCP error of the joint's lost motion in the window, m^2.
    pub before_m2: f64,
    /// The same of what is left by an estimate that did not see this stretch; noise is taken off, so it may be negative.
    pub left_m2: f64,
    /// Standard deviation of `left_m2` from noise alone.
    pub left_sigma_m2: f64,
    /// Lost motion as a multiple of the model's, with its standard error.
    pub ratio: f64,
    pub sigma: f64,
    /// Sign of the change of lost motion: the direction of the stroke that begins here.
    pub direction: f64,
    /// What is left, as sizes of the three shapes, rad or m, and the matrix that makes their mean square TCP error of it.
    pub left: Vector3<f64>,
    pub energy: Matrix3<f64>,
    /// TCP error at the end of the window, m: what is left, and the lost motion.
    pub end_m: f64,
    pub lost_end_m: f64,
}

/// The covariance, and the same without what logs disagree in.
pub fn covariances(problem: &Problem) -> Option<[DMatrix<f64>; 2]> {
    let inverse = inverse(&problem.normal().hessian)?;
    let parts: Vec<Part> = (0..problem.logs.len()).par_map(|l| problem.part(l));
    Some(sandwich(problem, &parts, &inverse))
}

/// Evaluates the problem at its present estimate.
pub fn evaluate(problem: &Problem) -> Option<Evidence> {
    let hessian = problem.normal().hessian;
    let inverse = inverse(&hessian)?;
    let parts: Vec<Part> = (0..problem.logs.len()).par_map(|l| problem.part(l));
    let [covariance, within] = sandwich(problem, &parts, &inverse);
    let all: Vec<Vec<Reversal>> = (0..parts.len()).par_map(|l| of_log(problem, l, &parts[l], Some(&hessian)));
    Some(Evidence { covariance, within, reversals: all.into_iter().flatten().collect() })
}

/// What the present estimate leaves after the reversals of the logs, that estimate as it stands.
pub fn standing(problem: &Problem, parts: &[Part]) -> Vec<Reversal> {
    parts.iter().enumerate().flat_map(|(l, p)| of_log(problem, l, p, None)).collect()
}

/// Inverse of a normal matrix; directions that the logs leave open get a large variance.
pub fn inverse(h: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    scaled_inverse(h, 1e-10).map(|found| found.inverse)
}

fn sandwich(problem: &Problem, parts: &[Part], inverse: &DMatrix<f64>) -> [DMatrix<f64>; 2] {
    let n = inverse.nrows();
    let prior = problem.prior().0;
    let open = problem.open_wind_up(&prior);
    let (mut meat, mut between) = (prior.clone(), prior);
    // logs with which a parameter is concerned
    let mut logs = vec![0usize; n];
    for (l, p) in parts.iter().enumerate() {
        let bins = problem.logs[l].len();
        let blocks = bins.div_ceil(BLOCK);
        let mut scores = DMatrix::zeros(p.index.len(), blocks);
        for b in 0..blocks {
            let (from, to) = (b * BLOCK, ((b + 1) * BLOCK).min(bins));
            for c in 0..3 {
                let (from, len) = (c * bins + from, to - from);
                let mut column = scores.column_mut(b);
                column.gemv_tr(1.0, &p.design.rows(from, len), &p.residual.rows(from, len), 1.0);
            }
        }
        let product = &scores * scores.transpose() * (blocks as f64 / (blocks as f64 - 1.0).max(1.0));
        let whole = scores.column_sum();
        let across = &whole * whole.transpose();
        p.index.iter().for_each(|i| logs[*i] += 1);
        for (i, &gi) in p.index.iter().enumerate() {
            for (k, &gk) in p.index.iter().enumerate() {
                meat[(gi, gk)] += product[(i, k)];
                between[(gi, gk)] += across[(i, k)];
            }
        }
    }
    let shared = inverse * (&meat + open) * inverse;
    let robust = inverse * meat * inverse;
    let between = inverse * between * inverse;
    // never less than the model itself says: scaled up where the scatter of blocks or logs is larger
    let scaled = |variance: &dyn Fn(usize) -> f64| {
        let factor: Vec<f64> = (0..n).map(|i| (variance(i) / inverse[(i, i)]).max(1.0).sqrt()).collect();
        DMatrix::from_fn(n, n, |i, k| inverse[(i, k)] * factor[i] * factor[k])
    };
    let all = scaled(&|i| robust[(i, i)].max(shared[(i, i)]).max(between[(i, i)] * few_logs(logs[i])));
    [all, scaled(&|i| robust[(i, i)])]
}

/// What the scatter of the scores of `logs` logs is to be multiplied by: the sample variance, and the wide tails of a variance from so
/// few (Student's t, at least two degrees of freedom). One log alone says nothing of this kind.
fn few_logs(logs: usize) -> f64 {
    if logs < 2 {
        return 0.0;
    }
    let n = logs as f64;
    let dof = (n - 1.0).max(2.0);
    let t = student::factor(0.95, dof);
    n / (n - 1.0) * (t / Z95).powi(2)
}

/// Reversals of a log, each judged by an estimate that left its stretch of the log out; without normal equations by the present one.
fn of_log(problem: &Problem, log: usize, part: &Part, hessian: Option<&DMatrix<f64>>) -> Vec<Reversal> {
    let l = &problem.logs[log];
    let bins = l.len();
    let responses = problem.responses(log, false);
    let turned: Vec<Vec<(usize, usize)>> = l
        .moving
        .iter()
        .map(|(_, rows)| {
            let bin = |row: usize| l.bins.iter().position(|b| b.1 > row).unwrap_or(bins);
            turns(&rows.x).into_iter().map(|row| (row, bin(row))).collect()
        })
        .collect();
    let lasts_s = l.t_s.last().zip(l.t_s.first()).map_or(0.0, |(b, a)| b - a);
    let shortest = (APART_S * bins as f64 / lasts_s.max(APART_S)).ceil() as usize;
    let at: Vec<Vec<usize>> = turned.iter().map(|t| t.iter().map(|t| t.1).collect()).collect();
    let mut out = Vec::new();
    for fold in folds(bins, &at, shortest) {
        // the residual of the stretches with that estimate, whitened
        let residual = match hessian {
            Some(hessian) => &part.residual - &part.design * left_out(part, bins, &fold, hessian),
            None => part.residual.clone(),
        };
        for (((axis, rows), (_, response)), turned) in l.moving.iter().zip(&responses).zip(&turned) {
            let mut errors = Vec::new();
            l.average(&response.error, &mut errors);
            for (k, &(row, bin)) in turned.iter().enumerate() {
                if bin == 0 || !fold.iter().any(|s| s.contains(&bin)) {
                    continue;
                }
                let t = rows.t_s[row];
                let next = turned.get(k + 1).map_or(f64::INFINITY, |next| rows.t_s[next.0]);
                let window = Window { log, axis: *axis, t_s: t, end_s: next.min(t + AFTER_S), bin };
                out.extend(reversal(problem, &window, &residual, &errors, rows.x[row]));
            }
        }
    }
    out
}

/// Change of the log's parameters when stretches of its bins are left out.
///
/// By the normal equations of all parameters: those of the log's own are as good only where what is left determines them.
fn left_out(part: &Part, bins: usize, stretches: &[Range<usize>], hessian: &DMatrix<f64>) -> DVector<f64> {
    let k = part.index.len();
    let (mut left, mut gradient) = (hessian.clone(), DVector::zeros(hessian.nrows()));
    for (c, stretch) in (0..3).flat_map(|c| stretches.iter().map(move |s| (c, s))) {
        let design = part.design.rows(c * bins + stretch.start, stretch.len()).into_owned();
        let h = design.transpose() * &design;
        let g = design.transpose() * part.residual.rows(c * bins + stretch.start, stretch.len());
        for i in 0..k {
            gradient[part.index[i]] -= g[i];
            for m in 0..k {
                left[(part.index[i], part.index[m])] -= h[(i, m)];
            }
        }
    }
    let change = solve::solve(&left, &gradient, 1e-9).unwrap_or_else(|| DVector::zeros(hessian.nrows()));
    DVector::from_fn(k, |i, _| change[part.index[i]])
}

struct Window {
    log: usize,
    axis: usize,
    t_s: f64,
    end_s: f64,
    bin: usize,
}

impl Window {
    /// Shape `k` of what is left after the reversal, in bin `b`: a step, and two that decay.
    fn shape(&self, l: &BinnedLog, b: usize, k: usize) -> f64 {
        if b < self.bin {
            return 0.0;
        }
        let since = (l.t_s[b] - self.t_s).max(0.0);
        if k == 0 { 1.0 } else { (-since / SHAPES_S[k - 1]).exp() }
    }
}

/// The matrix that makes a mean square TCP error, m^2, of sizes of the three shapes, and that error of the lost motion.
fn energies(l: &BinnedLog, w: &Window, to: usize, errors: &[f64]) -> (Matrix3<f64>, f64) {
    let window = (to - w.bin) as f64;
    let (mut energy, mut before) = (Matrix3::zeros(), 0.0);
    for b in w.bin..to {
        let lever2 = l.jacobian[b][w.axis].norm_squared();
        let s = Vector3::new(w.shape(l, b, 0), w.shape(l, b, 1), w.shape(l, b, 2));
        energy += s * s.transpose() * (lever2 / window);
        before += errors[b] * errors[b] * lever2 / window;
    }
    (energy, before)
}

/// Three shapes after a reversal against the held-out residual.
fn reversal(problem: &Problem, w: &Window, residual: &DVector<f64>, errors: &[f64], at: f64) -> Option<Reversal> {
    let l = &problem.logs[w.log];
    let bins = l.len();
    let to = (w.bin..bins).find(|&b| l.t_s[b] > w.end_s).unwrap_or(bins);
    let start = (0..=w.bin).rev().find(|&b| l.t_s[b] < w.t_s - BEFORE_S).unwrap_or(0);
    if to < w.bin + 5
        || w.bin < start + 3
        || problem.unused[w.log][start..to].iter().filter(|u| **u).count() > (to - start) * MOST_UNUSED / 4
    {
        return None;
    }
    let shape = |b: usize, k: usize| w.shape(l, b, k);
    // the lost motion itself: how it changes from before the reversal
    let from = errors[w.bin.saturating_sub(2)];
    let change = |b: usize| if b < w.bin { 0.0 } else { errors[b] - from };
    // the window and the lags before it: the shapes are zero there
    let first = start.saturating_sub(MOST_LAGS);
    let n = to - first;
    let mut white = vec![vec![0.0; 3 * n]; 4];
    for (k, column) in white.iter_mut().enumerate() {
        let size = |b: usize| if k < 3 { shape(b, k) } else { change(b) };
        let values: Vec<Vector3<f64>> = (first..to).map(|b| l.sensitivity[b][w.axis] * size(b)).collect();
        problem.whiten_from(w.log, first, &values, column);
    }
    let dot = |a: &dyn Fn(usize, usize) -> f64, b: &dyn Fn(usize, usize) -> f64| -> f64 {
        (0..3).map(|c| (start..to).map(|i| a(c, i) * b(c, i)).sum::<f64>()).sum()
    };
    let column = |k: usize| {
        let white = &white[k];
        move |c: usize, b: usize| white[c * n + b - first]
    };
    let remainder = |c: usize, b: usize| residual[c * bins + b];
    let mut h = Matrix3::zeros();
    let mut g = Vector3::zeros();
    for i in 0..3 {
        g[i] = dot(&column(i), &remainder);
        for k in 0..3 {
            h[(i, k)] = dot(&column(i), &column(k));
        }
    }
    // a decay that the window does not tell from the step is held near zero
    let ridge = 1e-3 * h.trace().max(f64::MIN_POSITIVE);
    let cov = (h + Matrix3::identity() * ridge).try_inverse()?;
    let found = cov * g;
    let (energy, before) = energies(l, w, to, errors);
    let (hh, gg) = (dot(&column(3), &column(3)), dot(&column(3), &remainder));
    let noise = energy * cov * h * cov;
    let last = to - 1;
    let lever = l.jacobian[last][w.axis].norm();
    Some(Reversal {
        log: w.log,
        axis: w.axis,
        t_s: w.t_s,
        at,
        before_m2: before,
        left_m2: found.dot(&(energy * found)) - noise.trace(),
        left_sigma_m2: (2.0 * (noise * noise).trace()).max(0.0).sqrt(),
        ratio: if hh > 0.0 { 1.0 + gg / hh } else { 1.0 },
        sigma: if hh > 0.0 { hh.sqrt().recip() } else { f64::INFINITY },
        direction: (errors[last] - from).signum(),
        left: found,
        energy,
        end_m: lever * found.dot(&Vector3::new(shape(last, 0), shape(last, 1), shape(last, 2))),
        lost_end_m: lever * errors[last],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Uniform numbers between -1 and 1.
    fn noise() -> impl FnMut() -> f64 {
        let mut state = 7u64;
        move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }
    }

    /// Truth: the fit of the rows that are left, by their own normal equations. One parameter is known from the stretches that are left out
    /// alone, and two are nearly the same.
    #[test]
    fn what_is_left_out_moves_the_estimate_to_the_fit_of_the_rest() {
        let (bins, stretches, mut next) = (60, [5..15, 40..48], noise());
        let left_out_bin = |b: usize| stretches.iter().any(|s| s.contains(&b));
        let mut design = DMatrix::from_fn(3 * bins, 4, |_, _| 1e5 * next());
        for row in 0..3 * bins {
            design[(row, 2)] = design[(row, 1)] + 3.0 * next();
            if !left_out_bin(row % bins) {
                design[(row, 3)] = 0.0;
            }
        }
        let prior = DMatrix::<f64>::identity(5, 5) * 25.0;
        let index = vec![0, 1, 3, 4];
        let residual = DVector::from_fn(3 * bins, |_, _| next());
        // at the minimum of the whole problem the gradient is zero, priors included
        let about = design.tr_mul(&residual);
        let full = |of: &DMatrix<f64>| {
            DMatrix::from_fn(5, 5, |i, k| {
                let at = |p: usize| index.iter().position(|x| *x == p);
                at(i).zip(at(k)).map_or(0.0, |(a, b)| of[(a, b)])
            })
        };
        let hessian = &prior + full(&design.tr_mul(&design));
        let change = left_out(
            &Part { index: index.clone(), design: design.clone(), residual: residual.clone() },
            bins,
            &stretches,
            &hessian,
        );
        let rows: Vec<usize> = (0..3 * bins).filter(|r| !left_out_bin(r % bins)).collect();
        let (kept, of_kept) = (design.select_rows(&rows), residual.select_rows(&rows));
        let normal = kept.tr_mul(&kept) + DMatrix::identity(4, 4) * 25.0;
        let want = normal.lu().solve(&(kept.tr_mul(&of_kept) - about)).unwrap();
        let (is, want) = (&design * change, &design * want);
        let apart = (&is - &want).amax() / want.amax();
        assert!(apart < 1e-3, "{apart}: {is} for {want}");
    }
}
