//! What is known of RAPID's names: which declaration a name means, whether its value is certain, which routines move.
//!
//! A value is certain where nothing in the text can change it and nothing outside can: a CONST; a VAR of a routine; a LOCAL
//! VAR or PERS that is not assigned. A global VAR or PERS may be set by any other module or task, so it is certain only in
//! a text that holds `main` (the program itself), and a note says what that takes for granted.

use super::arguments::{arguments, motion_of, positional};
use super::lex::Kind;
use super::project::LeftOut;
use super::read::{Decl, Item, ItemKind, Parsed, Routine, Span, Storage};
use super::reason::Reason;
use super::words::{self, Leads};
use crate::no_motion::NoMotion;
use crate::script::Text;
use crate::script::called::Needs;
use std::collections::{HashMap, HashSet};

/// What the text does with a declaration beyond moving to it.
#[derive(Debug, Clone, Default)]
pub struct State {
    /// Why its value may differ from the declared one.
    pub changed: Option<Reason>,
    /// Its value is read elsewhere, so it must stay.
    pub read: bool,
    /// Another declaration of the same scope has the same name.
    pub twice: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Scope {
    Routine(usize),
    Module(usize),
    Global,
}

pub struct Facts<'a> {
    pub text: &'a Text,
    pub p: &'a Parsed,
    pub states: Vec<State>,
    index: HashMap<(Scope, &'a str), usize>,
    /// By name: whether a routine of the file may move the robot.
    moving: HashMap<&'a str, bool>,
    /// What routines call, and what the user says of names without a text.
    pub needs: Needs,
    pub has_main: bool,
    /// Values are set by names that are computed (`SetDataVal`).
    sets_by_name: bool,
    left_out: &'a LeftOut,
    /// Names that the text may set, declared here or not; `None`: not asked for.
    touched: Option<HashSet<String>>,
}

impl<'a> Facts<'a> {
    /// Names that a text may set by an assignment or by passing them on, whoever declares them.
    pub fn touched(text: &Text, p: &Parsed) -> HashSet<String> {
        let alone = LeftOut::default();
        let mut f = Facts { touched: Some(HashSet::new()), ..Facts::none(text, p, &alone) };
        f.mark_all(&vec![None; p.items.len()]);
        f.touched.unwrap_or_default()
    }

    /// The same for each item of a kind, by its first token.
    pub fn touched_by(text: &Text, p: &Parsed, which: &dyn Fn(&Item) -> bool) -> Vec<(usize, HashSet<String>)> {
        let alone = LeftOut::default();
        let mut f = Facts { touched: Some(HashSet::new()), ..Facts::none(text, p, &alone) };
        let mut all = Vec::new();
        for item in p.items.iter().filter(|item| which(item)) {
            f.mark(item, None);
            if let Some(names) = f.touched.as_mut().filter(|names| !names.is_empty()) {
                all.push((item.span.start, std::mem::take(names)));
            }
        }
        all
    }

    fn none(text: &'a Text, p: &'a Parsed, left_out: &'a LeftOut) -> Self {
        Self {
            text,
            p,
            states: vec![State::default(); p.decls.len()],
            index: HashMap::new(),
            moving: HashMap::new(),
            needs: Needs::default(),
            has_main: p.routines.iter().any(|r| r.name == "main"),
            sets_by_name: p.words.different().any(|w| w == "setdataval" || w == "setalldataval"),
            left_out,
            touched: None,
        }
    }

    /// `goals`: per item the token of the name that a move leads to, which is no reading of its value; `declared`: routines that move
    /// nothing, where no file has them.
    pub fn new(
        text: &'a Text,
        p: &'a Parsed,
        left_out: &'a LeftOut,
        goals: &[Option<usize>],
        declared: &NoMotion,
    ) -> Self {
        let mut f = Self::none(text, p, left_out);
        f.needs = Needs::new(declared);
        if !declared.is_empty() {
            left_out.routines().iter().for_each(|name| f.needs.is_there(name));
        }
        for (k, d) in p.decls.iter().enumerate() {
            let scope = match d.routine {
                Some(r) => Scope::Routine(r),
                None => Scope::Module(d.module),
            };
            f.enter(scope, k);
            if d.routine.is_none() && !d.local {
                f.enter(Scope::Global, k);
                // what a file beside it goes to stays
                f.states[k].read |= left_out.names(&d.name).is_some();
            }
        }
        f.mark_all(goals);
        f.find_moving();
        f
    }

    fn mark_all(&mut self, goals: &[Option<usize>]) {
        let p = self.p;
        for (item, goal) in p.items.iter().zip(goals) {
            self.mark(item, *goal);
        }
        for d in &p.decls {
            if let Some(value) = &d.value {
                self.mark_span(value.clone(), (d.routine, d.module), None, None);
            }
        }
    }

    fn touch(&mut self, token: usize) {
        let word = self.word(token);
        if let Some(touched) = self.touched.as_mut().filter(|t| !t.contains(word)) {
            touched.insert(word.to_string());
        }
    }

    fn enter(&mut self, scope: Scope, k: usize) {
        let p = self.p;
        if let Some(old) = self.index.insert((scope, p.decls[k].name.as_str()), k) {
            self.states[old].twice = true;
            self.states[k].twice = true;
        }
    }

    pub fn word(&self, i: usize) -> &'a str {
        self.p.words.at(i)
    }

    fn kind(&self, i: usize) -> Option<Kind> {
        self.p.tokens.get(i).map(|t| t.kind)
    }

    /// Declaration that a name means in a routine.
    pub fn resolve(&self, name: &str, routine: Option<usize>, module: usize) -> Option<usize> {
        let at = |scope| self.index.get(&(scope, name)).copied();
        routine.and_then(|r| at(Scope::Routine(r))).or_else(|| at(Scope::Module(module))).or_else(|| at(Scope::Global))
    }

    /// Notes what an item does with names.
    ///
    /// `item = name ":=" expression | instruction | expression`
    fn mark(&mut self, item: &Item, goal: Option<usize>) {
        let place = (Some(item.routine), item.module);
        let first = item.span.start;
        match item.kind {
            ItemKind::Assign => {
                self.touch(first);
                if let Some(d) = self.resolve(self.word(first), place.0, place.1) {
                    let why = Reason::Assigned(self.shown(d).into());
                    self.states[d].changed.get_or_insert(why);
                }
                self.mark_span(first + 1..item.span.end, place, None, None);
            }
            ItemKind::Call { .. } => {
                let name = self.word(first);
                let motion = words::motion(name);
                let reads = motion.is_some() || words::only_reads(name);
                // a search writes the place where it was stopped into its second argument
                if motion.is_some_and(|m| matches!(m.leads, Leads::Search))
                    && let Some((_, args)) = motion_of(self.p, item)
                    && let Some(found) = positional(&args, 1).and_then(|k| args.get(k))
                {
                    self.mark_span(found.span.clone(), place, None, Some(first));
                }
                let from = self.mark_inputs(item, name, place);
                self.mark_span(from..item.span.end, place, goal, (!reads).then_some(first));
            }
            ItemKind::Start | ItemKind::Label | ItemKind::Connect => {}
            ItemKind::Late => self.mark_span(item.span.clone(), place, None, Some(first)),
            _ => self.mark_span(item.span.clone(), place, None, None),
        }
    }

    /// Notes what an instruction does with the arguments whose values it takes and does not set; the token after them.
    ///
    /// `instruction = name argument {"," argument}`
    fn mark_inputs(&mut self, item: &Item, name: &str, place: (Option<usize>, usize)) -> usize {
        let first = item.span.start;
        // a routine of the file with that name is another one
        let inputs = if self.p.routines.iter().any(|r| r.name == name) { 0..0 } else { words::inputs(name) };
        let mut from = first + 1;
        if inputs.is_empty() {
            return from;
        }
        let args = arguments(self.p, from..item.span.end);
        for arg in inputs.filter_map(|n| args.get(positional(&args, n)?)) {
            // `jtZ\XPos:=jtX`: the joints of a switch belong to it
            let end = arg.switches.iter().filter_map(|s| Some(s.value.as_ref()?.end)).fold(arg.span.end, usize::max);
            self.mark_span(from..arg.span.start, place, None, Some(first));
            self.mark_span(arg.span.start..end, place, None, None);
            from = end;
        }
        from
    }

    /// Names in an expression are read, or passed to something that may set them: `callee` is the token of that.
    ///
    /// `expression = {name | name "(" expression ")" | "." field | "\" switch | token}`
    fn mark_span(&mut self, span: Span, place: (Option<usize>, usize), goal: Option<usize>, callee: Option<usize>) {
        let mut callees: Vec<Option<usize>> = Vec::new();
        for i in span {
            match self.kind(i) {
                Some(Kind::Mark(b'(')) => {
                    let function = i.checked_sub(1).filter(|&k| self.kind(k) == Some(Kind::Word));
                    let foreign = function.filter(|&k| {
                        let name = self.word(k);
                        (!words::is_function(name) || words::sets_argument(name)) && !words::is_operator(name)
                    });
                    callees.push(foreign.filter(|&k| self.word(k) != "not"));
                }
                Some(Kind::Mark(b')')) => {
                    callees.pop();
                }
                Some(Kind::Word) if Some(i) != goal => {
                    let before = i.checked_sub(1).and_then(|k| self.kind(k));
                    if matches!(before, Some(Kind::Mark(b'.' | b'\\'))) {
                        continue;
                    }
                    let by = callees.iter().rev().find_map(|c| *c).or(callee);
                    if by.is_some() {
                        self.touch(i);
                    }
                    let Some(d) = self.resolve(self.word(i), place.0, place.1) else { continue };
                    self.states[d].read = true;
                    if let Some(by) = by
                        && self.p.decls[d].storage != Storage::Const
                    {
                        let to = String::from_utf8_lossy(self.text.slice(self.bytes(by))).into();
                        let why = Reason::Passed { name: self.shown(d).into(), to };
                        self.states[d].changed.get_or_insert(why);
                    }
                }
                _ => {}
            }
        }
    }

    fn bytes(&self, token: usize) -> std::ops::Range<usize> {
        self.p.tokens.get(token).map_or(0..0, |t| t.start()..t.end())
    }

    /// A declaration's name as it is written.
    pub fn shown(&self, d: usize) -> String {
        String::from_utf8_lossy(self.text.slice(self.bytes(self.p.decls[d].at))).into_owned()
    }

    /// Whether the declared value is the one that counts at run time; else why not.
    pub fn certain(&self, d: usize) -> Result<(), Reason> {
        let decl: &Decl = &self.p.decls[d];
        let state = &self.states[d];
        let shown = || self.shown(d).into();
        if state.twice {
            return Err(Reason::Twice(shown()));
        }
        match decl.storage {
            Storage::Bound => return Err(Reason::Parameter(shown())),
            Storage::Const => return Ok(()),
            Storage::Var | Storage::Pers => {}
        }
        if let Some(why) = &state.changed {
            return Err(why.clone());
        }
        if self.sets_by_name {
            return Err(Reason::SetDataVal(shown()));
        }
        if let Some(by) = self.left_out.by_name() {
            return Err(Reason::SetByName { name: shown(), by });
        }
        if decl.routine.is_some() || decl.local {
            return Ok(());
        }
        if let Some(by) = self.left_out.sets(&decl.name, &value_of(self.text, self.p, decl)) {
            return Err(Reason::SetElsewhere { name: shown(), by });
        }
        if self.has_main {
            return Ok(());
        }
        Err(Reason::Global(shown()))
    }

    /// Whether calls of a procedure by its name stand in this text alone. A file that is left out of the program may call one that is not
    /// LOCAL.
    pub fn is_called_here_alone(&self, r: &Routine) -> bool {
        let alone = self.p.routines.iter().filter(|other| other.name == r.name).count() == 1;
        r.procedure && alone && (r.local || self.has_main && !self.left_out.calls(&r.name))
    }

    /// Whether a file that is left out of the program sets data by names that are computed.
    pub fn is_set_by_name_outside(&self) -> bool {
        self.left_out.by_name().is_some()
    }

    /// Whether other modules can use a declaration that is not in the program's own text.
    pub fn reaches_out(&self, d: usize) -> bool {
        let decl = &self.p.decls[d];
        decl.routine.is_none() && !decl.local && !self.has_main
    }

    /// Whether a call of this name may move the robot or shift its targets.
    pub fn may_move(&self, name: &str) -> bool {
        if words::motion(name).is_some() || words::is_frame(name) {
            return true;
        }
        match self.moving.get(name) {
            Some(moving) => *moving,
            None => !(self.is_known(name) || self.needs.is_declared(name)),
        }
    }

    /// Whether a name is one of the language that moves nothing.
    fn is_known(&self, name: &str) -> bool {
        words::is_quiet(name) || words::is_wait(name) || words::is_function(name)
    }

    /// What routines call, for those who ask what they need to move nothing.
    fn find_needs(&mut self) {
        let p = self.p;
        let moves = |name: &str| {
            words::motion(name).is_some() || words::is_frame(name) || words::arms(name) || words::moves(name)
        };
        for r in &p.routines {
            self.needs.add(&r.name, false, []);
        }
        for item in &p.items {
            let Some(routine) = p.routines.get(item.routine) else { continue };
            let late = matches!(item.kind, ItemKind::Late | ItemKind::Connect);
            let unknown = |name: &&str| !moves(name) && (self.moving.contains_key(name) || !self.is_known(name));
            let calls: Vec<String> = called(p, item).filter(unknown).map(str::to_string).collect();
            let moves = late || called(p, item).any(|name| !self.moving.contains_key(name) && moves(name));
            if moves || !calls.is_empty() {
                self.needs.add(&routine.name, moves, calls);
            }
        }
    }

    /// Routines of the file that move, or call what may.
    fn find_moving(&mut self) {
        let p = self.p;
        let mut callers: HashMap<&str, Vec<usize>> = HashMap::new();
        let mut work: Vec<usize> = Vec::new();
        self.moving = p.routines.iter().map(|r| (r.name.as_str(), false)).collect();
        self.find_needs();
        for item in &p.items {
            let mut moves = matches!(item.kind, ItemKind::Late | ItemKind::Connect);
            for name in called(p, item) {
                if self.moving.contains_key(name) {
                    callers.entry(name).or_default().push(item.routine);
                } else {
                    moves |= self.may_move(name) || words::arms(name);
                }
            }
            if moves {
                work.push(item.routine);
            }
        }
        while let Some(r) = work.pop() {
            let name = p.routines[r].name.as_str();
            if self.moving.insert(name, true) == Some(false) {
                work.extend(callers.get(name).into_iter().flatten());
            }
        }
    }
}

/// The declared value as it is written, without blanks; empty: none.
pub fn value_of(text: &Text, p: &Parsed, d: &Decl) -> Vec<u8> {
    let tokens = d.value.clone().and_then(|span| p.tokens.get(span)).unwrap_or_default();
    tokens.iter().flat_map(|t| text.slice(t.start()..t.end()).iter().chain(b" ")).copied().collect()
}

/// Names of the procedures and functions that an item calls, in lower case.
///
/// `call = procedure ... | function "(" ...`
pub fn called<'a>(p: &'a Parsed, item: &Item) -> impl Iterator<Item = &'a str> {
    let procedure = matches!(item.kind, ItemKind::Call { .. }).then_some(item.span.start);
    let quiet = matches!(item.kind, ItemKind::Start | ItemKind::Label);
    let span = if quiet { 0..0 } else { item.span.clone() };
    let functions = span.filter(move |&i| {
        let open = p.tokens.get(i + 1).is_some_and(|t| t.kind == Kind::Mark(b'('));
        let word = p.words.at(i);
        open && !word.is_empty() && !words::is_operator(word) && word != "not"
    });
    // `IF (a) ...`: the bracket belongs to no name when the word stands in front of the span
    let end = item.span.end;
    procedure.into_iter().chain(functions.filter(move |&i| i + 1 < end)).map(move |i| p.words.at(i))
}
