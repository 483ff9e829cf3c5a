//! Lines of `/MN`: numbers, statements that go on over several lines, their words.

use crate::error::{Error, Result};
use crate::script::Text;
use std::ops::Range;

/// A line number of the program.
#[derive(Debug, Clone)]
pub(super) struct Numbered {
    /// From the line's first byte to the colon.
    pub field: Range<usize>,
    pub number: u64,
}

/// A statement: one instruction up to its `;`.
#[derive(Debug, Clone, Default)]
pub(super) struct Statement {
    /// Of its first line, from 0.
    pub line: usize,
    /// First byte of its first line, and the colon there.
    pub start: usize,
    pub colon: usize,
    /// The number before the colon; blank where there is none.
    pub number: Option<u64>,
    /// What stands after the colons, line by line, without the `;`.
    pub pieces: Vec<Range<usize>>,
    /// A line of point logic: it belongs to the motion before it.
    pub nested: bool,
}

/// What a line of `/MN` is.
enum Line {
    Blank,
    /// `   5:J P[1] ...`: colon, number.
    Colon(usize, Option<u64>),
    /// `------ ;`: the end of point logic.
    Rule,
    /// `;` alone.
    End,
    Other,
}

fn line_of(text: &Text, k: usize) -> Line {
    let span = text.line_span(k);
    let bytes = text.line(k);
    let content = bytes.trim_ascii();
    if content.is_empty() {
        return Line::Blank;
    }
    if content == b";" {
        return Line::End;
    }
    if content.starts_with(b"--") && content.iter().all(|b| b"- ;".contains(b)) {
        return Line::Rule;
    }
    let Some(colon) = memchr::memchr(b':', bytes) else { return Line::Other };
    let digits = bytes[..colon].trim_ascii();
    if digits.is_empty() {
        return Line::Colon(span.start + colon, None);
    }
    match std::str::from_utf8(digits).ok().filter(|d| d.bytes().all(|b| b.is_ascii_digit())).map(str::parse::<u32>) {
        Some(Ok(number)) => Line::Colon(span.start + colon, Some(u64::from(number))),
        _ => Line::Other,
    }
}

/// The statements of lines `lines`, and the numbers that a new line shifts.
pub(super) fn statements(text: &Text, lines: Range<usize>) -> Result<(Vec<Statement>, Vec<Numbered>)> {
    let (mut out, mut numbered): (Vec<Statement>, Vec<Numbered>) = (Vec::new(), Vec::new());
    let mut open: Option<Statement> = None;
    // a remark with a number goes on in indented lines without one, up to its `;`
    let mut remark = false;
    let mut nested = false;
    for k in lines {
        let span = text.line_span(k);
        let content_end = span.start + text.line(k).len();
        let (colon, number) = match line_of(text, k) {
            Line::Blank => continue,
            // the end of a statement on a line of its own, or an empty statement without a number
            Line::End => {
                out.extend(open.take());
                continue;
            }
            Line::Rule if nested => {
                nested = false;
                continue;
            }
            Line::Colon(colon, number) => (colon, number),
            Line::Rule | Line::Other => {
                return Err(text.bad(
                    span.start,
                    format!("`{}`", shown(text.line(k))),
                    "a program line such as `   5:J P[1] 100% FINE    ;`",
                ));
            }
        };
        let body = colon + 1..content_end;
        let indented = text.line(k).first().is_some_and(u8::is_ascii_whitespace);
        remark &= number.is_none() && indented && !motion_like(text.slice(body.clone()));
        if remark {
            remark = !text.slice(body).trim_ascii_end().ends_with(b";");
            continue;
        }
        if let Some(s) = &open {
            // a statement goes on in indented lines without a number, and only one that has a number: elsewhere such a
            // line may as well be the next statement
            if number.is_some() || s.number.is_none() || !indented || motion_like(text.slice(body.clone())) {
                return Err(endless(text, s));
            }
        }
        if nested && motion_like(text.slice(body.clone())) {
            nested = false;
        }
        if let (Some(number), false) = (number, nested) {
            numbered.push(Numbered { field: span.start..colon, number });
        }
        let mut statement = open.take().unwrap_or_else(|| Statement {
            line: k,
            start: span.start,
            colon,
            number,
            pieces: Vec::new(),
            nested,
        });
        let content = text.slice(body.clone()).trim_ascii_end();
        let comment = statement.pieces.is_empty() && is_comment(content);
        let closed = content.strip_suffix(b";");
        let piece = body.start..body.start + closed.map_or(content.len(), <[u8]>::len);
        statement.pieces.push(piece);
        let blank = content.trim_ascii().is_empty() && statement.pieces.len() == 1;
        remark = comment && closed.is_none() && statement.number.is_some();
        if closed.is_none() && !comment && !blank {
            open = Some(statement);
            continue;
        }
        // also of a motion that is switched off
        let motion = !comment || content.trim_ascii_start().starts_with(b"//");
        if motion && statement.pieces.iter().any(|p| has(text.slice(p.clone()), b"P-SPS")) {
            nested = true;
        }
        out.push(statement);
    }
    match open {
        Some(s) => Err(endless(text, &s)),
        None => Ok((out, numbered)),
    }
}

fn endless(text: &Text, s: &Statement) -> Error {
    let first = s.pieces.first().map_or(&[][..], |p| text.slice(p.clone()));
    text.bad(s.colon, format!("`:{}`, a statement without an end", shown(first)), "`;` at the end of a statement")
}

/// `!`, `--eg:` (a comment in a language) and `//` (a statement that is switched off).
pub(super) fn is_comment(content: &[u8]) -> bool {
    let content = content.trim_ascii_start();
    content.starts_with(b"!") || content.starts_with(b"--") || content.starts_with(b"//")
}

fn motion_like(content: &[u8]) -> bool {
    let mut words = content.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
    words.next().is_some_and(|w| w.len() == 1) && words.next().is_some_and(|w| is_position(w) || is_register(w))
}

/// `P[...`.
pub(super) fn is_position(word: &[u8]) -> bool {
    word.get(..2).is_some_and(|h| h.eq_ignore_ascii_case(b"P["))
}

/// `PR[...`.
pub(super) fn is_register(word: &[u8]) -> bool {
    word.get(..3).is_some_and(|h| h.eq_ignore_ascii_case(b"PR["))
}

/// Whether `needle` occurs, whatever its case.
pub(super) fn has(bytes: &[u8], needle: &[u8]) -> bool {
    bytes.windows(needle.len()).any(|w| w.eq_ignore_ascii_case(needle))
}

/// Words of a statement: split at blanks, but not within brackets.
pub(super) fn words(text: &Text, statement: &Statement) -> Vec<Range<usize>> {
    let mut out = Vec::new();
    for piece in &statement.pieces {
        let bytes = text.slice(piece.clone());
        let (mut start, mut depth) = (None, 0_usize);
        for (i, &b) in bytes.iter().enumerate() {
            match b {
                b'[' => depth += 1,
                b']' => depth = depth.saturating_sub(1),
                _ => {}
            }
            if b.is_ascii_whitespace() && depth == 0 {
                if let Some(s) = start.take() {
                    out.push(piece.start + s..piece.start + i);
                }
            } else {
                start = start.or(Some(i));
            }
        }
        if let Some(s) = start {
            out.push(piece.start + s..piece.end);
        }
    }
    out
}

/// Bytes for a message.
pub(super) fn shown(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes.trim_ascii()).chars().take(60).collect()
}

/// Index of `P[3]` or `P[3:name]`: its digits, and the value; `None` where it is computed.
pub(super) fn index(text: &Text, word: Range<usize>) -> Option<(Range<usize>, u64)> {
    let bytes = text.slice(word.clone());
    let open = memchr::memchr(b'[', bytes)? + 1;
    let close = memchr::memrchr(b']', bytes)?;
    let inside = bytes.get(open..close)?;
    let digits = &inside[..memchr::memchr(b':', inside).unwrap_or(inside.len())];
    let lead = digits.len() - digits.trim_ascii_start().len();
    let digits = digits.trim_ascii();
    let value: u32 =
        std::str::from_utf8(digits).ok().filter(|d| d.bytes().all(|b| b.is_ascii_digit()))?.parse().ok()?;
    let start = word.start + open + lead;
    Some((start..start + digits.len(), u64::from(value)))
}
