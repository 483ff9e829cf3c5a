//! The compensator: what `fit` writes and `rewrite` reads (seed 000 equations 15-17). Document `lostmotion/compensator/1`.
//!
//! Values are SI (rad or m, s); [`file`] turns them into the document's units.

pub mod file;

use crate::effect::{Decay, GapCurve};
use crate::gaps::LogRef;

/// Offsets for the joints of one robot.
#[derive(Debug, Clone)]
pub struct Compensator {
    pub robot_name: String,
    pub robot_sha256: String,
    pub joints: Vec<JointCompensator>,
    pub evidence: Evidence,
}

/// Offsets of one axis.
#[derive(Debug, Clone)]
pub struct JointCompensator {
    pub axis: usize,
    pub backlash: Option<BacklashOffset>,
    pub friction: Option<FrictionOffset>,
}

/// `C_b` of equation 16: `+positive` moving up, `-negative` moving down.
#[derive(Debug, Clone, PartialEq)]
pub struct BacklashOffset {
    pub positive: GapCurve,
    pub negative: GapCurve,
}

/// `C_f` of equation 17, with the sign of the new movement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionOffset {
    /// `g`, rad or m.
    pub gain: f64,
    pub shape: FrictionShape,
}

/// How the friction offset fades behind a reversal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FrictionShape {
    /// `exp(-t/tau)` or `exp(-travel/lambda)`: the inverse of the catalogue's stiction.
    Decay(Decay),
    /// Equation 17 as printed: `exp(1 - (1 + (k-1)/(poses-1))^exponent)` for `k = 1..=poses` program points.
    Poses { exponent: f64, poses: u32 },
}

/// What a compensator rests on.
#[derive(Debug, Clone, Default)]
pub struct Evidence {
    pub logs: Vec<LogRef>,
    /// TCP speed of the log, m/s: turns seconds into points where a program has no times.
    pub tcp_speed_m_s: Option<f64>,
    /// 95 % intervals, residuals and reasons, as lines.
    pub notes: Vec<String>,
}

impl Compensator {
    /// All offsets are zero: `rewrite` returns its input byte for byte.
    pub fn is_zero(&self) -> bool {
        self.joints.iter().all(|j| {
            j.friction.is_none_or(|f| f.gain == 0.0)
                && j.backlash.as_ref().is_none_or(|b| {
                    [&b.positive, &b.negative].iter().all(|c| c.largest() == 0.0 && c.smallest() == 0.0)
                })
        })
    }

    /// Offsets of an axis.
    pub fn on(&self, axis: usize) -> Option<&JointCompensator> {
        self.joints.iter().find(|j| j.axis == axis)
    }
}
