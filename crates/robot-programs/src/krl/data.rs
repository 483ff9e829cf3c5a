//! Names of a program: points and frame data that are declared, what they are given, and who else uses them.

use super::aggregate::{Aggregate, aggregate};
use super::calls::calls;
use super::frame::numbered_field;
use super::lex::{Kind, Token, begins_with, first_word, in_upper, index, tokens, upper};
use super::list_end::end_of_list;
use super::motion;
use super::name::{Assigned, Flow, Holds, Name};
use super::reason::{Uncertain, Where};
use super::statement::{DECLARING, assignment, comma, declaration, is_routine, item, may_declare, statements};
use crate::bases::CarriedBases;
use crate::error::Result;
use crate::script::{Few, Text};
use nalgebra::Isometry3;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// Every name of a program.
#[derive(Debug, Default)]
pub(super) struct Data {
    pub names: Vec<Name>,
    /// By routine (`None`: the data list) and name in upper case.
    by_name: HashMap<Box<str>, Scopes>,
    /// Frame data: file and line of the declaration.
    pub frames: HashMap<String, (usize, usize)>,
    /// Numbers of tool and base of frame data.
    pub numbers: HashMap<String, [Option<u32>; 2]>,
    /// Bases that frame data take on an external axis and the like.
    pub carried: CarriedBases,
}

/// Where a declaration stands: file, line from 0, and routine (`None`: a data list).
#[derive(Clone, Copy)]
pub(super) struct Declared {
    pub file: usize,
    pub line: usize,
    pub scope: Option<usize>,
}

/// Scope (routine; `None`: the data list) of a declaration, and its index into [`Data::names`].
type InScope = (Option<u32>, u32);

/// Declarations of one name: nearly always one.
#[derive(Debug)]
struct Scopes {
    first: InScope,
    others: Few<InScope>,
}

impl Scopes {
    fn of(&self, scope: Option<usize>) -> Option<usize> {
        let scope = scope.map(|routine| routine as u32);
        std::iter::once(&self.first).chain(&self.others).find(|d| d.0 == scope).map(|d| d.1 as usize)
    }
}

impl Data {
    /// A name as a routine sees it.
    pub fn find(&self, routine: usize, name: &str) -> Option<usize> {
        let all = self.by_name.get(name)?;
        all.of(Some(routine)).or_else(|| all.of(None))
    }

    /// A name of a routine (`None`: of the data list).
    pub(super) fn known(&self, scope: Option<usize>, name: &str) -> Option<usize> {
        self.by_name.get(name)?.of(scope)
    }

    /// The name that is added next stands in this scope.
    fn next_is(&mut self, name: String, scope: Option<usize>) {
        let own = (scope.map(|routine| routine as u32), self.names.len() as u32);
        match self.by_name.entry(name.into()) {
            Entry::Occupied(known) => known.into_mut().others.push(own),
            Entry::Vacant(place) => drop(place.insert(Scopes { first: own, others: Few::new() })),
        }
    }

    /// The frame of a name whose value is certain.
    pub fn frame(&self, routine: usize, name: &str) -> Option<Isometry3<f64>> {
        let name = self.names.get(self.find(routine, name)?)?;
        name.value().ok().filter(|_| name.holds == Holds::Pose)?.isometry()
    }

    /// Collects what the texts declare, assign and use.
    ///
    /// `text = {declaration | assignment | statement}`
    pub fn collect(texts: &[Text]) -> Result<Self> {
        let mut data = Self::default();
        let mut line = Vec::new();
        let own = || texts.iter().enumerate().filter(|(_, t)| !t.context);
        // lines of declarations, which are not read again
        let mut declared: Vec<(usize, usize)> = Vec::new();
        // declarations first: the data list comes after the program
        for pass in 0..2 {
            if pass == 1 {
                // the program assigns points of other modules, too
                data.declared_elsewhere(texts);
                if data.names.is_empty() {
                    break;
                }
            }
            let seen = if pass == 1 { std::mem::take(&mut declared) } else { Vec::new() };
            let mut known = seen.iter().peekable();
            for (file, text) in own() {
                let mut routine = 0;
                let mut flow = Flow::default();
                let end =
                    if file > 0 { end_of_list(text).map_or(text.line_count(), |k| k + 1) } else { text.line_count() };
                for k in 0..end {
                    if pass == 0 && !(begins_with(text, k, DECLARING) && may_declare(first_word(text, k))) {
                        continue;
                    }
                    if pass == 1 && known.next_if_eq(&&(file, k)).is_some() {
                        continue;
                    }
                    tokens(text, k, &mut line);
                    line.retain(|t| t.kind != Kind::Comment);
                    let first = line.first().map(|t| in_upper(text, t)).unwrap_or_default();
                    let second = line.get(1).filter(|_| first == "GLOBAL").map(|t| in_upper(text, t));
                    if is_routine(&first, &second.unwrap_or_default()) {
                        routine += 1;
                        flow = Flow::default();
                    }
                    flow.pass(&first);
                    let scope = (file == 0).then_some(routine);
                    if let Some(at) = declaration(text, &line) {
                        if pass == 0 {
                            declared.push((file, k));
                            data.declare(text, Declared { file, line: k, scope }, &line, at)?;
                        }
                    } else if pass == 1 && !matches!(&*first, "STRUC" | "ENUM" | "EXT" | "EXTP" | "EXTFCT") {
                        for (n, part) in statements(text, &line).into_iter().enumerate() {
                            data.uses(text, file, k, (scope.unwrap_or(0), n == 0 && flow.certain()), part)?;
                        }
                    }
                }
            }
        }
        data.look_around(texts);
        data.spread();
        Ok(data)
    }

    /// A declaration whose type is token `kind` of its line: `DECL [GLOBAL] [CONST] E6AXIS XP1={...},XP2`.
    ///
    /// `declaration = {"DECL" | "GLOBAL" | "CONST"} type item {"," item}`,
    /// `item = name ["[" ... "]"] ["=" (aggregate | expression)]`
    pub(super) fn declare(&mut self, text: &Text, at: Declared, line: &[Token], kind: usize) -> Result<()> {
        let Some(type_word) = line.get(kind) else { return Ok(()) };
        let holds = match &*in_upper(text, type_word) {
            "FDAT" => {
                self.declare_frame_data(text, at, line, kind + 1);
                return Ok(());
            }
            "E6AXIS" | "AXIS" => Holds::Axes,
            _ => Holds::Pose,
        };
        let global = line[..kind].iter().any(|t| text.slice(t.span()).eq_ignore_ascii_case(b"GLOBAL"));
        let mut next = kind + 1;
        while let Some(item) = item(line, next) {
            let (given, spoiled, end) = match item.value {
                None => (None, None, item.next),
                Some(k) if line.get(k).is_some_and(|t| t.is(b'{')) => {
                    let (mut value, end) = aggregate(text, at.file, line, k)?;
                    if let Some(before) = self.names.last().and_then(|name| name.given.as_ref()) {
                        value.share_names(before);
                    }
                    (Some(value), None, end)
                }
                Some(k) => (None, Some(Box::new(Uncertain::Computed)), k),
            };
            next = comma(line, end);
            let name = Name {
                text: String::from_utf8_lossy(text.slice(item.word.span())).into_owned(),
                file: at.file,
                line: at.line,
                type_word: type_word.span().into(),
                holds,
                local: at.scope.is_some(),
                global: global || text.context,
                context: text.context,
                array: item.array,
                of: None,
                given,
                assigned: Few::new(),
                used: false,
                spoiled_whole: spoiled.is_some(),
                spoiled,
                read: false,
            };
            self.add(text, at.scope, item.word, name)?;
        }
        Ok(())
    }

    /// A point that is declared in a scope, by a word of a text. A second declaration in the program is refused; of another module
    /// it makes the point's value uncertain, where the first is of another module, too.
    fn add(&mut self, text: &Text, scope: Option<usize>, word: &Token, name: Name) -> Result<()> {
        let key = upper(text, word);
        match self.known(scope, &key) {
            Some(there) if text.context => {
                let there = &mut self.names[there];
                if there.context {
                    there.spoil(Uncertain::SeveralModules);
                }
            }
            Some(_) => {
                let found = format!("a second declaration of {}", name.text);
                return Err(text.bad(word.start, found, "each name declared once"));
            }
            None => {
                self.next_is(key, scope);
                self.names.push(name);
            }
        }
        Ok(())
    }

    /// Frame data of an inline form: the first name from token `k` on with a value. The program's own come first.
    ///
    /// `declaration = ... "FDAT" name "=" "{" ... "TOOL_NO" number ... "BASE_NO" number ... "}"`
    fn declare_frame_data(&mut self, text: &Text, at: Declared, line: &[Token], mut k: usize) {
        while let Some(item) = item(line, k) {
            if item.value.is_some() {
                let name = upper(text, item.word);
                self.frames.entry(name.clone()).or_insert((at.file, at.line));
                let numbers = || ["TOOL_NO", "BASE_NO"].map(|field| numbered_field(text, line, field));
                self.numbers.entry(name).or_insert_with(numbers);
                return;
            }
            k = comma(line, item.next);
        }
    }

    /// Assignments, and uses besides motions. `at`: the routine, and whether the line certainly runs in it.
    ///
    /// `statement = name "=" [aggregate] ... | name "." ... "=" ... | call | motion | ...`
    fn uses(&mut self, text: &Text, file: usize, k: usize, at: (usize, bool), line: &[Token]) -> Result<()> {
        let (routine, certain) = at;
        let goal = motion::goal_word(text, line);
        let sign = assignment(line);
        let call = calls(text, line).into_iter().next();
        for (i, t) in line.iter().enumerate() {
            if t.kind != Kind::Word || i > 0 && line[i - 1].is(b'.') {
                continue;
            }
            let Some((n, next)) = self.at(routine, text, line, i) else { continue };
            if (i, sign) != (0, Some(next)) {
                self.names[n].used_in(routine);
            }
            if Some(i) == goal {
                continue;
            }
            let here = || Where::Line(k as u64 + 1);
            match sign {
                Some(sign) if i == 0 && sign == next && !self.names[n].array => {
                    let whole = line.get(sign + 1).filter(|t| t.is(b'{'));
                    let whole = whole.map(|_| aggregate(text, file, line, sign + 1)).transpose()?;
                    let whole = whole.filter(|(_, next)| *next == line.len()).map(|w| w.0);
                    if file > 0 {
                        self.initial(n, whole, false);
                        continue;
                    }
                    let used = self.names[n].used || self.names[n].of.is_some_and(|a| self.names[a].used);
                    let always = certain && !used;
                    let from = self.at(routine, text, line, sign + 1).filter(|(_, next)| *next == line.len());
                    let from = from.map(|f| f.0);
                    self.names[n].assigned.push(Assigned { line: k, routine, aggregate: whole, from, always });
                }
                Some(_) if i == 0 => {
                    self.names[n].spoil(Uncertain::PartAssigned(here()));
                }
                _ => match &call {
                    Some(name) => {
                        let to = name.as_str().into();
                        self.names[n].spoil(Uncertain::Passed { to, at: here() });
                    }
                    None => self.names[n].read = true,
                },
            }
        }
        Ok(())
    }

    /// The value that a data list gives a point on a separate line; `elsewhere`: another module's list.
    pub(super) fn initial(&mut self, n: usize, value: Option<Aggregate>, elsewhere: bool) {
        let name = &mut self.names[n];
        if name.given.is_some() || value.is_none() || (name.context && !elsewhere) {
            name.spoil(Uncertain::NotPlain);
        }
        name.given = value;
    }

    /// The point that the word at token `i` names, and the token after it: a name, an element of an array by a plain index, or the
    /// array itself where the index is computed.
    pub(super) fn at(&mut self, routine: usize, text: &Text, line: &[Token], i: usize) -> Option<(usize, usize)> {
        let name = in_upper(text, line.get(i)?);
        let n = self.find(routine, &name)?;
        if !self.names[n].array {
            return Some((n, i + 1));
        }
        let Some((index, next)) = index(text, line, i + 1) else { return Some((n, i + 1)) };
        let scope = [Some(routine), None].into_iter().find(|s| self.known(*s, &name) == Some(n))?;
        let fresh = self.names.len();
        let element = format!("{name}[{index}]");
        let e = self.known(scope, &element).unwrap_or(fresh);
        if e == fresh {
            self.next_is(element, scope);
            let array = &self.names[n];
            let element = Name {
                text: format!("{}[{index}]", array.text),
                array: false,
                of: Some(n),
                given: None,
                assigned: Few::new(),
                used: false,
                spoiled: None,
                spoiled_whole: false,
                read: false,
                ..array.clone()
            };
            self.names.push(element);
        }
        Some((e, next))
    }

    /// What is done to an array by a computed index, or as a whole, is done to each of its elements.
    fn spread(&mut self) {
        for e in 0..self.names.len() {
            let Some(array) = self.names[e].of.and_then(|n| self.names.get(n)) else { continue };
            let (spoiled, read, used) = (array.spoiled.clone(), array.read, array.used);
            let element = &mut self.names[e];
            element.read |= read;
            if let Some(why) = spoiled {
                // by a computed index it may get any value
                element.spoiled_whole = true;
                element.spoiled.get_or_insert(why);
            }
            if used {
                // which element is used before it is assigned is not known
                element.assigned.iter_mut().for_each(|a| a.always = false);
            }
        }
    }
}
