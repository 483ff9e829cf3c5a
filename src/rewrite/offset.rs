//! What one axis needs: the half gap on either side and the friction after a turn, as functions (Zhang (2023) equations 16, 17).

use crate::compensator::{FrictionOffset, FrictionShape, JointCompensator};
use crate::effects::{Decay, GapCurve};

/// Offsets of one axis, ready to be evaluated. Values are rad or m.
#[derive(Debug, Clone)]
pub struct Offset {
    positive: GapCurve,
    negative: GapCurve,
    friction: Option<FrictionOffset>,
    /// Half gap per direction where it is the same everywhere.
    fixed: Option<[f64; 2]>,
}

/// Below this share of its gain a fading friction offset is taken as gone: 0.3 um at a lever of 3 m for 0.003 deg.
const GONE: f64 = 2e-3;

impl Offset {
    pub fn new(joint: &JointCompensator) -> Self {
        let zero = || GapCurve::Constant(0.0);
        let (mut positive, mut negative) =
            joint.backlash.as_ref().map_or((zero(), zero()), |b| (b.positive.clone(), b.negative.clone()));
        // at the end of a stroke a wound-up joint stands back by its gap and its wind-up
        if let Some(FrictionShape::Response(r)) = joint.friction.map(|f| f.shape) {
            (positive, negative) = (positive.raised(r.windup()), negative.raised(r.windup()));
        }
        // a negative gain takes back what the gap would do at once: lost motion that builds up over travel
        let friction = joint.friction.filter(FrictionOffset::acts);
        let fixed = positive.constant().zip(negative.constant()).map(|(p, n)| [p, n]);
        Self { positive, negative, friction, fixed }
    }

    /// Half gap that a movement in direction `dir` has to cross to at position `p`.
    #[inline]
    pub fn gap(&self, dir: i8, p: f64) -> f64 {
        match self.fixed {
            Some([up, down]) => {
                if dir > 0 {
                    up
                } else {
                    down
                }
            }
            None if dir > 0 => self.positive.at(p),
            None => self.negative.at(p),
        }
    }

    /// The same offset at every position and no friction: adding a constant is all there is to do between turns.
    pub fn is_plain(&self) -> bool {
        self.fixed.is_some()
    }

    pub fn friction(&self) -> Option<FrictionOffset> {
        self.friction
    }

    /// Largest half gap, for sizes and dead bands.
    pub fn largest_gap(&self) -> f64 {
        self.positive.largest().max(self.negative.largest())
    }

    /// The largest step at a turn: both half gaps and the friction gain.
    pub fn largest_step(&self) -> f64 {
        self.positive.largest() + self.negative.largest() + self.friction.map_or(0.0, |f| f.gain)
    }
}

/// Friction that is left after a turn: `since_s` seconds, `poses` program points and `travel` of the command later.
pub fn friction_left(f: &FrictionOffset, since_s: f64, travel: f64, poses: f64) -> f64 {
    match f.shape {
        FrictionShape::Decay(decay) => f.gain * decay.left(since_s, travel),
        FrictionShape::Poses { exponent, poses: last } => {
            let span = f64::from(last.max(2) - 1);
            if poses > span { 0.0 } else { f.gain * (1.0 - (1.0 + poses / span).powf(exponent)).exp() }
        }
        // has its own state ([`super::plan`])
        FrictionShape::Response(_) => 0.0,
    }
}

/// The friction is gone for good: nothing after this place needs it.
pub fn friction_gone(f: &FrictionOffset, since_s: f64, travel: f64, poses: f64) -> bool {
    match f.shape {
        FrictionShape::Decay(Decay::Time(tau)) => since_s > -tau * GONE.ln(),
        FrictionShape::Decay(Decay::Travel(lambda)) => travel > -lambda * GONE.ln(),
        FrictionShape::Poses { poses: last, .. } => poses > f64::from(last.max(2) - 1),
        FrictionShape::Response(r) => r.gone(since_s, travel, GONE),
    }
}
