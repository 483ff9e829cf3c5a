//! What a program does to its positions and frames besides moving to them: positions that it reads or writes, frames and tools that it sets.

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
    /// Numbers of the user frames and tools that the program sets; `None`: any.
    frames: Vec<Option<u64>>,
    tools: Vec<Option<u64>>,
}

impl Uses {
    pub fn of(text: &Text, all: &[(Statement, Vec<Range<usize>>)]) -> Self {
        let mut uses = Self::default();
        for (statement, words) in all {
            if statement.pieces.first().is_some_and(|p| is_comment(text.slice(p.clone()))) {
                continue;
            }
            if let Some(said) = motion::read(text, statement, words) {
                uses.read.extend(said.via);
                uses.read_any |= said.any;
                continue;
            }
            uses.frame_setting(&words.first().map(|w| text.slice(w.clone()).to_ascii_uppercase()).unwrap_or_default());
            for k in 0..words.len() {
                uses.positions_of_word(text, words, k);
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

    /// Whether the program sets the user frame, or the tool, of a number.
    pub fn sets_frame(&self, number: Option<u64>) -> bool {
        self.frames.iter().any(|s| s.is_none() || *s == number)
    }

    pub fn sets_tool(&self, number: Option<u64>) -> bool {
        self.tools.iter().any(|s| s.is_none() || *s == number)
    }

    /// What positions in a frame mean that the program sets is known only while it runs; `first`: the first word, in upper case.
    ///
    /// `setting = ("UFRAME" | "UTOOL") "[" number ... "]" "=" ... | ("$MNUFRAME" | "$MNUTOOL") "[" group "," number "]" "=" ...`
    fn frame_setting(&mut self, first: &[u8]) {
        let lists = [&mut self.frames, &mut self.tools];
        for (list, (system, name)) in
            lists.into_iter().zip([(&b"$MNUFRAME["[..], &b"UFRAME["[..]), (b"$MNUTOOL[", b"UTOOL[")])
        {
            if let Some(inside) = first.strip_prefix(system) {
                let inside = inside.split(|b| *b == b']').next().unwrap_or_default();
                let number = inside.split(|b| *b == b',').nth(1).and_then(|n| std::str::from_utf8(n).ok());
                list.push(number.and_then(|n| n.trim().parse().ok()));
            } else if let Some(inside) = first.strip_prefix(name) {
                let mut cursor = Cursor::new(inside);
                let number = integer(cursor.digits());
                list.push(number.filter(|_| matches!(cursor.peek(), Some(b']' | b':'))));
            }
        }
    }

    /// Positions that word `k` of a statement names: written where the statement begins with it and `=` follows, else read.
    ///
    /// `statement = "P" "[" index "]" "=" ... | ... "P" "[" index "]" ...`
    fn positions_of_word(&mut self, text: &Text, words: &[Range<usize>], k: usize) {
        let Some(word) = words.get(k) else { return };
        let bytes = text.slice(word.clone());
        for at in memchr::memmem::find_iter(&bytes.to_ascii_uppercase(), b"P[") {
            if at > 0 && (bytes[at - 1].is_ascii_alphanumeric() || b"_$".contains(&bytes[at - 1])) {
                continue;
            }
            let close = memchr::memchr(b']', &bytes[at..bytes.len().min(at + NEAR)]).map_or(at + 2, |n| at + n + 1);
            let found = index(text, word.start + at..word.start + close).map(|i| i.1);
            let next = bytes.get(close).or_else(|| words.get(k + 1).and_then(|w| text.bytes.get(w.start)));
            let line = text.line_of(word.start);
            let writes = k == 0 && at == 0 && next == Some(&b'=');
            match (found, writes) {
                (Some(n), true) => drop(self.written.insert(n, line)),
                (None, true) => self.written_any = Some(line),
                (Some(n), false) => drop(self.read.insert(n)),
                (None, false) => self.read_any = true,
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
