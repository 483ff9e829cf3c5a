//! Notes of a test of bidirectional dwells.

use super::unit::lever_unit;
use crate::error::counted;
use crate::robot::JointKind;

/// A remark on a static test. Values of joints are in rad or m, as `kind` says.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// Of a joint.
    #[error("{joint}: {remark}")]
    Joint {
        /// Name of the joint.
        joint: String,
        /// What is to know of it.
        remark: Remark,
    },
    /// Dwells that no joint reached alone.
    #[error("dwells left out because several joints or none moved to reach them: {dwells}")]
    NotAlone {
        /// How many.
        dwells: usize,
    },
    /// The measured points lie on one line.
    #[error(
        "the measured points lie on one line, which does not determine the rotation of the frame about it (rank 5 of 6); motion along the line does not depend on this rotation"
    )]
    OnOneLine,
    /// Gross errors of the registration.
    #[error("points left out of the registration because they disagree with the others: {dropped} of {points}")]
    PointsLeftOut {
        /// How many are left out.
        dropped: usize,
        /// All points.
        points: usize,
    },
}

/// A remark on a joint; follows its name. Values are in rad or m, as `kind` says.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Remark {
    /// No position was reached from both sides.
    #[error(
        "all {positions} positions were reached from one side only, so no gap can be determined; reach each position from below and from above"
    )]
    AllOneSided {
        /// Number of positions.
        positions: usize,
    },
    /// Some positions were reached from one side only.
    #[error("positions left out because they were reached from one side only: {positions}")]
    OneSided {
        /// How many.
        positions: usize,
    },
    /// Dwells without a partner.
    #[error("{} left out, without a partner from the other side", counted(*dwells, "dwell"))]
    WithoutPartner {
        /// How many.
        dwells: usize,
    },
    /// Pairs without a reading.
    #[error("pairs left out because they have no reading: {pairs}")]
    WithoutReading {
        /// How many.
        pairs: usize,
    },
    /// Pairs at which the joint hardly moves the TCP.
    #[error(
        "pairs left out because the joint moves the TCP by less than {} {} there: {pairs}",
        least_lever * 1e3, lever_unit(*kind)
    )]
    HardlyMoves {
        /// Kind of the joint.
        kind: JointKind,
        /// The least effect on the TCP at which a gap is identified, m per rad or m per m.
        least_lever: f64,
        /// How many.
        pairs: usize,
    },
    /// Pairs at which the joint moves across the direction of the dial.
    #[error(
        "pairs left out because the joint moves across the dial there: its direction is known to {tilt_deg:.0} deg, which may be the whole reading: {pairs}"
    )]
    AcrossDial {
        /// Standard deviation of the direction, deg.
        tilt_deg: f64,
        /// How many.
        pairs: usize,
    },
    /// Pairs at which the reading does not follow the joint.
    #[error(
        "pairs left out because the reading did not change by a digit while the joint moved there (a dial at its stop, or lifted off): {pairs}"
    )]
    AtStop {
        /// How many.
        pairs: usize,
    },
    /// The last digit of the readings is not small against the gap.
    #[error(
        "the readings are written in steps that are not small against the gap: the rounding of each position is an error of {:.5} {} in all its \
         cycles; write them with more digits",
        kind.to_user_unit(*error), kind.unit()
    )]
    CoarseReadings {
        /// Kind of the joint.
        kind: JointKind,
        /// Standard deviation of the half gap at a position, rad or m.
        error: f64,
    },
    /// One cycle at one angle.
    #[error("only one cycle at one angle: no interval is possible, so no gap is reported")]
    OneValue,
    /// Gross errors at a position.
    #[error(
        "at {:.4} {unit} {} left out as gross errors: {} {unit}",
        kind.to_user_unit(*at), values.len(),
        values.iter().map(|v| format!("{:.5}", kind.to_user_unit(*v))).collect::<Vec<_>>().join(", "), unit = kind.unit()
    )]
    GrossErrors {
        /// Kind of the joint.
        kind: JointKind,
        /// Position, rad or m.
        at: f64,
        /// Half gaps that are left out, rad or m.
        values: Vec<f64>,
    },
    /// Gross errors at a position that could not be left out.
    #[error(
        "at {:.4} {} the cycles disagree, and too few would remain without the outliers: all are kept; do not trust this value",
        kind.to_user_unit(*at), kind.unit()
    )]
    CyclesDisagree {
        /// Kind of the joint.
        kind: JointKind,
        /// Position, rad or m.
        at: f64,
    },
    /// Whether the gap varies is not tested.
    #[error("too few repeats to test whether the gap varies with position")]
    TooFewRepeats,
    /// One cycle at several positions.
    #[error(
        "only one cycle: the intervals treat the spread between positions as noise, and no test shows whether the gap varies"
    )]
    OneCycle,
    /// One pair at one position.
    #[error("only one pair: its interval contains the noise within the dwells but not the repeatability")]
    OnePair,
    /// The rounding of the file is the noise.
    #[error("the repeats agree better than the last digit of the file: the rounding was used as the noise")]
    Rounding,
    /// The cycles scatter more than the readings within a dwell.
    #[error(
        "the cycles scatter {factor:.1} times as much as the noise within the dwells: drift, temperature or settling between cycles"
    )]
    CyclesScatter {
        /// How many times as much.
        factor: f64,
    },
    /// A steady drift.
    #[error(
        "the readings drift steadily by {:.5} {unit} a minute, which shifts the second approach of each cycle against the first and adds about \
         {:.5} {unit} to the half gap; the interval contains the value without it. Let tracker and robot warm up, or use shorter cycles",
        kind.to_user_unit(*per_min), kind.to_user_unit(*bias), unit = kind.unit()
    )]
    Drifts {
        /// Kind of the joint.
        kind: JointKind,
        /// Drift of the joint, rad or m a minute.
        per_min: f64,
        /// What it adds to the half gap, rad or m.
        bias: f64,
    },
    /// A gap that is clearly negative.
    #[error(
        "the gap is negative, as if the joint {} past its command: check the direction of the joint and of `trigger`",
        if *kind == JointKind::Revolute { "turns" } else { "moves" }
    )]
    Negative {
        /// Kind of the joint.
        kind: JointKind,
    },
    /// The dwells are too short to tell whether the readings still creep.
    #[error(
        "the dwells of {dwell_s:.1} s are too short to exclude that the readings still creep (probability {probability:.2}); the interval allows for it"
    )]
    MayCreep {
        /// Length of the dwells, s.
        dwell_s: f64,
        /// Probability that they creep.
        probability: f64,
    },
    /// The readings still creep when the dwells end.
    #[error(
        "the readings still creep when the dwells of {dwell_s:.1} s end ({:.5} {} then, pace {pace_s:.1} s, 95 % interval {:.1} to {:.1} s): the half gap at rest is extrapolated, and its interval allows for this; dwells of {:.0} s would measure it",
        kind.to_user_unit(*at_end), kind.unit(), pace_ci95_s[0], pace_ci95_s[1], needed_dwell_s.ceil()
    )]
    Creeps {
        /// Kind of the joint.
        kind: JointKind,
        /// Length of the dwells, s.
        dwell_s: f64,
        /// What is still to come at their end, rad or m.
        at_end: f64,
        /// Time constant, s.
        pace_s: f64,
        /// Its 95 % interval, s.
        pace_ci95_s: [f64; 2],
        /// Length of dwells that would measure the gap at rest, s.
        needed_dwell_s: f64,
    },
    /// An approach is too short to cross the gap.
    #[error(
        "an approach of {:.5} {} is shorter than twice the half gap: the gap was not crossed; approach from farther away",
        kind.to_user_unit(*stroke), kind.unit()
    )]
    ShortApproach {
        /// Kind of the joint.
        kind: JointKind,
        /// Shortest approach, rad or m.
        stroke: f64,
    },
    /// Too few positions for a smooth schedule.
    #[error("{positions} positions are too few to smooth: the schedule uses the raw means")]
    RawMeans {
        /// How many.
        positions: usize,
    },
    /// The schedule is negative in places.
    #[error("the schedule is set to zero where the estimated gap is negative")]
    CutAtZero,
}
