//! Joints that their offset would take over a border of their target's configuration.
//!
//! Programs stand on such borders: a tool that points straight down is reached with J4 and J6 at 0, where one quarter of ABB and one
//! sign of KUKA's turn ends and the next begins. The target orders one of them, so a joint goes no further than to the border, and less
//! of its offset is written; the other joints get theirs. The joint never comes to stand further from where it would have to be: it is
//! put between its place in the program and the place with its offset. Only a joint that stands on the border to the last digit is put
//! inside it by what rounding may move it.
//!
//! Fails where the joint stands beyond the border already, and where the digits of the pose are too coarse to keep it inside. Borders of
//! several joints together (front, elbow, wrist) are not for one joint to keep: there the target stays as it is.

use super::super::cause::Cause;
use super::super::configuration::{CLEAR, range};
use super::Place;
use crate::error::counted;
use crate::program::script::pose::{PoseForm, PoseGoal, Quantity, Solution};
use crate::program::script::{At, Edits, Note, TargetRef};
use crate::robot::{GapOf, JointKind, Robot};

/// Half a last digit of a pose may move a joint by so much at most, rad.
const LOST_RAD: f64 = 1e-3;
/// A weight this much below a power of ten, as a logarithm, is one.
const TENTH: f64 = 1e-9;
/// Offsets below this are none, and a joint has its offset where no more than [`SHARE`] of it is missing, rad.
const NONE: f64 = 1e-6;
const SHARE: f64 = 0.1;

/// What rounding the numbers of a target to their written digits may do to it: lengths, m, and angles, rad.
#[derive(Debug, Clone, Copy, Default)]
pub struct Rounding {
    /// Half the last digits of its lengths, and of its angles.
    half: [f64; 2],
    /// Weight of the finest digit of its coarsest angle, rad.
    coarsest: f64,
}

impl Rounding {
    /// Of a target as edits write it. A part of a quaternion turns by twice as much.
    pub fn of(target: Option<&TargetRef>, edits: &Edits) -> Self {
        let mut all = Self::default();
        let Some(target) = target else { return all };
        for (k, value) in target.values.iter().enumerate() {
            if let (Some(value), Some(form)) = (value, target.pose.filter(|form| k < form.count())) {
                all.add(form, k, value.finest, edits.digit_of(target, k));
            }
        }
        all
    }

    /// Number `k` of a pose, whose last digit weighs `finest` at least and is to weigh no more than `wish`, in SI.
    pub fn add(&mut self, form: PoseForm, k: usize, finest: f64, wish: f64) {
        let angle = match form.quantity(k) {
            Quantity::Length => 0.0,
            Quantity::Angle => 1.0,
            Quantity::Ratio => 2.0,
        };
        // the next power of ten, in its own unit
        let most = finest.max(wish) / form.unit(k);
        let digit = if most > 0.0 { 10f64.powf((most.log10() + TENTH).floor()) * form.unit(k) } else { 0.0 };
        self.half[usize::from(angle > 0.0)] += 0.5 * digit * f64::max(1.0, angle);
        self.coarsest = self.coarsest.max(finest * angle);
    }
}

impl Place {
    /// The digits of a target determine its joints.
    ///
    /// # Errors
    /// They do not.
    pub fn determined(&self, q: &[f64], rounding: Rounding) -> Result<(), Cause> {
        let robot = &self.tooled.robot;
        if robot.dof() < 6 || !robot.axis_joints().all(|j| j.kind == JointKind::Revolute) {
            return Ok(());
        }
        let (_, jacobian) = robot.chain().jacobian(q);
        let least = jacobian.singular_values().min();
        if 0.5 * rounding.coarsest > LOST_RAD * least { Err(Cause::Singular) } else { Ok(()) }
    }

    /// How far rounding may move each of six joints, rad; `None`: of another arm, or in a singularity.
    fn rounded(&self, q: &[f64], rounding: Rounding) -> Option<Vec<f64>> {
        let (_, jacobian) = self.tooled.robot.chain().jacobian(q);
        let square = (jacobian.ncols() == 6).then(|| jacobian.fixed_columns::<6>(0).into_owned())?;
        let rows = square.try_inverse()?;
        let of = |k: usize| {
            let [along, turned] = [rows.fixed_view::<1, 3>(k, 0).norm(), rows.fixed_view::<1, 3>(k, 3).norm()];
            along * rounding.half[0] + turned * rounding.half[1]
        };
        Some((0..6).map(of).collect())
    }

    /// Joints `to` of a target, with their offsets, of which none goes over a border of its configuration; `q`: without offsets,
    /// `on_way`: at the end of a straight way or an arc.
    ///
    /// # Errors
    /// A joint stands beyond its border, or cannot be kept inside.
    pub fn held(
        &self,
        goal: &PoseGoal,
        on_way: bool,
        [q, to]: [&[f64]; 2],
        rounding: Rounding,
    ) -> Result<Vec<f64>, Cause> {
        if let Some((alone, count)) = self.alone(q) {
            let kept = alone.held(goal, on_way, [&q[count..], &to[count..]], rounding)?;
            return Ok(to[..count].iter().copied().chain(kept).collect());
        }
        let (Solution::Configured(configuration), true, true) =
            (&goal.solution, goal.binding, self.tooled.arm.is_some())
        else {
            return Ok(to.to_vec());
        };
        let ranges = || (0..to.len()).map(|axis| range(configuration, axis, q[axis], on_way));
        let clear = |(v, [lo, hi]): (&f64, [f64; 2])| (lo + CLEAR..=hi - CLEAR).contains(v);
        if to.iter().zip(ranges()).all(clear) {
            return Ok(to.to_vec());
        }
        let rounded = self.rounded(q, rounding).ok_or(Cause::Border)?;
        let kept = |(axis, [lo, hi]): (usize, [f64; 2])| {
            let (q, to, inside) = (q[axis], to[axis], rounded[axis]);
            if (lo + CLEAR..=hi - CLEAR).contains(&to) {
                return Ok(to);
            }
            // what stands a little outside as it is written goes no further
            let [least, most] =
                [if q < lo - inside { q } else { lo + inside }, if q > hi + inside { q } else { hi - inside }];
            let kept = to.max(least).min(most);
            let beyond = !(lo - CLEAR..=hi + CLEAR).contains(&q);
            if beyond || inside > CLEAR || lacks(q, to, kept) && in_a_sum(&self.tooled.robot, axis) {
                return Err(Cause::Border);
            }
            Ok(kept)
        };
        ranges().enumerate().map(kept).collect()
    }
}

/// A gear turns by this axis and others: what one of them lacks would be wrong at the others.
fn in_a_sum(robot: &Robot, axis: usize) -> bool {
    let holds = |g: &GapOf| !g.others.is_empty() && (g.axis == axis || g.others.iter().any(|o| o.0 == axis));
    robot.gap_of.iter().any(holds)
}

/// Whether a joint that goes from `q` to `to` and is `kept` lacks a part of its offset.
fn lacks(q: f64, to: f64, kept: f64) -> bool {
    (to - q).abs() > NONE && (to - kept).abs() > SHARE * (to - q).abs()
}

/// Joints whose offsets are not written, or not whole, as their targets stand on a border.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Held {
    /// By axis: targets, and the first of them.
    axes: Vec<(usize, Option<At>)>,
}

impl Held {
    /// One more target: joints `q`, `to` with their offsets, and as they are `kept`.
    pub fn count(&mut self, at: At, q: &[f64], to: &[f64], kept: &[f64]) {
        self.axes.resize(self.axes.len().max(q.len()), (0, None));
        for (axis, (count, first)) in self.axes.iter_mut().enumerate() {
            if lacks(q[axis], to[axis], kept[axis]) {
                *count += 1;
                first.get_or_insert(at);
            }
        }
    }

    /// What a reader has to know.
    pub fn notes(&self, robot: &Robot) -> Vec<Note> {
        let note = |(axis, (count, first)): (usize, &(usize, Option<At>))| {
            let text = format!(
                "{} at {} (first here) stays within the configuration that is written there and lacks its offset, or a part of it: \
                 the offset would cross a boundary of the configuration; the other joints have theirs",
                robot.axis(axis).name,
                counted(*count, "target"),
            );
            first.map(|place| Note { place, text })
        };
        self.axes.iter().enumerate().filter_map(note).collect()
    }
}
