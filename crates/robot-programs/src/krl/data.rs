//! Names of a program: points and frame data that are declared, what they are given, and who else uses them.

use super::aggregate::{Aggregate, aggregate};
use super::calls::calls;
use super::lex::{Kind, Token, first_word, in_upper, index, tokens, upper};
use super::motion;
use super::name::{Assigned, Flow, Holds, Name};
use crate::error::Result;
use crate::script::Text;
use nalgebra::Isometry3;
use std::collections::HashMap;

/// Every name of a program.
#[derive(Debug, Default)]
pub(super) struct Data {
    pub names: Vec<Name>,
    /// By routine (`None`: the data list) and name in upper case.
    by_name: HashMap<String, Vec<(Option<usize>, usize)>>,
    /// Frame data: file and line of the declaration.
    pub frames: HashMap<String, (usize, usize)>,
    /// Numbers of tool and base of frame data.
    pub numbers: HashMap<String, [Option<u32>; 2]>,
}

impl Data {
    /// A name as a routine sees it.
    pub fn find(&self, routine: usize, name: &str) -> Option<usize> {
        let all = self.by_name.get(name)?;
        let of = |scope| all.iter().find(|n| n.0 == scope).map(|n| n.1);
        of(Some(routine)).or_else(|| of(None))
    }

    /// A name of a routine (`None`: of the data list).
    pub(super) fn known(&self, scope: Option<usize>, name: &str) -> Option<usize> {
        self.by_name.get(name)?.iter().find(|n| n.0 == scope).map(|n| n.1)
    }

    /// The frame of a name whose value is certain.
    pub fn frame(&self, routine: usize, name: &str) -> Option<Isometry3<f64>> {
        let name = self.names.get(self.find(routine, name)?)?;
        name.value().ok().filter(|_| name.holds == Holds::Pose)?.isometry()
    }

    pub fn collect(texts: &[Text]) -> Result<Self> {
        let mut data = Self::default();
        let mut line = Vec::new();
        let own = || texts.iter().enumerate().filter(|(_, t)| !t.context);
        // declarations first: the data list comes after the program
        for pass in 0..2 {
            if pass == 1 {
                // the program assigns points of other modules, too
                data.declared_elsewhere(texts);
                if data.names.is_empty() {
                    break;
                }
            }
            for (file, text) in own() {
                let mut routine = 0;
                let mut flow = Flow::default();
                for k in 0..text.line_count() {
                    if pass == 0 && !may_declare(first_word(text, k)) {
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
                            data.declare(text, file, k, scope, &line, at)?;
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

    /// `DECL [GLOBAL] [CONST] E6AXIS XP1={...},XP2`; `at` is the token of the type.
    pub(super) fn declare(
        &mut self,
        text: &Text,
        file: usize,
        k: usize,
        scope: Option<usize>,
        line: &[Token],
        at: usize,
    ) -> Result<()> {
        let kind = upper(text, &line[at]);
        let global = line[..at].iter().any(|t| text.slice(t.span()).eq_ignore_ascii_case(b"GLOBAL"));
        let mut i = at + 1;
        while let Some(word) = line.get(i) {
            if word.kind != Kind::Word {
                i += 1;
                continue;
            }
            let (name, own) = (upper(text, word), String::from_utf8_lossy(text.slice(word.span())).into_owned());
            i += 1;
            let array = line.get(i).is_some_and(|t| t.is(b'['));
            while line.get(i).is_some_and(|t| !t.is(b',') && !t.is(b'=')) {
                i += 1;
            }
            let mut given = None;
            let mut spoiled = None;
            if line.get(i).is_some_and(|t| t.is(b'=')) {
                i += 1;
                if line.get(i).is_some_and(|t| t.is(b'{')) && kind != "FDAT" {
                    let (a, next) = aggregate(text, file, line, i)?;
                    (given, i) = (Some(a), next);
                } else if kind == "FDAT" {
                    // the program's own come first
                    self.frames.entry(name.clone()).or_insert((file, k));
                    let numbers = || ["TOOL_NO", "BASE_NO"].map(|field| field_number(text, line, field));
                    self.numbers.entry(name).or_insert_with(numbers);
                    return Ok(());
                } else {
                    spoiled = Some("its value is computed".into());
                }
            }
            while line.get(i).is_some_and(|t| !t.is(b',')) {
                i += 1;
            }
            let holds = match kind.as_str() {
                "E6AXIS" | "AXIS" => Holds::Axes,
                "FDAT" => continue,
                _ => Holds::Pose,
            };
            let next = self.names.len();
            let there = self.known(scope, &name);
            if text.context
                && let Some(there) = there
            {
                let there = &mut self.names[there];
                if there.context {
                    there.spoiled.get_or_insert_with(|| "it is declared in several modules".into());
                }
                continue;
            }
            if there.is_some() {
                return Err(text.bad(word.start, format!("a second declaration of {own}"), "each name declared once"));
            }
            self.by_name.entry(name.clone()).or_default().push((scope, next));
            let (type_word, local) = (line[at].span(), scope.is_some());
            let (assigned, used, read) = (Vec::new(), false, false);
            let line = k;
            self.names.push(Name {
                text: own,
                file,
                line,
                type_word,
                holds,
                local,
                global: global || text.context,
                context: text.context,
                array,
                of: None,
                given,
                assigned,
                used,
                spoiled,
                read,
            });
        }
        Ok(())
    }

    /// Assignments, and uses besides motions. `at`: the routine, and whether the line certainly runs in it.
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
            let spoil = |name: &mut Name, why: String| {
                name.spoiled.get_or_insert(why);
            };
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
                    self.names[n].assigned.push(Assigned { line: k, routine, aggregate: whole, always });
                }
                Some(_) if i == 0 => {
                    spoil(
                        &mut self.names[n],
                        format!("a part of it is assigned while the program runs (line {})", k + 1),
                    );
                }
                _ => match &call {
                    Some(name) => {
                        let why = format!("it is passed to {name}, which may change it (line {})", k + 1);
                        spoil(&mut self.names[n], why);
                    }
                    None => self.names[n].read = true,
                },
            }
        }
        Ok(())
    }

    /// The value that a data list gives a point on a line of its own; `elsewhere`: another module's list.
    pub(super) fn initial(&mut self, n: usize, value: Option<Aggregate>, elsewhere: bool) {
        let name = &mut self.names[n];
        if name.given.is_some() || value.is_none() || (name.context && !elsewhere) {
            name.spoiled.get_or_insert_with(|| "its value in the data list is not plain".into());
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
            self.by_name.entry(element).or_default().push((scope, fresh));
            let array = &self.names[n];
            let element = Name {
                text: format!("{}[{index}]", array.text),
                array: false,
                of: Some(n),
                given: None,
                assigned: Vec::new(),
                used: false,
                spoiled: None,
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
                element.spoiled.get_or_insert(why);
            }
            if used {
                // which element is used before it is assigned is not known
                element.assigned.iter_mut().for_each(|a| a.always = false);
            }
        }
    }
}

/// The statements of a line: what stands after the `DO` of `TRIGGER` and `INTERRUPT` is one of its own.
pub(super) fn statements<'a>(text: &Text, line: &'a [Token]) -> Vec<&'a [Token]> {
    let is_do = |t: &Token| t.kind == Kind::Word && text.slice(t.span()).eq_ignore_ascii_case(b"DO");
    let at = line.iter().enumerate().skip(1).position(|(i, t)| is_do(t) && !line[i - 1].is(b'.')).map(|n| n + 1);
    match at {
        Some(at) => vec![&line[..at], &line[at + 1..]],
        None => vec![line],
    }
}

/// Whether a line begins a routine.
pub(super) fn is_routine(first: &str, second: &str) -> bool {
    matches!(first, "DEF" | "DEFFCT") || first == "GLOBAL" && matches!(second, "DEF" | "DEFFCT")
}

/// Whether a line that begins with this word may begin a routine or declare something.
fn may_declare(word: &[u8]) -> bool {
    let words = ["DEF", "DEFFCT", "GLOBAL", "DECL", "CONST", "E6AXIS", "AXIS", "E6POS", "POS", "FRAME", "FDAT"];
    words.iter().any(|w| word.eq_ignore_ascii_case(w.as_bytes()))
}

/// The token of the type of a declaration of points or frame data.
pub(super) fn declaration(text: &Text, line: &[Token]) -> Option<usize> {
    let mut at = 0;
    while let Some(t) = line.get(at).filter(|t| t.kind == Kind::Word) {
        let word = text.slice(t.span());
        let is = |names: &[&str]| names.iter().any(|n| word.eq_ignore_ascii_case(n.as_bytes()));
        if is(&["DECL", "GLOBAL", "CONST"]) {
            at += 1;
        } else if is(&["E6AXIS", "AXIS", "E6POS", "POS", "FRAME", "FDAT"]) {
            return line.get(at + 1).is_some_and(|t| t.kind == Kind::Word).then_some(at);
        } else {
            return None;
        }
    }
    None
}

/// The `=` of an assignment; not `==`, `<=`, `>=`, and not within brackets.
pub(super) fn assignment(line: &[Token]) -> Option<usize> {
    if line.first()?.kind != Kind::Word {
        return None;
    }
    let mut depth = 0_usize;
    for (i, t) in line.iter().enumerate().skip(1) {
        match t.kind {
            Kind::Mark(b'[') => depth += 1,
            Kind::Mark(b']') => depth = depth.saturating_sub(1),
            Kind::Mark(b'=') if depth == 0 => return (!line.get(i + 1).is_some_and(|t| t.is(b'='))).then_some(i),
            Kind::Mark(b'.') => {}
            Kind::Word if line[i - 1].is(b'.') => {}
            _ if depth > 0 => {}
            _ => return None,
        }
    }
    None
}

/// The number that follows a field: `TOOL_NO 1`.
fn field_number<T: std::str::FromStr>(text: &Text, line: &[Token], field: &str) -> Option<T> {
    let at = line.iter().position(|t| upper(text, t) == field)?;
    std::str::from_utf8(text.slice(line.get(at + 1)?.span())).ok()?.parse().ok()
}
