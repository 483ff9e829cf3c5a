//! The plain case: residuals and their derivatives as functions of a vector, with bounds.

use super::{Dense, Problem};
use nalgebra::DMatrix;

/// Residuals `r(p)` and Jacobian `dr/dp` of a vector of parameters.
pub struct Function<R, J> {
    residuals: R,
    jacobian: J,
    /// Lowest and highest value of each parameter; empty: none is bounded.
    bounds: Vec<[f64; 2]>,
}

impl<R, J> Function<R, J>
where
    R: FnMut(&[f64]) -> Vec<f64>,
    J: FnMut(&[f64]) -> DMatrix<f64>,
{
    /// Without bounds.
    pub fn new(residuals: R, jacobian: J) -> Self {
        Self { residuals, jacobian, bounds: Vec::new() }
    }

    /// Keeps each parameter within its bounds. The start must be within them.
    #[must_use]
    pub fn within(mut self, bounds: Vec<[f64; 2]>) -> Self {
        self.bounds = bounds;
        self
    }
}

impl<R, J> Problem for Function<R, J>
where
    R: FnMut(&[f64]) -> Vec<f64>,
    J: FnMut(&[f64]) -> DMatrix<f64>,
{
    type Point = Vec<f64>;
    type State = Vec<f64>;
    type Model = Dense;

    fn evaluate(&mut self, point: &Vec<f64>) -> Vec<f64> {
        (self.residuals)(point)
    }

    fn cost(&self, _point: &Vec<f64>, state: &Vec<f64>) -> f64 {
        state.iter().map(|r| r * r).sum()
    }

    fn linearise(&mut self, point: &Vec<f64>, state: &Vec<f64>) -> Dense {
        Dense::new((self.jacobian)(point), state)
    }

    fn moved(&self, point: &Vec<f64>, change: &mut [f64]) -> Vec<f64> {
        let mut next: Vec<f64> = point.iter().zip(change.iter()).map(|(p, s)| p + s).collect();
        for (k, [lo, hi]) in self.bounds.iter().enumerate() {
            next[k] = next[k].clamp(*lo, *hi);
            change[k] = next[k] - point[k];
        }
        next
    }

    fn hold(&self, point: &Vec<f64>, gradient: &[f64], held: &mut [bool]) {
        for (k, [lo, hi]) in self.bounds.iter().enumerate() {
            held[k] = (point[k] <= *lo && gradient[k] > 0.0) || (point[k] >= *hi && gradient[k] < 0.0);
        }
    }

    fn relative_change(&self, point: &Vec<f64>, change: &[f64]) -> f64 {
        let share = |(p, s): (&f64, &f64)| if *s == 0.0 { 0.0 } else { s.abs() / p.abs() };
        point.iter().zip(change).map(share).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::least_squares::{Criterion, Options, TerminationReason, minimise};

    /// Rosenbrock's valley: minimum 0 at (1, 1).
    #[allow(clippy::type_complexity)] // the closures have no names
    fn valley() -> Function<impl FnMut(&[f64]) -> Vec<f64>, impl FnMut(&[f64]) -> DMatrix<f64>> {
        Function::new(
            |p: &[f64]| vec![10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0]],
            |p: &[f64]| DMatrix::from_row_slice(2, 2, &[-20.0 * p[0], 10.0, -1.0, 0.0]),
        )
    }

    #[test]
    fn walks_along_a_bent_valley() {
        let found = minimise(&mut valley(), vec![-1.2, 1.0], &Options::default());
        assert!(found.reason.converged(), "{:?}", found.reason);
        assert!((found.point[0] - 1.0).abs() < 1e-12 && (found.point[1] - 1.0).abs() < 1e-12, "{:?}", found.point);
    }

    #[test]
    fn stops_at_a_bound_where_the_gradient_points_outwards() {
        // with x at most 0.5 the minimum is (0.5, 0.25)
        let mut bounded = valley().within(vec![[-2.0, 0.5], [-2.0, 2.0]]);
        let found = minimise(&mut bounded, vec![-1.2, 1.0], &Options::default());
        assert!(found.reason.converged(), "{:?}", found.reason);
        assert_eq!(found.point[0], 0.5, "{:?} {}", found.reason, found.steps);
        assert!((found.point[1] - 0.25).abs() < 1e-12, "{:?}", found.point);
    }

    #[test]
    fn leaves_a_bound_that_it_need_not_stand_at() {
        let mut bounded = valley().within(vec![[-2.0, 2.0], [-2.0, 2.0]]);
        let found = minimise(&mut bounded, vec![-2.0, -2.0], &Options::default());
        assert!((found.point[0] - 1.0).abs() < 1e-12 && (found.point[1] - 1.0).abs() < 1e-12, "{:?}", found.point);
    }

    #[test]
    fn says_that_a_start_is_impossible() {
        let found = minimise(&mut valley(), vec![f64::NAN, 1.0], &Options::default());
        assert_eq!(found.reason, TerminationReason::NotFinite);
        assert!(found.covariance(1.0).is_none());
    }

    #[test]
    fn says_that_it_ran_out_of_steps_and_then_gives_no_covariance() {
        let options = Options { max_steps: 3, ..Options::default() };
        let found = minimise(&mut valley(), vec![-1.2, 1.0], &options);
        assert_eq!((found.reason, found.steps), (TerminationReason::StepLimit, 3));
        assert!(found.covariance(1.0).is_none() && found.information().is_full());
    }

    #[test]
    fn says_that_a_wrong_derivative_leads_nowhere() {
        let mut wrong = Function::new(|p: &[f64]| vec![p[0] - 3.0], |_: &[f64]| DMatrix::from_row_slice(1, 1, &[-1.0]));
        let found = minimise(&mut wrong, vec![1.0], &Options::default());
        assert!(!found.reason.converged() || found.reason == TerminationReason::Converged(Criterion::Step));
        assert_eq!(found.point, [1.0]);
    }

    #[test]
    fn a_parameter_without_effect_leaves_a_direction_open() {
        let mut blind = Function::new(
            |p: &[f64]| vec![p[0] - 3.0, 2.0 * p[0]],
            |_: &[f64]| DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 2.0, 0.0]),
        );
        let found = minimise(&mut blind, vec![1.0, 7.0], &Options::default());
        assert!(found.reason.converged());
        assert!((found.point[0] - 0.6).abs() < 1e-14 && found.point[1] == 7.0, "{:?}", found.point);
        assert_eq!((found.information().rank, found.information().parameters), (1, 2));
        assert!(found.covariance(1.0).is_none());
    }

    #[test]
    fn more_parameters_than_residuals_take_the_step_of_least_norm() {
        use crate::least_squares::Scaling;
        let mut wide =
            Function::new(|p: &[f64]| vec![p[0] + p[1] - 2.0], |_: &[f64]| DMatrix::from_row_slice(1, 2, &[1.0, 1.0]));
        let options = Options { scaling: Scaling::Uniform, ..Options::default() };
        let found = minimise(&mut wide, vec![0.0, 0.0], &options);
        assert!((found.point[0] - 1.0).abs() < 1e-12 && (found.point[1] - 1.0).abs() < 1e-12, "{:?}", found.point);
    }
}
