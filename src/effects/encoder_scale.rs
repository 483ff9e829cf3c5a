//! `encoder_scale`: the joint moves a little more, or less, than commanded, in proportion: adds `scale * p`.
//!
//! Parameter: `scale_ppm`, within 5 %, beyond which a gear ratio is entered wrongly. It acts on the signal that arrives.
//! Action: correct the gear ratio, or the scale of the encoder, in the controller; an offset `-scale * p` undoes it.

use super::common::*;
use super::site::within;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "encoder_scale",
    heading: "encoder scale",
    stage: Stage::Gear,
    family: Family::Scale,
    acts_on: ActsOn::Joint,
    adds: "the joint moves proportionally more or less than commanded",
    equation: "scale p",
    reference: "gain error of a joint sensor: Mooring, Roth, Driels (1991), Fundamentals of Manipulator Calibration",
    parameters: &[("scale_ppm", "either sign, within 50,000 ppm; more means a wrong gear ratio")],
    confused_with: &["transmission_error", "link_error", "joint_zero_offset"],
    decide_by: "move the joint through its whole range",
    action: "correct the gear ratio or encoder scale in the controller",
    undone: "all of it, point by point",
    special: Special { needs_motion: true, ..Special::NONE },
    example: ("{effect: encoder_scale, joint: A1, scale_ppm: 150}", View::JointOverCommand),
    read: |f| Ok(EncoderScale { scale: f.any("scale_ppm")? * 1e-6 }.into()),
    typical: |_| vec![("scale_ppm".into(), 100.0.into())],
    candidates: |survey, list| {
        let one = |axis| Candidate::of_size(survey.robot, Target::Joint(axis), 1e-6, |scale| EncoderScale { scale });
        list.extend(survey.moving().map(one));
    },
};

/// Relative error of the movement (1e-6 per ppm).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EncoderScale {
    /// Relative error of the movement.
    pub scale: f64,
}

impl EffectType for EncoderScale {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn nature(&self) -> Nature {
        Nature::Scale
    }

    fn values(&self) -> Vec<f64> {
        vec![self.scale]
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { scale: v[0] }.into()
    }

    fn parameters(&self, _site: &Site) -> Vec<Parameter> {
        vec![Parameter::new("scale_ppm", 1e6, within(0.05), 1e-4)]
    }

    fn position_error(&self, arriving: f64, _rev: f64) -> Option<f64> {
        Some(self.scale * arriving)
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::point_by_point()
    }
}
