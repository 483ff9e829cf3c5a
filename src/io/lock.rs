//! One run at a time writes into a folder.
//!
//! Method: a file `.lostmotion.lock` in the folder, locked by the operating system (flock) as long as the run lasts and then taken
//! away. A lock ends with its process, so that a file without a lock is stale, whatever its text. A folder is also taken where one
//! above it is, or one below it. On a file system that knows no locks, runs are not kept apart; each of their files still
//! appears whole, as no other process has its temporary name.
//!
//! The name may stand for a file of somebody else: a link, a second name of a file, other text. That file is not written to, and the
//! folder is refused.

use super::regular;
use crate::error::{Error, Place, Result, shown};
use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Name of the file in a folder that a run writes into.
pub const LOCK: &str = ".lostmotion.lock";
/// Between two looks at a lock that another run holds.
const AGAIN: Duration = Duration::from_millis(20);
/// Time that parts of a job give to one that clears up a folder of millions of files.
const CLEARED: Duration = Duration::from_secs(600);

/// Locks of this process, by path: they stand in its own way nowhere, and go with it.
static HELD: Mutex<BTreeMap<PathBuf, (Arc<File>, Sharing)>> = Mutex::new(BTreeMap::new());

fn held() -> std::sync::MutexGuard<'static, BTreeMap<PathBuf, (Arc<File>, Sharing)>> {
    HELD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Takes the lock files of this process away: for a process that receives a signal to stop.
pub fn discard() {
    for (path, (file, sharing)) in held().iter() {
        take_away(file, *sharing, path);
    }
}

/// While it is ours: who waits for this file finds that it is no longer the folder's. The last of several parts takes it away.
fn take_away(file: &File, sharing: Sharing, path: &Path) {
    let last = sharing != Sharing::Shared || file.unlock().is_ok() && file.try_lock().is_ok();
    if last && is_at(file, path) {
        let _ = std::fs::remove_file(path);
    }
}

/// Who else may hold the same lock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sharing {
    /// Nobody.
    Alone,
    /// Nobody, for as long as a part of a job clears up what a killed run left; the other parts wait.
    Clearing,
    /// Others that share it: parts of one job.
    Shared,
}

/// A folder into which no other run writes; dropped, it is free.
#[derive(Debug)]
pub struct FolderLock {
    path: PathBuf,
    file: Arc<File>,
    sharing: Sharing,
    /// What the run wrote that held the lock last and was killed.
    pub stale: Option<String>,
}

enum Tried {
    Got(FolderLock),
    Busy(String),
    /// The file was taken away in between.
    Again,
    Unsupported,
    /// What stands there is no lock.
    Foreign,
}

impl FolderLock {
    /// Takes a folder, waiting up to `patience` for another run. `None`: the file system knows no locks.
    ///
    /// # Errors
    /// Bad input that names the other run.
    pub fn take(folder: &Path, sharing: Sharing, patience: Duration) -> Result<Option<Self>> {
        Self::take_named(folder, LOCK, sharing, patience)
    }

    /// The same under the name of a part of a job.
    pub fn take_named(folder: &Path, name: &str, sharing: Sharing, patience: Duration) -> Result<Option<Self>> {
        let folder = std::fs::canonicalize(folder).map_err(|e| Error::io(folder, "open", e))?;
        let path = folder.join(name);
        let until = Instant::now() + patience;
        loop {
            let by = match try_take(&path, sharing).map_err(|e| Error::io(&path, "lock", e))? {
                Tried::Unsupported => return Ok(None),
                Tried::Foreign => return Err(foreign(&path)),
                Tried::Again => continue,
                Tried::Busy(by) => by,
                Tried::Got(lock) => match folder.ancestors().skip(1).find_map(|above| holder(&above.join(LOCK))) {
                    None => return Ok(Some(lock)),
                    Some(by) => by,
                },
            };
            let until = if sharing == Sharing::Shared && clears_up(&by) { until + CLEARED } else { until };
            if Instant::now() >= until {
                return Err(busy(&folder, &by));
            }
            std::thread::sleep(AGAIN);
        }
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        take_away(&self.file, self.sharing, &self.path);
        held().remove(&self.path);
    }
}

/// Whether this process holds a folder.
pub fn is_ours(folder: &Path) -> bool {
    std::fs::canonicalize(folder).is_ok_and(|folder| held().contains_key(&folder.join(LOCK)))
}

/// Whether the holder that a lock file states clears up for the parts of a job.
fn clears_up(by: &str) -> bool {
    by.ends_with(CLEARING)
}

/// The refusal of a folder that another run holds.
pub fn busy(folder: &Path, by: &str) -> Error {
    Error::bad(
        Place::file(shown(folder)),
        format!("another run of lostmotion that writes into this folder ({by})"),
        "a folder into which no other run writes (wait until the other run ends, or give another folder)",
    )
}

fn foreign(path: &Path) -> Error {
    Error::bad(
        Place::file(shown(path)),
        "a link, or a file that is no lock of lostmotion",
        "the lock file of a run, or none (remove it if nothing else needs it)",
    )
}

/// Who holds the lock file at `path`, where another process does.
pub fn holder(path: &Path) -> Option<String> {
    if held().contains_key(path) {
        return None;
    }
    let mut file = regular::open_unlinked(path).ok()?;
    match file.try_lock_shared() {
        Err(TryLockError::WouldBlock) => Some(says(&mut file)),
        _ => None,
    }
}

fn try_take(path: &Path, sharing: Sharing) -> io::Result<Tried> {
    let mut file = match regular::open_or_make_unlinked(path) {
        Err(e) if regular::is_other(&e) || is_link(path) => return Ok(Tried::Foreign),
        Err(e) if e.kind() == io::ErrorKind::PermissionDenied => return take_over(path).ok_or(e),
        file => file?,
    };
    let locked = match sharing {
        Sharing::Alone | Sharing::Clearing => file.try_lock(),
        Sharing::Shared => file.try_lock_shared(),
    };
    match locked {
        Err(TryLockError::WouldBlock) => return Ok(Tried::Busy(says(&mut file))),
        Err(TryLockError::Error(e)) if knows_no_locks(&e) => {
            // empty: made here
            if head(&mut file).is_ok_and(|h| h.is_empty()) && is_at(&file, path) {
                let _ = std::fs::remove_file(path);
            }
            return Ok(Tried::Unsupported);
        }
        Err(TryLockError::Error(e)) => return Err(e),
        Ok(()) => {}
    }
    if !is_at(&file, path) {
        return Ok(Tried::Again);
    }
    if has_other_names(&file) || !is_lock_text(&head(&mut file)?) {
        return Ok(Tried::Foreign);
    }
    let before = says(&mut file);
    let stale = (sharing != Sharing::Shared && before != UNKNOWN).then_some(before);
    file.set_len(0)?;
    file.seek(SeekFrom::Start(0))?;
    let does = if sharing == Sharing::Clearing { CLEARING } else { "" };
    file.write_all(format!("process {}{does}\n", std::process::id()).as_bytes())?;
    let file = Arc::new(file);
    held().insert(path.to_path_buf(), (Arc::clone(&file), sharing));
    Ok(Tried::Got(FolderLock { path: path.to_path_buf(), file, sharing, stale }))
}

/// Looks at a lock file that may be read but not written, as a run of another user left it. It is removed if no run holds it and the
/// folder allows that. `None`: it cannot be read or removed.
fn take_over(path: &Path) -> Option<Tried> {
    let mut file = regular::open_unlinked(path).ok()?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => return Some(Tried::Busy(says(&mut file))),
        Err(TryLockError::Error(e)) => return knows_no_locks(&e).then_some(Tried::Unsupported),
        Ok(()) => {}
    }
    if has_other_names(&file) || !is_lock_text(&head(&mut file).ok()?) {
        return Some(Tried::Foreign);
    }
    if is_at(&file, path) {
        std::fs::remove_file(path).ok()?;
    }
    Some(Tried::Again)
}

/// Whether the file system knows no locks, or has no service for them (NFS).
#[cfg(unix)]
fn knows_no_locks(e: &io::Error) -> bool {
    e.kind() == io::ErrorKind::Unsupported || e.raw_os_error() == Some(rustix::io::Errno::NOLCK.raw_os_error())
}

#[cfg(not(unix))]
fn knows_no_locks(e: &io::Error) -> bool {
    e.kind() == io::ErrorKind::Unsupported
}

const UNKNOWN: &str = "an unknown process";
/// What the lock file of a part states that clears up.
const CLEARING: &str = ", which clears up after a run that was killed";

/// Bytes that a lock file has at most.
const MOST: u64 = 200;

/// What a lock file states about its holder.
fn says(file: &mut File) -> String {
    let head = head(file).unwrap_or_default();
    match std::str::from_utf8(&head).map(str::trim) {
        Ok(text) if text.starts_with(PROCESS) && is_lock_text(&head) => crate::error::one_line(text),
        _ => UNKNOWN.into(),
    }
}

/// The first bytes of a file, one more than a lock has.
fn head(file: &mut File) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    file.seek(SeekFrom::Start(0))?;
    file.take(MOST + 1).read_to_end(&mut head)?;
    Ok(head)
}

/// How the text of a lock begins.
const PROCESS: &str = "process ";

/// Whether a text is that of a lock: one line about a process, or nothing where the process or the power ended before it was there.
fn is_lock_text(head: &[u8]) -> bool {
    let line = head.strip_suffix(b"\n").unwrap_or(head);
    let states = line.starts_with(PROCESS.as_bytes()) && !line.contains(&b'\n');
    head.len() as u64 <= MOST && (states || head.iter().all(|b| *b == 0))
}

fn is_link(path: &Path) -> bool {
    std::fs::symlink_metadata(path).is_ok_and(|m| m.is_symlink())
}

/// Whether a file has a second name: then it was not made here.
#[cfg(unix)]
fn has_other_names(file: &File) -> bool {
    use std::os::unix::fs::MetadataExt;
    file.metadata().is_ok_and(|m| m.nlink() > 1)
}

#[cfg(not(unix))]
fn has_other_names(_: &File) -> bool {
    false
}

/// The file is still the one at the path.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), std::fs::symlink_metadata(path)) {
        (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => false,
    }
}

#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    const AT_ONCE: Duration = Duration::ZERO;

    /// As another process holds it: by its own handle.
    fn foreign(folder: &Path) -> File {
        let file = File::create(folder.join(LOCK)).unwrap();
        (&file).write_all(b"process 12345\n").unwrap();
        file.lock().unwrap();
        file
    }

    #[test]
    fn a_folder_that_another_run_holds_is_refused_by_the_name_of_that_run() {
        let dir = tempfile::tempdir().unwrap();
        let other = foreign(dir.path());
        let refused = FolderLock::take(dir.path(), Sharing::Alone, AT_ONCE).unwrap_err().to_string();
        assert!(refused.contains("another run of lostmotion") && refused.contains("process 12345"), "{refused}");
        drop(other);
        let lock = FolderLock::take(dir.path(), Sharing::Alone, AT_ONCE).unwrap().unwrap();
        assert_eq!(lock.stale.as_deref(), Some("process 12345"), "its holder has ended");
        drop(lock);
        assert!(!dir.path().join(LOCK).exists());
    }

    #[test]
    fn a_folder_below_one_that_is_held_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let below = dir.path().join("below");
        std::fs::create_dir(&below).unwrap();
        let _other = foreign(dir.path());
        assert!(FolderLock::take(&below, Sharing::Alone, AT_ONCE).is_err());
    }

    #[test]
    fn parts_of_a_job_share_a_folder_that_a_whole_job_does_not_get() {
        let dir = tempfile::tempdir().unwrap();
        let part = FolderLock::take(dir.path(), Sharing::Shared, AT_ONCE).unwrap();
        let other = File::open(dir.path().join(LOCK)).unwrap();
        other.try_lock_shared().unwrap();
        drop(part);
        assert!(FolderLock::take(dir.path(), Sharing::Alone, AT_ONCE).is_err());
    }

    #[test]
    fn parts_of_a_job_wait_for_the_one_that_clears_up() {
        let dir = tempfile::tempdir().unwrap();
        let other = File::create(dir.path().join(LOCK)).unwrap();
        (&other).write_all(format!("process 12345{CLEARING}\n").as_bytes()).unwrap();
        other.lock().unwrap();
        assert!(FolderLock::take(dir.path(), Sharing::Alone, AT_ONCE).is_err(), "a whole job does not");
        let done = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(300));
            drop(other);
        });
        assert!(FolderLock::take(dir.path(), Sharing::Shared, AT_ONCE).unwrap().is_some());
        done.join().unwrap();
    }

    /// What may stand at the name of the lock: the name of a file with `text`, a link to it, a second name of it.
    #[cfg(unix)]
    #[test]
    fn a_file_that_is_no_lock_is_neither_written_to_nor_shown() {
        type Make = fn(&Path, &Path) -> io::Result<()>;
        let link: Make = |file, lock| std::os::unix::fs::symlink(file, lock);
        let second: Make = |file, lock| std::fs::hard_link(file, lock);
        let itself: Make = |file, lock| std::fs::rename(file, lock);
        let long = format!("process {}\n", "1".repeat(300));
        for (text, make) in [
            ("0,1,2\n", link),
            ("process 12345\n", link),
            ("process 12345\n", second),
            ("0,1,2\n", itself),
            ("process 12345\n0,1,2\n", itself),
            (&long, itself),
        ] {
            let dir = tempfile::tempdir().unwrap();
            let (file, lock) = (dir.path().join("precious.csv"), dir.path().join(LOCK));
            std::fs::write(&file, text).unwrap();
            make(&file, &lock).unwrap();
            let refused = FolderLock::take(dir.path(), Sharing::Alone, AT_ONCE).unwrap_err().to_string();
            assert!(refused.contains("no lock of lostmotion") && !refused.contains("0,1,2"), "{refused}");
            assert_eq!(std::fs::read(&lock).unwrap(), text.as_bytes());
        }
    }

    #[test]
    fn a_lock_whose_text_was_lost_is_one() {
        for text in ["", "\0\0\0\0", "process 1", "process 12345, which clears up after a run that was killed\n"] {
            let dir = tempfile::tempdir().unwrap();
            std::fs::write(dir.path().join(LOCK), text).unwrap();
            assert!(FolderLock::take(dir.path(), Sharing::Alone, AT_ONCE).unwrap().is_some(), "{text}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_fifo_is_no_lock_and_nobody_waits_for_it() {
        let dir = tempfile::tempdir().unwrap();
        let below = dir.path().join("below");
        std::fs::create_dir(&below).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(dir.path().join(LOCK)).status().unwrap().success());
        assert!(FolderLock::take(&below, Sharing::Alone, AT_ONCE).unwrap().is_some());
        assert!(FolderLock::take(dir.path(), Sharing::Alone, AT_ONCE).is_err());
    }
}
