//! Outputs that belong together come into place together, or none does.
//!
//! Method: every output is whole in its temporary file before the first rename. What a rename would replace is kept under a second
//! name (a hard link). Where a step fails, those before it are taken back, so that an error means that nothing was written. Where
//! the process ends between two renames, a [`journal`], written before the first one, lets the next run finish. It is kept for
//! the files of one folder; a note stands before its program, and whatever stands in other folders (a summary, a page) follows.
//! Standard output comes last of all, as it cannot be taken back ([`super::streams`]); a signal that comes while its reader is waited
//! for takes the files back.
//!
//! New files of a run that holds their folder need no journal: the note that comes first shows what the program would be.

use super::folder::{folder_of, ignore_unsupported};
use super::interrupt;
use super::journal::{self, Journal, Towards};
use super::lock::{self, FolderLock, Sharing};
use super::notice::{self, Notice};
use super::output::{Durability, InFile, Output, Sink};
use super::streams::{self, Streams};
use super::temporary::{self, OLD};
use crate::error::{Error, Result, shown};
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::TempPath;

/// How long a commit waits for another run that has the folder.
const PATIENCE: Duration = Duration::from_secs(10);

enum Step {
    Put(Box<InFile>),
    Remove(PathBuf),
}

impl Step {
    fn target(&self) -> &Path {
        match self {
            Self::Put(file) => &file.target,
            Self::Remove(path) => path,
        }
    }

    fn is_new(&self) -> bool {
        matches!(self, Self::Put(file) if !file.replaces)
    }
}

/// Outputs and removals, in the order in which they come into place.
#[derive(Default)]
pub struct Transaction {
    outputs: Vec<Output>,
    removals: Vec<PathBuf>,
}

impl Transaction {
    /// Adds an output.
    pub fn put(&mut self, output: Output) {
        self.outputs.push(output);
    }

    /// Adds a file that is taken away once all outputs are in place.
    pub fn remove(&mut self, path: PathBuf) {
        self.removals.push(path);
    }

    /// Brings all bytes to disk, beside their targets.
    pub fn prepare(&mut self) -> Result<()> {
        self.outputs.iter_mut().try_for_each(Output::prepare)
    }

    /// Puts everything in place.
    ///
    /// # Errors
    /// Nothing is in place then, but for [`Error::Unfinished`], whose message says what is.
    pub fn commit(mut self) -> Result<()> {
        self.prepare()?;
        self.outputs.iter_mut().for_each(Output::look_again);
        self.outputs.iter().try_for_each(Output::refuse_other_kind)?;
        let replaced: Vec<String> =
            self.outputs.iter().filter(|o| o.tells_replaced()).map(|o| o.shown.clone()).collect();
        let synced = self.outputs.iter().any(|o| o.durability == Durability::Synced);
        let (mut steps, mut streams) = (Vec::new(), Vec::new());
        for output in self.outputs {
            match output.sink {
                Sink::File(file) => steps.push(Step::Put(file)),
                stream => streams.push((stream, output.shown)),
            }
        }
        steps.extend(self.removals.into_iter().map(Step::Remove));
        let no_signal = interrupt::placing();
        let folders = folders(&steps);
        let kept = steps.len() > 1 && (synced || !steps.iter().all(Step::is_new));
        let written = if kept { with_journal(steps, streams, synced) } else { in_order(steps, streams) };
        if synced && written.is_ok() {
            sync_folders(&folders);
        }
        drop(no_signal);
        if written.is_err() && interrupt::is_ending() {
            interrupt::wait_for_end();
        }
        if written.is_ok() && !replaced.is_empty() {
            notice::report(Notice::Replaced(&replaced));
        }
        written
    }
}

/// Steps that need no journal: one alone, or new files of a run that holds their folder.
fn in_order(steps: Vec<Step>, streams: Streams) -> Result<()> {
    let mut done: Vec<Done> = Vec::new();
    let keep_last = !streams.is_empty();
    let count = steps.len();
    for (k, step) in steps.into_iter().enumerate() {
        match take_step(step, keep_last || k + 1 < count) {
            Ok(d) => done.push(d),
            Err(e) => return Err(back(done, e)),
        }
    }
    streams::release(streams).map_err(|e| back(done, e))
}

/// Steps with a journal in the folder of the first of them: where its file is, whatever link it was named by.
fn with_journal(steps: Vec<Step>, streams: Streams, synced: bool) -> Result<()> {
    let home = steps.first().map(|s| folder_of(s.target()).to_path_buf()).unwrap_or_default();
    // one folder may be named in several ways
    let real = |folder: &Path| std::fs::canonicalize(folder).unwrap_or_else(|_| folder.to_path_buf());
    let real_home = real(&home);
    // a run that does not sync holds its folder as a whole, and one that holds it has seen to what was left there
    let ours = lock::is_ours(&home);
    let _lock = match synced && !ours {
        true => FolderLock::take(&home, Sharing::Alone, PATIENCE)?,
        false => None,
    };
    if synced && !ours {
        journal::finish_locked(&home, Towards::Before)?;
    }
    let mut backups = Vec::with_capacity(steps.len());
    for step in &steps {
        backups.push(backup(step).map_err(|e| Error::io(step.target(), "keep a copy of", e))?);
    }
    let entries = steps.iter().zip(&backups).filter(|(s, _)| real(folder_of(s.target())) == real_home);
    let entries = entries.map(|(step, old)| journal::Entry {
        target: name_of(step.target()),
        new: match step {
            Step::Put(file) => Some(name_of(file.temporary.path())),
            Step::Remove(_) => None,
        },
        bytes: match step {
            Step::Put(file) => file.bytes,
            Step::Remove(_) => 0,
        },
        old: old.as_ref().map(|o| name_of(o)),
    });
    let journal = Journal::new(entries.collect()).write(&home, synced)?;
    let mut done = Vec::with_capacity(steps.len());
    for (step, old) in steps.into_iter().zip(backups) {
        match one(step, old) {
            Ok(d) => done.push(d),
            Err(e) => return Err(back_with(journal, &home, done, e)),
        }
    }
    if let Err(e) = streams::release(streams) {
        return Err(back_with(journal, &home, done, e));
    }
    if synced {
        sync_folders(&[home]);
    }
    // the journal first: without it what was kept belongs to no run, and the next run removes it
    drop(journal);
    drop(done);
    Ok(())
}

/// Takes back what was done, then the journal that would do it again.
fn back_with(journal: journal::Written, home: &Path, done: Vec<Done>, e: Error) -> Error {
    match journal.turn_back(home) {
        Ok(journal) => {
            let e = back(done, e);
            if matches!(e, Error::Unfinished { .. }) {
                journal.keep();
            }
            e
        }
        Err(journal) => {
            let e = back(done, e);
            if matches!(e, Error::Unfinished { .. }) {
                journal.keep()
            } else {
                drop(journal)
            }
            e
        }
    }
}

/// What was put in place, and what stood there.
struct Done {
    target: PathBuf,
    old: Option<TempPath>,
    /// Nothing stood there.
    new: bool,
}

fn take_step(step: Step, keep: bool) -> Result<Done> {
    let old = match keep {
        true => backup(&step).map_err(|e| Error::io(step.target(), "keep a copy of", e))?,
        false => None,
    };
    one(step, old)
}

fn one(step: Step, old: Option<TempPath>) -> Result<Done> {
    let target = step.target().to_path_buf();
    let new = step.is_new();
    match step {
        Step::Put(file) => {
            let InFile { writer, temporary, target, .. } = *file;
            // open, and so locked, until it has its name
            let result = temporary.persist(&target);
            drop(writer);
            result.map_err(|e| Error::io(&target, "replace", e))?;
        }
        Step::Remove(path) => match std::fs::remove_file(&path) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(Error::io(&path, "remove", e)),
            _ => {}
        },
    }
    Ok(Done { target, old, new })
}

/// Takes back what was done; the error is that of the step that failed, or of one that could not be taken back.
fn back(done: Vec<Done>, e: Error) -> Error {
    let mut left = Vec::new();
    for d in done.into_iter().rev() {
        let result = match d.old {
            Some(old) => old.persist(&d.target).map_err(|e| {
                let _ = e.path.keep(); // the journal names it
                e.error
            }),
            None if d.new => std::fs::remove_file(&d.target),
            None => Ok(()),
        };
        if result.is_err_and(|e| e.kind() != io::ErrorKind::NotFound) {
            left.push(shown(&d.target));
        }
    }
    match left.is_empty() {
        true => e,
        false => Error::Unfinished { files: left.join(", "), source: Box::new(e) },
    }
}

/// A second name for what a step replaces.
fn backup(step: &Step) -> io::Result<Option<TempPath>> {
    let target = step.target();
    if step.is_new() {
        return Ok(None);
    }
    let mut absent = false;
    let made = temporary::builder(OLD).make_in(folder_of(target), |path| match std::fs::hard_link(target, path) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            absent = true;
            Err(e)
        }
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists => Err(e),
        // a file system without links
        Err(_) => copy(target, path),
        Ok(()) => Ok(()),
    });
    match made {
        Err(_) if absent => Ok(None),
        made => made.map(|m| Some(m.into_temp_path())),
    }
}

fn copy(from: &Path, to: &Path) -> io::Result<()> {
    let mut out = File::options().write(true).create_new(true).open(to)?;
    io::copy(&mut File::open(from)?, &mut out)?;
    out.set_permissions(std::fs::metadata(from)?.permissions())?;
    out.sync_all().or_else(ignore_unsupported)
}

/// The name of a file in its folder, as text.
fn name_of(path: &Path) -> String {
    super::name::text_of_name(path.file_name().unwrap_or_default())
}

fn folders(steps: &[Step]) -> Vec<PathBuf> {
    let mut all: Vec<PathBuf> = steps.iter().map(|s| folder_of(s.target()).to_path_buf()).collect();
    all.sort();
    all.dedup();
    all
}

/// Forces the names in folders to disk. What they name is in place and whole, so that a failure is a word, no more.
#[cfg(unix)]
fn sync_folders(folders: &[PathBuf]) {
    for folder in folders {
        let synced = File::open(folder).and_then(|f| f.sync_all().or_else(ignore_unsupported));
        if let Err(e) = synced {
            notice::report(Notice::NotSynced(folder, &e));
        }
    }
}

#[cfg(not(unix))]
fn sync_folders(_: &[PathBuf]) {}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn a_file_that_came_since_the_output_was_made_is_of_its_kind_or_stays() {
        let dir = tempfile::tempdir().unwrap();
        let target = dir.path().join("summary.jsonl");
        let mut output = Output::create(&target).unwrap();
        output.write_all(b"{\"input\": \"w.csv\"}\n").unwrap();
        std::fs::write(&target, "{\"schema\": \"lostmotion/rewritten/1\"}").unwrap();
        assert!(output.commit().unwrap_err().is_bad_input());
        assert!(std::fs::read_to_string(&target).unwrap().contains("rewritten"));
    }
}
