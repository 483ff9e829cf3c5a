//! A point's second form: a separate declaration with a free name, in an inline form together with all that it couples.

use super::aggregate::Aggregate;
use super::form::{Reference, references};
use super::lex::{Kind, tokens, upper};
use super::list_end::end_of_list;
use super::motion::Motion;
use super::name::Name;
use super::program::{Program, Source};
use crate::error::{Error, Result};
use crate::script::{Patch, Patches, Text};
use std::collections::{HashMap, HashSet};
use std::ops::Range;

/// Numbers of a point and their new text.
pub(super) type Change = Vec<(Range<usize>, String)>;

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
    /// Its own name; the old one.
    Name { old: String, new: String },
    /// The values in line.
    Inline(Vec<u8>),
}

/// A line with a name replaced, wherever it stands as a word.
fn renamed(text: &Text, line: usize, name: &str, new: &str) -> Vec<u8> {
    let mut words = Vec::new();
    tokens(text, line, &mut words);
    let span = text.line_span(line);
    let same = words.iter().filter(|t| t.kind == Kind::Word && upper(text, t) == name);
    text.substituted(span.start..span.start + text.line(line).len(), same.map(|t| (t.span(), new)))
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
    if let Some(Source::Made(made)) = program.sources.get(target) {
        return Ok(Clone::Inline(replaced(&made.text, &made.value.span.range(), change)));
    }
    let parting = Parting::of(program, step, target)?;
    let values = replaced(program.text(parting.value.file)?, &parting.value.span.range(), change);
    if parting.is_in_line()? {
        return Ok(Clone::Inline(values));
    }
    let new = parting.new_name(taken)?;
    let (file, line) = parting.place_of_clone()?;
    let mut lines = vec![parting.declaration(&new.point, &values)?];
    lines.extend(parting.frame_data(&new)?);
    below(program.text(file)?, file, line, &lines, out);
    Ok(Clone::Name { old: parting.name.text.clone(), new: new.point })
}

/// A motion whose point must part from the point's other uses.
struct Parting<'a> {
    program: &'a Program,
    step: usize,
    target: usize,
    motion: &'a Motion,
    name: &'a Name,
    value: &'a Aggregate,
}

/// The name of a clone, and what all names of its inline form have in common.
struct NewName {
    point: String,
    stem: String,
}

impl<'a> Parting<'a> {
    fn of(program: &'a Program, step: usize, target: usize) -> Result<Self> {
        let refused = |why: &str| refused(program, step, target, why);
        let Some(Source::Name(n)) = program.sources.get(target) else { return Err(refused("the point has no name")) };
        let name = &program.data.names[*n as usize];
        let value = name.value().map_err(|_| refused("the point's value is not certain"))?;
        Ok(Self { program, step, target, motion: program.motion(step)?, name, value })
    }

    fn refused(&self, why: &str) -> Error {
        refused(self.program, self.step, self.target, why)
    }

    /// Whether the motion takes the values themselves: a point of the routine, or of another module outside of a form.
    fn is_in_line(&self) -> Result<bool> {
        let form = self.motion.fold().is_some();
        if self.name.local && form {
            return Err(self.refused("a point of the routine itself cannot be cloned in an inline form"));
        }
        Ok(self.name.local || self.name.context && !form)
    }

    /// The point's name without the index of an array; in an inline form without its `X`.
    fn body(&self) -> &'a str {
        match self.motion.fold() {
            Some(_) => &self.name.text[1..],
            None => self.name.text.split('[').next().unwrap_or_default(),
        }
    }

    fn new_name(&self, taken: &mut Taken) -> Result<NewName> {
        let name = self.name;
        let fold = self.motion.fold();
        if fold.is_some() && !name.text.to_ascii_uppercase().starts_with('X') {
            return Err(self.refused("its inline form does not name the point as inline forms do (X and the name)"));
        }
        if fold.is_some() && name.of.is_some() {
            return Err(self.refused("an element of an array cannot be cloned in an inline form"));
        }
        // the form may write the name in another case than its declaration
        let spelled =
            fold.map(|fold| Ok(shown(self.program.text(0)?, fold, self.motion.line(), self.body()))).transpose()?;
        let stem = taken
            .fresh(spelled.as_deref().unwrap_or(self.body()), fold.is_some())
            .ok_or_else(|| self.refused("no name is free for a clone of the point"))?;
        let head = if fold.is_some() { name.text.get(..1).unwrap_or_default() } else { "" };
        Ok(NewName { point: format!("{head}{stem}"), stem })
    }

    /// File and line below which the clone is declared. A point of another module parts into the program's own data list.
    fn place_of_clone(&self) -> Result<(usize, usize)> {
        if !self.name.context {
            return Ok((self.name.file, self.name.line));
        }
        own_list(self.program)
            .ok_or_else(|| self.refused("there is no data list (.dat) beside the program for a clone of the point"))
    }

    /// `DECL E6AXIS XP1_2={A1 ...}`.
    fn declaration(&self, point: &str, values: &[u8]) -> Result<Vec<u8>> {
        let mut line = b"DECL ".to_vec();
        line.extend_from_slice(self.program.text(self.name.file)?.slice(self.name.type_word));
        line.extend_from_slice(format!(" {point}=").as_bytes());
        line.extend_from_slice(values);
        Ok(line)
    }

    /// The declaration of the frame data that an inline form couples with its point, for the clone.
    fn frame_data(&self, new: &NewName) -> Result<Option<Vec<u8>>> {
        let Some(fold) = self.motion.fold() else { return Ok(None) };
        let framed = |r: &Reference| r.head.is_some_and(|h| h.eq_ignore_ascii_case(&b'F'));
        let text = self.program.text(0)?;
        if !references(text, fold, self.motion.line(), self.body()).iter().any(framed) {
            return Ok(None);
        }
        let frame = format!("F{}", self.body().to_ascii_uppercase());
        let refused = |why: &str| self.refused(&format!("its inline form needs a clone of {frame}, which {why}"));
        let Some(&(file, at)) = self.program.data.frames.get(&frame) else {
            return Err(refused("is not declared in the data list"));
        };
        let from = self.program.text(file)?;
        if from.context && words_of(from, at).iter().any(|w| w == "GLOBAL") {
            return Err(refused("another module declares GLOBAL"));
        }
        Ok(Some(renamed(from, at, &frame, &format!("F{}", new.stem))))
    }
}

fn refused(program: &Program, step: usize, target: usize, why: &str) -> Error {
    let uses = program.script.uses().get(target).cloned().unwrap_or_default();
    let uses: Vec<String> = uses.into_iter().map(|s| program.place(s)).collect();
    Error::Refused(format!("{}: {why}; it is used at {}", program.place(step), uses.join(", ")))
}

/// The program's own data list, and the line before its `ENDDAT`.
fn own_list(program: &Program) -> Option<(usize, usize)> {
    let own = program.script.texts.iter().enumerate().skip(1);
    own.filter(|(_, t)| !t.context).find_map(|(file, text)| {
        let end = end_of_list(text)?;
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
    let mut change = change.clone();
    change.sort_by_key(|c| c.0.start);
    text.substituted(whole.clone(), change)
}

/// The point's name as the fold's line writes it.
fn shown(text: &Text, fold: usize, to: usize, name: &str) -> String {
    let line = text.line_span(fold);
    let found = references(text, fold, to, name).into_iter().find(|r| line.contains(&r.span.start));
    found.map_or_else(|| name.to_string(), |r| String::from_utf8_lossy(text.slice(r.span)).into_owned())
}

/// Makes a motion lead to a clone: the whole fold of an inline form, else the goal alone.
pub(super) fn refer(program: &Program, step: usize, clone: &Clone, out: &mut Patches) -> Result<()> {
    let motion = program.motion(step)?;
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
        return Err(Error::Refused(format!("{}: {why}", program.place(step))));
    }
    let text = program.text(0)?;
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
    Err(Error::Refused(format!("{}: {why}", program.place(step))))
}
