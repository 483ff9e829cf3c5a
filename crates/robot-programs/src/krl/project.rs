//! The project around a KRL program: which files declare what is known to every module.
//!
//! `$config.dat` declares for all modules, a data list with `PUBLIC` what it calls `GLOBAL`. They are looked for where a controller
//! keeps them: `$config.dat` in `System` beside or above the program's folder, or in that folder itself, and data lists in the tree
//! that hangs on it (`Program`, `System`); without one, in the folder of the program alone. Programs of that tree are read for
//! what they assign to such points. Nothing of it is ever written.

use crate::files::of_folder;
use std::path::{Path, PathBuf};

/// Folders above a program that are looked at.
const LEVELS: usize = 8;
/// Most files of a project's tree.
const MOST: usize = 400;
/// Most files of a folder that is taken for a project.
const MOST_BESIDE: usize = 64;
/// Deepest folder of a tree.
const DEEPEST: usize = 8;

/// The other files of the project of the program at `path`, whose own data lists are `own`.
pub(super) fn files(path: &Path, own: &[PathBuf]) -> Vec<PathBuf> {
    let Some(folder) = path.parent() else { return Vec::new() };
    let mut all = match root(folder) {
        Some(root) => {
            let mut all = Vec::new();
            for part in ["Program", "System", "PROGRAM", "SYSTEM"] {
                tree(&root.join(part), 0, &mut all);
            }
            all
        }
        None => of_folder(folder, MOST_BESIDE),
    };
    all.retain(|p| is_module(p) && p != path && !own.contains(p));
    all.sort();
    all.dedup();
    if all.len() > MOST { Vec::new() } else { all }
}

/// `R1` of a controller's files: the folder above that has `System/$config.dat`.
fn root(folder: &Path) -> Option<PathBuf> {
    let above = folder.ancestors().take(LEVELS).filter(|a| !a.as_os_str().is_empty());
    above.into_iter().find(|a| is_configured(a)).map(Path::to_path_buf)
}

fn is_configured(root: &Path) -> bool {
    ["System/$config.dat", "System/$CONFIG.DAT", "SYSTEM/$CONFIG.DAT", "System/$Config.dat"]
        .iter()
        .any(|name| root.join(name).is_file())
}

fn is_module(path: &Path) -> bool {
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    ending.is_some_and(|e| matches!(e.as_str(), "dat" | "src" | "sub"))
}

/// Modules of a folder and of those in it.
fn tree(folder: &Path, depth: usize, all: &mut Vec<PathBuf>) {
    if depth > DEEPEST || all.len() > MOST {
        return;
    }
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        match entry.file_type() {
            Ok(t) if t.is_dir() => tree(&entry.path(), depth + 1, all),
            Ok(t) if t.is_file() && is_module(&entry.path()) => all.push(entry.path()),
            _ => {}
        }
    }
}
