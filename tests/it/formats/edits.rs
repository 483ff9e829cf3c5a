//! Random edits of a document, and whether they are found again in its output.

use super::samples::Sample;
use lostmotion::program::script::{
    Document, Edit, Edits, Goal, Move, NewPoint, PathKind, Script, StepKind, Value, text,
};
use lostmotion::robot::{JointKind, Robot};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use robot_programs::error::Error;
use std::collections::BTreeMap;

pub enum Outcome {
    /// The output holds what was asked for.
    Edited,
    /// Nothing was asked for.
    Nothing,
    /// The format has no way to say it.
    Refused(String),
}

/// What a script does, without places: numbers aside, for comparing ways of writing.
pub fn shape(script: &Script) -> Vec<String> {
    let of = |kind: &StepKind| match kind {
        StepKind::Move(m) => {
            format!("{:?} {:?} {:?} {:?} {}", m.path, values(script, m), m.speed, m.blend_m, m.way.len())
        }
        other => format!("{other:?}"),
    };
    script.steps.iter().map(|s| of(&s.kind)).collect()
}

/// Joint values of a move's goal.
fn values(script: &Script, m: &Move) -> Vec<Option<f64>> {
    let Goal::Joints(t) = m.goal else { return Vec::new() };
    script.targets.get(t).unwrap().values.iter().map(|v| v.map(|v| v.si)).collect()
}

/// That an empty edit leaves every byte.
pub fn nothing(s: &Sample, document: &dyn Document) -> Result<(), String> {
    let patches = document.patches(&Edits::default()).map_err(|e| format!("an empty edit was refused: {e}"))?;
    if !patches.is_empty() {
        return Err(format!("an empty edit gave {} patches", patches.len()));
    }
    let out = text::apply(&document.script().texts, &patches).map_err(|e| e.to_string())?;
    let same = out.len() == s.texts.len() && out.iter().zip(&s.texts).all(|(o, t)| *o == *t.bytes);
    if same { Ok(()) } else { Err("the document's texts are not those that it was read from".into()) }
}

/// Edits that a rewriter could want: joint values a little beside the old ones, points on the way, smaller corners. Half of
/// them ask the same of all moves to one target, half do not.
pub fn random(document: &dyn Document, robot: &Robot, seed: u64) -> Edits {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let script = document.script();
    let dof = robot.dof();
    let size: Vec<f64> =
        robot.axis_joints().map(|j| if j.kind == JointKind::Revolute { 0.02 } else { 0.002 }).collect();
    let digit = 10f64.powf(rng.random_range(-7.0..-3.0));
    let mut edits = Edits { digit: vec![digit; dof], ..Edits::default() };
    let agree = rng.random_bool(0.5);
    let chance = *[0.1, 0.4, 1.0].get(rng.random_range(0..3)).unwrap_or(&0.4);
    let mut shifts: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    let mut last: Option<Vec<f64>> = None;
    for (step, m) in script.moves() {
        let near = |q: &[f64], rng: &mut ChaCha8Rng| -> Vec<f64> {
            q.iter().zip(&size).map(|(v, s)| v + s * rng.random_range(-1.0..1.0)).collect()
        };
        let Goal::Joints(t) = m.goal else {
            if matches!(m.goal, Goal::Pose(_))
                && document.takes_joints_for_poses()
                && m.path == PathKind::Linear
                && m.closed.is_none()
                && m.fixed.is_none()
                && rng.random_bool(chance * 0.2)
            {
                let goal = Some(near(last.as_deref().unwrap_or(&vec![0.1; dof]), &mut rng));
                edits.steps.insert(step, Edit { goal, as_joint_moves: true, ..Edit::default() });
            }
            last = None;
            continue;
        };
        let known: Vec<f64> = values(script, m)
            .iter()
            .enumerate()
            .map(|(k, v)| v.or_else(|| last.as_ref().and_then(|q| q.get(k).copied())).unwrap_or(0.0))
            .collect();
        let mut edit = Edit::default();
        if m.fixed.is_none() && rng.random_bool(chance) {
            let shift = near(&vec![0.0; dof], &mut rng);
            let shift = if agree { shifts.entry(t).or_insert(shift).clone() } else { shift };
            edit.goal = Some(known.iter().zip(&shift).map(|(a, b)| a + b).collect());
        } else if agree
            && m.fixed.is_none()
            && let Some(shift) = shifts.get(&t)
        {
            edit.goal = Some(known.iter().zip(shift).map(|(a, b)| a + b).collect());
        }
        let point = |q, share, rng: &mut ChaCha8Rng, of_way| NewPoint {
            q,
            share,
            t_s: None,
            clearance_m: 10f64.powf(rng.random_range(-4.0..-1.0)),
            of_way,
            waits: false,
        };
        if m.closed.is_none() && rng.random_bool(chance * 0.5) {
            if m.way.is_empty() {
                let from = last.clone().unwrap_or_else(|| known.clone());
                let count = rng.random_range(1..=3);
                for k in 1..=count {
                    let share = f64::from(k) / f64::from(count + 1);
                    let q: Vec<f64> = from.iter().zip(&known).map(|(a, b)| a + share * (b - a)).collect();
                    let q = near(&q, &mut rng);
                    edit.before.push(point(q, share, &mut rng, false));
                }
            } else {
                for w in &m.way {
                    edit.before.push(point(near(&w.q, &mut rng), w.share, &mut rng, true));
                }
            }
            if rng.random_bool(0.3) {
                edit.blend_at_most_m = Some(10f64.powf(rng.random_range(-4.0..-1.0)));
            }
        }
        if edit.goal.is_some() || !edit.before.is_empty() {
            edits.steps.insert(step, edit);
        }
        last = Some(known);
    }
    edits
}

/// Applies edits, reads the output and compares: every asked point is there, and everything else is as it was.
pub fn check(s: &Sample, document: &dyn Document, edits: &Edits) -> Result<Outcome, String> {
    if edits.steps.is_empty() {
        return Ok(Outcome::Nothing);
    }
    let patches = match document.patches(edits) {
        Ok(patches) => patches,
        Err(Error::Refused(why)) => return Ok(Outcome::Refused(why)),
        Err(e) => return Err(format!("edits give another error than a refusal: {e}")),
    };
    let script = document.script();
    let out = text::apply(&script.texts, &patches).map_err(|e| format!("patches do not fit: {e}"))?;
    let texts: Vec<_> = out.into_iter().zip(&s.texts).map(|(b, t)| text::Text::new(t.name.as_str(), b)).collect();
    let shown = |k: usize| String::from_utf8_lossy(texts.get(k).map_or(&[][..], |t| &t.bytes)).into_owned();
    let again = s
        .format
        .parse(texts.clone(), s.robot.axes())
        .map_err(|e| format!("its output is refused: {e}\n{}", shown(0)))?;
    compare(s.format.name(), script, again.script(), edits).map_err(|e| format!("{e}\n{}", shown(0)))?;
    Ok(Outcome::Edited)
}

fn compare(format: &str, before: &Script, after: &Script, edits: &Edits) -> Result<(), String> {
    let mut steps = after.steps.iter();
    // where each axis was sent last: in G-code a word that leads there may be left out
    let mut standing: Vec<Option<Value>> = Vec::new();
    for (k, step) in before.steps.iter().enumerate() {
        let line = step.at.line;
        let mut next = || steps.next().ok_or_else(|| format!("line {line}: the step is gone"));
        let StepKind::Move(m) = &step.kind else {
            standing.clear();
            let found = next()?;
            if format!("{:?}", found.kind) != format!("{:?}", step.kind) {
                return Err(format!("line {line}: {:?} became {:?}", step.kind, found.kind));
            }
            continue;
        };
        let edit = edits.steps.get(k);
        for p in edit.map_or(&[][..], |e| e.before) {
            let StepKind::Move(found) = &next()?.kind else {
                return Err(format!("line {line}: a new point is missing"));
            };
            joints((before, m), (after, found), Some(&p.q), edits, &mut standing)
                .map_err(|e| format!("line {line}, new point: {e}"))?;
            if format != "gcode" {
                standing.clear();
            }
        }
        let StepKind::Move(found) = &next()?.kind else { return Err(format!("line {line}: the move is gone")) };
        let asked = edit.and_then(|e| e.goal);
        joints((before, m), (after, found), asked, edits, &mut standing).map_err(|e| format!("line {line}: {e}"))?;
        if format != "gcode" || m.goal.target().is_none() {
            standing.clear();
        }
    }
    match steps.next() {
        None => Ok(()),
        Some(step) => Err(format!("line {} of the output: a step too many", step.at.line)),
    }
}

/// A number of many digits is written with fewer, rad or m.
const FINEST: f64 = 1e-12;

/// That a move leads where it shall: every number within half of its last digit, and that digit fine enough.
fn joints(
    (before, m): (&Script, &Move),
    (after, found): (&Script, &Move),
    asked: Option<&[f64]>,
    edits: &Edits,
    standing: &mut Vec<Option<Value>>,
) -> Result<(), String> {
    let Goal::Joints(t) = m.goal else {
        return match (&found.goal, asked) {
            (Goal::Joints(_), None) => Err("it became a joint move".into()),
            (Goal::Joints(f), Some(q)) => {
                let wrong = after
                    .targets
                    .get(*f)
                    .unwrap()
                    .values
                    .iter()
                    .zip(q)
                    .any(|(v, q)| v.is_none_or(|v| (v.si - q).abs() > v.digit));
                if wrong { Err("the joint move leads elsewhere".into()) } else { Ok(()) }
            }
            (_, Some(_)) => Err("it is no joint move".into()),
            (_, None) => Ok(()),
        };
    };
    let Goal::Joints(f) = found.goal else { return Err(format!("it is no joint move: {:?}", found.goal)) };
    let (old, new) = (before.targets.get(t).unwrap().values, after.targets.get(f).unwrap().values);
    if old.len() != new.len() {
        return Err(format!("{} values, not {}", new.len(), old.len()));
    }
    standing.resize(new.len(), None);
    for (axis, (o, n)) in old.iter().zip(new.iter()).enumerate() {
        let stood = standing[axis];
        standing[axis] = n.or(stood);
        let (o, n) = match (o, n) {
            (Some(o), Some(n)) => (o, n),
            (None, None) => continue,
            (None, Some(n)) => {
                // an axis that a point moves must be commanded again by those after it
                let wrong = asked
                    .and_then(|q| q.get(axis))
                    .is_some_and(|q| (n.si - q).abs() > 0.501 * n.digit + FINEST + q.abs() * 1e-12);
                if wrong {
                    return Err(format!("axis {axis}, not commanded before: {} instead of {asked:?}", n.si));
                }
                continue;
            }
            (Some(o), None) => {
                let want = asked.and_then(|q| q.get(axis)).copied().unwrap_or(o.si);
                if stood.is_some_and(|s| (s.si - want).abs() <= 0.501 * s.digit + FINEST + want.abs() * 1e-12) {
                    continue;
                }
                return Err(format!("axis {axis} is not commanded any more"));
            }
        };
        let want = asked.and_then(|q| q.get(axis)).copied().unwrap_or(o.si);
        if asked.is_none() || want == o.si {
            // a copy may be written with other digits
            if (n.si - o.si).abs() > 0.51 * n.digit + o.si.abs() * 1e-15 || (asked.is_none() && n.si != o.si) {
                return Err(format!("axis {axis}: {} became {}", o.si, n.si));
            }
            continue;
        }
        if (n.si - want).abs() > 0.501 * n.digit + FINEST + want.abs() * 1e-12 {
            return Err(format!("axis {axis}: {} instead of {want}, last digit {}", n.si, n.digit));
        }
        let digit = edits.digit.get(axis).copied().unwrap_or(f64::INFINITY);
        // an unwritten zero after the point is no coarser digit
        if n.digit > 1.001 * digit.max(n.finest) && n.digit > 1.001 * o.digit {
            return Err(format!("axis {axis}: last digit {}, asked {digit}, finest {}", n.digit, n.finest));
        }
    }
    Ok(())
}
