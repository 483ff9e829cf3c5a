//! A program's text into its script; `triggered`: what a motion runs near its end.

mod triggered;

use super::calls;
use super::flow::{self, Flow};
use super::instruction;
use super::motion;
use super::positions;
use super::reason::Reason;
use super::registers::Known;
use super::sections::{line_count, sections, tracks};
use super::statement::{Statement, is_comment, statements, words};
use super::taught::{Taught, bare};
use super::uses::{Uses, mentioned};
use super::{Motion, Program};
use crate::axes::Axes;
use crate::error::{Error, Place, Result};
use crate::script::blocks::Steps;
use crate::script::called::{self, Called, NamedCalls};
use crate::script::lex::not_too_long;
use crate::script::{At, Break, Note, Script, StepKind, Text, pragma};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

pub(super) fn program(texts: Vec<Text>, robot: &Axes) -> Result<Program> {
    let Some(text) = texts.first() else {
        return Err(Error::bad(Place::default(), "no text", "a FANUC TP program (.LS)"));
    };
    not_too_long(text)?;
    let sections = sections(text)?;
    let positions = positions::read(text, sections.positions.clone())?;
    let (all, numbered) = statements(text, sections.program.clone())?;
    let all: Vec<(Statement, Parsed)> = all.into_iter().map(|s| (words(text, &s), s)).map(|(w, s)| (s, w)).collect();
    let count = line_count(text, sections.attributes.clone(), numbered.last().map(|n| n.number));
    let taught = Taught::of(text, robot, positions)?;
    let mut reader = Reader::new(text, robot, taught, Uses::of(text, &all));
    reader.registers = Known::of(&texts, &robot.registers, &robot.no_motion);
    reader.uncounted = count.is_none();
    reader.tracks = tracks(text, 0..sections.program.start);
    let beside = calls::beside(&texts, &robot.no_motion);
    reader.uses.sets.extend(&beside.sets);
    reader.still = beside.called;
    reader.reached_at_rest = flow::labels_reached_at_rest(text, &all, &reader.still);
    reader.push(At { file: 0, line: sections.program.start as u64 }, StepKind::Break(Break::Start));
    reader.led = flow::led(text, &all, &beside.effects);
    for (k, (statement, parsed)) in all.iter().enumerate() {
        reader.led_now = reader.led.get(k).copied().unwrap_or_default();
        reader.statement(statement, parsed);
    }
    reader.notes.extend(called::note(&reader.met, "program", ["the file beside it", "the files beside it"]));
    if let (Some(found), Some(last)) = (&count, numbered.last())
        && found.1 != last.number
    {
        reader.note(
            text.line_of(found.0.start),
            format!("the number of lines is given as {}, the last line is {}", found.1, last.number),
        );
    }
    let reads = reader.readings(&all);
    let read = flow::last_before(text, &all, &reads).into_iter().filter_map(|k| all.get(k));
    let read = read.map(|(statement, _)| statement.line as u64 + 1).collect();
    reader.notes.extend(reader.registers_note());
    let Reader { steps, taught, uses, notes, counted_calls, named_calls, .. } = reader;
    let Taught { positions, targets, of_target, .. } = taught;
    let bare = bare(&positions);
    let mentioned = mentioned(text, sections.program.clone());
    let last = positions.iter().map(|p| p.index).chain([mentioned]).max().unwrap_or(0);
    let shared = of_target.iter().map(|&p| positions.get(p).is_some_and(|p| uses.reads(p.index))).collect();
    let kinds = robot.axis_joints().map(|j| j.kind).collect();
    let end = sections.end;
    let mut script = Script { targets, notes, ..Script::default() };
    named_calls.report_to(&mut script);
    let motions = steps.finish(&mut script);
    script.keep_before_relative(&Reason::BeforeIncrement.into(), &counted_calls, true);
    script.keep_read(&Reason::EndIsRead.into(), &read);
    script.texts = texts;
    let robot = robot.clone();
    Ok(Program { script, kinds, robot, motions, numbered, count, positions, of_target, shared, last, end, bare })
}

pub(super) struct Reader<'a> {
    pub(super) text: &'a Text,
    pub(super) robot: &'a Axes,
    pub(super) taught: Taught,
    pub(super) uses: Uses,
    /// Extras of the last goal, where they are known.
    pub(super) before: Option<usize>,
    pub(super) steps: Steps<Motion>,
    pub(super) notes: Vec<Note>,
    /// Programs that it calls and that move nothing, and those of them that were met.
    pub(super) still: Called,
    pub(super) met: BTreeMap<String, u64>,
    pub(super) named_calls: NamedCalls,
    pub(super) own_name: Option<String>,
    /// Registers with the values of a listing, and those that were used, with the first line.
    pub(super) registers: Known<'a>,
    pub(super) used: BTreeMap<u64, u64>,
    /// User frame and tool that are selected, where that is certain.
    pub(super) selected: [Option<u64>; 2],
    /// Labels that are reached from nowhere but from where nothing has moved since.
    pub(super) reached_at_rest: BTreeSet<u64>,
    /// `before` at the start of each open block.
    pub(super) blocks: Vec<Option<usize>>,
    /// The program is one of line tracking: its positions move with a conveyor.
    pub(super) tracks: bool,
    /// Registers are added to goals.
    pub(super) offsets: bool,
    /// What leads the robot away from its positions: before each statement, and at this one.
    pub(super) led: Vec<u32>,
    pub(super) led_now: u32,
    /// Lines of calls of programs that may begin with an increment.
    pub(super) counted_calls: BTreeSet<u64>,
    /// No attribute gives the number of lines, which must grow with new ones.
    pub(super) uncounted: bool,
}

/// Statement and its words.
type Parsed = Vec<Range<usize>>;

impl<'a> Reader<'a> {
    fn new(text: &'a Text, robot: &'a Axes, taught: Taught, uses: Uses) -> Self {
        Self {
            text,
            robot,
            taught,
            uses,
            before: None,
            steps: Steps::of_text(text),
            notes: Vec::new(),
            still: Called::default(),
            met: BTreeMap::new(),
            named_calls: NamedCalls::default(),
            own_name: calls::name_in(text),
            registers: Known::default(),
            used: BTreeMap::new(),
            selected: [None, None],
            reached_at_rest: BTreeSet::new(),
            blocks: Vec::new(),
            tracks: false,
            offsets: instruction::has_offsets(text),
            led: Vec::new(),
            led_now: 0,
            counted_calls: BTreeSet::new(),
            uncounted: false,
        }
    }

    fn note(&mut self, line: u64, text: String) {
        self.notes.push(Note { place: At { file: 0, line }, text });
    }

    fn comment(&self, statement: &Statement) -> Option<Vec<u8>> {
        let content = statement.pieces.first().map(|p| self.text.slice(p.clone()))?;
        is_comment(content).then(|| {
            let content = content.trim_ascii_start();
            let language = content.starts_with(b"--").then(|| memchr::memchr(b':', content)).flatten();
            content[language.map_or(0, |c| c + 1)..].to_vec()
        })
    }

    pub(super) fn push(&mut self, at: At, kind: StepKind) {
        if matches!(kind, StepKind::Break(_)) {
            self.before = None;
        }
        self.steps.push(at, kind);
    }

    fn statement(&mut self, statement: &Statement, words: &Parsed) {
        let at = At::of_line(statement.line);
        if let Some(comment) = self.comment(statement) {
            if let Some(on) = pragma(&comment) {
                self.push(at, StepKind::Pragma(on));
            }
        } else if let (false, Some(said)) = (statement.nested, motion::read(self.text, statement, words)) {
            // `SKIP,LBL[1]` leaves the motion where a signal comes
            let labels = flow::named(self.text, words);
            labels.into_iter().for_each(|n| self.steps.jumps_on_the_way(n.map(|n| n.to_string())));
            let actions = said.actions.clone();
            self.motion(at, said);
            actions.iter().for_each(|action| self.triggered(at, action));
        } else {
            let label = matches!(flow::read(self.text, words), Flow::Label(_));
            let labels = if label { Vec::new() } else { flow::named(self.text, words) };
            labels.into_iter().for_each(|n| self.steps.jumps_to(n.map(|n| n.to_string())));
            self.selects(words, statement.nested);
            if statement.nested {
                if let Some(kind @ StepKind::Break(_)) = instruction::read(self.text, words) {
                    self.push(at, kind);
                }
            } else {
                self.flow(at, flow::read(self.text, words));
            }
            if let Some(register) = instruction::register_set(self.text, words).filter(|_| self.offsets) {
                self.push(at, StepKind::Sets(register.into()));
            }
        }
    }

    fn flow(&mut self, at: At, flow: Flow) {
        match flow {
            Flow::On => {}
            Flow::Label(Some(n)) if self.reached_at_rest.contains(&n) => {}
            Flow::Label(n) => {
                self.before = None;
                self.steps.label(at, n.map(|n| n.to_string()));
            }
            Flow::Jump(jump) if jump.always => self.steps.jump(at),
            Flow::Jump(_) => {}
            Flow::Open(kind) => {
                self.blocks.push(self.before.take());
                self.steps.open(at, kind);
            }
            Flow::Round => {
                self.blocks.push(self.before.take());
                self.steps.open_loop(at, true);
            }
            // there is no `ELSE IF`
            Flow::Middle => {
                self.before = None;
                self.steps.branch(at, true);
            }
            Flow::Close(kind) => {
                let (before, busy) = (self.blocks.pop().flatten(), self.steps.close(at, kind));
                self.before = before.filter(|_| !busy);
            }
            Flow::Call(name) => self.call(at, name, true),
            Flow::Macro(name) => match self.still.is_still_macro(&name) {
                true => {
                    self.named_calls.still(self.still.needs(), &name, at.line);
                    self.push(at, StepKind::Dwell(None));
                }
                false => {
                    self.named_calls.moving(self.still.needs(), &name, at);
                    self.push(at, StepKind::Break(Break::Call));
                }
            },
            Flow::Step(kind) => self.push(at, kind),
        }
    }

    /// Follows which user frame and tool are selected: nothing that jumps, calls or branches leaves that certain.
    ///
    /// `selection = ("UFRAME_NUM" | "UTOOL_NUM" | "BENUTZER_NUM" | "WKZ_NUM") "=" number`
    fn selects(&mut self, words: &Parsed, nested: bool) {
        let whole: Vec<u8> =
            words.iter().flat_map(|w| self.text.slice(w.clone())).map(u8::to_ascii_uppercase).collect();
        let quiet =
            matches!(flow::read(self.text, words), Flow::On | Flow::Step(StepKind::Dwell(_) | StepKind::Process(_)));
        if !quiet || nested {
            self.selected = [None, None];
            return;
        }
        for (k, names) in [[&b"UFRAME_NUM"[..], b"BENUTZER_NUM"], [b"UTOOL_NUM", b"WKZ_NUM"]].iter().enumerate() {
            for name in names.iter().filter(|name| memchr::memmem::find(&whole, name).is_some()) {
                let value = whole.strip_prefix(*name).and_then(|rest| rest.strip_prefix(b"="));
                self.selected[k] = value.and_then(|v| std::str::from_utf8(v).ok()?.parse().ok());
            }
        }
    }

    /// Says which registers must hold the values of the listing.
    fn registers_note(&self) -> Option<Note> {
        let line = self.used.values().min().copied()?;
        let names: Vec<String> = self.used.keys().map(|n| format!("PR[{n}]")).collect();
        let text = format!(
            "the values of {} are those of the listing: they must hold these values whenever the program runs",
            names.join(", ")
        );
        Some(Note { place: At { file: 0, line }, text })
    }

    /// A call of a program; `held`: the robot stands until it has ended.
    fn call(&mut self, at: At, name: String, held: bool) {
        if self.own_name.as_deref().is_some_and(|own| own.eq_ignore_ascii_case(&name)) {
            self.steps.runs_again();
        }
        match self.still.waits(&name) {
            Some(waits) => {
                self.named_calls.still(self.still.needs(), &name, at.line);
                if !self.still.needs().is_declared(&name) {
                    self.met.entry(name).or_insert(at.line);
                }
                if waits && held {
                    self.push(at, StepKind::Dwell(None));
                }
                // it may set any register
                if self.offsets {
                    self.push(at, StepKind::Sets("pr".into()));
                }
            }
            None => {
                self.named_calls.moving(self.still.needs(), &name, at);
                if self.still.counts(&name) {
                    self.counted_calls.insert(at.line);
                }
                self.push(at, StepKind::Break(Break::Call));
            }
        }
    }
}
