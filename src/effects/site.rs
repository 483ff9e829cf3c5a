//! The place at which an effect acts, as its keys, units and bounds depend on it.

use super::{DhParameter, Target};
use crate::robot::{JointKind, Robot};
use std::f64::consts::{PI, TAU};

/// A target on a robot.
#[derive(Debug, Clone, Copy)]
pub struct Site<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// The target.
    pub target: Target,
}

impl Site<'_> {
    /// The axis whose position changes.
    pub fn axis(&self) -> Option<usize> {
        match self.target {
            Target::Joint(axis) | Target::Coupled { to: axis, .. } => Some(axis),
            _ => None,
        }
    }

    /// Unit of what changes: of the joint, of the DH parameter; degrees where there is neither.
    pub fn kind(&self) -> JointKind {
        match self.target {
            Target::Link { parameter: DhParameter::A | DhParameter::D, .. } => JointKind::Prismatic,
            Target::Link { parameter: DhParameter::Alpha | DhParameter::Beta, .. } => JointKind::Revolute,
            _ => self.axis().map_or(JointKind::Revolute, |a| self.robot.axis(a).kind),
        }
    }

    /// Whether the target is a revolute joint.
    pub fn is_revolute(&self) -> bool {
        self.kind() == JointKind::Revolute
    }

    /// `deg` or `mm`.
    pub fn unit(&self) -> &'static str {
        self.kind().unit()
    }

    /// rad per deg, m per mm.
    pub fn si_per_user_unit(&self) -> f64 {
        self.kind().si_per_user_unit()
    }

    /// `half_gap_deg`, `half_gap_mm`.
    pub fn key(&self, name: &str) -> String {
        format!("{name}_{}", self.unit())
    }

    /// Why an effect of gravity does nothing on this robot.
    pub fn without_links(&self) -> Option<&'static str> {
        self.robot.links.is_empty().then_some("the robot file has no `links`")
    }

    /// One turn of the joint: 2 pi rad, or the lead of a screw in m.
    pub fn rev(&self) -> f64 {
        match self.kind() {
            JointKind::Revolute => TAU,
            JointKind::Prismatic => self.axis().and_then(|a| self.robot.axis(a).lead_m_per_rev).unwrap_or(1.0),
        }
    }

    /// Largest lost motion: 0.1 rad, or 10 mm. More is a broken joint.
    pub fn most_lost(&self) -> f64 {
        if self.is_revolute() { 0.1 } else { 0.01 }
    }

    /// Bounds of a travel over which something builds up or fades: from a hundred-thousandth of a lost motion to more than a stroke.
    pub fn travel_bounds(&self) -> (f64, f64) {
        (self.most_lost() * 1e-5, if self.is_revolute() { TAU } else { 10.0 })
    }

    /// A ratio of two joints in the units of both: 1 where both turn or both slide.
    pub fn user_units_per_ratio(&self) -> f64 {
        match self.target {
            Target::Coupled { to, from } => {
                self.robot.axis(from).kind.si_per_user_unit() / self.robot.axis(to).kind.si_per_user_unit()
            }
            _ => 1.0,
        }
    }

    /// A typical size of revolute joints in deg or of prismatic ones in mm, as SI.
    pub fn typical(&self, deg: f64, mm: f64) -> f64 {
        if self.is_revolute() { deg.to_radians() } else { mm * 1e-3 }
    }

    /// A parameter in the joint's unit: `name_deg` or `name_mm`.
    pub fn length(&self, name: &str, (least, most): (f64, f64), typical: f64) -> Parameter {
        Parameter { key: self.key(name), user_units_per_si: 1.0 / self.si_per_user_unit(), least, most, typical }
    }
}

/// One value of an effect: its key in a model file, its bounds and its typical size, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Key in a model file, with its unit.
    pub key: String,
    /// Factor from SI to the unit of the key.
    pub user_units_per_si: f64,
    /// Smallest value, SI.
    pub least: f64,
    /// Largest value, SI.
    pub most: f64,
    /// Size that one meets on machines: the scale of a weak prior.
    pub typical: f64,
}

impl Parameter {
    /// A parameter whose unit is SI already, or the one that its key says.
    pub fn new(key: &str, user_units_per_si: f64, (least, most): (f64, f64), typical: f64) -> Self {
        Self { key: key.into(), user_units_per_si, least, most, typical }
    }

    /// Seconds.
    pub fn seconds(key: &str, bounds: (f64, f64), typical: f64) -> Self {
        Self::new(key, 1.0, bounds, typical)
    }

    /// An angle in degrees, whatever the joint; a phase lies within half a turn either way.
    pub fn degrees(key: &str, bounds: (f64, f64), typical: f64) -> Self {
        Self::new(key, 180.0 / PI, bounds, typical)
    }

    /// `x_mm`, `y_mm`, `z_mm` of a vector in m.
    pub fn xyz_mm(most: f64, typical: f64) -> [Self; 3] {
        ["x_mm", "y_mm", "z_mm"].map(|key| Self::new(key, 1e3, within(most), typical))
    }
}

/// Bounds of either sign.
pub fn within(most: f64) -> (f64, f64) {
    (-most, most)
}
