//! The static test (Zhang (2023), Table 1 and Figure 5): every angle reached from below and from above, a dwell, some cycles.
//!
//! The method, one module for each step:
//! - [`readings`]: dwells of all logs; which joint each one tests; pairs of the two approaches of one cycle.
//! - [`frame`]: the tracker's frame from both approaches averaged.
//! - [`deviation`]: each joint's deviation from its command by the inverse of that one joint. Half the difference between the
//!   two approaches is the half gap: everything that does not depend on the side (geometry, gravity, frame) cancels.
//! - `tested`: what the pairs of one joint gave, place by place; `stop`: a dial that reads nothing.
//! - [`creep`]: what the servo still works off within a dwell, so that the gap is that at rest.
//! - [`drift`]: what moves steadily, which looks like a gap.
//! - [`summary`]: gross errors, pure error between cycles, intervals, and the test whether the gap varies with position.
//! - [`polynomial`], [`knots`]: two families of curves for a gap that varies.
//! - [`schedule`]: their average, weighted by how well each explains the data for its size.
//! - [`document`], [`display`]: the result as a document and as a table.
//!
//! A joint that was reached from one side only, that barely moves the TCP, or whose dwells the tracker missed gets no gap and a
//! note that says why.

pub(crate) mod creep;
pub(crate) mod deviation;
#[cfg(feature = "cli")]
pub(crate) mod display;
pub mod document;
pub(crate) mod drift;
pub(crate) mod frame;
pub(crate) mod knots;
pub(crate) mod polynomial;
pub(crate) mod readings;
pub(crate) mod schedule;
mod stop;
pub(crate) mod summary;
mod tested;

use crate::effects::GapCurve;
use crate::error::{Error, Place, Result};
use crate::gaps::note::static_test::{Note, Remark};
use crate::gaps::{self, GapPoint, Gaps, JointGap};
use crate::identify::gears::geared;
use crate::identify::scalar::{self, Setup};
use crate::log::Log;
use crate::log::dwells::DwellOptions;
use crate::machine::measurement::Instrument;
use crate::robot::Robot;
use frame::Frame;
use nalgebra::Isometry3;
use schedule::Schedule;
use std::collections::HashSet;
use summary::Summary;

/// Which curve is exported where a gap varies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Knots {
    /// PCHIP with a knot at every tested angle, on the average of all curves: the most accurate.
    #[default]
    All,
    /// The single best curve of few parameters: PCHIP with few knots, or a polynomial where polynomials hold nearly all
    /// weight.
    Few,
}

/// Settings of the identification.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// How dwells are found in a log.
    pub dwell: DwellOptions,
    /// How many knots a curve over position has.
    pub knots: Knots,
    /// Base frame -> tracker frame, where it is known; else it is found from the logs.
    pub registration: Option<Isometry3<f64>>,
    /// What is known of an instrument with a single reading.
    pub setup: Setup,
}

/// One joint's test, with everything that its figures are based on.
#[derive(Debug, Clone)]
pub struct JointTest {
    /// Number of the axis, from 0.
    pub axis: usize,
    /// Half gap of the joint with its intervals.
    pub summary: Summary,
    /// Where the gap varies with position.
    pub schedule: Option<Schedule>,
    /// Approaches without a partner from the other side at a tested angle.
    pub unpaired: usize,
    /// Measured after the gear instead of through the TCP.
    pub measured: bool,
}

/// What the test found.
#[derive(Debug, Clone)]
pub struct Found {
    /// Half gaps of the joints, for a compensator.
    pub gaps: Gaps,
    /// In the order of `gaps.joints`.
    pub joints: Vec<JointTest>,
    /// How the tracker's frame was found, where it was needed.
    pub frame: Option<Frame>,
}

fn each_once(logs: &[Log]) -> Result<()> {
    let mut seen = HashSet::new();
    match logs.iter().find(|l| !seen.insert(&l.sha256)) {
        None => Ok(()),
        Some(twice) => {
            let expected = "each log once: its cycles would count twice";
            Err(Error::bad(Place::file(&twice.name), "a log that was given before (same SHA-256)", expected))
        }
    }
}

/// The half gap at each tested place of an axis.
fn points(axis: usize, summary: &Summary) -> impl Iterator<Item = GapPoint> {
    summary.angles.iter().map(move |angle| GapPoint {
        axis,
        at: angle.at,
        half_gap: angle.mean,
        ci95: angle.ci95,
        cycles: angle.cycles.len(),
        per_cycle: angle.cycles.clone(),
    })
}

/// Finds the half gap of every joint that the logs test, by gears where gears turn by sums of axes.
pub fn identify(robot: &Robot, logs: &[Log], options: &Options) -> Result<Found> {
    let by_gears = geared(robot, logs);
    let mut found = of_axes(&by_gears.robot, &by_gears.logs, options)?;
    found.gaps.robot_sha256 = robot.fingerprint();
    found.gaps.notes.extend(by_gears.notes);
    Ok(found)
}

/// The same where every gear turns by its own axis.
fn of_axes(robot: &Robot, logs: &[Log], options: &Options) -> Result<Found> {
    each_once(logs)?;
    let mut readings = readings::collect(robot, logs, &options.dwell)?;
    let frame = frame::find(robot, logs, &readings, options.registration)?;
    let instruments: Vec<Option<Instrument>> = logs
        .iter()
        .map(|log| {
            let scalar = log.tcp_m.is_empty() && log.instruments.has_scalar();
            let read = || scalar::refuse_still(log).and_then(|()| scalar::instrument(robot, log, &options.setup));
            scalar.then(read).transpose()
        })
        .collect::<Result<_>>()?;
    let tables = tested::half_gaps(robot, logs, &mut readings, frame.as_ref(), &instruments);
    let mut gaps = Gaps { registration: frame.as_ref().map(|f| f.found.clone()), ..Gaps::new(robot, logs) };
    gaps.notes.extend(readings.notes.into_iter().map(gaps::Note::from));
    if let Some(f) = &frame {
        gaps.notes.splice(0..0, f.distrust.iter().cloned().map(gaps::Note::Distrust));
        gaps.notes.extend(f.notes.iter().cloned().map(gaps::Note::from));
        gaps.distrust.clone_from(&f.distrust);
    }
    let mut joints = Vec::new();
    for table in tables {
        let joint = robot.axis(table.axis);
        let note = |remark| gaps::Note::from(Note::Joint { joint: joint.name.clone(), remark });
        let Some(summary) = summary::summarise(&table) else {
            gaps.notes.push(note(Remark::OneValue));
            continue;
        };
        let schedule = summary.varies().then(|| schedule::build(&summary));
        gaps.notes.extend(summary::notes(&table, &summary, joint.kind).into_iter().map(note));
        if let Some(s) = &schedule {
            gaps.notes.extend(s.notes.iter().cloned().map(note));
        }
        gaps.points.extend(points(table.axis, &summary));
        gaps.joints.push(JointGap {
            axis: table.axis,
            half_gap: summary.half_gap,
            ci95: summary.ci95,
            significant: summary.ci95[0] > 0.0 || summary.ci95[1] < 0.0,
            sides: None,
            schedule: schedule.as_ref().map(|s| exported(s, options.knots)),
            varies_p_value: summary.gate.as_ref().map(|g| g.p_value),
            stiction: None,
            stiction_p_value: None,
        });
        joints.push(JointTest {
            axis: table.axis,
            summary,
            schedule,
            unpaired: table.unpaired,
            measured: table.measured,
        });
    }
    Ok(Found { gaps, joints, frame })
}

fn exported(schedule: &Schedule, knots: Knots) -> GapCurve {
    match knots {
        Knots::All => schedule.all.clone(),
        Knots::Few => schedule.few.clone(),
    }
}
