//! What a program does to its positions and frames besides moving to them: positions that it reads or writes, frames and tools that it
//! sets.

use super::motion;
use super::statement::{Statement, index, is_comment};
use crate::script::Text;
use crate::script::cursor::{Cursor, integer};
use std::collections::{BTreeSet, HashMap};
use std::ops::Range;

/// How far after `P[` its `]` is looked for: a comment has 16 characters.
const NEAR: usize = 64;

/// Uses of positions, and settings of frames.
#[derive(Default)]
pub(super) struct Uses {
    read: BTreeSet<u64>,
    read_any: bool,
    /// Line of the last statement that gives a position a value, by index; of one whose index is computed.
    written: HashMap<u64, u64>,
    pub written_any: Option<u64>,
    pub sets: FramesSet,
}

/// Numbers of the user frames and tools that a program sets; `None`: any.
#[derive(Default)]
pub(super) struct FramesSet {
    frames: Vec<Option<u64>>,
    tools: Vec<Option<u64>>,
}

impl FramesSet {
    /// Whether the program sets the user frame, or the tool, of a number.
    pub fn has_frame(&self, number: Option<u64>) -> bool {
        self.frames.iter().any(|s| s.is_none() || *s == number)
    }

    pub fn has_tool(&self, number: Option<u64>) -> bool {
        self.tools.iter().any(|s| s.is_none() || *s == number)
    }

    /// Adds those of another program.
    pub fn extend(&mut self, other: &Self) {
        self.frames.extend(&other.frames);
        self.tools.extend(&other.tools);
    }

    /// Adds the frames and tools that a statement sets, also as the action of an IF or on the way of a motion: what positions in them mean
    /// is known only while the program runs.
    ///
    /// `setting = ("UFRAME" | "UTOOL") "[" number ... "]" "=" ... | ("$MNUFRAME" | "$MNUTOOL") "[" group "," number "]" "=" ...`
    pub fn add(&mut self, text: &Text, words: &[Range<usize>]) {
        for (k, word) in words.iter().enumerate() {
            let word = text.slice(word.clone());
            let named = |open: usize| open.checked_sub(1).is_some_and(|at| b"eElL".contains(&word[at]));
            if !memchr::memchr_iter(b'[', word).any(named) {
                continue;
            }
            let word = word.to_ascii_uppercase();
            let next = words.get(k + 1).and_then(|w| text.bytes.get(w.start)).copied();
            for (list, (system, name)) in [&mut self.frames, &mut self.tools]
                .into_iter()
                .zip([(&b"$MNUFRAME["[..], &b"UFRAME["[..]), (b"$MNUTOOL[", b"UTOOL[")])
            {
                if let Some(inside) = assigned(&word, system, next) {
                    let number = inside.split(|b| *b == b',').nth(1).and_then(|n| std::str::from_utf8(n).ok());
                    list.push(number.and_then(|n| n.trim().parse().ok()));
                } else if let Some(inside) = assigned(&word, name, next) {
                    let mut cursor = Cursor::new(inside);
                    let number = integer(cursor.digits());
                    list.push(number.filter(|_| matches!(cursor.peek(), None | Some(b':'))));
                }
            }
        }
    }
}

/// What stands in the brackets after `head` in a word, where that is given a value; `next`: what follows the word.
///
/// `assigned = [... ","] head ... "]" "="`
fn assigned<'a>(word: &'a [u8], head: &[u8], next: Option<u8>) -> Option<&'a [u8]> {
    let mut all = memchr::memmem::find_iter(word, head);
    all.find_map(|at| {
        let begins = at.checked_sub(1).is_none_or(|before| matches!(word[before], b',' | b')' | b'{'));
        let open = at + head.len() - 1;
        let end = closing(word, open).filter(|_| begins)?;
        let sign = word.get(end).copied().or(next);
        (sign == Some(b'=')).then(|| &word[open + 1..end - 1])
    })
}

/// The byte after the bracket that closes the one at `open`; after the first that closes any, where a name has another one.
///
/// `brackets = "[" ... [brackets] ... "]"`
fn closing(bytes: &[u8], open: usize) -> Option<usize> {
    let mut depth = 0_usize;
    let rest = bytes.get(open..bytes.len().min(open + NEAR))?;
    let first = || rest.iter().position(|b| *b == b']');
    let closes = |b: &u8| {
        match b {
            b'[' => depth += 1,
            b']' => depth = depth.saturating_sub(1),
            _ => {}
        }
        *b == b']' && depth == 0
    };
    Some(open + rest.iter().position(closes).or_else(first)? + 1)
}

impl Uses {
    pub fn of(text: &Text, all: &[(Statement, Vec<Range<usize>>)]) -> Self {
        let mut uses = Self::default();
        for (statement, words) in all {
            if statement.pieces.first().is_some_and(|p| is_comment(text.slice(p.clone()))) {
                continue;
            }
            let said = motion::read(text, statement, words);
            uses.sets.add(text, words);
            for k in 0..words.len() {
                uses.positions_of_word(text, words, k, said.is_some());
            }
            if let Some(said) = said {
                uses.read.extend(said.via);
                uses.read_any |= said.any;
            }
        }
        uses
    }

    /// Whether a statement reads the position of an index.
    pub fn reads(&self, index: u64) -> bool {
        self.read_any || self.read.contains(&index)
    }

    /// The line that gives the position of an index a value.
    pub fn written(&self, index: u64) -> Option<u64> {
        self.written.get(&index).copied()
    }

    /// Positions that word `k` of a statement names: written where `=` follows, also as the action of an IF or on the way of a motion, else
    /// read. Of a motion (`moves`) only those that it writes.
    ///
    /// `statement = "P" "[" index "]" "=" ... | ... "P" "[" index "]" ...`
    fn positions_of_word(&mut self, text: &Text, words: &[Range<usize>], k: usize, moves: bool) {
        let Some(word) = words.get(k) else { return };
        let bytes = text.slice(word.clone());
        let named = |open: usize| open.checked_sub(1).filter(|at| bytes[*at].eq_ignore_ascii_case(&b'P'));
        for at in memchr::memchr_iter(b'[', bytes).filter_map(named) {
            if at > 0 && (bytes[at - 1].is_ascii_alphanumeric() || b"_$".contains(&bytes[at - 1])) {
                continue;
            }
            let close = closing(bytes, at + 1).unwrap_or(at + 2);
            let found = index(text, word.start + at..word.start + close).map(|i| i.1);
            let next = bytes.get(close).or_else(|| words.get(k + 1).and_then(|w| text.bytes.get(w.start)));
            let line = text.line_of(word.start);
            match (found, next == Some(&b'=')) {
                (Some(n), true) => drop(self.written.insert(n, line)),
                (None, true) => self.written_any = Some(line),
                (Some(n), false) if !moves => drop(self.read.insert(n)),
                (None, false) if !moves => self.read_any = true,
                _ => {}
            }
        }
    }
}

/// The largest index in brackets after `P` on these lines; a new position must not answer to any of them.
///
/// `position = "P" "[" number ...`
pub(super) fn mentioned(text: &Text, lines: Range<usize>) -> u64 {
    let bytes = text.slice(text.line_span(lines.start).start..text.line_span(lines.end).start);
    let digits = |at: usize| {
        let rest = bytes.get(at + 1..).unwrap_or_default().trim_ascii_start();
        integer::<u32>(Cursor::new(rest).digits())
    };
    let named = memchr::memchr_iter(b'[', bytes).filter(|at| *at > 0 && bytes[at - 1].eq_ignore_ascii_case(&b'P'));
    named.filter_map(digits).max().map_or(0, u64::from)
}
