//! Programs of an object store: listed for a manifest, and brought to disk for a shard together with what is read beside them.
//!
//! A shard takes its programs in parts. Of each part the programs are copied below a separate folder, with what a run on disk would
//! read beside them: all modules or jobs of their folders (of `PROGMOD` and `SYSMOD` together), the project of a KRL program, the notes of
//! results. Files that are not read are there without their bytes, as readers count the files of a folder. So a program
//! comes out as it would in a folder on disk.

use super::batch;
use super::guard::{self, is_note, note_name};
use super::manifest::{Entry, State};
use crate::error::{Error, Place, Result, shown};
use crate::io::name::{path_of, text_of};
use crate::io::store::{Digest, Fetched, Store};
use crate::io::temporary::TemporaryFolder;
use crate::program::formats::{self, Recognised};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};

/// Bytes at the start of a program by which its format is recognised.
const HEAD: usize = 1 << 16;
/// Objects whose hashes are worked out before the next ones are asked for.
const LISTED: usize = 4096;
/// Folders above a KRL program that may hold its project, as its reader looks at them.
const LEVELS: usize = 8;
/// Modules of a project beyond which no reader looks at any of them.
const MOST_MODULES: usize = 2048;
/// Folders between the copies and the rest of the disk, so that no reader that looks above a program finds what lies there.
const APART: &str = "0/1/2/3/4/5/6/7";

/// The programs below the prefix of a store, in the order of their keys.
///
/// # Errors
/// The store fails, or has no program there.
pub fn entries(store: &Store, format: Option<Recognised>) -> Result<Vec<Entry>> {
    let name = |key: &str| formats::is_program_by_name(Path::new(key), format);
    let keys = store.list(&|key| !is_note(Path::new(key)) && name(key) != Some(false))?;
    let mut entries = Vec::new();
    for keys in keys.chunks(LISTED) {
        let locations: Vec<String> = keys.iter().filter_map(|k| store.location(Path::new(k))).collect();
        let digests = store.digests(&locations, HEAD)?;
        entries.extend(keys.iter().zip(digests).filter_map(|(key, got)| entry(key, got, format)));
    }
    if entries.is_empty() {
        let expected = format!("objects that end in {}", formats::endings().join(", "));
        return Err(Error::bad(Place::file(store.name_of(store.prefix())), "no program", expected));
    }
    entries.sort_by(|a, b| a.key.cmp(&b.key));
    Ok(entries)
}

/// `None`: it is no program.
fn entry(key: &str, got: Fetched<Digest>, format: Option<Recognised>) -> Option<Entry> {
    let (path, key) = (Path::new(key), text_of(Path::new(key)));
    let unreadable = Entry { key, size: 0, sha256: None, format: None, state: State::Unreadable, reason: None };
    let by_name = formats::is_program_by_name(path, format);
    match got {
        Fetched::Not(why) => Some(Entry { reason: Some(why), ..unreadable }),
        Fetched::Whole(d) if by_name.unwrap_or_else(|| formats::is_program_by_content(path, &d.head, format)) => {
            let format = format.unwrap_or_else(|| formats::recognise(path, &d.head));
            Some(Entry {
                size: d.size,
                sha256: Some(d.sha256),
                format: Some(name_of(format).into()),
                state: State::Ready,
                ..unreadable
            })
        }
        Fetched::Whole(_) => None,
    }
}

fn name_of(format: Recognised) -> &'static str {
    match format {
        Recognised::Csv => "csv",
        Recognised::Script(f) => f.name(),
    }
}

/// Programs of a store on disk.
pub struct Staged {
    _dir: TemporaryFolder,
    /// What stands on disk for the bucket.
    bucket: PathBuf,
    /// What stands there for the prefix.
    folder: PathBuf,
    /// Programs that are not there, and why.
    missing: HashMap<PathBuf, String>,
}

impl Staged {
    /// Brings programs to disk; `programs` are their paths below the prefix, with the names of their formats.
    ///
    /// # Errors
    /// The store or the disk fails.
    pub fn of(store: &Store, programs: &[(PathBuf, &str)]) -> Result<Self> {
        let (dir, bucket) = empty_folder()?;
        let folder = bucket.join(store.prefix());
        let mut staged = Self { _dir: dir, bucket, folder, missing: HashMap::new() };
        let wanted = wanted(store, programs)?;
        for (location, whole) in &wanted.beside {
            let path = staged.bucket.join(location);
            make_folder(path.parent())?;
            if !whole {
                std::fs::File::create(&path).map_err(|e| Error::io(&path, "write", e))?;
            }
        }
        let of = |location: &String| (location.clone(), staged.bucket.join(location));
        let whole: Vec<_> = wanted.beside.iter().filter(|(_, whole)| **whole).map(|(l, _)| of(l)).collect();
        for ((location, _), got) in whole.iter().zip(store.get(&whole)?) {
            // without it, a program would come out as if nothing stood there
            if let (Fetched::Not(why), false) = (got, wanted.programs.contains_key(location)) {
                return Err(Error::bad(Place::file(store.name_of(location)), why, "what was listed a moment before"));
            }
        }
        for (location, program) in &wanted.programs {
            if !staged.bucket.join(location).is_file() {
                staged.missing.insert(program.clone(), "there is no such object that can be read".into());
            }
        }
        Ok(staged)
    }

    /// What stands on disk for the prefix.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Why a program is not on disk.
    pub fn missing(&self, program: &Path) -> Option<&str> {
        self.missing.get(program).map(String::as_str)
    }

    /// A text with the names of objects where it has those of their copies.
    pub fn in_words(&self, store: &Store, text: &str) -> String {
        named(text, &self.bucket, store)
    }
}

/// A text with the names of a store's objects where it has paths below `bucket`.
fn named(text: &str, bucket: &Path, store: &Store) -> String {
    text.replace(&format!("{}/", shown(bucket)), &store.name_of(""))
}

/// A folder for copies: what is to be removed, and where copies go.
fn empty_folder() -> Result<(TemporaryFolder, PathBuf)> {
    let dir = TemporaryFolder::create().map_err(|e| Error::io(std::env::temp_dir(), "write", e))?;
    let bucket = dir.path().join(APART);
    make_folder(Some(&bucket))?;
    Ok((dir, bucket))
}

fn make_folder(folder: Option<&Path>) -> Result<()> {
    folder.map_or(Ok(()), |f| std::fs::create_dir_all(f).map_err(|e| Error::io(f, "make", e)))
}

/// Objects to be copied, by location.
struct ObjectsToCopy {
    /// Whether all bytes are wanted, or the name alone.
    beside: BTreeMap<String, bool>,
    /// The programs themselves.
    programs: BTreeMap<String, PathBuf>,
}

/// Endings of the files that the reader of a format looks at beside a program; empty: none, `None`: any.
fn endings_beside(format: &str) -> Option<&'static [&'static str]> {
    match format {
        "csv" | "urscript" | "trajectory" | "gcode" => Some(&[]),
        "krl" => Some(&["src", "sub", "dat"]),
        "rapid" => Some(&["mod", "modx", "prg", "sys", "sysx", "pgf"]),
        "fanuc" => Some(&["ls"]),
        "inform" => Some(&["jbi", "jbr"]),
        _ => None,
    }
}

fn is_beside(format: &str, location: &str) -> bool {
    let ending = Path::new(location).extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    endings_beside(format).is_none_or(|all| ending.is_some_and(|e| all.contains(&e.as_str())))
}

fn wanted(store: &Store, programs: &[(PathBuf, &str)]) -> Result<ObjectsToCopy> {
    let mut wanted = ObjectsToCopy { beside: BTreeMap::new(), programs: BTreeMap::new() };
    let mut folders: BTreeMap<String, BTreeSet<&str>> = BTreeMap::new();
    for (program, format) in programs {
        let Some(location) = store.location(program) else { continue };
        let folder = parent(&location).to_string();
        if *format == "rapid"
            && let Some(other) = fellow(&folder)
        {
            folders.entry(other).or_default().insert(format);
        }
        folders.entry(folder).or_default().insert(format);
        wanted.programs.insert(location, program.clone());
    }
    let names: Vec<String> = folders.keys().cloned().collect();
    for (formats, locations) in folders.values().zip(store.list_folders(&names)?) {
        let counts = formats.iter().any(|f| endings_beside(f) != Some(&[]));
        for location in locations {
            let whole = wanted.programs.contains_key(&location)
                || is_note(Path::new(&location))
                || formats.iter().any(|f| is_beside(f, &location));
            if whole || counts {
                wanted.beside.insert(location, whole);
            }
        }
    }
    let of_krl = folders.iter().filter(|(_, formats)| formats.contains("krl")).map(|(folder, _)| folder.as_str());
    for root in projects(store, of_krl)? {
        for location in store.list_below(&root, MOST_MODULES, &|l| is_beside("krl", l))? {
            let whole = is_beside("krl", &location) || wanted.beside.get(&location) == Some(&true);
            wanted.beside.insert(location, whole);
        }
    }
    Ok(wanted)
}

/// Folder of a location; empty: the bucket.
fn parent(location: &str) -> &str {
    location.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// The folder of system modules beside one of program modules, or the other way.
fn fellow(folder: &str) -> Option<String> {
    let (above, name) = folder.rsplit_once('/').map_or(("", folder), |(a, n)| (a, n));
    let other = match name.to_ascii_uppercase().as_str() {
        "PROGMOD" => "SYSMOD",
        "SYSMOD" => "PROGMOD",
        _ => return None,
    };
    Some(if above.is_empty() { other.into() } else { format!("{above}/{other}") })
}

/// The folders that hold the projects of KRL programs in `folders`: those above them with `System/$config.dat`.
fn projects<'a>(store: &Store, folders: impl Iterator<Item = &'a str>) -> Result<BTreeSet<String>> {
    let above = |folder: &'a str| {
        let mut next = Some(folder);
        std::iter::from_fn(move || {
            let here = next?;
            next = (!here.is_empty()).then(|| parent(here));
            Some(here)
        })
        .take(LEVELS)
    };
    let roots: BTreeSet<&str> = folders.flat_map(above).collect();
    let system = |root: &&str| {
        let slash = if root.is_empty() { "" } else { "/" };
        ["System", "SYSTEM"].map(|name| format!("{root}{slash}{name}"))
    };
    let asked: Vec<String> = roots.iter().flat_map(system).collect();
    let found = store.list_folders(&asked)?;
    let has = |listed: &[Vec<String>]| {
        listed.iter().flatten().any(|l| l.rsplit('/').next().is_some_and(|n| n.eq_ignore_ascii_case("$config.dat")))
    };
    let configured = roots.iter().zip(found.chunks(2)).filter(|(_, listed)| has(listed));
    Ok(configured.map(|(root, _)| (*root).to_string()).collect())
}

/// Results on their way to a store.
pub struct Results {
    _dir: TemporaryFolder,
    bucket: PathBuf,
    folder: PathBuf,
    /// SHA-256 of what stands in the store, by location.
    before: HashMap<String, String>,
}

impl Results {
    /// Brings the results of earlier runs to disk: those of the programs, which are copies or files below `input`.
    ///
    /// # Errors
    /// The store or the disk fails.
    pub fn of(store: &Store, programs: &[PathBuf], input: &Path) -> Result<Self> {
        let (dir, bucket) = empty_folder()?;
        let folder = bucket.join(store.prefix());
        let mut results = Self { _dir: dir, bucket, folder, before: HashMap::new() };
        results.fetch(store, programs.iter().map(|p| note_name(p)))?;
        let mut more = BTreeSet::new();
        for program in programs {
            let beside =
                |name: &str| path_of(name).filter(|n| n.components().count() == 1).map(|n| program.with_file_name(n));
            // a damaged one is none to rely on
            if let Some(note) = guard::read_note(&results.folder.join(program)).ok().flatten() {
                more.extend(beside(&note.output));
                more.extend(note.companions.iter().filter_map(|c| beside(&c.output)));
            }
            let companions = formats::companions(&input.join(program), &crate::program::files::Files::Disk);
            more.extend(companions.iter().filter_map(|c| c.extension()).map(|e| program.with_extension(e)));
        }
        results.fetch(store, more.into_iter())?;
        Ok(results)
    }

    fn fetch(&mut self, store: &Store, files: impl Iterator<Item = PathBuf>) -> Result<()> {
        let objects: Vec<(String, PathBuf)> =
            files.filter_map(|f| Some((store.location(&f)?, self.folder.join(f)))).collect();
        let folders: BTreeSet<&Path> = objects.iter().filter_map(|(_, path)| path.parent()).collect();
        folders.into_iter().try_for_each(|f| make_folder(Some(f)))?;
        for ((location, path), got) in objects.iter().zip(store.get(&objects)?) {
            match got {
                Fetched::Whole(()) => self.before.insert(location.clone(), batch::hash(path).unwrap_or_default()),
                Fetched::Not(_) => None,
            };
        }
        Ok(())
    }

    /// What stands on disk for the prefix.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// A text with the names of objects where it has those of their copies.
    pub fn in_words(&self, store: &Store, text: &str) -> String {
        named(text, &self.bucket, store)
    }

    /// Puts what is new or changed into the store: notes first, so that no rewritten program stands there without its note; and takes away
    /// what is gone, last. Before the notes it takes away what changes: where the run is killed in between, the next one finds a note whose
    /// program is missing, and puts it, and no program that differs from its note as if somebody had edited it.
    ///
    /// # Errors
    /// The store or the disk fails.
    pub fn put(self, store: &Store) -> Result<()> {
        let (mut notes, mut others) = (Vec::new(), Vec::new());
        let mut gone: BTreeSet<&String> = self.before.keys().collect();
        for path in files_below(&self.folder)? {
            let below = path.strip_prefix(&self.folder).ok().and_then(|p| store.location(p));
            let Some(location) = below else { continue };
            gone.remove(&location);
            if self.before.get(&location) != batch::hash(&path).as_ref() {
                if is_note(&path) { &mut notes } else { &mut others }.push((path, location));
            }
        }
        let replaced = others.iter().map(|(_, location)| location).filter(|l| self.before.contains_key(*l));
        store.delete(&replaced.cloned().collect::<Vec<_>>())?;
        store.put(&notes)?;
        store.put(&others)?;
        store.delete(&gone.into_iter().cloned().collect::<Vec<_>>())
    }
}

/// Results and notes below a folder, sorted; files of a run on its way are left out.
fn files_below(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(here) = open.pop() {
        for (name, kind) in crate::io::folder::list(&here).map_err(|e| Error::io(&here, "list", e))? {
            let path = here.join(&name);
            if kind == crate::io::folder::Kind::Folder {
                open.push(path);
            } else if !crate::io::temporary::is_ours(&name) {
                files.push(path);
            }
        }
    }
    files.sort();
    Ok(files)
}

#[cfg(test)]
mod tests;
