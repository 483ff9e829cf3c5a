//! The tracker's frame: the rigid transform that takes points of the base frame onto measured ones.
//!
//! Method: least squares over rotations and translations (Kabsch 1976; Umeyama 1991, without scale), made robust in two
//! steps: iteratively reweighted towards least absolute distances, then plain least squares on what lies within
//! [`GROSS`] standard deviations, the deviation taken from the median distance. Rows that disagree are reported.
//! Uncertainty: covariance of the linearised model `y = R x + t` (rotation vector in the tracker frame, Markley 1993),
//! scaled with the residual's variance over `3 n - 6` degrees of freedom.
//!
//! Assumptions: errors of the points are equal in all directions; less than half of the points are wrong. A lag looks like a
//! turned frame on a path that goes round one way: register on settled points, averaged over both directions of approach.
//!
//! Fails with an error on fewer than three points, on points that coincide (one pose), and on points of one line
//! ([`register`]); [`register_line`] accepts a line and reports about which axis the frame is not determined.

use crate::error::{Error, Place, Result, counted};
use crate::numerics::rigid;
use crate::numerics::robust::{MEDIAN_DISTANCE, median_of};
use nalgebra::{Isometry3, Matrix3, Matrix6, Rotation3, SMatrix, Translation3, UnitQuaternion, Vector3};

/// Points farther off than this many standard deviations of a coordinate are left out: wide, since the points are averages
/// of unlike numbers of samples, and geometry errors of a robot have no normal distribution.
const GROSS: f64 = 10.0;
/// With fewer points nothing can be distinguished from the rest.
const GROSS_FROM: usize = 6;
/// Spread across a line, over the spread along it, below which points count as one line.
const LINE: f64 = 1e-6;
/// Points that spread by less than this (m) are one pose.
const ONE_POSE_M: f64 = 1e-6;
/// Distances below this (m) have the same weight: the last digit of a tracker's file.
const LAST_DIGIT_M: f64 = 1e-7;
const REWEIGHTINGS: usize = 50;
/// Eigenvalue of the normal equations, over the largest, below which a direction counts as open.
const OPEN: f64 = 1e-12;

/// The tracker's frame as it was found.
#[derive(Debug, Clone)]
pub struct Registered {
    /// Base frame -> tracker frame.
    pub frame: Isometry3<f64>,
    /// Residual per coordinate, m.
    pub rms_m: f64,
    /// Number of points that were used.
    pub samples: usize,
    /// Standard uncertainty of the translation (m) and of the rotation vector (rad), where estimated.
    pub sigma_m: [f64; 3],
    /// Standard uncertainty of the rotation about x, y, z, rad.
    pub sigma_rad: [f64; 3],
}

/// A point as the robot has it (base frame) and as the tracker sees it, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// Point in the robot's frame, m.
    pub base_m: Vector3<f64>,
    /// The same point in the tracker's frame, m.
    pub tracker_m: Vector3<f64>,
}

/// A registration and how it came about.
#[derive(Debug, Clone)]
pub struct Registration {
    /// The frame and its uncertainty.
    pub found: Registered,
    /// Pairs that disagree with the rest, by index: they were left out.
    pub dropped: Vec<usize>,
    /// Axis in the tracker frame about which the points leave the rotation open (points of one line).
    pub open_axis: Option<Vector3<f64>>,
}

/// Finds the frame; refuses geometry that leaves it open.
///
/// ```
/// use lostmotion::log::registration::{Pair, register};
/// use nalgebra::Vector3;
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vector3::from);
/// let pairs = corners.map(|p| Pair { base_m: p, tracker_m: Vector3::new(2.0 - p.y, p.x, p.z) });
/// let frame = register(&pairs).unwrap().found.frame;
/// assert!((frame.translation.vector - Vector3::new(2.0, 0.0, 0.0)).norm() < 1e-12);
/// assert!((frame.rotation.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
/// ```
pub fn register(pairs: &[Pair]) -> Result<Registration> {
    let registration = register_line(pairs)?;
    if registration.open_axis.is_some() {
        return Err(Error::bad(
            Place::file("registration"),
            format!("{} points on one line", pairs.len()),
            "points that do not lie on one line (a line does not determine the rotation about it)",
        ));
    }
    Ok(registration)
}

/// The same, but points of one line give the frame that turns least about that line, and the axis is named.
pub fn register_line(pairs: &[Pair]) -> Result<Registration> {
    let n = pairs.len();
    if n < 3 {
        return Err(refuse(counted(n, "point"), "three points or more"));
    }
    if pairs.iter().any(|p| !(p.base_m.iter().chain(p.tracker_m.iter()).all(|v| v.is_finite()))) {
        return Err(refuse("a point that is not finite".into(), "finite points"));
    }
    let mut weights = vec![1.0; n];
    let mut fit = weighted_fit(pairs, &weights)?;
    let mut distances = residuals(pairs, &fit.frame);
    for _ in 0..REWEIGHTINGS {
        // a tenth of the median keeps points that fit by chance from taking over
        let least = (0.1 * median_of(&mut distances.clone()).unwrap_or(0.0)).max(LAST_DIGIT_M);
        for (w, d) in weights.iter_mut().zip(&distances) {
            *w = 1.0 / d.max(least);
        }
        let Ok(next) = weighted_fit(pairs, &weights) else { break };
        let moved = residuals(pairs, &next.frame);
        let change = moved.iter().zip(&distances).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        (fit, distances) = (next, moved);
        if change < 0.01 * least {
            break;
        }
    }
    let mut kept = vec![true; n];
    for _ in 0..20 {
        let limit = limit_m(&distances);
        let mut next: Vec<bool> = distances.iter().map(|&d| d <= limit).collect();
        if n < GROSS_FROM || next.iter().filter(|&&k| k).count() < n.div_ceil(2) {
            next.fill(true);
        }
        weights.iter_mut().zip(&next).for_each(|(w, &k)| *w = f64::from(u8::from(k)));
        let Ok(refit) = weighted_fit(pairs, &weights) else { break };
        fit = refit;
        distances = residuals(pairs, &fit.frame);
        let settled = next == kept;
        kept = next;
        if settled {
            break;
        }
    }
    let used: Vec<usize> = (0..n).filter(|&i| kept[i]).collect();
    let sum_squares: f64 = used.iter().map(|&i| distances[i].powi(2)).sum();
    let unknowns = if fit.open_axis.is_some() { 5.0 } else { 6.0 };
    let dof = (3.0 * used.len() as f64 - unknowns).max(1.0);
    let (sigma_m, sigma_rad) = uncertainty(used.iter().map(|&i| &pairs[i].base_m), &fit.frame, sum_squares / dof);
    Ok(Registration {
        found: Registered {
            frame: fit.frame,
            rms_m: (sum_squares / (3.0 * used.len() as f64)).sqrt(),
            samples: used.len(),
            sigma_m,
            sigma_rad,
        },
        dropped: (0..n).filter(|&i| !kept[i]).collect(),
        open_axis: fit.open_axis,
    })
}

fn refuse(found: String, expected: &str) -> Error {
    Error::bad(Place::file("registration"), found, expected)
}

fn residuals(pairs: &[Pair], frame: &Isometry3<f64>) -> Vec<f64> {
    pairs.iter().map(|p| (frame * nalgebra::Point3::from(p.base_m) - p.tracker_m).coords.norm()).collect()
}

fn limit_m(distances: &[f64]) -> f64 {
    // residuals are smaller than errors where six unknowns were fitted to few points
    let n = distances.len() as f64;
    let shrunk = (n / (n - 2.0)).sqrt();
    GROSS * (shrunk * median_of(&mut distances.to_vec()).unwrap_or(0.0) / MEDIAN_DISTANCE).max(LAST_DIGIT_M)
}

struct Fit {
    frame: Isometry3<f64>,
    open_axis: Option<Vector3<f64>>,
}

/// Weighted least squares in closed form, and the axis that points on one line leave open.
fn weighted_fit(pairs: &[Pair], weights: &[f64]) -> Result<Fit> {
    let total: f64 = weights.iter().sum();
    let mean = |of: fn(&Pair) -> &Vector3<f64>| {
        pairs.iter().zip(weights).map(|(p, &w)| of(p) * w).sum::<Vector3<f64>>() / total
    };
    let (from, to) = (mean(|p| &p.base_m), mean(|p| &p.tracker_m));
    let (mut spread, mut cross) = (Matrix3::zeros(), Matrix3::zeros());
    for (p, &w) in pairs.iter().zip(weights) {
        let (x, y) = (p.base_m - from, p.tracker_m - to);
        spread += x * x.transpose() * (w / total);
        cross += y * x.transpose() * (w / total);
    }
    // spread of the robot's own points: free of measurement noise, so their rank is the geometry's
    let (values, vectors) = principal(spread);
    if values[0].sqrt() < ONE_POSE_M {
        return Err(refuse("points that coincide: one pose".into(), "poses that differ"));
    }
    let (rotation, open_axis) = if values[1].sqrt() < LINE * values[0].sqrt() {
        let along = vectors[0];
        let seen = cross * along;
        if seen.norm() == 0.0 {
            return Err(refuse("points that do not move as one rigid body".into(), "points of one rigid transform"));
        }
        let turn = Rotation3::rotation_between(&along, &seen)
            .unwrap_or_else(|| Rotation3::from_axis_angle(&perpendicular(&along), std::f64::consts::PI));
        (turn, Some(seen.normalize()))
    } else {
        let weighted = pairs.iter().zip(weights).map(|(p, &w)| (p.base_m, p.tracker_m, w));
        let Some(found) = rigid::fit(weighted, false) else {
            return Err(refuse("points without a singular value decomposition".into(), "finite points"));
        };
        (Rotation3::from_matrix_unchecked(found.rotation), None)
    };
    let quaternion = UnitQuaternion::from_rotation_matrix(&rotation);
    let frame = Isometry3::from_parts(Translation3::from(to - quaternion * from), quaternion);
    Ok(Fit { frame, open_axis })
}

/// Eigenvalues in falling order with their vectors.
fn principal(m: Matrix3<f64>) -> ([f64; 3], [Vector3<f64>; 3]) {
    let e = m.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| e.eigenvalues[b].total_cmp(&e.eigenvalues[a]));
    (order.map(|i| e.eigenvalues[i].max(0.0)), order.map(|i| e.eigenvectors.column(i).into()))
}

fn perpendicular(v: &Vector3<f64>) -> nalgebra::Unit<Vector3<f64>> {
    let other = if v.x.abs() < 0.9 * v.norm() { Vector3::x() } else { Vector3::y() };
    nalgebra::Unit::new_normalize(v.cross(&other))
}

/// Standard uncertainty of translation (base origin) and rotation vector, from `variance` (m^2) of one coordinate. A
/// direction that the points leave open gets half a turn: nothing is known about it.
fn uncertainty<'a>(
    points: impl Iterator<Item = &'a Vector3<f64>>,
    frame: &Isometry3<f64>,
    variance: f64,
) -> ([f64; 3], [f64; 3]) {
    let mut normal = Matrix6::zeros();
    for p in points {
        let mut design = SMatrix::<f64, 3, 6>::zeros();
        design.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
        design.fixed_view_mut::<3, 3>(0, 3).copy_from(&-(frame.rotation * p).cross_matrix());
        normal += design.transpose() * design;
    }
    let eigen = normal.symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let mut covariance = Matrix6::zeros();
    for (value, v) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        let of_direction = if *value > OPEN * largest { variance / value } else { std::f64::consts::PI.powi(2) };
        covariance += v * v.transpose() * of_direction;
    }
    let sigma = |k: usize| covariance[(k, k)].max(0.0).sqrt();
    ([sigma(0), sigma(1), sigma(2)], [sigma(3), sigma(4), sigma(5)].map(|s| s.min(std::f64::consts::PI)))
}
