//! The plan as it is written: `lostmotion/plan/1`, and the program.

use super::motions::Motion;
use super::note::{Note, Reason};
use super::path::{DECIMALS, Envelope};
use super::question::Set;
use super::reasons::With;
use super::separate::{Comparison, DesignScore, Experiment, NEEDED, named, right};
use super::{LEAST, Separation, Shown, reasons};
use crate::diagnose::search::MOST_EFFECTS;
use crate::effects::{EffectInstance, entry};
use crate::io::rounded::significant;
use crate::log::write;
use crate::robot::Robot;
use serde::Serialize;
use serde_json::Value;

pub const SCHEMA: &str = "lostmotion/plan/1";

/// What a plan is to decide.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum QuestionKind {
    /// Which of the alternatives that the user named is right.
    Between,
    /// Which member of the sets of a diagnosis is right.
    Diagnosis,
    /// Which effects of the catalogue are there at all.
    Catalogue,
}

/// What `plan-experiment --json` prints.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Plan {
    pub schema: &'static str,
    pub question: QuestionKind,
    pub verdict: Verdict,
    pub noise_um: f64,
    pub rate_hz: f64,
    /// Alternatives of every set with their sizes.
    pub sets: Vec<SetShown>,
    /// The proposal; null where nothing is worth running.
    pub best: Option<Entry>,
    /// Every motion of the library, best first: of those that are enough, the one that no other effect comes near.
    pub motions: Vec<Entry>,
    /// Why no motion is enough; null where one is.
    #[schemars(with = "Option<String>")]
    pub reason: Option<Reason>,
    /// What a further channel would give, where no motion is enough.
    pub channels: Vec<ChannelShown>,
    /// The channel that has to be logged for the proposal to decide.
    pub needs_channel: Option<String>,
    #[schemars(with = "Vec<String>")]
    pub notes: Vec<Note>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The proposal tells them apart in 99 of 100 logs.
    Separable,
    /// More often than not, but not surely.
    Weak,
    /// No motion does; with another channel the proposal does.
    NeedsChannel,
    /// Nothing that this tool knows does.
    Inseparable,
    /// The whole catalogue: everything that can be seen is seen at its typical size.
    Observable,
    /// The whole catalogue: some effect is seen only when larger.
    PartlyObservable,
    /// The diagnosis has no set.
    NothingToDecide,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct SetShown {
    #[serde(rename = "rivals")]
    pub alternatives: Vec<AlternativeShown>,
    /// Further found effects, refitted with each.
    pub beside: Vec<Value>,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct AlternativeShown {
    pub name: String,
    pub effects: Vec<Value>,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Entry {
    pub motion: String,
    pub does: String,
    /// Of one run.
    pub duration_s: f64,
    /// One, or one per payload.
    pub runs: Vec<RunShown>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub evidence: Option<Evidence>,
    /// Size over smallest detectable size of the effect that is seen worst (whole catalogue).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worst_ratio: Option<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub detectable: Vec<DetectableShown>,
}

/// How small an effect a motion shows.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct DetectableShown {
    pub effect: &'static str,
    pub target: String,
    /// Typical size over the smallest detectable size.
    pub ratio: f64,
    /// The effect at its smallest detectable size, as a model file has it; null where no size shows.
    pub detectable_from: Option<Value>,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct RunShown {
    pub payload_kg: Option<f64>,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Evidence {
    /// Expected difference in 2 ln L, the least over all comparisons.
    pub expected_2lnl: f64,
    /// Probability that the truth fits better, and that a diagnosis names it alone, for that comparison.
    pub probability_right: f64,
    pub probability_named: f64,
    pub comparisons: Vec<ComparisonShown>,
    /// The effect outside the sets that comes nearest to one of the alternatives; null where it was not looked for.
    pub nearest_outside: Option<OutsideShown>,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct OutsideShown {
    pub what: String,
    pub expected_2lnl: f64,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct ComparisonShown {
    pub truth: String,
    #[serde(rename = "rival")]
    pub alternative: String,
    pub expected_2lnl: f64,
    pub probability_right: f64,
    pub probability_named: f64,
    /// The alternative where it fits the truth best.
    #[serde(rename = "rival_fitted")]
    pub alternative_fitted: Vec<Value>,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct ChannelShown {
    pub channel: &'static str,
    pub log: &'static str,
    pub motion: String,
    pub expected_2lnl: f64,
}

fn digits(value: f64) -> f64 {
    significant(value, 6)
}

fn effect(placed: &EffectInstance, robot: &Robot) -> Value {
    let mut value = serde_json::to_value(entry::write(placed, robot)).unwrap_or(Value::Null);
    if let Value::Object(map) = &mut value {
        for v in map.values_mut() {
            if let Some(x) = v.as_f64() {
                *v = digits(x).into();
            }
        }
    }
    value
}

fn sets_shown(sets: &[Set], robot: &Robot) -> Vec<SetShown> {
    let list = |p: &[EffectInstance]| p.iter().map(|p| effect(p, robot)).collect();
    sets.iter()
        .map(|s| SetShown {
            alternatives: s
                .alternatives
                .iter()
                .map(|r| AlternativeShown { name: r.name.clone(), effects: list(&r.effects) })
                .collect(),
            beside: list(&s.common),
        })
        .collect()
}

fn entry_of(motion: &Motion, bench: &Experiment) -> Entry {
    let payloads = if motion.two_payloads { vec![Some(0.0), Some(bench.payload_kg)] } else { vec![None] };
    Entry {
        motion: motion.name.clone(),
        does: motion.does.clone(),
        duration_s: digits((motion.rows.len() - 1) as f64 * bench.envelope.step_s),
        runs: payloads.into_iter().map(|payload_kg| RunShown { payload_kg }).collect(),
        evidence: None,
        worst_ratio: None,
        detectable: Vec::new(),
    }
}

fn evidence(worth: &DesignScore, sets: &[Set], robot: &Robot) -> Evidence {
    let shown = |c: &Comparison| ComparisonShown {
        truth: sets[c.set].alternatives[c.truth].name.clone(),
        alternative: sets[c.set].alternatives[c.other].name.clone(),
        expected_2lnl: digits(c.evidence),
        probability_right: digits(right(c.evidence)),
        probability_named: digits(named(c.evidence)),
        alternative_fitted: c.fitted.iter().map(|p| effect(p, robot)).collect(),
    };
    Evidence {
        expected_2lnl: digits(worth.evidence),
        probability_right: digits(right(worth.evidence)),
        probability_named: digits(named(worth.evidence)),
        comparisons: worth.comparisons.iter().map(shown).collect(),
        nearest_outside: worth
            .outside
            .as_ref()
            .map(|(left, what)| OutsideShown { what: what.clone(), expected_2lnl: digits(*left) }),
    }
}

fn empty(question: QuestionKind, bench: &Experiment) -> Plan {
    Plan {
        schema: SCHEMA,
        question,
        verdict: Verdict::NothingToDecide,
        noise_um: digits(bench.noise.sigma * 1e6),
        rate_hz: bench.envelope.rate_hz,
        sets: Vec::new(),
        best: None,
        motions: Vec::new(),
        reason: None,
        channels: Vec::new(),
        needs_channel: None,
        notes: Vec::new(),
    }
}

/// The document where a diagnosis has no set.
pub fn of_nothing(bench: &Experiment) -> Plan {
    let mut plan = empty(QuestionKind::Diagnosis, bench);
    plan.reason = Some(Reason::NothingToDecide);
    plan
}

/// Why the pair with the least evidence cannot be distinguished.
fn hardest_pair(worth: &DesignScore, sets: &[Set], bench: &Experiment) -> Reason {
    let Some(c) = worth.comparisons.iter().min_by(|a, b| a.evidence.total_cmp(&b.evidence)) else {
        return Reason::SpecialCase;
    };
    let (a, b) = (&sets[c.set].alternatives[c.truth], &sets[c.set].alternatives[c.other]);
    Reason::Alike { first: a.name.clone(), second: b.name.clone(), why: reasons::reason(a, b, bench.model) }
}

fn channels_shown(answer: &Separation) -> Vec<ChannelShown> {
    let shown = |w: &With| ChannelShown {
        channel: w.channel.name,
        log: w.channel.log,
        motion: answer.singles[w.motion].motion.name.clone(),
        expected_2lnl: digits(w.worth.evidence),
    };
    answer.with.iter().map(shown).collect()
}

/// The document of a separation, and the motion to run.
pub fn of_separation<'a>(
    question: QuestionKind,
    answer: &'a Separation,
    sets: &[Set],
    bench: &Experiment,
) -> (Plan, Option<&'a Motion>) {
    let robot = &bench.model.robot;
    let mut plan = empty(question, bench);
    plan.sets = sets_shown(sets, robot);
    let shown = |motion: &Motion, worth: &DesignScore| Entry {
        evidence: Some(evidence(worth, sets, robot)),
        ..entry_of(motion, bench)
    };
    plan.motions = answer.singles.iter().map(|j| shown(&j.motion, &j.worth)).collect();
    if sets.iter().flat_map(|s| &s.alternatives).any(|r| r.effects.len() > MOST_EFFECTS) {
        plan.notes.push(Note::ManyEffects);
    }
    let Some(best) = answer.best() else {
        plan.verdict = Verdict::Inseparable;
        plan.reason = Some(Reason::NoMotion);
        return (plan, None);
    };
    if answer.pair.is_some() {
        plan.notes.push(Note::TwoMotions);
    }
    if best.worth.evidence >= NEEDED {
        plan.verdict = Verdict::Separable;
        plan.best = Some(shown(&best.motion, &best.worth));
        if let Some((_, what)) = best.worth.outside.as_ref().filter(|o| o.0 < NEEDED) {
            plan.notes.push(Note::OtherEffect { effect: what.clone() });
        }
        return (plan, Some(&best.motion));
    }
    plan.channels = channels_shown(answer);
    if best.worth.evidence >= LEAST {
        plan.notes.push(Note::MoreTime { times: (NEEDED / best.worth.evidence).ceil() });
        plan.verdict = Verdict::Weak;
        plan.best = Some(shown(&best.motion, &best.worth));
        return (plan, Some(&best.motion));
    }
    plan.reason = Some(hardest_pair(&best.worth, sets, bench));
    let Some(with) = answer.channel() else {
        plan.verdict = Verdict::Inseparable;
        return (plan, None);
    };
    let motion = &answer.singles[with.motion].motion;
    plan.verdict = Verdict::NeedsChannel;
    plan.needs_channel = Some(with.channel.name.into());
    plan.best = Some(shown(motion, &with.worth));
    (plan, Some(motion))
}

/// The document of the whole catalogue, and the motion to run.
pub fn of_catalogue<'a>(answer: &'a [Shown], bench: &Experiment) -> (Plan, Option<&'a Motion>) {
    let robot = &bench.model.robot;
    let mut plan = empty(QuestionKind::Catalogue, bench);
    let shown = |s: &Shown| {
        let mut entry = entry_of(&s.motion, bench);
        entry.worst_ratio = Some(digits(s.worst));
        let mut seen: Vec<_> = s.seen.iter().collect();
        seen.sort_by(|a, b| a.ratio.total_cmp(&b.ratio));
        entry.detectable = seen
            .iter()
            .map(|x| DetectableShown {
                effect: x.effect,
                target: x.target.clone(),
                ratio: digits(x.ratio),
                detectable_from: x.detectable.as_ref().map(|p| effect(p, robot)),
            })
            .collect();
        entry
    };
    plan.motions = answer.iter().map(shown).collect();
    let Some(best) = answer.first() else {
        plan.verdict = Verdict::Inseparable;
        plan.reason = Some(Reason::NoMotion);
        return (plan, None);
    };
    plan.best = Some(shown(best));
    plan.verdict = if best.worst >= 1.0 { Verdict::Observable } else { Verdict::PartlyObservable };
    let effects: Vec<String> = best
        .seen
        .iter()
        .filter(|x| {
            answer.iter().all(|s| s.seen.iter().all(|y| y.effect != x.effect || y.target != x.target || y.ratio == 0.0))
        })
        .map(|x| format!("{} {}", x.effect, x.target))
        .collect();
    if !effects.is_empty() {
        plan.reason = Some(Reason::Hidden { effects, frame_known: bench.model.registration.is_some() });
    }
    (plan, Some(&best.motion))
}

/// The program: `t_s` and a column per joint, one row an interval.
pub fn program(motion: &Motion, envelope: &Envelope) -> Vec<u8> {
    let mut out = b"t_s".to_vec();
    for joint in envelope.robot.axis_joints() {
        out.extend_from_slice(format!(",{}_{}", joint.name.to_lowercase(), joint.kind.unit()).as_bytes());
    }
    out.push(b'\n');
    for (i, row) in motion.rows.iter().enumerate() {
        write::number(&mut out, i as f64 * envelope.step_s, DECIMALS);
        for (axis, v) in row.iter().enumerate() {
            out.push(b',');
            write::number(&mut out, envelope.robot.axis(axis).kind.to_user_unit(*v), DECIMALS);
        }
        out.push(b'\n');
    }
    out
}
