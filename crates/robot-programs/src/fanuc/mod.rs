//! FANUC TP programs as text (`.LS`).
//!
//! A program has sections: `/ATTR` (attributes, with the number of lines), `/MN` (numbered statements, each up to its `;`)
//! and `/POS` (the positions `P[n]`, per motion group, as joints or Cartesian). Moves name positions; one position may serve
//! several moves. What is edited are the numbers of group 1 (joints, or X Y Z W P R), in their columns with three decimals. A new point is
//! a new line after whose number all others move up, and a new position after the last one.
//!
//! Facts from public programs of R-J3 to R-30iB controllers and FANUC's operator manuals. Attribute names and some
//! instructions follow the language of the controller: a word that is not known is kept, and ends what is known of the
//! joints' directions, as it might move or jump.
//!
//! Modules: [`sections`] finds the sections; [`positions`] reads `/POS`; [`taught`] makes targets of it; [`uses`] finds what else uses
//! them; [`statement`] lines, statements and their words; [`motion`] a motion, [`triggers`] what it runs near its end; [`instruction`]
//! everything else, [`readings`] which of it reads where the robot stands; [`flow`] jumps, blocks and calls; [`calls`] programs beside it;
//! [`listing`] registers as the controller lists them, [`registers`] which of them hold these values; [`read`] makes the script, [`goals`]
//! the goals of its motions, [`reason`] why one stays; [`write`] the patches.
//!
//! How it fails: the angle J3 of a program is that of the forearm against the horizontal. The motor at the elbow turns by
//! J3 + J2. Values are taken as they are written, and so a reversal is one of the written J3 (docs/program-fanuc.md).
//!
//! # Example
//!
//! A move names a position, whose joints are written in degrees and read in rad.
//!
//! ```
//! use robot_programs::axes::{Axes, Axis, JointKind};
//! use robot_programs::script::{Format, Goal, Text};
//!
//! let axes = Axes::new("arm", (1..=6).map(|i| Axis::new(format!("J{i}"), JointKind::Revolute)).collect());
//! let source = b"/PROG  HOME\n/ATTR\nLINE_COUNT\t= 1;\n/MN\n   1:J P[1] 50% FINE    ;\n/POS\nP[1]{\n   GP1:\n\tUF : 0, UT : 1,\t\n\
//!     \tJ1=    10.000 deg,\tJ2=   -20.000 deg,\tJ3=    30.000 deg,\n\tJ4=     0.000 deg,\tJ5=   -60.000 deg,\tJ6=     0.000 deg\n};\n/END\n";
//! let program = robot_programs::fanuc::Fanuc.parse(vec![Text::new("home.ls", source.to_vec())], &axes)?;
//! let (_, goal) = program.script().moves().next().expect("one move");
//! let Goal::Joints(target) = goal.goal else { panic!("a joint target") };
//! let target = program.script().targets.get(target).expect("the target of a move");
//! let deg: Vec<f64> = target.values.iter().map(|v| v.map_or(f64::NAN, |v| v.si.to_degrees())).collect();
//! let written = [10.0, -20.0, 30.0, 0.0, -60.0, 0.0];
//! assert!(deg.iter().zip(written).all(|(a, b)| (a - b).abs() < 1e-9));
//! # Ok::<(), robot_programs::Error>(())
//! ```

mod calls;
mod flow;
mod goals;
mod instruction;
mod listing;
mod motion;
mod positions;
mod read;
mod readings;
pub(crate) mod reason;
mod registers;
mod sections;
mod statement;
mod taught;
mod triggers;
mod uses;
mod write;

#[cfg(test)]
pub(super) mod props;
#[cfg(test)]
mod tests;

use super::files::Folders;
use super::script::blocks::BySteps;
use super::script::cursor::{strip_word, unmarked};
use super::script::{Document, Edits, Format, Patches, Script, Text};
use crate::axes::{Axes, JointKind};
use crate::error::Result;
pub use crate::registers::{Register, Registers};
use motion::Motion;
use positions::Position;
pub use reason::{Reason, SetsAny};
use statement::Numbered;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// FANUC TP (`.LS`).
pub struct Fanuc;

impl Format for Fanuc {
    fn name(&self) -> &'static str {
        "fanuc"
    }

    fn title(&self) -> &'static str {
        "FANUC TP (.LS)"
    }

    /// J3 is shown against the horizontal; the motor at the elbow turns by J2 + J3.
    fn coupled(&self) -> Option<(usize, usize)> {
        Some((2, 1))
    }

    fn endings(&self) -> &'static [&'static str] {
        &["ls"]
    }

    fn recognises(&self, bytes: &[u8]) -> bool {
        let bytes = unmarked(bytes).trim_ascii_start();
        strip_word(bytes, b"/PROG").is_some_and(|rest| rest.starts_with(b" ") || rest.starts_with(b"\t"))
    }

    fn context(&self, path: &Path, seen: &Folders, robot: &Axes) -> Vec<PathBuf> {
        calls::files(path, seen, !robot.registers.positions.is_empty())
    }

    fn is_called(&self, path: &Path, own: &Text, seen: &Folders) -> bool {
        calls::is_called(path, own, seen)
    }

    fn minds_unread(&self) -> bool {
        true
    }

    fn parse(&self, texts: Vec<Text>, robot: &Axes) -> Result<Box<dyn Document>> {
        Ok(Box::new(read::program(texts, robot)?))
    }
}

/// A program that has been read.
struct Program {
    script: Script,
    kinds: Vec<JointKind>,
    robot: Axes,
    /// Where the motion of each move step stands.
    motions: BySteps<Motion>,
    /// Lines with a number, in order.
    numbered: Vec<Numbered>,
    /// The number of lines among the attributes, and its value.
    count: Option<(Range<usize>, u64)>,
    positions: Vec<Position>,
    /// Position of each target of the script.
    of_target: Vec<usize>,
    /// Targets that something else reads too: never changed in place.
    shared: Vec<bool>,
    /// The largest index of a position that the program has or mentions, remarks included.
    last: u64,
    /// Where a new position is put.
    end: usize,
    /// The file writes `.384`, not `0.384`.
    bare: bool,
}

impl Document for Program {
    fn script(&self) -> &Script {
        &self.script
    }

    fn patches(&self, edits: &Edits) -> Result<Patches> {
        write::patches(self, edits)
    }
}
