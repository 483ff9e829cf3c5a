//! Clocks of commands and measurement that are apart: put together before the fit, whose own column for the clock is linear and
//! holds some hundredths of a second.
//!
//! The deviation from the nominal path is regressed on the TCP's velocity, beside small movements of the frame and a gap of each joint:
//! at one slow speed alone a gap and a late clock look the same. The commands are then taken that much later or earlier, and the
//! regression is repeated, as a path bends.

use super::frame;
use crate::error::Result;
use crate::log::Log;
use crate::numerics::robust::median_of;
use crate::robot::Robot;
use nalgebra::{DMatrix, DVector, Point3, Vector3};
use std::borrow::Cow;

/// Rows of a log that are looked at, and fewest.
const ROWS: usize = 1000;
const FEWEST: usize = 100;
/// Differences of clocks that are left to the fit, s, and beyond which two recordings were not joined.
const SMALL_S: f64 = 0.02;
const LARGEST_S: f64 = 1.0;
/// Deviation, m rms, below which it may all be lost motion and geometry.
const LEAST_M: f64 = 3e-4;
/// Share of the deviation that may be left for a clock to be the cause.
const EXPLAINED: f64 = 0.6;
const ROUNDS: usize = 4;
/// Speed of a joint or the TCP up to which it is stationary, rad/s, m/s.
const RESTS: f64 = 1e-6;

/// Logs by one clock each, and the number and shift (s) of those whose commands were shifted.
type Aligned<'a> = (Vec<Cow<'a, Log>>, Vec<(usize, f64)>);

/// Logs by one clock each, and by how much (s) the commands of which were shifted.
pub fn aligned<'a>(robot: &Robot, logs: &'a [Log]) -> Result<Aligned<'a>> {
    let mut out: Vec<Cow<Log>> = logs.iter().map(Cow::Borrowed).collect();
    let mut shifts = vec![0.0; logs.len()];
    for _ in 0..ROUNDS {
        let now: Vec<&Log> = out.iter().map(|l| l.as_ref()).collect();
        let Some(registered) = frame::frame(robot, &now)? else { break };
        let mut still = true;
        for (k, log) in logs.iter().enumerate() {
            let Some(by) = apart(robot, &out[k], &registered) else { continue };
            let next = shifts[k] + by;
            if next.abs() <= LARGEST_S
                && let Some(moved) = shifted(log, next)
            {
                (out[k], shifts[k], still) = (Cow::Owned(moved), next, false);
            }
        }
        if still {
            break;
        }
    }
    let found = shifts.iter().copied().enumerate().filter(|s| s.1 != 0.0).collect();
    Ok((out, found))
}

/// By how much later the commands are to be taken, s; `None`: the clocks explain little of the deviation.
fn apart(robot: &Robot, log: &Log, registered: &crate::gaps::Registered) -> Option<f64> {
    let to_base = frame::own_frame(robot, log, registered).ok()?;
    let moving = super::readings::moving(log, robot);
    let each = (log.len() / ROWS).max(1);
    let rows: Vec<usize> = (1..log.len().saturating_sub(1))
        .step_by(each)
        .filter(|i| log.tcp_m.get(*i).is_some_and(Option::is_some))
        .collect();
    if rows.len() < FEWEST || log.poses {
        return None;
    }
    let columns = 7 + moving.len();
    let mut design = DMatrix::zeros(3 * rows.len(), columns);
    let mut right = DVector::zeros(3 * rows.len());
    let mut jacobian = vec![Vector3::zeros(); robot.dof()];
    for (n, &i) in rows.iter().enumerate() {
        let q = log.command(i);
        let at = robot.chain().position_and_jacobian(&q, &mut jacobian);
        let measured = (to_base * Point3::from(log.tcp_m[i]?)).coords;
        let dt = log.t_s[i + 1] - log.t_s[i - 1];
        let rate = |a: usize| (log.cmd[a][i + 1] - log.cmd[a][i - 1]) / dt;
        let velocity: Vector3<f64> = moving.iter().map(|a| jacobian[*a] * rate(*a)).sum();
        let off = measured - at;
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        for c in 0..3 {
            let row = 3 * n + c;
            right[row] = off[c];
            for (k, e) in axes.iter().enumerate() {
                design[(row, k)] = e[c];
                design[(row, 3 + k)] = e.cross(&at)[c];
            }
            design[(row, 6)] = velocity[c];
            for (k, a) in moving.iter().enumerate() {
                let v = rate(*a);
                design[(row, 7 + k)] = if v.abs() > RESTS { -jacobian[*a][c] * v.signum() } else { 0.0 };
            }
        }
    }
    if right.norm() < LEAST_M * (rows.len() as f64).sqrt() {
        return None;
    }
    let left = |with: bool| -> Option<(f64, DVector<f64>)> {
        let mut design = design.clone();
        if !with {
            design.column_mut(6).fill(0.0);
        }
        let x = design.clone().svd(true, true).solve(&right, 1e-9).ok()?;
        Some(((&right - design * &x).norm(), x))
    };
    let (without, (with, x)) = (left(false)?.0, left(true)?);
    (x[6].abs() > SMALL_S && with < EXPLAINED * without).then(|| x[6])
}

/// A log whose commands are those of `by_s` later; a whole number of rows where they are even, as commands between rows are not known.
fn shifted(log: &Log, by_s: f64) -> Option<Log> {
    let mut steps: Vec<f64> = log.t_s.windows(2).map(|w| w[1] - w[0]).collect();
    let step = median_of(&mut steps)?;
    let even = log.t_s.windows(2).all(|w| (w[1] - w[0] - step).abs() < 0.02 * step);
    let by_s = if even { (by_s / step).round() * step } else { by_s };
    let (first, last) = (*log.t_s.first()?, *log.t_s.last()?);
    let mut out = log.clone();
    for (to, from) in out.cmd.iter_mut().zip(&log.cmd) {
        for (v, t) in to.iter_mut().zip(&log.t_s) {
            let t = (t + by_s).clamp(first, last);
            let k = log.t_s.partition_point(|s| *s <= t).clamp(1, log.len() - 1);
            let share = (t - log.t_s[k - 1]) / (log.t_s[k] - log.t_s[k - 1]);
            // a row that is met but for rounding is that row
            let share = if even { share.round() } else { share };
            *v = from[k - 1] + share * (from[k] - from[k - 1]);
        }
    }
    for (p, t) in out.tcp_m.iter_mut().zip(&log.t_s) {
        if t + by_s < first || t + by_s > last {
            *p = None;
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::input::{Input, sha256};
    use std::fmt::Write;

    /// An arm of two joints in a plane and a lift, with gaps of 0.01 deg, whose clock runs late by `late_s`; `fast` times its pace.
    fn log(late_s: f64, fast: f64) -> (Robot, Log) {
        let yaml = "schema: lostmotion/robot/1\nname: two\njoints:\n  - {name: A1, kind: revolute, a_mm: 700}\n  - {name: A2, kind: revolute, a_mm: 500}\n  - {name: A3, kind: prismatic}\n";
        let robot = Robot::parse("robot.yaml", yaml).unwrap();
        let at = |t: f64| {
            let t = t * fast;
            [20.0 * (0.31 * t).sin() + 5.0 * (0.9 * t).sin(), 40.0 + 15.0 * (0.43 * t).cos(), 60.0 * (0.27 * t).sin()]
        };
        let mut text = String::from("t_s,cmd_A1_deg,cmd_A2_deg,cmd_A3_mm,x_mm,y_mm,z_mm\n");
        for i in 0..3000 {
            let t = f64::from(i) * 0.02;
            let (q, was) = (at(t), at(t - late_s));
            let v = |k: usize| at(t - late_s)[k] - at(t - late_s - 1e-3)[k];
            let joints: Vec<f64> = (0..3)
                .map(|k| {
                    let unit = if k < 2 { 1f64.to_radians() } else { 1e-3 };
                    (was[k] - 0.01 * v(k).signum()) * unit
                })
                .collect();
            let p = robot.tcp_m(&joints) * 1e3;
            let _ = writeln!(text, "{t},{:.6},{:.6},{:.6},{:.5},{:.5},{:.5}", q[0], q[1], q[2], p.x, p.y, p.z);
        }
        let input = Input { name: "log.csv".into(), sha256: sha256(text.as_bytes()), bytes: text.into() };
        let log = Log::parse(input, &robot).unwrap();
        (robot, log)
    }

    #[test]
    fn clocks_that_are_apart_are_put_together_to_a_row() {
        for late_s in [0.3, -0.2, 0.1] {
            let (robot, log) = log(late_s, 1.0);
            let logs = [log];
            let (moved, shifts) = aligned(&robot, &logs).unwrap();
            assert_eq!(shifts.len(), 1, "{late_s}");
            assert!((shifts[0].1 + late_s).abs() < 0.0101, "{late_s}: {}", shifts[0].1);
            // the ends of which no command is known do not count
            let lost = moved[0].tcp_m.iter().filter(|p| p.is_none()).count();
            assert!((lost as f64 - late_s.abs() / 0.02).abs() < 1.5, "{lost}");
        }
    }

    #[test]
    fn gaps_at_a_slow_pace_are_no_late_clock() {
        for fast in [0.01, 0.1, 1.0] {
            let (robot, log) = log(0.0, fast);
            assert!(aligned(&robot, &[log]).unwrap().1.is_empty(), "{fast}");
        }
    }
}
