//! What each line of a text means for the base and the tool in force: the events that [`in_force`](super::in_force) follows.

use super::ahead::by_a_routine;
use super::in_force::{ASSIGNED, CARRIED, ELSEWHERE, IPO, MOVED, Setting, WORLD};
use super::versions::Names;
use crate::krl::calls::{self, calls};
use crate::krl::data::Data;
use crate::krl::going::Going;
use crate::krl::lex::{Kind, Token, begins_with, first_word, in_upper, tokens, upper};
use crate::krl::lists::Lists;
use crate::krl::motion;
use crate::krl::outside::Outside;
use crate::krl::reason::MovesBase;
use crate::krl::settings::{self, Settings};
use crate::krl::statement::{assignment, is_label, is_routine, routine_name};
use crate::krl::still::{Still, may_begin_routine};
use crate::script::Text;
use crate::script::blocks::is_entered;
use crate::script::lex::upper_of;
use crate::script::pose::Frame;
use crate::script::reach::{BEFORE, Block, Event, FIRST, Routine};
use std::collections::{BTreeMap, BTreeSet};

/// Names of the routines of a text.
pub(super) fn own_routines(text: &Text) -> BTreeSet<String> {
    let (mut names, mut line) = (BTreeSet::new(), Vec::new());
    for k in (0..text.line_count()).filter(|k| begins_with(text, *k, b"DG") && may_begin_routine(first_word(text, *k)))
    {
        tokens(text, k, &mut line);
        let words: Vec<String> = line.iter().take(2).map(|t| upper(text, t)).collect();
        if matches!(words.as_slice(), [first, second] if is_routine(first, second)) {
            names.insert(routine_name(text, &line));
        }
    }
    names
}

/// What a look at all lines has found.
#[derive(Default)]
pub(super) struct Found {
    pub(super) routines: Vec<Routine>,
    /// Their first lines, but of what stands before the first one.
    pub(super) first: Vec<usize>,
    pub(super) settings: Vec<Setting>,
    /// Settings by frame, but those that their words do not tell.
    plain: BTreeMap<(usize, String), u32>,
    /// Routines that interrupts call.
    pub(super) interrupts: BTreeSet<String>,
    /// Those that are called elsewhere on the way than where the call stands.
    pub(super) apart: BTreeSet<String>,
    pub(super) resumes: bool,
}

pub(super) struct Scan<'a> {
    pub(super) text: &'a Text,
    pub(super) data: &'a Data,
    pub(super) going: &'a Going,
    pub(super) outside: &'a Outside,
    pub(super) still: &'a Still,
    pub(super) lists: &'a Lists,
    pub(super) names: &'a Names,
    /// Routines of the text.
    pub(super) own: BTreeSet<String>,
    pub(super) passed: [BTreeSet<u64>; 2],
    /// Where it is asked for which moves come last.
    pub(super) moves: Option<Moves<'a>>,
    pub(super) out: Found,
}

/// Lines that move, and those before which it is asked which of them came last, ascending; the number of this kind.
#[derive(Clone, Copy)]
pub(super) struct Moves<'a> {
    pub(super) lines: &'a BTreeSet<usize>,
    pub(super) asked: &'a [usize],
    pub(super) kind: usize,
    /// Lines whose calls run elsewhere on the way.
    pub(super) apart: &'a BTreeSet<usize>,
}

impl Scan<'_> {
    /// Looks at all lines.
    pub(super) fn lines(&mut self) {
        let (mut line, mut set, mut blocks) = (Vec::new(), Settings::default(), Vec::new());
        self.out.routines.push(Routine::default());
        let text = self.text;
        let mut calling = text.lines_with(b"(").peekable();
        for k in 0..self.text.line_count() {
            let word = first_word(self.text, k);
            let calls = calling.next_if_eq(&k).is_some();
            // of most motions nothing is called, and no frame depends on what is assigned
            let called = || calls || self.names.depends(k);
            let nothing = word.is_empty() || motion::word(&upper_of(word)).is_some() && !called();
            if !nothing {
                tokens(self.text, k, &mut line);
                line.retain(|t| t.kind != Kind::Comment);
                if let Some(first) = line.first().filter(|t| !t.is(b'&')) {
                    let word = upper(self.text, first);
                    let second = line.get(1).map(|t| upper(self.text, t)).unwrap_or_default();
                    self.statement(k, &line, (&word, &second), &mut set, &mut blocks);
                }
            }
            if let (Some(moves), Some(routine)) = (self.moves, self.out.routines.last_mut())
                && moves.lines.contains(&k)
            {
                routine.comes_last(k, moves.kind, k, moves.asked);
            }
        }
    }

    fn push(&mut self, k: usize, event: Event) {
        if let Some(routine) = self.out.routines.last_mut() {
            routine.events.push((k, event));
        }
    }

    /// Control comes from elsewhere, too: which frame data are in force is not known. `unset`: nothing above may have run; `None`: a
    /// branch.
    fn joined(&self, set: &mut Settings, unset: Option<bool>) {
        if let Some(unset) = unset {
            set.lists.merge_all(self.lists, unset);
        }
        set.frame_data = None;
    }

    /// A line: the start of a routine, a label, a block, a jump, or what it calls and sets.
    fn statement(
        &mut self,
        k: usize,
        line: &[Token],
        (word, second): (&str, &str),
        set: &mut Settings,
        blocks: &mut Vec<Lists>,
    ) {
        match word {
            _ if is_routine(word, second) => {
                blocks.clear();
                self.joined(set, Some(true));
                self.out.first.push(k);
                let name = routine_name(self.text, line);
                return self.out.routines.push(Routine { name, events: Vec::new() });
            }
            _ if is_label(line) => {
                self.joined(set, Some(true));
                return self.push(k, Event::Label(word.to_string()));
            }
            "GOTO" => return self.push(k, Event::Jump(second.to_ascii_uppercase())),
            "EXIT" => return self.push(k, Event::Leave),
            "RETURN" | "END" | "ENDFCT" => {
                self.called(k, line, set);
                return self.push(k, Event::End);
            }
            "RESUME" => self.out.resumes = true,
            "INTERRUPT" => return self.out.interrupts.extend(calls(self.text, line)),
            "GLOBAL" if second == "INTERRUPT" => return self.out.interrupts.extend(calls(self.text, line)),
            _ => {}
        }
        if self.block(k, line, word, set, blocks) {
            return;
        }
        self.called(k, line, set);
        if settings::may_have_with(word) {
            return self.with(k, line, set);
        }
        self.sets(k, line, word, set);
        for list in 0..2 {
            if self.passed[list].contains(&(k as u64 + 1)) {
                self.set(k, list, by_a_routine(list), false);
            }
        }
        for kind in self.names.assigned(k) {
            self.push(k, Event::Set(ASSIGNED + kind, FIRST + k as u32));
        }
    }

    /// A block opens, goes on or closes; `true`: nothing more is to be read of the line.
    fn block(&mut self, k: usize, line: &[Token], word: &str, set: &mut Settings, blocks: &mut Vec<Lists>) -> bool {
        match word {
            "IF" | "SWITCH" | "LOOP" | "FOR" | "WHILE" | "REPEAT" => {
                blocks.push(set.lists.clone());
                self.joined(set, (!matches!(word, "IF" | "SWITCH")).then_some(false));
                self.push(k, Event::Open(block(self.text, line, word)));
            }
            "ELSE" | "CASE" | "DEFAULT" => {
                if let Some(before) = blocks.last() {
                    set.lists.merge(before);
                }
                self.joined(set, None);
                self.push(k, Event::Middle(word != "CASE"));
            }
            "ENDIF" | "ENDSWITCH" | "ENDLOOP" | "ENDFOR" | "ENDWHILE" | "UNTIL" => {
                self.called(k, line, set);
                if let Some(before) = blocks.pop() {
                    set.lists.merge(&before);
                }
                self.joined(set, None);
                self.push(k, Event::Close);
                return true;
            }
            _ => {}
        }
        false
    }

    /// What a line calls, in its order: routines of the program, and what those of other files set.
    fn called(&mut self, k: usize, line: &[Token], set: &mut Settings) {
        if self.moves.is_some_and(|moves| moves.apart.contains(&k)) {
            return self.out.apart.extend(calls(self.text, line));
        }
        let names: Vec<String> = calls(self.text, line).into_iter().chain(calls::quiet(self.text, line)).collect();
        if names.is_empty() {
            return;
        }
        let perhaps = line.iter().any(|t| t.kind == Kind::Word && in_upper(self.text, t) == "DO");
        if perhaps {
            self.push(k, Event::Open(Block::Branch));
        }
        for name in names {
            if self.still.waits(&name).is_none() && !calls::is_quiet(&name) {
                set.lists.merge_all(self.lists, false);
                set.frame_data = None;
            }
            let (sets, names) = (self.outside.sets_of(&name), self.names);
            for list in (0..2).filter(|list| sets.frames[*list]) {
                self.set(k, list, by_a_routine(list), false);
            }
            let may = |scan: &mut Self, kind: usize, to: u32| {
                scan.push(k, Event::Open(Block::Branch));
                scan.push(k, Event::Set(kind, FIRST + to));
                scan.push(k, Event::Close);
            };
            if let Some(at) = sets.carried.and_then(|by| IPO.iter().position(|i| *i == Some(by))) {
                may(self, CARRIED, at as u32);
            }
            if let Some(at) = sets.moved.and_then(|by| WORLD.iter().position(|w| *w == by)) {
                may(self, MOVED, at as u32);
            }
            for kind in names.kinds().filter(|kind| sets.assigned.contains(names.variable(*kind))) {
                self.push(k, Event::Set(ASSIGNED + kind, FIRST + k as u32));
            }
            let known = self.own.contains(&name) || self.outside.sets.contains_key(&name);
            let still = known || self.still.waits(&name).is_some() || calls::is_quiet(&name);
            self.push(k, Event::Call(if still { name } else { ELSEWHERE.into() }));
        }
        if perhaps {
            self.push(k, Event::Close);
        }
    }

    /// A frame comes into force.
    fn set(&mut self, k: usize, list: usize, frame: Frame, part: bool) {
        let atom = self.atom(k, list, frame, part);
        self.push(k, Event::Set(list, atom));
    }

    fn atom(&mut self, k: usize, list: usize, frame: Frame, part: bool) -> u32 {
        let next = FIRST + self.out.settings.len() as u32;
        let key = (list, format!("{frame:?}"));
        if !part && !self.names.is_computed(list, k) {
            if let Some(atom) = self.out.plain.get(&key) {
                return *atom;
            }
            self.out.plain.insert(key, next);
        }
        self.out.settings.push(Setting { line: k, list, frame, part });
        next
    }

    /// A motion or a spline block that sets frames for itself: they are named as others are, and hold for nothing else.
    fn with(&mut self, k: usize, line: &[Token], set: &Settings) {
        if !self.names.depends(k) {
            return;
        }
        let frames = settings::with(set, self.text, line, self.data, self.out.first.len());
        let own = frames.into_iter().enumerate().filter_map(|(list, frame)| Some((list, frame?)));
        self.out.settings.extend(own.map(|(list, frame)| Setting { line: k, list, frame, part: false }));
    }

    /// `setting = "BAS" "(" "#" command ... | variable ... "=" ...`
    fn sets(&mut self, k: usize, line: &[Token], word: &str, set: &mut Settings) {
        let sign = assignment(line);
        // what a line leaves as it is keeps this
        let none = || Some(Frame::Named(String::new()));
        (set.base, set.tool) = (none(), none());
        match (word, sign) {
            ("BAS", _) => {
                if line.get(3).is_some_and(|t| upper(self.text, t) == "INITMOV") {
                    (0..2).for_each(|list| self.push(k, Event::Set(list, BEFORE)));
                    return self.push(k, Event::Set(CARRIED, FIRST));
                }
                let known = set.frame_data.is_some();
                set.bas(self.text, line, self.data);
                let of_data = !known
                    && !matches!(
                        in_upper(self.text, line.get(3).unwrap_or(&line[0])).as_ref(),
                        "BASE" | "TOOL" | "EX_BASE"
                    );
                for (list, frame) in [set.base.take(), set.tool.take()].into_iter().enumerate() {
                    match frame.filter(|f| Some(f) != none().as_ref()) {
                        Some(frame) if of_data => {
                            let atom = self.atom(k, list, frame, false);
                            self.push(k, Event::Reset(list, atom));
                        }
                        Some(frame) => self.set(k, list, frame, false),
                        None => {}
                    }
                }
            }
            (_, Some(sign)) => {
                set.assign(self.text, line, sign, word, self.data, self.out.first.len());
                for (list, frame) in [set.base.take(), set.tool.take()].into_iter().enumerate() {
                    let part = word.starts_with('$') && line.get(1).is_some_and(|t| t.is(b'.'));
                    if let Some(frame) = frame.filter(|f| Some(f) != none().as_ref()) {
                        self.set(k, list, frame, part);
                    }
                }
                self.moves_base(k, line, word);
            }
            _ => {}
        }
    }

    /// An assignment that makes any base mean something else, or ends it.
    fn moves_base(&mut self, k: usize, line: &[Token], word: &str) {
        match word {
            "$IPO_MODE" => {
                let back = line.get(3).is_some_and(|t| upper(self.text, t) == "BASE");
                self.push(k, Event::Set(CARRIED, FIRST + u32::from(!back)));
            }
            "FDAT_ACT" if self.going.holds_part(self.text, &line[1..]) => self.push(k, Event::Set(CARRIED, FIRST + 2)),
            "FDAT_ACT" if line.get(1).is_some_and(|t| t.is(b'=')) => self.push(k, Event::Set(CARRIED, FIRST)),
            "$WORLD" | "$ROBROOT" => {
                let at = WORLD.iter().position(|w| *w == MovesBase::of_world(word)).unwrap_or_default();
                self.push(k, Event::Set(MOVED, FIRST + at as u32));
            }
            _ => {}
        }
    }
}

/// What kind of block a line opens.
fn block(text: &Text, line: &[Token], word: &str) -> Block {
    let bytes = line.first().map_or(0, |t| t.start)..line.last().map_or(0, |t| t.end);
    match word {
        "IF" => Block::Branch,
        "SWITCH" => Block::Switch,
        "LOOP" => Block::Endless,
        "REPEAT" => Block::Entered,
        "FOR" if is_entered(text.slice(bytes)) => Block::Entered,
        _ => Block::Loop,
    }
}
