//! Lists of programs for jobs that many machines share: what there is, who does which part, what came of it.
//!
//! A manifest is a line of JSON for each program, in the order of the keys. A key is the path of the program below the folder of the
//! programs. A program belongs to one of N shards by the hash of its key alone, so that a program that is added moves no other
//! one. A shard writes its summary last; summaries are merged only if they hold every program of the manifest once.
//!
//! Parts: `merged` what the summaries of the shards hold.

mod merged;

use super::batch;
use super::earlier;
use super::summary::Line;
use crate::error::{Error, Place, Result, shown};
use crate::io::input;
use crate::io::name::{path_of, text_of};
use crate::numerics::parallel::ParMap;
use crate::program::formats::{self, Recognised};
pub use merged::{Counts, Merged, SummaryLine};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Component, Path, PathBuf};

/// Bytes at the start of a program by which its format is recognised.
const HEAD: usize = 1 << 16;

/// A program of a manifest.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Entry {
    /// Path below the folder of the programs.
    pub key: String,
    /// Size of the file, bytes.
    pub size: u64,
    /// `None`: it could not be read.
    pub sha256: Option<String>,
    /// Name of its format; `None` where it cannot be read.
    pub format: Option<String>,
    /// Whether it can be read.
    pub state: State,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    /// Why it cannot be read.
    pub reason: Option<String>,
}

/// What is known of a program before it is rewritten.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// It can be read.
    Ready,
    /// It cannot; why is in `reason`.
    Unreadable,
}

/// The programs below `root`, in the order of their keys, without results of an earlier rewrite.
///
/// # Errors
/// Bad input where the folder cannot be listed, or holds no program.
pub fn of_folder(root: &Path, format: Option<Recognised>) -> Result<Vec<Entry>> {
    let mut tree = batch::tree(root, Path::new(""), format)?;
    earlier::leave_out(root, &mut tree.programs, &tree.files);
    let mut entries: Vec<Entry> = tree.programs.par_map(|p| entry(root, p, format));
    entries.extend(tree.unreadable.iter().map(|(path, why)| {
        let key = path.strip_prefix(root).unwrap_or(path);
        unreadable(text_of(key), 0, why.clone())
    }));
    entries.sort_by(|a, b| a.key.cmp(&b.key));
    Ok(entries)
}

/// The programs that a list names, a path below `root` on each line; blank lines and lines that begin with `#` are left out.
/// A path is spelt in one way in the key: `./cell//a.csv` is `cell/a.csv`. A line holds the bytes of the path, as `ls` prints them to a
/// file, or the path escaped as in a key.
///
/// # Errors
/// Bad input where a path leads out of the folder, or stands twice.
pub fn of_list(name: &str, list: &[u8], root: &Path, format: Option<Recognised>) -> Result<Vec<Entry>> {
    let mut paths = Vec::new();
    for (k, line) in list.split(|b| *b == b'\n').enumerate() {
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        if !line.trim_ascii().is_empty() && !line.starts_with(b"#") {
            let path = listed(line, root);
            paths.push(path.ok_or_else(|| outside(name, k as u64 + 1, &line.escape_ascii().to_string()))?);
        }
    }
    let mut entries: Vec<Entry> = paths.par_map(|p| entry(root, p, format));
    entries.sort_by(|a, b| a.key.cmp(&b.key));
    if let Some(pair) = entries.windows(2).find(|p| p[0].key == p[1].key) {
        return Err(Error::bad(Place::file(name), format!("`{}` twice", pair[0].key), "each program once"));
    }
    Ok(entries)
}

fn entry(root: &Path, program: &Path, format: Option<Recognised>) -> Entry {
    let key = text_of(program);
    let path = root.join(program);
    match read(&path, format) {
        Ok((size, sha256, format)) => {
            Entry { key, size, sha256: Some(sha256), format: Some(format.into()), state: State::Ready, reason: None }
        }
        Err(e) => unreadable(key, 0, Error::io(&path, "read", e).to_string()),
    }
}

fn unreadable(key: String, size: u64, why: String) -> Entry {
    Entry { key, size, sha256: None, format: None, state: State::Unreadable, reason: Some(why) }
}

/// Size, SHA-256 and format of a file, in constant memory.
fn read(path: &Path, format: Option<Recognised>) -> std::io::Result<(u64, String, &'static str)> {
    let mut file = File::open(path)?;
    let mut head = Vec::new();
    file.by_ref().take(HEAD as u64).read_to_end(&mut head)?;
    let mut hash = Sha256::new_with_prefix(&head);
    let mut size = head.len() as u64;
    if head.len() == HEAD {
        size += std::io::copy(&mut file, &mut hash)?;
    }
    let format = match format.unwrap_or_else(|| formats::recognise(path, &head)) {
        Recognised::Csv => "csv",
        Recognised::Script(f) => f.name(),
    };
    Ok((size, input::hex(&hash.finalize()), format))
}

/// A manifest as text.
pub fn text(entries: &[Entry]) -> String {
    entries.iter().map(|e| serde_json::to_string(e).unwrap_or_default() + "\n").collect()
}

/// The entries of a manifest that `wanted` takes, in order; the others are not kept.
///
/// # Errors
/// Bad input where a line is no entry, leads out of the folder, or is not in the order of the keys.
pub fn load(path: &Path, wanted: &dyn Fn(&Entry) -> bool) -> Result<Vec<Entry>> {
    parse(&shown(path), BufReader::new(input::open(path)?), wanted)
}

/// The same of lines that are open already; `name` stands in messages.
///
/// # Errors
/// As [`load`].
pub fn parse(name: &str, lines: impl BufRead, wanted: &dyn Fn(&Entry) -> bool) -> Result<Vec<Entry>> {
    let mut entries: Vec<Entry> = Vec::new();
    let mut last: Option<String> = None;
    for (k, line) in lines.lines().enumerate() {
        let line = line.map_err(|e| Error::io_of(name, "read", e))?;
        if line.trim().is_empty() {
            continue;
        }
        let at = || Place::line(name, k as u64 + 1);
        let entry: Entry = serde_json::from_str(&line).map_err(|e| {
            let found = if e.is_data() { e.to_string() } else { "a line that is not JSON".into() };
            Error::bad(at(), found, "a line of a manifest, as `lostmotion manifest` writes it")
        })?;
        let path = below(&entry.key).ok_or_else(|| outside(name, k as u64 + 1, &entry.key))?;
        if text_of(&path).replace('\\', "/") != entry.key.replace('\\', "/") {
            return Err(Error::bad(at(), format!("`{}`", entry.key), format!("the key as `{}`", text_of(&path))));
        }
        if entry.state == State::Ready && entry.sha256.is_none() {
            return Err(Error::bad(
                at(),
                "a program that can be read, without its `sha256`",
                "its SHA-256 (list it again)",
            ));
        }
        if last.as_ref().is_some_and(|l| *l >= entry.key) {
            let found = format!("`{}` after `{}`", entry.key, last.unwrap_or_default());
            return Err(Error::bad(at(), found, "each key once, in order, as `lostmotion manifest` writes them"));
        }
        last = Some(entry.key.clone());
        if wanted(&entry) {
            entries.push(entry);
        }
    }
    if last.is_none() {
        return Err(Error::bad(Place::file(name), "no line", "a manifest, as `lostmotion manifest` writes it"));
    }
    Ok(entries)
}

/// The path of a line of a list: one that exists by these very bytes, or that of a key.
#[cfg(unix)]
fn listed(line: &[u8], root: &Path) -> Option<PathBuf> {
    use std::os::unix::ffi::OsStrExt;
    let plain = inside(Path::new(std::ffi::OsStr::from_bytes(line)));
    let exists = plain.as_ref().is_some_and(|p| root.join(p).symlink_metadata().is_ok());
    let escaped = || std::str::from_utf8(line).ok().and_then(|key| below(key.trim_start_matches("./")));
    if exists { plain } else { escaped().or(plain) }
}

#[cfg(not(unix))]
fn listed(line: &[u8], _root: &Path) -> Option<PathBuf> {
    below(std::str::from_utf8(line).ok()?.trim_start_matches("./"))
}

/// A path that stays below its folder, without doubled separators and `.` between them.
fn inside(path: &Path) -> Option<PathBuf> {
    let parts = || path.components().filter(|c| !matches!(c, Component::CurDir));
    let inside = parts().all(|c| matches!(c, Component::Normal(_)));
    (inside && parts().next().is_some()).then(|| parts().collect())
}

/// The path of a key, if it stays below its folder, without doubled separators and `.` between them.
pub fn below(key: &str) -> Option<PathBuf> {
    path_of(key).filter(|p| !p.starts_with(".")).and_then(|p| inside(&p))
}

fn outside(name: &str, line: u64, key: &str) -> Error {
    let expected = "a path below the folder of the programs, without `..`";
    Error::bad(Place::line(name, line), format!("`{key}`"), expected)
}

/// The shard, from 1 to `n`, to which a program belongs by its key.
pub fn shard_of(key: &str, n: usize) -> usize {
    let digest = Sha256::digest(key.replace('\\', "/").as_bytes());
    let first = digest.iter().take(8).fold(0u64, |sum, b| sum << 8 | u64::from(*b));
    (first % n.max(1) as u64) as usize + 1
}

/// Lines of the programs that are no longer what the manifest has, by key: it is not known whether they are to be rewritten.
pub fn changed(root: &Path, entries: &[Entry]) -> HashMap<String, Line> {
    let differs = |e: &Entry| {
        let path = root.join(below(&e.key)?);
        // `rewrite` reports what cannot be read
        let (size, sha256, _) = read(&path, None).ok()?;
        let (other, now) = (size != e.size || e.sha256.as_ref() != Some(&sha256), Some(sha256));
        let bad = || Error::bad(Place::file(shown(&path)), "content that differs from the manifest", "a new manifest");
        other.then(|| (e.key.clone(), Line::failed(shown(&path), &bad(), now)))
    };
    entries.par_map(differs).into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_that_is_added_moves_no_other_to_another_shard() {
        // by hand: the first eight bytes of SHA-256("cell/a.csv"), modulo 8
        let digest = Sha256::digest(b"cell/a.csv");
        let mut first = [0; 8];
        first.copy_from_slice(&digest[..8]);
        assert_eq!(shard_of("cell/a.csv", 8), (u64::from_be_bytes(first) % 8) as usize + 1);
        let counts = (0..8000).fold([0usize; 8], |mut sum, k| {
            sum[shard_of(&format!("p{k}.src"), 8) - 1] += 1;
            sum
        });
        // 1,000 each, standard deviation 30
        assert!(counts.iter().all(|c| (850..1150).contains(c)), "{counts:?}");
    }

    #[test]
    fn a_key_stays_below_its_folder() {
        for key in ["../a.csv", "/etc/a.csv", "a/../../b.csv", "", "."] {
            assert_eq!(below(key), None, "{key}");
        }
        assert_eq!(below("cell/a.csv"), Some(PathBuf::from("cell/a.csv")));
        assert_eq!(below("cell//./a.csv").unwrap().as_os_str(), "cell/a.csv");
    }
}
