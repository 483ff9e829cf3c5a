//! Units, axes and clocks that cannot be right: found before anything is computed from a log.
//!
//! Method: the path computed from the commands and the measured one are compared in shape (any rigid frame). Only where
//! they differ by more than 1 in 500 of their size are faults tried, one at a time: TCP in metres, micrometres or inches;
//! commands in radians (all, or one joint's), in metres or inches; a mirrored frame (a TCP axis swapped or of the wrong
//! sign); a command column of the wrong sign, or two of them swapped; clocks apart. A fault is reported where it explains
//! the difference to a seventh or less, which a wrong guess does not do by chance. A path that no fault explains, and no
//! other TCP in the flange either, is of another robot. One that fits only with a TCP that no tool has is read, and what is identified
//! from it is marked as not to be trusted ([`AnotherArm`]). Figures on 1,400 changed logs: `docs/log.md`.
//!
//! Assumptions: the lost motion sought is far smaller than the path. What a log does not determine is not checked: a short
//! travel in noise, one joint turning on a circle (its mirror image is the same circle), the unit of one joint where no
//! other moves. Then there is no note.
//!
//! Where the kinematics of the machine is what is looked for, or does not matter ([`Kinematics::Unknown`]: tendons, sheaths), a path
//! of another shape is no fault but news, and a sign or an order of the file that explains it is a guess: both are notes. Units
//! stay errors: they are known by the path's size alone, as 57 or 1,000 is more than any machine stretches.
//!
//! How it fails: two faults at once may be reported as a path of another robot.

use super::faults::{Fault, Sample};
use super::note::{ClocksApart, Explained, Note, millimetres};
use super::shape::{fit, fit_with_free_tool, spread};
use super::side_columns;
use super::{Log, clock};
use crate::error::{Error, Place, Result};
use crate::robot::Robot;
use crate::robot::plausible::reach_m;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Fewest places visited that say something about a shape.
const FEWEST: usize = 10;
/// Part of the path's size (2 mm of 1 m) below which a difference is the business of the effects, not of plausibility checks.
const BENIGN: f64 = 0.002;
/// A fault explains a difference where this part of it is left, or less.
pub(crate) const EXPLAINED: f64 = 0.15;
/// Part of the path's size above which an unexplained difference means another robot.
const FOREIGN: f64 = 0.25;
/// Size below which a path is not called another robot's, metres.
const SMALLEST_PATH_M: f64 = 0.005;
/// Misfit that an arm's own calibration errors do not reach, metres: without calibration arms are accurate to 1 to 4 mm.
pub(crate) const CALIBRATION_M: f64 = 0.005;
/// Share of the arm's reach by which a TCP may stand from the robot file's `tool` and still be that of a tool nobody entered: tools and
/// reflectors are mounted within a tenth of it or two, and spindles within a third.
const FAR_TOOL: f64 = 0.5;
/// Share of the reach from which another TCP has to explain the path down to [`LEFT_BY_ARM`]: a lever as long as that bends the path of
/// another arm into nearly the right one, but leaves more than an arm's own errors do.
const LONG_TOOL: f64 = 0.05;
/// What a right arm leaves of its path with the TCP free: geometry errors and the servo's lag, as a share of the path's size and in metres.
/// The random machines of the tests leave at most 0.4 % and 0.8 mm; another arm of half the size leaves 2 mm or more on a circle of 0.3 m.
const LEFT_BY_ARM: f64 = 0.005;
const LEFT_BY_ARM_M: f64 = 0.0015;
/// Where the kinematics is not known: sizes of both paths agree up to this factor, and disagree beyond its square (a unit is
/// wrong by 25 or more).
const ALIKE: f64 = 2.0;
/// With its unit put right a path leaves this part of its size, or less, beside the computed one; noise leaves all of it.
const CORRELATED: f64 = 0.7;

/// What was found to be in order, and what a reader should know.
#[derive(Debug, Clone, Default)]
pub struct Plausibility {
    /// 75th percentile of the distance between measured and computed path after a rigid fit, metres; `None` where the
    /// log has no TCP columns or too few places.
    pub misfit_m: Option<f64>,
    /// 75th percentile of the distance from the path's centre, metres.
    pub spread_m: f64,
    /// Suspicions that do not stop the work.
    pub notes: Vec<Note>,
    /// Why results from this log cannot be trusted: the robot file seems to be that of another arm.
    pub distrust: Option<AnotherArm>,
}

/// The measured path is that of the robot file only with a TCP that no tool has, or with none at all.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AnotherArm {
    /// 75th percentile of the distances between both paths with the TCP free, mm.
    pub misfit_mm: f64,
    /// Size of the path: 75th percentile of the distances from its centre, mm.
    pub path_mm: f64,
    /// Distance from the robot file's `tool` to the TCP that fits best, mm.
    pub tool_offset_mm: f64,
}

/// How much of the machine the robot file is taken to know.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Kinematics {
    /// Its lengths and joints are those of the machine, up to what an effect changes.
    #[default]
    OfFile,
    /// Its joints are those of the machine; how they move the TCP is not known.
    Unknown,
}

/// Refuses a log whose units, axes or clocks cannot be right for this robot; reports what else is implausible.
pub fn check(log: &Log, robot: &Robot) -> Result<Plausibility> {
    check_for(log, robot, Kinematics::OfFile)
}

/// The same for a machine whose kinematics may be another than the robot file's.
pub fn check_for(log: &Log, robot: &Robot, kinematics: Kinematics) -> Result<Plausibility> {
    let mut found = Plausibility::default();
    side_columns::swapped(log, robot)?;
    side_columns::sensors(log, robot, kinematics == Kinematics::OfFile, &mut found.notes)?;
    side_columns::times(log, robot, &mut found.notes)?;
    clock::sensors(log, robot)?;
    side_columns::samples_without_times(log, &mut found.notes);
    side_columns::limits(log, robot, &mut found.notes);
    let sample = Sample::take(log);
    if sample.commands.len() >= FEWEST {
        shape(log, robot, kinematics, &sample, &mut found)?;
    }
    Ok(found)
}

/// Why gaps from these logs cannot be trusted, where the robot file seems to be that of another arm.
pub(crate) fn distrust(logs: &[Log], robot: &Robot) -> Option<AnotherArm> {
    logs.iter().find_map(|log| {
        let (sample, mut found) = (Sample::take(log), Plausibility::default());
        if sample.commands.len() >= FEWEST {
            shape(log, robot, Kinematics::OfFile, &sample, &mut found).ok()?;
        }
        found.distrust
    })
}

/// A measurement that another clock explains: a note, or refused where the clocks are far apart.
fn shifted(log: &Log, shift_s: f64) -> Result<Note> {
    if shift_s.abs() > clock::APART_S {
        return Err(clock::refused(log, "measured positions", shift_s));
    }
    Ok(Note::ClocksApart(ClocksApart { by_s: shift_s }))
}

/// What a log is expected to hold.
const PATH_OF_FILE: &str = "the path computed with the robot file from the commands";

fn shape(log: &Log, robot: &Robot, kinematics: Kinematics, sample: &Sample, found: &mut Plausibility) -> Result<()> {
    let computed = sample.computed(robot);
    let as_read = fit(&computed, &sample.measured, false);
    let size = spread(&sample.measured).max(spread(&computed));
    found.misfit_m = Some(as_read.misfit_m);
    found.spread_m = size;
    if as_read.misfit_m.is_nan() || as_read.misfit_m <= BENIGN * size {
        return Ok(());
    }
    let moving = log.moving_axes();
    let tried: Vec<(Fault, f64)> =
        Fault::all(robot, &log.cmd).into_iter().map(|f| (f, f.corrected(robot, sample, &computed).misfit_m)).collect();
    let refused = |(text, first): (String, Fault)| {
        let mended = first
            .mended(robot)
            .map_or(String::new(), |entry| format!(" (correct the file, or use a column map with `{entry}`)"));
        Err(Error::bad(Place::file(&log.name), text, format!("{PATH_OF_FILE}{mended}")))
    };
    let known = kinematics == Kinematics::OfFile;
    let units: Vec<(Fault, f64)> = tried.iter().copied().filter(|t| known || t.0.is_of_units(log)).collect();
    if let Some((why, first)) = explained(&units, robot, as_read.misfit_m) {
        return refused((why.to_string(), first));
    }
    if !known {
        let whole: Vec<(Fault, f64)> = units.iter().copied().filter(|u| !u.0.is_of_one_joint()).collect();
        if let Some(text) = of_another_size(&whole, robot, sample, &computed).or_else(|| alone(&units, robot, log)) {
            return refused(text);
        }
        if let Some((why, _)) = explained(&tried, robot, as_read.misfit_m) {
            found.notes.push(Note::Explained(why));
            return Ok(());
        }
    }
    if let Some((shift_s, left)) = best_clock(log, robot, sample)
        && left <= EXPLAINED * as_read.misfit_m
    {
        found.notes.push(shifted(log, shift_s)?);
        return Ok(());
    }
    if moving.len() < 2 || spread(&sample.measured) < SMALLEST_PATH_M {
        return Ok(());
    }
    if as_read.misfit_m <= FOREIGN * size {
        if known && as_read.misfit_m > CALIBRATION_M {
            another_arm(robot, sample, &computed, found);
        }
        return Ok(());
    }
    foreign_path(log, robot, known, sample, &computed, found)
}

/// A note where the path differs by more than an arm's calibration errors, but not so much that it is certainly another arm's.
fn another_arm(robot: &Robot, sample: &Sample, computed: &[Vector3<f64>], found: &mut Plausibility) {
    let freed = Freed::of(robot, sample, computed);
    found.notes.push(Note::Uncalibrated {
        misfit_m: found.misfit_m.unwrap_or(0.0),
        path_m: found.spread_m,
        tool_off_m: if freed.misfit_m > CALIBRATION_M { None } else { Some(freed.offset_m.into()) },
    });
    found.distrust = freed.distrust(robot, found.spread_m);
}

/// The path with the TCP free in the flange.
struct Freed {
    /// 75th percentile of the distances that are left, m.
    misfit_m: f64,
    /// From the robot file's `tool` to the TCP that fits best, in the axes of the tool, m.
    offset_m: Vector3<f64>,
}

impl Freed {
    fn of(robot: &Robot, sample: &Sample, computed: &[Vector3<f64>]) -> Self {
        let frames: Vec<_> = sample.commands.iter().map(|q| robot.forward(q).rotation).collect();
        let (fit, offset_m) = fit_with_free_tool(computed, &frames, &sample.measured);
        Self { misfit_m: fit.misfit_m, offset_m }
    }

    /// Another arm: whatever TCP is tried, the path differs by more than calibration errors; or only a TCP fits that no tool has.
    fn distrust(&self, robot: &Robot, size_m: f64) -> Option<AnotherArm> {
        let (far_m, reach_m) = (self.offset_m.norm(), reach_m(robot));
        let unlike = self.misfit_m > (LEFT_BY_ARM * size_m).max(LEFT_BY_ARM_M);
        let long = far_m > LONG_TOOL * reach_m && unlike;
        let doubted = self.misfit_m > CALIBRATION_M || far_m > FAR_TOOL * reach_m || long;
        doubted.then_some(AnotherArm {
            misfit_mm: self.misfit_m * 1e3,
            path_mm: size_m * 1e3,
            tool_offset_mm: far_m * 1e3,
        })
    }
}

/// A measured path of another shape than the robot file's: noted of a machine whose kinematics is another, or whose tool is;
/// refused otherwise.
fn foreign_path(
    log: &Log,
    robot: &Robot,
    known: bool,
    sample: &Sample,
    computed: &[Vector3<f64>],
    found: &mut Plausibility,
) -> Result<()> {
    let (misfit_m, size) = (found.misfit_m.unwrap_or(0.0), found.spread_m);
    if !known {
        found.notes.push(Note::OtherShape { misfit_m, path_m: size });
        return Ok(());
    }
    let freed = Freed::of(robot, sample, computed);
    if freed.misfit_m <= 0.5 * FOREIGN * size {
        found.notes.push(Note::OtherTool { tool_off_m: freed.offset_m.into() });
        found.distrust = freed.distrust(robot, size);
        return Ok(());
    }
    let text = format!(
        "a measured path of another shape ({} of misfit on a path of {})",
        millimetres(freed.misfit_m),
        millimetres(size)
    );
    Err(Error::bad(
        Place::file(&log.name),
        text,
        format!("{PATH_OF_FILE}: check robot file, units, order and clock of the columns"),
    ))
}

/// The faults that explain the difference, and the first of them.
fn explained(tried: &[(Fault, f64)], robot: &Robot, misfit_m: f64) -> Option<(Explained, Fault)> {
    let least = tried.iter().map(|t| t.1).fold(f64::INFINITY, f64::min);
    let alike: Vec<Fault> = tried.iter().filter(|t| t.1 <= 1.5 * least).take(3).map(|t| t.0).collect();
    let first = *alike.first().filter(|_| least <= EXPLAINED * misfit_m)?;
    let mistakes = alike.iter().map(|f| f.named(robot)).collect();
    Some((Explained { mistakes, left_m: least, misfit_m }, first))
}

/// Units that make paths of one size out of two that are far apart, and that leave a path and not noise.
fn of_another_size(
    units: &[(Fault, f64)],
    robot: &Robot,
    sample: &Sample,
    computed: &[Vector3<f64>],
) -> Option<(String, Fault)> {
    let measured = spread(&sample.measured);
    let apart = |ratio: f64| if ratio > 1.0 { ratio } else { 1.0 / ratio };
    let as_read = measured / spread(computed);
    if apart(as_read) <= ALIKE * ALIKE {
        return None;
    }
    let right = |t: &&(Fault, f64)| {
        t.1 <= CORRELATED * measured && t.0.ratio(robot, sample, computed).is_some_and(|r| apart(r) <= ALIKE)
    };
    let found: Vec<Fault> = units.iter().filter(right).map(|t| t.0).collect();
    let said: Vec<String> = found.iter().map(|f| f.named(robot).to_string()).collect();
    let text = format!(
        "a measured path {} times the size of the computed one: {}",
        if as_read < 0.1 { format!("{as_read:.4}") } else { format!("{as_read:.1}") },
        said.join("; or ")
    );
    found.first().map(|first| (text, *first))
}

/// The unit of one joint by the path on which it moves alone: the path of all joints hides it where the others move far more.
fn alone(units: &[(Fault, f64)], robot: &Robot, log: &Log) -> Option<(String, Fault)> {
    let one = |axis: usize| {
        let sample = Sample::of_joint_alone(log, axis);
        if sample.commands.len() < FEWEST || spread(&sample.measured) < SMALLEST_PATH_M {
            return None;
        }
        let computed = sample.computed(robot);
        let of_joint = |f: Fault| {
            f.of_joint(axis, robot.axis(axis).kind).map(|f| (f, f.corrected(robot, &sample, &computed).misfit_m))
        };
        let units: Vec<(Fault, f64)> = units.iter().filter_map(|u| of_joint(u.0)).collect();
        let (text, first) = of_another_size(&units, robot, &sample, &computed)?;
        Some((format!("where {} moves alone, {text}", robot.axis(axis).name), first))
    };
    (0..robot.dof()).find_map(one)
}

/// Shift in s of the commands that fits the measurement best, and the misfit it leaves.
fn best_clock(log: &Log, robot: &Robot, sample: &Sample) -> Option<(f64, f64)> {
    if log.poses {
        return None;
    }
    let t0 = log.t_s.first()?;
    let whole_s = log.t_s.last()? - t0;
    let thin = (sample.rows.len() / 200).max(1);
    let mut q = vec![0.0; robot.dof()];
    let left = |shift: f64| -> f64 {
        let (mut from, mut to) = (Vec::new(), Vec::new());
        for (&row, p) in sample.rows.iter().zip(&sample.measured).step_by(thin) {
            for (v, c) in q.iter_mut().zip(&log.cmd) {
                *v = clock::at(&log.t_s, c, log.t_s[row] + shift).unwrap_or(*v);
            }
            from.push(robot.tcp_m(&q));
            to.push(*p);
        }
        fit(&from, &to, false).misfit_m
    };
    Some(clock::best(whole_s, left))
}
