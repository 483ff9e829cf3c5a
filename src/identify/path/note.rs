//! What a reader of an identification should know, as data; the words are made here.

use crate::error::counted;
use crate::gaps::Distrust;
use crate::identify::LEAST_LEVER;
use crate::robot::JointKind;
use std::fmt;

/// A remark on the identification of a path.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Note {
    NeverReverses {
        log: String,
        joint: String,
    },
    /// The joint's effect on the TCP is below [`LEAST_LEVER`].
    HardlyMoves {
        log: String,
        joint: String,
        kind: JointKind,
    },
    RowsLeftOut {
        log: String,
        lost: usize,
        rows: usize,
        outliers: usize,
    },
    Distrust(Distrust),
    /// Strong correlation, with a residual of the order of the noise.
    IntervalsWidened {
        inflation: f64,
    },
    /// Correlation that the intervals do not cover wholly.
    ResidualsCorrelated {
        inflation: f64,
    },
    TooManyReversals,
    /// Lag (rad or m) at the time after a reversal at which the log determines it best.
    LagKnownBest {
        joint: String,
        kind: JointKind,
        at_s: f64,
        lag: f64,
        ci95: [f64; 2],
    },
    SpikeAndDecayNotSeparated {
        joint: String,
    },
    GapsDiffer {
        joint: String,
        p_value: f64,
    },
    SharedDecay,
    LinkErrors {
        fitted: bool,
    },
    SeveralFrames {
        logs: usize,
    },
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NeverReverses { log, joint } => {
                write!(f, "{log}: {joint} never reverses, so its lost motion cannot be determined")
            }
            Self::HardlyMoves { log, joint, kind } => {
                let per = if *kind == JointKind::Revolute { "mm per radian" } else { "um per mm" };
                let least = LEAST_LEVER * 1e3;
                write!(
                    f,
                    "{log}: {joint} is left out: it moves the TCP by less than {least} {per}, so its gap cannot be determined"
                )
            }
            Self::RowsLeftOut { log, lost, rows, outliers } => {
                write!(
                    f,
                    "{log}: {lost} of {rows} rows without a measurement, {} left out",
                    counted(*outliers, "outlier")
                )
            }
            Self::Distrust(distrust) => distrust.fmt(f),
            Self::IntervalsWidened { inflation } => write!(
                f,
                "the residuals are correlated (variance inflated {inflation:.1} times: a ripple, a drift, or friction of another form); the intervals are widened accordingly"
            ),
            Self::ResidualsCorrelated { inflation } => write!(
                f,
                "the residuals are correlated (variance inflated {inflation:.1} times): the model lacks an effect (a gap that varies, a drift, or another one), and the intervals are too narrow"
            ),
            Self::TooManyReversals => f.write_str("too many reversals to list the gap at each of them"),
            Self::LagKnownBest { joint, kind, at_s, lag, ci95: [low, high] } => write!(
                f,
                "{joint}: the lag is known most precisely {at_s:.2} s after a reversal: {:.6} {}, 95 % {:.6} to {:.6}",
                kind.to_user_unit(*lag),
                kind.unit(),
                kind.to_user_unit(*low),
                kind.to_user_unit(*high)
            ),
            Self::SpikeAndDecayNotSeparated { joint } => {
                write!(f, "{joint}: this log does not separate spike and decay; rely on the lag above")
            }
            Self::GapsDiffer { joint, p_value } => {
                write!(
                    f,
                    "{joint}: the gaps at its reversals differ by more than their uncertainty (p = {p_value:.1e})"
                )
            }
            Self::SharedDecay => {
                f.write_str("the joints with stiction share one decay, because this log does not determine one for each joint")
            }
            Self::LinkErrors { fitted: true } => {
                f.write_str("rigid errors of the links were fitted together with the tracker's frame")
            }
            Self::LinkErrors { fitted: false } => f.write_str(
                "the log shows no rigid errors of the links: only the tracker's frame was fitted together with the lost motion",
            ),
            Self::SeveralFrames { logs } => {
                write!(
                    f,
                    "{logs} logs were fitted together, each with its own frame; the reported frame is that of the first log"
                )
            }
        }
    }
}
