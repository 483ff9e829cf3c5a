//! Runs through the engine, and what comes out of it as edits of the program's steps.

use super::edits;
use super::fading::ByClock;
use super::rates::Rates;
use super::run::{Run, Vertex};
use super::task::{Choices, Task};
use super::unplaced::Unplaced;
use crate::error::Result;
use crate::program::script::{At, Document, Edits, Goal, Script, StepEdits, StepKind, processes};
use crate::rewrite::engine::Engine;
use crate::rewrite::stats::{RewriteStats, UncheckedRates};
use crate::rewrite::{Options, Origin, OutputPoints, Points};
use std::collections::BTreeMap;

/// Points that the engine takes at a time.
const BLOCK: usize = 8192;

/// What came out of the engine, run by run, as edits.
pub(super) struct Collected {
    pub(super) edits: Edits,
    pub(super) stats: RewriteStats,
    pub(super) unplaced: Unplaced,
    pub(super) rates: Rates,
    /// Lines of the points of violations, by the number of the point.
    pub(super) lines: BTreeMap<u64, At>,
}

impl Collected {
    pub(super) fn of(
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
            lines: BTreeMap::new(),
        };
        let least_gain_m = task.choices.least_gain_m.unwrap_or(0.0);
        let mut first = 0;
        for run in runs {
            let mut options = task.options.clone();
            options.deadband.clear();
            options.deadband.extend_from_slice(deadband);
            options.unplaced = run.unplaced(script);
            if !run.entry {
                // only the program starts where the user says
                options.initial_direction.fill(0);
            }
            for (known, first) in options.initial_direction.iter_mut().zip(&run.first_directions) {
                *known = if *known == 0 { *first } else { *known };
            }
            let task = &Task { compensator: by_clock.on(run), ..*task };
            let alone = options.clone();
            let (emitted, done) =
                all.rates.within(script, task, run, options, &|options| through(task, run, options))?;
            let done = own(task, run, alone, done)?;
            let (lost, added) =
                edits::collect(document, task.robot, run, &emitted, (solve, least_gain_m), &mut all.edits);
            all.unplaced.points += lost.points;
            all.unplaced.lines.extend(lost.lines);
            for (why, lines) in &lost.why {
                all.unplaced.because(why, lines);
            }
            all.unplaced.rounded += lost.rounded;
            all.unplaced.little += lost.little;
            all.unplaced.differing.extend(lost.differing);
            all.unplaced.whole.extend(lost.whole);
            for v in &done.violations {
                let (Origin::Point(n) | Origin::Inserted { after: n, .. }) = v.origin;
                let step = run.vertices.get(n as usize).and_then(|vertex| script.steps.get(vertex.step));
                all.lines.extend(step.map(|step| (first + n, step.at)));
            }
            add(&mut all.stats, done, added, first);
            first += run.vertices.len() as u64;
        }
        Ok(all)
    }
}

/// New points that are not wanted go: in processes, and beyond the most that may be added. Returns how many went.
pub(super) fn spare(script: &Script, choices: &Choices, edits: &mut Edits) -> u64 {
    let (mut gone, mut added) = (0, 0);
    let processes = processes::before_each(script);
    for (k, step) in script.steps.iter().enumerate() {
        let process = processes.get(k).copied().unwrap_or(false);
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

/// One run through the engine.
fn through(task: &Task, run: &Run, options: Options) -> Result<(OutputPoints, RewriteStats)> {
    let axes = task.robot.dof();
    let seconds = task.compensator.fades_in_seconds();
    let timed = run.timed() && (run.certain || seconds);
    let mut options = options;
    if !timed {
        let before = std::iter::once(0.0).chain(run.vertices.iter().map(|v| v.t_s));
        let leg = |(v, before): (&Vertex, f64)| if v.certain { v.t_s - before } else { f64::NAN };
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

/// The statistics of a run without those of the points before it, which are another run's; where others lead through the same moves, theirs
/// alone count.
fn own(task: &Task, run: &Run, options: Options, done: RewriteStats) -> Result<RewriteStats> {
    let kept = run.before();
    if kept == 0 {
        return Ok(done);
    }
    let before = Run { vertices: run.vertices[..kept].to_vec(), ..run.clone() };
    let (_, before) = through(task, &before, options)?;
    let mut done = done;
    done.violations.retain(|v| {
        let (Origin::Point(n) | Origin::Inserted { after: n, .. }) = v.origin;
        n as usize >= kept
    });
    done.violations_total = done.violations_total.saturating_sub(before.violations_total);
    done.out_of_range = done.out_of_range.saturating_sub(before.out_of_range);
    for (all, before) in done.reversals.iter_mut().zip(&before.reversals) {
        *all = if run.is_again() { 0 } else { all.saturating_sub(*before) };
    }
    Ok(done)
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
    // a program whose moves have no times may state speeds, though not of every move
    let unchecked = run.unchecked_rates.map(|why| match why {
        UncheckedRates::NoTimes => UncheckedRates::SomeSpeeds,
        other => other,
    });
    sum.unchecked_rates = sum.unchecked_rates.or(unchecked);
    sum.largest_change_m = sum.largest_change_m.max(run.largest_change_m);
}
