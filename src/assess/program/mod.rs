//! Path error along any program, before and after it was changed, and the verdict: better, unchanged or worse.
//!
//! Method: the reference is the TCP path that the program as it was would draw on the same machine without the joint errors that
//! an offset can undo (gap, friction, hysteresis, ripple, scale, zero, coupling, gravity). Geometry, tool, servo lag and
//! drift stay in the reference: no joint offset is meant to move them. The error of a point is its distance to that path, looked
//! for near the same length of path ([`path`]). Both runs are compared point by point along the path ([`runs`]), at the reversals of
//! the joints, by their cycle time and by their text ([`text`]). [`verdict`] turns the figures into a word; `rewrite` uses the same function.
//!
//! A program that grows its largest error is worse, whatever its mean does.
//!
//! Where a model does not say on which side of its gap a joint starts, the joint comes from the direction in which it first moves:
//! what a run does before its gaps have closed depends on the approach, which a program does not hold.
//!
//! Assumptions: both programs draw the same path (a difference of more than [`path::SLACK_M`] in its length is noted). A log is
//! compared after a rigid fit onto the reference: geometry errors that the model does not hold count in both runs.
//!
//! Files beside:
//! - `document`: the document `lostmotion/program-assessment/1`

pub mod document;
pub mod path;
pub mod runs;
pub mod text;
pub mod verdict;

pub use runs::{Measured, Run};
pub use verdict::{Figures, Verdict, judge};

use crate::effects::{Backlash, BacklashPosition, Effect, PreslidingStiction, Stage, Stiction, Target};
use crate::error::{Error, Place, Result};
use crate::log::Log;
use crate::model::Model;
use crate::program::Program;
use path::Reference;

/// Seconds after a reversal within which its largest error is looked for, and before it (a step may come early).
pub const WINDOW_S: [f64; 2] = [-0.1, 4.0];

/// Share of its half gap by which a joint may move and come back before that is its first movement: a program that starts at a turning
/// point of a joint has such steps there, and the joint does not follow them.
const CREEP: f64 = 0.1;

/// What was run: a program, at its own times or at a TCP speed, or a log with what was measured.
pub enum Source<'a> {
    Program(&'a Program),
    Log(&'a Log),
}

/// What a user may choose.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// TCP speed of a program without times, m/s.
    pub speed_m_s: f64,
    /// The speed goes before a program's own times.
    pub at_speed: bool,
}

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
    pub notes: Vec<String>,
}

/// The machine without the joint errors that an offset can undo.
fn reference_machine(model: &Model) -> Model {
    let friction = |e: &Effect| e.is::<Stiction>() || e.is::<PreslidingStiction>();
    let stays = |e: &Effect| !matches!(e.stage(), Stage::Gear | Stage::Link) && !friction(e);
    let effects = model.effects.iter().filter(|e| stays(&e.effect)).cloned().collect();
    Model { effects, ..model.clone() }
}

/// Compares two runs on the model's machine.
///
/// # Errors
/// Where a run has fewer than two points, does not move, or a log has no TCP.
pub fn assess(model: &Model, before: &Source, after: &Source, options: &Options) -> Result<Assessment> {
    let mut base = model.clone();
    base.registration = None;
    for (side, first) in base.initial_gap_side.iter_mut().zip(before.first_directions(model)) {
        if *side == 0 {
            *side = first;
        }
    }
    let model = &base;
    let ideal = reference_machine(model);
    let rate_hz = runs::rate_hz(model, before, options);
    let wanted = runs::simulated(&ideal, before, options, rate_hz)?;
    let reference = Reference::new(&wanted.points_m, &wanted.t_s);
    if reference.length_m() <= 0.0 {
        let found = "a program that does not move the TCP";
        return Err(Error::bad(Place::file(before.name()), found, "a path"));
    }
    let mut notes = Vec::new();
    let run = |source: &Source| -> Result<Run> {
        let measured = match source {
            Source::Program(_) => runs::simulated(model, source, options, rate_hz)?,
            Source::Log(log) => runs::measured(&ideal, log, &reference)?,
        };
        Ok(Run::new(source.name(), &measured, &reference))
    };
    let (first, second) = (run(before)?, run(after)?);
    let off = (first.length_m - second.length_m).abs();
    if off > path::SLACK_M.max(0.01 * reference.length_m()) {
        notes.push(format!(
            "the commanded paths differ in length by {:.2} mm of {:.1} mm: do both programs draw the same path?",
            off * 1e3,
            reference.length_m() * 1e3
        ));
    }
    let reversals = reversals(&wanted, &first, &second);
    let figures = Figures::of(&first, &second, &reversals);
    let verdict = judge(&figures);
    Ok(Assessment { before: first, after: second, reversals, figures, verdict, notes })
}

impl Source<'_> {
    /// Direction in which each joint first moves by more than [`CREEP`] of its half gap there; 0: it rests.
    fn first_directions(&self, model: &Model) -> Vec<i8> {
        let columns = match self {
            Self::Program(p) => &p.q,
            Self::Log(l) => &l.cmd,
        };
        let first = |(axis, q): (usize, &Vec<f64>)| {
            let least = (CREEP * half_gap(model, axis, q.first().copied().unwrap_or(0.0))).max(runs::REST);
            let moved = q.iter().map(|x| x - q[0]).find(|d| d.abs() > least);
            moved.map_or(0, |d| if d > 0.0 { 1 } else { -1 })
        };
        columns.iter().enumerate().map(first).collect()
    }

    pub fn name(&self) -> &str {
        match self {
            Self::Program(p) => &p.name,
            Self::Log(l) => &l.name,
        }
    }
}

/// Half gap of an axis at a position, rad or m.
fn half_gap(model: &Model, axis: usize, at: f64) -> f64 {
    let of = |e: &Effect| match (e.get::<Backlash>(), e.get::<BacklashPosition>()) {
        (Some(b), _) => b.half_gap,
        (_, Some(b)) => b.half_gap.at(at),
        _ => 0.0,
    };
    model.effects.iter().filter(|e| e.target == Target::Joint(axis)).map(|e| of(&e.effect)).sum()
}

/// Reversals of the run before, with the largest error of both runs on the same stretch of path.
fn reversals(wanted: &Measured, before: &Run, after: &Run) -> Vec<ReversalError> {
    let mut out = Vec::new();
    for turn in &wanted.turns {
        let [from, to] = WINDOW_S.map(|s| turn.at_s + s);
        let within = |run: &Run| {
            let on_stretch = run.reference_s.iter().zip(&run.errors_m).filter(|(t, _)| **t >= from && **t <= to);
            on_stretch.map(|(_, e)| *e).fold(0.0, f64::max)
        };
        out.push(ReversalError {
            axis: turn.axis,
            at_s: turn.at_s,
            command: turn.command,
            direction: turn.direction,
            before_m: within(before),
            after_m: within(after),
        });
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::EffectInstance;
    use crate::robot::Robot;

    #[test]
    fn a_step_within_the_gap_before_the_first_stroke_is_no_first_movement() {
        let text = "schema: lostmotion/robot/1\njoints:\n  - {name: A1, kind: revolute, a_mm: 500}\n";
        let robot = Robot::parse("robot.yaml", text).unwrap();
        let mut model = Model::ideal(robot.clone());
        model.effects.push(EffectInstance { target: Target::Joint(0), effect: Backlash::constant(7e-5).into() });
        // half gap 0.004 deg
        for (first, wanted) in [("-0.00004", 1), ("-0.00060", -1), ("0.0", 1)] {
            let rows = format!("a1_deg\n0.0\n{first}\n0.1\n0.2\n");
            let program = Program::of_texts(vec![("p.csv".into(), rows.into_bytes())], &robot).unwrap();
            assert_eq!(Source::Program(&program).first_directions(&model), [wanted], "{first}");
        }
    }
}
