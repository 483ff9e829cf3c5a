//! `axis_coupling`: a joint also moves in proportion to another joint's command: adds `ratio * p` of that joint.
//!
//! Wrists whose motors sit in the arm are geared this way; the controller takes it out, with a ratio that may be wrong.
//! Parameter: `ratio` (rad or m per rad or m; at the edges in the units of the two joints), at most 0.5 either way: hollow-shaft
//! wrists couple by 1/100 or so, and only the error of the ratio is left. Action: correct the coupling ratio in the controller.

use super::common::*;
use super::site::within;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "axis_coupling",
    heading: "axis coupling",
    stage: Stage::Link,
    family: Family::Scale,
    acts_on: ActsOn::Coupling,
    adds: "a joint also moves in proportion to another joint",
    equation: "ratio * p of the other joint",
    reference: "Mooring, Roth, Driels (1991), Fundamentals of Manipulator Calibration (joint coupling)",
    parameters: &[("from", "the other joint"), ("ratio", "either sign, within 0.5")],
    confused_with: &["link_error", "encoder_scale"],
    decide_by: "move the other joint alone",
    action: "correct the coupling ratio in the controller",
    undone: "all of it, point by point",
    special: Special::NONE,
    example: ("{effect: axis_coupling, target: A1<-A2, ratio: 0.0002}", View::JointOverOther),
    read: |f| {
        let per_user_unit = 1.0 / f.site().user_units_per_ratio();
        Ok(AxisCoupling { ratio: f.any("ratio")? * per_user_unit }.into())
    },
    typical: |_| vec![("ratio".into(), 1e-4.into())],
    candidates,
};

/// Movement of this joint per movement of the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisCoupling {
    /// Movement of this joint per movement of the other one, rad or m per rad or m.
    pub ratio: f64,
}

/// A joint at rest may still be moved by another one, of its kind.
fn candidates(survey: &Survey, list: &mut Vec<Candidate>) {
    let robot = survey.robot;
    for to in survey.all_axes() {
        let kind = robot.axis(to).kind;
        let drives = |from: &usize| {
            *from != to && robot.axis(*from).kind == kind && survey.axes[*from].travel > 1e-3 * kind.si_per_user_unit()
        };
        for from in survey.all_axes().filter(drives) {
            let target = Target::Coupled { to, from };
            list.push(Candidate::of_size(survey.robot, target, 1e-6, |ratio| AxisCoupling { ratio }));
        }
    }
}

impl EffectType for AxisCoupling {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn nature(&self) -> Nature {
        Nature::Coupling
    }

    fn values(&self) -> Vec<f64> {
        vec![self.ratio]
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { ratio: v[0] }.into()
    }

    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        let per_ratio = site.user_units_per_ratio();
        vec![Parameter::new("ratio", per_ratio, within(0.5 / per_ratio), 1e-4 / per_ratio)]
    }

    fn add_to_joint(&self, target: Target, inputs: &dyn Inputs, joint: &mut [f64]) {
        if let Target::Coupled { from, .. } = target {
            joint.iter_mut().zip(inputs.command(from)).for_each(|(q, p)| *q += self.ratio * p);
        }
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::point_by_point()
    }
}
