//! Ways between targets: a straight TCP path followed for its joints, and where joints turn on it.
//!
//! Method: the inverse next to the joints before, along poses between start and end (position straight, rotation by the
//! shortest turn): in closed form where the arm has one, else damped. It follows the branch on which the robot stands. Where a pose is not reached within [`REACHED_M`] and
//! [`REACHED_RAD`], or the joints leap, nothing is claimed.

use super::poses::Tooled;
use crate::program::script::Way;
use crate::robot::arm::{Form, isometry};
use crate::robot::{InverseOptions, Pose, Target};
use nalgebra::Isometry3;
use std::sync::Arc;

/// A pose counts as reached within these.
const REACHED_M: f64 = 1e-7;
const REACHED_RAD: f64 = 1e-6;
/// Parts of a way at least, and the TCP way that one part covers at most.
const PARTS: usize = 16;
const PART_M: f64 = 0.02;
const MOST_PARTS: usize = 512;
/// Turning points closer than this share of a way are one.
const APART: f64 = 2e-3;
/// A joint that moves further than this in one part has changed its branch, rad or m.
const LEAP: f64 = 0.5;

/// Why a target has no joints.
pub const NOT_REACHED: &str = "a Cartesian target that the robot's kinematics do not reach";

/// Joints at the end of the straight way from `from` to a pose of the world; `turned`: the orientation counts.
pub fn follow(tooled: &Arc<Tooled>, from: &[f64], end: &Isometry3<f64>, turned: bool) -> Option<Vec<f64>> {
    let start = isometry(&tooled.robot.forward(from));
    along(tooled, &start, end, turned, from)?.pop()
}

/// A straight TCP path: its two poses, and joints along it as first guesses.
#[derive(Debug, Clone)]
pub struct Line {
    tooled: Arc<Tooled>,
    start: Isometry3<f64>,
    end: Isometry3<f64>,
    /// Position and orientation count; else the position alone.
    pose: bool,
    samples: Vec<Vec<f64>>,
}

impl Line {
    /// The path between two joint vectors, both ends included; `None` where it cannot be followed.
    pub fn between(tooled: &Arc<Tooled>, from: &[f64], to: &[f64]) -> Option<Self> {
        let robot = &tooled.robot;
        let (start, end) = (isometry(&robot.forward(from)), isometry(&robot.forward(to)));
        let pose = robot.dof() >= 6;
        let mut samples = along(tooled, &start, &end, pose, from)?;
        // the branch must be the one on which the target stands
        let last = samples.last_mut()?;
        let off = last.iter().zip(to).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        if off > 1e-4 {
            return None;
        }
        last.clear();
        last.extend_from_slice(to);
        Some(Self { tooled: tooled.clone(), start, end, pose, samples })
    }

    /// Joints at a share of the path, solved there: between the samples a line through joints is none of the TCP.
    pub fn at(&self, share: f64) -> Option<Vec<f64>> {
        let guess = at_share(&self.samples, share)?;
        if share <= 0.0 || share >= 1.0 {
            return Some(guess);
        }
        solved(&self.tooled, &self.start, &self.end, self.pose, share, &guess)
    }

    /// Shares at which joints turn by more than `deadband` (per axis, rad or m), and the joints there. Turns closer than
    /// [`APART`] are one.
    pub fn turning_points(&self, deadband: &[f64]) -> Vec<Way> {
        let mut gears = self.samples.clone();
        gears.iter_mut().for_each(|q| self.tooled.robot.to_gears(q));
        let mut shares = turning_shares(&gears, deadband);
        shares.sort_by(f64::total_cmp);
        shares.dedup_by(|b, a| *b - *a < APART);
        shares.into_iter().filter_map(|share| Some(Way { share, q: self.at(share)? })).collect()
    }
}

fn along(
    tooled: &Tooled,
    start: &Isometry3<f64>,
    end: &Isometry3<f64>,
    pose: bool,
    from: &[f64],
) -> Option<Vec<Vec<f64>>> {
    let length = (end.translation.vector - start.translation.vector).norm();
    let parts = ((length / PART_M).ceil() as usize).clamp(PARTS, MOST_PARTS);
    let mut line = vec![from.to_vec()];
    for k in 1..=parts {
        let next = solved(tooled, start, end, pose, k as f64 / parts as f64, line.last()?)?;
        line.push(next);
    }
    Some(line)
}

/// Joints at a share of the way between two poses, from a guess near them.
fn solved(
    tooled: &Tooled,
    start: &Isometry3<f64>,
    end: &Isometry3<f64>,
    pose: bool,
    share: f64,
    guess: &[f64],
) -> Option<Vec<f64>> {
    let rotation = start.rotation.try_slerp(&end.rotation, share, 1e-12).unwrap_or(end.rotation);
    let position = start.translation.vector.lerp(&end.translation.vector, share);
    let leaps = |q: &[f64]| q.iter().zip(guess).any(|(a, b)| (a - b).abs() > LEAP);
    if let Some(arm) = tooled.arm.as_ref().filter(|a| pose && a.form() != Form::General) {
        let wanted = Pose { position, rotation: rotation.to_rotation_matrix() };
        let far = |q: &[f64]| q.iter().zip(guess).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let all = arm.solutions(&tooled.robot, &wanted, guess);
        return all.into_iter().min_by(|a, b| far(a).total_cmp(&far(b))).filter(|q| !leaps(q));
    }
    let options = InverseOptions {
        target_error_m: REACHED_M * 1e-4,
        target_error_rad: REACHED_RAD * 1e-4,
        ..InverseOptions::default()
    };
    let target = if pose {
        Target::Pose(Pose { position, rotation: rotation.to_rotation_matrix() })
    } else {
        Target::Position(position)
    };
    let found = tooled.robot.inverse(&target, guess, &options);
    (found.error_m <= REACHED_M && found.error_rad <= REACHED_RAD && !leaps(&found.q)).then_some(found.q)
}

/// Shares at which joints turn on a sampled way, by parabolas through its samples.
fn turning_shares(line: &[Vec<f64>], deadband: &[f64]) -> Vec<f64> {
    let Some(first) = line.first() else { return Vec::new() };
    let parts = (line.len() - 1).max(1) as f64;
    let mut found = Vec::new();
    for axis in 0..first.len() {
        let p = |k: usize| line[k][axis];
        let band = deadband.get(axis).copied().unwrap_or(0.0);
        let [lo, hi] = line.iter().fold([f64::MAX, f64::MIN], |[lo, hi], q| [lo.min(q[axis]), hi.max(q[axis])]);
        for k in 1..line.len().saturating_sub(1) {
            let (before, behind) = (p(k) - p(k - 1), p(k + 1) - p(k));
            if before * behind >= 0.0 {
                continue;
            }
            let ends = [p(0), p(line.len() - 1)];
            let height = if before > 0.0 { hi - ends[0].max(ends[1]) } else { ends[0].min(ends[1]) - lo };
            if height > band {
                found.push((k as f64 + 0.5 * (before + behind) / (before - behind)) / parts);
            }
        }
    }
    found
}

/// Joints at a share of a sampled way, linear between its samples.
fn at_share(line: &[Vec<f64>], share: f64) -> Option<Vec<f64>> {
    let last = line.len().checked_sub(1)?;
    let at = (share.clamp(0.0, 1.0) * last as f64).min(last as f64);
    let low = (at.floor() as usize).min(last.saturating_sub(1));
    let s = at - low as f64;
    let (a, b) = (line.get(low)?, line.get((low + 1).min(last))?);
    Some(a.iter().zip(b).map(|(x, y)| x + s * (y - x)).collect())
}
