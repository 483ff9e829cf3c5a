//! Straight relative motions after a known place: `LIN_REL {X 10,Z -100} #TOOL`.
//!
//! Grammar read here: `LIN_REL {X v,Y v,Z v,A v,B v,C v} [C_...] [#BASE | #TOOL]`, any of the components (`SLIN_REL` likewise). They count
//! from the end of the motion before: along the axes of $BASE without a word and with `#BASE`, along those of the tool as it stands there with
//! `#TOOL` (KUKA System Software, Operating and Programming Instructions for System Integrators). Where the goal leads is known
//! where the motion before ends exactly at a known point in the same frame for the same tool, and nothing turns: angles are 0 or
//! not given.
//!
//! Such a goal is known and not written, and neither is the point before it: with an offset that would be another place from which the
//! motion counts. X, Y and Z cannot take that back, as the offsets of the joints turn the tool, too. The point before a relative motion that is not known
//! (`PTP_REL`) stays for the same reason.

use super::aggregate::Aggregate;
use super::lex::{Token, upper};
use super::motion::Word;
use crate::script::pose::{Frame, PoseGoal};
use crate::script::{PathKind, Solution, Text};
use nalgebra::{UnitQuaternion, Vector3};

/// Why such a goal is not written, and why the one before it is not.
pub(super) const ITSELF: &str = "a relative motion: it counts from where the motion before ends";
pub(super) const BEFORE: &str = "a relative motion after it would carry its offset along";

/// Why the goal is not known.
pub(super) const UNKNOWN: &str = "a relative motion: the goal depends on where the robot stands";

/// The place where the robot stands after a motion.
#[derive(Debug, Clone)]
pub(super) struct Stands {
    pub position_m: Vector3<f64>,
    pub rotation: UnitQuaternion<f64>,
    pub frame: Frame,
    pub tool: Frame,
}

impl Stands {
    pub fn of(goal: &PoseGoal) -> Option<Self> {
        let (position_m, rotation) = (goal.position_m, goal.rotation?);
        Some(Self { position_m, rotation, frame: goal.frame.clone(), tool: goal.tool.clone() })
    }

    /// Where a straight relative motion leads from here, in the frame and for the tool in force at it.
    pub fn moved(
        &self,
        text: &Text,
        word: Word,
        a: &Aggregate,
        tail: &[Token],
        in_force: (Frame, Frame),
    ) -> Option<PoseGoal> {
        let of_tool = tail.windows(2).any(|w| w[0].is(b'#') && upper(text, &w[1]) == "TOOL");
        let known = |name: &str| match a.component(name) {
            None => Some(0.0),
            Some(c) => c.value.as_ref().map(|v| v.1),
        };
        let turns = ["A", "B", "C"].iter().any(|n| known(n) != Some(0.0));
        let other = a.components.iter().any(|c| !["X", "Y", "Z", "A", "B", "C"].contains(&c.name.as_str()));
        let with = tail.iter().any(|t| upper(text, t) == "WITH");
        if word.path != PathKind::Linear
            || with
            || turns
            || other
            || (&self.frame, &self.tool) != (&in_force.0, &in_force.1)
        {
            return None;
        }
        let by = Vector3::new(known("X")?, known("Y")?, known("Z")?) * 1e-3;
        let by = if of_tool { self.rotation * by } else { by };
        Some(PoseGoal {
            position_m: self.position_m + by,
            rotation: Some(self.rotation),
            frame: self.frame.clone(),
            tool: self.tool.clone(),
            solution: Solution::Same,
            ..PoseGoal::default()
        })
    }
}
