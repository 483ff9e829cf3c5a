//! Which base and tool may be in force after each line, and what makes any base mean something else: followed through branches, loops,
//! labels and the routines of the file ([`reach`]).
//!
//! A line that sets a base, a tool, `$IPO_MODE` or `$WORLD` is a setting of its kind. What a frame is computed from (`N` of `BASE_DATA[N]`) is
//! followed alike, by the lines that assign it: see [`versions`](super::versions).

use super::ahead::{by_a_routine, passed};
use super::versions::{Names, Versions};
use crate::krl::calls::{self, calls};
use crate::krl::data::Data;
use crate::krl::going::Going;
use crate::krl::lex::{Kind, Token, begins_with, first_word, in_upper, tokens, upper};
use crate::krl::lists::{Lists, one_of};
use crate::krl::motion;
use crate::krl::outside::Outside;
use crate::krl::reason::MovesBase;
use crate::krl::settings::Settings;
use crate::krl::statement::{assignment, is_label, is_routine, routine_name};
use crate::krl::still::{Still, may_begin_routine};
use crate::script::Text;
use crate::script::blocks::is_entered;
use crate::script::pose::Frame;
use crate::script::reach::{Atoms, BEFORE, Block, Event, FIRST, Reach, Routine, State};
use std::collections::{BTreeMap, BTreeSet};

/// Kinds of settings: base and tool (as their lists), and what moves a base.
pub(super) const CARRIED: usize = 2;
pub(super) const MOVED: usize = 3;
/// The first kind of what frames are computed from.
pub(super) const ASSIGNED: usize = 4;

/// What `$IPO_MODE` and frame data make of a base, as atoms.
const IPO: [Option<MovesBase>; 3] = [None, Some(MovesBase::IpoMode), Some(MovesBase::HoldsPart)];
const WORLD: [MovesBase; 2] = [MovesBase::World, MovesBase::RobRoot];

/// What is in force at a place.
#[derive(Debug, Default, Clone, PartialEq)]
pub(super) struct InForce {
    /// $BASE and $TOOL; `None`: those with which the program starts.
    pub frames: [Option<Frame>; 2],
    pub carried: Option<MovesBase>,
    pub moved: Option<MovesBase>,
}

/// A statement that sets a frame.
#[derive(Debug, Clone)]
pub(super) struct Setting {
    pub line: usize,
    pub list: usize,
    pub frame: Frame,
    /// It sets a part of the one before.
    pub part: bool,
}

/// What may be in force after each line.
#[derive(Default)]
pub(super) struct Force {
    reach: Reach,
    /// The first line of each routine but what stands before the first one.
    routines: Vec<usize>,
    settings: Vec<Setting>,
    versions: Versions,
    /// What an interrupt may set at any place.
    always: State,
    /// What may be in force where nothing is known.
    unknown: State,
}

impl Force {
    /// Of the program's text. Nothing is followed where nothing is set.
    pub(super) fn of(text: &Text, data: &Data, going: &Going, outside: &Outside, still: &Still, lists: &Lists) -> Self {
        let passed = passed(text);
        let sets = sets_any(text) || passed.iter().any(|p| !p.is_empty());
        if !sets && outside.sets.values().all(|s| s.is_empty()) {
            return Self::default();
        }
        let names = Names::of(text, data);
        let (own, out) = (own_routines(text), Found::default());
        let mut scan = Scan { text, data, going, outside, still, lists, names: &names, own, passed, out };
        scan.lines();
        let Found { mut routines, first, settings, interrupts, resumes, .. } = scan.out;
        // what was there before stays where nothing else is set
        for list in 0..2 {
            let sets = |(_, e): &(usize, Event)| matches!(e, Event::Set(of, to) if *of == list && *to >= FIRST);
            if !routines.iter().any(|r| r.events.iter().any(sets)) {
                let other = |e: &(usize, Event)| !matches!(e.1, Event::Reset(of, _) if of == list);
                routines.iter_mut().for_each(|r| r.events.retain(other));
            }
        }
        let kinds = ASSIGNED + names.len();
        let unknown = unknown(&routines, kinds);
        routines.push(elsewhere(&unknown));
        let mut starts: Vec<Option<State>> = vec![None; routines.len()];
        let called = |name: &str| {
            let is = |(_, e): &(usize, Event)| matches!(e, Event::Call(called) if called == name);
            routines.iter().any(|r| r.events.iter().any(is))
        };
        let main = routines.iter().position(|r| !r.name.is_empty()).unwrap_or_default();
        for (k, (start, routine)) in starts.iter_mut().zip(&routines).enumerate() {
            if k <= main || routine.name == ELSEWHERE {
                *start = Some(vec![Atoms::from([BEFORE]); kinds]);
            } else if interrupts.contains(&routine.name) || !called(&routine.name) {
                *start = Some(unknown.clone());
            }
        }
        let always = match resumes {
            true => unknown.clone(),
            false => set_by(&routines, &interrupts, kinds),
        };
        let reach = Reach::of(&routines, &starts, &unknown);
        let mut force = Self { reach, routines: first, settings, versions: Versions::default(), always, unknown };
        force.versions = Versions::of(names, &force.settings, |kind, line| force.before(kind, line));
        force.versions.changed_at.extend(changing(&routines, &force.versions.kinds, kinds));
        for k in 0..force.settings.len() {
            let Setting { line, list, frame, part } = force.settings[k].clone();
            let frame = force.versions.named(list, line, frame);
            let uncertain = part && force.before(list, line).len() > 1;
            force.settings[k].frame = if uncertain { Versions::unclear() } else { frame };
        }
        force
    }

    fn routine(&self, line: usize) -> usize {
        self.routines.partition_point(|first| *first <= line)
    }

    fn state(&self, kind: usize, line: usize) -> Atoms {
        let state = self.reach.after(self.routine(line), line).unwrap_or(&self.unknown);
        let of = |state: &State| state.get(kind).cloned().unwrap_or_default();
        of(state).union(&of(&self.always)).copied().collect()
    }

    /// What may be in force before a line of a routine.
    fn before(&self, kind: usize, line: usize) -> Atoms {
        let before = line.checked_sub(1).filter(|k| self.routine(*k) == self.routine(line));
        before.map_or_else(|| self.unknown.get(kind).cloned().unwrap_or_default(), |k| self.state(kind, k))
    }

    /// What is in force after a line.
    pub(super) fn after(&self, line: usize) -> InForce {
        if self.unknown.is_empty() {
            return InForce::default();
        }
        let frame = |list: usize, name: &str| {
            let of = |atom: &u32| {
                let setting = atom.checked_sub(FIRST).and_then(|k| self.settings.get(k as usize));
                setting.map(|s| s.frame.clone())
            };
            let mut all = self.state(list, line).into_iter().map(|atom| of(&atom));
            let first = all.next().flatten();
            all.fold(first, |all, frame| one_of(all.as_ref(), name, frame.as_ref()))
        };
        let at = |atom: u32| atom.checked_sub(FIRST).map(|k| k as usize);
        let carried = self.state(CARRIED, line).into_iter().filter_map(at).find_map(|k| IPO.get(k).copied().flatten());
        let moved = self.state(MOVED, line).into_iter().filter_map(at).find_map(|k| WORLD.get(k).copied());
        InForce { frames: [frame(0, "$BASE"), frame(1, "$TOOL")], carried, moved }
    }

    /// A frame that a line sets, by the name that tells it from others of the same words.
    pub(super) fn named(&self, list: usize, line: usize, frame: Frame) -> Frame {
        let first = self.settings.partition_point(|s| s.line < line);
        let own = self.settings.iter().skip(first).take_while(|s| s.line == line);
        match own.into_iter().find(|s| s.list == list && s.part) {
            Some(set) => set.frame.clone(),
            None => self.versions.named(list, line, frame),
        }
    }

    /// Whether a line assigns anything that a frame is computed from: what the frame is called by may be another one after it.
    pub(super) fn changes_frames(&self, line: usize) -> bool {
        self.versions.changed_at.contains(&line)
    }
}

/// Names of the routines of a text.
fn own_routines(text: &Text) -> BTreeSet<String> {
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

/// Whether a text sets a frame, or what it means.
///
/// `setting = "BAS" ... | ("$BASE" | "$TOOL" | "FDAT_ACT" | "$IPO_MODE" | "$WORLD" | "$ROBROOT") ... "=" ...`
fn sets_any(text: &Text) -> bool {
    const WORDS: [&str; 7] = ["BAS", "$BASE", "$TOOL", "FDAT_ACT", "$IPO_MODE", "$WORLD", "$ROBROOT"];
    (0..text.line_count()).any(|k| {
        begins_with(text, k, b"B$F") && {
            let word = first_word(text, k);
            let end = word.iter().position(|b| !(b.is_ascii_alphanumeric() || matches!(b, b'_' | b'$')));
            let word = &word[..end.unwrap_or(word.len())];
            WORDS.iter().any(|w| word.eq_ignore_ascii_case(w.as_bytes()))
        }
    })
}

/// What any of the routines sets, and what was there before.
fn unknown(routines: &[Routine], kinds: usize) -> State {
    let mut all = vec![Atoms::from([BEFORE]); kinds];
    for (_, event) in routines.iter().flat_map(|r| &r.events) {
        add(event, &mut all);
    }
    all
}

fn add(event: &Event, all: &mut State) {
    if let Event::Set(kind, to) | Event::Reset(kind, to) = event
        && let Some(atoms) = all.get_mut(*kind)
    {
        atoms.insert(*to);
    }
}

/// The name of what no file has.
const ELSEWHERE: &str = "?";

/// A routine that no file has: what is in force after it may be anything that the file sets.
fn elsewhere(all: &State) -> Routine {
    let mut events = Vec::new();
    for (kind, atoms) in all.iter().enumerate().take(ASSIGNED) {
        events.push((0, Event::Open(Block::Switch)));
        for atom in atoms.iter().filter(|a| **a >= FIRST) {
            events.extend([(0, Event::Middle(false)), (0, Event::Set(kind, *atom))]);
        }
        events.push((0, Event::Close));
    }
    Routine { name: ELSEWHERE.into(), events }
}

/// Lines that assign, themselves or by a routine that they call, one of these kinds of what frames are computed from.
fn changing(routines: &[Routine], used: &BTreeSet<usize>, kinds: usize) -> BTreeSet<usize> {
    if used.is_empty() {
        return BTreeSet::new();
    }
    let mut by_name: BTreeMap<&str, bool> = BTreeMap::new();
    let mut lines = BTreeSet::new();
    for (line, event) in routines.iter().flat_map(|r| &r.events) {
        let changes = match event {
            Event::Set(kind, _) => used.iter().any(|k| k + ASSIGNED == *kind),
            Event::Call(name) => *by_name.entry(name).or_insert_with(|| {
                let sets = set_by(routines, &BTreeSet::from([name.clone()]), kinds);
                used.iter().any(|k| !sets[k + ASSIGNED].is_empty())
            }),
            _ => false,
        };
        if changes {
            lines.insert(*line);
        }
    }
    lines
}

/// What routines set, themselves or by those that they call.
fn set_by(routines: &[Routine], names: &BTreeSet<String>, kinds: usize) -> State {
    let (mut open, mut seen) = (names.clone(), BTreeSet::new());
    let mut all = vec![Atoms::new(); kinds];
    while let Some(name) = open.pop_first() {
        if !seen.insert(name.clone()) {
            continue;
        }
        for (_, event) in routines.iter().filter(|r| r.name == name).flat_map(|r| &r.events) {
            add(event, &mut all);
            if let Event::Call(name) = event {
                open.insert(name.clone());
            }
        }
    }
    all
}

/// What a look at all lines has found.
#[derive(Default)]
struct Found {
    routines: Vec<Routine>,
    /// Their first lines, but of what stands before the first one.
    first: Vec<usize>,
    settings: Vec<Setting>,
    /// By frame, those of which the words do not tell which it is left out.
    plain: BTreeMap<(usize, String), u32>,
    /// Routines that interrupts call.
    interrupts: BTreeSet<String>,
    resumes: bool,
}

struct Scan<'a> {
    text: &'a Text,
    data: &'a Data,
    going: &'a Going,
    outside: &'a Outside,
    still: &'a Still,
    lists: &'a Lists,
    names: &'a Names,
    /// Routines of the text.
    own: BTreeSet<String>,
    passed: [BTreeSet<u64>; 2],
    out: Found,
}

impl Scan<'_> {
    fn lines(&mut self) {
        let (mut line, mut set, mut blocks) = (Vec::new(), Settings::default(), Vec::new());
        self.out.routines.push(Routine::default());
        for k in 0..self.text.line_count() {
            let word = first_word(self.text, k);
            // of most motions nothing is called
            let called = || memchr::memchr(b'(', self.text.line(k)).is_some();
            if word.is_empty()
                || motion::word(&String::from_utf8_lossy(word).to_ascii_uppercase()).is_some() && !called()
            {
                continue;
            }
            tokens(self.text, k, &mut line);
            line.retain(|t| t.kind != Kind::Comment);
            if let Some(first) = line.first().filter(|t| !t.is(b'&')) {
                let word = upper(self.text, first);
                let second = line.get(1).map(|t| upper(self.text, t)).unwrap_or_default();
                self.statement(k, &line, (&word, &second), &mut set, &mut blocks);
            }
        }
    }

    fn push(&mut self, k: usize, event: Event) {
        if let Some(routine) = self.out.routines.last_mut() {
            routine.events.push((k, event));
        }
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
        // where control comes from elsewhere, which frame data are in force is not known
        let joined = |set: &mut Settings, unset: Option<bool>| {
            if let Some(unset) = unset {
                set.lists.merge_all(self.lists, unset);
            }
            set.frame_data = None;
        };
        match word {
            _ if is_routine(word, second) => {
                blocks.clear();
                joined(set, Some(true));
                self.out.first.push(k);
                let name = routine_name(self.text, line);
                return self.out.routines.push(Routine { name, events: Vec::new() });
            }
            _ if is_label(line) => {
                joined(set, Some(true));
                return self.push(k, Event::Label(word.to_string()));
            }
            "IF" | "SWITCH" | "LOOP" | "FOR" | "WHILE" | "REPEAT" => {
                blocks.push(set.lists.clone());
                joined(set, (!matches!(word, "IF" | "SWITCH")).then_some(false));
                self.push(k, Event::Open(block(self.text, line, word)));
            }
            "ELSE" | "CASE" | "DEFAULT" => {
                if let Some(before) = blocks.last() {
                    set.lists.merge(before);
                }
                joined(set, None);
                self.push(k, Event::Middle(word != "CASE"));
            }
            "ENDIF" | "ENDSWITCH" | "ENDLOOP" | "ENDFOR" | "ENDWHILE" | "UNTIL" => {
                self.called(k, line, set);
                if let Some(before) = blocks.pop() {
                    set.lists.merge(&before);
                }
                joined(set, None);
                return self.push(k, Event::Close);
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
        self.called(k, line, set);
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

    /// What a line calls, in its order: routines of the program, and what those of other files set.
    fn called(&mut self, k: usize, line: &[Token], set: &mut Settings) {
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
                set.bas(self.text, line);
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
