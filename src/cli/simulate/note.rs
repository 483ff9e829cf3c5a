//! What a user of `simulate` should know: of the predicted log, and of options that do not apply.

use crate::simulate::Note as OfLog;

/// A remark on a run of the command.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// Of the predicted log.
    #[error(transparent)]
    Log(#[from] OfLog),
    /// A rate or a speed was given for a log, which has its own rows.
    #[error("--rate-hz and --speed-mm-s do not apply to a log: it keeps its rows")]
    KeepsRows,
    /// A speed was given for a program that has times.
    #[error("the program's t_s is ignored because of --speed-mm-s {}", speed_m_s * 1e3)]
    TimesIgnored {
        /// Speed of the TCP, m/s.
        speed_m_s: f64,
    },
    /// A program has neither times nor a speed.
    #[error("no t_s and no --speed-mm-s: the program runs at {} mm/s", speed_m_s * 1e3)]
    NoTimes {
        /// Speed of the TCP, m/s.
        speed_m_s: f64,
    },
}

crate::io::in_words!(Note);
