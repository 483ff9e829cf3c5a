//! Sizes of a residual: root mean square and largest.

use super::forward::Problem;
use super::layout::Sensor;

/// rms per coordinate or reading of the residual of points; of all where none is measured.
pub fn rms(problem: &Problem, residual: &[f64]) -> f64 {
    let (mut sum, mut n) = (0.0, 0usize);
    let points = problem.groups.iter().any(|g| g.sensor.is_length());
    for g in problem.groups.iter().filter(|g| !points || g.sensor.is_length()) {
        sum += residual[g.range()].iter().map(|v| v * v).sum::<f64>();
        n += g.range().len();
    }
    (sum / n.max(1) as f64).sqrt()
}

/// Largest distance between measured and predicted points, m; of joint sensors rad. An orientation does not count.
pub fn largest(problem: &Problem, residual: &[f64]) -> f64 {
    let mut most = 0.0_f64;
    for g in problem.groups.iter().filter(|g| g.sensor != Sensor::Orientation) {
        let (v, n) = (&residual[g.range()], g.len());
        for b in 0..n {
            let squares: f64 = (0..g.dims).map(|c| v[c * n + b] * v[c * n + b]).sum();
            most = most.max(squares.sqrt());
        }
    }
    most
}
