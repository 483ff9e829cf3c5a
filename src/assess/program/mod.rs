//! Path error along any program, before and after it was changed, and the verdict: better, unchanged or worse.
//!
//! Method: the reference is the TCP path that the program as it was would draw on the same machine without the joint errors that
//! an offset can undo (gap, friction, hysteresis, ripple, scale, zero, coupling, gravity). Geometry, tool, servo lag and
//! drift stay in the reference: no joint offset is meant to move them. The error of a point is its distance to that path, looked
//! for near the same length of path ([`path`]). Both runs are compared point by point along the path ([`runs`]), at the reversals of
//! the joints, by their cycle time and by their text ([`text`]). [`verdict`] turns the figures into a word; `rewrite` uses the same
//! function.
//!
//! A program that grows its largest error is worse, whatever its mean does.
//!
//! Where a model does not say on which side of its gap a joint starts, the joint comes from the direction in which it first moves:
//! what a run does before its gaps have closed depends on the approach, which a program does not hold. Where a stretch in the middle of a
//! program starts at a target with an offset, the joint comes from the side that the offset is for: the way there is in no stretch, so
//! a wrong offset at such a start is not seen here.
//!
//! Assumptions: both programs draw the same path (a difference of more than [`path::SLACK_M`] in its length is noted). A log is
//! compared after a rigid fit onto the reference: geometry errors that the model does not hold count in both runs.
//!
//! Files beside:
//! - `document`: the document `lostmotion/program-assessment/1`
//! - `frame`: the frame of a log, across the path
//! - `note`: what a reader should know
//! - `source`: what is compared
//! - `targets`: the error where the robot stops or is taught
//! - `stretches`: programs of which parts are not known, stretch by stretch

pub(crate) mod document;
mod frame;
pub mod note;
pub(crate) mod path;
pub(crate) mod runs;
mod source;
mod stretches;
mod targets;
pub(crate) mod text;
pub(crate) mod verdict;

pub use note::Note;
pub use runs::{Measured, Run};
pub use source::{Options, Source};
pub use verdict::{AtTargets, Figures, Verdict, judge};

use crate::compensator::from_model::part_of_geometry;
use crate::effects::{Effect, Nature, Stage};
use crate::error::{Error, Place, Result};
use crate::io::memory;
use crate::log::Log;
use crate::model::Model;
use crate::numerics::parallel::ParMap;
use crate::program::{Moves, Program};
use crate::robot::Robot;
use std::collections::VecDeque;

/// Seconds after a reversal within which its largest error is looked for, and before it (a step may come early).
pub const WINDOW_S: [f64; 2] = [-0.1, 4.0];

/// A reversal of a joint and the largest error after it, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReversalError {
    pub axis: usize,
    /// s on the clock of the run before.
    pub at_s: f64,
    /// Command, rad or m, and direction of the new movement.
    pub command: f64,
    pub direction: i8,
    pub before_m: f64,
    pub after_m: f64,
}

/// The comparison.
#[derive(Debug, Clone)]
pub struct Assessment {
    pub before: Run,
    pub after: Run,
    pub reversals: Vec<ReversalError>,
    pub figures: Figures,
    pub verdict: Verdict,
    /// How much of the program before is in the verdict; `None`: all of it, rows of joints or a log.
    pub moves: Option<Moves>,
    pub notes: Vec<Note>,
}

impl Assessment {
    /// The reversal after which the error grows most, where it grows.
    pub fn worst_reversal(&self) -> Option<&ReversalError> {
        let grows = |r: &&ReversalError| r.after_m > r.before_m;
        let growth = |r: &&ReversalError| r.after_m - r.before_m;
        self.reversals.iter().filter(grows).max_by(|a, b| growth(a).total_cmp(&growth(b)))
    }
}

/// The machine without the joint errors that an offset undoes. Zero offsets and gravity that belong to a calibrated geometry stay:
/// `rewrite` leaves them to the kinematics.
fn reference_machine(model: &Model) -> Model {
    let friction = |e: &Effect| matches!(e.nature(), Nature::Spike | Nature::Presliding);
    let of_joint = |e: &Effect| matches!(e.stage(), Stage::Gear | Stage::Link) || friction(e);
    let effects =
        model.effects.iter().filter(|e| !of_joint(&e.effect) || part_of_geometry(model, e)).cloned().collect();
    Model { effects, ..model.clone() }
}

/// Compares two runs on the model's machine. Where a gap belongs to a sum of axes, they are run in what the gears turn by.
///
/// # Errors
/// Where a run has fewer than two points, does not move, or a log has no TCP.
pub fn assess(model: &Model, before: &Source, after: &Source, options: &Options) -> Result<Assessment> {
    if let Some(robot) = model.robot.of_gears() {
        let [first, second] = [before, after].map(|source| InGears::of(source, &model.robot));
        let model = Model { robot, ..model.clone() };
        return by_axes(&model, &first.source(), &second.source(), options);
    }
    let mut found = by_axes(model, before, after, options)?;
    if model.robot.has_sums() {
        found.notes.push(Note::JointsAlone);
    }
    Ok(found)
}

/// A run as what the gears turn by.
enum InGears {
    Program(Box<Program>),
    Log(Box<Log>),
}

impl InGears {
    fn of(source: &Source, robot: &Robot) -> Self {
        match source {
            Source::Program(program) => Self::Program(Box::new(program.by_gears(robot))),
            Source::Log(log) => Self::Log(Box::new(log.by_gears(robot))),
        }
    }

    fn source(&self) -> Source<'_> {
        match self {
            Self::Program(program) => Source::Program(program),
            Self::Log(log) => Source::Log(log),
        }
    }
}

fn by_axes(model: &Model, before: &Source, after: &Source, options: &Options) -> Result<Assessment> {
    let mut notes = Vec::new();
    let parts = stretches::of(model, before, after, &mut notes);
    let parts = match parts {
        None => vec![part(model, [before, after], options, runs::Rows::whole(), false)?],
        Some(pairs) => {
            let total_m: f64 = pairs.iter().map(|p| p.length_m).sum();
            let one = |p: &stretches::Pair| {
                let [before, after] = [Source::Program(&p.before), Source::Program(&p.after)];
                part(model, [&before, &after], options, runs::Rows::share(p.length_m / total_m), p.anew)
            };
            pairs.par_map(one).into_iter().collect::<Result<Vec<_>>>()?
        }
    };
    if parts.is_empty() {
        let found = "no move whose start, path and goal are known in both programs";
        return Err(Error::bad(Place::file(before.name()), found, "a path"));
    }
    notes.extend(speed_note(before, options));
    let stops = |source: &Source, own: usize| match source {
        Source::Program(p) => p.script.as_ref().map_or(own, |s| s.exact_stops),
        Source::Log(_) => own,
    };
    let mut all = Part::together(parts);
    for (run, source) in [(&mut all.before, before), (&mut all.after, after)] {
        run.stops = stops(source, run.stops);
        run.name = source.name().into();
    }
    notes.extend(all.notes);
    let figures = Figures::of(&all.before, &all.after, &all.reversals, AtTargets::of(&all.targets));
    let verdict = judge(&figures);
    let moves = match before {
        Source::Program(p) => p.script.as_ref().map(|s| s.moves),
        Source::Log(_) => None,
    };
    Ok(Assessment { before: all.before, after: all.after, reversals: all.reversals, figures, verdict, moves, notes })
}

/// At which speed a program runs that does not state one.
fn speed_note(before: &Source, options: &Options) -> Option<Note> {
    let Source::Program(p) = before else { return None };
    if options.at_speed {
        return None;
    }
    let speed_m_s = options.speed_m_s;
    match (&p.t_s, &p.script) {
        (None, Some(_)) => Some(Note::SpeedNotStated { speed_m_s }),
        (None, None) => Some(Note::NoTimes { speed_m_s }),
        (Some(_), Some(s)) if s.moves.unknown_speed > 0 => {
            Some(Note::UnknownSpeed { moves: s.moves.unknown_speed, assumed: s.assumed })
        }
        _ => None,
    }
}

/// The comparison of two runs without a gap between their points.
struct Part {
    before: Run,
    after: Run,
    reversals: Vec<ReversalError>,
    /// Errors at the targets, before and after, m.
    targets: Vec<[f64; 2]>,
    notes: Vec<Note>,
}

impl Part {
    /// Several, one after the other.
    fn together(parts: Vec<Self>) -> Self {
        let mut parts = parts.into_iter();
        let Some(mut all) = parts.next() else {
            let (before, after) = (Run::default(), Run::default());
            return Self { before, after, reversals: Vec::new(), targets: Vec::new(), notes: Vec::new() };
        };
        for part in parts {
            all.before.append(part.before);
            all.after.append(part.after);
            all.reversals.extend(part.reversals);
            all.targets.extend(part.targets);
            all.notes.extend(part.notes);
        }
        all.before.total();
        all.after.total();
        all
    }
}

/// `anew`: both runs start in the middle of their programs.
fn part(model: &Model, [before, after]: [&Source; 2], options: &Options, rows: runs::Rows, anew: bool) -> Result<Part> {
    let mut base = model.clone();
    base.registration = None;
    let first = before.first_directions(model);
    let sides = if anew { source::sides_of_offsets(model, before, after) } else { vec![0; first.len()] };
    for (side, (first, own)) in base.initial_gap_side.iter_mut().zip(first.into_iter().zip(sides)) {
        *side = match [if anew { own } else { *side }, first] {
            [0, first] => first,
            [known, _] => known,
        };
    }
    let model = &base;
    let ideal = reference_machine(model);
    let sampling = runs::sampling(model, before, options, rows);
    memory::require(before.name(), "a comparison", sampling.memory())?;
    let targets = targets::Targets::of(model, before, after);
    let mut wanted = runs::simulated(&ideal, before, options, sampling, &targets.before)?;
    let reference = wanted.become_reference();
    if reference.length_m() <= 0.0 {
        let found = "a program that does not move the TCP";
        return Err(Error::bad(Place::file(before.name()), found, "a path"));
    }
    let mut notes = Vec::new();
    let run = |source: &Source, at: &[usize]| {
        let measured = match source {
            Source::Program(_) => runs::simulated(model, source, options, sampling, at)?,
            Source::Log(log) => runs::measured(&ideal, log, &reference)?,
        };
        Ok::<_, Error>((Run::new(source.name(), &measured, &reference), measured.deviations_m))
    };
    let (first, first_off_m) = run(before, &targets.before)?;
    let (second, second_off_m) = run(after, &targets.after)?;
    let off_m = [&first_off_m[..], &second_off_m];
    let targets = targets.errors(&model.robot, [before, after], &wanted.deviations_m, off_m);
    let off = (first.length_m - second.length_m).abs();
    if off > path::SLACK_M.max(0.01 * reference.length_m()) {
        notes.push(Note::LengthsDiffer { off_m: off, length_m: reference.length_m() });
    }
    let reversals = reversals(&wanted, &first, &second);
    Ok(Part { before: first, after: second, reversals, targets, notes })
}

/// Reversals of the run before, with the largest error of both runs on the same stretch of path.
fn reversals(wanted: &Measured, before: &Run, after: &Run) -> Vec<ReversalError> {
    let windows: Vec<[f64; 2]> = wanted.turns.iter().map(|turn| WINDOW_S.map(|s| turn.at_s + s)).collect();
    let within = |run: &Run| largest_within(&run.reference_s, &run.errors_m, &windows);
    let (before, after) = (within(before), within(after));
    let turns = wanted.turns.iter().zip(before.into_iter().zip(after));
    turns
        .map(|(turn, (before_m, after_m))| ReversalError {
            axis: turn.axis,
            at_s: turn.at_s,
            command: turn.command,
            direction: turn.direction,
            before_m,
            after_m,
        })
        .collect()
}

/// Largest of `values` whose times lie within each window, 0 where there is none. The windows are of one width, in order of time.
fn largest_within(t_s: &[f64], values: &[f64], windows: &[[f64; 2]]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..t_s.len()).collect();
    order.sort_by(|a, b| t_s[*a].total_cmp(&t_s[*b]));
    // of those that are within, each one is larger than all that come after it
    let mut within: VecDeque<usize> = VecDeque::new();
    let mut next = 0;
    let of = |[from, to]: &[f64; 2]| {
        while let Some(&row) = order.get(next).filter(|row| t_s[**row] <= *to) {
            while within.back().is_some_and(|last| values[*last] <= values[row]) {
                within.pop_back();
            }
            within.push_back(row);
            next += 1;
        }
        while within.front().is_some_and(|first| t_s[*first] < *from) {
            within.pop_front();
        }
        within.front().map_or(0.0, |row| values[*row])
    };
    windows.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_within_each_window_is_that_of_a_plain_search() {
        let t: Vec<f64> = (0..400).map(|i| f64::from((i * 37) % 400) * 0.1).collect();
        let v: Vec<f64> = (0..400).map(|i| f64::from((i * 151) % 397)).collect();
        let windows: Vec<[f64; 2]> = (0..90).map(|k| [f64::from(k) * 0.5 - 3.0, f64::from(k) * 0.5 - 1.2]).collect();
        let plain = |w: &[f64; 2]| {
            let on = t.iter().zip(&v).filter(|(t, _)| **t >= w[0] && **t <= w[1]);
            on.map(|(_, v)| *v).fold(0.0, f64::max)
        };
        assert_eq!(largest_within(&t, &v, &windows), windows.iter().map(plain).collect::<Vec<f64>>());
    }
}
