//! What a joint estimate over all logs of a machine adds to the gaps: friction's response, the scatter of single reversals,
//! trust, local evidence, covariance. Values are SI; the document holds degrees or millimetres, seconds, micrometres.
//!
//! In the document: `response`, `scatter`, `trust` and `agreement` of each joint, and at the top `reversals` and `covariance`. A
//! document without them is one of a single kind of test.
//!
//! Here are the types; `fields` writes them into a document, `read` takes them from one.

mod fields;
mod read;

pub(super) use fields::{JointFields, TopFields};
pub(super) use read::{read_covariance, read_joint, read_predicted, read_reversals};

use crate::effects::response::Response;

/// The joint estimate of a machine.
#[derive(Debug, Clone, Default)]
pub struct Estimate {
    /// Estimates, one for each joint.
    pub joints: Vec<JointEstimate>,
    /// Distance from the path along each log with several moving joints, m rms: name, before, after compensation.
    pub predicted: Vec<(String, f64, f64)>,
    /// Each reversal by itself.
    pub reversals: Vec<LocalReversal>,
    /// Names of parameters, as `A1.windup_deg`, and their covariance in the units of the names.
    pub covariance: Option<(Vec<String>, Vec<Vec<f64>>)>,
}

/// What is known of a joint beside its gap.
#[derive(Debug, Clone)]
pub struct JointEstimate {
    /// Axis of the robot.
    pub axis: usize,
    /// Response of the joint after a reversal: wind-up and spikes.
    pub response: Response,
    /// 95 % intervals: presliding, the whole wind-up, gain of each spike.
    pub presliding_ci95: [f64; 2],
    /// 95 % interval of the wind-up, rad or m.
    pub windup_ci95: [f64; 2],
    /// 95 % interval of each spike, rad or m.
    pub spikes_ci95: Vec<[f64; 2]>,
    /// Standard deviation of a single reversal's lost motion, as a share of it.
    pub scatter: f64,
    /// Whether the estimate reduces the errors of the logs it was not fitted to.
    pub trust: Trust,
    /// The fit of all logs against the single reversals; `None` where too few of these can be judged.
    pub agreement: Option<Agreement>,
}

/// Lost motion after a reversal (half gap, spikes and wind-up together) by the fit of all logs, which a compensator uses, and by the single
/// reversals, each estimated from its window alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Agreement {
    /// By the fit of all logs, rad or m, with its 95 % interval.
    pub all_logs: f64,
    /// Its 95 % interval.
    pub all_logs_ci95: [f64; 2],
    /// By the single reversals, rad or m.
    pub single: f64,
    /// Its 95 % interval.
    pub single_ci95: [f64; 2],
    /// Whether they differ by no more than their uncertainties allow (95 %).
    pub agree: bool,
}

impl Agreement {
    /// Which of the two a compensator uses, and why.
    pub fn reason(&self) -> &'static str {
        if self.agree {
            "both agree; the fit of all logs also has the course of a stroke"
        } else {
            "they differ; the fit of all logs is used because it has the course of a stroke and every log, and `trust` tells by the single \
             reversals whether its offset helps"
        }
    }
}

/// What compensating a joint does, predicted on parts of the logs that were not fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Trust {
    /// Whether the joint should be compensated.
    pub compensate: bool,
    /// Root mean square TCP error after the joint's reversals without and with compensation, m.
    pub before_m: f64,
    /// Error after reversals with compensation, m at the TCP.
    pub after_m: f64,
    /// Number of reversals that were judged.
    pub reversals: usize,
    /// Why.
    pub reason: Why,
}

/// Why a joint is compensated, or not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Why {
    /// Compensation helps on parts of the logs that were not fitted.
    Helps,
    /// It helps in the mean of its reversals, which scatter too much to tell by how much.
    HelpsInTheMean,
    /// It does not help beyond doubt.
    NotBeyondDoubt,
    /// As much error is predicted with compensation as without it.
    NoLess,
    /// The lost motion may be zero: something else explains it as well.
    NotTold,
    /// No reversal of the joint can be judged.
    NoReversal,
    /// The lost motion of the joint hardly moves the TCP.
    TooSmall,
    /// Compensation of all joints together would not reduce the error along the paths of the logs.
    NothingGained,
    /// The words of a document by another version or by hand.
    Words(String),
}

impl Why {
    /// The reasons that have fixed words.
    const ALL: [Self; 8] = [
        Self::Helps,
        Self::HelpsInTheMean,
        Self::NotBeyondDoubt,
        Self::NoLess,
        Self::NotTold,
        Self::NoReversal,
        Self::TooSmall,
        Self::NothingGained,
    ];

    /// The reason in words.
    pub fn format_text(&self) -> &str {
        match self {
            Self::Helps => "helps on parts of the logs that were not fitted",
            Self::HelpsInTheMean => "helps in the mean of its reversals, which scatter too much to tell by how much",
            Self::NotBeyondDoubt => "does not help beyond doubt on parts of the logs that were not fitted",
            Self::NoLess => "would leave as much error after its reversals, which scatter too much",
            Self::NotTold => {
                "would take a lag of the servo or a late clock for lost motion, which one speed does not tell apart: record a second speed, or one that varies"
            }
            Self::NoReversal => "cannot be judged: none of its reversals is far enough from others and from dwells",
            Self::TooSmall => "moves the TCP by less than 0.5 um at its reversals, which is not worth an offset",
            Self::NothingGained => {
                "would not reduce the error along the paths of these logs: the model does not describe them"
            }
            Self::Words(words) => words,
        }
    }

    fn read(words: &str) -> Self {
        Self::ALL.into_iter().find(|w| w.format_text() == words).unwrap_or_else(|| Self::Words(words.into()))
    }
}

/// One reversal, estimated from a window around it alone.
#[derive(Debug, Clone)]
pub struct LocalReversal {
    /// Axis of the robot.
    pub axis: usize,
    /// Name of the log.
    pub log: String,
    /// Time of the reversal, s.
    pub t_s: f64,
    /// Command at the reversal, rad or m.
    pub at: f64,
    /// Lost motion of this reversal as a multiple of the model's value, with its standard error.
    pub ratio: f64,
    /// Standard error of `ratio`.
    pub sigma: f64,
    /// Whether the reversal contradicts the others of its joint.
    pub outlying: bool,
}

impl std::fmt::Display for Why {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(self.format_text())
    }
}
