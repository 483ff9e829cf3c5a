//! Arcs through positions of the list: three or more `MOVC` after each other.
//!
//! Yaskawa (operator's manuals of NX100 to YRC1000, circular interpolation): an arc is taught as three circular steps; the path to the
//! first of them, after a joint or a straight step, is straight. Each step ends at its own position and orientation. Of more steps after
//! each other every three follow an arc; through which three the path between two of them goes, the manuals leave open
//! ([`crate::script::How::circle`]). Steps that end an arc by a tag of their own are left out, and so is everything that is not plain in
//! such a group.

use super::flow::{self, Flow};
use super::job::{Kind, Meaning, Position};
use super::list::List;
use super::words::{PROCESS, PlainMoves, STANDS, STILL, sets_frame, upper, upper_words, words};
use crate::script::called::Called;
use crate::script::{Goal, PathKind, Script, StepKind, Text, number};
use std::cell::LazyCell;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

/// Steps of an arc at least.
const STEPS: usize = 3;

/// Which step of its arc a line is, from 0, and of how many, by line.
pub(super) type Circles = BTreeMap<usize, (usize, usize)>;

/// What stands between two `MOVC`.
enum Between {
    /// Nothing that moves or jumps.
    Nothing,
    /// Whatever else it is, the group is none that is known.
    Anything,
}

/// The lines of a job that are steps of arcs, from line `begin` on; `overlaid`: what is laid over the path before each line.
///
/// `arc = ("MOVJ" | "MOVL") ... {still} circular {still} circular {still} circular {{still} circular} {still} move`
pub(super) fn of(text: &Text, begin: usize, list: &List, jobs: &Called, overlaid: &[u32]) -> Circles {
    let mut found = Circles::new();
    if list.foreign.is_some() {
        return found;
    }
    let labelled = LazyCell::new(|| label_leads_to_a_circular_step(text, begin, jobs));
    let mut group: Vec<Option<(usize, usize)>> = Vec::new();
    let (mut after_plain, mut between) = (false, Between::Nothing);
    let plain_moves = PlainMoves::of(text);
    for k in begin..text.line_count() {
        let line = text.line(k).trim_ascii();
        if line.is_empty() || line.starts_with(b"'") {
            continue;
        }
        if plain_moves.has_indented(k) {
            close(text, list, &mut group, &mut found);
            (after_plain, between) = (true, Between::Nothing);
            continue;
        }
        let words = words(text, k);
        let Some(word) = words.first().map(|w| upper(text, w)) else { continue };
        if word == "MOVC" {
            let free = overlaid.get(k).is_none_or(|bits| *bits == 0);
            let first = group.is_empty() && after_plain;
            let sure = free && (first || !group.is_empty() && matches!(between, Between::Nothing));
            let position = plain(text, list, &words).filter(|_| sure);
            group.push(position.map(|p| (k, p)));
            between = Between::Nothing;
        } else if word.starts_with('+') {
            // a second group moves along
            group.push(None);
        } else if word.contains("MOV") && !word.starts_with('*') || word == "END" {
            if matches!(word.as_str(), "SMOVC" | "SMOVS") && !group.is_empty() {
                group.push(None);
            }
            close(text, list, &mut group, &mut found);
            (after_plain, between) = (matches!(word.as_str(), "MOVJ" | "MOVL"), Between::Nothing);
        } else if !is_still(&word) || !sets_frame(text, k).is_empty() {
            // what is jumped to may be reached from an arc, too
            after_plain &= word == "JUMP";
            let goes_on = match flow::read(&upper_words(text, k)) {
                Flow::Jump { label: Some(_), .. } => *labelled,
                Flow::Jump { label: None, .. } => word == "JUMP",
                Flow::Call(job) => jobs.waits(&job).is_none(),
                _ => matches!(word.as_str(), "JUMP" | "CALL"),
            };
            if goes_on && !group.is_empty() {
                // more circular steps may follow where it leads
                group.push(None);
            }
            between = Between::Anything;
        }
    }
    close(text, list, &mut group, &mut found);
    found
}

/// Whether a circular step or a spline, or a job that may begin with one, may come first after a label.
fn label_leads_to_a_circular_step(text: &Text, begin: usize, jobs: &Called) -> bool {
    let (mut after_label, plain) = (false, PlainMoves::of(text));
    for k in begin..text.line_count() {
        if plain.has(k) {
            after_label = false;
            continue;
        }
        let words = upper_words(text, k);
        let Some(word) = words.first().map(String::as_str) else { continue };
        let leads = match flow::read(&words) {
            Flow::Label(_) => {
                after_label = true;
                false
            }
            // an instruction on the line of a label
            _ if word.starts_with('*') => true,
            Flow::Call(job) => after_label && jobs.waits(&job).is_none(),
            Flow::Jump { label: None, .. } => after_label && word == "JUMP",
            Flow::Other if word == "JUMP" => true,
            Flow::Other => after_label && (word == "CALL" || word.ends_with("MOVC") || word.ends_with("SMOVS")),
            _ => false,
        };
        if leads {
            return true;
        }
        after_label &= !word.contains("MOV") && word != "END" || word.starts_with('*');
    }
    false
}

/// Ends a group of circular steps.
fn close(text: &Text, list: &List, group: &mut Vec<Option<(usize, usize)>>, found: &mut Circles) {
    let steps: Option<Vec<(usize, usize)>> = std::mem::take(group).into_iter().collect();
    let Some(steps) = steps.filter(|s| s.len() >= STEPS) else { return };
    let positions: Vec<&Position> = steps.iter().filter_map(|s| list.positions.get(s.1)).collect();
    let joints = |p: &&Position| matches!(p.section.meaning, Meaning::Pulse | Meaning::Angle);
    let tool = |p: &Position| p.section.tool.map(|k| text.line(k as usize).trim_ascii());
    let alike = positions.windows(2).all(|p| tool(p[0]) == tool(p[1]));
    let apart = steps.iter().map(|s| s.1).collect::<BTreeSet<usize>>().len() == steps.len();
    if alike && apart && positions.len() == steps.len() && positions.iter().all(joints) {
        found.extend(steps.iter().enumerate().map(|(n, s)| (s.0, (n, steps.len()))));
    }
}

/// The position of a circular step that says nothing but its speed, its ramps and its corner.
///
/// `circular = "MOVC" position {("V" | "VR" | "PL" | "CR" | "ACC" | "DEC") "=" number | "NWAIT"}`
fn plain(text: &Text, list: &List, words: &[Range<usize>]) -> Option<usize> {
    let (name, tags) = words.get(1..)?.split_first()?;
    let (kind, n, _) = Kind::read(upper(text, name).as_bytes()).filter(|(kind, ..)| *kind == Kind::C)?;
    let usual = |w: &Range<usize>| {
        let word = upper(text, w);
        let tag = word.split_once('=').filter(|(key, _)| matches!(*key, "V" | "VR" | "PL" | "CR" | "ACC" | "DEC"));
        word == "NWAIT" || tag.is_some_and(|(_, v)| number::read(v.as_bytes()).is_some())
    };
    tags.iter().all(usual).then(|| list.by_name.get((kind, n))).flatten()
}

/// Nothing that moves, jumps or leads the path.
fn is_still(word: &str) -> bool {
    word == "TIMER" || STILL.contains(&word) || STANDS.contains(&word) || PROCESS.iter().any(|p| p.0 == word)
}

/// Tells the moves of each arc its targets; where one of them is none, the first step is none that goes straight.
pub(super) fn join(script: &mut Script, circles: &Circles) {
    let on = |k: usize, script: &Script| {
        let step = script.steps.get(k)?;
        let leg = *circles.get(&(usize::try_from(step.at.line).ok()?.checked_sub(1)?))?;
        let StepKind::Move(m) = &step.kind else { return None };
        let target = if let Goal::Joints(t) = m.goal { Some(t) } else { None };
        Some((k, leg, target))
    };
    let all: Vec<(usize, (usize, usize), Option<usize>)> =
        (0..script.steps.len()).filter_map(|k| on(k, script)).collect();
    for arc in all.chunk_by(|a, b| b.1.0 == a.1.0 + 1) {
        let targets: Option<Arc<[usize]>> = arc.iter().map(|a| a.2).collect();
        let whole = arc.first().is_some_and(|a| a.1 == (0, arc.len()));
        let circle = targets.filter(|_| whole);
        for (k, ..) in arc {
            if let Some(StepKind::Move(m)) = script.steps.get_mut(*k).map(|s| &mut s.kind) {
                m.circle.clone_from(&circle);
                m.path = if circle.is_some() { m.path } else { PathKind::Curve };
            }
        }
    }
}
