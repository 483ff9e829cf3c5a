//! One found effect as the document tells it: evidence, sizes with intervals, where it shows, what to do.

use crate::diagnose::candidates::is_geometry;
use crate::diagnose::result::document::{Evidence, GroupTest, Parameter, Place, Round, Tried, UM, Validation, digits};
use crate::diagnose::search::across::ALL;
use crate::diagnose::search::geometry;
use crate::diagnose::search::outcome::Outcome;
use crate::diagnose::search::story::NestedFit;
use crate::diagnose::search::unnamed;
use crate::diagnose::verdict::Member;
use crate::effects::{AfterReversal, EffectInstance, TrackerFrame, Vibration};
use crate::numerics::normal::Z95;
use indexmap::IndexMap;

pub(in crate::diagnose) fn round(
    outcome: &Outcome,
    k: usize,
    named: &(String, String),
    set: &[Member],
    (before, after): (&NestedFit, &NestedFit),
) -> Round {
    let robot = &outcome.problem.robot;
    let placed = &outcome.fit.hypothesis.effects[outcome.fit.free[k]];
    let alternatives = &outcome.alternatives[k];
    let info = placed.effect.info();
    let group = outcome.group.as_ref().filter(|g| k < g.count);
    let predicted = if group.is_some() { after.rms } else { after.predicted };
    Round {
        effect: named.0.clone(),
        target: named.1.clone(),
        decide_by: (set.len() > 1).then(|| decide_by(set, info.decide_by)),
        group: (group.is_some() || outcome.together.is_some() && is_geometry(&named.0)).then_some("geometry"),
        tcp_um: outcome.together.as_ref().map(|report| digits(report.contributions[k] * UM)),
        place: place(outcome, placed, group),
        evidence: evidence(outcome, k, named, group),
        set: set.to_vec(),
        parameters: parameters(outcome, k),
        with_windup: with_windup(outcome, k),
        rms_before_um: digits(before.rms * UM),
        rms_after_um: digits(after.rms * UM),
        rms_after_predicted_um: digits(predicted * UM),
        validation: Validation {
            rms_before_um: digits(before.held_out * UM),
            rms_after_um: digits(after.held_out * UM),
            gain_2lnl: digits(outcome.support.get(k).copied().unwrap_or(0.0)),
        },
        action: placed.effect.action().to_string(),
        joint_unit: placed.axis().map_or("deg", |a| robot.axis(a).kind.unit()),
        candidates: alternatives
            .iter()
            .map(|r| Tried {
                effect: r.effect.into(),
                target: r.target.clone(),
                gain_2lnl: digits(r.gain),
                parameters: r.parameters,
            })
            .collect(),
    }
}

/// Sizes of effect `k` with their intervals; a fit that did not converge has none.
fn parameters(outcome: &Outcome, k: usize) -> IndexMap<String, Parameter> {
    let placed = &outcome.fit.hypothesis.effects[outcome.fit.free[k]];
    let sigma = match &outcome.together {
        _ if unnamed::is_unnamed(placed) => unnamed::sigma_of(&outcome.fit, k),
        Some(report) => report.sigma[k].clone(),
        None => outcome.fit.sigma_of(k),
    };
    let values = placed.effect.values();
    let mut parameters = keyed(outcome, placed, &sigma);
    // of an oscillation the size is given, as in a model; its direction stands with the place
    if let Some(v) = placed.effect.get::<Vibration>() {
        let share = values.iter().map(|a| a / v.amplitude_m.max(f64::MIN_POSITIVE));
        let spread = share.zip(&sigma).take(3).map(|(share, s)| (share * s).powi(2)).sum::<f64>().sqrt();
        parameters.retain(|key, _| !key.starts_with("amplitude_um["));
        parameters.shift_insert(0, "amplitude_um".into(), parameter(outcome, v.amplitude_m * UM, spread * UM));
    }
    parameters
}

/// Sizes of a gap together with the wind-up of its joint that is not in the fit: the log tells their sum better than the gap alone.
fn with_windup(outcome: &Outcome, k: usize) -> IndexMap<String, Parameter> {
    let placed = &outcome.fit.hypothesis.effects[outcome.fit.free[k]];
    let sigma = outcome.together.as_ref().and_then(|report| report.with_windup[k].as_deref());
    sigma.map(|sigma| keyed(outcome, placed, sigma)).unwrap_or_default()
}

/// The values of an effect under their keys, with these standard uncertainties (SI).
fn keyed(outcome: &Outcome, placed: &EffectInstance, sigma: &[f64]) -> IndexMap<String, Parameter> {
    let keys = placed.keys(&outcome.problem.robot).into_iter();
    keys.zip(placed.effect.values().iter().zip(sigma))
        .map(|((key, factor), (v, s))| (key, parameter(outcome, v * factor, s * factor.abs())))
        .collect()
}

/// A value with its interval; a fit that did not converge has none, and neither has a value that the log does not move.
fn parameter(outcome: &Outcome, value: f64, sigma: f64) -> Parameter {
    let half = Z95 * sigma;
    let ci95 = (outcome.fit.converged && half > 0.0).then(|| [digits(value - half), digits(value + half)]);
    Parameter { value: digits(value), ci95 }
}

/// The test of effect `k` against the fit without it, and of its group.
fn evidence(outcome: &Outcome, k: usize, named: &(String, String), group: Option<&geometry::Group>) -> Evidence {
    let own = outcome.alternatives[k].iter().find(|r| r.effect == named.0 && r.target == named.1);
    let gain = own.map_or(0.0, |r| r.gain);
    // its form may have fewer than the one that was refitted among the alternatives
    let count = outcome.fit.hypothesis.effects[outcome.fit.free[k]].effect.values().len();
    let dof = outcome.problem.n as f64;
    Evidence {
        statistic: "F",
        value: digits(gain / count as f64),
        dof: count,
        p_value: crate::numerics::fisher::tail(gain / count as f64, count as f64, dof),
        delta_bic: digits(count as f64 * dof.ln() - gain),
        group: group.map(|g| GroupTest { name: "geometry", value: digits(g.f), dof: g.parameters, p_value: g.p_value }),
    }
}

/// The experiment that decides within a set.
fn decide_by(set: &[Member], otherwise: &str) -> String {
    if set.iter().any(|m| m.target == ALL) {
        return "record all sensors with one clock, at 2 kHz or more, in a stop from full speed: a lag rounds the corner, a clock \
                offset shifts it"
            .into();
    }
    otherwise.to_string()
}

/// Where an effect shows: of a group its test, of an oscillation its direction, else its joint and its reversals.
fn place(outcome: &Outcome, placed: &EffectInstance, group: Option<&geometry::Group>) -> Place {
    let mut place = at_reversals(outcome, placed);
    if let Some(g) = group {
        place.description = format!("geometry: {} parameters together, joint F {:.0}", g.parameters, g.f);
    } else if let Some(v) = placed.effect.get::<Vibration>() {
        let [x, y, z] = v.direction.into();
        place.description = format!("throughout: the TCP vibrates along ({x:.2}, {y:.2}, {z:.2})");
    } else if let Some(f) = placed.effect.get::<TrackerFrame>() {
        place.description = f.describe();
    }
    place
}

/// Where an effect shows: its joint, and the stretches after its reversals.
fn at_reversals(outcome: &Outcome, placed: &EffectInstance) -> Place {
    const SHOWN: usize = 12;
    let robot = &outcome.problem.robot;
    let joint = placed.axis().map(|a| robot.axis(a).name.clone());
    let log = &outcome.problem.logs[0];
    let info = placed.effect.info();
    let reverses = info.special.after_reversal != AfterReversal::Nothing;
    let Some(axis) = placed.axis().filter(|_| reverses && !log.log.poses) else {
        return Place { joint, description: format!("all along: {}", info.adds), t_s: Vec::new() };
    };
    let turns = log.trajectory.turns(axis);
    let end = log.trajectory.t_s().last().copied().unwrap_or(0.0);
    let t_s = turns
        .iter()
        .enumerate()
        .take(SHOWN)
        .map(|(i, t)| {
            let next = turns.get(i + 1).map_or(end, |n| n.0);
            [digits(t.0), digits(next.min(t.0 + 2.0))]
        })
        .collect();
    let what = if info.special.after_reversal == AfterReversal::Tail { "tails after" } else { "steps at" };
    let description = match turns.len() {
        0 => "because it moves in one direction throughout this log".into(),
        1 => format!("{what} its reversal"),
        n => format!("{what} its {n} reversals"),
    };
    Place { joint, description, t_s }
}
