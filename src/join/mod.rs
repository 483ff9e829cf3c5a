//! A tracker's and a controller's recordings of one motion, on one clock.
//!
//! Files, in the order to read: `play` (a joint with a gap along a recording), `clock` (what stamps may mean), `search` (a start
//! from the speeds and the paths), `suspect` (units and axes that cannot be right), `frame` (where a fit begins), `placement` (clock, frame
//! and reflector), [`mod@fit`] (offset and drift with intervals), `variance` (of sums of correlated terms), `rests` (the same
//! from tests that move one joint after another), `best` (which reading of the stamps fits best), [`mod@step`] (a clock that steps),
//! `failure` (why there is no fit), [`mod@write`] (the rows of the joined log), [`mod@note`] (what a reader should know).
//!
//! Method: every reading of the two files' stamps (as they are, or as regular clocks with jitter) is fitted, and the one with the
//! smallest residual is taken; stamps as they are where the difference is small.
//!
//! Assumptions: both recordings show one motion, the robot file is that robot's, the tool does not move in the flange. The offset
//! contains what lies between a command and the motion (servo lag), unless the controller also recorded encoders (`enc_`),
//! by which the clocks are then aligned.
//!
//! Fails: an error where a column is missing, where the recordings share no motion, or where a motion that repeats allows several
//! offsets (`--near-s` chooses one).

#![warn(missing_docs)]

mod best;
mod clock;
pub mod failure;
pub mod fit;
mod frame;
pub mod note;
mod placement;
mod play;
mod rests;
mod search;
pub mod step;
mod suspect;
mod variance;
pub mod write;

pub use fit::Estimate;
pub use note::{AlignedBy, Note};

use crate::error::{Error, Place, Result};
use crate::log::columns::Meaning;
use crate::log::recording::Recording;
use crate::numerics::robust::{median_interval, median_of};
use crate::robot::{JointKind, Robot};
use best::{Best, Recordings};
use clock::Clock;
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::Serialize;
use std::borrow::Cow;

/// The schema that the report names.
pub const SCHEMA: &str = "lostmotion/join/1";
/// Movement of a channel up to which it stands still, rad or m.
const STILL: f64 = 1e-7;
/// Offsets around a given one within which the start is sought, s.
const NEAR_S: f64 = 1.0;
/// Part of the path's size that is left where two recordings are not of one motion.
const NO_COMMON_PATH: f64 = 0.1;

/// Periods of the slower recording within which the offset must be known.
const MOST_SAMPLES: f64 = 3.0;

/// Which rows the joined log has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rows {
    /// Readings of the tracker as they are; commands are interpolated.
    Tracker,
    /// Samples of the controller as they are; readings are interpolated on straight lines.
    Controller,
}

/// What to do.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Whose rows the joined log has.
    pub rows: Rows,
    /// Offset, s, near which the right one lies: for a motion that repeats.
    pub near_s: Option<f64>,
}

impl Default for Options {
    fn default() -> Self {
        Self { rows: Rows::Tracker, near_s: None }
    }
}

impl Options {
    /// Offsets among which the start is sought, s.
    fn within(&self) -> Option<[f64; 2]> {
        self.near_s.map(|near| [near - NEAR_S, near + NEAR_S])
    }
}

/// What is known of the two clocks.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Report {
    /// Always [`SCHEMA`].
    pub schema: &'static str,
    /// The controller's recording.
    pub controller: Part,
    /// The tracker's recording.
    pub tracker: Part,
    /// `cmd` or `enc`: by which the path was computed.
    #[schemars(with = "String")]
    pub aligned_by: AlignedBy,
    /// Controller's time minus the tracker's at `at_tracker_s`.
    pub offset_ms: Interval,
    /// Tracker time to which the offset refers, s.
    pub at_tracker_s: f64,
    /// Parts per million by which the controller's clock runs faster.
    pub drift_ppm: Interval,
    /// What is left of the path, per coordinate.
    pub rms_um: f64,
    /// Correlation of the speeds at the offset found.
    pub speed_correlation: f64,
    /// Number of readings that were left out as gross errors.
    pub outliers: usize,
    /// Number of rows.
    pub rows: usize,
    /// Number of rows without a reading of the tracker.
    pub rows_without_reading: usize,
    /// What a user should know about the joined log.
    #[schemars(with = "Vec<String>")]
    pub notes: Vec<Note>,
}

/// One of the two files.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Part {
    /// Name of the file as messages show it.
    pub name: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
    /// Number of rows.
    pub rows: usize,
    /// Mean rate of its rows, Hz.
    pub rate_hz: f64,
    /// Jitter of the stamps, where a regular clock replaces them.
    pub jitter_ms: Option<f64>,
}

/// An estimate with its 95 % interval.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct Interval {
    /// The estimate.
    pub value: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
}

impl Interval {
    fn of(e: Estimate, per_unit: f64) -> Self {
        Self { value: e.value * per_unit, ci95: [(e.value - e.half_95) * per_unit, (e.value + e.half_95) * per_unit] }
    }
}

/// A joined log: columns by name, and what was found.
#[derive(Debug, Clone)]
pub struct Joined {
    /// What was found.
    pub report: Report,
    /// The joined log.
    pub table: write::Table,
}

/// The arm and its joint positions by gears, where gears turn by sums of axes (`gap_of`): a half gap belongs to its gear.
struct Geared<'a> {
    robot: Cow<'a, Robot>,
    positions: Cow<'a, [Vec<f64>]>,
}

impl<'a> Geared<'a> {
    fn of(robot: &'a Robot, positions: &'a [Vec<f64>]) -> Self {
        let Some(arm) = robot.of_gears() else {
            return Self { robot: Cow::Borrowed(robot), positions: Cow::Borrowed(positions) };
        };
        let mut summed = positions.to_vec();
        let mut q = vec![0.0; positions.len()];
        for row in 0..positions.first().map_or(0, Vec::len) {
            q.iter_mut().zip(positions).for_each(|(to, from)| *to = from[row]);
            robot.to_gears(&mut q);
            q.iter().zip(&mut summed).for_each(|(from, to)| to[row] = *from);
        }
        Self { robot: Cow::Owned(arm), positions: Cow::Owned(summed) }
    }
}

/// What a reader of the offset should know.
fn notes(aligned_by: AlignedBy, fit: &fit::Fit) -> Vec<Note> {
    let mut notes = Vec::new();
    if aligned_by == AlignedBy::Cmd {
        notes.push(Note::ContainsServoLag);
    }
    if let Some(step) = fit.step {
        notes.push(Note::Step { at_tracker_s: step.at_s, by_s: step.by_s, share: step.share });
    }
    if fit.offset_s.half_95 > 1e-3 {
        notes.push(Note::OffsetUncertain { half_95_s: fit.offset_s.half_95 });
    }
    notes
}

/// Joins the recordings.
pub fn join(robot: &Robot, controller: &Recording, tracker: &Recording, options: &Options) -> Result<Joined> {
    let controller_stamps = times(controller)?;
    let tracker_stamps = times(tracker)?;
    let (aligned_by, positions) = joints(robot, controller)?;
    let by_gears = Geared::of(robot, &positions);
    let arm = by_gears.robot.as_ref();
    let seen: Vec<Option<Vector3<f64>>> = tracker.positions_m();
    if seen.is_empty() {
        return Err(missing(tracker, "x_mm, y_mm, z_mm"));
    }
    let readings = [clocks(controller, controller_stamps)?, clocks(tracker, tracker_stamps)?];
    let recordings = Recordings { robot, arm, controller, tracker, positions: &positions, seen: &seen };
    let Best { mut fit, ours, theirs, correlation, .. } =
        recordings.best_clocks(&readings, by_gears.positions.to_vec(), options)?;
    refuse_misfit(&fit, &seen, tracker)?;
    refuse_step(&fit, tracker)?;
    refuse_open(&fit, [ours, theirs], tracker)?;
    // on either side of the step rows are off by half of it
    if let Some(step) = fit.step {
        fit.offset_s.half_95 += 0.5 * step.by_s.abs();
    }
    let table = write::table(robot, controller, tracker, ours, theirs, &fit, options.rows);
    let empty = table.rows_without_reading();
    let notes = notes(aligned_by, &fit);
    let report = Report {
        schema: SCHEMA,
        controller: part(controller, ours),
        tracker: part(tracker, theirs),
        aligned_by,
        offset_ms: Interval::of(fit.offset_s, 1e3),
        at_tracker_s: fit.middle_s,
        drift_ppm: Interval::of(fit.drift, 1e6),
        rms_um: fit.rms_m * 1e6,
        speed_correlation: correlation,
        outliers: fit.outliers,
        rows: table.rows(),
        rows_without_reading: empty,
        notes,
    };
    Ok(Joined { report, table })
}

/// Refuses a start that others fit as well.
fn refuse_repeated(found: &search::Found, options: &Options, tracker: &Recording) -> Result<()> {
    if options.near_s.is_some() || found.alternatives.is_empty() {
        return Ok(());
    }
    let place = Place::file(&tracker.name);
    if found.misfit > NO_COMMON_PATH {
        let text = format!(
            "no clock offset at which both recordings show the same path: at best, {} of its size remains",
            suspect::percent(found.misfit)
        );
        return Err(Error::bad(place, text, "recordings of one motion, and the robot file of that robot"));
    }
    let mut all: Vec<f64> = found.alternatives.iter().copied().chain([found.offset_s]).collect();
    all.sort_by(f64::total_cmp);
    let mut apart: Vec<f64> = all.windows(2).map(|w| w[1] - w[0]).collect();
    let period = median_of(&mut apart).unwrap_or(0.0);
    let text = match all.as_slice() {
        [a, b] => format!("{a:.2} s and {b:.2} s"),
        [a, .., b] => format!("{a:.2} s to {b:.2} s, about every {period:.2} s"),
        _ => String::new(),
    };
    let text =
        format!("a motion that repeats: the recordings agree equally well at {} clock offsets, {text}", all.len());
    let expected = "an approximate offset, or a motion with a part that occurs only once";
    Err(Error::bad(place, text, expected).mended_by(&["near_s"]))
}

/// Refuses a fit that leaves too much of the path: the recordings are of different motions, or the robot file of another robot.
fn refuse_misfit(fit: &fit::Fit, seen: &[Option<Vector3<f64>>], tracker: &Recording) -> Result<()> {
    let points: Vec<Vector3<f64>> = seen.iter().flatten().copied().collect();
    let n = points.len().max(1) as f64;
    let centre = points.iter().sum::<Vector3<f64>>() / n;
    let size = (points.iter().map(|p| (p - centre).norm_squared()).sum::<f64>() / (3.0 * n)).sqrt();
    if fit.rms_m <= NO_COMMON_PATH * size {
        return Ok(());
    }
    let text = format!(
        "a path that differs from the controller's: {:.1} mm rms per coordinate remains of {:.1} mm",
        fit.rms_m * 1e3,
        size * 1e3
    );
    Err(Error::bad(Place::file(&tracker.name), text, "recordings of one motion, and the robot file of that robot"))
}

/// Refuses clocks of which one steps: with one offset and one drift, rows would stand beside the wrong commands before and after it.
fn refuse_step(fit: &fit::Fit, tracker: &Recording) -> Result<()> {
    let Some(step) = fit.step.filter(|s| s.share >= step::CERTAIN) else { return Ok(()) };
    let text = format!(
        "a clock that steps by about {:.1} ms at about {:.1} s of the tracker: the step explains {} of what the fit leaves",
        step.by_s.abs() * 1e3,
        step.at_s,
        suspect::percent(step.share)
    );
    let expected =
        "clocks that run evenly: cut the recordings at the step and join each part, or correct the times of one file";
    Err(Error::bad(Place::file(&tracker.name), text, expected))
}

/// Refuses an offset that is known to no better than some samples: rows would stand beside the wrong commands.
fn refuse_open(fit: &fit::Fit, clocks: [&Clock; 2], tracker: &Recording) -> Result<()> {
    let period = clocks.iter().filter_map(|c| median_interval(&c.t_s)).fold(0.0, f64::max);
    let half = fit.offset_s.half_95;
    if half <= MOST_SAMPLES * period {
        return Ok(());
    }
    let text = format!(
        "a motion that determines the clock offset only within {:.0} ms, which is {:.0} samples",
        half * 1e3,
        half / period.max(f64::MIN_POSITIVE)
    );
    let expected = format!(
        "an offset known within {MOST_SAMPLES} samples: give an approximate offset, or record a faster or longer motion"
    );
    Err(Error::bad(Place::file(&tracker.name), text, expected).mended_by(&["near_s"]))
}

fn missing(of: &Recording, what: &str) -> Error {
    Error::unknown_header(
        Place::file(&of.name),
        format!("no column {what}"),
        "this column under its standard name or through a column map",
    )
}

fn times(of: &Recording) -> Result<&[f64]> {
    of.values(Meaning::Time).ok_or_else(|| missing(of, "t_s"))
}

fn clocks(of: &Recording, stamps: &[f64]) -> Result<Vec<Clock>> {
    let readings = clock::readings(stamps);
    if readings.is_empty() {
        let at = stamps.windows(2).position(|w| w[1] <= w[0]).map_or(0, |i| i + 1);
        let line = of.line.get(at).map(|l| u64::from(*l));
        let place = Place { file: of.name.clone(), line, column: None };
        return Err(Error::bad(
            place,
            "a time that does not increase",
            "times that increase, or jitter about a regular clock",
        ));
    }
    Ok(readings)
}

/// Encoders where the controller recorded all of them throughout, else commands; per axis.
fn joints(robot: &Robot, controller: &Recording) -> Result<(AlignedBy, Vec<Vec<f64>>)> {
    let all = |of: fn(usize) -> Meaning| -> Option<Vec<Vec<f64>>> {
        let whole = |v: &&[f64]| v.iter().all(|x| x.is_finite());
        (0..robot.dof()).map(|a| controller.values(of(a)).filter(whole).map(<[f64]>::to_vec)).collect()
    };
    for axis in 0..robot.dof() {
        if controller.values(Meaning::Command(axis)).is_none() {
            return Err(missing(controller, &Meaning::Command(axis).name(robot)));
        }
    }
    // an encoder of a prismatic joint may count from elsewhere
    let turning = robot.axis_joints().all(|j| j.kind == JointKind::Revolute);
    if let Some(enc) = all(Meaning::Encoder).filter(|_| turning) {
        return Ok((AlignedBy::Enc, enc));
    }
    all(Meaning::Command)
        .map(|c| (AlignedBy::Cmd, c))
        .ok_or_else(|| missing(controller, "of commands without empty cells"))
}

fn part(of: &Recording, clock: &Clock) -> Part {
    let n = clock.t_s.len();
    let span = clock.t_s[n - 1] - clock.t_s[0];
    Part {
        name: of.name.clone(),
        sha256: of.sha256.clone(),
        rows: of.rows(),
        rate_hz: if span > 0.0 { (n - 1) as f64 / span } else { 0.0 },
        jitter_ms: clock.jitter_s.map(|s| s * 1e3),
    }
}
