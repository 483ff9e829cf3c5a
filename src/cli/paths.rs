//! No command writes two results into one file, or a result over what it reads.

use crate::cli::exit::bad;
use crate::error::{Place, is_stdio, shown};
use crate::io::links;
use crate::program::formats;
use anyhow::Result;
use std::path::{Path, PathBuf};

/// A file of the command line and the option that names it.
pub type Named<'a> = (&'a str, Option<&'a Path>);

/// Refuses an output that is the same file as one of `inputs`, or as an output before it.
pub fn refuse_shared(inputs: &[Named], outputs: &[Named]) -> Result<()> {
    let mut taken: Vec<(&str, PathBuf)> = Vec::new();
    for (option, path) in inputs.iter().filter_map(|(o, p)| p.map(|p| (*o, p))) {
        if let Some(file) = real(path).filter(|_| !is_stdio(path)) {
            taken.push((option, file));
        }
    }
    let reads_stdin = inputs.iter().any(|(_, p)| p.is_some_and(is_stdio));
    for (option, path) in outputs.iter().filter_map(|(o, p)| p.map(|p| (*o, p))) {
        if reads_stdin && is_standard_input(path) {
            let expected = "another file: the one that is read would be lost";
            return Err(bad(Place::file(option), "the same file as standard input", expected));
        }
        let Some(file) = real(path) else { continue };
        if let Some((other, _)) = taken.iter().find(|(_, f)| *f == file) {
            if is_stdio(path) {
                let found = format!("standard output, which {other} uses");
                return Err(bad(Place::file(option), found, "a file"));
            }
            return Err(bad(Place::file(option), format!("the same file as {other}"), "a separate file"));
        }
        taken.push((option, file));
    }
    Ok(())
}

/// Refuses outputs into folders that are not there, or named as folders, before anything is computed.
pub fn refuse_missing_folders(outputs: &[Named]) -> Result<()> {
    for (option, path) in outputs.iter().filter_map(|(o, p)| p.map(|p| (*o, p))) {
        if path.as_os_str().to_string_lossy().ends_with(std::path::is_separator) {
            return Err(bad(Place::file(option), format!("{}, the name of a folder", shown(path)), "a file"));
        }
        let folder = path.parent().filter(|f| !is_stdio(path) && !f.as_os_str().is_empty());
        if let Some(folder) = folder.filter(|f| !f.is_dir()) {
            let found = format!("{} in a folder that does not exist, {}", shown(path), shown(folder));
            return Err(bad(Place::file(option), found, "an existing folder"));
        }
    }
    Ok(())
}

/// Refuses a table under the name of a vendor's program: a controller would be given CSV as RAPID.
pub fn refuse_program_ending(option: &str, path: Option<&Path>) -> Result<()> {
    const GENERAL: [&str; 5] = ["csv", "txt", "json", "yaml", "yml"];
    let Some((path, ending)) = path.and_then(|p| Some((p, formats::ending(p)?))) else { return Ok(()) };
    if is_stdio(path) || GENERAL.contains(&ending.as_str()) || !formats::endings().contains(&ending.as_str()) {
        return Ok(());
    }
    let found = format!("{}, the name of a vendor's program", shown(path));
    Err(bad(Place::file(option), found, "a name for a table, such as .csv (the output is CSV)"))
}

/// Whether both are one regular file.
pub fn same(a: &Path, b: &Path) -> bool {
    !is_stdio(a) && !is_stdio(b) && real(a).is_some_and(|a| real(b) == Some(a))
}

/// Whether standard input is the regular file at `path`, by whatever name.
#[cfg(unix)]
fn is_standard_input(path: &Path) -> bool {
    use std::os::fd::AsFd;
    use std::os::unix::fs::MetadataExt;
    let input = std::io::stdin().as_fd().try_clone_to_owned();
    let input = input.and_then(|fd| std::fs::File::from(fd).metadata());
    match (input, std::fs::metadata(path)) {
        (Ok(a), Ok(b)) => a.is_file() && !is_stdio(path) && (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => false,
    }
}

#[cfg(not(unix))]
fn is_standard_input(_: &Path) -> bool {
    false
}

/// Where a path leads, whether or not the file is there; `None`: a FIFO, `/dev/null`, a folder, a path to nowhere.
fn real(path: &Path) -> Option<PathBuf> {
    if is_stdio(path) {
        return Some(path.to_path_buf());
    }
    if std::fs::metadata(path).is_ok_and(|m| !m.is_file()) {
        return None; // the name of a descriptor leads to no other name
    }
    match std::fs::canonicalize(path) {
        Ok(real) => Some(real).filter(|r| r.is_file()),
        Err(_) => links::real(path),
    }
}
