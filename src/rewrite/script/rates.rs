//! Speed and acceleration limits of vendor programs.
//!
//! Where a program holds times, the robot must keep them, and a step that asks a joint for more than it can is spread over a longer
//! travel after its reversal until all limits hold. Elsewhere the controller plans speeds itself and slows down where a joint needs
//! it: there a limit is no reason to refuse the program, and a note tells where time will be lost.

use super::run::Run;
use super::task::Task;
use crate::error::Result;
use crate::program::script::{At, Note, Script};
use crate::rewrite::deadband::smallest;
use crate::rewrite::stats::{LimitKind, RewriteStats, Violation};
use crate::rewrite::{Options, Origin, OutputPoints};
use crate::robot::Robot;
use std::collections::BTreeMap;

/// Travel over which a step is spread, in half gaps of its joint: the first of them that keeps all limits.
const RAMPS: [f64; 6] = [5.0, 10.0, 20.0, 50.0, 100.0, 200.0];

fn is_rate(v: &Violation) -> bool {
    v.what != LimitKind::Range
}

/// What is to be reported of the rates of a whole program.
#[derive(Debug, Default)]
pub struct Rates {
    /// By axis, and speed or not: the largest share of its limit, the first place, the number of places.
    planned: BTreeMap<(usize, bool), (f64, At, u64)>,
    /// By axis: the longest ramp, rad or m, and the first place.
    spread: BTreeMap<usize, (f64, At)>,
}

impl Rates {
    /// One run through the engine, by `through`; where the times of the program would break limits, with a longer ramp.
    pub fn within(
        &mut self,
        script: &Script,
        task: &Task,
        run: &Run,
        options: Options,
        through: &dyn Fn(Options) -> Result<(OutputPoints, RewriteStats)>,
    ) -> Result<(OutputPoints, RewriteStats)> {
        let (emitted, mut stats) = through(options.clone())?;
        if !stats.violations.iter().any(is_rate) {
            return Ok((emitted, stats));
        }
        let at = |v: &Violation| {
            let (Origin::Point(n) | Origin::Inserted { after: n, .. }) = v.origin;
            let step = run.vertices.get(n as usize).and_then(|vertex| script.steps.get(vertex.step));
            step.map_or(At::default(), |s| s.at)
        };
        if !run.by_program {
            for v in stats.violations.iter().filter(|v| is_rate(v)) {
                let entry = self.planned.entry((v.axis, v.what == LimitKind::Speed)).or_insert((0.0, at(v), 0));
                *entry = (entry.0.max((v.value / v.limit).abs()), entry.1, entry.2 + 1);
            }
            stats.violations.retain(|v| !is_rate(v));
            stats.violations_total = stats.out_of_range;
            return Ok((emitted, stats));
        }
        let first: BTreeMap<usize, At> =
            stats.violations.iter().rev().filter(|v| is_rate(v)).map(|v| (v.axis, at(v))).collect();
        let chosen = options.step_exact || options.ramp.iter().any(|&r| r > 0.0);
        for ramp in RAMPS.iter().filter(|_| !chosen) {
            let mut longer = options.clone();
            for &axis in first.keys() {
                let gap = task.compensator.on(axis).and_then(smallest).unwrap_or(0.0);
                longer.ramp[axis] = ramp * gap;
            }
            let ramps = longer.ramp.clone();
            let (emitted, tried) = through(longer)?;
            if !tried.violations.iter().any(is_rate) {
                for (&axis, &place) in &first {
                    let entry = self.spread.entry(axis).or_insert((0.0, place));
                    entry.0 = entry.0.max(ramps[axis]);
                }
                return Ok((emitted, tried));
            }
        }
        Ok((emitted, stats))
    }

    /// A sentence for each joint and kind of limit, at its first place.
    pub fn notes(&self, robot: &Robot) -> Vec<Note> {
        let planned = self.planned.iter().map(|(&(axis, speed), &(share, place, places))| {
            let what = if speed { "speed" } else { "acceleration" };
            let at = if places == 1 { "here".into() } else { format!("at {places} places, first here") };
            let text = format!(
                "at the programmed speed {} would need {share:.2} times its largest {what} ({at}): the controller slows down there; to avoid this, spread the step over a longer ramp",
                robot.axis(axis).name
            );
            Note { place, text }
        });
        let spread = self.spread.iter().map(|(&axis, &(ramp, place))| {
            let joint = robot.axis(axis);
            let text = format!(
                "the step of {} is spread over {:.4} {unit} after its reversals, so that its speed and acceleration stay within the limits at the times of the program; until then, a part of the gap is not compensated",
                joint.name,
                joint.kind.to_user_unit(ramp),
                unit = joint.kind.unit()
            );
            Note { place, text }
        });
        planned.chain(spread).collect()
    }
}
