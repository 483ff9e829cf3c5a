//! A folder tree of programs: several at a time, each by itself; one bad file stops nothing else.
//!
//! Programs are files whose ending is that of a format (where the ending is a general one, `.json` say, the content must be
//! that of a program); the tree below the input folder appears again below the output folder. The summary is in the order
//! of the paths, whatever finished first. A program that stands finished in the output folder, as its note says (same input,
//! files around it, compensator, options and version, and the very bytes that were written), is not done again: a run that was killed goes
//! on where it was, and ends with the same bytes as one that was not.

use super::apart::Apart;
use super::guard::{self, is_note};
use super::job::Job;
use super::outcome::Target;
use super::refusal::Refusal;
use super::summary::{Line, PathErrors, Status};
use crate::error::{Error, Place, Result, shown};
use crate::io::folder::{self, Kind};
use crate::io::input;
use crate::io::journal::{self, Towards};
use crate::io::lock::{self, FolderLock, LOCK, Sharing};
use crate::io::name::path_of;
use crate::io::notice::{self, Notice};
use crate::io::temporary;
use crate::numerics::parallel::ParMap;
use crate::program::files::Files;
use crate::program::formats::{self, Recognised};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// What lies below a folder.
#[derive(Debug, Default)]
pub struct Tree {
    /// The programs, relative to the folder, sorted.
    pub programs: Vec<PathBuf>,
    /// All files.
    pub files: Files,
    /// Folders that cannot be read, and why, sorted.
    pub unreadable: Vec<(PathBuf, String)>,
    /// Folders in which an interrupted run left a journal, sorted.
    pub interrupted: Vec<PathBuf>,
}

/// What lies below `root`; `but` (the output folder) is left out, links to folders too. A folder below it that cannot be read
/// stops nothing.
pub fn tree(root: &Path, but: &Path, format: Option<Recognised>) -> Result<Tree> {
    let but = std::fs::canonicalize(but).ok();
    let mut tree = Tree::default();
    let mut files = HashSet::new();
    let mut open = vec![root.to_path_buf()];
    while let Some(here) = open.pop() {
        let entries = match folder::list(&here) {
            Ok(entries) => entries,
            Err(e) if here == root => return Err(Error::io(&here, "list", e)),
            Err(e) => {
                tree.unreadable.push((here.clone(), Error::io(&here, "list", e).to_string()));
                continue;
            }
        };
        for (name, kind) in entries {
            let path = here.join(name);
            if kind == Kind::Folder {
                if but.is_none() || std::fs::canonicalize(&path).ok() != but {
                    open.push(path);
                }
            } else if kind == Kind::File || path.is_file() {
                if journal::is_journal(&path) {
                    tree.interrupted.push(here.clone());
                } else if !is_note(&path)
                    && formats::is_program(&path, format)
                    && let Ok(relative) = path.strip_prefix(root)
                {
                    tree.programs.push(relative.to_path_buf());
                }
                files.insert(path);
            }
        }
    }
    tree.programs.sort();
    tree.unreadable.sort();
    tree.interrupted.sort();
    tree.interrupted.dedup();
    if tree.programs.is_empty() && tree.unreadable.is_empty() {
        return Err(Error::bad(
            Place::file(shown(root)),
            "no program",
            format!("files that end in {}", formats::endings().join(", ")),
        ));
    }
    tree.files = Files::Listed(files);
    Ok(tree)
}

/// The lines of what cannot be read.
pub fn unreadable_lines(tree: &Tree) -> impl Iterator<Item = Line> + '_ {
    tree.unreadable.iter().map(|(path, why)| Line::unreadable(shown(path), why))
}

/// A folder of results that no other run writes into; dropped, it is free.
#[derive(Debug)]
pub struct Claim {
    _folder: Option<FolderLock>,
    _part: Option<FolderLock>,
}

/// Takes the folder of results `output` for a whole job, or for `part` (K, N) of it, beside the other parts. What an interrupted
/// run left there is finished, or taken away.
///
/// # Errors
/// Bad input where another run writes into the folder, into one above it or (for a whole job) into one below it.
pub fn claim(output: &Path, part: Option<(usize, usize)>) -> Result<Claim> {
    if let Some((k, n)) = part {
        return claim_part(output, &format!("{LOCK}-{k}-of-{n}"));
    }
    let folder = FolderLock::take(output, Sharing::Alone, Duration::ZERO)?;
    report_takeover(output, folder.as_ref());
    clear(output, folder.is_some())?;
    Ok(Claim { _folder: folder, _part: None })
}

/// A part looks through the folder only where a run was killed: the folder holds the results of all parts, and each would list them.
fn claim_part(output: &Path, name: &str) -> Result<Claim> {
    // another part may hold it
    let alone = match FolderLock::take(output, Sharing::Clearing, Duration::ZERO) {
        Ok(None) => {
            clear(output, false)?;
            return Ok(Claim { _folder: None, _part: None });
        }
        Ok(lock) => lock,
        Err(_) => None,
    };
    if alone.as_ref().is_some_and(|l| l.stale.is_some()) {
        report_takeover(output, alone.as_ref());
        clear(output, true)?;
        // of parts that were killed with it: nobody holds the folder
        for (name, _) in folder::list(output).unwrap_or_default() {
            if name.as_encoded_bytes().starts_with(LOCK.as_bytes()) && name != LOCK {
                let _ = std::fs::remove_file(output.join(name));
            }
        }
    }
    drop(alone);
    let folder = FolderLock::take(output, Sharing::Shared, Duration::from_secs(1))?;
    let part = FolderLock::take_named(output, name, Sharing::Alone, Duration::ZERO)?;
    if part.as_ref().is_some_and(|l| l.stale.is_some()) {
        clear(output, false)?;
    }
    Ok(Claim { _folder: folder, _part: part })
}

fn report_takeover(output: &Path, lock: Option<&FolderLock>) {
    if let Some(by) = lock.and_then(|l| l.stale.as_ref()) {
        notice::report(Notice::LockTakenOver(output, by));
    }
}

/// Finishes what a killed run left in `output` and the folders below it, where it is held alone; else only its temporary files go.
fn clear(output: &Path, alone: bool) -> Result<()> {
    let mut open = vec![output.to_path_buf()];
    while let Some(here) = open.pop() {
        if here != output
            && let Some(by) = lock::holder(&here.join(LOCK))
        {
            return Err(lock::busy(&here, &by));
        }
        let mut left = false;
        for (name, kind) in folder::list(&here).unwrap_or_default() {
            if kind == Kind::Folder {
                open.push(here.join(name));
            } else {
                left |= temporary::is_ours(&name);
            }
        }
        match alone {
            _ if !left => {}
            true => journal::finish_locked(&here, Towards::Before)?,
            false => temporary::clean(&here),
        }
    }
    Ok(())
}

/// Refuses a part whose programs go into folders that another run writes into.
///
/// # Errors
/// Bad input that names the other run.
pub fn refuse_busy_below(output: &Path, programs: &[PathBuf]) -> Result<()> {
    let below = programs.iter().flat_map(|p| p.ancestors().skip(1)).filter(|f| !f.as_os_str().is_empty());
    for folder in below.collect::<BTreeSet<&Path>>() {
        let here = output.join(folder);
        if let Some(by) = lock::holder(&here.join(LOCK)) {
            return Err(lock::busy(&here, &by));
        }
    }
    Ok(())
}

/// Where the results of a folder go.
#[derive(Debug, Clone, Copy)]
pub enum Results<'a> {
    /// Nowhere: a dry run.
    DryRun,
    /// Into this folder, under the names of the programs.
    Folder(&'a Path),
    /// They are compared with the files of this folder.
    Check(&'a Path),
}

/// Names and bytes of a rewritten program and of the files that belong to it.
pub type Texts = Vec<(String, Vec<u8>)>;

/// What a program that was rewritten does to its path.
#[derive(Debug)]
pub struct Judged {
    pub path_error: PathErrors,
    /// Why it must not be put in place.
    pub refused: Option<String>,
}

/// Works out the verdict on a program: its original, the number of its points, and what is written.
pub type Judge<'a> = dyn Fn(&Path, u64, &mut dyn FnMut() -> Result<Texts>) -> Option<Judged> + Sync + 'a;

/// Rewrites every program of a folder; `done` hears of each as it finishes. The lines are in the order of `programs`. A program that goes
/// into a folder is judged before it is put in place, and one that stands there from an earlier run as it stands.
pub fn run(
    job: &Job,
    folder: &Path,
    programs: &[PathBuf],
    results: Results,
    judge: Option<&Judge>,
    done: &(dyn Fn() + Sync),
) -> Vec<Line> {
    let shared = shared(folder, programs, &job.files);
    if let Results::Folder(output) = results {
        // the first program that needs a folder reports that it cannot be made
        let folders: BTreeSet<&Path> = programs.iter().filter_map(|p| p.parent()).collect();
        for folder in folders {
            let _ = std::fs::create_dir_all(output.join(folder));
        }
    }
    let apart = match results {
        Results::Folder(output) => Some(Apart::of(folder, programs, output, job.force)),
        Results::DryRun | Results::Check(_) => None,
    };
    let one = |relative: &PathBuf| {
        let from = folder.join(relative);
        let result = match shared.get(relative) {
            Some(with) => Err(Refusal::Shared { name: shown(&from), with: with.to_string() }.into()),
            None => apart_from(apart.as_ref(), &from, relative, results)
                .and_then(|()| one(job, &from, relative, results, judge)),
        };
        let line = match result {
            Ok(line) => line,
            Err(e) => Line::failed(shown(&from), &e, hash(&from)),
        };
        done();
        line
    };
    programs.par_map(one)
}

/// Programs that share a file with another one, and that file: which of them would be written last is not determined.
fn shared(folder: &Path, programs: &[PathBuf], there: &Files) -> BTreeMap<PathBuf, String> {
    let mut owners: BTreeMap<PathBuf, Vec<&PathBuf>> = BTreeMap::new();
    for program in programs {
        for companion in formats::companions(&folder.join(program), there) {
            owners.entry(companion).or_default().push(program);
        }
    }
    let several = owners.into_iter().filter(|(_, list)| list.len() > 1);
    several.flat_map(|(file, list)| list.into_iter().map(move |p| (p.clone(), shown(&file)))).collect()
}

/// Refuses a result that a link leads to a program, or to another result.
fn apart_from(apart: Option<&Apart>, from: &Path, relative: &Path, results: Results) -> Result<()> {
    match (apart, results) {
        (Some(apart), Results::Folder(output)) => apart.check(from, &output.join(relative)),
        _ => Ok(()),
    }
}

fn one(job: &Job, from: &Path, relative: &Path, results: Results, judge: Option<&Judge>) -> Result<Line> {
    let to = match results {
        Results::DryRun => return Ok(Line::of(&job.run(from, Target::DryRun, &|_| {})?)),
        Results::Check(golden) => {
            let golden = golden.join(relative);
            return match golden.is_file() {
                true => Ok(Line::of(&job.run(from, Target::Check(&golden), &|_| {})?)),
                false => Ok(Line::without_golden(shown(from), &shown(&golden), hash(from))),
            };
        }
        Results::Folder(output) => output.join(relative),
    };
    if let Some((line, files)) = finished(job, from, &to) {
        let mut texts = || files.iter().map(|f| Ok((shown(f), input::read(f)?.bytes.to_vec()))).collect();
        let judge = judge.filter(|_| line.status == Status::Written);
        let judged = judge.and_then(|j| j(from, line.moves, &mut texts));
        return Ok(Line { path_error: judged.map(|j| j.path_error), ..line });
    }
    let mut ready = job.prepare(from, Target::File(&to), &|_| {})?;
    let judge = judge.filter(|_| !ready.outcome.unchanged && ready.outcome.refusal.is_none());
    let judged = judge.and_then(|j| j(from, ready.outcome.points, &mut || ready.texts()));
    let (path_error, refused) = judged.map_or((None, None), |j| (Some(j.path_error), j.refused));
    if let Some(why) = refused {
        ready.refuse(why);
    }
    Ok(Line { path_error, ..Line::of(&ready.commit()?) })
}

/// The line of a program that was finished by an earlier run, and the files that it wrote; `None`: it has to be done.
fn finished(job: &Job, from: &Path, to: &Path) -> Option<(Line, Vec<PathBuf>)> {
    if job.force {
        return None;
    }
    let note = guard::read_note(to).ok().flatten()?; // a damaged one is none to rely on: it is done again
    let ours = note.version == env!("CARGO_PKG_VERSION")
        && note.compensator == job.source
        && note.options == job.said
        && note.robot.sha256 == job.robot.fingerprint();
    let stands = |name: &str, beside: &Path, sha256: &str| {
        let path = path_of(name).map(|n| beside.with_file_name(n));
        !sha256.is_empty() && path.is_some_and(|p| hash(&p).as_deref() == Some(sha256))
    };
    // a result of another program may stand under this name
    let is_of = |name: &str, file: &Path| path_of(name).is_some_and(|n| n.file_name() == file.file_name());
    let same = ours
        && is_of(&note.input, from)
        && is_of(&note.output, to)
        && stands(&note.input, from, note.sha256_in.as_deref()?)
        && stands(&note.output, to, &note.sha256_out)
        && note.companions.iter().all(|c| stands(&c.input, from, &c.sha256_in) && stands(&c.output, to, &c.sha256_out))
        && note.context == job.context_sum(from);
    let companions = note.companions.iter().filter_map(|c| Some(to.with_file_name(path_of(&c.output)?)));
    let files = std::iter::once(to.to_path_buf()).chain(companions).collect();
    let line = Line {
        key: None,
        input: shown(from),
        output: Some(shown(to)),
        status: if note.is_of_copy() { Status::Unchanged } else { Status::Written },
        reason: None,
        moves: note.moves,
        editable: note.editable,
        edited_as_joints: note.edited_as_joints,
        edited_as_poses: note.edited_as_poses,
        missing: None,
        reversals: note.reversals,
        inserted: note.inserted,
        path_error: None,
        sha256_in: note.sha256_in,
        sha256_out: Some(note.sha256_out),
        rewritten_by: None,
    };
    same.then_some((line, files))
}

/// SHA-256 of a file that could not be used, where it can be read.
pub(super) fn hash(path: &Path) -> Option<String> {
    read_hash(path).ok()
}

/// SHA-256 of a file.
pub(super) fn read_hash(path: &Path) -> std::io::Result<String> {
    let mut file = std::fs::File::open(path)?;
    let mut hash = Sha256::new();
    std::io::copy(&mut file, &mut hash)?;
    Ok(input::hex(&hash.finalize()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEFT: &str = ".lostmotion-abcdefghij.part";

    /// A folder of results with what a killed run left one folder down.
    fn left_over(locks: &[&str]) -> tempfile::TempDir {
        let dir = tempfile::tempdir().unwrap();
        std::fs::create_dir(dir.path().join("cell")).unwrap();
        std::fs::write(dir.path().join("cell").join(LEFT), "half").unwrap();
        for lock in locks {
            std::fs::write(dir.path().join(lock), "process 12345\n").unwrap();
        }
        dir
    }

    #[test]
    fn a_part_looks_through_the_folder_only_after_a_run_that_was_killed() {
        let own = format!("{LOCK}-2-of-3");
        let other = format!("{LOCK}-1-of-3");
        // locks that are left, and whether the part clears up and which locks of parts stay
        let cases: [(&[&str], bool, bool); 4] = [
            (&[], false, false),
            (&[LOCK], true, false),
            (&[LOCK, &other], true, false),
            (&[&own, &other], true, true), // the other part clears up when it runs again
        ];
        for (locks, clears, stays) in cases {
            let dir = left_over(locks);
            let claim = claim(dir.path(), Some((2, 3))).unwrap();
            assert_eq!(!dir.path().join("cell").join(LEFT).exists(), clears, "{locks:?}");
            assert_eq!(dir.path().join(&other).exists(), stays, "{locks:?}");
            drop(claim);
            assert!(!dir.path().join(LOCK).exists() && !dir.path().join(&own).exists());
        }
    }

    #[test]
    fn a_part_whose_programs_go_where_another_run_writes_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let programs = [PathBuf::from("a/b/p.src"), PathBuf::from("q.src")];
        refuse_busy_below(dir.path(), &programs).unwrap();
        std::fs::create_dir_all(dir.path().join("a")).unwrap();
        let file = std::fs::File::create(dir.path().join("a").join(LOCK)).unwrap();
        file.lock().unwrap();
        assert!(refuse_busy_below(dir.path(), &programs).is_err());
        assert!(refuse_busy_below(dir.path(), &programs[1..]).is_ok());
    }
}
