//! Rewriting a vendor program: read whole, cut into runs, each run through the engine, what comes out back as edits.
//!
//! ```text
//! texts -> Format::parse -> Script -> runs (run, way, clock) -> Engine -> edits -> Document::patches -> texts -> read again
//! ```
//!
//! Modules:
//! - [`task`]: what is asked.
//! - [`coverage`]: how much can be edited, and why not the rest ([`cause`]).
//! - [`run`]: where positions follow each other; [`poses`] solves Cartesian targets by their [`configuration`] and writes them
//!   again, [`way`] follows straight TCP paths, `turns`: where joints turn on them; `circles`: arcs through joint targets; [`clock`] tells
//!   durations; [`fading`]: friction where none can be determined.
//! - [`approach`]: targets that are reached from one side.
//! - [`rates`]: speed and acceleration limits; `spread`: whether spread steps are worth it; [`stops`]: how long new exact stops take.
//! - `bands`: dead bands; `collected`: runs through the engine; `demands`: what must hold before anything is written.
//! - `again`: first moves of a program that runs again from its start.
//! - `edited`: the edits of a program, from its runs to what the report tells; `reasons`: why steps stay as they are.
//! - [`edits`]: points that came out -> values and new points of the program; `unplaced`: what finds no place; `arcs`: pieces of arcs that
//!   are split; `out`: where such a point stands; `gain`: what it gains; `whole`: goals of moves that stay whole; `corners`: corners that
//!   must not overlap.
//! - `installation`: where the robot stands in the controller's world, and its software limits.
//! - `wrists`: what is edited alike whatever letters for the wrist mean.
//! - `asked`: calls that nobody knows and moves wait for.
//! - [`writing`]: edits into texts; [`notes`]: what the program or the robot file does not say.
//! - [`verify`]: the result is read again before anyone gets it; `recognised`, `retraced`: was the program rewritten before?
//! - [`job`]: from file to file; [`context`]: what is looked up beside it.
//! - [`path`]: a program as one path in the joints, for those who run it on a machine.
//! - [`change`]: what differs, move by move, in degrees and micrometres: dry runs and golden files.

mod again;
pub(crate) mod approach;
mod arcs;
mod asked;
mod bands;
pub(crate) mod cause;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod change;
mod circles;
pub(crate) mod clock;
mod collected;
pub(crate) mod configuration;
pub(crate) mod context;
mod corners;
pub(crate) mod coverage;
mod demands;
mod edited;
pub(crate) mod edits;
pub(crate) mod fading;
mod gain;
mod installation;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod job;
pub(crate) mod notes;
mod out;
pub mod path;
pub(crate) mod poses;
pub(crate) mod rates;
mod reasons;
mod recognised;
mod retraced;
pub(crate) mod run;
mod spread;
pub(crate) mod stops;
pub(crate) mod task;
mod turns;
pub(crate) mod unplaced;
pub(crate) mod verify;
pub(crate) mod way;
mod whole;
mod wrists;
pub(crate) mod writing;

use super::equation2::Law;
use super::offset::Offset;
use super::stats::RewriteStats;
use crate::error::Result;
use crate::program::script::{At, Format, Note, Script, Text};
use crate::robot::frames::Missing;
use change::Change;
use coverage::Coverage;
use edited::Edited;
use run::{Choice, Gap};
use std::collections::BTreeMap;
pub use task::{Choices, Task};
use unplaced::Unplaced;

/// A rewritten program, in memory.
pub struct Done {
    /// The rewritten files, in the order of the originals.
    pub texts: Vec<Text>,
    /// As it was.
    pub originals: Vec<Text>,
    /// What a reader should know, with lines.
    pub notes: Vec<Note>,
    /// Points, new points, limits and durations.
    pub stats: RewriteStats,
    /// How much of the program was edited, and why the rest was not.
    pub coverage: Coverage,
    /// What the rewritten program reads as when it is read again.
    pub written: verify::Written,
    /// What the report tells of it.
    pub report: EditReport,
}

/// What a report tells of the edits of a program.
pub struct EditReport {
    /// Lines of the points of violations, by the number of the point.
    pub lines: BTreeMap<u64, At>,
    /// Frames, tools and calls that moves wait for.
    pub missing: Missing,
    /// Where directions are lost.
    pub gaps: Vec<Gap>,
    /// New points that could not be placed.
    pub unplaced: Unplaced,
    /// The first changes, as many as were asked for.
    pub changes: Vec<Change>,
    /// Number of all changes, listed or not.
    pub changes_total: usize,
    /// Number of runs that start elsewhere than the program: with unknown directions.
    pub anew: usize,
    /// Number of runs.
    pub runs: usize,
    /// Its numbers are those of a program that this compensator has been through.
    pub looks_rewritten: bool,
}

impl Done {
    /// No byte differs.
    pub fn unchanged(&self) -> bool {
        self.texts.iter().zip(&self.originals).all(|(a, b)| a.bytes == b.bytes)
    }
}

/// Axes that some joint target of the script names.
fn commanded(script: &Script, dof: usize) -> Vec<bool> {
    let joints = || script.targets.iter().filter(|t| t.pose.is_none());
    (0..dof).map(|k| joints().any(|t| t.values.get(k).is_some())).collect()
}

/// Travel of each gear over which its offset forgets what was before a turn, rad or m: where there is no friction, and no step is spread.
fn forgets_over(task: &Task, deadband: &[f64]) -> Option<Vec<f64>> {
    /// Times the step of both gaps together.
    const OVER: f64 = 8.0;
    let options = task.options;
    let spread = options.ramp.iter().any(|r| *r > 0.0) || !options.ramps_after.is_empty();
    let gaps = task.compensator.joints.iter().all(|j| j.friction.is_none());
    let step = |axis: usize| task.compensator.on(axis).map_or(0.0, |j| Offset::new(j).largest_step());
    let over = deadband.iter().enumerate().map(|(axis, own)| own.max(OVER * step(axis)));
    (gaps && !spread && options.law == Law::SymmetricHalfGap).then(|| over.collect())
}

/// The sides from which targets are to be reached; points of a trajectory that the robot passes have none.
fn sides(document: &dyn crate::program::script::Document, task: &Task, deadband: &[f64]) -> approach::Sides {
    let Choices { approach_from, approach_unknown, .. } = task.choices;
    match document.passes_points() {
        true => approach::Sides::default(),
        false => {
            let how = (*approach_unknown, document.names_missing_axes());
            approach::Sides::new(task.robot, approach_from, how, task.compensator, deadband)
        }
    }
}

/// Takes a program through.
///
/// # Errors
/// Bad input where it cannot be read; refused where coverage is too low, the format cannot hold the gap, or an edit cannot be
/// said in it.
pub fn rewrite(format: &dyn Format, texts: Vec<Text>, task: &Task) -> Result<Done> {
    let held = installation::with_bases(task.robot, &task.choices.frames);
    let task = &Task { robot: held.as_ref().unwrap_or(task.robot), ..*task };
    let document = format.parse(texts, task.robot.axes())?;
    let script = document.script();
    let limited = installation::limited(script, &task.choices.frames, task.robot);
    let robot = limited.as_ref().map_or(task.robot, |l| &l.0);
    let task = &Task { robot, ..*task };
    demands::require_posture(task)?;
    demands::require_positions(script, task.robot)?;
    let (mut notes, reduced) = notes::uncoupled(format, task);
    let task = &Task { compensator: reduced.as_ref().unwrap_or(task.compensator), ..*task };
    notes.extend(notes::missing(script));
    notes.extend(notes::only_whole_numbers(script));
    notes.extend(notes::diameter_unstated(script));
    let root = installation::root(script, &task.choices.frames)?;
    notes.extend(installation::note(task.robot, root.as_ref()));
    notes.extend(limited.as_ref().map(|l| l.1.clone()));
    notes.extend(notes::unread(script));
    let left_out = reasons::left_out(script, task.choices);
    let excluded = |k: usize| left_out.get(k).is_some_and(Option::is_some);
    let deadband = bands::deadbands(script, task);
    let commanded = commanded(script, task.robot.dof());
    let crossing_s = approach::crossing_s(task);
    let forgets_over = forgets_over(task, &deadband);
    let mut choice = Choice {
        forgets_over: forgets_over.as_deref(),
        crossing_s: &crossing_s,
        commanded: &commanded,
        by_place: task.compensator.joints.iter().filter(|j| j.depends_on_position()).map(|j| j.axis).collect(),
        robot: task.robot,
        deadband: &deadband,
        tcp_speed_m_s: task.options.tcp_speed_m_s,
        certain_speed_m_s: task.choices.speed_m_s,
        excluded: &excluded,
        solve_within_m: task.choices.solve_within_m.filter(|_| document.takes_joints_for_poses()),
        as_poses: !task.choices.leave_poses,
        on_way: &|step, share| document.on_way(step, share),
        approach: sides(document.as_ref(), task, &deadband),
        sides_given: task.options.initial_direction.iter().any(|d| *d != 0),
        rounds: true,
        joins: true,
    };
    let unknown_arm = notes::unknown_arm(format, task.robot);
    let edited = edited::by_approach(document.as_ref(), task, &mut choice, unknown_arm.as_ref())?;
    let Edited { mut edits, mut stats, patches, stops, runs, report, .. } = edited;
    notes.extend(edited.of_runs);
    let coverage = edited.reasons.coverage(script, task.choices, &left_out, &edits);
    demands::require_coverage(&coverage, task.choices, script)?;
    stats.points = coverage.moves;
    stats.inserted = edits.steps.iter().map(|(_, e)| e.before.len() as u64).sum();
    notes.extend(demands::enough_digits(script, &edits, task)?);
    notes.extend(edited.of_moves);
    notes.extend(script.notes.iter().cloned());
    notes.extend(notes::not_understood(script));
    notes.extend(notes::approached(script, &choice.approach, &commanded, &runs, &edits));
    notes.extend(notes::approached_anew(task.robot, &choice.approach, &runs, &edits));
    notes.splice(0..0, notes::unsolved(format, document.as_ref(), task.choices));
    drop(runs);
    let originals = script.texts.clone();
    let (texts, written) = writing::write(format, document, &mut edits, patches, task)?;
    if !written.halts.is_empty() {
        let stops_s = stops.and_then(|s| s.duration_s(&written.halts));
        stats.duration_s = stats.duration_s.and_then(|[before, after]| Some([before, after + stops_s?]));
    }
    Ok(Done { texts, originals, notes, stats, coverage, written, report })
}
