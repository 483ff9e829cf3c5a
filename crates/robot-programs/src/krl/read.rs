//! A program's text into its script.

use super::aggregate::Aggregate;
use super::calls::{arc, calls};
use super::data::{Data, assignment, is_routine};
use super::form;
use super::going::{Going, Turning};
use super::lex::{Kind, Token, first_word, in_upper, tokens, upper};
use super::motion::{self, Word};
use super::name::Holds;
use super::product;
use super::relative::{self, Stands};
use super::settings::{self, Settings};
use super::still::Still;
use super::target::{Others, axis_names, external_axes, target};
use super::{Motion, Program, Source};
use crate::axes::{Axes, JointKind};
use crate::error::{Error, Place, Result};
use crate::script::blocks::{BySteps, Steps};
use crate::script::lex::not_too_long;
use crate::script::pose::Frame;
use crate::script::{
    At, Break, Few, Goal, How, Move, Note, PathKind, PoseForm, PoseGoal, Script, Shift, Span, Speed, StepKind, Target,
    Targets, Text, pragma,
};
use nalgebra::Vector3;
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::sync::Arc;

pub(super) fn program(texts: Vec<Text>, robot: &Axes) -> Result<Program> {
    let Some(text) = texts.first() else {
        return Err(Error::bad(Place::default(), "no text", "a KUKA KRL program (.src)"));
    };
    for text in &texts {
        not_too_long(text)?;
    }
    whole(text)?;
    let data = Data::collect(&texts)?;
    let axes: Vec<(String, JointKind)> =
        axis_names(robot).into_iter().zip(robot.axis_joints().map(|j| j.kind)).collect();
    let mut reader = Reader::new(&texts, &data, &axes);
    let mut line = Vec::new();
    reader.later = later(text, &data);
    for k in 0..text.line_count() {
        tokens(text, k, &mut line);
        reader.line(k, &line)?;
    }
    reader.note_calls();
    let Reader { steps, targets, sources, mut notes, .. } = reader;
    let mut script = Script::default();
    let (mut motions, mut others) = (BySteps::of_text(text), BySteps::default());
    for (k, site) in steps.finish(&mut script).into_values() {
        if let Some(motion) = site.motion {
            motions.push(k, motion);
        }
        others.push(k, site.others);
    }
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

/// $BASE and $TOOL after a branch, a label or a call: known where the file sets none, or always the same.
fn later(text: &Text, data: &Data) -> [Option<Frame>; 2] {
    let mut set = Settings::default();
    let mut found: [Vec<Frame>; 2] = Default::default();
    let mut line = Vec::new();
    let mut routine = 0;
    for k in 0..text.line_count() {
        // a routine, BAS or an assignment
        if !matches!(first_word(text, k), [b'B' | b'b' | b'D' | b'd' | b'G' | b'g', ..])
            && memchr::memchr(b'=', text.line(k)).is_none()
        {
            continue;
        }
        tokens(text, k, &mut line);
        line.retain(|t| t.kind != Kind::Comment);
        let Some(first) = line.first() else { continue };
        let word = upper(text, first);
        routine += usize::from(is_routine(&word, &line.get(1).map(|t| upper(text, t)).unwrap_or_default()));
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
    found.map(|all| match all.as_slice() {
        [] => None,
        [one] => Some(one.clone()),
        // which is in force is not certain
        all => Some(Frame::Any(all.to_vec())),
    })
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

/// A block that is open: the settings before it and with which it began.
struct Block {
    before: Settings,
    begins: Settings,
    /// It sets others.
    sets: bool,
}

/// Whether a text sets `$ORI_TYPE` or `$CIRC_TYPE`.
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
    /// The factor of a product whose numbers are edited, of the goal that was read last.
    point: Option<Range<usize>>,
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
            point: None,
            later: [None, None],
        }
    }

    fn push(&mut self, k: usize, kind: StepKind) {
        if let StepKind::Break(b) = kind
            && b != Break::Frame
        {
            self.set = self.later_settings();
        }
        if matches!(kind, StepKind::Break(_)) {
            self.stands = None;
        }
        self.steps.push(At { file: 0, line: k as u64 + 1 }, kind);
    }

    /// What is in force where it is not known which way the program came: frames stay where the file sets but one.
    fn later_settings(&self) -> Settings {
        let (base, tool) = (self.later[0].clone(), self.later[1].clone());
        let (bases, tools) = (self.set.bases.clone(), self.set.tools.clone());
        Settings { base, tool, bases, tools, ..Settings::default() }
    }

    /// A block opens; what its line calls belongs to it.
    fn open(&mut self, k: usize, line: &[Token], kind: Break) {
        self.stands = None;
        let before = self.set.clone();
        self.steps.open(At { file: 0, line: k as u64 + 1 }, kind);
        self.set = self.later_settings();
        self.blocks.push(Block { before, begins: self.set.clone(), sets: false });
        self.called(k, line);
    }

    /// Its next branch begins.
    fn middle(&mut self, k: usize, line: &[Token]) {
        self.stands = None;
        self.steps.middle(At { file: 0, line: k as u64 + 1 }, Break::Jump);
        if let Some(block) = self.blocks.last_mut() {
            block.sets |= self.set != block.begins;
        }
        self.set = self.later_settings();
        self.called(k, line);
    }

    /// It closes: where nothing in it moves, the directions stay, and where it sets nothing the settings do.
    fn close(&mut self, k: usize, line: &[Token], kind: Break) {
        self.stands = None;
        self.called(k, line);
        let busy = self.steps.close(At { file: 0, line: k as u64 + 1 }, kind);
        let block = self.blocks.pop();
        let sets = block.as_ref().is_none_or(|b| b.sets || self.set != b.begins);
        match block {
            Some(block) if !busy && !sets => self.set = block.before,
            _ => self.set = self.later_settings(),
        }
        if let Some(outer) = self.blocks.last_mut() {
            outer.sets |= sets;
        }
    }

    /// A jump away: what follows is reached by a label, or the end of its block.
    fn leave(&mut self, k: usize) {
        self.stands = None;
        if self.blocks.is_empty() {
            self.stop(k, Break::Jump)
        } else {
            self.steps.middle(At { file: 0, line: k as u64 + 1 }, Break::Jump)
        }
    }

    /// Says which calls end nothing that is known of the joints.
    fn note_calls(&mut self) {
        let Some(line) = self.met.values().min().copied() else { return };
        let names: Vec<&str> = self.met.keys().map(String::as_str).collect();
        let text = match names.as_slice() {
            [one] => format!("the routine {one} that it calls moves nothing, by the files of the project"),
            all => format!("the routines {} that it calls move nothing, by the files of the project", all.join(", ")),
        };
        self.notes.push(Note { place: At { file: 0, line }, text });
    }

    fn stop(&mut self, k: usize, kind: Break) {
        self.push(k, StepKind::Break(kind));
    }

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
        self.going.follow(self.text, line, &word, self.text.line(k));
        self.other_statement(k, line, &word, &second);
        Ok(())
    }

    /// A statement that is no motion: a routine, a label, a jump, a wait, a process, a declaration, a call.
    fn other_statement(&mut self, k: usize, line: &[Token], word: &str, second: &str) {
        if is_routine(word, second) {
            self.routine += 1;
            (self.spline, self.trigger) = (false, false);
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
            "GOTO" | "EXIT" => self.leave(k),
            "RETURN" => {
                self.called(k, line);
                self.leave(k);
            }
            "RESUME" | "END" | "ENDFCT" => self.stop(k, Break::Jump),
            "LOOP" | "FOR" | "WHILE" | "REPEAT" => self.open(k, line, Break::Loop),
            "ENDLOOP" | "ENDFOR" | "ENDWHILE" | "UNTIL" => self.close(k, line, Break::Loop),
            "WAIT" => {
                let seconds =
                    (second == "SEC").then(|| settings::number(self.text, line.get(2..).unwrap_or_default())).flatten();
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
            "SPLINE" | "PTP_SPLINE" => self.spline = true,
            "ENDSPLINE" => self.spline = false,
            "DECL" | "GLOBAL" | "CONST" | "INT" | "REAL" | "BOOL" | "CHAR" | "E6AXIS" | "AXIS" | "E6POS" | "POS"
            | "FRAME" | "FDAT" | "PDAT" | "LDAT" | "ANOUT" | "ANIN" | "DIGIN" | "CCLOSE" => self.called(k, line),
            "STRUC" | "ENUM" | "SIGNAL" | "EXT" | "EXTP" | "EXTFCT" | "IMPORT" | "CONTINUE" | "ON_ERROR_PROCEED" => {}
            "BAS" => {
                self.stands = None;
                self.set.bas(self.text, line);
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

    /// A break where the line calls something that may move.
    fn called(&mut self, k: usize, line: &[Token]) {
        let mut waits = false;
        for name in calls(self.text, line) {
            match self.still.waits(&name) {
                Some(waiting) => {
                    waits |= waiting;
                    self.met.entry(name).or_insert(k as u64 + 1);
                }
                None => return self.stop(k, Break::Call),
            }
        }
        if waits {
            self.push(k, StepKind::Dwell(None));
        }
    }

    /// An assignment, a call, or something unknown.
    fn other(&mut self, k: usize, line: &[Token], word: &str) {
        let Some(sign) = assignment(line) else {
            match line.get(1).is_some_and(|t| t.is(b'(')) {
                true => self.called(k, line),
                false => self.stop(k, Break::Call),
            }
            return;
        };
        self.called(k, line);
        // a frame that is computed may be another one under the same name
        if word.starts_with('$') || ["FDAT_ACT", "BASE_DATA", "TOOL_DATA"].contains(&word) {
            self.stands = None;
        }
        self.set.assign(self.text, line, sign, word, self.data, self.routine);
        if word == "FDAT_ACT" && self.going.holds_part(self.text, &line[1..]) {
            self.set.base = Some(Frame::Unknown("the robot holds the part (IPO_FRAME #TCP)".into()));
        }
    }

    /// The goal of an arc, with the point on its way; the angle CA moves its end.
    fn end_of_arc(&self, pose: PoseGoal, line: &[Token]) -> Goal {
        if line.iter().any(|t| upper(self.text, t) == "CA") {
            return Goal::Opaque("an angle CA tells where the arc ends".into());
        }
        Goal::pose(PoseGoal { via_m: self.via(line), ..pose })
    }

    fn motion(&mut self, k: usize, line: &[Token], word: Word) -> Result<()> {
        // where the robot stands: the controller stops, reads the joints and goes nowhere
        if !word.relative && !word.arc && !self.spline && motion::stands(self.text, line) {
            self.trigger = false;
            self.push(k, StepKind::Dwell(None));
            return Ok(());
        }
        let at = if word.arc { motion::second(line).unwrap_or(line.len()) } else { 1 };
        let mut others: Others = None;
        let mut end = None;
        let goal = self.goal(k, line, at, word, &mut end, &mut others)?;
        let relative = word.relative && matches!(goal, Goal::Pose(_));
        let whole = end.is_some_and(|e| motion::ends(self.text, line, e)) && !word.relative;
        let goal = match goal {
            goal @ Goal::Opaque(_) => goal,
            goal if relative => goal,
            _ if !whole => Goal::Opaque("the goal is computed".into()),
            Goal::Pose(pose) if word.arc => self.end_of_arc(*pose, line),
            goal => goal,
        };
        let tail = &line[end.unwrap_or(at).min(line.len())..];
        let turning = self.going.of_motion(self.text, tail);
        let goal = self.as_the_robot_goes(goal, word, tail, turning);
        let via = self.via_of_splittable(line, at, word, &goal);
        let copied = word.arc || whole || !has_more_after(line, at);
        let closed = self.closed(word, turning, via.is_some(), copied);
        let (speed, blend_m) = self.speed_and_blend(word, tail);
        let motion = end.filter(|_| whole).map(|e| self.written(k, line, at..e, word, via));
        // of most motions they are those of the one before
        let others = match self.steps.last_place() {
            Some(last) if last.others == others => last.others.clone(),
            _ => others,
        };
        self.steps.place(self.steps.next(), Site { motion, others });
        if word.relative
            && let Some(before) = self.steps.last_move_mut()
        {
            before.fixed.get_or_insert_with(|| relative::BEFORE.into());
        }
        self.stands = match &goal {
            Goal::Pose(pose) if blend_m == Some(0.0) && !self.spline => Stands::of(pose),
            _ => None,
        };
        let path = if self.spline { PathKind::Curve } else { word.path };
        let fixed = relative.then(|| relative::ITSELF.to_string());
        let how = How { path, fixed, closed, speed, blend_m };
        self.push(k, StepKind::Move(Move::new(how, goal, Few::new())));
        Ok(())
    }

    /// The goal, or why nobody knows where it is as the robot goes: led by a sensor, turned otherwise, holding the part.
    fn as_the_robot_goes(&mut self, goal: Goal, word: Word, tail: &[Token], turning: Turning) -> Goal {
        match goal {
            goal @ Goal::Opaque(_) => goal,
            _ if self.going.led.is_some() => {
                let by = self.going.led.unwrap_or_default();
                Goal::Opaque(format!("{by} leads the robot away from its points"))
            }
            _ if word.path != PathKind::Joint && turning == Turning::Otherwise => {
                Goal::Opaque("$ORI_TYPE: the tool does not turn to the orientation of the point".into())
            }
            _ if word.path != PathKind::Joint && self.going.holds_part(self.text, tail) => {
                Goal::Opaque("the robot holds the part (IPO_FRAME #TCP)".into())
            }
            goal => goal,
        }
    }

    /// Why no point may come before a motion; `has_via`: the point on the way of an arc is known; `copied`: its statement can be.
    fn closed(&mut self, word: Word, turning: Turning, has_via: bool, copied: bool) -> Option<String> {
        let fold = self.inline_fold();
        let in_fold = fold.is_some_and(|f| f.more || f.steps != self.steps.next());
        let reasons = [
            (word.arc && !has_via, "an arc is given by three points"),
            (
                turning == Turning::Wrist && word.path == PathKind::Linear,
                "$ORI_TYPE #JOINT: the wrist turns axis by axis on its way",
            ),
            (word.relative, relative::ITSELF),
            (self.spline, "it stands in a spline block, whose curve a further point would change"),
            (std::mem::take(&mut self.trigger), "a TRIGGER before it belongs to this very motion"),
            (!copied, "its statement cannot be copied"),
            (in_fold, "its inline form does more than this motion"),
        ];
        reasons.into_iter().find(|r| r.0).map(|r| r.1.to_string())
    }

    fn inline_fold(&self) -> Option<&Fold> {
        self.folds.last().filter(|f| f.inline)
    }

    /// Where a motion stands in the text whose goal, `goal` of the tokens, is written out.
    fn written(
        &mut self,
        k: usize,
        line: &[Token],
        goal: Range<usize>,
        word: Word,
        via: Option<Range<usize>>,
    ) -> Motion {
        let goal = line[goal.start].start..line[goal.end - 1].end;
        let last = line.last().map_or(goal.end, |t| t.end);
        let (keyword, tail) = (line[0].span(), goal.end..last);
        let fold = self.inline_fold().map(|f| f.line as u32);
        let point = std::mem::take(&mut self.point).unwrap_or_else(|| goal.clone());
        Motion {
            line: k as u32,
            keyword: keyword.into(),
            goal: goal.into(),
            point: point.into(),
            via: via.map(Span::from),
            tail: tail.into(),
            spline: word.spline,
            fold,
        }
    }

    /// The goal of a relative motion.
    fn relative(&self, line: &[Token], at: usize, word: Word, end: &mut Option<usize>) -> Goal {
        let given = line.get(at).filter(|t| t.is(b'{'));
        let given = given.and_then(|_| super::aggregate::aggregate(self.text, 0, line, at).ok());
        let goal = given.zip(self.stands.as_ref()).and_then(|((a, next), stands)| {
            *end = Some(next);
            stands.moved(self.text, word, &a, &line[next..], self.frames())
        });
        goal.map_or_else(|| Goal::Opaque(relative::UNKNOWN.into()), Goal::pose)
    }

    /// The goal of a motion at token `at`; `end`: the token after it, `others`: its external axes.
    fn goal(
        &mut self,
        k: usize,
        line: &[Token],
        at: usize,
        word: Word,
        end: &mut Option<usize>,
        others: &mut Others,
    ) -> Result<Goal> {
        Ok(match line.get(at) {
            _ if word.relative => self.relative(line, at, word, end),
            None => Goal::Opaque("the motion has no goal".into()),
            Some(_) if !word.arc && product::is(self.text, line, at) => self.product(k, line, at, word, end, others)?,
            Some(t) if t.is(b'{') => {
                let (a, next) = super::aggregate::aggregate(self.text, 0, line, at)?;
                *end = Some(next);
                *others = Some(a.others(&self.names, self.text).into());
                self.aggregate(k, a, word)?
            }
            Some(t) if t.kind == Kind::Word => {
                let (name, next) = product::name(self.text, line, at);
                *end = Some(next);
                match self.data.find(self.routine, &name) {
                    // a call, an element of an array by a computed index, a sum of frames
                    _ if !motion::ends(self.text, line, next) => Goal::Opaque("the goal is computed".into()),
                    None if name.starts_with('$') => Goal::Opaque(format!("{name} is known on the controller only")),
                    None => Goal::Opaque(format!("{name} is not declared in the files given")),
                    Some(n) => {
                        if let Ok(a) = self.data.names[n].value() {
                            *others = Some(a.others(&self.names, &self.texts[a.file]).into());
                        }
                        self.named(n, word)?
                    }
                }
            }
            Some(_) => Goal::Opaque("the goal is computed".into()),
        })
    }

    /// `P1:{X 0,Y 4,...}`, `$NULLFRAME:P[2]:F`: the numbers of one factor are edited, the others displace it.
    fn product(
        &mut self,
        k: usize,
        line: &[Token],
        at: usize,
        word: Word,
        end: &mut Option<usize>,
        others: &mut Others,
    ) -> Result<Goal> {
        let (factors, next) = match product::factors(self.text, line, at, self.data, self.routine)? {
            Ok(found) => found,
            Err(why) => return Ok(Goal::Opaque(why)),
        };
        if !motion::ends(self.text, line, next) {
            return Ok(Goal::Opaque("the goal is computed".into()));
        }
        *end = Some(next);
        *others = Some(Arc::default());
        // numbers in the motion itself belong to nobody else
        let chosen = factors.iter().position(|f| f.inline).or_else(|| factors.iter().position(|f| f.name.is_some()));
        let Some(chosen) = chosen else { return Ok(Goal::Opaque("the goal is computed".into())) };
        let factor = &factors[chosen];
        let goal = match factor.name {
            Some(n) => self.named(n, word)?,
            None => self.aggregate(k, factor.value.clone(), word)?,
        };
        let Goal::Pose(mut pose) = goal else { return Ok(Goal::Opaque("the goal is computed".into())) };
        let of = |list: &[product::Factor]| {
            list.iter().try_fold(nalgebra::Isometry3::identity(), |all, f| Some(all * f.value.isometry()?))
        };
        let (Some(before), Some(after)) = (of(&factors[..chosen]), of(&factors[chosen + 1..])) else {
            return Ok(Goal::Opaque("a part of its position is not given".into()));
        };
        // status and turn are those of the right operand, and a FRAME has none
        let (frame, tool) = self.frames();
        let last = factors.last().and_then(|f| f.value.pose(&frame, &tool, word.path, None));
        pose.solution = last.map(|p| p.solution).unwrap_or_default();
        self.point = Some(line[factor.tokens.start].start..line[factor.tokens.end - 1].end);
        Ok(Goal::pose(pose.shifted(Shift { before, after })))
    }

    /// Speed and approximation of a motion, by the settings in force and the words after its goal.
    fn speed_and_blend(&self, word: Word, tail: &[Token]) -> (Speed, Option<f64>) {
        let tail: Vec<String> = tail.iter().map(|t| upper(self.text, t)).collect();
        let has = |w: &str| tail.iter().any(|t| t == w);
        let blend_m = if !tail.iter().any(|t| t.starts_with("C_")) {
            Some(0.0)
        } else if word.path != PathKind::Joint && has("C_DIS") {
            self.set.apo_m
        } else {
            None
        };
        let speed = match word.path {
            _ if has("WITH") => Speed::Unknown,
            PathKind::Joint => self.set.share().map_or(Speed::Unknown, |v| Speed::Share(v / 100.0)),
            _ => self.set.vel_cp.map_or(Speed::Unknown, Speed::Tcp),
        };
        (speed, blend_m)
    }

    /// Frame and tool in force. What no line sets has the controller's name: the frame in which the program starts.
    fn frames(&self) -> (Frame, Frame) {
        let or = |set: &Option<Frame>, name: &str| set.clone().unwrap_or_else(|| Frame::Named(name.into()));
        (or(&self.set.base, "$BASE"), or(&self.set.tool, "$TOOL"))
    }

    /// A Cartesian goal, with a target for its numbers.
    fn pose(&mut self, a: &Aggregate, word: Word, name: Option<String>, at: At, source: Source) -> Option<PoseGoal> {
        let (frame, tool) = self.frames();
        let target = a.coordinates().map(|values| {
            self.targets.push(Target { pose: Some(PoseForm::EulerZyx), name, at, values });
            self.sources.push(source);
            self.targets.len() - 1
        });
        a.pose(&frame, &tool, word.path, target)
    }

    /// The goal that a motion gives in line.
    fn aggregate(&mut self, k: usize, a: Aggregate, word: Word) -> Result<Goal> {
        if a.has_axes() {
            return Ok(match target(self.axes, self.text, &a, None, At { file: 0, line: k as u64 + 1 }, word)? {
                Err(why) => Goal::Opaque(why),
                Ok(target) => {
                    self.targets.push(target);
                    self.sources.push(Source::Inline(a.file as u16, a.span.into()));
                    Goal::Joints(self.targets.len() - 1)
                }
            });
        }
        let at = At { file: 0, line: k as u64 + 1 };
        let pose = self.pose(&a, word, None, at, Source::Inline(a.file as u16, a.span.clone().into()));
        Ok(pose.map_or_else(|| Goal::Opaque("a part of its position is not given".into()), Goal::pose))
    }

    /// Position of the point on the way of an arc, m.
    fn via(&self, line: &[Token]) -> Option<Vector3<f64>> {
        let t = line.get(1)?;
        let of = |a: &Aggregate| {
            let at = |name: &str| a.component(name).and_then(|c| c.value.as_ref()).map(|v| v.1 * 1e-3);
            Some(Vector3::new(at("X")?, at("Y")?, at("Z")?))
        };
        if t.is(b'{') {
            let (point, next) = super::aggregate::aggregate(self.text, 0, line, 1).ok()?;
            // a product of frames goes on after the aggregate
            return line.get(next).filter(|t| t.is(b',')).and_then(|_| of(&point));
        }
        let (name, next) = product::name(self.text, line, 1);
        let comma = t.kind == Kind::Word && line.get(next).is_some_and(|t| t.is(b','));
        let n = self.data.find(self.routine, &name).filter(|_| comma)?;
        of(self.data.names[n].value().ok()?)
    }

    /// The bytes of the point on the way of an arc that several arcs may take the place of: a CIRC of its own, whose orientation
    /// nothing in the program steers. An inline form couples its point on the way, and a spline its neighbours.
    fn via_of_splittable(&self, line: &[Token], at: usize, word: Word, goal: &Goal) -> Option<Range<usize>> {
        let Goal::Pose(pose) = goal else { return None };
        let plain = word.arc && !word.spline && !self.spline && self.folds.is_empty() && !self.steers_arcs;
        let (first, last) = (line.get(1)?, line.get(at.checked_sub(2)?)?);
        (plain && pose.via_m.is_some() && pose.target.is_some() && pose.rotation.is_some())
            .then_some(first.start..last.end)
    }

    /// Says where the values of a point of another module come from.
    fn elsewhere(&mut self, n: usize) {
        let name = &self.data.names[n];
        if name.context {
            let file = self.texts.get(name.file).map_or("", |t| t.name.as_str());
            let text = format!("the values of {} are those of another module ({file}:{})", name.text, name.line + 1);
            self.notes.push(Note { place: At { file: name.file, line: name.line as u64 + 1 }, text });
        }
    }

    /// The goal that a name gives.
    fn named(&mut self, n: usize, word: Word) -> Result<Goal> {
        let name = &self.data.names[n];
        let a = match name.value() {
            Ok(a) => a,
            Err(why) => return Ok(Goal::Opaque(why)),
        };
        if name.holds == Holds::Pose {
            let (a, text) = (a.clone(), name.text.clone());
            let (frame, tool) = self.frames();
            let pose = match self.of_name.get(&n).copied() {
                Some(t) => a.pose(&frame, &tool, word.path, Some(t)),
                None => {
                    let line = name
                        .given
                        .as_ref()
                        .map_or_else(|| name.assigned.first().map_or(name.line, |a| a.line), |_| name.line);
                    let at = At { file: a.file, line: line as u64 + 1 };
                    let pose = self.pose(&a, word, Some(text.clone()), at, Source::Name(n as u32));
                    if let Some(t) = pose.as_ref().and_then(|p| p.target) {
                        self.of_name.insert(n, t);
                        self.elsewhere(n);
                    }
                    pose
                }
            };
            return Ok(pose.map_or_else(|| Goal::Opaque(format!("a part of {text} is not given")), Goal::pose));
        }
        if let (Some(&t), true) = (self.of_name.get(&n), word.path == PathKind::Joint) {
            return Ok(Goal::Joints(t));
        }
        let line = if name.given.is_some() { name.line } else { name.assigned.first().map_or(name.line, |a| a.line) };
        let at = At { file: a.file, line: line as u64 + 1 };
        Ok(match target(self.axes, &self.texts[a.file], a, Some(name.text.clone()), at, word)? {
            Err(why) => Goal::Opaque(why),
            Ok(target) => {
                self.targets.push(target);
                self.sources.push(Source::Name(n as u32));
                self.of_name.insert(n, self.targets.len() - 1);
                self.elsewhere(n);
                Goal::Joints(self.targets.len() - 1)
            }
        })
    }
}

/// Whether a list goes on after the token `at`.
fn has_more_after(line: &[Token], at: usize) -> bool {
    line.iter().any(|t| t.kind == Kind::Mark(b',') && t.start > line[at.min(line.len() - 1)].end)
}
