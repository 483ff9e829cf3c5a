//! Instructions to steps; moves are read by [`movement`](super::movement).

use super::circles::{self, Circles};
use super::facts::{Counted, FramesSet, assigned};
use super::flow::{self, Flow};
use super::job::{self, Job, Kind, Parts, Positions, Section, Statement};
use super::list::{List, shown};
use super::movement::Model;
use super::order::Order;
use super::reason::Reason;
use super::shared::{Shared, job_name};
use super::words::{FRAMES, JUMPS, LOOPS, OVERLAID, PROCESS, STANDS, STILL, sets_frame, upper, words};
use crate::axes::Axes;
use crate::error::{Error, Place, Result};
use crate::script::blocks::Steps;
use crate::script::called::{self, Called, NamedCalls};
use crate::script::lex::{not_too_long, upper_of};
use crate::script::{At, Break, Goal, Move, Script, Step, StepKind, Targets, Text, Value, number, pragma};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Reads a job.
pub(super) fn job(texts: Vec<Text>, robot: &Axes) -> Result<Job> {
    let Some(text) = texts.first() else {
        return Err(Error::bad(Place::file(""), "no text", "an INFORM job"));
    };
    not_too_long(text)?;
    let mut list = List { positions: Positions::of_text(text), ..List::default() };
    let begin = list.read(text)?;
    let mut reader = Reader::new(text, robot, &list, begin, &texts[1..]);
    reader.instructions(begin)?;
    let called = called::note(&reader.met, "job", ["the file beside it", "the files beside it"]);
    reader.script.notes.extend(called);
    reader.script.notes.extend(reader.counted.as_ref().map(Counted::note));
    std::mem::take(&mut reader.named_calls).report_to(&mut reader.script);
    let Reader { mut script, steps, parts, numbers, mut pinned, counted_calls, circles, jobs, .. } = reader;
    let statements = steps.finish(&mut script);
    circles::join(&mut script, &circles);
    // what a move before a relative one leads to stays, whoever else leads there
    let mut kept = script.keep_before_relative(&Reason::BeforeRelative.into(), &counted_calls, true);
    let read = flow::last_before(text, begin, &script.lines_of_moves(), &jobs);
    kept.extend(script.keep_read(&Reason::EndIsRead.into(), &read));
    for step in kept {
        let positions = statements.get(step).map(|s| parts.references(s)).unwrap_or_default();
        positions.iter().for_each(|r| pinned[r.position()] = true);
    }
    script.texts = texts;
    Ok(Job {
        script,
        positions: list.positions,
        counts: list.counts,
        statements,
        parts,
        numbers,
        pinned,
        pulses: robot.axis_joints().map(|j| j.pulses).collect(),
        unit: robot.axis_joints().map(|j| j.kind.si_per_user_unit()).collect(),
    })
}

pub(super) struct Reader<'a> {
    pub(super) text: &'a Text,
    pub(super) robot: &'a Axes,
    pub(super) list: &'a List,
    /// Headers in force where new positions of each kind go.
    pub(super) ends: BTreeMap<Kind, Section>,
    pub(super) assigned: BTreeSet<u32>,
    pub(super) shared: Shared,
    pub(super) frames_set: FramesSet,
    /// It was said that position variables are edited.
    pub(super) has_noted: bool,
    counted: Option<Counted>,
    /// Moves so far, as the controller counts the steps of a job.
    moves: u32,
    pub(super) script: Script,
    pub(super) steps: Steps<Statement>,
    pub(super) parts: Parts,
    /// `still` at the start of each open block.
    blocks: Vec<Option<Vec<f64>>>,
    /// Jobs beside it that move nothing, and those of them that it calls.
    jobs: Called,
    met: BTreeMap<String, u64>,
    named_calls: NamedCalls,
    own_name: Option<String>,
    /// Lines of labels, where a move may run on.
    pub(super) labels: BTreeMap<String, usize>,
    /// Labels that are reached from nowhere but from where nothing has moved since.
    reached_at_rest: BTreeSet<String>,
    /// Targets by the positions that make them.
    pub(super) targets: job::Known,
    pub(super) numbers: Vec<job::Numbers>,
    pub(super) pinned: Vec<bool>,
    /// Motions laid over the path, as bits, before each line.
    pub(super) overlaid: Vec<u32>,
    /// Steps of arcs through three positions.
    pub(super) circles: Circles,
    /// Lines of calls of jobs that may begin with a relative move.
    counted_calls: BTreeSet<u64>,
    pub(super) base_axes: bool,
    /// Which numbers are which axes'.
    pub(super) order: Order,
    /// The numbers of a position that has one for each axis are those of the axes, in their order.
    pub(super) in_order: bool,
    /// The move that was read last, where others may be like it.
    pub(super) model: Option<Model>,
    pub(super) room: Vec<Option<Value>>,
    /// Numbers beyond the robot's axes where the move before left them.
    pub(super) still: Option<Vec<f64>>,
    /// Where the move before left the other groups, as it names their positions (their numbers by bits); `None`: not known.
    pub(super) station: Option<Vec<(Kind, Vec<u64>)>>,
}

impl<'a> Reader<'a> {
    /// Before the instructions, which begin at line `begin`; `beside`: the other jobs.
    fn new(text: &'a Text, robot: &'a Axes, list: &'a List, begin: usize, beside: &[Text]) -> Self {
        let run = flow::run_by(text, beside);
        let overlaid = flow::overlaid_before(text, begin, &run);
        let jobs = flow::beside(text, beside, &robot.no_motion);
        let order = Order::of(robot);
        Self {
            text,
            robot,
            list,
            ends: job::ends(&list.positions),
            assigned: assigned(text, begin, list),
            shared: Shared::of(text, begin, beside),
            frames_set: FramesSet::of(text, begin, &run),
            has_noted: false,
            counted: Counted::of(text, begin),
            moves: 0,
            script: Script { targets: Targets::of_text(text), ..Script::default() },
            steps: Steps::of_text(text),
            parts: Parts::of_text(text),
            blocks: Vec::new(),
            met: BTreeMap::new(),
            named_calls: NamedCalls::default(),
            own_name: job_name(text),
            labels: flow::labels(text, begin),
            reached_at_rest: flow::labels_reached_at_rest(text, begin, &jobs),
            targets: job::Known::default(),
            numbers: Vec::new(),
            pinned: vec![false; list.positions.len()],
            circles: circles::of(text, begin, list, &jobs, &overlaid),
            jobs,
            overlaid,
            counted_calls: BTreeSet::new(),
            base_axes: list.base_axes,
            in_order: order.is_in_order(),
            order,
            model: None,
            room: Vec::new(),
            still: None,
            station: None,
        }
    }
}

impl Reader<'_> {
    pub(super) fn step(&mut self, k: usize, kind: StepKind, statement: Option<Statement>) {
        let known = match &kind {
            StepKind::Break(_) => false,
            StepKind::Move(m) => !matches!(m.goal, Goal::Opaque(_)),
            _ => true,
        };
        if !known {
            self.still = None;
        }
        if matches!(kind, StepKind::Break(_)) {
            self.station = None;
        }
        let step = self.steps.push(At::of_line(k), kind);
        if let Some(statement) = statement {
            self.steps.place(step, statement);
        }
    }

    /// Labels, jumps, blocks and calls; `false`: it is none of them.
    ///
    /// `flow = label | jump | call | block`, as [`flow::read`] reads them
    fn flow(&mut self, k: usize, words: &[Range<usize>]) -> bool {
        let at = At::of_line(k);
        let words: Vec<String> = words.iter().map(|w| upper(self.text, w)).collect();
        if flow::to_job(&words).is_some_and(|name| self.own_name.as_ref() == Some(&name)) {
            self.steps.runs_again();
        }
        match flow::read(&words) {
            Flow::Label(name) if self.reached_at_rest.contains(&name) => {}
            Flow::Label(name) => {
                (self.still, self.station) = (None, None);
                self.steps.label(at, Some(name));
            }
            Flow::Jump { label, always } => {
                if label.is_some() {
                    self.steps.jumps_to(label);
                }
                if always {
                    self.steps.jump(at);
                }
            }
            Flow::Open(kind) => {
                self.station = None;
                self.blocks.push(self.still.take());
                self.steps.open(at, kind);
            }
            Flow::Middle => {
                (self.still, self.station) = (None, None);
                self.steps.branch(at, words.first().is_some_and(|w| w == "ELSE" || w == "DEFAULT"));
            }
            Flow::Close(kind) => {
                self.station = None;
                let (before, busy) = (self.blocks.pop().flatten(), self.steps.close(at, kind));
                self.still = before.filter(|_| !busy);
            }
            Flow::Condition if !self.blocks.is_empty() => {}
            Flow::Call(name) => match self.jobs.waits(&name) {
                Some(waits) => {
                    self.named_calls.still(self.jobs.needs(), &name, at.line);
                    if !self.jobs.needs().is_declared(&name) {
                        self.met.entry(name).or_insert(at.line);
                    }
                    if waits {
                        self.step(k, StepKind::Dwell(None), None);
                    }
                }
                None => {
                    self.named_calls.moving(self.jobs.needs(), &name, at);
                    if self.jobs.counts(&name) {
                        self.counted_calls.insert(at.line);
                    }
                    self.step(k, StepKind::Break(Break::Call), None);
                }
            },
            Flow::Condition | Flow::Other => {
                if words.first().is_some_and(|w| w == "JUMP") {
                    // to a label that a variable names
                    self.steps.jumps_to(None);
                }
                return false;
            }
        }
        true
    }

    /// All instructions from line `begin`.
    ///
    /// `instructions = {blank | "'" comment | instruction} "END" {blank | "'" comment}`
    fn instructions(&mut self, begin: usize) -> Result<()> {
        self.step(begin.saturating_sub(1), StepKind::Break(Break::Start), None);
        let mut ended = false;
        for k in begin..self.text.line_count() {
            if !ended && self.again(k)? {
                continue;
            }
            let line = self.text.line(k).trim_ascii();
            if line.is_empty() || line == b"\x1a" {
                continue;
            }
            let at = self.text.line_span(k).start;
            if ended && !line.starts_with(b"'") {
                return Err(self.text.bad(at, shown(line), "nothing after `END`"));
            }
            if line.starts_with(b"'") {
                if let Some(on) = pragma(line) {
                    self.step(k, StepKind::Pragma(on), None);
                }
                continue;
            }
            if line.starts_with(b"/JOB") || line.starts_with(b"//") {
                return Err(self.text.bad(at, shown(line), "an instruction"));
            }
            ended = self.instruction(k)?;
        }
        if ended { Ok(()) } else { Err(self.text.bad(self.text.bytes.len(), "the end of the file", "`END`")) }
    }

    /// One instruction; `true`: it is `END`.
    ///
    /// `instruction = move | "+" ... | flow | process | overlay | "TIMER" ... | stand | jump | loop | frame | still | "END" | call`
    fn instruction(&mut self, k: usize) -> Result<bool> {
        let words = words(self.text, k);
        let Some(first) = words.first() else { return Ok(false) };
        let text = self.text;
        let word = upper_of(text.slice(first.clone()));
        let is = |list: &[&str]| list.contains(&&*word);
        let foreign = word.starts_with('+');
        if !foreign && !word.starts_with('*') && word.contains("MOV") {
            self.movement(k, &words, &word)?;
            return Ok(false);
        }
        // positions that others than moves of the first group use stay as they are
        let at = if foreign { 0 } else { 1 };
        for w in words.get(at..).unwrap_or_default() {
            self.pin(w);
        }
        if self.flow(k, &words) {
            return Ok(false);
        }
        let kind = if foreign {
            self.close_last(Reason::SecondGroup);
            None
        } else if let Some(&(_, on)) = PROCESS.iter().find(|p| p.0 == word) {
            Some(StepKind::Process(on))
        } else if OVERLAID.iter().any(|p| p.0 == word || p.1 == word) {
            Some(StepKind::Break(Break::Frame))
        } else if word == "TIMER" {
            Some(StepKind::Dwell(self.seconds(&words)))
        } else if is(STANDS) {
            Some(StepKind::Dwell(None))
        } else if word.starts_with('*') || is(JUMPS) {
            Some(StepKind::Break(Break::Jump))
        } else if is(LOOPS) {
            Some(StepKind::Break(Break::Loop))
        } else if is(FRAMES) || !sets_frame(self.text, k).is_empty() {
            Some(StepKind::Break(Break::Frame))
        } else if word == "END" || is(STILL) {
            None
        } else {
            // CALL, MACRO, PSTART, and whatever is not known
            Some(self.unknown(k, &words, &word))
        };
        if let Some(kind) = kind {
            self.step(k, kind, None);
        }
        Ok(word == "END")
    }

    /// An instruction that is not known: a macro moves nothing where the user says so.
    fn unknown(&mut self, k: usize, words: &[Range<usize>], word: &str) -> StepKind {
        let all: Vec<String> = words.iter().map(|w| upper(self.text, w)).collect();
        let may_be = flow::is_macro(self.text, k, &all);
        if may_be && self.jobs.is_still_macro(word) {
            self.named_calls.still(self.jobs.needs(), word, At::of_line(k).line);
            return StepKind::Dwell(None);
        }
        if may_be {
            self.named_calls.moving(self.jobs.needs(), word, At::of_line(k));
        }
        StepKind::Break(Break::Call)
    }

    /// What is laid over the path on line `k`.
    pub(super) fn overlaid(&self, k: usize) -> Vec<&'static str> {
        let bits = self.overlaid.get(k).copied().unwrap_or_default();
        OVERLAID.iter().enumerate().filter(|(n, _)| bits & 1 << n != 0).map(|(_, p)| p.0).collect()
    }

    /// A position that is named by something else than a move of the first group stays as it is.
    ///
    /// `position = ["+"] kind digit {digit}`
    pub(super) fn pin(&mut self, word: &Range<usize>) {
        let name = self.text.slice(word.clone());
        let name = name.strip_prefix(b"+").unwrap_or(name);
        if let Some(p) = Kind::read(name).and_then(|(kind, n, _)| self.list.by_name.get((kind, n))) {
            self.pinned[p] = true;
        }
    }

    /// The next move of a job that names its moves by number: a new one before it would shift the numbers.
    pub(super) fn counted(&mut self, m: &mut Move) {
        self.moves += 1;
        let Some(counted) = &self.counted else { return };
        m.closed.get_or_insert_with(|| Reason::StepsCounted.into());
        if counted.any || counted.steps.contains(&self.moves) {
            m.fixed.get_or_insert_with(|| Reason::StepRead.into());
        }
    }

    fn close_last(&mut self, why: Reason) {
        if let Some(Step { kind: StepKind::Move(m), .. }) = self.steps.last_mut()
            && m.closed.is_none()
        {
            m.closed = Some(why.into());
        }
    }

    /// `TIMER T=0.50`.
    ///
    /// `timer = "TIMER" "T=" number`
    fn seconds(&self, words: &[Range<usize>]) -> Option<f64> {
        let value = words.get(1).map(|w| upper(self.text, w))?;
        number::read(value.strip_prefix("T=")?.as_bytes()).map(|n| n.0).filter(|s| *s >= 0.0)
    }
}
