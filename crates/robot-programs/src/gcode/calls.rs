//! What a block calls: a part of the text by the number of a block, a program of the text, or one that is not in it.
//!
//! A local call is a way to its label, as a jump is. A program that is not in the text may count from where the machine stands: subprograms
//! of relative words are the usual form of patterns of holes, so an offset would stay in all of them.

use super::certain::Carried;
use super::labels::{is_code, is_conditional_call, local_labels, whole};
use super::lex::Block;
use super::read::Reader;
use super::reason::After;
use super::survey::{Survey, is_numbered_call};

/// What a block calls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Callee {
    /// A part of the text.
    Here,
    /// A program that is not in the text, and may move the machine.
    Away,
    /// None, it is the end of one or of a modal macro; or one that moves nothing, as the user says.
    Nothing,
}

impl Survey {
    /// A block of this number may be jumped to, or called.
    pub(super) fn is_label(&self, number: f64) -> bool {
        self.jumps || !self.labels.is_empty() && number.fract() == 0.0 && self.labels.contains(&(number as u32))
    }

    /// A program of this number stands in the text; `P31000` calls O1000 three times on some controls.
    fn has_program(&self, number: u32) -> bool {
        let has = |n: u32| self.subs.contains(&n.to_string());
        has(number) || number >= 10_000 && has(number % 10_000)
    }
}

impl Reader<'_> {
    /// Control may come to a block by its number.
    pub(super) fn is_label(&self, block: &Block) -> bool {
        let number = block.words.first().filter(|w| w.letter == b'N');
        number.is_some_and(|w| self.survey.is_label(w.value.map_or(f64::NAN, |v| v.0)))
    }

    /// What the M98, G65, G66 or `L100` of a block calls.
    ///
    /// `call = ("M98" | "M198" | "G65" | "G66" | "G66.1") "P" number | "L" number | local`
    pub(super) fn callee(&self, block: &Block) -> Callee {
        let named = block.words.iter().any(|w| w.letter == b'P');
        let local = block.words.iter().any(|w| is_code(w, b'M', &[97.0])) || is_conditional_call(block);
        // `M98 P9100 Q5` begins at a block of that program
        if local || !named && local_labels(block).next().is_some() {
            return Callee::Here;
        }
        let numbered = is_numbered_call(block);
        let letter = if numbered { b'L' } else { b'P' };
        let Some(number) = block.words.iter().find(|w| w.letter == letter).and_then(whole) else {
            return Callee::Away;
        };
        // in the folder of the control, which may hold another one of the same number
        let outside = numbered || block.words.iter().any(|w| is_code(w, b'M', &[198.0]));
        if !outside && self.survey.has_program(number) {
            return Callee::Here;
        }
        let letter = char::from(if numbered { b'L' } else { b'O' });
        let names = [format!("{letter}{number}"), format!("{letter}{number:04}"), number.to_string()];
        if names.iter().any(|name| self.robot.no_motion.has(name)) { Callee::Nothing } else { Callee::Away }
    }

    /// What `O<name> call` calls.
    pub(super) fn callee_of_flow(&self, block: &Block) -> Callee {
        let name = block.label.trim_matches(['<', '>']);
        let forms = [name.to_string(), format!("O{name}")];
        match () {
            () if self.survey.subs.contains(&block.label) => Callee::Here,
            () if forms.iter().any(|name| self.robot.no_motion.has(name)) => Callee::Nothing,
            () => Callee::Away,
        }
    }

    /// What a line with a word of several letters calls, as Siemens controls do: `POCKET3(10, 5)`.
    pub(super) fn callee_of_keyword(&self, k: usize, keyword: &str) -> Callee {
        // messages, declarations, and how the control follows its way
        const STILL: &[&str] = &["MSG", "DEF", "EXTERN", "STOPRE", "FFWON", "FFWOF", "SOFT", "BRISK"];
        let line = String::from_utf8_lossy(self.text.line(k)).to_ascii_uppercase();
        let from = line.find(keyword).unwrap_or(line.len());
        let name: String = line[from..].chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
        if STILL.contains(&name.as_str()) || self.robot.no_motion.has(&name) { Callee::Nothing } else { Callee::Away }
    }

    /// A call on line `k`. Before one of a program that is not in the text no offset may stay.
    pub(super) fn calls(&mut self, k: usize, callee: Callee) {
        if callee == Callee::Away {
            self.keeps_place(After::CallAway);
        }
        self.call(k);
        if callee == Callee::Here {
            // what is called ends where it ends
            self.carried.fill(Carried::Anywhere);
        }
    }
}
