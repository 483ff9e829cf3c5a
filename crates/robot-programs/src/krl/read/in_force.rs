//! Which base and tool may be in force after each line, and what makes any base mean something else: followed through branches, loops,
//! labels and the routines of the file ([`reach`](crate::script::reach)).
//!
//! A line that sets a base, a tool, `$IPO_MODE` or `$WORLD` is a setting of its kind. What a frame is computed from (`N` of `BASE_DATA[N]`)
//! is followed alike, by the lines that assign it: see [`versions`](super::versions).

use super::ahead::passed;
use super::scan::{Found, Scan, own_routines};
use super::versions::{Names, Versions};
use crate::krl::data::Data;
use crate::krl::going::Going;
use crate::krl::lex::{begins_with, first_word};
use crate::krl::lists::{Lists, one_of};
use crate::krl::outside::Outside;
use crate::krl::reason::MovesBase;
use crate::krl::still::Still;
use crate::script::Text;
use crate::script::pose::Frame;
use crate::script::reach::{Atoms, BEFORE, Block, Event, FIRST, Reach, Routine, State, add, set_by};
use std::collections::{BTreeMap, BTreeSet};

/// Kinds of settings: base and tool (as their lists), and what moves a base.
pub(super) const CARRIED: usize = 2;
pub(super) const MOVED: usize = 3;
/// The first kind of what frames are computed from.
pub(super) const ASSIGNED: usize = 4;

/// What `$IPO_MODE` and frame data make of a base, as atoms.
pub(super) const IPO: [Option<MovesBase>; 3] = [None, Some(MovesBase::IpoMode), Some(MovesBase::HoldsPart)];
pub(super) const WORLD: [MovesBase; 2] = [MovesBase::World, MovesBase::RobRoot];

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
        let sets = sets || !outside.sets.values().all(|s| s.is_empty());
        if !sets && memchr::memmem::find(&text.bytes.to_ascii_uppercase(), b"WITH").is_none() {
            return Self::default();
        }
        let names = Names::of(text, data);
        if !sets && !names.any_depends() {
            return Self::default();
        }
        let (own, out) = (own_routines(text), Found::default());
        let mut scan = Scan { text, data, going, outside, still, lists, names: &names, own, passed, moves: None, out };
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

/// The name of what no file has.
pub(super) const ELSEWHERE: &str = "?";

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
