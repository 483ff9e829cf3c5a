//! What sensors, speeds and limits say about a log, mostly as notes: they make a fault likely, the path's shape proves it.
//!
//! Method: encoders against commands by the slope of a straight line, and against those of other joints, which tells swapped columns;
//! speeds by the 99th percentile of the differences, so that one jump is no suspicion; limits row by row.

use super::Log;
use super::note::Note;
use crate::error::{Error, Place, Result};
use crate::numerics::linear;
use crate::numerics::robust::lower_quantile;
use crate::robot::{Joint, JointKind, Robot};
use nalgebra::DMatrix;

/// Fewest rows that say something.
const FEWEST: usize = 10;
/// Time between rows that a motion is not sampled with: milliseconds of 40 Hz or less, read as seconds.
const SURELY_MILLISECONDS_S: f64 = 25.0;

/// Slope of a sensor over its command beyond which its unit or scale is wrong: gears and encoders err by some per cent at most.
const SLOPES: [f64; 2] = [0.9, 1.1];
/// Slope within which nothing is noted, and the correlation from which it is known that well: play makes a loop and not a slope, and a
/// motor that its controller moves for another joint too (a coupled wrist) follows its own command with a slope that is no scale.
const USUAL_SLOPES: [f64; 2] = [0.97, 1.03];
const STRAIGHT: f64 = 0.999;
/// Sensors per unit of the command, and what they are then in: of angles, and of lengths.
const ANGLES: [(f64, &str); 6] = [
    (60.0, "minutes of arc"),
    (3600.0, "seconds of arc"),
    (17.453_292_52, "mrad"),
    (1.0 / 360.0, "revolutions"),
    (10.0 / 9.0, "gon"),
    (1e3, "thousandths of a degree"),
];
const LENGTHS: [(f64, &str); 3] = [(1e3, "micrometres"), (0.1, "centimetres"), (1e3 / 25.4, "thousandths of an inch")];
/// Share by which a slope may differ from one of them.
const NEAR_UNIT: f64 = 0.005;

/// Encoders and joint sensors against the commands: another unit is refused, another sense or a wide gap is noted. `known`: the joints
/// turn as the commands say; behind tendons or sheaths they may have another ratio.
pub(super) fn sensors(log: &Log, robot: &Robot, known: bool, notes: &mut Vec<Note>) -> Result<()> {
    for (what, columns) in [("enc", &log.enc), ("screw", &log.screw), ("meas", &log.meas)] {
        for (axis, column) in columns.iter().enumerate() {
            let Some(column) = column else { continue };
            let joint = robot.axis(axis);
            let angle = what != "meas" && joint.kind == JointKind::Prismatic && joint.lead_m_per_rev.is_some();
            let name = format!("{what}_{}", joint.name);
            let pairs: Vec<(f64, f64)> =
                log.cmd[axis].iter().zip(column).filter_map(|(c, v)| v.map(|v| (*c, v))).collect();
            let Some((slope, correlation)) = line(&pairs) else { continue };
            let is = |factor: f64| (slope / factor - 1.0).abs() < 0.05;
            let per_radian = 1_f64.to_radians();
            let wrong = match joint.kind {
                JointKind::Revolute if is(per_radian) => Some("radians"),
                JointKind::Prismatic if is(1e-3) => Some("metres"),
                JointKind::Prismatic if is(1.0 / 25.4) => Some("inches"),
                // an angle of the screw, in another unit than degrees
                JointKind::Prismatic if angle && is(per_radian) => Some("radians"),
                JointKind::Prismatic if angle && is(1.0 / 360.0) => Some("revolutions"),
                _ => None,
            };
            if let Some(unit) = wrong
                && correlation > 0.99
            {
                let turns = angle && matches!(unit, "radians" | "revolutions");
                let text =
                    format!("values in {unit} in column `{name}_{}`", if turns { "deg" } else { joint.kind.unit() });
                let expected = if angle { "degrees of the screw, or mm of the joint" } else { joint.kind.unit() };
                return Err(Error::bad(Place::file(&log.name), text, expected));
            }
            if is(-1.0) && correlation < -0.99 {
                notes.push(Note::AgainstCommand { column: name, joint: joint.name.clone() });
                continue;
            }
            // the angle of a screw goes by its lead, which `identify screw` checks
            if known && !angle && correlation.abs() > FOLLOWS {
                if explained(log, axis, column).is_some_and(|share| share > STRAIGHT * STRAIGHT) {
                    scaled(log, joint, what, slope)?;
                }
                if correlation > STRAIGHT && !(USUAL_SLOPES[0]..=USUAL_SLOPES[1]).contains(&slope) {
                    notes.push(Note::Slope { column: name, joint: joint.name.clone(), slope });
                    continue;
                }
            }
            let apart: Vec<f64> = pairs.iter().map(|(c, v)| (v - c).abs()).collect();
            let (usual, travel) = (lower_quantile(&apart, 0.5), log.travel(axis));
            if travel > 0.0 && usual > 0.05 * travel {
                notes.push(Note::OffCommand { column: name, kind: joint.kind, median: usual });
            }
        }
    }
    Ok(())
}

/// A number above 0 with six significant digits, without an exponent.
fn six_digits(v: f64) -> String {
    let decimals = (5 - v.log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{v:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

/// Refuses a sensor that follows its command with a slope that no gear and no encoder has.
fn scaled(log: &Log, joint: &Joint, what: &str, slope: f64) -> Result<()> {
    if (SLOPES[0]..=SLOPES[1]).contains(&slope.abs()) {
        return Ok(());
    }
    let unit = joint.kind.unit();
    let column = format!("{what}_{}_{unit}", joint.name);
    let known: &[(f64, &str)] = if joint.kind == JointKind::Revolute { &ANGLES } else { &LENGTHS };
    let near = known.iter().find(|u| (slope.abs() / u.0 - 1.0).abs() < NEAR_UNIT);
    let factor = near.map_or(slope.abs(), |u| u.0);
    let meant = near.map_or(String::new(), |u| format!(", as if they were in {}", u.1));
    let sign = if slope < 0.0 { "sign: -1, " } else { "" };
    let found =
        format!("values of `{column}` that move {slope:.4} times as far as the commands of {}{meant}", joint.name);
    let expected = format!(
        "{unit} of the joint: check unit, scale and gear ratio of the sensor (a column map with \
         `{{to: {column}, {sign}scale: {}}}` brings them to the commands)",
        six_digits(1.0 / factor)
    );
    Err(Error::bad(Place::file(&log.name), found, expected))
}

/// Correlation from which a sensor follows a command, and below which it does not.
const FOLLOWS: f64 = 0.99;
const FOLLOWS_NOT: f64 = 0.9;

/// Refuses sensors of joints that follow the command of another joint, and not that of their own.
///
/// # Errors
/// Two columns that are swapped, or one of another joint.
pub(super) fn swapped(log: &Log, robot: &Robot) -> Result<()> {
    for (what, columns) in [("enc", &log.enc), ("meas", &log.meas)] {
        let follows = |sensor: usize, axis: usize| -> Option<f64> {
            let pairs =
                log.cmd[axis].iter().zip(columns.get(sensor)?.as_ref()?).filter_map(|(c, v)| v.map(|v| (*c, v)));
            let (slope, correlation) = line(&pairs.collect::<Vec<_>>())?;
            (robot.axis(axis).kind == robot.axis(sensor).kind && (slope - 1.0).abs() < 0.05).then_some(correlation)
        };
        let own = |axis: usize| follows(axis, axis).is_some_and(|r| r > FOLLOWS_NOT);
        for sensor in (0..robot.dof()).filter(|a| columns.get(*a).is_some_and(Option::is_some) && !own(*a)) {
            // a sensor that sees another joint as well as its own is no other column as long as that one has its own
            let other =
                |axis: &usize| *axis != sensor && follows(sensor, *axis).is_some_and(|r| r > FOLLOWS) && !own(*axis);
            let Some(axis) = (0..robot.dof()).find(other) else { continue };
            let (name, of) = (&robot.axis(sensor).name, &robot.axis(axis).name);
            let text = format!("column `{what}_{name}` follows the commands of {of}, not those of {name}");
            let expected =
                format!("the sensor of {name} (exchange the columns of {name} and {of}, or use a column map)");
            return Err(Error::bad(Place::file(&log.name), text, expected));
        }
    }
    Ok(())
}

/// Slope of `v` on `c` and their correlation; `None` where the command hardly moves.
fn line(pairs: &[(f64, f64)]) -> Option<(f64, f64)> {
    let n = pairs.len() as f64;
    let (mc, mv) = (pairs.iter().map(|p| p.0).sum::<f64>() / n, pairs.iter().map(|p| p.1).sum::<f64>() / n);
    let sum = |f: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|p| f(p.0 - mc, p.1 - mv)).sum::<f64>();
    let (cc, cv, vv) = (sum(&|c, _| c * c), sum(&|c, v| c * v), sum(&|_, v| v * v));
    (pairs.len() >= FEWEST && cc / n > 1e-6 && vv > 0.0).then(|| (cv / cc, cv / (cc * vv).sqrt()))
}

/// Share of the variance of a sensor that its command explains, with its speed beside it where rows have times: a sensor that lags has
/// a loop as well, and is as straight as one that does not.
fn explained(log: &Log, axis: usize, column: &[Option<f64>]) -> Option<f64> {
    let (cmd, t) = (&log.cmd[axis], &log.t_s);
    let speed = |i: usize| -> f64 {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(cmd.len() - 1));
        if log.poses || t[b] <= t[a] { 0.0 } else { (cmd[b] - cmd[a]) / (t[b] - t[a]) }
    };
    let rows: Vec<(usize, f64)> = column.iter().enumerate().filter_map(|(i, v)| v.map(|v| (i, v))).collect();
    let n = rows.len() as f64;
    let mean = rows.iter().map(|r| r.1).sum::<f64>() / n;
    let all: f64 = rows.iter().map(|r| (r.1 - mean).powi(2)).sum();
    let y: Vec<f64> = rows.iter().map(|r| r.1).collect();
    let ones = vec![1.0; y.len()];
    let of = |columns: usize| {
        let design = DMatrix::from_fn(y.len(), columns, |r, c| match c {
            0 => 1.0,
            1 => cmd[rows[r].0],
            _ => speed(rows[r].0),
        });
        linear::weighted(&design, &y, &ones)
    };
    let fit = of(3).or_else(|| of(2))?;
    (all > 0.0).then(|| 1.0 - fit.residual / all)
}

/// A joint that is so many times faster than it can be in this share of the rows is no such column: rows out of order, or another unit.
const IMPOSSIBLE: f64 = 3.0;
const IMPOSSIBLE_SHARE: f64 = 0.25;

/// Times in another unit than seconds, as far as speeds show it.
pub(super) fn times(log: &Log, robot: &Robot, notes: &mut Vec<Note>) -> Result<()> {
    if log.poses || log.len() < FEWEST {
        return Ok(());
    }
    let dt: Vec<f64> = log.t_s.windows(2).map(|w| w[1] - w[0]).collect();
    let usual = lower_quantile(&dt, 0.5);
    let moving = log.moving_axes();
    let mut slow = !moving.is_empty();
    for axis in moving {
        let joint = robot.axis(axis);
        let speed: Vec<f64> = log.cmd[axis].windows(2).zip(&dt).map(|(w, dt)| ((w[1] - w[0]) / dt).abs()).collect();
        let fast = lower_quantile(&speed, 0.99);
        let unit = joint.kind.unit();
        if let Some(max) = joint.max_speed
            && fast > 3.0 * max
        {
            if lower_quantile(&speed, 1.0 - IMPOSSIBLE_SHARE) > IMPOSSIBLE * max {
                return Err(Error::bad(
                    Place::file(&log.name),
                    format!(
                        "{} at more than {IMPOSSIBLE:.0} times its largest speed, {:.0} {unit}/s, in every fourth row or more",
                        joint.name,
                        joint.kind.to_user_unit(max)
                    ),
                    format!("`t_s` in seconds, rows in the order of time, commands in {unit}"),
                ));
            }
            notes.push(Note::TooFast { joint: joint.name.clone(), kind: joint.kind, speed: fast, limit: max });
        }
        // 0.1 deg/s or mm/s with a row a second: rarely a program, often milliseconds read as seconds
        slow &= joint.kind.to_user_unit(fast) < 0.1;
    }
    // no tracker waits so long between the samples of a motion: settled poses have no `t_s`
    if usual >= SURELY_MILLISECONDS_S && slow {
        return Err(Error::bad(
            Place::file(&log.name),
            format!("rows that are {usual} s apart, and no joint faster than 0.1 deg/s or mm/s"),
            "`t_s` in seconds (these look like milliseconds: use a column map with `unit: ms`)",
        ));
    }
    if usual >= 1.0 && slow {
        notes.push(Note::SlowRows { apart_s: usual });
    }
    Ok(())
}

/// Rows from which on poses in small steps are rather samples of a motion, and the largest step, as a share of the travel.
const SAMPLED_ROWS: usize = 500;
const SAMPLED_STEP: f64 = 0.02;

/// Rows without times that follow each other as the samples of a motion do: they count as settled poses, which they may not be.
pub(super) fn samples_without_times(log: &Log, notes: &mut Vec<Note>) {
    let moving = log.moving_axes();
    if !log.poses || log.len() < SAMPLED_ROWS || moving.is_empty() {
        return;
    }
    let small = |axis: usize| {
        let steps: Vec<f64> = log.cmd[axis].windows(2).map(|w| (w[1] - w[0]).abs()).collect();
        lower_quantile(&steps, 0.99) <= SAMPLED_STEP * log.travel(axis)
    };
    if moving.into_iter().all(small) {
        notes.push(Note::SamplesWithoutTimes { rows: log.len() });
    }
}

/// Commands beyond the limits of the robot file.
pub(super) fn limits(log: &Log, robot: &Robot, notes: &mut Vec<Note>) {
    for (axis, joint) in robot.axis_joints().enumerate() {
        let Some([lo, hi]) = joint.limits else { continue };
        let slack = 1e-6 * (hi - lo);
        if let Some(row) = log.cmd[axis].iter().position(|&v| v < lo - slack || v > hi + slack) {
            let (line, at) = (log.line[row], log.cmd[axis][row]);
            let (joint, kind) = (joint.name.clone(), joint.kind);
            notes.push(Note::OutsideLimits { line, joint, kind, at, limits: [lo, hi] });
        }
    }
}
