//! A program's text into its script, line by line.
//!
//! Read this file first: the reader, folds, and which line is what. Then [`moves`]: motions; [`flow`]: blocks, jumps and calls; [`alike`]:
//! motions that differ in their axis values alone, read once.

mod alike;
mod flow;
mod moves;

use super::calls::{arc, calls};
use super::data::Data;
use super::form;
use super::frame::number;
use super::going::{Going, Turning};
use super::led::Led;
use super::lex::{Kind, Token, first_word, in_upper, tokens, upper};
use super::lists::Lists;
use super::motion::{self, Motion};
use super::program::{Program, Source};
use super::relative::{self, Stands};
use super::settings::{self, Settings};
use super::statement::{assignment, is_routine};
use super::still::Still;
use super::target::{Others, axis_names, external_axes};
use crate::axes::{Axes, JointKind};
use crate::error::{Error, Place, Result};
use crate::script::blocks::{BySteps, Steps};
use crate::script::lex::not_too_long;
use crate::script::pose::Frame;
use crate::script::{At, Break, Goal, Note, Script, StepKind, Targets, Text, pragma};
use alike::Alike;
use flow::Block;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ops::Range;

pub(super) fn program(texts: Vec<Text>, robot: &Axes) -> Result<Program> {
    let Some(text) = texts.first() else {
        return Err(Error::bad(Place::default(), "no text", "a KUKA KRL program (.src)"));
    };
    for text in &texts {
        not_too_long(text)?;
    }
    whole(text)?;
    let mut data = Data::collect(&texts)?;
    changed_frame_data(text, &mut data);
    let axes: Vec<(String, JointKind)> =
        axis_names(robot).into_iter().zip(robot.axis_joints().map(|j| j.kind)).collect();
    let mut reader = Reader::new(&texts, &data, &axes);
    let mut line = Vec::new();
    reader.lists = lists(text, &data);
    (reader.later, reader.turning_later) = later(text, &data, &reader.going, &reader.lists);
    (reader.carried_later, reader.moved_later) = carried(text, &data);
    reader.passed = passed(text);
    for list in (0..2).filter(|list| !reader.passed[*list].is_empty()) {
        reader.later[list] = Some(by_a_routine(list));
    }
    let mut alike = Alike::default();
    for k in 0..text.line_count() {
        if !alike.again(&mut reader, k) {
            tokens(text, k, &mut line);
            let seen = alike.before(&reader);
            reader.line(k, &line)?;
            alike.learn(&reader, k, &line, seen);
        }
    }
    reader.note_calls();
    let Reader { steps, targets, sources, mut notes, counted_calls, jumps, .. } = reader;
    let mut script = Script::default();
    let (mut motions, mut others) = (BySteps::of_text(text), BySteps::default());
    for (k, site) in steps.finish(&mut script).into_values() {
        if let Some(motion) = site.motion {
            motions.push(k, motion);
        }
        others.push(k, site.others);
    }
    script.keep_before_relative(relative::BEFORE, &counted_calls, jumps);
    script.keep_before_reading("the program reads where it ends", &reads_place(text));
    let mut steps = script.steps;
    if texts.iter().filter(|t| !t.context).count() == 1
        && data.names.is_empty()
        && targets.is_empty()
        && motions.values().next().is_some()
    {
        let text = "no data list (.dat) was found beside the program, and no point is declared in it".to_string();
        notes.push(Note { place: At { file: 0, line: 1 }, text });
    }
    external_axes(&mut steps, &others);
    if targets.iter().filter(|t| t.pose.is_none()).all(|t| t.values.iter().all(|v| v.is_none())) {
        // a new point would have no axis to name
        for step in &mut steps {
            if let StepKind::Move(m) = &mut step.kind
                && !matches!(m.goal, Goal::Pose(_))
            {
                m.closed.get_or_insert_with(|| "no motion of the program gives axis values".into());
            }
        }
    }
    let (axes, kinds) = axes.iter().cloned().unzip();
    drop(line);
    let script = Script { steps, targets, notes, ..Script::default() };
    let mut program = Program { script, kinds, axes, motions, data, sources };
    program.script.texts = texts;
    Ok(program)
}

/// Refuses a data list alone, and a text without a routine.
///
/// `program = ... ("DEF" | "DEFFCT" | "GLOBAL") ... | "DEFDAT" ...`
fn whole(text: &Text) -> Result<()> {
    let mut line = Vec::new();
    for k in 0..text.line_count() {
        tokens(text, k, &mut line);
        let Some(first) = line.first().filter(|t| t.kind == Kind::Word) else { continue };
        match upper(text, first).as_str() {
            "DEFDAT" => {
                return Err(text.bad(
                    first.start,
                    "a data list (DEFDAT)",
                    "the program itself: give the .src, its .dat is found beside it",
                ));
            }
            "DEF" | "DEFFCT" | "GLOBAL" => return Ok(()),
            _ => {}
        }
    }
    Err(text.bad(0, "no routine", "a KUKA KRL program with DEF ... END"))
}

/// Frame data that the program changes (`FP1.BASE_NO=3`): which base and tool they name is not certain.
///
/// `assignment = name ["." field] "=" value`
fn changed_frame_data(text: &Text, data: &mut Data) {
    if data.numbers.is_empty() {
        return;
    }
    let mut line = Vec::new();
    for k in 0..text.line_count() {
        if memchr::memchr(b'=', text.line(k)).is_none() {
            continue;
        }
        tokens(text, k, &mut line);
        let Some(first) = line.first().filter(|_| assignment(&line).is_some()) else { continue };
        if let Some(numbers) = data.numbers.get_mut(in_upper(text, first).as_ref()) {
            *numbers = [None, None];
        }
    }
}

/// What the text sets in BASE_DATA and TOOL_DATA, wherever it stands.
///
/// `assignment = ("BASE_DATA" | "TOOL_DATA") "[" number "]" "=" value`
fn lists(text: &Text, data: &Data) -> Lists {
    let mut all = Lists::default();
    let (mut line, mut routine) = (Vec::new(), 0);
    for k in 0..text.line_count() {
        if !matches!(first_word(text, k), [b'B' | b'b' | b'T' | b't' | b'D' | b'd' | b'G' | b'g', ..]) {
            continue;
        }
        tokens(text, k, &mut line);
        line.retain(|t| t.kind != Kind::Comment);
        let word = line.first().map(|t| in_upper(text, t)).unwrap_or_default();
        routine += usize::from(is_routine(&word, &line.get(1).map(|t| upper(text, t)).unwrap_or_default()));
        if let Some(sign) = assignment(&line).filter(|_| matches!(&*word, "BASE_DATA" | "TOOL_DATA")) {
            let mut set = Settings::default();
            set.assign(text, &line, sign, &word, data, routine);
            all.add(&set.lists);
        }
    }
    all
}

/// Whether control may come to a line from elsewhere than from the line before: by a label or the start of a routine (`true`: nothing
/// above it may have run), after a call or at a loop.
///
/// `join = name ":" | routine | "LOOP" | "FOR" | "WHILE" | "REPEAT" | ... call ...`
fn joins(text: &Text, line: &[Token], word: &str, second: &str) -> Option<bool> {
    let label = line.len() == 2 && line[0].kind == Kind::Word && line[1].is(b':');
    let more = || matches!(word, "LOOP" | "FOR" | "WHILE" | "REPEAT") || !calls(text, line).is_empty();
    (label || is_routine(word, second)).then_some(true).or_else(|| more().then_some(false))
}

/// $BASE and $TOOL after a branch, a label or a call: known where the file sets none, or always the same.
///
/// `setting = "BAS" "(" ... ")" | assignment`
fn later(text: &Text, data: &Data, going: &Going, lists: &Lists) -> ([Option<Frame>; 2], Turning) {
    let mut set = Settings::default();
    let mut turning = Turning::Evenly;
    let mut found: [Vec<Frame>; 2] = Default::default();
    let mut line = Vec::new();
    let mut routine = 0;
    for k in 0..text.line_count() {
        // a routine, BAS or an assignment
        if lists.is_empty()
            && !matches!(first_word(text, k), [b'B' | b'b' | b'D' | b'd' | b'G' | b'g', ..])
            && memchr::memchr(b'=', text.line(k)).is_none()
        {
            continue;
        }
        tokens(text, k, &mut line);
        line.retain(|t| t.kind != Kind::Comment);
        let Some(first) = line.first() else { continue };
        let (word, second) = (upper(text, first), line.get(1).map(|t| upper(text, t)).unwrap_or_default());
        routine += usize::from(is_routine(&word, &second));
        if let Some(unset) = joins(text, &line, &word, &second).filter(|_| !lists.is_empty()) {
            set.lists.merge_all(lists, unset);
        }
        turning = turning.max(going.turning(text, &line, &word).unwrap_or_default());
        if word == "BAS" {
            set.bas(text, &line);
        } else if let Some(sign) = assignment(&line) {
            set.assign(text, &line, sign, &word, data, routine);
        } else {
            continue;
        }
        for (all, now) in found.iter_mut().zip([&set.base, &set.tool]) {
            if let Some(now) = now.as_ref().filter(|now| !all.contains(now)) {
                all.push(now.clone());
            }
        }
    }
    let frames = found.map(|all| match all.as_slice() {
        [] => None,
        [one] => Some(one.clone()),
        // which is in force is not certain
        all => Some(Frame::Any(all.to_vec())),
    });
    (frames, turning)
}

/// What may make any base mean something else after a branch, a label or a call: `$IPO_MODE`, `$WORLD`.
///
/// `assignment = ("$IPO_MODE" | "$WORLD" | ...) "=" value`
fn carried(text: &Text, data: &Data) -> (Option<String>, Option<String>) {
    let (mut carried, mut moved) = (None, None);
    let mut line = Vec::new();
    for k in 0..text.line_count() {
        if !matches!(first_word(text, k), [b'$', b'I' | b'i' | b'W' | b'w' | b'R' | b'r', ..]) {
            continue;
        }
        tokens(text, k, &mut line);
        line.retain(|t| t.kind != Kind::Comment);
        let (Some(first), Some(sign)) = (line.first(), assignment(&line)) else { continue };
        let mut set = Settings::default();
        set.assign(text, &line, sign, &upper(text, first), data, 0);
        (carried, moved) = (carried.or(set.carried), moved.or(set.moved));
    }
    (carried, moved)
}

struct Fold {
    line: usize,
    inline: bool,
    /// Steps before it.
    steps: usize,
    /// Something stands in it that is no setting of the form.
    more: bool,
}

/// Where a motion stands, and the axes that are none of the robot's.
#[derive(Default)]
struct Site {
    motion: Option<Motion>,
    others: Others,
}

/// `$BASE` and `$TOOL`, of which a routine may make others to which they are passed themselves.
const FRAMES: [&str; 2] = ["$BASE", "$TOOL"];

fn by_a_routine(list: usize) -> Frame {
    Frame::Named(format!("{} as a routine sets it", FRAMES[list]))
}

/// Lines at which each of them is an argument.
///
/// `argument = ("(" | ",") ("$BASE" | "$TOOL") (")" | ",")`
fn passed(text: &Text) -> [BTreeSet<u64>; 2] {
    let argument = |at: usize, name: &str| {
        let (before, rest) = text.bytes.split_at(at);
        let Some((word, after)) = rest.split_at_checked(name.len()) else { return false };
        word.eq_ignore_ascii_case(name.as_bytes())
            && matches!(before.trim_ascii_end().last(), Some(b'(' | b','))
            && matches!(after.trim_ascii_start().first(), Some(b')' | b','))
    };
    FRAMES.map(|name| {
        let all = memchr::memchr_iter(b'$', &text.bytes).filter(|at| argument(*at, name));
        all.map(|at| text.line_of(at)).collect()
    })
}

/// Lines that assign where the robot stands to a variable: `HERE=$POS_ACT`.
///
/// `reading = name "=" {any} ("$POS_ACT" | "$AXIS_ACT" | "$POS_INT" | "$AXIS_INT" | "$POS_FOR" | "$AXIS_FOR" | "$POS_RET" | "$AXIS_RET")`
fn reads_place(text: &Text) -> BTreeSet<u64> {
    const PLACES: [&[u8]; 8] =
        [b"$POS_ACT", b"$AXIS_ACT", b"$POS_INT", b"$AXIS_INT", b"$POS_FOR", b"$AXIS_FOR", b"$POS_RET", b"$AXIS_RET"];
    let is = |at: usize| {
        let rest = text.bytes.get(at..).unwrap_or_default();
        PLACES.iter().any(|place| rest.get(..place.len()).is_some_and(|w| w.eq_ignore_ascii_case(place)))
    };
    let mut line = Vec::new();
    let assigns = |at: usize| {
        let k = text.line_of(at);
        tokens(text, k as usize - 1, &mut line);
        line.retain(|t| t.kind != Kind::Comment);
        let first = line.first().map(|t| upper(text, t)).unwrap_or_default();
        let sign = assignment(&line).filter(|_| motion::word(&first).is_none());
        let after = sign.and_then(|sign| line.get(sign)).is_some_and(|t| t.start < at);
        (after && line.last().is_some_and(|t| at < t.end)).then_some(k)
    };
    memchr::memchr_iter(b'$', &text.bytes).filter(|at| is(*at)).filter_map(assigns).collect()
}

/// Whether a text sets `$ORI_TYPE` or `$CIRC_TYPE`.
///
/// `setting = ... ("$ORI_TYPE" | "$CIRC_TYPE") ...`
fn steers_arcs(text: &Text) -> bool {
    memchr::memchr_iter(b'$', &text.bytes).any(|at| {
        let sets = |word: &[u8]| text.slice(at..at + word.len()).eq_ignore_ascii_case(word);
        sets(b"$ORI_TYPE") || sets(b"$CIRC_TYPE")
    })
}

struct Reader<'a> {
    texts: &'a [Text],
    text: &'a Text,
    data: &'a Data,
    axes: &'a [(String, JointKind)],
    names: Vec<String>,
    /// $BASE and $TOOL after a branch or a call, where that is certain.
    later: [Option<Frame>; 2],
    steps: Steps<Site>,
    blocks: Vec<Block>,
    /// Where the robot stands after the last motion, where that ends exactly at a known point.
    stands: Option<Stands>,
    /// Routines that move nothing, and those of them that were met.
    still: Still,
    met: BTreeMap<String, u64>,
    targets: Targets,
    sources: Vec<Source>,
    of_name: HashMap<usize, usize>,
    notes: Vec<Note>,
    routine: usize,
    folds: Vec<Fold>,
    trigger: bool,
    spline: bool,
    /// The program sets how the orientation goes on arcs.
    steers_arcs: bool,
    set: Settings,
    going: Going,
    /// What leads the robot away from its points.
    led: Led,
    /// Routines that may begin with a relative motion, and the lines that call them.
    counting: BTreeSet<String>,
    counted_calls: BTreeSet<u64>,
    /// Something jumps, which leaves no step where the block around it moves nothing.
    jumps: bool,
    /// What the text sets in the lists of the controller.
    lists: Lists,
    /// What may make any base mean something else there.
    carried_later: Option<String>,
    moved_later: Option<String>,
    /// How the tool may turn where it is not known which way the program came.
    turning_later: Turning,
    /// Frames that a motion sets for itself, and a spline block for its motions: base and tool.
    with: [Option<Frame>; 2],
    of_block: [Option<Frame>; 2],
    /// In the first routine: base and tool may be others than at its start.
    frames_set: bool,
    /// The factor of a product whose numbers are edited, of the goal that was read last.
    point: Option<Range<usize>>,
    /// Lines at which `$BASE` and `$TOOL` are passed to a routine.
    passed: [BTreeSet<u64>; 2],
}

impl<'a> Reader<'a> {
    fn new(texts: &'a [Text], data: &'a Data, axes: &'a [(String, JointKind)]) -> Self {
        Self {
            texts,
            text: &texts[0],
            data,
            axes,
            names: axes.iter().map(|a| a.0.clone()).collect(),
            steps: Steps::of_text(&texts[0]),
            blocks: Vec::new(),
            stands: None,
            still: Still::of(texts),
            met: BTreeMap::new(),
            targets: Targets::of_text(&texts[0]),
            sources: Vec::with_capacity(texts[0].likely_steps()),
            of_name: HashMap::new(),
            notes: Vec::new(),
            routine: 0,
            folds: Vec::new(),
            steers_arcs: texts.iter().filter(|t| !t.context).any(steers_arcs),
            trigger: false,
            spline: false,
            set: Settings::default(),
            going: Going::of(texts),
            led: Led::of(&texts[0]),
            counting: relative::routines(texts),
            counted_calls: BTreeSet::new(),
            jumps: false,
            lists: Lists::default(),
            carried_later: None,
            moved_later: None,
            turning_later: Turning::Evenly,
            with: [None, None],
            of_block: [None, None],
            frames_set: false,
            point: None,
            passed: [BTreeSet::new(), BTreeSet::new()],
            later: [None, None],
        }
    }

    /// `line = [statement] [comment]`
    fn line(&mut self, k: usize, tokens: &[Token]) -> Result<()> {
        let code = tokens.iter().position(|t| t.kind == Kind::Comment).unwrap_or(tokens.len());
        if let (0, Some(t)) = (code, tokens.first()) {
            self.fold(k, t);
        }
        if code > 0 {
            self.statement(k, &tokens[..code])?;
        }
        if let Some(on) = tokens.get(code).and_then(|t| pragma(self.text.slice(t.span()))) {
            self.push(k, StepKind::Pragma(on));
        }
        Ok(())
    }

    /// `fold = ";" ("FOLD" text | "ENDFOLD" text)`
    fn fold(&mut self, k: usize, t: &Token) {
        let comment = String::from_utf8_lossy(self.text.slice(t.span())).to_ascii_uppercase();
        let comment = comment.trim_start_matches([';', ' ', '\t']);
        if comment.starts_with("ENDFOLD") {
            let more = self.folds.pop().is_some_and(|f| f.more);
            if let Some(outer) = self.folds.last_mut() {
                outer.more |= more;
            }
        } else if let Some(rest) = comment.strip_prefix("FOLD").filter(|r| r.starts_with([' ', '\t']) || r.is_empty()) {
            let first = rest.split_ascii_whitespace().next().unwrap_or_default();
            let inline = rest.contains("%{P") && !rest.contains("%{PH}") || motion::word(first).is_some();
            self.folds.push(Fold { line: k, inline, steps: self.steps.next(), more: false });
        }
    }

    /// `statement = "&" ... | motion | other_statement`
    fn statement(&mut self, k: usize, line: &[Token]) -> Result<()> {
        let Some(first) = line.first() else { return Ok(()) };
        if first.is(b'&') {
            return Ok(());
        }
        let text = self.text;
        let word = in_upper(text, first);
        if let Some(w) = motion::word(&word) {
            return self.motion(k, line, w);
        }
        let second = line.get(1).map(|t| in_upper(text, t)).unwrap_or_default();
        if let Some(fold) = self.folds.last_mut() {
            fold.more = fold.more || !form::setting(self.text, line);
        }
        self.other_statement(k, line, &word, &second);
        if let Some(turning) = self.going.turning(self.text, line, &word) {
            self.set.turns(turning, &*word == "LDAT_ACT");
        }
        Ok(())
    }

    /// A statement that is no motion: a routine, a label, a jump, a wait, a process, a declaration, a call.
    ///
    /// `other_statement = routine | name ":" | block | jump | "WAIT" ["SEC" number] | "HALT" | declaration | other`,
    /// `block = "IF" | "SWITCH" | "LOOP" | "FOR" | "WHILE" | "REPEAT" | ... with their middles and ends`
    fn other_statement(&mut self, k: usize, line: &[Token], word: &str, second: &str) {
        if is_routine(word, second) {
            self.routine += 1;
            (self.spline, self.trigger) = (false, false);
            (self.of_block, self.frames_set) = ([None, None], false);
            self.folds.clear();
            self.blocks.clear();
            self.steps.start();
            self.stop(k, Break::Start);
            return;
        }
        if line.len() == 2 && line[0].kind == Kind::Word && line[1].is(b':') {
            self.stop(k, Break::Jump);
            return;
        }
        match word {
            "IF" | "SWITCH" => self.open(k, line, Break::Jump),
            "ELSE" | "CASE" | "DEFAULT" => self.middle(k, line),
            "ENDIF" | "ENDSWITCH" => self.close(k, line, Break::Jump),
            "GOTO" | "EXIT" => {
                self.jumps = true;
                self.leave(k);
            }
            "RETURN" => {
                self.jumps = true;
                self.called(k, line);
                self.leave(k);
            }
            "RESUME" | "END" | "ENDFCT" => self.stop(k, Break::Jump),
            "LOOP" | "FOR" | "WHILE" | "REPEAT" => self.open(k, line, Break::Loop),
            "ENDLOOP" | "ENDFOR" | "ENDWHILE" | "UNTIL" => self.close(k, line, Break::Loop),
            "WAIT" => {
                let seconds = (second == "SEC").then(|| number(self.text, line.get(2..).unwrap_or_default())).flatten();
                self.push(k, StepKind::Dwell(seconds.filter(|s| *s >= 0.0)));
                self.called(k, line);
            }
            "HALT" => self.push(k, StepKind::Dwell(None)),
            "INTERRUPT" | "BRAKE" => self.stop(k, Break::Interrupt),
            "GLOBAL" if second == "INTERRUPT" => self.stop(k, Break::Interrupt),
            // an action at a place of the next motion; what it calls runs beside the program and may not move the robot
            "TRIGGER" => self.trigger = true,
            "STOP" if second == "WHEN" => {
                self.trigger = true;
                self.stop(k, Break::Interrupt);
            }
            "CONST_VEL" => self.trigger = true,
            "SPLINE" | "PTP_SPLINE" => {
                self.spline = true;
                self.of_block = settings::with(&self.set, self.text, line, self.data, self.routine);
            }
            "ENDSPLINE" => (self.spline, self.of_block) = (false, [None, None]),
            "DECL" | "GLOBAL" | "CONST" | "INT" | "REAL" | "BOOL" | "CHAR" | "E6AXIS" | "AXIS" | "E6POS" | "POS"
            | "FRAME" | "FDAT" | "PDAT" | "LDAT" | "ANOUT" | "ANIN" | "DIGIN" | "CCLOSE" => self.called(k, line),
            "STRUC" | "ENUM" | "SIGNAL" | "EXT" | "EXTP" | "EXTFCT" | "IMPORT" | "CONTINUE" | "ON_ERROR_PROCEED" => {}
            "BAS" => {
                self.stands = None;
                self.set.bas(self.text, line);
                self.frames_set |= self.set.base.is_some() || self.set.tool.is_some();
            }
            "ARC_ON" | "ARCON" | "ARC_STRT" => self.push(k, StepKind::Process(true)),
            "ARC_OFF" | "ARCOFF" | "ARCOF" => self.push(k, StepKind::Process(false)),
            _ => {
                if let Some(on) = arc(self.text, line, word) {
                    self.push(k, StepKind::Process(on));
                }
                self.other(k, line, word);
            }
        }
    }

    /// A routine to which `$BASE` or `$TOOL` itself is passed may set it.
    fn passed(&mut self, k: usize) {
        let set = |list: usize| self.passed[list].contains(&(k as u64 + 1)).then(|| by_a_routine(list));
        let [base, tool] = [set(0), set(1)];
        self.set.base = base.or(self.set.base.take());
        self.set.tool = tool.or(self.set.tool.take());
    }

    /// An assignment, a call, or something unknown.
    ///
    /// `other = assignment | call | unknown`
    fn other(&mut self, k: usize, line: &[Token], word: &str) {
        let Some(sign) = assignment(line) else {
            match line.get(1).is_some_and(|t| t.is(b'(')) {
                true => self.called(k, line),
                false => self.stop(k, Break::Call),
            }
            self.passed(k);
            return;
        };
        self.called(k, line);
        self.passed(k);
        // a frame that is computed may be another one under the same name
        if word.starts_with('$') || ["FDAT_ACT", "BASE_DATA", "TOOL_DATA"].contains(&word) {
            self.stands = None;
        }
        self.set.assign(self.text, line, sign, word, self.data, self.routine);
        self.frames_set |= self.set.base.is_some() || self.set.tool.is_some();
        if word == "FDAT_ACT" && self.going.holds_part(self.text, &line[1..]) {
            self.set.carried = Some("the robot holds the part (IPO_FRAME #TCP)".into());
        }
    }
}
