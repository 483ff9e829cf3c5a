//! What a reader of a compensator should know: what each joint's offsets come from, what was left out and why. Code compares the
//! variants; the words are for readers.

use crate::gaps::Distrust;
use crate::gaps::estimate::Why;
use crate::robot::JointKind;
use serde::{Deserialize, Deserializer};
use std::fmt;

/// A remark on how a compensator came about. Gaps, spikes and offsets are in rad or m, as `kind` says.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// A note as a compensator file holds it.
    #[error("{0}")]
    Read(String),
    /// The offsets are those of a model file.
    #[error("offsets undo the effects of a model file")]
    OfModel,
    /// No joint gets an offset.
    #[error("no joint has lost motion that exceeds its uncertainty, so programs stay as they are")]
    NothingToCompensate,
    /// The gaps cannot be trusted and were fitted all the same.
    #[error("{0}")]
    Distrust(Distrust),
    /// Two documents contradict each other, and the one that is known best was used all the same.
    #[error("{0}")]
    Contradiction(Contradiction),
    /// Half gaps of two documents differ; that of the narrower interval is used.
    #[error(
        "{joint}: half gaps from {used} ({}) and {other} ({}) differ by more than their uncertainty; the narrower is used",
        shown(*used_half_gap, *kind), shown(*other_half_gap, *kind)
    )]
    HalfGapsDiffer {
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Logs of the document that is used.
        used: Source,
        /// Half gap that is used, rad or m.
        used_half_gap: f64,
        /// Logs of the other document.
        other: Source,
        /// Half gap of the other document, rad or m.
        other_half_gap: f64,
    },
    /// Gaps of a document are passed over for those that were estimated together with the friction.
    #[error(
        "{}: gaps from {unused} are not used: those from {used} were estimated together with the friction; one `identify` of all logs uses both",
        joints.join(", ")
    )]
    PassedOver {
        /// Names of the joints.
        joints: Vec<String>,
        /// Logs of the document that is not used.
        unused: Source,
        /// Logs of the document that is used.
        used: Source,
    },
    /// An estimate of all logs does not trust the compensation of a joint.
    #[error("{joint}: left out: {reason} ({} before, {} after)", um(*before_m), um(*after_m))]
    NotTrusted {
        /// Name of the joint.
        joint: String,
        /// Why it is not trusted.
        reason: Why,
        /// Error at its reversals without compensation, m.
        before_m: f64,
        /// With compensation, m.
        after_m: f64,
    },
    /// What compensation of a joint is predicted to leave at its reversals.
    #[error("{joint}: {} at its reversals before, {} predicted after compensation", um(*before_m), um(*after_m))]
    Predicted {
        /// Name of the joint.
        joint: String,
        /// Error at its reversals without compensation, m.
        before_m: f64,
        /// With compensation, m.
        after_m: f64,
    },
    /// A joint that overshoots its command has no gap.
    #[error(
        "{joint}: half gap {} is left out: the joint overshoots its command, which is not a gap (check the direction of the joint and the log)",
        shown(*half_gap, *kind)
    )]
    Overshoots {
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Half gap that was found, rad or m.
        half_gap: f64,
    },
    /// A half gap that is not larger than its uncertainty.
    #[error(
        "{joint}: half gap {} is left out because it is not larger than its uncertainty of {}",
        shown(*half_gap, *kind), shown(*uncertainty, *kind)
    )]
    GapUncertain {
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Half gap that was found, rad or m.
        half_gap: f64,
        /// Half of its 95 % interval, rad or m.
        uncertainty: f64,
    },
    /// Tested positions at which the gap is not larger than its uncertainty.
    #[error("{joint}: at {positions} tested positions the gap is smaller than its uncertainty and set to 0")]
    PositionsUncertain {
        /// Name of the joint.
        joint: String,
        /// How many.
        positions: usize,
    },
    /// The offset follows a schedule.
    #[error("{joint}: the gap varies with position; its schedule comes from {from}")]
    Scheduled {
        /// Name of the joint.
        joint: String,
        /// Logs of the document that the schedule comes from.
        from: Source,
    },
    /// The offset differs from one direction to the other.
    #[error(
        "{joint}: the sides of its gap differ: {} moving up, {} moving down",
        shown(*positive, *kind), shown(*negative, *kind)
    )]
    SidesDiffer {
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Offset moving up, rad or m.
        positive: f64,
        /// Moving down, rad or m.
        negative: f64,
    },
    /// The gaps at the reversals differ, and the offset is not their mean.
    #[error(
        "{joint}: the gaps at its reversals differ by more than their uncertainty; {} leaves the smallest largest error (mean {})",
        shown(*offset, *kind), shown(*mean, *kind)
    )]
    NotTheMean {
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Offset that is used, rad or m.
        offset: f64,
        /// Mean of the half gaps, rad or m.
        mean: f64,
    },
    /// The log shows no stiction.
    #[error("{joint}: no friction term: the log shows no stiction (p = {p_value:.2})")]
    NoStiction {
        /// Name of the joint.
        joint: String,
        /// p value of the test that there is none.
        p_value: f64,
    },
    /// What looks like stiction may be another misfit.
    #[error(
        "{joint}: no friction term: the apparent stiction cannot be distinguished from other misfit (p = {p_value:.2})"
    )]
    StictionLikeMisfit {
        /// Name of the joint.
        joint: String,
        /// p value of the test that there is none.
        p_value: f64,
    },
    /// A spike that is not larger than its uncertainty.
    #[error(
        "{joint}: friction term of {} is left out because it is not larger than its uncertainty of {}",
        shown(*spike, *kind), shown(*uncertainty, *kind)
    )]
    FrictionUncertain {
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Spike that was found, rad or m.
        spike: f64,
        /// Half of its 95 % interval, rad or m.
        uncertainty: f64,
    },
    /// The gain is smaller than the spike, to be on the safe side.
    #[error(
        "{joint}: friction gain {} is used instead of the spike {}, because it is at the end of the uncertainty that does less harm",
        shown(*gain, *kind), shown(*spike, *kind)
    )]
    PrudentGain {
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Gain that is used, rad or m.
        gain: f64,
        /// Spike that was found, rad or m.
        spike: f64,
    },
    /// Points are too far apart in time for the decay.
    #[error(
        "{joint}: friction term is left out because points {spacing_s:.2} s apart cannot follow a decay of {decay_s:.2} s"
    )]
    PointsTooFarApart {
        /// Name of the joint.
        joint: String,
        /// Time from one point to the next, s.
        spacing_s: f64,
        /// Decay of the spike, s.
        decay_s: f64,
    },
    /// What equation 17 leaves of the decay.
    #[error(
        "{joint}: {{g, l, k_t}} leave at most {} of the decay of {decay_s:.2} s at points {spacing_s:.2} s apart; they hold for that spacing only",
        shown(*left, *kind)
    )]
    LeftByPoints {
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Largest lag that is left, rad or m.
        left: f64,
        /// Decay of the spike, s.
        decay_s: f64,
        /// Time from one point to the next, s.
        spacing_s: f64,
    },
    /// What a run did to the offsets of a joint.
    #[error("{joint}: {change}")]
    Run {
        /// Name of the joint.
        joint: String,
        /// What happened to its offsets.
        change: Change,
    },
}

/// What a run of rewritten programs does to the offsets of a joint.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Change {
    /// The run shows nothing to correct.
    #[error("kept: the run shows no significant correction (p = {p_value:.2})")]
    NotSignificant {
        /// p value of the test that nothing is to be corrected.
        p_value: f64,
    },
    /// The run has too few strokes.
    #[error("kept: too few strokes in the run to judge a correction")]
    TooFewStrokes,
    /// A correction by some strokes does not help at the others.
    #[error("kept: a correction by one half of its strokes does not improve the other half (gain {gain:.1})")]
    DoesNotHelp {
        /// What the correction gains at the other half; above 0: it improves it.
        gain: f64,
    },
    /// The offsets were corrected; changes in rad or m.
    #[error(
        "half gap corrected by up to {:+.5} {unit}, spikes by {:+.5} {unit}, wind-up by {:+.5} {unit} (p = {p_value:.1e}); {} left before",
        kind.to_user_unit(*half_gap), kind.to_user_unit(*spikes), kind.to_user_unit(*windup), um(*left_m), unit = kind.unit()
    )]
    Corrected {
        /// Kind of the joint.
        kind: JointKind,
        /// Largest change of the half gap, rad or m.
        half_gap: f64,
        /// Change of the sum of the spikes, rad or m.
        spikes: f64,
        /// Change of the wind-up, rad or m.
        windup: f64,
        /// p value of the test that nothing is to be corrected.
        p_value: f64,
        /// Root mean square error after the reversals of the run, m.
        left_m: f64,
    },
    /// The last correction made the joint worse and was taken back.
    #[error(
        "returned to the values before its last correction: {} left after its reversals with it, {} without",
        um(*with_m), um(*without_m)
    )]
    TakenBack {
        /// Root mean square error after the reversals with the correction, m.
        with_m: f64,
        /// Without it, m.
        without_m: f64,
    },
}

/// Logs of a gaps document, by name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source(pub Vec<String>);

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.as_slice() {
            [] => f.write_str("a document without logs"),
            [one] => f.write_str(one),
            [first, rest @ ..] => write!(f, "{first} and {} more", rest.len()),
        }
    }
}

/// Half gaps of a joint that contradict each other.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "{joint}: the half gaps of two documents contradict each other: {} and {}",
    earlier.words(*kind), later.words(*kind)
)]
pub struct Contradiction {
    /// Name of the joint.
    pub joint: String,
    /// Kind of the joint.
    pub kind: JointKind,
    /// Half gap of the document that was given first.
    pub earlier: Stated,
    /// Half gap of the other.
    pub later: Stated,
}

/// A half gap as a document states it, rad or m.
#[derive(Debug, Clone, PartialEq)]
pub struct Stated {
    /// Mean half gap, rad or m.
    pub half_gap: f64,
    /// 95 % interval, rad or m.
    pub ci95: [f64; 2],
    /// It varies with position.
    pub varies: bool,
    /// First log of the document, if it names one.
    pub log: Option<String>,
}

impl Stated {
    fn words(&self, kind: JointKind) -> String {
        let [low, high] = self.ci95.map(|v| kind.to_user_unit(v));
        let varies = if self.varies { ", varying with position" } else { "" };
        let from = self.log.as_deref().unwrap_or("a document without logs");
        format!("{} (95 % {low:.5} to {high:.5}{varies}) from {from}", shown(self.half_gap, kind))
    }
}

/// A value of a joint (rad or m) in the unit of the edges.
fn shown(value: f64, kind: JointKind) -> String {
    format!("{:.5} {}", kind.to_user_unit(value), kind.unit())
}

/// A distance in micrometres.
fn um(distance_m: f64) -> String {
    format!("{:.1} um", distance_m * 1e6)
}

crate::io::in_words!(Note);

/// What a file holds are words.
impl<'de> Deserialize<'de> for Note {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer).map(Self::Read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_shown_in_the_unit_of_their_joint() {
        let note = Note::SidesDiffer { joint: "X".into(), kind: JointKind::Prismatic, positive: 2e-5, negative: 3e-5 };
        assert_eq!(note.to_string(), "X: the sides of its gap differ: 0.02000 mm moving up, 0.03000 mm moving down");
    }

    #[test]
    fn a_note_of_a_file_keeps_its_words() {
        let note: Note = serde_json::from_str("\"A1: as it was written\"").unwrap();
        assert_eq!(note, Note::Read("A1: as it was written".into()));
        assert_eq!(serde_json::to_string(&note).unwrap(), "\"A1: as it was written\"");
    }
}
