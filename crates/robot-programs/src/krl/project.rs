//! The project around a KRL program: which files declare what is known to every module.
//!
//! `$config.dat` declares for all modules, a data list with `PUBLIC` what it calls `GLOBAL`. They are looked for where a controller
//! keeps them: `$config.dat` in `System` beside or above the program's folder, or in that folder itself, and data lists in the whole
//! tree below the folder that has it; without one, in the folder of the program alone, which tells no values then. Programs of that tree
//! are read for what they assign to such points. A tree that is not read as a whole tells no values. Nothing of it is ever written.

use crate::files::{Folders, of_folder};
use crate::script::Text;
use std::path::{Path, PathBuf};

/// Folders above a program that are looked at.
const LEVELS: usize = 8;
/// Most files of a project's tree.
const MOST: usize = 400;
/// Most files of a folder that is taken for a project.
const MOST_BESIDE: usize = 64;
/// Largest file of a project, bytes.
const LARGEST: usize = 16 << 20;
/// Deepest folder of a tree.
const DEEPEST: usize = 8;

/// The other files of the project of the program at `path`, whose own data list `own` tells among those that are there. None where
/// there are too many: then it is not known what assigns a point of all modules.
pub(super) fn files(
    path: &Path,
    own: impl Fn(&dyn Fn(&Path) -> bool) -> Option<PathBuf>,
    seen: &Folders,
) -> Vec<PathBuf> {
    let Some(folder) = path.parent() else { return Vec::new() };
    let here = seen.of("krl", folder, || modules(folder));
    if here.is_empty() {
        return Vec::new();
    }
    let own = own(&|p| here.binary_search_by(|h| h.as_path().cmp(p)).is_ok());
    let others = || here.iter().filter(|p| *p != path && Some(*p) != own.as_ref());
    if others().count() > MOST { Vec::new() } else { others().cloned().collect() }
}

/// The modules of the project of the programs in a folder, sorted; none where there are more than are looked at.
fn modules(folder: &Path) -> Vec<PathBuf> {
    let mut all = match root(folder) {
        Some(root) => {
            let mut all = Vec::new();
            if !tree(&root, 0, &mut all) {
                return Vec::new();
            }
            all
        }
        None => of_folder(folder, MOST_BESIDE),
    };
    all.retain(|p| is_module(p));
    all.sort();
    all.dedup();
    all
}

/// `R1` of a controller's files: the folder above that has `System/$config.dat`; else the program's own, where that has it.
fn root(folder: &Path) -> Option<PathBuf> {
    let mut above = folder.ancestors().take(LEVELS).filter(|a| !a.as_os_str().is_empty());
    let beside = || ["$config.dat", "$CONFIG.DAT", "$Config.dat"].iter().any(|n| folder.join(n).is_file());
    let beside = || (!folder.as_os_str().is_empty() && beside()).then(|| folder.to_path_buf());
    above.find(|a| is_configured(a)).map(Path::to_path_buf).or_else(beside)
}

/// Whether a file of the project was read, and is of a size and a form that are understood.
pub(super) fn is_read(text: &Text) -> bool {
    // a text of two bytes a character has zeros
    let begin = text.bytes.get(..64).unwrap_or(&text.bytes);
    let wide = matches!(begin, [0xff, 0xfe, ..] | [0xfe, 0xff, ..]) || begin.contains(&0);
    !text.unread && !wide && text.bytes.len() <= LARGEST
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

/// Modules of a folder and of those in it; `false`: there is more than is looked at.
fn tree(folder: &Path, depth: usize, all: &mut Vec<PathBuf>) -> bool {
    if depth > DEEPEST || all.len() > MOST {
        return false;
    }
    let Ok(entries) = std::fs::read_dir(folder) else { return false };
    for entry in entries {
        let Ok(entry) = entry else { return false };
        let path = entry.path();
        match entry.file_type() {
            Ok(t) if t.is_dir() => {
                if !tree(&path, depth + 1, all) {
                    return false;
                }
            }
            Ok(t) if t.is_file() => all.extend(Some(path).filter(|p| is_module(p))),
            // a link to a file is one; where a link to a folder leads is not followed
            _ if path.is_file() => all.extend(Some(path).filter(|p| is_module(p))),
            _ => return false,
        }
    }
    true
}
