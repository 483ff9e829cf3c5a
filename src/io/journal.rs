//! What a run was about to put in place, so that the next one can finish it or take it back.
//!
//! Method: a file `.lostmotion-*.journal` lists the renames of a transaction before the first of them. While it is there, the new
//! files are whole under their temporary names, and what they replace has a second name. A run that finds it (and no living run
//! holds the folder) goes one of two ways ([`Towards`]): `rewrite` restores what stood there before, as the interrupted run has
//! not said that it was done and would be repeated on its own result otherwise; `undo` does the renames that are left, and finds
//! the note that it needs. Where everything had come into place, only the journal goes. A journal names files of its own folder
//! alone: one that names a link which leads out of the folder is damaged.

use super::folder::{folder_of, ignore_unsupported};
use super::links;
use super::lock::{FolderLock, LOCK, Sharing};
use super::name::path_of;
use super::notice::{self, Notice};
use super::regular;
use super::temporary::{self, OLD, PART, PREFIX, Temporary};
use crate::error::{Error, Result, shown};
use serde::{Deserialize, Serialize};
use std::io::{self, Read, Write};
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

    /// Reads a journal; what the system refuses is no damage.
    fn read(path: &Path) -> Result<Self> {
        let refused = |e: io::Error| match regular::is_other(&e) {
            true => damaged(path),
            false => Error::io(path, "read", e),
        };
        let mut bytes = Vec::new();
        let file = regular::open(path).map_err(refused)?;
        file.take(LARGEST + 1).read_to_end(&mut bytes).map_err(refused)?;
        let small = bytes.len() as u64 <= LARGEST;
        small.then(|| Self::parse(&bytes)).flatten().ok_or_else(|| damaged(path))
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

    /// Its entries with the files that they are about, all of them in `folder`; `None`: a link leads elsewhere.
    fn targets(&self, folder: &Path) -> Option<Vec<(&Entry, PathBuf)>> {
        let folder = std::fs::canonicalize(folder).ok()?;
        let target = |e: &Entry| {
            let target = links::target_of(&folder.join(ours(&e.target)?));
            (std::fs::canonicalize(folder_of(&target)).ok()? == folder).then_some(target)
        };
        self.files.iter().map(|e| Some((e, target(e)?))).collect()
    }

    /// Does what is left to do, or takes back what was done. `false`: nothing was done, as it is damaged.
    fn finish(&self, folder: &Path, towards: Towards) -> io::Result<bool> {
        let Some(targets) = self.targets(folder) else { return Ok(false) };
        let whole = |target: &Path, e: &Entry, new: &str| {
            let meta = std::fs::symlink_metadata(folder_of(target).join(new));
            meta.map_or(true, |m| m.is_file() && m.len() == e.bytes) // not there: it has its name already
        };
        let towards_result = towards == Towards::Result || is_complete(&targets);
        let forward = !self.back
            && towards_result
            && targets.iter().all(|(e, target)| e.new.as_deref().is_none_or(|n| whole(target, e, n)));
        for (entry, target) in &targets {
            let here = folder_of(target);
            match (&entry.new, &entry.old) {
                (Some(new), _) if forward => rename(&here.join(new), target)?,
                (None, _) if forward => remove(&here.join(ours(&entry.target).unwrap_or_default()))?,
                (_, Some(old)) => rename(&here.join(old), target)?,
                // it has its name: nothing stood there before
                (Some(new), None) if !here.join(new).exists() => remove(target)?,
                _ => {}
            }
        }
        for (entry, target) in &targets {
            for left in entry.old.iter().chain(&entry.new) {
                let _ = remove(&folder_of(target).join(left));
            }
        }
        Ok(true)
    }
}

/// Whether nothing is left to do.
fn is_complete(targets: &[(&Entry, PathBuf)]) -> bool {
    targets.iter().all(|(entry, target)| match &entry.new {
        Some(new) => !folder_of(target).join(new).exists(),
        None => std::fs::symlink_metadata(target).is_err(),
    })
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
        let journal = Journal::read(path)?;
        let done = journal.finish(folder, towards).map_err(|e| Error::io(path, "finish what it lists in", e))?;
        if !done {
            return Err(damaged(path));
        }
        std::fs::remove_file(path).map_err(|e| Error::io(path, "remove", e))?;
        notice::report(Notice::ClearedUp(folder));
    }
    for old in temporary::named(folder, OLD) {
        let _ = std::fs::remove_file(old);
    }
    temporary::clean(folder);
    Ok(())
}

fn damaged(path: &Path) -> Error {
    Error::bad(
        crate::error::Place::file(shown(path)),
        "a journal that is damaged",
        "the journal of a run that was killed (check the programs next to it, then remove it)",
    )
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

    /// A folder `cell` with a program and a journal about `target`, and another folder beside it.
    #[cfg(unix)]
    fn with_journal(target: &str) -> (tempfile::TempDir, PathBuf) {
        let dir = tempfile::tempdir().unwrap();
        let cell = dir.path().join("cell");
        std::fs::create_dir(&cell).unwrap();
        std::fs::create_dir(dir.path().join("home")).unwrap();
        std::fs::write(cell.join("w.csv"), "w").unwrap();
        std::fs::write(dir.path().join("home/precious.csv"), "precious").unwrap();
        let entry = Entry { target: target.into(), new: Some(".lostmotion-q.part".into()), bytes: 0, old: None };
        let journal = Journal { schema: SCHEMA.into(), back: true, files: vec![entry] };
        std::fs::write(cell.join(".lostmotion-abcdefghij.journal"), serde_json::to_vec(&journal).unwrap()).unwrap();
        (dir, cell)
    }

    #[cfg(unix)]
    #[test]
    fn a_journal_whose_link_leads_out_of_its_folder_is_damaged_and_touches_nothing() {
        for link in ["../home/precious.csv", "../home/new.csv"] {
            let (dir, cell) = with_journal("x.csv");
            std::os::unix::fs::symlink(link, cell.join("x.csv")).unwrap();
            let refused = finish(&cell, Towards::Before).unwrap_err().to_string();
            assert!(refused.contains("a journal that is damaged"), "{refused}");
            assert_eq!(std::fs::read(dir.path().join("home/precious.csv")).unwrap(), b"precious");
            assert!(std::fs::symlink_metadata(cell.join("x.csv")).is_ok(), "the link stays");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_link_within_the_folder_is_followed_as_the_run_did_that_wrote_the_journal() {
        let (_dir, cell) = with_journal("x.csv");
        std::os::unix::fs::symlink("w.csv", cell.join("x.csv")).unwrap();
        finish(&cell, Towards::Before).unwrap();
        assert!(!cell.join("w.csv").exists(), "nothing stood there before");
        assert!(std::fs::symlink_metadata(cell.join("x.csv")).is_ok());
    }
}
