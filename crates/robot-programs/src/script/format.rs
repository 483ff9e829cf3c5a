//! The interface of a program format: texts to a document, and edits to patches.

use super::edits::Edits;
use super::patches::Patches;
use super::program::Script;
use super::reason::Reason;
use super::step::Way;
use super::text::Text;
use crate::axes::Axes;
use crate::error::Result;
use crate::files::{Files, Folders};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A program format.
pub trait Format: Sync {
    /// Word for `--format` and messages: `inform`.
    fn name(&self) -> &'static str;
    /// As a person calls it: `Yaskawa INFORM (.JBI)`.
    fn title(&self) -> &'static str;
    /// Endings of its files, lower case, without the dot.
    fn endings(&self) -> &'static [&'static str];
    /// Whether a text looks like this format, by its content alone.
    fn recognises(&self, bytes: &[u8]) -> bool;
    /// Further files that belong to the program at `path`, such as the `.dat` of a `.src`, of those that are there.
    fn companions(&self, _path: &Path, _there: &Files) -> Vec<PathBuf> {
        Vec::new()
    }
    /// Further files that declare what a program at `path` uses, of those that are there: the other modules of its project. They are
    /// read and never written. What is found in a folder is kept in `seen`; what is known of the `robot` tells what is asked for.
    fn context(&self, _path: &Path, _seen: &Folders, _robot: &Axes) -> Vec<PathBuf> {
        Vec::new()
    }
    /// Whether another program in the folder of the one at `path`, whose text is `own`, calls or runs it.
    fn is_called(&self, _path: &Path, _own: &Text, _seen: &Folders) -> bool {
        false
    }
    /// Whether a file beside the program may set what it goes to, so that one that cannot be read counts: [`Text::unread`] stands
    /// for it among the context.
    fn minds_unread(&self) -> bool {
        false
    }
    /// An axis whose gear, on most arms of this maker, turns by the sum of its own value and another's as programs show them: the
    /// axis and the other one.
    fn coupled(&self) -> Option<(usize, usize)> {
        None
    }
    /// Reads a program: its own text first, then its companions in their order, then its [context](Text::context).
    ///
    /// # Errors
    /// [`crate::error::Error::BadInput`] with file, line and column where the text cannot be what it must be.
    fn parse(&self, texts: Vec<Text>, robot: &Axes) -> Result<Box<dyn Document>>;
}

/// Least angles of an arc through three points, rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeastArc {
    /// From its start to its end.
    pub whole_rad: f64,
    /// From the point on its way to its end. That point stands in the middle where this leaves it there, else nearer to the start.
    pub after_via_rad: f64,
}

/// A program that has been read.
pub trait Document: Send + Sync {
    /// What the program does, step by step.
    fn script(&self) -> &Script;
    /// The bytes to change so that the program moves as `edits` say; none overlapping.
    ///
    /// # Errors
    /// [`crate::error::Error::Refused`] where the format has no legal way to say it (lines and reason in the message).
    fn patches(&self, edits: &Edits) -> Result<Patches>;
    /// Edited moves that the format cannot say although it reads them (an arc that no centre in its digits holds), and why. A caller
    /// leaves these moves as they are and asks again: what is left of the others may be another case.
    fn unwritable(&self, _edits: &Edits) -> Vec<(usize, Reason)> {
        Vec::new()
    }
    /// The same edits with the patches for them, where the format has these at hand because all can be said.
    fn written_or_not(&self, edits: &Edits) -> (Vec<(usize, Reason)>, Option<Patches>) {
        (self.unwritable(edits), None)
    }
    /// Whether straight moves to Cartesian targets can be written as moves to joint values
    /// ([`Edit::as_joint_moves`](super::Edit::as_joint_moves)).
    fn takes_joints_for_poses(&self) -> bool {
        false
    }
    /// Whether the robot passes the points of a program at their own times: it stops at none of them, although no corner is cut.
    fn passes_points(&self) -> bool {
        false
    }
    /// Whether the goal of a move is written with axes that its target does not name, where a new point before it has moved them.
    fn names_missing_axes(&self) -> bool {
        false
    }
    /// Whether the corner at a goal must not reach into the corner at the next one: the controller refuses it, or skips a corner.
    fn corners_must_not_overlap(&self) -> bool {
        false
    }
    /// How short an arc through three points may be: controllers refuse points too close.
    fn least_arc(&self) -> LeastArc {
        LeastArc { whole_rad: 0.04, after_via_rad: 0.0 }
    }
    /// Joints (rad or m) at a share of the way to the goal of a step, where the format alone knows the way: on an arc, or on a spline
    /// at the time at which a new point of this share is written. An axis of which the format does not know where it stands is NaN.
    /// `None`: straight, or not known.
    fn on_way(&self, _step: usize, _share: f64) -> Option<Vec<f64>> {
        None
    }
    /// By step, points on ways that are not straight in the joints, at shares of their time and so close that straight lines between
    /// them stay at the way, those of [`Move::way`](super::Move::way) among them. A step that is not in it goes straight over
    /// [`Move::way`](super::Move::way).
    fn passed(&self) -> BTreeMap<usize, Vec<Way>> {
        BTreeMap::new()
    }
    /// The goal of a step on a way that is no straight one, as it would stand if the way from the goal before it to the one after it were
    /// straight in the joints: what it is off that way stays. NaN as in [`Document::on_way`]. `None`: the way is straight, or an end of
    /// it is not known.
    fn straightened(&self, _step: usize) -> Option<Vec<f64>> {
        None
    }
}
