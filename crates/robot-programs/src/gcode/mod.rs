//! G-code of gantries and other machines whose axes have letters: `G1 X10.5 Y-3 F600`.
//!
//! ```text
//! text -> lex: blocks of words -> survey, whole, read, words: modal state (frame: what moves their meaning; certain: what ends it)
//!      -> goal: positions, steps (statements: what is kept of them); lathe: X as a diameter; places: who reads where the machine
//!      stands; labels, callee, calls: what is called; programs, order, routes: from where control comes; cycles: holes; waits: dwells;
//!      rotary: which way an axis turns; starts: where arcs that stay begin; reason: why a block stays
//! edits -> write: blocks; leg: words; pieces: arcs -> patches
//! ```
//!
//! Words X, Y, Z, A, B, C, U, V, W meet the robot's axes by name. A word that a block does not have leaves its axis where it is.
//! Arcs (G2, G3 by I, J, K or R, helical too) know the quadrants at which an axis turns ([`arc`]).
//!
//! Reference: T. Kramer, F. Proctor, E. Messina, The NIST RS274NGC Interpreter - Version 3, NISTIR 6556 (2000); the LinuxCNC
//! and Fanuc dialects where they differ. Assumes that the work frame in which the first motion stands is the frame of the
//! axes (its offset is not in the program), G17 until a plane is named, and G91.1.
//!
//! Blocks that differ in their numbers alone are read once ([`alike`], [`passed`]); [`codes`] has the G words by what they do, [`makers`]
//! those of single makers, [`flow`] the words that steer the order of blocks, [`across`] what an X word of a lathe counts and [`signs`]
//! what shows that there is one.
//!
//! Variables and expressions that have one value whatever runs are folded ([`variables`]); [`assignments`] looks at what a line assigns
//! and what it may do besides. What cannot be determined stays as it is and says why: units or distance mode that no word has set, other
//! expressions, some canned cycles, cutter compensation. Text that is no G-code is refused with its
//! place. `docs/program-gcode.md` has what may be edited.

mod across;
mod alike;
mod arc;
mod assignments;
mod callee;
mod calls;
mod certain;
mod codes;
mod cycles;
mod flow;
mod frame;
mod goal;
mod labels;
mod lathe;
mod leg;
mod lex;
mod makers;
mod order;
mod passed;
mod pieces;
mod places;
mod programs;
mod read;
pub(crate) mod reason;
mod rotary;
mod routes;
mod signs;
mod starts;
mod statements;
mod survey;
#[cfg(test)]
mod tests;
mod variables;
mod waits;
mod whole;
mod words;
mod write;

use super::script::{self, Document, Edits, Format, Patches, Script, Text};
use crate::axes::Axes;
pub use crate::control::{Control, UnknownWord};
use crate::error::{Error, Place, Result};
pub use arc::NoArc;
use lex::Word;
pub use reason::{After, Doubt, Elsewhere, Reason};
use statements::Program;

/// The format.
pub struct Gcode;

impl Format for Gcode {
    fn name(&self) -> &'static str {
        "gcode"
    }

    fn title(&self) -> &'static str {
        "G-code"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["nc", "gcode", "ngc", "tap", "cnc", "gc"]
    }

    fn recognises(&self, bytes: &[u8]) -> bool {
        const LINES: usize = 60;
        const HEAD: usize = 1 << 14;
        let text = Text::new("", bytes.get(..HEAD).unwrap_or(bytes).to_vec());
        // the last line may be cut
        let cut = usize::from(text.bytes.len() < bytes.len() && text.line_count() > 1);
        let lines = (text.line_count() - cut).min(LINES);
        let blocks: Option<Vec<_>> = (0..lines).map(|k| lex::block(&text, k).ok()).collect();
        let Some(blocks) = blocks else { return false };
        let code = |w: &Word| matches!(w.letter, b'G' | b'M') && w.value.is_some_and(|v| v.0 >= 0.0);
        blocks.iter().filter(|b| b.keyword.is_none()).any(|b| b.words.iter().any(code))
            && blocks.iter().filter(|b| b.keyword.is_some()).count() * 4 <= blocks.len()
    }

    fn parse(&self, texts: Vec<Text>, robot: &Axes) -> Result<Box<dyn Document>> {
        if texts.is_empty() {
            return Err(Error::bad(Place::file(""), "no text", "a G-code program"));
        }
        Ok(Box::new(whole::program(texts, robot)?))
    }
}

impl Document for Program {
    fn script(&self) -> &Script {
        &self.script
    }

    fn patches(&self, edits: &Edits) -> Result<Patches> {
        write::patches(self, edits)
    }

    fn unwritable(&self, edits: &Edits) -> Vec<(usize, script::Reason)> {
        write::written_or_not(self, edits).0
    }

    fn written_or_not(&self, edits: &Edits) -> (Vec<(usize, script::Reason)>, Option<Patches>) {
        write::written_or_not(self, edits)
    }

    fn names_missing_axes(&self) -> bool {
        true
    }

    fn on_way(&self, step: usize, share: f64) -> Option<Vec<f64>> {
        let place = self.statements.on_arc(step, self.letters.len(), share)?;
        Some(place.into_iter().zip(&self.si).map(|(v, si)| v * si).collect())
    }
}
