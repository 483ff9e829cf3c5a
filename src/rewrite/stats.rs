//! What a rewrite did, and the limits that it would exceed.

use super::Origin;
use std::collections::BTreeSet;

/// Why limits of speed and acceleration could not be checked everywhere.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UncheckedRates {
    /// The robot file gives no largest speeds.
    NoLimits,
    /// The speeds of some moves are not known.
    SomeSpeeds,
    /// The program contains no times and no speeds.
    NoTimes,
}

impl UncheckedRates {
    /// As it stands in documents and messages.
    pub fn text(self) -> &'static str {
        match self {
            Self::NoLimits => "the robot file contains no limits of speed and acceleration (max_speed, max_accel)",
            Self::SomeSpeeds => "the speeds of some moves are not known",
            Self::NoTimes => "the program contains no times and no speeds",
        }
    }

    /// A TCP speed from the user would let them be checked.
    pub fn wants_speed(self) -> bool {
        self != Self::NoLimits
    }
}

/// What a rewrite did, for the report that a user reads.
#[derive(Debug, Clone, Default)]
pub struct RewriteStats {
    /// Number of points of the program.
    pub points: u64,
    /// Number of new points.
    pub inserted: u64,
    /// Reversals per axis.
    pub reversals: Vec<u64>,
    /// Largest offset per axis, rad or m; with static corrections the sum of the largest of both.
    pub largest_offset: Vec<f64>,
    /// Largest joint error that the command must leave at a reversal because it may not turn back, per axis, rad or m.
    pub largest_left: Vec<f64>,
    /// Places where a limit would be exceeded after compensation, the first of them in full.
    pub violations: Vec<Violation>,
    /// Number of all violations, listed or not.
    pub violations_total: u64,
    /// Of them those of a joint's range.
    pub out_of_range: u64,
    /// Reversals after which a speed or an acceleration would exceed a limit: axis, and the program point at which it turns or after
    /// which it does; as many as [`super::limits`] keeps.
    pub strained: BTreeSet<(usize, u64)>,
    /// Why speeds and accelerations were not checked everywhere, where they were not.
    pub unchecked_rates: Option<UncheckedRates>,
    /// Duration of the program before and after, s, where it can be determined.
    pub duration_s: Option<[f64; 2]>,
    /// Largest distance of the TCP from the path that was given, m: by the offset at a reversal, and at points of a refined path.
    pub largest_change_m: f64,
    /// The angles, read as degrees, are probably radians.
    pub looks_like_radians: bool,
    /// The times, read as seconds, are probably milliseconds.
    pub looks_like_milliseconds: bool,
}

/// A limit that would be exceeded.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    /// The point at which it occurs.
    pub origin: Origin,
    /// Number of the axis, from 0.
    pub axis: usize,
    /// Which limit is exceeded.
    pub what: LimitKind,
    /// Value and limit, SI.
    pub value: f64,
    /// The limit, rad or m, per s or s^2.
    pub limit: f64,
}

/// Kind of a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitKind {
    /// The range of the joint.
    Range,
    /// The speed of the joint.
    Speed,
    /// The acceleration of the joint.
    Acceleration,
}
