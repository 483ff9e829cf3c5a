//! URScript of Universal Robots (`.script`, `.urscript`): joint targets in `movej`, `movel`, `movep`, `servoj`, as lists or in
//! variables.
//!
//! Modules:
//! - [`lex`]: bytes to words, numbers, marks and line ends.
//! - [`words`]: what URScript's own functions do: move, wait, or neither.
//! - [`read`]: functions, blocks, assignments.
//! - [`scopes`]: which assignments make one variable.
//! - [`value`]: lists of joint values (`d2r()` too) and poses.
//! - [`constant`]: values that are computed from constants; [`certain`]: values of names at each place; [`evaluate`]: expressions of them.
//! - [`arguments`]: calls and their arguments.
//! - [`goals`]: targets of moves: joint values, poses, or why neither can be determined; [`folded`]: those that are computed.
//! - [`steps`]: statements to waits and whatever ends a known direction; [`in_force`]: what is set where a move begins.
//! - [`moves`]: calls to moves.
//! - [`write`]: edits to patches; [`reason`]: why a move stays.
//!
//! Reference: Universal Robots, The URScript Programming Language. A variable that may hold several values
//! where a move reads it is not certain, and its moves say why they are left alone.
//!
//! # Example
//!
//! A list of joint values in rad.
//!
//! ```
//! use robot_programs::axes::{Axes, Axis, JointKind};
//! use robot_programs::script::{Format, Goal, Text};
//!
//! let axes = Axes::new("arm", (1..=6).map(|i| Axis::new(format!("J{i}"), JointKind::Revolute)).collect());
//! let source = b"def home():\n  movej([0, -1.5707963267948966, 0.5, 0, d2r(90), 0], a=1.4, v=1.05)\nend\n";
//! let program = robot_programs::urscript::UrScript.parse(vec![Text::new("home.script", source.to_vec())], &axes)?;
//! let (_, goal) = program.script().moves().next().expect("one move");
//! let Goal::Joints(target) = goal.goal else { panic!("a joint target") };
//! let target = program.script().targets.get(target).expect("the target of a move");
//! let deg: Vec<f64> = target.values.iter().map(|v| v.map_or(f64::NAN, |v| v.si.to_degrees())).collect();
//! let written = [0.0, -90.0, 0.5f64.to_degrees(), 0.0, 90.0, 0.0];
//! assert!(deg.iter().zip(written).all(|(a, b)| (a - b).abs() < 1e-9));
//! # Ok::<(), robot_programs::Error>(())
//! ```

mod arguments;
mod certain;
mod constant;
mod evaluate;
mod folded;
mod goals;
mod in_force;
mod lex;
mod moves;
mod read;
pub(crate) mod reason;
mod scopes;
mod steps;
mod value;
mod words;
mod write;

#[cfg(test)]
mod props;
#[cfg(test)]
mod tests;

use crate::axes::{Axes, OF_ARM};
use crate::error::{Error, Place, Result};
use crate::script::cursor::unmarked;
use crate::script::{Document, Edits, Format, Patches, Script, Text};
use lex::Like;
pub use reason::Reason;
use std::collections::HashSet;

/// The format.
pub struct UrScript;

impl Format for UrScript {
    fn name(&self) -> &'static str {
        "urscript"
    }

    fn title(&self) -> &'static str {
        "URScript (.script, .urscript)"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["script", "urscript"]
    }

    /// The first line that is no comment starts a function or calls a motion.
    fn recognises(&self, bytes: &[u8]) -> bool {
        let lines = bytes.split(|&b| b == b'\n').map(|l| unmarked(l).trim_ascii());
        let first = lines.into_iter().find(|l| !(l.is_empty() || l.starts_with(b"#") || l.starts_with(b"$")));
        first.is_some_and(|l| {
            let function = (l.starts_with(b"def ") || l.starts_with(b"sec ")) && l.contains(&b'(') && l.contains(&b':');
            let call = [b"movej(".as_slice(), b"movel(", b"movep(", b"servoj(", b"set_tcp("];
            function || call.iter().any(|c| l.starts_with(c))
        })
    }

    fn parse(&self, texts: Vec<Text>, robot: &Axes) -> Result<Box<dyn Document>> {
        let text = texts.into_iter().next().ok_or_else(|| Error::bad(Place::default(), "nothing", "a URScript"))?;
        let whole = |like: Like| steps::build(text.clone(), read::parse(&text, lex::lex(&text, like)?)?, robot);
        let (built, words) = match whole(Like::Passed)? {
            Some(found) => found,
            // some of the lines that were passed over are more than their numbers
            None => whole(Like::Read)?.ok_or_else(|| text.bad(0, "a script", "lines that are read"))?,
        };
        let words = words.different().filter(|w| !w.is_empty()).map(String::from).collect();
        let numbers = value::numbers(robot).filter(|_| robot.dof() >= OF_ARM);
        Ok(Box::new(Doc { built, words, numbers }))
    }
}

struct Doc {
    built: steps::Built,
    words: HashSet<String>,
    numbers: Option<Vec<usize>>,
}

impl Document for Doc {
    fn script(&self) -> &Script {
        &self.built.script
    }

    fn corners_must_not_overlap(&self) -> bool {
        true
    }

    fn patches(&self, edits: &Edits) -> Result<Patches> {
        write::Writer { built: &self.built, numbers: self.numbers.as_deref(), words: &self.words, edits }.patches()
    }

    fn takes_joints_for_poses(&self) -> bool {
        true
    }
}
