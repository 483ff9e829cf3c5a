//! Was the program rewritten before? By its names, its joint targets, and its Cartesian targets ([`retraced`]).

use super::fading::ByClock;
use super::retraced;
use super::run::{Role, Run, Vertex};
use super::task::Task;
use crate::program::script::{Document, Script, is_clone};
use crate::rewrite::rewritten::{Digits, Evidence, Rows};

/// Last digit of an axis that no target names, rad or m.
const LEAST_DIGIT: f64 = 1e-9;

/// By names that `rewrite` makes, or by its numbers, run by run: by what the gears turn.
pub(super) fn looks_rewritten(document: &dyn Document, runs: &[Run], task: &Task, by_clock: &ByClock) -> bool {
    let script = document.script();
    let axes = task.robot.dof();
    let digits = written_digits(script, axes);
    let mut evidence = Evidence::default();
    if script.targets.iter().filter_map(|t| t.name).any(is_clone) {
        return true;
    }
    // what several runs lead through counts once
    for run in runs.iter().filter(|run| !run.is_again()) {
        let mut q: Vec<f64> = of_program(run).flat_map(|v| v.q.iter().copied()).collect();
        q.chunks_exact_mut(axes).for_each(|row| task.robot.to_gears(row));
        let mut straight = straightened(document, run);
        straight.chunks_exact_mut(axes).for_each(|row| task.robot.to_gears(row));
        let rows = Rows { q: &q, straight: &straight, axes };
        evidence.add(rows, &digits, by_clock.on(run), task.options.step_fraction);
    }
    evidence.is_rewritten() || retraced::looks_rewritten(script, runs, task.robot, by_clock)
}

/// The points of a run that the program has itself: one that is to be added before a target would look as if it had been.
fn of_program(run: &Run) -> impl Iterator<Item = &Vertex> {
    run.own().iter().filter(|v| v.role != Role::Approach)
}

/// The points of a run beside straight ways between their neighbours; none where all ways are straight.
fn straightened(document: &dyn Document, run: &Run) -> Vec<f64> {
    let place = |v: &Vertex| document.straightened(v.step).filter(|_| v.role == Role::Goal);
    if !document.passes_points() || of_program(run).all(|v| place(v).is_none()) {
        return Vec::new();
    }
    let row = |v: &Vertex| place(v).map_or_else(|| v.q.to_vec(), |q| run.standing(v.step, q, &v.q));
    of_program(run).flat_map(row).collect()
}

/// How the numbers of each axis are written: the finest last digit of its targets, in degrees or radians (millimetres or metres),
/// or in steps of the format's own.
fn written_digits(script: &Script, axes: usize) -> Vec<Digits> {
    let mut finest = vec![f64::INFINITY; axes];
    for target in script.targets.iter() {
        for (finest, weights) in finest.iter_mut().zip(target.values.weights()) {
            *finest = weights.map_or(*finest, |[digit, _]| finest.min(digit));
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
