//! Results of an earlier rewrite among the programs of a folder: they are no programs to rewrite or to list.

use super::guard::{note_name, note_path, read_note};
use crate::error::shown;
use crate::io::input::sha256;
use crate::io::notice::{self, Notice};
use crate::program::files::Files;
use std::collections::{BTreeSet, HashSet};
use std::path::{Path, PathBuf};

/// Leaves out of `programs`, paths below `input`, what an earlier rewrite of it wrote into a folder below it, and reports that.
pub fn leave_out(input: &Path, programs: &mut Vec<PathBuf>, files: &Files) {
    let folders = folders(input, programs, files);
    if folders.is_empty() {
        return;
    }
    let before = programs.len();
    programs.retain(|p| !folders.iter().any(|folder| p.starts_with(folder)));
    let folders: Vec<String> = folders.iter().map(|f| shown(&input.join(f))).collect();
    notice::report(Notice::EarlierResults(before - programs.len(), &folders));
}

/// Folders below `input` with results of an earlier rewrite of it: a program whose path goes on, after that folder, as that of
/// another program of `input`, which is the one that its note names.
fn folders(input: &Path, programs: &[PathBuf], files: &Files) -> BTreeSet<PathBuf> {
    let all: HashSet<&Path> = programs.iter().map(PathBuf::as_path).collect();
    let mut found = BTreeSet::new();
    let of = |original: &Path| std::fs::read(input.join(original)).ok().map(|bytes| sha256(&bytes));
    // a note beside the file that a link leads to is on no list
    let noted = |p: &&PathBuf| {
        let (own, listed) = (note_path(&input.join(p)), note_name(&input.join(p)));
        files.has(&listed) || own != listed && own.is_file()
    };
    for (program, note) in programs.iter().filter(noted).filter_map(|p| Some((p, read_note(&input.join(p)).ok()??))) {
        let mut rest = program.components();
        let mut folder = PathBuf::new();
        while let Some(first) = rest.next() {
            folder.push(first);
            if all.contains(rest.as_path()) && note.sha256_in.is_some() && note.sha256_in == of(rest.as_path()) {
                found.insert(folder);
                break;
            }
        }
    }
    found
}
