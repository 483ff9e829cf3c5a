//! The joints of a Cartesian target: along the way from the joints before, or of all that reach its pose the ones that are meant, by
//! its configuration, by the joints before, by joints elsewhere in the program, or by the posture that the user gives.

use super::super::cause::Cause;
use super::super::configuration::{self, allows, allows_axis, determines, misfit, prefers, tolerates, tolerates_axis};
use super::super::way;
use super::Place;
use super::letters::turns_alike;
use crate::program::script::PathKind;
use crate::program::script::pose::{Configuration, PoseGoal, Solution};
use crate::robot::Robot;
use crate::robot::arm::{self, Arm};
use nalgebra::Isometry3;
use std::f64::consts::{PI, TAU};

/// Slack of the borders of a configuration, rad: programs are rounded.
pub(super) const SLACK: f64 = 2e-3;
/// Joints beyond a limit by less stand on it, rad or m.
const ON_LIMIT: f64 = 1e-6;
/// Solutions whose distances differ by less are as near, rad.
const AS_NEAR: f64 = 0.02;
/// Joints that a program names for a solution are no further from it, rad.
const BESIDE: f64 = 0.5;
/// Joints closer than this are the same solution, rad.
pub(super) const SAME: f64 = 1e-5;
/// A sign of a configuration whose measure is less is none (m, sines, and the determinant of a Jacobian in m).
const ON_BORDER: f64 = 1e-6;

impl Place {
    /// Joints of a target, from the joints before where they are known. `hint`: joints at another place of the program, which tell
    /// in which of its configurations the arm works where nothing else does.
    ///
    /// # Errors
    /// Why they cannot be determined.
    pub fn joints(
        &self,
        goal: &PoseGoal,
        from: Option<&[f64]>,
        path: PathKind,
        hint: Option<&[f64]>,
    ) -> Result<Vec<f64>, Cause> {
        let robot = &self.tooled.robot;
        if let Some(carried) = &self.tooled.carried {
            return self.joints_carried(carried, goal, from, path, hint);
        }
        if self.tooled.is_redundant() {
            return Err(Cause::Redundant);
        }
        let end = self.world(goal, from).ok_or(Cause::NoStart)?;
        let via = self.via(goal);
        let Some(arm) = &self.tooled.arm else {
            let from = from.ok_or(Cause::NoStart)?;
            return way::follow(&self.tooled, from, &end, goal.rotation.is_some(), via).ok_or(Cause::NotReached);
        };
        let follows = path == PathKind::Linear || path == PathKind::Curve && via.is_some();
        let ordered = matches!(goal.solution, Solution::Near(_)) && goal.binding;
        if let (Some(from), true, false) = (from, follows, ordered) {
            let q = way::follow(&self.tooled, from, &end, true, via).ok_or(Cause::NotReached)?;
            within(robot, &q)?;
            return self.fits(goal, &q, &end, from).map(|()| q);
        }
        self.chosen(arm, goal, from, &end, hint, path).or_else(|why| match &goal.solution {
            // a straight way from an unknown place ends at the only joints at which the check of the configuration lets it
            Solution::Configured(c) if follows && why == Cause::NotConfigured => self.tolerated(arm, c, &end, hint),
            _ => Err(why),
        })
    }

    /// Joints at the end of a way from `from`, at pose `end`, are those that the target orders.
    ///
    /// # Errors
    /// They are others.
    pub(super) fn fits(&self, goal: &PoseGoal, q: &[f64], end: &Isometry3<f64>, from: &[f64]) -> Result<(), Cause> {
        let (Some(arm), Solution::Configured(c), true) = (&self.tooled.arm, &goal.solution, goal.binding) else {
            return Ok(());
        };
        let fits = allows(c, arm, q, SLACK) || tolerates(c, arm, q, SLACK) && !self.named(arm, c, end, from);
        match fits {
            true => Ok(()),
            false if goal.unsure => Err(Cause::PerhapsOtherArm),
            false => Err(Cause::OtherArm),
        }
    }

    /// Whether joints that reach a pose have the configuration.
    fn named(&self, arm: &Arm, c: &Configuration, end: &Isometry3<f64>, near: &[f64]) -> bool {
        let robot = &self.tooled.robot;
        let may = |axis: usize, v: f64| allows_axis(c, axis, v, SLACK);
        let all = arm.solutions(robot, &arm::pose_of(end), near);
        all.iter().filter_map(|q| turned(robot, q, near, &may)).any(|q| allows(c, arm, &q, SLACK))
    }

    /// The only joints that reach a pose and that are [tolerated](tolerates) for a configuration.
    fn tolerated(
        &self,
        arm: &Arm,
        c: &Configuration,
        end: &Isometry3<f64>,
        hint: Option<&[f64]>,
    ) -> Result<Vec<f64>, Cause> {
        let robot = &self.tooled.robot;
        let zero = vec![0.0; robot.dof()];
        let beside = hint.filter(|h| h.len() == zero.len()).unwrap_or(&zero);
        let all = arm.solutions(robot, &arm::pose_of(end), beside);
        let may = |axis: usize, v: f64| tolerates_axis(c, axis, v, SLACK);
        let mut found: Vec<Vec<f64>> = all.iter().filter_map(|q| turned(robot, q, beside, &may)).collect();
        found.retain(|q| tolerates(c, arm, q, SLACK));
        if found.len() > 1 { Err(Cause::SeveralArms) } else { found.pop().ok_or(Cause::NotConfigured) }
    }

    /// Whether joints are those that a target's letter for the wrist means on most models.
    pub fn is_preferred(&self, goal: &PoseGoal, q: &[f64]) -> bool {
        match (self.tooled.arm_of(q), &goal.solution) {
            (Some((arm, _, q)), Solution::Configured(c)) => goal.binding && prefers(c, arm, q, self.flip),
            _ => false,
        }
    }

    /// Whether a joint motion from joints to others leads into another configuration of the arm, or turns a joint by more than half a turn.
    pub fn goes_over(&self, from: &[f64], to: &[f64]) -> bool {
        let class = |q: &[f64]| self.tooled.arm_of(q).and_then(|(arm, robot, q)| class_of(robot, arm, q));
        let of_arm = |q| self.tooled.arm_of(q).map_or(q, |found| found.2);
        distance(of_arm(from), of_arm(to)) > PI || class(from).zip(class(to)).is_some_and(|(a, b)| a != b)
    }

    /// Whether a controller that takes the joints next to `near` comes to `q`: by their largest difference and by the sum of squares,
    /// as makers do not say what they measure.
    pub(super) fn is_next_to(&self, arm: &Arm, near: &[f64], q: &[f64]) -> bool {
        let robot = &self.tooled.robot;
        let squares = |a: &[f64]| a.iter().zip(near).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt();
        let all = arm.solutions(robot, &robot.forward(q), near);
        let mut others = all.iter().filter_map(|other| turned(robot, other, near, &|_, _| true));
        // the same place by other whole turns is another solution, too
        turned(robot, q, near, &|_, _| true).is_some_and(|own| distance(&own, q) < ON_LIMIT)
            && others.all(|other| {
                let same = distance(&other, q) < SAME;
                let further = distance(&other, near) > distance(q, near) + AS_NEAR;
                same || further && squares(&other) > squares(q) + AS_NEAR
            })
    }

    /// The configurations in which the arm reaches a target within its limits, as its language writes them, those nearest to the
    /// joints before first; empty where the target names none.
    pub fn configurations(&self, goal: &PoseGoal, from: Option<&[f64]>) -> Vec<Configuration> {
        if let Some((alone, count)) = self.alone_at(goal, from) {
            return alone.configurations(goal, from.and_then(|q| q.get(count..)));
        }
        let (Some(arm), Solution::Configured(like)) = (&self.tooled.arm, &goal.solution) else { return Vec::new() };
        let Some(end) = self.world(goal, from) else { return Vec::new() };
        let robot = &self.tooled.robot;
        let zero = vec![0.0; robot.dof()];
        let near = from.unwrap_or(&zero);
        let solutions = arm.solutions(robot, &arm::pose_of(&end), near);
        let mut all: Vec<Vec<f64>> = solutions.iter().filter_map(|q| turned(robot, q, near, &|_, _| true)).collect();
        all.sort_by(|a, b| distance(a, near).total_cmp(&distance(b, near)));
        let mut found = Vec::new();
        for own in all.iter().filter_map(|q| configuration::of(like, arm, q, self.flip)) {
            if !found.contains(&own) {
                found.push(own);
            }
        }
        found
    }

    /// The same in words, beside the configuration that the target names; `None`: nothing to say.
    pub fn configurations_text(&self, goal: &PoseGoal, from: Option<&[f64]>) -> Option<String> {
        const LISTED: usize = 4;
        let Solution::Configured(own) = &goal.solution else { return None };
        let all = self.configurations(goal, from);
        let shown: Vec<String> = all.iter().take(LISTED).map(|c| format!("`{c}`")).collect();
        let more = all.len().saturating_sub(LISTED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let first = match (all.len(), from) {
            (0, _) => return None,
            (1, _) | (_, None) => "",
            _ => " (first the one next to the joints before)",
        };
        Some(format!(
            "the configuration here is `{own}`; this robot reaches the target in {}{more}{first}",
            shown.join(", ")
        ))
    }

    /// Of all joints that reach a pose the ones that are meant.
    fn chosen(
        &self,
        arm: &Arm,
        goal: &PoseGoal,
        from: Option<&[f64]>,
        end: &Isometry3<f64>,
        hint: Option<&[f64]>,
        path: PathKind,
    ) -> Result<Vec<f64>, Cause> {
        let robot = &self.tooled.robot;
        let zero = vec![0.0; robot.dof()];
        let configuration = match &goal.solution {
            // what only tells how a point was taught counts where nothing else does
            Solution::Configured(c) if goal.binding || from.is_none() => Some(c),
            _ => None,
        };
        let near = match &goal.solution {
            Solution::Near(near) if near.len() == zero.len() && (goal.binding || from.is_none()) => {
                Some(near.as_slice())
            }
            _ => from,
        };
        let hint = hint.filter(|h| near.is_none() && h.len() == zero.len());
        let all = arm.solutions(robot, &arm::pose_of(end), near.unwrap_or(&zero));
        if all.is_empty() {
            return Err(Cause::NotReached);
        }
        let beside = near.or(hint).unwrap_or(&zero);
        let any: Vec<Vec<f64>> = all.iter().filter_map(|q| turned(robot, q, beside, &|_, _| true)).collect();
        if any.is_empty() {
            return Err(Cause::Outside);
        }
        let mut candidates = configuration.map_or_else(|| any.clone(), |c| self.configured(arm, c, &all, beside));
        let follows = path == PathKind::Joint && goal.binding && !goal.unsure;
        let ordered = self.by_order && follows && configuration.is_some_and(determines);
        // letters whose meaning differs by model do not count here
        let ordered = ordered && candidates.len() == 1 && candidates.iter().flatten().all(|v| v.abs() < TAU);
        if let Some(c) = configuration
            && candidates.iter().any(|q| prefers(c, arm, q, self.flip))
        {
            candidates.retain(|q| prefers(c, arm, q, self.flip));
        }
        if candidates.is_empty() && goal.binding {
            return Err(Cause::NotConfigured);
        }
        if near.is_none() {
            let found = self.without_start(arm, configuration, candidates, [&any, &all], (hint, end))?;
            // whoever does not follow the configuration may stand whole turns from there
            let beyond = found.iter().any(|v| v.abs() > PI + SLACK);
            return if goal.unsure && beyond { Err(Cause::NoStart) } else { Ok(found) };
        }
        let (mut best, first, second) = nearest(&candidates, beside);
        if second - first < AS_NEAR {
            // how the point was taught decides between solutions as near
            best = self.taught(goal, arm, &candidates, beside, first).ok_or(Cause::AsNear)?;
        }
        // letters that mean the one or the other wrist at both ends
        let alike = self.lettered && path == PathKind::Joint && candidates.len() == 1;
        let q = candidates.swap_remove(best);
        let alike =
            alike && configuration.is_some_and(|c| prefers(c, arm, &q, self.flip) && turns_alike(c, beside, &q));
        if matches!(goal.solution, Solution::Near(_)) && !goal.binding && first > BESIDE {
            return Err(Cause::NotNear);
        }
        match first > nearest(&any, beside).1 + SAME && !ordered && !alike {
            true if goal.unsure => Err(Cause::PerhapsOtherArm),
            true => Err(Cause::OtherArm),
            false => Ok(q),
        }
    }

    /// Of the solutions as near as the nearest the one with which the point was taught; `None`: none, or several.
    fn taught(&self, goal: &PoseGoal, arm: &Arm, all: &[Vec<f64>], beside: &[f64], first: f64) -> Option<usize> {
        let Solution::Configured(c) = &goal.solution else { return None };
        let tied = || (0..all.len()).filter(|&k| distance(&all[k], beside) < first + AS_NEAR);
        let only = |found: Vec<usize>| if let [one] = found[..] { Some(one) } else { None };
        let allowed: Vec<usize> = tied().filter(|&k| allows(c, arm, &all[k], SLACK)).collect();
        match allowed.len() {
            0 | 1 => only(allowed),
            _ => only(allowed.into_iter().filter(|&k| prefers(c, arm, &all[k], self.flip)).collect()),
        }
    }

    /// The solutions that have a configuration, in the turns nearest to `beside` that it allows.
    pub(super) fn configured(&self, arm: &Arm, c: &Configuration, all: &[Vec<f64>], beside: &[f64]) -> Vec<Vec<f64>> {
        let may = |axis: usize, v: f64| allows_axis(c, axis, v, SLACK);
        let turned = all.iter().filter_map(|q| turned(&self.tooled.robot, q, beside, &may));
        turned.filter(|q| allows(c, arm, q, SLACK)).collect()
    }

    /// The joints of a target where those before are not known: of the candidates with its configuration, and of all solutions, in the
    /// turns that the limits allow and as the arm gives them.
    fn without_start(
        &self,
        arm: &Arm,
        configuration: Option<&Configuration>,
        mut candidates: Vec<Vec<f64>>,
        [any, all]: [&[Vec<f64>]; 2],
        (hint, end): (Option<&[f64]>, &Isometry3<f64>),
    ) -> Result<Vec<f64>, Cause> {
        match (configuration, candidates.len()) {
            (Some(_), 1) => Ok(candidates.swap_remove(0)),
            (Some(c), 0) => self.by_hint(any, hint, end).or_else(|| fitting(c, arm, any)).ok_or(Cause::NoStart),
            (Some(_), _) => self.by_hint(&candidates, hint, end).ok_or(Cause::SeveralArms),
            (None, _) => {
                let found = self.by_hint(any, hint, end);
                found.or_else(|| self.by_posture(arm, all)).ok_or(Cause::NoStart)
            }
        }
    }

    /// Of the solutions the one in the arm configuration of `hint`: the nearest by far, or that at which a straight way from the
    /// hint ends.
    fn by_hint(&self, solutions: &[Vec<f64>], hint: Option<&[f64]>, end: &Isometry3<f64>) -> Option<Vec<f64>> {
        let hint = hint?;
        let (best, first, second) = nearest(solutions, hint);
        let q = solutions.get(best)?;
        let reached = way::follow(&self.tooled, hint, end, true, None);
        let agrees = reached.as_ref().is_none_or(|r| distance(r, q) < AS_NEAR);
        (agrees && second - first >= AS_NEAR && (reached.is_some() || first < BESIDE)).then(|| q.clone())
    }

    /// The one solution in the configuration of the posture that the user gives, in the turns next to it.
    fn by_posture(&self, arm: &Arm, all: &[Vec<f64>]) -> Option<Vec<f64>> {
        let robot = &self.tooled.robot;
        let posture = self.posture.as_deref()?;
        let class = class_of(robot, arm, posture)?;
        let mut found = all.iter().filter(|q| class_of(robot, arm, q) == Some(class));
        let one = turned(robot, found.next()?, posture, &|_, _| true)?;
        found.all(|q| turned(robot, q, posture, &|_, _| true).is_none_or(|q| distance(&q, &one) < SAME)).then_some(one)
    }
}

/// The configuration in which an arm of six joints stands, by three signs: of its front, elbow and wrist where the wrist is
/// spherical; else of its elbow, its wrist and its Jacobian's determinant, which is their product with the shoulder's. `None`: on a border.
fn class_of(robot: &Robot, arm: &Arm, q: &[f64]) -> Option<[bool; 3]> {
    let signs = match arm.posture(q) {
        Some(p) => [p.front_m, p.elbow, q.get(4)?.sin()],
        None => {
            let (_, jacobian) = robot.chain().jacobian(q);
            let square = (jacobian.ncols() == 6).then(|| jacobian.fixed_columns::<6>(0).into_owned())?;
            [square.determinant(), q.get(2)?.sin(), q.get(4)?.sin()]
        }
    };
    signs.iter().all(|s| s.abs() > ON_BORDER).then(|| signs.map(|s| s > 0.0))
}

/// The solution that fits a configuration best that none has and that the controller does not look at; `None`: two fit as well.
fn fitting(configuration: &Configuration, arm: &Arm, all: &[Vec<f64>]) -> Option<Vec<f64>> {
    let fit: Option<Vec<f64>> = all.iter().map(|q| misfit(configuration, arm, q)).collect();
    let fit = fit?;
    let best = (0..all.len()).min_by(|a, b| fit[*a].total_cmp(&fit[*b]))?;
    let alone = (0..all.len()).all(|k| k == best || fit[k] > fit[best] + BESIDE);
    alone.then(|| all[best].clone())
}

/// Within the limits of the joints.
pub(super) fn within(robot: &Robot, q: &[f64]) -> Result<(), Cause> {
    let outside = |(j, v): (&crate::robot::Joint, &f64)| {
        j.limits.is_some_and(|[lo, hi]| !(lo - ON_LIMIT..=hi + ON_LIMIT).contains(v))
    };
    if robot.axis_joints().zip(q).any(outside) { Err(Cause::Outside) } else { Ok(()) }
}

/// Joints by the whole turns nearest to `near` that stay within the limits and that `may` allows; `None`: there are none.
fn turned(robot: &Robot, q: &[f64], near: &[f64], may: &dyn Fn(usize, f64) -> bool) -> Option<Vec<f64>> {
    let of = |(axis, joint): (usize, &crate::robot::Joint)| {
        let at = near.get(axis).copied().unwrap_or(0.0);
        let own = q.get(axis)? - ((q.get(axis)? - at) / TAU).round() * TAU;
        let inside =
            |v: &f64| joint.limits.is_none_or(|[lo, hi]| (lo - ON_LIMIT..=hi + ON_LIMIT).contains(v)) && may(axis, *v);
        let all = (-2..=2).map(|k| own + TAU * f64::from(k)).filter(inside);
        all.min_by(|a, b| (a - at).abs().total_cmp(&(b - at).abs()))
    };
    robot.axis_joints().enumerate().map(of).collect()
}

/// Largest distance of a joint, rad.
pub(super) fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

/// The nearest candidate, its distance and that of the next one.
fn nearest(candidates: &[Vec<f64>], near: &[f64]) -> (usize, f64, f64) {
    let mut best = (0, f64::INFINITY, f64::INFINITY);
    for (k, q) in candidates.iter().enumerate() {
        let d = distance(q, near);
        if d < best.1 {
            best = (k, d, best.1);
        } else if d < best.2 {
            best.2 = d;
        }
    }
    best
}
