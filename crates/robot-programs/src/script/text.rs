//! Bytes of a program, their lines, and patches of them.

use crate::error::{Error, Place, Result};
use std::any::Any;
use std::fmt;
use std::ops::{Deref, Range};
use std::sync::{Arc, Mutex, PoisonError};

/// A text of a program. Bytes, as files in Latin-1 and with any line ending must come back as they were. A clone shares them.
#[derive(Debug, Clone, Default)]
pub struct Text {
    /// As messages show it.
    pub name: String,
    /// As the file has them.
    pub bytes: Arc<Vec<u8>>,
    /// It is looked up and never written: another module of the same project.
    pub context: bool,
    /// It is there and cannot be read: what it declares or changes is not known.
    pub unread: bool,
    /// First byte of every line.
    starts: Arc<Vec<usize>>,
    /// What a format has found out about it.
    known: Arc<Known>,
}

#[derive(Default)]
struct Known(Mutex<Vec<Arc<dyn Any + Send + Sync>>>);

impl fmt::Debug for Known {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("known")
    }
}

/// Bytes to be put in the place of others.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Patch {
    /// Index of the text.
    pub file: usize,
    /// Bytes that go; empty: an insertion.
    pub span: Range<usize>,
    /// What takes the place of the span.
    pub bytes: NewBytes,
}

/// Bytes of a patch: those of a number, as most are, need no memory of their own.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NewBytes(Kept);

const SHORT: usize = 22;

#[derive(Debug, Clone, PartialEq, Eq)]
enum Kept {
    Short(u8, [u8; SHORT]),
    Long(Box<[u8]>),
}

impl From<&[u8]> for NewBytes {
    fn from(bytes: &[u8]) -> Self {
        let mut short = [0; SHORT];
        match short.get_mut(..bytes.len()) {
            Some(place) => {
                place.copy_from_slice(bytes);
                Self(Kept::Short(bytes.len() as u8, short))
            }
            None => Self(Kept::Long(bytes.into())),
        }
    }
}

impl From<Vec<u8>> for NewBytes {
    fn from(bytes: Vec<u8>) -> Self {
        if bytes.len() <= SHORT { bytes.as_slice().into() } else { Self(Kept::Long(bytes.into_boxed_slice())) }
    }
}

impl From<String> for NewBytes {
    fn from(text: String) -> Self {
        text.into_bytes().into()
    }
}

impl From<&str> for NewBytes {
    fn from(text: &str) -> Self {
        text.as_bytes().into()
    }
}

impl<const N: usize> From<[u8; N]> for NewBytes {
    fn from(bytes: [u8; N]) -> Self {
        bytes.as_slice().into()
    }
}

impl Deref for NewBytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match &self.0 {
            Kept::Short(len, bytes) => bytes.get(..usize::from(*len)).unwrap_or_default(),
            Kept::Long(bytes) => bytes,
        }
    }
}

impl Patch {
    /// New bytes in the place of a span of a file.
    pub fn new(file: usize, span: Range<usize>, bytes: impl Into<NewBytes>) -> Self {
        Self { file, span, bytes: bytes.into() }
    }
}

impl Text {
    /// A text with its name, as messages show it.
    pub fn new(name: impl Into<String>, bytes: Vec<u8>) -> Self {
        // a file without a line feed may end its lines in carriage returns
        let end = if memchr::memchr(b'\n', &bytes).is_some() { b'\n' } else { b'\r' };
        let starts = std::iter::once(0).chain(memchr::memchr_iter(end, &bytes).map(|k| k + 1)).collect();
        let (bytes, starts, known) = (Arc::new(bytes), Arc::new(starts), Arc::default());
        Self { name: name.into(), bytes, context: false, unread: false, starts, known }
    }

    /// A text that is looked up and never written.
    pub fn of_context(name: impl Into<String>, bytes: Vec<u8>) -> Self {
        Self { context: true, ..Self::new(name, bytes) }
    }

    /// A file of the context that cannot be read.
    pub fn unread(name: impl Into<String>) -> Self {
        Self { unread: true, ..Self::of_context(name, Vec::new()) }
    }

    /// What `find` finds out about the text, which its clones share: a file that is the context of many programs is looked over once.
    pub fn known<T: Any + Send + Sync>(&self, find: impl FnOnce(&Self) -> T) -> Arc<T> {
        // one that failed while it looked has left nothing behind
        let lock = || self.known.0.lock().unwrap_or_else(PoisonError::into_inner);
        let there = lock().iter().find_map(|known| Arc::clone(known).downcast().ok());
        there.unwrap_or_else(|| {
            let found = Arc::new(find(self));
            lock().push(found.clone());
            found
        })
    }

    /// This text under another name.
    pub fn named(self, name: String) -> Self {
        Self { name, ..self }
    }

    /// This text with other bytes.
    pub fn with(&self, bytes: Vec<u8>) -> Self {
        Self { context: self.context, unread: self.unread, ..Self::new(self.name.clone(), bytes) }
    }

    /// Number of lines; what follows a last line ending counts only if there is something.
    pub fn line_count(&self) -> usize {
        self.starts.len() - usize::from(self.starts.last() == Some(&self.bytes.len()))
    }

    /// Bytes of line `k` (from 0), line ending included; empty beyond the last.
    pub fn line_span(&self, k: usize) -> Range<usize> {
        let end = self.bytes.len();
        let at = |k: usize| self.starts.get(k).copied().unwrap_or(end);
        at(k)..at(k + 1)
    }

    /// Bytes of line `k` (from 0) without its ending (`\n`, `\r\n`, `\r` where the text has no `\n`).
    pub fn line(&self, k: usize) -> &[u8] {
        let bytes = self.slice(self.line_span(k));
        let bytes = bytes.strip_suffix(b"\n").unwrap_or(bytes);
        bytes.strip_suffix(b"\r").unwrap_or(bytes)
    }

    /// Line number of a byte, counted from 1.
    pub fn line_of(&self, byte: usize) -> u64 {
        self.starts.partition_point(|&s| s <= byte).max(1) as u64
    }

    /// Bytes of a span; empty where it is not in the text.
    pub fn slice(&self, span: Range<usize>) -> &[u8] {
        self.bytes.get(span).unwrap_or_default()
    }

    /// Place of a byte for a message: line and column in bytes, both from 1.
    pub fn place(&self, byte: usize) -> Place {
        let line = self.line_of(byte);
        let start = self.starts.get(line as usize - 1).copied().unwrap_or(0);
        Place::field(&self.name, line, (byte - start) as u64 + 1)
    }

    /// Bad input at a byte.
    pub fn bad(&self, byte: usize, found: impl Into<String>, expected: impl Into<String>) -> Error {
        Error::bad(self.place(byte), found, expected)
    }

    /// The line ending that a new line behind `byte` takes: that of its line, else that of the first line, else `\n`.
    pub fn ending(&self, byte: usize) -> &'static [u8] {
        let line = self.line_span(self.line_of(byte) as usize - 1);
        let of = |span: Range<usize>| {
            let bytes = self.slice(span);
            if bytes.ends_with(b"\r\n") {
                Some(b"\r\n".as_slice())
            } else {
                let end = [b"\n".as_slice(), b"\r"].into_iter().find(|e| bytes.ends_with(e));
                end.filter(|e| *e != b"\r" || memchr::memchr(b'\n', &self.bytes).is_none())
            }
        };
        of(line).or_else(|| of(self.line_span(0))).unwrap_or(b"\n")
    }
}

/// The texts with their patches, sorted here; refuses patches that overlap or lie outside (a fault of a format).
pub fn apply(texts: &[Text], patches: &[Patch]) -> Result<Vec<Vec<u8>>> {
    let place = |p: &Patch| (p.file, p.span.start, p.span.end);
    // stable: insertions at one place keep their order and stand before a replacement there
    let mut sorted: Vec<&Patch> = Vec::new();
    if !patches.is_sorted_by_key(place) {
        sorted.extend(patches);
        sorted.sort_by_key(|p| place(p));
    }
    let all = || (0..patches.len()).filter_map(|k| sorted.get(k).copied().or_else(|| patches.get(k)));
    let mut out = Vec::with_capacity(texts.len());
    for (file, text) in texts.iter().enumerate() {
        let own = || all().filter(|p| p.file == file);
        let longer: usize = own().map(|p| p.bytes.len().saturating_sub(p.span.len())).sum();
        let mut bytes = Vec::with_capacity(text.bytes.len() + longer);
        let mut at = 0;
        for p in own() {
            if p.span.start < at || p.span.end < p.span.start || p.span.end > text.bytes.len() {
                return Err(Error::Refused(format!(
                    "{}: two edits touch the same bytes ({}); nothing was written",
                    text.name,
                    text.line_of(p.span.start)
                )));
            }
            bytes.extend_from_slice(&text.bytes[at..p.span.start]);
            bytes.extend_from_slice(&p.bytes);
            at = p.span.end;
        }
        bytes.extend_from_slice(&text.bytes[at..]);
        out.push(bytes);
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_places() {
        let t = Text::new("a", b"one\r\ntwo\nthree".to_vec());
        assert_eq!((t.line_count(), t.line(0), t.line(2)), (3, b"one".as_slice(), b"three".as_slice()));
        assert_eq!((t.line_of(0), t.line_of(5), t.line_of(13)), (1, 2, 3));
        assert_eq!(
            (t.ending(1), t.ending(6), t.ending(12)),
            (b"\r\n".as_slice(), b"\n".as_slice(), b"\r\n".as_slice())
        );
        assert_eq!(Text::new("a", b"one\n".to_vec()).line_count(), 1);
        assert_eq!(Text::new("a", Vec::new()).line_count(), 0);
    }

    #[test]
    fn what_is_found_out_is_found_out_once_for_all_clones() {
        let text = Text::new("a", b"abc".to_vec());
        let clone = text.clone();
        assert_eq!(*clone.known(|t| t.bytes.len()), 3);
        assert_eq!(*text.known(|_| 0_usize), 3);
        assert_eq!(*text.known(|t| t.name.clone()), "a");
    }

    #[test]
    fn patches_change_their_bytes_alone() {
        let t = vec![Text::new("a", b"0123456789".to_vec())];
        let patches = [Patch::new(0, 8..9, *b"x"), Patch::new(0, 2..2, *b"ab"), Patch::new(0, 2..4, *b"-")];
        assert_eq!(apply(&t, &patches).unwrap(), vec![b"01ab-4567x9".to_vec()]);
        assert!(apply(&t, &[Patch::new(0, 2..5, *b""), Patch::new(0, 4..6, *b"")]).is_err());
        assert!(apply(&t, &[Patch::new(0, 9..11, *b"")]).is_err());
    }
}
