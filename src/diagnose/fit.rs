//! Generalised least squares over the whole chain: all found effects and the nuisance (frames, sensor zeros) refitted together.
//!
//! Method: Levenberg-Marquardt on whitened residuals with the signatures of [`super::forward`], scaled by the columns'
//! norms, steps held inside the physical bounds. Covariance from the whitened normal matrix at the end, so intervals
//! account for coloured noise. Fails softly: it says whether it converged, and returns the best point it saw.

use super::forward::{Hypothesis, Problem, State};
use super::geometry;
use super::layout::Sensor;
use super::noise::{self, Noise, Whitener};
use super::screen::{orthonormal, project_off};
use crate::effect::{Effect, Placed};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::sync::Arc;

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
        let of = |g: &super::layout::Group| {
            let v = &residual[g.range()];
            let rms = (v.iter().map(|x| x * x).sum::<f64>() / v.len() as f64).sqrt();
            Noise::white(rms.max(noise::least_sigma(g)))
        };
        Self::new(problem, problem.groups.iter().map(of).collect())
    }

    /// Noise of the largest likelihood for a residual from which `fitted` parameters were taken; with 2 ln L.
    pub fn of_residual(problem: &Problem, residual: &[f64], fitted: usize) -> (Self, f64) {
        let share = fitted as f64 / problem.n.max(1) as f64;
        let found: Vec<(Noise, f64)> = problem
            .groups
            .par_iter()
            .map(|g| {
                let (mut noise, mut two_ln_l) =
                    noise::estimate(g, &residual[g.range()], share * g.range().len() as f64);
                // reflectors of one pose err together
                let together = geometry::inflation(problem, g.log, residual);
                noise.sigma *= together.sqrt();
                two_ln_l /= together;
                if matches!(g.sensor, Sensor::Motor(_)) {
                    noise.sigma = noise.sigma.max(LEAST_MOTOR_SIGMA);
                }
                (noise, two_ln_l)
            })
            .collect();
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

/// A hypothesis refitted, with what it leaves.
#[derive(Debug, Clone)]
pub struct Fit {
    pub hypothesis: Hypothesis,
    pub state: State,
    /// Effects that were free: index into the hypothesis' effects, in the order of the columns.
    pub free: Vec<usize>,
    /// Sum of the whitened squares.
    pub cost: f64,
    /// Covariance of the free parameters (effects in order, each with all its values; then the nuisance).
    pub covariance: DMatrix<f64>,
    pub converged: bool,
}

impl Fit {
    /// Number of free parameters.
    pub fn parameters(&self) -> usize {
        self.covariance.nrows()
    }

    /// Standard uncertainties of the values of the k-th free effect.
    pub fn sigma_of(&self, k: usize) -> Vec<f64> {
        let values = |i: &usize| self.hypothesis.effects[*i].effect.values().len();
        let start: usize = self.free[..k].iter().map(values).sum();
        (start..start + values(&self.free[k])).map(|i| self.covariance[(i, i)].max(0.0).sqrt()).collect()
    }
}

/// Most steps of a refit.
const STEPS: usize = 15;
/// Change of the cost, in units of 2 ln L, at which a refit stops.
const SETTLED: f64 = 1e-2;

/// Factor by which a step that makes things worse raises the damping; it doubles from one to the next.
const GROWTH: f64 = 8.0;
/// Factor by which a step that keeps what was promised lowers it.
const LEAST_EASING: f64 = 0.1;
/// A refit is given up where it is farther than this from its aim, in units of 2 ln L,
const FAR: f64 = 50.0;
/// and a step brings less than this part of what is missing,
const HOPELESS: f64 = 0.02;
/// the first steps apart: shapes may start far off.
const FIRST_STEPS: usize = 2;
/// Gain of a step, in the same units, below which the next one uses the same signatures.
const REFRESHED: f64 = 1.0;

/// Step of a parameter for its numerical derivative: small, as a frequency turns the phase at the end of a long log.
fn step_of(value: f64, bounds: (f64, f64)) -> f64 {
    let span = (bounds.1 - bounds.0).abs();
    let least = if span.is_finite() { 1e-8 * span } else { 1e-9 };
    let h = if value == 0.0 { least } else { (2e-6 * value.abs()).max(1e-13) };
    if value + h > bounds.1 { -h } else { h }
}

/// Signatures of all values of one effect of the hypothesis.
pub fn effect_columns(problem: &Problem, h: &Hypothesis, state: &State, index: usize) -> Vec<Vec<f64>> {
    let placed = &h.effects[index];
    let bounds = placed.bounds(&problem.robot);
    let values = placed.effect.values();
    (0..values.len())
        .map(|v| {
            let step = step_of(values[v], bounds[v]);
            let mut changed = values.clone();
            changed[v] += step;
            let to = Placed { target: placed.target, effect: placed.effect.with_values(&changed) };
            problem.difference(h, state, std::slice::from_ref(placed), &[to], step)
        })
        .collect()
}

/// Whitened signatures of the free effects and frames.
pub fn tangent(
    problem: &Problem,
    h: &Hypothesis,
    state: &State,
    free: &[usize],
    whitening: &Whitening,
) -> Vec<Vec<f64>> {
    let mut columns: Vec<Vec<f64>> = free
        .par_iter()
        .map(|&i| effect_columns(problem, h, state, i))
        .collect::<Vec<_>>()
        .into_iter()
        .flatten()
        .collect();
    columns.extend(problem.nuisance_columns(h, state));
    columns.par_iter_mut().for_each(|c| whitening.apply(problem, c));
    columns
}

/// Normal matrix of columns.
pub fn gram(columns: &[Vec<f64>]) -> DMatrix<f64> {
    let all: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    products(&all, |_, _| true)
}

/// Scalar products of all pairs of columns that are `wanted` (the second not behind the first), both ways round; 0 elsewhere.
/// Piece by piece, as many columns do not fit into the cache; the pieces do not depend on the number of threads.
fn products(columns: &[&[f64]], wanted: impl Fn(usize, usize) -> bool + Sync) -> DMatrix<f64> {
    const PIECE: usize = 1024;
    const PARTS: usize = 8;
    let k = columns.len();
    let n = columns.first().map_or(0, |c| c.len());
    let part = n.div_ceil(PARTS).next_multiple_of(PIECE).max(PIECE);
    let sum_of = |start: usize| {
        let mut sum = DMatrix::zeros(k, k);
        for from in (start..n.min(start + part)).step_by(PIECE) {
            let to = n.min(from + PIECE);
            for i in 0..k {
                for j in (0..=i).filter(|&j| wanted(i, j)) {
                    sum[(i, j)] += dot(&columns[i][from..to], &columns[j][from..to]);
                }
            }
        }
        sum
    };
    let sums: Vec<DMatrix<f64>> = (0..n).step_by(part).collect::<Vec<_>>().into_par_iter().map(sum_of).collect();
    let mut sum = sums.into_iter().fold(DMatrix::zeros(k, k), |a, b| a + b);
    sum.fill_upper_triangle_with_lower_triangle();
    sum
}

/// Scalar product, in a fixed order whatever the width of the processor's registers.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    pulp::Arch::new().dispatch(Dot(a, b))
}

struct Dot<'a>(&'a [f64], &'a [f64]);

impl pulp::NullaryFnOnce for Dot<'_> {
    type Output = f64;

    // inlined, so that it is compiled for the registers that there are
    #[inline(always)]
    fn call(self) -> f64 {
        const LANES: usize = 32;
        let mut sums = [0.0; LANES];
        let (x, y) = (self.0.chunks_exact(LANES), self.1.chunks_exact(LANES));
        let rest: f64 = x.remainder().iter().zip(y.remainder()).map(|(a, b)| a * b).sum();
        for (p, q) in x.zip(y) {
            for k in 0..LANES {
                sums[k] += p[k] * q[k];
            }
        }
        sums.iter().sum::<f64>() + rest
    }
}

/// Inverse of a normal matrix after scaling its diagonal to one; open directions (eigenvalue under `floor`) get none.
pub fn scaled_inverse(gram: &DMatrix<f64>, floor: f64) -> DMatrix<f64> {
    let k = gram.nrows();
    if k == 0 {
        return DMatrix::zeros(0, 0);
    }
    let d: Vec<f64> = (0..k).map(|i| if gram[(i, i)] > 0.0 { 1.0 / gram[(i, i)].sqrt() } else { 0.0 }).collect();
    let scaled = DMatrix::from_fn(k, k, |i, j| gram[(i, j)] * d[i] * d[j]);
    let eigen = scaled.symmetric_eigen();
    let mut inverse = DMatrix::zeros(k, k);
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        if *value > floor {
            inverse += vector * vector.transpose() / *value;
        }
    }
    DMatrix::from_fn(k, k, |i, j| inverse[(i, j)] * d[i] * d[j])
}

/// Eigenvalue, after scaling, below which a direction of the parameters is open.
const OPEN: f64 = 1e-10;

/// A whitened signature, shared by the refits that start from one fit.
pub type Column = Arc<Vec<f64>>;

/// Whitened signatures of a fit: of each free effect in order, then of the nuisance.
#[derive(Debug, Clone)]
pub struct Signatures {
    blocks: Vec<Vec<Column>>,
    normal: DMatrix<f64>,
}

impl Signatures {
    /// Those of a hypothesis and its free effects.
    pub fn new(problem: &Problem, h: &Hypothesis, state: &State, free: &[usize], whitening: &Whitening) -> Self {
        let mut new = Self { blocks: vec![Vec::new(); free.len() + 1], normal: DMatrix::zeros(0, 0) };
        new.renew(problem, h, state, free, whitening, &vec![true; free.len() + 1]);
        new
    }

    /// The columns one behind the other.
    pub fn columns(&self) -> impl Iterator<Item = &Column> {
        self.blocks.iter().flatten()
    }

    /// Copies that may be changed.
    pub fn to_columns(&self) -> Vec<Vec<f64>> {
        self.columns().map(|c| c.as_ref().clone()).collect()
    }

    /// Computes the blocks that are `stale` anew, and what they change of the normal matrix.
    fn renew(
        &mut self,
        problem: &Problem,
        h: &Hypothesis,
        state: &State,
        free: &[usize],
        whitening: &Whitening,
        stale: &[bool],
    ) {
        let fresh: Vec<Option<Vec<Column>>> = (0..stale.len())
            .into_par_iter()
            .map(|k| {
                let mut columns = match (stale[k], free.get(k)) {
                    (false, _) => return None,
                    (true, Some(&i)) => effect_columns(problem, h, state, i),
                    (true, None) => problem.nuisance_columns(h, state),
                };
                columns.par_iter_mut().for_each(|c| whitening.apply(problem, c));
                Some(columns.into_iter().map(Arc::new).collect())
            })
            .collect();
        // where a kept column stood in the normal matrix
        let mut stood: Vec<Option<usize>> = Vec::new();
        let mut at = 0;
        for (k, block) in fresh.into_iter().enumerate() {
            let before = self.blocks[k].len();
            match block {
                Some(columns) => {
                    stood.extend(std::iter::repeat_n(None, columns.len()));
                    self.blocks[k] = columns;
                }
                None => stood.extend((at..at + before).map(Some)),
            }
            at += before;
        }
        let columns: Vec<&[f64]> = self.columns().map(|c| c.as_slice()).collect();
        let mut normal = products(&columns, |i, j| stood[i].is_none() || stood[j].is_none());
        for (i, a) in stood.iter().enumerate() {
            for (j, b) in stood.iter().enumerate() {
                if let (Some(a), Some(b)) = (a, b) {
                    normal[(i, j)] = self.normal[(*a, *b)];
                }
            }
        }
        self.normal = normal;
    }

    /// The same with `more` effects behind the free ones, whose signatures are not there yet.
    fn with_more(&self, more: usize) -> Self {
        let mut blocks = self.blocks.clone();
        let nuisance = blocks.pop().unwrap_or_default();
        blocks.extend(std::iter::repeat_n(Vec::new(), more));
        blocks.push(nuisance);
        Self { blocks, normal: self.normal.clone() }
    }
}

/// Refits the effects `free` (indices) and the frames from where the hypothesis stands.
pub fn refit(problem: &Problem, start: &Hypothesis, free: &[usize], whitening: &Whitening) -> Fit {
    refit_above(problem, start, free, whitening, f64::INFINITY)
}

/// The same for a fit that is known to lie above `aim`: where it stays far above it does not settle to the last digit.
pub fn refit_above(problem: &Problem, start: &Hypothesis, free: &[usize], whitening: &Whitening, aim: f64) -> Fit {
    let state = problem.evaluate(start);
    let signatures = Signatures::new(problem, start, &state, free, whitening);
    solve(problem, start.clone(), state, free, whitening, signatures, aim)
}

/// The same where the signatures `known` of the first free effects and of the nuisance were computed at this very start,
/// without the effects behind them: only those on a joint that has a new one are computed anew. It ends early where the cost
/// stays far above `aim`.
pub fn refit_near(
    problem: &Problem,
    start: &Hypothesis,
    free: &[usize],
    whitening: &Whitening,
    known: &Signatures,
    aim: f64,
) -> Fit {
    let state = problem.evaluate(start);
    let old = known.blocks.len() - 1;
    let touched = |i: &usize| {
        let axis = start.effects[*i].axis();
        axis.is_some() && free[old..].iter().any(|&j| start.effects[j].axis() == axis)
    };
    let mut stale: Vec<bool> = free.iter().enumerate().map(|(k, i)| k >= old || touched(i)).collect();
    stale.push(false);
    let mut signatures = known.with_more(free.len() - old);
    signatures.renew(problem, start, &state, free, whitening, &stale);
    solve(problem, start.clone(), state, free, whitening, signatures, aim)
}

fn solve(
    problem: &Problem,
    mut h: Hypothesis,
    mut state: State,
    free: &[usize],
    whitening: &Whitening,
    mut signatures: Signatures,
    aim: f64,
) -> Fit {
    let mut white = whitening.of(problem, &state.residual);
    let mut cost = dot(&white, &white);
    let mut lambda = 1e-4;
    let mut growth = GROWTH;
    let mut converged = false;
    // how far each value has moved since its signature was computed, in its own uncertainties
    let mut moves = vec![0.0; signatures.normal.nrows()];
    for step in 0..STEPS {
        if moves.is_empty() {
            converged = true;
            break;
        }
        let gradient = DVector::from_iterator(moves.len(), signatures.columns().map(|c| dot(c, &white)));
        let mut improved = None;
        for _ in 0..8 {
            let mut damped = signatures.normal.clone();
            for i in 0..damped.nrows() {
                damped[(i, i)] *= 1.0 + lambda;
            }
            let inverse = scaled_inverse(&damped, OPEN);
            let step = &inverse * &gradient;
            // what the signatures promise: where that is nothing, this is the place
            let promised = 2.0 * step.dot(&gradient) - (&signatures.normal * &step).dot(&step);
            if promised < SETTLED {
                break;
            }
            let next = moved(problem, &h, free, step.as_slice());
            let next_state = problem.evaluate(&next);
            let next_white = whitening.of(problem, &next_state.residual);
            let next_cost = dot(&next_white, &next_white);
            if next_cost <= cost {
                for (k, m) in moves.iter_mut().enumerate() {
                    *m += step[k] / inverse[(k, k)].max(f64::MIN_POSITIVE).sqrt();
                }
                let kept = (cost - next_cost) / promised;
                lambda = (lambda * (1.0 - (2.0 * kept - 1.0).powi(3)).clamp(LEAST_EASING, 2.0)).max(1e-9);
                growth = GROWTH;
                improved = Some((next, next_state, next_white, next_cost));
                break;
            }
            lambda = (lambda * growth).max(1e-6);
            growth *= 2.0;
        }
        let Some((next, next_state, next_white, next_cost)) = improved else {
            converged = true;
            break;
        };
        let gain = cost - next_cost;
        (h, state, white, cost) = (next, next_state, next_white, next_cost);
        if gain < SETTLED {
            converged = true;
            break;
        }
        let far = cost - aim;
        if step >= FIRST_STEPS && far > FAR && gain < HOPELESS * far {
            break;
        }
        // close to the end the signatures hardly change any more
        if gain > REFRESHED {
            let stale = signatures.moved_too_far(&h, free, &moves);
            signatures.renew(problem, &h, &state, free, whitening, &stale);
            let mut at = 0;
            for (k, block) in signatures.blocks.iter().enumerate() {
                if stale[k] {
                    moves[at..at + block.len()].fill(0.0);
                }
                at += block.len();
            }
        }
    }
    let covariance = scaled_inverse(&signatures.normal, OPEN);
    Fit { hypothesis: h, state, free: free.to_vec(), cost, covariance, converged }
}

/// Squared cosine up to which two effects do not touch each other.
pub const APART: f64 = 0.02;

/// Movement of a value, in its own uncertainties, up to which its signature holds: within the noise nothing bends.
const HOLDS: f64 = 0.5;

impl Signatures {
    /// Largest squared cosine between a signature of effect `a` and one of effect `b` (places in the list of free effects),
    /// the nuisance taken off both: below [`APART`] neither can stand in for the other.
    pub fn shared(&self, a: usize, b: usize) -> f64 {
        let nuisance: Vec<Vec<f64>> =
            self.blocks.last().map(|n| n.iter().map(|c| c.as_ref().clone()).collect()).unwrap_or_default();
        let nuisance = orthonormal(nuisance);
        let freed = |k: usize| -> Vec<Vec<f64>> {
            let own = self.blocks.get(k).map(Vec::as_slice).unwrap_or_default();
            own.iter()
                .map(|c| {
                    let mut c = c.as_ref().clone();
                    project_off(&nuisance, &mut c);
                    c
                })
                .collect()
        };
        let (x, y) = (orthonormal(freed(a)), orthonormal(freed(b)));
        x.iter().flat_map(|u| y.iter().map(|v| dot(u, v).powi(2))).fold(0.0, f64::max)
    }

    /// Blocks of which a value has moved too far, and those on the same joint.
    fn moved_too_far(&self, h: &Hypothesis, free: &[usize], moves: &[f64]) -> Vec<bool> {
        let mut at = 0;
        let far: Vec<bool> = self
            .blocks
            .iter()
            .map(|b| {
                let own = &moves[at..at + b.len()];
                at += b.len();
                own.iter().any(|m| m.abs() > HOLDS)
            })
            .collect();
        let with = |k: usize| {
            let Some(&i) = free.get(k) else { return far[k] };
            let axis = h.effects[i].axis();
            far[k] || axis.is_some() && (0..free.len()).any(|j| far[j] && h.effects[free[j]].axis() == axis)
        };
        (0..self.blocks.len()).map(with).collect()
    }
}

/// Which value of an effect is a phase: it goes round instead of stopping at a bound.
fn phase_of(effect: &Effect) -> Option<usize> {
    match effect {
        Effect::TransmissionError(_) => Some(2),
        Effect::Vibration(_) => Some(4),
        _ => None,
    }
}

/// An angle within half a turn either way.
fn turned(angle_rad: f64) -> f64 {
    let turns = angle_rad / std::f64::consts::TAU;
    (turns - turns.round()) * std::f64::consts::TAU
}

/// The hypothesis with its free values moved by `step`, held inside their bounds.
fn moved(problem: &Problem, h: &Hypothesis, free: &[usize], step: &[f64]) -> Hypothesis {
    let mut next = h.clone();
    let mut at = 0;
    for &i in free {
        let placed = &mut next.effects[i];
        let bounds = placed.bounds(&problem.robot);
        let mut values = placed.effect.values();
        let phase = phase_of(&placed.effect);
        for (k, (v, (lo, hi))) in values.iter_mut().zip(bounds).enumerate() {
            let wanted = *v + step[at];
            *v = if phase == Some(k) { turned(wanted) } else { wanted.clamp(lo, hi) };
            at += 1;
        }
        placed.effect = placed.effect.with_values(&values);
    }
    next.move_nuisance(problem, &step[at..]);
    next
}
