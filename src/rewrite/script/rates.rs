//! Speed and acceleration limits of vendor programs.
//!
//! Where a program holds times, the robot must keep them, and a step that asks a joint for more than it can is spread over a longer
//! travel behind its reversal until all limits hold. Elsewhere the controller plans speeds itself and slows down where a joint needs
//! it: there a limit is no reason to refuse the program, and a note tells where time will be lost.

use super::Task;
use super::run::Run;
use crate::error::Result;
use crate::program::script::{Note, Script};
use crate::rewrite::engine::{Account, LimitKind, Violation};
use crate::rewrite::{Emitted, Options, Origin};
use std::collections::BTreeMap;

/// Travel over which a step is spread, in half gaps of its joint: the first of them that keeps all limits.
const RAMPS: [f64; 6] = [5.0, 10.0, 20.0, 50.0, 100.0, 200.0];

fn is_rate(v: &Violation) -> bool {
    v.what != LimitKind::Range
}

/// One run through the engine, by `through`; where the times of the program would break limits, with a longer ramp. What is to be
/// said about it goes to `notes`.
pub fn within(
    script: &Script,
    task: &Task,
    run: &Run,
    options: Options,
    notes: &mut Vec<Note>,
    through: &dyn Fn(Options) -> Result<(Emitted, Account)>,
) -> Result<(Emitted, Account)> {
    let (emitted, mut account) = through(options.clone())?;
    if !account.violations.iter().any(is_rate) {
        return Ok((emitted, account));
    }
    if !run.by_program {
        notes.extend(planned(script, task, run, &account));
        account.violations.retain(|v| !is_rate(v));
        account.violations_total = account.out_of_range;
        return Ok((emitted, account));
    }
    let chosen = options.step_exact || options.ramp.iter().any(|&r| r > 0.0);
    let mut axes: Vec<usize> = account.violations.iter().filter(|v| is_rate(v)).map(|v| v.axis).collect();
    axes.sort_unstable();
    axes.dedup();
    for ramp in RAMPS.iter().filter(|_| !chosen) {
        let mut longer = options.clone();
        for &axis in &axes {
            let gap = task.compensator.on(axis).and_then(crate::rewrite::job::smallest).unwrap_or(0.0);
            longer.ramp[axis] = ramp * gap;
        }
        let ramps = longer.ramp.clone();
        let (emitted, tried) = through(longer)?;
        if !tried.violations.iter().any(is_rate) {
            notes.extend(axes.iter().filter_map(|&axis| spread(script, task, run, &account, axis, ramps[axis])));
            return Ok((emitted, tried));
        }
    }
    Ok((emitted, account))
}

/// The step at which a point stands.
fn vertex_of(origin: Origin) -> usize {
    let (Origin::Point(n) | Origin::Inserted { after: n, .. }) = origin;
    n as usize
}

/// What a controller that plans speeds itself will do: a sentence for each joint and kind of limit, at its first place.
fn planned(script: &Script, task: &Task, run: &Run, account: &Account) -> Vec<Note> {
    let mut worst: BTreeMap<(usize, bool), (f64, usize, u64)> = BTreeMap::new();
    for v in account.violations.iter().filter(|v| is_rate(v)) {
        let share = (v.value / v.limit).abs();
        let entry = worst.entry((v.axis, v.what == LimitKind::Speed)).or_insert((0.0, vertex_of(v.origin), 0));
        *entry = (entry.0.max(share), entry.1, entry.2 + 1);
    }
    let of = |((axis, speed), (share, vertex, places)): (&(usize, bool), &(f64, usize, u64))| {
        let place = script.steps.get(run.vertices.get(*vertex)?.step)?.at;
        let (joint, what) = (&task.robot.axis(*axis).name, if *speed { "speed" } else { "acceleration" });
        let at = if *places == 1 { "here".into() } else { format!("at {places} places, first here") };
        let text = format!(
            "at the programmed speed {joint} would need {share:.2} times its largest {what} ({at}): the controller slows down for it, \
             or spread the step (--ramp-deg, --ramp-mm)"
        );
        Some(Note { place, text })
    };
    worst.iter().filter_map(of).collect()
}

/// What the longer ramp of a joint costs.
fn spread(script: &Script, task: &Task, run: &Run, account: &Account, axis: usize, ramp: f64) -> Option<Note> {
    let first = account.violations.iter().find(|v| is_rate(v) && v.axis == axis)?;
    let place = script.steps.get(run.vertices.get(vertex_of(first.origin))?.step)?.at;
    let joint = task.robot.axis(axis);
    let text = format!(
        "the step of {} is spread over {:.4} {unit} behind its reversals, so that its speed and acceleration hold at the times of the \
         program; until then a part of its gap is left",
        joint.name,
        joint.kind.to_edge(ramp),
        unit = joint.kind.unit()
    );
    Some(Note { place, text })
}
