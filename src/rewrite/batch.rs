//! A folder tree of programs: several at a time, each by itself; one bad file stops nothing else.
//!
//! Programs are the files that end in `.csv`; the tree below the input folder appears again below the output folder. The
//! summary is in the order of the paths, whatever finished first.

use super::job::{Job, Target};
use super::stream::guard::is_note;
use super::summary::Line;
use crate::error::{Error, Place, Result};
use crate::io::input;
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// The programs below `folder`, relative to it, sorted; `but` (the output folder) is left out, links to folders too.
pub fn programs(folder: &Path, but: &Path) -> Result<Vec<PathBuf>> {
    let but = std::fs::canonicalize(but).ok();
    let mut found = Vec::new();
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
            } else if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"))
                && !is_note(&path)
                && path.is_file()
                && let Ok(relative) = path.strip_prefix(folder)
            {
                found.push(relative.to_path_buf());
            }
        }
    }
    found.sort();
    if found.is_empty() {
        return Err(Error::bad(Place::file(folder.display().to_string()), "no .csv file", "a folder with programs"));
    }
    Ok(found)
}

/// Rewrites every program of a folder; `done` hears of each as it finishes. The lines are in the order of `programs`.
pub fn run(
    job: &Job,
    folder: &Path,
    programs: &[PathBuf],
    output: Option<&Path>,
    done: &(dyn Fn() + Sync),
) -> Vec<Line> {
    let one = |relative: &PathBuf| {
        let from = folder.join(relative);
        let line = match one(job, &from, output.map(|o| o.join(relative))) {
            Ok(line) => line,
            Err(e) => Line::failed(from.display().to_string(), &e, hash(&from)),
        };
        done();
        line
    };
    programs.par_iter().map(one).collect()
}

fn one(job: &Job, from: &Path, to: Option<PathBuf>) -> Result<Line> {
    let Some(to) = to else {
        return Ok(Line::of(&job.run(from, Target::DryRun, &|_| {})?));
    };
    if let Some(parent) = to.parent() {
        std::fs::create_dir_all(parent).map_err(|e| Error::io(parent, "make", e))?;
    }
    Ok(Line::of(&job.run(from, Target::File(&to), &|_| {})?))
}

/// SHA-256 of a file that could not be used, where it can be read.
fn hash(path: &Path) -> Option<String> {
    let mut file = std::fs::File::open(path).ok()?;
    let mut hash = Sha256::new();
    std::io::copy(&mut file, &mut hash).ok()?;
    Some(input::hex(&hash.finalize()))
}
