//! The runs of a script for one meaning of the letters for the wrist: through loops whose passes are alike, and over breaks of which it is
//! known from where control comes.

use super::super::approach::Directions;
use super::super::clock::LastTcp;
use super::super::poses::{Poses, Tooled};
use super::cutter::{Choice, Cut, Cutter, Tells};
use super::joints::Joints;
use super::lengths::Lengths;
use super::stretch::empty_run;
use super::{arm, joins};
use crate::program::script::{AxisSet, Break, Goal, Note, Round, Script, StepKind};
use std::collections::BTreeSet;
use std::sync::Arc;

/// The runs for one meaning of the letters for the wrist.
pub(super) fn cut_by(script: &Script, choice: &Choice, poses: &mut Poses) -> Cut {
    let given = poses.posture.is_some();
    if !given {
        poses.posture = arm::by_project(script, choice.robot).map(Arc::from);
    }
    let (missing, posture) = (poses.missing.clone(), poses.posture.clone());
    let (mut cut, over) = cut_rounds(script, choice, poses);
    if arm::mostly_goes_over(script, &over) {
        // no arm changes its configuration all the time: frames, tool or robot are others, and orders tell nothing
        (poses.missing, poses.posture, poses.by_order) = (missing, posture, false);
        cut = cut_rounds(script, choice, poses).0;
        poses.by_order = true;
    }
    poses.posture = poses.posture.take().filter(|_| given);
    cut
}

/// The same through those loops of which every pass leads to the same joints, and the motions that go over into another configuration of
/// the arm because they order it.
fn cut_rounds(script: &Script, choice: &Choice, poses: &mut Poses) -> (Cut, Vec<usize>) {
    /// Loops may depend on loops before them; few do.
    const TRIES: usize = 4;
    let mut rounds: Vec<Round> = script.rounds.iter().filter(|_| choice.rounds).copied().collect();
    let (missing, posture) = (poses.missing.clone(), poses.posture.clone());
    let lengths = Lengths::of(script, choice);
    let mut tried = 0;
    let mut begins = !script.has_no_start();
    loop {
        let Once { cut, over, failed, starts } = cut_once(script, choice, poses, (&rounds, begins), &lengths);
        let passes = failed.is_empty() || rounds.is_empty();
        if passes && starts {
            return (cut, over);
        }
        (poses.missing, poses.posture) = (missing.clone(), posture.clone());
        if passes {
            begins = false;
        } else {
            rounds.retain(|r| !failed.contains(&r.open) && tried < TRIES);
            tried += 1;
        }
    }
}

/// A script that was gone through once.
struct Once {
    cut: Cut,
    /// Steps of joint motions that go over into another configuration of the arm.
    over: Vec<usize>,
    /// Loops whose passes are not known to be alike, by the step with which they open.
    failed: Vec<usize>,
    /// What the first movement says of its start does not contradict what is known of where it is reached from.
    starts: bool,
}

/// `begins`: where the program starts its own first movement says from which side joints come; else nothing does.
fn cut_once(
    script: &Script,
    choice: &Choice,
    poses: &mut Poses,
    (rounds, begins): (&[Round], bool),
    lengths: &Lengths,
) -> Once {
    let start = |k: usize| matches!(script.steps[k].kind, StepKind::Break(Break::Start));
    let entry = script.entry.or_else(|| (0..script.steps.len()).find(|&k| start(k)));
    let entry = if begins { entry } else { Some(usize::MAX) };
    let plain = Arc::new(Tooled::new(choice.robot, choice.robot.tool));
    let mut run = empty_run(entry.is_none());
    // most programs are one run: a list that doubles is copied and leaves holes
    run.vertices.reserve(script.steps.len());
    // what joint targets say of the arm serves Cartesian ones alone
    let solves = poses.posture.is_some() || script.moves().any(|(_, m)| matches!(m.goal, Goal::Pose(_)));
    let one_arm = !solves || arm::one_configuration(script, &plain);
    let hint = script.targets.iter().find_map(|t| arm::joints_of(t, choice.robot.dof())).filter(|_| one_arm);
    let hint = hint.map(Joints::from);
    if !one_arm {
        poses.posture = None;
    }
    let mut out = Cut::default();
    if let Some(note) = arm::contradiction(script, &plain, poses.posture.as_deref()) {
        poses.posture = None;
        out.notes.push(note);
    }
    let mut cutter = Cutter {
        choice,
        poses,
        plain,
        out,
        run,
        known: Vec::new(),
        free: AxisSet::default(),
        rest: None,
        hint,
        one_arm,
        named: 0,
        over: Vec::new(),
        lettered: false,
        by_letter: false,
        tells: Tells::default(),
        by_joints: false,
        last_frame: None,
        stands: false,
        tcp: LastTcp::default(),
        lengths,
        directions: Directions::default(),
        pass: None,
        again: false,
        failed: Vec::new(),
    };
    let join = choice.joins && script.joins.len() <= joins::MOST;
    let wanted = if join { joins::places(script) } else { BTreeSet::new() };
    let mut places = joins::Places::default();
    for k in 0..script.steps.len() {
        if wanted.contains(&k) {
            places.extend(cutter.standing().map(|standing| (k, standing)));
        }
        cutter.follow(script, k, rounds, entry);
    }
    // the last routine ends after the last step
    let last = script.steps.len();
    places.extend(cutter.standing().filter(|_| wanted.contains(&last)).map(|standing| (last, standing)));
    cutter.end(false);
    let failed = std::mem::take(&mut cutter.failed);
    let mut starts = true;
    if !wanted.is_empty() {
        cutter.join(script, rounds, &mut places);
        starts = cutter.run_again(script, &places);
    }
    let Cutter { mut out, mut over, tells, .. } = cutter;
    out.tells = tells;
    over.sort_unstable();
    over.dedup();
    out.notes.splice(0..0, arm::another_robot(script, &out.left));
    out.notes.extend(called(script));
    out.notes.extend(arm::goes_over(script, &over));
    Once { cut: out, over, failed, starts }
}

/// Why the first movement of a program does not tell from which side its first target is reached, where that is so.
fn called(script: &Script) -> Option<Note> {
    let (first, _) = script.moves().next().filter(|_| script.has_no_start())?;
    let text = "another program calls this one, or starts it: from which side its first target is reached is not known";
    Some(Note { place: script.steps.get(first)?.at, text: text.into() })
}
