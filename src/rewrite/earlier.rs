//! Results of an earlier rewrite among the programs of a folder: they are no programs to rewrite or to list.
//!
//! Method: a program is left out only if its own note says that it is a result, by the hashes of its files, and if its path goes on,
//! after a folder of results, as that of another program. A folder is one of results if a note there names the content of that other
//! program, or, of an original that has changed since, if every program in the folder has such a counterpart. What stands beside a
//! result is a program like any other.

use super::batch::hash;
use super::guard::{Note, note_name, note_path, read_note};
use crate::error::shown;
use crate::io::name::path_of;
use crate::io::notice::{self, Notice};
use crate::program::files::Files;
use std::collections::{BTreeSet, HashSet};
use std::path::{Path, PathBuf};

/// Leaves out of `programs`, paths below `input`, what an earlier rewrite of it wrote into a folder below it, and reports that.
pub fn leave_out(input: &Path, programs: &mut Vec<PathBuf>, files: &Files) {
    let results = results(input, programs, files);
    if results.is_empty() {
        return;
    }
    let left_out: HashSet<&PathBuf> = results.iter().map(|(program, _)| program).collect();
    programs.retain(|p| !left_out.contains(p));
    let folders: BTreeSet<&PathBuf> = results.iter().map(|(_, folder)| folder).collect();
    let folders: Vec<String> = folders.iter().map(|f| shown(&input.join(f))).collect();
    notice::report(Notice::EarlierResults(results.len(), &folders));
}

/// The results among `programs`, each with the folder of results that it is in.
fn results(input: &Path, programs: &[PathBuf], files: &Files) -> Vec<(PathBuf, PathBuf)> {
    let all: HashSet<&Path> = programs.iter().map(PathBuf::as_path).collect();
    let counterparts = |program: &PathBuf| -> Vec<(PathBuf, PathBuf)> {
        splits(program).filter(|(_, rest)| all.contains(rest.as_path())).collect()
    };
    // a note beside the file that a link leads to is on no list
    let noted = |p: &Path| {
        let (own, listed) = (note_path(&input.join(p)), note_name(&input.join(p)));
        files.has(&listed) || own != listed && own.is_file()
    };
    /// A noted result, and the folders in which it may be, each with the program that it would be a result of.
    type Found<'a> = (&'a PathBuf, Note, Vec<(PathBuf, PathBuf)>);
    let mut found: Vec<Found> = Vec::new();
    for program in programs.iter().filter(|p| noted(p)) {
        let counterparts = counterparts(program);
        if let (false, Ok(Some(note))) = (counterparts.is_empty(), read_note(&input.join(program)))
            && is_result(&input.join(program), &note)
        {
            found.push((program, note, counterparts));
        }
    }
    let is_input = |note: &Note, rest: &Path| note.sha256_in.is_some() && note.sha256_in == hash(&input.join(rest));
    let of_inputs = found.iter().filter_map(|(program, note, counterparts)| {
        Some((*program, counterparts.iter().find(|(_, rest)| is_input(note, rest))?.0.clone()))
    });
    let mut results: Vec<(PathBuf, PathBuf)> = of_inputs.map(|(p, folder)| (p.clone(), folder)).collect();
    let mirrors = |folder: &Path| {
        let mut below = programs.iter().filter_map(|p| p.strip_prefix(folder).ok());
        below.all(|rest| all.contains(rest))
    };
    let folders: BTreeSet<PathBuf> = results.iter().map(|(_, folder)| folder.clone()).filter(|f| mirrors(f)).collect();
    let known: HashSet<PathBuf> = results.iter().map(|(program, _)| program.clone()).collect();
    for (program, _, counterparts) in found.iter().filter(|(program, ..)| !known.contains(*program)) {
        if let Some((folder, _)) = counterparts.iter().find(|(folder, _)| folders.contains(folder)) {
            results.push(((*program).clone(), folder.clone()));
        }
    }
    results
}

/// The ways to part a path into a folder and the rest.
fn splits(program: &Path) -> impl Iterator<Item = (PathBuf, PathBuf)> + '_ {
    let mut rest = program.components();
    let mut folder = PathBuf::new();
    std::iter::from_fn(move || {
        folder.push(rest.next()?);
        Some((folder.clone(), rest.as_path().to_path_buf()))
    })
}

/// Whether the files of a program are those that its note says were written.
fn is_result(program: &Path, note: &Note) -> bool {
    let beside = |name: &str| Some(program.with_file_name(path_of(name)?.file_name()?));
    hash(program).as_ref() == Some(&note.sha256_out)
        && note.companions.iter().all(|c| beside(&c.output).and_then(|p| hash(&p)).as_ref() == Some(&c.sha256_out))
}
