//! What the caller and the format demand of a program before it is written.

use super::coverage::Coverage;
use super::task::{Choices, Task};
use crate::error::{Error, Result};
use crate::program::script::{Edits, Goal, Note, Script};
use crate::rewrite::deadband;
use crate::rewrite::refusal::{CoarseDigit, Refusal};
use crate::robot::Robot;

/// Largest joint position that a program can mean, in user units (deg or mm): beyond it a number is damaged, and offsets of other points
/// would be lost in the rounding of differences.
const LARGEST: f64 = 1e7;

/// Joint targets are positions that a machine can have.
pub(super) fn require_positions(script: &Script, robot: &Robot) -> Result<()> {
    for (k, m) in script.moves() {
        let Goal::Joints(target) = m.goal else { continue };
        let Some(target) = script.targets.get(target) else { continue };
        // no number is none that is too large
        for (joint, si) in robot.axis_joints().zip(target.values.si_or_nan()) {
            let value = joint.kind.to_user_unit(si);
            if value.abs() > LARGEST {
                let found = format!("{value:e} {} for {}", joint.kind.unit(), joint.name);
                return Err(Error::bad(script.place(script.steps[k].at), found, "a position that the joint can have"));
            }
        }
    }
    Ok(())
}

/// The posture that the user gives must be one of this robot.
pub(super) fn require_posture(task: &Task) -> Result<()> {
    let Some(posture) = &task.choices.frames.posture_deg else { return Ok(()) };
    if posture.len() == task.robot.dof() {
        return Ok(());
    }
    let found = format!("`posture_deg` of {} numbers", posture.len());
    let expected = format!("{}, one for each axis of {}", task.robot.dof(), task.robot.name);
    Err(Error::setting("frames", found, expected))
}

pub(super) fn require_coverage(coverage: &Coverage, choices: &Choices, script: &Script) -> Result<()> {
    let Some(share) = choices.require_coverage else { return Ok(()) };
    if coverage.percent() >= 100.0 * share - 1e-9 {
        return Ok(());
    }
    let name = script.texts.first().map_or("", |t| t.name.as_str());
    let reasons = coverage.reasons.iter().map(|r| format!("\n  {}: {} ({})", r.moves, r.why, r.lines_text()));
    let Coverage { editable, moves, .. } = *coverage;
    Err(Refusal::Coverage { name: name.into(), editable, moves, required: share, reasons: reasons.collect() }.into())
}

/// A gap below what the format can hold is refused, not faked. Where poses are edited, too, they hold it: the few joint targets beside
/// them are rounded, and a note says so.
pub(super) fn enough_digits(script: &Script, edits: &Edits, task: &Task) -> Result<Option<Note>> {
    let (mut coarse, mut first) = (Vec::new(), None);
    let (mut joints, mut poses) = (0, 0);
    // by axis: the last step whose number can be no finer, and the weight of its finest digit
    let mut coarsest: Vec<Option<(usize, f64)>> = vec![None; task.robot.dof()];
    for (k, m) in script.moves().filter(|(k, _)| edits.steps.contains(*k)) {
        let Goal::Joints(t) = m.goal else {
            poses += 1;
            continue;
        };
        joints += 1;
        let Some(target) = script.targets.get(t) else { continue };
        for (place, weights) in coarsest.iter_mut().zip(target.values.weights()) {
            if let Some([_, finest]) = weights
                && place.is_none_or(|(_, most)| finest.total_cmp(&most).is_ge())
            {
                *place = Some((k, finest));
            }
        }
    }
    for ((axis, joint), coarsest) in task.robot.axis_joints().enumerate().zip(coarsest) {
        let Some(gap) = task.compensator.on(axis).and_then(deadband::smallest) else { continue };
        let gap = gap * task.options.gain;
        if let Some((k, finest)) = coarsest
            && finest > gap
            && gap > 0.0
        {
            let edge = |v: f64| joint.kind.to_user_unit(v);
            first.get_or_insert(script.steps[k].at);
            coarse.push(CoarseDigit {
                place: script.place(script.steps[k].at).to_string(),
                joint: joint.name.clone(),
                unit: joint.kind.unit(),
                step: edge(finest),
                half_gap: edge(gap),
            });
        }
    }
    let Some(place) = first else { return Ok(None) };
    if joints >= poses {
        return Err(Refusal::CoarseDigits(coarse).into());
    }
    let each: Vec<String> = coarse
        .iter()
        .map(|c| {
            format!("{} (half gap {:.6} {unit}, steps of {:.6} {unit})", c.joint, c.half_gap, c.step, unit = c.unit)
        })
        .collect();
    let text = format!(
        "joint targets hold no offset of {}: they are rounded to what the format holds; the offsets are in the poses",
        each.join(", ")
    );
    Ok(Some(Note { place, text }))
}
