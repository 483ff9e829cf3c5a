//! A vendor program in memory: what moves in which order, and where each number of it stands.
//!
//! The interface is small. A [`Format`] reads texts into a [`Document`]; the document shows its [`Script`] (steps with joint
//! targets, and whatever ends what is known of a joint's direction) and turns [`Edits`] (other joint values for a move,
//! new points on the way to it) into [`Patch`]es of bytes. Bytes outside the patches cannot change. Nothing here knows of
//! robots beyond the unit of an axis, nor of compensation.
//!
//! Modules: `format` the interface, `program` the [`Script`], `order` what is known of the order of its steps; [`step`] motions and what
//! stands between them; [`targets`] targets, [`edits`] what shall be different and [`patches`] the bytes for it, all in columns; [`thin`]
//! what few moves have; [`alike`] lines that differ in their numbers alone; [`pose`] Cartesian targets; [`reason`] why a move stays as it
//! is; [`number`] numbers and the style in which they are written, `shares` a time over several legs; [`text`] bytes and lines; [`sites`]
//! what writers of languages with statements share; [`held`] what may be on where control comes from several places, `reach` which
//! of several settings may be in force at each place, [`processes`] where a process may be; [`kept`] ends of moves that stay, [`last`]
//! which of them come last before a place; [`cursor`] how lexers read bytes; [`lex`] words, numbers and marks of such languages; [`blocks`]
//! their steps, `by_steps` values of some of them; `joins` and `routines` from where control comes to them;
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
mod format;
#[cfg(test)]
pub(crate) mod harness;
pub mod held;
pub(crate) mod joins;
mod kept;
pub mod last;
pub mod lex;
pub mod number;
mod order;
pub mod patches;
pub mod pose;
pub mod processes;
mod program;
pub mod reach;
pub mod reason;
pub(crate) mod routines;
mod shares;
pub mod sites;
pub mod step;
pub mod targets;
pub mod text;
pub mod thin;
pub mod without_joint;

pub use edits::{Edit, EditRef, Edits, NewPoint, StepEdits};
pub use format::{Document, Format, LeastArc};
pub use order::{Join, Round};
pub use patches::{Patch, PatchRef, Patches};
pub use pose::{Frame, OfAxis, PoseForm, PoseGoal, Quantity, Shift, Solution};
pub use program::{Installed, Script, Stance, pragma};
pub use reason::Reason;
pub use step::{At, AxisSet, Break, EndTrigger, Goal, How, Move, Note, OtherWay, PathKind, Speed, Step, StepKind, Way};
pub use targets::{CLONE, Target, TargetRef, Targets, Value, Values, is_clone};
pub use text::{Span, Text};
pub use thin::Few;
