//! How large the effects of real machines are: weak priors that keep the absurd out and leave the data alone.
//!
//! Each value has a normal prior about 0 whose standard deviation is a few times the typical size of the catalogue; shapes (a
//! decay, a presliding travel) have one about the value that the screening gave, as wide as that value. Where the data tell a
//! value, the prior weighs nothing; where they do not, it stays small instead of cancelling against another one.

use super::super::fit::{Fit, Prior};
use super::super::forward::{Hypothesis, Problem};
use crate::effects::{Backlash, DhParameter, Effect, EffectInstance, GapCurve, Target};
use crate::robot::JointKind;

/// How much a gap varies over position, in parts of its mean, one standard deviation.
const KNOT: f64 = 0.5;
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
        Effect::JointZeroOffset(_) => vec![joint(ANGLE_DEG, LENGTH_M * 1e3)],
        Effect::AxisCoupling(_) => vec![1e-3],
        Effect::GravityCompliance(_) => {
            let most = placed.axis().map_or(0.0, |a| largest_torque(problem, a));
            vec![if most > 0.0 { joint(0.05, 0.1) / most } else { 1e-9 }]
        }
        Effect::LinkError(_) => match placed.target {
            Target::Link { parameter: DhParameter::A | DhParameter::D, .. } => vec![LENGTH_M],
            _ => vec![ANGLE_DEG * DEG],
        },
        Effect::ToolError(_) => vec![2e-3; 3],
        Effect::ThermalDrift(_) => vec![1e-4, 1e-4, 1e-4, shape(3)],
        Effect::Vibration(_) => vec![1e-4, 1e-4, 1e-4, free, free],
    }
}

fn largest_torque(problem: &Problem, axis: usize) -> f64 {
    problem.logs.iter().flat_map(|l| l.drive.gravity_torque(axis).iter()).fold(0.0, |m, t| m.max(t.abs()))
}

/// How far a made arm is off its drawing.
const LENGTH_M: f64 = 1e-3;
const ANGLE_DEG: f64 = 0.1;
/// The same is not believed to be smaller than this part of it, whatever the arm says.
const LEAST: f64 = 0.1;

/// Widths of the geometry as the arm itself shows them: one for lengths, one for angles (m, rad).
#[derive(Debug, Clone, Copy)]
pub struct Geometry {
    length: f64,
    angle: f64,
}

impl Default for Geometry {
    fn default() -> Self {
        Self { length: LENGTH_M, angle: ANGLE_DEG * DEG }
    }
}

impl Geometry {
    /// Is an effect a length or an angle of the geometry?
    fn width(&self, problem: &Problem, placed: &EffectInstance) -> Option<f64> {
        match (&placed.effect, placed.target) {
            (Effect::LinkError(_), Target::Link { parameter: DhParameter::Alpha, .. }) => Some(self.angle),
            (Effect::LinkError(_), _) => Some(self.length),
            (Effect::JointZeroOffset(_), Target::Joint(a)) => {
                Some(if problem.robot.axis(a).kind == JointKind::Revolute { self.angle } else { self.length })
            }
            _ => None,
        }
    }

    /// The widths that make the values of a fit likeliest: the mean square of values and uncertainties (one step of
    /// expectation and maximisation; Dempster, Laird and Rubin 1977).
    pub fn of_fit(self, problem: &Problem, fit: &Fit) -> Self {
        let mean = |width: f64, most: f64| {
            let mut at = 0;
            let (mut sum, mut n) = (0.0, 0.0);
            for &i in &fit.free {
                let placed = &fit.hypothesis.effects[i];
                let values = placed.effect.values();
                if self.width(problem, placed) == Some(width) {
                    sum += values[0].powi(2) + fit.covariance[(at, at)].max(0.0);
                    n += 1.0;
                }
                at += values.len();
            }
            if n > 2.0 { f64::sqrt(sum / n).clamp(LEAST * most, most) } else { most }
        };
        Self { length: mean(self.length, LENGTH_M), angle: mean(self.angle, ANGLE_DEG * DEG) }
    }
}

/// Which values are shapes: their prior stands about the value that they have now.
fn is_shape(effect: &Effect, value: usize) -> bool {
    matches!((effect, value), (Effect::Stiction(_) | Effect::Hysteresis(_), 1) | (Effect::ThermalDrift(_), 3))
}

/// The prior of the free effects of a hypothesis.
pub fn of(problem: &Problem, h: &Hypothesis, free: &[usize], geometry: Geometry) -> Prior {
    let mut prior = Prior::default();
    for &i in free {
        let placed = &h.effects[i];
        if let Effect::Backlash(Backlash { half_gap: GapCurve::Pchip(_) }) = &placed.effect {
            // knots that no reversal visits stay near the others
            let values = placed.effect.values();
            let mean = (values.iter().sum::<f64>() / values.len() as f64).max(1e-7);
            prior.precision.extend(values.iter().map(|_| (KNOT * mean).powi(-2)));
            prior.centre.extend(values.iter().map(|_| mean));
            continue;
        }
        if let Some(width) = geometry.width(problem, placed) {
            prior.precision.push(width.powi(-2));
            prior.centre.push(0.0);
            continue;
        }
        for (k, (value, width)) in placed.effect.values().into_iter().zip(widths(problem, placed)).enumerate() {
            prior.precision.push(if width.is_finite() && width > 0.0 { width.powi(-2) } else { 0.0 });
            prior.centre.push(if is_shape(&placed.effect, k) { value } else { 0.0 });
        }
    }
    prior
}
