//! An effect at the place where it acts.

use super::{DhParameter, Effect, Parameter, Site, Target};
use crate::robot::Robot;

/// An effect at its place.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectInstance {
    /// Where it acts.
    pub target: Target,
    /// The effect with its values.
    pub effect: Effect,
}

impl EffectInstance {
    /// An effect at a target.
    pub fn new(target: Target, effect: impl Into<Effect>) -> Self {
        Self { target, effect: effect.into() }
    }

    /// An effect on one axis.
    pub fn on_axis(axis: usize, effect: impl Into<Effect>) -> Self {
        Self::new(Target::Joint(axis), effect)
    }

    /// Its target on a robot.
    pub fn site<'a>(&self, robot: &'a Robot) -> Site<'a> {
        Site { robot, target: self.target }
    }

    /// The axis whose position it changes.
    pub fn axis(&self) -> Option<usize> {
        self.target.axis()
    }

    /// As a reader knows it: "A1", "A2.a", "A6<-A5", "tool", "tcp", "log".
    pub fn target_text(&self, robot: &Robot) -> String {
        self.target.text(robot)
    }

    /// Keys, bounds and typical sizes of the values, in the order of [`super::EffectType::values`].
    pub fn parameters(&self, robot: &Robot) -> Vec<Parameter> {
        self.effect.parameters(&self.site(robot))
    }

    /// Keys of the parameters in a model file, and the factor from SI to their unit. Knots are `knots[0]`, ...; the coordinates
    /// of a vibration's amplitude are `amplitude_um[0]`, ... (in a file they stand as amplitude and direction).
    pub fn keys(&self, robot: &Robot) -> Vec<(String, f64)> {
        self.parameters(robot).into_iter().map(|p| (p.key, p.user_units_per_si)).collect()
    }

    /// Least and most of each value, SI.
    pub fn bounds(&self, robot: &Robot) -> Vec<(f64, f64)> {
        self.parameters(robot).into_iter().map(|p| (p.least, p.most)).collect()
    }
}

impl Target {
    /// The axis whose position changes.
    pub fn axis(self) -> Option<usize> {
        match self {
            Self::Joint(axis) | Self::Coupled { to: axis, .. } => Some(axis),
            _ => None,
        }
    }

    /// As a reader knows it.
    pub fn text(self, robot: &Robot) -> String {
        match self {
            Self::Joint(axis) => robot.axis(axis).name.clone(),
            Self::Coupled { to, from } => format!("{}<-{}", robot.axis(to).name, robot.axis(from).name),
            Self::Link { joint, parameter } => format!("{}.{}", robot.joints[joint].name, parameter.text()),
            Self::Base => "base".into(),
            Self::Tool => "tool".into(),
            Self::Tcp => "tcp".into(),
            Self::Log => "log".into(),
        }
    }
}

impl DhParameter {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::A, Self::D, Self::Alpha, Self::Beta];
}
