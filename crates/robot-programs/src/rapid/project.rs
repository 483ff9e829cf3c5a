//! The task around a RAPID module: which files are its other modules, and one text of all of them.
//!
//! A controller loads the modules of a task into one name space: what is not LOCAL is seen by all of them, and no name may be
//! declared globally twice. So a module is read together with those that can be its fellows: the files of its folder (of `PROGMOD` and
//! `SYSMOD` where it stands in one of them), of which a `.pgf` that names the module names the others, too. A file that declares a
//! global name again, or a second `main`, is of another task and left out. Where nothing tells which of several `main` is the
//! module's own, none of them is looked at. What is found there is read and never written.

use super::arguments::motion_of;
use super::lex;
use super::read::{self, Parsed};
use crate::files::of_folder;
use crate::script::{At, Text};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Most files of a folder that is taken for a task.
const MOST: usize = 64;
/// Most bytes of all modules of a task.
const MOST_BYTES: usize = 8 << 20;

/// Whether a file may hold modules.
fn is_module(path: &Path) -> bool {
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    ending.is_some_and(|e| matches!(e.as_str(), "mod" | "modx" | "prg" | "sys" | "sysx"))
}

/// The other files of the task of the module at `path`.
pub fn files(path: &Path) -> Vec<PathBuf> {
    let Some(folder) = path.parent() else { return Vec::new() };
    let here = of_folder(folder, MOST);
    let own = path.file_name();
    let named = |p: &PathBuf| {
        let list = std::fs::read(p).map(|b| String::from_utf8_lossy(&b).to_ascii_lowercase()).unwrap_or_default();
        let modules: Vec<String> = list
            .split("<module>")
            .skip(1)
            .filter_map(|rest| Some(rest.split('<').next()?.trim().rsplit(['/', '\\']).next()?.to_string()))
            .collect();
        modules
    };
    let of = |p: &Path| p.file_name().map(|n| n.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let lists: Vec<Vec<String>> = here
        .iter()
        .filter(|p| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("pgf")))
        .map(named)
        .filter(|list| list.contains(&of(path)))
        .collect();
    let listed = |p: &Path| match lists.as_slice() {
        [] => true,
        [one] => one.contains(&of(p)) || of(p).ends_with(".sys") || of(p).ends_with(".sysx"),
        _ => false,
    };
    let mut all: Vec<PathBuf> =
        here.iter().filter(|p| is_module(p) && p.file_name() != own && listed(p)).cloned().collect();
    let beside = match folder.file_name().map(|n| n.to_string_lossy().to_ascii_uppercase()).as_deref() {
        Some("PROGMOD") => "SYSMOD",
        Some("SYSMOD") => "PROGMOD",
        _ => return all,
    };
    all.extend(of_folder(&folder.with_file_name(beside), MOST).into_iter().filter(|p| is_module(p)));
    all
}

/// The modules of a task as one text: the program's own first.
pub struct Project {
    pub text: Text,
    pub parsed: Parsed,
    /// First byte of each context, with the number of its file.
    starts: Vec<(usize, usize)>,
}

impl Project {
    /// The own text alone, parsed.
    pub fn alone(text: &Text, parsed: Parsed) -> Self {
        Self { text: text.clone(), parsed, starts: Vec::new() }
    }

    /// The program with those of its context that can be of its task.
    pub fn of(texts: &[Text], own: Parsed) -> Self {
        let Some(text) = texts.first() else { return Self { text: Text::default(), parsed: own, starts: Vec::new() } };
        // a module that moves nothing asks for nothing
        if texts.len() == 1 || !own.items.iter().any(|item| motion_of(&own, item).is_some()) {
            return Self::alone(text, own);
        }
        // of programs that were put into one folder each has its own `main`: that is seen without reading them whole
        let ours = starts(text);
        let others = || (1..).zip(&texts[1..]).filter(|(_, t)| !(ours && starts(t)));
        if others().filter(|(_, t)| starts(t)).count() > 1 {
            return Self::alone(text, own);
        }
        let all: Vec<(usize, &Text, Parsed)> =
            others().filter_map(|(k, t)| Some((k, t, read::parse(t, lex::lex(t).ok()?).ok()?))).collect();
        let taken = globals(&own);
        let mut fellows: Vec<&(usize, &Text, Parsed)> =
            all.iter().filter(|(.., p)| globals(p).is_disjoint(&taken)).collect();
        let main = |p: &Parsed| p.routines.iter().any(|r| r.name == "main");
        let mains = fellows.iter().filter(|(.., p)| main(p)).count();
        let size: usize = fellows.iter().map(|f| f.1.bytes.len()).sum();
        if mains > 1 || size > MOST_BYTES {
            fellows.clear();
        }
        if fellows.is_empty() {
            return Self::alone(text, own);
        }
        let (mut bytes, mut starts) = (text.bytes.clone(), Vec::new());
        for (k, fellow, _) in fellows {
            bytes.push(b'\n');
            starts.push((bytes.len(), *k));
            bytes.extend_from_slice(fellow.bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&fellow.bytes));
        }
        let joined = Text::new(text.name.clone(), bytes);
        match lex::lex(&joined).and_then(|l| read::parse(&joined, l)) {
            Ok(parsed) => Self { text: joined, parsed, starts },
            // each of them is whole, but not one behind the other
            Err(_) => Self::alone(text, own),
        }
    }

    /// First byte behind the program's own text.
    pub fn own_end(&self) -> usize {
        self.starts.first().map_or(self.text.bytes.len(), |s| s.0)
    }

    /// File and line of a byte.
    pub fn at(&self, byte: usize) -> At {
        let line = self.text.line_of(byte);
        match self.starts.iter().rev().find(|s| s.0 <= byte) {
            None => At { file: 0, line },
            Some((start, file)) => At { file: *file, line: line + 1 - self.text.line_of(*start) },
        }
    }
}

/// Whether a text may hold `PROC main`.
fn starts(text: &Text) -> bool {
    let upper = text.bytes.to_ascii_uppercase();
    let after = |at: usize| upper.get(at + 4..).unwrap_or_default().trim_ascii_start();
    memchr::memmem::find_iter(&upper, b"PROC").any(|at| after(at).starts_with(b"MAIN"))
}

/// Names that modules share: data and routines that are not LOCAL, and the modules themselves.
fn globals(p: &Parsed) -> HashSet<String> {
    let data = p.decls.iter().filter(|d| d.routine.is_none() && !d.local).map(|d| d.name.clone());
    let routines = p.routines.iter().filter(|r| !r.local).map(|r| r.name.clone());
    data.chain(routines).chain(p.modules.iter().cloned()).collect()
}
