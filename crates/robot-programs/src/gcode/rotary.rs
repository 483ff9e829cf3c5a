//! Rotary axes whose way is not certain: a control with rollover takes the shorter way to an absolute angle.
//!
//! `A10` after `A350` turns back by 340 deg as it is counted, and on by 20 deg with rollover (Fanuc parameters 1006#0 and 1008; Haas
//! setting 162). Below 180 deg both are the same. An axis that cannot turn once around has one way alone. Relative words go as they are
//! written.

use super::certain::Carried;
use super::lex::Block;
use super::read::Reader;
use super::reason::After;
use crate::axes::JointKind;
use crate::script::{At, AxisSet, Break, Note, StepKind};
use std::f64::consts::TAU;

/// From this on the shorter way may be the other one, deg. The rest is for offsets: none turns a way that is shorter into one that is
/// longer.
const HALF_TURN: f64 = 179.0;
/// Ways so near to half a turn may be shorter to the other side with an offset, deg.
const NEAR_HALF: f64 = 1.0;

impl Reader<'_> {
    /// A way of an axis from and to these places, deg, may be another one on a control with rollover.
    pub(super) fn may_roll_over(&self, axis: usize, from: f64, to: f64) -> bool {
        let joint = self.robot.axis(axis);
        let around = || joint.limits.is_none_or(|[low, high]| high - low >= TAU - 1e-6);
        joint.kind == JointKind::Revolute
            && (to - from).abs() >= HALF_TURN
            && !self.robot.control.no_rollover
            && around()
    }

    /// A turn by about half a turn starts where it always did: with an offset the other way might be the shorter one.
    pub(super) fn keep_before_half_turn(&mut self, block: &Block) {
        if self.absolute == Some(false) {
            return;
        }
        let near = |from: f64, to: f64| ((to - from).rem_euclid(360.0) - 180.0).abs() <= NEAR_HALF;
        let turn = |w: &super::lex::Word| {
            let a = self.letters.iter().position(|own| *own == w.letter)?;
            let to = self.shift(a) + w.value?.0;
            let half = |from: f64| near(from, to) && self.may_roll_over(a, from, to);
            match self.position[a] {
                Some(from) => self.last.filter(|_| half(from)),
                // where it is not known any more, from where it was known last
                None => match self.carried[a] {
                    Carried::After(step) => {
                        let places = self.statements.places_of(step, self.letters.len());
                        Some(step).filter(|_| places.and_then(|p| p.goal.get(a).copied()).is_some_and(half))
                    }
                    _ => None,
                },
            }
        };
        let steps: Vec<usize> = block.words.iter().filter_map(turn).collect();
        steps.into_iter().for_each(|step| self.anchor_at(step, After::HalfTurn));
    }

    /// Of axes that may take another way to where a block leads it is not known any more from which side they come.
    pub(super) fn rolls_over(&mut self, k: usize, block: &Block) {
        let (Some(true), Some(inch)) = (self.absolute, self.inch) else { return };
        let axis = |l: u8| self.letters.iter().position(|own| *own == l);
        let over = |w: &super::lex::Word| {
            let a = axis(w.letter)?;
            let to = self.shift(a) + w.value?.0 * self.unit(a, inch);
            self.position[a].filter(|from| self.may_roll_over(a, *from, to)).map(|_| a)
        };
        let axes: AxisSet = block.words.iter().filter_map(over).collect();
        if axes.is_empty() {
            return;
        }
        self.lose_axes(axes, After::RollOver);
        self.step(k, StepKind::Break(Break::Axes(axes)), None);
        if !self.has_noted_rollover {
            self.has_noted_rollover = true;
            let text = "a rotary axis turns by 179 deg or more to an absolute angle: a control with rollover takes the shorter way, so from \
                        which side it comes is not known: if it turns as it is counted, assume no-rollover (an option), or write \
                        `control: [no-rollover]` into the robot file";
            self.script.notes.push(Note { place: At::of_line(k), text: text.into() });
        }
    }

    /// The step before, in the same line, is that of a rotary axis whose way is not known.
    pub(super) fn is_after_rollover(&self) -> bool {
        let turns = |a: usize| self.robot.axis(a).kind == JointKind::Revolute;
        match self.script.steps.last().map(|s| &s.kind) {
            Some(StepKind::Break(Break::Axes(axes))) => axes.axes().any(turns),
            _ => false,
        }
    }
}
