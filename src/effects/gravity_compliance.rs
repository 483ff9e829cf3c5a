//! `gravity_compliance`: the gear yields to gravity: adds `compliance * torque` about the joint's axis.
//!
//! The torque is that of the weights of `links` and, where logged, of `payload_kg` at the flange, at the commanded pose; a positive
//! one turns the joint positive. Parameter: compliance 0 or more (a spring gives way along its load), at most 1e-3 rad/Nm or
//! 1e-4 m/N. Action: an elasto-static correction (most controllers have one, with load data); check the counterbalance.

use super::common::*;
use super::free_mass_gravity;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "gravity_compliance",
    heading: "gravity compliance",
    stage: Stage::Link,
    family: Family::Gravity,
    acts_on: ActsOn::Joint,
    adds: "the joint yields to gravity",
    equation: "compliance * gravity torque about the joint (a positive torque turns it in the positive direction), from links and payload_kg; with moments sum x_i (z_j cross x_i).g + y_i (z_j cross y_i).g",
    reference: "Whitney, Lozinski, Rourke (1986), J. Dynamic Systems, Measurement, and Control 108(1); Khalil, Dombre (2002), Modeling, Identification and Control of Robots, for the moments",
    parameters: &[
        (
            "compliance_deg_per_nm",
            "0 to 1e-3 rad/Nm (1e-4 m/N); never negative, because a spring yields along its load",
        ),
        (
            "moments",
            "instead of compliance, if the masses are not known: [[JOINT, x_deg, y_deg], ...], the deflection that each link causes when its x or y axis is perpendicular to gravity",
        ),
    ],
    confused_with: &["joint_zero_offset", "link_error"],
    decide_by: "repeat the poses with another payload",
    action: "enter load data, use the controller's elasto-static correction, check the counterbalance",
    undone: "the part of the links (without payload), point by point",
    special: Special { further: free_mass_gravity::further, ..Special::NONE },
    example: ("{effect: gravity_compliance, joint: A1, compliance_deg_per_nm: 1.0e-5}", View::JointOverCommand),
    read: |f| {
        let site = f.site();
        if f.has("moments") {
            return free_mass_gravity::read(f);
        }
        Ok(GravityCompliance { compliance: f.any(key(&site))? * site.si_per_user_unit() }.into())
    },
    typical: |size| {
        let key = if size.is_revolute() { REVOLUTE_KEY } else { PRISMATIC_KEY };
        vec![(key.into(), 2e-5.into())]
    },
    candidates: |survey, list| {
        let yields = |compliance| GravityCompliance { compliance };
        let one = |axis| Candidate::of_size(survey.robot, Target::Joint(axis), 1e-8, yields).positive();
        list.extend(survey.all_axes().filter(|&a| survey.axes[a].loaded).map(one));
    },
};

pub(super) const REVOLUTE_KEY: &str = "compliance_deg_per_nm";
pub(super) const PRISMATIC_KEY: &str = "compliance_mm_per_n";

/// rad/Nm, or m/N for a prismatic joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GravityCompliance {
    /// Compliance, rad/Nm or m/N.
    pub compliance: f64,
}

pub(super) fn key(site: &Site) -> &'static str {
    if site.is_revolute() { REVOLUTE_KEY } else { PRISMATIC_KEY }
}

/// The compliance of a joint: a spring yields along its load, and not without bounds.
pub(super) fn parameter(site: &Site, typical: f64) -> Parameter {
    let most = if site.is_revolute() { 1e-3 } else { 1e-4 };
    Parameter::new(key(site), 1.0 / site.si_per_user_unit(), (0.0, most), site.typical(typical, typical))
}

impl EffectType for GravityCompliance {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        vec![self.compliance]
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { compliance: v[0] }.into()
    }

    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        vec![parameter(site, 2e-5)]
    }

    fn add_to_joint(&self, target: Target, inputs: &dyn Inputs, joint: &mut [f64]) {
        if let Target::Joint(axis) = target {
            joint.iter_mut().zip(inputs.gravity_torque(axis)).for_each(|(q, t)| *q += self.compliance * t);
        }
    }

    fn uses_gravity(&self) -> bool {
        true
    }

    fn idle(&self, site: &Site, _settled_poses: bool) -> Option<&'static str> {
        site.without_links()
    }

    fn undo(&self, context: &UndoContext) -> Undo {
        self.idle(&context.site, false).map_or_else(Undo::point_by_point, Undo::nothing)
    }
}
