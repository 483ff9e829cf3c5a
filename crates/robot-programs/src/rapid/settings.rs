//! Names of which tools and work objects of moves are made, and where the program sets them: from there on they are others.
//!
//! A tool or a work object that is set at run time is asked for by its name. Where the program sets it more than once, and the last
//! assignment before each of its moves is certain, it is asked for once for each of them. Assignments that follow each other without a
//! move (`w.oframe.trans.x:=...; w.oframe.trans.y:=...;`) are one.
//!
//! Names count, not declarations: two of one name are taken as one.

use super::arguments::{motion_of, positional};
use super::facts::{self, Facts};
use super::lex::Kind;
use super::read::{Item, ItemKind, Parsed, Span, Storage};
use super::words;
use crate::script::Text;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

/// Names in lower case.
type Names = BTreeSet<String>;

/// What a program sets of which tools and work objects are made.
#[derive(Debug, Default)]
pub struct Settings {
    /// All of these names.
    names: Names,
    /// Those that an item sets itself, by its first token.
    direct: HashMap<usize, Names>,
    /// Those that a routine sets, itself or by others, by its name.
    by_routine: HashMap<String, Names>,
    /// Those that a trap sets, whatever the program does.
    in_traps: Names,
    /// The assignment after which a move stands, by its first token and a name that is asked for more than once.
    after: HashMap<(usize, String), usize>,
    /// Tokens of these assignments, with the name and the number.
    assignments: Vec<(usize, String, usize)>,
}

impl Settings {
    /// Reads them; `own`: items of the program itself; `entry`: the routine with which it starts.
    pub fn of(text: &Text, p: &Parsed, own: &dyn Fn(&Item) -> bool, entry: Option<usize>) -> Self {
        let mut direct = set_by_items(text, p);
        let set: HashSet<&str> = direct.values().flatten().map(String::as_str).collect();
        let names: Names =
            if set.is_empty() { Names::new() } else { p.items.iter().flat_map(|item| used(p, item, &set)).collect() };
        if names.is_empty() {
            return Self::default();
        }
        direct.values_mut().for_each(|all| all.retain(|name| names.contains(name)));
        direct.retain(|_, all| !all.is_empty());
        let by_routine = by_routine(p, &direct);
        let traps = p.routines.iter().filter(|r| r.is_trap).filter_map(|r| by_routine.get(&r.name));
        let in_traps = traps.flatten().cloned().collect();
        let mut settings = Self { names, direct, by_routine, in_traps, ..Self::default() };
        settings.number(p, own, entry);
        settings
    }

    /// Names that an item sets itself.
    pub fn set_at(&self, item: &Item) -> impl Iterator<Item = &str> {
        self.direct.get(&item.span.start).into_iter().flatten().map(String::as_str)
    }

    /// Names that the call of a routine sets.
    pub fn set_by(&self, routine: &str) -> impl Iterator<Item = &str> {
        self.by_routine.get(routine).into_iter().flatten().map(String::as_str)
    }

    /// Whether a tool or a work object is made of a name that is set.
    pub fn has(&self, p: &Parsed, span: &Span) -> bool {
        words_of(p, span.clone()).any(|w| self.names.contains(w))
    }

    /// Whether a trap may set it.
    pub fn is_set_in_trap(&self, p: &Parsed, span: &Span) -> bool {
        words_of(p, span.clone()).any(|w| self.in_traps.contains(w))
    }

    /// By what it is asked for besides its name, where that is not enough.
    pub fn since(&self, p: &Parsed, span: &Span, item: &Item) -> String {
        let number = |w: &str| self.after.get(&(item.span.start, w.to_string()));
        words_of(p, span.clone()).filter_map(number).map(|n| since(*n)).collect()
    }

    /// Tokens of assignments from which on a name is asked for by another one, and that, where one of the words in `asked` (in lower case)
    /// is made of it.
    pub fn assignments(&self, asked: &BTreeSet<String>) -> impl Iterator<Item = (usize, String)> {
        let inside = |c: char| c.is_alphanumeric() || c == '_';
        let made = move |words: &str, name: &str| words.split(|c| !inside(c)).any(|word| word == name);
        let all = self.assignments.iter().map(|(token, name, n)| (*token, name, since(*n)));
        let wanted = move |(_, name, since): &(usize, &String, String)| {
            asked.iter().any(|words| words.contains(since.as_str()) && made(words, name))
        };
        all.filter(wanted).map(|(token, name, since)| (token, format!("{name}{since}")))
    }

    /// Finds the last assignment before each move, and keeps it where that is certain for all moves of a name.
    fn number(&mut self, p: &Parsed, own: &dyn Fn(&Item) -> bool, entry: Option<usize>) {
        let mut flow = Flow::new(self, entry);
        let items: Vec<&Item> = p.items.iter().filter(|item| own(item)).collect();
        for (k, item) in items.iter().enumerate() {
            flow.item(p, &items, k, item);
        }
        let Flow { uses, counts, tokens, .. } = flow;
        let several = |name: &String| {
            let states: BTreeSet<State> = uses.iter().filter(|u| u.1 == *name).map(|u| u.2).collect();
            states.len() > 1 && !states.contains(&State::Unclear)
        };
        let apart: Names = counts.keys().filter(|name| several(name)).cloned().collect();
        let of = |(token, name, state): (usize, String, State)| match state {
            State::After(n) if apart.contains(&name) => Some(((token, name), n)),
            _ => None,
        };
        self.after = uses.into_iter().filter_map(of).collect();
        self.assignments = tokens.into_iter().filter(|a| apart.contains(&a.1)).collect();
    }
}

fn since(number: usize) -> String {
    format!(" from assignment {number} on")
}

/// Names in an expression, without fields and switches.
fn words_of(p: &Parsed, span: Span) -> impl Iterator<Item = &str> {
    let mark = |i: usize| p.tokens.get(i).is_some_and(|t| matches!(t.kind, Kind::Mark(b'.' | b'\\')));
    let word = |i: &usize| p.tokens.get(*i).is_some_and(|t| t.kind == Kind::Word);
    span.filter(word).filter(move |i| i.checked_sub(1).is_none_or(|k| !mark(k))).map(|i| p.words.at(i))
}

/// Names that each item sets, by its first token: assignments, what is passed on and may be set, counters of loops, and data of a routine
/// where it starts.
fn set_by_items(text: &Text, p: &Parsed) -> HashMap<usize, Names> {
    let mut found: HashMap<usize, Names> = HashMap::new();
    for (token, names) in Facts::touched_by(text, p, &|item| !is_quiet(p, item)) {
        found.entry(token).or_default().extend(names);
    }
    let mut heads: HashMap<usize, &Span> = HashMap::new();
    for item in p.items.iter().filter(|item| item.kind == ItemKind::Start) {
        heads.entry(item.routine).or_insert(&item.span);
    }
    for d in p.decls.iter().filter(|d| d.storage != Storage::Const) {
        let Some(head) = d.routine.and_then(|r| heads.get(&r)) else { continue };
        // a counter is set by its loop
        if d.storage != Storage::Bound || head.contains(&d.at) {
            found.entry(head.start).or_default().insert(d.name.clone());
        }
    }
    // `i FROM 1 TO 4`
    for item in p.items.iter().filter(|item| item.kind == ItemKind::Loop) {
        if item.span.start.checked_sub(1).is_some_and(|k| p.words.at(k) == "for") {
            found.entry(item.span.start).or_default().insert(p.words.at(item.span.start).to_string());
        }
    }
    found
}

/// Whether an item sets nothing by its arguments: a motion without a call in it, a setting that ends what is known anyway, and the call of
/// a procedure of the task that takes values alone.
fn is_quiet(p: &Parsed, item: &Item) -> bool {
    let ItemKind::Call { .. } = item.kind else { return false };
    let name = p.words.at(item.span.start);
    if words::motion(name).is_some() {
        return facts::called(p, item).count() == 1;
    }
    if words::is_frame(name) {
        return true;
    }
    let head = |r: usize| p.items.iter().find(|item| item.routine == r && item.kind == ItemKind::Start);
    let by_name = |span: &Span| p.words.within(span.clone()).any(|w| matches!(w, "inout" | "var" | "pers"));
    let mut own = (0..p.routines.len()).filter(|r| p.routines[*r].name == name).peekable();
    own.peek().is_some() && own.all(|r| head(r).is_some_and(|item| !by_name(&item.span)))
}

/// Names among `set` of which tool and work object of a motion are made.
fn used(p: &Parsed, item: &Item, set: &HashSet<&str>) -> Vec<String> {
    let ItemKind::Call { .. } = item.kind else { return Vec::new() };
    let any = words::motion(p.words.at(item.span.start)).is_some()
        && p.words.within(item.span.start + 1..item.span.end).any(|w| set.contains(w));
    let Some((motion, args)) = any.then(|| motion_of(p, item)).flatten() else { return Vec::new() };
    let named = args.iter().position(|a| a.name == "tool");
    let goal = positional(&args, motion.target).unwrap_or_default();
    let last = || (0..args.len()).rev().find(|k| *k > goal + 2 && !args[*k].span.is_empty());
    let third = || if motion.tool_third { positional(&args, motion.target + 3) } else { last() };
    let tools = named.or_else(third).map(|k| args[k].span.clone());
    let objects = args.iter().flat_map(|a| &a.switches).filter(|s| s.name == "wobj").filter_map(|s| s.value.clone());
    let spans: Vec<Span> = tools.into_iter().chain(objects).collect();
    let all = spans.into_iter().flat_map(|span| words_of(p, span));
    all.filter(|w| set.contains(w)).map(str::to_string).collect()
}

/// What routines set, themselves or by those that they call; their own data are no one else's.
fn by_routine(p: &Parsed, direct: &HashMap<usize, Names>) -> HashMap<String, Names> {
    let mut all: HashMap<String, Names> = p.routines.iter().map(|r| (r.name.clone(), Names::new())).collect();
    let mut calls: HashSet<(&str, &str)> = HashSet::new();
    for item in &p.items {
        let Some(routine) = p.routines.get(item.routine) else { continue };
        let local = |name: &&String| p.decls.iter().any(|d| d.routine == Some(item.routine) && d.name == **name);
        if let (Some(names), Some(own)) = (direct.get(&item.span.start), all.get_mut(&routine.name)) {
            own.extend(names.iter().filter(|name| !local(name)).cloned());
        }
        calls.extend(facts::called(p, item).filter(|name| all.contains_key(*name)).map(|n| (routine.name.as_str(), n)));
    }
    // it only grows, so that it comes to an end
    loop {
        let mut grown = false;
        for (caller, callee) in &calls {
            let names = all.get(*callee).cloned().unwrap_or_default();
            if let Some(own) = all.get_mut(*caller).filter(|own| !names.is_subset(own)) {
                own.extend(names);
                grown = true;
            }
        }
        if !grown {
            return all;
        }
    }
}

/// The last assignment of a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum State {
    /// None since the program has started.
    Entry,
    After(usize),
    Unclear,
}

/// Where a name has no state: what it had where the routine began.
type States = BTreeMap<String, State>;

/// Goes through the items of the program in the order of the text.
struct Flow<'a> {
    settings: &'a Settings,
    entry: Option<usize>,
    routine: Option<usize>,
    now: States,
    /// State before each open block, and at the ends of its branches; whether one of these is taken in any case.
    blocks: Vec<(States, Vec<States>, bool)>,
    /// Names that have been set since the last move, label or branch.
    open: Names,
    counts: BTreeMap<String, usize>,
    tokens: Vec<(usize, String, usize)>,
    uses: Vec<(usize, String, State)>,
}

impl<'a> Flow<'a> {
    fn new(settings: &'a Settings, entry: Option<usize>) -> Self {
        Self {
            settings,
            entry,
            routine: None,
            now: States::new(),
            blocks: Vec::new(),
            open: Names::new(),
            counts: BTreeMap::new(),
            tokens: Vec::new(),
            uses: Vec::new(),
        }
    }

    /// The state of a name; where the routine is not the one with which the program starts, what held at its start is not known.
    fn state(&self, states: &States, name: &str) -> State {
        let before = if self.routine == self.entry { State::Entry } else { State::Unclear };
        states.get(name).copied().unwrap_or(before)
    }

    fn join(&mut self, other: &States) {
        for name in &self.settings.names {
            let (a, b) = (self.state(&self.now, name), self.state(other, name));
            if a != b {
                self.now.insert(name.clone(), State::Unclear);
            }
        }
    }

    fn forget(&mut self, names: impl IntoIterator<Item = String>) {
        self.now.extend(names.into_iter().map(|name| (name, State::Unclear)));
    }

    /// Names that items set, themselves or by what they call.
    fn set_in<'i>(&self, p: &Parsed, items: impl Iterator<Item = &'i &'i Item>) -> Names {
        let settings = self.settings;
        let of = |item: &&Item| -> Names {
            let called = facts::called(p, item).flat_map(|name| settings.set_by(name));
            settings.set_at(item).chain(called).map(str::to_string).collect()
        };
        items.flat_map(of).collect()
    }

    fn item(&mut self, p: &Parsed, items: &[&Item], k: usize, item: &Item) {
        let of_routine = || items.iter().filter(|other| other.routine == item.routine && other.kind != ItemKind::Start);
        match item.kind {
            ItemKind::Start => {
                let handler = self.routine == Some(item.routine);
                self.routine = Some(item.routine);
                self.now.clear();
                self.blocks.clear();
                if handler {
                    self.forget(self.set_in(p, of_routine()));
                }
            }
            ItemKind::Label => self.forget(self.set_in(p, of_routine())),
            ItemKind::Late => self.forget(self.settings.names.clone()),
            ItemKind::Branch => self.blocks.push((self.now.clone(), Vec::new(), false)),
            ItemKind::Loop => {
                let end = end_of(items, k);
                self.forget(self.set_in(p, items[k..end].iter()));
                self.blocks.push((self.now.clone(), Vec::new(), false));
            }
            ItemKind::Middle => {
                if let Some((before, ends, whole)) = self.blocks.last_mut() {
                    ends.push(std::mem::replace(&mut self.now, before.clone()));
                    *whole |= item.span.is_empty();
                }
            }
            ItemKind::EndBranch | ItemKind::EndLoop => {
                if let Some((before, ends, whole)) = self.blocks.pop() {
                    ends.iter().chain((!whole).then_some(&before)).for_each(|other| self.join(other));
                }
            }
            ItemKind::Leave | ItemKind::Connect | ItemKind::Assign | ItemKind::Call { .. } => {}
        }
        let motion = words::motion(p.words.at(item.span.start)).is_some();
        match item.kind {
            ItemKind::Assign => {}
            ItemKind::Call { .. } if !motion => {}
            _ => self.open.clear(),
        }
        if !matches!(item.kind, ItemKind::Start | ItemKind::Loop) {
            self.set_in(p, [item].iter()).into_iter().for_each(|name| self.set(item.span.start, name));
        }
        if matches!(item.kind, ItemKind::Call { .. }) && motion {
            let set: HashSet<&str> = self.settings.names.iter().map(String::as_str).collect();
            for name in used(p, item, &set) {
                let state = self.state(&self.now, &name);
                self.uses.push((item.span.start, name, state));
            }
        }
    }

    fn set(&mut self, token: usize, name: String) {
        if self.open.insert(name.clone()) {
            let count = self.counts.entry(name.clone()).or_default();
            *count += 1;
            self.tokens.push((token, name.clone(), *count));
        }
        let n = self.counts.get(&name).copied().unwrap_or_default();
        self.now.insert(name, State::After(n));
    }
}

/// The place after the end of the loop at `k`.
fn end_of(items: &[&Item], k: usize) -> usize {
    let mut depth = 0_usize;
    for (n, item) in items.iter().enumerate().skip(k) {
        match item.kind {
            ItemKind::Loop => depth += 1,
            ItemKind::EndLoop => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth == 0 {
            return n + 1;
        }
    }
    items.len()
}
