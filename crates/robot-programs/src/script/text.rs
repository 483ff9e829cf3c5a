//! Bytes of a program and their lines.

use super::cursor::unmarked;
pub use super::patches::apply;
use crate::error::{Error, Place};
use std::any::Any;
use std::fmt;
use std::ops::Range;
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
    /// Another program calls it ([`Format::is_called`](super::Format::is_called)): at its start the robot may stand anywhere.
    pub called: bool,
    /// First byte of every line.
    starts: Arc<Vec<u32>>,
    /// What [`Self::head`] tells of every line.
    heads: Arc<[u8]>,
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

/// A span of bytes in the memory of one number: formats keep several for each move. Texts are no longer than
/// [`super::lex::LONGEST`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Span {
    start: u32,
    end: u32,
}

impl Span {
    /// First byte.
    pub fn start(self) -> usize {
        self.start as usize
    }

    /// Byte after the last.
    pub fn end(self) -> usize {
        self.end as usize
    }

    /// As a range.
    pub fn range(self) -> Range<usize> {
        self.start()..self.end()
    }
}

impl From<Range<usize>> for Span {
    fn from(range: Range<usize>) -> Self {
        Self { start: range.start as u32, end: range.end as u32 }
    }
}

impl From<Span> for Range<usize> {
    fn from(span: Span) -> Self {
        span.range()
    }
}

impl Text {
    /// A text with its name, as messages show it.
    pub fn new(name: impl Into<String>, bytes: Vec<u8>) -> Self {
        // a file without a line feed may end its lines in carriage returns
        let end = if memchr::memchr(b'\n', &bytes).is_some() { b'\n' } else { b'\r' };
        // lines are rarely shorter; memory that nothing goes to is never touched
        const LEAST_BYTES: usize = 16;
        // no format reads a text longer than its line starts can tell
        let mut starts: Vec<u32> = Vec::with_capacity(2 + bytes.len() / LEAST_BYTES);
        starts.push(0);
        starts.extend(memchr::memchr_iter(end, &bytes).map_while(|k| u32::try_from(k + 1).ok()));
        let heads = heads(&bytes, &starts);
        let (bytes, starts, known) = (Arc::new(bytes), Arc::new(starts), Arc::default());
        Self { name: name.into(), bytes, context: false, unread: false, called: false, starts, heads, known }
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
        // one that failed while it looked has stored nothing
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
        Self { context: self.context, unread: self.unread, called: self.called, ..Self::new(self.name.clone(), bytes) }
    }

    /// How many steps the text may hold, as far as its size tells: readers ask for their memory at once, as lists that double are
    /// copied and leave holes. What is not used is never touched.
    pub fn likely_steps(&self) -> usize {
        const LEAST_BYTES: usize = 24;
        self.line_count().min(self.bytes.len() / LEAST_BYTES) + 1
    }

    /// How many numbers its targets may hold, in the same way.
    pub fn likely_numbers(&self) -> usize {
        const LEAST_BYTES: usize = 10;
        self.bytes.len() / LEAST_BYTES
    }

    /// Number of lines; what follows a last line ending counts only if there is something.
    pub fn line_count(&self) -> usize {
        self.starts.len() - usize::from(self.starts.last().map(|s| *s as usize) == Some(self.bytes.len()))
    }

    /// Bytes of line `k` (from 0), line ending included; empty beyond the last.
    #[inline]
    pub fn line_span(&self, k: usize) -> Range<usize> {
        let end = self.bytes.len();
        let at = |k: usize| self.starts.get(k).map_or(end, |s| *s as usize);
        at(k)..at(k + 1)
    }

    /// Bytes of line `k` (from 0) without its ending (`\n`, `\r\n`, `\r` where the text has no `\n`).
    #[inline]
    pub fn line(&self, k: usize) -> &[u8] {
        let bytes = self.slice(self.line_span(k));
        let bytes = bytes.strip_suffix(b"\n").unwrap_or(bytes);
        bytes.strip_suffix(b"\r").unwrap_or(bytes)
    }

    /// The first byte of line `k` (from 0) that is no blank, a letter in upper case; `None`: the line is blank. Many readers look for
    /// lines by their first letter.
    #[inline]
    pub fn head(&self, k: usize) -> Option<u8> {
        self.heads.get(k).copied().filter(|head| *head != NO_HEAD)
    }

    /// The lines (from 0) on which one of these marks stands, ascending.
    pub fn lines_with<'a>(&'a self, marks: &'a [u8]) -> impl Iterator<Item = usize> + 'a {
        let (mut at, mut line) = (0, 0);
        std::iter::from_fn(move || {
            let rest = self.bytes.get(at..)?;
            let found = match marks {
                [mark] => memchr::memchr(*mark, rest),
                [a, b] => memchr::memchr2(*a, *b, rest),
                [a, b, c] => memchr::memchr3(*a, *b, *c, rest),
                _ => rest.iter().position(|b| marks.contains(b)),
            };
            let byte = at + found?;
            if self.line_span(line).end <= byte {
                line = self.line_of(byte) as usize - 1;
            }
            let found = line;
            (at, line) = (self.line_span(line).end, line + 1);
            Some(found)
        })
    }

    /// Line number of a byte, counted from 1.
    pub fn line_of(&self, byte: usize) -> u64 {
        self.starts.partition_point(|&s| s as usize <= byte).max(1) as u64
    }

    /// Bytes of a span; empty where it is not in the text.
    #[inline]
    pub fn slice(&self, span: impl Into<Range<usize>>) -> &[u8] {
        self.bytes.get(span.into()).unwrap_or_default()
    }

    /// Bytes of a span with some of them replaced, in order.
    pub fn substituted<B: AsRef<[u8]>>(
        &self,
        span: Range<usize>,
        changes: impl IntoIterator<Item = (Range<usize>, B)>,
    ) -> Vec<u8> {
        let mut out = Vec::with_capacity(span.len() + 32);
        let mut at = span.start;
        for (old, new) in changes {
            out.extend_from_slice(self.slice(at..old.start));
            out.extend_from_slice(new.as_ref());
            at = old.end;
        }
        out.extend_from_slice(self.slice(at..span.end));
        out
    }

    /// Place of a byte for a message: line and column in bytes, both from 1.
    pub fn place(&self, byte: usize) -> Place {
        let line = self.line_of(byte);
        let start = self.starts.get(line as usize - 1).map_or(0, |s| *s as usize);
        Place::field(&self.name, line, (byte - start) as u64 + 1)
    }

    /// Bad input at a byte.
    pub fn bad(&self, byte: usize, found: impl Into<String>, expected: impl Into<String>) -> Error {
        Error::bad(self.place(byte), found, expected)
    }

    /// The line ending that a new line after `byte` takes: that of its line, else that of the first line, else `\n`.
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

/// A blank line has no head.
const NO_HEAD: u8 = b' ';

/// The heads of lines. The byte 0x1A, with which files of old controllers end, is a blank.
fn heads(bytes: &[u8], starts: &[u32]) -> Arc<[u8]> {
    let ends = starts.iter().skip(1).map(|s| *s as usize).chain([bytes.len()]);
    let marked = bytes.len() - unmarked(bytes).len();
    let starts = starts.iter().map(|s| (*s as usize).max(marked));
    let blank = |b: &&u8| b.is_ascii_whitespace() || **b == 0x1a;
    let head = |(start, end): (usize, usize)| {
        let line = bytes.get(start..end).unwrap_or_default();
        line.iter().find(|b| !blank(b)).map_or(NO_HEAD, u8::to_ascii_uppercase)
    };
    starts.zip(ends).map(head).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_of_lines_and_lines_with_marks() {
        let t = Text::new("a", b"\xef\xbb\xbf  def x=(1)\r\n\r\n\t\x1a\nend =\n\x1a".to_vec());
        let heads: Vec<Option<u8>> = (0..t.line_count()).map(|k| t.head(k)).collect();
        assert_eq!(heads, [Some(b'D'), None, None, Some(b'E'), None]);
        assert_eq!((t.head(5), Text::new("a", Vec::new()).head(0)), (None, None));
        let with = |marks: &[u8]| t.lines_with(marks).collect::<Vec<_>>();
        assert_eq!(
            (with(b"="), with(b"("), with(b"=("), with(b"(1e"), with(b"#")),
            (vec![0, 3], vec![0], vec![0, 3], vec![0, 3], vec![])
        );
        assert_eq!((with(b"abcdefgh"), with(b"")), (vec![0, 3], vec![]));
    }

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
}
