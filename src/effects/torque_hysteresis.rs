//! `torque_hysteresis`: friction holds a gear's wind-up back: adds `-half_width * z`, `dz/dT = (1 - z sign(dT))/torque`.
//!
//! Dahl's model (1968) over the torque of the log's column `torque_<joint>_nm` (a force in N for a prismatic joint): the loop
//! that a gear with a locked output shows beside its compliance ([`super::torque_windup`]), as play, friction of the
//! flanks and preload make it. After a swing of the torque within `-T..T` and back to zero the joint stands
//! `half_width (1 - 1/cosh(T/torque))` from where it would be: all of the half width after a large torque, little after a small one.
//! Row by row, after the gear, exact between rows of a monotone torque; `z = 0` at the first row. A diagnosis looks for it on joints
//! that are held.
//!
//! Parameters: half width 0 or more, at most 0.1 rad (10 mm); torque above 0. Typical: 0.1 to 2 deg of a printed cycloidal reducer,
//! 0.01 deg of a harmonic drive. Without the column it does nothing.

use super::common::*;
use serde_yaml::Value;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "torque_hysteresis",
    heading: "torque hysteresis",
    stage: Stage::Link,
    family: Family::Friction,
    acts_on: ActsOn::Joint,
    adds: "friction in the gear delays its wind-up: a loop over the measured torque of the drive",
    equation: "-half_width z, dz/dT = (1 - z sign(dT))/torque (Dahl), T from the column torque_<joint>_nm",
    reference: "Dahl (1968), A Solid Friction Model, Aerospace Corporation TOR-0158(3107-18)-1; Tuttle, Seering (1996), IEEE Trans. Robotics and Automation 12(3)",
    parameters: &[
        ("half_width_deg", "half of the loop after a large torque, 0 to 0.1 rad (10 mm)"),
        (
            "torque_nm",
            "change of the torque over which 63 % of the loop builds up, above 0 (N for a prismatic joint: force_n)",
        ),
    ],
    confused_with: &["torque_windup", "hysteresis", "backlash"],
    decide_by: "lock the output and ramp the torque both ways, with two amplitudes; log it",
    action: "preload or shim the reducer; avoid torque that changes its sign where accuracy matters",
    undone: "nothing: a program contains no torque",
    special: Special::NONE,
    example: ("{effect: torque_hysteresis, joint: A1, half_width_deg: 0.003, torque_nm: 400}", View::JointOverCommand),
    read: |f| {
        let key = torque_key(f.site().is_revolute());
        Ok(TorqueHysteresis { half_width: f.length("half_width", 0.0)?, torque: f.above_0(key)? }.into())
    },
    typical: |size| {
        let torque = torque_key(size.is_revolute()).into();
        vec![(size.key("half_width"), size.gap.into()), (torque, Value::from(50.0))]
    },
    candidates: |survey, list| {
        // of a joint that moves, friction turns the torque over with the movement: a loop over it would be a gap by another name
        let held = |a: &usize| survey.axes[*a].travel <= AT_REST * survey.robot.axis(*a).kind.si_per_user_unit();
        for axis in survey.all_axes().filter(|&a| survey.axes[a].torque_measured).filter(held) {
            let [lo, hi] = survey.axes[axis].torque;
            for share in SHARES.into_iter().filter(|_| hi > lo) {
                let make = move |width: f64| TorqueHysteresis { half_width: width.max(0.0), torque: share * (hi - lo) };
                let one = Candidate::of_size(survey.robot, Target::Joint(axis), candidate::TRIAL, make);
                list.push(one.positive().with_shape(1));
            }
        }
    },
};

/// Travel of a joint, deg or mm, up to which it counts as held.
const AT_REST: f64 = 1e-3;
/// Torques that are tried, as shares of the range of the measured one.
const SHARES: [f64; 4] = [0.01, 0.03, 0.1, 0.3];

fn torque_key(revolute: bool) -> &'static str {
    if revolute { "torque_nm" } else { "force_n" }
}

/// Half width in rad or m, torque in Nm or N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorqueHysteresis {
    /// Half the width of the loop, rad or m.
    pub half_width: f64,
    /// Torque over which the loop is crossed, Nm or N.
    pub torque: f64,
}

impl EffectType for TorqueHysteresis {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        vec![self.half_width, self.torque]
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { half_width: v[0], torque: v[1] }.into()
    }

    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        vec![
            site.length("half_width", (0.0, site.most_lost()), site.typical(0.003, 0.005)),
            Parameter::new(torque_key(site.is_revolute()), 1.0, (1e-3, 1e5), 50.0),
        ]
    }

    fn add_to_joint(&self, target: Target, inputs: &dyn Inputs, joint: &mut [f64]) {
        let Some(torque) = target.axis().and_then(|axis| inputs.measured_torque(axis)) else { return };
        let Some(&first) = torque.first() else { return };
        let (mut z, mut before) = (0.0, first);
        for (q, &t) in joint.iter_mut().zip(torque) {
            let step = t - before;
            if step != 0.0 {
                let side = step.signum();
                z = side + (z - side) * (-step.abs() / self.torque).exp();
            }
            before = t;
            *q -= self.half_width * z;
        }
    }

    fn without_columns(&self, target: Target, inputs: &dyn Inputs) -> Option<&'static str> {
        without_torque(target, inputs)
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::needs_torque()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Held(Vec<f64>);

    impl Inputs for Held {
        fn command(&self, _axis: usize) -> &[f64] {
            &[]
        }

        fn gravity_torque(&self, _axis: usize) -> &[f64] {
            &[]
        }

        fn gravity_levers(&self, _axis: usize, _joint: usize) -> std::borrow::Cow<'_, [[f64; 2]]> {
            (&[][..]).into()
        }

        fn measured_torque(&self, _axis: usize) -> Option<&[f64]> {
            Some(&self.0)
        }
    }

    #[test]
    fn behind_a_swing_of_the_torque_the_joint_stays_off_by_what_the_formula_says() {
        for (most, share) in [(4.0, 1.0 - 1.0 / (4.0f64 / 1.5).cosh()), (40.0, 1.0), (0.3, 1.0 - 1.0 / 0.2f64.cosh())] {
            // swings until the loop repeats, then back to zero from above
            let swings = [most, -most].repeat(40).into_iter();
            let torque: Vec<f64> = std::iter::once(0.0).chain(swings).chain([most, 0.0]).collect();
            let mut joint = vec![0.0; torque.len()];
            let effect = TorqueHysteresis { half_width: 0.01, torque: 1.5 };
            effect.add_to_joint(Target::Joint(0), &Held(torque), &mut joint);
            let last = joint[joint.len() - 1];
            assert!((last - 0.01 * share).abs() < 1e-9, "{most}: {last}");
        }
    }

    #[test]
    fn a_torque_that_stays_moves_nothing() {
        let mut joint = vec![0.5; 3];
        let effect = TorqueHysteresis { half_width: 0.01, torque: 1.5 };
        effect.add_to_joint(Target::Joint(0), &Held(vec![7.0; 3]), &mut joint);
        assert_eq!(joint, [0.5; 3]);
    }
}
