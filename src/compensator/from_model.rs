//! The compensator of a model: the predicted joint error with its sign turned, for every effect that an offset can undo.
//!
//! Backlash becomes the offset of equation 16, stiction the fading offset of equation 17 with the decay of the model. Two
//! plays in series are one play of their sum (exactly, for symmetric play); where one of them varies with position, the sum is
//! joined by PCHIP through 41 positions of the joint's range. Two stictions on one joint are one only if their decay is
//! the same; otherwise the model is refused, because the document holds one friction term a joint.

use super::{BacklashOffset, Compensator, Evidence, FrictionOffset, FrictionShape, JointCompensator};
use crate::effect::{Effect, GapCurve, curve::Pchip};
use crate::error::{Error, Place, Result};
use crate::model::Model;

/// Intervals of the grid on which two curves are added.
const GRID: usize = 40;

impl Compensator {
    /// Offsets that undo the model's joint effects.
    pub fn from_model(model: &Model) -> Result<Self> {
        let robot = &model.robot;
        let mut joints = Vec::new();
        for axis in 0..robot.dof() {
            let name = &robot.axis(axis).name;
            let mut gap: Option<GapCurve> = None;
            let mut friction: Option<FrictionOffset> = None;
            for effect in model.effects_on(axis) {
                match effect {
                    Effect::Backlash(b) => {
                        gap = Some(match gap.take() {
                            None => b.half_gap.clone(),
                            Some(g) => sum(&g, &b.half_gap),
                        });
                    }
                    Effect::Stiction(s) => {
                        let shape = FrictionShape::Decay(s.decay);
                        match &mut friction {
                            None => friction = Some(FrictionOffset { gain: s.spike, shape }),
                            Some(f) if f.shape == shape => f.gain += s.spike,
                            Some(_) => {
                                return Err(Error::bad(
                                    Place::default(),
                                    format!("two stictions with different decays on {name}"),
                                    "one stiction per joint, or the same decay: one friction offset can undo it",
                                ));
                            }
                        }
                    }
                    _ => {}
                }
            }
            if gap.is_some() || friction.is_some() {
                let backlash = gap.map(BacklashOffset::symmetric);
                joints.push(JointCompensator { axis, backlash, friction });
            }
        }
        let evidence =
            Evidence { notes: vec!["offsets undo the effects of a model file".into()], ..Evidence::default() };
        Ok(Self { robot_name: robot.name.clone(), robot_sha256: robot.fingerprint(), joints, evidence })
    }
}

impl BacklashOffset {
    /// The same offset in both directions.
    pub fn symmetric(half_gap: GapCurve) -> Self {
        Self { positive: half_gap.clone(), negative: half_gap }
    }
}

/// Sum of two gaps over position.
fn sum(a: &GapCurve, b: &GapCurve) -> GapCurve {
    if let (Some(x), Some(y)) = (a.constant(), b.constant()) {
        return GapCurve::Constant(x + y);
    }
    let mut places: Vec<f64> = Vec::new();
    for curve in [a, b] {
        match curve {
            GapCurve::Constant(_) => {}
            GapCurve::Polynomial { range: [lo, hi], .. } => {
                places.extend((0..=GRID).map(|k| lo + (hi - lo) * k as f64 / GRID as f64));
            }
            GapCurve::Pchip(p) => {
                for w in p.knots().windows(2) {
                    places.extend((0..=4).map(|k| w[0][0] + (w[1][0] - w[0][0]) * f64::from(k) / 4.0));
                }
            }
        }
    }
    places.sort_by(f64::total_cmp);
    places.dedup_by(|x, y| (*x - *y).abs() < 1e-9);
    let knots: Vec<[f64; 2]> = places.iter().map(|&p| [p, a.at(p) + b.at(p)]).collect();
    match Pchip::new(&knots) {
        Some(p) => GapCurve::Pchip(p),
        None => GapCurve::Constant(a.largest() + b.largest()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::{Backlash, Decay, Placed, Stiction};
    use crate::robot::Robot;

    fn model(effects: Vec<Effect>) -> Model {
        let text = "schema: lostmotion/robot/1\njoints:\n  - {name: A1, kind: revolute, a_mm: 500}\n";
        let mut model = Model::ideal(Robot::parse("robot.yaml", text).unwrap());
        model.effects = effects.into_iter().map(|e| Placed::on_axis(0, e)).collect();
        model
    }

    #[test]
    fn two_plays_in_series_are_undone_by_the_sum_of_their_gaps() {
        let play = |b| Effect::Backlash(Backlash::constant(b));
        let c = Compensator::from_model(&model(vec![play(1e-4), play(2e-4)])).unwrap();
        let b = c.joints[0].backlash.as_ref().unwrap();
        assert!((b.positive.constant().unwrap() - 3e-4).abs() < 1e-18);
        assert_eq!(b.positive, b.negative);
    }

    #[test]
    fn refuses_two_stictions_that_fade_differently() {
        let stick = |s| Effect::Stiction(Stiction { spike: 1e-4, decay: Decay::Time(s) });
        let e = Compensator::from_model(&model(vec![stick(1.0), stick(2.0)])).unwrap_err();
        assert!(e.to_string().contains("two stictions"), "{e}");
    }
}
