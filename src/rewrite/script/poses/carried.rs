//! Arms that external axes carry: a track under a robot.
//!
//! A pose determines six joints. Where the robot file has axes before the six of its arm, a target gives their positions itself (`E1`,
//! `eax_a`), and the arm is solved from where they put it: they are given, never solved. An axis that a target does not name stays where it
//! stood. Robots with further axes elsewhere in their chain are not solved. [`external`](super::external) solves targets with it.

use super::super::cause::Cause;
use crate::program::script::pose::PoseGoal;
use crate::robot::arm::{self, Arm};
use crate::robot::{GapOf, Robot};
use nalgebra::Isometry3;

/// Joints of an arm.
pub(super) const OF_ARM: usize = 6;

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
    pub(super) fn positions(&self, goal: &PoseGoal, from: Option<&[f64]>) -> Result<Vec<f64>, Cause> {
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
