//! Points that the program computes, where the text tells their values all the same: `XUP=XP1`, `XUP.Z=XUP.Z+H`, and then `LIN XUP`.
//!
//! Which assignments may have been the last before a line is followed along control ([`reach`](crate::script::reach)), as far as
//! routines of the file go. A value is certain where all that may have been the last give the same one, and each computes it from values
//! that are certain: declared points and numbers that nothing assigns, and values of other such assignments. What a variable holds where
//! the program starts is not known where the program assigns it: data lists keep values from one run to the next.
//!
//! Nothing is certain of variables that something else may change at any time: by a routine that an interrupt or a TRIGGER calls, by one
//! that gets them as an argument, by another module; nor of parameters. A line that computes its value from its own one in a loop has no
//! value.
//!
//! Expressions: numbers, `+`, `-`, `*`, `/` and brackets. A quotient of whole numbers is cut to a whole number by the controller: none
//! is computed. Values of points are copied between variables of one type.

mod assigned;
mod flow;
mod numbers;

use super::scan::own_routines;
use crate::krl::aggregate::{Aggregate, aggregate};
use crate::krl::data::Data;
use crate::krl::going::Going;
use crate::krl::lex::{Kind, Token, tokens, upper};
use crate::krl::lists::Lists;
use crate::krl::made::{self, Made, Parts};
use crate::krl::outside::Outside;
use crate::krl::product;
use crate::krl::reason::Uncertain;
use crate::krl::still::Still;
use crate::script::fold::{self, Part};
use crate::script::reach::{Atoms, BEFORE, FIRST, Reach};
use crate::script::{Text, number};
use assigned::{Assigned, Assignment, Place};
use flow::Flow;
use numbers::Numbers;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

/// A variable, by its index among the names of the data or among the numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Var {
    Point(usize),
    Number(usize),
}

/// A value that is certain.
#[derive(Debug, Clone, PartialEq)]
enum Value {
    Point(Parts),
    /// Its decimals; whether it is a whole number to the controller.
    Number(f64, u8, bool),
}

/// Variables that are followed at once, and at most.
const AT_ONCE: usize = 32;
const MOST: usize = 1024;
/// Values that a value is computed from, one after the other.
const DEEPEST: usize = 64;
/// Assignments that may have been the last.
const MOST_LAST: usize = 4;

/// What the program computes.
#[derive(Default)]
pub(super) struct Computed<'a> {
    texts: &'a [Text],
    all: Vec<Assignment>,
    numbers: Numbers,
    /// Which assignments may have been the last, [`AT_ONCE`] variables each.
    reach: Vec<Reach>,
    /// Where each variable is among those.
    kinds: BTreeMap<Var, (usize, usize)>,
    /// First lines of the routines.
    first: Vec<usize>,
    /// Values of the assignments as far as they were asked for; one that is being computed has none.
    known: RefCell<BTreeMap<usize, Option<Value>>>,
}

/// What is known of the program besides.
#[derive(Clone, Copy)]
pub(super) struct Around<'a> {
    pub data: &'a Data,
    pub going: &'a Going,
    pub outside: &'a Outside,
    pub still: &'a Still,
    pub lists: &'a Lists,
}

/// Whether the order of its assignments may tell the value of a point.
fn is_candidate(data: &Data, n: usize) -> bool {
    data.names.get(n).is_some_and(|n| !n.array && n.of.is_none() && !n.spoiled_whole && n.value().is_err())
}

impl<'a> Computed<'a> {
    /// Of a program. Nothing is followed where it computes no point.
    pub(super) fn of(texts: &'a [Text], around: Around) -> Self {
        let Some(text) = texts.first() else { return Self::default() };
        let data = around.data;
        let assigns = |n: usize| {
            let in_part = |why: &Uncertain| matches!(why, Uncertain::PartAssigned(_));
            data.names.get(n).is_some_and(|n| !n.assigned.is_empty() || n.spoiled.as_deref().is_some_and(in_part))
        };
        if !(0..data.names.len()).any(|n| assigns(n) && is_candidate(data, n)) || numbers::goes_elsewhere(text) {
            return Self::default();
        }
        let own = own_routines(text);
        let mut numbers = Numbers::of(texts);
        let mut assigned = Assigned::of(text, data, &numbers, &own);
        numbers.look_around(texts, &used(text, &numbers, &assigned));
        let Some(flow) = Flow::of(texts, own, around, &assigned) else { return Self::default() };
        for a in assigned.all.iter().filter(|a| !is_local(data, &numbers, a.var)) {
            if flow.at_any_time(a.routine) {
                assigned.spoiled.insert(a.var);
            }
        }
        let fine = |var: &Var| match var {
            Var::Point(_) => !assigned.spoiled.contains(var),
            Var::Number(n) => !assigned.spoiled.contains(var) && numbers.all.get(*n).is_some_and(|n| !n.spoiled),
        };
        let vars: BTreeSet<Var> = assigned.all.iter().map(|a| a.var).filter(fine).collect();
        for var in &assigned.spoiled {
            if let Var::Number(n) = var {
                numbers.all[*n].spoiled = true;
            }
        }
        if vars.len() > MOST {
            return Self::default();
        }
        let (local, shared): (Vec<Var>, Vec<Var>) = vars.iter().partition(|var| is_local(data, &numbers, **var));
        let (mut reach, mut kinds) = (Vec::new(), BTreeMap::new());
        for (vars, local) in [(local, true), (shared, false)] {
            for chunk in vars.chunks(AT_ONCE) {
                kinds.extend(chunk.iter().enumerate().map(|(k, var)| (*var, (reach.len(), k))));
                let global = |var: &Var| is_global(data, &numbers, *var);
                reach.push(flow.reach(&assigned, chunk, local, &global));
            }
        }
        let first = flow.first;
        let all = std::mem::take(&mut assigned.all);
        Self { texts, all, numbers, reach, kinds, first, known: RefCell::default() }
    }

    /// The point that a name is at the motion on line `k`; `None`: its value is not computed, or not certain.
    pub(super) fn point(&self, data: &Data, n: usize, k: usize) -> Option<Made> {
        let holds = data.names.get(n).filter(|_| self.kinds.contains_key(&Var::Point(n)))?.holds;
        // what the motion itself calls may run before or after its point is read
        let mut last = self.last(Var::Point(n), k, k.checked_sub(1)?)?;
        last.extend(self.last(Var::Point(n), k, k)?);
        match self.all_give(data, Var::Point(n), &last, 0)? {
            Value::Point(parts) => Made::of(&parts, holds),
            Value::Number(..) => None,
        }
    }

    /// What may have been assigned last to a variable after a line of the routine in which `line` stands.
    fn last(&self, var: Var, line: usize, after: usize) -> Option<Atoms> {
        let (chunk, kind) = self.kinds.get(&var)?;
        let routine = self.first.partition_point(|first| *first <= line);
        self.reach.get(*chunk)?.after(routine, after)?.get(*kind).cloned()
    }

    /// The value that all of these assignments give.
    fn all_give(&self, data: &Data, var: Var, last: &Atoms, depth: usize) -> Option<Value> {
        if last.is_empty() || last.len() > MOST_LAST || last.contains(&BEFORE) || depth > DEEPEST {
            return None;
        }
        let mut given = last.iter().map(|atom| {
            let line = atom.checked_sub(FIRST)? as usize;
            let a = self.all.iter().position(|a| a.line == line && a.var == var)?;
            self.given(data, a, depth + 1)
        });
        let first = given.next()??;
        given.all(|value| value.as_ref() == Some(&first)).then_some(first)
    }

    /// The value of a variable before a line.
    fn before(&self, data: &Data, var: Var, line: usize, depth: usize) -> Option<Value> {
        if self.kinds.contains_key(&var) {
            return self.all_give(data, var, &self.last(var, line, line.checked_sub(1)?)?, depth);
        }
        match var {
            Var::Point(n) => {
                let a = data.names.get(n)?.value().ok()?;
                Some(Value::Point(made::parts(a, self.texts.get(a.file)?)?))
            }
            Var::Number(n) => {
                let number = self.numbers.all.get(n).filter(|n| !n.spoiled)?;
                number.given.map(|(value, decimals)| Value::Number(value, decimals, number.whole))
            }
        }
    }

    /// The value that an assignment gives, by its index. While it is computed it has none.
    fn given(&self, data: &Data, a: usize, depth: usize) -> Option<Value> {
        if let Some(known) = self.known.borrow().get(&a) {
            return known.clone();
        }
        self.known.borrow_mut().insert(a, None);
        let value = self.computed(data, a, depth);
        self.known.borrow_mut().insert(a, value.clone());
        value
    }

    fn computed(&self, data: &Data, a: usize, depth: usize) -> Option<Value> {
        let (Some(a), Some(text)) = (self.all.get(a), self.texts.first()) else { return None };
        let mut line = Vec::new();
        tokens(text, a.line, &mut line);
        line.retain(|t| t.kind != Kind::Comment);
        let value = line.get(a.value..)?;
        match (a.var, &a.place) {
            (Var::Point(n), Place::Whole) => self.copied(data, n, a, value, depth).map(Value::Point),
            (Var::Point(n), Place::Part(part)) => {
                let Value::Point(mut parts) = self.before(data, a.var, a.line, depth)? else { return None };
                let number = self.number(data, a, value, depth)?;
                let text = part_as_text(part, full(data, self.texts, n)?, number)?;
                match parts.iter_mut().find(|p| p.0 == *part) {
                    Some(there) => there.1 = text,
                    None => parts.push((part.clone(), text)),
                }
                Some(Value::Point(parts))
            }
            (Var::Number(n), Place::Whole) => {
                let (value, decimals, whole) = self.number(data, a, value, depth)?;
                // a value with decimals would be rounded
                match self.numbers.all.get(n)?.whole {
                    true => whole.then_some(Value::Number(value, decimals, true)),
                    false => Some(Value::Number(value, decimals, false)),
                }
            }
            (Var::Number(_), Place::Part(_)) => None,
        }
    }

    /// The parts of an aggregate, or of another point.
    ///
    /// `value = aggregate | name ["[" index "]"]`
    fn copied(&self, data: &Data, n: usize, a: &Assignment, value: &[Token], depth: usize) -> Option<Parts> {
        let text = self.texts.first()?;
        let (first, names) = (value.first()?, full(data, self.texts, n)?);
        if first.is(b'{') {
            let (given, end) = aggregate(text, 0, value, 0).ok()?;
            return (end == value.len() && self.is_whole(data, n, &given, names)).then(|| made::parts(&given, text))?;
        }
        let (name, next) = product::name(text, value, 0);
        let from = data.find(a.routine, &name).filter(|_| first.kind == Kind::Word && next == value.len())?;
        let same = full(data, self.texts, from) == Some(names);
        match self.before(data, Var::Point(from), a.line, depth).filter(|_| same)? {
            Value::Point(parts) => Some(parts),
            Value::Number(..) => None,
        }
    }

    /// Whether an aggregate leaves nothing of what the point was before: it has all parts of the type, or nothing gives the point others.
    fn is_whole(&self, data: &Data, n: usize, given: &Aggregate, names: &[&str]) -> bool {
        let has = |name: &str| given.component(name).is_some();
        let alone = data.names.get(n).is_some_and(|n| usize::from(n.given.is_some()) + n.assigned.len() == 1);
        let mut parts = self.all.iter().filter(|a| a.var == Var::Point(n)).filter_map(|a| match &a.place {
            Place::Part(part) => Some(part),
            Place::Whole => None,
        });
        names.iter().all(|name| has(name)) || alone && parts.all(|part| has(part))
    }

    /// The value of an expression.
    ///
    /// `expression = operand {("+" | "-" | "*" | "/") operand}`, `operand = number | name | name "." part`, with brackets and signs
    fn number(&self, data: &Data, a: &Assignment, value: &[Token], depth: usize) -> Option<(f64, u8, bool)> {
        let text = self.texts.first()?;
        let (mut parts, mut finest, mut k) = (Vec::new(), 0, 0);
        let mut leaves: Vec<(f64, bool, bool)> = Vec::new();
        while let Some(t) = value.get(k) {
            let divides_by = parts.last() == Some(&Part::Mark(b'/'));
            let (number, decimals, whole, next) = match t.kind {
                Kind::Mark(m) if b"+-*/()".contains(&m) => {
                    parts.push(Part::Mark(m));
                    k += 1;
                    continue;
                }
                Kind::Number => {
                    let (number, style) = number::read(text.slice(t.span())).filter(|n| !n.1.exponent)?;
                    (number, style.decimals, !style.point, k + 1)
                }
                Kind::Word => self.operand(data, a, value, k, depth)?,
                _ => return None,
            };
            let literal = t.kind == Kind::Number;
            leaves.push((number, whole, divides_by && literal));
            (finest, k) = (finest.max(decimals), next);
            parts.push(Part::Number(number));
        }
        let has = |mark: u8| parts.contains(&Part::Mark(mark));
        let whole = leaves.iter().all(|leaf| leaf.1);
        // what is divided must not be a whole number
        let cut = has(b'/') && leaves.iter().any(|(_, whole, divides)| *whole && !divides);
        // whole numbers have 32 bits
        let most = if has(b'*') { LARGEST_FACTOR } else { LARGEST };
        let overflows = leaves.iter().any(|(v, whole, _)| *whole && v.abs() > most);
        let (value, style) = fold::plain(&parts, finest).filter(|_| !cut && !overflows)?;
        (value.abs() <= LARGEST).then_some((value, if whole { 0 } else { style.decimals.min(FINEST) }, whole))
    }

    /// A variable or a part of a point in an expression; the token after it.
    ///
    /// `operand = name | name ["[" index "]"] "." part`
    fn operand(
        &self,
        data: &Data,
        a: &Assignment,
        value: &[Token],
        k: usize,
        depth: usize,
    ) -> Option<(f64, u8, bool, usize)> {
        let text = self.texts.first()?;
        let (name, next) = product::name(text, value, k);
        if value.get(next).is_some_and(|t| t.is(b'.')) {
            let part = value.get(next + 1).filter(|t| t.kind == Kind::Word)?;
            let from = data.find(a.routine, &name)?;
            let Value::Point(parts) = self.before(data, Var::Point(from), a.line, depth)? else { return None };
            let part = upper(text, part);
            let there = parts.iter().find(|p| p.0 == part && !matches!(part.as_str(), "S" | "T"))?;
            let (number, style) = number::read(&there.1).filter(|n| !n.1.exponent)?;
            return Some((number, style.decimals, false, next + 2));
        }
        let alone = next == k + 1 && !value.get(next).is_some_and(|t| t.is(b'(') || t.is(b'['));
        let n = self.numbers.find(a.routine, &name).filter(|_| alone && data.find(a.routine, &name).is_none())?;
        match self.before(data, Var::Number(n), a.line, depth)? {
            Value::Number(number, decimals, whole) => Some((number, decimals, whole, next)),
            Value::Point(_) => None,
        }
    }
}

/// Numbers that assignments name.
fn used(text: &Text, numbers: &Numbers, assigned: &Assigned) -> BTreeSet<usize> {
    let (mut used, mut line) = (BTreeSet::new(), Vec::new());
    for a in &assigned.all {
        tokens(text, a.line, &mut line);
        let words = line.iter().filter(|t| t.kind == Kind::Word);
        used.extend(words.filter_map(|t| numbers.find(a.routine, &upper(text, t))));
    }
    used
}

/// Largest values that are computed.
const LARGEST: f64 = 1e8;
const LARGEST_FACTOR: f64 = 1e3;
/// Most decimals of a computed number.
const FINEST: u8 = 6;

/// The parts of a point's type.
///
/// `type = "FRAME" | "POS" | "E6POS" | "AXIS" | "E6AXIS"`
fn full(data: &Data, texts: &[Text], n: usize) -> Option<&'static [&'static str]> {
    let name = data.names.get(n)?;
    let word = texts.get(name.file)?.slice(name.type_word).to_ascii_uppercase();
    Some(match word.as_slice() {
        b"FRAME" => &["X", "Y", "Z", "A", "B", "C"],
        b"POS" => &["X", "Y", "Z", "A", "B", "C", "S", "T"],
        b"E6POS" => &["X", "Y", "Z", "A", "B", "C", "S", "T", "E1", "E2", "E3", "E4", "E5", "E6"],
        b"AXIS" => &["A1", "A2", "A3", "A4", "A5", "A6"],
        b"E6AXIS" => &["A1", "A2", "A3", "A4", "A5", "A6", "E1", "E2", "E3", "E4", "E5", "E6"],
        _ => return None,
    })
}

/// A number of a part that the type has.
fn part_as_text(part: &str, names: &[&str], (value, decimals, whole): (f64, u8, bool)) -> Option<Vec<u8>> {
    let fits = match part {
        "S" | "T" => whole && value >= 0.0,
        _ => true,
    };
    let style = number::Style { decimals, point: decimals > 0, ..number::Style::default() };
    (fits && names.contains(&part)).then(|| number::write(value, style, decimals).into_bytes())
}

fn is_local(data: &Data, numbers: &Numbers, var: Var) -> bool {
    match var {
        Var::Point(n) => data.names.get(n).is_some_and(|n| n.local),
        Var::Number(n) => numbers.all.get(n).is_some_and(|n| n.local),
    }
}

fn is_global(data: &Data, numbers: &Numbers, var: Var) -> bool {
    match var {
        Var::Point(n) => data.names.get(n).is_some_and(|n| n.global),
        Var::Number(n) => numbers.all.get(n).is_some_and(|n| n.global),
    }
}
