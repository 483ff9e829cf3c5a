//! `torque_windup`: the gear winds up under the torque that the drive measures: adds `compliance * torque + cubic * torque^3`.
//!
//! The torque is the log's column `torque_<joint>_nm` (a force in N for a prismatic joint): it holds weight, acceleration and
//! friction together. A gear that stiffens has a cubic term of the other sign. Reference: Spong (1987), J. Dynamic Systems,
//! Measurement, and Control 109(4), for the flexible joint; Tuttle, Seering (1996), IEEE Trans. Robotics and Automation 12(3), for
//! the cubic stiffness of a harmonic drive. Row by row, after the gear.
//!
//! Parameters: compliance of either sign (columns differ in sign), at most 0.1 rad/Nm (1e-3 m/N); cubic at most 1e-4
//! rad/Nm^3. Typical: 1e-6 to 1e-5 deg/Nm of a large gear, 0.1 deg/Nm of a printed one. Without the column it does nothing.

use super::common::*;
use super::site::within;
use serde_yaml::Value;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "torque_windup",
    heading: "torque wind-up",
    stage: Stage::Link,
    family: Family::Gravity,
    acts_on: ActsOn::Joint,
    adds: "the gear winds up under the measured torque of its drive",
    equation: "compliance torque + cubic torque^3, torque from the column torque_<joint>_nm",
    reference: "Spong (1987), J. Dynamic Systems, Measurement, and Control 109(4); Tuttle, Seering (1996), IEEE Trans. Robotics and Automation 12(3)",
    parameters: &[
        ("compliance_deg_per_nm", "either sign, within 0.1 rad/Nm (1e-3 m/N)"),
        ("cubic_deg_per_nm3", "either sign, within 1e-4 rad/Nm^3; may be left out"),
    ],
    confused_with: &["gravity_compliance", "servo_lag", "stiction"],
    decide_by: "log the torque; move at two speeds and with two loads",
    action: "enter load data and joint stiffness in the controller; accelerate less",
    undone: "nothing: a program contains no torque",
    special: Special {
        further: |survey, list| {
            for axis in survey.all_axes().filter(|&a| survey.axes[a].torque_measured) {
                let target = Target::Joint(axis);
                let [lo, hi] = survey.axes[axis].torque;
                let largest = lo.abs().max(hi.abs()).max(1.0);
                let stiffening = |c: &[f64]| TorqueWindup { compliance: c[0], cubic: Some(c[1]) };
                let trials = [1e-8, 1e-8 / (largest * largest)];
                list.push(Candidate::of_sizes(survey.robot, target, &trials, stiffening).with_form("stiffening"));
            }
        },
        ..Special::NONE
    },
    example: (
        "{effect: torque_windup, joint: A1, compliance_deg_per_nm: 1.0e-5, cubic_deg_per_nm3: -1.0e-11}",
        View::JointOverCommand,
    ),
    read: |f| {
        let site = f.site();
        let si = site.si_per_user_unit();
        let (linear, cubic) = keys(site.is_revolute());
        let compliance = f.any(linear)? * si;
        let cubic = f.number(cubic, f64::NEG_INFINITY)?.map(|c| c * si);
        Ok(TorqueWindup { compliance, cubic }.into())
    },
    typical: |size| vec![(keys(size.is_revolute()).0.into(), Value::from(1e-5))],
    candidates: |survey, list| {
        for axis in survey.all_axes().filter(|&a| survey.axes[a].torque_measured) {
            let linear = |compliance| TorqueWindup { compliance, cubic: None };
            list.push(Candidate::of_size(survey.robot, Target::Joint(axis), 1e-8, linear));
        }
    },
};

/// rad/Nm and rad/Nm^3, or m/N and m/N^3.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorqueWindup {
    /// Compliance at torque 0, rad/Nm or m/N.
    pub compliance: f64,
    /// Cubic part of the compliance, rad/Nm^3 or m/N^3; `None`: not a part of the effect.
    pub cubic: Option<f64>,
}

fn keys(revolute: bool) -> (&'static str, &'static str) {
    if revolute { ("compliance_deg_per_nm", "cubic_deg_per_nm3") } else { ("compliance_mm_per_n", "cubic_mm_per_n3") }
}

impl EffectType for TorqueWindup {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn is_wider(&self) -> bool {
        self.cubic.is_some()
    }

    fn values(&self) -> Vec<f64> {
        std::iter::once(self.compliance).chain(self.cubic).collect()
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { compliance: v[0], cubic: self.cubic.map(|_| v[1]) }.into()
    }

    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        let per_si = 1.0 / site.si_per_user_unit();
        let (linear, cubic) = keys(site.is_revolute());
        let most = if site.is_revolute() { 0.1 } else { 1e-3 };
        let mut all = vec![Parameter::new(linear, per_si, within(most), site.typical(1e-5, 1e-5))];
        all.extend(self.cubic.map(|_| Parameter::new(cubic, per_si, within(1e-4), site.typical(1e-11, 1e-11))));
        all
    }

    fn add_to_joint(&self, target: Target, inputs: &dyn Inputs, joint: &mut [f64]) {
        let Some(torque) = target.axis().and_then(|axis| inputs.measured_torque(axis)) else { return };
        let cubic = self.cubic.unwrap_or(0.0);
        joint.iter_mut().zip(torque).for_each(|(q, t)| *q += t * (self.compliance + cubic * t * t));
    }

    fn without_columns(&self, target: Target, inputs: &dyn Inputs) -> Option<&'static str> {
        without_torque(target, inputs)
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::needs_torque()
    }
}
