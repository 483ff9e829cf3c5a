//! What a caller states and what the loop needs of a linear model.

use super::Information;

/// A sum of squares `c(x) = |r(x)|^2` to minimise, with `J = dr/dx`.
///
/// A point is whatever the caller fits: a vector, a joint vector, a model with its effects. The loop knows only the changes
/// of its free parameters.
pub trait Problem {
    /// Where the parameters are.
    type Point: Clone;
    /// What an evaluation leaves for the cost and the linear model: the residuals, say.
    type State;
    /// The linear model at a point.
    type Model: LinearModel;

    /// Evaluates a point.
    fn evaluate(&mut self, point: &Self::Point) -> Self::State;

    /// Sum of squares of an evaluated point; NaN or infinite where the point is impossible.
    fn cost(&self, point: &Self::Point, state: &Self::State) -> f64;

    /// Linear model at an evaluated point. It may change weights that the cost depends on: the cost is computed again.
    fn linearise(&mut self, point: &Self::Point, state: &Self::State) -> Self::Model;

    /// The point moved by `change`; what bounds cut off is cut off in `change` too.
    fn moved(&self, point: &Self::Point, change: &mut [f64]) -> Self::Point;

    /// Marks the parameters that stand at a bound and would leave it against `gradient` (`J^T r`).
    fn hold(&self, _point: &Self::Point, _gradient: &[f64], _held: &mut [bool]) {}

    /// Norm of a change, over that of the parameters; infinite where no norm has a meaning.
    fn relative_change(&self, _point: &Self::Point, _change: &[f64]) -> f64 {
        f64::INFINITY
    }

    /// Called at the start and after every step taken: the caller may end the fit by its own criterion.
    fn judge(&mut self, _point: &Self::Point, _state: &Self::State, _progress: &Progress) -> Flow {
        Flow::Continue
    }
}

/// Where a fit stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Steps taken.
    pub steps: usize,
    /// Sum of squares.
    pub cost: f64,
    /// Fall of the cost in the last step; infinite before the first.
    pub gain: f64,
}

/// Whether a fit goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flow {
    /// The fit goes on.
    Continue,
    /// The caller's own criterion is met.
    Reached,
    /// The caller gives the fit up.
    Abandon,
}

/// Linear model `r + J s` of the residuals at a point.
pub trait LinearModel {
    /// `J^T r`.
    fn gradient(&self) -> &[f64];

    /// Squared norms of the columns of `J`.
    fn squared_norms(&self) -> &[f64];

    /// `argmin |r + J s|^2 + sum damping_k s_k^2` where held parameters change by `at` (whose other values are not read).
    /// `None` where it cannot be solved.
    fn step(&self, damping: &[f64], held: &[bool], at: &[f64]) -> Option<Vec<f64>>;

    /// `|J s|^2`.
    fn image_squared(&self, change: &[f64]) -> f64;

    /// Rank, condition and covariance for residuals of unit variance.
    fn information(&self) -> Information;
}
