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
//!   again, [`way`] follows straight TCP paths; `circles`: arcs through joint targets; [`clock`] tells durations; [`fading`]: friction where none can be determined.
//! - [`approach`]: targets that are reached from one side.
//! - [`rates`]: speed and acceleration limits; [`stops`]: how long new exact stops take.
//! - `bands`: dead bands; `collected`: runs through the engine; `demands`: what must hold before anything is written.
//! - [`edits`]: points that came out -> values and new points of the program; `arcs`: pieces of arcs that are split.
//! - `installation`: where the robot stands in the controller's world, and its software limits.
//! - `asked`: calls that nobody knows and moves wait for.
//! - [`writing`]: edits into texts; [`notes`]: what the program or the robot file does not say.
//! - [`verify`]: the result is read again before anyone gets it; `recognised`, `retraced`: was the program rewritten before?
//! - [`job`]: from file to file; [`context`]: what is looked up beside it.
//! - [`path`]: a program as one path in the joints, for those who run it on a machine.
//! - [`change`]: what differs, move by move, in degrees and micrometres: dry runs and golden files.

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
pub(crate) mod coverage;
mod demands;
pub(crate) mod edits;
pub(crate) mod fading;
mod installation;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod job;
pub(crate) mod notes;
pub mod path;
pub(crate) mod poses;
pub(crate) mod rates;
mod recognised;
mod retraced;
pub(crate) mod run;
pub(crate) mod stops;
pub(crate) mod task;
pub(crate) mod verify;
pub(crate) mod way;
pub(crate) mod writing;

use super::stats::RewriteStats;
use crate::error::Result;
use crate::program::script::{At, Document, Edits, Format, Goal, Note, Script, StepKind, Text};
use crate::robot::frames::Missing;
use cause::Cause;
use change::Change;
use collected::Collected;
use coverage::Coverage;
use edits::Unplaced;
use fading::ByClock;
use poses::{Held, Poses};
use run::{Choice, Cut, Gap, Run};
use std::collections::BTreeMap;
pub use task::{Choices, Task};

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
    /// Lines of the points of violations, by the number of the point.
    pub lines: BTreeMap<u64, At>,
    /// How much of the program was edited, and why the rest was not.
    pub coverage: Coverage,
    /// Frames, tools and calls that moves wait for.
    pub missing: Missing,
    /// Where directions are lost.
    pub gaps: Vec<Gap>,
    /// New points that could not be placed.
    pub unplaced: Unplaced,
    /// What the rewritten program reads as when it is read again.
    pub written: verify::Written,
    /// The first changes, as many as were asked for, and how many there are.
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

/// Takes a program through.
///
/// # Errors
/// Bad input where it cannot be read; refused where coverage is too low, the format cannot hold the gap, or an edit cannot be
/// said in it.
pub fn rewrite(format: &dyn Format, texts: Vec<Text>, task: &Task) -> Result<Done> {
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
    let root = installation::root(script, &task.choices.frames)?;
    notes.extend(installation::note(task.robot, root.as_ref()));
    notes.extend(limited.as_ref().map(|l| l.1.clone()));
    notes.extend(notes::unread(script));
    let left_out = left_out(script, task.choices);
    let excluded = |k: usize| left_out.get(k).is_some_and(Option::is_some);
    let deadband = bands::deadbands(script, task);
    let commanded = commanded(script, task.robot.dof());
    let crossing_s = approach::crossing_s(task);
    let mut choice = Choice {
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
        approach: approach::Sides::new(
            if document.passes_points() { &[] } else { &task.choices.approach_from },
            task.compensator,
        ),
        sides_given: task.options.initial_direction.iter().any(|d| *d != 0),
        rounds: true,
        joins: true,
    };
    let unknown_arm = notes::unknown_arm(format, task.robot);
    let edited = edited_by_approach(document.as_ref(), task, &mut choice, unknown_arm.as_ref())?;
    let Edited { mut edits, mut stats, unplaced, left, partial, unwritable, patches, stops, runs, .. } = edited;
    notes.extend(edited.of_runs);
    let missing = Missing { calls: asked::calls(script, &left), ..edited.missing };
    let reasons = Reasons { left_out: &left_out, left, partial, unwritable };
    let coverage = reasons.coverage(script, task.choices, &edits);
    demands::require_coverage(&coverage, task.choices, script)?;
    stats.points = coverage.moves;
    stats.inserted = edits.steps.iter().map(|(_, e)| e.before.len() as u64).sum();
    notes.extend(demands::enough_digits(script, &edits, task)?);
    notes.extend(edited.clockless);
    notes.extend(edited.rates.notes(task.robot));
    notes.extend(edited.held.notes(task.robot));
    notes.extend(edited.of_arm);
    notes.extend(script.notes.iter().cloned());
    notes.extend(notes::not_understood(script));
    notes.extend(notes::approached(script, &choice.approach, &runs, &edits));
    notes.splice(0..0, notes::unsolved(format, document.as_ref(), task.choices));
    drop(runs);
    let originals = script.texts.clone();
    let (texts, written) = writing::write(format, document, &mut edits, patches, task)?;
    if !written.halts.is_empty() {
        let stops_s = stops.and_then(|s| s.duration_s(&written.halts));
        stats.duration_s = stats.duration_s.and_then(|[before, after]| Some([before, after + stops_s?]));
    }
    Ok(Done {
        texts,
        stats,
        lines: edited.lines,
        coverage,
        missing,
        gaps: edited.gaps,
        unplaced,
        written,
        changes: edited.changes,
        changes_total: edited.changes_total,
        anew: edited.anew,
        runs: edited.count,
        looks_rewritten: edited.looks_rewritten,
        notes,
        originals,
    })
}

/// What is to be written into a program, and what the report tells of it.
struct Edited {
    edits: Edits,
    stats: RewriteStats,
    unplaced: Unplaced,
    rates: rates::Rates,
    /// Lines of the points of violations, by the number of the point.
    lines: BTreeMap<u64, At>,
    held: Held,
    changes: Vec<Change>,
    changes_total: usize,
    gaps: Vec<Gap>,
    /// Steps with an axis whose position is not known yet, ascending.
    partial: Vec<usize>,
    /// Where the engine or a pose cannot be written, by step.
    left: BTreeMap<usize, Cause>,
    /// By the format, by step.
    unwritable: BTreeMap<usize, Cause>,
    patches: Option<crate::program::script::Patches>,
    missing: Missing,
    looks_rewritten: bool,
    stops: Option<stops::Stops>,
    clockless: Option<Note>,
    of_runs: Vec<Note>,
    of_arm: Vec<Note>,
    /// Runs that start elsewhere than the program, and all of them.
    anew: usize,
    count: usize,
    /// Where targets are reached from one side; else what is written needs the edits alone.
    runs: Vec<Run>,
}

/// The edits of a program. A target whose point of approach cannot be written is reached as the program says, and the program is gone
/// through once more.
fn edited_by_approach(
    document: &dyn Document,
    task: &Task,
    choice: &mut Choice,
    unknown_arm: Option<&Cause>,
) -> Result<Edited> {
    /// Each round leaves targets for good; hardly a program needs a third.
    const ROUNDS: usize = 6;
    for _ in 0..ROUNDS {
        let edited = edited(document, task, choice, unknown_arm)?;
        let unwritten = approach::unwritten(&edited.runs, &edited.edits);
        if unwritten.is_empty() {
            return Ok(edited);
        }
        choice.approach.leave(unwritten);
    }
    choice.approach.leave(0..document.script().steps.len());
    edited(document, task, choice, unknown_arm)
}

/// The edits of a program, one way through it.
fn edited(document: &dyn Document, task: &Task, choice: &Choice, unknown_arm: Option<&Cause>) -> Result<Edited> {
    let script = document.script();
    let mut known = Poses::new(task.robot, &task.choices.frames);
    let root = installation::root(script, &task.choices.frames)?;
    known.world = installation::world(task.robot, root.as_ref());
    known.unknown_arm = unknown_arm.cloned();
    let Cut { mut runs, gaps, partial, mut left, notes: of_arm } = run::cut(script, choice, &mut known);
    let by_clock = ByClock::of(task);
    let looks_rewritten = recognised::looks_rewritten(script, &runs, task, &by_clock);
    let solve = choice.solve_within_m.is_some();
    let Collected { mut edits, mut stats, mut unplaced, rates, lines } =
        Collected::of(document, task, &by_clock, &runs, choice.deadband, solve)?;
    left.extend(unplaced.differing.drain(..).map(|step| (step, Cause::PassesDiffer)));
    unplaced.points += collected::spare(script, task.choices, &mut edits);
    let mut held = Held::default();
    let (changes, changes_total) = as_poses(document, task, &runs, &mut edits, &mut left, &mut unplaced, &mut held);
    // an estimate of a part would read as one of the whole
    let loops = runs.iter().any(|r| !r.entered.is_empty() || r.goes_on());
    let whole = gaps.is_empty() && partial.is_empty() && !loops;
    stats.duration_s = duration_s(&runs).filter(|_| whole).map(|s| [s, s]);
    let stops = stats.duration_s.map(|_| stops::Stops::of(task.robot, &runs));
    let clockless = by_clock.note(&runs);
    let of_runs = notes::unplaced(script, task.robot, &runs).into_iter().collect();
    let anew = runs.iter().filter(|r| !r.entry && !r.goes_on()).count();
    let count = runs.iter().filter(|r| !r.is_again()).count();
    if !choice.approach.any() {
        runs = Vec::new();
    }
    let (unwritable, patches) = writing::leave_unwritable(document, &mut edits, &mut stats);
    Ok(Edited {
        edits,
        stats,
        unplaced,
        rates,
        lines,
        held,
        changes,
        changes_total,
        gaps,
        partial,
        left,
        unwritable,
        patches,
        missing: known.missing,
        looks_rewritten,
        stops,
        clockless,
        of_runs,
        of_arm,
        anew,
        count,
        runs,
    })
}

/// Why steps stay as they are.
struct Reasons<'a> {
    /// On request, up to the last step that is.
    left_out: &'a [Option<Cause>],
    /// Where the engine or a pose cannot be written, by step.
    left: BTreeMap<usize, Cause>,
    /// Steps with an axis whose position is not known yet, ascending.
    partial: Vec<usize>,
    /// By the format, by step.
    unwritable: BTreeMap<usize, Cause>,
}

impl Reasons<'_> {
    fn coverage(&self, script: &Script, choices: &Choices, edits: &Edits) -> Coverage {
        let posed = |k: usize| match self.left.get(&k) {
            Some(why) => Err(why.clone()),
            None if choices.leave_poses => Err(Cause::Cartesian),
            None => Ok(()),
        };
        let solved = |k: usize| edits.steps.get(k).is_some_and(|e| e.as_joint_moves);
        let unknown = |k: usize| self.partial.binary_search(&k).is_ok().then_some(Cause::NotYetKnown);
        let kept = |k: usize| {
            let asked = self.left_out.get(k).cloned().flatten().or_else(|| unknown(k));
            let joints = || matches!(&script.steps[k].kind, StepKind::Move(m) if matches!(m.goal, Goal::Joints(_)));
            asked
                .or_else(|| self.unwritable.get(&k).cloned())
                .or_else(|| self.left.get(&k).filter(|_| joints()).cloned())
        };
        Coverage::of(script, &kept, &solved, &posed)
    }
}

/// How long the runs take together, s, where each of them is known.
fn duration_s(runs: &[Run]) -> Option<f64> {
    let known = runs.iter().all(Run::timed) && !runs.is_empty();
    known.then(|| runs.iter().filter_map(|r| r.vertices.last()).map(|v| v.t_s).sum())
}

/// Writes the edits of Cartesian targets as poses; the largest changes, and how many there are.
fn as_poses(
    document: &dyn Document,
    task: &Task,
    runs: &[Run],
    edits: &mut Edits,
    left: &mut BTreeMap<usize, Cause>,
    unplaced: &mut Unplaced,
    held: &mut Held,
) -> (Vec<Change>, usize) {
    let script = document.script();
    circles::settle(script, runs, edits, left);
    if !script.moves().any(|(_, m)| matches!(m.goal, Goal::Pose(_))) {
        return change::of_edits(script, runs, edits, task.robot, task.listed);
    }
    let mut in_joints = poses::write(script, runs, edits, left, unplaced, held);
    arcs::settle(script, runs, &mut in_joints, edits, left, unplaced, document.least_arc());
    change::of_edits(script, runs, &in_joints, task.robot, task.listed)
}

/// Why each step is left out on request, up to the last one that is.
fn left_out(script: &Script, choices: &Choices) -> Vec<Option<Cause>> {
    let (mut process, mut off) = (false, false);
    let mut all = Vec::new();
    for (k, step) in script.steps.iter().enumerate() {
        match step.kind {
            StepKind::Process(on) => process = on,
            StepKind::Pragma(on) => off = !on,
            _ => {}
        }
        let why = match (off, process && choices.exclude_process) {
            (true, _) => Cause::SwitchedOff,
            (_, true) => Cause::ProcessOn,
            _ => continue,
        };
        all.resize(k, None);
        all.push(Some(why));
    }
    all
}
