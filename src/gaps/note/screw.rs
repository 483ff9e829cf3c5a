//! Notes of the identification of two gaps in series, and what they are about: gaps of a drive train, sensors, and why gaps are not seen.

use crate::error::counted;
use crate::robot::JointKind;
use std::fmt;

/// A gap of the train between motor and carriage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrainGap {
    /// Between motor and screw.
    Coupling,
    /// Between screw and carriage.
    Nut,
    /// Between motor and carriage.
    Both,
}

impl TrainGap {
    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Coupling => "coupling",
            Self::Nut => "nut",
            Self::Both => "both",
        }
    }
}

/// The gap as sentences name it.
impl fmt::Display for TrainGap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Coupling => "coupling",
            Self::Nut => "nut",
            Self::Both => "total",
        })
    }
}

/// What a sensor stands on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Sensor {
    /// On the screw.
    #[error("the screw")]
    Screw,
    /// On the carriage.
    #[error("the carriage")]
    Carriage,
}

/// Why the gaps before a sensor are not closed; ways in rad or m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Short {
    /// The joint turns back only once or less: one direction has no stroke.
    OneWay,
    /// The output stands still over strokes of this way: the lost motion is larger.
    NeverCrossed {
        /// The way, rad or m.
        way: f64,
    },
    /// The output moves, but no stroke goes far enough beyond the gap.
    HardlyCrossed {
        /// The way, rad or m.
        way: f64,
        /// Longest stroke, rad or m.
        longest: f64,
    },
    /// The output does not move with the joint.
    Dead {
        /// The way, rad or m.
        way: f64,
    },
    /// The output moves by this much per command: another unit or lead.
    Slope(f64),
    /// Too few rows.
    Rows,
}

/// Why there is no flank of a gap.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Missing {
    /// No stroke of some direction goes farther than this.
    #[error("too few rows beyond the gap in one of the directions")]
    TooShort,
    /// The lines have no slope that can be determined.
    #[error("its input hardly moves beyond the gap")]
    Singular,
}

/// Why a tracker tells nothing of a joint.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Unseen {
    /// The log has no coordinates of a tracker.
    #[error("no coordinates")]
    NoCoordinates,
    /// Joints turn, so that lines are no lines.
    #[error("{} turns in this log, so that the TCP does not move on straight lines", joints.join(", "))]
    Turns {
        /// Names of the joints that turn.
        joints: Vec<String>,
    },
    /// Joints that move together only.
    #[error("the joints move only together, so the tracker cannot distinguish them")]
    Together,
    /// The joint stands still.
    #[error("it stands still")]
    StandsStill,
    /// The coordinates do not see the joint.
    #[error("the logged coordinates hardly move with it")]
    HardlyMoves,
}

/// Where a joint stood when a log begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Start {
    /// The log begins with a move to this side that crosses the gap.
    Move(i8),
    /// The first rows stand on the flank of this direction.
    Flank(i8),
    /// Inside the gap, at this part of it from the flank of upward movement.
    Inside(f64),
    /// Nothing tells the flank.
    Unknown,
}

/// A remark on a joint; follows its name. Values are in rad or m, as `kind` says.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Remark {
    /// A log is passed over for a better one.
    #[error("{log} is not used, because {better} contains more")]
    LogNotUsed {
        /// Name of the log.
        log: String,
        /// Name of the log that is used.
        better: String,
    },
    /// The tracker does not see the joint.
    #[error("the tracker is not used: {0}")]
    TrackerNotUsed(Unseen),
    /// The gaps before a sensor are not seen.
    #[error("{}", short(*sensor, *why, *kind))]
    NotReached {
        /// The sensor.
        sensor: Sensor,
        /// Kind of the joint.
        kind: JointKind,
        /// Why.
        why: Short,
    },
    /// A gap has no flanks.
    #[error("no {gap} gap: {why}")]
    NoGap {
        /// Which gap.
        gap: TrainGap,
        /// Why.
        why: Missing,
    },
    /// Too few strokes to know their repeatability.
    #[error(
        "{gap} gap: {} up and {down} down: its interval contains the noise within them but not the repeatability; make at least three of each",
        counted(*up, "stroke")
    )]
    FewStrokes {
        /// Which gap.
        gap: TrainGap,
        /// Strokes up.
        up: usize,
        /// Strokes down.
        down: usize,
    },
    /// Gross errors.
    #[error("{gap} gap: {dropped} of {} left out as gross errors", counted(*rows, "row"))]
    RowsLeftOut {
        /// Which gap.
        gap: TrainGap,
        /// How many.
        dropped: usize,
        /// All rows.
        rows: usize,
    },
    /// A lag looks like a gap.
    #[error(
        "{gap} gap: at a single speed a lag looks like a gap: each millisecond of lag would add {}; let the joint stand still at the ends of its strokes, or move at two speeds, or log the encoder",
        shown(per_s * 1e-3, *kind)
    )]
    LagLooksLikeGap {
        /// Which gap.
        gap: TrainGap,
        /// Kind of the joint.
        kind: JointKind,
        /// Gap per second of lag, rad or m.
        per_s: f64,
    },
    /// A gap that is clearly negative.
    #[error(
        "{gap} gap is negative, so it is not a gap: the output leads its input; check the signs, the order and the clocks of the columns{}",
        if *gap == TrainGap::Both { "" } else { " (are `enc` and `screw`, or `screw` and `meas`, swapped?)" }
    )]
    Negative {
        /// Which gap.
        gap: TrainGap,
    },
    /// The slope is no lead error.
    #[error("{gap}: slope {slope:.4}: does the lead or the scale of the sensor differ from the robot file?")]
    OffScale {
        /// Which gap.
        gap: TrainGap,
        /// Output per input.
        slope: f64,
    },
    /// On which side of its gap the joint stands when the log begins.
    #[error("{}", begins(*start, *from, *kind))]
    Begins {
        /// Where it stands.
        start: Start,
        /// Kind of the joint.
        kind: JointKind,
        /// Way into a stroke at which the gap is closed, rad or m.
        from: f64,
    },
    /// No sensor separates coupling and nut.
    #[error(
        "no sensor between coupling and nut (`{column}`): the two gaps cannot be separated, so only their sum is reported"
    )]
    NotSeparated {
        /// The column that would separate them.
        column: String,
    },
    /// A lead error.
    #[error(
        "slope {slope:.6}: the joint moves {:+.0} ppm of its command too far; correct the lead or scale in the controller; offsets at reversals cannot correct it",
        (slope - 1.0) * 1e6
    )]
    LeadError {
        /// Output per input.
        slope: f64,
    },
    /// A tracker has no zero.
    #[error("the tracker has no zero, so only the difference of c_l and c_r is known")]
    TrackerWithoutZero,
    /// The zero is not known well enough.
    #[error("only the difference of c_l and c_r is known, because the zero lies too far outside the strokes")]
    ZeroTooFar,
    /// Sensor and command differ in their zero.
    #[error(
        "both flanks lie on one side of zero (c_l {}, c_r {}): the zero of the sensor differs from that of the command; the gap is split evenly",
        shown(*c_l, *kind), shown(*c_r, *kind)
    )]
    OtherZero {
        /// Kind of the joint.
        kind: JointKind,
        /// Flank of downward movement, rad or m.
        c_l: f64,
        /// Flank of upward movement, rad or m.
        c_r: f64,
    },
    /// The parts do not add up.
    #[error(
        "the sum of coupling and nut differs from the gap over both by {}: does the screw column have the scale of the joint?",
        shown(*off, *kind)
    )]
    SumDiffers {
        /// Kind of the joint.
        kind: JointKind,
        /// Sum of the parts minus the whole, rad or m.
        off: f64,
    },
    /// Only the coupling was measured.
    #[error("the gap of the coupling alone is not the lost motion of the joint: the result contains no gap for `fit`")]
    CouplingAlone,
}

/// A joint value with its unit.
pub fn shown(v: f64, kind: JointKind) -> String {
    format!("{:.4} {}", kind.to_user_unit(v) + 0.0, kind.unit())
}

/// Why the gaps before a sensor cannot be seen.
fn short(sensor: Sensor, why: Short, kind: JointKind) -> String {
    let way = |v: f64| shown(v, kind);
    match why {
        Short::OneWay => {
            format!("{sensor}: the joint moves in one direction only: strokes up and down are needed")
        }
        Short::NeverCrossed { way: w } => format!(
            "{sensor} stands still over strokes of {}: no stroke crossed the gap, so it is larger than that; make longer strokes",
            way(w)
        ),
        Short::HardlyCrossed { way: w, longest } => format!(
            "{sensor} moves, but its strokes of {} end too soon after the gap: make them at least twice as long (longest: {})",
            way(w),
            way(longest)
        ),
        Short::Dead { way: w } => format!(
            "{sensor} stands still over strokes of {}, and no gap is so wide: check that this is the sensor of this joint and that it works",
            way(w)
        ),
        Short::Slope(m) => format!("{sensor} moves by {m:.5} per command"),
        Short::Rows => format!("{sensor}: too few rows in the far half of the strokes"),
    }
}

/// Where the log begins.
fn begins(start: Start, from: f64, kind: JointKind) -> String {
    let side = |d: i8| if d > 0 { "upwards" } else { "downwards" };
    let left = || format!("the first {} are left out like those after every reversal", shown(from, kind));
    match start {
        Start::Move(d) => format!("preloaded: the log begins with a short move {}, which closes the gaps", side(d)),
        Start::Flank(d) => format!("the log begins on the flank of movement {}, as after a preload", side(d)),
        Start::Inside(p) => format!(
            "no preload: the log begins inside the gap, about {:.0} % of it from the flank of upward movement; {}",
            p * 100.0,
            left()
        ),
        Start::Unknown => {
            format!("no preload before the first stroke: the side on which it starts is unknown; {}", left())
        }
    }
}
