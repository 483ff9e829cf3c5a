//! Rotations about lines, and the two equations to which the inverse comes down.

use nalgebra::{Matrix3, Vector3};

/// A line in space: an axis of the arm at all joints zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Unit vector.
    pub direction: Vector3<f64>,
    pub point: Vector3<f64>,
}

/// Lines are the same within these, m and sine of the angle.
const SAME: f64 = 1e-9;

impl Line {
    /// Distance of a point, m.
    pub fn distance(&self, point: &Vector3<f64>) -> f64 {
        (point - self.point).cross(&self.direction).norm()
    }

    pub fn is_same(&self, other: &Line) -> bool {
        self.direction.cross(&other.direction).norm() < SAME && self.distance(&other.point) < SAME
    }

    /// The point midway between two lines where they pass closest; `None`: they are parallel, or further apart than `within`.
    pub fn meets(&self, other: &Line, within: f64) -> Option<Vector3<f64>> {
        let normal = self.direction.cross(&other.direction);
        let square = normal.norm_squared();
        if square < 1e-6 {
            return None;
        }
        let between = other.point - self.point;
        let s = between.cross(&other.direction).dot(&normal) / square;
        let t = between.cross(&self.direction).dot(&normal) / square;
        let (a, b) = (self.point + self.direction * s, other.point + other.direction * t);
        ((a - b).norm() < within).then_some((a + b) * 0.5)
    }

    /// A point turned about the line, rad.
    pub fn turned(&self, angle: f64, point: &Vector3<f64>) -> Vector3<f64> {
        self.point + turned(&self.direction, angle, &(point - self.point))
    }
}

/// A vector turned about a unit vector (Rodrigues).
pub fn turned(axis: &Vector3<f64>, angle: f64, v: &Vector3<f64>) -> Vector3<f64> {
    let (s, c) = angle.sin_cos();
    v * c + axis.cross(v) * s + axis * (axis.dot(v) * (1.0 - c))
}

/// The matrix of such a turn.
pub fn matrix(axis: &Vector3<f64>, angle: f64) -> Matrix3<f64> {
    let column = |v: Vector3<f64>| turned(axis, angle, &v);
    Matrix3::from_columns(&[column(Vector3::x()), column(Vector3::y()), column(Vector3::z())])
}

/// The angle about `axis` that turns the part of `a` across the axis onto that of `b`; `None`: one of them lies on the axis.
pub fn angle(axis: &Vector3<f64>, a: &Vector3<f64>, b: &Vector3<f64>) -> Option<f64> {
    let a = a - axis * axis.dot(a);
    let b = b - axis * axis.dot(b);
    (a.norm() > ON_AXIS && b.norm() > ON_AXIS).then(|| axis.dot(&a.cross(&b)).atan2(a.dot(&b)))
}

/// Shorter parts across an axis count as on it.
const ON_AXIS: f64 = 1e-9;
/// How far beyond its largest value a sine may be: rounding, at the edge of the reach.
const EDGE: f64 = 1e-9;

/// What solves an equation in one angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Angles {
    None,
    /// Twice the same at the edge of the reach.
    Two(f64, f64),
    Any,
}

impl Angles {
    /// The angles; `free` where any solves it.
    pub fn list(self, free: f64) -> Vec<f64> {
        match self {
            Self::None => Vec::new(),
            Self::Two(a, b) if a == b => vec![a],
            Self::Two(a, b) => vec![a, b],
            Self::Any => vec![free],
        }
    }
}

/// Angles `x` with `normal . turned(axis, x, v) = height`.
pub fn to_height(axis: &Vector3<f64>, v: &Vector3<f64>, normal: &Vector3<f64>, height: f64) -> Angles {
    let along = axis.dot(normal) * axis.dot(v);
    let (a, b) = (normal.dot(v) - along, normal.dot(&axis.cross(v)));
    let (size, wanted) = (a.hypot(b), height - along);
    let scale = v.norm().max(height.abs()).max(ON_AXIS);
    if size < ON_AXIS * scale {
        return if wanted.abs() < 1e-6 * scale { Angles::Any } else { Angles::None };
    }
    let cosine = wanted / size;
    if cosine.abs() > 1.0 + EDGE {
        return Angles::None;
    }
    let (middle, half) = (b.atan2(a), cosine.clamp(-1.0, 1.0).acos());
    Angles::Two(middle + half, middle - half)
}
