//! Files that are not in place yet.
//!
//! A temporary file stands in the folder of its target under a name that no other run has (`.lostmotion-` and random letters, so
//! the target's own bytes play no part), and its process holds a lock on it. The lock ends with the process, however that ends: a
//! file without one was left by a run that was killed, and the next run that writes into the folder takes it away ([`clean`]).

use super::folder;
use super::regular;
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{File, OpenOptions, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::TempPath;

/// Ending of a journal: what the next run needs to finish an interrupted one.
pub const JOURNAL: &str = ".journal";

/// How the names of all files begin that are no result.
pub const PREFIX: &str = ".lostmotion-";
/// The end of the name of a file that is not in place yet.
pub const PART: &str = ".part";
/// The end of the name of a file that was in place before.
pub const OLD: &str = ".old";
const RANDOM: usize = 10;
/// Names that are tried before a file is given up.
const TRIES: usize = 8;

/// Temporary files of this process, for [`discard`].
static OPEN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn open_files() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    OPEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Takes away what is not in place: for a process that receives a signal to stop.
pub fn discard() {
    for path in open_files().iter() {
        if std::fs::remove_file(path).is_err() {
            let _ = std::fs::remove_dir_all(path);
        }
    }
}

/// A folder among the temporary files of the system, for copies; dropped, it is gone with all in it.
#[cfg(feature = "cloud")]
#[derive(Debug)]
pub struct TemporaryFolder(tempfile::TempDir);

#[cfg(feature = "cloud")]
impl TemporaryFolder {
    /// Makes an empty one.
    pub fn create() -> io::Result<Self> {
        let folder = tempfile::Builder::new().prefix(PREFIX).tempdir()?;
        open_files().insert(folder.path().to_path_buf());
        Ok(Self(folder))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.0.path()
    }
}

#[cfg(feature = "cloud")]
impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        open_files().remove(self.0.path());
    }
}

/// A temporary file; dropped, it is gone.
#[derive(Debug)]
pub struct Temporary {
    path: Option<TempPath>,
    /// As listed in [`OPEN`].
    listed: PathBuf,
}

impl Temporary {
    /// Makes a file in `folder` and locks it.
    pub fn create(folder: &Path, mode: Option<u32>) -> io::Result<(File, Self)> {
        let options = options(mode.unwrap_or(PRIVATE));
        for _ in 0..TRIES {
            // not by `tempfile` itself, whose errors have the name of the temporary file, which tells nobody anything
            let (file, path) = builder(PART).make_in(folder, |path| options.open(path))?.into_parts();
            match file.try_lock() {
                // another run took the file for one that was left, between its making and its locking
                Err(TryLockError::WouldBlock) => continue,
                // a file system without locks: then nothing takes it for one that was left either
                Err(TryLockError::Error(_)) | Ok(()) => {}
            }
            if is_gone(&file) {
                continue;
            }
            let listed = path.to_path_buf();
            open_files().insert(listed.clone());
            return Ok((file, Self { path: Some(path), listed }));
        }
        Err(io::Error::other("another run takes the temporary files away"))
    }

    /// Where the file lies until it is in place.
    pub fn path(&self) -> &Path {
        &self.listed
    }

    /// Renames it to `target`, whatever stands there.
    pub fn persist(mut self, target: &Path) -> io::Result<()> {
        let Some(path) = self.path.take() else { return Ok(()) };
        path.persist(target).map_err(|e| e.error) // the error drops the file
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        self.path.take();
        open_files().remove(&self.listed);
    }
}

/// Names of one kind.
pub fn builder(suffix: &str) -> tempfile::Builder<'static, '_> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(suffix).rand_bytes(RANDOM);
    builder
}

/// Mode of a file that nobody else may read.
const PRIVATE: u32 = 0o600;

/// A new file with a mode.
#[cfg(unix)]
fn options(mode: u32) -> OpenOptions {
    use std::os::unix::fs::OpenOptionsExt;
    let mut options = OpenOptions::new();
    options.read(true).write(true).create_new(true).mode(mode);
    options
}

#[cfg(not(unix))]
fn options(_: u32) -> OpenOptions {
    let mut options = OpenOptions::new();
    options.read(true).write(true).create_new(true);
    options
}

#[cfg(unix)]
fn is_gone(file: &File) -> bool {
    use std::os::unix::fs::MetadataExt;
    file.metadata().is_ok_and(|m| m.nlink() == 0)
}

#[cfg(not(unix))]
fn is_gone(_: &File) -> bool {
    false
}

/// Whether a name is that of a file which is no result.
pub fn is_ours(name: &OsStr) -> bool {
    name.as_encoded_bytes().starts_with(PREFIX.as_bytes())
}

/// Names in `folder` that begin as ours and end in `suffix`; none where the folder cannot be listed.
pub fn named(folder: &Path, suffix: &str) -> Vec<PathBuf> {
    let entries = folder::list(folder).unwrap_or_default();
    let ours = |name: &OsStr| is_ours(name) && name.as_encoded_bytes().ends_with(suffix.as_bytes());
    let mut found: Vec<PathBuf> = entries.into_iter().filter(|e| ours(&e.0)).map(|e| folder.join(e.0)).collect();
    found.sort();
    found
}

/// Takes away what a run that was killed left in `folder`; files that a journal needs stay.
pub fn clean(folder: &Path) {
    for path in named(folder, PART) {
        let Ok(file) = regular::open_unlinked(&path) else { continue };
        // the process that made it has ended, and any journal has its last form
        if file.try_lock().is_ok() && named(folder, JOURNAL).is_empty() {
            let _ = std::fs::remove_file(&path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_was_left_is_taken_away_and_one_that_is_written_stays() {
        let dir = tempfile::tempdir().unwrap();
        let left = dir.path().join(".lostmotion-abcdefghij.part");
        std::fs::write(&left, "half").unwrap();
        let (_file, mine) = Temporary::create(dir.path(), None).unwrap();
        let foreign = dir.path().join("mine.part");
        std::fs::write(&foreign, "whole").unwrap();
        clean(dir.path());
        assert!(!left.exists() && mine.path().exists() && foreign.exists());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn an_error_is_that_of_the_system_without_the_name_of_the_temporary_file() {
        let refused = Temporary::create(Path::new("/proc"), None).unwrap_err();
        assert!(refused.raw_os_error().is_some() && !refused.to_string().contains(PREFIX), "{refused}");
    }

    #[test]
    fn what_a_journal_needs_stays() {
        let dir = tempfile::tempdir().unwrap();
        let left = dir.path().join(".lostmotion-abcdefghij.part");
        std::fs::write(&left, "half").unwrap();
        std::fs::write(dir.path().join(".lostmotion-klmnopqrst.journal"), "{}").unwrap();
        clean(dir.path());
        assert!(left.exists());
    }
}
