//! Which TCP may be in force at each move, what may lead the robot away from its targets there, and which moves may come last before the
//! program reads where the robot stands, or acts (switches, reads, waits): followed through branches, loops and the functions of the file
//! in the order in which they run ([`reach`](crate::script::reach)), not in that of the text. A thread reads at any time, and so after no
//! move that is known.

use super::arguments::call;
use super::lex::Kind;
use super::read::{Item, ItemKind, Parsed};
use super::words;
use crate::script::Text;
use crate::script::blocks::is_entered;
use crate::script::reach::{Atoms, BEFORE, Block, Event, FIRST, Reach, Routine, State, add, set_by};
use std::collections::{BTreeSet, HashSet};

/// Kinds of settings.
const TCP: usize = 0;
const LED: usize = 1;
/// The move that came last.
const LAST: usize = 2;
const KINDS: usize = 3;

/// What may be in force before each item.
pub struct InForce {
    reach: Reach,
    /// What threads may set at any place.
    always: State,
    /// What may be in force where nothing is known.
    unknown: State,
    /// Functions that lead the robot, by their atoms.
    leaders: Vec<&'static str>,
}

/// Events of the functions of a file; that of a `set_tcp` is its item.
struct Scan<'a> {
    text: &'a Text,
    p: &'a Parsed,
    routines: Vec<Routine>,
    threads: BTreeSet<String>,
    leaders: Vec<&'static str>,
    /// Items before which the last move is looked for, ascending.
    asked: &'a [usize],
}

impl InForce {
    /// Of a file that starts with the function `entry`; `None`: with what stands outside of functions. `tcps`: atom of each item that sets
    /// a TCP; `asked`: items before which the last move is looked for, ascending.
    pub fn of(
        text: &Text,
        p: &Parsed,
        entry: Option<usize>,
        tcps: &dyn Fn(usize) -> Option<u32>,
        asked: &[usize],
    ) -> Self {
        let named = |(name, _): &(String, Option<usize>)| Routine { name: name.clone(), events: Vec::new() };
        let routines = std::iter::once(Routine::default()).chain(p.defs.iter().map(named)).collect();
        let mut scan = Scan { text, p, routines, threads: BTreeSet::new(), leaders: Vec::new(), asked };
        for (k, item) in p.items.iter().enumerate() {
            scan.item(k, item, tcps(k));
        }
        let Scan { routines, threads, leaders, .. } = scan;
        let before = || Atoms::from([BEFORE]);
        let mut all = vec![before(); KINDS];
        routines.iter().flat_map(|r| &r.events).for_each(|(_, event)| add(event, &mut all));
        all[LAST] = before();
        // a function that nothing calls is led by nothing that others begin
        let unknown = vec![all[TCP].clone(), before(), before()];
        let start = |(k, routine): (usize, &Routine)| match () {
            () if threads.contains(&routine.name) => Some(all.clone()),
            () if k == 0 || entry == Some(k - 1) => Some(vec![before(); KINDS]),
            () => None,
        };
        let starts: Vec<Option<State>> = routines.iter().enumerate().map(start).collect();
        let always = set_by(&routines, &threads, KINDS);
        Self { reach: Reach::of(&routines, &starts, &unknown), always, unknown, leaders }
    }

    fn atoms(&self, kind: usize, def: Option<usize>, item: usize) -> impl Iterator<Item = u32> {
        let state = self.reach.after(def.map_or(0, |d| d + 1), item).unwrap_or(&self.unknown);
        let all: Atoms = state[kind].union(&self.always[kind]).copied().collect();
        all.into_iter()
    }

    /// Atoms of the TCPs that may be in force before an item of a function.
    pub fn tcps(&self, def: Option<usize>, item: usize) -> impl Iterator<Item = u32> {
        self.atoms(TCP, def, item)
    }

    /// Items whose moves may come last before one of these items of the text, which must have been asked for.
    pub fn last_before(&self, p: &Parsed, items: &[usize]) -> BTreeSet<usize> {
        let item_of = |atom: u32| atom.checked_sub(FIRST).map(|k| k as usize);
        // what its own condition or expression calls has moved before it
        let places = items.iter().flat_map(|k| [(*k, *k), (*k, *k + 1)]);
        let def = |k: usize| p.items.get(k).and_then(|item| item.def);
        places.flat_map(|(k, place)| self.atoms(LAST, def(k), place)).filter_map(item_of).collect()
    }

    /// The function by which something may lead the robot before an item.
    pub fn led(&self, def: Option<usize>, item: usize) -> Option<&'static str> {
        let of = |atom: u32| self.leaders.get(atom.checked_sub(FIRST + 1)? as usize).copied();
        self.atoms(LED, def, item).find_map(of)
    }
}

impl Scan<'_> {
    /// An event of an item: it holds from the next one on.
    fn push(&mut self, k: usize, item: &Item, event: Event) {
        if let Some(routine) = self.routines.get_mut(item.def.map_or(0, |d| d + 1)) {
            routine.events.push((k + 1, event));
        }
    }

    fn item(&mut self, k: usize, item: &Item, tcp: Option<u32>) {
        let p = self.p;
        let event = block(self.text, p, item);
        match item.kind {
            ItemKind::Start => return,
            ItemKind::Loop | ItemKind::Middle => {
                event.into_iter().for_each(|event| self.push(k, item, event));
                self.called(k, item);
            }
            _ => {
                self.called(k, item);
                if matches!(item.kind, ItemKind::Assign { .. } | ItemKind::Other)
                    && !self.asked.is_empty()
                    && call(p, item).is_some()
                    && let Some(routine) = self.routines.get_mut(item.def.map_or(0, |d| d + 1))
                {
                    routine.comes_last(k + 1, LAST, k, self.asked);
                }
                event.into_iter().for_each(|event| self.push(k, item, event));
            }
        }
        if let Some(tcp) = tcp {
            self.push(k, item, Event::Set(TCP, tcp));
        }
    }

    /// What an item calls: functions of the file, and those that lead the robot or end it. A thread runs beside what follows.
    fn called(&mut self, k: usize, item: &Item) {
        let p = self.p;
        let runs = p.words.within(item.span.clone()).any(|w| w == "run");
        for name in p.called(item) {
            match words::leads(name) {
                Some(None) => self.push(k, item, Event::Set(LED, FIRST)),
                Some(Some(on)) => {
                    let at = self.leaders.iter().position(|l| *l == on).unwrap_or_else(|| {
                        self.leaders.push(on);
                        self.leaders.len() - 1
                    });
                    self.push(k, item, Event::Set(LED, FIRST + 1 + at as u32));
                }
                None if runs => drop(self.threads.insert(name.to_string())),
                None => self.push(k, item, Event::Call(name.to_string())),
            }
        }
        if runs {
            // `run th` without brackets
            let own = |w: &&str| p.defs.iter().any(|(name, _)| name == w);
            let names: Vec<String> = p.words.within(item.span.clone()).filter(own).map(str::to_string).collect();
            self.threads.extend(names);
        }
    }
}

/// Where control goes with an item; `None`: on to the next.
pub fn block(text: &Text, p: &Parsed, item: &Item) -> Option<Event> {
    Some(match (item.kind, p.words.at(item.span.start)) {
        (ItemKind::Branch, _) => {
            let head = item.span.start.checked_sub(1).map_or("", |at| p.words.at(at));
            Event::Open(if head == "switch" { Block::Switch } else { Block::Branch })
        }
        (ItemKind::Loop, _) => {
            let tokens = p.tokens.get(item.span.clone()).unwrap_or_default();
            let bytes = tokens.first().map_or(0, |t| t.start())..tokens.last().map_or(0, |t| t.end());
            let endless = is_entered(&[b"while ", text.slice(bytes)].concat());
            Event::Open(if endless { Block::Endless } else { Block::Loop })
        }
        (ItemKind::Middle, _) => Event::Middle(item.span.is_empty()),
        (ItemKind::EndBranch | ItemKind::EndLoop, _) => Event::Close,
        (ItemKind::Other, "return") => Event::End,
        (ItemKind::Other, "break") => Event::Leave,
        (ItemKind::Other, "continue") => Event::Skip,
        _ => return None,
    })
}

/// Functions that the file calls at more than one place.
pub fn called_twice(p: &Parsed) -> HashSet<&str> {
    let mut seen = HashSet::new();
    p.items.iter().flat_map(|item| p.called(item)).filter(|name| !seen.insert(*name)).collect()
}

/// Whether what an expression of these tokens gives may be another value at another time: it calls something, or a name in it is a
/// parameter, or may be assigned anew.
pub fn may_differ(p: &Parsed, def: Option<usize>, span: std::ops::Range<usize>) -> bool {
    span.clone().any(|i| {
        let name = p.words.at(i);
        let calls = i + 1 < span.end && p.tokens.get(i + 1).is_some_and(|t| t.kind == Kind::Mark(b'('));
        let assigned = || {
            let key = p.key(def, name)?;
            p.variables.get(&key).map(|v| v.assigned.len() > 1 || v.changed.is_some())
        };
        !name.is_empty()
            && !words::is_reserved(name)
            && (calls || assigned().unwrap_or_else(|| p.is_parameter(def, name)))
    })
}

/// Whether an item takes on where the robot stands, or where its last move leads: into the program, not into a message or to another
/// device.
pub fn reads_place(p: &Parsed, item: &Item) -> bool {
    const PLACES: [&str; 8] = [
        "get_actual_tcp_pose",
        "get_target_tcp_pose",
        "get_actual_joint_positions",
        "get_actual_joint_positions_history",
        "get_target_joint_positions",
        "get_actual_tool_flange_pose",
        "get_joint_positions",
        "get_target_waypoint",
    ];
    let word = p.words.at(item.span.start);
    let writes = matches!(word, "textmsg" | "popup") || word.starts_with("socket_") || word.starts_with("rpc_");
    if item.kind == ItemKind::Start || item.kind == ItemKind::Other && writes {
        return false;
    }
    // without joints it is the pose of those at which the robot stands
    let here = |i: usize| p.tokens.get(i + 2).is_some_and(|t| t.kind == Kind::Mark(b')'));
    item.span.clone().any(|i| PLACES.contains(&p.words.at(i)) || p.words.at(i) == "get_forward_kin" && here(i))
}
