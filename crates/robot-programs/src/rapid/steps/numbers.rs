//! Numbers: written, declared, or expressions of these.

use super::super::lex::Kind;
use super::super::read::{Item, Span};
use super::{Builder, plain};
use crate::script::fold;
use std::collections::HashMap;

/// Declarations by other declarations that are followed.
const DEEPEST: usize = 32;

impl Builder<'_> {
    /// A number: written there, declared and certain, or an expression of such.
    ///
    /// `number = plain | name | expression of these`
    pub fn number(&mut self, span: &Span, item: &Item) -> Option<f64> {
        self.number_in(span, (Some(item.routine), item.module), 0)
    }

    /// The same as a routine (`None`: a module alone) sees it; what a name is declared with may be such an expression.
    fn number_in(&mut self, span: &Span, place: (Option<usize>, usize), depth: usize) -> Option<f64> {
        if let Some((v, ..)) = plain(self.f.text, self.f.p, span) {
            return Some(v);
        }
        if depth > DEEPEST {
            return None;
        }
        let parts = fold::parts(self.f.text, self.f.p.tokens.get(span.clone())?)?;
        // names first: what they are is looked up once
        let mut names = HashMap::new();
        for i in span.clone().filter(|&i| self.f.p.tokens[i].kind == Kind::Word) {
            if let Some(v) = self.named_number(i, place, depth) {
                names.insert(self.shown(i), v);
            }
        }
        fold::fold(&parts, &Names(names))
    }

    /// The number that a name is declared with, where that is certain.
    fn named_number(&mut self, token: usize, place: (Option<usize>, usize), depth: usize) -> Option<f64> {
        let d = self.f.resolve(self.f.word(token), place.0, place.1)?;
        self.f.certain(d).ok()?;
        let decl = &self.f.p.decls[d];
        if !matches!(decl.ty.as_str(), "num" | "dnum") {
            return self.declared(d)?.number();
        }
        let (value, place) = (decl.value.clone()?, (decl.routine, decl.module));
        if let Some(known) = self.numbers.get(&d) {
            return *known;
        }
        // one that is declared by itself has no value
        self.numbers.insert(d, None);
        let number = self.number_in(&value, place, depth + 1);
        self.numbers.insert(d, number);
        number
    }
}

/// Names with their values.
struct Names(HashMap<String, f64>);

impl fold::Known for Names {
    fn name(&self, name: &str) -> Option<f64> {
        self.0.get(name).copied()
    }

    fn call(&self, _name: &str, _value: f64) -> Option<f64> {
        None
    }
}
