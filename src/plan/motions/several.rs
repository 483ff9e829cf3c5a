//! Motions of several joints: all at once, sets of poses, the wrist, the return to one pose.

use super::*;
use crate::numerics::halton;
use crate::plan::path::{Envelope, Path};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// The three axes whose motion of the TCP is farthest from flat.
pub(super) fn three_best(envelope: &Envelope) -> Option<Vec<usize>> {
    let dof = envelope.robot.dof();
    let mut columns = vec![Vector3::zeros(); dof];
    envelope.robot.chain().position_and_jacobian(&envelope.pose, &mut columns);
    let mut best: Option<(f64, Vec<usize>)> = None;
    for i in 0..dof {
        for j in i + 1..dof {
            for k in j + 1..dof {
                let m = Matrix3::from_columns(&[columns[i], columns[j], columns[k]]);
                let least = m.singular_values().min();
                if least > 1e-3 && best.as_ref().is_none_or(|b| least > b.0 * 1.000_001) {
                    best = Some((least, vec![i, j, k]));
                }
            }
        }
    }
    best.map(|b| b.1)
}

/// Periods of the axes in [`all_joints`]: no two equal, none twice another within the first six.
const PERIODS: [f64; 8] = [2.0, 3.0, 5.0, 7.0, 8.0, 9.0, 11.0, 13.0];

/// All axes at once, each a sine with its own period through its window, forwards and then the same way back.
pub fn all_joints(envelope: &Envelope) -> Option<Vec<Vec<f64>>> {
    const UP: f64 = 0.06;
    let middle: Vec<f64> = envelope.window.iter().map(|[lo, hi]| 0.5 * (lo + hi)).collect();
    let mut path = Path::new(envelope);
    path.go(&middle, 1.0);
    let time_s = 0.48 * (envelope.duration_s - 2.0 * path.length_s() - 1.0);
    if time_s < 4.0 {
        return None;
    }
    let amplitude: Vec<f64> = (0..middle.len())
        .map(|a| {
            let omega = TAU * PERIODS[a % PERIODS.len()] / (time_s * (1.0 - UP));
            (0.5 * envelope.span(a)).min(0.8 * envelope.fast[a] / omega).min(0.5 * envelope.accel[a] / (omega * omega))
        })
        .collect();
    let n = (time_s / envelope.step_s) as usize;
    let row = |i: usize| -> Vec<f64> {
        let phi = TAU * warp(i as f64 / n as f64, UP);
        (0..middle.len()).map(|a| middle[a] + amplitude[a] * (PERIODS[a % PERIODS.len()] * phi).sin()).collect()
    };
    path.follow((1..=n).map(row));
    path.follow((0..n).rev().map(row));
    path.home();
    path.finish()
}

/// Poses that fill the window evenly, each with a dwell; as many as the time allows.
pub fn poses(envelope: &Envelope) -> Option<Vec<Vec<f64>>> {
    const BASES: [usize; 8] = [2, 3, 5, 7, 11, 13, 17, 19];
    let mut path = Path::new(envelope);
    let mut done: Option<Path> = None;
    for i in 1..200 {
        let to: Vec<f64> = envelope
            .window
            .iter()
            .enumerate()
            .map(|(a, [lo, hi])| lo + (hi - lo) * halton::member(i, BASES[a % 8]))
            .collect();
        path.go(&to, 1.0);
        path.stand(DWELL_S);
        let mut whole = path.clone();
        whole.home();
        if whole.left_s() < 0.0 {
            break;
        }
        done = Some(whole);
    }
    done?.finish()
}

/// The last three axes (or all there are) one after the other over wide angles, and together.
pub fn wrist(envelope: &Envelope) -> Option<Vec<Vec<f64>>> {
    let dof = envelope.robot.dof();
    let last: Vec<usize> = (dof.saturating_sub(3)..dof).collect();
    let each_s = envelope.duration_s / (last.len() as f64 + 1.0);
    Path::new(envelope).repeat(|p| {
        for &axis in &last {
            let [lo, hi] = stretch(envelope, axis, 1.0, 0.6 * each_s);
            for to in [hi, lo, envelope.pose[axis]] {
                p.axis_to(axis, to, 1.0);
                p.stand(0.3);
            }
        }
        let ends: Vec<(usize, [f64; 2])> = last.iter().map(|&a| (a, stretch(envelope, a, 1.0, 0.3 * each_s))).collect();
        for side in 0..2 {
            let mut q = envelope.pose.clone();
            for (k, (axis, end)) in ends.iter().enumerate() {
                q[*axis] = end[(side + k) % 2];
            }
            p.go(&q, 1.0);
        }
        p.home();
    })
}

/// Short moves of all joints away from one pose and back, with waits there, over the whole time.
pub fn back_to_one_pose(envelope: &Envelope) -> Option<Vec<Vec<f64>>> {
    let cycle_s = (envelope.duration_s / 6.0).clamp(4.0, 60.0);
    let away: Vec<f64> = (0..envelope.pose.len()).map(|a| stretch(envelope, a, 1.0, 0.2 * cycle_s)[1]).collect();
    Path::new(envelope).repeat(|p| {
        p.go(&away, 1.0);
        p.home();
        p.stand(0.6 * cycle_s);
    })
}

/// One short move, then rest.
pub fn stand_still(envelope: &Envelope) -> Option<Vec<Vec<f64>>> {
    let away: Vec<f64> =
        (0..envelope.pose.len()).map(|a| stretch(envelope, a, 1.0, 0.1 * envelope.duration_s)[1]).collect();
    let mut path = Path::new(envelope);
    path.go(&away, 1.0);
    path.home();
    path.stand((path.left_s() - envelope.step_s).max(envelope.step_s));
    path.finish()
}
