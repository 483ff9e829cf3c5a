//! New bytes instead of others: most are the digits of a number, of which a program may have a million.

use super::text::Text;
use crate::error::{Error, Result};
use std::ops::Range;

/// Bytes that replace others.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Patch {
    /// Index of the text.
    pub file: usize,
    /// Bytes that go; empty: an insertion.
    pub span: Range<usize>,
    /// What replaces the span.
    pub bytes: Vec<u8>,
}

impl Patch {
    /// New bytes instead of a span of a file.
    pub fn new(file: usize, span: impl Into<Range<usize>>, bytes: impl Into<Vec<u8>>) -> Self {
        Self { file, span: span.into(), bytes: bytes.into() }
    }
}

/// Patches one after the other, in little memory.
#[derive(Debug, Clone, Default)]
pub struct Patches {
    heads: Vec<Head>,
    bytes: Vec<u8>,
    /// Ends of the spans of [`LONG`] patches, by their index.
    long: Vec<(u32, u32)>,
    /// File, start and end of the last one, and whether one before it stands after the one that follows it.
    last: (u16, u32, u32),
    mixed: bool,
}

#[derive(Debug, Clone, Copy)]
struct Head {
    start: u32,
    /// Where its new bytes end; they begin where those of the patch before end.
    to: u32,
    /// Bytes that go.
    len: u16,
    file: u16,
}

/// So many bytes go, or more.
const LONG: u16 = u16::MAX;

/// A patch of [`Patches`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PatchRef<'a> {
    /// Index of the text.
    pub file: usize,
    /// Bytes that go; empty: an insertion.
    pub span: Range<usize>,
    /// What replaces the span.
    pub bytes: &'a [u8],
}

impl Patches {
    /// With memory for so many patches, most of them of numbers.
    pub fn with_capacity(numbers: usize) -> Self {
        const BYTES: usize = 9;
        let (heads, bytes) = (Vec::with_capacity(numbers), Vec::with_capacity(numbers * BYTES));
        Self { heads, bytes, ..Self::default() }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.heads.len()
    }

    /// There is none.
    pub fn is_empty(&self) -> bool {
        self.heads.is_empty()
    }

    /// Adds a patch.
    pub fn push(&mut self, patch: Patch) {
        self.put(patch.file, patch.span, &patch.bytes);
    }

    /// Adds a patch whose bytes stand elsewhere.
    pub fn put(&mut self, file: usize, span: Range<usize>, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
        // a span that ends before it begins is long, too: it is refused as it stands
        let len = span.end.checked_sub(span.start).and_then(|len| u16::try_from(len).ok()).unwrap_or(LONG);
        if len == LONG {
            self.long.push((self.heads.len() as u32, span.end as u32));
        }
        let here = (file as u16, span.start as u32, span.end as u32);
        self.mixed |= here < self.last;
        self.last = here;
        self.heads.push(Head { start: span.start as u32, to: self.bytes.len() as u32, len, file: file as u16 });
    }

    /// Byte after those that patch `k` replaces.
    fn end(&self, k: usize, head: &Head) -> u32 {
        let long = || self.long.binary_search_by_key(&(k as u32), |l| l.0).ok().and_then(|at| self.long.get(at));
        match head.len {
            LONG => long().map_or(head.start, |l| l.1),
            len => head.start + u32::from(len),
        }
    }

    /// Patch `k`, in the order in which they were added.
    fn get(&self, k: usize) -> Option<PatchRef<'_>> {
        let head = self.heads.get(k)?;
        let from = k.checked_sub(1).and_then(|before| self.heads.get(before)).map_or(0, |before| before.to);
        let bytes = self.bytes.get(from as usize..head.to as usize).unwrap_or_default();
        Some(PatchRef { file: head.file.into(), span: head.start as usize..self.end(k, head) as usize, bytes })
    }

    /// All patches, in the order in which they were added.
    pub fn iter(&self) -> impl Iterator<Item = PatchRef<'_>> {
        (0..self.len()).filter_map(|k| self.get(k))
    }

    /// All patches by file and place. Insertions at one place keep their order and stand before a replacement there.
    pub fn sorted(&self) -> impl Iterator<Item = PatchRef<'_>> {
        let place = |k: &u32| self.heads.get(*k as usize).map(|h| (h.file, h.start, self.end(*k as usize, h)));
        let mut order: Vec<u32> = if self.mixed { (0..self.len() as u32).collect() } else { Vec::new() };
        order.sort_by_key(place);
        (0..self.len()).filter_map(move |k| self.get(order.get(k).map_or(k, |k| *k as usize)))
    }
}

impl Extend<Patch> for Patches {
    fn extend<I: IntoIterator<Item = Patch>>(&mut self, all: I) {
        all.into_iter().for_each(|patch| self.push(patch));
    }
}

impl FromIterator<Patch> for Patches {
    fn from_iter<I: IntoIterator<Item = Patch>>(all: I) -> Self {
        let mut patches = Self::default();
        patches.extend(all);
        patches
    }
}

/// The texts with their patches; refuses patches that overlap or lie outside (a fault of a format).
///
/// # Errors
/// [`Error::Refused`] with the line.
pub fn apply(texts: &[Text], patches: &Patches) -> Result<Vec<Vec<u8>>> {
    // memory that no byte goes to is never touched
    let more = patches.bytes.len();
    let mut out: Vec<Vec<u8>> = texts.iter().map(|t| Vec::with_capacity(t.bytes.len() + more)).collect();
    let mut at = vec![0; texts.len()];
    for p in patches.sorted() {
        let (Some(text), Some(bytes), Some(at)) = (texts.get(p.file), out.get_mut(p.file), at.get_mut(p.file)) else {
            continue;
        };
        let between =
            text.bytes.get(*at..p.span.start).filter(|_| p.span.start <= p.span.end && p.span.end <= text.bytes.len());
        let Some(between) = between else {
            return Err(Error::Refused(format!(
                "{}: two edits touch the same bytes ({}); nothing was written",
                text.name,
                text.line_of(p.span.start)
            )));
        };
        bytes.extend_from_slice(between);
        bytes.extend_from_slice(p.bytes);
        *at = p.span.end;
    }
    for ((text, bytes), at) in texts.iter().zip(&mut out).zip(at) {
        bytes.extend_from_slice(text.bytes.get(at..).unwrap_or_default());
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_change_their_bytes_alone() {
        let t = vec![Text::new("a", b"0123456789".to_vec())];
        let of = |all: &[(Range<usize>, &str)]| -> Patches {
            all.iter().map(|(s, b)| Patch::new(0, s.clone(), *b)).collect()
        };
        let patches = of(&[(8..9, "x"), (2..2, "ab"), (2..4, "-")]);
        assert_eq!(apply(&t, &patches).unwrap(), vec![b"01ab-4567x9".to_vec()]);
        assert!(apply(&t, &of(&[(2..5, ""), (4..6, "")])).is_err());
        assert!(apply(&t, &of(&[(9..11, "")])).is_err());
    }

    #[test]
    fn any_number_of_bytes_goes() {
        let t = vec![Text::new("a", vec![b'x'; 200_000])];
        for len in [65_534, 65_535, 65_536, 150_000] {
            let patches: Patches =
                [Patch::new(0, 20_000..20_000 + len, *b"new"), Patch::new(0, 0..1, *b"")].into_iter().collect();
            let out = apply(&t, &patches).unwrap();
            assert_eq!((out[0].len(), &out[0][19_998..20_003]), (200_000 - len + 2, &b"xnewx"[..]));
        }
    }

    #[test]
    fn insertions_at_one_place_keep_their_order_in_every_file() {
        let t = vec![Text::new("a", b"ab".to_vec()), Text::new("b", b"cd".to_vec())];
        let mut patches = Patches::default();
        assert!(patches.is_empty());
        for (file, span, new) in [(1, 1..1, "2"), (0, 1..2, "B"), (1, 1..1, "3"), (0, 1..1, "1")] {
            patches.put(file, span, new.as_bytes());
        }
        assert_eq!(apply(&t, &patches).unwrap(), vec![b"a1B".to_vec(), b"c23d".to_vec()]);
        assert_eq!(patches.iter().map(|p| p.bytes.len()).sum::<usize>(), 4);
        assert!(!patches.is_empty() && patches.len() == 4);
    }
}
