//! Speed and acceleration limits of vendor programs.
//!
//! Where a program holds times, the robot must keep them, and a step that asks a joint for more than it can is spread over a longer
//! travel after its reversal until all limits hold: each reversal for itself, as a joint may be fast at one and slow at the next. Until a
//! spread step is done the joint is further off than without it; a joint whose error grows by that along the whole run ([`super::spread`])
//! stays without offsets. Elsewhere the controller plans speeds itself and slows down where a joint needs
//! it: there a limit is no reason to refuse the program, and a note tells where time will be lost.

use super::run::Run;
use super::spread;
use super::task::Task;
use crate::error::Result;
use crate::program::script::{At, Note, Script};
use crate::rewrite::deadband::smallest;
use crate::rewrite::stats::{LimitKind, RewriteStats, Violation};
use crate::rewrite::{Options, Origin, OutputPoints};
use crate::robot::Robot;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Travel over which a step is spread, in half gaps of its joint: the first of them that keeps all limits.
const RAMPS: [f64; 6] = [5.0, 10.0, 20.0, 50.0, 100.0, 200.0];
/// Runs through the engine in search of the ramps of single reversals: a longer one may bring the next reversal to its limit.
const MOST_RUNS: usize = 24;

fn is_rate(v: &Violation) -> bool {
    v.what != LimitKind::Range
}

/// What is to be reported of the rates of a whole program.
#[derive(Debug, Default)]
pub struct Rates {
    /// By axis, and speed or not: the largest share of its limit, the first place, the number of places.
    planned: BTreeMap<(usize, bool), (f64, At, u64)>,
    /// By axis: where its steps are spread.
    spread: BTreeMap<usize, Spread>,
    /// Axes without offsets in a run, and the first place at which a step would break a limit.
    without: BTreeMap<usize, At>,
}

/// Steps of a joint that are spread.
#[derive(Debug, Clone, Copy)]
struct Spread {
    /// The shortest and the longest travel, rad or m.
    over: [f64; 2],
    /// Reversals; 0: all.
    reversals: usize,
    place: At,
}

impl Spread {
    /// The same with those of another run.
    fn and(self, other: Self) -> Self {
        let [a, b] = [self.over, other.over];
        let all = self.reversals == 0 || other.reversals == 0;
        let reversals = if all { 0 } else { self.reversals + other.reversals };
        Self { over: [a[0].min(b[0]), a[1].max(b[1])], reversals, place: self.place }
    }
}

/// What comes out of a run.
type Through<'a> = dyn Fn(Options) -> Result<(OutputPoints, RewriteStats)> + 'a;
/// Ramps, rad or m, by axis and the point of the reversal; of all reversals of an axis where there is no point.
type Ramps = BTreeMap<(usize, Option<u64>), f64>;

impl Rates {
    /// One run through the engine, by `through`; where the times of the program would break limits, with a longer ramp.
    pub fn within(
        &mut self,
        script: &Script,
        task: &Task,
        run: &Run,
        options: Options,
        through: &Through,
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
        if chosen {
            return Ok((emitted, stats));
        }
        let gap = |axis: usize| task.compensator.on(axis).and_then(smallest).unwrap_or(0.0);
        let left = |found: &Found, axis: usize| spread::left(task, run, &found.2.0, axis).unwrap_or(0.0);
        let of_all = |found: &Found| first.keys().map(|&axis| left(found, axis)).sum::<f64>();
        let ways = [by_reversal(&options, &stats, &gap, through)?, by_axis(&options, &first, &gap, through)?];
        // the first of those that leave least: a reversal that has to wait for the next one may need a travel that none alone needs
        let found = ways.into_iter().flatten().min_by(|a, b| of_all(a).total_cmp(&of_all(b)));
        let Some(found) = found else { return Ok((emitted, stats)) };
        let worse = first.keys().copied().filter(|&axis| left(&found, axis) > 1.0);
        let worse: BTreeSet<usize> = worse.collect();
        let (options, ramps, done) = found;
        if worse.is_empty() {
            self.note(&ramps, &first, &worse);
            return Ok(done);
        }
        let done = through(Options { without: worse.iter().copied().collect(), ..options })?;
        if done.1.violations.iter().any(is_rate) {
            return Ok((emitted, stats));
        }
        self.note(&ramps, &first, &worse);
        Ok(done)
    }

    /// Notes what was spread, and which axes stay without offsets.
    fn note(&mut self, ramps: &Ramps, first: &BTreeMap<usize, At>, without: &BTreeSet<usize>) {
        for (&axis, &place) in first.iter().filter(|(axis, _)| without.contains(axis)) {
            self.without.entry(axis).or_insert(place);
        }
        for (&(axis, point), &ramp) in ramps.iter().filter(|((axis, _), _)| !without.contains(axis)) {
            let Some(&place) = first.get(&axis) else { continue };
            let one = Spread { over: [ramp; 2], reversals: usize::from(point.is_some()), place };
            self.spread.entry(axis).and_modify(|s| *s = s.and(one)).or_insert(one);
        }
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
        let spread = self.spread.iter().map(|(&axis, spread)| {
            let joint = robot.axis(axis);
            let [least, most] = spread.over.map(|v| format!("{:.4}", joint.kind.to_user_unit(v)));
            let over = if least == most { most } else { format!("{least} to {most}") };
            let after = match spread.reversals {
                0 => "its reversals".into(),
                1 => "one of its reversals".into(),
                n => format!("{n} of its reversals"),
            };
            let text = format!(
                "the step of {} is spread over {over} {unit} after {after}, so that its mean speeds between points, and their changes, stay within the limits at the times of the program; until then, a part of the gap is not compensated",
                joint.name,
                unit = joint.kind.unit()
            );
            Note { place: spread.place, text }
        });
        let without = self.without.iter().map(|(&axis, &place)| {
            let text = format!(
                "{} stays without compensation: at the times of the program its steps would have to be spread over so much travel that its error would grow; a slower program lets it be compensated",
                robot.axis(axis).name
            );
            Note { place, text }
        });
        planned.chain(spread).chain(without).collect()
    }
}

/// Ramps that keep all limits, with the options that hold them and what comes out.
type Found = (Options, Ramps, (OutputPoints, RewriteStats));

/// Longer and longer ramps after those reversals alone whose steps break limits; `None`: they do not help.
fn by_reversal(
    options: &Options,
    stats: &RewriteStats,
    gap: &dyn Fn(usize) -> f64,
    through: &Through,
) -> Result<Option<Found>> {
    let mut lengths: BTreeMap<(usize, u64), usize> = BTreeMap::new();
    let mut strained = stats.strained.clone();
    for _ in 0..MOST_RUNS {
        if strained.is_empty() {
            break;
        }
        for reversal in &strained {
            lengths.entry(*reversal).and_modify(|k| *k += 1).or_insert(0);
        }
        let ramps = lengths.iter().map(|(&(axis, point), &k)| Some(((axis, point), RAMPS.get(k)? * gap(axis))));
        let Some(ramps) = ramps.collect::<Option<BTreeMap<_, _>>>() else { break };
        let longer = Options { ramps_after: Arc::new(ramps), ..options.clone() };
        let done = through(longer.clone())?;
        if !done.1.violations.iter().any(is_rate) {
            let ramps = longer.ramps_after.iter().map(|(&(axis, point), &ramp)| ((axis, Some(point)), ramp)).collect();
            return Ok(Some((longer, ramps, done)));
        }
        strained = done.1.strained;
    }
    Ok(None)
}

/// The same after all reversals of an axis that breaks limits anywhere.
fn by_axis(
    options: &Options,
    first: &BTreeMap<usize, At>,
    gap: &dyn Fn(usize) -> f64,
    through: &Through,
) -> Result<Option<Found>> {
    for ramp in RAMPS {
        let mut longer = options.clone();
        for &axis in first.keys() {
            longer.ramp[axis] = ramp * gap(axis);
        }
        let done = through(longer.clone())?;
        if !done.1.violations.iter().any(is_rate) {
            let ramps = first.keys().map(|&axis| ((axis, None), longer.ramp[axis])).collect();
            return Ok(Some((longer, ramps, done)));
        }
    }
    Ok(None)
}
