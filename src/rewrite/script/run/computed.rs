//! Frames and tools that the program computes: the user gives one value for each, and the program may have another one.
//!
//! A target with its offset and a point between two targets are right for every value, as long as they are written in the same frame and
//! for the same tool. A point on the way from such a place to another one, or from another one to it, would be written where the value that
//! is given puts it: the robot would go there first. The step of such a move is spread over its way instead.

use super::{Cutter, LastFrame};
use crate::program::script::pose::{Frame, PoseGoal};
use crate::program::script::{Move, PathKind};

impl LastFrame {
    fn is_computed(&self) -> bool {
        self.own.iter().any(Frame::is_computed)
    }

    /// Frame and tool of a goal are those of this target; which of several it is may have changed.
    fn is_of(&self, goal: &PoseGoal) -> bool {
        let one = |frame: &Frame| !(matches!(frame, Frame::Any(_)) && frame.is_computed());
        self.own.iter().zip([&goal.frame, &goal.tool]).all(|(own, other)| own == other && one(own))
    }
}

impl Cutter<'_> {
    /// Whether no point can be on the way to a Cartesian target from where the robot stands.
    pub(super) fn changes_to(&self, goal: &PoseGoal) -> bool {
        match &self.last_frame {
            Some(before) => (before.is_computed() || goal.is_computed()) && !before.is_of(goal),
            // from joint values
            None => goal.is_computed(),
        }
    }

    /// The same of joint values: from a target in a computed place, or straight with a computed tool.
    pub(super) fn changes_to_joints(&self, m: &Move) -> bool {
        let tooled = m.path == PathKind::Linear && m.tool.as_ref().is_some_and(|t| t.is_computed());
        tooled || self.last_frame.as_ref().is_some_and(LastFrame::is_computed)
    }

    /// The program sets a name: a frame or tool that is made of it is another one, and where the robot stands in it is not known.
    pub(super) fn set(&mut self, name: &str) {
        let made = |last: &LastFrame| last.own.iter().any(|frame| frame.is_made_of(name));
        if self.last_frame.as_ref().is_some_and(made) {
            self.last_frame = None;
            self.end(false);
        }
    }
}
