//! What a block calls: a part of the text by the number of a block, a program of the text, or one that is not in it.
//!
//! A local call is a way to its label, as a jump is. A program that is not in the text may count from where the machine stands: subprograms
//! of relative words are the usual form of patterns of holes, so an offset would stay in all of them.

use super::callee::{Called, called_by};
use super::certain::Carried;
use super::labels::whole;
use super::lex::Block;
use super::order::Entry;
use super::read::Reader;
use super::reason::After;
use super::survey::Survey;
use crate::script::AxisSet;

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

    /// A program of this number may stand in the text; `P31000` calls O1000 three times on some controls.
    fn may_have_program(&self, number: u32) -> bool {
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
    pub(super) fn callee(&self, block: &Block) -> Callee {
        let Some(called) = called_by(block) else { return Callee::Away };
        let (number, letter) = match called {
            Called::Block => return Callee::Here,
            Called::Subprogram(Some(n)) | Called::Macro(Some(n)) if self.survey.may_have_program(n) => {
                return Callee::Here;
            }
            Called::Subprogram(number) | Called::Macro(number) | Called::OfFolder(number) => (number, 'O'),
            Called::Numbered(number) => (number, 'L'),
        };
        let Some(number) = number else { return Callee::Away };
        let names = [format!("{letter}{number}"), format!("{letter}{number:04}"), number.to_string()];
        if names.iter().any(|name| self.robot.no_motion.has(name)) { Callee::Nothing } else { Callee::Away }
    }

    /// The call of a program of the text by an M98; L repeats it, and L0 does not run it.
    ///
    /// `call = "M98" "P" number ["L" number]`
    pub(super) fn entry_of(&self, block: &Block) -> Option<Entry> {
        let number = called_by(block).and_then(Called::in_text)?;
        let repeats = block.words.iter().find(|w| matches!(w.letter, b'L' | b'K'));
        let times = repeats.map_or(Some(1), |w| whole(w).filter(|n| *n > 0 && w.letter == b'L'));
        Some(Entry { name: number.to_string(), certain: times.is_some(), once: times == Some(1) })
    }

    /// The same by a label: one that is defined below may be looked for in a separate file.
    ///
    /// `call = "O" label "CALL" ...`
    pub(super) fn entry_of_flow(&self, block: &Block) -> Option<Entry> {
        let call = block.flow.as_deref() == Some("CALL");
        let name = block.label.clone();
        call.then(|| Entry { certain: self.order.is_defined(&name), once: true, name })
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
    pub(super) fn calls(&mut self, k: usize, callee: Callee, entry: Option<Entry>) {
        if callee == Callee::Away {
            self.keeps_place(After::CallAway);
        }
        let before = self.modes_before();
        self.call(k);
        if let Some(entry) = entry.filter(|_| callee == Callee::Here) {
            self.route_call(&entry, before);
        }
        if callee == Callee::Here {
            // what is called ends where it ends
            self.carried.fill(Carried::Anywhere);
            self.named = AxisSet::default();
        }
    }
}
