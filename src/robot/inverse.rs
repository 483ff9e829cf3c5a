//! Numerical inverse kinematics: damped least squares from a seed, for any subset of axes.
//!
//! Method: [`crate::numerics::least_squares`] on the position error (metres) and, for a pose, the rotation vector scaled by a
//! length so that both count alike. The damping is one for all axes, so the step is that of least norm where there are more
//! free axes than rows. It works where the target is reachable near the seed; it
//! does not search other branches. It never returns NaN: it returns the best `q` seen and reports why it stopped.

use super::Robot;
use crate::numerics::least_squares::{Dense, Flow, Options, Problem, Progress, Scaling, TerminationReason, minimise};
use nalgebra::{DMatrix, Matrix3, Vector3, Vector6};

/// What to reach.
#[derive(Debug, Clone, Copy)]
pub enum Target {
    /// Position of the TCP only, metres.
    Position(Vector3<f64>),
    /// Position and orientation of the TCP.
    Pose(super::Pose),
}

/// Settings of the inverse.
#[derive(Debug, Clone)]
pub struct InverseOptions {
    /// Axes that may move; empty means all.
    pub free: Vec<usize>,
    /// Position error at which the search stops, m.
    pub target_error_m: f64,
    /// Orientation error at which the search stops, rad.
    pub target_error_rad: f64,
    /// Most steps of the search.
    pub max_iterations: usize,
    /// Length that makes one radian of orientation count like metres.
    pub rotation_length_m: f64,
    /// Keep within the limits of the joints (a step that would leave is cut at the limit).
    pub within_limits: bool,
}

impl Default for InverseOptions {
    fn default() -> Self {
        Self {
            free: Vec::new(),
            target_error_m: 1e-10,
            target_error_rad: 1e-10,
            max_iterations: 100,
            rotation_length_m: 1.0,
            within_limits: false,
        }
    }
}

/// Why the inverse stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// Both errors are below their targets.
    Converged,
    /// No step reduces the error any more: out of reach, singular, or held by a limit.
    NoProgress,
    /// The steps were used up.
    IterationLimit,
    /// The target or the seed is not finite.
    NotFinite,
}

/// Result: the best joint vector, its errors, and why it stopped.
#[derive(Debug, Clone)]
pub struct Inverse {
    /// Joint positions, rad or m, one per axis.
    pub q: Vec<f64>,
    /// Why the search stopped.
    pub stop: Stop,
    /// Position error that remains, m.
    pub error_m: f64,
    /// 0 where only the position was asked for.
    pub error_rad: f64,
}

impl Inverse {
    /// Whether both errors are below their targets.
    pub fn converged(&self) -> bool {
        self.stop == Stop::Converged
    }
}

impl Robot {
    /// Joint vector that brings the TCP to `target`, from the seed `seed` (rad or m; one value per axis).
    pub fn inverse(&self, target: &Target, seed: &[f64], options: &InverseOptions) -> Inverse {
        let free: Vec<usize> = if options.free.is_empty() { (0..self.dof()).collect() } else { options.free.clone() };
        let q = seed.to_vec();
        let finite = q.iter().all(|v| v.is_finite())
            && match target {
                Target::Position(p) => p.iter().all(|v| v.is_finite()),
                Target::Pose(p) => p.position.iter().chain(p.rotation.matrix().iter()).all(|v| v.is_finite()),
            };
        if !finite {
            return Inverse { q, stop: Stop::NotFinite, error_m: f64::INFINITY, error_rad: 0.0 };
        }
        let mut reach = Reach { robot: self, target, options, free: &free };
        let settings = Options { max_steps: options.max_iterations, ..SETTINGS };
        let found = minimise(&mut reach, q, &settings);
        let stop = match found.reason {
            _ if found.state.reached(options) => Stop::Converged,
            TerminationReason::StepLimit => Stop::IterationLimit,
            TerminationReason::NotFinite => Stop::NotFinite,
            _ => Stop::NoProgress,
        };
        Inverse { q: found.point, stop, error_m: found.state.error_m, error_rad: found.state.error_rad }
    }

    fn miss(&self, target: &Target, q: &[f64], options: &InverseOptions) -> Miss {
        match target {
            Target::Position(want) => {
                let e = want - self.tcp_m(q);
                Miss { vector: Vector6::new(e.x, e.y, e.z, 0.0, 0.0, 0.0), error_m: e.norm(), error_rad: 0.0 }
            }
            Target::Pose(want) => {
                let now = self.forward(q);
                let e = want.position - now.position;
                let w = rotation_vector(&(want.rotation.matrix() * now.rotation.matrix().transpose()));
                let l = options.rotation_length_m;
                Miss {
                    vector: Vector6::new(e.x, e.y, e.z, w.x * l, w.y * l, w.z * l),
                    error_m: e.norm(),
                    error_rad: w.norm(),
                }
            }
        }
    }

    fn free_jacobian(&self, target: &Target, q: &[f64], free: &[usize], options: &InverseOptions) -> DMatrix<f64> {
        let (_, full) = self.chain().jacobian(q);
        let rows = if matches!(target, Target::Pose(_)) { 6 } else { 3 };
        DMatrix::from_fn(rows, free.len(), |r, c| {
            full[(r, free[c])] * if r < 3 { 1.0 } else { options.rotation_length_m }
        })
    }
}

/// Axis times angle of a rotation, rad; half a turn keeps its axis, which an iterative projection would lose.
pub fn rotation_vector(r: &Matrix3<f64>) -> Vector3<f64> {
    let sine = Vector3::new(r[(2, 1)] - r[(1, 2)], r[(0, 2)] - r[(2, 0)], r[(1, 0)] - r[(0, 1)]) * 0.5;
    let (s, c) = (sine.norm(), 0.5 * (r.trace() - 1.0));
    let angle = s.atan2(c);
    if c > -0.99 {
        return if s > 1e-12 { sine * (angle / s) } else { sine };
    }
    // near half a turn the sine has no digits left: (R + R^T)/2 = cos I + (1 - cos) axis axis^T
    let square = (r + r.transpose()) * 0.5 - Matrix3::identity() * c;
    let k = square.diagonal().imax();
    let axis = Vector3::from(square.column(k)).normalize();
    axis * if axis.dot(&sine) < 0.0 { -angle } else { angle }
}

/// Error of a joint vector: target minus what it reaches.
struct Miss {
    vector: Vector6<f64>,
    error_m: f64,
    /// 0 where only the position was asked for.
    error_rad: f64,
}

impl Miss {
    fn reached(&self, options: &InverseOptions) -> bool {
        self.error_m <= options.target_error_m && self.error_rad <= options.target_error_rad
    }
}

/// Settings of the least squares: full steps at once, as seeds lie near.
const SETTINGS: Options = Options {
    max_steps: 0,
    cost_tolerance: 0.0,
    cost_tolerance_absolute: 0.0,
    gradient_tolerance: 1e-15,
    step_tolerance: 0.0,
    initial_damping: 1e-6,
    least_damping: 1e-15,
    most_damping: 1e6,
    least_easing: 0.1,
    scaling: Scaling::Uniform,
    model_at_end: false,
};

/// The inverse as a least-squares problem over the free axes.
struct Reach<'a> {
    robot: &'a Robot,
    target: &'a Target,
    options: &'a InverseOptions,
    free: &'a [usize],
}

impl Reach<'_> {
    fn limits(&self, axis: usize) -> Option<[f64; 2]> {
        self.robot.axis(axis).limits.filter(|_| self.options.within_limits)
    }
}

impl Problem for Reach<'_> {
    type Point = Vec<f64>;
    type State = Miss;
    type Model = Dense;

    fn evaluate(&mut self, q: &Vec<f64>) -> Miss {
        self.robot.miss(self.target, q, self.options)
    }

    fn cost(&self, _q: &Vec<f64>, miss: &Miss) -> f64 {
        miss.vector.norm_squared()
    }

    fn linearise(&mut self, q: &Vec<f64>, miss: &Miss) -> Dense {
        let jacobian = self.robot.free_jacobian(self.target, q, self.free, self.options);
        let residual = -miss.vector;
        Dense::new(jacobian, &residual.as_slice()[..if matches!(self.target, Target::Pose(_)) { 6 } else { 3 }])
    }

    fn moved(&self, q: &Vec<f64>, change: &mut [f64]) -> Vec<f64> {
        let mut next = q.clone();
        for (step, &axis) in change.iter_mut().zip(self.free) {
            next[axis] += *step;
            if let Some([lo, hi]) = self.limits(axis)
                && !(lo..=hi).contains(&next[axis])
            {
                next[axis] = next[axis].clamp(lo, hi);
                *step = next[axis] - q[axis];
            }
        }
        next
    }

    fn hold(&self, q: &Vec<f64>, gradient: &[f64], held: &mut [bool]) {
        for ((held, g), &axis) in held.iter_mut().zip(gradient).zip(self.free) {
            *held =
                self.limits(axis).is_some_and(|[lo, hi]| (q[axis] <= lo && *g > 0.0) || (q[axis] >= hi && *g < 0.0));
        }
    }

    fn judge(&mut self, _q: &Vec<f64>, miss: &Miss, _progress: &Progress) -> Flow {
        if miss.reached(self.options) { Flow::Reached } else { Flow::Continue }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;
    use std::f64::consts::PI;

    #[test]
    fn a_rotation_vector_comes_back_at_every_angle() {
        let axis = Vector3::new(0.36, -0.48, 0.8);
        for angle in [0.0, 1e-13, 1e-6, 0.5, 3.0, 3.1, PI - 1e-6, PI - 1e-9] {
            let v = rotation_vector(Rotation3::from_scaled_axis(axis * angle).matrix());
            assert!((v - axis * angle).norm() < 1e-13, "{angle}: {v}");
        }
        let half = rotation_vector(Rotation3::from_scaled_axis(axis * PI).matrix());
        assert!((half.norm() - PI).abs() < 1e-13 && half.cross(&axis).norm() < 1e-13);
    }
}
