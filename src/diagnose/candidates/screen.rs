//! Screening: what each candidate would explain of the whitened residual beyond the present effects and the frames.
//!
//! Method: sensitivities and residual are whitened and projected off the tangent of everything that is fitted already, since
//! a frame can swallow an effect; a small least-squares problem per candidate then gives its gain in 2 ln L and its first
//! values. The same projected norms say how small an effect the log would show: the minimal detectable bias.

use crate::diagnose::candidates::Candidate;
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::problem::forward::{Hypothesis, Problem, State};
use crate::diagnose::problem::normal::{dot, gram, orthonormal, project_off};
use crate::numerics::normal_equations::pseudo_inverse;
use crate::numerics::parallel::ParMap;
use nalgebra::{DMatrix, DVector};

/// Whitened residual and orthonormal tangent of a fitted hypothesis.
pub struct ScreeningContext<'a> {
    pub problem: &'a Problem,
    pub hypothesis: &'a Hypothesis,
    pub state: &'a State,
    pub whitening: &'a Whitening,
    /// Orthonormal, whitened.
    basis: Vec<Vec<f64>>,
    /// Whitened, off the tangent.
    pub residual: Vec<f64>,
}

/// What a candidate explains.
#[derive(Debug, Clone)]
pub struct Score {
    /// Index into the candidates.
    pub candidate: usize,
    /// Gain in 2 ln L.
    pub gain: f64,
    pub coefficients: Vec<f64>,
    /// Standard uncertainty of each coefficient.
    pub sigma: Vec<f64>,
    /// Share of the sensitivities' squared norm that is left off the tangent: 0 where the log cannot tell.
    pub own: f64,
}

/// Share below which a sensitivity counts as swallowed by frame and present effects.
pub const SWALLOWED: f64 = 1e-8;

/// The score of whitened sensitivities by their scalar products: `before` with each other, `inside` with the orthonormal tangent
/// (a row each), `right` with the residual. What the tangent holds of a product is that of the coordinates in it.
pub fn scored(
    index: usize,
    before: &DMatrix<f64>,
    inside: &DMatrix<f64>,
    right: &DVector<f64>,
    positive: bool,
) -> Score {
    let k = before.nrows();
    let normal = before - inside.tr_mul(inside);
    let own = (0..k)
        .map(|i| if before[(i, i)] > 0.0 { normal[(i, i)] / before[(i, i)] } else { 0.0 })
        .fold(if k == 0 { 0.0 } else { f64::INFINITY }, f64::min);
    if own < SWALLOWED || !own.is_finite() {
        return Score { candidate: index, gain: 0.0, coefficients: vec![0.0; k], sigma: vec![f64::INFINITY; k], own };
    }
    let covariance = pseudo_inverse(&normal, 1e-9);
    let solution = &covariance * right;
    let gain = solution.dot(right);
    let sigma = (0..k).map(|i| covariance[(i, i)].max(0.0).sqrt()).collect();
    let gain = if positive && solution[0] < 0.0 { 0.0 } else { gain };
    Score { candidate: index, gain, coefficients: solution.as_slice().to_vec(), sigma, own }
}

impl<'a> ScreeningContext<'a> {
    /// `tangent`: whitened sensitivities of all that is fitted.
    pub fn new(
        problem: &'a Problem,
        hypothesis: &'a Hypothesis,
        state: &'a State,
        whitening: &'a Whitening,
        tangent: Vec<Vec<f64>>,
    ) -> Self {
        let basis = orthonormal(tangent);
        let mut residual = whitening.of(problem, &state.residual);
        project_off(&basis, &mut residual);
        Self { problem, hypothesis, state, whitening, basis, residual }
    }

    /// Whitens columns and takes the tangent off; with the squared norms before.
    pub fn project(&self, columns: &mut [Vec<f64>]) -> Vec<f64> {
        columns
            .iter_mut()
            .map(|c| {
                self.whitening.apply(self.problem, c);
                let before = dot(c, c);
                project_off(&self.basis, c);
                before
            })
            .collect()
    }

    /// The orthonormal tangent, a row each.
    pub fn basis_rows(&self) -> DMatrix<f64> {
        DMatrix::from_row_iterator(self.basis.len(), self.residual.len(), self.basis.iter().flatten().copied())
    }

    /// What one candidate explains.
    pub fn score(&self, index: usize, candidate: &Candidate) -> Score {
        let columns = candidate.columns(self.problem, self.hypothesis, self.state);
        self.score_columns(index, columns, candidate.positive)
    }

    /// What given sensitivities explain.
    pub fn score_columns(&self, index: usize, mut columns: Vec<Vec<f64>>, positive: bool) -> Score {
        columns.iter_mut().for_each(|c| self.whitening.apply(self.problem, c));
        let inside = DMatrix::from_fn(self.basis.len(), columns.len(), |b, c| dot(&self.basis[b], &columns[c]));
        let right = DVector::from_iterator(columns.len(), columns.iter().map(|c| dot(c, &self.residual)));
        scored(index, &gram(&columns), &inside, &right, positive)
    }

    /// Scores of all candidates, in their order.
    pub fn score_all(&self, candidates: &[Candidate]) -> Vec<Score> {
        (0..candidates.len()).par_map(|i| self.score(i, &candidates[i]))
    }

    /// The whitened residual taken back through the filters: its scalar product with a raw sensitivity is the whitened one.
    pub fn back(&self) -> Vec<f64> {
        let mut back = self.residual.clone();
        self.whitening.adjoint(self.problem, &mut back);
        back
    }
}
