//! Declared numbers (`DECL REAL H=50`, `INT`), and what may change them besides a plain assignment.
//!
//! They are known to the same standard as declared points are: those of all modules only where the whole project with its `$config.dat` was
//! read, and no other module assigns them or hands them over.

use crate::krl::calls::KEYWORDS;
use crate::krl::lex::{Kind, Token, begins_with, first_word, tokens, upper};
use crate::krl::list_end::end_of_list;
use crate::krl::project::is_read;
use crate::krl::statement::{assignment, comma, is_routine, item, statements};
use crate::script::{Text, number};
use std::collections::{BTreeSet, HashMap};

/// Functions that leave what they are given as it is.
const PURE: [&str; 13] =
    ["BAS", "SIN", "COS", "TAN", "ACOS", "ATAN2", "ABS", "SQRT", "ROUND", "PULSE", "SVEL_JOINT", "STOOL2", "SBASE"];

/// A declared number.
#[derive(Debug)]
pub(super) struct Number {
    /// `INT`.
    pub whole: bool,
    /// Its value, and its decimals.
    pub given: Option<(f64, u8)>,
    /// One of all modules.
    pub global: bool,
    /// One of a routine.
    pub local: bool,
    /// Its value is not certain.
    pub spoiled: bool,
    name: String,
    /// Another module declares it.
    context: bool,
}

/// All numbers that the program may name.
#[derive(Debug, Default)]
pub(super) struct Numbers {
    pub all: Vec<Number>,
    /// By routine (`None`: a data list) and name in upper case.
    by_name: HashMap<(Option<usize>, String), usize>,
}

impl Numbers {
    /// Of the program, its data list, and the lists of other modules that declare for all.
    ///
    /// `list = "DEFDAT" name ["PUBLIC"] {declaration}`
    pub fn of(texts: &[Text]) -> Self {
        let mut numbers = Self::default();
        let (mut line, mut routine) = (Vec::new(), 0);
        for (file, text) in texts.iter().enumerate() {
            let list = file > 0;
            if list && !is_list(text) {
                continue;
            }
            let end = if list { end_of_list(text).unwrap_or(text.line_count()) } else { text.line_count() };
            let mut shared = None;
            for k in (0..end).filter(|k| begins_with(text, *k, b"DGCRI")) {
                tokens(text, k, &mut line);
                line.retain(|t| t.kind != Kind::Comment);
                let word = |i: usize| line.get(i).map(|t| upper(text, t)).unwrap_or_default();
                if is_routine(&word(0), &word(1)) {
                    routine += 1;
                } else if word(0) == "DEFDAT" {
                    let public = line.iter().any(|t| upper(text, t) == "PUBLIC");
                    shared = (word(1) == "$CONFIG" || public).then_some(word(1) == "$CONFIG");
                } else if let Some(kind) = declaration(text, &line) {
                    let global = line[..kind].iter().any(|t| upper(text, t) == "GLOBAL");
                    if text.context && !shared.is_some_and(|all| all || global) {
                        continue;
                    }
                    let scope = (!list).then_some(routine);
                    numbers.declare(text, (scope, global || text.context), &line, kind);
                }
            }
        }
        numbers
    }

    /// `declaration = ... ("REAL" | "INT") item {"," item}`
    fn declare(&mut self, text: &Text, at: (Option<usize>, bool), line: &[Token], kind: usize) {
        let (scope, global) = at;
        let whole = upper(text, &line[kind]) == "INT";
        let mut next = kind + 1;
        while let Some(item) = item(line, next) {
            next = comma(line, item.next);
            let value = item.value.and_then(|from| line.get(from..next)).unwrap_or_default();
            let given = plain(text, value).filter(|(v, _)| !whole || v.fract() == 0.0);
            let spoiled = item.array || item.value.is_some() && given.is_none();
            let (name, context) = (upper(text, item.word), text.context);
            match self.by_name.get(&(scope, name.clone())).and_then(|n| self.all.get_mut(*n)) {
                // another module's of the same name as one of the program is another one
                Some(there) if text.context && !there.context => {}
                Some(there) => there.spoiled = true,
                None => {
                    self.by_name.insert((scope, name.clone()), self.all.len());
                    self.all.push(Number { whole, given, global, local: scope.is_some(), spoiled, name, context });
                }
            }
        }
    }

    /// A number as a routine sees it.
    pub fn find(&self, routine: usize, name: &str) -> Option<usize> {
        let of = |scope| self.by_name.get(&(scope, name.to_string())).copied();
        of(Some(routine)).or_else(|| of(None))
    }

    /// Those of `used` that are not of one routine.
    fn shared<'a>(&'a mut self, used: &'a BTreeSet<usize>) -> impl Iterator<Item = &'a mut Number> {
        let of = |(k, n): (usize, &'a mut Number)| (used.contains(&k) && !n.local).then_some(n);
        self.all.iter_mut().enumerate().filter_map(of)
    }

    /// Spoils those of `used` that something outside of the program's text may change.
    ///
    /// `line = ... "=" ... | ... "(" ... | ... "." ...`
    pub fn look_around(&mut self, texts: &[Text], used: &BTreeSet<usize>) {
        let unread = texts.iter().any(|t| t.context && !is_read(t));
        let configured = texts.iter().any(|t| t.context && file_name(t).eq_ignore_ascii_case("$config.dat"));
        let whole = configured && !unread;
        let mut open: BTreeSet<String> = BTreeSet::new();
        for n in self.shared(used) {
            // a module that cannot be read may give one of a public list another name
            n.spoiled |= unread || n.global && !whole;
            open.insert(n.name.clone());
        }
        if open.is_empty() {
            return;
        }
        // by other modules, and by the program's own list
        let mut touched = BTreeSet::new();
        let mut line = Vec::new();
        for text in texts.iter().skip(1) {
            for k in text.lines_with(b"=(.") {
                tokens(text, k, &mut line);
                line.retain(|t| t.kind != Kind::Comment);
                let seen = touches(text, &line, &BTreeSet::new());
                touched
                    .extend(seen.iter().filter(|name| open.contains(*name)).map(|name| (text.context, name.clone())));
            }
        }
        for n in self.shared(used) {
            // of the numbers of one module other modules know nothing, but for an IMPORT
            n.spoiled |= touched.iter().any(|(elsewhere, name)| *name == n.name && (n.global || !elsewhere));
        }
        self.imports(texts, used);
    }

    /// `IMPORT REAL H IS /R1/Program/prog..H`: another name of a number, by which it may be assigned.
    ///
    /// `import = "IMPORT" type name "IS" path ".." name`
    fn imports(&mut self, texts: &[Text], used: &BTreeSet<usize>) {
        let mut line = Vec::new();
        for text in texts.iter().filter(|t| memchr::memmem::find(&t.bytes, b"..").is_some()) {
            for k in text.lines_with(b".").filter(|k| memchr::memmem::find(text.line(*k), b"..").is_some()) {
                tokens(text, k, &mut line);
                let names: Vec<String> = line.iter().filter(|t| t.kind == Kind::Word).map(|t| upper(text, t)).collect();
                if names.iter().any(|w| w == "IMPORT") {
                    self.shared(used).filter(|n| names.contains(&n.name)).for_each(|n| n.spoiled = true);
                }
            }
        }
    }
}

/// Names that a line may give another value: assigned, counted by a loop, read cyclically, or handed over to a routine that is not known to
/// leave them. `own`: routines of the program, one of which may have the name of a function.
///
/// `line = statement ["DO" statement]`, `statement = name ... "=" value | "FOR" name "=" ... | ("ANIN" | "DIGIN") ... | ... call ...`
pub(super) fn touches(text: &Text, line: &[Token], own: &BTreeSet<String>) -> Vec<String> {
    let mut found = passed(text, line, own);
    for part in statements(text, line) {
        let Some(first) = part.first() else { continue };
        let word = upper(text, first);
        match word.as_str() {
            "FOR" => found.extend(part.get(1).map(|t| upper(text, t))),
            "ANIN" | "DIGIN" => found.extend(part.iter().filter(|t| t.kind == Kind::Word).map(|t| upper(text, t))),
            _ if assignment(part).is_some() => found.push(word),
            _ => {}
        }
    }
    found
}

/// Words within the brackets of a call.
///
/// `call = name "(" {argument} ")"`
pub(super) fn passed(text: &Text, line: &[Token], own: &BTreeSet<String>) -> Vec<String> {
    let (mut found, mut open) = (Vec::new(), Vec::new());
    for (k, t) in line.iter().enumerate() {
        match t.kind {
            Kind::Mark(b'(') => {
                let before = k.checked_sub(1).and_then(|b| line.get(b)).filter(|b| b.kind == Kind::Word);
                let name = before.map(|b| upper(text, b)).unwrap_or_default();
                let harmless = name.is_empty()
                    || KEYWORDS.contains(&name.as_str())
                    || PURE.contains(&name.as_str()) && !own.contains(&name);
                open.push(!harmless);
            }
            Kind::Mark(b')') => drop(open.pop()),
            Kind::Word if open.contains(&true) => found.push(upper(text, t)),
            _ => {}
        }
    }
    found
}

/// The token of the type of a declaration of numbers.
///
/// `declaration = {"DECL" | "GLOBAL" | "CONST"} ("REAL" | "INT") name ...`
pub(super) fn declaration(text: &Text, line: &[Token]) -> Option<usize> {
    for (k, t) in line.iter().enumerate() {
        match upper(text, t).as_str() {
            "DECL" | "GLOBAL" | "CONST" => {}
            "REAL" | "INT" => return line.get(k + 1).is_some_and(|t| t.kind == Kind::Word).then_some(k),
            _ => return None,
        }
    }
    None
}

/// A plain number, and its decimals.
///
/// `number = ["+" | "-"] digits`
fn plain(text: &Text, tokens: &[Token]) -> Option<(f64, u8)> {
    let (first, last) = (tokens.first()?, tokens.last()?);
    let alone = matches!(tokens, [n] | [_, n] if n.kind == Kind::Number);
    let signed = tokens.len() == 1 || first.is(b'-') || first.is(b'+');
    let (value, style) = number::read(text.slice(first.start..last.end)).filter(|_| alone && signed)?;
    (!style.exponent).then_some((value, style.decimals))
}

/// Whether control may go on elsewhere than the statements of a text tell: after `RESUME`, or after an error.
///
/// `statement = "RESUME" | "ON_ERROR_PROCEED"`
pub(super) fn goes_elsewhere(text: &Text) -> bool {
    (0..text.line_count()).any(|k| {
        begins_with(text, k, b"RO") && {
            let word = first_word(text, k);
            word.eq_ignore_ascii_case(b"RESUME") || word.eq_ignore_ascii_case(b"ON_ERROR_PROCEED")
        }
    })
}

fn is_list(text: &Text) -> bool {
    text.name.rsplit_once('.').is_some_and(|(_, e)| e.eq_ignore_ascii_case("dat"))
}

fn file_name(text: &Text) -> &str {
    text.name.rsplit(['/', '\\']).next().unwrap_or_default()
}
