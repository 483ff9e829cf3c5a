//! Items of a list of points: where one stands with its comments, and where new ones go.

use super::Writer;
use crate::error::Result;
use crate::script::{Patch, pragma};
use crate::trajectory::read::Time;
use std::ops::Range;

impl Writer<'_> {
    /// Bytes of an item as they are copied: from its dash, or its brace, to its last line's end.
    pub(super) fn item(&self, point: usize) -> Result<Range<usize>> {
        let Some(p) = self.trajectory.points.get(point) else { return Ok(0..0) };
        if self.trajectory.brackets {
            return Ok(p.span.range());
        }
        let line = self.text.line_span(self.text.line_of(p.span.end().max(1) - 1) as usize - 1);
        Ok(self.dash(point)?..line.end)
    }

    /// Bytes of a comment with the blanks before it; with its line where it is alone on it.
    pub(super) fn comment(&self, comment: &Range<usize>, first: usize) -> Range<usize> {
        let head = self.text.slice(first..comment.start);
        let start = first + head.len() - head.iter().rev().take_while(|b| matches!(b, b' ' | b'\t')).count();
        let alone = start > first && matches!(self.text.bytes.get(start - 1), Some(b'\n'));
        let line_end = self.text.slice(comment.end..comment.end + 2);
        let ending = if line_end.starts_with(b"\r\n") { 2 } else { usize::from(line_end.starts_with(b"\n")) };
        start..comment.end + if alone { ending } else { 0 }
    }

    /// What stands between a point and the one before it, with comments as blanks.
    fn gap(&self, point: usize) -> (usize, Vec<u8>) {
        let end = self.trajectory.points.get(point).map_or(0, |p| p.span.start());
        let before = point.checked_sub(1).and_then(|b| self.trajectory.points.get(b));
        let start = before.map_or(end, |b| b.span.end()).min(end);
        let mut gap = self.text.slice(start..end).to_vec();
        for c in self.document.tree.comments_in(&(start..end)) {
            for b in c.clone() {
                if let Some(b) = b.checked_sub(start).and_then(|k| gap.get_mut(k)) {
                    *b = b' ';
                }
            }
        }
        (start, gap)
    }

    /// Place of a block item's dash.
    fn dash(&self, point: usize) -> Result<usize> {
        let (start, gap) = self.gap(point);
        let dash = gap.iter().rposition(|&b| b == b'-').map(|k| start + k);
        let p = &self.trajectory.points[point];
        dash.ok_or_else(|| self.refused(p, "the point's dash cannot be found; write the points one below the other"))
    }

    /// Blanks from the start of the line to a byte; `None`: something else stands there.
    fn indentation(&self, byte: usize) -> Option<&[u8]> {
        let line = self.text.line_span(self.text.line_of(byte) as usize - 1);
        let head = self.text.slice(line.start..byte);
        head.iter().all(|b| matches!(b, b' ' | b'\t')).then_some(head)
    }

    /// New items after the point before, and after its comments on its line; before the comments of this one.
    pub(super) fn insertion(&self, point: usize, copies: &[Vec<u8>]) -> Result<Patch> {
        let p = &self.trajectory.points[point];
        let (start, gap) = self.gap(point);
        let brackets = self.trajectory.brackets;
        let comma = if brackets { gap.iter().position(|&b| b == b',').map_or(0, |k| k + 1) } else { 0 };
        // a word to the tool holds from its place on: the new points stand after it
        let comments = self.document.tree.comments_in(&(start..start + gap.len()));
        let told = comments.iter().rev().find(|c| pragma(self.text.slice((*c).clone())).is_some());
        let from = told.map_or(0, |c| c.end.saturating_sub(start)).max(comma);
        let line = gap.iter().skip(from).position(|&b| b == b'\n').map(|k| start + from + k + 1);
        let first = if brackets { p.span.start() } else { self.dash(point)? };
        let separator: &[u8] = if brackets { b"," } else { b"" };
        let mut bytes = Vec::new();
        if let (Some(at), Some(indentation)) = (line, self.indentation(first)) {
            for copy in copies {
                bytes.extend_from_slice(indentation);
                bytes.extend_from_slice(copy);
                bytes.extend_from_slice(separator);
                bytes.extend_from_slice(self.text.ending(at - 1));
            }
            return Ok(Patch::new(0, at..at, bytes));
        }
        if !brackets {
            return Err(self.refused(p, "the point does not begin on a separate line; no point can be put before it"));
        }
        let blank = gap.get(comma..).unwrap_or_default();
        for copy in copies {
            bytes.extend_from_slice(copy);
            bytes.extend_from_slice(separator);
            bytes.extend_from_slice(blank);
        }
        Ok(Patch::new(0, first..first, bytes))
    }

    /// The time in the copy; a part that is left out (0) is written where it is needed.
    pub(super) fn swap_time(&self, time: &Time, text: &str, swaps: &mut Vec<(Range<usize>, Vec<u8>)>) {
        match time {
            Time::Seconds(n) => swaps.push((n.span.range(), text.into())),
            Time::Parts { sec, nano, braces, ros1, quote } => {
                let (s, ns) = text.split_once('.').unwrap_or((text, "0"));
                let ns = ns.trim_start_matches('0');
                let ns = if ns.is_empty() { "0" } else { ns };
                let names = if *ros1 { ["secs", "nsecs"] } else { ["sec", "nanosec"] };
                for (n, other, text, name) in [(sec, nano, s, names[0]), (nano, sec, ns, names[1])] {
                    if let Some(n) = n {
                        let point = if n.style.point { ".0" } else { "" };
                        swaps.push((n.span.range(), format!("{text}{point}").into()));
                    } else if let (Some(other), true) = (other, text != "0") {
                        let q = quote.map_or(String::new(), |q| char::from(q).to_string());
                        let entry = format!("{q}{name}{q}: {text}");
                        let line = self.text.line_span(self.text.line_of(other.span.start()) as usize - 1);
                        let head = self.text.slice(line.start..other.span.start());
                        let blanks = head.iter().take_while(|b| matches!(b, b' ' | b'\t')).count();
                        let mut bytes =
                            if *braces { b", ".to_vec() } else { self.text.ending(other.span.end()).to_vec() };
                        if !*braces {
                            bytes.extend_from_slice(&head[..blanks]);
                        }
                        bytes.extend_from_slice(entry.as_bytes());
                        swaps.push((other.span.end()..other.span.end(), bytes));
                    }
                }
            }
        }
    }
}
