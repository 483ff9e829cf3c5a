//! What holds for a whole file: where the program starts, what leads the arm, and external axes as they are written.

use super::arguments::{Arg, Given, arguments, given};
use super::facts;
use super::lex::Kind;
use super::read::{Item, ItemKind, Parsed};
use super::value::Node;
use super::words;
use crate::axes::Axes;
use crate::script::Text;
use crate::script::cursor::integer;
use crate::script::lex::text_of;
use std::collections::HashSet;

/// `main`, else the first procedure with a move or a call that none of this file calls.
pub fn entry_routine(p: &Parsed, own: &dyn Fn(&Item) -> bool) -> Option<usize> {
    // of the program's own routines
    let ours: HashSet<usize> = p.items.iter().filter(|item| own(item)).map(|item| item.routine).collect();
    let main = p.routines.iter().position(|r| r.name == "main").filter(|k| ours.contains(k));
    let called: HashSet<&str> = p.items.iter().flat_map(|item| facts::called(p, item)).collect();
    let acts = |k: usize| {
        let of = |item: &&Item| item.routine == k && facts::called(p, item).any(|name| !words::is_quiet(name));
        p.items.iter().any(|item| of(&item))
    };
    let may = |k: &usize| p.routines[*k].procedure && !called.contains(p.routines[*k].name.as_str()) && acts(*k);
    main.or_else(|| (0..p.routines.len()).filter(|k| ours.contains(k)).find(may))
}

/// How the arm goes to its targets, in the order of the text of a routine.
#[derive(Clone, Copy, Default)]
pub struct Going {
    /// The instruction by which something leads it away from them.
    pub led: Option<&'static str>,
    /// Axes that `SoftAct` has made soft, as bits.
    soft: u8,
    /// Blocks around the instruction, and around the outermost that made an axis soft.
    depth: usize,
    soft_depth: usize,
    /// On straight ways the wrist turns as its joints do (`SingArea\Wrist`, `\LockAxis4`).
    pub wrist: bool,
}

impl Going {
    /// At the start of each routine: what holds at the end of any of them may hold there.
    pub fn first(text: &Text, p: &Parsed) -> Self {
        let mut first = Self::default();
        let mut now = Self::default();
        for (k, item) in p.items.iter().enumerate() {
            now.follow(text, p, item);
            first.wrist |= now.wrist;
            let end = p.items.get(k + 1).is_none_or(|next| next.routine != item.routine);
            if end || now.soft != 0 && p.words.at(item.span.start) == "return" {
                first.led = first.led.or(now.led);
                first.soft |= now.soft;
            }
            if end {
                now = Self::default();
            }
        }
        first
    }

    /// After an item.
    ///
    /// `setting = "SingArea" "\" ("Wrist" | "LockAxis4" | ...) | lead ["\" "Off"] ...`
    pub fn follow(&mut self, text: &Text, p: &Parsed, item: &Item) {
        match item.kind {
            ItemKind::Call { .. } => {}
            ItemKind::Branch | ItemKind::Loop => return self.depth += 1,
            ItemKind::EndBranch | ItemKind::EndLoop => return self.depth = self.depth.saturating_sub(1),
            // what another branch made soft ends after the block
            ItemKind::Middle => return self.soft_depth = self.soft_depth.min(self.depth.saturating_sub(1)),
            _ => return,
        }
        let name = p.words.at(item.span.start);
        if name == "softact" {
            return self.soften(text, p, item);
        }
        let has = |word: &str| p.words.within(item.span.clone()).any(|w| w == word);
        match words::leads(name, given(p, &item.span, "off") == Given::Yes) {
            Some(led) => {
                self.led = led;
                if name == "softdeact" && !self.may_be_passed(item) {
                    self.soft = 0;
                }
            }
            None if name == "singarea" => self.wrist = has("wrist") || has("lockaxis4"),
            None => {}
        }
    }
}

impl Going {
    /// Something may lead the arm from before.
    pub fn may_be_led(&mut self, by: Option<&'static str>) {
        self.led = self.led.or(by);
        if by == Some(SOFT) {
            (self.soft, self.soft_depth) = (u8::MAX, self.depth);
        }
    }

    /// Through blocks, which may be passed by: what leads the arm before one, or at the end of one of its branches, may lead it after it.
    pub fn pass_by(&mut self, before: &mut Vec<Option<&'static str>>, kind: ItemKind) {
        match kind {
            ItemKind::Start => before.clear(),
            ItemKind::Branch | ItemKind::Loop => before.push(self.led),
            ItemKind::Middle => {
                if let Some(before) = before.last_mut() {
                    *before = before.or(self.led);
                }
            }
            ItemKind::EndBranch | ItemKind::EndLoop => self.led = self.led.or(before.pop().flatten()),
            _ => {}
        }
    }

    /// Whether an instruction may be passed by after an axis was made soft.
    fn may_be_passed(&self, item: &Item) -> bool {
        matches!(item.kind, ItemKind::Call { alone: true }) || self.depth > self.soft_depth
    }

    /// `SoftAct`: a softness of 0 is the greatest stiffness, with which the axis goes to its targets (RAPID Instructions, SoftAct). It
    /// counts where nothing may pass it by that did not pass by what made the axis soft.
    ///
    /// `soft = "SoftAct" ["\" "MechUnit" ":=" name ","] axis "," softness ["\" "Ramp" ":=" number]`
    fn soften(&mut self, text: &Text, p: &Parsed, item: &Item) {
        let args = arguments(p, item.span.start + 1..item.span.end);
        let plain = |a: &Arg| match (a.span.len(), p.tokens.get(a.span.start)) {
            (1, Some(t)) if t.kind == Kind::Number => integer::<u32>(text.slice(t.start()..t.end())),
            _ => None,
        };
        let (axis, softness) = match &args[..] {
            [axis, softness] if axis.switches.is_empty() => (plain(axis), plain(softness)),
            _ => (None, None),
        };
        // one that is not known may be any
        let bits = (1..=6).find(|k| axis == Some(*k)).map_or(u8::MAX, |k| 1_u8 << k);
        if softness == Some(0) && bits != u8::MAX {
            if !self.may_be_passed(item) {
                self.soft &= !bits;
            }
        } else {
            self.soft_depth = if self.soft == 0 { self.depth } else { self.soft_depth.min(self.depth) };
            self.soft |= bits;
            self.led = Some(SOFT);
        }
        if self.soft == 0 && self.led == Some(SOFT) {
            self.led = None;
        }
    }
}

/// The instruction that makes an axis soft.
const SOFT: &str = "softact";

/// External axes of a target, as they are written.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum External {
    Numbers([f64; 6]),
    /// A name, or numbers that are computed.
    Text(String),
    /// Nothing is known.
    #[default]
    Unknown,
}

impl External {
    /// Of the list of a target.
    ///
    /// `extax = "[" six numbers "]" | expression`
    pub fn of(text: &Text, node: Option<&Node>) -> Self {
        let Some(node) = node else { return Self::Unknown };
        let written = || text_of(text.slice(node.bytes())).to_lowercase();
        node.numbers::<6>().map_or_else(|| Self::Text(written()), Self::Numbers)
    }

    /// Whether one that is none of the robot's `own` may be used.
    pub fn used_beside(&self, own: [bool; 6]) -> bool {
        match self {
            Self::Numbers(axes) => axes.iter().zip(own).any(|(v, own)| !own && is_used(*v)),
            _ => own.contains(&false),
        }
    }

    /// Name and value of those that are none of the robot's `own`, are used and stand elsewhere than at 0; `None`: not known.
    pub fn standing(&self, own: [bool; 6]) -> Option<Vec<(String, f64)>> {
        let Self::Numbers(axes) = self else { return None };
        let used = axes.iter().enumerate().filter(|(k, v)| !own[*k] && is_used(**v) && **v != 0.0);
        Some(used.map(|(k, v)| (format!("eax_{}", char::from(b'a' + k as u8)), *v)).collect())
    }

    /// Whether one that is none of the robot's `own` may move on the way to `next`.
    pub fn moves_to(&self, next: &Self, own: [bool; 6]) -> bool {
        match (self, next) {
            (Self::Numbers(a), Self::Numbers(b)) => {
                a.iter().zip(b).zip(own).any(|((a, b), own)| !own && (is_used(*a) || is_used(*b)) && a != b)
            }
            (Self::Text(a), Self::Text(b)) => own.contains(&false) && a != b,
            (_, next) => next.used_beside(own),
        }
    }
}

/// Which of the six external axes of a target the robot file has.
pub fn own_external(robot: &Axes) -> [bool; 6] {
    let mut own = [false; 6];
    let places = robot.places();
    for (number, _) in places.external.iter().filter(|_| places.certain) {
        if let Some(place) = own.get_mut(number - 1) {
            *place = true;
        }
    }
    own
}

/// 9E9 (9E+09, 1E+10 in older programs): the axis is not used.
fn is_used(external: f64) -> bool {
    external.abs() < 8.9e9
}

/// Whether the controller looks at configurations (`ConfJ`, `ConfL`): on joint moves, and on straight and circular ones.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Configured {
    pub joint: Watched,
    pub linear: Watched,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Watched {
    #[default]
    On,
    Off,
    /// One way through the program leaves them on, another one off.
    Perhaps,
}
