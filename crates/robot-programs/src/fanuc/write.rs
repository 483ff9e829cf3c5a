//! Edits as patches: joint fields, cloned positions, new lines with new positions, line numbers.

use super::positions::{Field, Position};
use super::taught::FINEST;
use super::{Motion, Program};
use crate::axes::JointKind;
use crate::error::{Error, Result};
use crate::script::number::{self, Own};
use crate::script::{Edits, Goal, NewPoint, Patch, Patches, PathKind, StepKind, Text, Value};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ops::Range;

/// Fields of a position and their new text.
type Change = Vec<(Range<usize>, String)>;

/// New positions, with the text of each.
struct Appended {
    next: u64,
    text: Vec<u8>,
}

pub(super) fn patches(program: &Program, edits: &Edits) -> Result<Patches> {
    let Some(text) = program.script.texts.first() else { return Ok(Patches::default()) };
    let mut out = Patches::with_capacity(edits.steps.likely_patches());
    let mut appended = Appended { next: program.last + 1, text: Vec::new() };
    goals(program, text, edits, &mut out, &mut appended)?;
    let inserted = insertions(program, text, edits, &mut out, &mut appended)?;
    renumber(program, text, &inserted, &mut out)?;
    if !appended.text.is_empty() {
        out.push(Patch::new(0, program.end..program.end, appended.text));
    }
    Ok(out)
}

/// A joint value instead of one that stands in `text`, in its style, deg or mm.
fn written(program: &Program, edits: &Edits, axis: usize, q: f64, (value, text): (Value, &Text)) -> String {
    let kind = program.kinds.get(axis).copied().unwrap_or(JointKind::Revolute);
    let most = ((-FINEST.log10()).round() as u8).max(value.style.decimals);
    let digit = edits.digit.get(axis).map_or(f64::NAN, |d| kind.to_user_unit(*d));
    let style = number::Style { bare: program.bare, exponent: false, ..value.style };
    let own = Own { text: text.slice(value.span()), value: kind.to_user_unit(value.si), style: value.style };
    number::write_moved(own, kind.to_user_unit(q), style, number::decimals_for(style, digit, most))
}

/// Fields of a target that differ from `q`: the bytes to replace, and by what.
fn changes(program: &Program, edits: &Edits, target: usize, q: &[f64]) -> Result<Change> {
    let position = position_of(program, target)?;
    let Some(written_there) = program.script.targets.get(target) else { return Ok(Change::new()) };
    let fields: Vec<&Field> = match (written_there.pose, position.coordinates()) {
        (Some(_), Some(fields)) => {
            let placed = position.placed(&program.robot).into_iter().map(|f| f.1);
            fields.into_iter().chain(placed).collect()
        }
        _ => position.fields_of(program.robot.places()).unwrap_or_default(),
    };
    let Some(own) = program.script.texts.first() else { return Ok(Change::new()) };
    let mut out = Vec::new();
    for (k, (field, value)) in fields.into_iter().zip(written_there.values.iter()).enumerate() {
        let (Some(value), Some(&q)) = (value, q.get(k)) else { continue };
        let new = if written_there.pose.is_some() {
            let Some(new) = written_there.pose_number(k, q, edits, own) else { continue };
            bare(program, new)
        } else if (q - value.si).abs() <= 1e-13 {
            continue;
        } else {
            written(program, edits, k, q, (value, own))
        };
        // blanks before a number are its column and give way; a tab stays
        let blanks = own.slice(field.field.start()..field.number.start()).iter().all(|b| *b == b' ');
        let (span, new) = match blanks {
            true => (field.field.range(), number::field(&new, field.field.range().len())),
            false => (field.number.range(), new),
        };
        if own.slice(span.clone()) != new.as_bytes() {
            out.push((span, new));
        }
    }
    Ok(out)
}

/// A number without the zero before its point where the file writes them so.
fn bare(program: &Program, number: String) -> String {
    let (sign, digits) = number.strip_prefix('-').map_or(("", number.as_str()), |d| ("-", d));
    match digits.strip_prefix("0.").filter(|_| program.bare) {
        Some(fraction) => format!("{sign}.{fraction}"),
        None => number,
    }
}

fn position_of(program: &Program, target: usize) -> Result<&Position> {
    let found = program.of_target.get(target).and_then(|&p| program.positions.get(p));
    found.ok_or_else(|| Error::Refused("a joint target without its position".into()))
}

fn motion_of(program: &Program, step: usize) -> Result<&Motion> {
    program.motions.get(step).ok_or_else(|| {
        let place = program.script.steps.get(step).map(|s| program.script.place(s.at).to_string()).unwrap_or_default();
        Error::Refused(format!("{place}: this motion cannot be rewritten"))
    })
}

/// New goals: in place where every move to the position wants the same, else separate positions.
fn goals(program: &Program, text: &Text, edits: &Edits, out: &mut Patches, appended: &mut Appended) -> Result<()> {
    // target, step, and its joints or the numbers of its pose
    let mut wanted: Vec<(usize, usize, &[f64])> = Vec::with_capacity(edits.steps.len());
    for (step, edit) in edits.steps.iter() {
        let place =
            || program.script.steps.get(step).map(|s| program.script.place(s.at).to_string()).unwrap_or_default();
        let Some(StepKind::Move(m)) = program.script.steps.get(step).map(|s| &s.kind) else {
            return Err(Error::Refused(format!("step {step} is no move")));
        };
        if edit.as_joint_moves {
            return Err(Error::Refused(format!("{}: a Cartesian motion is not written as joint motions", place())));
        }
        let Some(q) = edit.goal else { continue };
        let (Some(target), None) = (m.goal.target(), &m.fixed) else {
            return Err(Error::Refused(format!("{}: the goal's numbers are not in the program", place())));
        };
        wanted.push((target, step, q));
    }
    wanted.sort_by_key(|w| w.0);
    let uses = program.script.use_counts();
    for list in wanted.chunk_by(|a, b| a.0 == b.0) {
        let Some(&(target, ..)) = list.first() else { continue };
        let change = |&(_, step, q): &(usize, usize, &[f64])| Ok((step, changes(program, edits, target, q)?));
        let list = list.iter().map(change).collect::<Result<Vec<(usize, Change)>>>()?;
        let all = list.len() == uses.get(target).copied().unwrap_or(0);
        let all = all && !program.shared.get(target).copied().unwrap_or(true);
        // where some moves stay, or something else reads it, the position stays too
        let kept = if all { list.first().map(|l| l.1.clone()).unwrap_or_default() } else { Vec::new() };
        for (field, new) in &kept {
            out.push(Patch::new(0, field.clone(), new.as_bytes()));
        }
        let mut clones: HashMap<Change, u64> = HashMap::new();
        for (step, change) in list {
            if change == kept {
                continue;
            }
            let index = match clones.entry(change) {
                Entry::Occupied(known) => *known.get(),
                Entry::Vacant(place) => {
                    let index = appended.take()?;
                    appended.text.extend(copy(text, position_of(program, target)?, index, true, place.key()));
                    *place.insert(index)
                }
            };
            out.push(Patch::new(0, motion_of(program, step)?.digits, index.to_string()));
        }
    }
    Ok(())
}

impl Appended {
    /// The next free index. Controllers number positions up to 32767.
    fn take(&mut self) -> Result<u64> {
        if self.next > 32_767 {
            return Err(Error::Refused("no position index is free below 32768".into()));
        }
        self.next += 1;
        Ok(self.next - 1)
    }
}

/// A position's text under another index, with other fields.
fn copy(text: &Text, position: &Position, index: u64, comment: bool, change: &[(Range<usize>, String)]) -> Vec<u8> {
    let mut out = Vec::new();
    let head = text.slice(position.head.clone());
    let name = head.iter().position(|b| *b == b':' || *b == b']').unwrap_or(head.len());
    let rest = if comment { &head[name..] } else { &head[memchr::memrchr(b']', head).unwrap_or(name)..] };
    out.extend_from_slice(text.slice(position.span.start..position.head.start));
    out.extend_from_slice(index.to_string().as_bytes());
    out.extend_from_slice(rest);
    let mut change = change.to_vec();
    change.sort_by_key(|c| c.0.start);
    out.extend(text.substituted(position.head.end..position.span.end, change));
    out
}

/// The position of a new point: a copy of the goal's.
fn position(program: &Program, text: &Text, edits: &Edits, goal: &Goal, p: &NewPoint, index: u64) -> Result<Vec<u8>> {
    match (goal.target(), goal) {
        (Some(target), _) => {
            Ok(copy(text, position_of(program, target)?, index, false, &changes(program, edits, target, &p.q)?))
        }
        (None, Goal::Opaque(why)) => Err(Error::Refused(format!("no point can be added on the way: {why}"))),
        _ => Err(Error::Refused("the goal's position is not in the program".into())),
    }
}

/// New lines; the byte before which they stand and their number, in order.
fn insertions(
    program: &Program,
    text: &Text,
    edits: &Edits,
    out: &mut Patches,
    appended: &mut Appended,
) -> Result<Vec<(usize, u64)>> {
    let mut inserted: Vec<(usize, u64)> = Vec::new();
    let mut shift = 0;
    for (step, edit) in edits.steps.iter().filter(|e| !e.1.before.is_empty()) {
        let Some(StepKind::Move(m)) = program.script.steps.get(step).map(|s| &s.kind) else { continue };
        let motion = motion_of(program, step)?;
        if let Some(why) = &m.closed {
            let line = text.line_of(motion.start);
            return Err(Error::Refused(format!("{}:{line}: no point can be added on the way: {why}", text.name)));
        }
        let mut lines = Vec::new();
        let mut numbered = 0;
        for p in edit.before {
            let index = appended.take()?;
            let new = position(program, text, edits, &m.goal, p, index)?;
            appended.text.extend(new);
            // a straight TCP move is not stopped on its way
            let exact = motion.exact && m.path != PathKind::Linear;
            lines.extend(line(text, motion, index, exact, motion.number.map(|n| n + shift + numbered)));
            lines.extend_from_slice(text.ending(motion.start));
            numbered += u64::from(motion.number.is_some());
        }
        out.push(Patch::new(0, motion.start..motion.start, lines));
        shift += numbered;
        inserted.push((motion.start, numbered));
    }
    Ok(inserted)
}

/// The motion's line again, to another position: same speed, without what is attached; with its exact stop, or with the
/// smallest rounding there is.
fn line(text: &Text, motion: &Motion, index: u64, exact: bool, number: Option<u64>) -> Vec<u8> {
    let mut out = match number {
        Some(n) => field_of(text.slice(motion.start..motion.colon), n),
        None => text.slice(motion.start..motion.colon).to_vec(),
    };
    out.push(b':');
    out.extend_from_slice(text.slice(motion.lead));
    out.extend_from_slice(format!("P[{index}]").as_bytes());
    out.extend_from_slice(text.slice(motion.speed_and_end.start()..motion.end_type.start()));
    out.extend_from_slice(if exact { text.slice(motion.end_type) } else { b"CNT0" });
    for kept in &motion.kept {
        out.push(b' ');
        out.extend_from_slice(text.slice(*kept));
    }
    let tail = text.slice(motion.tail);
    out.extend_from_slice(if tail.ends_with(b";") { tail } else { b"    ;" });
    out
}

/// A number in the field of another.
fn field_of(old: &[u8], n: u64) -> Vec<u8> {
    let start = old.iter().position(u8::is_ascii_digit).unwrap_or(old.len());
    let digits = old[start..].iter().take_while(|b| b.is_ascii_digit()).count();
    let mut out = number::field(&n.to_string(), start + digits).into_bytes();
    out.extend_from_slice(&old[start + digits..]);
    out
}

/// Moves the numbers after new lines up, and the count of lines with them.
fn renumber(program: &Program, text: &Text, inserted: &[(usize, u64)], out: &mut Patches) -> Result<()> {
    let total: u64 = inserted.iter().map(|i| i.1).sum();
    if total == 0 {
        return Ok(());
    }
    let mut next = inserted.iter().peekable();
    let mut shift = 0;
    for line in &program.numbered {
        while let Some((_, n)) = next.next_if(|(at, _)| *at <= line.field.start) {
            shift += n;
        }
        if shift > 0 {
            let new = field_of(text.slice(line.field.clone()), line.number + shift);
            out.push(Patch::new(0, line.field.clone(), new));
        }
    }
    match &program.count {
        Some((span, count)) => out.push(Patch::new(0, span.clone(), (count + total).to_string())),
        None => {
            let why = "no attribute gives the number of lines, and it must grow with new lines (LINE_COUNT)";
            return Err(Error::Refused(format!("{}: {why}", text.name)));
        }
    }
    Ok(())
}
