//! Rewriting a vendor program: read whole, cut into runs, each run through the engine, what comes out back as edits.
//!
//! ```text
//! texts -> Format::parse -> Script -> runs (run, way, clock) -> Engine -> edits -> Document::patches -> texts -> read again
//! ```
//!
//! Modules:
//! - [`coverage`]: how much can be edited, and why not the rest.
//! - [`run`]: where positions follow each other; [`poses`] solves Cartesian targets by their [`configuration`] and writes them
//!   again, [`way`] follows straight TCP paths; [`clock`] tells durations; [`fading`]: friction where none can be determined.
//! - [`approach`]: targets that are reached from one side.
//! - [`rates`]: speed and acceleration limits; [`stops`]: how long new exact stops take.
//! - [`edits`]: points that came out -> values and new points of the program; `arcs`: pieces of arcs that are split.
//! - [`writing`]: edits into texts; [`notes`]: what the program or the robot file does not say.
//! - [`verify`]: the result is read again before anyone gets it; `retraced`: was the program rewritten before?
//! - [`job`]: from file to file; [`context`]: what is looked up beside it.
//! - [`path`]: a program as one path in the joints, for those who run it on a machine.
//! - [`change`]: what differs, move by move, in degrees and micrometres: dry runs and golden files.

pub(crate) mod approach;
mod arcs;
pub(crate) mod cause;
pub(crate) mod change;
pub(crate) mod clock;
pub(crate) mod configuration;
pub(crate) mod context;
pub(crate) mod coverage;
pub(crate) mod edits;
pub(crate) mod fading;
pub(crate) mod job;
pub(crate) mod notes;
pub mod path;
pub(crate) mod poses;
pub(crate) mod rates;
mod retraced;
pub(crate) mod run;
pub(crate) mod stops;
pub(crate) mod verify;
pub(crate) mod way;
pub(crate) mod writing;

use super::deadband;
use super::engine::Engine;
use super::refusal::{CoarseDigit, Refusal};
use super::rewritten::{Digits, Evidence, Rows};
use super::stats::RewriteStats;
use super::{Options, Origin, OutputPoints, Points};
use crate::compensator::Compensator;
use crate::error::{Error, Result};
use crate::program::script::{
    At, Document, Edits, Format, Goal, Note, Quantity, Script, StepEdits, StepKind, TargetRef, Text, Value, is_clone,
};
use crate::robot::Robot;
use crate::robot::frames::{Frames, Missing};
use cause::Cause;
use change::Change;
use coverage::Coverage;
use edits::Unplaced;
use fading::ByClock;
use poses::Poses;
use rates::Rates;
use run::{Choice, Cut, Gap, Run};
use std::collections::BTreeMap;

/// Smallest dead band of a program with Cartesian targets, as a share of the smallest half gap: where straight TCP moves meet at a
/// corner near a joint's turn, the joint turns there and back, and two steps by the whole gap would cost more than that leg.
const DEADBAND_SHARE_TCP: f64 = 0.5;
/// Distance of a TCP from a joint at which the digits of its position count, m.
const LEVER_M: f64 = 0.5;
/// Last digit of an axis that no target names, rad or m.
const LEAST_DIGIT: f64 = 1e-9;
/// Points that the engine takes at a time.
const BLOCK: usize = 8192;

/// What a user may choose about vendor programs alone.
#[derive(Debug, Clone, Default)]
pub struct Choices {
    /// Moves while a process (welding, dispensing) is on stay as they are.
    pub exclude_process: bool,
    /// Write Cartesian moves between joint moves as joint moves, within this distance of the TCP's line, m.
    pub solve_within_m: Option<f64>,
    /// Share of the moves that must be editable, 0 to 1.
    pub require_coverage: Option<f64>,
    /// TCP speed in the place of what joint speeds would make it, m/s.
    pub speed_m_s: Option<f64>,
    /// Frames and tools by the controller's names, besides those of the robot file.
    pub frames: Frames,
    /// Cartesian targets stay as they are.
    pub leave_poses: bool,
    /// Most points that may be added to a program.
    pub max_added: Option<u64>,
    /// No points are added while a process is on; targets are edited.
    pub leave_process: bool,
    /// Direction in which each axis comes to targets at which the robot stops, +1 or -1; 0: any. Empty: all any.
    pub approach_from: Vec<i8>,
}

/// The task: what is the same for all programs of a call.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// The robot that the program moves.
    pub robot: &'a Robot,
    /// What is to be undone.
    pub compensator: &'a Compensator,
    /// Options of the engine.
    pub options: &'a Options,
    /// What the user chooses for programs.
    pub choices: &'a Choices,
    /// Dead bands that were asked for, per axis.
    pub deadband: &'a [Option<f64>],
    /// Weight of the last digit that changed numbers should have at most, per axis, rad or m.
    pub digit: &'a [f64],
    /// ... and of lengths (m) and angles (rad) of poses.
    pub pose_digit: [f64; 2],
    /// Changes that are listed.
    pub listed: usize,
}

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
    /// Line of each point of the violations.
    pub lines: Vec<At>,
    /// How much of the program was edited, and why the rest was not.
    pub coverage: Coverage,
    /// Frames and tools that moves wait for.
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
    require_posture(task)?;
    let (mut notes, reduced) = notes::uncoupled(format, task);
    let task = &Task { compensator: reduced.as_ref().unwrap_or(task.compensator), ..*task };
    notes.extend(notes::missing(script));
    notes.extend(notes::unread(script));
    let left_out = left_out(script, task.choices);
    let excluded = |k: usize| left_out.get(k).is_some_and(Option::is_some);
    let deadband = deadbands(script, task);
    let commanded = commanded(script, task.robot.dof());
    let choice = Choice {
        commanded: &commanded,
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
    };
    let mut known = Poses::new(task.robot, &task.choices.frames);
    let Cut { runs, gaps, partial, mut left, notes: of_arm } = run::cut(script, &choice, &mut known);
    let by_clock = ByClock::of(task);
    let looks_rewritten = looks_rewritten(script, &runs, task, &by_clock);
    let solve = choice.solve_within_m.is_some();
    let Collected { mut edits, mut stats, mut unplaced, rates, lines } =
        Collected::of(document.as_ref(), task, &by_clock, &runs, &deadband, solve)?;
    unplaced.points += spare(script, task.choices, &mut edits);
    let (changes, changes_total) = as_poses(document.as_ref(), task, &runs, &mut edits, &mut left, &mut unplaced);
    let (unwritable, patches) = writing::leave_unwritable(document.as_ref(), &mut edits, &mut stats);
    let posed = |k: usize| match left.get(&k) {
        Some(why) => Err(why.clone()),
        None if task.choices.leave_poses => Err(Cause::Cartesian),
        None => Ok(()),
    };
    let solved = |k: usize| edits.steps.get(k).is_some_and(|e| e.as_joint_moves);
    let unknown = |k: usize| partial.binary_search(&k).is_ok().then_some(Cause::NotYetKnown);
    let kept = |k: usize| {
        let asked = left_out.get(k).cloned().flatten().or_else(|| unknown(k));
        let joints = || matches!(&script.steps[k].kind, StepKind::Move(m) if matches!(m.goal, Goal::Joints(_)));
        asked.or_else(|| unwritable.get(&k).cloned()).or_else(|| left.get(&k).filter(|_| joints()).cloned())
    };
    let coverage = Coverage::of(script, &kept, &solved, &posed);
    require_coverage(&coverage, task.choices, script)?;
    stats.points = coverage.moves;
    stats.inserted = edits.steps.iter().map(|(_, e)| e.before.len() as u64).sum();
    // an estimate of a part would read as one of the whole
    let whole = runs.iter().all(Run::timed) && !runs.is_empty() && gaps.is_empty() && partial.is_empty();
    let duration_s = || runs.iter().filter_map(|r| r.vertices.last()).map(|v| v.t_s).sum();
    stats.duration_s = whole.then(duration_s).map(|s: f64| [s, s]);
    enough_digits(script, &edits, task)?;
    notes.extend(by_clock.note(&runs));
    notes.extend(rates.notes(task.robot));
    notes.extend(of_arm);
    notes.extend(script.notes.iter().cloned());
    notes.extend(notes::not_understood(script));
    notes.extend(notes::approached(script, &choice.approach, &runs, &edits));
    notes.splice(0..0, notes::unsolved(format, document.as_ref(), task.choices));
    let stops = stats.duration_s.map(|_| stops::Stops::of(task.robot, &runs));
    let (anew, count) = (runs.iter().filter(|r| !r.entry).count(), runs.len());
    // what is written needs the edits alone
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
        lines,
        coverage,
        missing: known.missing,
        gaps,
        unplaced,
        written,
        changes,
        changes_total,
        anew,
        runs: count,
        looks_rewritten,
        notes,
        originals,
    })
}

/// Writes the edits of Cartesian targets as poses; the largest changes, and how many there are.
fn as_poses(
    document: &dyn Document,
    task: &Task,
    runs: &[Run],
    edits: &mut Edits,
    left: &mut BTreeMap<usize, Cause>,
    unplaced: &mut Unplaced,
) -> (Vec<Change>, usize) {
    let script = document.script();
    if !script.moves().any(|(_, m)| matches!(m.goal, Goal::Pose(_))) {
        return change::of_edits(script, runs, edits, task.robot, task.listed);
    }
    let mut in_joints = edits.clone();
    poses::write(script, runs, edits, left, unplaced);
    edits::keep_written(&mut in_joints, edits);
    arcs::settle(script, runs, &mut in_joints, edits, left, unplaced, document.least_arc());
    change::of_edits(script, runs, &in_joints, task.robot, task.listed)
}

/// What came out of the engine, run by run, as edits.
struct Collected {
    edits: Edits,
    stats: RewriteStats,
    unplaced: Unplaced,
    rates: Rates,
    /// Line of each point of the violations.
    lines: Vec<At>,
}

impl Collected {
    fn of(
        document: &dyn Document,
        task: &Task,
        by_clock: &ByClock,
        runs: &[Run],
        deadband: &[f64],
        solve: bool,
    ) -> Result<Self> {
        let script = document.script();
        let points: usize = runs.iter().map(|r| r.vertices.len()).sum();
        let mut all = Self {
            edits: Edits {
                steps: StepEdits::with_capacity(script.steps.len(), points * task.robot.dof()),
                digit: task.digit.to_vec(),
                pose_digit: task.pose_digit,
            },
            stats: empty(task.robot.dof()),
            unplaced: Unplaced::default(),
            rates: Rates::default(),
            lines: Vec::new(),
        };
        for run in runs {
            let mut options = task.options.clone();
            options.deadband.clear();
            options.deadband.extend_from_slice(deadband);
            if !run.entry {
                // only the program starts where the user says
                options.initial_direction.fill(0);
            }
            let task = &Task { compensator: by_clock.on(run), ..*task };
            let (emitted, done) =
                all.rates.within(script, task, run, options, &|options| through(task, run, options))?;
            let (lost, added) = edits::collect(document, task.robot, run, &emitted, solve, &mut all.edits);
            all.unplaced.points += lost.points;
            all.unplaced.lines.extend(lost.lines);
            all.unplaced.rounded += lost.rounded;
            add(&mut all.stats, done, added, all.lines.len() as u64);
            all.lines.extend(run.vertices.iter().map(|v| script.steps[v.step].at));
        }
        Ok(all)
    }
}

/// New points that are not wanted go: in processes, and beyond the most that may be added. Returns how many went.
fn spare(script: &Script, choices: &Choices, edits: &mut Edits) -> u64 {
    let (mut gone, mut added) = (0, 0);
    let mut process = false;
    for (k, step) in script.steps.iter().enumerate() {
        if let StepKind::Process(on) = step.kind {
            process = on;
        }
        let Some(edit) = edits.steps.get(k).filter(|e| !e.as_joint_moves && !e.before.is_empty()) else {
            continue;
        };
        let points = edit.before.len() as u64;
        let most = choices.max_added.is_some_and(|most| added + points > most);
        // a copy of a Cartesian move that stops exactly would stop in the middle of a seam
        let stops =
            matches!(&step.kind, StepKind::Move(m) if matches!(m.goal, Goal::Pose(_)) && m.blend_m == Some(0.0));
        if most || process && (choices.leave_process || stops) {
            gone += points;
            let has_goal = edit.goal.is_some();
            edits.steps.change(k, |edit| {
                edit.clear_points();
            });
            if !has_goal {
                edits.steps.remove(k);
            }
        } else {
            added += points;
        }
    }
    gone
}

/// By names that `rewrite` makes, or by its numbers, run by run: by what the gears turn.
fn looks_rewritten(script: &Script, runs: &[Run], task: &Task, by_clock: &ByClock) -> bool {
    let axes = task.robot.dof();
    let digits = written_digits(script, axes);
    let mut evidence = Evidence::default();
    if script.targets.iter().filter_map(|t| t.name).any(is_clone) {
        return true;
    }
    for run in runs {
        let mut q: Vec<f64> = run.vertices.iter().flat_map(|v| v.q.iter().copied()).collect();
        q.chunks_exact_mut(axes).for_each(|row| task.robot.to_gears(row));
        evidence.add(Rows { q: &q, axes }, &digits, by_clock.on(run), task.options.step_fraction);
    }
    evidence.is_rewritten() || retraced::looks_rewritten(script, runs, task.robot, by_clock)
}

/// How the numbers of each axis are written: the finest last digit of its targets, in degrees or radians (millimetres or metres),
/// or in steps of the format's own.
fn written_digits(script: &Script, axes: usize) -> Vec<Digits> {
    let mut finest = vec![f64::INFINITY; axes];
    for target in script.targets.iter() {
        for (finest, value) in finest.iter_mut().zip(target.values.iter()) {
            *finest = value.map_or(*finest, |v| finest.min(v.digit));
        }
    }
    finest.into_iter().map(digits_of).collect()
}

fn digits_of(last: f64) -> Digits {
    if !last.is_finite() {
        return Digits { last: LEAST_DIGIT, unit: 1.0 };
    }
    let is_decimal = |unit: f64| {
        let power = (last / unit).log10();
        (power - power.round()).abs() < 1e-6 && power < 0.5
    };
    let unit = [1f64.to_radians(), 1e-3, 1.0].into_iter().find(|u| is_decimal(*u)).unwrap_or(last);
    Digits { last, unit }
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

/// The posture that the user gives must be one of this robot.
fn require_posture(task: &Task) -> Result<()> {
    let Some(posture) = &task.choices.frames.posture_deg else { return Ok(()) };
    if posture.len() == task.robot.dof() {
        return Ok(());
    }
    let found = format!("`posture_deg` of {} numbers", posture.len());
    let expected = format!("{}, one for each axis of {}", task.robot.dof(), task.robot.name);
    Err(Error::setting("frames", found, expected))
}

fn require_coverage(coverage: &Coverage, choices: &Choices, script: &Script) -> Result<()> {
    let Some(share) = choices.require_coverage else { return Ok(()) };
    if coverage.percent() >= 100.0 * share - 1e-9 {
        return Ok(());
    }
    let name = script.texts.first().map_or("", |t| t.name.as_str());
    let reasons = coverage.reasons.iter().map(|r| format!("\n  {}: {} ({})", r.moves, r.why, r.lines_text()));
    let Coverage { editable, moves, .. } = *coverage;
    Err(Refusal::Coverage { name: name.into(), editable, moves, required: share, reasons: reasons.collect() }.into())
}

/// What the last digits of a pose make of a joint, rad: of its angles, and of its lengths at [`LEVER_M`].
fn pose_noise(target: TargetRef) -> f64 {
    let of = |(k, v): (usize, Option<Value>)| {
        let digit = v?.digit;
        Some(match target.pose?.quantity(k) {
            Quantity::Length => digit / LEVER_M,
            Quantity::Angle => digit,
            Quantity::Ratio => 2.0 * digit,
        })
    };
    target.values.iter().enumerate().filter_map(of).fold(0.0, f64::max)
}

/// What was asked for, else 1.5 of the coarsest last digits with which the axis is written and a share of its smallest half gap.
fn deadbands(script: &Script, task: &Task) -> Vec<f64> {
    let poses = || script.targets.iter().filter(|t| t.pose.is_some());
    let of_pose = poses().map(pose_noise).fold(0.0, f64::max);
    let coarsest = |a: usize| {
        let joints = script.targets.iter().filter(|t| t.pose.is_none());
        let digits = joints.filter_map(|t| t.values.get(a)).map(|v| v.digit);
        digits.fold(of_pose, f64::max)
    };
    let mut all = deadband::deadbands(task.deadband, task.compensator, task.robot.dof(), coarsest);
    if poses().next().is_some() {
        for (a, band) in all.iter_mut().enumerate().filter(|(a, _)| task.deadband.get(*a).is_none_or(Option::is_none)) {
            let least = task.compensator.on(a).and_then(deadband::smallest).map_or(0.0, |gap| DEADBAND_SHARE_TCP * gap);
            *band = band.max(least);
        }
    }
    all
}

/// One run through the engine.
fn through(task: &Task, run: &Run, options: Options) -> Result<(OutputPoints, RewriteStats)> {
    let axes = task.robot.dof();
    let seconds = task.compensator.fades_in_seconds();
    let timed = run.timed() && (run.certain || seconds);
    let mut options = options;
    if !timed {
        let before = std::iter::once(0.0).chain(run.vertices.iter().map(|v| v.t_s));
        let leg = |(v, before): (&run::Vertex, f64)| if v.certain { v.t_s - before } else { f64::NAN };
        options.legs_s = Some(run.vertices.iter().zip(before).map(leg).collect());
    }
    let mut engine = Engine::new(task.robot, task.compensator, options)?;
    let mut out = OutputPoints { axes, ..OutputPoints::default() };
    out.reserve(run.vertices.len() + run.vertices.len() / 8);
    // in blocks, so that the engine forgets what it is done with
    let mut points = Points { axes, ..Points::default() };
    for vertices in run.vertices.chunks(BLOCK) {
        points.q.clear();
        points.t_s.clear();
        for v in vertices {
            points.q.extend_from_slice(&v.q);
            if timed {
                points.t_s.push(v.t_s);
            }
        }
        engine.push(&points, &mut out)?;
    }
    let stats = engine.finish(&mut out)?;
    Ok((out, stats))
}

fn empty(axes: usize) -> RewriteStats {
    RewriteStats {
        reversals: vec![0; axes],
        largest_offset: vec![0.0; axes],
        largest_left: vec![0.0; axes],
        ..RewriteStats::default()
    }
}

/// Adds the statistics of a run whose points count from `first` on.
fn add(sum: &mut RewriteStats, run: RewriteStats, added: u64, first: u64) {
    sum.inserted += added;
    for (a, b) in sum.reversals.iter_mut().zip(&run.reversals) {
        *a += b;
    }
    for (a, b) in sum.largest_offset.iter_mut().zip(&run.largest_offset) {
        *a = a.max(*b);
    }
    for (a, b) in sum.largest_left.iter_mut().zip(&run.largest_left) {
        *a = a.max(*b);
    }
    sum.violations_total += run.violations_total.max(run.violations.len() as u64);
    sum.out_of_range += run.out_of_range;
    sum.violations.extend(run.violations.into_iter().map(|mut v| {
        v.origin = match v.origin {
            Origin::Point(n) => Origin::Point(n + first),
            Origin::Inserted { after, fraction } => Origin::Inserted { after: after + first, fraction },
        };
        v
    }));
    sum.unchecked_rates = sum.unchecked_rates.or(run.unchecked_rates);
    sum.largest_change_m = sum.largest_change_m.max(run.largest_change_m);
}

/// A gap below what the format can hold is refused, not faked.
fn enough_digits(script: &Script, edits: &Edits, task: &Task) -> Result<()> {
    let mut coarse = Vec::new();
    for (axis, joint) in task.robot.axis_joints().enumerate() {
        let Some(gap) = task.compensator.on(axis).and_then(super::deadband::smallest) else { continue };
        let gap = gap * task.options.gain;
        let coarsest = script
            .moves()
            .filter(|(k, _)| edits.steps.contains(*k))
            .filter_map(|(k, m)| match m.goal {
                Goal::Joints(t) => Some((k, script.targets.get(t)?.values.get(axis)?)),
                _ => None,
            })
            .max_by(|a, b| a.1.finest.total_cmp(&b.1.finest));
        if let Some((k, value)) = coarsest
            && value.finest > gap
            && gap > 0.0
        {
            let edge = |v: f64| joint.kind.to_user_unit(v);
            coarse.push(CoarseDigit {
                place: script.place(script.steps[k].at).to_string(),
                joint: joint.name.clone(),
                unit: joint.kind.unit(),
                step: edge(value.finest),
                half_gap: edge(gap),
            });
        }
    }
    if coarse.is_empty() { Ok(()) } else { Err(Refusal::CoarseDigits(coarse).into()) }
}
