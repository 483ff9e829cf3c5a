//! What a program assigns to points and numbers, line by line, and what may be assigned at any time.

use super::numbers::{self, Numbers, passed, touches};
use super::{Var, is_candidate};
use crate::krl::calls::{calls, quiet};
use crate::krl::data::Data;
use crate::krl::lex::{Kind, Token, begins_with, first_word, tokens, upper};
use crate::krl::statement::{assignment, declaration, is_routine, statements};
use crate::krl::still::may_begin_routine;
use crate::script::Text;
use std::collections::BTreeSet;

/// What an assignment gives a value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Place {
    Whole,
    /// `Z`, in upper case.
    Part(String),
}

/// `XP.Z=XP.Z+100`.
#[derive(Debug)]
pub(super) struct Assignment {
    pub line: usize,
    pub routine: usize,
    pub var: Var,
    pub place: Place,
    /// First token of its value.
    pub value: usize,
}

/// All of a text.
#[derive(Default)]
pub(super) struct Assigned {
    pub all: Vec<Assignment>,
    /// Variables of which it is not known when they get which value.
    pub spoiled: BTreeSet<Var>,
    /// Routines that interrupts and triggers call.
    pub at_any_time: BTreeSet<String>,
}

/// A look at a text.
struct Look<'a> {
    text: &'a Text,
    data: &'a Data,
    numbers: &'a Numbers,
    own: &'a BTreeSet<String>,
    routine: usize,
    out: Assigned,
}

impl Assigned {
    /// Of a text. `own`: its routines.
    ///
    /// `line = ("DEF" | "DEFFCT" | "GLOBAL" | "DECL") ... | ... "=" ... | ... "(" ...`
    pub fn of(text: &Text, data: &Data, numbers: &Numbers, own: &BTreeSet<String>) -> Self {
        let mut look = Look { text, data, numbers, own, routine: 0, out: Self::default() };
        let (mut line, mut says) = (Vec::new(), text.lines_with(b"=(").peekable());
        for k in 0..text.line_count() {
            let says = says.next_if_eq(&k).is_some();
            let declares = |word: &[u8]| may_begin_routine(word) || word.eq_ignore_ascii_case(b"DECL");
            if !(says || begins_with(text, k, b"DG") && declares(first_word(text, k))) {
                continue;
            }
            tokens(text, k, &mut line);
            line.retain(|t| t.kind != Kind::Comment);
            look.line(k, &line);
        }
        look.out
    }
}

impl Look<'_> {
    /// `line = routine | declaration | assignment | statement ["DO" statement]`
    fn line(&mut self, k: usize, line: &[Token]) {
        let Some(first) = line.first() else { return };
        let second = line.get(1).map(|t| upper(self.text, t)).unwrap_or_default();
        if is_routine(&upper(self.text, first), &second) {
            self.routine += 1;
            // what it is given may be a variable of its caller, or the same one twice
            let open = line.iter().position(|t| t.is(b'(')).unwrap_or(line.len());
            let names = line.iter().skip(open).filter(|t| t.kind == Kind::Word);
            names.for_each(|t| self.spoil(&upper(self.text, t)));
            return;
        }
        if declaration(self.text, line).is_some() || numbers::declaration(self.text, line).is_some() {
            return;
        }
        if upper(self.text, first) == "DECL" {
            // a structure of the routine may have the name of a point
            line.iter().filter(|t| t.kind == Kind::Word).for_each(|t| self.spoil(&upper(self.text, t)));
            return;
        }
        let parts = statements(self.text, line);
        for part in parts.iter().skip(1) {
            self.out.at_any_time.extend(calls(self.text, part).into_iter().chain(quiet(self.text, part)));
        }
        let plain = parts.first().is_some_and(|part| self.assigns(k, part));
        let touched = if plain { passed(self.text, line, self.own) } else { touches(self.text, line, self.own) };
        let later = if plain {
            parts.iter().skip(1).flat_map(|part| touches(self.text, part, self.own)).collect()
        } else {
            Vec::new()
        };
        touched.into_iter().chain(later).for_each(|name| self.spoil_number(&name));
        for part in parts.iter().skip(1).filter(|part| assignment(part).is_some()) {
            part.first().into_iter().for_each(|t| self.spoil(&upper(self.text, t)));
        }
    }

    /// A plain assignment to a variable that is followed; `false`: it is none.
    ///
    /// `assignment = name ["." part] "=" value`
    fn assigns(&mut self, k: usize, line: &[Token]) -> bool {
        let Some(sign) = assignment(line) else { return false };
        let name = line.first().map(|t| upper(self.text, t)).unwrap_or_default();
        let Some(var) = self.find(&name) else { return false };
        let place = match (sign, line.get(1), line.get(2)) {
            (1, ..) => Place::Whole,
            (3, Some(dot), Some(part)) if dot.is(b'.') && part.kind == Kind::Word => {
                Place::Part(upper(self.text, part))
            }
            _ => {
                self.out.spoiled.insert(var);
                return false;
            }
        };
        self.out.all.push(Assignment { line: k, routine: self.routine, var, place, value: sign + 1 });
        true
    }

    fn find(&self, name: &str) -> Option<Var> {
        match self.data.find(self.routine, name) {
            Some(n) => is_candidate(self.data, n).then_some(Var::Point(n)),
            None => self.numbers.find(self.routine, name).map(Var::Number),
        }
    }

    fn spoil(&mut self, name: &str) {
        self.out.spoiled.extend(self.find(name));
    }

    /// What is done to points besides assignments the data know.
    fn spoil_number(&mut self, name: &str) {
        self.out.spoiled.extend(self.find(name).filter(|var| matches!(var, Var::Number(_))));
    }
}
