//! The words of one block: M words, then G words (modes, actions, motion), then the move, then what follows it.

use super::across::Across;
use super::callee::is_numbered_call;
use super::calls::Callee;
use super::codes::{AXES, CANNED, HARMLESS, PROBES, SPLINES, TOUCHES, code};
use super::frame::changes_tool;
use super::labels::is_conditional_call;
use super::lex::{self, Block, Word, has_axes};
use super::makers::{is_corner_mode, is_high_speed, work_frame};
use super::order::Entry;
use super::read::Reader;
use super::reason::{After, Doubt, Elsewhere, Reason};
use super::signs::unit_of_siemens;
use super::survey::{acts_once, homes, moves_offsets};
use crate::error::Result;
use crate::script::{Break, StepKind};

/// M words that save modes and bring them back.
const SAVES: std::ops::RangeInclusive<u32> = 70..=73;
/// M words that leave the machine where it is.
const STILL_M: &[u32] =
    &[7, 8, 9, 10, 11, 19, 48, 49, 50, 51, 52, 53, 67, 68, 104, 106, 107, 140, 82, 83, 84, 117, 118];
/// M words of printer firmware that leave the machine where it is, besides M862.1 and its like.
const STILL_PRINTER: &[u32] = &[
    73, 105, 108, 109, 111, 115, 141, 142, 155, 190, 191, 200, 201, 203, 204, 205, 207, 208, 209, 220, 221, 300, 301,
    302, 304, 400, 413, 486, 555, 566, 569, 572, 593, 900, 906, 907, 913, 914,
];

/// What the words of a block make of it.
struct OwnWords {
    /// A word uses the block's numbers itself: they are no target.
    taken: bool,
    /// G53.
    machine_frame: bool,
    /// A dwell stands beside places: some controls go there, others take a number for the time.
    dwells: bool,
    /// The block ends in its point.
    exact: bool,
}

/// What an M word calls.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Call {
    /// A program, which changes any mode.
    Program(Callee),
    /// Something that may move the machine.
    MayMove,
}

/// What follows the move of a block.
#[derive(Default)]
struct Ending {
    steps: Vec<StepKind>,
    /// M2, M30.
    program: bool,
    call: Option<Call>,
    /// M99.
    returns: bool,
}

impl Reader<'_> {
    /// Takes the words of a block in the order in which a control does.
    ///
    /// `block = {G_word | M_word | axis_word | F_word | ...}, in the order of a control`
    pub(super) fn words(&mut self, k: usize, block: Block) -> Result<()> {
        if block.optional {
            return self.optional(k, block);
        }
        self.certain_words(k, block, None)
    }

    /// A block that an operator may switch off: where it leads is not determined, and modes that it changes are not certain after it.
    fn optional(&mut self, k: usize, block: Block) -> Result<()> {
        let before = self.modes();
        self.route_optional(&block);
        let (modal_macro, strange, feed_mode) = (self.modal_macro, self.strange, self.feed_mode);
        self.certain_words(k, block, Some(Reason::Optional))?;
        if self.modes() != before {
            // what it switches off may stay on
            self.modal_macro = self.modal_macro.take().or(modal_macro);
            self.strange = self.strange.take().or(strange);
            if self.feed_mode != feed_mode {
                self.strange.get_or_insert(Doubt::FeedMode);
            }
            self.anchor(After::Optional);
            self.variables.forget();
            self.end(k, Break::Call, After::Optional);
            self.forget_modes(After::Optional);
        }
        Ok(())
    }

    /// The words of a block that certainly runs.
    ///
    /// `block = {M_word | G_word | axis_word | "F" number | ...}`
    fn certain_words(&mut self, k: usize, block: Block, unclear: Option<Reason>) -> Result<()> {
        if is_numbered_call(&block) {
            self.calls(k, self.callee(&block), None);
            return Ok(());
        }
        let mut unclear = unclear.or_else(|| block.special.clone());
        let ending = self.m_words(k, &block, &mut unclear);
        let entry = self.entry_of(&block);
        let codes: Vec<Option<u32>> =
            block.words.iter().filter(|w| w.letter == b'G').map(|w| w.value.map(|v| code(v.0))).collect();
        if let Some(across) = block.across {
            self.count_across(k, across);
        }
        let mut own = OwnWords { taken: false, machine_frame: false, dwells: false, exact: self.exact };
        for c in &codes {
            match *c {
                Some(c) => self.g_word(k, &block, c, &codes, &mut own),
                None => {
                    self.keeps_place(After::CountsFromHere);
                    self.strange = Some(Doubt::ComputedGWord);
                }
            }
        }
        if codes.contains(&Some(431)) && has_axes(&block) {
            unclear.get_or_insert(Reason::WordsOfTool);
        }
        if own.dwells {
            unclear.get_or_insert(Reason::DwellBesidePositions);
        }
        // which of its words count from where the axes stand depends on the control
        let both = [900, 910].iter().all(|c| codes.contains(&Some(*c)));
        let last = self.absolute.take_if(|_| both);
        if both {
            unclear.get_or_insert(Reason::BothDistances);
        }
        let changes_tool = changes_tool(&block, &self.survey);
        if changes_tool {
            unclear.get_or_insert(Reason::ToolOrOffset);
        }
        if let Some(w) = block.words.iter().find(|w| w.letter == b'F') {
            self.feed = match codes.contains(&Some(40)) {
                false => w.value.map(|v| v.0),
                // beside another time it may be either; alone it is the time, and the feed stays
                true => self.feed.filter(|_| !own.dwells && !block.words.iter().any(|w| b"PXU".contains(&w.letter))),
            };
        }
        let moves = |w: &Word| AXES.contains(&w.letter) || b"E@^".contains(&w.letter);
        let arc = matches!(self.motion, Some(20 | 30)) && block.words.iter().any(|w| b"IJKR".contains(&w.letter));
        let drills = self.drills_by_level(&block);
        // its words may be its own: X, Y, Z are no places then
        if codes.is_empty()
            && let Some(m) = block.words.iter().find(|w| w.letter != b'N').filter(|w| lex::is_firmware(w))
        {
            own.taken |= self.survey.printer;
            unclear.get_or_insert_with(|| Reason::WordsOf(String::from_utf8_lossy(self.text.slice(m.span())).into()));
        }
        if !own.taken && own.machine_frame && unclear.is_none() && block.words.iter().any(moves) {
            let axes = self.axes_of_machine(&block);
            self.goes_elsewhere(k, axes, Elsewhere::Machine);
        } else if !own.taken && (block.words.iter().any(moves) || arc || drills) {
            self.movement(k, block, &codes, unclear, own.exact)?;
        } else if !own.taken {
            self.keep_start_of_circle(&block);
        }
        self.absolute = last.or(self.absolute);
        if changes_tool {
            self.end(k, Break::Frame, After::Tool);
        }
        self.finish(k, ending, entry);
        Ok(())
    }

    /// The M words of a block: what starts before its move is done here, what follows the move is returned.
    fn m_words(&mut self, k: usize, block: &Block, unclear: &mut Option<Reason>) -> Ending {
        let mut ending = Ending::default();
        for w in block.words.iter().filter(|w| w.letter == b'M') {
            if self.survey.printer && w.value.is_some_and(|v| v.0.floor() == 862.0) {
                continue;
            }
            let Some((v, _)) = w.value.filter(|v| v.0 >= 0.0 && v.0.fract() == 0.0) else {
                ending.call = Some(Call::Program(Callee::Away));
                continue;
            };
            let m = v as u32;
            match m {
                3 | 4 | 62 | 64 => self.step(k, StepKind::Process(true), None),
                5 | 63 | 65 => ending.steps.push(StepKind::Process(false)),
                0 | 1 | 60 | 66 => ending.steps.push(StepKind::Dwell(None)),
                2 | 30 => ending.program = true,
                97 | 98 => ending.call = Some(Call::Program(self.callee(block))),
                96 if is_conditional_call(block) => ending.call = Some(Call::Program(Callee::Here)),
                198 if !self.survey.printer => ending.call = Some(Call::Program(self.callee(block))),
                99 => (ending.call, ending.returns) = (Some(Call::Program(Callee::Nothing)), true),
                m if SAVES.contains(&m) && !self.survey.printer => ending.call = Some(Call::Program(Callee::Nothing)),
                6 => {
                    self.variables.forget();
                    unclear.get_or_insert(Reason::ToolChange);
                    ending.call.get_or_insert(Call::MayMove);
                }
                21..=23 if self.survey.mirrors => self.mirror(k, m),
                m if STILL_M.contains(&m) || (self.survey.printer && STILL_PRINTER.contains(&m)) => {}
                _ => {
                    if m == 428 {
                        // home offsets of printers from where the machine stands
                        self.keeps_place(After::StoresPlace);
                    }
                    // a macro of the machine's maker may assign any
                    self.variables.forget();
                    ending.call.get_or_insert(Call::MayMove);
                }
            }
        }
        ending
    }

    /// M21 and M22 mirror X and Y on older controls, M23 ends both; elsewhere they are the maker's own.
    fn mirror(&mut self, k: usize, m: u32) {
        self.end(k, Break::Call, After::MayMirror);
        self.motion = None;
        match m {
            23 => drop(self.strange.take_if(|doubt| doubt.mirrors())),
            _ => drop(self.strange.get_or_insert(Doubt::MayMirror(m))),
        }
    }

    /// One G word (times ten): a mode, an action with the block's numbers, or the motion.
    fn g_word(&mut self, k: usize, block: &Block, c: u32, codes: &[Option<u32>], own: &mut OwnWords) {
        let c = if self.survey.siemens { unit_of_siemens(c) } else { c };
        if self.mode(k, block, c) {
            return;
        }
        if c == 40 {
            let time = |w: &Word| b"XU".contains(&w.letter) && Self::number(block, b'P').is_none();
            own.dwells = block.words.iter().any(|w| AXES.contains(&w.letter) && !time(w));
            own.taken |= !own.dwells;
            return self.dwell(k, block);
        }
        if self.counts_from_here(block, c) {
            self.keeps_place(After::CountsFromHere);
        }
        if self.cuts_thread(block, c) {
            self.motion = Some(c);
            return;
        }
        if self.action(k, block, c, codes.len() == 1) {
            own.taken = true;
            return;
        }
        match c {
            0 | 10 | 20 | 30 => self.motion = Some(c),
            // printers store a place by it
            600 => {
                self.keeps_place(After::StoresPlace);
                self.strange = Some(Doubt::On(c));
            }
            c if CANNED.contains(&c) || TOUCHES.contains(&c) => self.motion = Some(c),
            // which motion is on after it is not certain
            310 if acts_once(block, c) && !self.survey.printer => self.motion = Some(c),

            // a G0 beside it goes on; G80 ends a cycle alone there
            800 if codes.iter().flatten().any(|c| [0, 10, 20, 30].contains(c)) => {}
            800 => self.motion = None,
            530 => own.machine_frame = true,
            c if is_corner_mode(block, c) => {
                self.exact = matches!(c, 610 | 611);
                own.exact = self.exact;
            }
            90 => own.exact = true,
            // a lathe's limit of the spindle, or the end of a scaling
            500 => {}
            // look-ahead of Fanuc
            51 if !has_axes(block) => {}
            c if is_high_speed(block, c) => {}
            c if SPLINES.contains(&c) && (c != 50 || has_axes(block)) => self.motion = Some(c),
            c if HARMLESS.contains(&c) => {}
            c => {
                self.keeps_place(After::CountsFromHere);
                self.strange = Some(Doubt::On(c));
            }
        }
    }

    /// A mode that the word sets; false where it is none.
    ///
    /// `mode = "G17" | "G18" | "G19" | "G20" | "G21" | "G40" | "G41" | "G42" | "G43" | "G49" | "G54" ... | "G90" | "G91" | "G93" | "G94" | "G95"`
    fn mode(&mut self, k: usize, block: &Block, c: u32) -> bool {
        match c {
            170 => self.plane = Some([b'X', b'Y', b'Z']),
            180 => self.plane = Some([b'Z', b'X', b'Y']),
            190 => self.plane = Some([b'Y', b'Z', b'X']),
            200 | 210 => {
                if self.inch.is_some_and(|i| i != (c == 200)) {
                    self.step(k, StepKind::Break(Break::Frame), None);
                    self.lose(After::Units);
                }
                self.inch = Some(c == 200);
                self.feed = None;
            }
            70 | 80 => {
                let Some(across) = Across::of_g_word(block, c) else { return false };
                self.count_across(k, across);
            }
            980 | 990 if self.survey.diameters => self.feed_of_lathe(c),
            980 | 990 => self.back_to_r = c == 990 && !block.optional,
            900 | 940 if self.survey.lathe => {
                if has_axes(block) {
                    self.keeps_place(After::CountsFromHere);
                }
                self.strange = Some(Doubt::TurningCycle(c));
            }
            900 | 910 => self.absolute = Some(c == 900),
            901 | 911 => self.centre_absolute = c == 901,
            930 | 940 | 950 => {
                self.feed_mode = c / 10;
                self.feed = None;
            }
            400 => self.compensation = None,
            410 | 420 | 411 | 421 => self.compensation = Some(Doubt::Compensation(c)),
            430 | 431 | 440 | 490 => self.tool_length(k, block, c),
            c if self.survey.names_frame(block, c) => self.select(k, work_frame(block, c, k)),
            _ => return false,
        }
        true
    }

    /// What a word does itself with the numbers of its block, which are then no target; false where it does nothing.
    fn action(&mut self, k: usize, block: &Block, c: u32, alone: bool) -> bool {
        match c {
            1030 if acts_once(block, c) => {
                self.keeps_place(After::MayMove);
                self.end(k, Break::Call, After::MayMove);
                self.motion = None;
            }
            c if self.survey.printer && PROBES.contains(&c) && alone => self.end(k, Break::Call, After::BedProbing),
            // retraction of filament; with `P` and `S` the temperature of a tool
            100 | 110 if self.survey.printer && Self::number(block, b'L').is_none() && !has_axes(block) => {}
            100 => {
                // it may be set from where the machine stands
                match Self::number(block, b'L') {
                    // the values that are written, wherever the machine stands
                    Some(1.0 | 2.0) => self.anchor(After::G10),
                    _ => self.keeps_place(After::G10),
                }
                self.end(k, Break::Frame, After::G10);
                self.lost_frame |= self.reference.is_some();
                // `G10 P1 X-25` of printers: the offset of a tool
                let of_tool = self.survey.printer && Self::number(block, b'L').is_none();
                if !of_tool && !moves_offsets(block) {
                    self.strange = Some(Doubt::MayTurn);
                }
            }
            520 => self.local_frame(k, block),
            920..=923 => self.shift_frame(k, block, c),
            // a lathe's G92
            500 if has_axes(block) => self.shift_frame(k, block, 920),
            501 | 510 | 511 => {
                self.end(k, Break::Frame, After::Scaling);
                if c != 501 {
                    self.strange = Some(Doubt::On(c));
                }
            }
            281 | 301 => self.stores_place(k, block, c),
            280 | 300 | 1610 | 1620 if c < 1000 || homes(block) => {
                // G91 in this block is about the way there alone
                let absolute = self.absolute.replace(true);
                let axes = self.axes_named(block).and_then(|axes| self.with_length(axes)).filter(|_| has_axes(block));
                self.goes_elsewhere(k, axes, Elsewhere::Reference(c));
                self.absolute = absolute;
            }
            650 => self.calls(k, self.callee(block), None),
            660 | 661 => {
                self.calls(k, self.callee(block), None);
                self.modal_macro = Some(Doubt::MacroOn);
            }
            670 => {
                // of several, it ends one
                let ends = self.survey.macros <= 1 && self.modal_macro == Some(Doubt::MacroOn);
                self.call(k);
                if ends {
                    self.modal_macro = None;
                }
            }
            _ => return false,
        }
        true
    }

    /// What stands after the move of its block.
    fn finish(&mut self, k: usize, ending: Ending, entry: Option<Entry>) {
        for kind in ending.steps {
            self.step(k, kind, None);
        }
        if ending.program {
            self.end(k, Break::Jump, After::End);
            self.order.ends();
        }
        match ending.call {
            Some(Call::Program(callee)) => {
                self.calls(k, callee, entry);
                self.route_return(ending.returns);
            }
            Some(Call::MayMove) => {
                self.end(k, Break::Call, After::MayMove);
                self.motion = None;
            }
            None => {}
        }
    }
}
