//! Notes of the identification of a path.

use super::unit::lever_unit;
use crate::error::counted;
use crate::robot::JointKind;

/// A remark on the identification of a path.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// A joint without a reversal.
    #[error("{log}: {joint} never reverses, so its lost motion cannot be determined")]
    NeverReverses {
        /// Name of the log.
        log: String,
        /// Name of the joint.
        joint: String,
    },
    /// The joint hardly moves the TCP.
    #[error(
        "{log}: {joint} is left out: it moves the TCP by less than {} {}, so its gap cannot be determined",
        least_lever * 1e3, lever_unit(*kind)
    )]
    HardlyMoves {
        /// Name of the log.
        log: String,
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// The least effect on the TCP at which a gap is identified, m per rad or m per m.
        least_lever: f64,
    },
    /// Rows that tell nothing.
    #[error("{log}: {lost} of {rows} rows without a measurement, {} left out", counted(*outliers, "outlier"))]
    RowsLeftOut {
        /// Name of the log.
        log: String,
        /// Rows without a measurement.
        lost: usize,
        /// All rows.
        rows: usize,
        /// Rows whose measurement is a gross error.
        outliers: usize,
    },
    /// Strong correlation, with a residual of the order of the noise.
    #[error(
        "the residuals are correlated (variance inflated {inflation:.1} times: a ripple, a drift, or friction of another form); the intervals are widened accordingly"
    )]
    IntervalsWidened {
        /// Factor on the variance.
        inflation: f64,
    },
    /// Correlation that the intervals do not cover wholly.
    #[error(
        "the residuals are correlated (variance inflated {inflation:.1} times): the model lacks an effect (a gap that varies, a drift, or another one), and the intervals are too narrow"
    )]
    ResidualsCorrelated {
        /// Factor on the variance.
        inflation: f64,
    },
    /// The gap at each reversal is not listed.
    #[error("too many reversals to list the gap at each of them")]
    TooManyReversals,
    /// The lag at the time after a reversal at which the log determines it best.
    #[error(
        "{joint}: the lag is known most precisely {at_s:.2} s after a reversal: {:.6} {}, 95 % {:.6} to {:.6}",
        kind.to_user_unit(*lag), kind.unit(), kind.to_user_unit(ci95[0]), kind.to_user_unit(ci95[1])
    )]
    LagKnownBest {
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Time after a reversal, s.
        at_s: f64,
        /// Lag then, rad or m.
        lag: f64,
        /// Its 95 % interval, rad or m.
        ci95: [f64; 2],
    },
    /// Spike and decay trade off.
    #[error("{joint}: this log does not separate spike and decay; rely on the lag above")]
    SpikeAndDecayNotSeparated {
        /// Name of the joint.
        joint: String,
    },
    /// A lag may be what seems to be a gap.
    #[error(
        "{joint}: this log does not tell a half gap from a lag of the servo or a late clock, because the joint moves at one speed; record a second \
         log at another speed, or a motion whose speed varies, and give both"
    )]
    LagNotTold {
        /// Name of the joint.
        joint: String,
    },
    /// The gaps at the reversals of a joint differ.
    #[error("{joint}: the gaps at its reversals differ by more than their uncertainty (p = {p_value:.1e})")]
    GapsDiffer {
        /// Name of the joint.
        joint: String,
        /// p value of the test that they are alike.
        p_value: f64,
    },
    /// One decay for all joints.
    #[error("the joints with stiction share one decay, because this log does not determine one for each joint")]
    SharedDecay,
    /// Rigid errors of the links were fitted.
    #[error("rigid errors of the links were fitted together with the tracker's frame")]
    LinkErrors,
    /// The log shows no rigid errors of the links.
    #[error(
        "the log shows no rigid errors of the links: only the tracker's frame was fitted together with the lost motion"
    )]
    NoLinkErrors,
    /// Each log has its own frame.
    #[error("{logs} logs were fitted together, each with its own frame; the reported frame is that of the first log")]
    SeveralFrames {
        /// How many.
        logs: usize,
    },
}

impl Note {
    /// The log that the note begins with.
    pub(super) fn log_mut(&mut self) -> Option<&mut String> {
        match self {
            Self::NeverReverses { log, .. } | Self::HardlyMoves { log, .. } | Self::RowsLeftOut { log, .. } => {
                Some(log)
            }
            _ => None,
        }
    }
}
