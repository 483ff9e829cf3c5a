//! `joint_zero_offset`: the joint position differs from its command by a constant.
//!
//! Parameter: `offset` of either sign, at most 0.2 rad or 50 mm: a robot mastered worse than that does not reach its work.
//! Action: master the joint again (or enter the offset in the controller).

use super::common::*;
use super::site::within;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "joint_zero_offset",
    heading: "zero offset",
    stage: Stage::Link,
    family: Family::Geometry,
    acts_on: ActsOn::Joint,
    adds: "the joint position differs from its command by a constant",
    equation: "offset",
    reference: "Hollerbach, Wampler (1996), Int. J. Robotics Research 15(6)",
    parameters: &[("offset_deg", "either sign, within 0.2 rad (50 mm)")],
    confused_with: &["tool_error", "link_error"],
    decide_by: "fix the registration by measuring the base (first joint); measure two reflectors on the tool (last joint)",
    action: "master the joint again, or enter the offset in the controller",
    undone: "all of it, point by point",
    special: Special::NONE,
    example: ("{effect: joint_zero_offset, joint: A1, offset_deg: 0.003}", View::JointOverCommand),
    read: |f| Ok(JointZeroOffset { offset: f.length("offset", f64::NEG_INFINITY)? }.into()),
    typical: |size| vec![(size.key("offset"), if size.is_revolute() { 0.01 } else { 0.05 }.into())],
    candidates: |survey, list| {
        let zero = |offset| JointZeroOffset { offset };
        let one = |axis| Candidate::of_size(survey.robot, Target::Joint(axis), candidate::TRIAL, zero);
        list.extend(survey.all_axes().map(one));
    },
};

/// Constant, rad or m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointZeroOffset {
    /// Offset of the joint's zero, rad or m.
    pub offset: f64,
}

impl EffectType for JointZeroOffset {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn nature(&self) -> Nature {
        Nature::ZeroOffset
    }

    fn values(&self) -> Vec<f64> {
        vec![self.offset]
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { offset: v[0] }.into()
    }

    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        let most = if site.is_revolute() { 0.2 } else { 0.05 };
        vec![site.length("offset", within(most), site.typical(0.02, 0.1))]
    }

    fn add_to_joint(&self, _target: Target, _inputs: &dyn Inputs, joint: &mut [f64]) {
        joint.iter_mut().for_each(|q| *q += self.offset);
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::point_by_point()
    }
}
