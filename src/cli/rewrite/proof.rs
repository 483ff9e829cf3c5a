//! What the rewritten program does on the machine that its offsets rest on: the verdict of `assess program`.
//!
//! With a model the machine is that model. With a compensator that has evidence it is the robot with the compensator's own
//! gaps and friction: the verdict then says whether the offsets do on this program what they are meant to do (chords
//! between far points, offsets that fade over too few points, steps at the wrong place show here).

use super::Args;
use super::job::Source;
use crate::assess::program::{self, Figures, Verdict, document};
use crate::compensator::{Compensator, FrictionOffset, FrictionShape};
use crate::effects::{BacklashPosition, EffectInstance, GapCurve, Stiction, Target, curve::Pchip};
use crate::model::Model;
use crate::program::Program;
use crate::rewrite::outcome::Ready;
use crate::robot::Robot;
use crate::simulate;
use serde_json::{Value, json};
use std::path::Path;

/// Points of a program up to which the verdict is worked out: it runs the program three times.
const MOST_POINTS: u64 = 20_000;
/// Knots of a gap whose two sides are averaged.
const KNOTS: usize = 41;

/// The verdict, or why there is none.
pub(super) enum Proof {
    Told { verdict: Verdict, figures: Figures },
    None(String),
}

/// Works out the verdict on a program that is about to be put in place in a file.
pub(super) fn of(args: &Args, source: &Source, ready: &mut Ready) -> Option<Proof> {
    let outcome = &ready.outcome;
    outcome.output.as_deref().filter(|o| *o != "-")?;
    if outcome.unchanged || outcome.refusal.is_some() || args.input == Path::new("-") {
        return None;
    }
    let model = source.machine.as_ref()?;
    if outcome.points > MOST_POINTS {
        return Some(Proof::None(format!("more than {MOST_POINTS} points; `assess program` compares them")));
    }
    let speed = args.speed_mm_s.map(|v| v * 1e-3).or(source.compensator.evidence.tcp_speed_m_s);
    let options = program::Options {
        speed_m_s: speed.unwrap_or(simulate::Options::default().speed_m_s),
        at_speed: args.speed_mm_s.is_some(),
    };
    let assessed = Program::load(&args.input, &model.robot).and_then(|before| {
        let after = Program::of_texts(ready.texts()?, &model.robot)?;
        program::assess(model, &program::Source::Program(&before), &program::Source::Program(&after), &options)
    });
    Some(match assessed {
        Ok(a) => Proof::Told { verdict: a.verdict, figures: a.figures },
        Err(e) => Proof::None(crate::error::one_line(&e.to_string())),
    })
}

impl Proof {
    /// For standard error.
    pub(super) fn words(&self, of_model: bool) -> String {
        let machine =
            if of_model { "the model's machine" } else { "a machine with the compensator's gaps and friction" };
        match self {
            Self::None(why) => format!("  verdict: not worked out ({why})\n"),
            Self::Told { verdict, figures: f } => {
                let um = |v: f64| v * 1e6;
                let line = format!(
                    "  verdict on {machine}: {}: path error rms {:.1} -> {:.1} um, largest {:.1} -> {:.1} um\n",
                    verdict.text(),
                    um(f.rms_m[0]),
                    um(f.rms_m[1]),
                    um(f.largest_m[0]),
                    um(f.largest_m[1])
                );
                match verdict {
                    Verdict::Worse if f.rms_m[1] < f.rms_m[0] => {
                        line + "  less error on the whole, more of it at one place: look there before you run it (`assess program` shows where); \
                                more points near the reversals (--refine cubic or cartesian), slower turns, or a smaller --gain may help\n"
                    }
                    Verdict::Worse => {
                        line + "  do not run this program: more points near the reversals (--refine cubic or cartesian), or a smaller --gain, may help\n"
                    }
                    _ => line,
                }
            }
        }
    }

    /// For `--json`.
    pub(super) fn document(&self) -> Value {
        match self {
            Self::None(why) => json!({"verdict": Value::Null, "reason": why}),
            Self::Told { verdict, figures } => {
                let mut doc = document::figures(figures);
                doc["verdict"] = verdict.text().into();
                doc
            }
        }
    }

    pub(super) fn verdict(&self) -> Option<Verdict> {
        match self {
            Self::Told { verdict, .. } => Some(*verdict),
            Self::None(_) => None,
        }
    }
}

/// The robot with the gaps and the friction of a compensator; `None` without evidence: offsets that were typed in say
/// nothing of a machine.
pub(super) fn machine_of(robot: &Robot, compensator: &Compensator) -> Option<Model> {
    let known = !compensator.evidence.joints.is_empty() || !compensator.evidence.logs.is_empty();
    // a friction offset that no effect of the catalogue reproduces would be judged on a machine without that friction
    let reproduced = |f: &FrictionOffset| matches!(f.shape, FrictionShape::Decay(_));
    let all = compensator.joints.iter().filter_map(|j| j.friction.as_ref()).all(reproduced);
    if !known || !all || compensator.is_zero() {
        return None;
    }
    let mut model = Model::ideal(robot.clone());
    for joint in &compensator.joints {
        let target = Target::Joint(joint.axis);
        if let Some(f) = joint.friction
            && let FrictionShape::Decay(decay) = f.shape
        {
            let effect = Stiction { spike: f.gain, decay }.into();
            model.effects.push(EffectInstance { target, effect });
        }
        if let Some(b) = &joint.backlash {
            let half_gap = mean(&b.positive, &b.negative, robot, joint.axis);
            model.effects.push(EffectInstance { target, effect: BacklashPosition::or_constant(half_gap) });
        }
    }
    Some(model)
}

/// Mean of both sides of a gap: the play; the rest of an asymmetric gap is an offset that does not depend on direction.
fn mean(positive: &GapCurve, negative: &GapCurve, robot: &Robot, axis: usize) -> GapCurve {
    if positive == negative {
        return positive.clone();
    }
    if let (Some(a), Some(b)) = (positive.constant(), negative.constant()) {
        return GapCurve::Constant(0.5 * (a + b));
    }
    let range = robot.axis(axis).limits.unwrap_or([-std::f64::consts::PI, std::f64::consts::PI]);
    let knots: Vec<[f64; 2]> = (0..KNOTS)
        .map(|k| {
            let p = range[0] + (range[1] - range[0]) * k as f64 / (KNOTS - 1) as f64;
            [p, 0.5 * (positive.at(p) + negative.at(p))]
        })
        .collect();
    Pchip::new(&knots).map_or_else(|| positive.clone(), GapCurve::Pchip)
}
