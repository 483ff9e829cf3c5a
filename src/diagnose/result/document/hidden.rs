//! What a log leaves open: structure without a name, and effects that it does not show.

use super::*;
use crate::diagnose::search::outcome::Outcome;
use crate::diagnose::verdict::{self};
use crate::effects::{EffectInstance, catalogue};

pub(super) fn unexplained(outcome: &Outcome, ratio: &crate::diagnose::candidates::structure::Ratio) -> Unexplained {
    let rms = |residual: &[f64]| crate::diagnose::problem::residual::rms(&outcome.problem, residual);
    let (left, floor) = (outcome.rms_named, rms(&outcome.structure.freed));
    let size = outcome.contradictions.first().map_or((left * left - floor * floor).max(0.0).sqrt(), |c| c.rms);
    let best = outcome
        .last
        .iter()
        .filter(|s| s.gain > 0.0)
        .max_by(|a, b| a.gain.total_cmp(&b.gain))
        .map(|s| (&outcome.candidates[s.candidate], s.gain));
    let record = match ratio.aspect {
        Some(crate::diagnose::candidates::basis::Aspect::Time) => "temperature, and the tracker on a fixed reflector",
        Some(crate::diagnose::candidates::basis::Aspect::Geometry) => {
            "more poses, far apart, with the orientation of the tool"
        }
        _ => "the joint after its gear (secondary encoder), at two speeds, in both directions",
    };
    let tried = |effect: &str, target: &str, gain: f64, parameters: usize| Tried {
        effect: effect.into(),
        target: target.into(),
        gain_2lnl: digits(gain),
        parameters,
    };
    let next = outcome.next.as_ref().map(|n| tried(n.effect, &n.target, n.gain, n.parameters));
    Unexplained {
        rms_um: digits(size * UM),
        joint: ratio.axis.map(|a| outcome.problem.robot.axis(a).name.clone()),
        goes_with: match &outcome.next {
            _ if !outcome.contradictions.is_empty() => "what is assumed to be known: see the first note".into(),
            Some(n) => format!("{} {}, which a further round would name", n.effect, n.target),
            None => verdict::structure_text(outcome, ratio),
        },
        p_value: ratio.p_value,
        nearest: best.map(|(c, gain)| tried(c.effect, &c.target, gain, c.parameters())),
        next,
        record: record.into(),
    }
}

/// What the noise model holds for wander, where that is far beyond the scatter of the instrument.
pub(super) fn slow_remainder(outcome: &Outcome) -> Option<Unexplained> {
    let slow = outcome.slow.as_ref()?;
    let text = format!("{}, more slowly than the instrument scatters", verdict::structure_text(outcome, &slow.ratio));
    Some(Unexplained { rms_um: digits(slow.rms * UM), goes_with: text, ..unexplained(outcome, &slow.ratio) })
}

/// Detectable sizes, then the effects of motion on joints that do not move, or do not move the TCP: no size of them would show.
pub(super) fn blind_spots(outcome: &Outcome) -> Vec<BlindSpot> {
    let mut all: Vec<BlindSpot> = verdict::blind_spots(outcome).iter().map(|s| spot(s, outcome)).collect();
    for (effect, target, why) in of_unseen_joints(outcome) {
        if !all.iter().any(|s| s.effect == effect && s.target == target) {
            all.push(BlindSpot { effect, target, detectable_from: None, reason: Some(why) });
        }
    }
    for (axis, joint) in outcome.problem.robot.axis_joints().enumerate() {
        // tried in vain, every one of them: the joint's motion does not arrive at the instrument
        let own = |s: &BlindSpot| s.target == joint.name && of_motion().contains(&s.effect);
        if all.iter().filter(|s| own(s)).all(|s| s.detectable_from.is_none()) {
            let why = why_unseen(outcome, axis);
            all.iter_mut().filter(|s| own(s)).for_each(|s| s.reason = s.reason.or(Some(why)));
        }
    }
    all
}

/// Effects that show in motion alone.
pub fn of_motion() -> Vec<&'static str> {
    catalogue::ALL.iter().filter(|e| e.special.needs_motion).map(|e| e.name).collect()
}

/// Effects of motion on joints that move in no log, or that do not move what is measured as they do.
pub fn of_unseen_joints(outcome: &Outcome) -> Vec<(&'static str, String, Unseen)> {
    let robot = &outcome.problem.robot;
    let of_motion = of_motion();
    let tried = |name: &str| outcome.candidates.iter().any(|c| of_motion.contains(&c.effect) && c.target == name);
    let unseen = robot.axis_joints().enumerate().filter(|(_, j)| !tried(&j.name));
    unseen
        .flat_map(|(axis, j)| of_motion.iter().map(move |e| (*e, j.name.clone(), why_unseen(outcome, axis))))
        .collect()
}

/// Why nothing that a joint does in motion shows.
fn why_unseen(outcome: &Outcome, axis: usize) -> Unseen {
    match outcome.problem.logs.iter().any(|l| l.log.moving_axes().contains(&axis)) {
        true => Unseen::DoesNotMoveTcp,
        false => Unseen::Rests,
    }
}

fn spot(spot: &verdict::BlindSpot, outcome: &Outcome) -> BlindSpot {
    let c = spot.candidate;
    let keys = |size: &Vec<f64>| {
        let of = |p: EffectInstance| p.keys(&outcome.problem.robot).into_iter().zip(p.effect.values());
        c.at(size).into_iter().flat_map(of).map(|((key, factor), v)| (key, digits((v * factor).abs()))).collect()
    };
    BlindSpot {
        effect: c.effect,
        target: c.target.clone(),
        detectable_from: spot.size.as_ref().map(keys),
        reason: None,
    }
}
