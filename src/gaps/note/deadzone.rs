//! Notes of the identification by growing sweeps.

use crate::error::counted;
use crate::robot::JointKind;

/// A remark on the deadzones of a joint; follows its name. Values of joints are in rad or m, as `kind` says.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Remark {
    /// The joint has no deadzone.
    #[error("{0}")]
    None(NoDeadzone),
    /// All deadzones begin at one or two places.
    #[error(
        "all deadzones ({deadzones}) begin at {} {}: the sweep does not grow, so the gap at other positions is not known",
        places.iter().map(|p| format!("{:.3}", kind.to_user_unit(*p))).collect::<Vec<_>>().join(" and "), kind.unit()
    )]
    DoesNotGrow {
        /// Number of deadzones.
        deadzones: usize,
        /// Kind of the joint.
        kind: JointKind,
        /// Where they begin, rad or m.
        places: Vec<f64>,
    },
    /// Whether the gap varies is not tested.
    #[error("{deadzones} deadzones are too few to see whether the gap varies with position")]
    TooFew {
        /// Number of deadzones.
        deadzones: usize,
    },
    /// The range of the map.
    #[error(
        "the gap is mapped from {:.3} to {:.3} {} and constant beyond",
        kind.to_user_unit(*from), kind.to_user_unit(*to), kind.unit()
    )]
    Mapped {
        /// Kind of the joint.
        kind: JointKind,
        /// Lower end, rad or m.
        from: f64,
        /// Upper end, rad or m.
        to: f64,
    },
    /// The deadzones scatter more than the tracker.
    #[error(
        "deadzones scatter {factor:.1} times as much as the tracker's noise explains; the intervals are widened by that: \
         friction, drift, a gap that depends on more than position, or noise that is correlated"
    )]
    Scatter {
        /// How many times as much.
        factor: f64,
    },
    /// Turns without readings.
    #[error("{} left out: too few tracker readings near them", counted(*turns, "turn"))]
    TurnsLeftOut {
        /// How many.
        turns: usize,
    },
    /// Gross errors of the tracker.
    #[error("{} left out as gross errors of the tracker", counted(*rows, "row"))]
    RowsLeftOut {
        /// How many.
        rows: usize,
    },
    /// A size that no gap can have.
    #[error("the size is negative, as if the tip moved before its motor: check the clocks of commands and tracker")]
    Negative,
}

/// Why a joint has no deadzone; follows its name.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoDeadzone {
    /// No reversal.
    #[error("it never reverses")]
    NeverTurns,
    /// One reversal.
    #[error("it reverses only once")]
    TurnsOnce,
    /// No stroke crosses the gap.
    #[error(
        "the tip does not move after any of the {turns} reversals (longest stroke {:.4} {}): the strokes are smaller than the gap",
        kind.to_user_unit(*stroke), kind.unit()
    )]
    AllInside {
        /// Number of reversals.
        turns: usize,
        /// Kind of the joint.
        kind: JointKind,
        /// Longest stroke, rad or m.
        stroke: f64,
    },
    /// Too few readings.
    #[error("too few tracker readings near its {turns} reversals")]
    FewRows {
        /// Number of reversals.
        turns: usize,
    },
    /// The tip hardly leaves the radius within which it counts as at rest.
    #[error(
        "after its {turns} reversals the tip moves too little compared with a rest radius of {:.0} um (longest stroke {:.4} {})",
        radius_m * 1e6, kind.to_user_unit(*stroke), kind.unit()
    )]
    TooShort {
        /// Number of reversals.
        turns: usize,
        /// Radius within which the tip counts as at rest, m.
        radius_m: f64,
        /// Kind of the joint.
        kind: JointKind,
        /// Longest stroke, rad or m.
        stroke: f64,
    },
    /// No mean.
    #[error("the sizes of its deadzones have no mean")]
    NoMean,
}
