//! Programs that a program calls: whether they move the robot, and what they leave behind: weaving, tracking, offsets, other frames and
//! tools.
//!
//! A called program stands beside the one that calls it, as `NAME.LS`, and says its name in `/PROG`. It moves nothing where it has no
//! motion, no process, no frame, no monitor, no instruction that is not known (a macro may move), and where all that it calls stand there
//! and move nothing either. What is loaded on the controller under the name is taken to be that file, and a note says so.

use super::flow::{self, Flow};
use super::readings::reads_place;
use super::sections::sections;
use super::statement::{is_comment, program_name, statements, words};
use super::uses::FramesSet;
use super::{instruction, motion};
use crate::files::{self, ANY, Folders, of_folder};
use crate::no_motion::NoMotion;
pub(super) use crate::script::called::stem_of as stem;
use crate::script::called::{Called, Does, stem_of};
use crate::script::held::{Effects, Event};
use crate::script::lex::text_of;
use crate::script::{StepKind, Text};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Most programs of a folder that is looked through.
const MOST_BESIDE: usize = 10_000;
/// Files beside the program at `path` that hold what it calls, and what these call.
///
/// `registers`: values of registers are given, and all programs of the folder tell which of them they set.
pub(super) fn files(path: &Path, seen: &Folders, registers: bool) -> Vec<PathBuf> {
    let Some(folder) = path.parent() else { return Vec::new() };
    let look = || programs(folder);
    let own = std::fs::read(path).unwrap_or_default();
    if registers && memchr::memmem::find(&own.to_ascii_uppercase(), b"PR[").is_some() {
        let here = seen.of("fanuc", folder, look);
        // a folder that is not looked through stands for itself: it is none that can be read
        return match here.is_empty() {
            true => vec![folder.to_path_buf()],
            false => here.iter().filter(|p| p.file_name() != path.file_name()).cloned().collect(),
        };
    }
    files::called(path, names_of(&own), names_of, || seen.of("fanuc", folder, look))
}

/// The programs of a folder.
fn programs(folder: &Path) -> Vec<PathBuf> {
    let is_program = |p: &PathBuf| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("ls"));
    of_folder(folder, MOST_BESIDE).into_iter().filter(is_program).collect()
}

/// Whether another program of the folder calls or runs the one at `path`.
pub(super) fn is_called(path: &Path, own: &Text, seen: &Folders) -> bool {
    let names: Vec<String> = [Some(stem_of(own)), name_in(own)].into_iter().flatten().collect();
    seen.calls(("fanuc", path), &names, programs, callees)
}

/// What a program calls or runs, in upper case; [`ANY`]: one whose name is computed. Comments and messages call nothing.
///
/// `line = [number] ":" ("!" | "//" | "--" | "MESSAGE") ... | [number] ":" ... ("CALL" | "RUN") (name | ("SR" | "AR") "[" ...)`
fn callees(program: &[u8]) -> BTreeSet<String> {
    let body = |line: &[u8]| -> Vec<u8> {
        let colon =
            memchr::memchr(b':', line).filter(|at| line[..*at].iter().all(|b| b.is_ascii_digit() || *b == b' '));
        line.get(colon.map_or(0, |at| at + 1)..).unwrap_or_default().trim_ascii().to_ascii_uppercase()
    };
    let says = |line: &Vec<u8>| [&b"!"[..], b"//", b"--", b"MESSAGE"].iter().any(|mark| line.starts_with(mark));
    let lines = program.split(|b| matches!(b, b'\n' | b'\r')).map(body).filter(|line| !says(line));
    let mut found = BTreeSet::new();
    for line in lines {
        let names = names_after(&line, &[b"CALL ", b"AUFRUF ", b"RUN "]);
        let computed =
            |name: &String| ["SR[", "AR["].iter().any(|word| name.starts_with(word)) || name == "SR" || name == "AR";
        if names.iter().any(computed) {
            found.insert(ANY.into());
        }
        found.extend(names);
        found.extend(macro_of(&[b": ", line.as_slice()].concat()).map(|name| name.to_ascii_uppercase()));
    }
    found
}

/// Names after CALL in a program, and those that a macro may have: a line of words alone, with `_` for its blanks. In upper case.
///
/// `call = ("CALL " | "AUFRUF ") name | number ":" word {word} ";"`
fn names_of(program: &[u8]) -> BTreeSet<String> {
    names_after(program, &[b"CALL ", b"AUFRUF "])
}

/// The same after other `words`.
///
/// `call = words name | number ":" word {word} ";"`
fn names_after(program: &[u8], words: &[&[u8]]) -> BTreeSet<String> {
    /// Bytes that are looked through at a time, in upper case.
    const PIECE: usize = 1 << 16;
    let longest = words.iter().map(|w| w.len()).max().unwrap_or(1);
    let names = program.split(|b| matches!(b, b'\n' | b'\r')).filter_map(macro_of);
    let mut found: BTreeSet<String> = names.map(|name| name.to_ascii_uppercase()).collect();
    let mut piece = Vec::new();
    for start in (0..program.len()).step_by(PIECE) {
        // a word may begin in one piece and end in the next
        let end = program.len().min(start + PIECE + longest - 1);
        piece.clear();
        piece.extend_from_slice(program.get(start..end).unwrap_or_default());
        piece.make_ascii_uppercase();
        for word in words {
            for at in memchr::memmem::find_iter(&piece, word) {
                let rest = program.get(start + at + word.len()..).unwrap_or_default().trim_ascii_start();
                found.insert(program_name(rest).iter().map(|b| char::from(b.to_ascii_uppercase())).collect());
            }
        }
    }
    found
}

/// Longest name of a macro.
const LONGEST: usize = 40;

/// The name of the program that a line may run as a macro.
///
/// `line = {digit | blank} ":" word {word} ["(" ...] ";"`
fn macro_of(line: &[u8]) -> Option<String> {
    let colon = memchr::memchr(b':', line).filter(|at| line[..*at].iter().all(|b| b.is_ascii_digit() || *b == b' '))?;
    let rest = line[colon + 1..].trim_ascii().strip_suffix(b";")?;
    let name = rest.split(|b| *b == b'(').next()?.trim_ascii();
    let plain = |b: &u8| b.is_ascii_alphanumeric() || b" _-.".contains(b) || !b.is_ascii();
    let is_name = (1..=LONGEST).contains(&name.len()) && name.iter().all(plain);
    is_name.then(|| text_of(name).split_whitespace().collect::<Vec<_>>().join("_"))
}

/// A program beside one.
#[derive(Default)]
struct Program {
    does: Does,
    switches: Vec<Event>,
    sets: FramesSet,
}

/// What the programs do that one calls, itself or by others.
#[derive(Default)]
pub(super) struct Beside {
    pub called: Called,
    /// What they switch on and off.
    pub effects: Effects,
    /// Frames and tools that they set.
    pub sets: FramesSet,
}

/// The name that a program gives itself, in upper case.
///
/// `head = "/PROG" name`
pub(super) fn name_in(text: &Text) -> Option<String> {
    (0..text.line_count().min(4)).find_map(|k| {
        let words: Vec<&[u8]> = text.line(k).split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).collect();
        let begins = words.first().is_some_and(|w| w.to_ascii_uppercase().ends_with(b"/PROG"));
        words.get(1).filter(|_| begins).map(|n| text_of(n).to_ascii_uppercase())
    })
}

/// What a program does besides what it calls; one that cannot be read may do anything.
fn program(text: &Text) -> Program {
    let name = name_in(text);
    let read = sections(text).ok().and_then(|s| statements(text, s.program).ok());
    let (Some(name), Some((all, _)), false) = (name, read, text.unread) else {
        let does = Does { moves: true, file: stem_of(text), ..Does::default() };
        return Program { does, ..Program::default() };
    };
    let all: Vec<_> = all.into_iter().map(|s| (words(text, &s), s)).map(|(w, s)| (s, w)).collect();
    let mut does = Does { name, file: stem_of(text), ..Does::default() };
    let mut sets = FramesSet::default();
    for (statement, words) in &all {
        let first = statement.pieces.first().map_or(&[][..], |p| text.slice(p.clone()));
        if is_comment(first) {
            continue;
        }
        sets.add(text, words);
        let said = motion::read(text, statement, words);
        does.reads |= reads_place(text, words);
        does.counts |= said.as_ref().is_some_and(|said| said.relative);
        does.moves |= said.is_some() || instruction::leads(text, words).is_some() || statement.nested;
        for action in said.iter().flat_map(|said| &said.actions) {
            if let Flow::Call(name) = flow::read(text, &action.words) {
                does.calls.insert(name);
            }
        }
        match flow::read(text, words) {
            Flow::On | Flow::Label(_) | Flow::Jump(_) | Flow::Open(_) | Flow::Round => {}
            Flow::Middle | Flow::Close(_) => {}
            Flow::Call(name) => drop(does.calls.insert(name)),
            Flow::Macro(name) => drop(does.macros.insert(name)),
            Flow::Step(StepKind::Dwell(_)) => does.waits = true,
            Flow::Step(_) => does.moves = true,
        }
    }
    Program { does, switches: flow::switches(text, &all), sets }
}

/// Keeps the programs that the first text calls, itself or by others: others may stand there for what they do to registers.
fn keep_called(texts: &[Text], all: &mut Vec<(&Text, Arc<Program>)>) {
    let mut open: Vec<String> = texts.iter().filter(|t| !t.context).flat_map(|t| names_of(&t.bytes)).collect();
    let mut named = BTreeSet::new();
    while let Some(name) = open.pop() {
        if !named.insert(name.clone()) {
            continue;
        }
        let own = |p: &&(&Text, Arc<Program>)| p.1.does.name == name || p.1.does.file == name;
        open.extend(all.iter().filter(own).flat_map(|p| names_of(&p.0.bytes)));
    }
    all.retain(|p| named.contains(&p.1.does.name) || named.contains(&p.1.does.file));
}

/// What the programs beside one do; `declared`: names that move nothing, where no file has them.
pub(super) fn beside(texts: &[Text], declared: &NoMotion) -> Beside {
    let mut all: Vec<_> = texts.iter().filter(|t| t.context).map(|t| (t, t.known(program))).collect();
    keep_called(texts, &mut all);
    let all: Vec<_> = all.into_iter().map(|p| p.1).collect();
    let switches: Vec<_> = all.iter().map(|p| (p.does.name.clone(), p.switches.clone())).collect();
    let own: Vec<String> =
        texts.iter().filter(|t| !t.context).flat_map(|t| [Some(stem_of(t)), name_in(t)]).flatten().collect();
    let called = Called::of(&all.iter().map(|p| &p.does).collect::<Vec<_>>(), &own, declared);
    let mut sets = FramesSet::default();
    all.iter().for_each(|p| sets.extend(&p.sets));
    Beside { called, effects: Effects::of(&switches), sets }
}
