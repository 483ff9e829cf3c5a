//! What moves the meaning of words: work frames, shifts, tool lengths, mirrors.

use super::codes::{code, code_text};
use super::lex::{self, Block, Word};
use super::read::Reader;
use super::reason::After;
use super::survey::Survey;
use crate::script::{AxisSet, Break, StepKind};

/// Whether a block chooses a tool or an offset, which moves the frame: a T word where no M6 changes tools (a turret), D and H without
/// the G word that takes them.
///
/// `change = "T" number | "D" number | "H" number`
pub(super) fn changes_tool(block: &Block, survey: &Survey) -> bool {
    if block.words.iter().any(lex::is_firmware) {
        return false; // their words are their own
    }
    let has = |letter: u8| block.words.iter().any(|w| w.letter == letter);
    let taken = |codes: &[u32]| {
        let of = |w: &Word| w.letter == b'G' && w.value.is_none_or(|v| codes.contains(&code(v.0)));
        block.words.iter().any(of)
    };
    let cycle = block.words.iter().any(|w| w.letter == b'G' && w.value.is_none_or(|v| code(v.0) >= 650));
    has(b'T') && !survey.changes_tools
        || has(b'D') && !taken(&[410, 420, 411, 421]) && !cycle
        || has(b'H') && !taken(&[430, 431, 440, 490]) && !cycle
}

impl Reader<'_> {
    /// The axes that a G53 moves, where they are the named ones alone: a tool length may be given up for it.
    pub(super) fn axes_of_machine(&self, block: &Block) -> Option<AxisSet> {
        let straight = matches!(self.motion, Some(0 | 10)) && self.absolute == Some(true);
        self.with_length(self.axes_named(block).filter(|_| straight)?)
    }

    /// These axes, and that of a tool length that is on.
    pub(super) fn with_length(&self, axes: AxisSet) -> Option<AxisSet> {
        match self.length.as_str() {
            "G49" => Some(axes),
            _ => Some(axes.axes().chain(self.length_axis()?.axes()).collect()),
        }
    }

    pub(super) fn local_frame(&mut self, k: usize, block: &Block) {
        match self.axis_values(block) {
            Ok(values) => {
                for (local, v) in self.local.iter_mut().zip(values) {
                    *local = v.unwrap_or(*local);
                }
            }
            Err(()) => self.lost_frame = true,
        }
        self.end(k, Break::Frame, After::G52);
    }

    pub(super) fn shift_frame(&mut self, k: usize, block: &Block, c: u32) {
        let named = block.words.iter().any(|w| self.letters.contains(&w.letter));
        if c == 920 && !named && block.words.iter().any(|w| w.letter == b'E') {
            return;
        }
        // a lathe's relative words, which move axes by other names
        let others = block.words.iter().any(|w| b"UVW".contains(&w.letter) && !self.letters.contains(&w.letter));
        self.keeps_place(After::G92);
        match (c, self.axis_values(block)) {
            (921, _) => self.moved.fill(Some(0.0)),
            (920, Ok(values)) if named && !others => {
                for (a, v) in values.into_iter().enumerate() {
                    if let Some(v) = v {
                        let local = self.local[a];
                        self.moved[a] = self.position[a].map(|p| p - v - local);
                    }
                }
            }
            _ => self.moved.fill(None),
        }
        self.end(k, Break::Frame, After::G92);
    }

    /// What is added to an absolute word. Where that is not known, the axis counts from its own origin ([`Self::is_displaced`]).
    pub(super) fn shift(&self, axis: usize) -> f64 {
        self.moved[axis].unwrap_or(0.0) + self.local[axis]
    }

    /// The numbers of an axis count from another origin than those of the first motion.
    pub(super) fn is_displaced(&self, axis: usize) -> bool {
        let strange = self.lost_frame || self.reference.is_some_and(|r| Some(r) != self.frame.or(Some(r)));
        let z = self.has_length(axis) && self.length_reference.as_ref().is_some_and(|r| *r != self.length);
        strange || z || self.moved[axis].is_none()
    }

    /// The numbers of an axis count from an origin that is not in the program.
    pub(super) fn is_unplaced(&self, axis: usize) -> bool {
        self.named_frame || self.is_displaced(axis) || self.has_length(axis) && self.length != "G49"
    }

    /// A tool length may move the axis.
    fn has_length(&self, axis: usize) -> bool {
        self.length_axis().is_none_or(|axes| axes.has(axis)) || self.letters[axis] == b'Z'
    }

    pub(super) fn tool_length(&mut self, k: usize, block: &Block, c: u32) {
        // a dynamic offset may be of any axis
        self.slip(k, self.length_axis().filter(|_| c != 431), After::ToolLength);
        let h = block.words.iter().find(|w| w.letter == b'H').map(|w| self.text.slice(w.number()));
        self.length = match h {
            _ if c == 490 => "G49".into(),
            Some(h) => format!("{} H{}", code_text(c), String::from_utf8_lossy(h)),
            None => format!("{} on line {}", code_text(c), k + 1),
        };
    }

    pub(super) fn select(&mut self, k: usize, c: u32) {
        if self.frame != Some(c) || self.lost_frame {
            self.step(k, StepKind::Break(Break::Frame), None);
            self.lose(After::WorkFrame);
        }
        self.frame = Some(c);
        self.frame_to_name = false;
        self.named_frame = true;
        if !self.survey.codes.iter().any(|c| [520, 920, 100].contains(c)) {
            self.lost_frame = false;
        }
    }
}
