//! Programs that a program calls: whether they move the robot.
//!
//! A called program stands beside the one that calls it, as `NAME.LS`, and says its name in `/PROG`. It moves nothing where it has no
//! motion, no process, no frame, no monitor, no instruction that is not known (a macro may move), and where all that it calls stand there
//! and move nothing either. What is loaded on the controller under the name is taken to be that file, and a note says so.

use super::flow::{self, Flow};
use super::sections::sections;
use super::statement::{is_comment, program_name, statements, words};
use super::{instruction, motion};
use crate::files::{Folders, of_folder};
use crate::script::{StepKind, Text};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Most programs of a folder that is looked through.
const MOST_BESIDE: usize = 10_000;
/// Most programs that one may call, itself or by others.
const MOST: usize = 256;

/// Files beside the program at `path` that hold what it calls, and what these call.
pub(super) fn files(path: &Path, seen: &Folders) -> Vec<PathBuf> {
    let Some(folder) = path.parent() else { return Vec::new() };
    let mut open = names_of(path);
    if open.is_empty() {
        return Vec::new();
    }
    let is_program = |p: &PathBuf| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("ls"));
    let here = seen.of("fanuc", folder, || of_folder(folder, MOST_BESIDE).into_iter().filter(is_program).collect());
    let mut found: BTreeSet<PathBuf> = BTreeSet::new();
    let mut asked: BTreeSet<String> = BTreeSet::new();
    while let Some(name) = open.pop_first() {
        if found.len() >= MOST || !asked.insert(name.clone()) {
            continue;
        }
        let stem = |p: &Path| p.file_stem().is_some_and(|s| s.eq_ignore_ascii_case(name.as_str()));
        for file in here.iter().filter(|p| stem(p) && *p != path) {
            open.extend(names_of(file));
            found.insert(file.clone());
        }
    }
    found.into_iter().collect()
}

/// Names after CALL in the file at `path`, in upper case.
///
/// `call = ("CALL " | "AUFRUF ") name`
fn names_of(path: &Path) -> BTreeSet<String> {
    let bytes = std::fs::read(path).unwrap_or_default().to_ascii_uppercase();
    let mut found = BTreeSet::new();
    for word in [&b"CALL "[..], b"AUFRUF "] {
        for at in memchr::memmem::find_iter(&bytes, word) {
            let rest = bytes[at + word.len()..].trim_ascii_start();
            found.insert(program_name(rest).iter().map(|b| char::from(*b)).collect());
        }
    }
    found
}

/// What a program does besides what it calls.
#[derive(Debug, Clone, Default)]
struct Does {
    name: String,
    moves: bool,
    /// It holds an increment.
    counts: bool,
    waits: bool,
    calls: BTreeSet<String>,
}

impl Does {
    fn of(text: &Text) -> Self {
        let name = (0..text.line_count().min(4)).find_map(|k| {
            let words: Vec<&[u8]> = text.line(k).split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).collect();
            let begins = words.first().is_some_and(|w| w.to_ascii_uppercase().ends_with(b"/PROG"));
            words.get(1).filter(|_| begins).map(|n| String::from_utf8_lossy(n).to_ascii_uppercase())
        });
        let read = sections(text).ok().and_then(|s| statements(text, s.program).ok());
        let (Some(name), Some((all, _)), false) = (name, read, text.unread) else {
            return Self { moves: true, ..Self::default() };
        };
        let mut does = Self { name, ..Self::default() };
        for statement in &all {
            let first = statement.pieces.first().map_or(&[][..], |p| text.slice(p.clone()));
            if is_comment(first) {
                continue;
            }
            let words = words(text, statement);
            let said = motion::read(text, statement, &words);
            does.counts |= said.as_ref().is_some_and(|said| said.relative);
            does.moves |= said.is_some() || instruction::leads(text, &words).is_some() || statement.nested;
            match flow::read(text, &words) {
                Flow::On | Flow::Label(_) | Flow::Jump(_) | Flow::Open(_) | Flow::Middle | Flow::Close(_) => {}
                Flow::Call(name) => drop(does.calls.insert(name)),
                Flow::Step(StepKind::Dwell(_)) => does.waits = true,
                Flow::Step(_) => does.moves = true,
            }
        }
        does
    }
}

/// Programs that stand beside one and move nothing, whether they wait; and those that may begin with an increment.
#[derive(Debug, Default)]
pub(super) struct Still {
    waits: BTreeMap<String, bool>,
    counts: BTreeSet<String>,
}

/// Programs that hold an increment, or call one that does.
fn counting(all: &[Arc<Does>]) -> BTreeSet<String> {
    let mut found: BTreeSet<String> = all.iter().filter(|d| d.counts).map(|d| d.name.clone()).collect();
    loop {
        let calls = |d: &&Arc<Does>| !found.contains(&d.name) && d.calls.iter().any(|c| found.contains(c));
        let Some(next) = all.iter().find(calls).map(|d| d.name.clone()) else { return found };
        found.insert(next);
    }
}

impl Still {
    pub(super) fn of(texts: &[Text]) -> Self {
        let all: Vec<_> = texts.iter().filter(|t| t.context).map(|t| t.known(Does::of)).collect();
        let mut by_name: BTreeMap<&str, Option<&Does>> = BTreeMap::new();
        for does in &all {
            // two files of one name: which is loaded is not known
            by_name.entry(&does.name).and_modify(|d| *d = None).or_insert((!does.moves).then_some(does));
        }
        let mut still: BTreeMap<String, bool> = BTreeMap::new();
        // a program is still once all that it calls are; one that calls itself never is
        loop {
            let next = by_name.values().flatten().find_map(|d| {
                let fresh = !still.contains_key(&d.name) && d.calls.iter().all(|c| still.contains_key(c));
                fresh.then(|| (d.name.clone(), d.waits || d.calls.iter().any(|c| still[c])))
            });
            let Some((name, waits)) = next else { return Self { waits: still, counts: counting(&all) } };
            still.insert(name, waits);
        }
    }

    /// Whether the program of this name moves nothing, and then whether it waits.
    pub(super) fn waits(&self, name: &str) -> Option<bool> {
        self.waits.get(name).copied()
    }

    /// Whether the program of this name may begin with an increment.
    pub(super) fn counts(&self, name: &str) -> bool {
        self.counts.contains(name)
    }
}
