//! What holds at each place of a task, followed along control ([`reach`](crate::script::reach)): whether the controller looks at
//! configurations (`ConfJ`, `ConfL`), whether a program displacement is on (`PDispOn`, `PDispSet`, `PDispOff`), and which moves may come
//! last before the program reads where the robot stands.
//!
//! `ConfJ` and `ConfL` are states of the task (ABB, Technical reference manual, RAPID Instructions: valid until the next of them; on at a
//! restart), so that they go with control through calls, branches, loops and handlers of all modules. A handler may run after any item of
//! its routine; `%name%` and `CallByVar` may call any procedure whose name begins as the name is written; a routine that no file has
//! may have switched what the task switches. In a task without `main`, routines that none calls may run one after the other.
//!
//! Where an error or an interrupt strikes the robot stands anywhere on its way: a reading there is one of no move before it.

use super::arguments::{Given, given};
use super::facts;
use super::lex::Kind;
use super::read::{Item, ItemKind, Parsed};
use super::rules::{Configured, Watched};
use super::words::{self, Leads};
use crate::script::Text;
use crate::script::blocks::is_entered;
use crate::script::lex::text_of;
use crate::script::reach::{Atoms, BEFORE, Block, Event, FIRST, Reach, Routine, State, add, set_by};
use std::collections::{BTreeSet, HashSet};

/// Kinds of settings: those of `ConfJ` and `ConfL`, that of the program displacement, and the move that came last.
const WATCHES: [&str; 2] = ["confj", "confl"];
const DISPLACED: usize = 2;
const LAST: usize = 3;
const KINDS: usize = 4;
/// Settings of the first three; with that of [`BEFORE`] configurations are watched, and nothing is displaced: `PP to Main` ends a
/// displacement.
const ON: u32 = FIRST;
const OFF: u32 = FIRST + 1;

/// A routine that no file has. No routine of a file has a blank in its name.
const ELSEWHERE: &str = "no file";
/// A label that stands nowhere: control goes out of the routine.
const OUT: &str = "";

/// What holds before each item.
#[derive(Default)]
pub struct InForce {
    states: Option<(Found, Reach)>,
    /// Items whose moves may be the last before a reading.
    read: BTreeSet<usize>,
}

/// The routines of a task.
struct Found {
    /// First item of each routine but the first, which calls those that are called from outside.
    first: Vec<usize>,
    /// What traps may set at any place.
    always: State,
    unknown: State,
}

impl InForce {
    /// Of the items of a task; `may_move`: whether a name that no routine has may be one that moves.
    pub fn of(text: &Text, p: &Parsed, may_move: &dyn Fn(&str) -> bool) -> Self {
        let watches = p.words.different().any(|w| WATCHES.contains(&w));
        let states = watches || p.words.different().any(displaces);
        let readings: Vec<usize> = (0..p.items.len()).filter(|k| reads_place(p, &p.items[*k])).collect();
        if !states && readings.is_empty() {
            return Self::default();
        }
        let (found, reach) = Scan::of(text, p, may_move, &readings);
        let mut read = BTreeSet::new();
        for k in readings {
            // what its own condition or expression calls has moved before it
            for place in [k, k + 1] {
                let atoms = found.atoms(&reach, LAST, k, place);
                read.extend(atoms.into_iter().filter_map(|atom| Some(atom.checked_sub(FIRST)? as usize)));
            }
        }
        Self { states: states.then_some((found, reach)), read }
    }

    /// Whether configurations are watched before an item.
    pub fn configured(&self, item: usize) -> Configured {
        let Some((found, reach)) = &self.states else { return Configured::default() };
        let of = |kind: usize| {
            let atoms = found.atoms(reach, kind, item, item);
            match (atoms.contains(&OFF), atoms.iter().any(|a| *a != OFF)) {
                (true, true) => Watched::Perhaps,
                (true, false) => Watched::Off,
                (false, _) => Watched::On,
            }
        };
        Configured { joint: of(0), linear: of(1) }
    }

    /// Whether targets may be displaced before an item.
    pub fn is_displaced(&self, item: usize) -> bool {
        let Some((found, reach)) = &self.states else { return false };
        found.atoms(reach, DISPLACED, item, item).contains(&ON)
    }

    /// Whether the program may read where the robot stands after the last move of an item.
    pub fn is_read(&self, item: usize) -> bool {
        self.read.contains(&item)
    }
}

impl Found {
    fn atoms(&self, reach: &Reach, kind: usize, item: usize, place: usize) -> Atoms {
        let routine = self.first.partition_point(|first| *first <= item);
        let state = reach.after(routine, place).unwrap_or(&self.unknown);
        let of = |state: &State| state.get(kind).cloned().unwrap_or_default();
        of(state).union(&of(&self.always)).copied().collect()
    }
}

/// Whether an instruction displaces targets (in lower case).
pub fn displaces(name: &str) -> bool {
    name.starts_with("pdispon") || name == "pdispset"
}

/// Whether an item takes on where the robot stands: into the program, not into a message or a file.
///
/// `reading = ("CRobT" | "CJointT" | "CPos" | "ReadMotor") "(" ... ")" | ("PDispOn" | "EOffsOn") ...` without `\ExeP`: these displace by where the robot stands
/// (ABB, Technical reference manual, RAPID Instructions)
fn reads_place(p: &Parsed, item: &Item) -> bool {
    const WRITES: [&str; 7] = ["tpwrite", "errwrite", "write", "writeanybin", "writestrbin", "socketsend", "tpshow"];
    let says = |word: &str| p.words.within(item.span.clone()).any(|w| w == word);
    let name = p.words.at(item.span.start);
    match item.kind {
        ItemKind::Start | ItemKind::Label => return false,
        ItemKind::Call { .. }
            if matches!(name, "pdispon" | "eoffson") && given(p, &item.span, "exep") != Given::Yes =>
        {
            return true;
        }
        ItemKind::Call { .. } if WRITES.contains(&name) => return false,
        _ => {}
    }
    ["crobt", "cjointt", "cpos", "readmotor"].into_iter().any(says)
}

/// Events of the items of a task.
struct Scan<'a> {
    text: &'a Text,
    p: &'a Parsed,
    may_move: &'a dyn Fn(&str) -> bool,
    names: HashSet<&'a str>,
    /// Routines with a handler, by their numbers.
    handled: HashSet<usize>,
    readings: &'a [usize],
    routines: Vec<Routine>,
    first: Vec<usize>,
    /// The routine at hand, and whether its handler is.
    now: (Option<usize>, bool),
    /// What is called from routines with a handler, and how the names of those that are called by a name begin.
    inside: BTreeSet<String>,
    late: BTreeSet<String>,
}

impl<'a> Scan<'a> {
    fn of(text: &'a Text, p: &'a Parsed, may_move: &'a dyn Fn(&str) -> bool, readings: &'a [usize]) -> (Found, Reach) {
        let names = p.routines.iter().map(|r| r.name.as_str()).collect();
        let mut scan = Self {
            text,
            p,
            may_move,
            names,
            handled: handled(p),
            readings,
            routines: vec![Routine::default()],
            first: Vec::new(),
            now: (None, false),
            inside: BTreeSet::new(),
            late: BTreeSet::new(),
        };
        for (k, item) in p.items.iter().enumerate() {
            scan.item(k, item);
        }
        scan.finish()
    }

    fn push(&mut self, k: usize, event: Event) {
        if let Some(routine) = self.routines.last_mut() {
            routine.events.push((k, event));
        }
    }

    fn item(&mut self, k: usize, item: &Item) {
        let before = self.routines.last().map_or(0, |r| r.events.len());
        match item.kind {
            ItemKind::Start => return self.start(k, item),
            ItemKind::Branch => {
                self.called(k, item);
                let test = item.span.start.checked_sub(1).is_some_and(|at| self.p.words.at(at) == "test");
                self.push(k + 1, Event::Open(if test { Block::Switch } else { Block::Branch }));
            }
            ItemKind::Loop => {
                let block = self.loop_of(item);
                self.push(k + 1, Event::Open(block));
                self.called(k, item);
            }
            ItemKind::Middle => {
                self.push(k + 1, Event::Middle(item.span.is_empty()));
                self.called(k, item);
            }
            ItemKind::EndBranch | ItemKind::EndLoop => self.push(k + 1, Event::Close),
            ItemKind::Label => self.push(k + 1, Event::Label(self.p.words.at(item.span.start).to_string())),
            ItemKind::Leave => {
                self.called(k, item);
                let event = match self.p.words.at(item.span.start) {
                    "goto" => Event::Jump(self.p.words.at(item.span.start + 1).to_string()),
                    "exit" | "raise" => Event::Jump(OUT.into()),
                    // RETRY and TRYNEXT: back to the routine of the handler
                    _ => Event::End,
                };
                self.push(k + 1, event);
            }
            ItemKind::Connect => {}
            ItemKind::Late => {
                self.called(k, item);
                self.late(k, item.span.start + 1);
            }
            ItemKind::Assign => self.called(k, item),
            ItemKind::Call { .. } => {
                self.called(k, item);
                self.instruction(k, item);
            }
        }
        if self.routines.last().map_or(0, |r| r.events.len()) != before {
            self.handler_may_run(k, item);
        }
    }

    /// A routine starts, or a handler of it.
    fn start(&mut self, k: usize, item: &Item) {
        let handler = self.now.0 == Some(item.routine);
        let routine = self.p.routines.get(item.routine);
        let name = routine.map(|r| r.name.clone()).unwrap_or_default();
        self.now = (Some(item.routine), handler);
        self.first.push(k);
        let name = if handler { handler_of(&name) } else { name };
        self.routines.push(Routine { name, events: Vec::new() });
        if handler || routine.is_some_and(|r| r.is_trap) {
            self.push(k, Event::Set(LAST, BEFORE));
        }
        self.handler_may_run(k, item);
    }

    /// After an item of a routine its handler may run, also from inside of what the item calls.
    fn handler_may_run(&mut self, k: usize, item: &Item) {
        if self.now.1 || !self.handled.contains(&item.routine) {
            return;
        }
        let Some(name) = self.p.routines.get(item.routine).map(|r| handler_of(&r.name)) else { return };
        let called: Vec<String> = facts::called(self.p, item).filter(|n| self.names.contains(n)).map(inside).collect();
        self.push(k + 1, Event::Open(Block::Branch));
        for inside in called {
            self.push(k + 1, Event::Call(inside.clone()));
            self.inside.insert(inside);
        }
        self.push(k + 1, Event::Call(name));
        self.push(k + 1, Event::Close);
    }

    /// `head = "WHILE" condition "DO" | "FOR" name "FROM" start "TO" end ["STEP" step] "DO"`
    fn loop_of(&self, item: &Item) -> Block {
        let head = item.span.start.saturating_sub(1)..item.span.end;
        let tokens = self.p.tokens.get(head.clone()).unwrap_or_default();
        let bytes = tokens.first().map_or(0, |t| t.start())..tokens.last().map_or(0, |t| t.end());
        match is_entered(self.text.slice(bytes)) {
            false => Block::Loop,
            true if self.p.words.at(head.start) == "for" => Block::Entered,
            true => Block::Endless,
        }
    }

    /// What the expressions of an item call.
    fn called(&mut self, k: usize, item: &Item) {
        let own = usize::from(matches!(item.kind, ItemKind::Call { .. }));
        for name in facts::called(self.p, item).skip(own) {
            self.call(k, name);
        }
    }

    fn call(&mut self, k: usize, name: &str) {
        if self.names.contains(name) {
            self.push(k + 1, Event::Call(name.to_string()));
            return;
        }
        let of_rapid =
            words::motion(name).is_some() || words::is_frame(name) || words::arms(name) || words::moves(name);
        if !of_rapid && (self.may_move)(name) {
            self.push(k + 1, Event::Call(ELSEWHERE.into()));
        }
    }

    /// `instruction = ("ConfJ" | "ConfL") ["\" ("On" | "Off")] | motion ... | "ExitCycle" | "CallByVar" text "," number | procedure ...`
    fn instruction(&mut self, k: usize, item: &Item) {
        let name = self.p.words.at(item.span.start);
        if let Some(kind) = WATCHES.iter().position(|w| *w == name) {
            let off = given(self.p, &item.span, "off");
            self.push(k + 1, Event::Set(kind, if off == Given::Yes { OFF } else { ON }));
            if off == Given::Perhaps {
                self.push(k + 1, Event::Open(Block::Branch));
                self.push(k + 1, Event::Set(kind, OFF));
                self.push(k + 1, Event::Close);
            }
            return;
        }
        match (name, words::motion(name)) {
            _ if self.names.contains(name) => self.call(k, name),
            (_, Some(motion)) => {
                // external axes alone: the arm stands where the move before left it
                let beside = motion.leads == Leads::External;
                if beside {
                    self.push(k + 1, Event::Open(Block::Branch));
                }
                if let Some(routine) = self.routines.last_mut() {
                    routine.comes_last(k + 1, LAST, k, self.readings);
                }
                if beside {
                    self.push(k + 1, Event::Close);
                }
            }
            ("exitcycle", _) => {
                self.push(k + 1, Event::Call("main".into()));
                self.push(k + 1, Event::Jump(OUT.into()));
            }
            ("callbyvar", _) => self.late(k, item.span.start + 1),
            ("pdispoff", _) => self.push(k + 1, Event::Set(DISPLACED, OFF)),
            _ if displaces(name) => self.push(k + 1, Event::Set(DISPLACED, ON)),
            _ => self.call(k, name),
        }
    }

    /// A call by a name that is computed, of which the text that begins it is known where it stands there.
    ///
    /// `name = text {"+" expression}`
    fn late(&mut self, k: usize, at: usize) {
        let first = self.p.tokens.get(at).filter(|t| t.kind == Kind::String);
        let begins = first.map(|t| text_of(self.text.slice(t.start()..t.end())).trim_matches('"').to_lowercase());
        // `"module:procedure"`
        let begins = begins.filter(|b| !b.contains(':')).unwrap_or_default();
        let name = late(&begins);
        self.late.insert(begins);
        self.push(k + 1, Event::Call(name));
        // it may stand in a module that is loaded later
        self.push(k + 1, Event::Open(Block::Branch));
        self.push(k + 1, Event::Set(DISPLACED, ON));
        self.push(k + 1, Event::Close);
    }

    fn finish(self) -> (Found, Reach) {
        let Self { p, mut routines, first, inside: inside_of, late: begins, .. } = self;
        let called = |name: &str| {
            let is = |(_, e): &(usize, Event)| matches!(e, Event::Call(called) if called == name);
            routines.iter().any(|r| r.events.iter().any(is))
        };
        let procedures = || p.routines.iter().filter(|r| r.procedure).map(|r| r.name.as_str());
        let outside: Vec<&str> = match procedures().any(|name| name == "main") {
            true => vec!["main"],
            false => procedures().filter(|name| !called(name)).collect(),
        };
        // one after the other, again and again
        let mut events = vec![(0, Event::Open(Block::Endless))];
        events.extend(any_of(outside.into_iter().map(|name| Event::Call(name.into()))));
        events.push((0, Event::Close));
        if let Some(routine) = routines.first_mut() {
            routine.events = events;
        }
        let mut all = vec![Atoms::from([BEFORE]); KINDS];
        routines.iter().flat_map(|r| &r.events).for_each(|(_, event)| add(event, &mut all));
        let sets = |state: &State, kinds: std::ops::Range<usize>| {
            let of = |kind: usize| state.get(kind).into_iter().flatten().map(move |atom| Event::Set(kind, *atom));
            any_of(kinds.flat_map(of).filter(|e| !matches!(e, Event::Set(_, BEFORE))))
        };
        for name in inside_of {
            let own = name.strip_suffix(INSIDE).unwrap_or(&name).to_string();
            let events = sets(&set_by(&routines, &BTreeSet::from([own]), KINDS), 0..LAST);
            routines.push(Routine { name, events });
        }
        for begin in begins {
            let calls = procedures().filter(|name| name.starts_with(&begin)).map(|name| Event::Call(name.into()));
            routines.push(Routine { name: late(&begin), events: any_of(calls) });
        }
        routines.push(Routine { name: ELSEWHERE.into(), events: sets(&all, 0..LAST) });
        let traps: BTreeSet<String> = p.routines.iter().filter(|r| r.is_trap).map(|r| r.name.clone()).collect();
        let mut unknown = all;
        unknown[LAST] = Atoms::from([BEFORE]);
        let start = |(k, routine): (usize, &Routine)| match k {
            0 => Some(vec![Atoms::from([BEFORE]); KINDS]),
            _ => traps.contains(&routine.name).then(|| unknown.clone()),
        };
        let starts: Vec<Option<State>> = routines.iter().enumerate().map(start).collect();
        let always = set_by(&routines, &traps, KINDS);
        let reach = Reach::of(&routines, &starts, &unknown);
        (Found { first, always, unknown }, reach)
    }
}

/// Any of these events, or none.
fn any_of(events: impl Iterator<Item = Event>) -> Vec<(usize, Event)> {
    let each = events.flat_map(|event| [(0, Event::Middle(false)), (0, event)]);
    std::iter::once((0, Event::Open(Block::Switch))).chain(each).chain([(0, Event::Close)]).collect()
}

/// Routines that have a handler.
fn handled(p: &Parsed) -> HashSet<usize> {
    let (mut started, mut found) = (HashSet::new(), HashSet::new());
    for item in p.items.iter().filter(|item| item.kind == ItemKind::Start) {
        if !started.insert(item.routine) {
            found.insert(item.routine);
        }
    }
    found
}

/// The name under which the handlers of a routine are followed.
fn handler_of(name: &str) -> String {
    format!("{name} handler")
}

const INSIDE: &str = " inside";

/// The name of what a routine may have set where an error strikes in it.
fn inside(name: &str) -> String {
    format!("{name}{INSIDE}")
}

/// The name of any procedure whose name begins so.
fn late(begins: &str) -> String {
    format!("any {begins}")
}
