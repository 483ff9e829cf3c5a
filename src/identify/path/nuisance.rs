//! What is not lost motion: the tracker's frame, and rigid errors of the links; removed by projection.
//!
//! Columns, weighted by the square root of the rows of a bin: 3 translations and 3 rotations of the frame; per free joint the
//! 3 translations of the body after it, and for all but the last its 3 rotations. To first order these hold every rigid error of
//! geometry, zero positions and tool, and nothing that depends on direction. A joint that never reverses gets its own level
//! before and after its first movement; a joint that waits before it moves, one before. Per joint of each log speed and acceleration,
//! with priors ([`crate::identify::following`]): a lag of the servo, and between all joints a clock that is late. At one speed a lag looks
//! like a gap; what tells them apart is that a lag grows with the speed and a gap does not.
//!
//! Bins between a joint's first movement and the moment its gap is closed for the first time are left out: where it stood in
//! its gap at the start is unknown.
//!
//! Method: columns of unit norm, Gram-Schmidt with pivoting on the largest remainder; columns whose remainder falls below
//! [`DEPENDENT`] are combinations of others and are dropped.

use super::prepare::Binned;
use crate::identify::following::{ACCELERATION_S2, LAG_S};
use nalgebra::{Matrix6, Vector3, Vector6};

/// Norm of the remainder of a unit column that counts as none.
const DEPENDENT: f64 = 1e-6;

/// What removes the nuisances, one vector of three values per bin, and the weights of the bins: `v - sum q (q v)` is what they leave of
/// `v`. Orthonormal but for columns with a prior, whose vectors are shorter the less the log says against it.
#[derive(Debug, Clone)]
pub struct Basis {
    pub vectors: Vec<Vec<Vector3<f64>>>,
    /// Square root of the weight of a bin; 0 where it is left out.
    pub root: Vec<f64>,
}

impl Basis {
    pub fn rank(&self) -> usize {
        self.vectors.len()
    }

    pub fn used(&self) -> usize {
        self.root.iter().filter(|r| **r > 0.0).count()
    }
}

/// What is projected out beside the frame: rigid errors of the links; lags of the joints, which hold the clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct With {
    pub links: bool,
    pub lags: bool,
    /// Bins with corners of commands are used, where lags are not fitted: a lag is not that of the speed there.
    pub corners: bool,
}

/// Builds the basis. `pushed[j]` says per bin whether joint `j` has closed its gap.
pub fn basis(log: &Binned, pushed: &[Vec<bool>], scale: f64, with: With) -> Basis {
    let n = log.t_s.len();
    let mut root: Vec<f64> = log.rows.iter().map(|r| r.sqrt() * scale).collect();
    for (j, flags) in log.joints.iter().zip(pushed).filter(|(j, _)| j.reverses()) {
        let from = j.runs[0].bins.start;
        if let Some(closed) = flags.iter().position(|&f| f) {
            root[from.min(closed)..closed].fill(0.0);
        }
    }
    for (root, _) in root.iter_mut().zip(&log.corner).filter(|(_, corner)| **corner && !with.corners) {
        *root = 0.0;
    }
    let mut columns = frame(log);
    if with.links {
        columns.extend(links(log));
    }
    columns.extend(starts(log));
    let free = columns.len();
    let mut priors = Vec::new();
    for j in log.joints.iter().filter(|_| with.lags) {
        for (sigma, rate) in [(LAG_S, &j.speed), (ACCELERATION_S2, &j.acceleration)] {
            columns.push(j.jac.iter().zip(rate).map(|(c, v)| c * *v).collect());
            priors.push(1.0 / sigma);
        }
    }
    for c in &mut columns {
        for (v, r) in c.iter_mut().zip(&root) {
            *v *= *r;
        }
        c.resize(n + priors.len(), Vector3::zeros());
    }
    // a prior is one more value that was measured: zero for its column, with its standard deviation
    for (k, prior) in priors.iter().enumerate() {
        columns[free + k][n + k].x = *prior;
    }
    let mut vectors = orthonormal(columns);
    vectors.iter_mut().for_each(|v| v.truncate(n));
    Basis { vectors, root }
}

/// The tracker's frame.
fn frame(log: &Binned) -> Vec<Vec<Vector3<f64>>> {
    let n = log.t_s.len();
    let centre = log.want.iter().sum::<Vector3<f64>>() / n.max(1) as f64;
    let mut columns = Vec::new();
    for e in [Vector3::x(), Vector3::y(), Vector3::z()] {
        columns.push(vec![e; n]);
        columns.push(log.want.iter().map(|x| e.cross(&(x - centre))).collect());
    }
    columns
}

/// Where joints stood before they moved, and those that never reverse.
fn starts(log: &Binned) -> Vec<Vec<Vector3<f64>>> {
    let n = log.t_s.len();
    let mut columns = Vec::new();
    for j in &log.joints {
        let first = j.runs.first().map_or(n, |r| r.bins.start);
        let part = |from: usize, to: usize| {
            let inside = |i: usize| if (from..to).contains(&i) { 1.0 } else { 0.0 };
            j.jac.iter().enumerate().map(|(i, c)| c * inside(i)).collect()
        };
        if !j.reverses() {
            columns.push(part(0, n));
            columns.push(part(first, n));
        } else if first > 0 {
            columns.push(part(0, first));
        }
    }
    columns
}

/// Small rigid movements of the body after each joint.
fn links(log: &Binned) -> Vec<Vec<Vector3<f64>>> {
    let mut columns = Vec::new();
    for (k, j) in log.joints.iter().enumerate() {
        let Some(body) = &j.body else { continue };
        for e in [Vector3::x(), Vector3::y(), Vector3::z()] {
            columns.push(body.iter().map(|(r, _)| r * e).collect());
            if k + 1 < log.joints.len() {
                columns.push(body.iter().map(|(r, x)| r * e.cross(x)).collect());
            }
        }
    }
    columns
}

fn square(c: &[Vector3<f64>]) -> f64 {
    c.iter().map(|v| v.norm_squared()).sum()
}

pub fn dot(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x.dot(y)).sum()
}

/// Pivoted Gram-Schmidt.
fn orthonormal(mut columns: Vec<Vec<Vector3<f64>>>) -> Vec<Vec<Vector3<f64>>> {
    columns.retain_mut(|c| {
        let norm = square(c).sqrt();
        if norm > 0.0 && norm.is_finite() {
            c.iter_mut().for_each(|v| *v /= norm);
            true
        } else {
            false
        }
    });
    let mut norms: Vec<f64> = vec![1.0; columns.len()];
    let mut out = Vec::new();
    while let Some((k, &largest)) = norms.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)) {
        if largest.sqrt() < DEPENDENT {
            break;
        }
        let mut q = columns.swap_remove(k);
        norms.swap_remove(k);
        let norm = square(&q).sqrt();
        q.iter_mut().for_each(|v| *v /= norm);
        for (c, size) in columns.iter_mut().zip(&mut norms) {
            let share = dot(&q, c);
            *size = 0.0;
            for (v, u) in c.iter_mut().zip(&q) {
                *v -= u * share;
                *size += v.norm_squared();
            }
        }
        out.push(q);
    }
    out
}

/// Small rigid motion (rotation vector about `centre`, translation) that best explains `rest`, and its covariance for unit
/// noise; weights are squared roots. Directions that the path does not show stay zero.
pub fn rigid(
    points: &[Vector3<f64>],
    rest: &[Vector3<f64>],
    root: &[f64],
    centre: Vector3<f64>,
) -> (Vector6<f64>, Matrix6<f64>) {
    let length = points.iter().map(|p| (p - centre).norm()).fold(1e-6, f64::max);
    let mut h = Matrix6::zeros();
    let mut g = Vector6::zeros();
    for ((p, r), w) in points.iter().zip(rest).zip(root) {
        let v = (p - centre) / length;
        let w2 = w * w;
        // rows: d x = t + rot x v
        for (c, e) in [Vector3::x(), Vector3::y(), Vector3::z()].iter().enumerate() {
            let row_rot = v.cross(e);
            let row = Vector6::new(e.x, e.y, e.z, row_rot.x, row_rot.y, row_rot.z);
            h += row * row.transpose() * w2;
            g += row * (r[c] * w2);
        }
    }
    let eig = h.symmetric_eigen();
    let top = eig.eigenvalues.max();
    let mut inverse = Matrix6::zeros();
    for k in 0..6 {
        if eig.eigenvalues[k] > 1e-10 * top {
            let v = eig.eigenvectors.column(k);
            inverse += v * v.transpose() / eig.eigenvalues[k];
        }
    }
    let mut x = inverse * g;
    let mut cov = inverse;
    for k in 3..6 {
        x[k] /= length;
        for i in 0..6 {
            cov[(k, i)] /= length;
            cov[(i, k)] /= length;
        }
    }
    (x, cov)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dependent_columns_are_dropped_and_the_rest_is_orthonormal() {
        let c = |f: &dyn Fn(f64) -> f64| (0..200).map(|i| Vector3::new(f(f64::from(i)), 1.0, 0.0)).collect::<Vec<_>>();
        let a = c(&|x| x);
        let b = c(&|x| (x / 9.0).sin());
        let both = a.iter().zip(&b).map(|(x, y)| x * 2.0 - y).collect();
        let q = orthonormal(vec![a, both, b]);
        assert_eq!(q.len(), 2);
        assert!(dot(&q[0], &q[1]).abs() < 1e-12 && (square(&q[1]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_small_motion_is_found() {
        let points: Vec<Vector3<f64>> =
            (0..50).map(|i| Vector3::new(f64::from(i).sin(), f64::from(i).cos(), f64::from(i % 7) * 0.1)).collect();
        let centre = Vector3::new(0.1, 0.2, 0.3);
        let (t, w) = (Vector3::new(1e-4, -2e-4, 3e-5), Vector3::new(1e-5, 2e-5, -3e-5));
        let rest: Vec<Vector3<f64>> = points.iter().map(|p| t + w.cross(&(p - centre))).collect();
        let (x, _) = rigid(&points, &rest, &vec![1.0; 50], centre);
        assert!((x - Vector6::new(t.x, t.y, t.z, w.x, w.y, w.z)).abs().max() < 1e-12, "{x}");
    }
}
