//! Targets of an arm that external axes carry: it is solved from where they put it.

use super::super::cause::Cause;
use super::super::way;
use super::carried::Carried;
use super::place::Place;
use super::solve::within;
use super::tooled::Tooled;
use crate::program::script::pose::{PoseGoal, Solution};
use crate::program::script::{AxisSet, PathKind};
use std::sync::Arc;

/// External axes that differ by less stand at one place, rad or m.
const STANDS: f64 = 1e-9;

impl Place {
    /// Axes that a target names: an external axis that carries the arm stays where it stands unless the target places it.
    pub fn axes_named(&self, goal: &PoseGoal, dof: usize) -> AxisSet {
        let count = self.tooled.carried.as_ref().map_or(0, |c| c.count);
        (0..dof).filter(|axis| *axis >= count || goal.placed().iter().any(|p| p.axis == *axis)).collect()
    }

    /// The place for the arm alone where external axes put it; `q`: joints whose first ones are these.
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
        within(&self.tooled.robot, &q)?;
        Ok(q)
    }
}
