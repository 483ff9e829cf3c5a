//! What the instructions of a job say of all of it: which variables and frames they set, which moves they name by number.

use super::job::Kind;
use super::list::List;
use super::shared::{clears_positions, variables};
use super::words::{FRAME_WORDS, PlainMoves, begin_of, sets_frame, upper, upper_words, words};
use crate::script::{At, Note, Text};
use std::collections::BTreeSet;

/// Numbers of the position variables that instructions other than moves name: their values are not certain.
///
/// `instruction = {label} word {variable | word}`
pub(super) fn assigned(text: &Text, begin: usize, list: &List) -> BTreeSet<u32> {
    let (mut found, plain) = (BTreeSet::new(), PlainMoves::of(text));
    for k in begin..text.line_count() {
        if plain.has(k) {
            continue;
        }
        let words = upper_words(text, k);
        let Some(first) = words.iter().find(|w| !w.starts_with('*')) else { continue };
        // how many a CLEAR sets may not be written
        if clears_positions(&words) {
            found.extend(list.positions.iter().filter(|p| p.kind == Kind::P).map(|p| p.number));
        }
        if first.contains("MOV") || first == "SFTON" || first == "GETE" {
            continue;
        }
        let named = words.iter().filter(|w| !w.starts_with("JOB:"));
        found.extend(named.flat_map(|w| variables(w).0));
    }
    found
}

/// Whether a line takes down where the robot stands: `GETS PX010 $PX000`.
pub(super) fn reads_place(line: &[u8]) -> bool {
    memchr::memmem::find(line, b"$PX").is_some()
}

/// Numbers of user frames and tools that the job, or one that it calls, sets while it runs (`MFRAME UF#(1) ...`, `SETTOOL TL#(2) P001`);
/// `None`: any.
#[derive(Default)]
pub(super) struct FramesSet([BTreeSet<Option<u32>>; 2]);

impl FramesSet {
    /// Reads what the instructions from line `begin` set, and those of the jobs that are `run` from there.
    pub(super) fn of(text: &Text, begin: usize, run: &[&Text]) -> Self {
        let mut found = Self::default();
        found.add(text, begin);
        for job in run {
            found.add(job, begin_of(job).unwrap_or_default());
        }
        found
    }

    /// Adds what a job sets.
    ///
    /// `frame = ("UF#" | "TL#") "(" number ")"`
    fn add(&mut self, text: &Text, begin: usize) {
        for k in text.lines_with(b"#").filter(|k| *k >= begin) {
            let words = sets_frame(text, k);
            for (list, word) in self.0.iter_mut().zip(FRAME_WORDS) {
                let named = words.iter().filter_map(|w| w.split_once(word).map(|(_, rest)| rest));
                list.extend(named.map(|rest| {
                    let inside = rest.strip_prefix('(').and_then(|r| r.split(')').next());
                    inside.and_then(|n| n.parse::<u32>().ok())
                }));
            }
        }
    }

    /// Whether the user frame (`tool`: the tool) of a number is one of them.
    pub(super) fn has(&self, tool: bool, number: u32) -> bool {
        let list = &self.0[usize::from(tool)];
        list.contains(&Some(number)) || list.contains(&None)
    }
}

/// Instructions that name moves by their number: `GETPOS PX000 STEP#(4)`.
pub(super) struct Counted {
    /// Line of the first of them, from 0.
    pub(super) line: usize,
    pub(super) steps: BTreeSet<u32>,
    /// A number is set at run time: any step may be meant.
    pub(super) any: bool,
}

impl Counted {
    /// Reads the numbers in the instructions from line `begin`.
    ///
    /// `step = "STEP#" "(" number ")"`
    pub(super) fn of(text: &Text, begin: usize) -> Option<Self> {
        let mut found: Option<Self> = None;
        for k in text.lines_with(b"#").filter(|k| *k >= begin) {
            for word in words(text, k) {
                let word = upper(text, &word);
                let Some(at) = word.find("STEP#") else { continue };
                let counted = found.get_or_insert(Self { line: k, steps: BTreeSet::new(), any: false });
                let number = word[at..].strip_prefix("STEP#(").and_then(|w| w.split(')').next());
                match number.and_then(|n| n.parse().ok()) {
                    Some(n) => drop(counted.steps.insert(n)),
                    None => counted.any = true,
                }
            }
        }
        found
    }

    pub(super) fn note(&self) -> Note {
        let named: Vec<String> = self.steps.iter().map(u32::to_string).collect();
        let stay = match (self.any, named.as_slice()) {
            (true, _) => "every goal stays as it is, as the number is set at run time".to_string(),
            (false, [one]) => format!("the goal of move {one} stays as it is"),
            (false, all) => format!("the goals of moves {} stay as they are", all.join(", ")),
        };
        let text = format!("STEP# counts the moves of the job: no points are added, and {stay}");
        Note { place: At::of_line(self.line), text }
    }
}
