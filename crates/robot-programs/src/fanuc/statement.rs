//! Lines of `/MN`: numbers, statements that go on over several lines, their words.

use crate::error::{Error, Result};
use crate::script::Text;
use crate::script::cursor::{Cursor, integer, strip_word};
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

/// `line = blank | ";" | rule | [number] ":" text`,
/// `rule = "--" {"-" | " " | ";"}`
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
    let number = integer::<u32>(digits).map(u64::from);
    number.map_or(Line::Other, |number| Line::Colon(span.start + colon, Some(number)))
}

/// The statements of lines `lines`, and the numbers that a new line shifts.
///
/// `statement = [number] ":" text {newline blank ":" text} ";"`,
/// `remark = [number] ":" ("!" | "--" | "//") text {newline blank ":" text} [";"]`
pub(super) fn statements(text: &Text, lines: Range<usize>) -> Result<(Vec<Statement>, Vec<Numbered>)> {
    let (done, numbered) = (Vec::new(), Vec::new());
    let mut assembly = Assembly { text, done, numbered, open: None, remark: false, nested: false };
    for k in lines {
        assembly.line(k)?;
    }
    match assembly.open {
        Some(s) => Err(endless(text, &s)),
        None => Ok((assembly.done, assembly.numbered)),
    }
}

/// Statements that are put together line by line.
struct Assembly<'a> {
    text: &'a Text,
    done: Vec<Statement>,
    numbered: Vec<Numbered>,
    /// A statement whose `;` has not come yet.
    open: Option<Statement>,
    /// The line before belongs to a remark with a number, which goes on in indented lines without one, up to its `;`.
    remark: bool,
    /// Within point logic.
    nested: bool,
}

impl Assembly<'_> {
    fn line(&mut self, k: usize) -> Result<()> {
        match line_of(self.text, k) {
            Line::Blank => {}
            // the end of a statement on a separate line, or an empty statement without a number
            Line::End => self.done.extend(self.open.take()),
            Line::Rule if self.nested => self.nested = false,
            Line::Colon(colon, number) => self.after_colon(k, colon, number)?,
            Line::Rule | Line::Other => {
                let found = format!("`{}`", shown(self.text.line(k)));
                let expected = "a program line such as `   5:J P[1] 100% FINE    ;`";
                return Err(self.text.bad(self.text.line_span(k).start, found, expected));
            }
        }
        Ok(())
    }

    /// A line with its colon: it begins a statement, or the statement or remark before goes on in it.
    fn after_colon(&mut self, k: usize, colon: usize, number: Option<u64>) -> Result<()> {
        let text = self.text;
        let body = colon + 1..text.line_span(k).start + text.line(k).len();
        let indented = text.line(k).first().is_some_and(u8::is_ascii_whitespace);
        let is_motion = || motion_like(text.slice(body.clone()));
        let goes_on = || number.is_none() && indented && !is_motion();
        self.remark = self.remark && goes_on();
        if self.remark {
            self.remark = !text.slice(body).trim_ascii_end().ends_with(b";");
            return Ok(());
        }
        if let Some(s) = &self.open {
            // only a statement that has a number goes on: elsewhere such a line may as well be the next statement
            if s.number.is_none() || !goes_on() {
                return Err(endless(text, s));
            }
        }
        self.nested = self.nested && !is_motion();
        let start = text.line_span(k).start;
        if let (Some(number), false) = (number, self.nested) {
            self.numbered.push(Numbered { field: start..colon, number });
        }
        let nested = self.nested;
        let statement = self.open.take().unwrap_or_else(|| Statement {
            line: k,
            start,
            colon,
            number,
            pieces: Vec::with_capacity(1),
            nested,
        });
        self.extend(statement, body);
        Ok(())
    }

    /// A statement with a further piece, which ends it where that ends in `;`, is a remark, or is the only one and blank.
    fn extend(&mut self, mut statement: Statement, body: Range<usize>) {
        let text = self.text;
        let content = without_remark(text.slice(body.clone())).trim_ascii_end();
        let comment = statement.pieces.is_empty() && is_comment(content);
        let closed = content.strip_suffix(b";");
        let piece = body.start..body.start + closed.map_or(content.len(), <[u8]>::len);
        statement.pieces.push(piece);
        let blank = content.trim_ascii().is_empty() && statement.pieces.len() == 1;
        self.remark = comment && closed.is_none() && statement.number.is_some();
        if closed.is_none() && !comment && !blank {
            self.open = Some(statement);
            return;
        }
        // also of a motion that is switched off
        let motion = !comment || content.trim_ascii_start().starts_with(b"//");
        if motion && statement.pieces.iter().any(|p| has(text.slice(p.clone()), b"P-SPS")) {
            self.nested = true;
        }
        self.done.push(statement);
    }
}

/// A line up to the `;` that ends its statement, where a remark stands after that: people write them into listings by hand.
///
/// `line = text ";" "!" remark`
fn without_remark(content: &[u8]) -> &[u8] {
    if is_comment(content) {
        return content;
    }
    let ends = |at: &usize| content[at + 1..].trim_ascii_start().starts_with(b"!");
    memchr::memchr_iter(b';', content).find(ends).map_or(content, |at| &content[..=at])
}

fn endless(text: &Text, s: &Statement) -> Error {
    let first = s.pieces.first().map_or(&[][..], |p| text.slice(p.clone()));
    text.bad(s.colon, format!("`:{}`, a statement without an end", shown(first)), "`;` at the end of a statement")
}

/// `!`, `--eg:` (a comment in a language) and `//` (a statement that is switched off).
///
/// `comment = ("!" | "--" | "//") text`
pub(super) fn is_comment(content: &[u8]) -> bool {
    let content = content.trim_ascii_start();
    content.starts_with(b"!") || content.starts_with(b"--") || content.starts_with(b"//")
}

/// `motion = letter ("P[" | "PR[") ...`
fn motion_like(content: &[u8]) -> bool {
    let mut words = content.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
    words.next().is_some_and(|w| w.len() == 1) && words.next().is_some_and(|w| is_position(w) || is_register(w))
}

/// `P[...`.
pub(super) fn is_position(word: &[u8]) -> bool {
    strip_word(word, b"P[").is_some()
}

/// `PR[...`.
pub(super) fn is_register(word: &[u8]) -> bool {
    strip_word(word, b"PR[").is_some()
}

/// Whether `needle` occurs, whatever its case.
pub(super) fn has(bytes: &[u8], needle: &[u8]) -> bool {
    bytes.windows(needle.len()).any(|w| w.eq_ignore_ascii_case(needle))
}

/// Words of a statement: split at blanks, but not within brackets.
///
/// `words = word {blank word}, blanks within "[" "]" being part of the word`
pub(super) fn words(text: &Text, statement: &Statement) -> Vec<Range<usize>> {
    // those of a motion: all statements of a program are held at once
    let mut out = Vec::with_capacity(4);
    for piece in &statement.pieces {
        let mut cursor = Cursor::new(text.slice(piece.clone()));
        loop {
            cursor.blanks();
            let (from, mut depth) = (cursor.at(), 0_usize);
            cursor.while_is(|b| {
                match b {
                    b'[' => depth += 1,
                    b']' => depth = depth.saturating_sub(1),
                    _ => {}
                }
                depth > 0 || !b.is_ascii_whitespace()
            });
            if cursor.at() == from {
                break;
            }
            out.push(piece.start + from..piece.start + cursor.at());
        }
    }
    out
}

/// The name with which an instruction begins, without what is joined to it.
///
/// `name = {letter | digit | "_"}`
pub(super) fn name_of(word: &[u8]) -> &[u8] {
    Cursor::new(word).while_is(|b| b.is_ascii_alphanumeric() || b == b'_')
}

/// The name of a program.
///
/// `name = {letter | digit | "_" | "-"}`
pub(super) fn program_name(rest: &[u8]) -> &[u8] {
    Cursor::new(rest).while_is(|b| b.is_ascii_alphanumeric() || b"_-".contains(&b))
}

/// Bytes for a message.
pub(super) fn shown(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes.trim_ascii()).chars().take(60).collect()
}

/// Index of `P[3]` or `P[3:name]`: its digits, and the value; `None` where it is computed.
///
/// `index = "[" digit {digit} [":" name] "]"`
pub(super) fn index(text: &Text, word: Range<usize>) -> Option<(Range<usize>, u64)> {
    let bytes = text.slice(word.clone());
    let open = memchr::memchr(b'[', bytes)? + 1;
    let close = memchr::memrchr(b']', bytes)?;
    let inside = bytes.get(open..close)?;
    let digits = &inside[..memchr::memchr(b':', inside).unwrap_or(inside.len())];
    let lead = digits.len() - digits.trim_ascii_start().len();
    let digits = digits.trim_ascii();
    let value: u32 = integer(digits)?;
    let start = word.start + open + lead;
    Some((start..start + digits.len(), u64::from(value)))
}
