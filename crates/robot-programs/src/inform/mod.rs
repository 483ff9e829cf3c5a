//! Yaskawa INFORM jobs (`.JBI`): positions by number in a list, instructions that name them.
//!
//! ```text
//! ///NPOS 2,0,0,0,0,0                          counts of C, BC, EC, P, BP, EX lines
//! ///POSTYPE PULSE                             what the numbers of the lines below are; may switch again
//! C00000=-49439,115900,90850,0,-52300,1200     S, L, U, R, B, T (and E) in pulses of the controller
//! MOVL C00000 V=50.0 PL=0                      a straight TCP path to joint values
//! ```
//!
//! Method: the list is read with the headers in force at each line (`///TOOL`, `///POSTYPE`, ...); instructions are read line by
//! line. A move names a C line and, with base or station axes, BC and EC lines: together they are its target. Pulses become
//! radians or metres by [`crate::axes::Axis::pulses`].
//!
//! References: Yaskawa, INFORM manuals and "Data transmission function", job data format (public editions for NX100); public
//! jobs of DX200 cells. Assumes `V=` in mm/s where it has decimals, and the factory's position levels (12.5 mm for `PL=1`, twice
//! that for each further one up to 4).
//!
//! Fails with file, line and column where counts and lines disagree, a number is none, a position is not in the list, `END`
//! is missing, or the robot file has no pulses for a joint. `docs/program-inform.md` has what may be edited.
//!
//! Modules: [`job`] what is known of a job; [`words`] of instructions; [`list`] positions and headers; [`read`] instructions; [`facts`]
//! what they say of the whole job; [`flow`] jumps, blocks and calls; [`shared`] which position variables are certain; [`movement`] moves;
//! [`goals`] where they lead; [`order`] which number is which joint; [`circles`] arcs through three positions; [`reason`] why a move
//! stays; [`mod@write`] edits to patches.

mod circles;
mod facts;
mod flow;
mod goals;
mod job;
mod list;
mod movement;
mod order;
mod read;
pub(crate) mod reason;
mod shared;
#[cfg(test)]
mod tests;
mod words;
mod write;

use super::files::Folders;
use super::script::cursor::unmarked;
use super::script::{self, Document, Edits, Format, Patches, Script, Text};
use crate::axes::Axes;
use crate::error::Result;
use job::Job;
pub use order::places_on_line;
pub use reason::{Reason, Uncertain};
use std::path::{Path, PathBuf};

/// The format.
pub struct Inform;

impl Format for Inform {
    fn name(&self) -> &'static str {
        "inform"
    }

    fn title(&self) -> &'static str {
        "Yaskawa INFORM (.JBI)"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["jbi"]
    }

    fn recognises(&self, bytes: &[u8]) -> bool {
        let bytes = unmarked(bytes);
        let line = bytes.split(|&b| b == b'\n').map(<[u8]>::trim_ascii).find(|l| !l.is_empty());
        line.is_some_and(|l| l.eq_ignore_ascii_case(b"/JOB"))
    }

    fn context(&self, path: &Path, seen: &Folders, _robot: &Axes) -> Vec<PathBuf> {
        shared::files(path, seen)
    }

    fn is_called(&self, path: &Path, own: &Text, seen: &Folders) -> bool {
        shared::is_called(path, own, seen)
    }

    fn minds_unread(&self) -> bool {
        true
    }

    fn parse(&self, texts: Vec<Text>, robot: &Axes) -> Result<Box<dyn Document>> {
        Ok(Box::new(read::job(texts, robot)?))
    }
}

impl Document for Job {
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
