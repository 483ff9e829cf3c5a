//! Relative motions after a known place: `LIN_REL {X 10,Z -100} #TOOL`, `PTP_REL {A1 5}`.
//!
//! Grammar read here: `LIN_REL {X v,Y v,Z v,A v,B v,C v} [C_...] [#BASE | #TOOL]`, any of the components (`SLIN_REL` likewise). They count
//! from the end of the motion before: along the axes of $BASE without a word and with `#BASE`, along those of the tool as it stands there
//! with `#TOOL` (KUKA System Software, Operating and Programming Instructions for System Integrators). Where the goal leads is known
//! where the motion before ends exactly at a known point in the same frame for the same tool, and nothing turns: angles are 0 or
//! not given. `PTP_REL` (`SPTP_REL`) of axis values counts from those of the motions before, where the last ends exactly.
//!
//! Such a goal is known and not written, and neither is the point before it: with an offset that would be another place from which the
//! motion counts. X, Y and Z cannot take that back, as the offsets of the joints turn the tool, too. The point before a relative motion
//! that is not known (`PTP_REL {Z 10}`) stays for the same reason, and so does the last one before a call of a routine that may begin with
//! one.

use super::aggregate::{Aggregate, Component};
use super::calls::calls;
use super::lex::{Kind, Token, tokens, upper};
use super::made::Made;
use super::motion::{self, Word};
use super::name::Holds;
use super::statement::is_routine;
use crate::axes::JointKind;
use crate::script::pose::{Frame, PoseGoal};
use crate::script::{PathKind, Solution, Targets, Text, number};
use nalgebra::{UnitQuaternion, Vector3};
use std::collections::BTreeSet;

/// Decimals of axis values to which a relative motion leads.
const FINE: u8 = 6;

/// Names of the routines of a program and its project in which a relative motion stands, themselves or in what they call: it may be the
/// first that they make, and count from where their caller has led the robot.
pub(super) fn routines(texts: &[Text]) -> BTreeSet<String> {
    let counting: Vec<_> = texts.iter().map(|t| t.known(Counting::of)).collect();
    with_callers(texts, counting.iter().flat_map(|c| c.moves.iter().cloned()).collect())
}

/// The same of the routines that are `found`, with those that call them.
pub(super) fn with_callers(texts: &[Text], mut found: BTreeSet<String>) -> BTreeSet<String> {
    // few projects have any
    while !found.is_empty() {
        let known = found.len();
        for text in texts {
            callers(text, &mut found);
        }
        if found.len() == known {
            break;
        }
    }
    found
}

/// Routines of a text that hold a relative motion.
#[derive(Default)]
struct Counting {
    moves: BTreeSet<String>,
}

impl Counting {
    fn of(text: &Text) -> Self {
        let mut moves = BTreeSet::new();
        let holds = |word: &[u8]| memchr::memmem::find(&text.bytes, word).is_some();
        if !["_REL", "_rel", "_Rel"].iter().any(|w| holds(w.as_bytes())) {
            return Self::default();
        }
        each_line(text, |routine, line| {
            let relative = line.first().is_some_and(|t| motion::word(&upper(text, t)).is_some_and(|w| w.relative));
            if relative && !moves.contains(routine) {
                moves.insert(routine.to_string());
            }
        });
        Self { moves }
    }
}

/// Adds the routines of a text that call one of those that are found.
fn callers(text: &Text, found: &mut BTreeSet<String>) {
    each_line(text, |routine, line| {
        if !found.contains(routine) && calls(text, line).iter().any(|name| found.contains(name)) {
            found.insert(routine.to_string());
        }
    });
}

/// Calls `look` with the name of the routine and the tokens of each of its lines.
pub(super) fn each_line(text: &Text, mut look: impl FnMut(&str, &[Token])) {
    let (mut name, mut line) = (String::new(), Vec::new());
    for k in 0..text.line_count() {
        tokens(text, k, &mut line);
        line.retain(|t| t.kind != Kind::Comment);
        let Some(first) = line.first() else { continue };
        let second = line.get(1).map(|t| upper(text, t)).unwrap_or_default();
        if is_routine(&upper(text, first), &second) {
            let open = line.iter().position(|t| t.is(b'('));
            name = open.and_then(|o| o.checked_sub(1)).map(|n| upper(text, &line[n])).unwrap_or_default();
        } else {
            look(&name, &line);
        }
    }
}

/// The place where the robot stands after a motion.
#[derive(Debug, Clone)]
pub(super) enum Stands {
    Pose {
        position_m: Vector3<f64>,
        rotation: UnitQuaternion<f64>,
        frame: Frame,
        tool: Frame,
    },
    /// At this target of axis values.
    Target(usize),
    /// rad or m of each axis; `None`: not known.
    Axes(Vec<Option<f64>>),
}

impl Stands {
    pub fn of(goal: &PoseGoal) -> Option<Self> {
        let (position_m, rotation) = (goal.position_m, goal.rotation?);
        Some(Self::Pose { position_m, rotation, frame: goal.frame.clone(), tool: goal.tool.clone() })
    }

    /// rad or m of each axis, where it stands at axis values. Of axes that the motion does not name nothing is known: a new point before it
    /// names them all.
    fn axes(&self, targets: &Targets) -> Option<Vec<Option<f64>>> {
        match self {
            Self::Target(t) => Some(targets.get(*t)?.values.iter().map(|v| v.map(|v| v.si)).collect()),
            Self::Axes(all) => Some(all.clone()),
            Self::Pose { .. } => None,
        }
    }

    /// After a relative motion to the target `t`: axes that it does not name are where they were `before`.
    pub fn turned_to(before: Option<&Self>, t: usize, targets: &Targets) -> Option<Self> {
        let stood = before.and_then(|s| s.axes(targets)).unwrap_or_default();
        let now = Self::Target(t).axes(targets)?;
        Some(Self::Axes(now.into_iter().enumerate().map(|(k, v)| v.or(stood.get(k).copied().flatten())).collect()))
    }

    /// The axis values to which `PTP_REL {A1 5}` leads from here, as an aggregate: the axes that it names.
    ///
    /// `relative = aggregate {"C_..."}`
    pub fn turned(
        &self,
        text: &Text,
        word: Word,
        a: &Aggregate,
        tail: &[Token],
        axes: &[(String, JointKind)],
        targets: &Targets,
    ) -> Option<Made> {
        let plain = !tail.iter().any(|t| t.is(b'#') || upper(text, t) == "WITH");
        let stood = self.axes(targets)?;
        if word.path != PathKind::Joint || !plain {
            return None;
        }
        let part = |c: Component| {
            let name = c.name.as_str();
            let axis = axes.iter().position(|(own, _)| own == name)?;
            let kind = axes.get(axis)?.1;
            let value = kind.to_user_unit(stood.get(axis).copied().flatten()?) + c.value?.1;
            let style = number::Style { decimals: FINE, point: true, ..number::Style::default() };
            Some((name.to_string(), number::write(value, style, FINE).into_bytes()))
        };
        Made::of(&a.components().map(part).collect::<Option<_>>()?, Holds::Axes)
    }

    /// Where a straight relative motion leads from here, in the frame and for the tool in force at it.
    ///
    /// `relative = aggregate {"C_..."} ["#" "TOOL"] ["WITH" ...]`
    pub fn moved(
        &self,
        text: &Text,
        word: Word,
        a: &Aggregate,
        tail: &[Token],
        in_force: (Frame, Frame),
    ) -> Option<PoseGoal> {
        let Self::Pose { position_m, rotation, frame, tool } = self else { return None };
        let of_tool = tail.windows(2).any(|w| w[0].is(b'#') && upper(text, &w[1]) == "TOOL");
        let known = |name: &str| match a.component(name) {
            None => Some(0.0),
            Some(c) => c.value.map(|v| v.1),
        };
        let turns = ["A", "B", "C"].iter().any(|n| known(n) != Some(0.0));
        let other = a.components().any(|c| !["X", "Y", "Z", "A", "B", "C"].contains(&c.name.as_str()));
        let with = tail.iter().any(|t| upper(text, t) == "WITH");
        if word.path != PathKind::Linear || with || turns || other || (frame, tool) != (&in_force.0, &in_force.1) {
            return None;
        }
        let by = Vector3::new(known("X")?, known("Y")?, known("Z")?) * 1e-3;
        let by = if of_tool { rotation * by } else { by };
        Some(PoseGoal {
            position_m: position_m + by,
            rotation: Some(*rotation),
            frame: frame.clone(),
            tool: tool.clone(),
            solution: Solution::Same,
            ..PoseGoal::default()
        })
    }
}
