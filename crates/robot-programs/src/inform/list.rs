//! The list of positions with the headers in force at each of them, and its counts.

use super::job::{KINDS, Kind, Meaning, Positions, Section};
use crate::error::Result;
use crate::script::cursor::unmarked;
use crate::script::{Text, number};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// The list of positions.
#[derive(Default)]
pub(super) struct List {
    pub(super) positions: Positions,
    pub(super) by_name: ByName,
    pub(super) counts: Vec<Range<usize>>,
    pub(super) base_axes: bool,
    /// The job's group where it is not that of the first robot: `RB2`, `ST1`.
    pub(super) foreign: Option<String>,
}

/// Positions by their names. Nearly all of a kind have the numbers from 0 on.
#[derive(Default)]
pub(super) struct ByName {
    /// By kind and number.
    dense: [Vec<u32>; KINDS.len()],
    others: BTreeMap<(Kind, u32), u32>,
}

/// No position.
const NONE: u32 = u32::MAX;

impl ByName {
    pub(super) fn get(&self, (kind, number): (Kind, u32)) -> Option<usize> {
        let dense = self.dense.get(kind as usize)?.get(number as usize).filter(|p| **p != NONE);
        dense.or_else(|| self.others.get(&(kind, number))).map(|p| *p as usize)
    }

    /// `false`: there is one of this name.
    fn insert(&mut self, (kind, number): (Kind, u32), position: usize) -> bool {
        /// Numbers so far beyond those that were met stand elsewhere.
        const FAR: usize = 1024;
        if self.get((kind, number)).is_some() {
            return false;
        }
        let Some(dense) = self.dense.get_mut(kind as usize) else { return false };
        let n = number as usize;
        if n >= dense.len() && n > dense.len() + FAR {
            self.others.insert((kind, number), position as u32);
            return true;
        }
        if n >= dense.len() {
            dense.resize(n + 1, NONE);
        }
        if let Some(place) = dense.get_mut(n) {
            *place = position as u32;
        }
        true
    }
}

/// Digits with a sign or none, as few as a number holds.
///
/// `whole = ["+" | "-"] digit {digit}`
fn is_whole(bytes: &[u8]) -> bool {
    let digits = bytes.strip_prefix(b"-").or_else(|| bytes.strip_prefix(b"+")).unwrap_or(bytes);
    (1..=usize::from(crate::decimal::MOST)).contains(&digits.len()) && digits.iter().all(u8::is_ascii_digit)
}

impl List {
    /// Reads the headers and the list; returns the first line (from 0) of the instructions.
    ///
    /// `job = "/JOB" {section} "//INST" ...`,
    /// `section = "//POS" {header | position} | "//NAME" ... {"/" ... | "'" ...} | "//" ... {line}`
    pub(super) fn read(&mut self, text: &Text) -> Result<usize> {
        let lines = text.line_count();
        let mut section = Arc::<Section>::default();
        let (mut begun, mut in_list, mut in_other) = (false, false, false);
        for k in 0..lines {
            let line = text.line(k).trim_ascii();
            let at = text.line_span(k).start;
            if line.is_empty() {
                continue;
            }
            if !begun {
                let line = unmarked(line);
                if !line.eq_ignore_ascii_case(b"/JOB") {
                    return Err(text.bad(at, shown(line), "`/JOB`, the first line of an INFORM job"));
                }
                begun = true;
                continue;
            }
            if line.eq_ignore_ascii_case(b"/JOB") {
                return Err(text.bad(at, "a second `/JOB`", "one job in a file"));
            }
            if line.eq_ignore_ascii_case(b"//POS") {
                (in_list, in_other) = (true, false);
            } else if line.eq_ignore_ascii_case(b"//INST") {
                self.check_counts(text, at)?;
                return Ok(self.groups(text, k + 1));
            } else if line.starts_with(b"//") && !line.starts_with(b"///") {
                // `//NAME`, `//ARGINFO`, whose lines may be any words
                (in_list, in_other) = (false, !line.to_ascii_uppercase().starts_with(b"//NAME"));
            } else if in_other {
                continue;
            } else if line.starts_with(b"/") {
                if in_list {
                    self.header(text, k, line, Arc::make_mut(&mut section))?;
                }
            } else if in_list {
                self.position(text, k, &section)?;
            } else if !line.starts_with(b"'") {
                // a comment says nothing
                return Err(text.bad(at, shown(line), "a header that begins with `//`, or `//POS`"));
            }
        }
        Err(text.bad(text.bytes.len(), "the end of the file", "`//INST`"))
    }

    /// Skips the headers of the instructions; notes whose axes the job moves, and whether a base axis is one of them.
    ///
    /// `head = {blank | "///GROUP1" group {("," | "+") group} | "//" ...}`
    pub(super) fn groups(&mut self, text: &Text, from: usize) -> usize {
        let mut k = from;
        while k < text.line_count() {
            let line = text.line(k).trim_ascii();
            if !line.is_empty() && !line.starts_with(b"//") {
                break;
            }
            let upper = String::from_utf8_lossy(line).to_ascii_uppercase();
            self.base_axes |= upper.starts_with("///GROUP") && upper.contains("BS");
            if let Some(named) = upper.strip_prefix("///GROUP1") {
                let first = named.trim().split([',', '+', ' ', '\t']).next().unwrap_or_default();
                self.foreign = (!first.is_empty() && !matches!(first, "RB1" | "R1")).then(|| first.to_string());
            }
            k += 1;
        }
        k
    }

    /// A header of the list: it holds for the positions after it.
    ///
    /// `header = npos | ("///USER" | "///TOOL" | "///RCONF") ... | "///PULSE" | "///ANGLE" | "///RECTAN" | "///POSTYPE" meaning | "/" ...`,
    /// `meaning = "PULSE" | "ANGLE" | "BASE" | "ROBOT" | "USER" | word`
    pub(super) fn header(&mut self, text: &Text, k: usize, line: &[u8], section: &mut Section) -> Result<()> {
        let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
        let (word, rest) = line.split_at(end);
        let rest = String::from_utf8_lossy(rest.trim_ascii()).to_ascii_uppercase();
        match String::from_utf8_lossy(word).to_ascii_uppercase().as_str() {
            "///NPOS" => self.npos(text, k)?,
            "///USER" => section.user = Some(k as u32),
            "///TOOL" => section.tool = Some(k as u32),
            "///RCONF" => section.rconf = Some(k as u32),
            "///PULSE" | "///ANGLE" | "///RECTAN" => section.form = Some(k as u32),
            "///POSTYPE" => {
                section.postype = Some(k as u32);
                section.form = None;
                section.meaning = match rest.as_str() {
                    "PULSE" => Meaning::Pulse,
                    "ANGLE" => Meaning::Angle,
                    "BASE" => Meaning::Base,
                    "ROBOT" => Meaning::Robot,
                    "USER" => Meaning::User,
                    _ => Meaning::Other,
                };
            }
            _ => {}
        }
        Ok(())
    }

    /// The counts of the positions.
    ///
    /// `npos = "///NPOS" count "," count "," count "," count "," count "," count`
    pub(super) fn npos(&mut self, text: &Text, k: usize) -> Result<()> {
        let span = text.line_span(k);
        if !self.counts.is_empty() {
            return Err(text.bad(span.start, "a second `///NPOS`", "one"));
        }
        let line = text.line(k);
        let from = line.iter().position(|b| b.is_ascii_digit()).unwrap_or(line.len());
        self.counts = fields(text, span.start + from..span.start + line.len());
        let whole = |r: &Range<usize>| text.slice(r.clone()).iter().all(u8::is_ascii_digit) && !r.is_empty();
        if self.counts.len() != 6 || !self.counts.iter().all(whole) {
            return Err(text.bad(span.start + from, shown(&line[from..]), "six counts: C,BC,EC,P,BP,EX"));
        }
        Ok(())
    }

    /// A line of the list.
    ///
    /// `position = name "=" number {"," number}`
    pub(super) fn position(&mut self, text: &Text, k: usize, section: &Arc<Section>) -> Result<()> {
        let (start, line) = (text.line_span(k).start, text.line(k));
        let equals = line.iter().position(|&b| b == b'=').unwrap_or(line.len());
        let name = line[..equals].trim_ascii();
        let Some((kind, number, digits)) = Kind::read(name).filter(|_| equals < line.len()) else {
            return Err(text.bad(start, shown(line), "a position such as `C00000=...`, a header, or `//INST`"));
        };
        let numbers = fields(text, start + equals + 1..start + line.len());
        for n in &numbers {
            let bytes = text.slice(n.clone());
            if is_whole(bytes) {
                continue;
            }
            let read = number::read(bytes);
            let whole = section.meaning != Meaning::Pulse || read.is_some_and(|(_, s)| !s.point && !s.exponent);
            if read.is_none() || !whole {
                let expected = if section.meaning == Meaning::Pulse { "a whole number of pulses" } else { "a number" };
                return Err(text.bad(n.start, shown(bytes), expected));
            }
        }
        if !self.by_name.insert((kind, number), self.positions.len()) {
            return Err(text.bad(start, format!("{} a second time", shown(name)), "every position once"));
        }
        self.positions.push((kind, number, digits), k, section, numbers);
        Ok(())
    }

    pub(super) fn check_counts(&self, text: &Text, at: usize) -> Result<()> {
        if self.counts.is_empty() {
            return if self.positions.is_empty() {
                Ok(())
            } else {
                Err(text.bad(at, "no `///NPOS`", "the counts of the positions"))
            };
        }
        for ((kind, word), span) in KINDS.iter().zip(&self.counts) {
            let real = self.positions.iter().filter(|p| p.kind == *kind).count();
            let said = String::from_utf8_lossy(text.slice(span.clone())).parse::<usize>().ok();
            if said != Some(real) {
                let found = format!("{} {word} positions in `///NPOS`", shown(text.slice(span.clone())));
                return Err(text.bad(span.start, found, format!("{real}, as many as there are")));
            }
        }
        Ok(())
    }
}

/// Fields between commas, without the spaces around them.
///
/// `fields = field {"," field}`
fn fields(text: &Text, span: Range<usize>) -> Vec<Range<usize>> {
    let commas = memchr::memchr_iter(b',', text.slice(span.clone())).count();
    let mut found = Vec::with_capacity(commas + 1);
    let mut at = span.start;
    for field in text.slice(span).split(|&b| b == b',') {
        let lead = field.len() - field.trim_ascii_start().len();
        let len = field.trim_ascii().len();
        let start = if len == 0 { at } else { at + lead };
        found.push(start..start + len);
        at += field.len() + 1;
    }
    found
}

pub(super) fn shown(bytes: &[u8]) -> String {
    format!("`{}`", String::from_utf8_lossy(bytes.get(..60).unwrap_or(bytes)))
}
