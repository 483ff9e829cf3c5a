//! The formats, and which of them a program is written in: by ending, by content, or as asked.

use super::files::Files;
use super::script::Format;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Every format that is read whole into memory, in the order in which contents are asked. Joint-space CSV streams, and is
/// what a program is when no other format claims it.
pub static FORMATS: &[&dyn Format] = &[
    &super::inform::Inform,
    &super::rapid::Rapid,
    &super::krl::Krl,
    &super::fanuc::Fanuc,
    &super::urscript::UrScript,
    &super::trajectory::Ros,
    &super::gcode::Gcode,
];

/// How a program is read.
#[derive(Clone, Copy)]
pub enum Recognised {
    /// Joint-space CSV: rows, in constant memory.
    Csv,
    /// A language of a vendor, or a trajectory: read whole.
    Script(&'static dyn Format),
}

/// Names of the formats.
pub fn names() -> Vec<&'static str> {
    std::iter::once("csv").chain(FORMATS.iter().map(|f| f.name())).collect()
}

/// The format of a name, case ignored.
pub fn named(name: &str) -> Option<Recognised> {
    if name.eq_ignore_ascii_case("csv") {
        return Some(Recognised::Csv);
    }
    FORMATS.iter().find(|f| f.name().eq_ignore_ascii_case(name)).map(|f| Recognised::Script(*f))
}

/// Ending of a file name in lower case, a `.gz` after it left out.
pub fn ending(path: &Path) -> Option<String> {
    let name = path.file_name()?.to_string_lossy().to_ascii_lowercase();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    name.rsplit_once('.').map(|(_, e)| e.to_string())
}

/// Endings that files of many kinds have: there the content must be that of a program.
const GENERAL: &[&str] = &["yaml", "yml", "json", "txt", "sys"];
/// Bytes by which a file with such an ending is judged.
const HEAD: u64 = 1 << 16;

/// Endings of all programs, for messages.
pub fn endings() -> Vec<&'static str> {
    std::iter::once("csv").chain(FORMATS.iter().flat_map(|f| f.endings().iter().copied())).collect()
}

/// Whether a file in a folder is a program (of the requested format), so that other files of a folder are left out.
pub fn is_program(path: &Path, asked: Option<Recognised>) -> bool {
    is_program_by_name(path, asked).unwrap_or_else(|| {
        let mut head = Vec::new();
        let read = std::fs::File::open(path).and_then(|f| f.take(HEAD).read_to_end(&mut head));
        read.is_ok() && is_program_by_content(path, &head, asked)
    })
}

/// Whether a name is that of a program (of the requested format); `None`: the content decides ([`is_program_by_content`]).
pub fn is_program_by_name(path: &Path, asked: Option<Recognised>) -> Option<bool> {
    let Some(ending) = ending(path) else { return Some(false) };
    if ending == "csv" {
        return Some(!matches!(asked, Some(Recognised::Script(_))));
    }
    (!GENERAL.contains(&ending.as_str())).then(|| with_ending(&ending, asked).next().is_some())
}

/// Whether a file that may be anything by its name is a program by its first bytes, `head` (64 KiB are enough).
pub fn is_program_by_content(path: &Path, head: &[u8], asked: Option<Recognised>) -> bool {
    ending(path).is_some_and(|ending| with_ending(&ending, asked).any(|f| f.recognises(head)))
}

/// The formats, or the requested one of them, whose programs have this ending.
fn with_ending(ending: &str, asked: Option<Recognised>) -> impl Iterator<Item = &'static dyn Format> {
    let formats: Vec<&'static dyn Format> = match asked {
        Some(Recognised::Csv) => Vec::new(),
        Some(Recognised::Script(f)) => vec![f],
        None => FORMATS.to_vec(),
    };
    formats.into_iter().filter(move |f| f.endings().contains(&ending))
}

/// Files that belong to a program by its ending, and are there.
pub fn companions(path: &Path, there: &Files) -> Vec<PathBuf> {
    let Some(ending) = ending(path) else { return Vec::new() };
    let format = FORMATS.iter().find(|f| f.endings().contains(&ending.as_str()));
    format.map_or(Vec::new(), |f| f.companions(path, there))
}

/// The format of a program: of those that have its ending the one that recognises its first bytes, else one with the ending
/// alone; with a foreign ending the one that recognises it, else CSV.
pub fn recognise(path: &Path, head: &[u8]) -> Recognised {
    let ending = ending(path).unwrap_or_default();
    if ending == "csv" {
        return Recognised::Csv;
    }
    let by_ending = || FORMATS.iter().filter(|f| f.endings().contains(&ending.as_str()));
    let found = by_ending()
        .find(|f| f.recognises(head))
        .or_else(|| by_ending().next())
        .or_else(|| FORMATS.iter().find(|f| f.recognises(head)));
    found.map_or(Recognised::Csv, |f| Recognised::Script(*f))
}
