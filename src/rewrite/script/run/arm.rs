//! What a script says of the arm's configuration as a whole: whether it is of one, and whether it is this robot's.

use crate::program::script::pose::Configuration;
use crate::program::script::{Goal, Move, Note, PathKind, PoseGoal, Script, Solution, TargetRef};
use crate::rewrite::script::cause::Cause;
use crate::rewrite::script::poses::Tooled;
use crate::robot::Robot;
use crate::robot::arm::Arm;
use std::collections::BTreeMap;

/// That most configurations which the program orders are none of this robot's: its file is another arm's, or its flange is turned.
pub(super) fn another_robot(script: &Script, left: &BTreeMap<usize, Cause>) -> Option<Note> {
    const LEAST: usize = 3;
    let ordered = |m: &Move| matches!(&m.goal, Goal::Pose(goal) if is_ordered(goal));
    let all = script.moves().filter(|(_, m)| ordered(m)).count();
    let mut not = left.iter().filter(|(_, why)| **why == Cause::NotConfigured).map(|(step, _)| *step);
    let (first, others) = (not.next()?, not.count());
    let text = format!(
        "{} of {all} Cartesian targets name an arm configuration that this robot does not have there: if this is the robot of the program, compare a pose (position and angles) computed with its file with the pendant (`flange`, `base`, lengths)",
        others + 1
    );
    (others + 1 >= LEAST && 2 * (others + 1) > all).then(|| Note { place: script.steps[first].at, text })
}

/// Whether a Cartesian target orders a configuration.
pub(super) fn is_ordered(goal: &PoseGoal) -> bool {
    goal.binding && matches!(goal.solution, Solution::Configured(_))
}

/// Fewest motions that go over into another configuration and are too many.
const MANY: usize = 3;

/// Whether so many motions go over into another configuration of the arm that it is not this arm, or does not stand there.
pub(super) fn mostly_goes_over(script: &Script, over: &[usize]) -> bool {
    let ordered = |m: &Move| m.path == PathKind::Joint && matches!(&m.goal, Goal::Pose(goal) if is_ordered(goal));
    over.len() >= MANY && 2 * over.len() > script.moves().filter(|(_, m)| ordered(m)).count()
}

/// That motions go over into another configuration of the arm, as they order it.
pub(super) fn goes_over(script: &Script, over: &[usize]) -> Option<Note> {
    let at = |step: &usize| script.steps.get(*step).map(|s| s.at);
    let lines: Vec<String> = over.iter().filter_map(at).take(LINES).map(|at| at.line.to_string()).collect();
    let more = over.len().saturating_sub(LINES);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let text = format!(
        "joint moves to another arm configuration than that before, as their targets order it: lines {}{more}; if the robot does not turn over there, tool, frame or robot file is another one",
        lines.join(", ")
    );
    Some(Note { place: over.first().and_then(at)?, text })
}

/// Lines that a note lists.
const LINES: usize = 8;

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
    let (arm, _, posture) = plain.arm_of(posture?)?;
    let other = |t: &TargetRef| {
        let q = joints_of(*t, plain.robot.dof());
        q.is_some_and(|q| plain.arm_of(&q).is_some_and(|(_, _, q)| class(arm, q) != class(arm, posture)))
    };
    let target = script.targets.iter().find(other)?;
    let text = "the joints of this target are of another arm configuration than `posture_deg`, which is not used";
    Some(Note { place: target.at, text: text.into() })
}

/// Joints in whose configuration the arm works by the program's project: those of its home position, where all points of the project have
/// its front and its elbow, clear of their borders. Of the two wrists any will do: for a half gap both need the same offsets, as J5 changes
/// its sign and its direction at once.
pub(super) fn by_project(script: &Script, robot: &Robot) -> Option<Vec<f64>> {
    let stance = script.stance.as_ref()?;
    let arm = Arm::of(robot)?;
    let half = |q: &[f64]| {
        let p = arm.posture(q).filter(|p| p.front_m.abs() > CLEAR_M && p.elbow.abs() > CLEAR_SINE)?;
        Some([p.front_m > 0.0, p.elbow > 0.0])
    };
    let own = half(&stance.home)?;
    let ordered = |c: &Configuration| match *c {
        Configuration::Kuka { status: Some(s), .. } => own == [s & 1 == 0, s & 2 != 0],
        _ => false,
    };
    let all = stance.others.iter().all(|q| half(q) == Some(own)) && stance.configurations.iter().all(ordered);
    let mut home = stance.home.clone();
    if let Some(wrist) = home.get_mut(4).filter(|v| v.sin().abs() < CLEAR_SINE) {
        *wrist = WRIST_RAD;
    }
    all.then_some(home)
}

/// Where joint 5 stands in a home position that has it at 0, rad: on one side.
const WRIST_RAD: f64 = 0.5;
/// So far from the border between front and rear, m, and between elbow up and down, as a sine, a point has a side.
const CLEAR_M: f64 = 0.01;
const CLEAR_SINE: f64 = 0.02;

/// Whether all joint targets of a script, and all configurations that it orders, are of one arm configuration.
pub(super) fn one_configuration(script: &Script, plain: &Tooled) -> bool {
    if plain.arm_of(&[]).is_none() {
        return true;
    }
    let joints = script.targets.iter().filter_map(|t| joints_of(t, plain.robot.dof()));
    let mut classes = joints.filter_map(|q| plain.arm_of(&q).map(|(arm, _, q)| class(arm, q)));
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
