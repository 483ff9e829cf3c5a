//! The bounded quadratic program of Cursi (2022), equation 1: `min 1/2 |v - J x|^2` with `lower <= x <= upper`.
//!
//! With more joints than coordinates its minimum is no single point; a weight [`REST`] on the step itself takes the smallest one
//! (in units of `scale`, so that radians and metres compare). Where that step lies within its bounds, it is the minimum, and
//! its normal equations give it; else the interior-point solver Clarabel does (Goulart and Chen 2024). The weight makes a flat
//! minimum, so the bounds that hold are read off its result and the rest is solved again without them. The result is within the bounds
//! to the last digit.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};
use nalgebra::{DMatrix, DVector};

/// Weight of the step over the largest diagonal of `J^T J`: it leaves 1e-6 of a velocity along which the robot moves well, and
/// the next step makes up for that.
const REST: f64 = 1e-6;
/// Bounds closer than this (scaled) leave the variable at their middle.
const NARROW: f64 = 1e-9;
/// A variable of the solver's result this near to its bound (scaled) may stand on it.
const NEAR: f64 = 1e-4;

/// A problem. Bounds are finite, `lower <= upper`; `scale` is above 0.
#[derive(Debug)]
pub struct Quadratic<'a> {
    /// Velocity of the coordinates by each joint velocity.
    pub jacobian: &'a DMatrix<f64>,
    /// Wanted velocity of the coordinates, m/s.
    pub velocity: &'a DVector<f64>,
    /// Least joint velocities, rad/s or m/s.
    pub lower: &'a [f64],
    /// Largest joint velocities, rad/s or m/s.
    pub upper: &'a [f64],
    /// Scale of each unknown: a typical joint velocity, above 0.
    pub scale: &'a [f64],
}

impl Quadratic<'_> {
    /// The minimum; `None` where the solver fails or a number is not finite.
    pub fn solve(&self) -> Option<Vec<f64>> {
        let n = self.scale.len();
        let finite = self.jacobian.iter().chain(self.velocity.iter()).chain(self.lower).chain(self.upper);
        if !finite.clone().all(|v| v.is_finite()) {
            return None;
        }
        let mut scaled = self.jacobian.clone();
        for (mut column, s) in scaled.column_iter_mut().zip(self.scale) {
            column *= *s;
        }
        let mut p = scaled.transpose() * &scaled;
        // a robot that cannot move at all stays where it is
        let largest = p.diagonal().max().max(f64::MIN_POSITIVE.sqrt());
        for k in 0..n {
            p[(k, k)] += REST * largest;
        }
        p /= largest;
        let q = -(scaled.transpose() * self.velocity) / largest;
        let lower: Vec<f64> = self.lower.iter().zip(self.scale).map(|(b, s)| b / s).collect();
        let upper: Vec<f64> = self.upper.iter().zip(self.scale).map(|(b, s)| b / s).collect();
        let free = p.clone().cholesky()?.solve(&-&q);
        let inside = (0..n).all(|k| free[k] >= lower[k] && free[k] <= upper[k]);
        let x = if inside {
            free.as_slice().to_vec()
        } else {
            let x = interior(&p, &q, &lower, &upper)?;
            polished(&p, &q, &lower, &upper, &x).unwrap_or(x)
        };
        let back = (0..n).map(|k| (x[k] * self.scale[k]).clamp(self.lower[k], self.upper[k])).collect::<Vec<_>>();
        back.iter().all(|v| v.is_finite()).then_some(back)
    }
}

/// The minimum by interior points.
fn interior(p: &DMatrix<f64>, q: &DVector<f64>, lower: &[f64], upper: &[f64]) -> Option<Vec<f64>> {
    let n = q.len();
    let held = |k: usize| upper[k] - lower[k] < NARROW;
    let free: Vec<usize> = (0..n).filter(|&k| !held(k)).collect();
    let mut x: Vec<f64> = (0..n).map(|k| 0.5 * (lower[k] + upper[k])).collect();
    if free.is_empty() {
        return Some(x);
    }
    // what the held ones pull at the free ones
    let linear: Vec<f64> =
        free.iter().map(|&k| q[k] + (0..n).filter(|&j| held(j)).map(|j| p[(k, j)] * x[j]).sum::<f64>()).collect();
    let m = free.len();
    let upper_triangle = |r: usize, c: usize| if r <= c { p[(free[r], free[c])] } else { 0.0 };
    let cost = csc(m, m, upper_triangle);
    // A x + s = b, s >= 0: x <= upper, -x <= -lower
    let rows = csc(2 * m, m, |r, c| {
        if r == c {
            1.0
        } else if r == c + m {
            -1.0
        } else {
            0.0
        }
    });
    let bounds: Vec<f64> = free.iter().map(|&k| upper[k]).chain(free.iter().map(|&k| -lower[k])).collect();
    let settings = DefaultSettingsBuilder::default()
        .verbose(false)
        .tol_gap_abs(1e-12)
        .tol_gap_rel(1e-12)
        .tol_feas(1e-12)
        .build()
        .ok()?;
    let cones = [NonnegativeConeT(2 * m)];
    let mut solver = DefaultSolver::new(&cost, &linear, &rows, &bounds, &cones, settings).ok()?;
    solver.solve();
    // almost solved, or as far as digits reach: the bounds are kept by the caller, and the next step makes up for the rest
    let good = matches!(
        solver.solution.status,
        SolverStatus::Solved | SolverStatus::AlmostSolved | SolverStatus::InsufficientProgress
    );
    if !good || solver.solution.x.iter().any(|v| !v.is_finite()) {
        return None;
    }
    free.iter().zip(&solver.solution.x).for_each(|(&k, v)| x[k] = *v);
    Some(x)
}

/// The minimum among the points with the same bounds as `x`; `None` where that is no minimum of the problem.
fn polished(p: &DMatrix<f64>, q: &DVector<f64>, lower: &[f64], upper: &[f64], x: &[f64]) -> Option<Vec<f64>> {
    let n = x.len();
    let slope = |x: &[f64], k: usize| q[k] + (0..n).map(|j| p[(k, j)] * x[j]).sum::<f64>();
    let mut fixed: Vec<Option<f64>> = (0..n)
        .map(|k| {
            let (down, up) = (x[k] - lower[k], upper[k] - x[k]);
            let at = if down <= up { lower[k] } else { upper[k] };
            (down.min(up) < NEAR).then_some(at)
        })
        .collect();
    // a bound that pulls is let go, one that is passed holds: a few rounds settle it
    for _ in 0..2 * n {
        let free: Vec<usize> = (0..n).filter(|&k| fixed[k].is_none()).collect();
        let mut y: Vec<f64> = fixed.iter().map(|f| f.unwrap_or(0.0)).collect();
        if !free.is_empty() {
            let matrix = DMatrix::from_fn(free.len(), free.len(), |r, c| p[(free[r], free[c])]);
            let right = DVector::from_fn(free.len(), |r, _| -slope(&y, free[r]));
            let solved = matrix.cholesky()?.solve(&right);
            free.iter().zip(solved.iter()).for_each(|(&k, v)| y[k] = *v);
        }
        let passed = free.iter().copied().find(|&k| y[k] < lower[k] || y[k] > upper[k]);
        let pulls = |k: usize| match fixed[k] {
            Some(at) if upper[k] - lower[k] < NARROW => at.is_nan(),
            Some(at) => (at == lower[k] && slope(&y, k) < 0.0) || (at == upper[k] && slope(&y, k) > 0.0),
            None => false,
        };
        match (passed, (0..n).find(|&k| pulls(k))) {
            (Some(k), _) => fixed[k] = Some(if y[k] < lower[k] { lower[k] } else { upper[k] }),
            (None, Some(k)) => fixed[k] = None,
            (None, None) => return Some(y),
        }
    }
    None
}

/// A matrix by its columns, zeros left out.
fn csc(rows: usize, columns: usize, at: impl Fn(usize, usize) -> f64) -> CscMatrix<f64> {
    let (mut starts, mut places, mut values) = (vec![0], Vec::new(), Vec::new());
    for c in 0..columns {
        for r in 0..rows {
            let v = at(r, c);
            if v != 0.0 {
                places.push(r);
                values.push(v);
            }
        }
        starts.push(places.len());
    }
    CscMatrix::new(rows, columns, starts, places, values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// The minimum by trying every set of variables at their bounds: exact, and slow.
    fn by_enumeration(q: &Quadratic) -> Vec<f64> {
        let n = q.scale.len();
        let jac = DMatrix::from_fn(q.jacobian.nrows(), n, |r, c| q.jacobian[(r, c)] * q.scale[c]);
        let mut p = jac.transpose() * &jac;
        let largest = p.diagonal().max();
        (0..n).for_each(|k| p[(k, k)] += REST * largest);
        let g = jac.transpose() * q.velocity;
        let bound = |k: usize, state: usize| if state == 1 { q.lower[k] / q.scale[k] } else { q.upper[k] / q.scale[k] };
        let mut best = (f64::INFINITY, vec![]);
        for code in 0..3usize.pow(n as u32) {
            let states: Vec<usize> = (0..n).map(|k| code / 3usize.pow(k as u32) % 3).collect();
            let free: Vec<usize> = (0..n).filter(|&k| states[k] == 0).collect();
            let mut x = DVector::from_fn(n, |k, _| if states[k] == 0 { 0.0 } else { bound(k, states[k]) });
            if !free.is_empty() {
                let a = DMatrix::from_fn(free.len(), free.len(), |r, c| p[(free[r], free[c])]);
                let rest = &g - &p * &x;
                let b = DVector::from_fn(free.len(), |r, _| rest[free[r]]);
                let s = a.lu().solve(&b).unwrap();
                free.iter().zip(s.iter()).for_each(|(&k, v)| x[k] = *v);
            }
            let inside = (0..n).all(|k| x[k] >= bound(k, 1) - 1e-12 && x[k] <= bound(k, 2) + 1e-12);
            let value = 0.5 * (x.transpose() * &p * &x)[0] - g.dot(&x);
            if inside && value < best.0 {
                best = (value, (0..n).map(|k| x[k] * q.scale[k]).collect());
            }
        }
        best.1
    }

    #[test]
    fn bounded_steps_are_those_of_an_exhaustive_search() {
        let mut generator = ChaCha8Rng::seed_from_u64(11);
        let mut at_bounds = 0;
        for _ in 0..200 {
            let jacobian = DMatrix::from_fn(2, 4, |_, _| generator.random_range(-0.05..0.05));
            let velocity = DVector::from_fn(2, |_, _| generator.random_range(-0.01..0.01));
            let lower: Vec<f64> = (0..4).map(|_| generator.random_range(-0.2..0.0)).collect();
            let upper: Vec<f64> = (0..4).map(|_| generator.random_range(0.0..0.2)).collect();
            let q =
                Quadratic { jacobian: &jacobian, velocity: &velocity, lower: &lower, upper: &upper, scale: &[1.0; 4] };
            let (ours, truth) = (q.solve().unwrap(), by_enumeration(&q));
            let apart = ours.iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-9, "{ours:?} {truth:?}");
            let tip = |x: &[f64]| (&velocity - &jacobian * DVector::from_column_slice(x)).norm();
            assert!(tip(&ours) < tip(&truth) + 1e-8);
            at_bounds += usize::from(truth.iter().enumerate().any(|(k, v)| *v == lower[k] || *v == upper[k]));
        }
        assert!(at_bounds > 50, "{at_bounds} cases with a bound that holds");
    }

    #[test]
    fn a_robot_that_cannot_move_stays_and_numbers_that_are_none_are_refused() {
        let (j, v) = (DMatrix::zeros(2, 3), DVector::from_element(2, 1.0));
        let q = Quadratic { jacobian: &j, velocity: &v, lower: &[-1.0; 3], upper: &[1.0; 3], scale: &[1.0; 3] };
        assert_eq!(q.solve(), Some(vec![0.0; 3]));
        let bad = DVector::from_element(2, f64::NAN);
        assert_eq!(Quadratic { velocity: &bad, ..q }.solve(), None);
    }
}
