//! Where the centre of a ballbar is looked for first.

use crate::log::Log;
use crate::robot::Robot;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Scatter across a path over that along it below which it is no arc, and distance of a centre from the middle of its path, in sizes
/// of the path, beyond which it is none.
const STRAIGHT: f64 = 1e-6;
const MOST_OFF: f64 = 2.0;

/// Where the centre of a ballbar is looked for first: the centre of the circle that fits the commanded TCPs best; of a path that
/// is no arc the middle of what it encloses.
pub fn centre(robot: &Robot, log: &Log) -> Vector3<f64> {
    let mut q = vec![0.0; robot.dof()];
    let points: Vec<Vector3<f64>> = (0..log.len())
        .map(|row| {
            log.command_into(row, &mut q);
            robot.tcp_m(&q)
        })
        .collect();
    let [lo, hi] = [f64::min as fn(f64, f64) -> f64, f64::max].map(|pick| {
        let start = points.first().copied().unwrap_or_else(Vector3::zeros);
        points.iter().fold(start, |a, p| a.zip_map(p, pick))
    });
    let middle = 0.5 * (lo + hi);
    circle(&points).filter(|c| (c - middle).norm() < MOST_OFF * (hi - lo).norm()).unwrap_or(middle)
}

/// Centre of the circle through points in a plane (Kasa 1976): `|p|^2 = 2 c p + k` in the two principal directions.
fn circle(points: &[Vector3<f64>]) -> Option<Vector3<f64>> {
    let mean = points.iter().sum::<Vector3<f64>>() / points.len().max(1) as f64;
    let scatter = points.iter().map(|p| (p - mean) * (p - mean).transpose()).sum::<Matrix3<f64>>();
    let eigen = SymmetricEigen::new(scatter);
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let [u, v] = [order[0], order[1]].map(|k| eigen.eigenvectors.column(k).into_owned());
    if eigen.eigenvalues[order[1]] <= STRAIGHT * eigen.eigenvalues[order[0]] {
        return None;
    }
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for p in points {
        let (a, b) = ((p - mean).dot(&u), (p - mean).dot(&v));
        let row = Vector3::new(2.0 * a, 2.0 * b, 1.0);
        normal += row * row.transpose();
        right += row * (a * a + b * b);
    }
    let c = normal.cholesky()?.solve(&right);
    Some(mean + u * c.x + v * c.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_centre_of_an_arc_is_that_of_its_circle() {
        let centre = Vector3::new(1.2, -0.4, 0.7);
        let (u, v) = (Vector3::new(0.6, 0.8, 0.0), Vector3::new(0.0, 0.0, 1.0));
        let arc = |degrees: u32| -> Vec<Vector3<f64>> {
            let angles = (0..=degrees).map(|a| f64::from(a).to_radians());
            angles.map(|a| centre + 0.15 * (u * a.cos() + v * a.sin())).collect()
        };
        for degrees in [360, 220, 90] {
            assert!((circle(&arc(degrees)).unwrap() - centre).norm() < 1e-9, "{degrees} deg");
        }
        let line: Vec<Vector3<f64>> = (0..100).map(|i| centre + u * f64::from(i)).collect();
        assert!(circle(&line).is_none());
    }
}
