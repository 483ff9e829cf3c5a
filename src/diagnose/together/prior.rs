//! How large the effects of real machines are: weak priors that keep the absurd out and leave the data alone.
//!
//! Each value has a normal prior about 0 whose standard deviation is a few times the typical size of the catalogue; shapes (a
//! decay, a presliding travel) have one about the value that the screening gave, as wide as that value. Where the data tell a
//! value, the prior weighs nothing; where they do not, it stays small instead of cancelling against another one.

use super::super::fit::Prior;
use super::super::forward::{Hypothesis, Problem};
use crate::effects::{DhParameter, Effect, EffectInstance, Target};
use crate::robot::JointKind;

const DEG: f64 = std::f64::consts::PI / 180.0;

/// Standard deviation of each value of an effect, SI; infinite: no prior.
pub fn widths(problem: &Problem, placed: &EffectInstance) -> Vec<f64> {
    let robot = &problem.robot;
    let prismatic = placed.axis().is_some_and(|a| robot.axis(a).kind == JointKind::Prismatic);
    let joint = |deg: f64, mm: f64| if prismatic { mm * 1e-3 } else { deg * DEG };
    let values = placed.effect.values();
    let free = f64::INFINITY;
    let shape = |k: usize| values.get(k).map_or(free, |v| v.abs());
    match &placed.effect {
        Effect::ServoLag(_) => vec![0.03],
        Effect::TimeOffset(_) => vec![0.02],
        Effect::Stiction(_) => vec![joint(0.02, 0.05), shape(1)],
        Effect::Hysteresis(_) => vec![joint(0.02, 0.05), shape(1)],
        Effect::Backlash(_) => vec![joint(0.05, 0.2); values.len()],
        Effect::BacklashSpeed(_) => vec![joint(0.05, 0.2), joint(0.05, 0.2) / 0.1],
        Effect::TransmissionError(_) => vec![joint(0.01, 0.02), free, free],
        Effect::EncoderScale(_) => vec![2e-3],
        Effect::JointZeroOffset(_) => vec![joint(0.1, 1.0)],
        Effect::AxisCoupling(_) => vec![1e-3],
        Effect::GravityCompliance(_) => {
            let most = placed.axis().map_or(0.0, |a| largest_torque(problem, a));
            vec![if most > 0.0 { joint(0.05, 0.1) / most } else { 1e-9 }]
        }
        Effect::LinkError(_) => match placed.target {
            Target::Link { parameter: DhParameter::A | DhParameter::D, .. } => vec![1e-3],
            _ => vec![0.1 * DEG],
        },
        Effect::ToolError(_) => vec![2e-3; 3],
        Effect::ThermalDrift(_) => vec![1e-4, 1e-4, 1e-4, shape(3)],
        Effect::Vibration(_) => vec![1e-4, 1e-4, 1e-4, free, free],
    }
}

fn largest_torque(problem: &Problem, axis: usize) -> f64 {
    problem.logs.iter().flat_map(|l| l.drive.gravity_torque(axis).iter()).fold(0.0, |m, t| m.max(t.abs()))
}

/// Which values are shapes: their prior stands about the value that they have now.
fn is_shape(effect: &Effect, value: usize) -> bool {
    matches!((effect, value), (Effect::Stiction(_) | Effect::Hysteresis(_), 1) | (Effect::ThermalDrift(_), 3))
}

/// The prior of the free effects of a hypothesis.
pub fn of(problem: &Problem, h: &Hypothesis, free: &[usize]) -> Prior {
    let mut prior = Prior::default();
    for &i in free {
        let placed = &h.effects[i];
        for (k, (value, width)) in placed.effect.values().into_iter().zip(widths(problem, placed)).enumerate() {
            prior.precision.push(if width.is_finite() && width > 0.0 { width.powi(-2) } else { 0.0 });
            prior.centre.push(if is_shape(&placed.effect, k) { value } else { 0.0 });
        }
    }
    prior
}
