//! The parts of a diagnosis document, as they are written.

use crate::diagnose::note::Note;
use crate::diagnose::result::words::GapUnit;
use crate::diagnose::verdict::{Member, Verdict};
use crate::io::rounded::significant;
use indexmap::IndexMap;
use serde::Serialize;
use serde_json::Value;

/// What `diagnose --json` prints. Micrometres are rms per coordinate.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Diagnosis {
    /// Name and version of the document's form.
    pub schema: &'static str,
    /// What the log shows.
    pub verdict: Verdict,
    /// Number of rows that were used.
    pub samples: usize,
    /// Samples left out because they disagree with their neighbours.
    pub outliers: usize,
    /// Noise of the measurements.
    pub noise: NoiseFound,
    /// Residual of the model as given, with nuisances refitted, and with the effects found.
    pub gap: Gap,
    /// What was tried in each round, best first.
    pub rounds: Vec<Round>,
    /// Effects that a round named and a later one put aside.
    pub put_aside: Vec<PutAside>,
    /// What all geometry together does to the TCP, as `tcp_um` of a round.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub geometry_tcp_um: Option<f64>,
    /// Effects that were found, as in a model file, with intervals.
    pub effects: Vec<Value>,
    /// How much structure is left, and with what it goes, where the verdict is `unknown`.
    pub unexplained: Option<Unexplained>,
    /// What remains beside the named effects.
    pub remainder: Option<Unexplained>,
    /// Effects that this log does not show whatever their size.
    pub blind_spots: Vec<BlindSpot>,
    /// What a reader should know.
    #[schemars(with = "Vec<String>")]
    pub notes: Vec<Note>,
    /// The logs contradict what the model takes as known; the first notes say how.
    #[serde(skip)]
    pub contradicted: bool,
    /// What a further round would name, beyond the largest number of effects.
    #[serde(skip)]
    pub further: Option<String>,
    /// How a reader is shown the `_um` figures.
    #[serde(skip)]
    pub unit: GapUnit,
}

/// Noise of the first group: that of the TCP, where it was measured.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct NoiseFound {
    pub sigma_um: f64,
    pub source: &'static str,
    /// Autocorrelation from one sample to the next.
    pub ar1: f64,
    /// Correlation of the coloured part, and its share of the variance.
    pub phi: f64,
    pub share: f64,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Gap {
    pub initial_rms_um: f64,
    pub nuisance_only_rms_um: f64,
    pub final_rms_um: f64,
    pub initial_max_um: f64,
    pub final_max_um: f64,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Round {
    pub effect: String,
    pub target: String,
    pub set: Vec<Member>,
    pub decide_by: Option<String>,
    /// Rounds of one group were found, and are believed, together.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub group: Option<&'static str>,
    /// What it does to the TCP, rms per coordinate beyond a rigid movement in the log where it is largest; of effects that were
    /// fitted together.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tcp_um: Option<f64>,
    #[serde(rename = "where")]
    pub place: Place,
    pub evidence: Evidence,
    pub parameters: IndexMap<String, Parameter>,
    /// The same of a gap and the wind-up of its joint together, where no wind-up is in the fit: the log tells their sum better.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub with_windup: IndexMap<String, Parameter>,
    pub rms_before_um: f64,
    pub rms_after_um: f64,
    pub rms_after_predicted_um: f64,
    pub validation: Validation,
    /// What to do about it.
    pub action: String,
    /// Candidates that were refitted in this round, best first.
    pub candidates: Vec<Tried>,
    /// Unit of the joint that the effect moves; "deg" where there is none.
    #[serde(skip)]
    pub joint_unit: &'static str,
}

/// The smallest size of an effect that the logs would show.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct BlindSpot {
    pub effect: &'static str,
    pub target: String,
    /// Keys as in a model file, with the size from which on each is detected; null where no size shows.
    pub detectable_from: Option<IndexMap<String, f64>>,
    /// Why no size shows, where the joint's motion is the reason.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<Unseen>,
}

/// Why what a joint does in motion does not show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Unseen {
    /// It moves in no log.
    Rests,
    /// It moves, but hardly moves what is measured.
    DoesNotMoveTcp,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Tried {
    pub effect: String,
    pub target: String,
    pub gain_2lnl: f64,
    pub parameters: usize,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Place {
    pub joint: Option<String>,
    pub description: String,
    /// Stretches of the first log in which the effect shows, s.
    pub t_s: Vec<[f64; 2]>,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Evidence {
    pub statistic: &'static str,
    pub value: f64,
    pub dof: usize,
    pub p_value: f64,
    pub delta_bic: f64,
    /// The test of the group that the round belongs to.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub group: Option<GroupTest>,
}

/// F of all parameters of a group together.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct GroupTest {
    pub name: &'static str,
    pub value: f64,
    pub dof: usize,
    pub p_value: f64,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Parameter {
    pub value: f64,
    /// None where the fit did not converge, or the log does not move the value.
    pub ci95: Option<[f64; 2]>,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Validation {
    pub rms_before_um: f64,
    pub rms_after_um: f64,
    /// Gain in 2 ln L of this effect on parts that were not fitted, beside all the others.
    pub gain_2lnl: f64,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct PutAside {
    pub effect: String,
    pub target: String,
    pub replaced_by: String,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Unexplained {
    pub rms_um: f64,
    pub joint: Option<String>,
    pub goes_with: String,
    pub p_value: f64,
    pub nearest: Option<Tried>,
    /// Where the rounds ended at their limit: what the next one would have named.
    pub next: Option<Tried>,
    pub record: String,
}

pub(in crate::diagnose) const UM: f64 = 1e6;

pub(in crate::diagnose) fn digits(value: f64) -> f64 {
    significant(value, 8)
}
