//! What is edited alike whatever the letters for the wrist mean.
//!
//! Where a letter alone chose the joints of a target (FANUC's F and N, Yaskawa's flip) and more than one meaning of it is possible, the
//! program is edited once for each meaning ([`super::run::Cut::others`]). For a symmetrical gap a pose with its offset is the same with
//! either wrist, joint values after such a pose are not. What differs by no more than rounding is written; a target that would get other
//! numbers stays, and points that would stand elsewhere are not added.

use super::cause::Cause;
use super::unplaced::Unplaced;
use crate::program::script::{Edit, EditRef, Edits, Goal, NewPoint, Script, StepKind};
use std::collections::BTreeMap;

/// Joints that differ by less are the same, rad or m: no digit of any format shows it.
const SAME: f64 = 1e-7;
/// Numbers of poses that differ by this share of their last digit are the same: they are rounded to it.
const SHARE: f64 = 0.5;

/// Keeps of edits, and of the same in joints, what `other` has as well; `left` says of what goes why it stays.
pub(super) fn keep_alike(
    script: &Script,
    (edits, mut in_joints): (&mut Edits, Option<&mut Edits>),
    other: &Edits,
    left: &mut BTreeMap<usize, Cause>,
    unplaced: &mut Unplaced,
) {
    for step in 0..script.steps.len() {
        let own = edits.steps.get(step);
        let (one, two) = (own.unwrap_or_default(), other.steps.get(step).unwrap_or_default());
        if one == two {
            continue;
        }
        let digits = digits(script, step, one.as_joint_moves);
        let near = |a: &[f64], b: &[f64]| alike(a, b, &digits);
        let goals = match (one.goal, two.goal) {
            (Some(a), Some(b)) => near(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        let points = same_points(&one, &two, &near);
        let lost = one.before.len().max(two.before.len()) as u64;
        let joint_moves = one.as_joint_moves || two.as_joint_moves;
        if !goals || joint_moves && !points || one.as_joint_moves != two.as_joint_moves {
            remove(step, edits, in_joints.as_deref_mut());
            left.entry(step).or_insert(Cause::WristUnknown);
        } else if !points {
            unplaced.lose(script, step, lost);
            clear_points(edits, step);
            if let Some(in_joints) = in_joints.as_deref_mut() {
                clear_points(in_joints, step);
            }
        }
    }
}

fn remove(step: usize, edits: &mut Edits, in_joints: Option<&mut Edits>) {
    edits.steps.remove(step);
    if let Some(in_joints) = in_joints {
        in_joints.steps.remove(step);
    }
}

/// What of numbers of a step may differ: of joints as good as nothing, of poses what rounding takes.
fn digits(script: &Script, step: usize, as_joints: bool) -> Vec<f64> {
    let Some(StepKind::Move(m)) = script.steps.get(step).map(|s| &s.kind) else { return Vec::new() };
    let Goal::Pose(goal) = &m.goal else { return Vec::new() };
    let target = goal.target.filter(|_| !as_joints).and_then(|t| script.targets.get(t));
    target.map_or_else(Vec::new, |t| t.values.iter().map(|v| v.map_or(0.0, |v| SHARE * v.finest)).collect())
}

fn alike(a: &[f64], b: &[f64], digits: &[f64]) -> bool {
    let within = |(k, (x, y)): (usize, (&f64, &f64))| {
        let digit = digits.get(k).copied().filter(|d| d.is_finite()).unwrap_or(0.0);
        (x - y).abs() <= digit.max(SAME)
    };
    a.len() == b.len() && a.iter().zip(b).enumerate().all(within)
}

fn same_points(one: &EditRef, two: &EditRef, near: &dyn Fn(&[f64], &[f64]) -> bool) -> bool {
    let point = |(a, b): (&NewPoint, &NewPoint)| near(&a.q, &b.q);
    let counts = (one.before.len(), one.vias.len()) == (two.before.len(), two.vias.len());
    counts && one.before.iter().zip(two.before).all(point) && one.vias.iter().zip(two.vias).all(|(a, b)| near(a, b))
}

/// The step of a move is spread over its way.
fn clear_points(edits: &mut Edits, step: usize) {
    let Some(mut whole) = edits.steps.get(step).map(Edit::from) else { return };
    whole.clear_points();
    edits.steps.remove(step);
    if whole.goal.is_some() {
        edits.steps.insert(step, whole);
    }
}
