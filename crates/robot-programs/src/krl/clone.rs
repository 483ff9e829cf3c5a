//! A point's second form: a declaration of its own with a free name, in an inline form together with all that it couples.

use super::form::{Reference, references};
use super::lex::{Kind, tokens, upper};
use super::write::{Change, motion_of, place, texts};
use super::{Program, Source};
use crate::error::{Error, Result};
use crate::script::{Patch, Patches, Text};
use std::collections::{HashMap, HashSet};
use std::ops::Range;

/// KRL's longest name.
const LONGEST: usize = 24;

/// Words that a new name must not be.
#[derive(Default)]
pub(super) struct Taken {
    words: HashSet<String>,
    /// Where the count of clones of a name goes on.
    next: HashMap<String, u32>,
}

/// Every word of the program, in upper case.
pub(super) fn words(program: &Program) -> Taken {
    let mut out = HashSet::new();
    let mut line = Vec::new();
    for text in program.script.texts.iter().filter(|t| !t.context) {
        for k in 0..text.line_count() {
            tokens(text, k, &mut line);
            out.extend(line.iter().filter(|t| t.kind == Kind::Word).map(|t| upper(text, t)));
            for t in line.iter().filter(|t| t.kind == Kind::Comment) {
                let comment = String::from_utf8_lossy(text.slice(t.span())).to_ascii_uppercase();
                out.extend(comment.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).map(str::to_string));
            }
        }
    }
    out.extend(program.data.names.iter().filter(|n| n.context).map(|n| n.text.to_ascii_uppercase()));
    out.extend(program.data.frames.keys().cloned());
    Taken { words: out, next: HashMap::new() }
}

impl Taken {
    /// A free name from `stem`; in an inline form the names of its point and frame data are free too.
    fn fresh(&mut self, stem: &str, form: bool) -> Option<String> {
        let first = *self.next.entry(stem.to_ascii_uppercase()).or_insert(2);
        for i in first..1_000_000 {
            let suffix = format!("_{i}");
            let room = LONGEST - suffix.len() - usize::from(form);
            let cut: String = stem.chars().take_while(char::is_ascii).take(room).collect();
            let new = format!("{cut}{suffix}");
            let mut all = vec![new.to_ascii_uppercase()];
            if form {
                all.extend(["X", "F"].map(|c| format!("{c}{}", all[0])));
            }
            if all.iter().all(|w| !self.words.contains(w)) {
                self.words.extend(all);
                self.next.insert(stem.to_ascii_uppercase(), i + 1);
                return Some(new);
            }
        }
        None
    }
}

/// A point's second form.
pub(super) enum Clone {
    /// A name of its own; the old one.
    Name { old: String, new: String },
    /// The values in line.
    Inline(Vec<u8>),
}

/// A line with a name replaced, wherever it stands as a word.
fn renamed(text: &Text, line: usize, name: &str, new: &str) -> Vec<u8> {
    let mut words = Vec::new();
    tokens(text, line, &mut words);
    let span = text.line_span(line);
    let mut out = Vec::new();
    let mut from = span.start;
    for t in words.iter().filter(|t| t.kind == Kind::Word && upper(text, t) == name) {
        out.extend_from_slice(text.slice(from..t.start));
        out.extend_from_slice(new.as_bytes());
        from = t.end;
    }
    out.extend_from_slice(text.slice(from..span.start + text.line(line).len()));
    out
}

/// Declares a point anew with other values, or gives its values in line where it is a variable of the routine.
pub(super) fn clone(
    program: &Program,
    step: usize,
    target: usize,
    change: &Change,
    taken: &mut Taken,
    out: &mut Patches,
) -> Result<Clone> {
    let refused = |why: &str| {
        let uses = program.script.uses().get(target).cloned().unwrap_or_default();
        let uses: Vec<String> = uses.into_iter().map(|s| place(program, s)).collect();
        Error::Refused(format!("{}: {why}; it is used at {}", place(program, step), uses.join(", ")))
    };
    let Some(Source::Name(n)) = program.sources.get(target) else { return Err(refused("the point has no name")) };
    let name = &program.data.names[*n as usize];
    let Ok(value) = name.value() else { return Err(refused("the point's value is not certain")) };
    let motion = motion_of(program, step)?;
    let values = replaced(texts(program, value.file)?, &value.span, change);
    if name.local || name.context && motion.fold().is_none() {
        if motion.fold().is_some() {
            return Err(refused("a point of the routine itself cannot be cloned in an inline form"));
        }
        return Ok(Clone::Inline(values));
    }
    let form = motion.fold().is_some();
    if form && !name.text.to_ascii_uppercase().starts_with('X') {
        return Err(refused("its inline form does not name the point as inline forms do (X and the name)"));
    }
    if form && name.of.is_some() {
        return Err(refused("an element of an array cannot be cloned in an inline form"));
    }
    let plain = name.text.split('[').next().unwrap_or_default();
    let body = if form { &name.text[1..] } else { plain };
    // the form may write the name in another case than its declaration
    let spelled = motion.fold().map(|fold| Ok(shown(texts(program, 0)?, fold, motion.line(), body))).transpose()?;
    let Some(fresh) = taken.fresh(spelled.as_deref().unwrap_or(body), form) else {
        return Err(refused("no name is free for a clone of the point"));
    };
    let first = |s: &str| s.get(..1).unwrap_or_default().to_string();
    let new = if form { format!("{}{fresh}", first(&name.text)) } else { fresh.clone() };
    let text = texts(program, name.file)?;
    // a point of another module parts into the program's own data list
    let (file, following) = match name.context {
        false => (name.file, name.line),
        true => own_list(program)
            .ok_or_else(|| refused("there is no data list (.dat) beside the program for a clone of the point"))?,
    };
    let mut line = b"DECL ".to_vec();
    line.extend_from_slice(text.slice(name.type_word.clone()));
    line.extend_from_slice(format!(" {new}=").as_bytes());
    line.extend_from_slice(&values);
    let mut lines = vec![line];
    if form && let Some(fold) = motion.fold() {
        let frame = format!("F{}", body.to_ascii_uppercase());
        let framed = |r: &Reference| r.head.is_some_and(|h| h.eq_ignore_ascii_case(&b'F'));
        if references(texts(program, 0)?, fold, motion.line(), body).iter().any(framed) {
            let Some(&(file, at)) = program.data.frames.get(&frame) else {
                return Err(refused(&format!(
                    "its inline form needs a clone of {frame}, which is not declared in the data list"
                )));
            };
            let from = texts(program, file)?;
            if from.context && words_of(from, at).iter().any(|w| w == "GLOBAL") {
                return Err(refused(&format!(
                    "its inline form needs a clone of {frame}, which another module declares GLOBAL"
                )));
            }
            lines.push(renamed(from, at, &frame, &format!("F{fresh}")));
        }
    }
    below(texts(program, file)?, file, following, &lines, out);
    Ok(Clone::Name { old: name.text.clone(), new })
}

/// The program's own data list, and the line before its `ENDDAT`.
fn own_list(program: &Program) -> Option<(usize, usize)> {
    let own = program.script.texts.iter().enumerate().skip(1);
    own.filter(|(_, t)| !t.context).find_map(|(file, text)| {
        let end = (0..text.line_count()).rev().find(|k| words_of(text, *k).first().is_some_and(|w| w == "ENDDAT"))?;
        Some((file, end.checked_sub(1)?))
    })
}

/// Words of a line, in upper case.
fn words_of(text: &Text, k: usize) -> Vec<String> {
    let mut line = Vec::new();
    tokens(text, k, &mut line);
    line.iter().filter(|t| t.kind == Kind::Word).map(|t| upper(text, t)).collect()
}

/// Lines after line `k`.
fn below(text: &Text, file: usize, k: usize, lines: &[Vec<u8>], out: &mut Patches) {
    let span = text.line_span(k);
    let ending = text.ending(span.start);
    let closed = text.slice(span.clone()).ends_with(b"\n");
    let mut bytes = Vec::new();
    for line in lines {
        if !closed {
            bytes.extend_from_slice(ending);
        }
        bytes.extend_from_slice(line);
        if closed {
            bytes.extend_from_slice(ending);
        }
    }
    out.push(Patch::new(file, span.end..span.end, bytes));
}

/// An aggregate's text with other numbers.
pub(super) fn replaced(text: &Text, whole: &Range<usize>, change: &Change) -> Vec<u8> {
    let mut change: Vec<_> = change.iter().collect();
    change.sort_by_key(|c| c.0.start);
    let (mut out, mut at) = (Vec::new(), whole.start);
    for (span, new) in change {
        out.extend_from_slice(text.slice(at..span.start));
        out.extend_from_slice(new.as_bytes());
        at = span.end;
    }
    out.extend_from_slice(text.slice(at..whole.end));
    out
}

/// The point's name as the fold's line writes it.
fn shown(text: &Text, fold: usize, to: usize, name: &str) -> String {
    let line = text.line_span(fold);
    let found = references(text, fold, to, name).into_iter().find(|r| line.contains(&r.span.start));
    found.map_or_else(|| name.to_string(), |r| String::from_utf8_lossy(text.slice(r.span)).into_owned())
}

/// Makes a motion lead to a clone: the whole fold of an inline form, else the goal alone.
pub(super) fn refer(program: &Program, step: usize, clone: &Clone, out: &mut Patches) -> Result<()> {
    let motion = motion_of(program, step)?;
    let (old, new) = match clone {
        Clone::Inline(values) => {
            out.push(Patch::new(0, motion.point, values.clone()));
            return Ok(());
        }
        Clone::Name { old, new } => (old, new),
    };
    let Some(fold) = motion.fold() else {
        out.push(Patch::new(0, motion.point, new.as_bytes()));
        return Ok(());
    };
    let before = program.motions.before(step).is_some_and(|m| m.line() >= fold);
    let following = program.motions.after(step).is_some_and(|m| m.fold() == Some(fold));
    if before || following {
        let why = "its inline form holds several motions, and the point must part from its other uses";
        return Err(Error::Refused(format!("{}: {why}", place(program, step))));
    }
    let text = texts(program, 0)?;
    let (old, new) = (&old[1..], &new[1..]);
    let head = text.line_span(fold);
    let mut named = false;
    for r in references(text, fold, motion.line(), old) {
        named |= r.head.is_none() && head.contains(&r.span.start);
        let mut replacement: Vec<u8> = r.head.into_iter().collect();
        replacement.extend_from_slice(new.as_bytes());
        out.push(Patch::new(0, r.span, replacement));
    }
    if named {
        return Ok(());
    }
    let why = "its inline form names another point than its motion; put them in order first";
    Err(Error::Refused(format!("{}: {why}", place(program, step))))
}
