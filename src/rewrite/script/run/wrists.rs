//! Letters for the wrist (FANUC's F and N, Yaskawa's flip), whose meaning is a property of the model: what of a program tells it.
//!
//! The script is cut into runs once for each meaning that the letters may have. A meaning is refuted by what happens only with another one:
//! a straight way from joint values ends with the other wrist, a target near joint values would turn the wrist over, or the arm would stand
//! on the border of a turn all the time. The runs of meanings that nothing refutes are all returned: what is edited has to be the same for
//! each of them ([`super::super::wrists`]).

use super::super::cause::Cause;
use super::cuts::cut_by;
use super::{Choice, Cut, Cutter, Reached, Tells};
use crate::program::script::pose::{PoseGoal, Solution};
use crate::program::script::{At, Goal, Note, PathKind, Script};
use crate::rewrite::script::configuration::flips;
use crate::rewrite::script::poses::{Place, Poses, Tooled};
use crate::robot::Flip;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Targets on the border of a turn that are more than chance.
const ON_BORDERS: usize = 3;
/// So many times as much that speaks against a meaning refutes it.
const TIMES: usize = 2;

impl Tells {
    fn contradictions(self) -> usize {
        self.against + if self.on_border < ON_BORDERS { 0 } else { self.on_border }
    }
}

/// What the letters of a script for the wrist may mean, and where the first of them stands.
fn meanings(script: &Script) -> Option<(At, &'static [Flip])> {
    script.moves().find_map(|(step, m)| {
        let Goal::Pose(goal) = &m.goal else { return None };
        let Solution::Configured(c) = &goal.solution else { return None };
        let at = script.steps.get(step)?.at;
        Some((at, flips(c))).filter(|(_, all)| goal.binding && !all.is_empty())
    })
}

/// The runs of a script, and where directions are lost, for what the letters of the wrist most probably mean; beside them those for other
/// meanings that are as possible.
pub fn cut(script: &Script, choice: &Choice, poses: &mut Poses) -> Cut {
    let Some((at, meanings)) = meanings(script) else { return cut_by(script, choice, poses) };
    let given = poses.flip;
    let (missing, posture) = (poses.missing.clone(), poses.posture.clone());
    let mut all = Vec::new();
    for flip in given.into_iter().chain(meanings.iter().copied().filter(|f| Some(*f) != given)) {
        (poses.missing, poses.posture) = (missing.clone(), posture.clone());
        poses.flip = Some(flip);
        let cut = cut_by(script, choice, poses);
        let tells = cut.tells;
        all.push((flip, cut, poses.missing.clone()));
        // a meaning that is given holds until something speaks against it; letters that choose nothing may mean anything
        if all.len() == 1 && tells.contradictions() == 0 && (given.is_some() || !tells.by_letter) {
            break;
        }
    }
    poses.flip = given;
    let least = all.iter().map(|(_, cut, _)| cut.tells.contradictions()).min().unwrap_or_default();
    let first = all.first().map(|(flip, _, _)| *flip);
    all.retain(|(flip, cut, _)| {
        let against = cut.tells.contradictions();
        // against the robot file nothing is certain
        against == least || against <= TIMES * least || given == Some(*flip)
    });
    all.sort_by_key(|(flip, cut, _)| (given != Some(*flip), cut.tells.contradictions()));
    let mut all = all.into_iter();
    let Some((flip, mut cut, missing)) = all.next() else { return cut_by(script, choice, poses) };
    poses.missing = missing;
    cut.others = all.map(|(_, cut, _)| cut).collect();
    cut.notes.extend(note(at, flip, first, given, &cut.others));
    cut
}

/// That the letters mean something else than usual, or than the robot file says.
fn note(at: At, flip: Flip, first: Option<Flip>, given: Option<Flip>, others: &[Cut]) -> Option<Note> {
    let text = match given {
        Some(given) if !others.is_empty() => format!(
            "wrist_flip `{}` of the robot file does not fit the joints of this program: what depends on it stays",
            given.word()
        ),
        None if others.is_empty() && Some(flip) != first => format!(
            "the letters of the targets for the wrist (F and N, flip) are those of a robot with wrist_flip `{}`, as the joints of the program show",
            flip.word()
        ),
        _ => return None,
    };
    Some(Note { place: at, text })
}

impl Cutter<'_> {
    /// Notes by what the wrist at a Cartesian target was chosen, and whether its letter fits; `from`: the joints before are known.
    pub(super) fn see_wrist(&mut self, goal: &PoseGoal, from: bool, place: &Place, q: &[f64]) {
        if !from {
            self.by_letter = place.is_by_letter(goal, q);
            self.tells.by_letter |= self.by_letter;
        } else if !self.by_letter && !self.again {
            self.tells.against += usize::from(place.contradicts(goal, q));
        }
        if self.by_letter && !self.again {
            self.tells.on_border += usize::from(place.stands_on_turn(goal, q));
        }
    }

    /// The same of a target that the joints before do not lead to: its configuration is another one than that next to them, or the wrist
    /// comes beyond its limits.
    pub(super) fn see_other_arm(&mut self, goal: &PoseGoal, why: &Cause, path: PathKind, from: Option<&[f64]>) {
        let Some(from) = from.filter(|_| !self.again) else { return };
        // for both wrists it is the same way but for the borders of turns and limits
        let mut far = || self.poses.place(goal).is_ok_and(|place| place.turns_over_for_letter(goal, from));
        let against = match why {
            Cause::OtherArm => self.by_letter || path != PathKind::Joint || far(),
            Cause::Outside => self.by_letter,
            _ => false,
        };
        self.tells.against += usize::from(against);
    }

    /// Notes that the robot goes on to joint values: the wrist is certain again.
    pub(super) fn see_joints(&mut self, reached: Option<&Reached>) {
        if let Some(Reached { from: Some(from), q, .. }) = reached.filter(|_| self.by_letter && !self.again) {
            self.tells.against += usize::from(other_wrist_is_nearer(&self.plain, from, q));
        }
        self.by_letter = false;
    }
}

/// Whether the other wrist is nearer to joints by far.
fn other_wrist_is_nearer(tooled: &Tooled, from: &[f64], to: &[f64]) -> bool {
    let (Some((_, _, from)), Some((_, _, to))) = (tooled.arm_of(from), tooled.arm_of(to)) else { return false };
    let ([.., a4, a5, a6], [.., b4, b5, b6]) = (from, to) else { return false };
    let half = |by: f64| {
        let turned = by + PI;
        (turned - (turned / TAU).round() * TAU).abs()
    };
    let own = [b4 - a4, b5 - a5, b6 - a6].map(f64::abs).into_iter().fold(0.0, f64::max);
    let other = [half(b4 - a4), (b5 + a5).abs(), half(b6 - a6)].into_iter().fold(0.0, f64::max);
    own > other + FRAC_PI_2
}
