//! `process_force`: the joint yields to the force of the process: adds `compliance * torque` about the joint's axis.
//!
//! The force is what acts on the tool at the TCP, from the log's columns `fx_n, fy_n, fz_n`, in the axes of the robot's world frame;
//! its torque about a joint is `J^T F` at the commanded pose, and a positive one turns the joint positive. Moments on the tool are not
//! in it. Reference: Dumas, Caro, Garnier, Furet (2011), Robotics and Computer-Integrated Manufacturing 27(4); Schneider, Momeni-K.,
//! Ansaloni, Verl (2014), IROS, for machining.
//!
//! Parameter: compliance 0 or more (a spring gives way along its load), at most 1e-3 rad/Nm or 1e-4 m/N. It is the spring of
//! `gravity_compliance` under another load. Without the columns it does nothing.

use super::common::*;
use super::gravity_compliance::{PRISMATIC_KEY, REVOLUTE_KEY, key, parameter};

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "process_force",
    heading: "process force",
    stage: Stage::Link,
    family: Family::Gravity,
    acts_on: ActsOn::Joint,
    adds: "the joint yields to the measured force of the process on the tool",
    equation: "compliance J^T F about the joint, F on the tool at the TCP from the columns fx_n, fy_n, fz_n, in the axes of the robot's world frame",
    reference: "Dumas, Caro, Garnier, Furet (2011), Robotics and Computer-Integrated Manufacturing 27(4); Schneider, Momeni-K., Ansaloni, Verl (2014), IROS",
    parameters: &[(
        "compliance_deg_per_nm",
        "0 to 1e-3 rad/Nm (1e-4 m/N); never negative, because a spring yields along its load",
    )],
    confused_with: &["gravity_compliance", "torque_windup", "servo_lag"],
    decide_by: "record the same path with and without the process, or press the tool against a fixed load cell in several directions and poses",
    action: "take lighter cuts or another pose, in which the soft joint has a shorter lever to the force; stiffen the joint",
    undone: "nothing: a program contains no force",
    special: Special::NONE,
    example: ("{effect: process_force, joint: A1, compliance_deg_per_nm: 1.0e-5}", View::JointOverTime),
    read: |f| {
        let site = f.site();
        Ok(ProcessForce { compliance: f.needed(key(&site), 0.0)? * site.si_per_user_unit() }.into())
    },
    typical: |size| {
        let key = if size.is_revolute() { REVOLUTE_KEY } else { PRISMATIC_KEY };
        vec![(key.into(), TYPICAL.into())]
    },
    candidates: |survey, list| {
        let yields = |compliance| ProcessForce { compliance };
        let one = |axis| Candidate::of_size(survey.robot, Target::Joint(axis), 1e-8, yields).positive();
        list.extend(survey.all_axes().filter(|&a| survey.axes[a].pressed).map(one));
    },
};

/// deg/Nm, or mm/N: 6e5 Nm/rad, of a robot for some hundred kg.
const TYPICAL: f64 = 1e-4;

/// Compliance of a joint under the force on the tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProcessForce {
    /// Compliance, rad/Nm or m/N.
    pub compliance: f64,
}

impl EffectType for ProcessForce {
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
        vec![parameter(site, TYPICAL)]
    }

    fn add_to_joint(&self, target: Target, inputs: &dyn Inputs, joint: &mut [f64]) {
        let Some(torque) = target.axis().and_then(|axis| inputs.process_torque(axis)) else { return };
        joint.iter_mut().zip(torque).for_each(|(q, t)| *q += self.compliance * t);
    }

    fn without_columns(&self, target: Target, inputs: &dyn Inputs) -> Option<&'static str> {
        let axis = target.axis()?;
        inputs.process_torque(axis).is_none().then_some("fx_n, fy_n, fz_n")
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::nothing("a program contains no force")
    }
}
