//! A program that has been rewritten is not rewritten again.
//!
//! Two checks. (1) Beside every file that it writes, `rewrite` leaves a note `FILE.lostmotion.json` with the SHA-256 of the
//! file (beside the file itself, where it was named by a link); an input whose hash stands in a note of its folder is refused (the file
//! itself may carry no mark: every byte that is no motion target stays). (2) A file without its note is known by its numbers: joints by
//! [`super::rewritten`], Cartesian targets by `super::script::retraced`.

use crate::error::{BadInput, Error, Place, Result, is_stdio, shown};
use crate::io::input::sha256;
use crate::io::notice::{self, Notice};
use crate::io::{folder, links, regular};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// The schema that a note names.
pub const SCHEMA: &str = "lostmotion/rewritten/1";
const ENDING: &str = ".lostmotion.json";

/// The note beside a rewritten file.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Note {
    /// The schema of this note.
    pub schema: String,
    /// Version of the program that wrote the file.
    pub version: String,
    /// Names without folders.
    pub input: String,
    /// Name of the rewritten file.
    pub output: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    /// SHA-256 of the program before, hexadecimal; notes of earlier versions lack it.
    pub sha256_in: Option<String>,
    /// SHA-256 of the rewritten program, hexadecimal.
    pub sha256_out: String,
    /// The robot file.
    pub robot: Named,
    /// The compensator file.
    pub compensator: Named,
    /// Options as they were given.
    pub options: Vec<String>,
    /// As in a summary line.
    #[serde(default)]
    pub moves: u64,
    #[serde(default)]
    /// Number of moves that could be edited.
    pub editable: u64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    /// Of them those whose joint values were written.
    pub edited_as_joints: Option<u64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    /// Of them those whose Cartesian targets were written.
    pub edited_as_poses: Option<u64>,
    #[serde(default)]
    /// Number of reversals.
    pub reversals: u64,
    #[serde(default)]
    /// Number of new points.
    pub inserted: u64,
    /// The input's bytes, for `undo` ([`super::original`]); a large program is not kept, nor one that needed no change.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub original: Option<String>,
    /// SHA-256 of the files that declare what the program uses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub context: Option<String>,
    /// Further files of the program.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub companions: Vec<Companion>,
}

impl Note {
    /// Whether it is about a program that needed no change: the files of the result are those of the input, byte for byte.
    pub fn is_of_copy(&self) -> bool {
        self.sha256_in.as_ref() == Some(&self.sha256_out) && self.companions.iter().all(|c| c.sha256_in == c.sha256_out)
    }

    /// One word for the SHA-256 of all files of the result.
    pub fn result(&self) -> String {
        together(std::iter::once(&self.sha256_out).chain(self.companions.iter().map(|c| &c.sha256_out)))
    }
}

/// A file that belongs to a program, such as the `.dat` of a `.src`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Companion {
    /// Name of the program before.
    pub input: String,
    /// Name of the rewritten program.
    pub output: String,
    /// SHA-256 of the program before, hexadecimal.
    pub sha256_in: String,
    /// SHA-256 of the rewritten program, hexadecimal.
    pub sha256_out: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    /// The bytes of the file before, for `undo`; a large file is not kept, nor one that was not changed with its program.
    pub original: Option<String>,
}

/// Name and SHA-256.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Named {
    /// Name of the file.
    pub name: String,
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
}

/// Where the note of a file is written: beside the file that a link leads to, so that it is found by every name of the file.
pub fn note_path(file: &Path) -> PathBuf {
    note_name(&links::target_of(file))
}

/// Where the note of a file is: as [`note_path`] says; notes of earlier versions may stand beside a link.
pub fn find_note(file: &Path) -> PathBuf {
    let (own, linked) = (note_path(file), note_name(file));
    if own != linked && !own.exists() && linked.exists() { linked } else { own }
}

/// The name of the note of a file that is known by its name alone (a key, an entry of a list).
pub fn note_name(file: &Path) -> PathBuf {
    let mut name = file.as_os_str().to_os_string();
    name.push(ENDING);
    PathBuf::from(name)
}

/// Whether a name is that of a note.
pub fn is_note(file: &Path) -> bool {
    file.as_os_str().as_encoded_bytes().ends_with(ENDING.as_bytes())
}

/// The line that closes a note: the SHA-256 of all that stands before it.
const CHECK: &str = "  \"check\": \"";

/// The text of a note, with its check.
pub fn note_text(note: &Note) -> Result<String> {
    let text = serde_json::to_string_pretty(note).map_err(|e| Error::internal("write JSON", e))?;
    let body = format!("{},\n", text.trim_end().trim_end_matches('}').trim_end());
    let check = sha256(body.as_bytes());
    Ok(format!("{body}{CHECK}{check}\"\n}}\n"))
}

/// Reads the note of a file; `None`: there is none.
///
/// # Errors
/// Bad input where the note is damaged: silence would let its program be rewritten twice.
pub fn read_note(file: &Path) -> Result<Option<Note>> {
    let path = find_note(file);
    match regular::read(&path) {
        Ok(bytes) => parse_note(&bytes).map(Some).ok_or_else(|| damaged(&path)),
        // a name that is too long for the file system is that of no note
        Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::InvalidFilename) => Ok(None),
        Err(e) => Err(Error::io(&path, "read", e)),
    }
}

fn damaged(path: &Path) -> Error {
    Error::bad(
        Place::file(shown(path)),
        "a note that is damaged",
        "the note as `rewrite` wrote it, which describes the original program",
    )
}

/// A note that is whole; notes of earlier versions have no check. Line ends that version control converted do not count.
pub fn parse_note(bytes: &[u8]) -> Option<Note> {
    let text = std::str::from_utf8(bytes).ok()?.replace("\r\n", "\n");
    let note = serde_json::from_str::<Note>(&text).ok()?;
    let sound = match text.rfind(CHECK) {
        Some(at) => text[at + CHECK.len()..].starts_with(&sha256(&text.as_bytes()[..at])),
        None => !text.contains("\"check\""),
    };
    let is_hash = |s: &String| s.len() == 64 && s.bytes().all(|b| b.is_ascii_hexdigit());
    let hashes = std::iter::once(&note.sha256_out).chain(note.companions.iter().map(|c| &c.sha256_out));
    (sound && note.schema == SCHEMA && hashes.into_iter().all(is_hash)).then_some(note)
}

/// One word for the SHA-256 of all files of a program: a program is known by all of them, as a change may stand in one alone.
pub fn together<'a>(hashes: impl Iterator<Item = &'a String>) -> String {
    hashes.map(String::as_str).collect::<Vec<_>>().join("+")
}

/// SHA-256 of the files that were rewritten, folder by folder, each folder read once.
#[derive(Debug, Default)]
pub struct Notes {
    folders: Mutex<HashMap<PathBuf, Arc<Vec<String>>>>,
}

impl Notes {
    /// As the notes in the folder of `input` have it, and where it is a link those in the folder to which that leads.
    pub fn beside(&self, input: &Path) -> Result<Arc<Vec<String>>> {
        if is_stdio(input) {
            return Ok(Arc::default());
        }
        let here = self.of_folder(folder::folder_of(input))?;
        let target = links::target_of(input);
        if target == input {
            return Ok(here);
        }
        let there = self.of_folder(folder::folder_of(&target))?;
        Ok(Arc::new(here.iter().chain(there.iter()).cloned().collect()))
    }

    fn of_folder(&self, here: &Path) -> Result<Arc<Vec<String>>> {
        // a thread that failed while it read leaves at most a folder unread
        let mut folders = self.folders.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = folders.get(here) {
            return Ok(Arc::clone(known));
        }
        let entries = match folder::list(here) {
            // a folder that lets its files be read by name alone
            Err(e) if e.kind() == ErrorKind::PermissionDenied => Vec::new(),
            listed => listed.map_err(|e| Error::io(here, "list", e))?,
        };
        let notes = entries.into_iter().filter(|(name, _)| is_note(Path::new(name)));
        let results = notes.filter_map(|(name, kind)| result_of(&here.join(name), kind).transpose());
        let found: Arc<Vec<String>> = Arc::new(results.collect::<Result<_>>()?);
        folders.insert(here.to_path_buf(), Arc::clone(&found));
        Ok(found)
    }
}

/// SHA-256 of the rewritten program that a note is about; `None`: a program that needed no change, a damaged note, or a name like a
/// note's that stands for no file.
fn result_of(note: &Path, kind: folder::Kind) -> Result<Option<String>> {
    if kind != folder::Kind::File && !note.is_file() {
        return Ok(None);
    }
    match regular::read(note) {
        Ok(bytes) => {
            let note_of = parse_note(&bytes);
            if note_of.is_none() {
                notice::report(Notice::DamagedNote(note));
            }
            Ok(note_of.filter(|n| !n.is_of_copy()).map(|n| n.result()))
        }
        Err(e) if e.kind() == ErrorKind::NotFound || regular::is_other(&e) => Ok(None),
        Err(e) => Err(Error::io(note, "read", e)),
    }
}

/// The refusal of a program that has been rewritten already; `how` it is known.
pub fn already(name: &str, how: &str) -> Error {
    Error::RewrittenAlready(BadInput {
        place: Place::file(name),
        found: format!("a program that has been rewritten already ({how})"),
        expected: "the original program".into(),
    })
}

#[cfg(test)]
mod tests;
