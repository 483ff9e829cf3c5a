//! The steps of a RAPID program: moves with their targets, and what ends a joint's known direction.
//!
//! Read this file first: from statements to steps. Then [`motion`]: a motion instruction; [`alike`]: motions that differ in their joint
//! values alone, read once; [`cycle`]: where `main` ends; [`entered`]: from where control comes to a procedure; [`numbers`]: the values of
//! expressions.

mod alike;
mod cycle;
mod entered;
mod motion;
mod numbers;

use super::arguments::{Arg, arguments, goal_of, motion_of, positional};
use super::built::{Built, Literal, SharedSite};
use super::callers;
use super::facts::{self, Facts};
use super::in_force::{self, InForce};
use super::led::Led;
use super::lex::Kind;
use super::project::Project;
use super::read::{Item, ItemKind, Parsed, Span};
use super::rules::{Configured, External, Going, entry_routine};
use super::settings::Settings;
use super::value::{self, Node};
use super::words::{self, Motion};
use crate::axes::Axes;
use crate::error::Result;
use crate::script::alike::Passed;
use crate::script::blocks::{Steps, is_entered};
use crate::script::called::{NamedCalls, strikes};
use crate::script::without_joint::WithoutJoint;
use crate::script::{At, Break, Note, Reason, StepKind, Targets, Text, number};
use cycle::Cycle;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

/// Reads the items of a file as steps. `None`: lines without tokens are more than the numbers in which they differ from the statement
/// before them, so that all have to be read.
pub fn build(texts: Vec<Text>, project: &Project, robot: &Axes) -> Result<Option<Built>> {
    let (text, p) = (&project.text, &project.parsed);
    let own_end = project.own_end();
    let own = |item: &Item| p.tokens.get(item.span.start).is_none_or(|t| t.start() < own_end);
    // a move of another module needs the value that stands here; arguments are read again where they are needed, and never all held
    let goal = |item: &Item| if own(item) { goal_of(p, item) } else { None };
    let goals: Vec<Option<usize>> = p.items.iter().map(goal).collect();
    let entry = entry_routine(p, &|item| own(item));
    let is_main = |k: usize| p.routines.get(k).is_some_and(|r| r.name == "main");
    // nor does a program start with a trap or a function
    let starts_anywhere = entry.is_none_or(|k| !is_main(k) && p.routines.iter().any(|r| r.name == "main"));
    let going_first = Going::first(text, p);
    let mut b = Builder {
        settings: Settings::of(text, p, &|item| own(item), entry),
        f: Facts::new(text, p, &project.left_out, &goals, &robot.no_motion),
        project,
        robot,
        displaced: false,
        steps: Steps::of_text(text),
        targets: Targets::of_text(text),
        literals: Vec::with_capacity(text.likely_steps()),
        externals: Vec::with_capacity(text.likely_steps()),
        without_joint: WithoutJoint::of(robot),
        external: None,
        external_before: Vec::new(),
        configured: Configured::default(),
        going: Going::default(),
        going_first,
        led: Led::of(text, p, going_first),
        led_before: Vec::new(),
        known: HashMap::new(),
        kept_points: HashSet::new(),
        nodes: HashMap::new(),
        numbers: HashMap::new(),
        notes: BTreeMap::new(),
        synchronised: false,
        moved: false,
        called_here: HashSet::new(),
        calls_of: (usize::MAX, Vec::new()),
        entering: false,
        named_calls: NamedCalls::default(),
        entry_routine: entry.filter(|_| !starts_anywhere),
        cycle: Cycle::default(),
    };
    b.called_here = callers::all_known(&b.f, &|item| own(item));
    let in_force = InForce::of(text, p, &|name| b.f.may_move(name));
    let displaces = p.words.different().any(in_force::displaces);
    let mut passed = p.passed.iter().peekable();
    for (k, item) in p.items.iter().enumerate().filter(|(_, item)| own(item)) {
        let notes = b.notes.len();
        b.configured = in_force.configured(k);
        b.displaced = displaces && in_force.is_displaced(k);
        b.item(item, motion_of(p, item))?;
        let after = |lines: &&Passed| lines.token == item.span.end + 1;
        if let Some(lines) = passed.next_if(after)
            && (b.notes.len() > notes || b.again(item, lines).is_none())
        {
            return Ok(None);
        }
        if in_force.is_read(k) {
            b.steps.fix_last_move(Reason::EndIsRead);
        }
    }
    if passed.next().is_some() {
        return Ok(None);
    }
    if b.cycle.ends() {
        b.steps.runs_again();
    }
    b.steps.pragmas(text, &p.comments, own_end);
    b.note_assignments();
    b.keep_points();
    let Builder { steps, targets, literals, notes, named_calls, without_joint, .. } = b;
    let mut out = Built { literals, ..Built::default() };
    out.sites = steps.finish(&mut out.script);
    if let Some(without) = without_joint {
        without.close(&mut out.script.steps);
    }
    out.script.targets = targets;
    out.script.notes = notes.into_values().collect();
    named_calls.report_to(&mut out.script);
    out.script.starts_anywhere |= starts_anywhere;
    out.script.texts = texts;
    Ok(Some(out))
}

pub struct Builder<'a> {
    pub f: Facts<'a>,
    /// Where the program sets what tools and work objects are made of.
    pub settings: Settings,
    pub project: &'a Project,
    pub robot: &'a Axes,
    /// A program displacement may be on at the item.
    pub displaced: bool,
    steps: Steps<SharedSite>,
    pub targets: Targets,
    pub literals: Vec<Literal>,
    /// External axes of each target.
    pub externals: Vec<Arc<External>>,
    /// Numbers of each joint target for which the robot file has no joint.
    pub without_joint: Option<WithoutJoint>,
    /// ... and of the goal before, on the same stretch.
    pub external: Option<Arc<External>>,
    /// The same before each block that is open: there its branches begin.
    external_before: Vec<Option<Arc<External>>>,
    /// Whether configurations are watched at the item.
    pub configured: Configured,
    going: Going,
    going_first: Going,
    /// What may lead the arm from before a routine or a loop.
    led: Led,
    /// What leads the arm away before each open block, or at the end of one of its branches: a block may be passed by.
    led_before: Vec<Option<&'static str>>,
    /// Targets of declarations, by declaration and index list.
    pub known: HashMap<(usize, Vec<usize>), usize>,
    /// Declarations whose values moves need that have no target of their own.
    pub kept_points: HashSet<usize>,
    /// Values of declarations.
    nodes: HashMap<usize, Option<Node>>,
    /// Values of numbers that are declared, where they are certain.
    numbers: HashMap<usize, Option<f64>>,
    notes: BTreeMap<(u64, String), Note>,
    synchronised: bool,
    /// The routine or the handler moved above.
    moved: bool,
    /// Procedures of which all calls stand in the program.
    called_here: HashSet<usize>,
    /// A routine, and the procedures that it calls: its handler may run the call again that failed, from where that has led (RETRY).
    calls_of: (usize, Vec<String>),
    /// Nothing has moved since the routine at hand began.
    pub entering: bool,
    named_calls: NamedCalls,
    /// The routine with which the program starts.
    entry_routine: Option<usize>,
    cycle: Cycle,
}

impl Builder<'_> {
    pub fn at(&self, token: usize) -> At {
        self.project.at(self.f.p.tokens.get(token).map_or(0, |t| t.start()))
    }

    fn push(&mut self, token: usize, kind: StepKind) -> usize {
        if matches!(kind, StepKind::Break(_)) {
            self.external = None;
        }
        self.steps.push(self.at(token), kind)
    }

    fn close(&mut self, token: usize, kind: Break) {
        if self.steps.close(self.at(token), kind) {
            self.external = None;
        }
    }

    pub fn note(&mut self, token: usize, text: String) {
        let place = self.at(token);
        self.notes.entry((place.line, text.clone())).or_insert(Note { place, text });
    }

    fn item(&mut self, item: &Item, motion: Option<(Motion, Vec<Arg>)>) -> Result<()> {
        let token = item.span.start;
        self.follow_cycle(item, motion.is_some());
        self.going.follow(self.f.text, self.f.p, item);
        self.going.pass_by(&mut self.led_before, item.kind);
        self.led.enter(self.f.p, item, self.going_first, &mut self.going);
        match item.kind {
            ItemKind::Start => self.external_before.clear(),
            ItemKind::Branch | ItemKind::Loop => self.external_before.push(self.external.clone()),
            ItemKind::Middle => self.external = self.external_before.last().cloned().flatten(),
            ItemKind::EndBranch | ItemKind::EndLoop => drop(self.external_before.pop()),
            _ => {}
        }
        if let Some(t) = self.f.p.tokens.get(token) {
            self.steps.pragmas(self.f.text, &self.f.p.comments, t.start());
        }
        if item.kind != ItemKind::Start && motion.is_none() && !matches!(item.kind, ItemKind::Call { .. }) {
            let calls = facts::called(self.f.p, item).any(|name| self.f.may_move(name));
            if calls {
                self.push(token, StepKind::Break(Break::Call));
            }
        }
        if item.kind != ItemKind::Start {
            self.name_calls(item);
        }
        match item.kind {
            ItemKind::Start => {
                self.steps.start();
                let name = self.f.p.routines.get(item.routine).map(|r| r.name.clone()).unwrap_or_default();
                self.steps.routine(item.routine, name);
                if self.called_here.contains(&item.routine) {
                    self.steps.all_calls_are_here(true);
                }
                self.entering = true;
                self.synchronised = false;
                self.moved = false;
                let k = self.push(token, StepKind::Break(Break::Start));
                if self.entry_routine == Some(item.routine) {
                    self.steps.entry.get_or_insert(k);
                }
            }
            ItemKind::Branch => self.steps.open(self.at(token), Break::Jump),
            ItemKind::Loop => {
                let entered = self.head(item).is_some_and(|(_, head)| is_entered(head));
                self.steps.open_loop(self.at(token), entered);
            }
            ItemKind::Middle => self.steps.branch(self.at(token), item.span.is_empty()),
            ItemKind::EndBranch => self.close(token, Break::Jump),
            ItemKind::EndLoop => self.close(token, Break::Loop),
            ItemKind::Label => {
                self.steps.lands();
                self.push(token, StepKind::Break(Break::Jump));
            }
            ItemKind::Connect => {
                self.push(token, StepKind::Break(Break::Interrupt));
                let trap = self.f.p.words.within(item.span.clone()).filter(|w| *w != "with").last();
                if let Some(trap) =
                    trap.filter(|t| self.f.p.routines.iter().any(|r| r.name == *t) && self.f.may_move(t))
                {
                    let note = strikes(self.at(token), trap);
                    self.notes.entry((note.place.line, note.text.clone())).or_insert(note);
                }
            }
            ItemKind::Late => {
                self.push(token, StepKind::Break(Break::Call));
            }
            ItemKind::Leave => self.leave(token, item.routine),
            ItemKind::Assign => {}
            ItemKind::Call { alone } => match motion {
                Some((motion, args)) => {
                    self.moved = true;
                    self.motion(item, motion, args, alone)?;
                }
                None => self.call(item),
            },
        }
        self.set_names(item);
        Ok(())
    }

    /// Tools and work objects that are others after an item; what a routine that may move sets is seen where it stands.
    fn set_names(&mut self, item: &Item) {
        let still = facts::called(self.f.p, item).filter(|name| !self.f.may_move(name));
        let called = still.flat_map(|name| self.settings.set_by(name));
        let names: BTreeSet<String> = self.settings.set_at(item).chain(called).map(str::to_string).collect();
        for name in names {
            self.push(item.span.start, StepKind::Sets(name.into()));
        }
    }

    /// Calls of what no file has.
    fn name_calls(&mut self, item: &Item) {
        let at = self.at(item.span.start);
        for name in facts::called(self.f.p, item) {
            if words::motion(name).is_some() || words::is_frame(name) || words::moves(name) {
                continue;
            }
            match self.f.may_move(name) {
                true => self.named_calls.moving(&self.f.needs, name, at),
                false => self.named_calls.still(&self.f.needs, name, at.line),
            }
        }
    }

    /// `leave = "GOTO" name | "RETURN" ... | "EXIT" | "RAISE" ... | "RETRY" | "TRYNEXT"`
    fn leave(&mut self, token: usize, routine: usize) {
        let word = self.f.word(token);
        if matches!(word, "retry" | "trynext") && self.moved {
            let note = strikes(self.at(token), &format!("the error handler before {}", word.to_uppercase()));
            self.notes.entry((note.place.line, note.text.clone())).or_insert(note);
        }
        match word {
            "return" => self.steps.returns(),
            "retry" => self.calls_again(routine),
            // goes on after what failed, which may be a call
            "trynext" => self.steps.calls_are_unknown(),
            _ => {}
        }
        self.steps.ends_here();
        self.steps.jump(self.at(token));
    }

    /// An instruction that is no motion, or a call of a procedure.
    ///
    /// `call = "SyncMoveOn" ... | "SyncMoveOff" ... | wait | procedure ...`,
    /// `wait = "WaitTime" arguments | ...`
    fn call(&mut self, item: &Item) {
        let token = item.span.start;
        let name = self.f.word(token);
        match name {
            "syncmoveon" => self.synchronised = true,
            "syncmoveoff" => self.synchronised = false,
            "exitcycle" => return,
            _ => {}
        }
        if words::is_frame(name) {
            self.push(token, StepKind::Break(Break::Frame));
        } else if words::arms(name) {
            self.push(token, StepKind::Break(Break::Interrupt));
        } else if let Some(first) = facts::called(self.f.p, item).find(|name| self.f.may_move(name)) {
            // the procedure alone, and nothing in its arguments
            let alone = facts::called(self.f.p, item).filter(|name| self.f.may_move(name)).count() == 1;
            if alone && first == name {
                self.external = None;
                self.calls_here(item.routine, name);
                self.steps.calls(self.at(token), name.to_string());
            } else {
                self.steps.called_otherwise(name.to_string());
                self.push(token, StepKind::Break(Break::Call));
            }
        } else if words::is_wait(name) {
            let args = arguments(self.f.p, token + 1..item.span.end);
            let literal = positional(&args, 0).and_then(|k| self.number(&args[k].span, item));
            self.push(token, StepKind::Dwell(literal.filter(|s| name == "waittime" && *s >= 0.0)));
        } else if self.f.needs.is_declared(name) {
            self.push(token, StepKind::Dwell(None));
        }
    }

    /// An expression as an aggregate or number: written there, or declared and certain.
    ///
    /// `value = name | aggregate`
    pub fn node(&mut self, span: &Span, item: &Item) -> Option<Node> {
        let p = self.f.p;
        if span.len() == 1 && p.tokens[span.start].kind == Kind::Word {
            let d = self.f.resolve(self.f.word(span.start), Some(item.routine), item.module)?;
            self.f.certain(d).ok()?;
            return self.declared(d);
        }
        value::aggregate(self.f.text, &p.tokens, span.clone())
    }

    /// The value of work object or tool data; where the text declares it and its value is not certain, a note says why.
    pub fn known_data(&mut self, span: &Span, item: &Item) -> Option<Node> {
        let node = self.node(span, item);
        if node.is_none()
            && let Some(d) = self.f.resolve(self.f.word(span.start), Some(item.routine), item.module)
            && let Err(why) = self.f.certain(d)
        {
            self.note(self.f.p.decls[d].at, why.to_string());
        }
        node
    }

    pub fn declared(&mut self, d: usize) -> Option<Node> {
        let (p, text) = (self.f.p, self.f.text);
        let parse = || {
            let span = p.decls[d].value.clone()?;
            value::aggregate(text, &p.tokens, span.clone())
                .or_else(|| plain(text, p, &span).map(|(v, s, b)| Node::Number(v, s, b)))
        };
        self.nodes.entry(d).or_insert_with(parse).clone()
    }

    /// A name that the file does not declare.
    pub fn predefined(&self, span: &Span, item: &Item) -> Option<&str> {
        let name = self.f.word(span.start);
        let free = self.f.resolve(name, Some(item.routine), item.module).is_none();
        (span.len() == 1 && free && !name.is_empty()).then_some(name)
    }

    /// An expression as it is written, without blanks: `tools{2}`.
    pub fn written(&self, span: &Span) -> String {
        span.clone().map(|token| self.shown(token)).collect()
    }

    /// A token as it is written.
    pub fn shown(&self, token: usize) -> String {
        let t = self.f.p.tokens[token];
        String::from_utf8_lossy(self.f.text.slice(t.start()..t.end())).into_owned()
    }
}

/// The expression as a plain number, its style and bytes.
///
/// `plain = ["+" | "-"] digits`
fn plain(text: &Text, p: &Parsed, span: &Span) -> Option<(f64, number::Style, Range<usize>)> {
    let (a, b) = (p.tokens.get(span.start)?, p.tokens.get(span.end.checked_sub(1)?)?);
    if span.is_empty() {
        return None;
    }
    let bytes = a.start()..b.end();
    let (v, style) = number::read(text.slice(bytes.clone()))?;
    Some((v, style, bytes))
}
