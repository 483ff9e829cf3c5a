//! Programs to record: what a robot should run so that every gap can be identified, with the precision to expect.
//!
//! - [`options`]: which program, and the choices of a user.
//! - [`work`]: where to do it: in the middle of the programs that are to be compensated; [`posture`]: else a pose in which every
//!   joint moves the TCP, and from which the instrument sees it.
//! - [`motions`]: the programs. `static`: bidirectional dwells of one joint after another. `path`: all joints at once, slowly, by
//!   one sine each. `excitation`: all joints by three sines each, faster, with pauses.
//! - `ballbar`: circles about the centre of a double ballbar, at the bar's length.
//! - [`precision`]: standard deviation of every half gap from the sensitivities of the readings and the stated noise, with the
//!   instrument's own unknowns, lags and friction estimated beside it.
//! - [`mod@note`]: what a reader of the plan should know.
//! - [`document`]: the plan as it is written; [`vendor`]: a static test in the robot's own language, of the `legs` from rest to rest.
//!
//! The plan reports before the measurement what an instrument cannot show: a joint that it hardly sees gets a reason instead of a figure.
//! It does not know of obstacles.

mod ballbar;
pub mod document;
mod legs;
pub(crate) mod motions;
pub mod note;
pub mod options;
pub(crate) mod posture;
pub(crate) mod precision;
pub mod vendor;
pub mod work;

use super::path::{Envelope, EnvelopeOptions};
use crate::error::{Error, Result};
use crate::machine::measurement::Instrument;
use crate::robot::Robot;
pub use note::{Note, Reason};
pub use options::{Kind, Options};
use precision::Precision;

/// A program to record.
#[derive(Debug, Clone)]
pub struct Recording {
    /// Kind of the recording.
    pub kind: Kind,
    /// Joints about which it moves, rad or m.
    pub pose: Vec<f64>,
    /// Times (s) and joint vectors (rad or m), straight between them.
    pub rows: Vec<(f64, Vec<f64>)>,
    /// Duration, s.
    pub duration_s: f64,
    /// Expected uncertainty of each joint's half gap.
    pub precision: Vec<Precision>,
    /// What a reader should know.
    pub notes: Vec<Note>,
}

/// Plans a program. Where gears turn by sums of axes (`gap_of`), one gear moves at a time, and the axes as that needs.
///
/// # Errors
/// Where the pose is beyond a limit, no pose is visible, or the windows leave no room to move.
pub fn plan(robot: &Robot, kind: Kind, options: &Options) -> Result<Recording> {
    if let Some(pose) = &options.pose {
        for (joint, &q) in robot.axis_joints().zip(pose) {
            if joint.limits.is_some_and(|[lo, hi]| q < lo || q > hi) {
                let found = format!("{} at {:.3} {}", joint.name, joint.kind.to_user_unit(q), joint.kind.unit());
                return Err(Error::setting("pose", found, "a pose within the limits of the joints"));
            }
        }
    }
    let Some(by_gears) = robot.of_gears() else {
        let mut recording = of_axes(robot, kind, options)?;
        recording.notes.extend(robot.by_joints_alone().map(Note::JointsAlone));
        return Ok(recording);
    };
    let mut pose = match &options.pose {
        Some(pose) => pose.clone(),
        None => posture::find(robot, options)?,
    };
    robot.to_gears(&mut pose);
    let mut recording = of_axes(&by_gears, kind, &Options { pose: Some(pose), ..options.clone() })?;
    robot.from_gears(&mut recording.pose);
    recording.rows.iter_mut().for_each(|(_, q)| robot.from_gears(q));
    for (axis, joint) in robot.axis_joints().enumerate() {
        let beyond = |[lo, hi]: [f64; 2]| recording.rows.iter().any(|(_, q)| q[axis] < lo || q[axis] > hi);
        if joint.limits.is_some_and(beyond) {
            let found = format!("a motion in which {} leaves its limits", joint.name);
            let error = Error::setting("pose", found, "another pose, or a smaller travel");
            return Err(error.mended_by(&["travel_deg", "travel_mm"]));
        }
    }
    let sums = robot.gap_of.iter().filter(|g| !g.others.is_empty());
    for gear in sums {
        let joint = robot.axis(gear.axis).name.clone();
        recording.notes.push(Note::SumOfAxes { joint, sum: robot.sum_text(gear) });
    }
    Ok(recording)
}

/// Limits of a motion about a pose.
fn envelope_options(pose: Vec<f64>, duration_s: f64, options: &Options) -> EnvelopeOptions {
    EnvelopeOptions {
        pose: Some(pose),
        duration_s,
        rate_hz: options.rate_hz,
        speed_m_s: options.speed_m_s,
        travel_rad: options.travel_rad,
        travel_m: options.travel_m,
    }
}

/// Circles for a double ballbar.
fn by_ballbar(robot: &Robot, kind: Kind, options: &Options, bar_m: f64) -> Result<Recording> {
    let Instrument::Distance { centre_m } = options.instrument else {
        return Err(Error::setting("bar_mm", "a bar without a centre", "the centre of the ballbar"));
    };
    if kind != Kind::Path {
        let found = format!(
            "{} program, in which the distance from the centre changes by centimetres: a double ballbar reads about 1 mm either way of its \
             length",
            if kind == Kind::Static { "a static" } else { "an excitation" }
        );
        let expected =
            "a path, which is planned as circles about the centre; or a draw-wire sensor, which has that range";
        return Err(Error::setting("ballbar", found, expected).mended_by(&["draw_wire"]));
    }
    let found = ballbar::plan(robot, centre_m, bar_m, options)?;
    let duration_s = found.rows.last().map_or(0.0, |r| r.0);
    let ballbar::Circles { pose, rows, precision, notes } = found;
    Ok(Recording { kind, pose, rows, duration_s, precision, notes })
}

/// The same where every gear turns by its own axis.
fn of_axes(robot: &Robot, kind: Kind, options: &Options) -> Result<Recording> {
    if let Some(bar_m) = options.bar_m {
        return by_ballbar(robot, kind, options, bar_m);
    }
    let mut notes = Vec::new();
    let sight = posture::Sight::new(robot, options);
    let pose = match &options.pose {
        Some(pose) => pose.clone(),
        None => posture::find(robot, options)?,
    };
    let sight = sight.facing(&pose);
    if !sight.sees(&pose) {
        let found = "a pose that the tracker does not see, because the arm is between them";
        return Err(Error::setting("pose", found, "another pose, or another position of the tracker"));
    }
    let duration_s = match kind {
        Kind::Static => f64::INFINITY,
        _ => options.duration_s,
    };
    let mut envelope = Envelope::new(robot, &envelope_options(pose.clone(), duration_s, options));
    sight.narrow(&mut envelope, kind, &mut notes);
    let (rows, precision) = match kind {
        Kind::Static => {
            let test = motions::static_test(&envelope, options, &mut notes)?;
            let precision = precision::of_static(robot, &test, options);
            (test.rows, precision)
        }
        Kind::Path | Kind::Excitation => {
            let rows = visible(&mut envelope, kind, &sight, &mut notes)?;
            let precision = precision::of_motion(robot, &rows, options);
            (rows, precision)
        }
    };
    if options.tracker_m.is_some() {
        let hidden = rows.iter().filter(|(_, q)| !sight.sees(q)).count();
        if hidden > 0 {
            notes.push(Note::BeamInterrupted { hidden, rows: rows.len() });
        }
    }
    notes.extend(of_distance(robot, &rows, options));
    let rows = motions::without_straight_rows(rows);
    let duration_s = rows.last().map_or(0.0, |r| r.0);
    Ok(Recording { kind, pose, rows, duration_s, precision, notes })
}

/// A motion of all joints in windows that are narrowed about the pose until the tracker sees all of it: joints that are each seen alone
/// may hide the reflector together.
fn visible(
    envelope: &mut Envelope,
    kind: Kind,
    sight: &posture::Sight,
    notes: &mut Vec<Note>,
) -> Result<motions::Rows> {
    const STEP: f64 = 0.9;
    const MOST: i32 = 16;
    let (pose, whole) = (envelope.pose.clone(), envelope.window.clone());
    let mut rows = motions::all_joints(envelope, kind)?;
    for step in 1..=MOST {
        if rows.iter().all(|(_, q)| sight.sees(q)) {
            break;
        }
        let share = STEP.powi(step);
        for (axis, window) in envelope.window.iter_mut().enumerate() {
            *window = whole[axis].map(|end| pose[axis] + share * (end - pose[axis]));
        }
        rows = motions::all_joints(envelope, kind)?;
        if rows.iter().all(|(_, q)| sight.sees(q)) {
            notes.push(Note::Narrowed { share });
        }
    }
    Ok(rows)
}

/// A note where the distance changes by more than a ballbar reads.
fn of_distance(robot: &Robot, rows: &[(f64, Vec<f64>)], options: &Options) -> Option<Note> {
    /// A double ballbar reads about a millimetre either way of its length.
    const RANGE_M: f64 = 2e-3;
    let Instrument::Distance { centre_m } = &options.instrument else { return None };
    let away = rows.iter().map(|(_, q)| (robot.tcp_m(q) - centre_m).norm());
    let [nearest, farthest] = away.fold([f64::INFINITY, 0.0], |[lo, hi], v| [v.min(lo), v.max(hi)]);
    (farthest - nearest > RANGE_M).then_some(Note::ForDrawWire { nearest_m: nearest, farthest_m: farthest })
}
