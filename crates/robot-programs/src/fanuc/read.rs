//! A program's text into its script.

use super::calls::Still;
use super::flow::{self, Flow};
use super::instruction;
use super::motion::{self, MotionInstruction};
use super::positions::{self, Field, Position, is_extended, is_joint};
use super::statement::{Statement, index, is_comment, statements, words};
use super::{Motion, Program};
use crate::axes::{Axes, JointKind};
use crate::error::{Error, Place, Result};
use crate::script::blocks::Steps;
use crate::script::lex::not_too_long;
use crate::script::{
    At, Break, Few, Frame, Goal, How, Move, Note, PathKind, PoseForm, PoseGoal, Script, StepKind, Target, Targets,
    Text, Value, number, pragma,
};
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ops::Range;

/// The finest weight of a digit in a position: the controller writes three decimals, deg or mm. A number that stands there
/// with more keeps them.
pub(super) const FINEST: f64 = 1e-3;

/// Lines of the sections that matter.
pub(super) struct Sections {
    attributes: Range<usize>,
    pub program: Range<usize>,
    positions: Range<usize>,
    /// First byte after the positions.
    end: usize,
}

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
    let mut reader = Reader::new(text, robot, positions)?;
    reader.uncounted = count.is_none();
    reader.tracks = tracks(text, 0..sections.program.start);
    reader.collect(&all);
    reader.still = Still::of(&texts);
    reader.quiet = flow::quiet_labels(text, &all, &reader.still);
    reader.push(At { file: 0, line: sections.program.start as u64 }, StepKind::Break(Break::Start));
    for (statement, parsed) in &all {
        reader.statement(statement, parsed);
    }
    reader.note_calls();
    if let (Some(found), Some(last)) = (&count, numbered.last())
        && found.1 != last.number
    {
        reader.note(
            text.line_of(found.0.start),
            format!("the number of lines is given as {}, the last line is {}", found.1, last.number),
        );
    }
    let bare = bare(&reader.positions);
    let mentioned = mentioned(text, sections.program.clone());
    let last = reader.positions.iter().map(|p| p.index).chain([mentioned]).max().unwrap_or(0);
    let Reader { steps, targets, of_target, shared, notes, positions, .. } = reader;
    let kinds = robot.axis_joints().map(|j| j.kind).collect();
    let end = sections.end;
    let mut script = Script { targets, notes, ..Script::default() };
    let motions = steps.finish(&mut script);
    script.texts = texts;
    Ok(Program { script, kinds, motions, numbered, count, positions, of_target, shared, last, end, bare })
}

pub(super) fn sections(text: &Text) -> Result<Sections> {
    let mut found: Vec<(String, usize)> = Vec::new();
    for k in 0..text.line_count() {
        let line = text.line(k).strip_prefix(b"\xef\xbb\xbf").unwrap_or(text.line(k)).trim_ascii_start();
        if let [b'/', rest @ ..] = line
            && rest.first().is_some_and(u8::is_ascii_alphabetic)
        {
            let name = rest.iter().take_while(|b| b.is_ascii_alphanumeric()).map(|b| b.to_ascii_uppercase() as char);
            let name: String = name.collect();
            // some controllers write /APPL twice; nothing in it matters here
            if name != "APPL" && found.iter().any(|(n, _)| *n == name) {
                return Err(text.bad(text.line_span(k).start, format!("a second /{name}"), "each section once"));
            }
            let last = name == "END";
            found.push((name, k));
            if last {
                break;
            }
        }
    }
    let missing = |name: &str| {
        text.bad(text.bytes.len(), format!("no /{name}"), "the sections /PROG, /ATTR, /MN, /POS and /END in this order")
    };
    if found.first().is_none_or(|(n, _)| n != "PROG") {
        return Err(text.bad(0, "no /PROG at the start", "a FANUC TP program (.LS): /PROG, /ATTR, /MN, /POS, /END"));
    }
    let of = |name: &str| {
        let i = found.iter().position(|(n, _)| n == name)?;
        Some(found[i].1 + 1..found.get(i + 1).map_or(text.line_count(), |f| f.1))
    };
    let end = of("END").ok_or_else(|| missing("END"))?.start - 1;
    let program = of("MN").ok_or_else(|| missing("MN"))?;
    let positions = of("POS").unwrap_or(end..end);
    if positions.start < program.start {
        return Err(text.bad(text.line_span(positions.start).start, "/POS before /MN", "/MN before /POS"));
    }
    Ok(Sections {
        attributes: of("ATTR").unwrap_or(0..0),
        program,
        end: text.line_span(positions.end).start,
        positions,
    })
}

/// The attribute that counts the lines: by its name, else the only one with the last line's number.
fn line_count(text: &Text, lines: Range<usize>, last: Option<u64>) -> Option<(Range<usize>, u64)> {
    let mut same = Vec::new();
    for k in lines {
        let bytes = text.line(k);
        let Some(sign) = memchr::memchr(b'=', bytes) else { continue };
        let value = &bytes[sign + 1..];
        let digits = value.trim_ascii();
        let digits = digits.strip_suffix(b";").unwrap_or(digits).trim_ascii_end();
        let Some(number) = std::str::from_utf8(digits).ok().and_then(|d| d.parse::<u32>().ok()) else { continue };
        let start = text.line_span(k).start + sign + 1 + (value.len() - value.trim_ascii_start().len());
        let found = (start..start + digits.len(), u64::from(number));
        let name = bytes[..sign].trim_ascii().to_ascii_uppercase();
        if name == b"LINE_COUNT" || name.starts_with(b"ZEILEN") {
            return Some(found);
        }
        if Some(found.1) == last {
            same.push(found);
        }
    }
    if same.len() == 1 { same.pop() } else { None }
}

/// Whether the header (`/APPL`) gives a schedule of line tracking: `LINE_TRACK_SCHEDULE_NUMBER : 1;`; 0 is none.
fn tracks(text: &Text, lines: Range<usize>) -> bool {
    lines.map(|k| text.line(k).trim_ascii().to_ascii_uppercase()).any(|line| {
        let value = line.strip_prefix(b"LINE_TRACK_SCHEDULE_NUMBER").map(|v| v.trim_ascii_start());
        let value = value.and_then(|v| v.strip_prefix(b":").or(v.strip_prefix(b"="))).map(<[u8]>::trim_ascii);
        let value = value.map(|v| v.strip_suffix(b";").unwrap_or(v).trim_ascii_end());
        value.is_some_and(|v| v.is_empty() || v.iter().any(|b| *b != b'0'))
    })
}

/// Whether the file leaves the zero before the point off, as older controllers do.
fn bare(positions: &[Position]) -> bool {
    let values = || positions.iter().flat_map(|p| &p.fields).filter_map(|f| f.value);
    values().any(|v| v.1.bare) || !values().any(|v| v.0.abs() < 1.0)
}

/// The largest index in brackets after `P` on these lines; a new position must not answer to any of them.
fn mentioned(text: &Text, lines: Range<usize>) -> u64 {
    let bytes = text.slice(text.line_span(lines.start).start..text.line_span(lines.end).start);
    let digits = |at: usize| {
        let rest = bytes.get(at + 1..).unwrap_or_default().trim_ascii_start();
        let len = rest.iter().take_while(|b| b.is_ascii_digit()).count();
        std::str::from_utf8(&rest[..len]).ok()?.parse::<u32>().ok()
    };
    let named = memchr::memchr_iter(b'[', bytes).filter(|at| *at > 0 && bytes[at - 1].eq_ignore_ascii_case(&b'P'));
    named.filter_map(digits).max().map_or(0, u64::from)
}

/// What makes another frame or tool of one: told while the program runs.
const SET: &str = "as the program sets it";

/// How far after `P[` its `]` is looked for: a comment has 16 characters.
const NEAR: usize = 64;

struct Reader<'a> {
    text: &'a Text,
    dof: usize,
    positions: Vec<Position>,
    /// Position by its index.
    by_index: HashMap<u64, usize>,
    /// Target of each position; why there is none.
    target_of: Vec<std::result::Result<usize, String>>,
    /// Numbers of the user frames and tools that the program sets; `None`: any.
    frames_set: [Vec<Option<u64>>; 2],
    /// Target of each Cartesian position.
    pose_target: Vec<Option<usize>>,
    /// What each position says of axes that are not the robot's, and whether all say the same.
    extras: Vec<Vec<u8>>,
    idle: bool,
    /// Extras of the last goal, where they are known.
    before: Option<usize>,
    targets: Targets,
    of_target: Vec<usize>,
    shared: Vec<bool>,
    written: HashMap<u64, u64>,
    written_any: Option<u64>,
    steps: Steps<Motion>,
    notes: Vec<Note>,
    /// Programs that it calls and that move nothing, and those of them that were met.
    still: Still,
    met: BTreeMap<String, u64>,
    /// Labels that are reached from nowhere but from where nothing has moved since.
    quiet: BTreeSet<u64>,
    /// `before` at the start of each open block.
    blocks: Vec<Option<usize>>,
    /// The program is one of line tracking: its positions move with a conveyor.
    tracks: bool,
    /// What leads the robot away from its positions.
    led: Option<&'static str>,
    /// No attribute gives the number of lines, which must grow with new ones.
    uncounted: bool,
}

/// Statement and its words.
type Parsed = Vec<Range<usize>>;

impl<'a> Reader<'a> {
    fn new(text: &'a Text, robot: &Axes, positions: Vec<Position>) -> Result<Self> {
        let mut by_index = HashMap::new();
        let (mut targets, mut of_target, mut target_of, mut extras) =
            (Targets::of_text(text), Vec::new(), Vec::new(), Vec::new());
        let mut pose_target = Vec::with_capacity(positions.len());
        for (i, p) in positions.iter().enumerate() {
            if by_index.insert(p.index, i).is_some() {
                return Err(text.bad(p.head.start, format!("a second P[{}]", p.index), "each position once"));
            }
            target_of.push(if !p.ours {
                Err(format!("P[{}] has no group 1", p.index))
            } else if p.untaught() {
                Err(format!("P[{}] is not taught", p.index))
            } else if p.is_joints() {
                targets.push(target(text, robot, p)?);
                of_target.push(i);
                Ok(targets.len() - 1)
            } else if let Some(target) = coordinates(p) {
                targets.push(target);
                of_target.push(i);
                Err("a Cartesian position".into())
            } else {
                Err(format!("P[{}] holds neither joints nor a pose", p.index))
            });
            pose_target.push((!p.is_joints() && of_target.last() == Some(&i)).then(|| targets.len() - 1));
            let mut other = p.others.clone();
            let own = if p.is_joints() { robot.dof() } else { 0 };
            for f in p.axes().into_iter().skip(own) {
                other.extend_from_slice(text.slice(f.field).trim_ascii());
                other.push(b' ');
            }
            extras.push(other);
        }
        let idle = extras.windows(2).all(|w| w[0] == w[1]);
        let shared = vec![false; targets.len()];
        Ok(Self {
            text,
            dof: robot.dof(),
            positions,
            by_index,
            target_of,
            frames_set: Default::default(),
            pose_target,
            extras,
            idle,
            before: None,
            targets,
            of_target,
            shared,
            written: HashMap::new(),
            written_any: None,
            steps: Steps::of_text(text),
            notes: Vec::new(),
            still: Still::default(),
            met: BTreeMap::new(),
            quiet: BTreeSet::new(),
            blocks: Vec::new(),
            tracks: false,
            led: None,
            uncounted: false,
        })
    }

    fn note(&mut self, line: u64, text: String) {
        self.notes.push(Note { place: At { file: 0, line }, text });
    }

    /// Positions that the program writes or reads besides moving to them.
    fn collect(&mut self, all: &[(Statement, Parsed)]) {
        let mut read: BTreeSet<u64> = BTreeSet::new();
        let mut read_any = false;
        for (statement, words) in all {
            if self.comment(statement).is_some() {
                continue;
            }
            if let Some(said) = motion::read(self.text, statement, words) {
                read.extend(said.via);
                read_any |= said.any;
                continue;
            }
            // `UFRAME[1]=PR[2]`: what positions in that frame mean is known only while the program runs
            let first = words.first().map(|w| self.text.slice(w.clone()).to_ascii_uppercase()).unwrap_or_default();
            // by the group and the number: `$MNUFRAME[1,2]=PR[3]`
            for (list, name) in self.frames_set.iter_mut().zip([&b"$MNUFRAME["[..], b"$MNUTOOL["]) {
                if let Some(inside) = first.strip_prefix(name) {
                    let inside = inside.split(|b| *b == b']').next().unwrap_or_default();
                    let number = inside.split(|b| *b == b',').nth(1).and_then(|n| std::str::from_utf8(n).ok());
                    list.push(number.and_then(|n| n.trim().parse().ok()));
                }
            }
            for (list, name) in self.frames_set.iter_mut().zip([&b"UFRAME["[..], b"UTOOL["]) {
                if let Some(inside) = first.strip_prefix(name) {
                    let digits = inside.iter().take_while(|b| b.is_ascii_digit()).count();
                    let number = std::str::from_utf8(&inside[..digits]).ok().and_then(|d| d.parse().ok());
                    list.push(number.filter(|_| matches!(inside.get(digits), Some(b']' | b':'))));
                }
            }
            for (k, word) in words.iter().enumerate() {
                let bytes = self.text.slice(word.clone());
                for at in memchr::memmem::find_iter(&bytes.to_ascii_uppercase(), b"P[") {
                    if at > 0 && (bytes[at - 1].is_ascii_alphanumeric() || b"_$".contains(&bytes[at - 1])) {
                        continue;
                    }
                    let close =
                        memchr::memchr(b']', &bytes[at..bytes.len().min(at + NEAR)]).map_or(at + 2, |n| at + n + 1);
                    let found = index(self.text, word.start + at..word.start + close).map(|i| i.1);
                    let next = bytes.get(close).or_else(|| words.get(k + 1).and_then(|w| self.text.bytes.get(w.start)));
                    let line = self.text.line_of(word.start);
                    let writes = k == 0 && at == 0 && next == Some(&b'=');
                    match (found, writes) {
                        (Some(n), true) => drop(self.written.insert(n, line)),
                        (None, true) => self.written_any = Some(line),
                        (Some(n), false) => drop(read.insert(n)),
                        (None, false) => read_any = true,
                    }
                }
            }
        }
        for (t, &p) in self.of_target.iter().enumerate() {
            self.shared[t] = read_any || self.positions.get(p).is_some_and(|p| read.contains(&p.index));
        }
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
        let at = At { file: 0, line: statement.line as u64 + 1 };
        if let Some(comment) = self.comment(statement) {
            if let Some(on) = pragma(&comment) {
                self.push(at, StepKind::Pragma(on));
            }
        } else if let (false, Some(said)) = (statement.nested, motion::read(self.text, statement, words)) {
            self.motion(at, said);
        } else {
            self.led = instruction::leads(self.text, words).unwrap_or(self.led);
            if statement.nested {
                if let Some(kind @ StepKind::Break(_)) = instruction::read(self.text, words) {
                    self.push(at, kind);
                }
            } else {
                self.flow(at, flow::read(self.text, words));
            }
        }
    }

    fn flow(&mut self, at: At, flow: Flow) {
        match flow {
            Flow::On => {}
            Flow::Label(Some(n)) if self.quiet.contains(&n) => {}
            Flow::Label(_) => self.push(at, StepKind::Break(Break::Jump)),
            // what follows is reached by a label
            Flow::Jump(jump) if jump.always => self.steps.middle(at, Break::Jump),
            Flow::Jump(_) => {}
            Flow::Open(kind) => {
                self.blocks.push(self.before.take());
                self.steps.open(at, kind);
            }
            Flow::Middle => {
                self.before = None;
                self.steps.middle(at, Break::Jump);
            }
            Flow::Close(kind) => {
                let (before, busy) = (self.blocks.pop().flatten(), self.steps.close(at, kind));
                self.before = before.filter(|_| !busy);
            }
            Flow::Call(name) => match self.still.waits(&name) {
                Some(waits) => {
                    self.met.entry(name).or_insert(at.line);
                    if waits {
                        self.push(at, StepKind::Dwell(None));
                    }
                }
                None => self.push(at, StepKind::Break(Break::Call)),
            },
            Flow::Step(kind) => self.push(at, kind),
        }
    }

    /// Says which calls end nothing that is known of the joints.
    fn note_calls(&mut self) {
        let Some(line) = self.met.values().min().copied() else { return };
        let names: Vec<&str> = self.met.keys().map(String::as_str).collect();
        let text = match names.as_slice() {
            [one] => format!("the program {one} that it calls moves nothing, by the file beside it"),
            all => format!("the programs {} that it calls move nothing, by the files beside it", all.join(", ")),
        };
        self.note(line, text);
    }

    /// Whether the program sets the user frame or tool of a number.
    fn sets(list: &[Option<u64>], number: Option<u64>) -> bool {
        list.iter().any(|s| s.is_none() || *s == number)
    }

    /// The tool of a position.
    fn tool(&self, position: &Position) -> Frame {
        let tool = positions::named(position.tool, "tool");
        if Self::sets(&self.frames_set[1], position.tool) { tool.made("0", SET) } else { tool }
    }

    /// The Cartesian target of a position.
    fn pose(&self, position: usize) -> Option<PoseGoal> {
        let target = self.pose_target.get(position).copied().flatten()?;
        let own = self.positions.get(position)?;
        let mut pose = own.pose(target)?;
        if Self::sets(&self.frames_set[0], own.frame) {
            pose.frame = pose.frame.made("0", SET);
        }
        pose.tool = self.tool(own);
        Some(pose)
    }

    /// The point on the way of an arc, in the frame of its goal, m.
    fn via(&self, index: u64, goal: usize) -> Option<Vector3<f64>> {
        let p = self.by_index.get(&index).copied().filter(|_| !self.written.contains_key(&index))?;
        let same = self.positions[p].frame == self.positions[goal].frame && self.written_any.is_none();
        self.pose(p).filter(|_| same).map(|pose| pose.position_m)
    }

    /// Where `P[n]` leads; `position`: its place in /POS; `offset`: a register that moves it.
    fn goal(&mut self, n: u64, position: Option<usize>, offset: &Option<(bool, String)>) -> Goal {
        let Some(p) = position else { return Goal::Opaque(format!("P[{n}] is not in /POS")) };
        if let Some(line) = self.written.get(&n).copied().or(self.written_any) {
            return Goal::Opaque(format!("the program writes P[{n}] (line {line})"));
        }
        match self.target_of[p].clone() {
            Ok(_) if offset.is_some() => Goal::Opaque("an offset is added to the goal".into()),
            Ok(t) => Goal::Joints(t),
            Err(why) => self.pose(p).map_or(Goal::Opaque(why), |pose| Goal::pose(displaced(pose, offset))),
        }
    }

    /// Whether the other groups of all positions stand at one place: what they carry does not move.
    fn leader_stands(&self) -> bool {
        self.idle && self.positions.iter().all(|p| !p.others.is_empty())
    }

    fn motion(&mut self, at: At, said: MotionInstruction) {
        let mut closed = said.closed;
        let position = said.goal.as_ref().ok().and_then(|n| self.by_index.get(n).copied());
        let goal = match said.goal {
            Err(why) => Goal::Opaque(why),
            Ok(_) if self.tracks || self.led.is_some() => {
                let by = self.led.unwrap_or("a conveyor that the program tracks");
                Goal::Opaque(format!("{by} leads the robot away from its positions"))
            }
            Ok(_) if said.coordinated && !self.leader_stands() => {
                Goal::Opaque("COORD: its way is straight for a part that another group moves".into())
            }
            Ok(n) => self.goal(n, position, &said.offset),
        };
        let goal = match (goal, &said.via[..], position) {
            (Goal::Pose(pose), [via], Some(p)) if said.path == PathKind::Curve => {
                Goal::pose(PoseGoal { via_m: self.via(*via, p), ..*pose })
            }
            (goal, ..) => goal,
        };
        let still = match (self.before, position) {
            _ if self.idle => true,
            (Some(a), Some(b)) => self.extras[a] == self.extras[b],
            _ => false,
        };
        if !still {
            closed.get_or_insert_with(|| "another axis or group may move with it".into());
        }
        if matches!(goal, Goal::Pose(_)) && self.dof > 6 {
            closed.get_or_insert_with(|| "a Cartesian position with further axes cannot be written as joints".into());
        }
        if said.motion.is_none() {
            closed.get_or_insert_with(|| "its statement cannot be copied".into());
        }
        if self.uncounted && said.motion.as_ref().is_some_and(|m| m.number.is_some()) {
            closed.get_or_insert_with(|| "no attribute gives the number of lines, which must grow (LINE_COUNT)".into());
        }
        self.before = position;
        if said.relative
            && let Some(before) = self.steps.last_move_mut()
        {
            before.fixed.get_or_insert_with(|| "a motion after it counts from where it ends (INC)".into());
        }
        if let Some(motion) = said.motion {
            self.steps.place(self.steps.next(), motion);
        }
        let straight = said.path == PathKind::Linear && matches!(goal, Goal::Joints(_));
        let tool = position.filter(|_| straight).map(|p| self.tool(&self.positions[p]));
        let how = How {
            path: said.path,
            fixed: None,
            closed,
            speed: said.speed,
            blend_m: said.blend_m,
            tool,
            turns_known: false,
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

/// The joints of a position, as many as the robot has axes.
fn target(text: &Text, robot: &Axes, p: &Position) -> Result<Target> {
    let axes = p.axes();
    if axes.len() < robot.dof() {
        let found = format!("{} joint values in P[{}]", axes.len(), p.index);
        return Err(text.bad(p.head.start, found, format!("{}: one for each axis of the robot", robot.dof())));
    }
    let mut values = Vec::with_capacity(robot.dof());
    for (field, joint) in axes.into_iter().zip(robot.axis_joints()) {
        let mm = joint.kind == JointKind::Prismatic;
        if field.mm != mm || !(is_joint(&field.name) || is_extended(&field.name)) {
            let found = format!("`{}` in {}", field.name, if field.mm { "mm" } else { "deg" });
            return Err(text.bad(
                field.number.start(),
                found,
                format!("{} for axis {}", joint.kind.unit(), joint.name),
            ));
        }
        values.push(field.value.map(|(value, style)| Value {
            si: value * joint.kind.si_per_user_unit(),
            start: field.number.start(),
            end: field.number.end(),
            style,
            digit: weight(style) * joint.kind.si_per_user_unit(),
            finest: FINEST.min(weight(style)) * joint.kind.si_per_user_unit(),
        }));
    }
    Ok(Target { name: Some(format!("P[{}]", p.index)), at: At { file: 0, line: p.line }, values, pose: None })
}

/// A pose that is moved by a position register: in a frame, or for a tool, of its own.
fn displaced(mut pose: PoseGoal, offset: &Option<(bool, String)>) -> PoseGoal {
    if let Some((of_tool, text)) = offset {
        let place = if *of_tool { &mut pose.tool } else { &mut pose.frame };
        *place = std::mem::take(place).made("0", &format!("with {text}"));
    }
    pose
}

/// The numbers of a Cartesian position.
fn coordinates(p: &Position) -> Option<Target> {
    let form = PoseForm::FixedXyz;
    let value = |(k, field): (usize, &Field)| {
        let (value, style) = field.value?;
        let (unit, digit) = (form.unit(k), weight(style));
        let (start, end) = (field.number.start(), field.number.end());
        Some(Value { si: value * unit, start, end, style, digit: digit * unit, finest: FINEST.min(digit) * unit })
    };
    let values = p.coordinates()?.into_iter().enumerate().map(value).collect();
    let at = At { file: 0, line: p.line };
    Some(Target { name: Some(format!("P[{}]", p.index)), at, values, pose: Some(form) })
}

fn weight(style: number::Style) -> f64 {
    10_f64.powi(-i32::from(style.decimals))
}
