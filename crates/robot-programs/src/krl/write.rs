//! Edits as patches: numbers of goals, cloned points, new motions in line.

use super::aggregate::{finest, most_decimals};
use super::clone::{Change, Clone, Taken, clone, refer, replaced, words};
use super::form;
use super::lex::tokens;
use super::motion::Motion;
use super::program::{Program, Source};
use super::reason::Reason;
use crate::axes::JointKind;
use crate::error::{Error, Result};
use crate::script::cursor::strip_word;
use crate::script::number::{self, Own};
use crate::script::{self, EditRef, Edits, Goal, Move, Patch, Patches, PoseGoal, StepKind, Text, Value};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::Range;

pub(super) fn patches(program: &Program, edits: &Edits) -> Result<Patches> {
    let mut out = Patches::with_capacity(edits.steps.likely_patches());
    goals(program, edits, edits.steps.iter(), &mut out)?;
    let named = named(program);
    for (step, edit) in edits.steps.iter().filter(|(_, e)| !e.before.is_empty() || !e.vias.is_empty()) {
        insert(program, edits, &named, step, edit, &mut out)?;
    }
    Ok(out)
}

/// Goals in other modules, and elements of arrays, that no clone can take the place of: in an inline form the clone needs a data list and
/// all that the form couples.
pub(super) fn unwritable(program: &Program, edits: &Edits) -> Vec<(usize, script::Reason)> {
    let elsewhere = |step: usize| {
        let StepKind::Move(m) = &program.script.steps.get(step)?.kind else { return None };
        match program.sources.get(m.goal.target()?)? {
            Source::Name(n) => program.data.names.get(*n as usize).filter(|n| n.context || n.of.is_some()),
            Source::Inline(..) | Source::Made(_) => None,
        }
    };
    let alone = |(step, edit): (usize, EditRef)| {
        let name = elsewhere(step).filter(|_| edit.goal.is_some())?;
        let mut out = Patches::default();
        goals(program, edits, std::iter::once((step, edit)), &mut out).err()?;
        Some((step, Reason::NoClone(name.text.as_str().into()).into()))
    };
    edits.steps.iter().filter_map(alone).collect()
}

/// An axis value in deg or mm, after what stands in `out`.
fn written(program: &Program, edits: &Edits, axis: usize, q: f64, style: number::Style, out: &mut Vec<u8>) {
    let (value, decimals) = in_user_unit(program, edits, axis, q, style);
    number::append(out, value, number::Style { exponent: false, ..style }, decimals);
}

/// An axis value in deg or mm, and digits after its point.
fn in_user_unit(program: &Program, edits: &Edits, axis: usize, q: f64, style: number::Style) -> (f64, u8) {
    let kind = program.kinds.get(axis).copied().unwrap_or(JointKind::Revolute);
    let value = kind.to_user_unit(q);
    let digit = edits.digit.get(axis).map_or(f64::NAN, |d| kind.to_user_unit(*d));
    (value, number::decimals_for(style, digit, most_decimals(value)))
}

/// An axis value instead of one that stands in `own`, after what stands in `out`.
fn changed(program: &Program, edits: &Edits, axis: usize, q: f64, (value, own): (Value, &Text), out: &mut Vec<u8>) {
    let (new, decimals) = in_user_unit(program, edits, axis, q, value.style);
    let kind = program.kinds.get(axis).copied().unwrap_or(JointKind::Revolute);
    let own = Own { text: own.slice(value.span()), value: kind.to_user_unit(value.si), style: value.style };
    number::append_moved(out, own, new, number::Style { exponent: false, ..value.style }, decimals);
}

/// Numbers of a target that differ from `q`.
fn changes(program: &Program, edits: &Edits, target: usize, q: &[f64]) -> Change {
    let mut out = Change::new();
    each_change(program, edits, target, q, &mut Vec::new(), &mut |span, new| {
        out.push((span, String::from_utf8_lossy(new).into_owned()));
    });
    out
}

/// The same one after the other; `new`: room for their texts.
fn each_change(
    program: &Program,
    edits: &Edits,
    target: usize,
    q: &[f64],
    new: &mut Vec<u8>,
    each: &mut dyn FnMut(Range<usize>, &[u8]),
) {
    let Some(there) = program.script.targets.get(target) else { return };
    let values = there.values;
    let Some(own) = program.text_of_target(target) else { return };
    if there.pose.is_some() {
        for (k, v) in q.iter().enumerate() {
            if let (Some(old), Some(new)) = (values.get(k), there.pose_number_of_size(k, *v, edits, own, finest)) {
                each(old.span(), new.as_bytes());
            }
        }
        return;
    }
    for (axis, (value, &q)) in values.iter().zip(q).enumerate() {
        let Some(value) = value.filter(|v| (q - v.si).abs() > 1e-13) else { continue };
        new.clear();
        changed(program, edits, axis, q, (value, own), new);
        if own.slice(value.span()) != new.as_slice() {
            each(value.span(), new);
        }
    }
}

/// A changed goal: its step, its target, and its new joints or the numbers of its pose.
struct TargetEdit<'a> {
    step: usize,
    target: usize,
    numbers: &'a [f64],
}

/// Changed goals of the edits that are chosen, as patches.
fn goals<'a>(
    program: &Program,
    edits: &Edits,
    chosen: impl Iterator<Item = (usize, EditRef<'a>)>,
    out: &mut Patches,
) -> Result<()> {
    let mut wanted = wanted(program, chosen)?;
    wanted.sort_by_key(|w| w.target);
    let uses = program.script.use_counts();
    let (mut taken, mut room) = (None, Vec::new());
    for of_one in wanted.chunk_by(|a, b| a.target == b.target) {
        let Some(&TargetEdit { target, .. }) = of_one.first() else { continue };
        if let [one] = of_one
            && let (file, true) = place_of_numbers(program, target)?
            && uses.get(target) == Some(&1)
        {
            // one motion, one change: nearly every target
            each_change(program, edits, target, one.numbers, &mut room, &mut |span, new| out.put(file, span, new));
            continue;
        }
        let mut list: Vec<(usize, Change)> =
            of_one.iter().map(|w| (w.step, changes(program, edits, target, w.numbers))).collect();
        let (file, may) = place_of_numbers(program, target)?;
        let all = may && list.len() == uses.get(target).copied().unwrap_or(0);
        // where all uses change, the point itself takes the first one's numbers
        let kept = if all { list.first().map(|l| l.1.clone()).unwrap_or_default() } else { Vec::new() };
        for (span, new) in &kept {
            out.push(Patch::new(file, span.clone(), new.as_bytes()));
        }
        list.retain(|l| l.1 != kept);
        part(program, target, list, &mut taken, out)?;
    }
    Ok(())
}

/// The goals that the chosen edits change; refused where the program does not hold their numbers.
fn wanted<'a>(program: &Program, chosen: impl Iterator<Item = (usize, EditRef<'a>)>) -> Result<Vec<TargetEdit<'a>>> {
    let mut all = Vec::new();
    for (step, edit) in chosen {
        let Some(StepKind::Move(m)) = program.script.steps.get(step).map(|s| &s.kind) else {
            return Err(Error::Refused(format!("step {step} is no move")));
        };
        if edit.as_joint_moves {
            let why = "a Cartesian motion is not written as joint motions";
            return Err(Error::Refused(format!("{}: {why}", program.place(step))));
        }
        let Some(numbers) = edit.goal else { continue };
        let (Some(target), None) = (m.goal.target(), &m.fixed) else {
            let why = "the goal's numbers are not in the program";
            return Err(Error::Refused(format!("{}: {why}", program.place(step))));
        };
        all.push(TargetEdit { step, target, numbers });
    }
    Ok(all)
}

/// The file with a target's numbers, and whether they may change there.
fn place_of_numbers(program: &Program, target: usize) -> Result<(usize, bool)> {
    match program.sources.get(target) {
        Some(Source::Inline(file, _)) => Ok((usize::from(*file), true)),
        Some(Source::Made(_)) => Ok((0, false)),
        Some(Source::Name(n)) => {
            let name = &program.data.names[*n as usize];
            Ok((name.value().map_or(name.file, |a| a.file), !name.read && !name.global))
        }
        None => Err(Error::Refused("an axis target without its place".into())),
    }
}

/// Motions of `list` lead to clones of their target; those of the same numbers share one.
fn part(
    program: &Program,
    target: usize,
    list: Vec<(usize, Change)>,
    taken: &mut Option<Taken>,
    out: &mut Patches,
) -> Result<()> {
    // a form needs a clone of its frame data, too
    let mut clones: HashMap<(Change, bool), Clone> = HashMap::new();
    for (step, change) in list {
        let form = program.motion(step)?.fold.is_some();
        let clone = match clones.entry((change, form)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(place) => {
                let taken = taken.get_or_insert_with(|| words(program));
                let clone = clone(program, step, target, &place.key().0, taken, out)?;
                place.insert(clone)
            }
        };
        refer(program, step, clone, out)?;
    }
    Ok(())
}

/// By axis: a target of the program names it.
fn named(program: &Program) -> Vec<bool> {
    let named = |k: usize| program.script.targets.iter().any(|t| t.values.get(k).is_some());
    (0..program.axes.len()).map(named).collect()
}

/// Other points on the way of an arc, and new motions before a motion: before its fold where it stands in an inline form, with the settings
/// of the form.
fn insert(
    program: &Program,
    edits: &Edits,
    named: &[bool],
    step: usize,
    edit: EditRef,
    out: &mut Patches,
) -> Result<()> {
    let points = edit.before;
    let Some(StepKind::Move(m)) = program.script.steps.get(step).map(|s| &s.kind) else { return Ok(()) };
    let why = m.closed.as_ref().or(match &m.goal {
        Goal::Opaque(why) => Some(why),
        _ => None,
    });
    if let Some(why) = why {
        return Err(Error::Refused(format!("{}: no point can be added on the way: {why}", program.place(step))));
    }
    let motion = program.motion(step)?;
    if motion.via.is_some() && edit.vias.len() != points.len() + 1 {
        let why = "a piece of its arc has no point on its way";
        return Err(Error::Refused(format!("{}: {why}", program.place(step))));
    }
    let text = program.text(0)?;
    let start = text.line_span(motion.line()).start;
    let indent = text.slice(start..motion.keyword.start());
    let indent = &indent[indent.len() - indent.iter().rev().take_while(|b| b.is_ascii_whitespace()).count()..];
    let ending = text.ending(start);
    let at = motion.fold().map_or(start, |fold| text.line_span(fold).start);
    let mut bytes = settings_of_form(text, motion, ending);
    if let Goal::Pose(goal) = &m.goal {
        let lines = poses(program, edits, edit, goal, motion, points.iter().map(|p| p.q.as_slice()))?;
        if let (Some(at), Some(via), Some(target)) = (edit.piece(points.len()), &motion.via, goal.target) {
            out.push(Patch::new(0, *via, on_arc(program, edits, target, at)));
        }
        if lines.is_empty() {
            return Ok(());
        }
        for line in lines {
            bytes.extend_from_slice(indent);
            bytes.extend_from_slice(&line);
            bytes.extend_from_slice(ending);
        }
        out.push(Patch::new(0, at..at, bytes));
        return Ok(());
    }
    for point in points {
        bytes.extend_from_slice(indent);
        bytes.extend_from_slice(text.slice(motion.keyword));
        bytes.extend_from_slice(&joint_goal(program, edits, named, m, &point.q)?);
        bytes.extend_from_slice(&tail(text, motion));
        bytes.extend_from_slice(ending);
    }
    out.push(Patch::new(0, at..at, bytes));
    Ok(())
}

/// The lines of an inline form that set what its motion runs with: a point before the form needs the same.
fn settings_of_form(text: &Text, motion: &Motion, ending: &[u8]) -> Vec<u8> {
    let Some(fold) = motion.fold() else { return Vec::new() };
    let (mut bytes, mut line) = (Vec::new(), Vec::new());
    for k in fold + 1..motion.line() {
        tokens(text, k, &mut line);
        if form::setting(text, &line) {
            bytes.extend_from_slice(text.line(k));
            bytes.extend_from_slice(ending);
        }
    }
    bytes
}

/// ` {A1 10,A2 -20}`: joint values written as those of the motion's own goal are.
fn joint_goal(program: &Program, edits: &Edits, named: &[bool], m: &Move, q: &[f64]) -> Result<Vec<u8>> {
    let target = match m.goal {
        Goal::Joints(t) => Some(t),
        _ => None,
    };
    let values = target.and_then(|t| program.script.targets.get(t)).map(|t| t.values).unwrap_or_default();
    let own = || {
        let text = target.and_then(|t| program.text_of_target(t));
        text.ok_or_else(|| Error::Refused("a text that is not there".into()))
    };
    let usual = values.iter().flatten().map(|v| v.style).max_by_key(|s| s.decimals).unwrap_or_default();
    let usual = number::Style { decimals: usual.decimals.max(3), point: true, plus: false, ..usual };
    let mut all = b" {".to_vec();
    // an axis that no target names stands where nobody knows
    for (axis, (name, q)) in program.axes.iter().zip(q).enumerate().filter(|(axis, _)| named.get(*axis) == Some(&true))
    {
        if !all.ends_with(b"{") {
            all.push(b',');
        }
        all.extend_from_slice(name.as_bytes());
        all.push(b' ');
        match values.get(axis) {
            Some(v) if (v.si - q).abs() <= 1e-13 => {
                all.extend_from_slice(own()?.slice(v.span()));
            }
            Some(v) => {
                changed(program, edits, axis, *q, (v, own()?), &mut all);
            }
            None => written(program, edits, axis, *q, usual, &mut all),
        }
    }
    all.push(b'}');
    Ok(all)
}

/// New points before a motion to a Cartesian target: the same motion with other numbers in line.
fn poses<'a>(
    program: &Program,
    edits: &Edits,
    edit: EditRef,
    goal: &PoseGoal,
    motion: &Motion,
    points: impl Iterator<Item = &'a [f64]>,
) -> Result<Vec<Vec<u8>>> {
    let missing = || Error::Refused("a Cartesian target without its place".into());
    let target = goal.target.ok_or_else(missing)?;
    let (own, span) = match program.sources.get(target) {
        Some(Source::Inline(file, span)) => (program.text(usize::from(*file))?, &span.range()),
        Some(Source::Made(made)) => (&made.text, &made.value.span.range()),
        Some(Source::Name(n)) => {
            let value = program.data.names[*n as usize].value().map_err(|_| missing())?;
            (program.text(value.file)?, &value.span.range())
        }
        None => return Err(missing()),
    };
    let text = program.text(0)?;
    let line = |(n, q): (usize, &[f64])| {
        let piece = edit.piece(n);
        let mut bytes = text.slice(motion.keyword).to_vec();
        bytes.push(b' ');
        if let Some(at) = piece {
            bytes.extend_from_slice(on_arc(program, edits, target, at).as_bytes());
            bytes.push(b',');
        }
        // the other factors of a product stay
        bytes.extend_from_slice(text.slice(motion.goal.start()..motion.point.start()));
        bytes.extend_from_slice(&replaced(own, span, &changes(program, edits, target, q)));
        bytes.extend_from_slice(text.slice(motion.point.end()..motion.goal.end()));
        bytes.extend_from_slice(&tail(text, motion));
        bytes
    };
    Ok(points.enumerate().map(line).collect())
}

/// `{X 1,Y 2,Z 3}`: a point on the way of an arc, in digits as fine as those of a goal. Its orientation does not count.
fn on_arc(program: &Program, edits: &Edits, target: usize, at_m: &[f64]) -> String {
    let Some(there) = program.script.targets.get(target) else { return String::new() };
    let number = |(k, (name, v)): (usize, (&str, &f64))| {
        let style = there.values.get(k).map(|v| v.style).unwrap_or_default();
        let style = number::Style { exponent: false, plus: false, point: true, ..style };
        let mm = v * 1e3;
        let most = (-finest(mm).log10()).round().clamp(0.0, 9.0) as u8;
        let decimals = number::decimals_for(style, edits.digit_of(&there, k) * 1e3, most);
        format!("{name} {}", number::write(mm, style, decimals))
    };
    let all: Vec<String> = ["X", "Y", "Z"].into_iter().zip(at_m).enumerate().map(number).collect();
    format!("{{{}}}", all.join(","))
}

/// What follows the goal: approximate positioning where the motion has it, and
/// the settings of a spline motion, which hold for that motion alone. The size of a corner is no word of the motion but
/// `$APO.CDIS`; the controller begins a corner half the way to the point at the earliest and ends it half the way to the next one at
/// the latest, and ignores a greater distance. So the corner at a new point fits whatever the distance is; a new point without
/// one would stop the robot on its way.
fn tail(text: &Text, motion: &Motion) -> Vec<u8> {
    let tail = text.slice(motion.tail);
    if motion.spline {
        return tail.to_vec();
    }
    let approximates =
        tail.split(|b| !(b.is_ascii_alphanumeric() || *b == b'_')).any(|w| strip_word(w, b"C_").is_some());
    let of_tcp = !text.slice(motion.keyword).eq_ignore_ascii_case(b"PTP");
    match (approximates, of_tcp) {
        (false, _) => Vec::new(),
        (true, true) => b" C_DIS".to_vec(),
        (true, false) => b" C_PTP".to_vec(),
    }
}
