//! Which files there are beside a program.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Which files there are.
#[derive(Debug, Clone, Default)]
pub enum Files {
    /// As the file system says.
    #[default]
    Disk,
    /// As a folder tree was listed: thousands of programs are not asked for one by one, under every name they may have.
    Listed(HashSet<PathBuf>),
}

impl Files {
    /// Whether there is a file of this name.
    pub fn has(&self, path: &Path) -> bool {
        match self {
            Self::Disk => path.is_file(),
            Self::Listed(files) => files.contains(path),
        }
    }
}

/// The files of a folder, in the order of their names; none where there are more than `most`.
pub fn of_folder(folder: &Path, most: usize) -> Vec<PathBuf> {
    let open = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let Ok(entries) = std::fs::read_dir(open) else { return Vec::new() };
    let mut files = Vec::new();
    for entry in entries.flatten() {
        // a link counts as what it leads to
        if entry.file_type().is_ok_and(|t| t.is_file() || t.is_symlink() && entry.path().is_file()) {
            files.push(folder.join(entry.file_name()));
            if files.len() > most {
                return Vec::new();
            }
        }
    }
    files.sort();
    files
}

/// Lists of folders that are kept: those in which programs are being read.
const FOLDERS: usize = 64;

/// Files by who looked for them and where.
type Seen = HashMap<(&'static str, PathBuf), Arc<Vec<PathBuf>>>;

/// Stands for any program: its name is computed.
pub const ANY: &str = "*";

/// Programs that call another one, two at most, by the name of that one in upper case.
type Callers = BTreeMap<String, Vec<PathBuf>>;

/// What formats found in folders: thousands of programs of one folder look through it once. It holds for as long as it lives.
#[derive(Debug, Default)]
pub struct Folders {
    seen: Mutex<Seen>,
    callers: Mutex<HashMap<(&'static str, PathBuf), Arc<Callers>>>,
}

impl Folders {
    /// What `look` finds for the programs of `folder` under the word of the one who asks.
    pub fn of(&self, who: &'static str, folder: &Path, look: impl FnOnce() -> Vec<PathBuf>) -> Arc<Vec<PathBuf>> {
        // one that failed while it looked has left nothing after
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (who, folder.to_path_buf());
        if let Some(known) = seen.get(&key) {
            return Arc::clone(known);
        }
        if seen.len() >= FOLDERS {
            seen.clear();
        }
        let found = Arc::new(look());
        seen.insert(key, Arc::clone(&found));
        found
    }

    /// Whether one of the programs of a folder (`here`) that is not the one at `path` calls one of these names, in upper case, or one that
    /// is computed. `names`: what a program calls.
    pub fn calls(
        &self,
        (who, path): (&'static str, &Path),
        own: &[String],
        here: impl FnOnce(&Path) -> Vec<PathBuf>,
        names: impl Fn(&[u8]) -> BTreeSet<String>,
    ) -> bool {
        let Some(folder) = path.parent() else { return false };
        let mut known = self.callers.lock().unwrap_or_else(PoisonError::into_inner);
        if known.len() >= FOLDERS {
            known.clear();
        }
        let callers =
            known.entry((who, folder.to_path_buf())).or_insert_with(|| Arc::new(callers(here(folder), names)));
        let callers = Arc::clone(callers);
        drop(known);
        let any = callers.get(ANY).into_iter();
        own.iter().filter_map(|name| callers.get(name)).chain(any).flatten().any(|caller| caller != path)
    }
}

fn callers(here: Vec<PathBuf>, names: impl Fn(&[u8]) -> BTreeSet<String>) -> Callers {
    let mut all = Callers::new();
    for file in here {
        for name in names(&std::fs::read(&file).unwrap_or_default()) {
            let own = all.entry(name).or_default();
            if own.len() < 2 {
                own.push(file.clone());
            }
        }
    }
    all
}

/// Most programs that one may call, itself or by others.
const MOST_CALLED: usize = 256;

/// Files beside the program at `path` that hold what it calls (`open`), and what these call (`names`), all in upper case; `here`: the
/// programs of its folder.
pub fn called(
    path: &Path,
    mut open: BTreeSet<String>,
    names: impl Fn(&[u8]) -> BTreeSet<String>,
    here: impl FnOnce() -> Arc<Vec<PathBuf>>,
) -> Vec<PathBuf> {
    if open.is_empty() {
        return Vec::new();
    }
    let here = here();
    let (mut found, mut asked) = (BTreeSet::new(), BTreeSet::new());
    while let Some(name) = open.pop_first() {
        if found.len() >= MOST_CALLED || !asked.insert(name.clone()) {
            continue;
        }
        let stem = |p: &Path| p.file_stem().is_some_and(|s| s.eq_ignore_ascii_case(name.as_str()));
        for file in here.iter().filter(|p| stem(p) && *p != path) {
            open.extend(names(&std::fs::read(file).unwrap_or_default()));
            found.insert(file.clone());
        }
    }
    found.into_iter().collect()
}
