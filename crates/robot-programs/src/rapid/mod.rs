//! ABB RAPID (`.mod`, `.modx`, `.prg`, `.sys`): joint targets of `MoveAbsJ`, inline or declared.
//!
//! Modules:
//! - [`lex`]: bytes to words, numbers and marks; comments and the `%%%` header stand apart.
//! - [`words`]: what RAPID's own names mean: reserved words, motion instructions, what never moves, speeds and zones.
//! - [`read`]: tokens to modules, routines and declarations; [`statements`]: what stands in routines.
//! - [`project`]: the other modules of its task, read and never written.
//! - [`facts`]: which declaration a name means, whether its value is certain, which routines move.
//! - [`callers`]: procedures of which all calls stand in the program.
//! - [`rules`]: what holds for the file: where the program starts, what leads the arm, external axes.
//! - [`in_force`]: what holds at each place along control: whether configurations are watched, which moves end where the place is read.
//! - [`value`]: `[[..],[..]]` and the numbers in it.
//! - [`arguments`]: what stands between the commas of an instruction.
//! - [`goals`]: targets of moves, or why they cannot be determined; [`poses`]: Cartesian ones; [`absolute`]: those that are
//!   whole places all the same.
//! - [`built`]: what is needed to write the moves again.
//! - [`settings`]: names of tools and work objects, and where the program sets them; [`led`]: where something leads the arm away from its
//!   targets; [`passed`]: parameters for which every call passes the same constant; [`reason`]: why a move stays.
//! - [`steps`]: statements to moves, waits and whatever ends a known direction.
//! - [`write`]: edits to patches.
//!
//! Reference: ABB, Technical reference manuals: RAPID Kernel; RAPID Instructions, Functions and Data types. What is not
//! certain from this one text (a target of another module, a variable that is set) is not edited, and the move says why.
//!
//! # Example
//!
//! A target in line; written in degrees, read in rad.
//!
//! ```
//! use robot_programs::axes::{Axes, Axis, JointKind};
//! use robot_programs::script::{Format, Goal, Text};
//!
//! let axes = Axes::new("arm", (1..=6).map(|i| Axis::new(format!("J{i}"), JointKind::Revolute)).collect());
//! let source = b"MODULE T\nPROC main()\n  MoveAbsJ [[10,-20,30,0,45.5,0],[9E9,9E9,9E9,9E9,9E9,9E9]], v100, fine, tool0;\nENDPROC\nENDMODULE\n";
//! let program = robot_programs::rapid::Rapid.parse(vec![Text::new("home.mod", source.to_vec())], &axes)?;
//! let (_, goal) = program.script().moves().next().expect("one move");
//! let Goal::Joints(target) = goal.goal else { panic!("a joint target") };
//! let target = program.script().targets.get(target).expect("the target of a move");
//! let deg: Vec<f64> = target.values.iter().map(|v| v.map_or(f64::NAN, |v| v.si.to_degrees())).collect();
//! let written = [10.0, -20.0, 30.0, 0.0, 45.5, 0.0];
//! assert!(deg.iter().zip(written).all(|(a, b)| (a - b).abs() < 1e-9));
//! # Ok::<(), robot_programs::Error>(())
//! ```

mod absolute;
mod arguments;
mod beside;
mod built;
mod callers;
mod facts;
mod goals;
mod in_force;
mod led;
mod lex;
mod passed;
mod poses;
mod project;
mod read;
pub(crate) mod reason;
mod rules;
mod settings;
mod statements;
mod steps;
mod value;
mod words;
mod write;

#[cfg(test)]
mod props;
#[cfg(test)]
mod tests;

use crate::axes::{Axes, JointKind, OF_ARM};
use crate::error::{Error, Place, Result};
use crate::files::Folders;
use crate::script::cursor::unmarked;
use crate::script::{Document, Edits, Format, LeastArc, Patches, Script, Text};
use lex::Like;
use project::Project;
pub use reason::{Elsewhere, Reason};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// The format.
pub struct Rapid;

impl Format for Rapid {
    fn name(&self) -> &'static str {
        "rapid"
    }

    fn title(&self) -> &'static str {
        "ABB RAPID (.mod, .modx, .prg, .sys)"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["mod", "modx", "prg", "sys"]
    }

    /// The first word that is no comment and no header is `MODULE`, and no `;` ends its line (that would be Modula).
    fn recognises(&self, bytes: &[u8]) -> bool {
        let mut header = false;
        for line in bytes.split(|&b| b == b'\n') {
            let line = unmarked(line).trim_ascii();
            if line.starts_with(b"%%%") {
                header = !header;
            } else if !(header || line.is_empty() || line.starts_with(b"!")) {
                let word = line
                    .get(..7)
                    .is_some_and(|w| w.eq_ignore_ascii_case(b"module ") || w.eq_ignore_ascii_case(b"module\t"));
                return word && !line.ends_with(b";");
            }
        }
        false
    }

    fn context(&self, path: &Path, seen: &Folders, _robot: &Axes) -> Vec<PathBuf> {
        project::files(path, seen)
    }

    fn is_called(&self, path: &Path, own: &Text, seen: &Folders) -> bool {
        beside::is_called(path, own, seen)
    }

    fn minds_unread(&self) -> bool {
        true
    }

    fn parse(&self, texts: Vec<Text>, robot: &Axes) -> Result<Box<dyn Document>> {
        let text = texts.first().ok_or_else(|| Error::bad(Place::default(), "nothing", "a RAPID module"))?;
        let whole = |like: Like| -> Result<_> {
            let project = Project::of(&texts, read::parse(text, lex::lex(text, like)?)?);
            let built = steps::build(texts.clone(), &project, robot)?;
            Ok(built.map(|built| (built, project)))
        };
        let (built, project) = match whole(Like::Passed)? {
            Some(found) => found,
            // some of the lines that were passed over are more than their numbers
            None => whole(Like::Read)?.ok_or_else(|| text.bad(0, "a module", "lines that are read"))?,
        };
        let mut words: HashSet<String> =
            project.parsed.words.different().filter(|w| !w.is_empty()).map(String::from).collect();
        // a name of the predefined zone that the file declares itself means something else
        if project.parsed.decls.iter().any(|d| d.name == "z0") {
            words.insert("z0 declared".into());
        }
        let kinds = robot.axis_joints().map(|j| j.kind).collect();
        Ok(Box::new(Doc { built, words, kinds, numbers: all_numbers(robot) }))
    }
}

struct Doc {
    built: built::Built,
    words: HashSet<String>,
    kinds: Vec<JointKind>,
    numbers: Option<Vec<usize>>,
}

/// Numbers of the axes in a target, where the robot has no others: all six, or those of a palletizer, whose other numbers are 0.
fn all_numbers(robot: &Axes) -> Option<Vec<usize>> {
    let places = robot.places();
    let all = places.numbers.len() == OF_ARM || places.keeps_upright();
    (places.numbered && places.external.is_empty() && all).then(|| places.numbers.clone())
}

impl Document for Doc {
    fn script(&self) -> &Script {
        &self.built.script
    }

    fn patches(&self, edits: &Edits) -> Result<Patches> {
        let numbers = self.numbers.as_deref();
        write::Writer { built: &self.built, kinds: &self.kinds, numbers, words: &self.words, edits }.patches()
    }

    fn takes_joints_for_poses(&self) -> bool {
        true
    }

    /// ABB (RAPID Instructions, MoveC): seen from the start the second and the third point stand at least 1 deg apart, which is half of
    /// the arc's angle between them, and the start and the second at least 0.1 mm; each with a reserve for offsets and digits. So the
    /// second stands at 0.15 of the shortest piece: 0.15 mm of 1 mm.
    fn least_arc(&self) -> LeastArc {
        LeastArc { whole_rad: 0.047, after_via_rad: 0.04 }
    }
}
