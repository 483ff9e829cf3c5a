//! A program's text into its script.

mod triggered;

use super::calls;
use super::flow::{self, Flow};
use super::instruction;
use super::motion::{self, MotionInstruction};
use super::positions::{self, Position};
use super::reason::Reason;
use super::registers::Known;
use super::sections::{line_count, sections, tracks};
use super::statement::{Statement, is_comment, statements, words};
use super::taught::{Taught, bare};
use super::uses::{Uses, mentioned};
use super::{Motion, Program};
use crate::axes::Axes;
use crate::error::{Error, Place, Result};
use crate::registers::Register;
use crate::script::blocks::Steps;
use crate::script::called::{self, Called, NamedCalls};
use crate::script::lex::not_too_long;
use crate::script::pose::{Configuration, Shift, Solution};
use crate::script::{
    self, At, Break, Few, Frame, Goal, How, Move, Note, OtherWay, PathKind, PoseGoal, Script, StepKind, Text, pragma,
};
use nalgebra::{Translation3, UnitQuaternion, Vector3};
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
    reader.quiet = flow::quiet_labels(text, &all, &reader.still);
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

/// What makes another frame or tool of one while the program runs.
const SET: &str = "as the program sets it";

struct Reader<'a> {
    text: &'a Text,
    robot: &'a Axes,
    taught: Taught,
    uses: Uses,
    /// Extras of the last goal, where they are known.
    before: Option<usize>,
    steps: Steps<Motion>,
    notes: Vec<Note>,
    /// Programs that it calls and that move nothing, and those of them that were met.
    still: Called,
    met: BTreeMap<String, u64>,
    named_calls: NamedCalls,
    /// Registers with the values of a listing, and those that were used, with the first line.
    registers: Known<'a>,
    used: BTreeMap<u64, u64>,
    /// User frame and tool that are selected, where that is certain.
    selected: [Option<u64>; 2],
    /// Labels that are reached from nowhere but from where nothing has moved since.
    quiet: BTreeSet<u64>,
    /// `before` at the start of each open block.
    blocks: Vec<Option<usize>>,
    /// The program is one of line tracking: its positions move with a conveyor.
    tracks: bool,
    /// Registers are added to goals.
    offsets: bool,
    /// What leads the robot away from its positions: before each statement, and at this one.
    led: Vec<u32>,
    led_now: u32,
    /// Lines of calls of programs that may begin with an increment.
    counted_calls: BTreeSet<u64>,
    /// No attribute gives the number of lines, which must grow with new ones.
    uncounted: bool,
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
            registers: Known::default(),
            used: BTreeMap::new(),
            selected: [None, None],
            quiet: BTreeSet::new(),
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

    fn push(&mut self, at: At, kind: StepKind) {
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
            Flow::Label(Some(n)) if self.quiet.contains(&n) => {}
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

    /// Where a motion to a register leads, whose value a listing tells.
    fn registered(&mut self, n: u64, line: u64) -> Goal {
        // a register holds values of the other groups, too
        let alone = self.taught.positions.iter().all(|p| p.others.is_empty());
        let places = self.robot.places();
        // the six values of a register are those of the axes in their order
        if !(alone && places.certain && places.external.is_empty() && places.numbers.iter().copied().eq(1..=6)) {
            return Goal::opaque(Reason::Register);
        }
        let goal = match self.registers.value(n) {
            Err(why) => return Goal::opaque(why),
            Ok(Register::Joints(deg)) => Goal::Joints(self.taught.stands(n, line, *deg)),
            Ok(Register::Pose(values, configuration)) => {
                let [Some(frame), Some(tool)] = self.selected else {
                    return Goal::opaque(Reason::RegisterFrame(n));
                };
                let sets = self.uses.sets.has_frame(Some(frame)) || self.uses.sets.has_tool(Some(tool));
                let [frame, tool] = [positions::named(Some(frame), "user frame"), positions::named(Some(tool), "tool")];
                if sets {
                    return Goal::opaque(Reason::RegisterFrameSet(n));
                }
                Goal::pose(listed_pose(values, *configuration, frame, tool))
            }
        };
        self.used.entry(n).or_insert(line);
        goal
    }

    /// The displacement by a register whose value a listing tells: along the axes of the tool, or of the user frame.
    fn displacement(&mut self, said: &MotionInstruction, line: u64) -> Option<Shift> {
        let (of_tool, _) = said.offset.as_ref()?;
        let n = said.offset_by?;
        let Ok(Register::Pose(v, _)) = self.registers.value(n) else { return None };
        // what a rotation turns about depends on the controller's settings
        if v[3..].iter().any(|angle| *angle != 0.0) {
            return None;
        }
        self.used.entry(n).or_insert(line);
        let by = Vector3::new(v[0], v[1], v[2]) * 1e-3;
        Some(if *of_tool { Shift::of_pose(Translation3::from(by).into()) } else { Shift::in_frame(by) })
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

    /// The tool of a position.
    fn tool(&self, position: &Position) -> Frame {
        let tool = positions::named(position.tool, "tool");
        if self.uses.sets.has_tool(position.tool) { tool.made("0", SET) } else { tool }
    }

    /// The Cartesian target of a position.
    fn pose(&self, position: usize) -> Option<PoseGoal> {
        let mut pose = self.taught.pose(position, self.robot)?;
        let own = self.taught.positions.get(position)?;
        if self.uses.sets.has_frame(own.frame) {
            pose.frame = pose.frame.made("0", SET);
        }
        pose.tool = self.tool(own);
        Some(pose)
    }

    /// The point on the way of an arc, in the frame of its goal, m.
    fn via(&self, index: u64, goal: usize) -> Option<Vector3<f64>> {
        let p = self.taught.by_index.get(&index).copied().filter(|_| self.uses.written(index).is_none())?;
        let positions = &self.taught.positions;
        let same = positions[p].frame == positions[goal].frame && self.uses.written_any.is_none();
        self.pose(p).filter(|_| same).map(|pose| pose.position_m)
    }

    /// Where `P[n]` leads; `position`: its place in /POS; `offset`: a register that moves it.
    fn goal(&mut self, n: u64, position: Option<usize>, said: &MotionInstruction, line: u64) -> Goal {
        let offset = &said.offset;
        let Some(p) = position else { return Goal::opaque(Reason::NotInPos(n)) };
        if let Some(line) = self.uses.written(n).or(self.uses.written_any) {
            return Goal::opaque(Reason::Written { position: n, line });
        }
        match self.taught.joints[p].clone() {
            Ok(_) if offset.is_some() => Goal::opaque(Reason::Offset),
            Ok(t) => Goal::Joints(t),
            Err(why) => match (self.pose(p), self.displacement(said, line)) {
                (None, _) => Goal::Opaque(why),
                (Some(pose), Some(shift)) => Goal::pose(pose.shifted(shift)),
                (Some(pose), None) => Goal::pose(displaced(pose, offset)),
            },
        }
    }

    /// Whether all axes and groups but the robot's stand still on the way to a position.
    fn others_stand(&self, position: Option<usize>) -> bool {
        match (self.before, position) {
            _ if self.taught.idle => true,
            (Some(a), Some(b)) => self.taught.extras[a] == self.taught.extras[b],
            _ => false,
        }
    }

    /// Why no point may come before a motion, whatever its words are.
    fn closed(&self, position: Option<usize>, goal: &Goal, motion: Option<&Motion>) -> Option<script::Reason> {
        let still = self.others_stand(position);
        let further = matches!(goal, Goal::Pose(_)) && !self.robot.places().certain;
        let uncounted = self.uncounted && motion.is_some_and(|m| m.number.is_some());
        let own = match () {
            () if !still => Reason::OthersMove,
            () if further => Reason::UnclearAxes,
            () if motion.is_none() => return Some(script::Reason::NoCopy),
            () if uncounted => Reason::NoLineCount,
            () => return None,
        };
        Some(own.into())
    }

    /// A motion to a position selects its frame and tool, or the controller stops, or it does not check: where others were selected, none
    /// is known.
    fn select_by(&mut self, position: Option<usize>, elsewhere: bool) {
        if let Some(own) = position.and_then(|p| self.taught.positions.get(p)) {
            let own = [own.frame, own.tool];
            for (selected, own) in self.selected.iter_mut().zip(own) {
                *selected = if selected.is_none_or(|s| Some(s) == own) { own } else { None };
            }
        }
        if elsewhere {
            self.selected = [None, None];
        }
    }

    fn motion(&mut self, at: At, said: MotionInstruction) {
        let position = said.goal.as_ref().ok().and_then(|n| self.taught.by_index.get(n).copied());
        let register = said.register.filter(|_| said.offset.is_none() && !self.tracks && self.led_now == 0);
        let register = register.filter(|_| !(said.relative || said.coordinated || said.path == PathKind::Curve));
        let goal = match said.goal.clone() {
            Err(why) if said.is_register(&why) && register.is_some() => {
                register.map_or(Goal::Opaque(why), |n| self.registered(n, at.line))
            }
            Err(why) => Goal::Opaque(why),
            Ok(_) if self.tracks || self.led_now != 0 => {
                let by = instruction::led_by(self.led_now).unwrap_or("a conveyor that the program tracks");
                Goal::opaque(Reason::Led(by))
            }
            Ok(_) if said.coordinated && !self.taught.leader_stands() => Goal::opaque(Reason::LeaderMoves),
            Ok(n) => self.goal(n, position, &said, at.line),
        };
        let goal = match (goal, &said.via[..], position) {
            (Goal::Pose(pose), [via], Some(p)) if said.path == PathKind::Curve => {
                Goal::pose(PoseGoal { via_m: self.via(*via, p), ..*pose })
            }
            (goal, ..) => goal,
        };
        let closed = said.closed.or_else(|| self.closed(position, &goal, said.motion.as_ref()));
        let fixed = register.filter(|_| position.is_none() && !matches!(goal, Goal::Opaque(_)));
        let fixed = fixed.map(|n| Reason::Listed(n).into());
        let closed = closed.or_else(|| fixed.as_ref().map(|_| Reason::ToRegister.into()));
        // a position that is no part of the program does not tell
        let carried = matches!(goal, Goal::Pose(_)) && position.is_some() && !self.others_stand(position);
        let other_way = said.wrist.then_some(OtherWay::Wrist).or_else(|| carried.then_some(OtherWay::Carried));
        self.before = position;
        self.select_by(position, said.process.is_some() || said.skips || said.calls);
        if let Some(motion) = said.motion {
            self.steps.place(self.steps.next(), motion);
        }
        let straight = said.path == PathKind::Linear && matches!(goal, Goal::Joints(_));
        let tool = position.filter(|_| straight).map(|p| Box::new(self.tool(&self.taught.positions[p])));
        let selected = || Box::new(positions::named(self.selected[1], "tool"));
        let tool = tool.or_else(|| (straight && position.is_none()).then(selected));
        let how = How {
            path: said.path,
            closed,
            speed: said.speed,
            blend_m: said.blend_m,
            tool,
            relative: said.relative,
            fixed,
            other_way,
            end_trigger: said.end_trigger.map(Box::new),
            ..How::default()
        };
        self.push(at, StepKind::Move(Move::new(how, goal, Few::new())));
        if let Some(on) = said.process {
            self.push(at, StepKind::Process(on));
        }
        if said.skips {
            self.push(at, StepKind::Break(Break::Jump));
        }
    }
}

/// The pose of a register.
fn listed_pose(values: &[f64; 6], configuration: Configuration, frame: Frame, tool: Frame) -> PoseGoal {
    let [w, p, r] = [values[3], values[4], values[5]].map(f64::to_radians);
    PoseGoal {
        position_m: Vector3::new(values[0], values[1], values[2]) * 1e-3,
        rotation: Some(UnitQuaternion::from_euler_angles(w, p, r)),
        frame,
        tool,
        solution: Solution::Configured(configuration),
        binding: true,
        ..PoseGoal::default()
    }
}

/// A pose that is moved by a position register: in its own frame, or for its own tool.
fn displaced(mut pose: PoseGoal, offset: &Option<(bool, String)>) -> PoseGoal {
    if let Some((of_tool, text)) = offset {
        let place = if *of_tool { &mut pose.tool } else { &mut pose.frame };
        *place = std::mem::take(place).made("0", &format!("with {text}"));
    }
    pose
}
