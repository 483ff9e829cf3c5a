//! The edits of a program: its runs through the engine, their points as values and poses of the program, and what the report tells.

use super::cause::Cause;
use super::change;
use super::collected::{self, Collected};
use super::fading::ByClock;
use super::poses::{self, Held, Poses};
use super::reasons::Reasons;
use super::run::{self, Choice, Cut, Run};
use super::stops::Stops;
use super::{
    EditReport, Task, again, approach, arcs, asked, circles, corners, installation, notes, recognised, whole, wrists,
    writing,
};
use crate::error::Result;
use crate::program::script::{Document, Edits, Goal, Note, Patches};
use crate::rewrite::stats::RewriteStats;
use crate::robot::frames::Missing;
use std::collections::BTreeMap;

/// What is to be written into a program, and what the report tells of it.
pub(super) struct Edited {
    pub(super) edits: Edits,
    /// The same as patches, where the format made them to see what it can write.
    pub(super) patches: Option<Patches>,
    pub(super) stats: RewriteStats,
    /// How long new exact stops take, where the duration is known.
    pub(super) stops: Option<Stops>,
    pub(super) reasons: Reasons,
    pub(super) report: EditReport,
    /// Notes on runs whose way is not known, and those on moves, the robot and its limits.
    pub(super) of_runs: Vec<Note>,
    pub(super) of_moves: Vec<Note>,
    /// Where targets are reached from one side; else what is written needs the edits alone.
    pub(super) runs: Vec<Run>,
}

/// The edits of a program. A target whose point of approach cannot be written is reached as the program says, and the program is gone
/// through once more.
pub(super) fn by_approach(
    document: &dyn Document,
    task: &Task,
    choice: &mut Choice,
    unknown_arm: Option<&Cause>,
) -> Result<Edited> {
    /// Each round leaves targets for good, or takes some apart; hardly a program needs a fourth.
    const ROUNDS: usize = 12;
    for _ in 0..ROUNDS {
        let edited = one_way(document, task, choice, unknown_arm)?;
        let unwritten = approach::unwritten(&edited.runs, &edited.edits);
        let settled = unwritten.is_empty();
        choice.approach.leave(unwritten);
        if !choice.approach.take_apart(document.script(), &edited.reasons.left) && settled {
            return Ok(edited);
        }
    }
    choice.approach.leave(0..document.script().steps.len());
    one_way(document, task, choice, unknown_arm)
}

/// The edits of a program, one way through it.
fn one_way(document: &dyn Document, task: &Task, choice: &Choice, unknown_arm: Option<&Cause>) -> Result<Edited> {
    let script = document.script();
    let mut known = Poses::new(task.robot, &task.choices.frames);
    let root = installation::root(script, &task.choices.frames)?;
    known.world = installation::world(task.robot, root.as_ref());
    known.unknown_arm = unknown_arm.cloned();
    let Cut { mut runs, gaps, partial, mut left, notes: of_arm, others, again, .. } =
        run::cut(script, choice, &mut known);
    let by_clock = ByClock::of(task);
    let looks_rewritten = recognised::looks_rewritten(document, &runs, task, &by_clock);
    let ways = [runs.as_slice(), again.as_slice()];
    let OfRuns { collected, mut in_joints, held } = OfRuns::of(document, task, choice, &by_clock, ways, &mut left)?;
    let Collected { mut edits, mut stats, mut unplaced, rates, lines } = collected;
    for Cut { runs, again, left: mut other_left, .. } in others {
        let other = OfRuns::of(document, task, choice, &by_clock, [&runs, &again], &mut other_left)?;
        let own = (&mut edits, in_joints.as_mut());
        wrists::keep_alike(script, own, &other.collected.edits, &mut left, &mut unplaced);
    }
    let (changes, changes_total) =
        change::of_edits(document, &runs, in_joints.as_ref().unwrap_or(&edits), task.robot, task.listed);
    // an estimate of a part would read as one of the whole
    let loops = runs.iter().any(|r| !r.entered.is_empty() || r.goes_on());
    let whole = gaps.is_empty() && partial.is_empty() && !loops;
    stats.duration_s = duration_s(&runs).filter(|_| whole).map(|s| [s, s]);
    let stops = stats.duration_s.map(|_| Stops::of(task.robot, &runs));
    let mut of_moves: Vec<Note> = by_clock.note(&runs).into_iter().collect();
    of_moves.extend(rates.notes(task.robot));
    of_moves.extend(held.notes(task.robot));
    of_moves.extend(of_arm);
    let of_runs = notes::unplaced(script, task.robot, &runs).into_iter().collect();
    let anew = runs.iter().filter(|r| !r.entry && !r.goes_on() && !r.is_approached()).count();
    let number = runs.iter().filter(|r| !r.is_again()).count();
    if !choice.approach.any() {
        runs = Vec::new();
    }
    let (unwritable, patches) = writing::leave_unwritable(document, &mut edits, &mut stats);
    let missing = Missing { calls: asked::calls(script, &left), ..known.missing };
    let report =
        EditReport { lines, missing, gaps, unplaced, changes, changes_total, anew, runs: number, looks_rewritten };
    let reasons = Reasons { left, partial, unwritable };
    Ok(Edited { edits, patches, stats, stops, reasons, report, of_runs, of_moves, runs })
}

/// What is made of the runs of a program.
struct OfRuns {
    collected: Collected,
    /// The edits with those of Cartesian targets in joints; `None`: there are none.
    in_joints: Option<Edits>,
    held: Held,
}

impl OfRuns {
    /// Of runs, and of those from the end of the program to its start; `left` says why steps stay.
    fn of(
        document: &dyn Document,
        task: &Task,
        choice: &Choice,
        by_clock: &ByClock,
        [runs, from_end]: [&[Run]; 2],
        left: &mut BTreeMap<usize, Cause>,
    ) -> Result<Self> {
        let script = document.script();
        let solve = choice.solve_within_m.is_some();
        let mut collected = Collected::of(document, task, by_clock, runs, choice.deadband, solve)?;
        let Collected { edits, unplaced, .. } = &mut collected;
        again::settle(document, task, by_clock, from_end, (choice.deadband, solve), (edits, unplaced))?;
        left.extend(unplaced.differing.drain(..).map(|step| (step, Cause::PassesDiffer)));
        unplaced.points += collected::spare(script, task.choices, edits);
        let mut held = Held::default();
        circles::settle(script, runs, edits, left);
        corners::settle(document, task.robot, runs, choice, (edits, unplaced));
        whole::settle(edits, unplaced);
        let poses = script.moves().any(|(_, m)| matches!(m.goal, Goal::Pose(_)));
        let in_joints = poses.then(|| {
            let mut in_joints = poses::write(script, runs, edits, left, unplaced, &mut held);
            arcs::settle(script, runs, &mut in_joints, edits, left, unplaced, document.least_arc());
            in_joints
        });
        Ok(Self { collected, in_joints, held })
    }
}

/// How long the runs take together, s, where each of them is known.
fn duration_s(runs: &[Run]) -> Option<f64> {
    let known = runs.iter().all(Run::timed) && !runs.is_empty();
    known.then(|| runs.iter().filter_map(|r| r.vertices.last()).map(|v| v.t_s).sum())
}
