//! What a script says of the arm's configuration as a whole: whether it is of one, and whether it is this robot's.

use crate::program::script::{Goal, Move, Note, PoseGoal, Script, Solution, TargetRef};
use crate::rewrite::script::cause::Cause;
use crate::rewrite::script::poses::Tooled;
use crate::robot::arm::Arm;
use std::collections::BTreeMap;

/// That most configurations which the program orders are none of this robot's: its file is another arm's, or its flange is turned.
pub(super) fn another_robot(script: &Script, left: &BTreeMap<usize, Cause>) -> Option<Note> {
    const LEAST: usize = 3;
    let ordered = |m: &Move| match &m.goal {
        Goal::Pose(goal) => goal.binding && matches!(goal.solution, Solution::Configured(_)),
        _ => false,
    };
    let all = script.moves().filter(|(_, m)| ordered(m)).count();
    let mut not = left.iter().filter(|(_, why)| **why == Cause::NotConfigured).map(|(step, _)| *step);
    let (first, others) = (not.next()?, not.count());
    let text = format!(
        "{} of {all} Cartesian targets name an arm configuration that this robot does not have there: if this is the robot of the program, compare a pose (position and angles) computed with its file with the pendant (`flange`, `base`, lengths)",
        others + 1
    );
    (others + 1 >= LEAST && 2 * (others + 1) > all).then(|| Note { place: script.steps[first].at, text })
}

/// Joints of a target that names them all.
pub(super) fn joints_of(target: TargetRef, dof: usize) -> Option<Vec<f64>> {
    let values = target.values.iter().map(|v| v.map(|v| v.si)).collect::<Option<Vec<f64>>>()?;
    (target.pose.is_none() && values.len() == dof).then_some(values)
}

/// The arm configuration of joints: of an arm without a spherical wrist the bends of its third and fifth joint.
fn class(arm: &Arm, q: &[f64]) -> [bool; 3] {
    match arm.posture(q) {
        Some(p) => [p.front_m > 0.0, p.elbow > 0.0, q[4].sin() > 0.0],
        None => [true, q[2].sin() > 0.0, q[4].sin() > 0.0],
    }
}

/// That the posture which the user gives is of another configuration than a joint target of the program.
pub(super) fn contradiction(script: &Script, plain: &Tooled, posture: Option<&[f64]>) -> Option<Note> {
    let (arm, posture) = (plain.arm.as_ref()?, posture?);
    let other = |t: &TargetRef| joints_of(*t, plain.robot.dof()).is_some_and(|q| class(arm, &q) != class(arm, posture));
    let target = script.targets.iter().find(other)?;
    let text = "the joints of this target are of another arm configuration than `posture_deg`, which is not used";
    Some(Note { place: target.at, text: text.into() })
}

/// Whether all joint targets of a script, and all configurations that it orders, are of one arm configuration.
pub(super) fn one_configuration(script: &Script, plain: &Tooled) -> bool {
    let Some(arm) = &plain.arm else { return true };
    let joints = script.targets.iter().filter_map(|t| joints_of(t, plain.robot.dof()));
    let mut classes = joints.map(|q| class(arm, &q));
    let first = classes.next();
    let ordered = |m: &Move| match &m.goal {
        Goal::Pose(goal) => match &**goal {
            PoseGoal { solution: Solution::Configured(c), binding: true, .. } => c.posture(),
            _ => None,
        },
        _ => None,
    };
    let mut orders = script.moves().filter_map(|(_, m)| ordered(m));
    let order = orders.next();
    classes.all(|c| Some(c) == first) && orders.all(|o| Some(o) == order)
}
