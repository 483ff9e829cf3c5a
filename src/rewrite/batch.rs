//! A folder tree of programs: several at a time, each by itself; one bad file stops nothing else.
//!
//! Programs are files whose ending is that of a format (where the ending is a general one, `.json` say, the content must be
//! that of a program); the tree below the input folder appears again below the output folder. The summary is in the order
//! of the paths, whatever finished first. A program that stands finished in the output folder, as its note says (same input,
//! compensator, options and version, and the very bytes that were written), is not done again: a run that was killed goes
//! on where it was, and ends with the same bytes as one that was not.

use super::job::{Job, Target};
use super::stream::guard::{self, is_note};
use super::summary::{Line, Status};
use crate::error::{Error, Place, Result};
use crate::io::input;
use crate::program::files::Files;
use crate::program::formats::{self, Recognised};
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::path::{Path, PathBuf};

/// The programs below `folder`, relative to it, sorted, and all files that there are; `but` (the output folder) is left out,
/// links to folders too.
pub fn programs(folder: &Path, but: &Path, format: Option<Recognised>) -> Result<(Vec<PathBuf>, Files)> {
    let but = std::fs::canonicalize(but).ok();
    let mut found = Vec::new();
    let mut files = HashSet::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(here) = open.pop() {
        for entry in std::fs::read_dir(&here).map_err(|e| Error::io(&here, "list", e))? {
            let entry = entry.map_err(|e| Error::io(&here, "list", e))?;
            let path = entry.path();
            let kind = entry.file_type().map_err(|e| Error::io(&path, "look at", e))?;
            if kind.is_dir() {
                if but.is_none() || std::fs::canonicalize(&path).ok() != but {
                    open.push(path);
                }
            } else if kind.is_file() || path.is_file() {
                if !is_note(&path)
                    && formats::is_program(&path, format)
                    && let Ok(relative) = path.strip_prefix(folder)
                {
                    found.push(relative.to_path_buf());
                }
                files.insert(path);
            }
        }
    }
    found.sort();
    if found.is_empty() {
        return Err(Error::bad(
            Place::file(folder.display().to_string()),
            "no program",
            format!("files that end in {}", formats::endings().join(", ")),
        ));
    }
    Ok((found, Files::Listed(files)))
}

/// Rewrites every program of a folder; `done` hears of each as it finishes. The lines are in the order of `programs`.
pub fn run(
    job: &Job,
    folder: &Path,
    programs: &[PathBuf],
    output: Option<&Path>,
    done: &(dyn Fn() + Sync),
) -> Vec<Line> {
    let shared = shared(folder, programs, &job.files);
    if let Some(output) = output {
        // a folder that cannot be made is told by the first program that needs it
        let folders: BTreeSet<&Path> = programs.iter().filter_map(|p| p.parent()).collect();
        for folder in folders {
            let _ = std::fs::create_dir_all(output.join(folder));
        }
    }
    let one = |relative: &PathBuf| {
        let from = folder.join(relative);
        let result = match shared.get(relative) {
            Some(with) => Err(Error::Refused(format!(
                "{}: {with} belongs to another program of the folder, too; nothing was written",
                from.display()
            ))),
            None => one(job, &from, output.map(|o| o.join(relative))),
        };
        let line = match result {
            Ok(line) => line,
            Err(e) => Line::failed(from.display().to_string(), &e, hash(&from)),
        };
        done();
        line
    };
    programs.par_iter().map(one).collect()
}

/// Programs that share a file with another one, and that file: which of them would be written last is nobody's choice.
fn shared(folder: &Path, programs: &[PathBuf], there: &Files) -> BTreeMap<PathBuf, String> {
    let mut owners: BTreeMap<PathBuf, Vec<&PathBuf>> = BTreeMap::new();
    for program in programs {
        for companion in formats::companions(&folder.join(program), there) {
            owners.entry(companion).or_default().push(program);
        }
    }
    let several = owners.into_iter().filter(|(_, list)| list.len() > 1);
    several.flat_map(|(file, list)| list.into_iter().map(move |p| (p.clone(), file.display().to_string()))).collect()
}

fn one(job: &Job, from: &Path, to: Option<PathBuf>) -> Result<Line> {
    let Some(to) = to else {
        return Ok(Line::of(&job.run(from, Target::DryRun, &|_| {})?));
    };
    if let Some(line) = finished(job, from, &to) {
        return Ok(line);
    }
    Ok(Line::of(&job.run(from, Target::File(&to), &|_| {})?))
}

/// The line of a program that was finished by an earlier run; `None`: it has to be done.
fn finished(job: &Job, from: &Path, to: &Path) -> Option<Line> {
    if job.force {
        return None;
    }
    let note = guard::read_note(to)?;
    let ours = note.version == env!("CARGO_PKG_VERSION")
        && note.compensator == job.source
        && note.options == job.said
        && note.robot.sha256 == job.robot.fingerprint();
    let folder = |p: &Path| p.parent().map(Path::to_path_buf).unwrap_or_default();
    let stands = |name: &str, beside: &Path, sha256: &str| {
        !sha256.is_empty() && hash(&folder(beside).join(name)).as_deref() == Some(sha256)
    };
    let same = ours
        && stands(&note.input, from, note.sha256_in.as_deref()?)
        && stands(&note.output, to, &note.sha256_out)
        && note.companions.iter().all(|c| stands(&c.input, from, &c.sha256_in) && stands(&c.output, to, &c.sha256_out));
    same.then(|| Line {
        input: from.display().to_string(),
        output: Some(to.display().to_string()),
        status: Status::Written,
        reason: None,
        moves: note.moves,
        editable: note.editable,
        edited_as_joints: note.edited_as_joints,
        edited_as_poses: note.edited_as_poses,
        missing: None,
        reversals: note.reversals,
        inserted: note.inserted,
        sha256_in: note.sha256_in,
        sha256_out: Some(note.sha256_out),
    })
}

/// SHA-256 of a file that could not be used, where it can be read.
fn hash(path: &Path) -> Option<String> {
    let mut file = std::fs::File::open(path).ok()?;
    let mut hash = Sha256::new();
    std::io::copy(&mut file, &mut hash).ok()?;
    Some(input::hex(&hash.finalize()))
}
