//! What must be known of a program to compare its result with it.

use super::{fault, via};
use crate::error::Error;
use crate::program::script::{At, Break, Edits, Goal, Move, PathKind, PoseGoal, Script, StepKind, Value};
use nalgebra::Vector3;
use std::mem::{Discriminant, discriminant};

/// What must be known of a program to compare its result with it: far less than the program itself.
#[derive(Debug, Default)]
pub struct Before {
    names: Vec<String>,
    pub(super) steps: Vec<Step>,
    /// Numbers of the moves' targets, one after the other; NaN: not commanded.
    values: Vec<f64>,
}

#[derive(Debug)]
pub(super) struct Step {
    line: u32,
    file: u32,
    pub(super) kind: Kind,
}

impl Step {
    pub(super) fn at(&self) -> At {
        At { file: self.file as usize, line: self.line.into() }
    }
}

#[derive(Debug)]
pub(super) enum Kind {
    Move(Own),
    Other(Discriminant<StepKind>),
    /// Of some axes it is not known any more where they are. Whether it is so may hang on numbers: a turn by half a turn or more.
    LostAxes,
}

#[derive(Debug)]
pub(super) struct Own {
    pub(super) path: PathKind,
    goal: OwnGoal,
    /// NaN: not known.
    pub(super) blend_m: f64,
    /// Of a Cartesian goal.
    pose: Option<Box<OwnPose>>,
    /// The first of its numbers, and how many.
    first: u32,
    count: u16,
}

#[derive(Debug)]
enum OwnGoal {
    Joints,
    Pose,
    Opaque,
}

#[derive(Debug)]
struct OwnPose {
    /// `None`: it is edited, so that its numbers are what counts.
    goal: Option<PoseGoal>,
    /// Of an arc: the point on its way, in the frame of its goal.
    via_m: Option<Vector3<f64>>,
}

impl Own {
    pub(super) fn via_m(&self) -> Option<Vector3<f64>> {
        self.pose.as_ref()?.via_m
    }

    /// Another move leads to the same place in the same way; `values`: the numbers of this one's target.
    pub(super) fn alike(&self, values: &[f64], after: &Script, other: &Move) -> bool {
        let same = match (&self.goal, &other.goal) {
            (OwnGoal::Joints, Goal::Joints(t)) => {
                let same = |(own, v): (&f64, Option<Value>)| v.map_or(own.is_nan(), |v| v.si == *own);
                let there = after.targets.get(*t).map(|t| t.values).unwrap_or_default();
                values.len() == there.len() && values.iter().zip(there.iter()).all(same)
            }
            (OwnGoal::Pose, Goal::Pose(t)) => self.pose.as_ref().and_then(|own| own.goal.as_ref()).is_some_and(|s| {
                s.position_m == t.position_m
                    && s.rotation == t.rotation
                    && s.frame == t.frame
                    && s.tool == t.tool
                    && s.external == t.external
            }),
            (OwnGoal::Opaque, Goal::Opaque(_)) => true,
            _ => false,
        };
        same && self.path == other.path
    }
}

impl Before {
    /// Of a program to which `edits` are made.
    pub fn of(script: &Script, edits: &Edits) -> Self {
        let mut all = Self { names: script.texts.iter().map(|t| t.name.clone()).collect(), ..Self::default() };
        all.steps.reserve_exact(script.steps.len());
        let numbers = script.moves().filter_map(|(_, m)| script.targets.get(m.goal.target()?)).map(|t| t.values.len());
        all.values.reserve_exact(numbers.sum());
        for (k, step) in script.steps.iter().enumerate() {
            let kind = match &step.kind {
                StepKind::Move(m) => {
                    Kind::Move(all.own(script, m, edits.steps.get(k).is_some_and(|e| e.goal.is_some())))
                }
                StepKind::Break(Break::Axes(_)) => Kind::LostAxes,
                other => Kind::Other(discriminant(other)),
            };
            all.steps.push(Step { line: step.at.line as u32, file: step.at.file as u32, kind });
        }
        all
    }

    pub(super) fn own(&mut self, script: &Script, m: &Move, edited: bool) -> Own {
        let (goal, pose) = match &m.goal {
            Goal::Joints(_) => (OwnGoal::Joints, None),
            Goal::Pose(goal) => {
                let own = OwnPose { goal: (!edited).then(|| (**goal).clone()), via_m: via(m) };
                (OwnGoal::Pose, (own.goal.is_some() || own.via_m.is_some()).then(|| Box::new(own)))
            }
            Goal::Opaque(_) => (OwnGoal::Opaque, None),
        };
        let values = m.goal.target().and_then(|t| script.targets.get(t)).map(|t| t.values).unwrap_or_default();
        let first = self.values.len();
        self.values.extend(values.si_or_nan());
        let (first, count) = (first as u32, values.len() as u16);
        let blend_m = m.blend_m.unwrap_or(f64::NAN);
        Own { path: m.path, goal, blend_m, pose, first, count }
    }

    /// What the target of a move says as it is, by axis; empty where it has no numbers.
    pub(super) fn values(&self, own: &Own) -> &[f64] {
        let first = own.first as usize;
        self.values.get(first..first + usize::from(own.count)).unwrap_or_default()
    }

    pub(super) fn fault(&self, k: usize, what: &str) -> Error {
        let at = self.steps.get(k).map(Step::at);
        fault(at.map(|at| (self.names.get(at.file).map_or("", String::as_str), at)), what)
    }
}
