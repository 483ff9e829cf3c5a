//! Modal state and steps: the reader, and what each line is. What is certain of the position is in [`certain`](super::certain), how often a
//! text is read in [`whole`](super::whole).

use super::across::Across;
use super::alike::Alike;
use super::assignments::Assignments;
use super::certain::Carried;
use super::codes::AXES;
use super::flow::{assignments_of, flow_hides, is_flow};
use super::lex::{self, Block};
use super::order::Order;
use super::programs::Modes;
use super::reason::{After, Doubt};
use super::statements::{Statement, Statements, Waits};
use super::survey::Survey;
use super::variables::Variables;
use crate::axes::Axes;
use crate::error::Result;
use crate::script::{At, AxisSet, Break, Note, Script, Step, StepKind, Targets, Text, pragma};
use std::collections::BTreeMap;
use std::sync::Arc as Shared;

pub(super) struct Reader<'a> {
    pub(super) text: &'a Text,
    pub(super) robot: &'a Axes,
    pub(super) letters: &'a [u8],
    pub(super) survey: Survey,
    pub(super) variables: Variables,
    /// An expression was folded.
    pub(super) has_folded: bool,
    /// It was said in which frame positions are taken.
    pub(super) has_noted: bool,
    /// It was said that the way of a rotary axis is not certain.
    pub(super) has_noted_rollover: bool,
    pub(super) script: Script,
    pub(super) statements: Statements,
    /// Times ten; canned cycles too.
    pub(super) motion: Option<u32>,
    pub(super) absolute: Option<bool>,
    pub(super) inch: Option<bool>,
    /// Letters of the plane's axes and of the third.
    pub(super) plane: Option<[u8; 3]>,
    pub(super) centre_absolute: bool,
    /// What an X word counts; `None`: not known.
    pub(super) across: Option<Across>,
    pub(super) feed_mode: u32,
    pub(super) feed: Option<f64>,
    pub(super) exact: bool,
    /// The words of dwells behind moves, by the step of the move.
    pub(super) waits: Waits,
    /// Cutter compensation that is, or may be, on.
    pub(super) compensation: Option<Doubt>,
    /// A code after which words mean something else.
    pub(super) strange: Option<Doubt>,
    /// A macro that each block runs, or may.
    pub(super) modal_macro: Option<Doubt>,
    pub(super) frame: Option<u32>,
    pub(super) reference: Option<u32>,
    pub(super) lost_frame: bool,
    /// Modes are not known until a work frame is named again: something outside of this text ran.
    pub(super) frame_to_name: bool,
    /// A work frame was named: its offset is not in the program.
    pub(super) named_frame: bool,
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
    /// By axis whose position is not known.
    pub(super) carried: Vec<Carried>,
    /// Of them those that a move which stays took to the place of its own word: no offset is in it.
    pub(super) named: AxisSet,
    /// The last moves before labels, jumps, loops and calls.
    pub(super) leaving: Vec<usize>,
    /// Relative words may count from any of them.
    pub(super) counts_anywhere: bool,
    /// Some axes went on to a place of the machine after it: relative words after it do not count from it.
    pub(super) settled: bool,
    /// Cycles certainly take Z back to R (G99), not to where it stood before.
    pub(super) back_to_r: bool,
    /// What lines may be like.
    pub(super) alike: Alike,
    /// From where control comes to its breaks.
    pub(super) order: Order,
    /// The modes at the calls so far of each program of the text.
    pub(super) called_in: BTreeMap<String, Vec<Modes>>,
    /// The modes at all calls, as an earlier reading found them.
    pub(super) foreseen: BTreeMap<String, Vec<Modes>>,
    /// A program of the text stands in front of a call of it.
    pub(super) precedes_calls: bool,
    /// The modes around the definition of a subprogram, and the work frame.
    pub(super) around: Option<(Modes, Option<u32>)>,
}

impl<'a> Reader<'a> {
    /// The state in which a control begins a program.
    pub(super) fn new(text: &'a Text, robot: &'a Axes, letters: &'a [u8], survey: Survey) -> Self {
        let dof = robot.dof();
        let mut reader = Self {
            text,
            robot,
            letters,
            survey,
            variables: Variables::of(text),
            has_folded: false,
            has_noted: false,
            has_noted_rollover: false,
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
            across: None,
            feed_mode: 94,
            feed: None,
            exact: robot.control.exact_stop,
            waits: Waits::default(),
            compensation: None,
            strange: None,
            modal_macro: None,
            frame: None,
            reference: None,
            lost_frame: false,
            frame_to_name: false,
            named_frame: false,
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
            carried: vec![Carried::Nothing; dof],
            named: AxisSet::default(),
            leaving: Vec::new(),
            counts_anywhere: false,
            settled: false,
            back_to_r: false,
            alike: Alike::default(),
            order: Order::default(),
            called_in: BTreeMap::new(),
            foreseen: BTreeMap::new(),
            precedes_calls: false,
            around: None,
        };
        reader.begin_lathe();
        reader
    }
}

impl Reader<'_> {
    /// Reads the text from its start to its end.
    pub(super) fn whole(&mut self) -> Result<()> {
        self.step(0, StepKind::Break(Break::Start), None);
        if self.survey.repeats {
            // the first move of another pass comes from the end of the one before, and relative words count from there
            if !self.survey.named {
                self.step(0, StepKind::Break(Break::Jump), None);
            }
            self.carried.fill(Carried::Anywhere);
        }
        for k in 0..self.text.line_count() {
            if !self.again(k) {
                self.block(k)?;
            }
        }
        self.lose(After::End);
        Ok(())
    }

    pub(super) fn step(&mut self, k: usize, kind: StepKind, statement: Option<Statement>) {
        let step = Step::following(self.script.steps.last(), At::of_line(k), kind);
        self.script.steps.push(step);
        if let Some(statement) = statement {
            self.statements.push(self.script.steps.len() - 1, statement);
        }
    }

    /// The axes that words of a block name; `None`: a word names none of the robot's.
    pub(super) fn axes_named(&self, block: &Block) -> Option<AxisSet> {
        let named = block.words.iter().filter(|w| AXES.contains(&w.letter));
        named.map(|w| self.letters.iter().position(|l| *l == w.letter)).collect()
    }

    /// The axis of a tool length: Z, where the plane is X-Y; any on a lathe and in another plane.
    ///
    /// `length = ("G43" | "G44") ["H" number]`
    pub(super) fn length_axis(&self) -> Option<AxisSet> {
        let z = self.letters.iter().position(|l| *l == b'Z')?;
        let plain = self.plane == Some([b'X', b'Y', b'Z']) && !self.survey.lathe;
        plain.then(|| [z].into_iter().collect())
    }

    /// What a line assigns, and what it may do besides.
    fn assign(&mut self, k: usize, found: &Assignments) {
        // a frame that may be set from where the machine stands would keep a change
        if found.hidden || found.frame || found.any {
            self.keeps_place(After::ReadsPlace);
        }
        self.variables.assign(self.text.line(k), found);
        if found.hidden {
            self.strange = Some(Doubt::LineUnfollowed(k as u64 + 1));
            self.end(k, Break::Call, After::Unfollowed);
            self.forget_modes(After::Unfollowed);
        } else if found.frame || found.any {
            self.end(k, Break::Frame, After::FrameAssigned);
            self.lost_frame |= self.reference.is_some();
            if self.reference.is_some() {
                self.strange = Some(Doubt::FrameAssigned(k as u64 + 1));
            }
        } else if found.signal {
            self.end(k, Break::Call, After::Signal);
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
            self.end(k, Break::Start, After::TapeEnd);
            self.route_tape();
            return Ok(());
        }
        let assigned = assignments_of(self.text, k, &block);
        let reads = self.reads_place(k);
        let mut line = self.line_of_flow(k, &block);
        if let Some(flow) = &block.flow {
            match flow.as_str() {
                "" | "SUB" | "ENDSUB" | "RETURN" => self.start(k, &block),
                "IF" | "ELSEIF" | "ELSE" | "ENDIF" => self.join(k, Break::Jump),
                "WHILE" | "ENDWHILE" | "DO" | "REPEAT" | "ENDREPEAT" | "BREAK" | "CONTINUE" => {
                    self.join(k, Break::Loop)
                }
                _ => self.calls(k, self.callee_of_flow(&block), self.entry_of_flow(&block)),
            }
            self.route(&block, line.take());
            self.reads_anywhere(reads, &block);
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
                w => self.calls(k, self.callee_of_keyword(k, w), None),
            }
            self.route(&block, line.take());
            self.reads_anywhere(reads, &block);
            if flow_hides(self.text, k, &block) {
                self.assign(k, &Assignments { hidden: true, ..assigned.clone().unwrap_or_default() });
            } else if let Some(found) = &assigned {
                self.assign(k, found);
            }
            return Ok(());
        }
        if self.is_label(&block) {
            self.join(k, Break::Jump);
            self.reads_anywhere(reads, &block);
        }
        if let Some(found) = &assigned {
            self.assign(k, found);
        } else if block.assignment {
            // `#1` and no `=`
            self.assign(k, &Assignments { hidden: true, ..Assignments::default() });
        }
        if block.assignment {
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
                self.script.notes.push(Note { place: At::of_line(k), text: text.into() });
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
    /// F counts seconds on every control that takes it for the time, S seconds on printers and turns of the spindle elsewhere.
    ///
    /// `dwell = "G4" (("X" | "U" | "F" | "S" | "P") number)`
    pub(super) fn dwell(&mut self, k: usize, block: &Block) {
        self.waits_at_goal(block);
        let literal = |letters: &[u8]| block.words.iter().find(|w| letters.contains(&w.letter)).and_then(|w| w.value);
        let has = |letter: u8| block.words.iter().any(|w| w.letter == letter);
        let printer = self.survey.printer;
        let seconds = match (literal(b"XU"), literal(b"P")) {
            (Some((s, _)), _) => Some(s),
            // without a point it is milliseconds on some controls and seconds on others
            (None, Some((s, style))) if style.point => Some(s),
            (None, None) if !has(b'P') => match (literal(b"F"), literal(b"S")) {
                (None, Some((s, _))) if printer && !has(b'F') => Some(s),
                (Some((s, _)), None) if !printer && !has(b'S') => Some(s),
                _ => None,
            },
            _ => None,
        };
        self.step(k, StepKind::Dwell(seconds.filter(|s| *s >= 0.0)), None);
    }
}
