//! From a log to bins: axes that move, runs, a first registration, outliers, averages.
//!
//! The first registration fits all rows to the commanded path (Kabsch 1976). It is biased by the gaps (a lag on a path that goes
//! round looks like a turned frame) and only a start: the fit estimates frame and gaps together.
//!
//! Outliers are found per coordinate in what the first registration leaves, twice: single rows off the median of 7 by
//! [`SPIKE_SIGMA`], bursts off the median over +-[`BURST_S`] by [`BURST_SIGMA`]; the burst test is off around reversals, where the
//! error itself moves fast. Sigma is that of the differences of neighbouring rows.

use super::bins;
use super::chain::{Run, runs};
use super::medians::{burst, median_of_7};
use crate::effects::Track;
use crate::error::{Error, Place, Result, counted};
use crate::identify::following::rates;
use crate::identify::machine::corners;
use crate::log::Log;
use crate::numerics::parallel::{self, ParMap};
use crate::numerics::rigid;
use crate::numerics::robust::{SIGMA_PER_MAD, median_of};
use crate::robot::Robot;
use nalgebra::{Isometry3, Matrix3, Vector3};

/// Movements of the command up to this many last digits of its column are number noise.
const QUANTA: f64 = 10.0;
/// Least deadband, rad or m.
const LEAST_DEADBAND: f64 = 1e-10;
/// An axis moves if its travel exceeds this, rad or m (1e-3 deg; 1e-3 mm).
const MOVES: [f64; 2] = [1.7453e-5, 1e-6];
const SPIKE_SIGMA: f64 = 6.0;
const BURST_SIGMA: f64 = 8.0;
const BURST_S: f64 = 0.6;
/// No burst test from this long before to this long after a reversal, s.
const QUIET_S: [f64; 2] = [0.1, 1.2];

/// A joint of a log: its axis, its runs, its command and Jacobian column at the bins.
#[derive(Debug, Clone)]
pub struct FreeJoint {
    pub axis: usize,
    pub runs: Vec<Run>,
    pub p: Vec<f64>,
    /// Speed and acceleration of the command at the bins, rad or m over s.
    pub speed: Vec<f64>,
    pub acceleration: Vec<f64>,
    /// Derivative of the TCP by the joint, m/rad or m/m.
    pub jac: Vec<Vector3<f64>>,
    /// Rotation of the body after the joint and the TCP in that body, per bin; `None` where a coupling forbids it.
    pub body: Option<Vec<(Matrix3<f64>, Vector3<f64>)>>,
}

impl FreeJoint {
    pub fn reverses(&self) -> bool {
        self.runs.len() > 1
    }

    /// Largest effect of the joint on the TCP, m/rad or m/m.
    pub fn lever_m(&self) -> f64 {
        self.jac.iter().map(Vector3::norm).fold(0.0, f64::max)
    }
}

/// A log as bins.
#[derive(Debug, Clone)]
pub struct Binned {
    pub name: String,
    pub joints: Vec<FreeJoint>,
    pub t_s: Vec<f64>,
    /// Good rows in each bin.
    pub rows: Vec<f64>,
    /// Measured TCP, tracker frame, and commanded TCP, world, m.
    pub xyz: Vec<Vector3<f64>>,
    pub want: Vec<Vector3<f64>>,
    /// Tracker frame -> world, as known so far.
    pub frame: Isometry3<f64>,
    pub good: usize,
    pub outliers: usize,
    pub lost: usize,
    /// Bins at which a command changes its speed at once: what a lag does there is not that of the speed.
    pub corner: Vec<bool>,
    /// Scatter of the rows about their bins: sum of squares over all coordinates, m^2.
    pub within_m2: f64,
    /// Noise of a coordinate of a row, from neighbouring rows, m.
    pub sigma_m: f64,
    /// Median TCP speed of the commanded path where it moves, m/s.
    pub speed_m_s: Option<f64>,
}

impl Binned {
    /// Adds the mean of `rows` as a bin, unless there is none; its means of the columns `of`.
    fn add_bin(
        &mut self,
        log: &Log,
        want: &[Vector3<f64>],
        of: &[&[f64]],
        rows: &mut dyn Iterator<Item = usize>,
    ) -> Option<Vec<f64>> {
        let (mut n, mut t, mut xyz, mut cmd) = (0.0, 0.0, Vector3::zeros(), Vector3::zeros());
        let mut q = vec![0.0; of.len()];
        let (mut rest, mut rest2) = (Vector3::zeros(), 0.0);
        let rotation = self.frame.rotation.to_rotation_matrix();
        for i in rows {
            let Some(x) = log.tcp_m[i] else { continue };
            n += 1.0;
            t += log.t_s[i];
            xyz += x;
            cmd += want[i];
            let r = rotation * x + self.frame.translation.vector - want[i];
            rest += r;
            rest2 += r.norm_squared();
            for (s, c) in q.iter_mut().zip(of) {
                *s += c[i];
            }
        }
        if n == 0.0 {
            return None;
        }
        self.t_s.push(t / n);
        self.rows.push(n);
        self.xyz.push(xyz / n);
        self.want.push(cmd / n);
        self.within_m2 += (rest2 - rest.norm_squared() / n).max(0.0);
        q.iter_mut().for_each(|v| *v /= n);
        Some(q)
    }
}

/// Axes of a log that move.
pub fn moving(log: &Log, robot: &Robot) -> Vec<usize> {
    log.moving(robot, MOVES)
}

/// Deadband of an axis of a log, rad or m.
pub fn deadband(log: &Log, axis: usize, robot: &Robot) -> f64 {
    let digits = log.cmd_decimals.get(axis).copied().unwrap_or(6);
    (QUANTA * 10f64.powi(-i32::from(digits)) * robot.axis(axis).kind.si_per_user_unit()).max(LEAST_DEADBAND)
}

/// Bins of `log` for the axes `free`.
pub fn prepare(log: &Log, robot: &Robot, free: &[usize]) -> Result<Binned> {
    let valid = measured(log)?;
    let want = forward(log, robot);
    let tracks: Vec<(usize, Vec<Run>)> = free
        .iter()
        .map(|&a| (a, runs(&Track::new(&log.t_s, &log.cmd[a], deadband(log, a, robot)))))
        .filter(|(_, r)| !r.is_empty())
        .collect();
    let (bad, frame, sigma_m) = outliers(log, &want, &valid, &tracks);
    let outliers = bad.iter().filter(|b| **b).count();
    let good: Vec<bool> = (0..log.len()).map(|i| log.tcp_m[i].is_some() && !bad[i]).collect();
    let cuts: Vec<usize> = tracks.iter().flat_map(|(_, r)| r.iter().map(|x| x.index + 1)).collect();
    let starts = bins::starts(log.len(), &cuts);
    let mut out = Binned {
        name: log.name.clone(),
        joints: Vec::new(),
        t_s: Vec::new(),
        rows: Vec::new(),
        xyz: Vec::new(),
        want: Vec::new(),
        frame,
        good: valid.len() - outliers,
        outliers,
        lost: log.len() - valid.len(),
        corner: Vec::new(),
        within_m2: 0.0,
        sigma_m,
        speed_m_s: speed(log, &want),
    };
    let moves: Vec<_> = tracks.iter().map(|(a, _)| rates(&log.t_s, &log.cmd[*a])).collect();
    // commands of all axes, then speed and acceleration of each that moves
    let columns: Vec<&[f64]> =
        log.cmd.iter().chain(moves.iter().flat_map(|(v, a)| [v, a])).map(Vec::as_slice).collect();
    let mut kept: Vec<(usize, usize)> = Vec::new();
    let mut q_mean: Vec<Vec<f64>> = Vec::new();
    for (k, &from) in starts.iter().enumerate() {
        let to = starts.get(k + 1).copied().unwrap_or(log.len());
        if let Some(q) = out.add_bin(log, &want, &columns, &mut (from..to).filter(|&i| good[i])) {
            kept.push((from, to));
            q_mean.push(q);
        }
    }
    out.joints = tracks
        .into_iter()
        .enumerate()
        .map(|(k, (axis, runs))| joint(axis, runs, &kept, (&q_mean, log.cmd.len() + 2 * k), &out.want, robot))
        .collect();
    out.corner = corners_of(log, &out.joints, &kept);
    Ok(out)
}

/// Rows with a measured TCP; refuses a log without enough of them.
fn measured(log: &Log) -> Result<Vec<usize>> {
    let refuse = |found: &str, expected: &str| Err(Error::bad(Place::file(&log.name), found, expected));
    if log.poses {
        return refuse(
            "settled poses (no column `t_s`)",
            "samples of a motion with times `t_s` (use `identify static` for dwells)",
        );
    }
    if log.tcp_m.is_empty() {
        return refuse("no columns `x_mm,y_mm,z_mm`", "the measured TCP of each row");
    }
    let valid: Vec<usize> = (0..log.len()).filter(|&i| log.tcp_m[i].is_some()).collect();
    if valid.len() < 100 {
        return refuse(&format!("{} with a measured TCP", counted(valid.len(), "row")), "at least 100");
    }
    Ok(valid)
}

/// Bins with corners of commands.
fn corners_of(log: &Log, joints: &[FreeJoint], bins: &[(usize, usize)]) -> Vec<bool> {
    let commands: Vec<(&[f64], f64)> = joints.iter().map(|j| (log.cmd[j.axis].as_slice(), j.lever_m())).collect();
    corners::left_out(&log.t_s, &commands, bins, &|b| joints.iter().any(|j| j.speed[b] != 0.0)).0
}

/// Runs with their bins, command, speeds, Jacobian column and body of one joint; `means` has the commands of all axes per bin, and from
/// column `rates` speed and acceleration of this one.
fn joint(
    axis: usize,
    mut runs: Vec<Run>,
    bins: &[(usize, usize)],
    (means, rates): (&[Vec<f64>], usize),
    want: &[Vector3<f64>],
    robot: &Robot,
) -> FreeJoint {
    let begin: Vec<usize> = runs.iter().map(|r| bins.partition_point(|b| b.0 <= r.index)).collect();
    for (k, run) in runs.iter_mut().enumerate() {
        run.bins = begin[k]..begin.get(k + 1).copied().unwrap_or(bins.len());
    }
    let mut columns = vec![Vector3::zeros(); robot.dof()];
    let dof = robot.dof();
    let jac = means
        .iter()
        .map(|q| {
            robot.chain().position_and_jacobian(&q[..dof], &mut columns);
            columns[axis]
        })
        .collect();
    let body = body_chain(axis, robot).map(|(part, axes)| {
        let frames = means.iter().zip(want).map(|(q, tcp)| {
            let pose = part.forward(&q[..axes]);
            let r = *pose.rotation.matrix();
            (r, r.transpose() * (tcp - pose.position))
        });
        frames.collect()
    });
    let column = |k: usize| means.iter().map(|q| q[k]).collect();
    FreeJoint { axis, runs, p: column(axis), speed: column(rates), acceleration: column(rates + 1), jac, body }
}

/// The robot cut off after the joint of `axis`, and how many axes are left; `None` where a joint before it follows one after it.
fn body_chain(axis: usize, robot: &Robot) -> Option<(Robot, usize)> {
    let name = &robot.axis(axis).name;
    let last = robot.joints.iter().position(|j| &j.name == name)?;
    let part = &robot.joints[..=last];
    if part.iter().any(|j| j.follows.is_some_and(|f| f.joint > last)) {
        return None;
    }
    let part = Robot::new(String::new(), robot.convention, part.to_vec(), robot.base, Isometry3::identity());
    let axes = part.dof();
    Some((part, axes))
}

/// Commanded TCP of every row.
fn forward(log: &Log, robot: &Robot) -> Vec<Vector3<f64>> {
    let chain = robot.chain();
    let mut out = vec![Vector3::zeros(); log.len()];
    parallel::change_pieces(&mut out, 4096, |k, chunk| {
        let mut q = vec![0.0; robot.dof()];
        for (i, o) in chunk.iter_mut().enumerate() {
            log.command_into(k * 4096 + i, &mut q);
            *o = chain.position(&q);
        }
    });
    out
}

/// Median speed of the commanded TCP over stretches of a second or so in which it moves.
fn speed(log: &Log, want: &[Vector3<f64>]) -> Option<f64> {
    let step = (log.len() / 2000).max(1);
    let rows: Vec<usize> = (0..log.len()).step_by(step).collect();
    let mut v: Vec<f64> = rows
        .windows(2)
        .map(|w| (want[w[1]] - want[w[0]]).norm() / (log.t_s[w[1]] - log.t_s[w[0]]))
        .filter(|v| v.is_finite() && *v > 1e-7)
        .collect();
    median_of(&mut v)
}

/// Rows to leave out, the registration without them, and the noise of a coordinate.
fn outliers(
    log: &Log,
    want: &[Vector3<f64>],
    valid: &[usize],
    tracks: &[(usize, Vec<Run>)],
) -> (Vec<bool>, Isometry3<f64>, f64) {
    let mut bad = vec![false; log.len()];
    let xyz: Vec<Vector3<f64>> = valid.iter().filter_map(|&i| log.tcp_m[i]).collect();
    let target: Vec<Vector3<f64>> = valid.iter().map(|&i| want[i]).collect();
    let dt = median_of(
        &mut valid
            .windows(2)
            .step_by((valid.len() / 5000).max(1))
            .map(|w| log.t_s[w[1]] - log.t_s[w[0]])
            .collect::<Vec<_>>(),
    );
    let half_burst = dt.map_or(0, |dt| (BURST_S / dt) as usize);
    let mut turns: Vec<f64> = tracks.iter().flat_map(|(_, r)| r.iter().map(|x| x.t_s)).collect();
    turns.sort_by(f64::total_cmp);
    let quiet = |t: f64| {
        let k = turns.partition_point(|&u| u - QUIET_S[0] <= t);
        k > 0 && t <= turns[k - 1] + QUIET_S[1]
    };
    let mut frame = rigid_transform(xyz.iter().zip(&target));
    let mut sigma = [f64::MIN_POSITIVE; 3];
    for _ in 0..2 {
        let rotation = frame.rotation.to_rotation_matrix();
        let flags: Vec<(Vec<bool>, f64)> = (0..3usize).par_map(|c| {
            let r: Vec<f64> =
                xyz.iter().zip(&target).map(|(x, w)| (rotation * x)[c] + frame.translation.vector[c] - w[c]).collect();
            let sigma = noise(&r).max(1e-12);
            let smooth = median_of_7(&r);
            let mut off: Vec<bool> = r.iter().zip(&smooth).map(|(a, b)| (a - b).abs() > SPIKE_SIGMA * sigma).collect();
            if half_burst > 3 {
                burst(&smooth, half_burst, BURST_SIGMA * sigma, &mut off, |i| quiet(log.t_s[valid[i]]));
            }
            (off, sigma)
        });
        for (k, &i) in valid.iter().enumerate() {
            bad[i] = flags.iter().any(|(f, _)| f[k]);
        }
        sigma = [flags[0].1, flags[1].1, flags[2].1];
        frame = rigid_transform(xyz.iter().zip(&target).zip(valid).filter(|(_, i)| !bad[**i]).map(|(pair, _)| pair));
    }
    (bad, frame, (sigma.iter().map(|s| s * s).sum::<f64>() / 3.0).sqrt())
}

/// Robust sigma of a series from its differences over 1, 4 and 16 rows (at most 20,000 of each), the largest of the three: a
/// tracker slower than the log repeats its values, whose neighbours then differ by nothing.
fn noise(r: &[f64]) -> f64 {
    let step = (r.len() / 20_000).max(1);
    let over = |lag: usize| {
        let mut d: Vec<f64> = r.windows(lag + 1).step_by(step).map(|w| w[lag] - w[0]).collect();
        let m = median_of(&mut d)?;
        d.iter_mut().for_each(|v| *v = (*v - m).abs());
        median_of(&mut d)
    };
    [1, 4, 16].into_iter().filter_map(over).fold(0.0, f64::max) * SIGMA_PER_MAD / std::f64::consts::SQRT_2
}

/// Rigid transform that brings the first of each pair to the second, least squares; the identity where there is none.
pub fn rigid_transform<'a>(
    pairs: impl Iterator<Item = (&'a Vector3<f64>, &'a Vector3<f64>)> + Clone,
) -> Isometry3<f64> {
    rigid::fit(pairs.map(|(x, y)| (*x, *y, 1.0)), false).map_or_else(Isometry3::identity, |found| found.isometry())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rigid_transform_is_found_again() {
        let truth = Isometry3::new(Vector3::new(2.0, -1.0, 0.3), Vector3::new(0.4, 2.0, -1.1));
        let a: Vec<Vector3<f64>> =
            (0..20).map(|i| Vector3::new(f64::from(i).sin(), f64::from(i).cos(), f64::from(i % 3))).collect();
        let b: Vec<Vector3<f64>> = a.iter().map(|x| truth.rotation * x + truth.translation.vector).collect();
        let found = rigid_transform(a.iter().zip(&b));
        assert!((found.to_homogeneous() - truth.to_homogeneous()).abs().max() < 1e-12);
    }
}
