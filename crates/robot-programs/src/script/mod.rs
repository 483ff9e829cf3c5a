//! A vendor program in memory: what moves in which order, and where each number of it stands.
//!
//! The interface is small. A [`Format`] reads texts into a [`Document`]; the document shows its [`Script`] (steps with joint
//! targets, and whatever ends what is known of a joint's direction) and turns [`Edits`] (other joint values for a move,
//! new points on the way to it) into [`Patch`]es of bytes. Bytes outside the patches cannot change. Nothing here knows of
//! robots beyond the unit of an axis, nor of compensation.
//!
//! Modules: [`step`] motions and what stands between them; [`targets`] targets, [`edits`] what shall be different and [`patches`] the bytes
//! for it, all in columns; [`thin`] what few moves have; [`alike`] lines that differ in their numbers alone; [`pose`] Cartesian targets;
//! [`reason`] why a move stays as it is;
//! [`number`] numbers and the style in which they are written; [`text`] bytes and lines; [`sites`] what writers of languages with
//! statements share; [`held`] what may be on where control comes from several places, [`processes`] where a process may be; [`kept`] ends of moves that stay, [`last`] which of them come last before a place; [`cursor`] how
//! lexers read bytes; [`lex`] words, numbers and marks of such languages; [`blocks`] their steps, `by_steps` values of some of them; `joins` and `routines` from where control comes to
//! them;
//! [`fold`] expressions of plain numbers; [`called`] programs that a program calls; [`without_joint`] numbers of axes that the robot file
//! does not have.
//!
//! # Example
//!
//! Every format shows its programs in the same way: here a move of URScript, its path, its speed and the line of its target.
//!
//! ```
//! use robot_programs::axes::{Axes, Axis, JointKind};
//! use robot_programs::script::{Format, PathKind, Speed, Text};
//!
//! let axes = Axes::new("arm", (1..=6).map(|i| Axis::new(format!("J{i}"), JointKind::Revolute)).collect());
//! let source = b"def p():\n  movej([0, 0, 0, 0, 0, 0], v=0.5)\n  movel([0.1, 0, 0, 0, 0, 0], v=0.25)\nend\n";
//! let program = robot_programs::urscript::UrScript.parse(vec![Text::new("p.script", source.to_vec())], &axes)?;
//! let script = program.script();
//! let (_, line) = script.moves().nth(1).expect("two moves");
//! assert_eq!((line.path, line.speed), (PathKind::Linear, Speed::Tcp(0.25)));
//! let target = script.targets.get(line.goal.target().expect("numbers")).expect("the target of a move");
//! assert_eq!(target.at.line, 3);
//! # Ok::<(), robot_programs::Error>(())
//! ```

pub mod alike;
pub mod blocks;
mod by_steps;
pub mod called;
pub mod cursor;
pub mod edits;
#[cfg(test)]
mod exact;
pub mod fold;
#[cfg(test)]
pub(crate) mod harness;
pub mod held;
mod joins;
mod kept;
pub mod last;
pub mod lex;
pub mod number;
pub mod patches;
pub mod pose;
pub mod processes;
pub mod reach;
pub mod reason;
mod routines;
pub mod sites;
pub mod step;
pub mod targets;
pub mod text;
pub mod thin;
pub mod without_joint;

use super::files::{Files, Folders};
use crate::axes::Axes;
use crate::error::Result;
pub use blocks::Round;
pub use edits::{Edit, EditRef, Edits, NewPoint, StepEdits};
pub use joins::Join;
pub use patches::{Patch, PatchRef, Patches};
pub use pose::{Frame, OfAxis, PoseForm, PoseGoal, Quantity, Shift, Solution};
pub use reason::Reason;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
pub use step::{At, AxisSet, Break, EndTrigger, Goal, How, Move, Note, OtherWay, PathKind, Speed, Step, StepKind, Way};
pub use targets::{CLONE, Target, TargetRef, Targets, Value, Values, is_clone};
pub use text::{Span, Text};
pub use thin::Few;

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
    /// Whether straight moves to Cartesian targets can be written as moves to joint values ([`Edit::as_joint_moves`]).
    fn takes_joints_for_poses(&self) -> bool {
        false
    }
    /// Whether the robot passes the points of a program at their own times: it stops at none of them, although no corner is cut.
    fn passes_points(&self) -> bool {
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
    /// them stay at the way, those of [`Move::way`] among them. A step that is not in it goes straight over [`Move::way`].
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

/// What a program does, in the order of its text.
#[derive(Debug, Clone, Default)]
pub struct Script {
    /// The program's own text, then its companions, then its context.
    pub texts: Vec<Text>,
    /// In the order of the text.
    pub steps: Vec<Step>,
    /// Joint targets, inline or declared; moves name them by index. One may be used by several moves.
    pub targets: Targets,
    /// What a user should know, with its line: `second motion group is left as it is`.
    pub notes: Vec<Note>,
    /// Words that the program never says although its targets depend on them: `G90 or G91`.
    pub missing: Vec<&'static str>,
    /// No number of an axis word has a decimal point, so that whole numbers may count increments
    /// ([`crate::control::Control::whole_units`]).
    pub only_whole_numbers: bool,
    /// X words may be diameters, as it may be a program of a lathe, and nothing says so ([`crate::control::Control::diameter`]): they stay.
    pub diameter_unstated: bool,
    /// The [`Break::Start`] with which the program starts, where that is not the first.
    pub entry: Option<usize>,
    /// Loops whose every pass goes the same way, innermost ones alone.
    pub rounds: Vec<Round>,
    /// Breaks of which it is known from where alone control comes there, ascending.
    pub joins: Vec<Join>,
    /// The same as the text has them, ascending, each from the places that lead to it at once, and the starts of routines from the calls
    /// of them that the text holds; only where the program has processes.
    pub ways: Vec<Join>,
    /// Lines whose calls may move the robot, and the names that would have to move nothing for these calls to move nothing: none of them is
    /// among the files. Lines of other calls that may move are not here.
    pub unknown_calls: BTreeMap<At, BTreeSet<String>>,
    /// What the controller's files of its project say of where the robot stands and how far its axes go.
    pub installed: Vec<Installed>,
    /// Where its project lets the arm work; only where the program names no joints and a target of it has no configuration.
    pub stance: Option<Stance>,
}

/// What a file of the controller says of where the robot stands and how far its axes go.
#[derive(Debug, Clone)]
pub struct Installed {
    /// Where it says so.
    pub at: At,
    /// The place of the robot's base in the world in which frames are given; inside `None`: its numbers cannot be read.
    pub root: Option<Option<nalgebra::Isometry3<f64>>>,
    /// Lowest and highest value of each axis, rad or m; `None`: not given.
    pub limits: Vec<Option<[f64; 2]>>,
}

/// Where the project of a program lets its arm work: what tells the configuration of targets that have none.
#[derive(Debug, Clone, Default)]
pub struct Stance {
    /// Joints of its home position, rad or m, one per axis.
    pub home: Vec<f64>,
    /// Joints of all its other points that name them.
    pub others: Vec<Vec<f64>>,
    /// Configurations of all its points that name one.
    pub configurations: Vec<pose::Configuration>,
}

impl Script {
    /// Place of a line for a message.
    pub fn place(&self, at: At) -> crate::error::Place {
        let name = self.texts.get(at.file).map_or("", |t| t.name.as_str());
        crate::error::Place::line(name, at.line)
    }

    /// The moves in order, with their steps.
    pub fn moves(&self) -> impl Iterator<Item = (usize, &Move)> {
        self.steps.iter().enumerate().filter_map(|(k, s)| match &s.kind {
            StepKind::Move(m) => Some((k, m)),
            _ => None,
        })
    }

    /// How many moves lead to each target.
    pub fn use_counts(&self) -> Vec<usize> {
        let mut counts = vec![0; self.targets.len()];
        for (_, m) in self.moves() {
            if let Some(count) = m.goal.target().and_then(|t| counts.get_mut(t)) {
                *count += 1;
            }
        }
        counts
    }

    /// Steps whose moves lead to each target.
    pub fn uses(&self) -> Vec<Vec<usize>> {
        let mut uses = vec![Vec::new(); self.targets.len()];
        for (k, m) in self.moves() {
            if let Some(t) = m.goal.target()
                && let Some(list) = uses.get_mut(t)
            {
                list.push(k);
            }
        }
        uses
    }
}

/// A comment's word for the tool: `lostmotion: off`, `lostmotion on`; `None`: the comment is not meant for it.
pub fn pragma(comment: &[u8]) -> Option<bool> {
    let text = String::from_utf8_lossy(comment).to_ascii_lowercase();
    let rest = text.trim_start_matches(|c: char| !c.is_ascii_alphanumeric()).strip_prefix("lostmotion")?;
    match rest.trim_matches(|c: char| !c.is_ascii_alphanumeric()) {
        "off" => Some(false),
        "on" => Some(true),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comment_switches_the_tool_off_and_on() {
        assert_eq!(pragma(b"' lostmotion: off"), Some(false));
        assert_eq!(pragma(b"; LOSTMOTION ON"), Some(true));
        assert_eq!(pragma(b"(lostmotion: on)"), Some(true));
        assert_eq!(pragma(b"! lostmotion is a tool"), None);
        assert_eq!(pragma(b"! weld on"), None);
    }
}
