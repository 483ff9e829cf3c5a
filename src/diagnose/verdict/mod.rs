//! From the outcome of the search to a verdict: sets of alternatives with probabilities, remaining structure, blind spots.

use crate::diagnose::candidates::Candidate;
use crate::diagnose::candidates::screen::SWALLOWED;
use crate::diagnose::candidates::structure::{self, Ratio};
use crate::diagnose::problem::forward::LogData;
use crate::diagnose::search::finding::{Alternative, WITHIN};
use crate::diagnose::search::outcome::Outcome;
use crate::effects::{Inputs, catalogue};

/// Probability that the smallest set holds.
pub const HELD: f64 = 0.95;
/// Minimal detectable bias: non-centrality at a chance of 0.001 and a power of 0.8.
pub const MDB: f64 = 4.13;

/// What the log says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The model explains the log: nothing is left but noise.
    None,
    /// The effects are named, and none has an alternative.
    Named,
    /// At least one effect cannot be distinguished from an alternative with these logs.
    NamedSet,
    /// Structure remains that no effect of the catalogue describes, or the log contradicts what is taken as known.
    Unknown,
    /// No joint moves, and no measured torque changes.
    NotObservable,
    /// Units, axes, times or columns cannot be right.
    BadData,
}

/// One member of a set.
#[derive(Debug, Clone, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Member {
    pub effect: String,
    pub target: String,
    pub probability: f64,
}

/// The smallest set that holds the truth: the named effect first, then what fits as well. One that is `doubtful` does not stand there
/// alone: the best other one stands beside it, however much less it explains.
pub fn set(named: (&str, &str), alternatives: &[Alternative], price: f64, doubtful: bool) -> Vec<Member> {
    let best = alternatives.iter().map(|r| r.merit(price)).fold(f64::NEG_INFINITY, f64::max);
    let weight = |r: &Alternative| (0.5 * (r.merit(price) - best)).exp();
    let total: f64 = alternatives.iter().map(weight).sum();
    let is_named = |r: &Alternative| r.effect == named.0 && r.target == named.1;
    let gain = alternatives.iter().find(|r| is_named(r)).map_or(0.0, |r| r.gain);
    let parameters = alternatives.iter().find(|r| is_named(r)).map_or(1, |r| r.parameters);
    let mut members = Vec::new();
    let mut held = 0.0;
    let best = alternatives.iter().position(|r| doubtful && !is_named(r));
    for (place, r) in alternatives.iter().enumerate() {
        let share = if total > 0.0 { weight(r) / total } else { 0.0 };
        let needed = held < HELD && share > 1.0 - HELD;
        // a wider form of the named effect always fits as well: it is an alternative where what it adds is more than chance
        let price_here = if widens(r.effect, named.0) && r.target == named.1 {
            4.0 * r.parameters.saturating_sub(parameters) as f64 + WITHIN
        } else {
            0.0
        };
        if is_named(r) || needed || Some(place) == best || r.gain - price_here >= gain - WITHIN {
            members.push(Member { effect: r.effect.into(), target: r.target.clone(), probability: share });
        }
        held += share;
    }
    if let Some(k) = members.iter().position(|m| m.effect == named.0 && m.target == named.1) {
        let first = members.remove(k);
        members.insert(0, first);
    }
    members
}

/// Is `wide` a form of `narrow` with more freedom?
fn widens(wide: &str, narrow: &str) -> bool {
    catalogue::find(wide).is_some_and(|e| e.special.imitates.contains(&narrow))
}

/// Structure in words.
pub fn structure_text(outcome: &Outcome, r: &Ratio) -> String {
    structure::described(r, &outcome.problem)
}

/// Does a torque change?
fn changes(torque: Option<&[f64]>) -> bool {
    torque.is_some_and(|t| t.iter().any(|v| *v != t[0]))
}

/// The verdict.
pub fn of(outcome: &Outcome, sets: &[Vec<Member>], structured: bool) -> Verdict {
    let logs = &outcome.problem.logs;
    // a joint that is held shows its wind-up under a torque that changes
    let turned = |l: &LogData| {
        (0..outcome.problem.robot.dof())
            .any(|a| changes(l.trajectory.measured_torque(a)) || changes(l.trajectory.process_torque(a)))
    };
    let moves = logs.iter().any(|l| !l.log.moving_axes().is_empty() || turned(l));
    if !moves && !logs.iter().any(|l| l.log.poses) {
        Verdict::NotObservable
    } else if structured {
        Verdict::Unknown
    } else if outcome.fit.free.is_empty() {
        if moves { Verdict::None } else { Verdict::NotObservable }
    } else if sets.iter().any(|s| s.len() > 1) {
        Verdict::NamedSet
    } else {
        Verdict::Named
    }
}

/// What this log cannot show, one entry per effect and target: the smallest size that it would have detected.
#[derive(Clone)]
pub struct BlindSpot<'a> {
    pub candidate: &'a Candidate,
    /// Coefficients at the detectable size; `None` where frame or found effects swallow the effect whole.
    pub size: Option<Vec<f64>>,
}

/// Blind spots in the order of the candidates; of several shapes the one that is seen best.
pub fn blind_spots(outcome: &Outcome) -> Vec<BlindSpot<'_>> {
    let mut spots: Vec<(BlindSpot, f64)> = Vec::new();
    for s in &outcome.last {
        let c = &outcome.candidates[s.candidate];
        if c.sensitivities() != 1 && !c.is_vector {
            continue;
        }
        let found = outcome.fit.free.iter().any(|&i| {
            let p = &outcome.fit.hypothesis.effects[i];
            c.names(p, &outcome.problem.robot)
        });
        if found {
            continue;
        }
        let visible = s.own >= SWALLOWED && s.sigma.iter().all(|v| v.is_finite() && *v > 0.0);
        let (size, measure) = if visible {
            (Some(s.sigma.iter().map(|v| MDB * v).collect()), s.sigma.iter().sum::<f64>())
        } else {
            (None, f64::INFINITY)
        };
        let spot = BlindSpot { candidate: c, size };
        match spots.iter_mut().find(|(o, _)| o.candidate.effect == c.effect && o.candidate.target == c.target) {
            Some(known) if measure < known.1 => *known = (spot, measure),
            Some(_) => {}
            None => spots.push((spot, measure)),
        }
    }
    spots.into_iter().map(|s| s.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_that_may_be_zero_is_no_name_by_itself() {
        let one = |effect, gain| Alternative { effect, target: "A3".into(), gain, parameters: 2 };
        let all = [one("hysteresis", 400.0), one("backlash", 250.0), one("stiction", 90.0)];
        let names = |doubtful| -> Vec<String> {
            set(("hysteresis", "A3"), &all, 8.0, doubtful).into_iter().map(|m| m.effect).collect()
        };
        assert_eq!(names(false), ["hysteresis"]);
        assert_eq!(names(true), ["hysteresis", "backlash"]);
    }
}
