//! Notes of an estimate of all logs of a machine.

use crate::gaps::estimate::{Agreement, Trust};
use crate::robot::JointKind;

/// A remark on the estimate of a machine. Values of joints are in rad or m, as `kind` says.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// The clocks of commands and measurements were apart and were put together.
    #[error(
        "{log}: measured positions are {:.3} s {} the commands; the commands were shifted by this time",
        by_s.abs(), if *by_s > 0.0 { "ahead of" } else { "behind" }
    )]
    ClocksApart {
        /// Name of the log.
        log: String,
        /// By how much the measured positions are ahead, s; below 0: behind.
        by_s: f64,
    },
    /// Single readings do not determine the gap of a joint.
    #[error(
        "{joint}: not determined by these readings (standard deviation {:.4} {}): it hardly moves along them, or as other joints do",
        kind.to_user_unit(*sigma), kind.unit()
    )]
    NotDetermined {
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Standard deviation of its half gap, rad or m.
        sigma: f64,
    },
    /// A joint without a reversal.
    #[error("{joint}: never reverses in these logs, so its lost motion cannot be determined")]
    NeverReverses {
        /// Name of the joint.
        joint: String,
    },
    /// What compensation of a joint does.
    #[error("{joint}: {}", of_trust(trust))]
    Trusted {
        /// Name of the joint.
        joint: String,
        /// Errors without and with compensation, and why it is used or not.
        trust: Trust,
    },
    /// The single reversals of a joint do not agree with the fit of all logs.
    #[error("{joint}: {}", of_agreement(agreement, *kind))]
    Disagree {
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Lost motion by both.
        agreement: Agreement,
    },
    /// Distance from the path along a log.
    #[error(
        "{log}: {:.1} um rms off the path by lost motion, {:.1} um predicted after compensation",
        before_m * 1e6, after_m * 1e6
    )]
    OffPath {
        /// Name of the log.
        log: String,
        /// Without compensation, m rms.
        before_m: f64,
        /// With it, m rms.
        after_m: f64,
    },
    /// Friction in logs of dwells is not that in logs of motion.
    #[error(
        "{joint}: friction after a reversal is not the same in logs of dwells (spikes of {:.5} {unit} together) as in logs of motion \
         ({:.5} {unit}); each kind of log gets its own spikes, and compensation uses those of motion",
        kind.to_user_unit(*dwells), kind.to_user_unit(*motion), unit = kind.unit()
    )]
    FrictionApart {
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Sum of the spikes in logs of dwells, rad or m.
        dwells: f64,
        /// Sum of the spikes in logs of motion, rad or m.
        motion: f64,
    },
    /// No log of motion separates gap and wind-up.
    #[error(
        "these logs are tests of dwells alone, which do not separate a half gap from wind-up; the intervals are wide for that reason. \
         `identify static` gives their sum, gap and wind-up together, with the precision that `plan-experiment static` states; a path or an \
         excitation in addition separates the two"
    )]
    OnlyDwells,
    /// The tracker's frame jumps while a log was recorded.
    #[error(
        "{log}: the frame of the tracker jumps by {:.0} um at {at_s:.1} s, as after a lost beam; this log has a frame before it and another one \
         after it: give its two parts as two logs, or record it again",
        by_m * 1e6
    )]
    FrameJumps {
        /// Name of the log.
        log: String,
        /// Size of the jump, m.
        by_m: f64,
        /// When, s.
        at_s: f64,
    },
}

impl Note {
    /// The log that the note begins with.
    pub(super) fn log_mut(&mut self) -> Option<&mut String> {
        match self {
            Self::ClocksApart { log, .. } | Self::OffPath { log, .. } | Self::FrameJumps { log, .. } => Some(log),
            _ => None,
        }
    }
}

fn of_trust(t: &Trust) -> String {
    if t.reversals == 0 {
        return format!("compensation {}", t.reason);
    }
    format!(
        "{:.1} um at its {} reversals without compensation, {:.1} um predicted with it; compensation {}",
        t.before_m * 1e6,
        t.reversals,
        t.after_m * 1e6,
        t.reason
    )
}

fn of_agreement(a: &Agreement, kind: JointKind) -> String {
    let shown = |value: f64, [low, high]: [f64; 2]| {
        let [value, low, high] = [value, low, high].map(|v| kind.to_user_unit(v));
        format!("{value:.5} {} [{low:.5}, {high:.5}]", kind.unit())
    };
    let left = if a.single > 0.0 { 100.0 * (a.all_logs / a.single - 1.0).abs() } else { 100.0 };
    format!(
        "the lost motion after single reversals, {}, is not that of all logs together, {}; {}. It leaves {left:.0} % of the error there",
        shown(a.single, a.single_ci95),
        shown(a.all_logs, a.all_logs_ci95),
        a.reason()
    )
}
