//! The task around a RAPID module: which files are its other modules, and one text of all of them.
//!
//! A controller loads the modules of a task into one name space: what is not LOCAL is seen by all of them, and no name may be
//! declared globally twice. So a module is read together with those that can be its fellows: the files of its folder (of `PROGMOD` and
//! `SYSMOD` where it stands in one of them), of which a `.pgf` that names the module names the others, too. A file that declares a
//! global name again, or a second `main`, is of another task and left out. Where nothing tells which of several `main` is the
//! module's own, none of them is taken. In a folder of another name without a `.pgf` the modules are one program where no two of them
//! declare the same global name and one holds `main`; those that use each other's names are then read together, else none is. A global
//! variable that a file which is left out assigns, passes on or declares with another value may be another at run time. What is found
//! there is read and never written.

use super::arguments::motion_of;
use super::facts::{Facts, value_of};
use super::lex::{self, Like};
use super::read::{self, Parsed, Storage};
use super::reason::Elsewhere;
use crate::files::{Folders, of_folder};
use crate::script::cursor::unmarked;
use crate::script::lex::text_of;
use crate::script::{At, Text};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Most modules that are taken for a task.
const MOST: usize = 64;
/// Most files of a folder that is looked through.
const MOST_LISTED: usize = 4096;
/// Most bytes of all modules of a task.
const MOST_BYTES: usize = 8 << 20;

/// Whether a file may hold modules.
pub(super) fn is_module(path: &Path) -> bool {
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    ending.is_some_and(|e| matches!(e.as_str(), "mod" | "modx" | "prg" | "sys" | "sysx"))
}

/// Files that may be of the task of the module at `path`, and the `.pgf` that name it. A folder that cannot be looked through stands for
/// itself: it is none that can be read.
pub fn files(path: &Path, seen: &Folders) -> Vec<PathBuf> {
    let Some(folder) = path.parent() else { return Vec::new() };
    let of_folder = |folder: &Path| seen.of("rapid", folder, || of_folder(folder, MOST_LISTED));
    let here = of_folder(folder);
    if here.is_empty() {
        return vec![folder.to_path_buf()];
    }
    let own = path.file_name();
    let name = file_name(path);
    let names = |p: &PathBuf| is_list(p) && std::fs::read(p).is_ok_and(|b| listed(&b).contains(&name));
    let wanted = |p: &&PathBuf| is_module(p) && p.file_name() != own || names(p);
    let mut all: Vec<PathBuf> = here.iter().filter(wanted).cloned().collect();
    let beside = match folder.file_name().map(|n| n.to_string_lossy().to_ascii_uppercase()).as_deref() {
        Some("PROGMOD") => "SYSMOD",
        Some("SYSMOD") => "PROGMOD",
        _ => return all,
    };
    all.extend(of_folder(&folder.with_file_name(beside)).iter().filter(|p| is_module(p)).cloned());
    all
}

/// A list of the modules of a program.
fn is_list(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("pgf"))
}

/// Name of a file, in lower case.
fn file_name(path: &Path) -> String {
    path.file_name().map(|n| n.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

/// Names of the files that a `.pgf` names, in lower case.
///
/// `list = {... "<Module>" path "<" ...}`
fn listed(bytes: &[u8]) -> Vec<String> {
    let list = String::from_utf8_lossy(bytes).to_ascii_lowercase();
    let name = |rest: &str| Some(rest.split('<').next()?.trim().rsplit(['/', '\\']).next()?.to_string());
    list.split("<module>").skip(1).filter_map(name).collect()
}

/// Whether a module stands in the folder of a task's program or system modules.
fn in_task_folder(path: &Path) -> bool {
    let folder = path.parent().map(file_name).unwrap_or_default();
    matches!(folder.as_str(), "progmod" | "sysmod")
}

/// Files that are not read together with the module. What they say is looked up when it is asked for.
#[derive(Default)]
pub struct LeftOut {
    files: Vec<Text>,
}

/// What is known of such a file.
struct FileFacts {
    /// Its words in lower case, less what it declares for its own task alone.
    words: HashSet<String>,
    /// Names that it may set; `None`: all its words, it is no RAPID.
    sets: Option<HashSet<String>>,
    /// Its global PERS with their values: of the same PERS in two tasks there is one value.
    shared: HashMap<String, Vec<u8>>,
    /// It sets data by names that are computed.
    by_name: bool,
    /// Names of its routines; all its words, where it is no RAPID.
    routines: HashSet<String>,
}

impl FileFacts {
    fn of(text: &Text) -> Self {
        let is_word = |b: &u8| b.is_ascii_alphanumeric() || *b == b'_' || *b >= 0x80;
        let words = text.bytes.split(|b| !is_word(b)).filter(|w| !w.is_empty());
        let mut words: HashSet<String> = words.map(|w| text_of(w).to_lowercase()).collect();
        let by_name = words.contains("setdataval") || words.contains("setalldataval");
        let (mut sets, mut shared, mut routines) = (None, HashMap::new(), words.clone());
        if let Ok(p) = lex::lex(text, Like::Read).and_then(|l| read::parse(text, l)) {
            let alone = p.modules.len() == 1;
            let own = |d: &&read::Decl| d.routine.is_none() && d.storage != Storage::Pers && (alone || !d.local);
            for d in p.decls.iter().filter(own) {
                words.remove(&d.name);
            }
            routines = p.routines.iter().map(|r| r.name.clone()).collect();
            sets = Some(Facts::touched(text, &p));
            let persistent = |d: &&read::Decl| d.routine.is_none() && d.storage == Storage::Pers && !d.local;
            shared = p.decls.iter().filter(persistent).map(|d| (d.name.clone(), value_of(text, &p, d))).collect();
        }
        Self { words, sets, shared, by_name, routines }
    }
}

impl LeftOut {
    /// What can be read: an empty file says nothing.
    fn read(&self) -> impl Iterator<Item = (&Text, Arc<FileFacts>)> {
        self.files.iter().filter(|t| !t.unread).map(|t| (t, t.known(FileFacts::of)))
    }

    /// The file that names a name.
    pub fn names(&self, name: &str) -> Option<&str> {
        self.read().find(|(_, said)| !name.is_ascii() || said.words.contains(name)).map(|(file, _)| file.name.as_str())
    }

    /// Whether a file may call a routine of the program: one that has a routine of that name calls its own, and cannot be loaded beside it.
    pub fn calls(&self, routine: &str) -> bool {
        let own = |said: &FileFacts| said.sets.is_some() && said.routines.contains(routine);
        self.read().any(|(_, said)| !routine.is_ascii() || said.words.contains(routine) && !own(&said))
    }

    /// Names of the routines that these files may hold.
    pub fn routines(&self) -> HashSet<String> {
        self.read().flat_map(|(_, said)| said.routines.iter().cloned().collect::<Vec<_>>()).collect()
    }

    /// Why the value of a global name that is no constant is not certain; `value`: as the module declares it.
    pub fn sets(&self, name: &str, value: &[u8]) -> Option<Elsewhere> {
        let names = |said: &FileFacts| !name.is_ascii() || said.words.contains(name);
        for (file, said) in self.read().filter(|(_, said)| names(said)) {
            if said.sets.as_ref().is_none_or(|sets| !name.is_ascii() || sets.contains(name)) {
                return Some(Elsewhere::Sets(file.name.as_str().into()));
            }
            if said.shared.get(name).is_some_and(|own| own != value) {
                return Some(Elsewhere::Declares(file.name.as_str().into()));
            }
        }
        let unread = self.files.iter().find(|t| t.unread);
        unread.map(|t| Elsewhere::Unread(t.name.as_str().into())).or_else(|| self.by_name())
    }

    /// Why any name may be set.
    pub fn by_name(&self) -> Option<Elsewhere> {
        self.read().find(|(_, said)| said.by_name).map(|(file, _)| Elsewhere::ByName(file.name.as_str().into()))
    }
}

/// The modules of a task as one text: the program's own first.
pub struct Project {
    pub text: Text,
    pub parsed: Parsed,
    /// First byte of each context, with the number of its file.
    starts: Vec<(usize, usize)>,
    /// Files beside it that are not read together with it.
    pub left_out: LeftOut,
}

impl Project {
    /// The own text alone, parsed.
    fn alone(text: &Text, parsed: Parsed) -> Self {
        Self { text: text.clone(), parsed, starts: Vec::new(), left_out: LeftOut::default() }
    }

    /// The program with those of its context that are of its task; of the others it is kept what they name.
    pub fn of(texts: &[Text], own: Parsed) -> Self {
        let Some(text) = texts.first() else { return Self::alone(&Text::default(), own) };
        // a module that moves nothing asks for nothing
        if texts.len() == 1 || !own.items.iter().any(|item| motion_of(&own, item).is_some()) {
            return Self::alone(text, own);
        }
        let (taken, mut project) = Self::joined(text, texts, own);
        for (k, other) in texts.iter().enumerate().skip(1) {
            if !taken.contains(&k) && !is_list(Path::new(&other.name)) {
                project.left_out.files.push(other.clone());
            }
        }
        project
    }

    /// The module with those that are of its task, and the numbers of these.
    fn joined(text: &Text, texts: &[Text], own: Parsed) -> (HashSet<usize>, Self) {
        let alone = |own| (HashSet::new(), Self::alone(text, own));
        let path = |t: &Text| PathBuf::from(&t.name);
        let lists: Vec<Vec<String>> =
            texts[1..].iter().filter(|t| is_list(&path(t))).map(|t| listed(&t.bytes)).collect();
        if lists.len() > 1 {
            return alone(own);
        }
        // a list or the name of the folder tells that what stands there is of one task
        let told = !lists.is_empty() || in_task_folder(&path(text));
        let of_task = |t: &Text| {
            let path = path(t);
            let name = file_name(&path);
            // a list names the modules of its own folder
            let system =
                name.ends_with(".sys") || name.ends_with(".sysx") || path.parent() != Path::new(&text.name).parent();
            is_module(&path) && lists.first().is_none_or(|list| list.contains(&name) || system)
        };
        // of programs that were put into one folder each has its own `main`: that is seen without reading them whole
        let ours = starts(text);
        let others = || (1..).zip(&texts[1..]).filter(|(_, t)| of_task(t) && !(ours && starts(t)));
        if others().filter(|(_, t)| starts(t)).count() > 1 || others().count() > MOST {
            return alone(own);
        }
        let all: Vec<(usize, &Text, Parsed)> =
            others().filter_map(|(k, t)| Some((k, t, read::parse(t, lex::lex(t, Like::Read).ok()?).ok()?))).collect();
        let taken = globals(&own);
        let fellows: Vec<&(usize, &Text, Parsed)> = match told {
            true => all.iter().filter(|(.., p)| globals(p).is_disjoint(&taken)).collect(),
            false if is_one_program(text, &own, &texts[1..], &all) => connected(&own, &all),
            false => Vec::new(),
        };
        let main = |p: &Parsed| p.routines.iter().any(|r| r.name == "main");
        let mains = fellows.iter().filter(|(.., p)| main(p)).count();
        let size: usize = fellows.iter().map(|f| f.1.bytes.len()).sum();
        if mains > 1 || size > MOST_BYTES || fellows.is_empty() {
            return alone(own);
        }
        let (mut bytes, mut starts) = (text.bytes.to_vec(), Vec::new());
        for (k, fellow, _) in &fellows {
            bytes.push(b'\n');
            starts.push((bytes.len(), *k));
            bytes.extend_from_slice(unmarked(&fellow.bytes));
        }
        let joined = Text::new(text.name.clone(), bytes);
        match lex::lex(&joined, Like::Read).and_then(|l| read::parse(&joined, l)) {
            Ok(parsed) => {
                let taken = fellows.iter().map(|f| f.0).collect();
                (taken, Self { text: joined, parsed, starts, left_out: LeftOut::default() })
            }
            // each of them is whole, but not one after the other
            Err(_) => alone(own),
        }
    }

    /// First byte after the program's own text.
    pub fn own_end(&self) -> usize {
        self.starts.first().map_or(self.text.bytes.len(), |s| s.0)
    }

    /// File and line of a byte.
    pub fn at(&self, byte: usize) -> At {
        let line = self.text.line_of(byte);
        match self.starts.iter().rev().find(|s| s.0 <= byte) {
            None => At { file: 0, line },
            Some((start, file)) => At { file: *file, line: line + 1 - self.text.line_of(*start) },
        }
    }
}

/// Whether the modules of a folder without a list are one program: all of them can be read, can be loaded together, and hold one `main`.
fn is_one_program(text: &Text, own: &Parsed, beside: &[Text], all: &[(usize, &Text, Parsed)]) -> bool {
    let modules = || beside.iter().filter(|t| is_module(Path::new(&t.name)));
    let mains = usize::from(starts(text)) + modules().filter(|t| starts(t)).count();
    let mut names = globals(own);
    let apart = |p: &Parsed| {
        let own = globals(p);
        let apart = own.is_disjoint(&names);
        names.extend(own);
        apart
    };
    mains == 1 && modules().count() == all.len() && all.iter().map(|(.., p)| p).all(apart)
}

/// The modules that use what the module declares or declare what it uses, and so on from these: those that are loaded with it. None where
/// `main` is not among them.
fn connected<'a, 't>(own: &Parsed, all: &'a [(usize, &'t Text, Parsed)]) -> Vec<&'a (usize, &'t Text, Parsed)> {
    let uses = |a: &Parsed, b: &Parsed| {
        let shared = globals(b);
        let declares = |word: &str| a.decls.iter().any(|d| d.name == word) || a.routines.iter().any(|r| r.name == word);
        a.words.different().any(|w| shared.contains(w) && !declares(w))
    };
    let (mut found, mut rest): (Vec<_>, Vec<_>) = (Vec::new(), all.iter().collect());
    let mut open = vec![own];
    while let Some(from) = open.pop() {
        let (near, far): (Vec<_>, Vec<_>) = rest.into_iter().partition(|(.., p)| uses(from, p) || uses(p, from));
        open.extend(near.iter().map(|(.., p)| p));
        found.extend(near);
        rest = far;
    }
    let main = |p: &Parsed| p.routines.iter().any(|r| r.name == "main");
    found.sort_by_key(|f| f.0);
    if main(own) || found.iter().any(|(.., p)| main(p)) { found } else { Vec::new() }
}

/// Whether a text may hold `PROC main`.
///
/// `main = "PROC" {blank} "main"`
fn starts(text: &Text) -> bool {
    let upper = text.bytes.to_ascii_uppercase();
    let after = |at: usize| upper.get(at + 4..).unwrap_or_default().trim_ascii_start();
    memchr::memmem::find_iter(&upper, b"PROC").any(|at| after(at).starts_with(b"MAIN"))
}

/// Names that modules share: data and routines that are not LOCAL, and the modules themselves.
fn globals(p: &Parsed) -> HashSet<String> {
    let data = p.decls.iter().filter(|d| d.routine.is_none() && !d.local).map(|d| d.name.clone());
    let routines = p.routines.iter().filter(|r| !r.local).map(|r| r.name.clone());
    data.chain(routines).chain(p.modules.iter().cloned()).collect()
}
