//! Modal state, positions, steps.
//!
//! A position is known as long as every word since it was is known. Whatever lets it slip (a call, a label, a block that cannot be
//! told) ends what is known, and with it what relative words lead to. Before such a place, and before a G92, the last move must
//! end where it always ended where relative words led to it, or the difference would stay in all that follows (and add up in
//! a loop): it is fixed.

use super::goal::opaque;
use super::lex::{self, Block, Word};
use super::survey::{AXES, Survey, code, code_text, has_axes, homes, work_frame};
use super::{Program, Statement};
use crate::axes::Axes;
use crate::error::{Error, Result};
use crate::script::{At, Break, Goal, Script, Step, StepKind, Text, Value, pragma};

/// G words without effect on where a block leads, times ten.
const HARMLESS: &[u32] = &[80, 131, 150, 281, 301, 690, 960, 970, 980, 990, 1130, 1870];
/// Splines and parabolas, modal as G1 is.
pub(super) const SPLINES: &[u32] = &[50, 51, 52, 53, 60, 61, 62, 63];
/// Canned cycles.
const CANNED: &[u32] = &[730, 740, 760, 810, 820, 830, 840, 850, 860, 870, 880, 890];
/// M words that leave the machine where it is.
const STILL_M: &[u32] =
    &[7, 8, 9, 10, 11, 19, 48, 49, 50, 51, 52, 53, 67, 68, 104, 106, 107, 140, 82, 83, 84, 117, 118];
/// M words of printer firmware that leave the machine where it is, besides M862.1 and its like.
const STILL_PRINTER: &[u32] = &[
    73, 105, 108, 109, 111, 115, 141, 142, 155, 190, 191, 200, 201, 203, 204, 205, 207, 208, 209, 220, 221, 300, 301,
    302, 304, 400, 413, 486, 555, 566, 569, 572, 593, 900, 906, 907, 913, 914,
];
/// G words by which printers probe their bed; G80 is one of them on some.
const PROBES: &[u32] = &[290, 320, 340, 800];

/// Reads a program.
pub(super) fn program(texts: Vec<Text>, robot: &Axes) -> Result<Program> {
    let Some(text) = texts.first() else {
        return Err(Error::bad(crate::error::Place::file(""), "no text", "a G-code program"));
    };
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
    let mut survey = Survey::of(text)?;
    let said = |codes: [u32; 2]| codes.iter().any(|c| survey.codes.contains(c));
    let mut missing = Vec::new();
    if robot.control.absolute.is_none() && !said([900, 910]) {
        missing.push("G90 or G91");
    }
    if robot.control.inch.is_none() && !said([200, 210]) {
        missing.push("G20 or G21");
    }
    survey.codes.extend(robot.control.codes());
    let dof = robot.dof();
    let mut reader = Reader {
        text,
        robot,
        letters: &letters,
        survey,
        script: Script::default(),
        statements: Vec::new(),
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
        frame: None,
        reference: None,
        lost_frame: false,
        local: vec![0.0; dof],
        moved: vec![Some(0.0); dof],
        length: "G49".into(),
        length_reference: None,
        position: vec![None; dof],
        digit: vec![0.0; dof],
        relative: false,
        last: None,
    };
    reader.step(0, StepKind::Break(Break::Start), None);
    for k in 0..text.line_count() {
        reader.block(k)?;
    }
    reader.lose("the end of the program");
    let Reader { mut script, statements, .. } = reader;
    let si = robot.axis_joints().map(|j| j.kind.si_per_user_unit()).collect();
    script.texts = texts;
    // without a move nothing depends on them
    if script.moves().next().is_some() {
        script.missing = missing;
    }
    Ok(Program { script, statements, letters, si })
}

pub(super) struct Reader<'a> {
    pub(super) text: &'a Text,
    pub(super) robot: &'a Axes,
    pub(super) letters: &'a [u8],
    pub(super) survey: Survey,
    pub(super) script: Script,
    pub(super) statements: Vec<Option<Box<Statement>>>,
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
    pub(super) frame: Option<u32>,
    pub(super) reference: Option<u32>,
    pub(super) lost_frame: bool,
    /// G52, by axis, mm or deg.
    pub(super) local: Vec<f64>,
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
}

impl Reader<'_> {
    pub(super) fn step(&mut self, k: usize, kind: StepKind, statement: Option<Box<Statement>>) {
        self.script.steps.push(Step { at: At { file: 0, line: k as u64 + 1 }, kind });
        self.statements.push(statement);
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
        let Some(s) = self.statements.get(step).and_then(Option::as_deref) else { return };
        // axes without a word may need one, to take back what was changed before
        let at = s.words.last().map_or(0, |w| w.span.end);
        for (a, &goal) in s.goal.iter().enumerate() {
            if let (Some(goal), Some(value @ None)) = (goal, self.script.targets[t].values.get_mut(a)) {
                let (si, digit) = (goal * self.robot.axis(a).kind.si_per_user_unit(), self.digit[a]);
                *value = Some(Value { si, start: at, end: at, style: Default::default(), digit, finest: digit });
            }
        }
    }

    pub(super) fn end(&mut self, k: usize, kind: Break, why: &str) {
        self.lose(why);
        self.step(k, StepKind::Break(kind), None);
    }

    /// Control may come from elsewhere: only what the whole text never changes is still certain.
    pub(super) fn join(&mut self, k: usize, kind: Break) {
        self.end(k, kind, "a label, jump or loop");
        self.motion = None;
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
        if [430, 431, 440].iter().any(|c| self.survey.codes.contains(c)) && self.length_reference.is_some() {
            self.length = "unknown".into();
        }
    }

    /// Something outside of this text runs: no mode is certain.
    pub(super) fn call(&mut self, k: usize) {
        self.end(k, Break::Call, "a call");
        self.motion = None;
        self.absolute = None;
        self.inch = None;
        self.plane = None;
        self.feed = None;
        self.lost_frame = true;
        self.compensation.get_or_insert_with(|| "modes behind a call are not known (G40)".into());
    }

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
        if let Some(flow) = &block.flow {
            match flow.as_str() {
                "" | "SUB" | "ENDSUB" | "RETURN" => self.join(k, Break::Start),
                "IF" | "ELSEIF" | "ELSE" | "ENDIF" => self.join(k, Break::Jump),
                "WHILE" | "ENDWHILE" | "DO" | "REPEAT" | "ENDREPEAT" | "BREAK" | "CONTINUE" => {
                    self.join(k, Break::Loop)
                }
                _ => self.call(k),
            }
        }
        if let Some(keyword) = &block.keyword {
            match keyword.as_str() {
                w if w.contains("GOTO") || matches!(w, "IF" | "THEN") => self.join(k, Break::Jump),
                "WHILE" | "DO" | "END" => self.join(k, Break::Loop),
                // `M117 Printing`, `M0 Clean the nozzle`: a message
                _ if block.words.iter().any(lex::takes_text) => return self.words(k, block),
                _ => self.call(k),
            }
            return Ok(());
        }
        if self.survey.jumps && block.words.first().is_some_and(|w| w.letter == b'N') {
            self.join(k, Break::Jump);
        }
        if block.assignment {
            return Ok(());
        }
        self.words(k, block)
    }

    /// Literal number of a letter.
    pub(super) fn number(block: &Block, letter: u8) -> Option<f64> {
        block.words.iter().find(|w| w.letter == letter).and_then(|w| w.value).map(|v| v.0)
    }

    #[allow(clippy::too_many_lines)] // one table of words, in the order in which a control takes them
    pub(super) fn words(&mut self, k: usize, block: Block) -> Result<()> {
        let mut unclear: Option<String> = block.special.map(String::from);
        if block.optional {
            unclear = Some("a block that an operator may switch off".into());
        }
        let (mut taken, mut own_frame, mut exact) = (false, false, self.exact);
        let mut after: Vec<StepKind> = Vec::new();
        let mut call_after: Option<bool> = None;
        let mut ended = false;
        for w in block.words.iter().filter(|w| w.letter == b'M') {
            if self.survey.printer && w.value.is_some_and(|v| v.0.floor() == 862.0) {
                continue;
            }
            let Some((v, _)) = w.value.filter(|v| v.0 >= 0.0 && v.0.fract() == 0.0) else {
                call_after = Some(false);
                continue;
            };
            match v as u32 {
                3 | 4 | 62 | 64 => self.step(k, StepKind::Process(true), None),
                5 | 63 | 65 => after.push(StepKind::Process(false)),
                0 | 1 | 60 | 66 => after.push(StepKind::Dwell(None)),
                2 | 30 => ended = true,
                97..=99 => call_after = Some(true),
                6 => {
                    unclear.get_or_insert_with(|| "a tool change in the block".into());
                    call_after.get_or_insert(false);
                }
                m if STILL_M.contains(&m) || (self.survey.printer && STILL_PRINTER.contains(&m)) => {}
                _ => {
                    call_after.get_or_insert(false);
                }
            }
        }
        let codes: Vec<Option<u32>> =
            block.words.iter().filter(|w| w.letter == b'G').map(|w| w.value.map(|v| code(v.0))).collect();
        for c in &codes {
            let Some(c) = *c else {
                self.strange = Some("a computed G word".into());
                continue;
            };
            match c {
                c if self.survey.printer && PROBES.contains(&c) && codes.len() == 1 => {
                    taken = true;
                    self.end(k, Break::Call, "a probing of the bed");
                }
                // retraction of filament
                100 | 110 if self.survey.printer && Self::number(&block, b'L').is_none() => taken = true,
                0 | 10 | 20 | 30 => self.motion = Some(c),
                c if CANNED.contains(&c) => self.motion = Some(c),
                // a G0 beside it goes on; G80 ends a cycle alone there
                800 if codes.iter().flatten().any(|c| [0, 10, 20, 30].contains(c)) => {}
                800 => self.motion = None,
                170 => self.plane = Some([b'X', b'Y', b'Z']),
                180 => self.plane = Some([b'Z', b'X', b'Y']),
                190 => self.plane = Some([b'Y', b'Z', b'X']),
                200 | 210 => {
                    if self.inch.is_some_and(|i| i != (c == 200)) {
                        self.step(k, StepKind::Break(Break::Frame), None);
                        self.lose("a change of units");
                    }
                    self.inch = Some(c == 200);
                    self.feed = None;
                }
                900 | 910 => self.absolute = Some(c == 900),
                901 | 911 => self.centre_absolute = c == 901,
                930 | 940 | 950 => {
                    self.feed_mode = c / 10;
                    self.feed = None;
                }
                400 => self.compensation = None,
                410 | 420 | 411 | 421 => {
                    self.compensation = Some(format!("cutter compensation {} is on", code_text(c)))
                }
                430 | 431 | 440 | 490 => self.tool_length(k, &block, c),
                540..=599 => self.select(k, work_frame(&block, c, k)),
                530 => own_frame = true,
                610 | 611 | 640 => {
                    self.exact = c != 640;
                    exact = self.exact;
                }
                90 => exact = true,
                40 => {
                    taken = true;
                    self.dwell(k, &block);
                }
                100 => {
                    taken = true;
                    self.end(k, Break::Frame, "a G10");
                    self.lost_frame |= self.reference.is_some();
                }
                520 => {
                    taken = true;
                    self.local_frame(k, &block);
                }
                920..=923 => {
                    taken = true;
                    self.shift_frame(k, &block, c);
                }
                // a lathe's G92; alone it limits the spindle, or ends a scaling
                500 if has_axes(&block) => {
                    taken = true;
                    self.shift_frame(k, &block, 920);
                }
                500 => {}
                501 | 510 | 511 => {
                    taken = true;
                    self.end(k, Break::Frame, "a scaling or a mirror");
                    if c != 501 {
                        self.strange = Some(format!("{} is on", code_text(c)));
                    }
                }
                // look-ahead of Fanuc
                51 if !has_axes(&block) => {}
                c if SPLINES.contains(&c) && (c != 50 || has_axes(&block)) => self.motion = Some(c),
                280 | 300 | 1610 | 1620 if c < 1000 || homes(&block) => {
                    taken = true;
                    // G91 in this block is about the way there alone
                    let absolute = self.absolute.replace(true);
                    self.lose("a reference point");
                    self.absolute = absolute;
                    self.step(k, StepKind::Move(opaque(format!("{} goes to a reference point", code_text(c)))), None);
                }
                650 | 660 | 670 => {
                    taken = true;
                    self.call(k);
                }
                c if HARMLESS.contains(&c) => {}
                c => self.strange = Some(format!("{} is on", code_text(c))),
            }
        }
        if let Some(w) = block.words.iter().find(|w| w.letter == b'F') {
            self.feed = w.value.map(|v| v.0);
        }
        let moves = |w: &Word| AXES.contains(&w.letter) || b"E@^".contains(&w.letter);
        let arc = matches!(self.motion, Some(20 | 30)) && block.words.iter().any(|w| b"IJKR".contains(&w.letter));
        // its words may be its own: X, Y, Z are no places then
        if codes.is_empty()
            && let Some(m) = block.words.iter().find(|w| w.letter != b'N').filter(|w| lex::is_firmware(w))
        {
            taken |= self.survey.printer;
            unclear.get_or_insert_with(|| {
                let m = String::from_utf8_lossy(self.text.slice(m.span.clone()));
                format!("words that may be those of {m}")
            });
        }
        if !taken && (block.words.iter().any(moves) || arc) {
            if own_frame {
                unclear.get_or_insert_with(|| "G53: a place of the machine".into());
            }
            self.movement(k, block, &codes, unclear, exact)?;
        }
        for kind in after {
            self.step(k, kind, None);
        }
        if ended {
            self.end(k, Break::Jump, "the end of the program");
        }
        match call_after {
            Some(true) => self.call(k),
            Some(false) => {
                self.end(k, Break::Call, "an M word that may move the machine");
                self.motion = None;
            }
            None => {}
        }
        Ok(())
    }

    /// `G4 P500`: seconds where that is certain.
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
