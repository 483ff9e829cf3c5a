//! How large the effects of real machines are: weak priors that keep the absurd out and leave the data alone.
//!
//! Each size has a normal prior about 0 whose standard deviation is [`WIDE`] times the typical size of the catalogue; shapes (a
//! decay, a presliding travel, a frequency) have one about the value that the screening gave, as wide as that value; phases
//! have none. Where the data tell a value, the prior weighs nothing; where they do not, it stays small instead of cancelling
//! against another one. Lengths and angles of the geometry are as wide as the arm itself shows them ([`Geometry`]).

use crate::diagnose::problem::forward::{Hypothesis, Problem};
use crate::diagnose::search::fit::{Fit, Prior};
use crate::effects::{EffectInstance, Family, Nature, Target};
use crate::numerics::robust::largest_size;
use crate::robot::JointKind;

/// Standard deviation of a size, in typical sizes.
const WIDE: f64 = 10.0;
/// Deflection of a joint under its largest gravity torque, one standard deviation, deg or mm.
const SAG: f64 = 0.05;
/// How much a gap varies over position, in parts of its mean, one standard deviation.
pub const KNOT: f64 = 0.5;
/// Smallest mean of a gap over position, rad or m.
const LEAST_GAP: f64 = 1e-7;

/// How the values of an effect behave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The effect is linear in it, and nothing where it is zero.
    Size,
    /// A decay, a travel, a frequency: never zero.
    Shape,
    /// Beyond it something else happens: what it does comes in steps, and it may be zero.
    Threshold,
    Phase,
}

/// Kind of each value.
pub fn kinds(problem: &Problem, placed: &EffectInstance) -> Vec<Kind> {
    let kind = |(k, least): (usize, f64)| match () {
        () if placed.effect.is_phase(k) => Kind::Phase,
        () if placed.effect.is_threshold(k) => Kind::Threshold,
        () if least > 0.0 => Kind::Shape,
        () => Kind::Size,
    };
    placed.bounds(&problem.robot).into_iter().map(|b| b.0).enumerate().map(kind).collect()
}

/// Standard deviation of each size of an effect, SI; of a shape its value.
pub fn widths(problem: &Problem, placed: &EffectInstance) -> Vec<f64> {
    let values = placed.effect.values();
    if placed.effect.uses_gravity()
        && let Some(axis) = placed.axis()
    {
        let most = largest_torque(problem, axis);
        let si = problem.robot.axis(axis).kind.si_per_user_unit();
        return vec![if most > 0.0 { SAG * si / most } else { f64::MIN_POSITIVE.sqrt() }; values.len()];
    }
    let parameters = placed.parameters(&problem.robot);
    let width = |k: usize, kind: Kind| match kind {
        Kind::Size | Kind::Threshold => parameters.get(k).map_or(f64::INFINITY, |p| WIDE * p.typical),
        Kind::Shape => values.get(k).map_or(f64::INFINITY, |v| v.abs()),
        Kind::Phase => f64::INFINITY,
    };
    kinds(problem, placed).into_iter().enumerate().map(|(k, kind)| width(k, kind)).collect()
}

fn largest_torque(problem: &Problem, axis: usize) -> f64 {
    largest_size(problem.logs.iter().flat_map(|l| l.trajectory.gravity_torque(axis).iter().copied()))
}

/// How far a made arm is off its drawing at most, one standard deviation, m and rad.
const LENGTH_M: f64 = 1e-3;
const ANGLE_RAD: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// The same is not believed to be smaller than this part of it, whatever the arm says.
const LEAST: f64 = 0.1;
/// Parameters of one kind from which a width is taken.
const ENOUGH: f64 = 3.0;

/// Widths of the geometry as the arm itself shows them: one for lengths, one for angles (m, rad).
#[derive(Debug, Clone, Copy)]
pub struct Geometry {
    length: f64,
    angle: f64,
}

impl Default for Geometry {
    fn default() -> Self {
        Self { length: LENGTH_M, angle: ANGLE_RAD }
    }
}

impl Geometry {
    /// The width of a length or an angle of the arm; `None` for all else.
    pub(super) fn width(&self, problem: &Problem, placed: &EffectInstance) -> Option<f64> {
        let of_arm = placed.effect.info().family == Family::Geometry
            && matches!(placed.target, Target::Joint(_) | Target::Link { .. });
        let kind = placed.site(&problem.robot).kind();
        of_arm.then_some(if kind == JointKind::Revolute { self.angle } else { self.length })
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
            if n >= ENOUGH { f64::sqrt(sum / n).clamp(LEAST * most, most) } else { most }
        };
        Self { length: mean(self.length, LENGTH_M), angle: mean(self.angle, ANGLE_RAD) }
    }
}

/// The prior of the free effects of a hypothesis.
pub fn of(problem: &Problem, h: &Hypothesis, free: &[usize], geometry: Geometry) -> Prior {
    let mut prior = Prior::default();
    let mut add = |width: f64, centre: f64| {
        prior.precision.push(if width.is_finite() && width > 0.0 { width.powi(-2) } else { 0.0 });
        prior.centre.push(centre);
    };
    for &i in free {
        let placed = &h.effects[i];
        let values = placed.effect.values();
        if placed.effect.nature() == Nature::GapOverPosition {
            // knots that no reversal visits stay near the others
            let mean = (values.iter().sum::<f64>() / values.len() as f64).max(LEAST_GAP);
            values.iter().for_each(|_| add(KNOT * mean, mean));
        } else if let Some(width) = geometry.width(problem, placed) {
            add(width, 0.0);
        } else {
            let widths = widths(problem, placed);
            for ((value, width), kind) in values.into_iter().zip(widths).zip(kinds(problem, placed)) {
                add(width, if kind == Kind::Shape { value } else { 0.0 });
            }
        }
    }
    prior
}
