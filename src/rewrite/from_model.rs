//! `rewrite --model`: a compensator made of what a model file knows, the predicted joint error with its sign turned.
//!
//! Gaps in series on one joint add up; a stiction becomes a friction offset of the same size and decay. The sides on which
//! the model's gaps start become the directions before the first point.

use crate::compensator::{BacklashOffset, Compensator, Evidence, FrictionOffset, FrictionShape, JointCompensator};
use crate::effect::{Effect, GapCurve, Stage, curve::Pchip};
use crate::error::{Error, Place, Result};
use crate::model::Model;

/// The compensator of a model; `name` is the model file, for messages.
pub fn compensator(model: &Model, name: &str) -> Result<Compensator> {
    let mut joints = Vec::new();
    for axis in 0..model.robot.dof() {
        let mut gap: Option<GapCurve> = None;
        let mut friction: Option<FrictionOffset> = None;
        for effect in model.effects_on(axis) {
            match effect {
                Effect::Backlash(b) => {
                    gap = Some(match gap {
                        None => b.half_gap.clone(),
                        Some(g) => sum(&g, &b.half_gap),
                    });
                }
                Effect::Stiction(s) => {
                    if friction.is_some() {
                        return Err(Error::bad(
                            Place::file(name),
                            format!("two stictions on {}", model.robot.axis(axis).name),
                            "one stiction a joint: an offset has one decay",
                        ));
                    }
                    friction = Some(FrictionOffset { gain: s.spike, shape: FrictionShape::Decay(s.decay) });
                }
            }
        }
        if gap.is_some() || friction.is_some() {
            let backlash = gap.map(|g| BacklashOffset { positive: g.clone(), negative: g });
            joints.push(JointCompensator { axis, backlash, friction });
        }
    }
    debug_assert!(model.effects.iter().all(|e| matches!(e.effect.stage(), Stage::Servo | Stage::Gear)));
    Ok(Compensator {
        robot_name: model.robot.name.clone(),
        robot_sha256: model.robot.fingerprint(),
        joints,
        evidence: Evidence::default(),
    })
}

/// Sum of two half gaps: exact where one is constant, else PCHIP through the sums at all knots.
fn sum(a: &GapCurve, b: &GapCurve) -> GapCurve {
    if let (Some(x), Some(y)) = (a.constant(), b.constant()) {
        return GapCurve::Constant(x + y);
    }
    let knots = |c: &GapCurve| -> Vec<f64> {
        match c {
            GapCurve::Constant(_) => Vec::new(),
            GapCurve::Pchip(p) => p.knots().iter().map(|k| k[0]).collect(),
            GapCurve::Polynomial { range: [lo, hi], .. } => {
                (0..=40).map(|k| lo + (hi - lo) * f64::from(k) / 40.0).collect()
            }
        }
    };
    let mut at = [knots(a), knots(b)].concat();
    at.sort_by(f64::total_cmp);
    at.dedup();
    let sums: Vec<[f64; 2]> = at.iter().map(|&p| [p, a.at(p) + b.at(p)]).collect();
    Pchip::new(&sums).map_or_else(|| GapCurve::Constant(a.largest() + b.largest()), GapCurve::Pchip)
}
