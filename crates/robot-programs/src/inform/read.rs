//! Instructions to steps; moves are read by [`movement`](super::movement).

use super::circles::{self, Circles};
use super::flow::{self, Flow, StillJobs};
use super::list::{List, shown};
use super::shared::{Shared, clears_positions, variables};
use super::{Job, Kind, Section, Statement};
use crate::axes::Axes;
use crate::error::{Error, Place, Result};
use crate::script::blocks::Steps;
use crate::script::lex::{not_too_long, upper_of};
use crate::script::{At, Break, Goal, Move, Note, Script, Step, StepKind, Targets, Text, number, pragma};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Decimals of lengths in a Cartesian position, mm.
pub(super) const LENGTH_DECIMALS: u8 = 3;
/// Decimals that an ANGLE job, and the angles of a Cartesian position, keep.
pub(super) const ANGLE_DECIMALS: u8 = 4;

/// Instructions that do not move the robot, and do not change what positions mean.
pub(super) const STILL: &[&str] = &[
    "NOP", "DOUT", "DIN", "AOUT", "AIN", "PULSE", "GOUT", "GIN", "SET", "SETE", "GETE", "GETS", "ADD", "SUB", "MUL",
    "DIV", "INC", "DEC", "AND", "OR", "NOT", "XOR", "SQRT", "SIN", "COS", "ATAN", "CNVRT", "MSHIFT", "MULMAT",
    "INVMAT", "CLEAR", "SETFILE", "GETFILE", "SETREG", "GETREG", "GETPOS", "GETARG", "VAL2STR", "ASC", "CHR$", "MID$",
    "LEN", "CAT$", "STR$", "VAL", "MSG", "DIALOG", "ADVINIT", "ADVSTOP", "PRINT", "SETUALM", "REFP", "SPEED", "ARCSET",
    "AWELD", "VWELD", "ARATION", "ARATIOF", "PWAIT", "TSYNC", "ENDWAIT", "COMM",
];
/// Instructions at which the robot stands.
pub(super) const STANDS: &[&str] = &["WAIT", "CWAIT", "PAUSE", "HAND", "HSEN", "SPOT", "SVSPOT", "GUNCL"];
/// Branches.
const JUMPS: &[&str] = &[
    "JUMP",
    "RET",
    "IF",
    "IFTHEN",
    "IFTHENEXP",
    "ELSEIF",
    "ELSEIFEXP",
    "ELSE",
    "ENDIF",
    "SWITCH",
    "CASE",
    "DEFAULT",
    "ENDSWITCH",
    "LABEL",
    "ANDIF",
    "ORIF",
    "ABORT",
];
const LOOPS: &[&str] = &["WHILE", "WHILEEXP", "ENDWHILE", "FOR", "NEXT"];
const FRAMES: &[&str] = &["SETTOOL", "MFRAME", "GETTOOL"];
/// Instructions that start another job.
pub(super) const STARTS: &[&str] = &["CALL", "PSTART"];
pub(super) const PROCESS: &[(&str, bool)] = &[
    ("ARCON", true),
    ("ARCOF", false),
    ("TOOLON", true),
    ("TOOLOF", false),
    ("SPYON", true),
    ("SPYOF", false),
    ("LASERON", true),
    ("LASEROF", false),
];
/// Instructions that lay another motion over the path until the second of them.
const OVERLAID: &[(&str, &str)] = &[
    ("WVON", "WVOF"),
    ("COMARCON", "COMARCOF"),
    ("SFTON", "SFTOF"),
    // a conveyor, a soft servo
    ("SYSTART", "SYEND"),
    ("FLOATON", "FLOATOF"),
];

/// Reads a job.
pub(super) fn job(texts: Vec<Text>, robot: &Axes) -> Result<Job> {
    let Some(text) = texts.first() else {
        return Err(Error::bad(Place::file(""), "no text", "an INFORM job"));
    };
    not_too_long(text)?;
    let mut list = List::default();
    let begin = list.read(text)?;
    let overlaid = flow::overlaid_before(text, begin, OVERLAID);
    let jobs = StillJobs::of(&texts[1..]);
    let mut reader = Reader {
        text,
        robot,
        list: &list,
        ends: super::ends(&list.positions),
        assigned: assigned(text, begin, &list),
        shared: Shared::of(text, begin, &texts[1..]),
        frames_set: FramesSet::of(text, begin),
        has_noted: false,
        counted: Counted::of(text, begin),
        moves: 0,
        script: Script { targets: Targets::of_text(text), ..Script::default() },
        steps: Steps::of_text(text),
        blocks: Vec::new(),
        met: BTreeMap::new(),
        quiet: BTreeSet::new(),
        targets: super::Known::default(),
        numbers: Vec::new(),
        pinned: vec![false; list.positions.len()],
        circles: circles::of(text, begin, &list, &jobs, &overlaid),
        jobs,
        overlaid,
        counted_calls: BTreeSet::new(),
        base_axes: list.base_axes,
        still: None,
    };
    reader.quiet = flow::quiet_labels(text, begin, &reader.jobs);
    reader.instructions(begin)?;
    reader.note_calls();
    reader.script.notes.extend(reader.counted.as_ref().map(Counted::note));
    let Reader { mut script, steps, numbers, mut pinned, counted_calls, circles, .. } = reader;
    let statements = steps.finish(&mut script);
    circles::join(&mut script, &circles);
    // what a move before a relative one leads to stays, whoever else leads there
    let mut kept = script.keep_before_relative("IMOV after it counts from where it ends", &counted_calls, true);
    kept.extend(script.keep_before_reading("the job reads where it ends", &reads_place(text, begin)));
    for step in kept {
        let positions = statements.get(step).map(|s| &s.references[..]).unwrap_or_default();
        positions.iter().for_each(|r| pinned[r.position()] = true);
    }
    script.texts = texts;
    Ok(Job {
        script,
        positions: list.positions,
        counts: list.counts,
        statements,
        numbers,
        pinned,
        pulses: robot.axis_joints().map(|j| j.pulses).collect(),
        unit: robot.axis_joints().map(|j| j.kind.si_per_user_unit()).collect(),
    })
}

/// Whether an instruction is known, so that it sets no position variable that it does not name.
pub(super) fn is_known(word: &str) -> bool {
    let lists = [STILL, STANDS, JUMPS, LOOPS, FRAMES, STARTS];
    let pairs = PROCESS.iter().map(|p| p.0).chain(OVERLAID.iter().flat_map(|p| [p.0, p.1]));
    word.starts_with(['*', '+'])
        || word.contains("MOV")
        || matches!(word, "TIMER" | "END")
        || lists.iter().any(|list| list.contains(&word))
        || pairs.into_iter().any(|p| p == word)
}

/// The words of a line, each with its bytes; a comment (`'`, or `//` after a space) is left out.
///
/// `line = {blank | word} ["'" comment | "//" comment]`,
/// `word = {any | '"' {any} '"'}`
pub(super) fn words(text: &Text, k: usize) -> Vec<Range<usize>> {
    let (start, line) = (text.line_span(k).start, text.line(k));
    let mut quoted = false;
    let mut found = Vec::new();
    let mut word: Option<usize> = None;
    for (i, &b) in line.iter().enumerate() {
        let comment = b == b'\'' || (word.is_none() && line[i..].starts_with(b"//"));
        if !quoted && comment {
            break;
        }
        quoted ^= b == b'"';
        if b.is_ascii_whitespace() && !quoted {
            found.extend(word.take().map(|w| start + w..start + i));
        } else if word.is_none() {
            word = Some(i);
        }
        if i + 1 == line.len() {
            found.extend(word.take().map(|w| start + w..start + i + 1));
        }
    }
    found.extend(word.map(|w| {
        let end = line[w..].iter().position(|&b| b == b'\'').map_or(line.len(), |e| w + e);
        start + w..start + end
    }));
    found
}

pub(super) fn upper(text: &Text, span: &Range<usize>) -> String {
    upper_of(text.slice(span.clone())).into_owned()
}

/// Whether a line is a move of a form that is met nearly everywhere, to a position with a `C` and its number, and names nothing else:
/// it runs nothing, sets nothing and clears nothing.
///
/// `move = ("MOVJ" | "MOVL") "C" digit {digit} {("VJ=" | "V=" | "PL=") {digit | "."}}`
pub(super) fn is_plain_move(line: &[u8]) -> bool {
    let Some(rest) = [b"MOVJ C", b"MOVL C"].iter().find_map(|head| line.strip_prefix(&head[..])) else { return false };
    let digits = rest.iter().take_while(|b| b.is_ascii_digit()).count();
    let mut words = rest[digits..].split(|b| b.is_ascii_whitespace()).filter(|w| !w.is_empty());
    let usual = |w: &[u8]| {
        let value = [&b"VJ="[..], b"V=", b"PL="].iter().find_map(|head| w.strip_prefix(*head));
        value.is_some_and(|v| v.iter().all(|b| b.is_ascii_digit() || *b == b'.'))
    };
    digits > 0 && rest.get(digits).is_none_or(u8::is_ascii_whitespace) && words.all(usual)
}

/// Whether the robot stands at an instruction that begins with this word.
pub(super) fn stands(word: &str) -> bool {
    word == "TIMER" || STANDS.contains(&word)
}

/// Whether an instruction moves nothing and changes nothing of what positions mean.
pub(super) fn still(text: &Text, k: usize, words: &[String]) -> bool {
    let known = words.first().is_some_and(|w| w == "END" || STILL.contains(&w.as_str()));
    known && sets_frame(text, k).is_empty()
}

/// The first line of a job's instructions; `None`: it has none.
///
/// `head = "//INST" {"/" ...}`
pub(super) fn begin_of(text: &Text) -> Option<usize> {
    let is = |k: &usize| text.line(*k).trim_ascii().eq_ignore_ascii_case(b"//INST");
    let begin = (0..text.line_count()).find(is)? + 1;
    Some((begin..text.line_count()).find(|k| !text.line(*k).starts_with(b"/")).unwrap_or(text.line_count()))
}

/// Numbers of the position variables that instructions other than moves name: their values are not certain.
///
/// `instruction = {label} word {variable | word}`
fn assigned(text: &Text, begin: usize, list: &List) -> BTreeSet<u32> {
    let mut found = BTreeSet::new();
    for k in begin..text.line_count() {
        if is_plain_move(text.line(k)) {
            continue;
        }
        let words: Vec<String> = words(text, k).iter().map(|w| upper(text, w)).collect();
        let Some(first) = words.iter().find(|w| !w.starts_with('*')) else { continue };
        // how many a CLEAR sets may not be written
        if clears_positions(&words) {
            found.extend(list.positions.iter().filter(|p| p.kind == Kind::P).map(|p| p.number));
        }
        if first.contains("MOV") || first == "SFTON" || first == "GETE" {
            continue;
        }
        let named = words.iter().filter(|w| !w.starts_with("JOB:"));
        found.extend(named.flat_map(|w| variables(w).0));
    }
    found
}

/// Lines that take down where the robot stands: `GETS PX010 $PX000`.
fn reads_place(text: &Text, begin: usize) -> BTreeSet<u64> {
    let named = |k: &usize| memchr::memmem::find(text.line(*k), b"$PX").is_some();
    (begin..text.line_count()).filter(named).map(|k| k as u64 + 1).collect()
}

/// Numbers of user frames and tools that the job sets while it runs (`MFRAME UF#(1) ...`, `SETTOOL TL#(2) P001`); `None`: any.
#[derive(Default)]
pub(super) struct FramesSet([BTreeSet<Option<u32>>; 2]);

impl FramesSet {
    const WORDS: [&str; 2] = ["UF#", "TL#"];

    /// Reads what the instructions from line `begin` set.
    ///
    /// `frame = ("UF#" | "TL#") "(" number ")"`
    fn of(text: &Text, begin: usize) -> Self {
        let mut found = Self::default();
        for k in begin..text.line_count() {
            let words = sets_frame(text, k);
            for (list, word) in found.0.iter_mut().zip(Self::WORDS) {
                let named = words.iter().filter_map(|w| w.split_once(word).map(|(_, rest)| rest));
                list.extend(named.map(|rest| {
                    let inside = rest.strip_prefix('(').and_then(|r| r.split(')').next());
                    inside.and_then(|n| n.parse::<u32>().ok())
                }));
            }
        }
        found
    }

    /// Whether the user frame (`tool`: the tool) of a number is one of them.
    pub(super) fn has(&self, tool: bool, number: u32) -> bool {
        let list = &self.0[usize::from(tool)];
        list.contains(&Some(number)) || list.contains(&None)
    }
}

/// Words of an instruction that sets a user frame or a tool that it names; none of any other. Those that are listed only use it.
///
/// `setting = {label} word ... ("UF#" | "TL#") ...`
pub(super) fn sets_frame(text: &Text, k: usize) -> Vec<String> {
    const USE: [&str; 9] = ["CNVRT", "MSHIFT", "SFTON", "CALL", "JUMP", "GETPOS", "GETS", "GETE", "REFP"];
    if memchr::memchr(b'#', text.line(k)).is_none() {
        return Vec::new();
    }
    let words: Vec<String> = words(text, k).iter().map(|w| upper(text, w)).collect();
    let names = words.iter().any(|w| FramesSet::WORDS.iter().any(|f| w.contains(f)));
    let first = words.iter().find(|w| !w.starts_with('*'));
    let sets = names && first.is_some_and(|f| !f.contains("MOV") && !USE.contains(&f.as_str()));
    if sets { words } else { Vec::new() }
}

/// Instructions that name moves by their number: `GETPOS PX000 STEP#(4)`.
struct Counted {
    /// Line of the first of them, from 0.
    line: usize,
    steps: BTreeSet<u32>,
    /// A number is set at run time: any step may be meant.
    any: bool,
}

impl Counted {
    /// Reads the numbers in the instructions from line `begin`.
    ///
    /// `step = "STEP#" "(" number ")"`
    fn of(text: &Text, begin: usize) -> Option<Self> {
        let mut found: Option<Self> = None;
        for k in begin..text.line_count() {
            if memchr::memchr(b'#', text.line(k)).is_none() {
                continue;
            }
            for word in words(text, k) {
                let word = upper(text, &word);
                let Some(at) = word.find("STEP#") else { continue };
                let counted = found.get_or_insert(Self { line: k, steps: BTreeSet::new(), any: false });
                let number = word[at..].strip_prefix("STEP#(").and_then(|w| w.split(')').next());
                match number.and_then(|n| n.parse().ok()) {
                    Some(n) => drop(counted.steps.insert(n)),
                    None => counted.any = true,
                }
            }
        }
        found
    }

    fn note(&self) -> Note {
        let named: Vec<String> = self.steps.iter().map(u32::to_string).collect();
        let stay = match (self.any, named.as_slice()) {
            (true, _) => "every goal stays as it is, as the number is set at run time".to_string(),
            (false, [one]) => format!("the goal of move {one} stays as it is"),
            (false, all) => format!("the goals of moves {} stay as they are", all.join(", ")),
        };
        let text = format!("STEP# counts the moves of the job: no points are added, and {stay}");
        Note { place: At { file: 0, line: self.line as u64 + 1 }, text }
    }
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
    /// `still` at the start of each open block.
    blocks: Vec<Option<Vec<f64>>>,
    /// Jobs beside it that move nothing, and those of them that it calls.
    jobs: StillJobs,
    met: BTreeMap<String, u64>,
    /// Labels that are reached from nowhere but from where nothing has moved since.
    quiet: BTreeSet<String>,
    /// Targets by the positions that make them.
    pub(super) targets: super::Known,
    pub(super) numbers: Vec<super::Numbers>,
    pub(super) pinned: Vec<bool>,
    /// Motions laid over the path, as bits, before each line.
    overlaid: Vec<u32>,
    /// Steps of arcs through three positions.
    pub(super) circles: Circles,
    /// Lines of calls of jobs that may begin with a relative move.
    counted_calls: BTreeSet<u64>,
    pub(super) base_axes: bool,
    /// Numbers beyond the robot's axes where the move before left them.
    pub(super) still: Option<Vec<f64>>,
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
        let step = self.steps.push(At { file: 0, line: k as u64 + 1 }, kind);
        if let Some(statement) = statement {
            self.steps.place(step, statement);
        }
    }

    /// Labels, jumps, blocks and calls; `false`: it is none of them.
    ///
    /// `flow = label | jump | call | block`, as [`flow::read`] reads them
    fn flow(&mut self, k: usize, words: &[Range<usize>]) -> bool {
        let at = At { file: 0, line: k as u64 + 1 };
        let words: Vec<String> = words.iter().map(|w| upper(self.text, w)).collect();
        match flow::read(&words) {
            Flow::Label(name) if self.quiet.contains(&name) => {}
            Flow::Label(_) => self.step(k, StepKind::Break(Break::Jump), None),
            // what follows is reached by a label
            Flow::Jump { always: true, .. } => self.steps.middle(at, Break::Jump),
            Flow::Jump { .. } => {}
            Flow::Open(kind) => {
                self.blocks.push(self.still.take());
                self.steps.open(at, kind);
            }
            Flow::Middle => {
                self.still = None;
                self.steps.middle(at, Break::Jump);
            }
            Flow::Close(kind) => {
                let (before, busy) = (self.blocks.pop().flatten(), self.steps.close(at, kind));
                self.still = before.filter(|_| !busy);
            }
            Flow::Condition if !self.blocks.is_empty() => {}
            Flow::Call(name) => match self.jobs.waits(&name) {
                Some(waits) => {
                    self.met.entry(name).or_insert(at.line);
                    if waits {
                        self.step(k, StepKind::Dwell(None), None);
                    }
                }
                None => {
                    if self.jobs.counts(&name) {
                        self.counted_calls.insert(at.line);
                    }
                    self.step(k, StepKind::Break(Break::Call), None);
                }
            },
            Flow::Condition | Flow::Other => return false,
        }
        true
    }

    /// Says which calls end nothing that is known of the joints.
    fn note_calls(&mut self) {
        let Some(line) = self.met.values().min().copied() else { return };
        let names: Vec<&str> = self.met.keys().map(String::as_str).collect();
        let text = match names.as_slice() {
            [one] => format!("the job {one} that it calls moves nothing, by the file beside it"),
            all => format!("the jobs {} that it calls move nothing, by the files beside it", all.join(", ")),
        };
        self.script.notes.push(Note { place: At { file: 0, line }, text });
    }

    /// All instructions from line `begin`.
    ///
    /// `instructions = {blank | "'" comment | instruction} "END" {blank | "'" comment}`
    fn instructions(&mut self, begin: usize) -> Result<()> {
        self.step(begin.saturating_sub(1), StepKind::Break(Break::Start), None);
        let mut ended = false;
        for k in begin..self.text.line_count() {
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
        if !foreign && word.contains("MOV") {
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
            self.close_last("a second motion group moves along");
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
            Some(StepKind::Break(Break::Call))
        };
        if let Some(kind) = kind {
            self.step(k, kind, None);
        }
        Ok(word == "END")
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
        if let Some(&p) = Kind::read(name).and_then(|(kind, n, _)| self.list.by_name.get(&(kind, n))) {
            self.pinned[p] = true;
        }
    }

    /// The next move of a job that names its moves by number: a new one before it would shift the numbers.
    pub(super) fn counted(&mut self, m: &mut Move) {
        self.moves += 1;
        let Some(counted) = &self.counted else { return };
        m.closed.get_or_insert_with(|| "STEP# in the job counts its moves".into());
        if counted.any || counted.steps.contains(&self.moves) {
            m.fixed.get_or_insert_with(|| "STEP# in the job reads where it leads".into());
        }
    }

    fn close_last(&mut self, why: &str) {
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
