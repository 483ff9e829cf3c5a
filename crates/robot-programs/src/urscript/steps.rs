//! The steps of a URScript: moves with their targets, and what ends a joint's known direction.

mod alike;

use super::arguments::{arguments, call, goal_name};
use super::evaluate::Values;
use super::in_force::InForce;
use super::read::{Item, ItemKind, Parsed, Span};
use super::reason::Reason;
use super::value;
use super::words;
use crate::axes::Axes;
use crate::error::{Result, one_line};
use crate::script::blocks::{BySteps, Steps, is_entered};
use crate::script::called::{NamedCalls, Needs, strikes};
use crate::script::pose::Frame;
use crate::script::sites::Time;
use crate::script::without_joint::WithoutJoint;
use crate::script::{self, At, Break, Note, Script, Span as Bytes, StepKind, Targets, Text};
use std::collections::{BTreeSet, HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

/// A target as it can be written: bytes of its list, and where it is assigned.
#[derive(Debug, Clone)]
pub struct Literal {
    pub bytes: Bytes,
    /// SI per unit of each number: 1, or rad per degree inside `d2r()`.
    pub units: Arc<[f64]>,
    pub owner: Option<Box<Owner>>,
    /// Of an expression that is no list of numbers: the list that takes its place in the move.
    pub folded: Option<Box<Folded>>,
}

/// A list of numbers that is computed.
#[derive(Debug, Clone)]
pub struct Folded {
    /// It is a pose.
    pub pose: bool,
    /// All its numbers, m and rad.
    pub numbers: Vec<f64>,
    /// Which of them each value of the target is.
    pub places: Vec<usize>,
}

/// Assignment of a list to a name.
#[derive(Debug, Clone)]
pub struct Owner {
    /// From `global` or the name to the end of the list.
    pub bytes: Range<usize>,
    /// `global `, `local ` or nothing.
    pub qualifier: String,
    pub name: String,
    /// Its value is read elsewhere: it must stay.
    pub keep: bool,
}

/// Where a move stands.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Site {
    /// Function name to closing bracket.
    pub bytes: Bytes,
    /// The target's expression.
    pub goal: Bytes,
    /// Name or list of the target within it: that of the pose in `get_inverse_kin(p1)`.
    pub point: Bytes,
    /// `t=`: bytes of the number, s, style.
    pub time: Option<Box<Time>>,
    /// Expression of `r=`.
    pub blend: Option<Bytes>,
    /// Of an arc that may be split: the expression of the point on its way.
    pub via: Option<Bytes>,
}

#[derive(Default)]
pub struct Built {
    pub script: Script,
    pub sites: BySteps<Site>,
    /// One per target of the script.
    pub literals: Vec<Literal>,
}

/// Reads the items of a file as steps. `None`: lines without tokens are more than the numbers in which they differ from the statement
/// before them, so that all have to be read.
pub fn build(text: Text, mut p: Parsed, robot: &Axes) -> Result<Option<(Built, super::lex::Words)>> {
    let goals: Vec<Option<usize>> = p.items.iter().map(|item| goal_name(&p, item)).collect();
    p.settle(&goals);
    let mut b = Builder::new(&text, &p, robot);
    b.in_force = b.find_in_force();
    let mut passed = p.passed.iter().peekable();
    for (place, item) in p.items.iter().enumerate() {
        b.place = place;
        b.item(item)?;
        if let Some(lines) = passed.next_if(|lines| lines.token == item.span.end + 1)
            && b.again(item, lines).is_none()
        {
            return Ok(None);
        }
        if b.read.contains(&place) {
            b.steps.fix_last_move(script::Reason::EndIsRead);
        }
        if b.acted_on.contains(&place) {
            b.steps.act_in_corner(&Reason::ActsInBlend.into());
        }
    }
    if passed.next().is_some() {
        return Ok(None);
    }
    b.steps.pragmas(&text, &p.comments, usize::MAX);
    let Builder { steps, targets, literals, notes, named_calls, without_joint, .. } = b;
    let mut out = Built { literals, ..Built::default() };
    out.sites = steps.finish(&mut out.script);
    if let Some(without) = without_joint {
        without.close(&mut out.script.steps);
    }
    out.script.targets = targets;
    out.script.notes = notes;
    named_calls.report_to(&mut out.script);
    out.script.texts = vec![text];
    Ok(Some((out, p.words)))
}

pub struct Builder<'a> {
    pub text: &'a Text,
    pub p: &'a Parsed,
    pub robot: &'a Axes,
    moving: HashMap<String, bool>,
    needs: Needs,
    named_calls: NamedCalls,
    /// The TCPs that the file sets.
    pub tcps: Vec<Frame>,
    /// Which of them may be in force, and what leads the robot; `None`: it sets none, and nothing does.
    pub in_force: Option<InForce>,
    /// Items whose moves may come last before the program reads where the robot stands.
    pub read: BTreeSet<usize>,
    /// Items whose moves may come last before the program switches, reads or waits for something.
    pub acted_on: BTreeSet<usize>,
    /// The item at hand.
    pub place: usize,
    pub steps: Steps<Site>,
    pub targets: Targets,
    pub literals: Vec<Literal>,
    /// Numbers of each joint target for which the robot file has no joint.
    pub without_joint: Option<WithoutJoint>,
    notes: Vec<Note>,
    /// Values that are computed from constants.
    pub values: Values<'a>,
    /// Targets of variables.
    pub known: HashMap<(Option<usize>, String), usize>,
    /// Function by which something else may move the robot beside its targets.
    pub led: Option<&'static str>,
    /// The function with which the program starts; `None`: none.
    pub entry_def: Option<usize>,
    /// Threads may run, or end, anything at any time.
    runs_threads: bool,
    /// The function of the item at hand.
    pub def: Option<usize>,
    /// The step at which the last function started or ended.
    last_start: Option<usize>,
    /// Name or list of the pose of the move at hand.
    pub inner: Option<Span>,
}

/// A word by which threads run or end.
fn is_of_threads(word: &str) -> bool {
    matches!(word, "run" | "kill" | "join")
}

/// What runs first: what stands outside of functions, where that moves; the function that it calls first; else the first
/// function with a move or a call of one that no other calls. `None`: what stands outside.
fn entry_def(p: &Parsed, moving: &HashMap<String, bool>) -> Option<usize> {
    let outside = || p.items.iter().filter(|item| item.def.is_none() && item.kind != ItemKind::Start);
    if outside().any(|item| call(p, item).is_some()) {
        return None;
    }
    let named = |name: &str| p.defs.iter().position(|(n, parent)| parent.is_none() && n == name);
    if let Some(first) = outside().flat_map(|item| p.called(item)).find_map(named) {
        return Some(first);
    }
    let called: HashSet<&str> =
        p.items.iter().filter(|item| item.def.is_some()).flat_map(|item| p.called(item)).collect();
    let thread = |k: usize| {
        let head = p.items.iter().find(|item| item.kind == ItemKind::Start && item.def == Some(k));
        head.is_some_and(|item| p.words.at(item.span.start) == "thread")
    };
    let acts = |name: &str| moving.get(name).copied().unwrap_or(true);
    let may = |(k, (name, parent)): (usize, &(String, Option<usize>))| {
        parent.is_none() && !called.contains(name.as_str()) && !thread(k) && acts(name)
    };
    p.defs.iter().enumerate().find(|d| may(*d)).map(|d| d.0)
}

impl<'a> Builder<'a> {
    fn new(text: &'a Text, p: &'a Parsed, robot: &'a Axes) -> Self {
        let needs = p.needs(&robot.no_motion);
        let moving = p.moving(&needs);
        let entry = entry_def(p, &moving);
        Self {
            text,
            p,
            robot,
            tcps: Vec::new(),
            in_force: None,
            read: BTreeSet::new(),
            acted_on: BTreeSet::new(),
            place: 0,
            steps: Steps::of_text(text),
            targets: Targets::of_text(text),
            literals: Vec::with_capacity(text.likely_steps()),
            without_joint: WithoutJoint::of(robot),
            notes: Vec::new(),
            values: Values::of(text, p, entry),
            known: HashMap::new(),
            led: None,
            entry_def: entry,
            runs_threads: p.words.different().any(is_of_threads),
            moving,
            needs,
            named_calls: NamedCalls::default(),
            def: None,
            last_start: None,
            inner: None,
        }
    }

    pub fn line(&self, token: usize) -> u64 {
        self.text.line_of(self.p.tokens.get(token).map_or(self.text.bytes.len(), |t| t.start()))
    }

    /// Bytes of tokens.
    pub fn bytes(&self, span: &Span) -> Range<usize> {
        self.p.tokens[span.start].start()..self.p.tokens[span.end - 1].end()
    }

    fn at(&self, token: usize) -> At {
        At { file: 0, line: self.line(token) }
    }

    pub fn push(&mut self, token: usize, kind: StepKind) -> usize {
        match kind {
            StepKind::Break(Break::Start) => self.last_start = Some(self.steps.next()),
            StepKind::Move(_) | StepKind::Break(Break::Call | Break::Jump | Break::Loop) => self.acts(),
            _ => {}
        }
        self.steps.push(self.at(token), kind)
    }

    fn close(&mut self, token: usize, kind: Break) {
        if self.steps.close(self.at(token), kind) {
            self.acts();
        }
    }

    /// The program starts before the first thing that its first function does.
    fn acts(&mut self) {
        if self.def == self.entry_def {
            self.steps.entry = self.steps.entry.or(self.last_start);
        }
    }

    pub fn may_move(&self, name: &str) -> bool {
        let declared = || !words::moves(name) && self.needs.is_declared(name);
        self.moving.get(name).copied().unwrap_or_else(|| !(words::is_quiet(name) || declared()))
    }

    /// What an item of the script does.
    ///
    /// `item = call | ("run" | "kill" | "join") ... | "set_tcp" ... | assignment | other`
    fn item(&mut self, item: &Item) -> Result<()> {
        let token = item.span.start;
        if let Some(t) = self.p.tokens.get(token) {
            self.steps.pragmas(self.text, &self.p.comments, t.start());
        }
        self.def = item.def;
        self.led = self.in_force.as_ref().and_then(|f| f.led(self.def, self.place));
        if let Some((motion, args, span)) = call(self.p, item) {
            return self.motion(item, &motion, &args, span);
        }
        let runs = item.kind != ItemKind::Start && self.p.words.within(item.span.clone()).any(is_of_threads);
        if runs {
            self.push(token, StepKind::Break(Break::Interrupt));
            let moving = |name: &&str| self.moving.get(*name) == Some(&true);
            let thread = self.p.words.within(item.span.clone()).find(moving).map(str::to_string);
            self.notes.extend(thread.map(|name| strikes(self.at(token), &name)));
        }
        let name = self.p.words.at(token);
        if name == "set_tcp" {
            self.push(token, StepKind::Break(Break::Frame));
        } else {
            self.calls(item);
        }
        self.kind(item, name);
        Ok(())
    }

    /// What the kind of an item that is no motion does to the flow; `name`: its first word.
    ///
    /// `item = "def" name | "while" condition | "sleep" "(" seconds ")" | "continue" | "break" | "return" | other`
    fn kind(&mut self, item: &Item, name: &str) {
        let token = item.span.start;
        match item.kind {
            ItemKind::Start => {
                self.steps.start();
                let own = item.def.and_then(|d| self.p.defs.get(d)).map(|d| d.0.clone()).unwrap_or_default();
                self.steps.routine(item.def.map_or(0, |d| d + 1), own);
                if name == "def" {
                    self.steps.all_calls_are_here(!self.runs_threads && item.def != self.entry_def);
                }
                self.push(token, StepKind::Break(Break::Start));
            }
            ItemKind::Branch => self.steps.open(self.at(token), Break::Jump),
            ItemKind::Loop => {
                let tokens = self.p.tokens.get(item.span.clone()).unwrap_or_default();
                let bytes = tokens.first().map_or(0, |t| t.start())..tokens.last().map_or(0, |t| t.end());
                self.steps.open_loop(self.at(token), is_entered(&[b"while ", self.text.slice(bytes)].concat()));
            }
            ItemKind::Middle => self.steps.branch(self.at(token), item.span.is_empty()),
            ItemKind::EndBranch => self.close(token, Break::Jump),
            ItemKind::EndLoop => self.close(token, Break::Loop),
            ItemKind::Assign { .. } => {}
            ItemKind::Other if words::is_wait(name) => {
                let args = arguments(self.p, token + 2, item.span.end).map(|a| a.0).unwrap_or_default();
                let seconds = args.first().and_then(|a| self.number(&a.span, item));
                self.push(token, StepKind::Dwell(seconds.filter(|s| name == "sleep" && *s >= 0.0)));
            }
            ItemKind::Other if name == "continue" => self.steps.skips(),
            ItemKind::Other if name == "break" => self.steps.leaves(),
            ItemKind::Other if name == "return" => {
                self.steps.returns();
                self.steps.ends_here();
            }
            ItemKind::Other => {}
        }
    }

    /// A break where the item calls what may move.
    fn calls(&mut self, item: &Item) {
        let token = item.span.start;
        let moving: Vec<&str> = self.p.called(item).filter(|name| self.may_move(name)).collect();
        self.name_calls(item);
        match moving.as_slice() {
            [] if self.needs.is_declared(self.p.words.at(token)) => drop(self.push(token, StepKind::Dwell(None))),
            [] => {}
            // a statement that is nothing but the call
            [name] if item.kind == ItemKind::Other && *name == self.p.words.at(token) => {
                self.acts();
                self.steps.calls(self.at(token), (*name).to_string());
            }
            _ => {
                moving.iter().for_each(|name| self.steps.called_otherwise((*name).to_string()));
                self.push(token, StepKind::Break(Break::Call));
            }
        }
    }

    /// Calls of what the file does not have.
    pub fn name_calls(&mut self, item: &Item) {
        let at = self.at(item.span.start);
        for name in self.p.called(item).filter(|name| !words::moves(name)) {
            match self.may_move(name) {
                true => self.named_calls.moving(&self.needs, name, at),
                false => self.named_calls.still(&self.needs, name, at.line),
            }
        }
    }

    /// A number: written there, or a variable that is assigned it once.
    pub fn number(&self, span: &Span, item: &Item) -> Option<f64> {
        let found = value::plain(self.text, &self.p.tokens, span).map(|(v, ..)| v);
        found.or_else(|| {
            let (value, _) = self.assigned(span, item).ok()?;
            value::plain(self.text, &self.p.tokens, &value).map(|(v, ..)| v)
        })
    }

    /// What the name in `span` is assigned, if that is certain: tokens of the value, and the item.
    pub fn assigned(&self, span: &Span, item: &Item) -> std::result::Result<(Span, usize), script::Reason> {
        let name = self.p.words.at(span.start);
        if span.len() != 1 || name.is_empty() {
            let shown = one_line(&String::from_utf8_lossy(self.text.slice(self.bytes(span))));
            return Err(script::Reason::Expression(shown.into()));
        }
        let Some(key) = self.p.key(item.def, name) else {
            let parameter = self.p.is_parameter(item.def, name);
            let why = if parameter { Reason::Parameter(name.into()) } else { Reason::NotInFile(name.into()) };
            return Err(why.into());
        };
        let variable = &self.p.variables[&key];
        if let Some(why) = &variable.changed {
            return Err(why.clone().into());
        }
        match variable.assigned.first().map(|&n| (&self.p.items[n], n)) {
            // a parameter has another value until then
            Some((Item { span, .. }, _))
                if self.p.is_parameter(key.0, name) && self.p.words.at(span.start) != "local" =>
            {
                Err(Reason::Parameter(name.into()).into())
            }
            Some((Item { kind: ItemKind::Assign { value, .. }, span, .. }, n)) => Ok((*value..span.end, n)),
            _ => Err(Reason::NotInFile(name.into()).into()),
        }
    }
}
