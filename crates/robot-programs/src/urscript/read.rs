//! Tokens of a URScript to its functions, blocks, assignments and calls.
//!
//! A name without `local` is global where anything in the file makes it so, else it belongs to the outermost function around
//! that assigns it; two functions side by side may so use one name for two lists. Fails where a block is not closed, or `end`
//! closes none.

use super::lex::{Kind, Lexed, Token, Words};
use super::reason::Reason;
use super::words;
use crate::error::{Error, Result};
use crate::no_motion::NoMotion;
use crate::script::Text;
use crate::script::alike::Passed;
use crate::script::called::Needs;
use crate::script::lex::{outside, text_of};
use std::collections::{HashMap, HashSet};
use std::ops::Range;

/// Tokens by index.
pub type Span = Range<usize>;

#[derive(Debug, Clone)]
pub struct Item {
    /// Function that it belongs to; `None`: outside of all.
    pub def: Option<usize>,
    pub span: Span,
    pub kind: ItemKind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ItemKind {
    /// `def`, `thread`, or the `end` of one.
    Start,
    /// `if`, `switch`: the condition.
    Branch,
    Loop,
    /// `elif`, `else`, `case`.
    Middle,
    EndBranch,
    EndLoop,
    /// `name = ...`, whole; `value`: first token after the `=`.
    Assign {
        name: usize,
        value: usize,
        whole: bool,
    },
    /// Anything else: a call, `return`, `break`.
    Other,
}

/// A variable of a scope.
#[derive(Debug, Clone, Default)]
pub struct Variable {
    /// Items that assign it.
    pub assigned: Vec<usize>,
    /// Why its value may differ from the one list that it is assigned.
    pub changed: Option<Reason>,
    /// Its value is read by more than moves.
    pub read: bool,
    /// A method may change its list.
    pub method: bool,
}

#[derive(Default)]
pub struct Parsed {
    pub tokens: Vec<Token>,
    pub comments: Vec<(usize, usize)>,
    /// Lines without tokens, like the statement before them.
    pub passed: Vec<Passed>,
    /// As they are written.
    pub words: Words,
    pub items: Vec<Item>,
    /// Functions: name, and the function around them.
    pub defs: Vec<(String, Option<usize>)>,
    /// Parameters and `local` names by function.
    pub locals: HashSet<(Option<usize>, String)>,
    pub globals: HashSet<String>,
    pub variables: HashMap<(Option<usize>, String), Variable>,
}

/// Functions inside other blocks; real programs have two or three levels.
const DEEPEST: usize = 64;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Open {
    Def,
    Loop,
    Branch,
    /// `struct` and the like: nothing in it is a step.
    Plain,
}

/// Reads the tokens of a file.
///
/// # Errors
/// A block without its end, an `end` without its block, functions nested too deeply, or a `for`.
pub fn parse(text: &Text, lexed: Lexed) -> Result<Parsed> {
    let mut walk = Walk::new(text, lexed);
    let mut i = 0;
    let mut line_end = 0;
    while i < walk.p.tokens.len() {
        if matches!(walk.p.tokens[i].kind, Kind::Line | Kind::Mark(b';')) {
            i += 1;
            continue;
        }
        if i >= line_end {
            line_end = walk.p.line_end(i);
        }
        i = walk.statement(i, line_end)?;
    }
    match walk.open.pop() {
        Some((_, at)) => Err(walk.p.bad(text, at, "`end` after its block")),
        None => Ok(walk.p),
    }
}

/// The way through the tokens: which blocks are open, which function is read.
struct Walk<'a> {
    text: &'a Text,
    p: Parsed,
    open: Vec<(Open, usize)>,
    def: Option<usize>,
    /// Open branches: an assignment below an `if` may not happen.
    branches: usize,
}

impl<'a> Walk<'a> {
    fn new(text: &'a Text, lexed: Lexed) -> Self {
        let words = Words::of(text, &lexed.tokens, |bytes| text_of(bytes).into_owned());
        let p =
            Parsed { tokens: lexed.tokens, comments: lexed.comments, passed: lexed.passed, words, ..Parsed::default() };
        Self { text, p, open: Vec::new(), def: None, branches: 0 }
    }

    /// Reads the statement, or the head of a block, at token `i`; returns the token after it.
    ///
    /// `statement = head ":" | "end" | simple ["end"]`,
    /// `head = ("def" | "thread" | "sec") name "(" ... ")" | ("while" | "if" | "switch" | "elif" | "else" | "case" | ...) ...`
    fn statement(&mut self, i: usize, line_end: usize) -> Result<usize> {
        let p = &self.p;
        let colon = p.colon(i, line_end);
        let head = || colon.ok_or_else(|| p.bad(self.text, line_end, "`:` after the head of the block"));
        match p.words.at(i) {
            "def" | "thread" | "sec" => {
                let colon = head()?;
                self.function(i, colon)?;
                Ok(colon + 1)
            }
            word @ ("while" | "if" | "switch") => {
                let colon = head()?;
                let kind = if word == "while" { Open::Loop } else { Open::Branch };
                self.branches += usize::from(kind == Open::Branch);
                let item = if kind == Open::Loop { ItemKind::Loop } else { ItemKind::Branch };
                self.p.push(self.def, i + 1..colon, item);
                self.open.push((kind, i));
                Ok(colon + 1)
            }
            "elif" | "else" | "case" | "default" if colon.is_some() => {
                let colon = head()?;
                self.p.push(self.def, i + 1..colon, ItemKind::Middle);
                Ok(colon + 1)
            }
            "end" => self.end(i),
            // of dialects; were it passed over, its `end` would close the block around it
            "for" if !p.words.at(i + 1).is_empty() && colon.is_some() => {
                Err(p.bad(self.text, i, "a statement of URScript (its loops are `while`)"))
            }
            "struct" if colon.is_some_and(|c| c + 1 == line_end) => {
                self.open.push((Open::Plain, i));
                Ok(line_end)
            }
            _ => {
                // `if a: x = 1 end` on one line
                let end = (i..line_end).find(|&k| k > i && p.words.at(k) == "end").unwrap_or(line_end);
                let end = p.end_of_call(i, end).unwrap_or(end);
                self.p.simple(self.def, i..end, self.branches > 0);
                Ok(end)
            }
        }
    }

    /// The head of a function, its name and its parameters.
    ///
    /// `head = ("def" | "thread" | "sec") name ["(" [name {"," name}] ")"] ":"`
    fn function(&mut self, i: usize, colon: usize) -> Result<()> {
        let p = &mut self.p;
        let name = p.words.at(i + 1).to_string();
        if name.is_empty() {
            return Err(p.bad(self.text, i + 1, "the name of the function"));
        }
        if self.open.len() >= DEEPEST {
            return Err(p.bad(self.text, i, "functions nested less deeply"));
        }
        p.defs.push((name, self.def));
        self.def = Some(p.defs.len() - 1);
        for k in i + 2..colon {
            if !p.words.at(k).is_empty() {
                p.locals.insert((self.def, p.words.at(k).to_string()));
            }
        }
        p.push(self.def, i..i + 1, ItemKind::Start);
        self.open.push((Open::Def, i));
        Ok(())
    }

    /// `end`, which closes the innermost block.
    fn end(&mut self, i: usize) -> Result<usize> {
        let Some((kind, _)) = self.open.pop() else { return Err(self.p.bad(self.text, i, "a block that it ends")) };
        match kind {
            Open::Def => {
                self.def = self.def.and_then(|d| self.p.defs[d].1);
                self.p.push(self.def, i..i + 1, ItemKind::Start);
            }
            Open::Loop => self.p.push(self.def, i..i + 1, ItemKind::EndLoop),
            Open::Branch => {
                self.branches -= 1;
                self.p.push(self.def, i..i + 1, ItemKind::EndBranch);
            }
            Open::Plain => {}
        }
        Ok(i + 1)
    }
}

impl Parsed {
    fn push(&mut self, def: Option<usize>, span: Span, kind: ItemKind) {
        self.items.push(Item { def, span, kind });
    }

    pub fn bad(&self, text: &Text, i: usize, expected: &str) -> Error {
        match self.tokens.get(i).filter(|t| t.kind != Kind::Line) {
            Some(t) => {
                let found = String::from_utf8_lossy(text.slice(t.start()..t.end())).into_owned();
                text.bad(t.start(), format!("`{found}`"), expected)
            }
            None => {
                let at = self.tokens.get(i).map_or(text.bytes.len(), |t| t.start());
                text.bad(at, "the end of the line", expected)
            }
        }
    }

    fn line_end(&self, i: usize) -> usize {
        (i..self.tokens.len()).find(|&k| self.tokens[k].kind == Kind::Line).unwrap_or(self.tokens.len())
    }

    /// The first place of a mark outside of brackets.
    fn outside(&self, span: Span, mark: u8) -> Option<usize> {
        outside(span, |k| self.tokens[k].kind.mark()).find(|k| self.tokens[*k].kind == Kind::Mark(mark))
    }

    /// The `:` outside of brackets that ends a block's head.
    ///
    /// `head = {token | "(" {token} ")"} ":"`
    fn colon(&self, i: usize, end: usize) -> Option<usize> {
        self.outside(i..end, b':')
    }

    /// Token after a call that begins a statement, where another statement follows on its line.
    ///
    /// `call = name "(" ... ")"`
    fn end_of_call(&self, i: usize, end: usize) -> Option<usize> {
        if self.words.at(i).is_empty() || self.tokens.get(i + 1)?.kind != Kind::Mark(b'(') {
            return None;
        }
        let mut depth = 0_usize;
        let close = (i + 1..end).find(|&k| {
            match self.tokens[k].kind {
                Kind::Mark(b'(' | b'[' | b'{') => depth += 1,
                Kind::Mark(b')' | b']' | b'}') => depth = depth.saturating_sub(1),
                _ => {}
            }
            depth == 0
        })?;
        let next = close + 1;
        let word = self.words.at(next);
        let goes_on = word.is_empty() || matches!(word, "and" | "or" | "xor" | "not");
        let follows = next < end && (!goes_on || self.tokens[next].kind == Kind::Mark(b';'));
        follows.then_some(next)
    }

    /// `simple = ["global" | "local"] name ["[" ... "]"] "=" expression | call | other`
    fn simple(&mut self, def: Option<usize>, span: Span, conditional: bool) {
        let mut at = span.start;
        let qualifier = self.words.at(at);
        if matches!(qualifier, "global" | "local") {
            at += 1;
        }
        let name = if at < span.end { self.words.at(at).to_string() } else { String::new() };
        let equals = self.outside(at..span.end, b'=');
        let call = self.tokens.get(at + 1).is_some_and(|t| t.kind == Kind::Mark(b'('));
        match qualifier {
            "global" => drop(self.globals.insert(name.clone())),
            "local" => drop(self.locals.insert((def, name.clone()))),
            _ => {}
        }
        match equals {
            Some(equals) if !name.is_empty() && !call && equals > at => {
                let whole = equals == at + 1;
                if def.is_none() {
                    self.globals.insert(name.clone());
                }
                let n = self.items.len();
                self.push(def, span, ItemKind::Assign { name: at, value: equals + 1, whole });
                // the scope is settled when the whole file is read; until then by function
                let variable = self.variables.entry((def, name.clone())).or_default();
                variable.assigned.push(n);
                if !whole {
                    variable.changed.get_or_insert_with(|| Reason::ElementAssigned(name.into()));
                } else if conditional {
                    variable.changed.get_or_insert_with(|| Reason::AssignedConditionally(name.into()));
                }
            }
            _ => self.push(def, span, ItemKind::Other),
        }
    }

    /// Names of the functions that an item calls; `run` stands for a thread that starts.
    ///
    /// `call = name "(" ...`
    pub fn called(&self, item: &Item) -> impl Iterator<Item = &str> {
        let span = if item.kind == ItemKind::Start { 0..0 } else { item.span.clone() };
        let end = span.end;
        span.filter(move |&i| {
            let open = i + 1 < end && self.tokens[i + 1].kind == Kind::Mark(b'(');
            !self.words.at(i).is_empty() && open
        })
        .map(|i| self.words.at(i))
    }

    /// What the functions of the file call; `declared`: those that move nothing, where the file has none of that name.
    pub fn needs(&self, declared: &NoMotion) -> Needs {
        let mut needs = Needs::exactly(declared);
        self.defs.iter().for_each(|(name, _)| needs.add(name, false, []));
        for item in &self.items {
            let Some((routine, _)) = item.def.and_then(|d| self.defs.get(d)) else { continue };
            let own = |name: &str| self.defs.iter().any(|(n, _)| n == name);
            let moves = self.words.within(item.span.clone()).any(|w| w == "run" || w == "set_tcp")
                || self.called(item).any(|name| !own(name) && words::moves(name));
            let unknown = |name: &&str| own(name) || !(words::moves(name) || words::is_quiet(name));
            let calls: Vec<String> = self.called(item).filter(unknown).map(str::to_string).collect();
            if moves || !calls.is_empty() {
                needs.add(routine, moves, calls);
            }
        }
        needs
    }

    /// Functions of the file that move, or call what may.
    pub fn moving(&self, needs: &Needs) -> HashMap<String, bool> {
        let mut moving: HashMap<String, bool> = self.defs.iter().map(|(n, _)| (n.clone(), false)).collect();
        let mut callers: HashMap<&str, Vec<usize>> = HashMap::new();
        let mut work = Vec::new();
        for item in &self.items {
            let Some(d) = item.def else { continue };
            let mut moves = self.words.within(item.span.clone()).any(|w| w == "run" || w == "set_tcp");
            for name in self.called(item) {
                if moving.contains_key(name) {
                    callers.entry(name).or_default().push(d);
                } else {
                    let still = words::is_quiet(name) || words::leads(name).is_none() && needs.is_declared(name);
                    moves |= words::motion(name).is_some() || !still;
                }
            }
            if moves {
                work.push(d);
            }
        }
        while let Some(d) = work.pop() {
            let name = self.defs[d].0.as_str();
            if moving.insert(name.to_string(), true) == Some(false) {
                work.extend(callers.get(name).into_iter().flatten());
            }
        }
        moving
    }
}
