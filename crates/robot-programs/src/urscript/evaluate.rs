//! Expressions whose value is the same whenever the program comes to them.
//!
//! Followed are names that are assigned such values ([`certain`](super::certain)), parameters of functions that all calls give the same,
//! functions of the file that assign names of their own and return a value, and the functions of [`Constant`]. What may differ has no
//! value.

use super::arguments::{Arg, arguments};
use super::certain::{Holding, Key, Order};
use super::constant::Constant;
use super::lex::Kind;
use super::read::{Item, ItemKind, Parsed, Span};
use crate::script::{Text, number};
use std::cell::{Cell, OnceCell, RefCell};
use std::collections::HashMap;
use std::rc::Rc;

/// Deepest nesting of expressions, names and calls that is followed.
const DEEPEST: usize = 64;
/// Parts of expressions that are looked at for one target, beside those that are kept.
const MOST: usize = 20_000;
/// Items that are gone through for all variables together.
const MOST_ITEMS: usize = 20_000_000;

/// The values of a file, as far as they were asked for.
pub struct Values<'a> {
    text: &'a Text,
    p: &'a Parsed,
    /// The function with which the program starts.
    entry: Option<usize>,
    order: Order,
    holdings: RefCell<HashMap<Key, Option<Rc<Holding>>>>,
    /// Values after assignments, by their items; `None`: not certain, or not known yet.
    assigned: RefCell<HashMap<usize, Option<Constant>>>,
    /// Where functions are called, by their names: items and tokens.
    calls: OnceCell<HashMap<String, Vec<(usize, usize)>>>,
    /// First tokens of the functions.
    heads: OnceCell<HashMap<usize, usize>>,
    left: Cell<usize>,
    items_left: Cell<usize>,
    /// A value was not looked at to its end.
    cut: Cell<bool>,
}

/// Arguments with which a function is called.
struct Call<'c> {
    def: usize,
    arguments: HashMap<&'c str, Constant>,
}

/// Where an expression stands, how deep it is nested, and the call in which it is looked at.
#[derive(Clone, Copy)]
struct Place<'c> {
    item: usize,
    depth: usize,
    call: Option<&'c Call<'c>>,
}

impl Place<'_> {
    fn deeper(self, values: &Values) -> Option<Self> {
        values.cut.set(values.cut.get() || self.depth >= DEEPEST);
        (self.depth < DEEPEST).then_some(Self { depth: self.depth + 1, ..self })
    }
}

impl<'a> Values<'a> {
    pub fn of(text: &'a Text, p: &'a Parsed, entry: Option<usize>) -> Self {
        Self {
            text,
            p,
            entry,
            order: Order::default(),
            holdings: RefCell::default(),
            assigned: RefCell::default(),
            calls: OnceCell::new(),
            heads: OnceCell::new(),
            left: Cell::new(0),
            items_left: Cell::new(MOST_ITEMS),
            cut: Cell::new(false),
        }
    }

    /// The value of an expression at an item.
    pub fn value(&self, span: &Span, item: usize) -> Option<Constant> {
        self.left.set(MOST.max(self.p.tokens.len()));
        self.expression(span, Place { item, depth: 0, call: None })
    }

    /// `expression = product {("+" | "-") product}`
    fn expression(&self, span: &Span, place: Place) -> Option<Constant> {
        let mut reader = Reader { values: self, at: span.start, end: span.end, place: place.deeper(self)? };
        let value = reader.sum()?;
        let finite = value.number().is_none_or(f64::is_finite);
        (reader.at == span.end && finite).then_some(value)
    }

    fn def(&self, place: Place) -> Option<usize> {
        self.p.items.get(place.item)?.def
    }

    /// The value of a name.
    fn name(&self, name: &str, place: Place) -> Option<Constant> {
        let (p, def) = (self.p, self.def(place));
        let Some(key) = p.key(def, name) else { return self.parameter(name, place) };
        let variable = p.variables.get(&key)?;
        if variable.method {
            return None;
        }
        // what is looked at in a call are the names of its function
        let call = place.call.filter(|call| key.0 == Some(call.def));
        let place = Place { call, ..place };
        if let ([n], None, false) = (&variable.assigned[..], &variable.changed, p.locals.contains(&key)) {
            return self.after(*n, place);
        }
        let holding = self.holding(&key)?;
        let own = p.items.get(place.item)?;
        if key.0.is_none() && p.called(own).any(|name| self.order.leads_to(p, name, &holding.by)) {
            return None;
        }
        let mut values = holding.before(place.item, def)?.into_iter().map(|n| self.after(n, place));
        let first = values.next()??;
        values.all(|value| value.as_ref() == Some(&first)).then_some(first)
    }

    fn holding(&self, key: &Key) -> Option<Rc<Holding>> {
        if let Some(known) = self.holdings.borrow().get(key) {
            return known.clone();
        }
        let left = self.items_left.get().checked_sub(self.p.items.len())?;
        self.items_left.set(left);
        let found = self.order.of(self.text, self.p, self.entry, key).map(Rc::new);
        self.holdings.borrow_mut().insert(key.clone(), found.clone());
        found
    }

    /// The value that a name has after the assignment of an item.
    fn after(&self, item: usize, place: Place) -> Option<Constant> {
        let place = Place { item, ..place.deeper(self)? };
        if place.call.is_some() {
            return self.assigned_by(place);
        }
        if let Some(known) = self.assigned.borrow().get(&item) {
            return known.clone();
        }
        // one that leads back to itself has none
        self.assigned.borrow_mut().insert(item, None);
        let before = self.cut.replace(false);
        let value = self.assigned_by(place);
        if value.is_none() && self.cut.get() {
            self.assigned.borrow_mut().remove(&item);
        } else {
            self.assigned.borrow_mut().insert(item, value.clone());
        }
        self.cut.set(before || self.cut.get());
        value
    }

    /// `assignment = name ["[" index "]"] "=" expression`
    fn assigned_by(&self, place: Place) -> Option<Constant> {
        let p = self.p;
        let Item { kind: ItemKind::Assign { name, value, whole }, span, .. } = p.items.get(place.item)? else {
            return None;
        };
        let new = self.expression(&(*value..span.end), place)?;
        if *whole {
            return Some(new);
        }
        let (open, close) = (name + 1, value.checked_sub(2)?);
        if !(self.is(open, b'[') && self.is(close, b']')) {
            return None;
        }
        let index = self.expression(&(open + 1..close), place)?;
        self.name(p.words.at(*name), place)?.with_element(&index, &new)
    }

    /// What a parameter is in the call at hand, or else in every call of its function.
    fn parameter(&self, name: &str, place: Place) -> Option<Constant> {
        let p = self.p;
        let mut def = self.def(place);
        while let Some(d) = def.filter(|d| !p.is_parameter(Some(*d), name)) {
            def = p.defs[d].1;
        }
        let d = def?;
        if let Some(call) = place.call.filter(|call| call.def == d) {
            return call.arguments.get(name).cloned();
        }
        let function = p.defs.get(d)?.0.as_str();
        self.one(function)?;
        let k = self.parameters(d)?.iter().position(|parameter| *parameter == name)?;
        let calls = self.calls.get_or_init(|| calls(p)).get(function)?;
        let mut values = calls.iter().map(|(item, token)| {
            let end = p.items.get(*item)?.span.end;
            let (args, _) = arguments(p, token + 2, end)?;
            let arg = plain(&args)?.get(k)?;
            self.expression(&arg.span, Place { item: *item, call: None, ..place.deeper(self)? })
        });
        let first = values.next()??;
        values.all(|value| value.as_ref() == Some(&first)).then_some(first)
    }

    /// The one function of a name.
    fn one(&self, name: &str) -> Option<usize> {
        let mut all = self.p.defs.iter().enumerate().filter(|(_, d)| d.0 == name);
        all.next().filter(|_| all.next().is_none()).map(|d| d.0)
    }

    /// Parameters of a function in order; `None`: one has a default, or it is a thread.
    ///
    /// `head = "def" name "(" [name {"," name}] ")"`
    fn parameters(&self, def: usize) -> Option<Vec<&str>> {
        let p = self.p;
        let heads = || {
            let starts = p.items.iter().filter(|item| item.kind == ItemKind::Start);
            let named = starts.filter(|item| p.words.at(item.span.start) != "end");
            named.filter_map(|item| Some((item.def?, item.span.start))).collect()
        };
        let head = *self.heads.get_or_init(heads).get(&def)?;
        if p.words.at(head) != "def" || !self.is(head + 2, b'(') {
            return None;
        }
        let (args, _) = arguments(p, head + 3, p.tokens.len())?;
        plain(&args)?.iter().map(|a| (a.span.len() == 1).then(|| p.words.at(a.span.start))).collect()
    }

    /// What a function of the file returns: it assigns nothing but names of its own, and does nothing else.
    fn of_file(&self, def: usize, args: Vec<Constant>, place: Place) -> Option<Constant> {
        let p = self.p;
        let parameters = self.parameters(def).filter(|all| all.len() == args.len())?;
        let arguments = parameters.into_iter().zip(args).collect();
        let call = Call { def, arguments };
        let mut items = p.items.iter().enumerate().filter(|(_, i)| i.def == Some(def) && i.kind != ItemKind::Start);
        let (last, end) = items.next_back()?;
        let assigns_own = |item: &Item| {
            let ItemKind::Assign { name, .. } = item.kind else { return false };
            p.key(Some(def), p.words.at(name)).is_some_and(|key| key.0 == Some(def))
        };
        if p.words.at(end.span.start) != "return" || !items.all(|(_, item)| assigns_own(item)) {
            return None;
        }
        let place = Place { item: last, call: Some(&call), depth: place.depth };
        self.expression(&(end.span.start + 1..end.span.end), place)
    }

    fn is(&self, token: usize, mark: u8) -> bool {
        self.p.tokens.get(token).is_some_and(|t| t.kind == Kind::Mark(mark))
    }
}

/// Arguments without keywords.
fn plain<'r, 'p>(args: &'r [Arg<'p>]) -> Option<&'r [Arg<'p>]> {
    args.iter().all(|a| a.name.is_empty()).then_some(args)
}

/// Where functions of the file are called.
fn calls(p: &Parsed) -> HashMap<String, Vec<(usize, usize)>> {
    let mut all: HashMap<String, Vec<(usize, usize)>> = HashMap::new();
    all.extend(p.defs.iter().map(|(name, _)| (name.clone(), Vec::new())));
    for (k, item) in p.items.iter().enumerate().filter(|(_, item)| item.kind != ItemKind::Start) {
        for token in item.span.clone() {
            let open = token + 1 < item.span.end && p.tokens[token + 1].kind == Kind::Mark(b'(');
            if let Some(found) = all.get_mut(p.words.at(token)).filter(|_| open) {
                found.push((k, token));
            }
        }
    }
    all
}

/// An expression that is read up to a token.
struct Reader<'r, 'a, 'c> {
    values: &'r Values<'a>,
    at: usize,
    end: usize,
    place: Place<'c>,
}

impl Reader<'_, '_, '_> {
    fn mark(&mut self, marks: &[u8]) -> Option<u8> {
        let token = self.values.p.tokens.get(self.at).filter(|_| self.at < self.end)?;
        let mark = token.kind.mark().filter(|m| marks.contains(m))?;
        self.at += 1;
        Some(mark)
    }

    fn sum(&mut self) -> Option<Constant> {
        let mut value = self.product()?;
        while let Some(mark) = self.mark(b"+-") {
            let (a, b) = (value.number()?, self.product()?.number()?);
            value = Constant::Number(if mark == b'+' { a + b } else { a - b });
        }
        Some(value)
    }

    /// `product = one {("*" | "/") one}`
    fn product(&mut self) -> Option<Constant> {
        let mut value = self.signed()?;
        while let Some(mark) = self.mark(b"*/") {
            let (a, b) = (value.number()?, self.signed()?.number()?);
            value = Constant::Number(if mark == b'*' { a * b } else { divided(a, b)? });
        }
        Some(value)
    }

    /// `one = ["+" | "-"] operand {"[" expression "]" | "." name}`
    fn signed(&mut self) -> Option<Constant> {
        let left = self.values.left.get();
        self.values.cut.set(self.values.cut.get() || left == 0);
        self.values.left.set(left.checked_sub(1)?);
        if let Some(mark) = self.mark(b"+-") {
            self.place = self.place.deeper(self.values)?;
            let value = self.signed()?.number()?;
            return Some(Constant::Number(if mark == b'-' { -value } else { value }));
        }
        let mut value = self.operand()?;
        loop {
            if self.mark(b"[").is_some() {
                let index = self.inner(b"]")?;
                value = value.element(&index)?;
            } else if self.mark(b".").is_some() {
                let name = self.word()?;
                value = value.member(name)?;
            } else {
                return Some(value);
            }
        }
    }

    fn word(&mut self) -> Option<&str> {
        let word = self.values.p.words.at(self.at);
        self.at += 1;
        (!word.is_empty() && self.at <= self.end).then_some(word)
    }

    /// What stands in brackets, up to the closing one.
    fn inner(&mut self, close: &[u8]) -> Option<Constant> {
        let outer = self.place;
        self.place = outer.deeper(self.values)?;
        let value = self.sum()?;
        self.place = outer;
        self.mark(close).map(|_| value)
    }

    /// Values up to the closing bracket, which are parted by commas.
    fn several(&mut self, close: &[u8]) -> Option<Vec<Constant>> {
        let outer = self.place;
        self.place = outer.deeper(self.values)?;
        let mut all = Vec::new();
        while self.mark(close).is_none() {
            if !all.is_empty() {
                self.mark(b",")?;
            }
            all.push(self.sum()?);
        }
        self.place = outer;
        Some(all)
    }

    /// `operand = number | "(" expression ")" | "[" list "]" | "p" "[" list "]" | name | function "(" arguments ")"`
    fn operand(&mut self) -> Option<Constant> {
        if self.mark(b"(").is_some() {
            return self.inner(b")");
        }
        if self.mark(b"[").is_some() {
            return self.several(b"]").map(|all| Constant::List(all.into()));
        }
        let (values, place) = (self.values, self.place);
        let token = values.p.tokens.get(self.at).filter(|_| self.at < self.end)?;
        if token.kind == Kind::Number {
            self.at += 1;
            let bytes = values.text.slice(token.start()..token.end());
            return number::read(bytes).map(|v| Constant::Number(v.0));
        }
        let name = values.p.words.at(self.at);
        if name.is_empty() {
            return None;
        }
        self.at += 1;
        if name == "p" && self.mark(b"[").is_some() {
            return Constant::pose_of(&self.several(b"]")?);
        }
        if self.mark(b"(").is_none() {
            return values.name(name, place);
        }
        if name == "struct" {
            return self.members();
        }
        let args = self.several(b")")?;
        if values.p.defs.iter().any(|d| d.0 == name) {
            return values.of_file(values.one(name)?, args, place.deeper(values)?);
        }
        Constant::of_function(name, &args)
    }

    /// `struct = "struct" "(" name "=" expression {"," name "=" expression} ")"`
    fn members(&mut self) -> Option<Constant> {
        let mut all = Vec::new();
        while self.mark(b")").is_none() {
            if !all.is_empty() {
                self.mark(b",")?;
            }
            let name = self.word()?.to_string();
            self.mark(b"=")?;
            all.push((name, self.sum()?));
        }
        Some(Constant::Struct(all.into()))
    }
}

/// Of whole numbers that do not divide, the controller may give a whole number or not.
fn divided(a: f64, b: f64) -> Option<f64> {
    let value = a / b;
    let whole = |v: f64| v.fract() == 0.0;
    (!(whole(a) && whole(b)) || whole(value)).then_some(value)
}
