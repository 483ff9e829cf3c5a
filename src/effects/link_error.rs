//! `link_error`: a DH parameter of a joint (`a`, `d`, `alpha`, `beta`) differs from the robot file.
//!
//! `beta` is Hayati's twist: a turn about y after that about x, by which the next axis of two parallel ones (the standard convention;
//! in Craig's the joint's own axis) tilts out of their plane, which `a`, `d` and `alpha` cannot express (Hayati 1983, IEEE CDC;
//! Hayati, Mirmirani 1985, J. Robotic Systems 2(4)). Typical: 0.005 to 0.03 deg.
//!
//! Parameter: `delta` of either sign, at most 50 mm or 0.1 rad: a robot farther off is another robot. Action: enter the
//! calibrated parameter, where the controller allows it; else correct poses with the calibrated inverse kinematics.

use super::common::*;
use super::site::within;
use crate::robot::JointKind;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "link_error",
    heading: "link",
    stage: Stage::Geometry,
    family: Family::Geometry,
    acts_on: ActsOn::DhParameter(&DhParameter::ALL),
    adds: "a DH parameter differs from the robot file",
    equation: "a, d, alpha or beta of a joint plus delta; beta: Rot_y(beta) after Rot_x(alpha)",
    reference: "Hollerbach, Wampler (1996), Int. J. Robotics Research 15(6); Hayati, Mirmirani (1985), J. Robotic Systems 2(4)",
    parameters: &[("delta_mm or delta_deg", "either sign, within 50 mm or 0.1 rad")],
    confused_with: &["joint_zero_offset", "tool_error", "encoder_scale"],
    decide_by: "poses over the whole workspace, each joint through its range; parallel axes share their d",
    action: "enter the calibrated parameter, or correct poses with the calibrated kinematics",
    undone: "nothing: it changes poses, not joint positions",
    special: Special { further, ..Special::NONE },
    example: ("{effect: link_error, target: A1.a, delta_mm: 0.1}", View::TcpOverTime),
    read: |f| Ok(LinkError { delta: f.length("delta", f64::NEG_INFINITY)? }.into()),
    typical: |size| {
        let angle = size.target.ends_with(".alpha") || size.target.ends_with(".beta");
        vec![if angle { ("delta_deg".into(), 0.005.into()) } else { ("delta_mm".into(), 0.1.into()) }]
    },
    candidates,
};

/// Change of the parameter, m or rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkError {
    /// Change of the parameter, m or rad.
    pub delta: f64,
}

fn candidates(survey: &Survey, list: &mut Vec<Candidate>) {
    if !survey.points {
        return;
    }
    for (joint, j) in survey.robot.joints.iter().enumerate() {
        for parameter in [DhParameter::A, DhParameter::D, DhParameter::Alpha] {
            // a prismatic joint's d is its zero offset
            if parameter == DhParameter::D && j.kind == JointKind::Prismatic {
                continue;
            }
            let target = Target::Link { joint, parameter };
            list.push(Candidate::of_size(survey.robot, target, 1e-5, |delta| LinkError { delta }));
        }
    }
}

/// Sine of the angle between two axes below which they count as parallel.
const PARALLEL: f64 = 0.05;

/// Hayati's twist of every joint beside a parallel one.
fn further(survey: &Survey, list: &mut Vec<Candidate>) {
    if !survey.points {
        return;
    }
    for (joint, j) in survey.robot.joints.iter().enumerate() {
        if j.alpha_rad.sin().abs() < PARALLEL {
            let target = Target::Link { joint, parameter: DhParameter::Beta };
            list.push(Candidate::of_size(survey.robot, target, 1e-5, |delta| LinkError { delta }));
        }
    }
}

impl EffectType for LinkError {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn nature(&self) -> Nature {
        Nature::Link
    }

    fn values(&self) -> Vec<f64> {
        vec![self.delta]
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { delta: v[0] }.into()
    }

    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        let most = if site.is_revolute() { 0.1 } else { 0.05 };
        vec![site.length("delta", within(most), site.typical(0.02, 0.3))]
    }

    fn change_geometry(&self, target: Target, geometry: &mut Geometry) {
        let Target::Link { joint, parameter } = target else { return };
        let Some(j) = geometry.joints.get_mut(joint) else { return };
        match parameter {
            DhParameter::A => j.a_m += self.delta,
            DhParameter::D => j.d_m += self.delta,
            DhParameter::Alpha => j.alpha_rad += self.delta,
            DhParameter::Beta => j.beta_rad += self.delta,
        }
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::moves_poses()
    }
}
