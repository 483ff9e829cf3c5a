//! What a tracker in an unknown frame says about each prismatic joint.
//!
//! With prismatic joints alone the TCP moves on straight lines: `p = p_0 + sum d_j y_j`. The directions `d_j` are fitted by
//! least squares to what the joints do (at first their commands, then their commands less the gaps found so far), in any
//! frame and without assuming that joints are square to each other. A joint's position is the part of `p` along its own
//! direction, with the others' parts taken out. One coordinate is enough for a joint that moves along it.
//!
//! How it fails: a joint that moves only together with another one cannot be distinguished from it; where revolute joints turn, lines
//! are no lines. Both get no position, and a reason.

use super::series::OutputPositions;
use crate::gaps::note::screw::Unseen;
use crate::log::Log;
use crate::numerics::robust::{SIGMA_PER_MAD, median};
use crate::robot::{JointKind, Robot};
use nalgebra::{DMatrix, DVector};

/// A joint moves the coordinates by less than this part of its way: they do not see it.
const SEEN: f64 = 0.3;
/// Turn of a revolute joint (rad) that bends no line.
const STILL_RAD: f64 = 1e-5;
/// Eigenvalue of the joints' correlation below which two move together only.
const TOGETHER: f64 = 1e-6;
const GROSS: f64 = 8.0;

/// The coordinates that the log has, m.
pub fn coordinates(log: &Log) -> Vec<Vec<Option<f64>>> {
    if log.tcp_m.is_empty() {
        return log.lone_m.iter().flatten().cloned().collect();
    }
    (0..3).map(|c| log.tcp_m.iter().map(|p| p.map(|p| p[c])).collect()).collect()
}

/// Positions of the moving prismatic joints, m, up to a constant each; `motion[axis]` is what the joints do as far as is known.
pub fn positions(robot: &Robot, log: &Log, motion: &[Vec<f64>]) -> Vec<OutputPositions> {
    let none = |why: Unseen| -> Vec<OutputPositions> { vec![Err(why); robot.dof()] };
    let seen = coordinates(log);
    if seen.is_empty() {
        return none(Unseen::NoCoordinates);
    }
    let kind = |axis: usize| robot.axis(axis).kind;
    let joints: Vec<String> = (0..robot.dof())
        .filter(|&a| kind(a) == JointKind::Revolute && log.travel(a) > STILL_RAD)
        .map(|a| robot.axis(a).name.clone())
        .collect();
    if !joints.is_empty() {
        return none(Unseen::Turns { joints });
    }
    let axes: Vec<usize> = log.moving_axes().into_iter().filter(|&a| kind(a) == JointKind::Prismatic).collect();
    let mut rows: Vec<usize> = (0..log.len()).filter(|&i| seen.iter().all(|c| c[i].is_some())).collect();
    let mut lines = None;
    for _ in 0..2 {
        match directions(&rows, &axes, motion, &seen) {
            Some(found) => lines = Some(found),
            None => return none(Unseen::Together),
        }
        let Some(found) = &lines else { continue };
        let off: Vec<f64> = rows.iter().map(|&i| found.residual(i, &axes, motion, &seen, None).norm()).collect();
        let limit = GROSS * SIGMA_PER_MAD * median(&off) + 1e-7;
        let mut off = off.iter();
        rows.retain(|_| off.next().is_some_and(|o| *o <= limit));
    }
    let Some(found) = lines else { return none(Unseen::Together) };
    let mut out = none(Unseen::StandsStill);
    for (j, &axis) in axes.iter().enumerate() {
        let way = found.along.column(j + 1).norm();
        if way.is_nan() || way < SEEN {
            out[axis] = Err(Unseen::HardlyMoves);
            continue;
        }
        let direction = found.along.column(j + 1) / way;
        let at = |i: usize| -> Option<f64> {
            seen.iter().all(|c| c[i].is_some()).then(|| {
                let rest = found.residual(i, &axes, motion, &seen, Some(j));
                rest.dot(&direction)
            })
        };
        let raw: Vec<Option<f64>> = (0..log.len()).map(at).collect();
        // the zero is free: let it be the command's on average
        let (sum, n) = raw.iter().zip(&log.cmd[axis]).fold((0.0, 0.0), |(s, n), (w, c)| match w {
            Some(w) => (s + w - c, n + 1.0),
            None => (s, n),
        });
        out[axis] = Ok(raw.into_iter().map(|w| w.map(|w| w - sum / f64::max(n, 1.0))).collect());
    }
    out
}

/// Constant and direction of each moving joint, a column each.
struct Lines {
    along: DMatrix<f64>,
}

impl Lines {
    /// Measured minus computed point of a row, without the part of joint `own`.
    fn residual(
        &self,
        row: usize,
        axes: &[usize],
        motion: &[Vec<f64>],
        seen: &[Vec<Option<f64>>],
        own: Option<usize>,
    ) -> DVector<f64> {
        let mut rest = DVector::from_fn(seen.len(), |c, _| seen[c][row].unwrap_or(f64::NAN)) - self.along.column(0);
        for (j, &axis) in axes.iter().enumerate().filter(|(j, _)| own != Some(*j)) {
            rest -= self.along.column(j + 1) * motion[axis][row];
        }
        rest
    }
}

fn directions(rows: &[usize], axes: &[usize], motion: &[Vec<f64>], seen: &[Vec<Option<f64>>]) -> Option<Lines> {
    let n = axes.len() + 1;
    if rows.len() < 4 * n {
        return None;
    }
    let count = rows.len() as f64;
    let mean: Vec<f64> = axes.iter().map(|&a| rows.iter().map(|&i| motion[a][i]).sum::<f64>() / count).collect();
    let size: Vec<f64> = (axes.iter().zip(&mean))
        .map(|(&a, m)| (rows.iter().map(|&i| (motion[a][i] - m).powi(2)).sum::<f64>() / count).sqrt())
        .collect();
    let design =
        |row: usize, k: usize| if k == 0 { 1.0 } else { (motion[axes[k - 1]][row] - mean[k - 1]) / size[k - 1] };
    let mut matrix = DMatrix::zeros(n, n);
    let mut right = DMatrix::zeros(n, seen.len());
    for &i in rows {
        let d = DVector::from_fn(n, |k, _| design(i, k));
        matrix += &d * d.transpose() / count;
        for (c, column) in seen.iter().enumerate() {
            let v = column[i]? / count;
            right.column_mut(c).axpy(v, &d, 1.0);
        }
    }
    let least = matrix.clone().symmetric_eigenvalues().min();
    if least.is_nan() || least <= TOGETHER {
        return None;
    }
    let found = matrix.cholesky()?.solve(&right).transpose();
    let mut along = found.clone();
    for k in 1..n {
        along.set_column(k, &(found.column(k) / size[k - 1]));
        let back = found.column(k) * (mean[k - 1] / size[k - 1]);
        let constant = along.column(0) - back;
        along.set_column(0, &constant);
    }
    Some(Lines { along })
}
