//! What compensation leaves of the deadzones of a motion (Cursi (2022), Table I): mean size without and with it, joint by joint.
//!
//! Both runs are judged by the intended motion: the commands of the logs are replaced by those of the nominal program at the
//! same times, so that a size is the part of the intended motion during which the tip stands still. Sizes are those of
//! [`crate::identify::deadzone`]; after a good compensator they scatter about zero and some come out negative. The mean is plain,
//! as in the paper; its interval comes from the standard errors of the sizes.
//!
//! Assumptions: program and logs share one clock; the log begins when the program does. A log whose commands are far from
//! the program's at most times is of another motion, and refused.

use crate::error::{Error, Place, Result};
use crate::gaps::{self, file::number};
use crate::identify::deadzone::{self, Found, Options};
use crate::io::keyed::Keyed;
use crate::log::Log;
use crate::numerics::normal::Z95;
use crate::program::Program;
use crate::robot::Robot;
use serde::Serialize;
use serde_json::Value;

pub const SCHEMA: &str = "lostmotion/deadzone/1";

/// Share of the motion's range by which commands may differ from the wanted ones at [`MOST_ROWS`] of the times: an offset is
/// half a gap, another motion is elsewhere.
const OTHER_MOTION: f64 = 0.2;
const MOST_ROWS: f64 = 0.9;

/// Deadzones of one joint in one run; rad or m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Left {
    pub deadzones: usize,
    pub mean: f64,
    pub ci95: [f64; 2],
}

/// One joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointLeft {
    pub axis: usize,
    pub before: Left,
    pub after: Option<Left>,
}

impl JointLeft {
    /// Share of the mean size that compensation takes away; `None` where there was none to take: its interval contains 0.
    pub fn reduction(&self) -> Option<f64> {
        let after = self.after?;
        (self.before.ci95[0] > 0.0).then(|| 1.0 - after.mean / self.before.mean)
    }
}

/// The comparison.
#[derive(Debug, Clone)]
pub struct Assessment {
    pub joints: Vec<JointLeft>,
    pub notes: Vec<Note>,
}

/// A remark on the comparison. Code compares the variants; the words are for readers.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// Of the run without compensation.
    #[error("before: {0}")]
    Before(gaps::Note),
    /// Of the run with compensation.
    #[error("after: {0}")]
    After(gaps::Note),
    /// With compensation nothing is left of a joint that could be determined.
    #[error("{joint}: no deadzone could be determined with compensation")]
    NoneAfter {
        /// Name of the joint.
        joint: String,
    },
}

crate::io::in_words!(Note);

/// Compares runs of one program.
pub fn assess(robot: &Robot, nominal: &Program, before: &Log, after: Option<&Log>) -> Result<Assessment> {
    let found = |log: &Log| deadzone::identify(robot, &[wanted(log, nominal)?], &Options::default());
    let without = found(before)?;
    let with = after.map(found).transpose()?;
    let mut out = Assessment { joints: Vec::new(), notes: Vec::new() };
    out.notes.extend(without.gaps.notes.iter().cloned().map(Note::Before));
    out.notes.extend(with.iter().flat_map(|f| &f.gaps.notes).cloned().map(Note::After));
    for sweeps in &without.joints {
        let axis = sweeps.axis;
        let Some(before) = left(&without, axis) else { continue };
        let after = with.as_ref().and_then(|w| left(w, axis));
        if with.is_some() && after.is_none() {
            out.notes.push(Note::NoneAfter { joint: robot.axis(axis).name.clone() });
        }
        out.joints.push(JointLeft { axis, before, after });
    }
    Ok(out)
}

/// The log with the commands that were wanted.
fn wanted(log: &Log, nominal: &Program) -> Result<Log> {
    let times = nominal.t_s.as_deref().filter(|t| t.len() > 1);
    let Some(times) = times else {
        let found = "a program without times";
        return Err(Error::bad(
            Place::file(&nominal.name),
            found,
            "a column t_s with the times of the intended motion",
        ));
    };
    let (first, last) = (times[0], times[times.len() - 1]);
    if log.poses {
        return Err(Error::bad(Place::file(&log.name), "settled poses (no column t_s)", "samples of a motion"));
    }
    let end = log.t_s.last().copied().unwrap_or(0.0);
    if log.t_s.iter().all(|t| *t < first || *t > last) || end > last + 0.5 * (last - first) {
        let found = format!("times up to {end:.1} s");
        let expected = format!("a run of {}, which lasts from {first:.1} to {last:.1} s", nominal.name);
        return Err(Error::bad(Place::file(&log.name), found, expected));
    }
    let logged = log;
    let mut log = log.clone();
    for (row, t) in log.t_s.iter().enumerate() {
        let k = times.partition_point(|v| v <= t).clamp(1, times.len() - 1);
        let share = ((t - times[k - 1]) / (times[k] - times[k - 1])).clamp(0.0, 1.0);
        for (column, q) in log.cmd.iter_mut().zip(&nominal.q) {
            column[row] = q[k - 1] + share * (q[k] - q[k - 1]);
        }
    }
    let apart = apart(logged, &log);
    if apart > OTHER_MOTION {
        let found = format!(
            "commands that are {:.0} % of the motion's range or more from those of {} in a tenth of the rows",
            100.0 * apart,
            nominal.name
        );
        let expected = format!("a run of {}: the same motion, in the same order, on the same clock", nominal.name);
        return Err(Error::bad(Place::file(&log.name), found, expected));
    }
    Ok(log)
}

/// Distance of two motions, over the range of the joint that is farthest off: nine tenths of the times are nearer.
fn apart(logged: &Log, wanted: &Log) -> f64 {
    let ranges: Vec<f64> = (0..wanted.cmd.len()).map(|a| wanted.travel(a).max(logged.travel(a))).collect();
    let mut off: Vec<f64> = (0..wanted.len())
        .map(|row| {
            let of = |a: usize| {
                if ranges[a] > 0.0 { (logged.cmd[a][row] - wanted.cmd[a][row]).abs() / ranges[a] } else { 0.0 }
            };
            (0..ranges.len()).map(of).fold(0.0, f64::max)
        })
        .collect();
    off.sort_by(f64::total_cmp);
    off.get((MOST_ROWS * off.len() as f64) as usize).copied().unwrap_or(0.0)
}

fn left(found: &Found, axis: usize) -> Option<Left> {
    let zones = &found.joints.iter().find(|j| j.axis == axis)?.deadzones;
    let n = zones.len() as f64;
    let mean = zones.iter().map(|d| d.size).sum::<f64>() / n;
    let half = Z95 * zones.iter().map(|d| d.sigma * d.sigma).sum::<f64>().sqrt() / n;
    Some(Left { deadzones: zones.len(), mean, ci95: [mean - half, mean + half] })
}

/// What `assess deadzone --json` prints (`lostmotion/deadzone/1`).
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Document {
    schema: &'static str,
    joints: Vec<JointShown>,
    #[schemars(with = "Vec<String>")]
    notes: Vec<Note>,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
struct JointShown {
    joint: String,
    before: LeftShown,
    after: Option<LeftShown>,
    reduction: Option<Value>,
}

/// Numbers with ten significant digits.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
struct LeftShown {
    deadzones: usize,
    #[serde(flatten)]
    mean: Keyed<Value>,
    ci95: [Value; 2],
}

impl Assessment {
    /// The document.
    pub fn document(&self, robot: &Robot) -> Document {
        let joint = |j: &JointLeft| {
            let kind = robot.axis(j.axis).kind;
            let shown = |l: &Left| LeftShown {
                deadzones: l.deadzones,
                mean: Keyed::new("mean", kind.unit(), number(kind.to_user_unit(l.mean))),
                ci95: l.ci95.map(|v| number(kind.to_user_unit(v))),
            };
            JointShown {
                joint: robot.axis(j.axis).name.clone(),
                before: shown(&j.before),
                after: j.after.as_ref().map(shown),
                reduction: j.reduction().map(number),
            }
        };
        Document { schema: SCHEMA, joints: self.joints.iter().map(joint).collect(), notes: self.notes.clone() }
    }
}
