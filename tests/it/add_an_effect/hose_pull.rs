//! `hose_pull`: the hose package pulls the joint back, the more the farther it turns: adds `-pull * (p / 90 deg)^3`.
//!
//! Parameter: `pull_deg`, the error at 90 deg, 0 to 0.1 rad. It depends on the position alone, so that `rewrite` undoes it
//! point by point. Action: give the hose more slack.

use lostmotion::effects::*;
use std::f64::consts::FRAC_PI_2;

pub static INFO: EffectInfo = EffectInfo {
    name: "hose_pull",
    heading: "hose pull",
    stage: Stage::Gear,
    family: Family::Gravity,
    acts_on: ActsOn::Joint,
    adds: "the hose package pulls the joint back",
    equation: "-pull (p / 90 deg)^3",
    reference: "an example of this page",
    parameters: &[("pull_deg", "error at 90 deg, 0 to 0.1 rad (10 mm)")],
    confused_with: &["encoder_scale"],
    decide_by: "move the joint through its whole range, once without the hose package",
    action: "give the hose package more slack",
    undone: "all of it, point by point",
    special: Special { needs_motion: true, ..Special::NONE },
    example: ("{effect: hose_pull, joint: A1, pull_deg: 0.004}", View::JointOverCommand),
    read: |f| Ok(HosePull { pull: f.length("pull", 0.0)? }.into()),
    typical: |size| vec![(size.key("pull"), size.gap.into())],
    candidates: |survey, list| {
        let one = |axis| Candidate::of_size(survey.robot, Target::Joint(axis), 1e-6, |pull| HosePull { pull });
        list.extend(survey.moving().map(|axis| one(axis).positive()));
    },
};

/// Error at 90 deg, rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HosePull {
    pub pull: f64,
}

impl EffectType for HosePull {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        vec![self.pull]
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { pull: v[0] }.into()
    }

    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        vec![site.length("pull", (0.0, site.most_lost()), site.typical(0.005, 0.01))]
    }

    fn position_error(&self, arriving: f64, _rev: f64) -> Option<f64> {
        Some(-self.pull * (arriving / FRAC_PI_2).powi(3))
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::point_by_point()
    }
}
