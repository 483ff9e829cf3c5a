//! The diagnosis document `lostmotion/diagnosis/1`.
//!
//! Parts:
//! - [`hidden`]: what the log leaves open: structure without a name, effects that it does not show.

mod hidden;

use crate::diagnose::note::Note;
use crate::diagnose::problem::layout::Sensor;
use crate::diagnose::problem::recording::Recording;
use crate::diagnose::problem::residual::largest;
use crate::diagnose::result::round::round;
use crate::diagnose::result::words::GapUnit;
use crate::diagnose::search::outcome::Outcome;
use crate::diagnose::search::{story, unnamed};
use crate::diagnose::verdict::{self, Member, Verdict};
use crate::effects::{EffectInstance, Nature, TrackerFrame, entry};
use crate::robot::JointKind;
use hidden::{blind_spots, slow_remainder, unexplained};
pub use hidden::{of_motion, of_unseen_joints};
use indexmap::IndexMap;
use serde::Serialize;
use serde_json::Value;

pub const SCHEMA: &str = "lostmotion/diagnosis/1";

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
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let scale = 10f64.powi(7 - value.abs().log10().floor() as i32);
    if scale.is_finite() { (value * scale).round() / scale } else { value }
}

/// Does remaining structure mean that the cause is unknown? What stays of a real arm is reported; it takes nothing from what was
/// named. Joint sensors are so precise that a misfit always stays.
fn hides_unknown(outcome: &Outcome, found: &[&EffectInstance]) -> bool {
    let has_name = found.iter().any(|p| !unnamed::is_unnamed(p));
    let sensors = outcome.problem.recording() == Recording::JointSensors;
    let known_well = sensors && outcome.contradictions.is_empty() && has_name;
    outcome.group.is_none() && outcome.told.is_none() && !known_well
}

fn noise(outcome: &Outcome) -> NoiseFound {
    let noise = outcome.whitening.noise.first().copied().unwrap_or(crate::diagnose::noise::Noise::white(0.0));
    NoiseFound {
        sigma_um: digits(noise.sigma * UM),
        source: "autoregressive fit",
        ar1: digits(noise.lag_one()),
        phi: digits(noise.phi),
        share: digits(noise.share),
    }
}

/// The residual as given, with the frame refitted, and at the end.
fn gap(outcome: &Outcome) -> Gap {
    let (problem, residual) = (&outcome.problem, &outcome.fit.state.residual);
    Gap {
        initial_rms_um: digits(outcome.rms_given * UM),
        nuisance_only_rms_um: digits(outcome.rms_nuisance * UM),
        final_rms_um: digits(crate::diagnose::problem::residual::rms(problem, residual) * UM),
        initial_max_um: digits(outcome.max_given * UM),
        final_max_um: digits(largest(problem, residual) * UM),
    }
}

/// The document of an outcome.
pub fn of(outcome: &Outcome) -> Diagnosis {
    let found: Vec<&EffectInstance> = outcome.fit.free.iter().map(|&i| &outcome.fit.hypothesis.effects[i]).collect();
    let named = named(outcome);
    let sets: Vec<Vec<Member>> = (named.iter().zip(&outcome.alternatives).enumerate())
        .map(|(k, (n, r))| {
            let doubtful = outcome.doubtful.get(k).is_some_and(|d| *d);
            verdict::set((&n.0, &n.1), r, outcome.price, doubtful)
        })
        .collect();
    let order = told_in_order(outcome);
    let indices: Vec<usize> = order.iter().map(|&k| outcome.fit.free[k]).collect();
    let nested_fits = match &outcome.told {
        Some(story) => story.nested_fits.clone(),
        None => story::nested_fits(&outcome.problem, &outcome.fit, outcome.known, &indices, &outcome.whitening),
    };
    let structured = if outcome.group.is_some() { outcome.remains_of_arm() } else { outcome.remains.clone() };
    let unknown = structured.is_some() && hides_unknown(outcome, &found);
    let rounds = order
        .iter()
        .enumerate()
        .map(|(step, &k)| round(outcome, k, &named[k], &sets[k], (&nested_fits[step], &nested_fits[step + 1])))
        .collect();
    let put_aside = outcome
        .steps
        .iter()
        .filter_map(|s| {
            s.replaced_by.as_ref().map(|by| PutAside {
                effect: s.effect.into(),
                target: s.target.clone(),
                replaced_by: by.clone(),
            })
        })
        .collect();
    Diagnosis {
        schema: SCHEMA,
        verdict: verdict::of(outcome, &sets, unknown),
        samples: outcome.problem.groups.iter().map(|g| g.rows.len()).sum(),
        outliers: outcome.outliers,
        noise: noise(outcome),
        gap: gap(outcome),
        rounds,
        put_aside,
        geometry_tcp_um: outcome.told.as_ref().map(|story| digits(story.geometry * UM)),
        effects: found.iter().map(|p| effect_value(p, outcome)).collect(),
        unexplained: structured.as_ref().map(|s| unexplained(outcome, s)),
        remainder: structured.as_ref().map(|s| unexplained(outcome, s)).or_else(|| slow_remainder(outcome)),
        blind_spots: blind_spots(outcome),
        notes: notes(outcome),
        contradicted: !outcome.contradictions.is_empty(),
        further: outcome.further.as_ref().map(|n| format!("{} {}", n.effect, n.target)),
        unit: unit(outcome),
    }
}

/// Degrees where only joints were measured and the first of them turns.
fn unit(outcome: &Outcome) -> GapUnit {
    let p = &outcome.problem;
    match p.groups.first().map(|g| g.sensor) {
        Some(Sensor::Joint(a) | Sensor::Motor(a))
            if !p.groups.iter().any(|g| g.sensor.is_length()) && p.robot.axis(a).kind == JointKind::Revolute =>
        {
            GapUnit::DEGREE
        }
        _ => GapUnit::MICROMETRE,
    }
}

fn notes(outcome: &Outcome) -> Vec<Note> {
    let mut notes: Vec<Note> = outcome.contradictions.iter().map(|c| c.note.clone()).collect();
    notes.extend(outcome.notes.iter().cloned());
    for p in outcome
        .fit
        .free
        .iter()
        .map(|&i| &outcome.fit.hypothesis.effects[i])
        .filter(|p| p.effect.nature() == Nature::Ripple && p.effect.of_its_logs_alone())
    {
        let target = p.target_text(&outcome.problem.robot);
        notes.push(Note::PhaseOfEachLog { effect: p.effect.name(), target });
    }
    notes.extend(frame_jumps(outcome));
    if let Some(slow) = &outcome.slow {
        notes.push(Note::SlowRemainder {
            slow_m: slow.rms,
            instrument_m: slow.instrument,
            structure: verdict::structure_said(outcome, &slow.ratio),
        });
    }
    if unit(outcome) == GapUnit::DEGREE {
        notes.push(Note::OnlyJoints);
    }
    notes
}

/// Steps of the tracker's frame: another log does not have them.
fn frame_jumps(outcome: &Outcome) -> Vec<Note> {
    let found = outcome.fit.free.iter().map(|&i| &outcome.fit.hypothesis.effects[i]);
    let step = |f: &TrackerFrame| Note::FrameJumps { by_m: f.translation_m.norm(), when: f.when() };
    found.filter_map(|p| p.effect.get::<TrackerFrame>()).filter(|f| f.only_log.is_some()).map(step).collect()
}

/// Effect and target of each found effect.
fn named(outcome: &Outcome) -> Vec<(String, String)> {
    let found = outcome.fit.free.iter().map(|&i| &outcome.fit.hypothesis.effects[i]);
    found.map(|p| (p.effect.name().to_string(), p.target_text(&outcome.problem.robot))).collect()
}

/// Found effects (indices into the free ones) in the order in which they were accepted: that of the rounds.
pub fn told_in_order(outcome: &Outcome) -> Vec<usize> {
    let named = named(outcome);
    let mut order: Vec<usize> = (0..named.len()).collect();
    if let Some(story) = &outcome.told {
        return story.order.clone();
    }
    if outcome.group.is_some() {
        let accepted = |k: usize| {
            outcome
                .steps
                .iter()
                .position(|s| s.replaced_by.is_none() && s.effect == named[k].0 && s.target == named[k].1)
                .unwrap_or(usize::MAX)
        };
        order.sort_by_key(|&k| (accepted(k), k));
        return order;
    }
    // the one first that explains most beside all the others
    let gain = |k: usize| {
        let own = outcome
            .alternatives
            .get(k)
            .into_iter()
            .flatten()
            .find(|r| r.effect == named[k].0 && r.target == named[k].1);
        own.map_or(0.0, |r| r.gain)
    };
    // what has no name stands after what has one
    let unnamed = |k: usize| unnamed::is_unnamed(&outcome.fit.hypothesis.effects[outcome.fit.free[k]]);
    order.sort_by(|&a, &b| unnamed(a).cmp(&unnamed(b)).then(gain(b).total_cmp(&gain(a))));
    order
}

fn effect_value(placed: &EffectInstance, outcome: &Outcome) -> Value {
    let robot = &outcome.problem.robot;
    let mut value = serde_json::to_value(entry::write(placed, robot)).unwrap_or(Value::Null);
    if let Value::Object(map) = &mut value
        && !map.contains_key("target")
    {
        map.shift_insert(1, "target".into(), placed.target_text(robot).into());
    }
    value
}
