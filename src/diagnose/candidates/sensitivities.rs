//! Whitened sensitivities of everything that is fitted: the derivatives of the prediction by each value, kept while they hold.

use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::forward::{Hypothesis, Problem, State};
use crate::diagnose::problem::normal::{dot, products};
use crate::diagnose::problem::normal::{orthonormal, project_off};
use crate::effects::EffectInstance;
use crate::numerics::parallel::{self, ParMap};
use nalgebra::DMatrix;
use std::sync::Arc;

/// Step of a parameter for its numerical derivative: small, as a frequency turns the phase at the end of a long log.
fn step_of(value: f64, bounds: (f64, f64)) -> f64 {
    let span = (bounds.1 - bounds.0).abs();
    let least = if span.is_finite() { 1e-8 * span } else { 1e-9 };
    let h = if value == 0.0 { least } else { (2e-6 * value.abs()).max(1e-13) };
    if value + h > bounds.1 { -h } else { h }
}

/// Least step of the time of a filter for its numerical derivative, s: a filtered joint turns between its samples, one that is
/// not does not, so that nothing smaller tells the derivative at zero.
const FILTER_STEP_S: f64 = 1e-5;

/// Sensitivities of all values of one effect of the hypothesis.
pub fn effect_columns(problem: &Problem, h: &Hypothesis, state: &State, index: usize) -> Vec<Vec<f64>> {
    let placed = &h.effects[index];
    let bounds = placed.bounds(&problem.robot);
    let values = placed.effect.values();
    (0..values.len())
        .map(|v| {
            let least = if placed.effect.filters_in_time() { FILTER_STEP_S } else { 0.0 };
            let step = step_of(values[v], bounds[v]);
            let step = if step.abs() < least { least } else { step };
            let mut changed = values.clone();
            changed[v] += step;
            let to = EffectInstance { target: placed.target, effect: placed.effect.with_values(&changed) };
            problem.difference(h, state, std::slice::from_ref(placed), &[to], step)
        })
        .collect()
}

/// Whitened sensitivities of the free effects and frames.
pub fn tangent(
    problem: &Problem,
    h: &Hypothesis,
    state: &State,
    free: &[usize],
    whitening: &Whitening,
) -> Vec<Vec<f64>> {
    let mut columns: Vec<Vec<f64>> =
        free.par_map(|&i| effect_columns(problem, h, state, i)).into_iter().flatten().collect();
    columns.extend(problem.nuisance_columns(h, state));
    parallel::change(&mut columns, |_, c| whitening.apply(problem, c));
    columns
}

/// A whitened sensitivity, shared by the refits that start from one fit.
pub type Column = Arc<Vec<f64>>;

/// Whitened sensitivities of a fit: of each free effect in order, then of the nuisance.
#[derive(Debug, Clone)]
pub struct Sensitivities {
    pub(in crate::diagnose) blocks: Vec<Vec<Column>>,
    pub(in crate::diagnose) normal: DMatrix<f64>,
}

impl Sensitivities {
    /// Those of a hypothesis and its free effects.
    pub fn new(problem: &Problem, h: &Hypothesis, state: &State, free: &[usize], whitening: &Whitening) -> Self {
        let mut new = Self { blocks: vec![Vec::new(); free.len() + 1], normal: DMatrix::zeros(0, 0) };
        new.renew(problem, h, state, free, whitening, &vec![true; free.len() + 1]);
        new
    }

    /// The columns one after the other.
    pub fn columns(&self) -> impl Iterator<Item = &Column> {
        self.blocks.iter().flatten()
    }

    /// Copies that may be changed.
    pub fn to_columns(&self) -> Vec<Vec<f64>> {
        self.columns().map(|c| c.as_ref().clone()).collect()
    }

    /// Computes the blocks that are `stale` anew, and what they change of the normal matrix.
    pub(in crate::diagnose) fn renew(
        &mut self,
        problem: &Problem,
        h: &Hypothesis,
        state: &State,
        free: &[usize],
        whitening: &Whitening,
        stale: &[bool],
    ) {
        let fresh: Vec<Option<Vec<Column>>> = (0..stale.len()).par_map(|k| {
            let mut columns = match (stale[k], free.get(k)) {
                (false, _) => return None,
                (true, Some(&i)) => effect_columns(problem, h, state, i),
                (true, None) => problem.nuisance_columns(h, state),
            };
            parallel::change(&mut columns, |_, c| whitening.apply(problem, c));
            Some(columns.into_iter().map(Arc::new).collect())
        });
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

    /// The same with `more` effects after the free ones, whose sensitivities are not there yet.
    pub(in crate::diagnose) fn with_more(&self, more: usize) -> Self {
        let mut blocks = self.blocks.clone();
        let nuisance = blocks.pop().unwrap_or_default();
        blocks.extend(std::iter::repeat_n(Vec::new(), more));
        blocks.push(nuisance);
        Self { blocks, normal: self.normal.clone() }
    }
}

/// Squared cosine up to which two effects do not touch each other.
pub const APART: f64 = 0.02;

/// Movement of a value, in its own uncertainties, up to which its sensitivity holds: within the noise nothing bends.
const HOLDS: f64 = 0.5;

impl Sensitivities {
    /// Largest squared cosine between a sensitivity of effect `a` and one of effect `b` (places in the list of free effects),
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
    pub(in crate::diagnose) fn moved_too_far(&self, h: &Hypothesis, free: &[usize], moves: &[f64]) -> Vec<bool> {
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
