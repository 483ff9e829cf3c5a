//! Lengths of the TCP's ways on joint moves, which the durations of moves with a TCP speed need: they are measured on several processors
//! before a large script is cut. The same numbers come out of [`clock`] move by move.

use super::{Choice, arm};
use crate::numerics::parallel::{self, ParMap};
use crate::program::script::{Goal, Move, PathKind, Script, Speed, StepKind};
use crate::rewrite::script::clock;
use crate::robot::{JointKind, Robot};

/// Fewest ways that are measured together, and ways of one piece.
const LEAST: usize = 4096;
const PIECE: usize = 1024;

/// The way from one joint target to another.
struct Way {
    step: u32,
    targets: [u32; 2],
    length_m: f64,
}

/// Lengths of ways, by the step that goes there.
#[derive(Default)]
pub(super) struct Lengths(Vec<Way>);

impl Lengths {
    /// Of the joint moves of a script that follow another one.
    pub(super) fn of(script: &Script, choice: &Choice) -> Self {
        // where nothing turns a way is measured at once
        let robot = choice.robot;
        let turns = robot.axis_joints().any(|j| j.kind == JointKind::Revolute);
        if !turns || script.steps.len() < LEAST || parallel::threads() < 2 {
            return Self::default();
        }
        let mut ways = Vec::new();
        let mut before = None;
        for (step, one) in script.steps.iter().enumerate() {
            let StepKind::Move(m) = &one.kind else { continue };
            let Goal::Joints(to) = m.goal else {
                before = None;
                continue;
            };
            if let Some(from) = before.filter(|_| is_measured(m, choice)) {
                ways.push(Way { step: step as u32, targets: [from, to as u32], length_m: f64::NAN });
            }
            before = Some(to as u32);
        }
        if ways.len() < LEAST {
            return Self::default();
        }
        let pieces = parallel::pieces(ways.len(), PIECE);
        let all = &ways;
        let lengths = pieces.par_map(|piece| {
            let mut room = Vec::new();
            let ways = all.get(piece.clone()).unwrap_or_default();
            ways.iter().map(|way| length_m(script, robot, way, &mut room)).collect::<Vec<f64>>()
        });
        for (way, length_m) in ways.iter_mut().zip(lengths.into_iter().flatten()) {
            way.length_m = length_m;
        }
        Self(ways)
    }

    /// Of the way of a step between joints; `None`: it is not measured, or goes between others.
    pub(super) fn at(&self, script: &Script, step: usize, from: &[f64], to: &[f64]) -> Option<f64> {
        let way = self.0.get(self.0.binary_search_by_key(&step, |way| way.step as usize).ok()?)?;
        let is = |target: u32, q: &[f64]| {
            let there = script.targets.get(target as usize).map(|t| t.values).unwrap_or_default();
            there.len() == q.len() && there.si_or_nan().zip(q).all(|(a, b)| a == *b)
        };
        let [a, b] = way.targets;
        (!way.length_m.is_nan() && is(a, from) && is(b, to)).then_some(way.length_m)
    }
}

/// Whether the duration of a move needs the length of its way.
fn is_measured(m: &Move, choice: &Choice) -> bool {
    let given = choice.certain_speed_m_s.is_some();
    let speed = match m.speed {
        Speed::Tcp(v) => v > 0.0,
        Speed::Unknown => given || choice.tcp_speed_m_s.is_some(),
        Speed::Share(_) | Speed::Joint(_) => given,
        Speed::Seconds(_) => false,
    };
    speed && m.path == PathKind::Joint && m.way.is_empty()
}

/// NaN: a target does not name all joints.
fn length_m(script: &Script, robot: &Robot, way: &Way, room: &mut Vec<f64>) -> f64 {
    let joints = |t: u32| arm::joints_of(script.targets.get(t as usize)?, robot.dof());
    let [Some(a), Some(b)] = way.targets.map(joints) else { return f64::NAN };
    clock::joint_way_m(robot, robot.tcp_m(&a), (&a, &b), room)
}
