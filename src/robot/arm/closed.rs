//! The closed forms: turns about the six lines for a pose.

use super::lines::{angle, matrix, to_height, turned};
use super::{Arm, Form, moved};
use nalgebra::{Isometry3, Matrix3, Vector3, Vector6};

impl Arm {
    /// Turns about the lines that reach a pose, before any polishing; free angles are those of `near`.
    pub(super) fn closed(&self, target: &Isometry3<f64>, near: &Vector6<f64>) -> Vec<Vector6<f64>> {
        // the product of the six rotations
        let product = target * self.zero.inverse();
        match self.form {
            Form::Spherical(centre) => self.spherical(&product, &centre, near),
            Form::Parallel(centre) => self.parallel(&product, &centre, near),
            Form::General => Vec::new(),
        }
    }

    /// Joint 1: brings the point `there` back into the plane across axis 2 in which `centre` lies at zero.
    fn first(&self, there: &Vector3<f64>, centre: &Vector3<f64>, near: f64) -> Vec<f64> {
        let [one, two, ..] = &self.lines;
        let v = there - one.point;
        let height = two.direction.dot(&(centre - one.point));
        // a turn back is a turn by the opposite angle
        to_height(&one.direction, &v, &two.direction, height).list(-near).into_iter().map(|x| -x).collect()
    }

    /// Turns about axes 2 and 3 that bring the point `from` (moved by both) to `to`.
    fn triangle(&self, from: &Vector3<f64>, to: &Vector3<f64>) -> Vec<(f64, f64)> {
        let [_, two, three, ..] = &self.lines;
        let n = two.direction;
        let across = |v: Vector3<f64>| v - n * n.dot(&v);
        let (upper, fore) = (across(three.point - two.point), across(from - three.point));
        let reach = across(to - two.point);
        let (a, b, d) = (upper.norm(), fore.norm(), reach.norm());
        if a < 1e-6 || b < 1e-6 {
            return Vec::new();
        }
        let cosine = (d * d - a * a - b * b) / (2.0 * a * b);
        if cosine.abs() > 1.0 + 1e-9 {
            return Vec::new();
        }
        let bend = cosine.clamp(-1.0, 1.0).acos();
        let at_zero = angle(&n, &upper, &fore).unwrap_or(0.0);
        let sense = n.dot(&three.direction).signum();
        let bends = if bend == 0.0 { vec![0.0] } else { vec![bend, -bend] };
        let solve = |bend: f64| {
            let third = bend - at_zero;
            let arm = upper + turned(&n, third, &fore);
            (angle(&n, &arm, &reach).unwrap_or(0.0), sense * third)
        };
        bends.into_iter().map(solve).collect()
    }

    fn spherical(&self, product: &Isometry3<f64>, centre: &Vector3<f64>, near: &Vector6<f64>) -> Vec<Vector6<f64>> {
        let [one, two, three, four, five, six] = &self.lines;
        let there = moved(product, centre);
        let whole = *product.rotation.to_rotation_matrix().matrix();
        let mut found = Vec::with_capacity(8);
        for x1 in self.first(&there, centre, near[0]) {
            for (x2, x3) in self.triangle(centre, &one.turned(-x1, &there)) {
                let arm = matrix(&one.direction, x1) * matrix(&two.direction, x2) * matrix(&three.direction, x3);
                let axes = [four.direction, five.direction, six.direction];
                for [x4, x5, x6] in wrist(&axes, &(arm.transpose() * whole), near[3]) {
                    found.push(Vector6::new(x1, x2, x3, x4, x5, x6));
                }
            }
        }
        found
    }

    fn parallel(&self, product: &Isometry3<f64>, centre: &Vector3<f64>, near: &Vector6<f64>) -> Vec<Vector6<f64>> {
        let [one, two, three, four, five, six] = &self.lines;
        let n = two.direction;
        let (sense3, sense4) = (n.dot(&three.direction).signum(), n.dot(&four.direction).signum());
        let there = moved(product, centre);
        let whole = *product.rotation.to_rotation_matrix().matrix();
        let sum_near = near[1] + sense3 * near[2] + sense4 * near[3];
        let mut found = Vec::with_capacity(8);
        for x1 in self.first(&there, centre, near[0]) {
            let here = one.turned(-x1, &there);
            let rest = matrix(&one.direction, x1).transpose() * whole;
            for [sum, x5, x6] in wrist(&[n, five.direction, six.direction], &rest, sum_near) {
                let to = here - turned(&n, sum, &(centre - four.point));
                for (x2, x3) in self.triangle(&four.point, &to) {
                    let x4 = sense4 * (sum - x2 - sense3 * x3);
                    found.push(Vector6::new(x1, x2, x3, x4, x5, x6));
                }
            }
        }
        found
    }
}

/// Turns about three axes, in this order from the base, that make a rotation.
fn wrist(axes: &[Vector3<f64>; 3], rotation: &Matrix3<f64>, near_first: f64) -> Vec<[f64; 3]> {
    let [a, b, c] = axes;
    let last = rotation * c;
    // a vector across the last axis shows its turn
    let across = if c.x.abs() < 0.7 { c.cross(&Vector3::x()) } else { c.cross(&Vector3::y()) };
    let seconds = to_height(b, c, a, a.dot(&last)).list(0.0);
    let solve = |second: f64| {
        let first = angle(a, &turned(b, second, c), &last).unwrap_or(near_first);
        let rest = (matrix(a, first) * matrix(b, second)).transpose() * rotation;
        [first, second, angle(c, &across, &(rest * across)).unwrap_or(0.0)]
    };
    seconds.into_iter().map(solve).collect()
}
