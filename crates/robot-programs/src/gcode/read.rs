//! Modal state, positions, steps.
//!
//! A position is known as long as every word since it was is known. Whatever lets it slip (a call, a label, a block that cannot be
//! determined) ends what is known, and with it what relative words lead to. Before such a place, and before a G92, the last move must
//! end where it always ended where relative words led to it, or the difference would stay in all that follows (and add up in
//! a loop): it is fixed.

use super::alike::Alike;
use super::assignments::Assignments;
use super::lex::{self, Block};
use super::survey::{AXES, Survey, assignments_of, code_text, flow_hides, is_flow};
use super::variables::Variables;
use super::{Program, Statement, Statements};
use crate::axes::Axes;
use crate::error::{Error, Result};
use crate::script::lex::not_too_long;
use crate::script::{At, Break, Goal, Note, Script, Step, StepKind, Targets, Text, Value, pragma};
use std::sync::Arc as Shared;

/// Reads a program.
pub(super) fn program(texts: Vec<Text>, robot: &Axes) -> Result<Program> {
    let Some(text) = texts.first() else {
        return Err(Error::bad(crate::error::Place::file(""), "no text", "a G-code program"));
    };
    not_too_long(text)?;
    let letters = letters(text, robot)?;
    let mut survey = Survey::of(text)?;
    let missing = missing_modes(&survey, robot);
    survey.codes.extend(robot.control.codes());
    let mut reader = Reader::new(text, robot, &letters, survey);
    reader.step(0, StepKind::Break(Break::Start), None);
    for k in 0..text.line_count() {
        if !reader.again(k) {
            reader.block(k)?;
        }
    }
    reader.lose("the end of the program");
    let mixed = reader.survey.mixed();
    let Reader { mut script, statements, .. } = reader;
    let si = robot.axis_joints().map(|j| j.kind.si_per_user_unit()).collect();
    script.texts = texts;
    // without a move nothing depends on them
    if script.moves().next().is_some() {
        script.missing = missing;
    }
    Ok(Program { script, statements, letters, si, mixed })
}

/// Whether a line names variables in which a control keeps places: `#5041`, `#<_x>`, or a computed one.
///
/// `place = "#" ("<_" ... | "5" digit ... | "[" ...)`
fn reads_places(line: &[u8]) -> bool {
    (0..line.len()).filter(|&at| line[at] == b'#').any(|at| {
        let rest = &line[at + 1..];
        rest.starts_with(b"<_") || matches!(rest, [b'5', b, ..] if b.is_ascii_digit()) || rest.starts_with(b"[")
    })
}

/// The letter of each axis; 0 where its name is no word of G-code.
fn letters(text: &Text, robot: &Axes) -> Result<Vec<u8>> {
    let letters: Vec<u8> = robot
        .axis_joints()
        .map(|j| match j.name.as_bytes() {
            [b] if AXES.contains(&b.to_ascii_uppercase()) => b.to_ascii_uppercase(),
            _ => 0,
        })
        .collect();
    if letters.iter().all(|&l| l == 0) {
        return Err(text.bad(
            0,
            format!("G-code for a robot with the axes {}", robot.axis_names().join(", ")),
            "axes named as G-code words: X, Y, Z, A, B, C, U, V, W",
        ));
    }
    Ok(letters)
}

/// Modes that neither the program nor the robot file gives.
fn missing_modes(survey: &Survey, robot: &Axes) -> Vec<&'static str> {
    let given = |codes: [u32; 2]| codes.iter().any(|c| survey.codes.contains(c));
    let mut missing = Vec::new();
    if robot.control.absolute.is_none() && !given([900, 910]) {
        missing.push("G90 or G91");
    }
    if robot.control.inch.is_none() && !given([200, 210]) {
        missing.push("G20 or G21");
    }
    missing
}

pub(super) struct Reader<'a> {
    pub(super) text: &'a Text,
    pub(super) robot: &'a Axes,
    pub(super) letters: &'a [u8],
    pub(super) survey: Survey,
    pub(super) variables: Variables,
    /// An expression was folded.
    has_folded: bool,
    /// It was said in which frame positions are taken.
    pub(super) has_noted: bool,
    pub(super) script: Script,
    pub(super) statements: Statements,
    /// Times ten; canned cycles too.
    pub(super) motion: Option<u32>,
    pub(super) absolute: Option<bool>,
    pub(super) inch: Option<bool>,
    /// Letters of the plane's axes and of the third.
    pub(super) plane: Option<[u8; 3]>,
    pub(super) centre_absolute: bool,
    pub(super) feed_mode: u32,
    pub(super) feed: Option<f64>,
    pub(super) exact: bool,
    /// Cutter compensation that is, or may be, on.
    pub(super) compensation: Option<String>,
    /// A code after which words mean something else.
    pub(super) strange: Option<String>,
    /// A macro that each block runs, or may.
    pub(super) modal_macro: Option<String>,
    pub(super) frame: Option<u32>,
    pub(super) reference: Option<u32>,
    pub(super) lost_frame: bool,
    /// G52, by axis, mm or deg.
    pub(super) local: Vec<f64>,
    /// By axis: unit of a word and what is added to it, of the last motion.
    pub(super) units: Shared<[f64]>,
    pub(super) shifts: Shared<[f64]>,
    /// G92, by axis; `None`: not known.
    pub(super) moved: Vec<Option<f64>>,
    /// Tool length compensation, and the one under which the first Z word stood.
    pub(super) length: String,
    pub(super) length_reference: Option<String>,
    /// By axis, mm or deg.
    pub(super) position: Vec<Option<f64>>,
    /// By axis: weight of the last digit with which it was written, rad or m.
    pub(super) digit: Vec<f64>,
    /// A relative move was made since the position is known. Not asked by axis: an edit may add a word.
    pub(super) relative: bool,
    /// The last move since the position is known.
    pub(super) last: Option<usize>,
    /// What lines may be like.
    pub(super) alike: Alike,
}

impl<'a> Reader<'a> {
    /// The state in which a control begins a program.
    fn new(text: &'a Text, robot: &'a Axes, letters: &'a [u8], survey: Survey) -> Self {
        let dof = robot.dof();
        Self {
            text,
            robot,
            letters,
            survey,
            variables: Variables::of(text),
            has_folded: false,
            has_noted: false,
            script: Script {
                steps: Vec::with_capacity(text.likely_steps()),
                targets: Targets::of_text(text),
                ..Script::default()
            },
            statements: Statements::of_text(text, robot.dof()),
            motion: None,
            absolute: robot.control.absolute,
            inch: robot.control.inch,
            plane: Some([b'X', b'Y', b'Z']),
            centre_absolute: false,
            feed_mode: 94,
            feed: None,
            exact: false,
            compensation: None,
            strange: None,
            modal_macro: None,
            frame: None,
            reference: None,
            lost_frame: false,
            local: vec![0.0; dof],
            units: Shared::default(),
            shifts: Shared::default(),
            moved: vec![Some(0.0); dof],
            length: "G49".into(),
            length_reference: None,
            position: vec![None; dof],
            digit: vec![0.0; dof],
            relative: false,
            last: None,
            alike: Alike::default(),
        }
    }
}

impl Reader<'_> {
    pub(super) fn step(&mut self, k: usize, kind: StepKind, statement: Option<Statement>) {
        let step = Step::following(self.script.steps.last(), At { file: 0, line: k as u64 + 1 }, kind);
        self.script.steps.push(step);
        if let Some(statement) = statement {
            self.statements.push(self.script.steps.len() - 1, statement);
        }
    }

    /// Nothing is known of the position any more.
    pub(super) fn lose(&mut self, why: &str) {
        if self.absolute != Some(true) || self.relative {
            self.anchor(why);
        }
        self.last = None;
        self.position.fill(None);
        self.relative = false;
    }

    /// The last move must end where it always did, on every axis.
    pub(super) fn anchor(&mut self, why: &str) {
        let Some(step) = self.last else { return };
        let Some(StepKind::Move(m)) = self.script.steps.get_mut(step).map(|s| &mut s.kind) else { return };
        m.fixed.get_or_insert_with(|| format!("a change would stay in all that follows {why}"));
        let Goal::Joints(t) = m.goal else { return };
        let Some(s) = self.statements.get(step, self.text, self.letters) else { return };
        // axes without a word may need one, to take back what was changed before
        let at = s.words.last().map_or(0, |w| w.span().end);
        for (a, &goal) in s.goal.iter().enumerate() {
            if let (Some(goal), None) = (goal, self.script.targets.get(t).and_then(|t| t.values.get(a))) {
                let (si, digit) = (goal * self.robot.axis(a).kind.si_per_user_unit(), self.digit[a]);
                let value = Value { si, start: at, end: at, style: Default::default(), digit, finest: digit };
                self.script.targets.set(t, a, Some(value));
            }
        }
    }

    pub(super) fn end(&mut self, k: usize, kind: Break, why: &str) {
        self.lose(why);
        self.step(k, StepKind::Break(kind), None);
    }

    /// Control may come from elsewhere: only what the whole text never changes is still certain.
    pub(super) fn join(&mut self, k: usize, kind: Break) {
        self.end(k, kind, if kind == Break::Call { "a call" } else { "a label, jump or loop" });
        self.motion = None;
        if matches!(kind, Break::Start | Break::Call) {
            self.variables.forget();
        } else {
            self.variables.join();
        }
        if !self.survey.single(&[900, 910]) {
            self.absolute = None;
        }
        if !self.survey.single(&[200, 210]) {
            self.inch = None;
        }
        if !self.survey.single(&[170, 180, 190]) {
            self.plane = None;
        }
        self.feed = None;
        self.lost_frame |= self.survey.frames();
        if [410, 420, 411, 421].iter().any(|c| self.survey.codes.contains(c)) {
            self.compensation = Some("G41 or G42 may be on".into());
        }
        self.may_be_strange();
        if [430, 431, 440].iter().any(|c| self.survey.codes.contains(c)) && self.length_reference.is_some() {
            self.length = "unknown".into();
        }
    }

    /// Something outside of this text runs: no mode is certain.
    pub(super) fn call(&mut self, k: usize) {
        if self.survey.whole {
            // what runs stands in this text
            return self.join(k, Break::Call);
        }
        self.end(k, Break::Call, "a call");
        self.variables.forget();
        self.may_be_strange();
        self.forget_modes("modes after a call are not known");
    }

    /// What the text sets somewhere may be in force where control comes from elsewhere.
    fn may_be_strange(&mut self) {
        if self.strange.is_none() && self.survey.hidden {
            self.strange = Some("a line of the program does what is not followed".into());
        }
        if let (None, Some(c)) = (&self.strange, self.survey.unfollowed) {
            self.strange = Some(format!("{} may be on", code_text(c)));
        }
        if self.strange.is_none() && self.survey.mirrors {
            self.strange = Some("M21 or M22 may be on, which mirror an axis on older controls".into());
        }
        // centres of arcs, and feeds, that another way there may take otherwise
        for (set, words) in [(&[901, 911][..], "the centres of arcs"), (&[930, 940, 950], "the feed")] {
            let other = set[0];
            if self.strange.is_none() && self.survey.codes.contains(&other) {
                self.strange = Some(format!("{} may be on, by which {words} count otherwise", code_text(other)));
            }
        }
        if self.survey.macros > 0 {
            self.modal_macro = Some("G66 may be on: a block may run a macro".into());
        }
    }

    /// No mode is certain.
    pub(super) fn forget_modes(&mut self, why: &str) {
        self.motion = None;
        self.absolute = None;
        self.inch = None;
        self.plane = None;
        self.feed = None;
        self.lost_frame = true;
        self.compensation.get_or_insert_with(|| format!("{why} (G40)"));
    }

    /// What words mean, to be compared.
    pub(super) fn modes(&self) -> String {
        let words = (self.motion, self.absolute, self.inch, self.plane, self.centre_absolute, self.feed_mode);
        let frames = (self.frame, self.lost_frame, &self.local, &self.moved, &self.length);
        let doubts = (&self.strange, &self.modal_macro, &self.compensation, self.exact);
        format!("{words:?} {frames:?} {doubts:?}")
    }

    /// What a line assigns, and what it may do besides.
    fn assign(&mut self, k: usize, found: &Assignments) {
        // a place that is read, and a frame that may be set from it, would keep a change
        if found.hidden || found.frame || found.any || reads_places(self.text.line(k)) {
            self.anchor("a line that may read where the machine stands");
        }
        self.variables.assign(self.text.line(k), found);
        if found.hidden {
            self.strange = Some(format!("line {} assigns, and does what is not followed", k + 1));
            self.end(k, Break::Call, "a line that is not followed");
            self.forget_modes("modes after a line that is not followed are not known");
        } else if found.frame || found.any {
            self.end(k, Break::Frame, "an assignment that may move a frame");
            self.lost_frame |= self.reference.is_some();
        } else if found.signal {
            self.end(k, Break::Call, "a signal that may move the machine");
            self.motion = None;
        }
    }

    /// `block = "%" | flow | keyword ... | assignment | ["N" number] {word}`
    pub(super) fn block(&mut self, k: usize) -> Result<()> {
        let block = lex::block(self.text, k)?;
        for comment in &block.comments {
            if let Some(on) = pragma(self.text.slice(comment.clone())) {
                self.step(k, StepKind::Pragma(on), None);
            }
        }
        if block.percent {
            self.end(k, Break::Start, "the tape's end");
            return Ok(());
        }
        let assigned = assignments_of(self.text, k, &block);
        if let Some(flow) = &block.flow {
            match flow.as_str() {
                "" | "SUB" | "ENDSUB" | "RETURN" => self.join(k, Break::Start),
                "IF" | "ELSEIF" | "ELSE" | "ENDIF" => self.join(k, Break::Jump),
                "WHILE" | "ENDWHILE" | "DO" | "REPEAT" | "ENDREPEAT" | "BREAK" | "CONTINUE" => {
                    self.join(k, Break::Loop)
                }
                _ => self.call(k),
            }
            if flow_hides(self.text, k, &block) {
                self.assign(k, &Assignments { hidden: true, ..Assignments::default() });
            }
        }
        if let Some(keyword) = &block.keyword {
            match keyword.as_str() {
                "WHILE" | "DO" | "END" => self.join(k, Break::Loop),
                w if is_flow(w) => self.join(k, Break::Jump),
                // `M117 Printing`, `M0 Clean the nozzle`: a message
                _ if block.words.iter().any(lex::takes_text) => return self.words(k, block),
                _ => self.call(k),
            }
            if flow_hides(self.text, k, &block) {
                self.assign(k, &Assignments { hidden: true, ..assigned.clone().unwrap_or_default() });
            } else if let Some(found) = &assigned {
                self.assign(k, found);
            }
            return Ok(());
        }
        if self.survey.jumps && block.words.first().is_some_and(|w| w.letter == b'N') {
            self.join(k, Break::Jump);
        }
        if let Some(found) = &assigned {
            self.assign(k, found);
        }
        if block.assignment {
            // `#1` and no `=`
            if assigned.is_none() {
                self.assign(k, &Assignments { hidden: true, ..Assignments::default() });
            }
            return Ok(());
        }
        let block = self.folded(k, block);
        self.words(k, block)
    }

    /// A block whose computed numbers have the values that they certainly have.
    fn folded(&mut self, k: usize, mut block: Block) -> Block {
        let geometry = |w: &&mut lex::Word| AXES.contains(&w.letter) || b"IJKRF".contains(&w.letter);
        for w in block.words.iter_mut().filter(geometry).filter(|w| w.value.is_none()) {
            w.value = self.variables.fold(self.text.slice(w.number()));
            block.folded |= w.value.is_some();
            if w.value.is_some() && !self.has_folded {
                self.has_folded = true;
                let text = "expressions are folded where their value is certain: a word that is changed holds a number from then on";
                self.script.notes.push(Note { place: At { file: 0, line: k as u64 + 1 }, text: text.into() });
            }
        }
        block
    }

    /// Literal number of a letter.
    pub(super) fn number(block: &Block, letter: u8) -> Option<f64> {
        block.words.iter().find(|w| w.letter == letter).and_then(|w| w.value).map(|v| v.0)
    }

    /// `G4 P500`: seconds where that is certain.
    ///
    /// `dwell = "G4" (("X" | "U" | "S" | "P") number)`
    pub(super) fn dwell(&mut self, k: usize, block: &Block) {
        let literal = |letters: &[u8]| block.words.iter().find(|w| letters.contains(&w.letter)).and_then(|w| w.value);
        let seconds = match (literal(b"XUS"), literal(b"P")) {
            (Some((s, _)), _) => Some(s),
            // without a point it is milliseconds on some controls and seconds on others
            (None, Some((s, style))) if style.point => Some(s),
            _ => None,
        };
        self.step(k, StepKind::Dwell(seconds.filter(|s| *s >= 0.0)), None);
    }
}
