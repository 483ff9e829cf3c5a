//! Lists of programs for jobs that many machines share: what there is, who does which part, what came of it.
//!
//! A manifest is a line of JSON for each program, in the order of the keys. A key is the path of the program below the folder of the
//! programs. A program belongs to one of N shards by the hash of its key alone, so that a program that is added moves no other
//! one. A shard writes its summary last; summaries are merged only if they hold every program of the manifest once.

use super::batch;
use super::earlier;
use super::guard::read_note;
use super::refusal::Refusal;
use super::summary::{Line, RewrittenBy, Status};
use crate::error::{BadInput, Error, Place, Result, shown};
use crate::io::input;
use crate::io::name::{path_of, text_of};
use crate::numerics::parallel::ParMap;
use crate::program::formats::{self, Recognised};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Component, Path, PathBuf};

/// Bytes at the start of a program by which its format is recognised.
const HEAD: usize = 1 << 16;
/// Keys that a message lists.
const LISTED: usize = 5;

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

/// A line of a summary, as far as merging needs it.
#[derive(Deserialize)]
struct Summed {
    key: Option<String>,
    status: Status,
    sha256_in: Option<String>,
    sha256_out: Option<String>,
    /// Summaries of earlier versions lack it.
    #[serde(default)]
    rewritten_by: Option<RewrittenBy>,
}

impl Summed {
    /// Why the line says nothing about the job: found and expected.
    fn fault(&self, entry: &Entry) -> Option<[String; 2]> {
        let key = &entry.key;
        match self.status {
            Status::WouldBeWritten => {
                let expected = "a summary of a run that writes (not of a dry run or a check)";
                Some([format!("`{key}` that would be written"), expected.into()])
            }
            // one that failed may have changed since it was listed: that is why
            Status::Failed => None,
            _ if self.sha256_in == entry.sha256 => None,
            _ => Some([
                format!("`{key}` with another `sha256_in` than the manifest"),
                "a summary of this manifest".into(),
            ]),
        }
    }
}

/// The line of a program in a summary.
#[derive(Debug, Clone)]
pub struct SummaryLine {
    /// The line itself.
    pub text: String,
    /// `None`: it is of a former content of the program, or of a run that wrote nothing.
    pub status: Option<Status>,
    sha256_out: Option<String>,
}

/// What is known of the programs of a manifest, in their order.
#[derive(Debug, Default)]
pub struct Merged {
    /// Lines of the summaries; `None`: no summary holds the program.
    pub lines: Vec<Option<SummaryLine>>,
    /// The first line that is not of this job.
    fault: Option<BadInput>,
    /// By what the first program was rewritten, and where that stands.
    by: Option<(RewrittenBy, String)>,
    /// The first line of a program that was rewritten by something else.
    mixed: Option<BadInput>,
}

/// Counts of the programs of a manifest.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Number of programs in the manifest.
    pub programs: usize,
    /// Written or unchanged.
    pub done: usize,
    /// Number of programs that were refused.
    pub refused: usize,
    /// Number of programs that failed.
    pub failed: usize,
    /// Number of programs that are left to do.
    pub left: usize,
}

impl Merged {
    /// Reads summaries of shards.
    ///
    /// # Errors
    /// Bad input where a line has no key, a key that the manifest does not have, or one that came before.
    pub fn read(entries: &[Entry], summaries: &[PathBuf]) -> Result<Self> {
        let opened = summaries.iter().map(|path| Ok((path.as_path(), BufReader::new(input::open(path)?))));
        Self::merge(entries, opened)
    }

    /// Reads one summary of that name; errors as those of [`Merged::read`].
    pub fn parse(entries: &[Entry], name: &str, lines: impl BufRead) -> Result<Self> {
        Self::merge(entries, std::iter::once(Ok((Path::new(name), lines))))
    }

    fn merge<'a, R: BufRead>(
        entries: &[Entry],
        summaries: impl Iterator<Item = Result<(&'a Path, R)>>,
    ) -> Result<Self> {
        let places: HashMap<&str, usize> = entries.iter().enumerate().map(|(k, e)| (e.key.as_str(), k)).collect();
        let mut lines: Vec<Option<SummaryLine>> = vec![None; entries.len()];
        let (mut fault, mut by, mut mixed) = (None, None, None);
        for summary in summaries {
            let (path, text) = summary?;
            let name = shown(path);
            for (k, line) in text.lines().enumerate() {
                let line = line.map_err(|e| Error::io(path, "read", e))?;
                let at = || Place::line(&name, k as u64 + 1);
                let expected = "a line of a summary of a shard";
                let summed: Summed =
                    serde_json::from_str(&line).map_err(|e| Error::bad(at(), e.to_string(), expected))?;
                let key = summed.key.as_deref().ok_or_else(|| Error::bad(at(), "no key", expected))?;
                let place = places.get(key).copied();
                let place = place.ok_or_else(|| Error::bad(at(), format!("`{key}`"), "a program of the manifest"))?;
                if lines[place].is_some() {
                    return Err(Error::bad(at(), format!("`{key}` twice"), "each program in one summary"));
                }
                let other = summed.fault(&entries[place]);
                let status = other.is_none().then_some(summed.status);
                if let (Some([found, expected]), None) = (other, &fault) {
                    fault = Some(BadInput { place: at(), found, expected });
                }
                if let (Some(one), None) = (&summed.rewritten_by, &mixed) {
                    mixed = differs(&mut by, one, &name).map(|found| BadInput {
                        place: at(),
                        found: format!("`{key}`, rewritten by {found}"),
                        expected: ONE_JOB.into(),
                    });
                }
                lines[place] = Some(SummaryLine { text: line, status, sha256_out: summed.sha256_out });
            }
        }
        Ok(Self { lines, fault, by, mixed })
    }

    /// Refuses programs of one job that were rewritten by different compensators, robot files or options. With the folder of the results
    /// those are asked, too, of which there is no line yet.
    ///
    /// # Errors
    /// Bad input, with the first line or result that differs.
    pub fn require_one_job(&self, entries: &[Entry], results: Option<&Path>) -> Result<()> {
        if let Some(mixed) = &self.mixed {
            return Err(Error::BadInput(mixed.clone()));
        }
        let Some(results) = results else { return Ok(()) };
        let mut by = self.by.clone();
        for (entry, _) in entries.iter().zip(&self.lines).filter(|(_, line)| line.is_none()) {
            let Some(path) = below(&entry.key).map(|key| results.join(key)).filter(|p| stands(entry, p)) else {
                continue;
            };
            let Some(note) = read_note(&path).ok().flatten() else { continue };
            let one = RewrittenBy::of(&note.robot.sha256, &note.compensator.sha256, &note.options);
            if let Some(found) = differs(&mut by, &one, &shown(&path)) {
                return Err(Error::bad(Place::file(shown(&path)), format!("a program rewritten by {found}"), ONE_JOB));
            }
        }
        Ok(())
    }

    /// Refuses summaries that are not of this job, and those in which programs are missing.
    ///
    /// # Errors
    /// Bad input where a line is of a former content of its program, or of a run that wrote nothing; a refusal where programs are missing.
    pub fn require_all(&self, entries: &[Entry]) -> Result<()> {
        if let Some(fault) = &self.fault {
            return Err(Error::BadInput(fault.clone()));
        }
        let missing = || entries.iter().zip(&self.lines).filter(|(_, l)| l.is_none()).map(|(e, _)| e.key.as_str());
        let count = missing().count();
        if count == 0 {
            return Ok(());
        }
        let first: Vec<&str> = missing().take(LISTED).collect();
        let more = if count > LISTED { ", ..." } else { "" };
        Err(Refusal::Missing { missing: count, programs: entries.len(), first: first.join(", ") + more }.into())
    }

    /// Counts. With the folder of the results, every result is read: a program is done if its result is the one that its line of a
    /// summary or its note says, and of the listed content. A line of a former content, or of a run that wrote nothing, does not count.
    pub fn counts(&self, entries: &[Entry], results: Option<&Path>) -> Counts {
        let status = |(entry, told): (&Entry, &Option<SummaryLine>)| {
            let path = || Some(results?.join(below(&entry.key)?));
            match told.as_ref().and_then(|t| Some((t, t.status?))) {
                Some((told, status @ (Status::Written | Status::Unchanged))) => match path() {
                    Some(path) => {
                        (told.sha256_out.is_some() && batch::hash(&path) == told.sha256_out).then_some(status)
                    }
                    None => Some(status),
                },
                Some((_, status)) => Some(status),
                None => path().filter(|p| stands(entry, p)).map(|_| Status::Written),
            }
        };
        let all = (0..entries.len().min(self.lines.len())).par_map(|k| status((&entries[k], &self.lines[k])));
        let mut counts = Counts { programs: entries.len(), ..Counts::default() };
        for status in all {
            let count = match status {
                None => &mut counts.left,
                Some(Status::Refused) => &mut counts.refused,
                Some(Status::Failed) => &mut counts.failed,
                Some(Status::Written | Status::WouldBeWritten | Status::Unchanged) => &mut counts.done,
            };
            *count += 1;
        }
        counts
    }
}

/// What is expected where the programs of a job differ in what rewrote them.
const ONE_JOB: &str =
    "all programs of a job rewritten by one compensator, robot file and set of options: rewrite them again";

/// In what a program differs from the first one, which is kept with the place where that stands.
fn differs(first: &mut Option<(RewrittenBy, String)>, one: &RewrittenBy, place: &str) -> Option<String> {
    match first {
        None => {
            *first = Some((one.clone(), place.into()));
            None
        }
        Some((first, named)) => one.differs(first).map(|part| format!("another {part} than the programs in {named}")),
    }
}

/// Whether a result of the listed content stands at `path` as its note says.
fn stands(entry: &Entry, path: &Path) -> bool {
    let note = read_note(path).ok().flatten().filter(|n| n.sha256_in.is_some() && n.sha256_in == entry.sha256);
    note.is_some_and(|n| batch::hash(path).as_ref() == Some(&n.sha256_out))
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
