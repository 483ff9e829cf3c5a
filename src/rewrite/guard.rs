//! A program that has been rewritten is not rewritten again.
//!
//! Two checks. (1) Beside every file that it writes, `rewrite` leaves a note `FILE.lostmotion.json` with the SHA-256 of the
//! file; an input whose hash stands in a note of its folder is refused (the file itself may carry no mark: every byte that is
//! no motion target stays). (2) A file without its note is known by its numbers: joints by
//! [`super::rewritten`], Cartesian targets by `super::script::retraced`.

use crate::error::{BadInput, Error, Place, Result, is_stdio, shown};
use crate::io::folder;
use crate::io::input::sha256;
use crate::io::notice::{self, Notice};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
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
    /// The input's bytes, for `undo` ([`super::original`]); a large program is not kept.
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
    /// The bytes of the file before, for `undo`; a large file is not kept.
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

/// Where the note of a file stands.
pub fn note_path(file: &Path) -> PathBuf {
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
    let path = note_path(file);
    match std::fs::read(&path) {
        Ok(bytes) => parse_note(&bytes).map(Some).ok_or_else(|| damaged(&path)),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(Error::io(&path, "read", e)),
    }
}

fn damaged(path: &Path) -> Error {
    Error::bad(
        Place::file(shown(path)),
        "a note that is damaged",
        "the note as `rewrite` wrote it, which describes the original program",
    )
    .mended_by(&["force"])
}

/// A note that is whole; notes of earlier versions have no check.
pub fn parse_note(bytes: &[u8]) -> Option<Note> {
    let text = std::str::from_utf8(bytes).ok()?;
    let note = serde_json::from_str::<Note>(text).ok()?;
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
    /// As the notes in the folder of `input` have it.
    pub fn beside(&self, input: &Path) -> Result<Arc<Vec<String>>> {
        if is_stdio(input) {
            return Ok(Arc::default());
        }
        let here = match input.parent() {
            Some(p) if !p.as_os_str().is_empty() => p,
            _ => Path::new("."),
        };
        // a thread that failed while it read leaves at most a folder unread
        let mut folders = self.folders.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = folders.get(here) {
            return Ok(Arc::clone(known));
        }
        let entries = match folder::list(here) {
            // a folder that lets its files be read by name alone
            Err(e) if e.kind() == std::io::ErrorKind::PermissionDenied => Vec::new(),
            listed => listed.map_err(|e| Error::io(here, "list", e))?,
        };
        let entries = entries.into_iter().map(|e| here.join(e.0));
        let read = |p: PathBuf| match std::fs::read(&p) {
            Ok(bytes) => {
                let note = parse_note(&bytes);
                if note.is_none() {
                    notice::report(Notice::DamagedNote(&p));
                }
                note.map(Ok)
            }
            Err(e) => Some(Err(Error::io(&p, "read", e))),
        };
        let notes = entries.filter(|p| is_note(p)).filter_map(read);
        let found: Arc<Vec<String>> =
            Arc::new(notes.map(|n: Result<Note>| n.map(|n| n.result())).collect::<Result<_>>()?);
        folders.insert(here.to_path_buf(), Arc::clone(&found));
        Ok(found)
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
