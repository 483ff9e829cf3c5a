//! Files that are looked up for programs and never written: each is read once for all programs of a call.

use crate::error::shown;
use crate::io::name::text_of_name;
use crate::io::{input, memory};
use crate::program::files::Folders;
use crate::program::script::{Format, Text};
use crate::robot::Axes;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// A vendor program is read whole; a larger one is none that a controller could load.
pub(crate) const LARGEST_SCRIPT: u64 = 256 << 20;
/// Bytes of such files that are kept.
const KEPT: usize = 8 << 20;

/// What stands beside programs.
#[derive(Debug, Default)]
pub struct Contexts {
    folders: Folders,
    texts: Mutex<Cached>,
}

#[derive(Debug, Default)]
struct Cached {
    by_path: HashMap<PathBuf, Text>,
    bytes: usize,
}

impl Contexts {
    /// The context of the program at `input`. A file that cannot be read is evidence, too: what it declares is not known.
    pub fn of(&self, format: &dyn Format, input: &Path, robot: &Axes) -> Vec<Text> {
        format.context(input, &self.folders, robot).iter().map(|path| self.text(path)).collect()
    }

    /// Whether another program beside the one at `input`, whose text is `own`, calls it.
    pub fn is_called(&self, format: &dyn Format, input: &Path, own: &Text) -> bool {
        format.is_called(input, own, &self.folders)
    }

    fn text(&self, path: &Path) -> Text {
        // one that failed while it read has left nothing after
        let lock = || self.texts.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = lock().by_path.get(path) {
            return known.clone();
        }
        let read = read(path).unwrap_or_else(|| Text::unread(shown(path)));
        let mut kept = lock();
        kept.bytes += path.as_os_str().len() + read.bytes.len();
        if kept.bytes > KEPT {
            *kept = Cached::default();
        }
        kept.by_path.insert(path.to_path_buf(), read.clone());
        read
    }
}

fn read(path: &Path) -> Option<Text> {
    let name = shown(path);
    memory::require_for_file(path, &name, LARGEST_SCRIPT, |bytes| 2 * bytes).ok()?;
    let bytes = std::fs::read(path).ok()?;
    input::refuse_utf16(&name, &bytes).ok()?;
    Some(Text::of_context(name, bytes))
}

/// SHA-256 of the files that declare what a program uses, names and all, and of whether another one calls it; `None`: neither.
pub(crate) fn sum_of<'a>(called: bool, context: impl Iterator<Item = &'a Text>) -> Option<String> {
    let mut all = String::from(if called { "called" } else { "" });
    for text in context {
        let one = text.known(ContextSum::of);
        all.push_str(if all.is_empty() { "" } else { "\n" });
        all.push_str(&one.0);
    }
    (!all.is_empty()).then(|| input::sha256(all.as_bytes()))
}

/// Name and SHA-256 of one such file.
struct ContextSum(String);

impl ContextSum {
    fn of(text: &Text) -> Self {
        let name = Path::new(&text.name).file_name().map(text_of_name).unwrap_or_default();
        Self(format!("{name} {} {}", text.unread, input::sha256(&text.bytes)))
    }
}
