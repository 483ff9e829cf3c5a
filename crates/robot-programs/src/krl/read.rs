//! A program's text into its script, line by line.
//!
//! Read this file first: the reader, folds, and which line is what. Then [`ahead`]: what the whole text tells; [`moves`]: motions;
//! [`goals`]: where they lead; [`absolute`]: which of those that are not known count from nowhere; [`flow`]: blocks, jumps and calls;
//! [`in_force`]: which base and tool they leave; [`last`]: which motions end where the place is read; [`partial`]: before which calls
//! it is kept in parts; [`triggers`]: where the place is read on the way;
//! [`scan`]: what each line means for base and tool; [`versions`]: frames that the program computes; [`alike`]: motions that differ in
//! their axis values alone, read once.

mod absolute;
mod ahead;
mod alike;
mod computed;
mod flow;
mod goals;
mod in_force;
mod last;
mod moves;
mod partial;
mod scan;
mod triggers;
mod versions;

use super::calls::{arc, calls};
use super::carried::carried;
use super::data::Data;
use super::form;
use super::frame::number;
use super::going::Going;
use super::led::Led;
use super::lex::{Kind, Token, in_upper, tokens, upper};
use super::machine::installed;
use super::motion;
use super::outside::Outside;
use super::program::{Program, Source};
use super::reason::{MovesBase, Reason};
use super::relative::{self, Stands};
use super::settings::{self, Settings};
use super::stance::stance;
use super::statement::{assignment, is_label, is_routine, routine_name};
use super::still::Still;
use super::target::{Others, Site, axis_names, external_axes};
use crate::axes::{Axes, JointKind};
use crate::error::{Error, Place, Result};
use crate::no_motion::NoMotion;
use crate::script::blocks::Steps;
use crate::script::called::{self, NamedCalls};
use crate::script::held::Effects;
use crate::script::lex::not_too_long;
use crate::script::pose::Frame;
use crate::script::{self, At, Break, Goal, Note, Script, Solution, Step, StepKind, Targets, Text, pragma};
use ahead::{Ahead, changed_frame_data, steers_arcs};
use alike::Alike;
use computed::{Around, Computed};
use flow::Block;
use in_force::Force;
use std::collections::{BTreeMap, BTreeSet};
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
    data.carried = carried(&texts, &robot.carried_bases);
    let axes: Vec<(String, JointKind)> =
        axis_names(robot).into_iter().zip(robot.axis_joints().map(|j| j.kind)).collect();
    let mut reader = Reader::new(&texts, &data, &axes, &robot.no_motion);
    reader.lines()?;
    let by = "the files of the project";
    reader.notes.extend(called::note(&reader.met, "routine", [by, by]));
    let strikes = std::mem::take(&mut reader.strikes);
    let own = strikes.into_iter().filter(|(name, _)| reader.defined.contains(name));
    reader.notes.extend(own.map(|(name, line)| called::strikes(At { file: 0, line }, &name)).collect::<Vec<_>>());
    let Reader { steps, others, targets, sources, notes, counted_calls, jumps, named_calls, .. } = reader;
    let mut script = Script { notes, ..Script::default() };
    named_calls.report_to(&mut script);
    let mut notes = std::mem::take(&mut script.notes);
    notes.extend(super::list_end::notes(&texts));
    let sites = steps.finish(&mut script);
    script.keep_before_relative(&Reason::BeforeRelative.into(), &counted_calls, jumps);
    script.keep_read(&script::Reason::EndIsRead, &last::lines(&texts, &data, &robot.no_motion, &script));
    script.keep_read(&Reason::BeforePartial.into(), &last::before_partial(&texts, &data, &robot.no_motion, &script));
    let mut steps = std::mem::take(&mut script.steps);
    external_axes(&mut steps, &sites, &others);
    let motions = sites.filter_map(|site| site.motion);
    if no_list(&texts, &data) && targets.is_empty() && motions.values().next().is_some() {
        let text = "no data list (.dat) was found beside the program, and no point is declared in it".to_string();
        notes.push(Note { place: At { file: 0, line: 1 }, text });
    }
    close_without_axes(&mut steps, &targets);
    let named = axes;
    let (axes, kinds) = named.iter().cloned().unzip();
    let without = |s: &Step| matches!(&s.kind, StepKind::Move(m) if matches!(&m.goal, Goal::Pose(p) if p.solution == Solution::Same));
    // only where nothing in the program itself tells the arm's configuration
    let asks = targets.iter().all(|t| t.pose.is_some()) && steps.iter().any(without);
    let stance = asks.then(|| stance(&texts, &data, &named)).flatten();
    let installed = installed(&texts, robot);
    let script = Script { steps, targets, notes, stance, installed, ..script };
    let mut program = Program { script, kinds, axes, motions, data, sources };
    program.script.starts_anywhere |= Outside::calls_start(&texts);
    program.script.texts = texts;
    Ok(program)
}

/// Whether the program has no data list and declares no point itself.
fn no_list(texts: &[Text], data: &Data) -> bool {
    texts.iter().filter(|t| !t.context).count() == 1 && data.names.is_empty()
}

/// Closes the motions of a program without axis values to new points: a new point would have no axis to name.
fn close_without_axes(steps: &mut [Step], targets: &Targets) {
    if !targets.iter().filter(|t| t.pose.is_none()).all(|t| t.values.iter().all(|v| v.is_none())) {
        return;
    }
    for step in steps {
        if let StepKind::Move(m) = &mut step.kind
            && !matches!(m.goal, Goal::Pose(_))
        {
            m.closed.get_or_insert_with(|| Reason::NoAxisValues.into());
        }
    }
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

struct Fold {
    line: usize,
    inline: bool,
    /// Steps before it.
    steps: usize,
    /// Something stands in it that is no setting of the form.
    more: bool,
}

struct Reader<'a> {
    texts: &'a [Text],
    text: &'a Text,
    data: &'a Data,
    /// What holds where control comes from elsewhere.
    ahead: Ahead,
    /// Which base and tool may be in force after each line.
    force: Force,
    axes: &'a [(String, JointKind)],
    names: Vec<String>,
    steps: Steps<Site>,
    /// One for all motions after each other that have the same.
    others: Vec<Others>,
    blocks: Vec<Block>,
    /// Where the robot stands after the last motion, where that ends exactly at a known point.
    stands: Option<Stands>,
    /// Routines that move nothing, and those of them that were met.
    still: Still,
    met: BTreeMap<String, u64>,
    named_calls: NamedCalls,
    targets: Targets,
    sources: Vec<Source>,
    /// Target of each name of the data.
    of_name: Vec<Option<u32>>,
    notes: Vec<Note>,
    /// Routines that interrupts call and which may move, with the line of the first; routines of this text.
    strikes: BTreeMap<String, u64>,
    defined: BTreeSet<String>,
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
    /// Frames that a motion sets for itself, and a spline block for its motions: base and tool.
    with: [Option<Frame>; 2],
    of_block: [Option<Frame>; 2],
    /// Statements that have set anything that holds for the motions after them.
    settings_made: usize,
    /// The factor of a product whose numbers are edited, of the goal that was read last.
    point: Option<Range<usize>>,
    /// Points that the program computes.
    computed: Computed<'a>,
    /// Why the numbers of the goal that was read last must stay.
    fixed: Option<script::Reason>,
}

impl<'a> Reader<'a> {
    fn new(texts: &'a [Text], data: &'a Data, axes: &'a [(String, JointKind)], declared: &NoMotion) -> Self {
        let going = Going::of(texts);
        let outside = Outside::of(texts, &going);
        let ahead = Ahead::of(&texts[0], data, &going, &outside);
        let still = Still::of(texts, declared);
        let around = Around { data, going: &going, outside: &outside, still: &still, lists: &ahead.lists };
        let computed = Computed::of(texts, around);
        Self {
            force: Force::of(&texts[0], data, &going, &outside, &still, &ahead.lists),
            ahead,
            texts,
            text: &texts[0],
            data,
            axes,
            names: axes.iter().map(|a| a.0.clone()).collect(),
            steps: Steps::of_text(&texts[0]),
            others: Vec::new(),
            blocks: Vec::new(),
            stands: None,
            still,
            met: BTreeMap::new(),
            named_calls: NamedCalls::default(),
            targets: Targets::of_text(&texts[0]),
            sources: Vec::with_capacity(texts[0].likely_steps()),
            of_name: vec![None; data.names.len()],
            notes: Vec::new(),
            strikes: BTreeMap::new(),
            defined: BTreeSet::new(),
            routine: 0,
            folds: Vec::new(),
            steers_arcs: texts.iter().filter(|t| !t.context).any(steers_arcs),
            trigger: false,
            spline: false,
            set: Settings::default(),
            going,
            led: Led::of(&texts[0], &Effects::of(&outside.events), outside.switches),
            counting: relative::routines(texts),
            counted_calls: BTreeSet::new(),
            jumps: false,
            with: [None, None],
            of_block: [None, None],
            settings_made: 0,
            point: None,
            computed,
            fixed: None,
        }
    }

    /// All lines of the text; those that are like the one before are not read again.
    fn lines(&mut self) -> Result<()> {
        let (mut line, mut alike) = (Vec::new(), Alike::default());
        for k in 0..self.text.line_count() {
            if !alike.again(self, k) {
                tokens(self.text, k, &mut line);
                let seen = alike.before(self);
                self.line(k, &line)?;
                alike.learn(self, k, &line, seen);
            }
        }
        Ok(())
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
        if self.force.changes_frames(k) {
            self.stop(k, Break::Frame);
        }
        if let Some(turning) = self.going.turning(self.text, line, &word) {
            self.set.turns(turning, &*word == "LDAT_ACT");
            self.settings_made += 1;
        }
        Ok(())
    }

    /// A statement that is no motion: a routine, a label, a jump, a wait, a process, a declaration, a call.
    ///
    /// `other_statement = routine | label | flow | "WAIT" ["SEC" number] | "HALT" | declaration | other`
    fn other_statement(&mut self, k: usize, line: &[Token], word: &str, second: &str) {
        if is_routine(word, second) {
            self.routine += 1;
            (self.spline, self.trigger) = (false, false);
            self.of_block = [None, None];
            self.folds.clear();
            self.blocks.clear();
            self.steps.start();
            let name = routine_name(self.text, line);
            self.defined.insert(name.clone());
            self.steps.routine(self.routine, name);
            // the first routine is the program, and others see those that are GLOBAL
            self.steps.all_calls_are_here(word == "DEF" && self.routine > 1);
            return self.stop(k, Break::Start);
        }
        if is_label(line) {
            return self.label(k, word);
        }
        if self.flow(k, line, word, second) {
            return;
        }
        match word {
            "WAIT" => {
                let seconds = (second == "SEC").then(|| number(self.text, line.get(2..).unwrap_or_default())).flatten();
                self.push(k, StepKind::Dwell(seconds.filter(|s| *s >= 0.0)));
                self.called(k, line);
            }
            "HALT" => self.push(k, StepKind::Dwell(None)),
            // an action at a place of the next motion; what it calls runs beside the program and may not move the robot
            "TRIGGER" => {
                self.trigger = true;
                calls(self.text, line).into_iter().for_each(|name| self.steps.called_otherwise(name));
            }
            "STOP" if second == "WHEN" => {
                self.trigger = true;
                self.stop(k, Break::Interrupt);
            }
            "CONST_VEL" => self.trigger = true,
            "SPLINE" | "PTP_SPLINE" => {
                self.spline = true;
                self.of_block = self.with_of(k, line);
            }
            "ENDSPLINE" => (self.spline, self.of_block) = (false, [None, None]),
            "DECL" | "GLOBAL" | "CONST" | "INT" | "REAL" | "BOOL" | "CHAR" | "E6AXIS" | "AXIS" | "E6POS" | "POS"
            | "FRAME" | "FDAT" | "PDAT" | "LDAT" | "ANOUT" | "ANIN" | "DIGIN" | "CCLOSE" => self.called(k, line),
            "STRUC" | "ENUM" | "SIGNAL" | "EXT" | "EXTP" | "EXTFCT" | "IMPORT" | "CONTINUE" | "ON_ERROR_PROCEED" => {}
            "BAS" => {
                self.stands = None;
                self.set.bas(self.text, line, self.data);
                self.settings_made += 1;
                self.frames_by_name(k);
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
        self.settings_made += usize::from(settings::is_setting(word));
        self.frames_by_name(k);
        if word == "FDAT_ACT" && self.going.holds_part(self.text, &line[1..]) {
            self.set.carried = Some(MovesBase::HoldsPart);
        }
    }
}
