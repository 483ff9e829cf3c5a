//! Deadzones by growing sweeps (Cursi (2022), algorithm 1): one joint at a time turns again and again, a tracker sees the tip alone.
//!
//! Modules, one a step:
//! - [`motion`]: the stretches of all logs in which one joint moves alone, and its turning points.
//! - [`rest`]: at which turns the tip stops, and in which stroke it leaves again: algorithm 1, in a form in which noise cannot
//!   shatter a deadzone; [`printed`]: the algorithm as it is printed, to compare with.
//! - [`edge`]: the size of each deadzone from the rows about it, with its standard error.
//! - [`map`]: size over position, with intervals; does it vary?
//! - [`document`], [`display`]: the result as a document and as a table.
//!
//! A deadzone of the motor spans both half gaps: `half_gap = size / 2`, placed in the middle between where the deadzone
//! begins and where it ends. Kinematics serve for one thing only: how far a polynomial can follow the tip's path. No
//! tracker frame, no lengths, no followers of a coupled joint enter the sizes.
//!
//! How it fails: a tracker that lags behind the commands makes a deadzone longer by its lag times the speed with which the
//! motor leaves it; a deadzone that no stroke crosses has no size. `docs/identify-deadzone.md` has both.
//!
//! Files beside:
//! - `joint`: the deadzones of one joint, through the steps above, and its half gap
//! - `notes`: what a reader of the sweeps should know

#[cfg(feature = "cli")]
pub(crate) mod display;
pub mod document;
pub(crate) mod edge;
mod joint;
pub(crate) mod map;
pub(crate) mod motion;
mod notes;
pub(crate) mod printed;
pub(crate) mod rest;

use crate::effects::GapCurve;
use crate::effects::curve::Pchip;
use crate::error::{Error, Place, Result};
use crate::gaps::note::deadzone::{NoDeadzone, Remark};
use crate::gaps::{GapPoint, Gaps, JointGap, Note};
use crate::log::Log;
use crate::numerics::normal::Z95;
use crate::numerics::parallel::ParMap;
use crate::numerics::robust::{SIGMA_PER_MAD, median_of};
use crate::numerics::student;
use crate::robot::{JointKind, Robot};
use edge::{Edge, Warp};
use joint::{joint, joint_gap, point};
use map::{Map, Sized};
use motion::{Motions, Stretch};
use nalgebra::Vector3;
use std::collections::HashSet;

/// Settings of the identification; SI.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Joints to be looked at; empty: all that move.
    pub axes: Vec<usize>,
    /// Distance from where it stopped up to which the tip is stationary; else five standard deviations of the noise.
    pub rest_m: Option<f64>,
    /// Movement of a command that is noise, by axis (rad or m); else from the log. One per axis, or empty.
    pub deadband: Vec<Option<f64>>,
}

/// One deadzone of a joint; rad or m, s.
#[derive(Debug, Clone)]
pub struct Deadzone {
    /// Number of the axis, from 0.
    pub axis: usize,
    /// Number of the log, from 0.
    pub log: usize,
    /// Line of the log's file near the turn.
    pub line: u32,
    /// Time of the turn, s.
    pub t_s: f64,
    /// Motor position at which the tip stopped, and at which it moved again.
    pub from: f64,
    /// Motor position at which the tip moved again, rad or m.
    pub to: f64,
    /// Travel of the motor that moved nothing, both half gaps, rad or m.
    pub size: f64,
    /// Standard deviation of `size`, rad or m.
    pub sigma: f64,
    /// Number of rows that the size was estimated from.
    pub rows: usize,
    /// Place of the tip at rest in the frame of the tracker, m.
    pub rest_m: Vector3<f64>,
}

/// A joint's sweeps and what they gave.
#[derive(Debug, Clone)]
pub struct JointSweeps {
    /// Number of the axis, from 0.
    pub axis: usize,
    /// Deadzones that were crossed, in the order of the logs.
    pub deadzones: Vec<Deadzone>,
    /// Half gap over position.
    pub map: Map,
    /// Turning points seen, and what became of those that gave no size.
    pub turns: usize,
    /// Turns after which the tip stayed at rest: the stroke lies inside the gap.
    pub inside: usize,
    /// Turns after which the deadzone was not crossed to its end.
    pub not_crossed: usize,
    /// Turns whose following movement is too short to be seen against the noise.
    pub too_short: usize,
    /// Turns without enough rows of the tracker.
    pub unseen: usize,
    /// Deadzones whose branch could not be fitted.
    pub unfitted: usize,
    /// Standard deviation of one coordinate, m, from what the fits left.
    pub noise_m: f64,
    /// Rest radius that was used, m, the largest of all stretches.
    pub radius_m: f64,
    /// Number of rows that were left out as gross errors.
    pub outliers: usize,
}

/// What the sweeps gave.
#[derive(Debug, Clone)]
pub struct Found {
    /// Half gaps of the joints, for a compensator.
    pub gaps: Gaps,
    /// In the order of `gaps.joints`.
    pub joints: Vec<JointSweeps>,
}

/// Noise below this is the rounding of a file, m.
const LEAST_NOISE_M: f64 = 1e-8;
/// Root of the sum of the squared weights of a third difference.
const THIRD: f64 = 4.472_135_955;
/// Scatter at rest over that of third differences above which the noise is not white.
const COLOURED: f64 = 1.3;
/// A size is no use where its 95 % interval is wider than the travel that was looked at.
const WIDEST: f64 = 1.0;
/// Steps of the differences of the nominal path, rad or m.
const STEP_RAD: f64 = 0.05;
const STEP_M: f64 = 0.005;
/// Rounds of sizes and map; the map of the second changes by a tenth of its interval or less in a third.
const ROUNDS: usize = 3;

/// Finds the deadzones of every joint that the logs sweep alone.
pub fn identify(robot: &Robot, logs: &[Log], options: &Options) -> Result<Found> {
    let mut seen = HashSet::new();
    if let Some(twice) = logs.iter().find(|l| !seen.insert(&l.sha256)) {
        let expected = "each log once: its deadzones would count twice";
        return Err(Error::bad(Place::file(&twice.name), "a log that was given before (same SHA-256)", expected));
    }
    let stretches = sweeps(robot, logs, options)?;
    let mut gaps = Gaps::new(robot, logs);
    gaps.notes.extend(robot.by_joints_alone().map(Note::JointsAlone));
    let mut joints = Vec::new();
    for axis in 0..robot.dof() {
        let own: Vec<&Stretch> = stretches.iter().filter(|s| s.axis == axis).collect();
        if own.is_empty() {
            continue;
        }
        let note = |remark| Note::Deadzone { joint: robot.axis(axis).name.clone(), remark };
        match joint(robot, logs, &own, options) {
            Ok(found) => {
                gaps.notes.extend(notes::notes(robot, &found).into_iter().map(note));
                gaps.points.extend(found.deadzones.iter().map(point));
                gaps.joints.push(joint_gap(&found));
                joints.push(found);
            }
            Err(why) => gaps.notes.push(note(Remark::None(why))),
        }
    }
    if joints.is_empty() {
        let expected =
            "sweeps of one joint at a time that reverse repeatedly with growing amplitude, larger than its deadzone";
        let why: Vec<String> = gaps.notes.iter().map(Note::to_string).collect();
        let found = format!("no crossed deadzone ({})", why.join("; "));
        return Err(Error::bad(logs.first().map_or_else(Place::default, |l| Place::file(&l.name)), found, expected));
    }
    Ok(Found { gaps, joints })
}

/// Sizes by algorithm 1 as printed, joint by joint of `found`: thresholds in deg/s (or mm/s) of the motor and m/s of the tip.
pub fn as_printed(
    robot: &Robot,
    logs: &[Log],
    options: &Options,
    found: &Found,
    eps: f64,
    eps_tip_m_s: f64,
) -> Vec<(usize, Vec<f64>)> {
    let all = sweeps(robot, logs, options).unwrap_or_default();
    let of = |axis: usize| {
        let eps = eps * robot.axis(axis).kind.si_per_user_unit();
        let own = all.iter().filter(|s| s.axis == axis);
        own.flat_map(|s| printed::identify(s, eps, eps_tip_m_s)).map(|d| d.size).collect()
    };
    found.joints.iter().map(|j| (j.axis, of(j.axis))).collect()
}

/// Stretches of all logs in which a wanted joint moves alone; says what else the logs hold where there are none.
fn sweeps(robot: &Robot, logs: &[Log], options: &Options) -> Result<Vec<Stretch>> {
    let mut all = Vec::new();
    let mut last: Option<(&Log, Motions)> = None;
    for (index, log) in logs.iter().enumerate() {
        let bad = |found: String, expected: &str| Err(Error::bad(Place::file(&log.name), found, expected));
        if log.poses {
            return bad(
                "settled poses (no column t_s)".into(),
                "samples of a motion with t_s (use `identify static` for settled poses)",
            );
        }
        if log.tcp_m.iter().all(Option::is_none) {
            return bad("no measured tip".into(), "columns x_mm, y_mm, z_mm with measurements");
        }
        let chosen = |a: usize| options.deadband.get(a).copied().flatten();
        let deadband: Vec<f64> = (0..robot.dof()).map(|a| motion::deadband(log, robot, a, chosen(a))).collect();
        let mut motions = motion::stretches(log, index, &deadband);
        all.extend(motions.stretches.drain(..).filter(|s| options.axes.is_empty() || options.axes.contains(&s.axis)));
        last = Some((log, motions));
    }
    if all.iter().any(|s: &Stretch| !s.turns.is_empty()) {
        return Ok(all);
    }
    let Some((log, motions)) = last else {
        return Err(Error::bad(Place::default(), "no log", "one log or more"));
    };
    let names = |axes: &[usize]| axes.iter().map(|&a| robot.axis(a).name.as_str()).collect::<Vec<_>>().join(", ");
    let found = if motions.together > 0 {
        format!(
            "a motion of {} together ({} of {} rows that move)",
            names(&motions.mixed),
            motions.together,
            motions.moving
        )
    } else if motions.moving == 0 {
        "commands that do not move".into()
    } else if all.is_empty() && !options.axes.is_empty() {
        format!("no movement of {} alone", names(&options.axes))
    } else {
        "a motion without reversals".into()
    };
    let expected =
        "sweeps of one joint at a time, back and forth with growing amplitude, while the other joints stand still";
    Err(Error::bad(Place::file(&log.name), found, expected))
}

/// Standard deviation of one coordinate: third differences of rows that follow each other, robust.
fn noise(s: &Stretch) -> f64 {
    let mut third = Vec::new();
    for w in s.tip.windows(4) {
        if let [Some(a), Some(b), Some(c), Some(d)] = w {
            let e = d - 3.0 * c + 3.0 * b - a;
            third.extend(e.iter().map(|v| v.abs()));
        }
    }
    (SIGMA_PER_MAD * median_of(&mut third).unwrap_or(0.0) / THIRD).max(LEAST_NOISE_M)
}

/// The same from the scatter of the tip within its rests: larger where the noise is correlated.
fn noise_at_rest(s: &Stretch, rests: &rest::Rests) -> Option<f64> {
    let mut deviations = Vec::new();
    for r in &rests.crossed {
        let turn = s.turns[r.turn];
        let [_, end_s] = s.stroke_s(r.stroke);
        // the last third of a rest may hold the edge
        let inside = |i: &usize| (turn.dir * (s.p[*i] - turn.p)) < 0.67 * r.travel[0];
        let tips: Vec<Vector3<f64>> = s.rows(turn.t_s, end_s).take_while(inside).filter_map(|i| s.tip[i]).collect();
        if tips.len() < 3 {
            continue;
        }
        let mean = tips.iter().sum::<Vector3<f64>>() / tips.len() as f64;
        let widen = (tips.len() as f64 / (tips.len() - 1) as f64).sqrt();
        deviations.extend(tips.iter().flat_map(|p| (p - mean).iter().map(|v| widen * v.abs()).collect::<Vec<_>>()));
    }
    (deviations.len() >= 30).then(|| SIGMA_PER_MAD * median_of(&mut deviations).unwrap_or(0.0))
}
