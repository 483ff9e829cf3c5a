//! KUKA KRL programs: `.src` (or `.sub`) with the data list `.dat` of the same name.
//!
//! KRL is read line by line, as the controller does. What is edited are axis values: in a motion itself
//! (`PTP {A1 -5,A2 -90}`) or in the declaration of its point (`DECL E6AXIS XP1={A1 -5,...}`, mostly in the `.dat`). A new
//! point is a plain motion with its values in line. A motion of an inline form stands in a fold whose text, point, frame data
//! and motion data belong together: its new points stand before the fold, with the fold's own settings before them, and a
//! point that must part from another use is cloned as a whole (point, frame data, text of the fold).
//!
//! References: KUKA System Software 8.x, Operating and Programming Instructions for System Integrators (motions,
//! approximate positioning, folds, data lists); public programs.
//!
//! Modules: [`lex`] tokens; [`aggregate`] values in braces; [`statement`] the parts of a statement; [`data`] declarations;
//! [`elsewhere`] what other modules do to them; [`name`] a point and its value; [`calls`] what a line calls; [`still`] routines
//! that move nothing; [`project`] other modules, [`machine`] where the robot stands and how far its axes go; [`motion`] a motion
//! instruction; [`form`] inline forms; [`going`] orientations, parts that the robot holds, sensors; [`settings`] speeds and
//! frames in force, with [`lists`] of the controller, values of a [`frame`] and bases that are [`carried`] by other axes; [`target`] axis
//! values; points that are [`made`] of what the program computes; [`product`] products of
//! frames; [`relative`] relative motions; [`stance`] the configuration of the arm in the project; [`led`] what leads the robot
//! away from its points, by what statements [switch](switches) and the weld data of a [`seam`]; [`outside`] what routines of other
//! files leave behind; [`read`] makes the [`program`]; [`write`] the patches; [`clone`] a point's second form; [`reason`]
//! why a motion stays.
//!
//! How it fails: what other modules do to a point (`$config.dat`, GLOBAL data) is known as far as they are found. Such points are never
//! changed in place, and where no file that is read declares them their motions are not edited at all.
//!
//! # Example
//!
//! Axis values of a point that is declared beside its motion; written in degrees, read in rad.
//!
//! ```
//! use robot_programs::axes::{Axes, Axis, JointKind};
//! use robot_programs::script::{Format, Goal, Text};
//!
//! let axes = Axes::new("arm", (1..=6).map(|i| Axis::new(format!("J{i}"), JointKind::Revolute)).collect());
//! let source = b"DEF home()\nDECL E6AXIS XHOME={A1 10,A2 -90,A3 90,A4 0,A5 45.5,A6 0}\nPTP XHOME\nEND\n";
//! let program = robot_programs::krl::Krl.parse(vec![Text::new("home.src", source.to_vec())], &axes)?;
//! let (_, goal) = program.script().moves().next().expect("one move");
//! let Goal::Joints(target) = goal.goal else { panic!("a joint target") };
//! let target = program.script().targets.get(target).expect("the target of a move");
//! let deg: Vec<f64> = target.values.iter().map(|v| v.map_or(f64::NAN, |v| v.si.to_degrees())).collect();
//! let written = [10.0, -90.0, 90.0, 0.0, 45.5, 0.0];
//! assert!(deg.iter().zip(written).all(|(a, b)| (a - b).abs() < 1e-9));
//! # Ok::<(), robot_programs::Error>(())
//! ```

mod aggregate;
mod callers;
mod calls;
mod carried;
mod clone;
mod data;
mod elsewhere;
mod folded;
mod form;
mod frame;
mod going;
mod led;
mod lex;
mod list_end;
mod lists;
mod machine;
mod made;
mod motion;
mod name;
mod outside;
mod product;
mod program;
mod project;
mod read;
pub(crate) mod reason;
mod relative;
mod seam;
mod settings;
mod stance;
mod statement;
mod still;
mod switches;
mod target;
mod write;

#[cfg(test)]
mod props;
#[cfg(test)]
mod tests;

use super::files::{Files, Folders};
use super::script::cursor::unmarked;
use super::script::{self, Document, Edits, Format, Patches, Script, Text};
use crate::axes::Axes;
use crate::error::Result;
pub use machine::Machine;
use program::Program;
pub use reason::{MovesBase, Reason, Uncertain, Where};
use std::path::{Path, PathBuf};

/// KUKA KRL (`.src` with its `.dat`).
pub struct Krl;

impl Format for Krl {
    fn name(&self) -> &'static str {
        "krl"
    }

    fn title(&self) -> &'static str {
        "KUKA KRL (.src with its .dat)"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["src", "sub"]
    }

    fn recognises(&self, bytes: &[u8]) -> bool {
        let bytes = unmarked(bytes);
        for line in bytes.split(|b| *b == b'\n').map(<[u8]>::trim_ascii).take(200) {
            let upper = line.get(..line.len().min(16)).unwrap_or_default().to_ascii_uppercase();
            if upper.is_empty() || upper.starts_with(b";") {
                continue;
            }
            if upper.starts_with(b"&") {
                return [&b"&ACCESS"[..], b"&REL", b"&PARAM", b"&COMMENT", b"&USER"]
                    .iter()
                    .any(|h| upper.starts_with(h));
            }
            let word = upper.split(u8::is_ascii_whitespace).next().unwrap_or_default();
            // URScript's `def name():` ends in a colon
            return (matches!(word, b"DEF" | b"DEFFCT" | b"DEFDAT") || upper.starts_with(b"GLOBAL DEF"))
                && !line.ends_with(b":");
        }
        false
    }

    fn companions(&self, path: &Path, there: &Files) -> Vec<PathBuf> {
        companion(path, &|p| there.has(p)).into_iter().collect()
    }

    fn context(&self, path: &Path, seen: &Folders, _robot: &Axes) -> Vec<PathBuf> {
        project::files(path, |there| companion(path, there), seen)
    }

    fn is_called(&self, path: &Path, own: &Text, seen: &Folders) -> bool {
        callers::is_called(path, own, seen)
    }

    fn minds_unread(&self) -> bool {
        true
    }

    fn parse(&self, texts: Vec<Text>, robot: &Axes) -> Result<Box<dyn Document>> {
        Ok(Box::new(read::program(texts, robot)?))
    }
}

/// The `.dat` beside a `.src`: the same stem, as it is, in one case or capital, packed or not; the exact stem goes first.
fn companion(path: &Path, there: &dyn Fn(&Path) -> bool) -> Option<PathBuf> {
    let packed = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"));
    let plain = if packed { path.with_extension("") } else { path.to_path_buf() };
    plain.extension()?;
    // a name that is no text has its own stem alone
    let other_stems = plain.file_stem().and_then(|s| s.to_str()).map_or(Vec::new(), |stem| {
        let mut capital = stem.to_lowercase();
        if let Some(first) = capital.get_mut(..1) {
            first.make_ascii_uppercase();
        }
        vec![stem.to_lowercase(), stem.to_uppercase(), capital]
    });
    let of_ending = |ending: &'static str| {
        let others = other_stems.iter().map(move |s| format!("{s}.{ending}"));
        std::iter::once(plain.with_extension(ending)).chain(others.map(|name| plain.with_file_name(name)))
    };
    ["dat", "DAT", "Dat", "dat.gz"].into_iter().flat_map(of_ending).find(|p| there(p))
}

impl Document for Program {
    fn script(&self) -> &Script {
        &self.script
    }

    fn patches(&self, edits: &Edits) -> Result<Patches> {
        write::patches(self, edits)
    }

    fn unwritable(&self, edits: &Edits) -> Vec<(usize, script::Reason)> {
        write::unwritable(self, edits)
    }
}
