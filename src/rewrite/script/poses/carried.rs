//! Arms that external axes carry: a track under a robot.
//!
//! A pose determines six joints. Where the robot file has axes before the six of its arm, a target gives their positions itself (`E1`,
//! `eax_a`), and the arm is solved from where they put it: they are given, never solved. An axis that a target does not name stays where it
//! stood. Robots with further axes elsewhere in their chain are not solved.

use super::super::cause::Cause;
use super::super::way;
use super::{Place, Tooled};
use crate::program::script::PathKind;
use crate::program::script::pose::{PoseGoal, Solution};
use crate::robot::arm::{self, Arm};
use crate::robot::{GapOf, JointKind, Robot};
use nalgebra::Isometry3;
use std::sync::Arc;

/// Joints of an arm.
const OF_ARM: usize = 6;
/// External axes that differ by less stand at one place, rad or m.
const STANDS: f64 = 1e-9;

/// The arm behind external axes.
#[derive(Debug)]
pub struct Carried {
    /// How many axes carry it.
    pub count: usize,
    /// The arm alone, its base at the origin.
    pub robot: Robot,
    pub arm: Arm,
    /// From its pose at joints zero to its base.
    to_base: Isometry3<f64>,
}

impl Carried {
    /// The arm of a robot of more than six axes; `None`: the axes before the last six are not those that its file names as external ones,
    /// or the last six are no arm.
    pub fn of(robot: &Robot) -> Option<Self> {
        let count = robot.dof().checked_sub(OF_ARM).filter(|n| *n > 0)?;
        let places = robot.axes().places();
        let before = places.certain && places.arm.iter().copied().eq(count..count + OF_ARM);
        let first = robot.axis_index(count);
        let mut joints = robot.joints.get(first..).filter(|_| before)?.to_vec();
        for follow in joints.iter_mut().filter_map(|j| j.follows.as_mut()) {
            follow.joint = follow.joint.checked_sub(first)?;
        }
        if robot.joints[..first].iter().any(|j| j.follows.is_some_and(|f| f.joint >= first)) {
            return None;
        }
        let own = |g: &GapOf| Some(GapOf { axis: g.axis.checked_sub(count)?, others: others(g, count)? });
        // a sum of external axes alone is none of the arm's
        let of_arm = robot.gap_of.iter().filter(|g| g.axis >= count || g.others.iter().any(|o| o.0 >= count));
        let gap_of: Vec<GapOf> = of_arm.map(own).collect::<Option<_>>()?;
        let flange = *robot.flange();
        let mut alone = Robot::new(robot.name.clone(), robot.convention, joints, Isometry3::identity(), robot.tool)
            .with_flange(flange);
        alone.gap_of = gap_of;
        let arm = Arm::of(&alone)?;
        let to_base = arm::isometry(&alone.forward(&[0.0; OF_ARM])).inverse();
        Some(Self { count, robot: alone, arm, to_base })
    }

    /// The base of the arm in the world; `q`: joints whose first ones are the external axes.
    pub fn base(&self, robot: &Robot, q: &[f64]) -> Isometry3<f64> {
        let mut zero = q.get(..self.count).unwrap_or_default().to_vec();
        zero.resize(self.count + OF_ARM, 0.0);
        arm::isometry(&robot.forward(&zero)) * self.to_base
    }

    /// The joints of the arm.
    pub fn of_arm<'q>(&self, q: &'q [f64]) -> &'q [f64] {
        q.get(self.count..).unwrap_or_default()
    }

    /// Positions of the external axes at a target: its own, else those at which they stand.
    ///
    /// # Errors
    /// One is not known.
    fn positions(&self, goal: &PoseGoal, from: Option<&[f64]>) -> Result<Vec<f64>, Cause> {
        let of = |axis: usize| {
            let own = goal.placed().iter().find(|p| p.axis == axis).map(|p| p.si);
            own.or_else(|| from.and_then(|q| q.get(axis)).copied()).ok_or(Cause::ExternalUnknown)
        };
        (0..self.count).map(of).collect()
    }
}

/// The further axes of a sum, counted in the arm; `None`: one carries it.
fn others(gap: &GapOf, count: usize) -> Option<Vec<(usize, f64)>> {
    gap.others.iter().map(|&(axis, c)| Some((axis.checked_sub(count)?, c))).collect()
}

impl Tooled {
    /// The arm, the robot of which it is all, and its joints among those of the whole robot.
    pub fn arm_of<'q>(&'q self, q: &'q [f64]) -> Option<(&'q Arm, &'q Robot, &'q [f64])> {
        match (&self.arm, &self.carried) {
            (Some(arm), _) => Some((arm, &self.robot, q)),
            (None, Some(carried)) => Some((&carried.arm, &carried.robot, carried.of_arm(q))),
            (None, None) => None,
        }
    }

    /// A pose alone does not determine the joints.
    pub fn is_redundant(&self) -> bool {
        let turning = self.robot.axis_joints().any(|j| j.kind == JointKind::Revolute);
        let external = turning && !self.robot.axes().places().external.is_empty();
        self.arm.is_none() && self.carried.is_none() && (self.robot.dof() > OF_ARM || external)
    }
}

impl Place {
    /// The same for the arm alone where external axes put it; `q`: joints whose first ones are these.
    fn of_arm(&self, carried: &Carried, q: &[f64]) -> Self {
        let mut robot = carried.robot.clone();
        robot.base = carried.base(&self.tooled.robot, q);
        let tooled = Arc::new(Tooled::new(&robot, robot.tool));
        let posture = self.posture.as_deref().map(|p| Arc::from(carried.of_arm(p)));
        Self { tooled, posture, ..self.clone() }
    }

    /// The same, and how many external axes there are; `None`: no axes carry the arm.
    pub(super) fn alone(&self, q: &[f64]) -> Option<(Self, usize)> {
        let carried = self.tooled.carried.as_ref()?;
        Some((self.of_arm(carried, q), carried.count))
    }

    /// The same for a target, from the joints before.
    pub(super) fn alone_at(&self, goal: &PoseGoal, from: Option<&[f64]>) -> Option<(Self, usize)> {
        let carried = self.tooled.carried.as_ref()?;
        let at = carried.positions(goal, from).ok()?;
        Some((self.of_arm(carried, &at), carried.count))
    }

    /// [`Place::joints`] of a robot on external axes.
    ///
    /// # Errors
    /// Why they cannot be determined.
    pub(super) fn joints_carried(
        &self,
        carried: &Carried,
        goal: &PoseGoal,
        from: Option<&[f64]>,
        path: PathKind,
        hint: Option<&[f64]>,
    ) -> Result<Vec<f64>, Cause> {
        let external = carried.positions(goal, from)?;
        let alone = self.of_arm(carried, &external);
        let of_arm = |q: &[f64]| carried.of_arm(q).to_vec();
        let [start, hint] = [from, hint].map(|q| q.map(of_arm));
        let moves = |q: &[f64]| external.iter().zip(q).any(|(a, b)| (a - b).abs() > STANDS);
        let follows = path != PathKind::Joint;
        let ordered = matches!(goal.solution, Solution::Near(_)) && goal.binding;
        let q = match from.filter(|q| follows && !ordered && moves(q)) {
            Some(from) => {
                let arc = path == PathKind::Curve || goal.via_m.is_some();
                let end = self.world(goal, Some(from)).filter(|_| !arc).ok_or(Cause::Curve)?;
                let q = way::follow_carried(&self.tooled, from, &end, &external).ok_or(Cause::NotReached)?;
                alone.fits(goal, carried.of_arm(&q), &end, carried.of_arm(from))?;
                q
            }
            None => {
                let arm = alone.joints(goal, start.as_deref(), path, hint.as_deref())?;
                external.into_iter().chain(arm).collect()
            }
        };
        super::solve::within(&self.tooled.robot, &q)?;
        Ok(q)
    }
}
