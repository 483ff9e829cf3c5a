//! A program before and after edits, compared step by step with what was asked for.

use super::numbers;
use crate::script::{
    EditRef, Edits, Goal, Move, NewPoint, Patches, PathKind, Script, Speed, StepKind, TargetRef, Value,
};

/// Arithmetic of a value that is meant to stay, rad or m.
const SAME: f64 = 1e-12;

/// What is replaced is a number, a name or an expression, never a line.
pub(super) fn replaced(script: &Script, patches: &Patches) -> std::result::Result<(), String> {
    for p in patches.iter() {
        let old = script.texts[p.file].slice(p.span.clone());
        if old.contains(&b'\n') || (!old.is_empty() && p.bytes == old) {
            return Err(format!("an edit replaces {:?}", String::from_utf8_lossy(old)));
        }
    }
    Ok(())
}

/// Whether `after` moves as `edits` ask of `before`; the first difference.
pub fn difference(before: &Script, after: &Script, edits: &Edits) -> Option<String> {
    compared(before, after, edits, Language::of(""))
}

/// What is another matter in one language than in the others.
#[derive(Clone, Copy)]
pub(super) struct Language {
    /// G-code: an axis that a statement does not name stays where it is, so that a new point need not name those that its
    /// target does.
    modal: bool,
    krl: bool,
}

impl Language {
    pub(super) fn of(name: &str) -> Self {
        Self { modal: name == "gcode", krl: name == "krl" }
    }
}

pub(super) fn compared(before: &Script, after: &Script, edits: &Edits, how: Language) -> Option<String> {
    let mut rest = after.steps.iter();
    for (k, step) in before.steps.iter().enumerate() {
        let line = step.at.line;
        let edit = edits.steps.get(k);
        for point in edit.map_or(&[][..], |e| e.before) {
            let (StepKind::Move(m), Some(StepKind::Move(n))) = (&step.kind, rest.next().map(|s| &s.kind)) else {
                return Some(format!("line {line}: a new point is no move"));
            };
            if let Err(e) = new_point(before, m, after, n, point, edits, how) {
                return Some(format!("line {line}, new point: {e}"));
            }
            if point.waits {
                let Some(StepKind::Dwell(_)) = rest.next().map(|s| &s.kind) else {
                    return Some(format!("line {line}, new point: the program does not wait there"));
                };
            }
        }
        let Some(other) = rest.next() else { return Some(format!("line {line}: the step is missing")) };
        match (&step.kind, &other.kind) {
            (StepKind::Move(m), StepKind::Move(n)) => {
                if let Err(e) = step_itself(before, m, after, n, edit, edits) {
                    return Some(format!("line {line}: {e}"));
                }
            }
            (a, b) if format!("{a:?}") == format!("{b:?}") => {}
            (a, b) => return Some(format!("line {line}: {a:?} became {b:?}")),
        }
    }
    rest.next().map(|s| format!("a step too many: {s:?}"))
}

type Compared = std::result::Result<(), String>;

fn new_point(
    before: &Script,
    m: &Move,
    after: &Script,
    n: &Move,
    point: &NewPoint,
    edits: &Edits,
    how: Language,
) -> Compared {
    let Some(target) = n.goal.target() else { return Err(format!("its goal is {:?}", n.goal)) };
    if std::mem::discriminant(&m.goal) != std::mem::discriminant(&n.goal) {
        return Err(format!("its goal is {:?} and not as {:?}", n.goal, m.goal));
    }
    let target = &after.targets.get(target).unwrap();
    let written = numbers(after, n);
    for (axis, own) in numbers(before, m).iter().enumerate() {
        if own.is_some() && !how.modal && written.get(axis).copied().flatten().is_none() {
            return Err(format!("axis {axis} is not written"));
        }
    }
    for (axis, (v, q)) in written.iter().zip(&point.q).enumerate() {
        let own = numbers(before, m).get(axis).copied().flatten();
        v.map_or(Ok(()), |v| near(target, axis, own, v, *q, edits))?;
    }
    // KRL: $APO.CDIS is no word of the motion, and the controller keeps the corner within half the way on both sides, which is
    // what the room is; other languages write the size with the point
    let kept_within = how.krl && n.blend_m == m.blend_m;
    if n.blend_m.is_some_and(|r| r > point.clearance_m + 1e-9) && !kept_within {
        return Err(format!("its corner is larger than the space before it: {:?} > {}", n.blend_m, point.clearance_m));
    }
    let straight = m.path == PathKind::Joint || matches!(m.goal, Goal::Joints(_)) && m.path == PathKind::Linear;
    if straight && n.path != m.path {
        return Err(format!("it moves as {n:?}, not as {m:?}"));
    }
    same_speed(m, n)
}

fn same_speed(m: &Move, n: &Move) -> Compared {
    match (m.speed, n.speed) {
        // a time is shared out
        (Speed::Seconds(_), Speed::Seconds(_)) => Ok(()),
        (a, b) if a == b => Ok(()),
        (a, b) => Err(format!("speed {a:?} became {b:?}")),
    }
}

fn step_itself(before: &Script, m: &Move, after: &Script, n: &Move, edit: Option<EditRef>, edits: &Edits) -> Compared {
    let changed = || Err(format!("{m:?} became {n:?}"));
    match (&m.goal, &n.goal) {
        (Goal::Pose(a), Goal::Pose(b))
            if (&a.frame, &a.tool, &a.solution, a.binding, a.unsure)
                != (&b.frame, &b.tool, &b.solution, b.binding, b.unsure)
                || a.target.is_some() != b.target.is_some() =>
        {
            return changed();
        }
        (Goal::Pose(a), Goal::Pose(_)) if a.target.is_none() => {}
        (Goal::Joints(_), Goal::Joints(_)) | (Goal::Pose(_), Goal::Pose(_)) => {
            let Some(target) = n.goal.target().map(|t| after.targets.get(t).unwrap()) else { return changed() };
            let asked = edit.and_then(|e| e.goal);
            let (old, new) = (numbers(before, m), numbers(after, n));
            for (axis, (o, v)) in old.iter().zip(&new).enumerate() {
                match (o, v, asked.map(|q| q[axis])) {
                    (None, None, _) => {}
                    (_, Some(v), Some(q)) => near(&target, axis, *o, *v, q, edits)?,
                    (Some(o), Some(v), None) if o.si == v.si => {}
                    _ => return Err(format!("axis {axis}: {o:?} became {v:?}")),
                }
            }
        }
        // the reason may name a line, which has another number now
        (Goal::Opaque(_), Goal::Opaque(_)) => {}
        (a, b) if format!("{a:?}") == format!("{b:?}") => {}
        _ => return changed(),
    }
    // a time that was shared out may be too short to be shared out again
    let shared = edit.is_some_and(|e| !e.before.is_empty());
    if m.path != n.path || m.fixed != n.fixed || (m.closed != n.closed && !shared) {
        return changed();
    }
    let narrowed = edit.is_some_and(|e| e.blend_at_most_m.is_some());
    if m.blend_m != n.blend_m && !narrowed {
        return changed();
    }
    same_speed(m, n)
}

/// A written number is `q` within half a last digit, and that digit is no coarser than asked for or than the format can hold. One
/// that stands there with more digits than that may stay.
fn near(target: &TargetRef, axis: usize, own: Option<Value>, v: Value, q: f64, edits: &Edits) -> Compared {
    let lost = (v.si - q).abs();
    let asked = edits.digit_of(target, axis);
    let coarse = if asked.is_nan() { f64::INFINITY } else { asked.max(v.finest) };
    let digit = if own.is_some_and(|o| o.si == v.si) { coarse } else { coarse.min(v.digit) };
    if lost <= SAME * q.abs().max(1.0) || lost <= 0.501 * digit {
        return Ok(());
    }
    Err(format!("axis {axis} is {} and not {q}, digit {}", v.si, v.digit))
}
