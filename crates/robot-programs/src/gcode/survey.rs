//! A look over the whole text before it is read: which codes there are, how numbers are written, what may be jumped to.

use super::across::Across;
use super::callee::{Called, called_by};
use super::codes::{AXES, CANNED, PROBES, code, is_followed};
use super::flow::{assignments_of, flow_hides, is_flow};
use super::labels::local_labels;
use super::lex::{self, Block, has_axes, names};
use super::makers::{Makers, is_corner_mode, is_high_speed, is_numbered_frame, work_frame};
use super::passed::Passed;
use super::programs::Programs;

use super::signs::Signs;
use crate::error::Result;
use crate::script::Text;
use std::collections::BTreeSet;

/// G words, times ten, that a subprogram in the text may pass and whose modes a look over the text settles.
const PLAIN: &[u32] = &[
    0, 10, 20, 30, 40, 100, 170, 180, 190, 200, 210, 280, 300, 400, 410, 411, 420, 421, 430, 431, 440, 490, 520, 530,
    640, 690, 730, 740, 760, 800, 900, 910, 920, 921, 922, 923, 940, 980, 990,
];
/// What a look over the whole text tells.
#[derive(Default)]
pub(super) struct Survey {
    /// All G words, times ten.
    pub(super) codes: BTreeSet<u32>,
    /// Numbers with a point and nothing after it: a control on which `X10` may be 10 increments.
    pub(super) points: bool,
    /// The first line with such a number.
    point_line: usize,
    /// Numbers other than 0 without a point, of places to which moves lead.
    pub(super) bare: bool,
    /// Numbers with a point, wherever it is.
    pub(super) pointed: bool,
    /// The control reads numbers without a point in millimetres, inches and degrees: the user says so.
    pub(super) whole_units: bool,
    /// Line numbers may be jumped to.
    pub(super) jumps: bool,
    /// Numbers of blocks that are called or jumped to, where these are all ([`Self::jumps`]).
    pub(super) labels: BTreeSet<u32>,
    /// Firmware of a printer: it heats, or counts filament.
    pub(super) printer: bool,
    /// Every subprogram that is called stands in the text.
    pub(super) whole: bool,
    /// A line does what is not read, or a G word is computed: the codes are not all.
    pub(super) hidden: bool,
    /// A code after which words mean something else.
    pub(super) unfollowed: Option<u32>,
    /// Modal macros (G66) that are called.
    pub(super) macros: usize,
    /// The text is one of a mill of Haas: it has words that their controls alone have.
    pub(super) haas: bool,
    /// M21 or M22 stands in a text that may be no lathe's: older controls mirror X or Y from there on.
    pub(super) mirrors: bool,
    /// Tools are changed by M6: T alone chooses the next one.
    pub(super) changes_tools: bool,
    /// It may be a program of a lathe, on which G90 and G94 may be turning cycles: no Y, and a word of lathes.
    pub(super) lathe: bool,
    /// It may be a program of a lathe, whose X words may be diameters and whose feed may be that of a turn.
    pub(super) diameters: bool,
    /// It has a Y.
    pub(super) has_y: bool,
    /// It has words that only Siemens controls have.
    pub(super) siemens: bool,
    /// What its words make of X words.
    pub(super) across: BTreeSet<Across>,
    /// Its end goes back to its start (M99).
    pub(super) repeats: bool,
    /// Subprograms that are called, and whether one may be that cannot be determined.
    pub(super) called: BTreeSet<String>,
    /// Subprograms that stand in the text.
    pub(super) subs: BTreeSet<String>,
    pub(super) outside: bool,
    /// One that is called is not in the text, and may call others.
    pub(super) lacks: bool,
    /// Its programs and their calls.
    pub(super) programs: Programs,
    /// An O word or `%` stands before its first words.
    pub(super) named: bool,
    /// Cutter compensation may be on where control comes from elsewhere. A program starts with G40, as after a reset: where in the order of
    /// the text it is off at every label, jump, loop and call, it is off there in every order.
    pub(super) leaves_compensation: bool,
}

impl Survey {
    /// Numbers with and without a point stand in the program: those that end in a point say how the others are to be read.
    pub(super) fn mixed(&self) -> bool {
        self.points && self.bare
    }

    /// In such a program the line that stays as it is, so that the numbers without a point are read as they were.
    pub(super) fn marker(&self) -> Option<usize> {
        self.mixed().then_some(self.point_line)
    }

    /// Numbers without a point may count increments: others end in one, or no number of an axis word has one.
    pub(super) fn may_count(&self) -> bool {
        self.points || self.only_whole()
    }

    /// No number of an axis word has a point, and nobody says that whole numbers are millimetres. Firmware of printers knows no increments.
    pub(super) fn only_whole(&self) -> bool {
        self.bare && !self.pointed && !self.whole_units && !self.printer
    }

    pub(super) fn of(text: &Text) -> Result<Self> {
        let mut look = Look::default();
        let mut passed = Passed::default();
        for k in 0..text.line_count() {
            if let Some(written) = passed.again(text, k) {
                look.survey.bare |= written.bare;
                look.survey.pointed |= written.pointed;
                continue;
            }
            let block = lex::block(text, k)?;
            look.signs.y |= names(&block, b"Y");
            if look.survey.knows(&block) {
                block.words.iter().for_each(|w| look.survey.form(k, w, true));
                passed.note(text, k, &block.words);
            } else {
                look.block(text, k, &block);
            }
        }
        Ok(look.settle())
    }

    /// Whether a block is a plain move of which nothing is new but its numbers: places and a feed, with a G0 or G1 that was met before.
    ///
    /// `block = {("X" | "Y" | "Z" | "F") number | "G0" | "G1"}`
    fn knows(&self, block: &Block) -> bool {
        let Block { words, comments, optional, percent, flow, label: _, keyword, assignment, folded, special, across } =
            block;
        let known = |w: &lex::Word| match (w.letter, w.value) {
            (b'X' | b'Y' | b'Z' | b'F', Some(_)) => true,
            (b'G', Some((v, _))) => (v == 0.0 || v == 1.0) && self.codes.contains(&code(v)),
            _ => false,
        };
        let other = *optional || *percent || *assignment || *folded;
        let named = flow.is_some() || keyword.is_some() || special.is_some() || across.is_some();
        !other && !named && comments.is_empty() && words.iter().all(known)
    }

    /// How the number of a place in line `k` is written; `leads`: a move leads there.
    fn form(&mut self, k: usize, w: &lex::Word, leads: bool) {
        let Some((v, style)) = w.value else { return };
        let place = AXES.contains(&w.letter) || b"IJKR".contains(&w.letter);
        if place && style.point && style.decimals == 0 && !self.points {
            (self.points, self.point_line) = (true, k);
        }
        self.bare |= place && leads && !style.point && v != 0.0;
        self.pointed |= place && style.point;
    }

    /// At most one of these codes is in the text.
    pub(super) fn single(&self, codes: &[u32]) -> bool {
        !self.hidden && codes.iter().filter(|c| self.codes.contains(c)).count() <= 1
    }

    pub(super) fn frames(&self) -> bool {
        let many = self.codes.range(540..600).count() + usize::from(self.codes.contains(&541));
        self.hidden || many > 1 || [520, 920, 921, 922, 923, 100].iter().any(|c| self.codes.contains(c))
    }
}

/// What a look over the text gathers on its way.
#[derive(Default)]
struct Look {
    survey: Survey,
    /// Words of filament, and how they count (M82, M83).
    extrudes: bool,
    counts: bool,
    signs: Signs,
    makers: Makers,
    /// The program has begun without a name, and ended (M2, M30).
    begun: bool,
    ended: bool,
    /// Codes after which words mean something else.
    unfollowed: BTreeSet<u32>,
    /// Cutter compensation is on here; was on at a place that steers the order of blocks; was on at a line number.
    compensates: bool,
    compensates_at_flow: bool,
    compensates_at_number: bool,
}

impl Look {
    /// What a block tells of the program.
    ///
    /// `block = {"G" number | "M" number | word}`
    fn block(&mut self, text: &Text, k: usize, block: &Block) {
        self.begun |= !self.survey.named && !block.words.is_empty();
        self.survey.named |= !self.begun && (block.flow.is_some() || block.percent);
        self.signs.block(text, block);
        self.survey.across.extend(block.across);
        self.survey.hidden |= flow_hides(text, k, block);
        if let Some(found) = assignments_of(text, k, block) {
            self.survey.hidden |= found.hidden;
            if found.frame || found.any {
                // as a G10 does that may turn it
                self.survey.codes.insert(100);
                self.unfollowed.insert(100);
            }
        }
        self.survey.hidden |= block.words.iter().any(|w| w.letter == b'G' && w.value.is_none());
        self.order(text, k, block);
        self.compensation(block);
        self.extrudes |= names(block, b"E");
        let [leads_axes, leads_rest] = leads(block);
        for w in &block.words {
            self.survey.form(k, w, leads_axes && (leads_rest || AXES.contains(&w.letter)));
            match (w.letter, w.value) {
                (b'G', Some((v, _))) => self.g_word(k, block, code(v)),
                (b'M', Some((v, _))) => self.m_word(block, v),
                _ => {}
            }
        }
    }

    /// What a block jumps to and calls.
    fn order(&mut self, text: &Text, k: usize, block: &Block) {
        self.survey.jumps |=
            block.keyword.is_some() && text.line(k).to_ascii_uppercase().windows(4).any(|w| w == b"GOTO");
        match block.flow.as_deref() {
            Some("" | "SUB") => {
                self.survey.programs.begin(Some(&block.label));
                self.survey.subs.insert(block.label.clone());
            }
            Some("ENDSUB") => self.survey.programs.begin(None),
            Some("CALL") => {
                self.survey.programs.called(&block.label);
                self.survey.called.insert(block.label.clone());
            }
            Some(_) => self.survey.programs.branch(),
            None if block.keyword.is_some() => self.survey.programs.branch(),
            None => {}
        }
        self.survey.outside |=
            block.keyword.as_deref().is_some_and(|w| !is_flow(w) && !block.words.iter().any(lex::takes_text));
        for label in local_labels(block) {
            match label {
                Some(number) => drop(self.survey.labels.insert(number)),
                None => self.survey.jumps = true,
            }
        }
        match called_by(block).map(Called::in_text) {
            Some(Some(number)) => {
                self.survey.programs.called(&number.to_string());
                self.survey.called.insert(number.to_string());
            }
            Some(None) => self.survey.outside = true,
            None => {}
        }
    }

    /// Cutter compensation before and after a block: neither may be on where control goes elsewhere or comes from there.
    ///
    /// `compensation = "G40" | ("G41" | "G42") ["D" number]`
    fn compensation(&mut self, block: &Block) {
        let code_of = |letter: u8| move |w: &lex::Word| w.value.filter(|_| w.letter == letter).map(|v| code(v.0));
        let codes = |letter: u8| block.words.iter().filter_map(code_of(letter));
        let last = codes(b'G').rfind(|c| matches!(c, 400 | 410 | 411 | 420 | 421));
        let before = self.compensates;
        self.compensates = last.map_or(before, |c| c != 400);
        // an operator may switch off what switches it
        let either = before || self.compensates || block.optional && last.is_some();
        let calls = codes(b'M').any(|m| matches!(m, 20 | 300 | 960 | 970 | 980 | 990 | 1980))
            || codes(b'G').any(|g| matches!(g, 650 | 660 | 661 | 670));
        let flows = calls || block.flow.is_some() || block.keyword.is_some() || block.percent;
        self.compensates_at_flow |= either && flows || block.optional && last.is_some();
        self.compensates_at_number |= either && names(block, b"N");
    }

    fn m_word(&mut self, block: &Block, m: f64) {
        self.makers.m_word(m);
        self.survey.jumps |= m == 99.0 && names(block, b"P");
        self.survey.changes_tools |= m == 6.0;
        self.survey.mirrors |= m == 21.0 || m == 22.0;
        self.ended |= m == 2.0 || m == 30.0;
        self.survey.repeats |= m == 99.0 && !self.ended;
        self.counts |= m == 82.0 || m == 83.0;
        self.survey.printer |= [104.0, 109.0, 140.0, 190.0].contains(&m) && names(block, b"SR");
    }

    fn g_word(&mut self, k: usize, block: &Block, c: u32) {
        self.survey.codes.insert(c);
        self.survey.programs.g_word(c, block.optional);
        self.survey.macros += usize::from(matches!(c, 660 | 661));
        let across = Across::of_g_word(block, c);
        self.survey.across.extend(across);
        let of_maker = self.makers.g_word(block, c) || is_numbered_frame(block, c) || is_corner_mode(block, c);
        let followed = is_followed(c) || across.is_some() || acts_once(block, c) || of_maker;
        if !followed || c == 50 && !has_axes(block) && !is_high_speed(block, c) || c == 100 && !moves_offsets(block) {
            self.unfollowed.insert(c);
        }
        // by what they do
        match c {
            500 if has_axes(block) => drop(self.survey.codes.insert(920)),
            540 if work_frame(block, 540, k) != 540 => drop(self.survey.codes.insert(541)),
            501 | 511 => drop(self.survey.codes.insert(920)),
            _ => {}
        }
    }

    fn settle(mut self) -> Survey {
        let mut survey = self.survey;
        let plain = |c: &u32| PLAIN.contains(c) || (540..600).contains(c) || (810..900).contains(c);
        let stands = survey.called.is_subset(&survey.subs);
        let inside = !survey.outside && stands;
        survey.lacks = !stands;
        survey.whole = inside && !survey.hidden && survey.codes.iter().all(plain);
        survey.printer |= self.extrudes && self.counts;
        survey.has_y = self.signs.y;
        survey.siemens = self.signs.units(&mut survey.codes, &mut self.unfollowed);
        let numbers = survey.jumps || !survey.labels.is_empty();
        let at_flow = self.compensates_at_flow || numbers && self.compensates_at_number;
        let compensates = [410, 411, 420, 421].iter().any(|c| survey.codes.contains(c));
        survey.leaves_compensation = compensates && (at_flow || survey.hidden);
        // controls whose words say what X counts have no turning cycles G90 and G94
        survey.lathe = self.signs.cycles() && !survey.printer && !survey.across.iter().any(|a| *a != Across::Radius);
        survey.diameters = self.signs.diameters(&survey.codes, survey.changes_tools) && !survey.printer;
        self.makers.settle(&mut survey, &mut self.unfollowed);
        // a lathe's tailstock; not read by printers
        survey.mirrors &= !survey.lathe && !survey.printer;
        if survey.mirrors {
            // a frame that is moved
            survey.codes.insert(920);
        }
        // a printer's G10 moves filament
        let of_printer = |c: u32| survey.printer && (PROBES.contains(&c) || c == 100);
        if survey.printer && survey.codes.contains(&310) {
            self.unfollowed.insert(310);
        }
        survey.unfollowed = self.unfollowed.into_iter().find(|c| !of_printer(*c));
        survey
    }
}

/// Whether axis words of a block, and I, J, K and R, may be those of a place to which a move leads: arguments of a macro, a time and an
/// offset are none, and of a cycle the axis words alone.
fn leads(block: &Block) -> [bool; 2] {
    let codes = || block.words.iter().filter(|w| w.letter == b'G').filter_map(|w| w.value).map(|v| code(v.0));
    let axes = !codes().any(|c| matches!(c, 40 | 100 | 650 | 660 | 661));
    [axes, !codes().any(|c| CANNED.contains(&c))]
}

/// Whether a G10 changes offsets of tools or work frames and nothing else: with R it may turn a work frame, with other L it sets
/// parameters of the control.
///
/// `offsets = "G10" "L" ("2" | "20") | "G10" "L" ("1" | "10" | "11" | "12" | "13")`
pub(super) fn moves_offsets(block: &Block) -> bool {
    let l = block.words.iter().find(|w| w.letter == b'L').and_then(|w| w.value).map(|v| v.0);
    match l {
        Some(2.0 | 20.0) => !names(block, b"R"),
        Some(l) => [1.0, 10.0, 11.0, 12.0, 13.0].contains(&l),
        None => false,
    }
}

/// Words of controls that mean the same as before after their block: a skip G31 with axes, and G103, a limit of the look-ahead (Haas).
pub(super) fn acts_once(block: &Block, c: u32) -> bool {
    match c {
        310 => has_axes(block),
        1030 => !has_axes(block),
        _ => false,
    }
}

/// Whether axes are named without a place: `G162 X Y`.
pub(super) fn homes(block: &Block) -> bool {
    has_axes(block) && block.words.iter().all(|w| !AXES.contains(&w.letter) || w.value.is_none())
}
