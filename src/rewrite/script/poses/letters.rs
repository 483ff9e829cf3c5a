//! The two wrists with which a pose is reached, and what a letter of its configuration says of them.

use super::super::configuration::{self, prefers};
use super::Place;
use super::solve::{SAME, SLACK, distance};
use crate::program::script::pose::{Configuration, PoseGoal, Solution};
use crate::robot::arm;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

impl Place {
    /// Whether the letter for the wrist alone chose these joints: the other wrist has the same configuration else.
    pub fn is_by_letter(&self, goal: &PoseGoal, q: &[f64]) -> bool {
        if let Some((alone, count)) = self.alone(q) {
            return alone.is_by_letter(goal, q.get(count..).unwrap_or_default());
        }
        let (Some(arm), Solution::Configured(c)) = (&self.tooled.arm, &goal.solution) else { return false };
        let robot = &self.tooled.robot;
        let all = arm.solutions(robot, &robot.forward(q), q);
        let own = prefers(c, arm, q, self.flip);
        configuration::says_flipped(c).is_some()
            && self.configured(arm, c, &all, q).iter().any(|other| prefers(c, arm, other, self.flip) != own)
    }

    /// Whether the letter of a target for the wrist says other than joints that certainly reach it.
    pub fn contradicts(&self, goal: &PoseGoal, q: &[f64]) -> bool {
        let Some((_, _, q)) = self.tooled.arm_of(q).filter(|_| goal.binding) else { return false };
        let Solution::Configured(c) = &goal.solution else { return false };
        let is = self.flip.and_then(|flip| flip.is_clearly_flipped(q));
        is.zip(configuration::says_flipped(c)).is_some_and(|(is, says)| is != says)
    }

    /// Whether the joints next to those before have the configuration of a target but for its letter, and those with its letter are further
    /// away by far.
    pub fn turns_over_for_letter(&self, goal: &PoseGoal, from: &[f64]) -> bool {
        if let Some((alone, count)) = self.alone_at(goal, Some(from)) {
            return alone.turns_over_for_letter(goal, from.get(count..).unwrap_or_default());
        }
        let (Some(arm), Solution::Configured(c)) = (&self.tooled.arm, &goal.solution) else { return false };
        let Some(end) = self.world(goal, Some(from)) else { return false };
        let robot = &self.tooled.robot;
        let all = self.configured(arm, c, &arm.solutions(robot, &arm::pose_of(&end), from), from);
        let nearest = |says: bool| {
            let of = all.iter().filter(|q| prefers(c, arm, q, self.flip) == says);
            of.map(|q| distance(q, from)).min_by(f64::total_cmp)
        };
        nearest(false).zip(nearest(true)).is_some_and(|(other, own)| own > other + FRAC_PI_2)
    }

    /// Whether joint 4 stands where its turn ends that the target names.
    pub fn stands_on_turn(&self, goal: &PoseGoal, q: &[f64]) -> bool {
        let Some((_, _, q)) = self.tooled.arm_of(q) else { return false };
        let Solution::Configured(c) = &goal.solution else { return false };
        let on = |v: &f64| configuration::range(c, 3, *v, false).iter().any(|end| (v - end).abs() <= SLACK);
        q.get(3).is_some_and(on)
    }
}

/// Whether joints 4 and 6 turn by the same amount from one to the other whichever wrist the letter of both means; of FANUC's alone, whose
/// letter means a sign of joint 5. The other wrist has joints 4 and 6 half a turn further, within the turns that are written.
pub(super) fn turns_alike(configuration: &Configuration, from: &[f64], to: &[f64]) -> bool {
    let other = |v: f64| {
        let middle = (v / TAU).round() * TAU;
        if v > middle { v - PI } else { v + PI }
    };
    let alike = |axis: usize| match (from.get(axis), to.get(axis)) {
        (Some(a), Some(b)) => ((other(*b) - other(*a)) - (b - a)).abs() < SAME,
        _ => false,
    };
    matches!(configuration, Configuration::Fanuc { .. }) && alike(3) && alike(5)
}
