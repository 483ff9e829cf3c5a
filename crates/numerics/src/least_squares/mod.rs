//! Nonlinear least squares: one Levenberg-Marquardt for every fit of this crate.
//!
//! Method: Levenberg (1944) and Marquardt (1963), damping after Nielsen (1999; Madsen, Nielsen and Tingleff 2004, section
//! 3.2): a step that gains what the linear model predicts lowers the damping, a step that fails raises it faster and faster.
//! The damping acts on parameters in units of their columns' norms (Moré 1978), so units do not matter. Bounds: a parameter
//! at its bound whose gradient points outwards is held, and steps are cut at the bounds (projected Levenberg-Marquardt,
//! Kanzow, Yamashita and Fukushima 2004).
//!
//! Read in this order:
//! - [`problem`]: what a caller states ([`Problem`]) and what a linear model offers ([`LinearModel`]);
//! - [`solve`]: the loop, and why it stops ([`TerminationReason`]);
//! - [`dense`]: the linear model of a full Jacobian, by QR with pivoting;
//! - [`products`]: the linear model of a structured or partitioned Jacobian, by its products;
//! - [`function`]: the plain case, residuals and Jacobian as functions of a vector with bounds;
//! - [`reweighted`]: linear fits in rounds whose weights are estimated anew;
//! - [`information`]: rank, condition, covariance.
//!
//! Assumptions: residuals are differentiable where the fit goes. It finds the minimum into whose valley it starts.
//!
//! Accuracy: 27 certified problems of NIST from both starts ([docs/numerics.md](../../../docs/numerics.md)).
//!
//! ```
//! use lostmotion_numerics::least_squares::{Function, Options, minimise};
//! use nalgebra::DMatrix;
//! // y = a exp(b x) through three points of a = 2, b = -1
//! let x = [0.0, 1.0, 2.0];
//! let mut problem = Function::new(
//!     |p: &[f64]| x.iter().map(|x| p[0] * (p[1] * x).exp() - 2.0 * (-x).exp()).collect(),
//!     |p: &[f64]| DMatrix::from_fn(3, 2, |i, j| (p[1] * x[i]).exp() * if j == 0 { 1.0 } else { p[0] * x[i] }),
//! );
//! let found = minimise(&mut problem, vec![1.0, 0.0], &Options::default());
//! assert!(found.reason.converged());
//! assert!((found.point[0] - 2.0).abs() < 1e-12 && (found.point[1] + 1.0).abs() < 1e-12);
//! assert_eq!(found.information().rank, 2);
//! ```

pub mod dense;
pub mod function;
pub mod information;
pub mod problem;
pub mod products;
pub mod reweighted;
pub mod solve;

pub use dense::Dense;
pub use function::Function;
pub use information::Information;
pub use problem::{Flow, LinearModel, Problem, Progress};
pub use products::Products;
pub use reweighted::{Reweighted, ridge_weights, rounds};
pub use solve::{Criterion, Options, Scaling, Solution, TerminationReason, minimise};
