//! Which position registers hold the values of a listing when a program runs: those that nothing among the files gives a value.
//!
//! Any program of the controller may have set a register before this one runs, and a program that is not among the files may set any. So
//! all programs of the folder are looked over: a register that one of them sets, or may set, has no known value. Neither has any, where
//! one of them sets a register of a computed number, or calls what is not among them; a call without arguments of a name that the
//! user declares to move nothing is none of these.

use super::calls::{name_in, stem};
use super::flow::{self, Flow};
use super::reason::{Reason, SetsAny};
use super::sections::sections;
use super::statement::{is_comment, program_name, statements, words};
use super::{instruction, motion};
use crate::no_motion::NoMotion;
use crate::registers::{Register, Registers};
use crate::script::cursor::{Cursor, integer};
use crate::script::lex::text_of;
use crate::script::{Break, StepKind, Text};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// What a program does to position registers.
#[derive(Debug, Default)]
struct Sets {
    names: Vec<String>,
    /// Registers that it sets or may set.
    numbers: BTreeSet<u64>,
    /// Why it may set any.
    any: Option<SetsAny>,
    /// What it calls, and whether with arguments.
    calls: BTreeSet<(String, bool)>,
    /// Macros that it runs, and whether with arguments: which program that is the file does not tell.
    macros: BTreeSet<(String, bool)>,
}

/// Registers whose values are those of a listing.
#[derive(Debug, Default)]
pub(super) struct Known<'a> {
    listed: Option<&'a BTreeMap<u64, Register>>,
    /// Registers that are set, with the program.
    set: BTreeMap<u64, String>,
    /// The program that may set any, and why.
    any: Option<(String, SetsAny)>,
}

impl<'a> Known<'a> {
    /// By a listing and the programs of the folder, the own one among them.
    pub(super) fn of(texts: &[Text], listing: &'a Registers, declared: &NoMotion) -> Self {
        if listing.positions.is_empty() {
            return Self::default();
        }
        let all: Vec<_> = texts.iter().map(|t| (t, t.known(Sets::of))).collect();
        let there: BTreeSet<&String> = all.iter().flat_map(|(_, s)| &s.names).collect();
        let mut known = Self { listed: Some(&listing.positions), ..Self::default() };
        for (text, sets) in &all {
            let gone =
                |(name, arguments): &&(String, bool)| !there.contains(name) && (*arguments || !declared.has(name));
            let unknown = |(name, arguments): &&(String, bool)| *arguments || !declared.has(name);
            let gone = sets.calls.iter().find(gone).or_else(|| sets.macros.iter().find(unknown));
            let called = gone.map(|c| SetsAny::CallsAbsent(c.0.as_str().into()));
            if let Some(why) = sets.any.clone().or(called) {
                known.any.get_or_insert_with(|| (text.name.clone(), why));
            }
            for number in &sets.numbers {
                known.set.entry(*number).or_insert_with(|| text.name.clone());
            }
        }
        known
    }

    /// The value of a register.
    ///
    /// # Errors
    /// Why it is not known.
    pub(super) fn value(&self, number: u64) -> Result<&'a Register, Reason> {
        let listed = self.listed.ok_or(Reason::Register)?;
        let value = listed.get(&number).ok_or(Reason::NotListed(number))?;
        if let Some(by) = self.set.get(&number) {
            return Err(Reason::RegisterSet { by: by.as_str().into(), register: number });
        }
        match &self.any {
            Some((program, why)) => {
                Err(Reason::RegisterMayBeSet { register: number, program: program.as_str().into(), why: why.clone() })
            }
            None => Ok(value),
        }
    }
}

impl Sets {
    /// What a program sets; one that cannot be read may set any.
    fn of(text: &Text) -> Self {
        let mut sets = Self { names: vec![stem(text)], ..Self::default() };
        sets.names.extend(name_in(text));
        let read = sections(text).ok().and_then(|s| statements(text, s.program).ok());
        let (Some((all, _)), false) = (read, text.unread) else {
            sets.any = Some(SetsAny::Unread);
            return sets;
        };
        for statement in all {
            let first = statement.pieces.first().map_or(&[][..], |p| text.slice(p.clone()));
            if is_comment(first) {
                continue;
            }
            let words = words(text, &statement);
            let moves = motion::read(text, &statement, &words).is_some();
            sets.calls_of(text, &words, moves, statement.nested);
            sets.registers_of(text, &words, moves);
        }
        sets
    }

    fn open(&mut self, why: SetsAny) {
        self.any.get_or_insert(why);
    }

    /// What a statement runs, wherever that stands in it.
    ///
    /// `run = ... ("CALL" | "AUFRUF" | "RUN") name ["(" ...] | macro`
    fn calls_of(&mut self, text: &Text, words: &[Range<usize>], moves: bool, nested: bool) {
        let upper: Vec<Vec<u8>> = words.iter().map(|w| text.slice(w.clone()).to_ascii_uppercase()).collect();
        let runs =
            |w: &[u8]| [&b"CALL"[..], b"AUFRUF", b"RUN"].iter().any(|r| w == *r || w.ends_with(&[b",", *r].concat()));
        let mut found = false;
        for (k, _) in upper.iter().enumerate().filter(|(_, w)| runs(w)) {
            found = true;
            let next = upper.get(k + 1).map(Vec::as_slice).unwrap_or_default();
            let name = program_name(next);
            let rest = upper.get(k + 1..).unwrap_or_default().concat();
            let rest = rest.get(name.len()..).unwrap_or_default();
            if name.is_empty() || rest.starts_with(b"[") {
                self.open(SetsAny::CallComputed);
            } else {
                self.calls.insert((text_of(name).into_owned(), rest.starts_with(b"(")));
            }
        }
        let starts_one = |w: &Vec<u8>| w.starts_with(b"ERROR_PROG") || w.starts_with(b"RESUME_PROG");
        match flow::read(text, words) {
            _ if moves => {}
            // programs that run beside or after this one
            Flow::Step(StepKind::Break(Break::Interrupt)) => self.open(SetsAny::Monitor),
            _ if upper.first().is_some_and(starts_one) => self.open(SetsAny::ErrorProgram),
            Flow::Macro(name) => {
                let arguments = upper.concat().contains(&b'(');
                self.macros.insert((name, arguments));
            }
            Flow::Step(StepKind::Break(Break::Call)) if !found => {
                self.open(SetsAny::Unknown(String::from_utf8_lossy(&upper.join(&b' ')).into()));
            }
            _ if nested => self.open(SetsAny::Nested),
            _ => {}
        }
    }

    /// Registers that a statement names and may set: all but those of a motion, and those to the right of the sign of an assignment.
    ///
    /// `register = "PR" "[" ["GP" number ":"] number ["," number] [":" name] "]"`
    fn registers_of(&mut self, text: &Text, words: &[Range<usize>], moves: bool) {
        let whole: Vec<u8> = words.iter().flat_map(|w| text.slice(w.clone())).map(u8::to_ascii_uppercase).collect();
        let sign = memchr::memchr(b'=', &whole);
        let head = &whole[..memchr::memchr(b'[', &whole).unwrap_or(0)];
        let assigns = instruction::assigns(&whole) || head == b"PR";
        for at in memchr::memmem::find_iter(&whole, b"PR[") {
            if at.checked_sub(1).is_some_and(|k| whole[k].is_ascii_alphanumeric() || whole[k] == b'_') {
                continue;
            }
            let inside = &whole[at + 3..];
            let close = closing(inside);
            let set = close.is_none_or(|k| inside.get(k + 1) == Some(&b'='));
            let read = moves || assigns && sign.is_some_and(|sign| sign < at);
            if read && !set {
                continue;
            }
            match close.and_then(|k| number(&inside[..k])) {
                Some(n) => drop(self.numbers.insert(n)),
                None => self.open(SetsAny::NumberComputed),
            }
        }
    }
}

/// Where the bracket closes that is open before these bytes.
fn closing(bytes: &[u8]) -> Option<usize> {
    let mut depth = 1_usize;
    bytes.iter().position(|b| {
        match b {
            b'[' => depth += 1,
            b']' => depth -= 1,
            _ => {}
        }
        depth == 0
    })
}

/// The number of a register, by what stands in its brackets.
fn number(inside: &[u8]) -> Option<u64> {
    let inside = inside.trim_ascii();
    let inside = match inside.strip_prefix(b"GP") {
        Some(rest) => &rest[memchr::memchr(b':', rest)? + 1..],
        None => inside,
    };
    let mut cursor = Cursor::new(inside);
    let digits: u64 = integer(cursor.digits())?;
    matches!(cursor.peek(), None | Some(b',' | b':')).then_some(digits)
}
