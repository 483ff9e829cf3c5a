//! A vendor program in memory: what moves in which order, and where each number of it stands.
//!
//! The interface is small. A [`Format`] reads texts into a [`Document`]; the document shows its [`Script`] (steps with joint
//! targets, and whatever ends what is known of a joint's direction) and turns [`Edits`] (other joint values for a move,
//! new points on the way to it) into [`Patch`]es of bytes. Bytes outside the patches cannot change. Nothing here knows of
//! robots beyond the unit of an axis, nor of compensation.
//!
//! Modules: [`targets`] targets, [`edits`] what shall be different and [`patches`] the bytes for it, all in columns; [`thin`] what few moves
//! have; [`alike`] lines that differ in their numbers alone; [`pose`] Cartesian targets; [`number`] numbers and the style in which they
//! are written; [`text`] bytes and lines; [`sites`] what writers of languages with statements share; [`held`] what may be on where
//! control comes from several places; [`kept`] ends of moves that stay; [`cursor`] how lexers read bytes; [`lex`] words, numbers and marks of
//! such languages; [`blocks`]
//! their steps; [`fold`] expressions of plain numbers; [`called`] programs that a program calls.
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
pub mod called;
pub mod cursor;
pub mod edits;
pub mod fold;
#[cfg(test)]
pub(crate) mod harness;
pub mod held;
mod kept;
pub mod lex;
pub mod number;
pub mod patches;
pub mod pose;
pub mod sites;
pub mod targets;
pub mod text;
pub mod thin;

use super::files::{Files, Folders};
use crate::axes::Axes;
use crate::error::Result;
pub use edits::{Edit, EditRef, Edits, NewPoint, StepEdits};
pub use patches::{Patch, PatchRef, Patches};
pub use pose::{Frame, PoseForm, PoseGoal, Quantity, Shift, Solution};
use std::collections::BTreeSet;
use std::ops::{Deref, DerefMut, Range};
use std::path::{Path, PathBuf};
use std::sync::Arc;
pub use targets::{CLONE, TargetRef, Targets, Values, is_clone};
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
    /// read and never written. What is found in a folder is kept in `seen`.
    fn context(&self, _path: &Path, _seen: &Folders) -> Vec<PathBuf> {
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
    fn unwritable(&self, _edits: &Edits) -> Vec<(usize, String)> {
        Vec::new()
    }
    /// The same edits with the patches for them, where the format has these at hand because all can be said.
    fn written_or_not(&self, edits: &Edits) -> (Vec<(usize, String)>, Option<Patches>) {
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
    /// Joints (rad or m) at a share of the way to the goal of a step, where the format alone knows the way: on an arc. `None`:
    /// straight, or not known.
    fn on_way(&self, _step: usize, _share: f64) -> Option<Vec<f64>> {
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
    /// The [`Break::Start`] with which the program starts, where that is not the first.
    pub entry: Option<usize>,
}

/// A sentence about a place of the program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// Line of the program.
    pub place: At,
    /// What to know, in words.
    pub text: String,
}

/// A place: text and line, counted from 1.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct At {
    /// Number of the file, from 0: the order of the texts.
    pub file: usize,
    /// Line, from 1.
    pub line: u64,
}

/// One step.
#[derive(Debug, Clone)]
pub struct Step {
    /// Line at which it stands.
    pub at: At,
    /// What it is.
    pub kind: StepKind,
}

impl Step {
    /// A step that follows `before`: moves that go alike share what they have in common.
    pub fn following(before: Option<&Self>, at: At, mut kind: StepKind) -> Self {
        if let (StepKind::Move(m), Some(Self { kind: StepKind::Move(last), .. })) = (&mut kind, before)
            && (Arc::ptr_eq(&m.how, &last.how) || m.how == last.how)
        {
            m.how = Arc::clone(&last.how);
        }
        Self { at, kind }
    }
}

/// What a step of a program is.
#[derive(Debug, Clone)]
pub enum StepKind {
    /// A motion.
    Move(Move),
    /// The robot stands; directions stay known. Seconds where they are written.
    Dwell(Option<f64>),
    /// Where the robot comes from is not known after this: directions are unknown, and so is the position unless the move
    /// before it certainly led here.
    Break(Break),
    /// A process (welding, dispensing) goes on or off.
    Process(bool),
    /// A comment `lostmotion: off` (`false`: nothing is changed from here) or `lostmotion: on`.
    Pragma(bool),
}

/// Why directions are unknown from here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Break {
    /// Start of a routine.
    Start,
    /// A label, a jump, a branch.
    Jump,
    /// Start or end of a loop.
    Loop,
    /// A call of something that may move the robot.
    Call,
    /// An interrupt or trigger that may move the robot is armed.
    Interrupt,
    /// Tool, frame, unit or position was set in a way that moves the meaning of targets.
    Frame,
}

/// A motion instruction. How it goes there is its [`How`], as which it can be read and changed.
#[derive(Debug, Clone)]
pub struct Move {
    /// Where it leads.
    pub goal: Goal,
    /// Turning points on the way that the format knows itself (quadrants of an arc), in order, without the goal.
    pub way: Few<Way>,
    /// Moves that follow each other mostly share it.
    how: Arc<How>,
}

impl Move {
    /// A motion to `goal`.
    pub fn new(how: How, goal: Goal, way: impl Into<Few<Way>>) -> Self {
        Self { goal, way: way.into(), how: Arc::new(how) }
    }

    /// A motion that goes as this one does, straight to another goal.
    pub fn alike(&self, goal: Goal) -> Self {
        Self { goal, way: Few::new(), how: Arc::clone(&self.how) }
    }

    /// Whether both share how they go, as moves that follow each other do where it is the same.
    pub fn shares_how(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.how, &other.how)
    }
}

impl Deref for Move {
    type Target = How;

    fn deref(&self) -> &How {
        &self.how
    }
}

impl DerefMut for Move {
    fn deref_mut(&mut self) -> &mut How {
        Arc::make_mut(&mut self.how)
    }
}

/// How a motion goes to its goal.
#[derive(Debug, Clone, PartialEq)]
pub struct How {
    /// How the TCP or the joints get there.
    pub path: PathKind,
    /// Why the goal's numbers may not be changed, although they are known: `declared in another module`. `None`: they may.
    pub fixed: Option<String>,
    /// Whether new points may be put on the way to the goal (most arcs given by three points allow none). Why not.
    pub closed: Option<String>,
    /// How fast, as far as the program determines it.
    pub speed: Speed,
    /// Radius within which the corner at the goal is cut, m; 0: exact stop; `None`: not known.
    pub blend_m: Option<f64>,
    /// Of a straight motion to joint values: the tool whose TCP goes straight; `None`: the language names none. A Cartesian goal has its own.
    pub tool: Option<Frame>,
    /// Of a curve to joint values: its turning points on the way are all that there are. Else where its joints turn is not known.
    pub turns_known: bool,
    /// Its goal counts from where the motion before ends: an offset there would be carried along.
    pub relative: bool,
    /// Its goal is one of three joint targets through which the TCP goes on an arc: the targets, in the order in which they are passed.
    /// To the first the path is straight.
    pub circle: Option<[usize; 3]>,
}

impl Default for How {
    /// Straight in the joints, and nothing is known.
    fn default() -> Self {
        Self {
            path: PathKind::Joint,
            fixed: None,
            closed: None,
            speed: Speed::Unknown,
            blend_m: None,
            tool: None,
            turns_known: false,
            relative: false,
            circle: None,
        }
    }
}

/// A point on the way to a goal.
#[derive(Debug, Clone, PartialEq)]
pub struct Way {
    /// Share of the way, above 0 and below 1.
    pub share: f64,
    /// rad or m, one per axis.
    pub q: Vec<f64>,
}

/// How the robot moves between its points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathKind {
    /// Straight in the joints.
    Joint,
    /// The TCP on a straight line.
    Linear,
    /// The TCP on an arc, a spline, or something else.
    Curve,
}

/// Where a move leads.
#[derive(Debug, Clone)]
pub enum Goal {
    /// Index into [`Script::targets`].
    Joints(usize),
    /// A Cartesian pose; boxed, as it is large beside the others.
    Pose(Box<PoseGoal>),
    /// Neither can be determined from the text: why.
    Opaque(String),
}

impl Goal {
    /// A Cartesian pose.
    pub fn pose(goal: PoseGoal) -> Self {
        Self::Pose(Box::new(goal))
    }

    /// The target whose numbers lead there.
    pub fn target(&self) -> Option<usize> {
        match self {
            Self::Joints(t) => Some(*t),
            Self::Pose(goal) => goal.target,
            Self::Opaque(_) => None,
        }
    }
}

/// Speed of a move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Speed {
    /// Of the TCP, m/s.
    Tcp(f64),
    /// Share of the joints' largest speeds, 0 to 1.
    Share(f64),
    /// Of the leading joint, rad/s or m/s.
    Joint(f64),
    /// Duration of the whole move, s; 0 of a first point at which the robot stands already.
    Seconds(f64),
    /// Not determined by the program.
    Unknown,
}

/// A target as it is written: joint values, or the numbers of a pose.
#[derive(Debug, Clone, Default)]
pub struct Target {
    /// `None`: joint values, one per axis of the robot. Else the numbers of a pose in this form.
    pub pose: Option<PoseForm>,
    /// Name where it has one: `C00003`, `jHome`, `P[4]`.
    pub name: Option<String>,
    /// Line at which it stands.
    pub at: At,
    /// One per axis of the robot; `None`: this target does not command the axis, it stays where it is.
    pub values: Vec<Option<Value>>,
}

/// A number of a target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// rad or m.
    pub si: f64,
    /// Bytes of the number (sign included) in the target's text.
    pub start: usize,
    /// Byte after the number.
    pub end: usize,
    /// How it is written.
    pub style: number::Style,
    /// Weight of the last digit as it is written, rad or m.
    pub digit: f64,
    /// The finest weight of a last digit that the format can hold here, rad or m (a pulse; 0.001 deg in a fixed field).
    pub finest: f64,
}

impl Value {
    /// Bytes of the number.
    pub fn span(&self) -> Range<usize> {
        self.start..self.end
    }
}

impl TargetRef<'_> {
    /// SI value of the unit in which number `k` of a pose is written; `None`: it holds joint values.
    pub fn pose_unit(&self, k: usize) -> Option<f64> {
        self.pose.map(|form| form.unit(k))
    }

    /// New text of number `k` of a pose for a value in SI; `None`: it stays as it is.
    pub fn pose_number(&self, k: usize, value: f64, edits: &Edits) -> Option<String> {
        self.pose_number_of_size(k, value, edits, |_| f64::INFINITY)
    }

    /// The same where a number's size says how fine it can be: `finest` gives the weight of the last digit, both in the
    /// number's own unit.
    pub fn pose_number_of_size(
        &self,
        k: usize,
        value: f64,
        edits: &Edits,
        finest: impl Fn(f64) -> f64,
    ) -> Option<String> {
        let (unit, own) = (self.pose_unit(k)?, self.values.get(k)?);
        if (value - own.si).abs() <= SAME_NUMBER {
            return None;
        }
        let finest = (own.finest / unit).min(finest(value / unit));
        number::changed(own.si / unit, own.style, value / unit, edits.digit_of(self, k) / unit, finest)
    }
}

/// Numbers of a pose that differ by less are the same, m, rad or 1: rounding of the arithmetic.
const SAME_NUMBER: f64 = 1e-11;

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

    /// Keeps the ends of moves where they are from which a relative motion counts: an offset there would be carried along. Where a label, a
    /// branch, a loop or the start of a routine (or a call, in a text of several routines) stands before the relative motion, the motion may follow
    /// any move that ends before such a place; `jumps`: jumps of the language are no steps, so that it may follow any. `calls`: lines of calls of routines in
    /// which one may come first. Gives the steps that it kept.
    pub fn keep_before_relative(&mut self, why: &str, calls: &BTreeSet<u64>, jumps: bool) -> Vec<usize> {
        let ends = |s: &Step| matches!(s.kind, StepKind::Break(kind) if kind != Break::Frame);
        let counts = |s: &Step| match &s.kind {
            StepKind::Move(m) => m.relative,
            StepKind::Break(Break::Call) => calls.contains(&s.at.line),
            _ => false,
        };
        let starts = self.steps.iter().filter(|s| matches!(s.kind, StepKind::Break(Break::Start))).count();
        let (mut kept, mut anywhere) = (BTreeSet::new(), false);
        // the move before, and whether others may have come before
        let (mut last, mut others) = (None, false);
        for (k, step) in self.steps.iter().enumerate() {
            if counts(step) {
                kept.extend(last);
                anywhere |= others;
            }
            match &step.kind {
                StepKind::Move(_) => (last, others) = (Some(k), false),
                // by a word of the move itself, which may end before its goal
                _ if last.and_then(|k| self.steps.get(k)).is_some_and(|m: &Step| m.at == step.at) => {}
                // what is called stands elsewhere
                StepKind::Break(Break::Call) => others |= starts > 1,
                _ if ends(step) => (last, others) = (None, true),
                _ => {}
            }
        }
        if anywhere {
            let (mut before, all) = (None, jumps);
            for (k, step) in self.steps.iter().enumerate() {
                if let StepKind::Move(_) = step.kind {
                    before = Some(k);
                    kept.extend(before.filter(|_| all));
                } else if ends(step) {
                    kept.extend(before.take());
                }
            }
            kept.extend(before);
        }
        let mut fixed = Vec::new();
        for k in kept {
            if let Some(StepKind::Move(m)) = self.steps.get_mut(k).map(|s| &mut s.kind)
                && m.fixed.is_none()
            {
                m.fixed = Some(why.into());
                fixed.push(k);
            }
        }
        fixed
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
