//! The diagnosis document `lostmotion/diagnosis/1`.
//!
//! Parts:
//! - [`parts`]: what it is made of.
//! - [`hidden`]: what the log leaves open: structure without a name, effects that it does not show.

mod hidden;
mod parts;

use crate::diagnose::note::Note;
use crate::diagnose::problem::layout::Sensor;
use crate::diagnose::problem::recording::Recording;
use crate::diagnose::problem::residual::largest;
use crate::diagnose::result::round::round;
use crate::diagnose::result::words::GapUnit;
use crate::diagnose::search::outcome::Outcome;
use crate::diagnose::search::{story, unnamed};
use crate::diagnose::verdict::{self, Member};
use crate::effects::{EffectInstance, Nature, TrackerFrame, entry};
use crate::robot::JointKind;
use hidden::{blind_spots, slow_remainder, unexplained};
pub use hidden::{of_motion, of_unseen_joints};
pub use parts::{
    BlindSpot, Diagnosis, Evidence, Gap, GroupTest, NoiseFound, Parameter, Place, PutAside, Round, Tried, Unexplained,
    Unseen, Validation,
};
pub(in crate::diagnose) use parts::{UM, digits};
use serde_json::Value;

pub const SCHEMA: &str = "lostmotion/diagnosis/1";

/// Does remaining structure mean that the cause is unknown? What stays of a real arm is reported; it takes nothing from what was
/// named. Joint sensors are so precise that a misfit always stays.
fn hides_unknown(outcome: &Outcome, found: &[&EffectInstance]) -> bool {
    let has_name = found.iter().any(|p| !unnamed::is_unnamed(p));
    let sensors = outcome.problem.recording() == Recording::JointSensors;
    let known_well = sensors && outcome.contradictions.is_empty() && has_name;
    outcome.group.is_none() && outcome.together.is_none() && !known_well
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
    let nested_fits = match &outcome.together {
        Some(report) => report.nested_fits.clone(),
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
        geometry_tcp_um: outcome.together.as_ref().map(|report| digits(report.geometry * UM)),
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
            structure: verdict::structure_text(outcome, &slow.ratio),
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
    if let Some(report) = &outcome.together {
        return report.order.clone();
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
