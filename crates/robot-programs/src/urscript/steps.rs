//! The steps of a URScript: moves with their targets, and what ends a joint's known direction.

use super::arguments::{Arg, argument, arguments, call, goal, goal_name};
use super::read::{Item, ItemKind, Parsed, Span};
use super::value;
use super::words::{self, Motion, MotionKind};
use crate::axes::Axes;
use crate::error::{Result, one_line};
use crate::script::blocks::{BySteps, Steps};
use crate::script::pose::Frame;
use crate::script::sites::Time;
use crate::script::{
    At, Break, Few, Goal, How, Move, PathKind, PoseGoal, Script, Span as Bytes, Speed, StepKind, Targets, Text, number,
};
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

/// Shortest time between two set points that controllers of every generation keep, s (8 ms cycle of the CB series).
pub const CYCLE_S: f64 = 0.008;

/// A target as it can be written: bytes of its list, and where it is assigned.
#[derive(Debug, Clone)]
pub struct Literal {
    pub bytes: Bytes,
    /// SI per unit of each number: 1, or rad per degree inside `d2r()`.
    pub units: Arc<[f64]>,
    pub owner: Option<Box<Owner>>,
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
#[derive(Debug, Clone, Default)]
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

pub fn build(text: Text, mut p: Parsed, robot: &Axes) -> Result<(Built, super::lex::Words)> {
    let goals: Vec<Option<usize>> = p.items.iter().map(|item| goal_name(&p, item)).collect();
    p.settle(&goals);
    let moving = p.moving();
    let mut b = Builder {
        text: &text,
        p: &p,
        robot,
        tools: None,
        tools_def: None,
        steps: Steps::of_text(&text),
        targets: Targets::of_text(&text),
        literals: Vec::with_capacity(text.likely_steps()),
        known: HashMap::new(),
        led: None,
        led_before: Vec::new(),
        led_by: led_by(&p),
        entry_def: entry_def(&p, &moving),
        moving,
        def: None,
        last_start: None,
        inner: None,
    };
    b.tools = b.find_tools();
    let first = b.tools.as_ref().map(|t| t.0);
    b.tools_def = first.and_then(|first| p.items.iter().find(|item| item.span.contains(&first))).and_then(|i| i.def);
    for item in &p.items {
        b.item(item)?;
    }
    b.steps.pragmas(&text, &p.comments, usize::MAX);
    let Builder { steps, targets, literals, .. } = b;
    let mut out = Built { literals, ..Built::default() };
    out.sites = steps.finish(&mut out.script);
    out.script.targets = targets;
    out.script.texts = vec![text];
    Ok((out, p.words))
}

pub struct Builder<'a> {
    pub text: &'a Text,
    pub p: &'a Parsed,
    pub robot: &'a Axes,
    moving: HashMap<String, bool>,
    pub tools: Option<(usize, Vec<Frame>)>,
    /// The function in which the first of them is set.
    pub tools_def: Option<usize>,
    steps: Steps<Site>,
    pub targets: Targets,
    pub literals: Vec<Literal>,
    /// Targets of variables.
    pub known: HashMap<(Option<usize>, String), usize>,
    /// Function that was called last in the text and by which something else moves the robot beside its targets.
    led: Option<&'static str>,
    /// The same before each open block, or at the end of one of its branches: a block may be passed by.
    led_before: Vec<Option<&'static str>>,
    /// What the functions of the file leave behind of that.
    led_by: HashMap<String, Option<&'static str>>,
    /// The function with which the program starts; `None`: none.
    entry_def: Option<usize>,
    /// The function of the item at hand.
    pub def: Option<usize>,
    /// The step at which the last function started or ended.
    last_start: Option<usize>,
    /// Name or list of the pose of the move at hand.
    pub inner: Option<Span>,
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

/// Functions that begin or end to lead the robot away from its targets, also by calling others, and which of both.
fn led_by(p: &Parsed) -> HashMap<String, Option<&'static str>> {
    let mut found: HashMap<String, Option<&'static str>> = HashMap::new();
    // as often as there are functions, a call may lead on to another
    for _ in 0..=p.defs.len() {
        let before = found.clone();
        for item in &p.items {
            let Some((name, _)) = item.def.and_then(|d| p.defs.get(d)) else { continue };
            for called in p.called(item).filter(|c| *c != name.as_str()) {
                if let Some(led) = words::leads(called).or_else(|| found.get(called).copied()) {
                    found.insert(name.clone(), led);
                }
            }
        }
        if found == before {
            break;
        }
    }
    found
}

impl Builder<'_> {
    pub fn line(&self, token: usize) -> u64 {
        self.text.line_of(self.p.tokens.get(token).map_or(self.text.bytes.len(), |t| t.start()))
    }

    fn at(&self, token: usize) -> At {
        At { file: 0, line: self.line(token) }
    }

    fn push(&mut self, token: usize, kind: StepKind) -> usize {
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

    fn may_move(&self, name: &str) -> bool {
        self.moving.get(name).copied().unwrap_or_else(|| !words::is_quiet(name))
    }

    fn item(&mut self, item: &Item) -> Result<()> {
        let token = item.span.start;
        if let Some(t) = self.p.tokens.get(token) {
            self.steps.pragmas(self.text, &self.p.comments, t.start());
        }
        self.def = item.def;
        if let Some((motion, args, span)) = call(self.p, item) {
            return self.motion(item, motion, &args, span);
        }
        let runs = item.kind != ItemKind::Start
            && self.p.words.within(item.span.clone()).any(|w| matches!(w, "run" | "kill" | "join"));
        if runs {
            self.push(token, StepKind::Break(Break::Interrupt));
        }
        let name = self.p.words.at(token);
        let led = self.led;
        for called in self.p.called(item) {
            self.led = words::leads(called).or_else(|| self.led_by.get(called).copied()).unwrap_or(self.led);
        }
        if name == "set_tcp" {
            self.push(token, StepKind::Break(Break::Frame));
        } else if self.p.called(item).any(|name| self.may_move(name)) {
            self.push(token, StepKind::Break(Break::Call));
        }
        match item.kind {
            ItemKind::Start => self.led_before.clear(),
            ItemKind::Branch | ItemKind::Loop => self.led_before.push(led),
            ItemKind::Middle => {
                if let Some(before) = self.led_before.last_mut() {
                    *before = before.or(self.led);
                }
            }
            ItemKind::EndBranch | ItemKind::EndLoop => self.led = self.led.or(self.led_before.pop().flatten()),
            _ => {}
        }
        match item.kind {
            ItemKind::Start => {
                self.steps.start();
                self.push(token, StepKind::Break(Break::Start));
            }
            ItemKind::Branch | ItemKind::Loop => {
                let kind = if item.kind == ItemKind::Loop { Break::Loop } else { Break::Jump };
                self.steps.open(self.at(token), kind);
            }
            ItemKind::Middle => self.steps.middle(self.at(token), Break::Jump),
            ItemKind::EndBranch => self.close(token, Break::Jump),
            ItemKind::EndLoop => self.close(token, Break::Loop),
            ItemKind::Assign { .. } => {}
            ItemKind::Other if words::is_wait(name) => {
                let args = arguments(self.p, token + 2, item.span.end).map(|a| a.0).unwrap_or_default();
                let seconds = args.first().and_then(|a| self.number(&a.span, item));
                self.push(token, StepKind::Dwell(seconds.filter(|s| name == "sleep" && *s >= 0.0)));
            }
            ItemKind::Other => {}
        }
        Ok(())
    }

    /// A number: written there, or a variable that is assigned it once.
    fn number(&self, span: &Span, item: &Item) -> Option<f64> {
        let found = value::plain(self.text, &self.p.tokens, span).map(|(v, ..)| v);
        found.or_else(|| {
            let (value, _) = self.assigned(span, item).ok()?;
            value::plain(self.text, &self.p.tokens, &value).map(|(v, ..)| v)
        })
    }

    /// What the name in `span` is assigned, if that is certain: tokens of the value, and the item.
    pub fn assigned(&self, span: &Span, item: &Item) -> std::result::Result<(Span, usize), String> {
        let name = self.p.words.at(span.start);
        if span.len() != 1 || name.is_empty() {
            let bytes = self.p.tokens[span.start].start()..self.p.tokens[span.end - 1].end();
            let shown = one_line(&String::from_utf8_lossy(self.text.slice(bytes)));
            return Err(format!("the target `{shown}` is an expression"));
        }
        let Some(key) = self.p.key(item.def, name) else {
            let what = if self.p.is_parameter(item.def, name) {
                "a parameter of the function"
            } else {
                "not assigned in this file"
            };
            return Err(format!("`{name}` is {what}"));
        };
        let variable = &self.p.variables[&key];
        if let Some(why) = &variable.changed {
            return Err(why.clone());
        }
        match variable.assigned.first().map(|&n| (&self.p.items[n], n)) {
            Some((Item { kind: ItemKind::Assign { value, .. }, span, .. }, n)) => Ok((*value..span.end, n)),
            _ => Err(format!("`{name}` is not assigned in this file")),
        }
    }

    /// Whether an arc interpolates the orientation from its start to its end (`mode=0`, the default): the other mode turns it with
    /// the tangent, whatever its end says.
    fn interpolates(&self, motion: &Motion, args: &[Arg]) -> bool {
        let mode = |a: &Arg| value::plain(self.text, &self.p.tokens, &a.span).map(|m| m.0);
        motion.parameters.contains(&"mode") && argument(motion, args, "mode").is_none_or(|a| mode(a) == Some(0.0))
    }

    fn motion(&mut self, item: &Item, motion: Motion, args: &[Arg], span: Span) -> Result<()> {
        let (p, text) = (self.p, self.text);
        let token = span.start;
        let calls = p.called(item).any(|name| words::motion(name).is_none() && self.may_move(name));
        if calls {
            self.push(token, StepKind::Break(Break::Call));
        }
        let bytes = p.tokens[span.start].start()..p.tokens[span.end - 1].end();
        let Some(target) = goal(&motion, args).or(args.first()) else {
            return Err(text.bad(
                bytes.start,
                format!("`{}` without a target", p.words.at(token)),
                "a list of joint values or a pose",
            ));
        };
        let target = target.span.clone();
        let goal_bytes = p.tokens[target.start].start()..p.tokens[target.end - 1].end();
        let mut site =
            Site { bytes: bytes.into(), point: goal_bytes.clone().into(), goal: goal_bytes.into(), ..Site::default() };
        let line = text.line_span(self.line(token) as usize - 1);
        let alone =
            text.slice(line.start..site.bytes.start()).iter().all(u8::is_ascii_whitespace) && span.end == item.span.end;
        let via = argument(&motion, args, "pose_via").map(|a| a.span.clone());
        let splittable = via.is_some() && self.interpolates(&motion, args);
        let mut closed = match motion.kind {
            MotionKind::Arc if !splittable => Some("it is an arc or a process move"),
            MotionKind::Velocity => Some("it commands a velocity"),
            _ if calls => Some("its arguments call a function that may move the robot"),
            _ if !alone => Some("it shares its line with other code"),
            _ => None,
        };
        let t = argument(&motion, args, "t").map(|a| value::plain(text, &p.tokens, &a.span));
        let seconds = duration(t, motion.kind, &mut site, &mut closed);
        let v = argument(&motion, args, "v").map_or(motion.v, |a| self.number(&a.span, item));
        let speed = match (seconds, v, motion.kind) {
            (Some(s), ..) => Speed::Seconds(s),
            (None, Some(v), MotionKind::Optimised) => Speed::Share(v),
            (None, Some(v), MotionKind::Move) if motion.path == PathKind::Joint => Speed::Joint(v),
            (None, Some(v), MotionKind::Move | MotionKind::Arc) => Speed::Tcp(v),
            _ => Speed::Unknown,
        };
        let blend = argument(&motion, args, "r");
        let blend_m = match (&blend, motion.parameters.contains(&"r")) {
            (Some(a), _) => self.number(&a.span, item),
            (None, takes) => takes.then_some(0.0),
        };
        site.blend = blend.map(|a| (p.tokens[a.span.start].start()..p.tokens[a.span.end - 1].end()).into());
        self.inner = None;
        let goal = match motion.kind {
            _ if self.led.is_some() => {
                let by = self.led.unwrap_or_default();
                Goal::Opaque(format!("{by}() leads the robot away from the target"))
            }
            MotionKind::Velocity => Goal::Opaque("a velocity ends where its time ends".into()),
            MotionKind::Arc => self.pose_or_opaque(&target, item),
            _ => self.goal(&target, item)?,
        };
        if let Some(inner) = self.inner.take() {
            site.point = (p.tokens[inner.start].start()..p.tokens[inner.end - 1].end()).into();
        }
        let goal = match (goal, &via) {
            (Goal::Pose(pose), Some(via)) => Goal::pose(PoseGoal { via_m: self.via(via, item), ..*pose }),
            (goal, _) => goal,
        };
        if motion.kind == MotionKind::Arc {
            let known = matches!(&goal, Goal::Pose(pose) if pose.via_m.is_some() && pose.target.is_some());
            site.via = via.filter(|_| known).map(|v| (p.tokens[v.start].start()..p.tokens[v.end - 1].end()).into());
            if !known {
                closed.get_or_insert("it is an arc whose points are not all numbers");
            }
        }
        let closed = closed.map(String::from);
        let straight = motion.path == PathKind::Linear && matches!(goal, Goal::Joints(_));
        let tool = straight.then(|| self.tcp(token));
        let how = How { path: motion.path, fixed: None, closed, speed, blend_m, tool, turns_known: false };
        let k = self.push(token, StepKind::Move(Move::new(how, goal, Few::new())));
        self.steps.place(k, site);
        Ok(())
    }
}

/// The time of a motion, s, where it is written; closes the motion where a time cannot be shared out.
fn duration(
    t: Option<Option<(f64, number::Style, Range<usize>)>>,
    kind: MotionKind,
    site: &mut Site,
    closed: &mut Option<&'static str>,
) -> Option<f64> {
    match t {
        Some(Some((s, style, bytes))) if s > 0.0 => {
            if s < 2.0 * CYCLE_S {
                closed.get_or_insert("its time is too short to be shared out over two cycles of the controller");
            }
            site.time = Some(Box::new((bytes, s, style)));
            return Some(s);
        }
        Some(Some((s, ..))) if s == 0.0 && kind == MotionKind::Move => {}
        None if kind != MotionKind::Servo => {}
        Some(_) => drop(closed.get_or_insert("its time is no plain number, and cannot be shared out")),
        None => drop(closed.get_or_insert("it has no time t= that could be shared out")),
    }
    None
}
