//! What is compared: programs or logs, and the choices of a user.

use crate::effects::{Backlash, BacklashPosition, Effect, Target};
use crate::log::Log;
use crate::model::Model;
use crate::program::Program;

/// Share of its half gap by which a joint may move and come back before that is its first movement: a program that starts at a turning
/// point of a joint has such steps there, and the joint does not follow them.
const CREEP: f64 = 0.1;

/// A change of a target by more half gaps is no offset for its gap alone.
const MOST_OFFSET: f64 = 1.5;

/// Points that do not move by more than this (rad or m) are stationary.
pub(super) const REST: f64 = 1e-9;

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

impl Source<'_> {
    /// Direction in which each joint first moves by more than [`CREEP`] of its half gap there; 0: it is stationary.
    pub(super) fn first_directions(&self, model: &Model) -> Vec<i8> {
        let columns = match self {
            Self::Program(p) => &p.q,
            Self::Log(l) => &l.cmd,
        };
        let first = |(axis, q): (usize, &Vec<f64>)| {
            let least = (CREEP * half_gap(model, axis, q.first().copied().unwrap_or(0.0))).max(REST);
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

/// Sides of their gaps for which the first point of the program after has offsets, per axis; 0: it has none, or one of another size.
pub(super) fn sides_of_offsets(model: &Model, before: &Source, after: &Source) -> Vec<i8> {
    let (Source::Program(before), Source::Program(after)) = (before, after) else { return vec![0; model.robot.dof()] };
    let side = |(axis, (b, a)): (usize, (&Vec<f64>, &Vec<f64>))| {
        let (Some(b), Some(a)) = (b.first(), a.first()) else { return 0 };
        let (by, gap) = (a - b, half_gap(model, axis, *b));
        let is_offset = by.abs() > CREEP * gap && by.abs() < MOST_OFFSET * gap;
        if is_offset { by.signum() as i8 } else { 0 }
    };
    before.q.iter().zip(&after.q).enumerate().map(side).collect()
}

/// Half gap of an axis at a position, rad or m.
pub(super) fn half_gap(model: &Model, axis: usize, at: f64) -> f64 {
    let of = |e: &Effect| match (e.get::<Backlash>(), e.get::<BacklashPosition>()) {
        (Some(b), _) => b.half_gap,
        (_, Some(b)) => b.half_gap.at(at),
        _ => 0.0,
    };
    model.effects.iter().filter(|e| e.target == Target::Joint(axis)).map(|e| of(&e.effect)).sum()
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
