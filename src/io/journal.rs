//! What a run was about to put in place, so that the next one can finish it or take it back.
//!
//! Method: a file `.lostmotion-*.journal` lists the renames of a transaction before the first of them. While it is there, the new
//! files are whole under their temporary names, and what they replace has a second name. A run that finds it (and no living run
//! holds the folder) goes one of two ways ([`Towards`]): `rewrite` restores what stood there before, as the interrupted run has
//! not said that it was done and would be repeated on its own result otherwise; `undo` does the renames that are left, and finds
//! the note that it needs. Where everything had come into place, only the journal goes. A journal names files of its own folder alone.

use super::folder::{folder_of, ignore_unsupported};
use super::lock::{FolderLock, LOCK, Sharing};
use super::name::path_of;
use super::notice::{self, Notice};
use super::temporary::{self, OLD, PART, PREFIX, Temporary};
use crate::error::{Error, Result, shown};
use serde::{Deserialize, Serialize};
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};
use std::time::Duration;

/// The end of a journal's name.
pub use super::temporary::JOURNAL as ENDING;
const SCHEMA: &str = "lostmotion/journal/1";
/// How long a run waits for another one that may finish the journal itself.
const PATIENCE: Duration = Duration::from_secs(10);
/// A journal of more bytes was not written by this program.
const LARGEST: u64 = 1 << 20;

/// One file of a transaction; names as [`super::name`] spells them.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Entry {
    /// File name of the output in its folder.
    pub target: String,
    /// The temporary name of the new file, and its size; `None`: the target is taken away.
    pub new: Option<String>,
    /// Size of the output, bytes.
    #[serde(default)]
    pub bytes: u64,
    /// The second name of what is replaced; `None`: nothing stood there.
    pub old: Option<String>,
}

/// The renames of a transaction.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Journal {
    schema: String,
    /// What was there before is to be restored.
    back: bool,
    files: Vec<Entry>,
}

/// A journal in place; dropped, it is gone.
#[derive(Debug)]
pub struct Written {
    journal: Journal,
    path: PathBuf,
    kept: bool,
}

impl Journal {
    /// A journal of outputs that come into place together.
    pub fn new(files: Vec<Entry>) -> Self {
        Self { schema: SCHEMA.into(), back: false, files }
    }

    /// Puts the journal in place, on disk where `synced`.
    pub fn write(self, folder: &Path, synced: bool) -> Result<Written> {
        let failed = |e| Error::io(folder, "write a journal in", e);
        let (mut file, temporary) = Temporary::create(folder, Some(0o600)).map_err(failed)?;
        let path = temporary.path().with_extension(ENDING.trim_start_matches('.'));
        let text = serde_json::to_vec(&self).map_err(|e| failed(e.into()))?;
        file.write_all(&text).map_err(failed)?;
        if synced {
            file.sync_all().or_else(ignore_unsupported).map_err(failed)?;
        }
        temporary.persist(&path).map_err(failed)?;
        let written = Written { journal: self, path, kept: false };
        #[cfg(unix)]
        if synced {
            let folder = std::fs::File::open(folder);
            folder.and_then(|f| f.sync_all().or_else(ignore_unsupported)).map_err(failed)?;
        }
        Ok(written)
    }

    /// The files that it names.
    pub fn files(&self) -> &[Entry] {
        &self.files
    }

    fn read(path: &Path) -> Option<Self> {
        let small = std::fs::metadata(path).is_ok_and(|m| m.is_file() && m.len() <= LARGEST);
        Self::parse(&small.then(|| std::fs::read(path).ok()).flatten()?)
    }

    /// A journal as this program writes it; `None`: it is damaged, or names a file out of its folder.
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        let journal: Self = serde_json::from_slice(bytes).ok()?;
        let sound = |e: &Entry| {
            ours(&e.target).is_some()
                && e.new.as_deref().is_none_or(|n| named_as(n, PART))
                && e.old.as_deref().is_none_or(|o| named_as(o, OLD))
        };
        (journal.schema == SCHEMA && journal.files.iter().all(sound)).then_some(journal)
    }

    /// Whether nothing is left to do.
    fn is_complete(&self, folder: &Path) -> bool {
        self.files.iter().all(|e| match &e.new {
            Some(new) => !beside(folder, e).join(new).exists(),
            None => std::fs::symlink_metadata(named(folder, e)).is_err(),
        })
    }

    /// Does what is left to do, or takes back what was done.
    fn finish(&self, folder: &Path, towards: Towards) -> io::Result<()> {
        let whole = |e: &Entry, new: &str| {
            let meta = std::fs::metadata(beside(folder, e).join(new));
            meta.map_or(true, |m| m.len() == e.bytes) // not there: it has its name already
        };
        let towards_result = towards == Towards::Result || self.is_complete(folder);
        let forward =
            !self.back && towards_result && self.files.iter().all(|e| e.new.as_deref().is_none_or(|n| whole(e, n)));
        for entry in &self.files {
            let target = target_of(folder, entry);
            let here = folder_of(&target);
            match (&entry.new, &entry.old) {
                (Some(new), _) if forward => rename(&here.join(new), &target)?,
                (None, _) if forward => remove(&named(folder, entry))?,
                (_, Some(old)) => rename(&here.join(old), &target)?,
                // it has its name: nothing stood there before
                (Some(new), None) if !here.join(new).exists() => remove(&target)?,
                _ => {}
            }
        }
        for entry in &self.files {
            let here = beside(folder, entry);
            for left in entry.old.iter().chain(&entry.new) {
                let _ = remove(&here.join(left));
            }
        }
        Ok(())
    }
}

impl Written {
    /// From now on the journal restores what was there. Where it is not certain, the journal is handed back as it is.
    pub fn turn_back(mut self, folder: &Path) -> std::result::Result<Self, Self> {
        let back = Journal { back: true, ..self.journal.clone() };
        match back.write(folder, false) {
            Ok(back) => {
                self.kept = false;
                drop(self);
                Ok(back)
            }
            Err(_) => Err(self),
        }
    }

    /// The next run is to finish it.
    pub fn keep(mut self) {
        self.kept = true;
    }
}

impl Drop for Written {
    fn drop(&mut self) {
        if !self.kept {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Which state an interrupted transaction is brought to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Towards {
    /// That before it, unless it was complete.
    Before,
    /// That after it, unless it was being taken back.
    Result,
}

/// Finishes what a run that was killed left in `folder`, and takes its temporary files away. A folder in which another run is at
/// work is waited for; one that cannot be written is left alone.
pub fn finish(folder: &Path, towards: Towards) -> Result<()> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let stale = |suffix| !temporary::named(folder, suffix).is_empty();
    if !stale(ENDING) && !stale(OLD) && !folder.join(LOCK).exists() {
        temporary::clean(folder);
        return Ok(());
    }
    let _lock = match FolderLock::take(folder, Sharing::Alone, PATIENCE) {
        Err(Error::Io { source, .. }) if is_read_only(&source) => return Ok(()),
        lock => lock?,
    };
    finish_locked(folder, towards)
}

fn is_read_only(e: &io::Error) -> bool {
    matches!(e.kind(), io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem)
}

/// The same in a folder that this run holds.
pub fn finish_locked(folder: &Path, towards: Towards) -> Result<()> {
    let journals = temporary::named(folder, ENDING);
    for path in &journals {
        let Some(journal) = Journal::read(path) else {
            return Err(Error::bad(
                crate::error::Place::file(shown(path)),
                "a journal that is damaged",
                "the journal of a run that was killed (check the programs next to it, then remove it)",
            ));
        };
        journal.finish(folder, towards).map_err(|e| Error::io(path, "finish what it lists in", e))?;
        std::fs::remove_file(path).map_err(|e| Error::io(path, "remove", e))?;
        notice::report(Notice::ClearedUp(folder));
    }
    for old in temporary::named(folder, OLD) {
        let _ = std::fs::remove_file(old);
    }
    temporary::clean(folder);
    Ok(())
}

/// Whether a name is that of a journal.
pub fn is_journal(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().as_encoded_bytes();
    name.starts_with(PREFIX.as_bytes()) && name.ends_with(ENDING.as_bytes())
}

/// A name without a folder.
fn ours(text: &str) -> Option<PathBuf> {
    let path = path_of(text)?;
    // `name/` and `name/.` have one component, too
    let plain = matches!(path.components().next(), Some(Component::Normal(name)) if name == path.as_os_str());
    plain.then_some(path)
}

fn named_as(text: &str, suffix: &str) -> bool {
    ours(text).is_some() && text.starts_with(PREFIX) && text.ends_with(suffix)
}

/// A target by its name.
fn named(folder: &Path, entry: &Entry) -> PathBuf {
    folder.join(ours(&entry.target).unwrap_or_default())
}

/// Where the target's name leads.
fn target_of(folder: &Path, entry: &Entry) -> PathBuf {
    let named = named(folder, entry);
    std::fs::canonicalize(&named).unwrap_or(named)
}

fn beside(folder: &Path, entry: &Entry) -> PathBuf {
    folder_of(&target_of(folder, entry)).to_path_buf()
}

/// Renames a file that may have its name already.
fn rename(from: &Path, to: &Path) -> io::Result<()> {
    absent_is_done(std::fs::rename(from, to))
}

fn remove(path: &Path) -> io::Result<()> {
    absent_is_done(std::fs::remove_file(path))
}

fn absent_is_done(result: io::Result<()>) -> io::Result<()> {
    match result {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(e),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_journal_that_names_anything_but_a_file_of_its_folder_is_damaged() {
        let text = |target: &str| {
            let files = format!(r#"[{{"target": "{target}", "new": ".lostmotion-1.part", "old": null}}]"#);
            format!(r#"{{"schema": "{SCHEMA}", "back": false, "files": {files}}}"#)
        };
        assert!(Journal::parse(text("out.src").as_bytes()).is_some());
        for target in ["", ".", "..", "out.src/", "out.src/.", "./out.src", "/out.src", "a/out.src"] {
            assert!(Journal::parse(text(target).as_bytes()).is_none(), "{target}");
        }
    }
}
