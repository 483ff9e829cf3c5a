//! What stands where the files of a result go and is none: a program that a person edited there, or put there.
//!
//! Method: a result is known by its note, which has its SHA-256. A file with another content than its note says is replaced only where
//! nothing is lost: the input itself or the new result has that content, a conversion of line ends changed it alone, it is empty or holds
//! zeros (a loss of power), it ends within a line of the new result (the same), or a run was killed while it put the file in place. In a
//! folder of results, whose files nobody names one by one, the same holds for a file without a note.

use super::batch::read_hash;
use super::guard::{Note, note_path, read_note};
use super::job::Job;
use super::refusal::{Foreign, Refusal};
use super::sink::File;
use crate::error::{Error, Result, is_stdio, shown};
use crate::io::input::sha256;
use crate::io::journal::{self, Journal};
use crate::io::kind::Kind;
use crate::io::name::{path_of, text_of_name};
use crate::io::output::Durability;
use crate::io::regular;
use crate::io::remains;
use crate::io::temporary;
use std::io::{BufRead, BufReader};
use std::path::Path;

/// Bytes of a file up to which line ends that were converted are looked for.
const CONVERTED_UP_TO: u64 = 64 << 20;

/// A file that is about to be put in place, with the SHA-256 of its original and of the new content.
pub(super) struct PendingFile<'a> {
    pub(super) path: &'a Path,
    pub(super) sha256_in: Option<&'a str>,
    pub(super) sha256_out: &'a str,
}

/// What stands there.
#[derive(Debug, PartialEq, Eq)]
enum Standing {
    /// Nothing, or what may be replaced.
    Free,
    /// What its note says.
    Result,
    Other(Foreign),
}

/// Refuses files of a result, the program first, that would replace what is no earlier result, unless that is allowed. Where they may
/// replace it, they may do so whatever its kind.
///
/// # Errors
/// A refusal that names the first such file.
pub(super) fn refuse(job: &Job, files: &mut [File], placed: &[PendingFile]) -> Result<()> {
    let Some(to) = placed.first().map(|p| p.path) else { return Ok(()) };
    if is_stdio(to) || std::fs::metadata(to).is_ok_and(|m| !m.is_file()) {
        return Ok(());
    }
    let note = match read_note(to) {
        Err(error @ Error::Io { .. }) if !job.force => return Err(error),
        note => note,
    };
    for (k, (file, placed)) in files.iter_mut().zip(placed).enumerate() {
        let standing = match &note {
            Ok(Some(note)) => by_note(note, file, placed, k == 0),
            // a person named a single file, but none that appears beside it
            _ if job.durability == Durability::Synced && k == 0 => Ok(Standing::Free),
            _ if job.durability == Durability::Synced => beside(file, placed),
            Err(_) if is_lost(&note_path(to)) => Ok(Standing::Free),
            Ok(None) => without_note(placed, if k == 0 { Foreign::NoNote } else { Foreign::NoCompanion }),
            Err(_) => without_note(placed, Foreign::DamagedNote),
        };
        // what cannot be read may be replaced where all may be
        let standing = if job.force { standing.unwrap_or(Standing::Free) } else { standing? };
        match standing {
            Standing::Free => {}
            Standing::Result => file.replace_any_kind(),
            Standing::Other(_) if job.force => {}
            Standing::Other(_) if job.replace => {
                if Kind::of_file(placed.path).is_some_and(|k| k.is_program_or_table()) {
                    file.replace_any_kind();
                }
            }
            Standing::Other(_) if file.is_cut_short(placed.path) || is_interrupted(to) => {}
            Standing::Other(why) => return Err(Refusal::Foreign { file: shown(placed.path), why }.into()),
        }
    }
    Ok(())
}

/// What stands at a file of a result that has a note.
fn by_note(note: &Note, file: &mut File, placed: &PendingFile, is_program: bool) -> Result<Standing> {
    let name = placed.path.file_name();
    let companion = note.companions.iter().find(|c| path_of(&c.output).is_some_and(|p| p.file_name() == name));
    let written = match (is_program, companion) {
        (true, _) => Some(&note.sha256_out),
        (false, companion) => companion.map(|c| &c.sha256_out),
    };
    let Some(written) = written else { return beside(file, placed) };
    let former = companion.filter(|_| !is_program).map(|c| c.sha256_in.as_str());
    standing(placed, Some(written), former, Foreign::Changed)
}

/// What stands beside a program where no note mentions it: it is known by its content alone, or by its beginning and zeros after it.
fn beside(file: &mut File, placed: &PendingFile) -> Result<Standing> {
    let is_ours = |bytes: &[u8], ours: &[u8]| remains::before_zeros(bytes).is_some_and(|b| ours.starts_with(b));
    Ok(match without_note(placed, Foreign::NoCompanion)? {
        Standing::Free if is_lost(placed.path) => {
            let bytes = regular::read(placed.path).map_err(|e| Error::io(placed.path, "read", e))?;
            match file.contents() {
                Ok(ours) if bytes.is_empty() || is_ours(&bytes, &ours) => Standing::Free,
                _ => Standing::Other(Foreign::NoCompanion),
            }
        }
        standing => standing,
    })
}

fn without_note(placed: &PendingFile, why: Foreign) -> Result<Standing> {
    standing(placed, None, None, why)
}

/// What stands at a file whose note says that `written` was written; contents beside it that may be replaced are that of `former` and those
/// of the file that is placed.
fn standing(placed: &PendingFile, written: Option<&str>, former: Option<&str>, why: Foreign) -> Result<Standing> {
    let path = placed.path;
    if !path.is_file() || is_lost(path) {
        return Ok(Standing::Free);
    }
    // a file that cannot be read is not one that somebody changed
    let found = read_hash(path).map_err(|e| Error::io(path, "read", e))?;
    let free = [placed.sha256_in, Some(placed.sha256_out), former];
    let of = |found: &str| match Some(found) {
        it if it == written => Some(Standing::Result),
        it if free.contains(&it) => Some(Standing::Free),
        _ => None,
    };
    Ok(of(&found).or_else(|| converted(path).iter().find_map(|c| of(c))).unwrap_or(Standing::Other(why)))
}

/// SHA-256 of the contents of which a conversion of all line ends made the file, as version control may do it.
fn converted(path: &Path) -> Vec<String> {
    if !std::fs::metadata(path).is_ok_and(|m| m.len() <= CONVERTED_UP_TO) {
        return Vec::new();
    }
    let Ok(bytes) = regular::read(path) else { return Vec::new() };
    let crlf = bytes.windows(2).filter(|w| w == b"\r\n").count();
    let lf = bytes.iter().filter(|b| **b == b'\n').count();
    match (crlf, lf) {
        (0, 0) => Vec::new(),
        (0, _) => vec![sha256(&joined(&bytes, b"\r\n"))],
        (all, lines) if all == lines => vec![sha256(&joined(&bytes, b"\n"))],
        _ => Vec::new(),
    }
}

/// The lines of a text whose line ends are all alike, with other line ends.
fn joined(bytes: &[u8], end: &[u8]) -> Vec<u8> {
    let lines = bytes.split(|b| *b == b'\n').map(|line| line.strip_suffix(b"\r").unwrap_or(line));
    lines.collect::<Vec<_>>().join(end)
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
    fn line_ends_that_were_all_converted_are_seen_and_mixed_ones_are_left() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("p.src");
        for (text, of) in
            [(&b"a\r\nb\r\n"[..], Some(&b"a\nb\n"[..])), (b"a\nb", Some(b"a\r\nb")), (b"a\r\nb\n", None), (b"a", None)]
        {
            std::fs::write(&path, text).unwrap();
            assert_eq!(converted(&path), of.map(sha256).into_iter().collect::<Vec<_>>(), "{text:?}");
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
