//! What stands in a folder of results and is none: a program that a person edited there, or put there.
//!
//! Method: a result is known by its note, which has its SHA-256. A file without a note, or with another content than its note says,
//! is replaced only where nothing is lost: the input itself or the new result has that content, or the new result begins with it, a loss
//! of power left it empty or with zeros, or a run was killed while it put the file in place.

use super::batch::hash;
use super::guard::{note_path, read_note};
use super::job::Job;
use super::outcome::Ready;
use crate::error::shown;
use crate::io::journal::{self, Journal};
use crate::io::name::{path_of, text_of_name};
use crate::io::regular;
use crate::io::temporary;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

/// Refuses a program of a folder whose result would replace at `to` what is no earlier result, unless that is forced.
pub(super) fn refuse(job: &Job, ready: &mut Ready, to: &Path) {
    let outcome = &ready.outcome;
    if job.force || outcome.refusal.is_some() {
        return;
    }
    let known = [&outcome.sha256_in, &outcome.sha256_out].map(Option::as_deref);
    if let Some(file) = foreign(to, known).filter(|_| !is_interrupted(to)) {
        if ready.files.iter_mut().any(|f| f.begins_as(&file)) {
            return; // cut short
        }
        ready.refuse(format!(
            "{}: changed since it was written, or not a result of this tool; nothing was written (remove it, or force its replacement)",
            shown(&file)
        ));
    }
}

/// The file of the result `to` that is none, but for contents that are `known`.
fn foreign(to: &Path, known: [Option<&str>; 2]) -> Option<PathBuf> {
    let differs = |path: &Path, known: [Option<&str>; 3]| {
        path.is_file() && !is_lost(path) && hash(path).is_none_or(|found| !known.contains(&Some(&found)))
    };
    let [input, result] = known;
    let note = match read_note(to) {
        Ok(note) => note,
        Err(_) if is_lost(&note_path(to)) => return None,
        Err(_) => None,
    };
    if differs(to, [input, result, note.as_ref().map(|n| n.sha256_out.as_str())]) {
        return Some(to.to_path_buf());
    }
    let companions = note.iter().flat_map(|n| &n.companions);
    let mut files = companions.filter_map(|c| Some((c, to.with_file_name(path_of(&c.output)?.file_name()?))));
    files.find(|(c, path)| differs(path, [Some(&c.sha256_in), Some(&c.sha256_out), None])).map(|(_, path)| path)
}

/// Whether a file is empty or holds zeros, which no program does.
fn is_lost(path: &Path) -> bool {
    let Ok(file) = regular::open(path) else { return false };
    let mut reader = BufReader::with_capacity(1 << 16, file);
    let mut empty = true;
    loop {
        let Ok(bytes) = reader.fill_buf() else { return false };
        if bytes.is_empty() {
            return empty;
        }
        if bytes.contains(&0) {
            return true;
        }
        empty = false;
        let read = bytes.len();
        reader.consume(read);
    }
}

/// Whether a journal in the folder of `to` names it: a note may be in place without its program.
fn is_interrupted(to: &Path) -> bool {
    let (Some(folder), Some(name)) = (to.parent(), to.file_name().map(text_of_name)) else { return false };
    let journals = temporary::named(folder, journal::ENDING).into_iter().filter_map(|path| regular::read(&path).ok());
    journals.filter_map(|bytes| Journal::parse(&bytes)).any(|j| j.files().iter().any(|f| f.target == name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_lost_where_it_is_empty_or_holds_zeros_and_a_missing_one_is_not() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("p.csv");
        assert!(!is_lost(&path));
        for (bytes, lost) in [(&b""[..], true), (b"a1_deg\n1\0\0", true), (&[0; 9], true), (b"a1_deg\n1\n", false)] {
            std::fs::write(&path, bytes).unwrap();
            assert_eq!(is_lost(&path), lost, "{bytes:?}");
        }
    }

    #[test]
    fn a_program_that_a_journal_names_is_interrupted() {
        let dir = tempfile::tempdir().unwrap();
        let entry = |target: &str| journal::Entry { target: target.into(), new: None, bytes: 0, old: None };
        Journal::new(vec![entry("p.csv")]).write(dir.path(), false).unwrap().keep();
        assert!(is_interrupted(&dir.path().join("p.csv")) && !is_interrupted(&dir.path().join("q.csv")));
    }
}
