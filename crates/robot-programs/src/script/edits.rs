//! What shall be different about a program, move by move.
//!
//! Nearly every move of a program may get another goal, and few get more than that: goals stand one after the other
//! ([`StepEdits`], in `steps`), the rest has a separate list. A caller gets an [`EditRef`], which shows an [`Edit`] as it was put in.

mod steps;

use super::number::{self, Own};
use super::pose::Quantity;
use super::targets::TargetRef;
use super::text::Text;
use crate::axes::JointKind;
pub use steps::StepEdits;

/// What shall be different, by step. A step that is not named stays as it is.
#[derive(Debug, Clone, Default)]
pub struct Edits {
    /// Edits by number of the step.
    pub steps: StepEdits,
    /// Weight that the last digit of a changed number of each axis should have at most, rad or m. A format that cannot write
    /// that fine writes its finest.
    pub digit: Vec<f64>,
    /// The same for lengths (m) and angles (rad) of poses; 0: as they stand.
    pub pose_digit: [f64; 2],
}

impl Edits {
    /// Weight that the last digit of number `k` of a target should have at most, in SI; NaN: no wish.
    pub fn digit_of(&self, target: &TargetRef, k: usize) -> f64 {
        match target.quantity(k) {
            None => self.digit.get(k).copied().unwrap_or(f64::NAN),
            Some(Quantity::Length) => self.pose_digit[0],
            // a part of a quaternion turns by twice as much
            Some(Quantity::Angle) => self.pose_digit[1],
            Some(Quantity::Ratio) => 0.5 * self.pose_digit[1],
        }
    }
}

/// What shall be different about one move.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Edit {
    /// Points to be put on the way to the goal, in order.
    pub before: Vec<NewPoint>,
    /// Joint values of the goal, rad or m, one per axis; an axis that the target does not command is not written. Of a Cartesian
    /// target that stays one (see [`Edit::as_joint_moves`]): the numbers of its pose, in SI.
    pub goal: Option<Vec<f64>>,
    /// The corner at the goal may be cut within this radius at most, m: a new point lies near. Formats whose controllers
    /// shrink overlapping corners by themselves need not do anything.
    pub blend_at_most_m: Option<f64>,
    /// Write this Cartesian move as joint moves: `before` and `goal` are all of it.
    pub as_joint_moves: bool,
    /// Of an arc through three points: the point on the way of each piece, one for each of `before` and one for the goal; joints as
    /// in `before`, and once they are poses positions in the frame of the goal, m. Empty: the program's own stays.
    pub vias: Vec<Vec<f64>>,
}

impl Edit {
    /// The arc stays whole: its new points go. Returns how many there were.
    pub fn clear_points(&mut self) -> u64 {
        let points = self.before.len() as u64;
        self.before.clear();
        self.vias.clear();
        points
    }

    fn has_rest(&self) -> bool {
        let Self { before, blend_at_most_m, as_joint_moves, vias, .. } = self;
        *as_joint_moves || blend_at_most_m.is_some() || !before.is_empty() || !vias.is_empty()
    }
}

/// A point to be added.
#[derive(Debug, Clone, PartialEq)]
pub struct NewPoint {
    /// rad or m, one per axis; before a Cartesian target that stays one: the numbers of its pose, in SI.
    pub q: Vec<f64>,
    /// Share of the way to the goal, 0 to 1.
    pub share: f64,
    /// Time since the program's start where the program has times, s.
    pub t_s: Option<f64>,
    /// Half the distance to the nearer neighbour at the TCP, m: the largest radius within which its corner may be cut.
    pub clearance_m: f64,
    /// Whether it is one of the turning points of [`super::Move::way`], moved by its offset, and no new one.
    pub of_way: bool,
    /// Whether the program must wait at it as it does at the goal ([`super::How::waits`]): its corner must not be cut.
    pub waits: bool,
}

/// An [`Edit`] of [`StepEdits`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EditRef<'a> {
    /// [`Edit::before`].
    pub before: &'a [NewPoint],
    /// [`Edit::goal`].
    pub goal: Option<&'a [f64]>,
    /// [`Edit::blend_at_most_m`].
    pub blend_at_most_m: Option<f64>,
    /// [`Edit::as_joint_moves`].
    pub as_joint_moves: bool,
    /// [`Edit::vias`].
    pub vias: &'a [Vec<f64>],
}

impl<'a> EditRef<'a> {
    /// Over which place piece `n` (of the points before the goal, then the goal's) goes; `None`: over the program's own.
    pub fn piece(&self, n: usize) -> Option<&'a [f64]> {
        self.vias.get(n).map(Vec::as_slice)
    }
}

impl From<EditRef<'_>> for Edit {
    fn from(edit: EditRef<'_>) -> Self {
        Self {
            before: edit.before.to_vec(),
            goal: edit.goal.map(<[f64]>::to_vec),
            blend_at_most_m: edit.blend_at_most_m,
            as_joint_moves: edit.as_joint_moves,
            vias: edit.vias.to_vec(),
        }
    }
}

/// Numbers of a pose that differ by less are the same, m, rad or 1: rounding of the arithmetic.
const SAME_NUMBER: f64 = 1e-11;

impl TargetRef<'_> {
    /// SI value of the unit in which number `k` of a pose is written; `None`: it holds joint values.
    pub fn pose_unit(&self, k: usize) -> Option<f64> {
        let form = self.pose?;
        match self.beside(k) {
            Some(kind) => Some(kind.si_per_user_unit()),
            None => Some(form.unit(k)),
        }
    }

    /// What number `k` of a pose is; `None`: it holds joint values.
    pub fn quantity(&self, k: usize) -> Option<Quantity> {
        let form = self.pose?;
        Some(match self.beside(k) {
            Some(JointKind::Prismatic) => Quantity::Length,
            Some(JointKind::Revolute) => Quantity::Angle,
            None => form.quantity(k),
        })
    }

    /// The kind of the external axis whose number `k` is; `None`: it is one of the pose itself.
    fn beside(&self, k: usize) -> Option<JointKind> {
        let own = self.values.get(k).filter(|_| self.pose.is_some_and(|form| k >= form.count()))?;
        // its last digit tells the unit: 0.001 m, or a 180th of pi
        let unit = own.digit / number::last_digit(own.style.decimals);
        let linear = (unit - JointKind::Prismatic.si_per_user_unit()).abs() < 0.1 * unit;
        Some(if linear { JointKind::Prismatic } else { JointKind::Revolute })
    }

    /// New text of number `k` of a pose for a value in SI; `None`: it stays as it is. `text`: the bytes of the program.
    pub fn pose_number(&self, k: usize, value: f64, edits: &Edits, text: &Text) -> Option<String> {
        self.pose_number_of_size(k, value, edits, text, |_| f64::INFINITY)
    }

    /// The same where a number's size says how fine it can be: `finest` gives the weight of the last digit, both in the
    /// number's own unit.
    pub fn pose_number_of_size(
        &self,
        k: usize,
        value: f64,
        edits: &Edits,
        text: &Text,
        finest: impl Fn(f64) -> f64,
    ) -> Option<String> {
        let (unit, own) = (self.pose_unit(k)?, self.values.get(k)?);
        if (value - own.si).abs() <= SAME_NUMBER {
            return None;
        }
        let finest = (own.finest / unit).min(finest(value / unit));
        let there = Own { text: text.slice(own.span()), value: own.si / unit, style: own.style };
        number::changed(there, value / unit, edits.digit_of(self, k) / unit, finest)
    }
}
