//! `coupled_play`: play in a wrist axis that is driven through another one: the gap counts in the difference of both.
//!
//! The gear that has the play turns by `u = p - ratio * p_other`, so that it reverses where the difference does, also while the
//! joint itself goes on or stands. Adds `play(u) - u` to the joint. Reference: Craig (2005), Introduction to Robotics, 3rd ed.,
//! section 8.3, for wrists whose motors sit in the arm; the play operator is that of [`super::backlash`].
//!
//! Parameters: half gap 0 or more, at most 0.1 rad (10 mm); ratio of either sign, within 10 (rad or m per rad or m, in a file in the
//! units of the two joints). Row by row, with the turning points of the difference between rows estimated as those of a
//! joint. `rewrite` leaves it: an offset at the reversals of one joint alone does not follow the difference.

use super::common::*;
use super::site::within;
use serde_yaml::Value;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "coupled_play",
    heading: "coupled play",
    stage: Stage::Link,
    family: Family::Gap,
    acts_on: ActsOn::Coupling,
    adds: "play in a joint that is driven through another one",
    equation: "play(u) - u with u = p - ratio * p of the other joint",
    reference: "Craig (2005), Introduction to Robotics, 3rd ed., section 8.3",
    parameters: &[
        ("from", "the other joint"),
        ("half_gap_deg", "half of the gap, 0 to 0.1 rad (10 mm)"),
        ("ratio", "either sign, within 10"),
    ],
    confused_with: &["backlash", "axis_coupling"],
    decide_by: "reverse the other joint while this one continues in one direction",
    action: "remove the gap of the wrist's gears",
    undone: "nothing: it reverses with the difference of two joints",
    special: Special::NONE,
    example: ("{effect: coupled_play, target: A1<-A2, half_gap_deg: 0.003, ratio: 1}", View::JointOverOther),
    read: |f| {
        let per_ratio = f.site().user_units_per_ratio();
        Ok(CoupledPlay { half_gap: f.length("half_gap", 0.0)?, ratio: f.any("ratio")? / per_ratio }.into())
    },
    typical: |size| vec![(size.key("half_gap"), size.gap.into()), ("ratio".into(), Value::from(1.0))],
    candidates: |survey, list| {
        // wrists: a joint driven through the one before it
        for to in survey.moving().filter(|&a| a > 0) {
            let from = to - 1;
            let same = survey.robot.axis(to).kind == survey.robot.axis(from).kind;
            if !same || !survey.moving().any(|a| a == from) {
                continue;
            }
            for ratio in [1.0, -1.0] {
                let make = move |b: f64| CoupledPlay { half_gap: b.max(0.0), ratio };
                let one = Candidate::of_size(survey.robot, Target::Coupled { to, from }, candidate::TRIAL, make);
                list.push(one.positive().with_shape(1));
            }
        }
    },
};

/// Half gap (rad or m), and movement of the gear per movement of the other joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoupledPlay {
    /// Half gap, rad or m.
    pub half_gap: f64,
    /// Movement of the gear per movement of the other joint.
    pub ratio: f64,
}

impl EffectType for CoupledPlay {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        vec![self.half_gap, self.ratio]
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { half_gap: v[0], ratio: v[1] }.into()
    }

    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        let per_ratio = site.user_units_per_ratio();
        let (least, most) = within(10.0 / per_ratio);
        vec![
            site.length("half_gap", (0.0, site.most_lost()), site.typical(0.005, 0.005)),
            Parameter::new("ratio", per_ratio, (least, most), 1.0 / per_ratio),
        ]
    }

    fn add_to_joint(&self, target: Target, inputs: &dyn Inputs, joint: &mut [f64]) {
        let Target::Coupled { to, from } = target else { return };
        let driven = inputs.command(to).iter().zip(inputs.command(from));
        let u: Vec<f64> = driven.map(|(p, other)| p - self.ratio * other).collect();
        let Some(&first) = u.first() else { return };
        let mut turns = inputs.turning_points(&u).into_iter().peekable();
        let mut out = first;
        for (row, (q, &u)) in joint.iter_mut().zip(&u).enumerate() {
            out = out.clamp(u - self.half_gap, u + self.half_gap);
            *q += out - u;
            while let Some((_, _, turn)) = turns.next_if(|t| t.0 == row) {
                out = out.clamp(turn - self.half_gap, turn + self.half_gap);
            }
        }
    }

    fn has_memory(&self) -> bool {
        true
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::nothing("its reversals are those of a difference of two joints")
    }
}
