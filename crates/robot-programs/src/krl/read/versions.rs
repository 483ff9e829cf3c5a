//! Frames that a program asks for by what computes them, where that may change: `BASE_DATA[N]` is another frame after `N` has been
//! assigned.
//!
//! Each assignment of anything in such an expression makes it another one, which is asked for by its own name, with a number, where
//! the program uses several. Names of variables count wherever they are declared: two local ones of one name are one here.

use super::in_force::{ASSIGNED, Setting};
use crate::krl::calls::calls;
use crate::krl::data::Data;
use crate::krl::lex::{Kind, Token, in_upper, tokens, upper};
use crate::krl::lists::LISTS;
use crate::krl::reason::Reason;
use crate::krl::settings::{may_have_with, values_with};
use crate::krl::statement::{assignment, declaration, is_routine};
use crate::script::Text;
use crate::script::cursor::integer;
use crate::script::pose::Frame;
use crate::script::reach::{Atoms, BEFORE, FIRST};
use std::collections::{BTreeMap, BTreeSet};

/// Names after `#`, and words of the language, are no variables.
fn variables(text: &Text, value: &[Token]) -> BTreeSet<String> {
    let is = |k: usize, t: &Token| {
        t.kind == Kind::Word && !k.checked_sub(1).and_then(|b| value.get(b)).is_some_and(|b| b.is(b'.') || b.is(b'#'))
    };
    value.iter().enumerate().filter(|(k, t)| is(*k, t)).map(|(_, t)| upper(text, t)).collect()
}

/// What frames are computed from, of what the text assigns: `N`, `F1`, `BASE_DATA`, `BASE_DATA[1]`.
#[derive(Debug, Default)]
pub(super) struct Names {
    /// By kind.
    names: Vec<String>,
    /// Kinds that a line assigns.
    lines: BTreeMap<usize, Vec<usize>>,
    /// Kinds of a line that sets a frame, by list.
    uses: [BTreeMap<usize, BTreeSet<usize>>; 2],
    /// Lines of BAS that put frame data into force, and where those were set.
    data_of: BTreeMap<usize, usize>,
}

/// An element of a list, or the whole list.
fn element(text: &Text, list: usize, index: &[Token]) -> String {
    let number: Option<u32> = match index {
        [n] => integer(text.slice(n.span())),
        _ => None,
    };
    number.map_or_else(|| LISTS[list].to_string(), |n| format!("{}[{n}]", LISTS[list]))
}

impl Names {
    /// Of a text.
    pub(super) fn of(text: &Text, data: &Data) -> Self {
        let (mut used, mut line): ([BTreeMap<usize, BTreeSet<String>>; 2], _) = (Default::default(), Vec::new());
        let mut assigned: BTreeMap<usize, BTreeSet<String>> = BTreeMap::new();
        let (mut of_data, mut data_of) = (None, BTreeMap::new());
        for k in text.lines_with(b"=(") {
            tokens(text, k, &mut line);
            line.retain(|t| t.kind != Kind::Comment);
            let Some(first) = line.first() else { continue };
            let word = upper(text, first);
            let second = line.get(1).map(|t| upper(text, t)).unwrap_or_default();
            if is_routine(&word, &second) {
                of_data = None;
            }
            if is_routine(&word, &second) || declaration(text, &line).is_some() {
                continue;
            }
            if may_have_with(&word) {
                for (list, value) in values_with(text, &line).into_iter().enumerate() {
                    let uses = value.map(|value| with_uses(text, list, value, data)).unwrap_or_default();
                    used[list].extend((!uses.is_empty()).then_some((k, uses)));
                }
                continue;
            }
            let own = assigns(text, &line, &word);
            if !own.is_empty() {
                assigned.insert(k, own);
            }
            let mut all = uses(text, &line, &word, data);
            if puts_frame_data(text, &line, &word) {
                data_of.extend(of_data.as_ref().map(|(from, _)| (k, *from)));
                all = of_data.as_ref().map(|(_, uses)| <[BTreeSet<String>; 2]>::clone(uses)).unwrap_or_default();
            } else if word == "FDAT_ACT" && assignment(&line).is_some() {
                // a part of it leaves the rest
                let before = of_data.take().filter(|_| line.get(1).is_some_and(|t| t.is(b'.')));
                let mut own = all.clone();
                own.iter_mut().zip(before.map(|(_, uses)| uses).unwrap_or_default()).for_each(|(own, b)| own.extend(b));
                of_data = Some((k, own));
            }
            for (list, uses) in all.into_iter().enumerate() {
                if !uses.is_empty() {
                    used[list].insert(k, uses);
                }
            }
        }
        let is_used: BTreeSet<&String> = used.iter().flat_map(|u| u.values().flatten()).collect();
        let names: BTreeSet<&String> = assigned.values().flatten().filter(|n| is_used.contains(n)).collect();
        let names: Vec<String> = names.into_iter().cloned().collect();
        let kinds = |all: &BTreeSet<String>| all.iter().filter_map(|n| names.binary_search(n).ok()).collect::<Vec<_>>();
        let lines = assigned.iter().map(|(k, all)| (*k, kinds(all))).filter(|l| !l.1.is_empty()).collect();
        let uses = used.map(|used| used.iter().map(|(k, all)| (*k, kinds(all).into_iter().collect())).collect());
        Self { names, lines, uses, data_of }
    }

    pub(super) fn len(&self) -> usize {
        self.names.len()
    }

    /// Kinds that a line assigns.
    pub(super) fn assigned(&self, line: usize) -> Vec<usize> {
        self.lines.get(&line).cloned().unwrap_or_default()
    }

    pub(super) fn kinds(&self) -> std::ops::Range<usize> {
        0..self.names.len()
    }

    /// The variable of a kind.
    pub(super) fn variable(&self, kind: usize) -> &str {
        self.names.get(kind).map_or("", |n| n.split('[').next().unwrap_or(n))
    }

    /// Whether a frame that a line sets depends on something that the text assigns.
    pub(super) fn depends(&self, line: usize) -> bool {
        (0..2).any(|list| self.is_computed(list, line))
    }

    /// The same of any line.
    pub(super) fn any_depends(&self) -> bool {
        self.uses.iter().flat_map(|uses| uses.values()).any(|kinds| !kinds.is_empty())
    }

    /// Where it counts what was assigned last to a kind of which the frame of a line is computed: an element of a list where the frame
    /// comes into force, the rest where its frame data were set.
    fn counts_at(&self, kind: usize, line: usize) -> usize {
        let of_list = LISTS.contains(&self.variable(kind));
        self.data_of.get(&line).copied().filter(|_| !of_list).unwrap_or(line)
    }

    /// Whether the frame that a line sets is computed from something that the text assigns.
    pub(super) fn is_computed(&self, list: usize, line: usize) -> bool {
        self.uses[list].get(&line).is_some_and(|kinds| !kinds.is_empty())
    }
}

/// What a line assigns, itself or by a routine to which it is passed.
///
/// `assignment = ["FOR"] name ["[" index "]"] ["." part] "=" value`, `passed = call "(" {... ","} name {"," ...} ")"`
fn assigns(text: &Text, line: &[Token], word: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    if word == "FOR" {
        found.extend(line.get(1).map(|t| upper(text, t)));
    } else if let Some(list) = LISTS.iter().position(|l| *l == word).filter(|_| assignment(line).is_some()) {
        let close = line.iter().position(|t| t.is(b']')).unwrap_or(line.len());
        let name = element(text, list, line.get(2..close).unwrap_or_default());
        if name == LISTS[list] {
            // any of them
            found.insert(format!("{name}[]"));
        }
        found.extend([LISTS[list].to_string(), name]);
    } else if assignment(line).is_some() {
        found.insert(word.to_string());
    }
    if matches!(word, "BAS" | "FDAT_ACT") {
        found.extend(["$BASE", "$TOOL"].map(String::from));
    }
    if !calls(text, line).is_empty() {
        let argument = |w: &&[Token]| matches!(w, [a, n, b] if (a.is(b'(') || a.is(b',')) && n.kind == Kind::Word && (b.is(b')') || b.is(b',')));
        found.extend(line.windows(3).filter(argument).map(|w| upper(text, &w[1])));
    }
    found
}

/// Whether a line puts the frames of `FDAT_ACT` into force.
///
/// `bas = "BAS" "(" "#" ("CP_PARAMS" | "PTP_PARAMS" | "FRAMES") ...`
fn puts_frame_data(text: &Text, line: &[Token], word: &str) -> bool {
    word == "BAS" && line.get(3).is_some_and(|t| matches!(&*in_upper(text, t), "CP_PARAMS" | "PTP_PARAMS" | "FRAMES"))
}

/// What the value of a frame is computed from.
fn of_value(text: &Text, list: usize, value: &[Token]) -> BTreeSet<String> {
    let mut names = variables(text, value);
    let at = value.iter().position(|t| upper(text, t) == LISTS[list]);
    let close = at.and_then(|at| value.iter().skip(at).position(|t| t.is(b']')).map(|n| at + n));
    if let (Some(at), Some(close)) = (at, close) {
        names.remove(LISTS[list]);
        names.insert(element(text, list, value.get(at + 2..close).unwrap_or_default()));
    }
    names
}

/// What a frame is computed from that a motion sets for itself: `SBASE(FP1.BASE_NO)` is the element of its number.
fn with_uses(text: &Text, list: usize, value: &[Token], data: &Data) -> BTreeSet<String> {
    let mut names = of_value(text, list, value);
    let function = value.first().map(|t| upper(text, t)).unwrap_or_default();
    if matches!(function.as_str(), "STOOL2" | "STOOL" | "SBASE") {
        let of_data = value.get(2).and_then(|t| data.numbers.get(&upper(text, t)));
        let number = of_data.and_then(|n| n[1 - list]);
        names.insert(number.map_or_else(|| LISTS[list].to_string(), |n| format!("{}[{n}]", LISTS[list])));
    }
    with_any(list, &mut names);
    names
}

/// An index that is computed may mean any element.
fn with_any(list: usize, names: &mut BTreeSet<String>) {
    if names.iter().any(|n| n.starts_with(LISTS[list])) {
        names.insert(format!("{}[]", LISTS[list]));
    }
}

/// What the base and the tool that a line sets are computed from.
fn uses(text: &Text, line: &[Token], word: &str, data: &Data) -> [BTreeSet<String>; 2] {
    let mut found: [BTreeSet<String>; 2] = Default::default();
    let sign = assignment(line);
    let value = sign.and_then(|sign| line.get(sign + 1..)).unwrap_or_default();
    match word {
        "$BASE" if sign.is_some() => found[0] = of_value(text, 0, value),
        "$TOOL" if sign.is_some() => found[1] = of_value(text, 1, value),
        "FDAT_ACT" if sign.is_some() => {
            let names = variables(text, value);
            for (list, found) in found.iter_mut().enumerate() {
                let name = value.first().map(|t| upper(text, t)).unwrap_or_default();
                let number = data.numbers.get(&name).and_then(|n| n[1 - list]);
                let own = number.map_or_else(|| LISTS[list].to_string(), |n| format!("{}[{n}]", LISTS[list]));
                found.extend(names.iter().cloned().chain([own]));
            }
        }
        "BAS" => {
            let argument = line.get(5..).and_then(|v| v.get(..v.len().saturating_sub(1))).unwrap_or_default();
            let list = match line.get(3).map(|t| upper(text, t)).as_deref() {
                Some("BASE" | "EX_BASE") => 0,
                Some("TOOL") => 1,
                _ => return found,
            };
            found[list] = variables(text, argument);
            found[list].insert(element(text, list, argument));
        }
        _ => {}
    }
    for (list, names) in found.iter_mut().enumerate() {
        with_any(list, names);
    }
    found
}

/// The lines of the assignments that have made a frame what it is.
type Version = BTreeSet<u32>;

/// Which of the assignments may have been the last before each line that sets a frame.
#[derive(Debug, Default)]
pub(super) struct Versions {
    /// By list and line.
    of: BTreeMap<(usize, usize), Vec<Version>>,
    /// Names that the program gives to several frames.
    several: BTreeMap<(usize, String), Vec<Version>>,
    /// Lines that assign what a frame is computed from.
    pub(super) changed_at: BTreeSet<usize>,
    /// Kinds that frames are computed from.
    pub(super) kinds: BTreeSet<usize>,
}

/// How many frames one name may stand for at one place; with more none is asked for.
const MOST: usize = 8;

impl Versions {
    /// `before`: the assignments of a kind that may have been the last before a line.
    pub(super) fn of(names: Names, settings: &[Setting], before: impl Fn(usize, usize) -> Atoms) -> Self {
        let mut out = Self::default();
        let mut seen: BTreeMap<(usize, String), BTreeSet<Version>> = BTreeMap::new();
        for Setting { line, list, frame, part } in settings {
            let mut computed = Vec::new();
            leaves(frame, &mut computed);
            if computed.is_empty() {
                continue;
            }
            let used = names.uses[*list].get(line).cloned().unwrap_or_default();
            let mut versions = vec![Version::new()];
            for kind in &used {
                let atoms = before(ASSIGNED + kind, names.counts_at(*kind, *line));
                let with = |v: &Version| {
                    atoms
                        .iter()
                        .map(|a| v.iter().copied().chain((*a != BEFORE).then_some(*a)).collect())
                        .collect::<Vec<Version>>()
                };
                versions = versions.iter().flat_map(with).collect();
                versions.truncate(MOST + 1);
            }
            out.kinds.extend(used);
            if *part {
                versions = vec![Version::from([FIRST + *line as u32])];
                out.changed_at.insert(*line);
            }
            versions.sort();
            versions.dedup();
            for name in computed {
                seen.entry((*list, name)).or_default().extend(versions.iter().cloned());
            }
            out.of.insert((*list, *line), versions);
        }
        let several = seen.into_iter().filter(|(_, versions)| versions.len() > 1);
        out.several = several.map(|(name, versions)| (name, versions.into_iter().collect())).collect();
        out
    }

    /// The frame that a line sets, by names that tell frames from others of the same words.
    pub(super) fn named(&self, list: usize, line: usize, frame: Frame) -> Frame {
        let Some(versions) = self.of.get(&(list, line)) else { return frame };
        if versions.len() > MOST {
            return Self::unclear();
        }
        match frame {
            Frame::Named(ref name) | Frame::Computed(ref name) => {
                let Some(all) = self.several.get(&(list, name.clone())) else { return frame };
                // what the program sets has been set
                let unset = name.ends_with(AS_SET) && versions.len() > 1;
                let own = versions.iter().filter(|v| !(unset && v.is_empty()));
                let number = |v: &Version| all.iter().position(|other| other == v).unwrap_or_default();
                let mut own: Vec<Frame> = own.map(|v| Frame::Computed(numbered(name, number(v)))).collect();
                if own.len() == 1 { own.remove(0) } else { Frame::Any(own) }
            }
            Frame::Any(all) => Frame::Any(all.into_iter().map(|f| self.named(list, line, f)).collect()),
            frame => frame,
        }
    }

    /// A frame that may be any of many.
    pub(super) fn unclear() -> Frame {
        Frame::unclear(Reason::FrameUncertain)
    }
}

/// What a list holds that the program sets in part, or by a computed index.
const AS_SET: &str = " as the program sets it";

/// The name of the frame of this number, from 0, among those of the same words: the first keeps the plain one. Numbers of lines would
/// change with each point that is added.
fn numbered(name: &str, number: usize) -> String {
    if number == 0 { name.to_string() } else { format!("{name} ({})", number + 1) }
}

/// Whether a name is that of a frame that no expression of this file computes.
fn is_own(name: &str) -> bool {
    matches!(name, "$BASE" | "$TOOL") || name.ends_with(" as a routine sets it")
}

/// Names of a frame that stand for what the program computes.
fn leaves(frame: &Frame, out: &mut Vec<String>) {
    match frame {
        Frame::Named(name) | Frame::Computed(name) if !name.bytes().all(|b| b.is_ascii_digit()) && !is_own(name) => {
            out.push(name.clone())
        }
        Frame::Any(all) => all.iter().for_each(|f| leaves(f, out)),
        _ => {}
    }
}
