//! Whether the commands of a run carry a compensator's offsets: a log of the original program beside the run of the rewritten one looks
//! like a run that left the whole compensation as its error.
//!
//! Method: at a reversal the offset changes sides, so commands with offsets pass twice the half gap at once, and go on as the program does.
//! Commands of the program alone never do: from rest with a constant acceleration the first such travel takes 2.4 times as long as the
//! next one, and at a corner of even speed as long. Less than half as long is a step. Reversals after which the
//! second travel takes fewer than [`LEAST_ROWS`] rows do not tell, nor do gaps near the last digit of the file.

use crate::compensator::{Compensator, JointCompensator};
use crate::effects::Track;
use crate::error::{Error, Place, Result};
use crate::log::Log;
use crate::robot::Robot;

/// Rows from which the time of a travel is known.
const LEAST_ROWS: f64 = 4.0;
/// Last digits of a command that the step has at least.
const LEAST_DIGITS: f64 = 4.0;
/// Time of the first travel over that of the next, below which there is a step.
const STEP: f64 = 0.5;
/// Reversals that tell, from which a log is judged.
const FEWEST: usize = 4;
/// Decimals of a command column whose number is not known.
const DECIMALS: u8 = 6;

/// Refuses a log with reversals of which most lack the step of the compensator.
///
/// # Errors
/// Bad input that names the log which is wanted.
pub(super) fn refuse_without_offsets(robot: &Robot, log: &Log, previous: &Compensator) -> Result<()> {
    if log.poses {
        return Ok(());
    }
    let (mut told, mut steps) = (0, 0);
    for joint in previous.joints.iter().filter(|j| j.axis < log.cmd.len()) {
        let found = judged(robot, log, joint);
        told += found.len();
        steps += found.iter().filter(|s| **s).count();
    }
    if told < FEWEST || 2 * steps >= told {
        return Ok(());
    }
    let found = format!(
        "commands without the compensator's offsets: only {steps} of {told} reversals have the step of twice the half gap"
    );
    let expected = "the run of a program that was rewritten with this compensator, with the commands of the rewritten program in the log (not those of \
                    the original one)";
    Err(Error::bad(Place::file(&log.name), found, expected))
}

/// Of each reversal that tells, whether it has the step.
fn judged(robot: &Robot, log: &Log, joint: &JointCompensator) -> Vec<bool> {
    let (Some(offset), Some(p)) = (&joint.backlash, log.cmd.get(joint.axis)) else { return Vec::new() };
    // friction that builds up takes from the step
    if joint.friction.is_some_and(|f| f.gain < 0.0) {
        return Vec::new();
    }
    let decimals = log.cmd_decimals.get(joint.axis).copied().unwrap_or(DECIMALS);
    let digit = 10f64.powi(-i32::from(decimals)) * robot.axis(joint.axis).kind.si_per_user_unit();
    let step = |at: f64| offset.positive.at(at) + offset.negative.at(at);
    let least = offset.positive.smallest() + offset.negative.smallest();
    let track = Track::new(&log.t_s, p, (least / 2.0).max(digit));
    let told = track.strokes().filter_map(|(turn, rows)| {
        let whole = step(turn.p);
        if whole < LEAST_DIGITS * digit {
            return None;
        }
        let passed = |travel: f64| passes(&log.t_s, p, rows.clone(), turn.p, f64::from(turn.dir), travel);
        let [(first_s, from), (next_s, to)] = [passed(whole)?, passed(2.0 * whole)?];
        let resolved = (to - from) >= LEAST_ROWS;
        resolved.then_some(first_s - turn.t_s < STEP * (next_s - first_s))
    });
    told.collect()
}

/// When a stroke has moved by `travel` from `from`: time in s, and row; both between rows.
fn passes(
    t_s: &[f64],
    p: &[f64],
    rows: std::ops::Range<usize>,
    from: f64,
    dir: f64,
    travel: f64,
) -> Option<(f64, f64)> {
    let moved = |i: usize| dir * (p[i] - from);
    let i = rows.clone().find(|&i| moved(i) >= travel)?;
    let before = i.checked_sub(1)?;
    let share = ((travel - moved(before)) / (moved(i) - moved(before))).clamp(0.0, 1.0);
    Some((t_s[before] + share * (t_s[i] - t_s[before]), before as f64 + share))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensator::BacklashOffset;
    use crate::effects::GapCurve;
    use crate::io::input::Input;

    /// Judged reversals of a slow oscillation whose commands carry steps of `mm` at each reversal, of a half gap of 0.02 mm.
    fn steps(mm: f64) -> Vec<bool> {
        let robot = Robot::parse(
            "robot.yaml",
            "schema: lostmotion/robot/1\nconvention: dh-standard\njoints:\n  - {name: X, kind: prismatic, limits_mm: [-100, 100]}\n",
        )
        .unwrap();
        let mut text = String::from("t_s,cmd_X_mm,x_mm,y_mm,z_mm\n");
        for i in 0..5000 {
            let t = f64::from(i) * 0.02;
            let (p, v) = ((0.5 * t).sin(), (0.5 * t).cos());
            text += &format!("{t:.3},{:.6},0,0,{:.5}\n", p + mm * v.signum(), p);
        }
        let log =
            Log::parse(Input { name: "run.csv".into(), bytes: text.into(), sha256: String::new() }, &robot).unwrap();
        let backlash = Some(BacklashOffset::symmetric(GapCurve::Constant(2e-5)));
        judged(&robot, &log, &JointCompensator { axis: 0, backlash, friction: None })
    }

    #[test]
    fn commands_with_and_without_the_offsets_are_told_apart() {
        let (with, without) = (steps(0.02), steps(0.0));
        assert!(with.len() > 10 && with.iter().all(|s| *s), "{with:?}");
        assert!(without.len() > 10 && without.iter().all(|s| !*s), "{without:?}");
    }
}
