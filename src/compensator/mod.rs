//! The compensator: what `fit` writes and `rewrite` reads (Zhang (2023) equations 15-17). Document `lostmotion/compensator/1`.
//!
//! Values are SI (rad or m, s); [`mod@file`] turns them into the document's units.
//!
//! Modules:
//! - [`mod@file`]: the YAML document, to and from these types, with every refusal and its line.
//!   `evidence`: what the offsets are based on.
//! - [`schedule`]: a half gap over position as it stands in a document.
//! - [`mod@response`]: friction that builds up over travel and is worked off in time.
//! - [`from_model`]: the compensator of a model file: the predicted joint error with its sign turned.
//! - [`mod@note`]: what a reader of a compensator should know.
//! - [`as_machine`]: the machine that a compensator describes.

#![warn(missing_docs)]

pub mod as_machine;
mod evidence;
pub mod file;
pub mod from_model;
pub mod note;
pub mod schedule;

pub use crate::effects::response::{self, Response, Spike, Windup};
use crate::effects::{Decay, GapCurve};
use crate::gaps::LogRef;
pub use note::Note;

/// Offsets for the joints of one robot.
#[derive(Debug, Clone)]
pub struct Compensator {
    /// Name of the robot for which the offsets were made.
    pub robot_name: String,
    /// Fingerprint of that robot ([`Robot::fingerprint`](crate::robot::Robot::fingerprint)).
    pub robot_sha256: String,
    /// Offsets, one entry for each compensated joint.
    pub joints: Vec<JointCompensator>,
    /// The measurements from which the offsets were made.
    pub evidence: Evidence,
}

/// Offsets of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct JointCompensator {
    /// Axis of the robot.
    pub axis: usize,
    /// Offset that closes the gap; `None`: the gap of this joint is not compensated.
    pub backlash: Option<BacklashOffset>,
    /// Offset for friction after a reversal; `None`: it is not compensated.
    pub friction: Option<FrictionOffset>,
}

impl JointCompensator {
    /// Where the axis stands makes its offset, not only where it comes from.
    pub fn depends_on_position(&self) -> bool {
        self.backlash.as_ref().is_some_and(|b| [&b.positive, &b.negative].iter().any(|c| c.constant().is_none()))
    }
}

/// `C_b` of equation 16: `+positive` moving up, `-negative` moving down.
#[derive(Debug, Clone, PartialEq)]
pub struct BacklashOffset {
    /// Offset while the joint moves in positive direction, rad or m over position.
    pub positive: GapCurve,
    /// Offset while it moves in negative direction, rad or m over position; applied with a minus sign.
    pub negative: GapCurve,
}

/// `C_f` of equation 17, with the sign of the new movement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionOffset {
    /// `g`, rad or m.
    pub gain: f64,
    /// How the offset fades after a reversal.
    pub shape: FrictionShape,
}

/// How the friction offset fades after a reversal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FrictionShape {
    /// `exp(-t/tau)` or `exp(-travel/lambda)`: the inverse of the catalogue's stiction.
    Decay(Decay),
    /// Equation 17 as printed: `exp(1 - (1 + (k-1)/(poses-1))^exponent)` for `k = 1..=poses` program points.
    Poses {
        /// Exponent of the decay (`l` in the paper).
        exponent: f64,
        /// Number of points over which the offset fades (`k_t` in the paper).
        poses: u32,
    },
    /// Builds up over travel, decays in time, leaves a wind-up; the offset's gain is that of its spikes together, both ways.
    Response(Response),
}

impl FrictionOffset {
    /// A measured response.
    pub fn of_response(response: Response) -> Self {
        Self { gain: 2.0 * response.gain(), shape: FrictionShape::Response(response) }
    }

    /// There is something to apply.
    pub fn acts(&self) -> bool {
        self.gain != 0.0 || matches!(self.shape, FrictionShape::Response(r) if r.windup() != 0.0)
    }

    /// Its offset changes in seconds, so that a program needs times or a speed.
    pub fn needs_clock(&self) -> bool {
        self.gain != 0.0 && matches!(self.shape, FrictionShape::Decay(Decay::Time(_)) | FrictionShape::Response(_))
    }
}

/// What a compensator is based on.
#[derive(Debug, Clone, Default)]
pub struct Evidence {
    /// Logs that the gaps were identified from.
    pub logs: Vec<LogRef>,
    /// TCP speed of the log, m/s: turns seconds into points where a program has no times.
    pub tcp_speed_m_s: Option<f64>,
    /// Last day on which the compensator is meant to be used, `YYYY-MM-DD`; stands at the top of the document.
    pub valid_until: Option<String>,
    /// Joint by joint: how well the values are known, and what they leave.
    pub joints: Vec<JointEvidence>,
    /// What compensation is predicted to leave along the logs: what the offsets do not hold, such as scatter from one reversal to
    /// the next.
    pub predicted: Vec<Predicted>,
    /// What the offsets come from, what was left out and why.
    pub notes: Vec<Note>,
}

/// Distance from the path along a log, m rms.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Predicted {
    /// Name of the log.
    pub log: String,
    /// By lost motion, without compensation.
    pub before_m: f64,
    /// With it.
    pub after_m: f64,
}

/// How well the offsets of an axis are known; rad or m, s.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct JointEvidence {
    /// Axis of the robot.
    pub axis: usize,
    /// 95 % interval of the half gap, rad or m.
    pub half_gap_ci95: Option<[f64; 2]>,
    /// The joint is compensated because that reduces its error at the TCP beyond doubt, on parts of the logs that were not fitted or in a
    /// run: the interval of the half gap alone, which trades off against friction, decides nothing.
    pub proved: bool,
    /// 95 % interval of the gain of the friction offset, rad or m.
    pub gain_ci95: Option<[f64; 2]>,
    /// Of a decay in time, s.
    pub decay_s_ci95: Option<[f64; 2]>,
    /// Largest joint error after the reversals that the identified chain predicts, without and with the offsets.
    pub largest_before: Option<f64>,
    /// Largest error that the fit of the offset leaves, rad or m.
    pub largest_after: Option<f64>,
    /// What the last run showed of these offsets.
    pub run: Option<RunLeft>,
    /// Offsets that the last correction replaced, and what their run showed.
    pub replaced: Option<Replaced>,
}

/// What a run left after the reversals of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunLeft {
    /// Mean square TCP error by the joint, m^2, noise taken off (so it may be negative), and its standard error.
    pub left_m2: f64,
    /// Standard error of `left_m2`, m^2.
    pub sigma_m2: f64,
    /// Number of reversals that were judged.
    pub reversals: usize,
}

/// Offsets of a joint before a correction.
#[derive(Debug, Clone, PartialEq)]
pub struct Replaced {
    /// `None`: the joint was not compensated.
    pub offsets: Option<JointCompensator>,
    /// What the run left after its reversals.
    pub run: RunLeft,
}

impl Compensator {
    /// All offsets are zero: `rewrite` returns its input byte for byte.
    pub fn is_zero(&self) -> bool {
        self.joints.iter().all(|j| {
            j.friction.is_none_or(|f| !f.acts())
                && j.backlash.as_ref().is_none_or(|b| {
                    [&b.positive, &b.negative].iter().all(|c| c.largest() == 0.0 && c.smallest() == 0.0)
                })
        })
    }

    /// An offset fades in seconds, so that times are needed.
    pub fn fades_in_seconds(&self) -> bool {
        self.joints.iter().any(|j| j.friction.is_some_and(|f| f.needs_clock()))
    }

    /// The same without the friction that fades in seconds, for moves whose time is not known.
    #[must_use]
    pub fn without_clock(&self) -> Self {
        let mut gaps = self.clone();
        for joint in &mut gaps.joints {
            joint.friction = joint.friction.filter(|f| !f.needs_clock());
        }
        gaps
    }

    /// Axes with offsets whose gap may be zero: the interval of the half gap contains zero, and nothing else proves that they help.
    pub fn unproved(&self) -> Vec<usize> {
        // files of earlier versions do not say what proves a joint, but gap and friction were estimated together
        let together = |axis: usize| {
            let friction = self.on(axis).and_then(|j| j.friction);
            matches!(friction.map(|f| f.shape), Some(FrictionShape::Response(_)))
        };
        let zero = |e: &&JointEvidence| e.half_gap_ci95.is_some_and(|[lo, _]| lo <= 0.0);
        let known = self.evidence.joints.iter().filter(|e| self.on(e.axis).is_some());
        known.filter(zero).filter(|e| !e.proved && !together(e.axis)).map(|e| e.axis).collect()
    }

    /// Offsets of an axis.
    pub fn on(&self, axis: usize) -> Option<&JointCompensator> {
        self.joints.iter().find(|j| j.axis == axis)
    }
}
