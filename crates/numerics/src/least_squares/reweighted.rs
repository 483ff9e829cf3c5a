//! Linear fits in rounds, each with weights that the round before estimated: iteratively reweighted least squares.
//!
//! Method: a round solves the linear model at the present estimate (QR, [`super::Dense`]), takes the whole step, and lets the problem
//! estimate noise, correlation and the rows that count anew (Green 1984). The cost of a round is not that of the next, so no step can be
//! judged by it: the problem itself reports when it has settled.
//!
//! Fails: [`TerminationReason::NotFinite`] where a step cannot be solved, [`TerminationReason::StepLimit`] where the rounds are used up.

use super::{Flow, LinearModel, TerminationReason};

/// A fit whose weights change from round to round.
pub trait Reweighted {
    /// The linear model of a round.
    type Model: LinearModel;
    /// Why there is no linear model.
    type Failure;

    /// Linear model at the present estimate, with the present weights.
    ///
    /// # Errors
    /// Where the present estimate leaves too little to fit.
    fn linearise(&mut self) -> Result<Self::Model, Self::Failure>;

    /// Moves the estimate by `step` and estimates the weights anew; `round` counts from 0.
    fn take(&mut self, model: &Self::Model, step: &[f64], round: usize) -> Flow;
}

/// Runs at most `most` rounds; reports why they ended.
///
/// # Errors
/// What [`Reweighted::linearise`] fails with.
///
/// ```
/// use lostmotion_numerics::least_squares::{Dense, Flow, Reweighted, rounds};
/// use nalgebra::DMatrix;
/// /// A mean whose weights fall with the distance from it: the median of three values.
/// struct Median([f64; 3], f64);
/// impl Reweighted for Median {
///     type Model = Dense;
///     type Failure = ();
///     fn linearise(&mut self) -> Result<Dense, ()> {
///         let weights = self.0.map(|v| (v - self.1).abs().max(1e-12).powf(-0.5));
///         let residual: Vec<f64> = (0..3).map(|i| weights[i] * (self.1 - self.0[i])).collect();
///         Ok(Dense::new(DMatrix::from_column_slice(3, 1, &weights), &residual))
///     }
///     fn take(&mut self, _: &Dense, step: &[f64], _: usize) -> Flow {
///         self.1 += step[0];
///         if step[0].abs() < 1e-9 { Flow::Reached } else { Flow::Continue }
///     }
/// }
/// let mut median = Median([1.0, 2.0, 50.0], 0.0);
/// assert!(rounds(&mut median, 200)?.converged());
/// assert!((median.1 - 2.0).abs() < 1e-6);
/// # Ok::<(), ()>(())
/// ```
pub fn rounds<P: Reweighted>(problem: &mut P, most: usize) -> Result<TerminationReason, P::Failure> {
    use super::Criterion;
    for round in 0..most {
        let model = problem.linearise()?;
        let n = model.gradient().len();
        let Some(step) = model.step(&vec![0.0; n], &vec![false; n], &vec![0.0; n]) else {
            return Ok(TerminationReason::NotFinite);
        };
        match problem.take(&model, &step, round) {
            Flow::Continue => {}
            Flow::Reached => return Ok(TerminationReason::Converged(Criterion::Caller)),
            Flow::Abandon => return Ok(TerminationReason::Abandoned),
        }
    }
    Ok(TerminationReason::StepLimit)
}

/// Weights of rows, one per column with the norm `norms[k]`, that hold the parameters back by `ridge` of what the rows know of each: a
/// direction that the rows leave open gets a variance `1/ridge` times that of a known one, instead of none.
pub fn ridge_weights(norms: impl IntoIterator<Item = f64>, ridge: f64) -> Vec<f64> {
    // a column of zeros gets a variance that is large and finite
    norms.into_iter().map(|norm| ridge.sqrt() * norm.max(1e-100)).collect()
}
